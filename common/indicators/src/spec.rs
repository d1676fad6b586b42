//! What an indicator is: one entry of the table, from the figure to its meaning in words.
//!
//! # Glossary
//! *Rule*, *group*, *inhibition* as Alertmanager uses them: a rule raises an alert from an indicator; indicators with one
//! *cause* are grouped into one alert; an alert is inhibited while another one that explains it asks for action.

use crate::nominal::Nominal;
use crate::observed::{Instant, Memory, Observed};
use crate::settings::IndicatorSettings;
use crate::train::capability::{Capability, FullBraking};
use crate::train::neighbours::Neighbours;
use railgrip_messages::Indicator;

/// One indicator. Whatever lists indicators (API, history, metrics, alert rules, trends, the page *Meaning*) is a loop over
/// a table of these.
#[derive(Debug)]
pub struct IndicatorSpec {
    /// Stable id, for example `dragging`: symptom of alerts, and root of all names, see [`Self::field`].
    pub id: &'static str,
    /// Name in a table for people.
    pub label: &'static str,
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
        label: "",
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

    /// The id in words: `brake friction`.
    #[must_use]
    pub fn words(&self) -> String {
        self.id.replace('_', " ")
    }
}

/// Unit of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A ratio, a share or a factor.
    Ratio,
    /// A number of things.
    Count,
    /// s.
    Seconds,
    /// N.
    Newtons,
}

impl Unit {
    /// Its symbol; empty for a ratio or a count.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Ratio | Self::Count => "",
            Self::Seconds => "s",
            Self::Newtons => "N",
        }
    }

    /// What names of fields end with.
    #[must_use]
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Ratio | Self::Count => "",
            Self::Seconds => "_s",
            Self::Newtons => "_n",
        }
    }

    /// What names of Prometheus metrics end with: base units in words.
    #[must_use]
    pub const fn metric_suffix(self) -> &'static str {
        match self {
            Self::Ratio => "_ratio",
            Self::Count => "",
            Self::Seconds => "_seconds",
            Self::Newtons => "_newtons",
        }
    }
}

/// How a figure is written for people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// What the figure is multiplied with.
    pub factor: f64,
    /// Decimals.
    pub digits: usize,
    /// Unit behind it, with the space before it.
    pub unit: &'static str,
}

impl Form {
    /// A coefficient of friction.
    pub const COEFFICIENT: Self = Self { factor: 1.0, digits: 3, unit: "" };
    /// A share, as percent.
    pub const PERCENT: Self = Self { factor: 100.0, digits: 0, unit: "\u{202f}%" };
    /// A factor around 1.
    pub const FACTOR: Self = Self { factor: 1.0, digits: 2, unit: "" };
    /// A number of things.
    pub const COUNT: Self = Self { factor: 1.0, digits: 0, unit: "" };
    /// A time.
    pub const SECONDS: Self = Self { factor: 1.0, digits: 1, unit: "\u{202f}s" };
    /// A force given in N, as kN.
    pub const KILONEWTONS: Self = Self { factor: 1e-3, digits: 1, unit: "\u{202f}kN" };
}

/// How a wagon is judged by what was observed of it.
pub type JudgeWagon = fn(&Observed, &Memory) -> Indicator;
/// How a wheelset (index, 0 leading) is judged by what was observed of its wagon.
pub type JudgeWheelset = fn(&Observed, usize) -> Indicator;
/// How a wagon (number) is judged against the others of its train; `None` if they say nothing.
pub type JudgeAmong = fn(&Neighbours, u32, &IndicatorSettings) -> Option<Indicator>;
/// How a train is judged.
pub type JudgeTrain = fn(&Capability) -> Indicator;

