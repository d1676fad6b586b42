//! From the search to a verdict: what is named, what is missing, and how sure that is.

use crate::case::Case;
use crate::chance::Chance;
use crate::engine::{self, Acceptance, Found, GROSS, Gain, Round};
use crate::flexible::{self, Flexible, Place};
use crate::innovations::Clutter;
use crate::library::Candidate;
use crate::parameters::Shape;
use crate::report::Verdict;
use crate::search::{self, Fitted, Level};
use crate::wander::{self, Wander};
use rayon::prelude::*;

/// Named effects must recover this share of what they and a flexible discrepancy recover together.
const RECOVERED: f64 = 0.65;
/// Below this share the rest is missing beside the named effects.
const NEARLY_ALL: f64 = 0.8;
/// Least gain of a flexible discrepancy that counts as structure.
const STRUCTURE: f64 = 60.0;

/// A flexible discrepancy at one place that gains this many times what the named effects gain shows that they are not the
/// answer; laws of another form than the plant's fall short by less.
const OUTDONE: f64 = 1.25;
/// What freeing a place must gain to count as structure where nothing is named.
const LEFT_ALONE: f64 = 250.0;

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
    /// Share of what freeing the likeliest place gains that is left beside the named effects; one if there are none.
    pub left: f64,
    /// What is missing, for unknown and for effects with a rest.
    pub missing: Option<Freed>,
    /// The test against chance.
    pub chance: Option<Chance>,
    /// Flexible discrepancies on top of the best model, strongest first.
    pub beside: Vec<Freed>,
    /// Flexible discrepancies at likely places on top of the nuisances alone, strongest first; empty unless in doubt.
    pub instead: Vec<Freed>,
}

/// Judges the outcome of a search.
pub fn judge(case: &Case, found: &Found, acceptance: Acceptance, seed: u64) -> Judgement {
    let best = &found.best;
    let chance = found
        .rounds
        .first()
        .map(|round| Chance::new(round, found.base.fitted.shape.nuisance_count(), &best.fitted, seed));
    let gain = (found.base.evidence_cost() - best.evidence_cost()).max(0.0);
    let alarm = chance.as_ref().map_or(0.0, Chance::threshold);
    let named = !best.fitted.shape.effects.is_empty() && gain > alarm;
    let (places, likely) = (&found.places, wander::likely(&found.places));
    let mut beside = if engine::is_quiet(best, &found.rest) { Vec::new() } else { explainable(case, best) };
    let rest_gain = beside.first().map_or(0.0, |freed| freed.gain.max(0.0));
    let structure = beside.first().is_some_and(|f| {
        f.gain > STRUCTURE.max(2.0 * acceptance.gain) && (f.predictive > 0.1 * f.gain || f.gain > 250.0)
    });
    let recovered = if gain + rest_gain > 0.0 { gain / (gain + rest_gain) } else { 1.0 };
    let doubtful = best.level > 0 || structure || best.fitted.shape.effects.len() > 1 || on_bound(best);
    let left = if named { wander::share_left(places, &found.rest) } else { 1.0 };
    let alone = places.first().is_some_and(|w| w.evidence > LEFT_ALONE);
    let ask = if named { doubtful } else { structure || alone };
    let instead = if ask { in_place_of_effects(case, &found.base, likely) } else { Vec::new() };
    let outdone = instead.first().is_some_and(|(_, evidence)| *evidence > OUTDONE * gain + STRUCTURE);
    let fits_place = best.fitted.shape.effects.iter().any(|e| wander::may_act_at(e.spec.term, likely));
    let too_little = recovered < RECOVERED || (on_bound(best) && recovered < NEARLY_ALL);
    let verdict = match named {
        false if structure || alone => Verdict::Unknown,
        false => Verdict::None,
        true if outdone || left > 1.0 || (left > wander::MOST && !fits_place) => Verdict::Unknown,
        true if structure && too_little => Verdict::Unknown,
        true if left > wander::MOST || (structure && recovered < NEARLY_ALL) => Verdict::EffectsAndUnknown,
        true => Verdict::Effects,
    };
    // What makes the recordings less likely is no discrepancy, even at the likeliest place.
    let gains = instead.iter().any(|(_, evidence)| *evidence > 0.0);
    let kept = instead.into_iter().filter(|(_, evidence)| !gains || *evidence > 0.0);
    let mut instead: Vec<Freed> = kept.map(|(freed, _)| freed).collect();
    let missing = match verdict {
        Verdict::Unknown if !instead.is_empty() => Some(instead.remove(0)),
        Verdict::Unknown | Verdict::EffectsAndUnknown if !beside.is_empty() => Some(beside.remove(0)),
        _ => None,
    };
    Judgement { verdict, recovered, left, missing, chance, beside, instead }
}

