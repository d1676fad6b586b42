//! A wagon that does not brake while its train does.
//!
//! No wagon can tell by itself that the train brakes; here all of them are known. A wagon is without a brake when its
//! pressing force is a small share of the median of all wagons for as long as that median stands.

use super::middle::LEAST_WAGONS;
use crate::settings::IndicatorSettings;
use railgrip_messages::Health;
use std::collections::BTreeMap;

/// The train must have braked for so long, s: cylinders do not fill at the same instant.
const AFTER_S: f64 = 4.0;
/// Less than this share of the median is no pressing force.
const NONE_SHARE: f64 = 0.15;
/// Braking behind a verdict, s.
const LEAST_BRAKING_S: f64 = 3.0;

/// Who was pressed in the latest braking of the train.
#[derive(Debug, Default)]
pub(super) struct Pressed {
    wagons: BTreeMap<u32, Share>,
    braking_s: f64,
}

/// Seconds without a brake and seconds of braking, both fading.
#[derive(Debug, Default)]
struct Share {
    without_s: f64,
    braking_s: f64,
}

impl Pressed {
    /// Takes in what the live wagons say, `dt_s` after the last time.
    pub(super) fn take(&mut self, live: &[&Health], dt_s: f64, settings: &IndicatorSettings) {
        let of = |health: &Health| health.pressing_force_n / health.wheelset_count().max(1) as f64;
        let mut forces_n: Vec<f64> =
            live.iter().map(|health| of(health)).filter(|force_n| force_n.is_finite()).collect();
        forces_n.sort_by(f64::total_cmp);
        let median_n = forces_n.get(forces_n.len() / 2).copied().unwrap_or(0.0);
        let braking =
            forces_n.len() >= LEAST_WAGONS && median_n >= 2.0 * settings.brake_friction.min_pressing_force_n;
        self.braking_s = if braking { self.braking_s + dt_s } else { 0.0 };
        if self.braking_s < AFTER_S {
            return;
        }
        let keep = (-dt_s / settings.isolated.memory_s).exp();
        for health in live.iter().filter(|health| of(health).is_finite()) {
            let protected = health.wheelset[..health.wheelset_count()].iter().any(|one| one.wsp_active != 0);
            if protected {
                continue;
            }
            let share = self.wagons.entry(health.wagon).or_default();
            let without = f64::from(u8::from(of(health) < NONE_SHARE * median_n));
            share.without_s = keep * share.without_s + dt_s * without;
            share.braking_s = keep * share.braking_s + dt_s;
        }
    }

    /// Share of the latest braking of the train during which a wagon had no pressing force.
    pub(super) fn without_brake(&self, wagon: u32) -> Option<f64> {
        let share = self.wagons.get(&wagon).filter(|share| share.braking_s >= LEAST_BRAKING_S)?;
        Some(share.without_s / share.braking_s)
    }
}
