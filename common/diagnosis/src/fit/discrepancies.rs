//! Fits of flexible discrepancies: what could be explained at all, beside the named effects and instead of them.

use crate::data::case::Case;
use crate::fit::candidate::{self, Fitted};
use crate::fit::frozen::{self, FrozenFit, GROSS};
use crate::model::candidates::Candidate;
use crate::model::discrepancy::{self, Discrepancy, Place};
use crate::model::parameters::Shape;
use crate::predict::localise::PlaceEvidence;
use crate::predict::one_step::DisturbanceModel;
use rayon::prelude::*;

/// Flexible discrepancies that are fitted at all, after a linear screening.
const SCREENED: usize = 9;
/// Flexible discrepancies that are fitted to the end.
const PURSUED: usize = 3;

/// Least gain of a flexible discrepancy that counts as structure.
pub(crate) const STRUCTURE: f64 = 60.0;

/// A flexible discrepancy that was fitted.
#[derive(Debug)]
pub struct FittedDiscrepancy {
    /// Which.
    pub discrepancy: Discrepancy,
    /// Gain of log-likelihood.
    pub gain: f64,
    /// Gain of leave-one-run-out log-likelihood.
    pub predictive: f64,
    /// The fit.
    pub fitted: Fitted,
}

/// The flexible discrepancies at likely places that explain most instead of any effect, each with a filter of its own and
/// the evidence that it gains, best first.
pub fn instead_of_effects(
    case: &Case,
    base: &FrozenFit,
    likely: &[PlaceEvidence],
) -> Vec<(FittedDiscrepancy, f64)> {
    let mut discrepancies = discrepancy::all(case);
    if discrepancies.iter().any(|f| is_likely(f, likely)) {
        discrepancies.retain(|f| is_likely(f, likely));
    }
    let disturbances = DisturbanceModel::default();
    let settled = |discrepancy: &Discrepancy, frozen: FrozenFit| {
        let evidence = base.evidence_cost() - frozen.evidence_cost();
        let fitted = frozen.fitted;
        let gain = base.fitted.fit.total() - fitted.fit.total();
        let predictive = base.fitted.predictive_cost() - fitted.predictive_cost();
        let fitted = Fitted { columns: Vec::new(), residuals: Vec::new(), ..fitted };
        (FittedDiscrepancy { discrepancy: discrepancy.clone(), gain, predictive, fitted }, evidence)
    };
    let tolerant = explain_with(base, discrepancies.clone());
    let mut all: Vec<(FittedDiscrepancy, f64)> = tolerant
        .par_iter()
        .take(PURSUED)
        .map(|brief| {
            let fitted = &brief.fitted;
            let frozen =
                frozen::freeze(case, &fitted.shape, &disturbances, &fitted.fit.theta, base.tolerance);
            settled(&brief.discrepancy, frozen)
        })
        .collect();
    if base.tolerance >= GROSS {
        let candidates: Vec<Candidate> = discrepancies.iter().map(|f| f.candidate.clone()).collect();
        let strict = frozen::strict_trials(case, &base.fitted, &disturbances, &candidates, PURSUED);
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
pub fn beside_effects(case: &Case, frozen: &FrozenFit) -> Vec<FittedDiscrepancy> {
    explain_with(frozen, discrepancy::all(case))
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

fn explain_with(frozen: &FrozenFit, discrepancies: Vec<Discrepancy>) -> Vec<FittedDiscrepancy> {
    let (whitening, base) = (&frozen.whitening, &frozen.fitted);
    let closed = |discrepancy: Discrepancy, fitted: Fitted| {
        let gain = base.fit.total() - fitted.fit.total();
        let predictive = base.predictive_cost() - fitted.predictive_cost();
        // The columns are large and not needed any more.
        let fitted = Fitted { columns: Vec::new(), residuals: Vec::new(), ..fitted };
        FittedDiscrepancy { discrepancy, gain, predictive, fitted }
    };
    let screen = |f: Discrepancy| (candidate::linear_gain(whitening, base, &f.candidate), f);
    let mut screened: Vec<(f64, Discrepancy)> = discrepancies.into_par_iter().map(screen).collect();
    screened.sort_by(|a, b| b.0.total_cmp(&a.0));
    screened.truncate(SCREENED);
    let mut brief: Vec<FittedDiscrepancy> = screened
        .into_par_iter()
        .map(|(_, f)| {
            let fitted = candidate::fit_briefly(whitening, base, &f.candidate);
            closed(f, fitted)
        })
        .collect();
    brief.sort_by(|a, b| b.score().total_cmp(&a.score()));
    let rest = brief.split_off(PURSUED.min(brief.len()));
    let mut all: Vec<FittedDiscrepancy> = brief
        .into_par_iter()
        .map(|brief| {
            if brief.gain < 0.3 * STRUCTURE {
                return brief;
            }
            let fitted = candidate::fit_candidate(whitening, base, &brief.discrepancy.candidate);
            closed(brief.discrepancy, fitted)
        })
        .collect();
    all.extend(rest);
    all.sort_by(|a, b| b.score().total_cmp(&a.score()));
    all
}

impl FittedDiscrepancy {
    /// What discrepancies are ranked by, as candidates are.
    pub fn score(&self) -> f64 {
        let gain = self.gain.max(0.0);
        self.gain + self.predictive.clamp(-0.5 * gain, 1.5 * gain)
    }
}
