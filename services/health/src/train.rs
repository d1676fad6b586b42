//! The train as a whole: how far it needs to stop now, and where along the track the rail is low.

use crate::history::query;
use crate::model::Grade;
use crate::problem::Problem;
use crate::shared::Shared;
use crate::view::rounded;
use axum::Json;
use axum::extract::{RawQuery, State};
use railgrip_indicators::stopping::{BrakedWagon, distance_m};
use railgrip_indicators::track::TrackMap;
use railgrip_settings::CapabilitySettings;
use serde::Serialize;
use utoipa::ToSchema;

/// Worth a look from here on: the lower end of the interval over the nominal distance.
pub(crate) const WATCH_RATIO: f64 = 1.2;
/// Needs action from here on.
pub(crate) const ACT_RATIO: f64 = 1.6;
/// Weak wagons that are named.
const MOST_WEAK: usize = 5;

/// What requests about the whole train need beside the wagons; renewed every few seconds.
#[derive(Debug, Clone)]
pub struct Whole {
    /// The wagons as they brake now, with those that are nominal.
    pub braked: Vec<(BrakedWagon, BrakedWagon)>,
    /// Wagons whose brakes are known now.
    pub known: usize,
    /// What full braking is.
    pub settings: CapabilitySettings,
    /// Stopping distances from the speeds of the config.
    pub capability: CapabilityView,
    /// Adhesion along the track.
    pub map: MapView,
}

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

/// Stopping distances from the present friction and adhesion, against nominal.
#[utoipa::path(get, path = "/api/v1/train/capability", tag = "train",
    params(("speed_km_h" = Option<f64>, Query, minimum = 1, maximum = 500,
        description = "One speed, km/h, instead of those of the config")),
    responses(
        (status = 200, description = "Now against nominal", body = CapabilityView),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
    ))]
pub(crate) async fn capability(
    State(shared): State<Shared>,
    RawQuery(query): RawQuery,
) -> Result<Json<CapabilityView>, Problem> {
    let snapshot = shared.latest();
    let pairs = query::parameters(query.as_deref(), &["speed_km_h"])?;
    let Some(text) = query::value(&pairs, "speed_km_h") else {
        return Ok(Json(snapshot.whole.capability.clone()));
    };
    let speed = text.parse().ok().filter(|speed: &f64| (1.0..=500.0).contains(speed));
    let speed = speed.ok_or_else(|| query::refuse("speed_km_h", text, "1 to 500"))?;
    let whole = &snapshot.whole;
    Ok(Json(judge(&whole.braked, whole.known, &whole.settings, &[speed])))
}

impl Whole {
    /// Wagons as they brake now with those that are nominal, `known` of them with news, and the map.
    #[must_use]
    pub fn new(
        braked: Vec<(BrakedWagon, BrakedWagon)>,
        known: usize,
        settings: &CapabilitySettings,
        map: &TrackMap,
        now_s: f64,
    ) -> Self {
        let capability = judge(&braked, known, settings, &settings.speeds_km_h);
        let map = MapView::of(map, settings.cell_m, now_s);
        Self { braked, known, settings: settings.clone(), capability, map }
    }
}

