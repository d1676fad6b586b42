//! What the HTML report shows beyond `report.json`: traces, heat map, curves, parameters, runs and settings.
//!
//! An engine fills a [`Detail`] beside its report. Every part may be left empty (`Default`); the report then leaves out the
//! section. Numbers are SI unless a `unit` beside them says otherwise, and non-finite numbers are simply not drawn.

use crate::answer::schema::Interval;

/// Everything the HTML report shows beyond the report itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detail {
    /// What the case is called, usually the name of its folder.
    pub case: String,
    /// What is diagnosed, in a few words: `wagon "coach", 41.2 t, 2 wheelsets` or `creep bench`.
    pub subject: String,
    /// Why the verdict is what it is: the rule that decided, in one sentence.
    pub rule: String,
    /// Remarks a reader must know, such as how sigma was found.
    pub notes: Vec<String>,
    /// Fit and holdout runs.
    pub runs: Vec<RunRow>,
    /// Gap by signal and operating region.
    pub heat_map: HeatMap,
    /// Places of the equations that were freed one at a time, the likeliest first; may be empty.
    pub freed: Vec<FreedPlace>,
    /// What happens in the recordings beside ordinary running, in the order of runs and time.
    pub events: Vec<Event>,
    /// The window in which the calibrated model is worst (wagon cases), one that was only predicted where there is one.
    pub worst_window: Option<TraceWindow>,
    /// Measured points and models over a covariate (law-level cases).
    pub scatters: Vec<Scatter>,
    /// Fitted curve of each effect found, in the order of the report's effects.
    pub effect_curves: Vec<Curve>,
    /// What is missing, for `unknown` and `effects+unknown`.
    pub missing_curve: Option<Curve>,
    /// Every fitted parameter of the extended model, nuisances first.
    pub parameters: Vec<ParameterRow>,
    /// Candidates' intervals and forms, in the order of the report's candidates; may be shorter.
    pub candidates: Vec<CandidateDetail>,
    /// Fitted gap with none of the candidates, found in the same way as theirs (wagon cases).
    pub gap_without_any: Option<f64>,
    /// Candidates that the data cannot separate, and why.
    pub ties: Vec<Tie>,
    /// The test against chance.
    pub alarm: Option<Alarm>,
    /// How to make this report again.
    pub settings: Settings,
}

/// A run of the case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunRow {
    /// Name of the file without its ending.
    pub name: String,
    /// Whether the run was only predicted.
    pub holdout: bool,
    /// Samples or points.
    pub samples: usize,
    /// Length, s; absent for law-level cases.
    pub duration_s: Option<f64>,
    /// Gap of the nominal model.
    pub nominal: f64,
    /// Gap of the calibrated model.
    pub calibrated: f64,
    /// Gap of the extended model.
    pub extended: f64,
}

/// Gap by signal (rows) and region (columns, grouped by the variable that cuts them).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// Rows.
    pub signals: Vec<String>,
    /// Groups of columns.
    pub groups: Vec<HeatGroup>,
}

/// One variable's regions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatGroup {
    /// Name for people: `speed`, `slip`, `disc temperature`.
    pub variable: String,
    /// Unit for people.
    pub unit: String,
    /// Limits of the regions, one more than there are regions, rising.
    pub edges: Vec<f64>,
    /// Samples in each region.
    pub samples: Vec<usize>,
    /// Gap of the calibrated model, `[signal][region]`; NaN where there is no data.
    pub calibrated: Vec<Vec<f64>>,
    /// Gap of the extended model, same shape.
    pub extended: Vec<Vec<f64>>,
}

/// Something that happens to a wheelset in a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Event {
    /// Name of the run.
    pub run: String,
    /// Whether the run was only predicted: a run that was fitted may have the same name.
    pub holdout: bool,
    /// The wheelset's number from the front, from 0.
    pub wheelset: usize,
    /// Beginning, s as recorded.
    pub from_s: f64,
    /// End, s as recorded.
    pub to_s: f64,
    /// What happens: `front wheelset locks`.
    pub words: String,
    /// Largest creepage, 0 to 1: the events with the largest one matter most.
    pub severity: f64,
}

/// A place of the equations that was freed by a wandering disturbance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FreedPlace {
    /// In words, with its wheelset.
    pub place: String,
    /// Terms of the equations whose effects show at this place.
    pub terms: Vec<String>,
    /// Log-likelihood gained over the calibrated model.
    pub before: f64,
    /// Log-likelihood gained over the extended model, where there is one.
    pub after: Option<f64>,
    /// Size of the disturbance, one sigma.
    pub size: f64,
    /// Unit of the size; empty where dimensionless.
    pub unit: String,
    /// Correlation time, s.
    pub time_s: f64,
}

