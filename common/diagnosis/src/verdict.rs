//! From the search to a verdict: what is named, what is missing, and how sure that is.

use crate::case::Case;
use crate::chance::Chance;
use crate::engine::{Acceptance, Found, Gain, Round};
use crate::flexible::{self, Flexible};
use crate::report::Verdict;
use crate::search::{self, Fitted, Level};
use rayon::prelude::*;

/// Named effects must recover this share of what they and a flexible discrepancy recover together.
const RECOVERED: f64 = 0.65;
/// Below this share the rest is missing beside the named effects.
const NEARLY_ALL: f64 = 0.8;
/// Least gain of a flexible discrepancy that counts as structure.
const STRUCTURE: f64 = 60.0;

/// Flexible discrepancies that are fitted at all, after a linear screening.
const SCREENED: usize = 9;
/// Flexible discrepancies that are fitted to the end.
const PURSUED: usize = 3;

/// A flexible discrepancy that was fitted.
#[derive(Debug)]
pub struct Freed {
    /// Which.
    pub flexible: Flexible,
    /// Gain of log-likelihood.
    pub gain: f64,
    /// Gain of leave-one-run-out log-likelihood.
    pub predictive: f64,
    /// The fit.
    pub fitted: Fitted,
}

/// What was concluded.
#[derive(Debug)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Share of the explainable that the named effects recover.
    pub recovered: f64,
    /// What is missing, for unknown and for effects with a rest.
    pub missing: Option<Freed>,
    /// The test against chance.
    pub chance: Option<Chance>,
    /// Flexible discrepancies on top of the best model, strongest first.
    pub beside: Vec<Freed>,
    /// Flexible discrepancies on top of the nuisances alone, strongest first; empty unless they were needed.
    pub instead: Vec<Freed>,
}

/// Judges the outcome of a search.
pub fn judge(case: &Case, found: &Found, acceptance: Acceptance, seed: u64) -> Judgement {
    let best = &found.best;
    let chance = found
        .rounds
        .first()
        .map(|round| Chance::new(round, found.base.fitted.shape.nuisance_count(), &best.fitted, seed));
    let named = !best.fitted.shape.effects.is_empty();
    let gain = (found.base.evidence_cost() - best.evidence_cost()).max(0.0);
    let on_bound = named && on_bound(best);
    let mut beside = explainable(case, best);
    let rest = beside.first();
    let rest_gain = rest.map_or(0.0, |freed| freed.gain.max(0.0));
    let structure = rest.is_some_and(|f| {
        f.gain > STRUCTURE.max(2.0 * acceptance.gain) && (f.predictive > 0.1 * f.gain || f.gain > 250.0)
    });
    let recovered = if gain + rest_gain > 0.0 { gain / (gain + rest_gain) } else { 1.0 };
    let verdict = match (named, structure) {
        (false, false) => Verdict::None,
        (false, true) => Verdict::Unknown,
        (true, true) if recovered < RECOVERED || (on_bound && recovered < NEARLY_ALL) => Verdict::Unknown,
        (true, true) if recovered < NEARLY_ALL => Verdict::EffectsAndUnknown,
        (true, _) => Verdict::Effects,
    };
    let mut instead = match verdict {
        Verdict::Unknown if named => explainable(case, &found.base),
        _ => Vec::new(),
    };
    let missing = match verdict {
        Verdict::Unknown if !instead.is_empty() => Some(instead.remove(0)),
        Verdict::Unknown | Verdict::EffectsAndUnknown if !beside.is_empty() => Some(beside.remove(0)),
        _ => None,
    };
    Judgement { verdict, recovered, missing, chance, beside, instead }
}

