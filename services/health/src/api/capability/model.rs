//! What the API says of the braking capability, as types.

use crate::alerts::Vehicles;
use crate::api::figure::rounded;
use crate::api::grade::Grade;
use railgrip_indicators::indicator::STOPPING_DISTANCE;
use railgrip_indicators::train::capability::{self, Capability, FullBraking, Stop};
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

impl From<capability::Lack> for Lack {
    fn from(lack: capability::Lack) -> Self {
        match lack {
            capability::Lack::Pads => Self::Pads,
            capability::Lack::Isolated => Self::Isolated,
            capability::Lack::Rail => Self::Rail,
        }
    }
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
    /// The number of its vehicle, as it is written; `null` without one.
    pub vehicle_number: Option<String>,
    /// Its brake force at full braking over the nominal one.
    pub brake_share: f64,
    /// Why.
    pub lack: Lack,
}

impl CapabilityView {
    /// What was found for a train of these vehicles, whose full braking is `full`.
    pub(crate) fn of(found: &Capability, full: &FullBraking, vehicles: &Vehicles) -> Self {
        let judged = STOPPING_DISTANCE.judge.train.map(|judge| judge(found)).unwrap_or_default();
        let stop = |stop: &Stop| StopView {
            speed_km_h: stop.speed_km_h,
            distance_m: rounded(stop.distance_m[0]),
            low_m: rounded(stop.distance_m[1]),
            high_m: rounded(stop.distance_m[2]),
            nominal_m: rounded(stop.nominal_m),
            ratio: rounded(stop.ratio()[0]),
        };
        let weak = |weak: &capability::WeakWagon| WeakWagon {
            wagon: weak.wagon,
            vehicle_number: vehicles.at(weak.wagon),
            brake_share: rounded(weak.brake_share),
            lack: weak.lack.into(),
        };
        Self {
            grade: judged.grade().into(),
            reason: judged.reason.as_str().to_owned(),
            full_deceleration_m_s2: full.deceleration_m_s2,
            response_s: full.response_s,
            stops: found.stops.iter().map(stop).collect(),
            worst_wagons: found.weak.iter().map(weak).collect(),
        }
    }
}
