//! The track under a wagon: grade, rail condition and adhesion by position.

use crate::random::{Purpose, mix};
use crate::scenario::Scenario;
use railgrip_vehicle::{Rail, RailClass};

/// A value by position: constant from each place on, with a ramp into it.
#[derive(Clone, Debug)]
struct Profile {
    from_m: Vec<f64>,
    value: Vec<f64>,
    transition_m: f64,
}

impl Profile {
    fn at(&self, position_m: f64) -> f64 {
        let after = self.from_m.partition_point(|from| *from <= position_m);
        match after {
            0 | 1 => self.value[0],
            _ => {
                let (before, here) = (self.value[after - 2], self.value[after - 1]);
                let into_m = position_m - self.from_m[after - 1];
                if into_m < self.transition_m {
                    before + (here - before) * into_m / self.transition_m
                } else {
                    here
                }
            }
        }
    }
}

/// The nodes of the unevenness around one place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nodes {
    index: f64,
    left: f64,
    right: f64,
}

impl Default for Nodes {
    fn default() -> Self {
        Self { index: f64::NAN, left: 0.0, right: 0.0 }
    }
}

/// The track as one wagon's wheels meet it.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    adhesion: Profile,
    classes: Vec<(f64, RailClass)>,
    grade: Profile,
    variation: f64,
    variation_length_m: f64,
    seed: u64,
}

impl Track {
    /// The track of a scenario for a vehicle with these adhesion levels, times `factor`.
    pub fn new(scenario: &Scenario, levels: &Rail, factor: f64, seed: u64) -> Self {
        let mut classes: Vec<(f64, RailClass)> =
            scenario.rail.iter().map(|rail| (rail.from_m, rail.condition)).collect();
        let level =
            |(class, own): (RailClass, Option<f64>)| factor * own.unwrap_or_else(|| levels.adhesion(class));
        let mut adhesion: Vec<f64> =
            scenario.rail.iter().map(|rail| level((rail.condition, rail.adhesion))).collect();
        if classes.is_empty() {
            classes.push((0.0, RailClass::Dry));
            adhesion.push(level((RailClass::Dry, None)));
        }
        let transition_m = scenario.track.transition_m;
        let mut grade = Profile {
            from_m: scenario.grade.iter().map(|grade| grade.from_m).collect(),
            value: scenario.grade.iter().map(|grade| grade.grade_rad).collect(),
            transition_m,
        };
        if grade.value.is_empty() {
            grade.from_m.push(0.0);
            grade.value.push(0.0);
        }
        let from_m = classes.iter().map(|(from_m, _)| *from_m).collect();
        // The unevenness belongs to the track: one key for all wagons.
        let key = mix(seed ^ mix(Purpose::Track as u64));
        Self {
            adhesion: Profile { from_m, value: adhesion, transition_m },
            classes,
            grade,
            variation: scenario.track.adhesion_variation,
            variation_length_m: scenario.track.variation_length_m,
            seed: key,
        }
    }

    /// Adhesion available at a position; `near` remembers the place between calls.
    pub fn adhesion(&self, position_m: f64, near: &mut Nodes) -> f64 {
        let level = self.adhesion.at(position_m);
        if self.variation == 0.0 {
            return level;
        }
        level * (1.0 + self.variation * self.unevenness(position_m, near)).clamp(0.3, 1.7)
    }

    /// Rail class at a position.
    pub fn class(&self, position_m: f64) -> RailClass {
        let after = self.classes.partition_point(|(from_m, _)| *from_m <= position_m);
        self.classes[after.saturating_sub(1)].1
    }

    /// Grade at a position, rad, uphill positive.
    pub fn grade_rad(&self, position_m: f64) -> f64 {
        self.grade.at(position_m)
    }

    /// A smooth random function of position with unit variance everywhere.
    fn unevenness(&self, position_m: f64, near: &mut Nodes) -> f64 {
        let place = position_m / self.variation_length_m;
        let index = place.floor();
        if near.index != index {
            *near = Nodes { index, left: self.node(index), right: self.node(index + 1.0) };
        }
        let share = place - index;
        let weight = share * share * (3.0 - 2.0 * share);
        let other = 1.0 - weight;
        (other * near.left + weight * near.right) / (weight * weight + other * other).sqrt()
    }

    /// Nearly normal number with unit variance that belongs to a node: the sum of four uniform ones.
    fn node(&self, index: f64) -> f64 {
        let bits = mix(self.seed ^ (index as i64) as u64);
        let sum: u64 = (0..4).map(|part| bits >> (16 * part) & 0xFFFF).sum();
        (sum as f64 / 65_535.0 - 2.0) * 3f64.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile() -> Profile {
        Profile { from_m: vec![0.0, 100.0, 200.0], value: vec![1.0, 3.0, 2.0], transition_m: 10.0 }
    }

    #[test]
    fn ramps_lie_behind_the_boundary() {
        let profile = profile();
        let values = [-50.0, 0.0, 99.9, 105.0, 110.0, 150.0, 210.0, 1e4].map(|x| profile.at(x));
        assert_eq!(values, [1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 2.0, 2.0]);
    }

    #[test]
    fn unevenness_has_unit_variance_and_no_mean() {
        let flat = Profile { from_m: vec![0.0], value: vec![0.0], transition_m: 1.0 };
        let track = Track {
            adhesion: flat.clone(),
            classes: vec![(0.0, RailClass::Dry)],
            grade: flat,
            variation: 0.05,
            variation_length_m: 15.0,
            seed: 3,
        };
        let mut near = Nodes::default();
        let values: Vec<f64> =
            (0..200_000).map(|index| track.unevenness(0.7 * f64::from(index), &mut near)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
        println!("mean {mean:.3}, variance {variance:.3}");
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.05);
    }
}
