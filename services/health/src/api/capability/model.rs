//! What the API says of the braking capability, as types.

use crate::api::grade::Grade;
use serde::Serialize;
use utoipa::ToSchema;

/// Stopping distance from one speed.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct StopView {
    /// From this speed, km/h.
    pub speed_km_h: f64,
    /// Distance now, m.
    pub distance_m: f64,
    /// Lower end of its 95 % interval, m.
    pub low_m: f64,
    /// Upper end of its 95 % interval, m.
    pub high_m: f64,
    /// Distance with nominal pads on good rail, m.
    pub nominal_m: f64,
    /// Now over nominal.
    pub ratio: f64,
}

/// Braking capability now.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CapabilityView {
    /// How it is judged: ok, unless even the lower end is 20 % (watch) or 60 % (act) above nominal; unknown without news.
    pub grade: Grade,
    /// In words.
    pub reason: String,
    /// Deceleration of full braking with nominal pads, m/s².
    pub full_deceleration_m_s2: f64,
    /// Dead time, s.
    pub response_s: f64,
    /// One line a speed.
    pub stops: Vec<StopView>,
    /// Wagons that lack brake force, worst first; at most five.
    pub worst_wagons: Vec<WeakWagon>,
}

/// What keeps a wagon from braking as it should.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Lack {
    /// Its pads rub less than nominal.
    Pads,
    /// Some of its wheelsets have no brake.
    Isolated,
    /// The rail takes no more.
    Rail,
}

impl Lack {
    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Pads => "its pads rub less",
            Self::Isolated => "a brake is isolated",
            Self::Rail => "the rail takes no more",
        }
    }
}

/// A wagon that lacks brake force.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WeakWagon {
    /// The wagon.
    pub wagon: u32,
    /// Its brake force at full braking over the nominal one.
    pub brake_share: f64,
    /// Why.
    pub lack: Lack,
}
