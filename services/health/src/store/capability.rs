//! How far the train needs to stop now: the judgement.

use crate::api::capability::model::{CapabilityView, Lack, StopView, WeakWagon};
use crate::api::figure::rounded;
use crate::api::grade::Grade;
use railgrip_indicators::stopping::{BrakedWagon, distance_m};
use railgrip_messages::GRAVITY_M_S2;
use railgrip_settings::CapabilitySettings;

/// Worth a look from here on: the lower end of the interval over the nominal distance.
pub(crate) const WATCH_RATIO: f64 = 1.2;
/// Needs action from here on.
pub(crate) const ACT_RATIO: f64 = 1.6;
/// Weak wagons that are named.
const MOST_WEAK: usize = 5;
/// Stopping distances and what to think of them.
pub(crate) fn judge(
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
    let rail = now.adhesion[0] * GRAVITY_M_S2 / full_m_s2;
    let share = now.braked_share * pads.min(rail);
    let lack = match now.braked_share {
        braked if braked < pads.min(rail) => Lack::Isolated,
        _ if rail < pads => Lack::Rail,
        _ => Lack::Pads,
    };
    (share < 0.95).then(|| WeakWagon { wagon, brake_share: rounded(share), lack })
}
