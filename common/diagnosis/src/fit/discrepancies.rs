//! Fits of flexible discrepancies: what could be explained at all, beside the named effects and instead of them.

use crate::decide::criteria::Pursuit;
use crate::fit::candidate::{self, Fitted};
use crate::fit::frozen::{self, FrozenFit};
use crate::fit::linearisation::Linearisation;
use crate::fit::objective::Objective;
use crate::model::candidates::Candidate;
use crate::model::discrepancy::{self, Discrepancy, Place};
use crate::model::parameters::Shape;
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::localise::PlaceEvidence;
use rayon::prelude::*;

/// A flexible discrepancy that was fitted.
#[derive(Clone, Debug)]
pub struct FittedDiscrepancy {
    /// Which.
    pub discrepancy: Discrepancy,
    /// Gain of log-likelihood.
    pub gain: f64,
    /// Gain of leave-one-run-out log-likelihood.
    pub predictive: f64,
    /// What discrepancies are ranked by, see [`candidate::score`].
    pub score: f64,
    /// The fit.
    pub fitted: Fitted,
}

/// The flexible discrepancies at likely places that explain most instead of any effect, each with a filter of its own and
/// the evidence that it gains, best first.
pub fn instead_of_effects(
    base: &FrozenFit,
    likely: &[PlaceEvidence],
    pursuit: &Pursuit,
) -> Vec<(FittedDiscrepancy, f64)> {
    let case = base.case;
    let mut discrepancies = discrepancy::all(case);
    if discrepancies.iter().any(|f| is_likely(f, likely)) {
        discrepancies.retain(|f| is_likely(f, likely));
    }
    let disturbances = DisturbanceModel::default();
    let settled = |discrepancy: &Discrepancy, frozen: FrozenFit| {
        let evidence = base.evidence_cost() - frozen.evidence_cost();
        let fitted = frozen.fitted;
        let gain = base.fitted.fit.total() - fitted.fit.total();
        let predictive = fitted.predictive_gain(&base.fitted);
        let fitted = Fitted { columns: Vec::new(), residuals: Vec::new(), ..fitted };
        let score = candidate::score(gain, predictive, pursuit);
        (FittedDiscrepancy { discrepancy: discrepancy.clone(), gain, predictive, score, fitted }, evidence)
    };
    let tolerant = explain_with(base, discrepancies.clone(), pursuit);
    let mut all: Vec<(FittedDiscrepancy, f64)> = tolerant
        .par_iter()
        .take(pursuit.discrepancies_finished)
        .map(|brief| {
            let fitted = &brief.fitted;
            let frozen =
                frozen::freeze(case, &fitted.shape, &disturbances, &fitted.fit.theta, base.tolerance);
            settled(&brief.discrepancy, frozen)
        })
        .collect();
    if base.tolerance >= pursuit.gross_tolerance {
        let candidates: Vec<Candidate> = discrepancies.iter().map(|f| f.candidate.clone()).collect();
        let strict = frozen::open_loop_trials(
            case,
            (&base.fitted.shape, &base.fitted.fit.theta),
            &candidates,
            &[],
            pursuit.discrepancies_finished,
            &|_, _| false,
        );
        let settle = |(i, shape, theta): &(usize, Shape, Vec<f64>)| {
            let frozen = frozen::freeze_upwards(case, shape, &disturbances, theta, base.tolerance);
            settled(&discrepancies[*i], frozen)
        };
        all.extend(strict.par_iter().map(settle).collect::<Vec<_>>());
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

/// The flexible discrepancies that explain most on top of a model, best first.
pub fn beside_effects(frozen: &FrozenFit, pursuit: &Pursuit) -> Vec<FittedDiscrepancy> {
    explain_with(frozen, discrepancy::all(frozen.case), pursuit)
}

/// Whether a flexible discrepancy acts at one of the likely places; a torque on wheelsets is likely where pads are and the
/// other way round, and so are a wheelset sensor's error and its scale.
fn is_likely(discrepancy: &Discrepancy, likely: &[PlaceEvidence]) -> bool {
    let group = |place: Place| match place {
        Place::WheelTorque | Place::PadFriction => Place::PadFriction,
        Place::WheelSensor | Place::WheelScale => Place::WheelSensor,
        Place::LoadShift => Place::Adhesion,
        other => other,
    };
    likely.iter().any(|w| group(w.place) == group(discrepancy.place))
}

/// What discrepancies of one kind share: all but the wheelset.
fn kind(discrepancy: &Discrepancy) -> impl PartialEq + use<> {
    (discrepancy.place, std::mem::discriminant(&discrepancy.scope), discrepancy.covariate)
}

/// What is best first, with those of a kind that was before them at the end: where wheelsets hold, a force at one is as good as at any
/// other, and four alike would leave no room for another kind.
fn unlike_first<T, K: PartialEq>(best_first: Vec<T>, kind: impl Fn(&T) -> K) -> Vec<T> {
    let mut known = Vec::new();
    let (mut unlike, mut alike) = (Vec::new(), Vec::new());
    for item in best_first {
        let kind = kind(&item);
        if known.contains(&kind) {
            alike.push(item);
        } else {
            known.push(kind);
            unlike.push(item);
        }
    }
    unlike.append(&mut alike);
    unlike
}

fn explain_with(
    frozen: &FrozenFit,
    discrepancies: Vec<Discrepancy>,
    pursuit: &Pursuit,
) -> Vec<FittedDiscrepancy> {
    let base = &frozen.fitted;
    let around;
    let objective: &dyn Objective = if frozen.whitening.is_tolerant() {
        around = Linearisation::new(&frozen.whitening, base);
        &around
    } else {
        &frozen.whitening
    };
    let closed = |discrepancy: Discrepancy, fitted: Fitted| {
        let gain = base.fit.total() - fitted.fit.total();
        let predictive = fitted.predictive_gain(base);
        // The columns are large and not needed any more.
        let fitted = Fitted { columns: Vec::new(), residuals: Vec::new(), ..fitted };
        let score = candidate::score(gain, predictive, pursuit);
        FittedDiscrepancy { discrepancy, gain, predictive, score, fitted }
    };
    let screen = |f: Discrepancy| (candidate::linear_gain(objective, base, &f.candidate), f);
    let mut screened: Vec<(f64, Discrepancy)> = discrepancies.into_par_iter().map(screen).collect();
    screened.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut screened = unlike_first(screened, |(_, f)| kind(f));
    screened.truncate(pursuit.discrepancies_screened);
    let mut brief: Vec<FittedDiscrepancy> = screened
        .into_par_iter()
        .map(|(_, f)| {
            let fitted = candidate::fit_briefly(objective, base, &f.candidate);
            closed(f, fitted)
        })
        .collect();
    brief.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut brief = unlike_first(brief, |f| kind(&f.discrepancy));
    let rest = brief.split_off(pursuit.discrepancies_finished.min(brief.len()));
    let mut all: Vec<FittedDiscrepancy> = brief
        .into_par_iter()
        .map(|brief| {
            if brief.gain < pursuit.discrepancy_worthwhile {
                return brief;
            }
            // What a linearisation promises must hold when the filter is run.
            let led = candidate::fit_candidate(objective, base, &brief.discrepancy.candidate, pursuit);
            let fitted =
                if frozen.whitening.is_tolerant() { candidate::settle(&frozen.whitening, &led) } else { led };
            closed(brief.discrepancy, fitted)
        })
        .collect();
    // Those that were only tried come after those that were carried to the end.
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    all.extend(rest);
    all
}

#[cfg(test)]
mod tests {
    use super::unlike_first;

    #[test]
    fn curves_of_other_wheelsets_come_after_those_of_other_kinds() {
        let best_first = vec![("pads", 0), ("pads", 2), ("body", 0), ("pads", 1), ("rail", 0), ("rail", 1)];
        let sorted = unlike_first(best_first, |(kind, _)| *kind);
        assert_eq!(sorted, [("pads", 0), ("body", 0), ("rail", 0), ("pads", 2), ("pads", 1), ("rail", 1)]);
    }
}
