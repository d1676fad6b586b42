//! The simulated train as a source.

use super::{Arrival, Feed, InputError, Next, Rolls, When};
use railgrip_simulation::{Scenario, Train, WagonTruth};
use railgrip_vehicle::{RailClass, VehicleParameters};

/// A simulated train that runs in step with the clock.
pub struct Simulated {
    train: Train,
    next_s: f64,
    speed: f64,
    name: String,
    radius_m: Vec<f64>,
    rolls: Vec<Rolls>,
}

impl Simulated {
    /// Builds the train of a scenario, one wagon a vehicle.
    ///
    /// # Errors
    /// If scenario and vehicles do not fit.
    pub fn new(
        scenario: &Scenario,
        vehicles: &[VehicleParameters],
        seed: u64,
        sample_rate_hz: Option<f64>,
        speed: f64,
    ) -> Result<Self, InputError> {
        let train = Train::new(scenario, vehicles, seed, sample_rate_hz)?;
        let radius_m = vehicles.iter().map(|vehicle| vehicle.wheelset.radius_m).collect();
        Ok(Self { train, next_s: 0.0, speed, name: scenario.name.clone(), radius_m, rolls: Vec::new() })
    }
}

/// Dry rails are seldom bone-dry; contaminated ones are mostly wet.
fn rolls(truth: &WagonTruth, radius_m: f64) -> Rolls {
    let speed_m_s = truth.row.v_m_s.abs();
    let rim_m_s = truth.wheel_speed_rad_s[0] * radius_m;
    Rolls {
        speed_m_s,
        creepage: ((rim_m_s - truth.row.v_m_s).abs() / speed_m_s.max(0.5)).clamp(0.001, 1.0),
        wetness: match truth.rail {
            RailClass::Dry | RailClass::Undeclared => 0.05,
            RailClass::Wet | RailClass::Low => 0.9,
        },
    }
}

impl Feed for Simulated {
    fn rolls(&self, wagon: usize) -> Option<Rolls> {
        self.rolls.get(wagon).copied()
    }

    fn take_due(&mut self, until_s: f64, sink: &mut dyn FnMut(Arrival<'_>)) -> Next {
        while self.next_s <= until_s {
            let sample = self.train.step();
            let due_s = sample.t_s;
            for (wagon, sample) in sample.wagons.iter().enumerate().filter(|(_, sample)| sample.present) {
                let (row, wheelsets) = (&sample.row, sample.wheelsets);
                sink(Arrival::Row { wagon, row, wheelsets, when: When::Due(due_s), begins: false });
            }
            self.rolls.clear();
            let wagons = sample.wagons.iter().zip(&self.radius_m);
            self.rolls.extend(wagons.map(|(sample, radius_m)| rolls(&sample.truth, *radius_m)));
            self.next_s = due_s + self.train.sample_period_s();
        }
        Next::More
    }

    fn speed(&self) -> f64 {
        self.speed
    }

    fn describe(&self) -> String {
        format!("simulated train, scenario {}", self.name)
    }
}
