//! The train: all wagons, one sample at a time.

use crate::ScenarioError;
use crate::driver::Programme;
use crate::sample::WagonSample;
use crate::scenario::{CouplerTable, Scenario};
use crate::wagon::{Pace, SimulatedWagon};
use railgrip_vehicle::VehicleParameters;
use std::sync::Arc;

/// Integration step that is aimed at; the sample period is divided evenly.
const STEP_S: f64 = 1e-3;

/// One instant of the whole train.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainSample {
    /// Time since the start, never repeating.
    pub t_s: f64,
    /// Every wagon, front first.
    pub wagons: Vec<WagonSample>,
}

/// A simulated train.
#[derive(Clone, Debug)]
pub struct Train {
    wagons: Vec<SimulatedWagon>,
    couplers: Option<CouplerTable>,
    repeat_s: Option<f64>,
    rounds: u64,
    pace: Pace,
    samples: u64,
    rate_hz: f64,
    latest: TrainSample,
    coupler_force_n: Vec<f64>,
}

impl Train {
    /// A train with one vehicle a wagon, front first; the length of `vehicles` is the number of wagons, whatever the scenario
    /// says. `sample_rate_hz` is that of the vehicles unless given.
    ///
    /// # Errors
    /// No wagon, wagons of different sample rate where none is given, a rate out of 1 to 10,000 Hz, an unknown effect.
    pub fn new(
        scenario: &Scenario,
        vehicles: &[VehicleParameters],
        seed: u64,
        sample_rate_hz: Option<f64>,
    ) -> Result<Self, ScenarioError> {
        let refuse = |text: String| Err(ScenarioError::Train(text));
        let Some(first) = vehicles.first() else {
            return refuse("a train needs at least one wagon".to_owned());
        };
        let rate_hz = sample_rate_hz.unwrap_or(first.sensors.sample_rate_hz);
        if !(1.0..=1e4).contains(&rate_hz) {
            return refuse(format!("sample rate {rate_hz} Hz; allowed is 1 to 10000 Hz"));
        }
        let other =
            vehicles.iter().find(|vehicle| vehicle.sensors.sample_rate_hz != first.sensors.sample_rate_hz);
        if let (None, Some(other)) = (sample_rate_hz, other) {
            let (one, two) = (first.sensors.sample_rate_hz, other.sensors.sample_rate_hz);
            return refuse(format!(
                "wagons sampled at {one} Hz and at {two} Hz; one rate for the train is needed"
            ));
        }
        let period_s = 1.0 / rate_hz;
        let steps = (period_s / STEP_S).round().max(1.0);
        let pace = Pace { period_s, steps: steps as usize, step_s: period_s / steps };
        let programme = Arc::new(Programme::new(scenario));
        let wagons = vehicles
            .iter()
            .enumerate()
            .map(|(index, vehicle)| SimulatedWagon::new(scenario, &programme, vehicle, pace, seed, index))
            .collect::<Result<Vec<_>, _>>()?;
        let latest = TrainSample { t_s: 0.0, wagons: Vec::with_capacity(wagons.len()) };
        let coupler_force_n = vec![0.0; wagons.len()];
        let (couplers, repeat_s) = (scenario.couplers.clone(), scenario.repeat_s);
        Ok(Self { wagons, couplers, repeat_s, rounds: 0, pace, samples: 0, rate_hz, latest, coupler_force_n })
    }

    /// Number of wagons.
    pub fn wagons(&self) -> usize {
        self.wagons.len()
    }

    /// Wheelsets of a wagon (from 0).
    pub fn wheelsets(&self, wagon: usize) -> usize {
        self.wagons[wagon].wheelsets()
    }

    /// Time from one sample to the next, s.
    pub fn sample_period_s(&self) -> f64 {
        self.pace.period_s
    }

    /// The next sample of all wagons; the first is that of time 0. The train then runs on to the one after.
    pub fn step(&mut self) -> &TrainSample {
        let t_s = self.samples as f64 / self.rate_hz;
        self.begin_round(t_s);
        self.latest.t_s = t_s;
        self.latest.wagons.clear();
        self.latest.wagons.extend(self.wagons.iter_mut().map(|wagon| wagon.sample(t_s)));
        match self.couplers.clone() {
            Some(couplers) => self.advance_coupled(&couplers, t_s),
            None => self.wagons.iter_mut().for_each(|wagon| wagon.advance(t_s)),
        }
        self.samples += 1;
        &self.latest
    }

    fn begin_round(&mut self, t_s: f64) {
        let rounds = self.repeat_s.map_or(0, |repeat_s| (t_s / repeat_s) as u64);
        if rounds > self.rounds {
            self.rounds = rounds;
            self.wagons.iter_mut().for_each(SimulatedWagon::return_to_start);
        }
    }

    /// All wagons step by step; forces follow from the state at the start of each step, whatever the order of wagons.
    fn advance_coupled(&mut self, couplers: &CouplerTable, t_s: f64) {
        for step in 0..self.pace.steps {
            self.coupler_force_n.fill(0.0);
            for behind in 1..self.wagons.len() {
                let (front_m, front_m_s) = self.wagons[behind - 1].motion();
                let (rear_m, rear_m_s) = self.wagons[behind].motion();
                let pull_n = couplers.stiffness_n_per_m * (front_m - rear_m)
                    + couplers.damping_n_s_per_m * (front_m_s - rear_m_s);
                self.coupler_force_n[behind - 1] -= pull_n;
                self.coupler_force_n[behind] += pull_n;
            }
            for (wagon, force_n) in self.wagons.iter_mut().zip(&self.coupler_force_n) {
                wagon.step(t_s + step as f64 * self.pace.step_s, *force_n);
            }
        }
    }
}
