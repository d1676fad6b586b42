//! What a diagnosis says: the structure of `report.json`, the same for wagon cases and for law-level cases.
//!
//! Key names and their order are an interface: other programs read them.
//!
//! # Glossary
//! * *gap* – RMS over windows or points of (prediction − measurement) / sensor sigma; 1 is as good as the sensors tell.
//! * *nominal* – the model as the case states it; *calibrated* – with its nuisances fitted on the fit runs;
//!   *extended* – nuisances and found effects fitted together.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Name and version of the report's form.
pub const SCHEMA: &str = "railgrip.gap.report/1";

/// A closed interval, as `[low, high]`.
pub type Interval = [f64; 2];

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: String,
    /// The answer in one word.
    pub verdict: Verdict,
    /// The named rule that decided it; empty in reports that are older than the rules.
    #[serde(default)]
    pub rule: String,
    /// Where the gap lies.
    #[serde(rename = "where")]
    pub location: Location,
    /// Effects that were found, strongest first.
    pub effects: Vec<FoundEffect>,
    /// Sets of effects that may be the cause, the likeliest first; empty in reports without a posterior.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub posterior: Vec<PosteriorSet>,
    /// Indices into [`Self::posterior`]: the fewest sets of which one is the truth in 90 % of cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub verdict_set: Vec<usize>,
    /// Whether the extended model predicts the holdout runs better; `null` where there is none.
    #[serde(default)]
    pub carries_over: Option<bool>,
    /// Every candidate that was tried, best predictor first.
    pub candidates: Vec<Candidate>,
    /// How large the gap is before and after.
    pub gap: Gap,
    /// What the best model leaves, if that is more than chance.
    pub unexplained: Option<Unexplained>,
    /// The run that would separate candidates that tie, in words.
    pub next_run: Option<String>,
    /// What the rule compared; absent in law-level reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// Wall-clock time of the diagnosis, s.
    pub seconds: f64,
    /// What was mended in the recordings and assumed about them, in sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// The answer in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Nothing beyond the nuisances.
    #[serde(rename = "none")]
    None,
    /// The effects named explain the gap.
    #[serde(rename = "effects")]
    Effects,
    /// Something is missing that no candidate describes.
    #[serde(rename = "unknown")]
    Unknown,
    /// The effects named explain a part, and something else is missing.
    #[serde(rename = "effects+unknown")]
    EffectsAndUnknown,
}

impl Verdict {
    /// The word in the report.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Effects => "effects",
            Self::Unknown => "unknown",
            Self::EffectsAndUnknown => "effects+unknown",
        }
    }
}

/// What the verdict on a wagon's case rests on: evidence is a gain of log-likelihood, less what parameters must earn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Number of effects that were selected.
    pub effects: usize,
    /// Evidence that they gain over the calibrated model, never negative.
    pub gain: f64,
    /// What the best of the library gains by chance in one case of fifty, see `decide/significance.rs`.
    pub alarm: f64,
    /// Whether the strength of one of them sits on a bound.
    pub on_bound: bool,
    /// Whether one of them may show where freeing a place gains most over the calibrated model.
    pub at_likely_place: bool,
    /// Gain of the strongest flexible discrepancy beside them (beside the nuisances alone if there are none); zero where
    /// nothing is left to explain.
    pub discrepancy_gain: f64,
    /// The same on left-out runs.
    pub discrepancy_predictive: f64,
    /// Evidence that freeing the likeliest place gains over the calibrated model.
    pub place_evidence: f64,
    /// What freeing the likeliest place still gains beside the effects, as a share of that; one if none are named.
    pub left: f64,
    /// Evidence that the strongest flexible discrepancy at a likely place gains instead of the effects; `None` where it was
    /// not asked.
    pub instead_evidence: Option<f64>,
    /// Whether that discrepancy is in the term of one of the effects.
    pub instead_at_effects: bool,
    /// Whether it is in the term of the strongest of them.
    pub instead_at_strongest: bool,
}

/// Where the gap of the calibrated model lies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// Place in the equations; absent where nothing is missing.
    pub term: Option<String>,
    /// Gap of each output on the fit runs.
    pub signals: Vec<SignalShare>,
    /// Operating region that holds most of it; absent where nothing is missing or no region stands out.
    pub regime: Option<Regime>,
    /// Gap of each fit run.
    pub runs: Vec<RunGap>,
}

/// An output's part in the gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalShare {
    /// Column name.
    pub name: String,
    /// Gap of the calibrated model.
    pub gap: f64,
    /// Share of the squared excess gap, 0 to 1; the shares add up to 1 unless there is no excess.
    pub share: f64,
}

/// A range of a variable in which the gap is larger than elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Regime {
    /// Name of the variable, such as `temperature` or `speed`.
    pub variable: String,
    /// The range, in SI units (temperatures in °C).
    pub range: Interval,
    /// Gap of the calibrated model inside.
    pub gap_inside: f64,
    /// And outside of it.
    pub gap_outside: f64,
}

/// Gap of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunGap {
    /// Name of the run's file without its ending.
    pub name: String,
    /// Gap of the calibrated model.
    pub gap: f64,
}

