//! Stopping distance of the train from a speed, with its interval, from friction and adhesion now.
//!
//! Each wagon brakes with the lesser of what its pads give at full pressure and what its rail takes. The train is rigid:
//! forces and masses add. Pads must slow the rotating masses too: where wheels roll, `Σ J / r²` adds to the mass, as in the
//! balance of the dragging indicator; where the rail is the limit, wheels slide, and its force slows the mass alone. From
//! `m_eff v dv/ds = −(F_b + R(v))` with constant brake force F_b follows `s = v t_r + ∫₀^v m_eff u du / (F_b + R(u))`, t_r
//! the dead time of the brake. The interval comes from a fixed set of draws: pads err independently from wagon to wagon, the
//! rail is the same for all of them.

use railgrip_messages::GRAVITY_M_S2;

/// Draws behind an interval.
const DRAWS: usize = 401;
/// Steps of the integral over speed.
const STEPS: usize = 40;

/// A wagon as it is now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrakedWagon {
    /// Mass, kg.
    pub mass_kg: f64,
    /// What the inertia of its wheelsets adds when they roll, kg: Σ J / r².
    pub rotating_mass_kg: f64,
    /// Pad friction over its nominal value: value, low, high.
    pub friction_ratio: [f64; 3],
    /// Adhesion available: value, low, high.
    pub adhesion: [f64; 3],
    /// Share of its wheelsets that brake.
    pub braked_share: f64,
    /// Running resistance: N, N s/m, N s²/m².
    pub resistance: [f64; 3],
}

/// Brake force of a train, N, with the mass that it slows, kg.
#[derive(Debug, Clone, Copy, Default)]
struct Braking {
    force_n: f64,
    mass_kg: f64,
}

impl Braking {
    /// Adds a wagon whose pads rub with `friction_ratio` of nominal, on a rail with this adhesion. Full braking is what
    /// nominal pads make of mass and rotating mass together.
    fn add(mut self, wagon: &BrakedWagon, friction_ratio: f64, adhesion: f64, full_m_s2: f64) -> Self {
        let wanted_m_s2 = full_m_s2 * friction_ratio.max(0.0);
        let taken_m_s2 = GRAVITY_M_S2 * adhesion.max(0.0);
        let rolling_kg = wagon.mass_kg + wagon.rotating_mass_kg;
        let (braked, free) = (wagon.braked_share, 1.0 - wagon.braked_share);
        if wanted_m_s2 <= taken_m_s2 {
            self.force_n += braked * rolling_kg * wanted_m_s2;
            self.mass_kg += rolling_kg;
        } else {
            self.force_n += braked * wagon.mass_kg * taken_m_s2;
            self.mass_kg += wagon.mass_kg + free * wagon.rotating_mass_kg;
        }
        self
    }
}

/// Stopping distance: value and 95 % interval, m. Full braking is the deceleration with nominal pads on good rail.
#[must_use]
pub fn distance_m(wagons: &[BrakedWagon], v_m_s: f64, full_m_s2: f64, response_s: f64) -> [f64; 3] {
    if wagons.iter().map(|wagon| wagon.mass_kg).sum::<f64>() <= 0.0 {
        return [f64::NAN; 3];
    }
    let mut resistance = [0.0; 3];
    for wagon in wagons {
        resistance.iter_mut().zip(wagon.resistance).for_each(|(sum, part)| *sum += part);
    }
    let stop = |braking: Braking| {
        let step = v_m_s / STEPS as f64;
        let way = |index: usize| {
            let u = step * (index as f64 + 0.5);
            let against_n = braking.force_n + resistance[0] + resistance[1] * u + resistance[2] * u * u;
            braking.mass_kg * u * step / against_n.max(1.0)
        };
        v_m_s * response_s + (0..STEPS).map(way).sum::<f64>()
    };
    let braking = |pads: &mut dyn FnMut(&BrakedWagon) -> f64, rail: &dyn Fn(&BrakedWagon) -> f64| {
        let add = |sum: Braking, wagon: &BrakedWagon| sum.add(wagon, pads(wagon), rail(wagon), full_m_s2);
        wagons.iter().fold(Braking::default(), add)
    };
    let value = stop(braking(&mut |wagon| wagon.friction_ratio[0], &|wagon| wagon.adhesion[0]));
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let mut draws: Vec<f64> = (0..DRAWS)
        .map(|draw| {
            let rail_z = normal_quantile((draw as f64 + 0.5) / DRAWS as f64);
            let mut pads = |wagon: &BrakedWagon| spread(wagon.friction_ratio, random.normal());
            stop(braking(&mut pads, &|wagon| spread(wagon.adhesion, rail_z)))
        })
        .collect();
    draws.sort_by(f64::total_cmp);
    let at = |share: f64| draws[((DRAWS - 1) as f64 * share).round() as usize];
    [value, at(0.025).min(value), at(0.975).max(value)]
}

