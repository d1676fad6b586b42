//! Random circumstances of a second of rolling noise.
//!
//! Dry and wet overlap by purpose: a dry rail may be damp and a wet one drying, and load, roughness, rig, gain,
//! microphone, hiss, squeal and other machines vary as much as water does. All spreads are chosen; the tests of
//! `railgrip-acoustics` show that no single feature tells the conditions apart.

use crate::Condition;
use railgrip_acoustics::synthesis::rig::any;
use railgrip_acoustics::synthesis::{Rig, Rolling, Scene, Surroundings, dry_level_db};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Name that stands for a rig of random size and shape, another one every time.
pub const ANY_RIG: &str = "any";
/// Rigs from which the network learns: half of the clips are of rigs of any size, so that it does not learn single rigs
/// by heart. The traction rig stays unheard, and the sizes about it, to see what happens at a new place.
pub const TRAINING_RIGS: [&str; 6] = ["bogie", ANY_RIG, "roller", ANY_RIG, "track", ANY_RIG];
/// The rigs by name whose held-out speeds and noise levels judge a model.
pub const TEST_RIGS: [&str; 3] = ["bogie", "roller", "track"];
/// The rig that is never heard in training.
pub const UNHEARD_RIG: &str = "traction";
/// Levels of background over the dry rolling noise at the same speed that training uses, dB; each ± 2 dB.
pub const TRAINING_NOISE_DB: [f64; 4] = [-40.0, -25.0, -15.0, -5.0];
/// Levels that training never uses, dB.
pub const HELD_OUT_NOISE_DB: [f64; 4] = [-32.0, -20.0, -10.0, 0.0];
/// Bands of speed that training never uses, as shares of a rig's range.
pub const HELD_OUT_SPEEDS: [(f64, f64); 2] = [(0.30, 0.40), (0.65, 0.75)];

/// Which speeds a set of clips has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speeds {
    /// Those for training.
    Training,
    /// Those kept from training.
    HeldOut,
}

/// Which background a set of clips has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// Any of the levels for training.
    Training,
    /// This level over the dry rolling noise, dB.
    Level(f64),
}

/// A set of clips.
#[derive(Clone, Debug, PartialEq)]
pub struct Circumstances {
    /// Names of rigs.
    pub rigs: Vec<&'static str>,
    /// Speeds.
    pub speeds: Speeds,
    /// Background.
    pub noise: Noise,
}

impl Circumstances {
    /// What the network learns from.
    pub fn training() -> Self {
        Self { rigs: TRAINING_RIGS.to_vec(), speeds: Speeds::Training, noise: Noise::Training }
    }
}

/// One clip to be synthesised.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// The rig; no two clips have quite the same.
    pub rig: Rig,
    /// What is to be heard.
    pub scene: Scene,
    /// The condition.
    pub condition: Condition,
    /// Seed of the noise.
    pub seed: u64,
}

/// Draws `count` recipes, half of them wet.
pub fn draw(circumstances: &Circumstances, count: usize, seed: u64) -> Vec<Recipe> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let known = |name: &&str| *name == ANY_RIG || Rig::named(name).is_some();
    let rigs: Vec<&str> = circumstances.rigs.iter().copied().filter(|name| known(name)).collect();
    if rigs.is_empty() {
        return Vec::new();
    }
    (0..count)
        .map(|number| {
            let condition = if number % 2 == 0 { Condition::Dry } else { Condition::Wet };
            // Neighbours differ in condition, so rigs change every two clips.
            let name = rigs[number / 2 % rigs.len()];
            let rig = Rig::named(name).unwrap_or_else(|| any(&mut random)).varied(&mut random);
            one(rig, condition, circumstances, &mut random)
        })
        .collect()
}

fn one(rig: Rig, condition: Condition, circumstances: &Circumstances, random: &mut Pcg64Mcg) -> Recipe {
    let speed_m_s = speed(&rig, circumstances.speeds, random);
    let braking = random.random_range(0.0..1.0) < 0.3;
    let creepage = if braking { random.random_range(0.02..0.15) } else { random.random_range(0.001..0.01) };
    let rolling = Rolling {
        speed_m_s,
        load_n: rig.load_n * random.random_range(0.6..1.4),
        creepage,
        wetness: wetness(condition, random),
        roughness_db: rig.roughness_db + normal(2.0, random),
        roughness_tilt_db: normal(0.35, random),
    };
    let noise_db = match circumstances.noise {
        Noise::Level(level_db) => level_db,
        Noise::Training => {
            TRAINING_NOISE_DB[random.random_range(0..TRAINING_NOISE_DB.len())]
                + random.random_range(-2.0..2.0)
        }
    };
    let surroundings = surroundings(&rig, &rolling, condition, noise_db, random);
    Recipe { rig, scene: Scene { rolling, surroundings }, condition, seed: random.random_range(0..u64::MAX) }
}