/// An effect that was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FoundEffect {
    /// Id in the catalogue.
    pub id: String,
    /// Place in the equations.
    pub term: String,
    /// Probability that this is right.
    pub confidence: f64,
    /// The same from the posterior over sets of effects; absent in reports without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p: Option<f64>,
    /// Log-odds before they were calibrated on simulated cases; absent where they are not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// By how much the gap grows, relative, where this effect is taken out of the extended model and all else stays: the
    /// larger of fitted and predicted runs. Absent where it was not asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap_grows_without: Option<f64>,
    /// Ids that the data cannot tell from this one.
    pub equivalent: Vec<String>,
    /// Candidates that come nearest to it, the nearest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rivals: Vec<Rival>,
    /// Fitted parameters by name; the unit is in the name.
    pub parameters: BTreeMap<String, ParameterEstimate>,
}

/// A candidate in the place of a named effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rival {
    /// Id in the catalogue.
    pub id: String,
    /// Evidence that it gains, as a share of what the named effect gains.
    pub share: f64,
}

/// A set of effects and how probable it is that just these are the cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PosteriorSet {
    /// Ids; empty where nothing beyond tolerances is at work.
    pub effects: Vec<String>,
    /// Whether something is at work beside them that no candidate describes.
    pub unknown: bool,
    /// Probability.
    pub p: f64,
}

/// A fitted value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterEstimate {
    /// Best value.
    pub value: f64,
    /// 95 % confidence interval: of noise, and of laws whose form is another.
    pub ci95: Interval,
    /// The part of noise alone, as the fit knows it; absent where that is all, and of what was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_noise: Option<Interval>,
}

impl ParameterEstimate {
    /// An estimate whose interval is of noise alone, or of no width where the value was chosen.
    pub fn new(value: f64, ci95: Interval) -> Self {
        Self { value, ci95, by_noise: None }
    }
}

/// A candidate that was tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Id in the catalogue.
    pub id: String,
    /// Gap on the fit runs with this candidate alone, nuisances refitted.
    pub fit_gap: f64,
    /// Share of the calibrated model's squared error on left-out data that the candidate removes; negative if it predicts worse.
    pub cv_gain: f64,
    /// Probability that the best of the whole library scores as well where no effect is present.
    pub p_value: f64,
    /// Whether the optimiser settled, from the best of several starts.
    pub converged: bool,
}

/// Gaps before and after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// On the runs that the models were fitted to.
    pub fit: ThreeGaps,
    /// On the runs that they only predict.
    pub holdout: HoldoutGap,
    /// What the calibrated model would leave if it were right; absent where that is not asked (a law measured alone, a coupled wagon).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub natural: Option<NaturalGap>,
}

/// The gap that a right model would leave on these recordings, see [`natural`](crate::predict::natural).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NaturalGap {
    /// On the runs that the models were fitted to.
    pub fit: f64,
    /// On the runs that they only predict; absent without such runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holdout: Option<f64>,
}

impl Gap {
    /// Gap of the extended model over that of a right one, RMS of fitted and predicted runs; `None` where that was not asked.
    pub fn left(&self) -> Option<f64> {
        self.over_natural([self.fit.extended, self.holdout.extended])
    }

    /// The same of the calibrated model.
    pub fn unexplained(&self) -> Option<f64> {
        self.over_natural([self.fit.calibrated, self.holdout.calibrated])
    }

    fn over_natural(&self, [fit, holdout]: [f64; 2]) -> Option<f64> {
        let natural = self.natural?;
        let held_out = natural.holdout.map(|natural| [holdout, natural]);
        let sets = [Some([fit, natural.fit]), held_out];
        let square = |k: usize| sets.iter().flatten().map(|set| set[k].powi(2)).sum::<f64>();
        let over = (square(0) / square(1)).sqrt();
        over.is_finite().then_some(over)
    }
}

/// Gaps of the three models on one set of runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThreeGaps {
    /// As the case states the model.
    pub nominal: f64,
    /// With fitted nuisances.
    pub calibrated: f64,
    /// With fitted nuisances and effects.
    pub extended: f64,
}

/// Gaps of the three models on the holdout runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HoldoutGap {
    /// As the case states the model.
    pub nominal: f64,
    /// With fitted nuisances.
    pub calibrated: f64,
    /// With fitted nuisances and effects.
    pub extended: f64,
    /// `1 − extended / calibrated`.
    pub reduction: f64,
    /// Its 95 % interval by block bootstrap.
    pub reduction_ci95: Interval,
    /// The same by output.
    pub by_signal: BTreeMap<String, SignalGap>,
    /// The window that alone makes most of the extended model's gap, if one does; absent in reports that did not ask.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_window: Option<WorstWindow>,
}

/// A window that alone makes most of what the extended model misses on the holdout runs: there a wheelset mostly slides in the
/// model and held on the track, or the other way round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorstWindow {
    /// Name of the run's file without its ending.
    pub run: String,
    /// Time of the run at which the window starts, s.
    pub start_s: f64,
    /// Its share of the squared errors of the extended model.
    pub share: f64,
    /// Gap of all other windows with fitted nuisances.
    pub calibrated_without: f64,
    /// Gap of all other windows with fitted nuisances and effects.
    pub extended_without: f64,
}

/// Gap of one output on the holdout runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalGap {
    /// With fitted nuisances.
    pub calibrated: f64,
    /// With fitted nuisances and effects.
    pub extended: f64,
}

impl SignalGap {
    /// `1 − extended / calibrated`.
    pub fn reduction(&self) -> f64 {
        1.0 - self.extended / self.calibrated
    }
}

/// What the best model leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Gap of the extended model on the fit runs.
    pub gap: f64,
    /// Place in the equations at which the rest would help most.
    pub term: String,
    /// Places that these recordings cannot tell apart, the likeliest first; empty in reports that name one only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<String>,
    /// What is missing there, over the variable that describes it best.
    pub curve: Vec<[f64; 2]>,
}
