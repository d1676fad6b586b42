//! How an indicator is judged.

use crate::observed::{Instant, Memory, Observed};
use crate::settings::IndicatorSettings;
use crate::train::capability::Capability;
use crate::train::neighbours::Neighbours;
use railgrip_messages::Indicator;

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
