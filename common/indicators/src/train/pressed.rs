//! A wagon that does not brake while its train does.
//!
//! No wagon can tell by itself that the train brakes; here all of them are known. A wagon is without a brake when its
//! pressing force is a small share of the median of all wagons from the beginning of an application to its end. One that is
//! pressed later has a brake, and so has one that was pressed and is no longer: in a long train the order needs seconds to reach the
//! last wagons, and the first ones release before them.

use super::middle::LEAST_WAGONS;
use crate::settings::IndicatorSettings;
use railgrip_messages::Health;
use std::collections::BTreeMap;

/// The train must have braked for so long, s: cylinders do not fill at the same instant.
const AFTER_S: f64 = 4.0;
/// A wagon that has not been pressed for so long since then is not late, s: goods brakes take half a minute.
const LATEST_S: f64 = 45.0;
/// Less than this share of the median is no pressing force.
const NONE_SHARE: f64 = 0.15;
/// Braking behind a verdict, s.
const LEAST_BRAKING_S: f64 = 3.0;

/// Who was pressed in the latest braking of the train.
#[derive(Debug, Default)]
pub(super) struct Pressed {
    wagons: BTreeMap<u32, Share>,
    braking_s: f64,
    /// Median in the latest application.
    usual_n: f64,
}

/// Seconds without a brake and seconds of braking, both fading; of this application, whether the wagon was pressed, and for how
/// long it was not yet.
#[derive(Debug, Default)]
struct Share {
    without_s: f64,
    braking_s: f64,
    pressed: bool,
    not_yet_s: f64,
}

impl Share {
    /// What has not been pressed until now will not be.
    fn give_up(&mut self) {
        let lost_s = std::mem::take(&mut self.not_yet_s);
        (self.without_s, self.braking_s) = (self.without_s + lost_s, self.braking_s + lost_s);
    }
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
        let ended = !braking && self.braking_s > 0.0;
        self.braking_s = if braking { self.braking_s + dt_s } else { 0.0 };
        let counts = self.braking_s >= AFTER_S;
        if counts {
            self.usual_n = median_n;
        }
        // In the first seconds, and after the others have released, the last application tells what pressing is.
        let none_n =
            settings.brake_friction.min_pressing_force_n.max(NONE_SHARE * median_n.max(self.usual_n));
        let keep = (-dt_s / settings.isolated.memory_s).exp();
        for health in live.iter().filter(|health| of(health).is_finite()) {
            // Slide protection acts on what is pressed.
            let protected = health.wheelset[..health.wheelset_count()].iter().any(|one| one.wsp_active != 0);
            let share = self.wagons.entry(health.wagon).or_default();
            if ended {
                share.give_up();
                share.pressed = false;
            }
            if protected || of(health) >= none_n {
                (share.pressed, share.not_yet_s) = (true, 0.0);
            }
            if !counts {
                continue;
            }
            (share.without_s, share.braking_s) = (keep * share.without_s, keep * share.braking_s);
            if share.pressed {
                share.braking_s += dt_s;
            } else {
                share.not_yet_s += dt_s;
                if self.braking_s >= LATEST_S {
                    share.give_up();
                }
            }
        }
    }

    /// Share of the latest braking of the train during which a wagon had no pressing force.
    pub(super) fn without_brake(&self, wagon: u32) -> Option<f64> {
        let share = self.wagons.get(&wagon).filter(|share| share.braking_s >= LEAST_BRAKING_S)?;
        Some(share.without_s / share.braking_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    /// What nine wagons that are braked again and again say of the third, if at each fifth of a second of an application's 20 s it
    /// has the force and the slide protection that `third` tells, and the others press for the first 14 s.
    fn share_of(third: impl Fn(f64) -> (f64, u32)) -> f64 {
        let settings = IndicatorSettings::default();
        let mut pressed = Pressed::default();
        for at in 0..400 {
            let time_s = 0.2 * f64::from(at % 100);
            let healths: Vec<Health> = (1..=9)
                .map(|wagon| {
                    let others_n = if time_s < 14.0 { 80e3 } else { 0.0 };
                    let (force_n, active) = if wagon == 3 { third(time_s) } else { (others_n, 0) };
                    let mut health =
                        Health { wagon, wheelsets: 2, pressing_force_n: force_n, ..Health::zeroed() };
                    health.wheelset[0].wsp_active = active;
                    health
                })
                .collect();
            pressed.take(&healths.iter().collect::<Vec<_>>(), 0.2, &settings);
        }
        pressed.without_brake(3).unwrap()
    }

    #[test]
    fn a_wagon_that_the_order_reaches_late_has_a_brake() {
        let share = share_of(|time_s| (if (9.0..16.0).contains(&time_s) { 80e3 } else { 0.0 }, 0));
        assert!(share < 1e-9, "{share}");
    }

    #[test]
    fn a_long_application_is_not_waited_for() {
        let settings = IndicatorSettings::default();
        let mut pressed = Pressed::default();
        let braked = |wagon| if wagon == 3 { 0.0 } else { 80e3 };
        let mut told_s = None;
        for at in 0..400 {
            let healths: Vec<Health> = (1..=9)
                .map(|wagon| Health {
                    wagon,
                    wheelsets: 2,
                    pressing_force_n: braked(wagon),
                    ..Health::zeroed()
                })
                .collect();
            pressed.take(&healths.iter().collect::<Vec<_>>(), 0.2, &settings);
            told_s = told_s.or(pressed.without_brake(3).map(|_| 0.2 * f64::from(at)));
        }
        assert!(pressed.without_brake(3).unwrap() > 0.99 && pressed.without_brake(4).unwrap() < 1e-9);
        assert!(told_s.is_some_and(|told_s| (40.0..50.0).contains(&told_s)), "{told_s:?}");
    }

    #[test]
    fn a_wagon_is_without_a_brake_if_it_is_not_pressed_all_through() {
        assert!(share_of(|_| (0.0, 0)) > 0.99);
        assert!(share_of(|_| (4e3, 0)) > 0.99, "what leaks in is no brake");
        assert!(share_of(|_| (80e3, 0)) < 0.01);
    }

    #[test]
    fn a_wagon_that_releases_before_the_others_has_a_brake() {
        assert!(share_of(|time_s| (if time_s < 7.0 { 80e3 } else { 0.0 }, 0)) < 0.01);
    }

    #[test]
    fn a_wagon_whose_slide_protection_vents_it_has_a_brake() {
        let vented = |time_s: f64| if time_s < 2.0 { (1e3, 1) } else { (1e3, 0) };
        assert!(share_of(vented) < 0.01);
    }
}
