//! How a wagon brakes now, from what it says of itself.

use super::stopping::BrakedWagon;
use crate::belief::CLASSES;
use crate::indicator::{ADHESION_AVAILABLE, BRAKE_FRICTION, ISOLATED};
use crate::nominal::Nominal;
use railgrip_messages::Health;

/// Pad friction over nominal of a wagon that says nothing: value, low, high.
const UNKNOWN_FRICTION: [f64; 3] = [1.0, 0.7, 1.1];
/// Adhesion of very low rail over that of low rail.
const VERY_LOW: f64 = 0.5;

/// A wagon with nominal pads on dry rail.
#[must_use]
pub fn nominally(nominal: &Nominal) -> BrakedWagon {
    BrakedWagon {
        mass_kg: nominal.mass_kg,
        rotating_mass_kg: nominal.rotating_mass_kg(),
        friction_ratio: [1.0; 3],
        adhesion: [nominal.rail[0]; 3],
        braked_share: 1.0,
        resistance: nominal.resistance,
    }
}

/// A wagon as it brakes now; `health` is what it says of itself, `None` if it is not live. What is unknown is nominal with a
/// wide interval.
#[must_use]
pub fn now(nominal: &Nominal, health: Option<&Health>) -> BrakedWagon {
    let mut now = BrakedWagon { friction_ratio: UNKNOWN_FRICTION, ..nominally(nominal) };
    let Some(health) = health else { return now };
    let friction = BRAKE_FRICTION.of(health);
    if friction.known != 0 {
        let ends = [friction.value, friction.low, friction.high];
        now.friction_ratio = ends.map(|value| value / nominal.brake_friction);
    }
    let available = ADHESION_AVAILABLE.of(health);
    if available.known != 0 && health.adhesion_available_is_bound == 0 {
        now.adhesion = [available.value, available.low, available.high];
    } else if available.known != 0 {
        // No recent slide: the mean over what the rail may be, within what is known of it.
        let [dry, wet, low] = nominal.rail;
        let levels: [f64; CLASSES] = [dry, wet, low, VERY_LOW * low];
        let classes = levels.iter().zip(health.condition_probability);
        let mean: f64 = classes.map(|(adhesion, share)| adhesion * share).sum();
        let high = available.high.max(available.low);
        now.adhesion = [mean.min(high).max(available.low), available.low, high];
    }
    let wheelsets = health.wheelset_count();
    let isolated = (0..wheelsets).map(|index| ISOLATED.of_wheelset(health, index));
    let without: f64 = isolated.filter(|one| one.known != 0).map(|one| one.value).sum();
    if wheelsets > 0 {
        now.braked_share = (1.0 - without / wheelsets as f64).clamp(0.0, 1.0);
    }
    now
}

/// True if enough is known of the brakes of a wagon.
#[must_use]
pub fn is_known(health: &Health) -> bool {
    BRAKE_FRICTION.of(health).known != 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::indicator::judging::known;
    use railgrip_messages::Grade;

    const NOMINAL: Nominal = Nominal {
        brake_friction: 0.35,
        rail: [0.30, 0.12, 0.06],
        wheelsets: 2,
        mass_kg: 40e3,
        inertia_kg_m2: 120.0,
        wheel_radius_m: 0.44,
        brake_radius_m: 0.25,
        resistance: [400.0, 8.0, 4.0],
        coupled: false,
    };

    #[test]
    fn what_a_wagon_says_takes_the_place_of_what_is_assumed() {
        assert_eq!(now(&NOMINAL, None).friction_ratio, UNKNOWN_FRICTION);
        let mut health = Health { wheelsets: 2, ..Health::default() };
        assert!(!is_known(&health));
        let friction = known(0.28, 0.245, 0.315, Grade::Watch, "low");
        let isolated = known(1.0, 1.0, 1.0, Grade::Act, "no pressing force");
        BRAKE_FRICTION.put(&mut health, friction);
        ISOLATED.put_wheelset(&mut health, 1, isolated);
        let bound = known(0.1, 0.1, 0.35, Grade::Ok, "at least 0.1");
        ADHESION_AVAILABLE.put(&mut health, bound);
        health.adhesion_available_is_bound = 1;
        health.condition_probability = [0.5, 0.5, 0.0, 0.0];
        let now = now(&NOMINAL, Some(&health));
        assert!(is_known(&health));
        assert!((now.friction_ratio[0] - 0.8).abs() < 1e-12 && (now.friction_ratio[1] - 0.7).abs() < 1e-12);
        assert!((now.adhesion[0] - 0.21).abs() < 1e-12, "between dry and wet: {}", now.adhesion[0]);
        assert_eq!(now.braked_share, 0.5);
    }
}