/// A value whose 95 % interval is given, `z` sigmas away from its middle; each side has a sigma of its own.
fn spread([value, low, high]: [f64; 3], z: f64) -> f64 {
    value + z * if z < 0.0 { value - low } else { high - value } / 1.96
}

/// Quantile of the normal distribution (Abramowitz & Stegun 26.2.23, error below 4.5e-4).
fn normal_quantile(share: f64) -> f64 {
    let tail = share.min(1.0 - share);
    let t = (-2.0 * tail.ln()).sqrt();
    let top = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let bottom = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    let z = t - top / bottom;
    if share < 0.5 { -z } else { z }
}

/// A fixed sequence (xorshift): the same train gives the same interval.
struct Random(u64);

impl Random {
    fn normal(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        normal_quantile(((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn train(friction: [f64; 3], adhesion: [f64; 3]) -> Vec<BrakedWagon> {
        vec![
            BrakedWagon {
                mass_kg: 40e3,
                rotating_mass_kg: 2e3,
                friction_ratio: friction,
                adhesion,
                braked_share: 1.0,
                resistance: [0.0; 3]
            };
            8
        ]
    }

    #[test]
    fn a_constant_deceleration_gives_the_school_formula() {
        let v = 120.0 / 3.6;
        let [value, low, high] = distance_m(&train([1.0; 3], [0.3; 3]), v, 1.1, 2.0);
        let expected = 2.0 * v + v * v / 2.2;
        println!("{value:.1} m ({low:.1} to {high:.1}), formula {expected:.1} m");
        assert!((value - expected).abs() < 0.1 && (high - low).abs() < 0.1);
        let [low_rail, ..] = distance_m(&train([1.0; 3], [0.05; 3]), v, 1.1, 2.0);
        assert!((low_rail - (2.0 * v + v * v / (2.0 * 0.05 * GRAVITY_M_S2))).abs() < 0.5, "the rail limits");
        let mut one_isolated = train([1.0; 3], [0.3; 3]);
        one_isolated[3].braked_share = 0.0;
        let [longer, ..] = distance_m(&one_isolated, v, 1.1, 0.0);
        assert!((longer * 7.0 / 8.0 - v * v / 2.2).abs() < 0.1);
    }

    #[test]
    fn rotating_mass_counts_where_wheels_roll() {
        let v = 30.0;
        let coasting = |rotating_mass_kg: f64, adhesion: f64, friction: f64| {
            let mut wagons = train([friction; 3], [adhesion; 3]);
            for wagon in &mut wagons {
                (wagon.rotating_mass_kg, wagon.resistance) = (rotating_mass_kg, [1000.0, 0.0, 0.0]);
            }
            distance_m(&wagons, v, 1.0, 0.0)[0]
        };
        // No brake at all: the school formula with m + Σ J / r².
        for rotating_mass_kg in [0.0, 2e3] {
            let expected = v * v * (40e3 + rotating_mass_kg) / (2.0 * 1000.0);
            assert!((coasting(rotating_mass_kg, 0.3, 0.0) / expected - 1.0).abs() < 1e-9);
        }
        // Sliding wheels: the rail's force slows the mass alone.
        assert_eq!(coasting(2e3, 0.05, 1.0), coasting(0.0, 0.05, 1.0));
    }

    #[test]
    fn pads_average_out_over_the_train_and_the_rail_does_not() {
        let v = 30.0;
        let width = |wagons: &[BrakedWagon]| {
            let [value, low, high] = distance_m(wagons, v, 1.0, 0.0);
            (high - low) / value
        };
        let pads = width(&train([1.0, 0.9, 1.1], [0.3; 3]));
        let rail = width(&train([1.0; 3], [0.06, 0.054, 0.066]));
        println!("relative width: pads ±10 % each {pads:.3}, rail ±10 % {rail:.3}");
        assert!((pads - 0.2 / 8f64.sqrt()).abs() < 0.02 && (rail - 0.2).abs() < 0.02);
    }
}