/// The flexible discrepancies that explain most on top of a model, best first.
fn explainable(case: &Case, level: &Level) -> Vec<Freed> {
    let (whitening, base) = (&level.whitening, &level.fitted);
    let freed = |flexible: Flexible, fitted: Fitted| {
        let gain = base.fit.total() - fitted.fit.total();
        let predictive = base.predictive_cost() - fitted.predictive_cost();
        // The columns are large and not needed any more.
        let fitted = Fitted { columns: Vec::new(), residuals: Vec::new(), ..fitted };
        Freed { flexible, gain, predictive, fitted }
    };
    let screen = |f: Flexible| (search::linear_gain(whitening, base, &f.candidate), f);
    let mut screened: Vec<(f64, Flexible)> = flexible::all(case).into_par_iter().map(screen).collect();
    screened.sort_by(|a, b| b.0.total_cmp(&a.0));
    screened.truncate(SCREENED);
    let mut brief: Vec<Freed> = screened
        .into_par_iter()
        .map(|(_, f)| {
            let fitted = search::fit_briefly(whitening, base, &f.candidate);
            freed(f, fitted)
        })
        .collect();
    brief.sort_by(|a, b| b.score().total_cmp(&a.score()));
    let rest = brief.split_off(PURSUED.min(brief.len()));
    let mut all: Vec<Freed> = brief
        .into_par_iter()
        .map(|brief| {
            if brief.gain < 0.3 * STRUCTURE {
                return brief;
            }
            let fitted = search::fit_candidate(whitening, base, &brief.flexible.candidate);
            freed(brief.flexible, fitted)
        })
        .collect();
    all.extend(rest);
    all.sort_by(|a, b| b.score().total_cmp(&a.score()));
    all
}

impl Freed {
    /// What discrepancies are ranked by, as [`Gain::score`].
    pub fn score(&self) -> f64 {
        let gain = self.gain.max(0.0);
        self.gain + self.predictive.clamp(-0.5 * gain, 1.5 * gain)
    }
}

/// Whether an effect's strength sits on a bound that is not its neutral value.
fn on_bound(level: &Level) -> bool {
    let shape = &level.fitted.shape;
    (0..shape.effects.len()).any(|e| {
        let effect = &shape.effects[e];
        let values = &level.fitted.fit.theta[shape.range_of(e)];
        effect.parameters.iter().zip(values).any(|(p, v)| {
            let neutral = effect.spec.parameters.iter().find(|s| s.name == p.name).and_then(|s| s.neutral);
            let near = |bound: f64| (v - bound).abs() < 1e-6 * (p.upper - p.lower);
            neutral.is_some_and(|n| (near(p.lower) && n != p.lower) || (near(p.upper) && n != p.upper))
        })
    })
}

/// Candidates of a round that do nearly as well as the one named `id`.
pub fn rivals<'a>(round: &'a Round, id: &str) -> Vec<(&'a Gain, f64)> {
    let Some(own) = round.gains.iter().find(|g| g.id == id) else { return Vec::new() };
    let score = Gain::score;
    let mut rivals: Vec<(&Gain, f64)> =
        round.gains.iter().filter(|g| g.id != id).map(|g| (g, score(g) / score(own).max(1.0))).collect();
    rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
    rivals
}

/// Share of the named effect's score from which a rival counts as inseparable.
pub const TIE: f64 = 0.93;

/// Ids that the data cannot tell from `id`.
pub fn equivalents(round: &Round, id: &str, twins: &[&str]) -> Vec<String> {
    let span_same_model = |a: &str, b: &str| {
        let pair = [a, b];
        pair.contains(&"headwind") && pair.contains(&"running_resistance")
    };
    rivals(round, id)
        .into_iter()
        .filter(|(g, ratio)| {
            let tie = if span_same_model(id, g.id) {
                0.6
            } else if twins.contains(&g.id) {
                TIE - 0.05
            } else {
                TIE
            };
            *ratio >= tie
        })
        .map(|(g, _)| g.id.to_owned())
        .collect()
}

/// Probability that a named effect is right, from what it recovers and how close its best rival comes. The logistic is set
/// by hand from a few simulated cases; `railgrip gap blind` prints how often verdicts at each confidence are right.
pub fn confidence(recovered: f64, rival: f64, gain: f64) -> f64 {
    let margin = 3.4 + 6.0 * (recovered - 0.93) - 5.0 * (rival - 0.6).max(0.0)
        + 0.4 * (gain / 300.0).ln().clamp(-2.0, 1.5);
    (1.0 / (1.0 + (-margin).exp())).clamp(0.2, 0.985)
}
