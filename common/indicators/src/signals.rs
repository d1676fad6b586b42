//! Figures that are remembered and shown, but not judged: what a wagon does now, and what it has counted.

use railgrip_messages::{Health, WheelsetHealth};

/// A figure of a wagon or of a wheelset: value and ends of its 95 % interval, NaN where there is none.
#[derive(Debug)]
pub struct Signal<T: 'static> {
    /// Name in the API and in the history, with its unit.
    pub field: &'static str,
    /// Its unit; empty for a ratio, a number or a code.
    pub unit: &'static str,
    /// Whether an interval is kept with it.
    pub interval: bool,
    /// Where it stands.
    pub read: fn(&T) -> [f64; 3],
    /// Names under which older versions kept it in the history.
    pub formerly: &'static [&'static str],
}

/// Declares signals: field, unit, whether with interval, how it is read, and its former names.
macro_rules! signals {
    ($of:ty: $($field:literal $unit:literal $interval:literal $read:expr, $former:expr;)+) => {
        &[$(Signal::<$of> { field: $field, unit: $unit, interval: $interval, read: $read, formerly: $former },)+]
    };
}

/// Those of a wagon.
pub static OF_WAGON: &[Signal<Health>] = signals! { Health:
    "grade" "" false |health| only(f64::from(health.grade)), &[];
    "v_m_s" "m/s" false |health| only(health.v_m_s), &["speed"];
    "position_m" "m" false |health| only(health.position_m), &["position"];
    "adhesion" "" true |health| normal(health.mu_w, health.mu_w_sigma), &[];
    "brake_friction_now" "" true |health| normal(health.mu_b_mean, health.mu_b_mean_sigma), &[];
    "rail_dry" "" false |health| only(health.condition_probability[0]), &[];
    "rail_wet" "" false |health| only(health.condition_probability[1]), &[];
    "rail_low" "" false |health| only(health.condition_probability[2]), &[];
    "rail_very_low" "" false |health| only(health.condition_probability[3]), &[];
    "braking_s" "s" false |health| only(health.braking_s), &["braking"];
    "pressing_force_n" "N" false |health| only(health.pressing_force_n), &["pressing_force"];
    "sand" "" false |health| only(health.sanding_now), &[];
};

/// Those of a wheelset.
pub static OF_WHEELSET: &[Signal<WheelsetHealth>] = signals! { WheelsetHealth:
    "creepage" "" false |wheelset| only(wheelset.slip), &[];
    "slide_energy_j" "J" false |wheelset| only(wheelset.slide_energy_j), &["slide_energy"];
    "slide_s" "s" false |wheelset| only(wheelset.slide_s), &["slide_time"];
};

fn only(value: f64) -> [f64; 3] {
    [value, f64::NAN, f64::NAN]
}

/// Mean and 95 % interval of a normal distribution.
fn normal(mean: f64, sigma: f64) -> [f64; 3] {
    [mean, mean - 1.96 * sigma, mean + 1.96 * sigma]
}