/// How an indicator is judged: figure with its interval, grade and reason. Each place has its own function.
#[derive(Debug, Clone, Copy)]
pub struct Judge {
    /// Takes in an instant at full rate, for an indicator with a memory of its own.
    pub take: Option<fn(&mut Memory, &Instant<'_>)>,
    /// The wagon.
    pub wagon: Option<JudgeWagon>,
    /// Each wheelset.
    pub wheelset: Option<JudgeWheelset>,
    /// The wagon among its neighbours.
    pub among: Option<JudgeAmong>,
    /// The train.
    pub train: Option<JudgeTrain>,
}

impl Judge {
    /// Nothing is judged.
    pub const NONE: Self = Self { take: None, wagon: None, wheelset: None, among: None, train: None };
}

/// From where on a figure is worth a look or needs action, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Ends of the scale on which it is drawn.
    pub scale: (f64, f64),
    /// Needs action below.
    pub act_low: Option<f64>,
    /// Worth a look below.
    pub watch_low: Option<f64>,
    /// Worth a look above.
    pub watch_high: Option<f64>,
    /// Needs action above.
    pub act_high: Option<f64>,
}

impl Limit {
    /// A scale without limits.
    #[must_use]
    pub const fn free(low: f64, high: f64) -> Self {
        Self { scale: (low, high), act_low: None, watch_low: None, watch_high: None, act_high: None }
    }

    /// Limits of a figure that is bad when large, on a scale from zero.
    #[must_use]
    pub const fn above(scale_high: f64, watch: f64, act: f64) -> Self {
        Self { watch_high: Some(watch), act_high: Some(act), ..Self::free(0.0, scale_high) }
    }

    /// The same in another unit.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        let of = |end: Option<f64>| end.map(|end| end * factor);
        Self {
            scale: (self.scale.0 * factor, self.scale.1 * factor),
            act_low: of(self.act_low),
            watch_low: of(self.watch_low),
            watch_high: of(self.watch_high),
            act_high: of(self.act_high),
        }
    }
}

/// Which figures of an indicator something is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// None.
    Nowhere,
    /// That of the wagon.
    Wagon,
    /// Those of the wheelsets.
    Wheelsets,
    /// Both.
    Both,
}

impl Reach {
    /// True if that of the wagon is meant.
    #[must_use]
    pub const fn wagon(self) -> bool {
        matches!(self, Self::Wagon | Self::Both)
    }

    /// True if those of the wheelsets are meant.
    #[must_use]
    pub const fn wheelsets(self) -> bool {
        matches!(self, Self::Wheelsets | Self::Both)
    }
}

/// When an indicator raises an alert, with what it is grouped, and what to do. What the judges of a wagon among its
/// neighbours and of the train say always raises one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlertRule {
    /// Id of the indicator that stands for the cause; alerts are grouped by it. Inhibition, reach and advice of that entry
    /// hold for the group.
    pub cause: &'static str,
    /// Which of the figures judged on the wagon raise it.
    pub raised_by: Reach,
    /// How many times longer than others it must last before it counts, at watch and at act.
    pub patience: [f64; 2],
    /// The cause never lies in one wagon: there is one alert for the train.
    pub of_train: bool,
    /// Causes that explain it: while one of them asks for action on the same wagon, this one is inhibited.
    pub inhibited_by: &'static [&'static str],
    /// A recording of the latest minutes explains it.
    pub recorded: bool,
    /// What to do.
    pub advice: Advice,
    /// Names under which older versions kept its symptoms.
    pub formerly: &'static [&'static str],
}

impl AlertRule {
    /// A rule for one wagon that nothing inhibits.
    #[must_use]
    pub const fn of(cause: &'static str, raised_by: Reach, advice: Advice) -> Self {
        Self {
            cause,
            raised_by,
            patience: [1.0, 1.0],
            of_train: false,
            inhibited_by: &[],
            recorded: false,
            advice,
            formerly: &[],
        }
    }
}

/// What to do about a cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Advice {
    /// Where one wagon shows it.
    pub wagon: &'static str,
    /// Where most of the train shows it.
    pub train: &'static str,
}

impl Advice {
    /// Where nothing better is known.
    pub const LOOK: Self =
        Self { wagon: "Have a look at this wagon.", train: "Have a look at these wagons." };

    /// The same wherever it shows.
    #[must_use]
    pub const fn same(text: &'static str) -> Self {
        Self { wagon: text, train: text }
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
    /// Name as a heading.
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