fn surroundings(
    rig: &Rig,
    rolling: &Rolling,
    condition: Condition,
    noise_db: f64,
    random: &mut Pcg64Mcg,
) -> Surroundings {
    let level_db = dry_level_db(rig, rolling.speed_m_s);
    let may_squeal = rolling.creepage > 0.01;
    let squeals = match condition {
        Condition::Dry => 0.15,
        Condition::Wet => 0.03,
    };
    let squeal_db =
        (may_squeal && random.random_range(0.0..1.0) < squeals).then(|| random.random_range(-8.0..12.0));
    Surroundings {
        background_db: level_db + noise_db,
        background_slope_db: random.random_range(-6.0..-1.0),
        // Hum and hiss belong to the background: they rise and fall with it.
        hum_db: level_db + noise_db + random.random_range(-20.0..-3.0),
        hum_hz: random.random_range(30.0..120.0),
        hiss_db: level_db + noise_db.min(-12.0) + random.random_range(-15.0..0.0),
        spray_db: normal(4.0, random),
        squeal_db,
        squeal_mode: random.random_range(0..6),
        gain_db: normal(2.0, random),
        response_db: normal(0.4, random),
    }
}

fn speed(rig: &Rig, speeds: Speeds, random: &mut Pcg64Mcg) -> f64 {
    let (low, high) = rig.speed_m_s;
    let held_out = |share: f64| HELD_OUT_SPEEDS.iter().any(|(from, to)| (*from..=*to).contains(&share));
    loop {
        let share = random.random_range(0.0..1.0);
        if held_out(share) == (speeds == Speeds::HeldOut) {
            return low + share * (high - low);
        }
    }
}

/// A dry rail is seldom bone-dry, a wet one seldom under a closed film; between 0.3 and 0.4 lie both.
fn wetness(condition: Condition, random: &mut Pcg64Mcg) -> f64 {
    match condition {
        Condition::Dry => normal(0.12, random).abs().min(0.4),
        Condition::Wet => 1.0 - normal(0.25, random).abs().min(0.7),
    }
}

fn normal(sigma: f64, random: &mut Pcg64Mcg) -> f64 {
    let normal: f64 = StandardNormal.sample(random);
    sigma * normal.clamp(-3.0, 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_out_speeds_and_rigs_never_come_into_training() {
        for recipe in draw(&Circumstances::training(), 600, 3) {
            let (low, high) = recipe.rig.speed_m_s;
            let share = (recipe.scene.rolling.speed_m_s - low) / (high - low);
            assert!(HELD_OUT_SPEEDS.iter().all(|(from, to)| share < *from || share > *to), "{share}");
            assert_ne!(recipe.rig.name, UNHEARD_RIG);
        }
        let held_out = Circumstances { speeds: Speeds::HeldOut, ..Circumstances::training() };
        assert!(draw(&held_out, 100, 3).iter().all(|recipe| {
            let (low, high) = recipe.rig.speed_m_s;
            let share = (recipe.scene.rolling.speed_m_s - low) / (high - low);
            HELD_OUT_SPEEDS.iter().any(|(from, to)| (*from..=*to).contains(&share))
        }));
    }

    #[test]
    fn the_conditions_overlap_in_wetness() {
        let clips = draw(&Circumstances::training(), 2000, 5);
        let wetness = |condition| {
            let own = clips.iter().filter(move |clip| clip.condition == condition);
            own.map(|clip| clip.scene.rolling.wetness)
        };
        let dampest = wetness(Condition::Dry).fold(0.0, f64::max);
        let driest = wetness(Condition::Wet).fold(1.0, f64::min);
        println!("dry up to {dampest:.2}, wet from {driest:.2}");
        assert!(dampest > driest);
    }
}
