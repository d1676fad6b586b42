//! What an indicator is: one entry of the table, from the figure to its meaning in words.

mod alert;
mod judge;
mod limit;
mod reach;
mod unit;

pub use alert::{Advice, AlertRule};
pub use judge::{Judge, JudgeAmong, JudgeTrain, JudgeWagon, JudgeWheelset};
pub use limit::Limit;
pub use reach::Reach;
pub use unit::{Form, Unit};

use crate::nominal::Nominal;
use crate::settings::IndicatorSettings;
use crate::train::capability::FullBraking;

/// One indicator. Whatever lists indicators (API, history, metrics, alert rules, trends, the page *Meaning*) is a loop over
/// a table of these.
#[derive(Debug)]
pub struct IndicatorSpec {
    /// Stable id, for example `dragging`: symptom of alerts, and root of all names, see [`Self::field`].
    pub id: &'static str,
    /// Unit of the figure.
    pub unit: Unit,
    /// How the figure is written for people.
    pub form: Form,
    /// How it is judged.
    pub judge: Judge,
    /// From where on it is worth a look or needs action.
    pub limit: Option<fn(&IndicatorSettings, &Nominal) -> Limit>,
    /// The rule that raises alerts from it; without one it does not count towards the grade of its wagon.
    pub alert: Option<AlertRule>,
    /// What the history keeps of it.
    pub stored: Stored,
    /// Where its past is searched for a trend.
    pub trend: Reach,
    /// Its Prometheus metric.
    pub metric: Option<Metric>,
    /// Definition in words.
    pub meaning: Meaning,
    /// Names under which older versions kept it in the history.
    pub formerly: &'static [&'static str],
}

impl IndicatorSpec {
    /// An indicator that is kept with its interval and that nothing judges, for use with struct update syntax.
    pub const PLAIN: Self = Self {
        id: "",
        unit: Unit::Ratio,
        form: Form::COEFFICIENT,
        judge: Judge::NONE,
        limit: None,
        alert: None,
        stored: Stored::Interval,
        trend: Reach::Nowhere,
        metric: None,
        meaning: Meaning::PLAIN,
        formerly: &[],
    };

    /// Its name in the API and in the history: the id with its unit, for example `dragging_n`.
    #[must_use]
    pub fn field(&self) -> String {
        format!("{}{}", self.id, self.unit.suffix())
    }

    /// Its place on the page *Meaning*.
    #[must_use]
    pub fn anchor(&self) -> String {
        self.id.replace('_', "-")
    }

    /// What people call it, wherever it is shown.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.meaning.name
    }
}

/// What the history keeps of an indicator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stored {
    /// Nothing.
    Nothing,
    /// The figure.
    Value,
    /// The figure with its interval.
    Interval,
}

/// A Prometheus metric; of wheelsets it has `wheelset_` before its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Metric {
    /// Name without the prefix of the program, with its unit at the end.
    pub name: &'static str,
    /// What it is.
    pub help: &'static str,
    /// It only grows: a counter, not a gauge.
    pub counter: bool,
    /// Of what there is one.
    pub reach: Reach,
}

impl Metric {
    /// A gauge of the wagon, or of the train where the train is judged.
    #[must_use]
    pub const fn gauge(name: &'static str, help: &'static str) -> Self {
        Self { name, help, counter: false, reach: Reach::Wagon }
    }
}

/// Definition of a figure, in words.
#[derive(Debug, Clone, Copy)]
pub struct Meaning {
    /// What people call it.
    pub name: &'static str,
    /// Block of ISO 13374 that it belongs to.
    pub block: &'static str,
    /// What it is.
    pub definition: &'static str,
    /// Its unit on the page.
    pub unit: &'static str,
    /// What its interval is.
    pub interval: &'static str,
    /// The limits of this train.
    pub limits: fn(&IndicatorSettings, &FullBraking) -> String,
    /// What it cannot see.
    pub cannot_see: &'static str,
}

impl Meaning {
    /// Nothing is said, for use with struct update syntax.
    pub const PLAIN: Self = Self {
        name: "",
        block: "state detection",
        definition: "",
        unit: "none",
        interval: "none",
        limits: |_, _| "Not judged.".to_owned(),
        cannot_see: "",
    };
}