/// Stopping distances and what to think of them.
fn judge(
    braked: &[(BrakedWagon, BrakedWagon)],
    known: usize,
    settings: &CapabilitySettings,
    speeds_km_h: &[f64],
) -> CapabilityView {
    let (now, nominal): (Vec<BrakedWagon>, Vec<BrakedWagon>) = braked.iter().copied().unzip();
    let (full, response_s) = (settings.full_deceleration_m_s2, settings.response_s);
    let stop = |speed_km_h: &f64| {
        let v_m_s = speed_km_h / 3.6;
        let [distance, low, high] = distance_m(&now, v_m_s, full, response_s).map(rounded);
        let [nominal_m, ..] = distance_m(&nominal, v_m_s, full, response_s).map(rounded);
        let ratio = rounded(distance / nominal_m.max(1e-9));
        StopView { speed_km_h: *speed_km_h, distance_m: distance, low_m: low, high_m: high, nominal_m, ratio }
    };
    let stops: Vec<StopView> = speeds_km_h.iter().map(stop).collect();
    let largest = |of: fn(&StopView) -> f64| {
        stops.iter().map(|stop| of(stop) / stop.nominal_m.max(1e-9)).fold(0.0, f64::max)
    };
    let (sure, now) = (largest(|stop| stop.low_m), largest(|stop| stop.distance_m));
    let (grade, words) = match sure {
        _ if known == 0 => {
            (Grade::Unknown, "no wagon has told enough of its brakes yet, so this rests on assumptions")
        }
        _ if sure > ACT_RATIO => (Grade::Act, "needs far longer than nominal"),
        _ if sure > WATCH_RATIO => (Grade::Watch, "needs longer than nominal"),
        _ if now > WATCH_RATIO => {
            (Grade::Ok, "may need longer than nominal, which the interval does not settle")
        }
        _ => (Grade::Ok, "nothing shows that it needs longer than nominal"),
    };
    let mut worst_wagons: Vec<WeakWagon> =
        braked.iter().enumerate().filter_map(|(index, (now, _))| weak(index as u32 + 1, now, full)).collect();
    worst_wagons.sort_by(|a, b| a.brake_share.total_cmp(&b.brake_share));
    worst_wagons.truncate(MOST_WEAK);
    let reason = format!("{words}: about {:.0} % of the nominal distance", 100.0 * now);
    CapabilityView { grade, reason, full_deceleration_m_s2: full, response_s, stops, worst_wagons }
}

/// What a wagon lacks of its nominal brake force, if it is worth a word.
fn weak(wagon: u32, now: &BrakedWagon, full_m_s2: f64) -> Option<WeakWagon> {
    let pads = now.friction_ratio[0];
    let rail = now.adhesion[0] * 9.81 / full_m_s2;
    let share = now.braked_share * pads.min(rail);
    let lack = match now.braked_share {
        braked if braked < pads.min(rail) => Lack::Isolated,
        _ if rail < pads => Lack::Rail,
        _ => Lack::Pads,
    };
    (share < 0.95).then(|| WeakWagon { wagon, brake_share: rounded(share), lack })
}

/// One stretch of track.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapCell {
    /// Where it begins, m.
    pub from_m: f64,
    /// Where it ends, m.
    pub to_m: f64,
    /// Adhesion available: the median.
    pub adhesion: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Probability that it is low or very low.
    pub low_probability: f64,
    /// Wagons that have passed it.
    pub wagons: u32,
    /// Observations of sliding wheelsets behind it.
    pub slides: u32,
    /// Since it was last passed, s.
    pub age_s: f64,
}

/// Adhesion along the track.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapView {
    /// Length of a cell, m.
    pub cell_m: f64,
    /// Passed cells in the order of position.
    pub cells: Vec<MapCell>,
}

impl MapView {
    fn of(map: &TrackMap, cell_m: f64, now_s: f64) -> Self {
        let cells = map.view(now_s).into_iter().map(|cell| MapCell {
            from_m: cell.from_m,
            to_m: cell.from_m + cell_m,
            adhesion: rounded(cell.adhesion[0]),
            low: rounded(cell.adhesion[1]),
            high: rounded(cell.adhesion[2]),
            low_probability: rounded((cell.classes[2] + cell.classes[3]).min(1.0)),
            wagons: cell.wagons as u32,
            slides: cell.slides,
            age_s: rounded(cell.age_s),
        });
        Self { cell_m, cells: cells.collect() }
    }
}

/// Adhesion by track position, from what every wagon saw that passed; it fades when nobody passes.
#[utoipa::path(get, path = "/api/v1/train/adhesion-map", tag = "train", responses(
    (status = 200, description = "The passed stretches", body = MapView),
))]
pub(crate) async fn adhesion_map(State(shared): State<Shared>) -> Json<MapView> {
    Json(shared.latest().whole.map.clone())
}