/// The flexible discrepancies at likely places that explain most instead of any effect, each with a filter of its own and
/// the evidence that it gains, best first.
pub fn in_place_of_effects(case: &Case, base: &Level, likely: &[Wander]) -> Vec<(Freed, f64)> {
    let mut flexibles = flexible::all(case);
    if flexibles.iter().any(|f| is_likely(f, likely)) {
        flexibles.retain(|f| is_likely(f, likely));
    }
    let clutter = Clutter::default();
    let settled = |flexible: &Flexible, level: Level| {
        let evidence = base.evidence_cost() - level.evidence_cost();
        let fitted = level.fitted;
        let gain = base.fitted.fit.total() - fitted.fit.total();
        let predictive = base.fitted.predictive_cost() - fitted.predictive_cost();
        let fitted = Fitted { columns: Vec::new(), residuals: Vec::new(), ..fitted };
        (Freed { flexible: flexible.clone(), gain, predictive, fitted }, evidence)
    };
    let tolerant = explain_with(base, flexibles.clone());
    let mut all: Vec<(Freed, f64)> = tolerant
        .par_iter()
        .take(PURSUED)
        .map(|freed| {
            let fitted = &freed.fitted;
            let level = search::settle(case, &fitted.shape, &clutter, &fitted.fit.theta, base.level);
            settled(&freed.flexible, level)
        })
        .collect();
    if base.level >= GROSS {
        let candidates: Vec<Candidate> = flexibles.iter().map(|f| f.candidate.clone()).collect();
        let strict = search::strict_trials(case, &base.fitted, &clutter, &candidates, PURSUED);
        let settle = |(i, shape, theta): &(usize, Shape, Vec<f64>)| {
            let level = search::settle_upwards(case, shape, &clutter, theta, base.level);
            settled(&flexibles[*i], level)
        };
        all.extend(strict.par_iter().map(settle).collect::<Vec<_>>());
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

/// The flexible discrepancies that explain most on top of a model, best first.
fn explainable(case: &Case, level: &Level) -> Vec<Freed> {
    explain_with(level, flexible::all(case))
}

/// Whether a flexible discrepancy acts at one of the likely places; a torque on wheelsets is likely where pads are and the
/// other way round, and so are a wheelset sensor's error and its scale.
fn is_likely(flexible: &Flexible, likely: &[Wander]) -> bool {
    let group = |place: Place| match place {
        Place::WheelTorque | Place::PadFriction => Place::PadFriction,
        Place::WheelSensor | Place::WheelScale => Place::WheelSensor,
        Place::LoadShift => Place::Adhesion,
        other => other,
    };
    likely.iter().any(|w| group(w.place) == group(flexible.place))
}

fn explain_with(level: &Level, flexibles: Vec<Flexible>) -> Vec<Freed> {
    let (whitening, base) = (&level.whitening, &level.fitted);
    let freed = |flexible: Flexible, fitted: Fitted| {
        let gain = base.fit.total() - fitted.fit.total();
        let predictive = base.predictive_cost() - fitted.predictive_cost();
        // The columns are large and not needed any more.
        let fitted = Fitted { columns: Vec::new(), residuals: Vec::new(), ..fitted };
        Freed { flexible, gain, predictive, fitted }
    };
    let screen = |f: Flexible| (search::linear_gain(whitening, base, &f.candidate), f);
    let mut screened: Vec<(f64, Flexible)> = flexibles.into_par_iter().map(screen).collect();
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

/// Whether an effect's strength sits on a bound.
fn on_bound(level: &Level) -> bool {
    (0..level.fitted.shape.effects.len()).any(|e| engine::is_on_bound(&level.fitted, e))
}

/// How well the other candidates of a round do beside the one named `id`, best first: by the evidence that they gain with
/// a filter of their own if they were carried so far, else by their score.
pub fn rivals<'a>(round: &'a Round, id: &str) -> Vec<(&'a Gain, f64)> {
    let Some(own) = round.gains.iter().find(|g| g.id == id) else { return Vec::new() };
    let top = round.gains.iter().max_by(|a, b| a.score().total_cmp(&b.score())).unwrap_or(own);
    let settled = |other: &Gain| {
        let (other, own) = (round.settled_gain(other.id)?, round.settled_gain(id)?);
        Some(other / own.max(1.0))
    };
    let scale = settled(top).unwrap_or(1.0).clamp(0.0, 1.0) / top.score().max(1.0);
    let ratio = |g: &Gain| settled(g).unwrap_or(scale * g.score());
    let mut rivals: Vec<(&Gain, f64)> =
        round.gains.iter().filter(|g| g.id != id).map(|g| (g, ratio(g))).collect();
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

/// What a named effect's confidence follows from.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// Share of the explainable that the named effects recover.
    pub recovered: f64,
    /// Share of what freeing the likeliest place gains that they leave.
    pub left: f64,
    /// Score of the best rival that is not declared equivalent, relative to the effect's own.
    pub rival: f64,
    /// Log-likelihood gained by the effect.
    pub gain: f64,
    /// Whether an effect named before it may show at the same place.
    pub mends: bool,
}

/// Probability that a named effect is right. The logistic is set by hand from some forty simulated cases whose answer is
/// known, not fitted; `railgrip gap blind` prints how often verdicts at each confidence are right.
pub fn confidence(standing: Standing) -> f64 {
    let Standing { recovered, left, rival, gain, mends } = standing;
    let margin = 3.8 + 3.0 * (recovered.max(0.5) - 0.95) - 4.5 * left.min(1.0) - 5.0 * (rival - 0.6).max(0.0)
        + 0.4 * (gain.max(1.0) / 300.0).ln().clamp(-2.0, 1.0)
        - if mends { 1.5 } else { 0.0 };
    (1.0 / (1.0 + (-margin).exp())).clamp(0.1, 0.985)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURE: Standing = Standing { recovered: 1.0, left: 0.0, rival: 0.1, gain: 1e4, mends: false };

    #[test]
    fn confidence_is_a_probability_whatever_the_gain() {
        for gain in [-1e5, 0.0, 1e-9, 1e9] {
            let confidence = confidence(Standing { gain, ..SURE });
            assert!((0.0..=1.0).contains(&confidence), "{confidence} at {gain}");
        }
    }

    #[test]
    fn a_close_rival_and_a_rest_cost_confidence() {
        let sure = confidence(SURE);
        for worse in [
            Standing { rival: 0.92, ..SURE },
            Standing { left: 0.5, ..SURE },
            Standing { recovered: 0.6, ..SURE },
            Standing { mends: true, ..SURE },
        ] {
            assert!(confidence(worse) < sure - 0.005, "{worse:?}");
        }
    }
}
