//! The simulated train as a source.

use super::{Arrival, Feed, InputError, Next};
use railgrip_simulation::{Scenario, Train};
use railgrip_vehicle::VehicleParameters;

/// A simulated train that runs in step with the clock.
pub struct Simulated {
    train: Train,
    next_s: f64,
    speed: f64,
    name: String,
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
        Ok(Self { train, next_s: 0.0, speed, name: scenario.name.clone() })
    }
}

impl Feed for Simulated {
    fn take_due(&mut self, until_s: f64, sink: &mut dyn FnMut(Arrival<'_>)) -> Next {
        while self.next_s <= until_s {
            let sample = self.train.step();
            let due_s = sample.t_s;
            for (wagon, sample) in sample.wagons.iter().enumerate().filter(|(_, sample)| sample.present) {
                let (row, wheelsets) = (&sample.row, sample.wheelsets);
                sink(Arrival::Row { wagon, row, wheelsets, due_s, begins: false });
            }
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
