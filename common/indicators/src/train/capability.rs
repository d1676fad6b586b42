//! Braking capability: how far the train runs now from given speeds, against nominal, and which wagons lack force.

use super::stopping::{BrakedWagon, distance_m};
use railgrip_messages::GRAVITY_M_S2;

/// Worth a look from here on: the lower end of the interval over the nominal distance.
pub const WATCH_RATIO: f64 = 1.2;
/// Needs action from here on.
pub const ACT_RATIO: f64 = 1.6;
/// A wagon is weak below this share of its nominal brake force.
const WEAK_SHARE: f64 = 0.95;
/// Weak wagons that are named.
const MOST_WEAK: usize = 5;

/// What full braking of a train is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FullBraking {
    /// Deceleration with nominal pads on good rail, m/s².
    pub deceleration_m_s2: f64,
    /// From the driver's action until the brakes act in full, as a dead time, s.
    pub response_s: f64,
}

/// Stopping distance from one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// From this speed, km/h.
    pub speed_km_h: f64,
    /// Distance now, with the ends of its 95 % interval, m.
    pub distance_m: [f64; 3],
    /// Distance with nominal pads on good rail, m.
    pub nominal_m: f64,
}

impl Stop {
    /// Now over nominal, with the ends of the interval.
    #[must_use]
    pub fn ratio(&self) -> [f64; 3] {
        self.distance_m.map(|distance_m| distance_m / self.nominal_m.max(1e-9))
    }
}

/// What keeps a wagon from braking as it should.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lack {
    /// Its pads rub less than nominal.
    Pads,
    /// Some of its wheelsets have no brake.
    Isolated,
    /// The rail takes no more.
    Rail,
}

/// A wagon that lacks brake force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeakWagon {
    /// The wagon.
    pub wagon: u32,
    /// Its brake force at full braking over the nominal one.
    pub brake_share: f64,
    /// Why.
    pub lack: Lack,
}

/// Braking capability now.
#[derive(Debug, Clone, PartialEq)]
pub struct Capability {
    /// Wagons whose brakes are known now.
    pub known_wagons: usize,
    /// One line a speed.
    pub stops: Vec<Stop>,
    /// Wagons that lack brake force, worst first; at most five.
    pub weak: Vec<WeakWagon>,
}

impl Capability {
    /// Of wagons as they brake now, each with how it would brake nominally, wagon 1 first; `known_wagons` of them have
    /// told enough.
    #[must_use]
    pub fn of(
        braked: &[(BrakedWagon, BrakedWagon)],
        known_wagons: usize,
        full: &FullBraking,
        speeds_km_h: &[f64],
    ) -> Self {
        let (now, nominal): (Vec<BrakedWagon>, Vec<BrakedWagon>) = braked.iter().copied().unzip();
        let (full_m_s2, response_s) = (full.deceleration_m_s2, full.response_s);
        let stop = |speed_km_h: &f64| {
            let v_m_s = speed_km_h / 3.6;
            let [nominal_m, ..] = distance_m(&nominal, v_m_s, full_m_s2, response_s);
            let distance_m = distance_m(&now, v_m_s, full_m_s2, response_s);
            Stop { speed_km_h: *speed_km_h, distance_m, nominal_m }
        };
        let numbered = braked.iter().zip(1..);
        let mut weak: Vec<WeakWagon> =
            numbered.filter_map(|((now, _), wagon)| weak(wagon, now, full_m_s2)).collect();
        weak.sort_by(|a, b| a.brake_share.total_cmp(&b.brake_share));
        weak.truncate(MOST_WEAK);
        Self { known_wagons, stops: speeds_km_h.iter().map(stop).collect(), weak }
    }

    /// The largest ratio of now to nominal over the speeds, with that of the lower and of the upper ends.
    #[must_use]
    pub fn ratio(&self) -> Option<[f64; 3]> {
        let ratios = self.stops.iter().map(Stop::ratio);
        ratios.reduce(|largest, ratio| std::array::from_fn(|end| f64::max(largest[end], ratio[end])))
    }
}

/// What a wagon lacks of its nominal brake force, if it is worth a word.
fn weak(wagon: u32, now: &BrakedWagon, full_m_s2: f64) -> Option<WeakWagon> {
    let pads = now.friction_ratio[0];
    let rail = now.adhesion[0] * GRAVITY_M_S2 / full_m_s2;
    let brake_share = now.braked_share * pads.min(rail);
    let lack = match now.braked_share {
        braked if braked < pads.min(rail) => Lack::Isolated,
        _ if rail < pads => Lack::Rail,
        _ => Lack::Pads,
    };
    (brake_share < WEAK_SHARE).then_some(WeakWagon { wagon, brake_share, lack })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weakest_wagon_is_named_with_what_it_lacks() {
        let nominal = BrakedWagon {
            mass_kg: 40e3,
            rotating_mass_kg: 2e3,
            friction_ratio: [1.0; 3],
            adhesion: [0.3; 3],
            braked_share: 1.0,
            resistance: [0.0; 3],
        };
        let train = [
            (nominal, nominal),
            (BrakedWagon { friction_ratio: [0.8; 3], ..nominal }, nominal),
            (BrakedWagon { braked_share: 0.5, ..nominal }, nominal),
            (BrakedWagon { adhesion: [0.05; 3], ..nominal }, nominal),
        ];
        let full = FullBraking { deceleration_m_s2: 1.0, response_s: 1.0 };
        let found = Capability::of(&train, 4, &full, &[60.0, 120.0]);
        let weak: Vec<(u32, Lack)> = found.weak.iter().map(|weak| (weak.wagon, weak.lack)).collect();
        assert_eq!(weak, [(4, Lack::Rail), (3, Lack::Isolated), (2, Lack::Pads)]);
        let [value, low, high] = found.ratio().unwrap_or_default();
        println!("{value:.2} times nominal ({low:.2} to {high:.2})");
        // The faster train loses less of its way to the dead time.
        assert_eq!(value, found.stops[1].ratio()[0]);
        assert!(low <= value && value <= high && (1.2..1.6).contains(&value));
    }
}
