//! The health indicators of a wagon and of its train: pure arithmetic from samples and estimates, no clock, no channel, no
//! file. README.md beside this crate says what an indicator is, how to add one, and what none of them can see.
//!
//! * [`INDICATORS`] – the one table; each entry is an [`IndicatorSpec`] in a file of its own below [`indicator`];
//! * `measure` – the quantities behind them, at full rate;
//! * [`Observed`] – all that was measured of one wagon; [`WagonIndicators`] takes each sample with its estimate and gives a
//!   [`railgrip_messages::Health`] on demand: figures with 95 % intervals, a grade each, and the reason in words;
//! * [`train`] – what only the wagons together show: who brakes late, who not at all, how far the train runs, where the
//!   rail is low;
//! * [`signals`] – figures that are remembered and not judged;
//! * [`trend`] – where an indicator is going.
//!
//! # Glossary
//! *Utilised* and *available* adhesion as in the vehicle crate. *Memory*: older data count less, by a factor e per memory.

pub mod belief;
pub mod indicator;
mod measure;
mod nominal;
mod observed;
mod settings;
pub mod signals;
mod spec;
mod table;
pub mod train;
pub mod trend;
mod wagon;

pub use nominal::Nominal;
pub use observed::{IndicatorState, Instant, Memory, Observed};
pub use settings::{
    AdhesionSettings, AsymmetrySettings, BrakeFrictionSettings, DraggingSettings, FilterSettings,
    IndicatorSettings, IsolatedSettings, ResponseSettings, SandingSettings, SensorSettings, SettingEntry,
    SettingError, SlideSettings, StandardSettings, WspSettings,
};
pub use spec::{
    Advice, AlertRule, Form, IndicatorSpec, Judge, JudgeAmong, JudgeTrain, JudgeWagon, JudgeWheelset, Limit,
    Meaning, Metric, Reach, Stored, Unit,
};
pub use table::{INDICATORS, Judged, Table};
pub use wagon::WagonIndicators;
