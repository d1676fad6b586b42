//! A designed run, and what is said of it.

use super::runs::PlannedRun;
use serde::Serialize;

/// A designed run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Sets of effects that it tells apart, the likeliest first; an empty set is a model without effects.
    pub separates: Vec<Vec<String>>,
    /// Their probabilities before it; the rest is something unknown, and what no model was made of.
    pub p: Vec<f64>,
    /// Entropy of all sets that the report lists, nats.
    pub entropy_before: f64,
    /// The same expected after the run.
    pub entropy_after: f64,
    /// What a run of equal length, drawn from the same library, leaves on average.
    pub entropy_after_random: f64,
    /// The run.
    pub run: PlannedRun,
    /// The same in words.
    pub words: String,
    /// Time that the plan took, with its diagnosis, s.
    pub seconds: f64,
}

/// Probability of what no model was made of, or no set lists, from which it is said.
pub(super) const WORTH_SAYING: f64 = 0.05;

/// The plan in words.
pub(super) fn words(plan: &Plan) -> String {
    let name = |effects: &Vec<String>| match effects.as_slice() {
        [] => "no effect".to_owned(),
        some => some.join(" and ").replace('_', " "),
    };
    let unknown = (1.0 - plan.p.iter().sum::<f64>() > WORTH_SAYING).then(|| "something else".to_owned());
    let names: Vec<String> = plan.separates.iter().map(name).chain(unknown).collect();
    let (first, others) = names
        .split_first()
        .map_or((String::new(), String::new()), |(first, others)| (first.clone(), others.join(", ")));
    let mut from_s = 0.0;
    let mut steps = Vec::new();
    for phase in &plan.run.phases {
        let what = match (phase.brake_demand, phase.drive_demand) {
            (brake, _) if brake > 0.0 => format!("brake at {:.0} %", 100.0 * brake),
            (_, drive) if drive > 0.0 => format!("drive at {:.0} %", 100.0 * drive),
            _ => "coast".to_owned(),
        };
        steps.push(format!("{what} from {from_s:.0} to {:.0} s", phase.until_s));
        from_s = phase.until_s;
    }
    let worth = if plan.entropy_after < 0.5 * plan.entropy_before {
        "It should settle most of the doubt"
    } else {
        "It settles little; no test within these limits does better"
    };
    format!(
        "On {} rail, from {:.1} m/s ({:.0} km/h): {}. This tells {first} from {others}. {worth}: {:.2} of {:.2} nats are expected to be left, {:.2} after an \
         average test of this length.",
        plan.run.rail,
        plan.run.v0_m_s,
        3.6 * plan.run.v0_m_s,
        steps.join(", "),
        plan.entropy_after,
        plan.entropy_before,
        plan.entropy_after_random,
    )
}