/// A stretch of one run with the outputs of the models.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TraceWindow {
    /// Name of the run.
    pub run: String,
    /// Number of the window within the run, from 0.
    pub window: usize,
    /// Whether the run was only predicted.
    pub holdout: bool,
    /// Time axis, s; at most a few hundred samples are drawn, more are thinned.
    pub t_s: Vec<f64>,
    /// One for each output.
    pub traces: Vec<Trace>,
}

impl TraceWindow {
    /// Those of the events that are in this window.
    pub fn among<'a>(&self, events: &'a [Event]) -> Vec<&'a Event> {
        let (Some(first), Some(last)) = (self.t_s.first(), self.t_s.last()) else { return Vec::new() };
        let same = |e: &&Event| e.run == self.run && e.holdout == self.holdout;
        events.iter().filter(same).filter(|e| e.to_s >= *first && e.from_s <= *last).collect()
    }
}

/// An output, measured and predicted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Column name.
    pub name: String,
    /// Unit for people.
    pub unit: String,
    /// Sensor sigma.
    pub sigma: f64,
    /// As measured.
    pub measured: Vec<f64>,
    /// Predicted by the nominal model.
    pub nominal: Vec<f64>,
    /// Predicted by the calibrated model.
    pub calibrated: Vec<f64>,
    /// Predicted by the extended model.
    pub extended: Vec<f64>,
}

impl Trace {
    /// Errors of `predicted` in sensor sigmas.
    pub fn errors(&self, predicted: &[f64]) -> Vec<f64> {
        let pairs = predicted.iter().zip(&self.measured);
        pairs.map(|(predicted, measured)| (predicted - measured) / self.sigma).collect()
    }
}

/// RMS of errors; zero if there are none.
pub fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}

/// Points of a bench and the models over one covariate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scatter {
    /// Heading, such as `holdout: sweep_3` or `force over creepage, load 9 to 11 kN`.
    pub title: String,
    /// Axis across.
    pub x: Axis,
    /// Axis upwards.
    pub y: Axis,
    /// Measured points.
    pub measured: Vec<[f64; 2]>,
    /// Lines of the models, each rising in x.
    pub nominal: Vec<[f64; 2]>,
    /// With fitted nuisances.
    pub calibrated: Vec<[f64; 2]>,
    /// With nuisances and effects.
    pub extended: Vec<[f64; 2]>,
}

/// What an axis shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Name for people.
    pub label: String,
    /// Unit for people; empty where dimensionless.
    pub unit: String,
}

/// A curve with a band, and the data behind it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Heading: the effect's id, or what is missing.
    pub title: String,
    /// The law in one line; may be empty.
    pub equation: String,
    /// Axis across.
    pub x: Axis,
    /// Axis upwards.
    pub y: Axis,
    /// The curve, rising in x.
    pub points: Vec<CurvePoint>,
    /// What the model without the effect says, as a constant or a line; may be empty.
    pub reference: Vec<[f64; 2]>,
    /// Binned data that the curve follows; may be empty.
    pub data: Vec<[f64; 2]>,
    /// Region of x that matters most.
    pub region: Option<Interval>,
}

/// A point of a curve with its 95 % band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvePoint {
    /// Across.
    pub x: f64,
    /// Upwards.
    pub y: f64,
    /// Lower limit of the band.
    pub low: f64,
    /// Upper limit of the band.
    pub high: f64,
}

/// A fitted parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterRow {
    /// Id of the effect, or `nuisance`.
    pub owner: String,
    /// Name; the unit is in it.
    pub name: String,
    /// As the case states it, where it does.
    pub nominal: Option<f64>,
    /// Fitted value.
    pub value: f64,
    /// 95 % confidence interval.
    pub ci95: Interval,
    /// Allowed range.
    pub bounds: Interval,
}

/// More about a candidate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CandidateDetail {
    /// Id, as in the report.
    pub id: String,
    /// Interval of its `cv_gain` (two standard errors over the folds), where there is one.
    pub cv_gain_interval: Option<Interval>,
    /// The form that fitted best, in one line; may be empty.
    pub form: String,
    /// Names of parameters that ended on a bound.
    pub on_bound: Vec<String>,
}

/// Candidates that the data cannot separate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tie {
    /// Ids.
    pub ids: Vec<String>,
    /// Why, and what would separate them.
    pub because: String,
}

/// The test of the best candidate against chance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Alarm {
    /// What is compared, in words.
    pub statistic: String,
    /// Probability of a false alarm for which the threshold was set.
    pub level: f64,
    /// Its quantile under no effect.
    pub threshold: f64,
    /// What the best candidate reaches.
    pub observed: f64,
    /// How recordings without an effect were imitated, as a clause that `… times` can follow.
    pub how: String,
    /// Draws behind the quantile.
    pub replicates: usize,
}

/// How to make a report again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Program and version.
    pub version: String,
    /// The command line.
    pub command: String,
    /// Seed of the bootstraps.
    pub seed: u64,
    /// Candidates that were left out on demand.
    pub without: Vec<String>,
    /// More settings as name and value.
    pub more: Vec<(String, String)>,
}
