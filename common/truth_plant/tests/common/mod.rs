//! What several tests of the plant share.
// Not every test file uses every helper, and a helper that fails should fail the test.
#![allow(dead_code, clippy::unwrap_used)]

use railgrip_truth_plant::{
    departure::Departures,
    departures::Kind,
    plant::{Plant, Run, SAMPLE_S, Truth},
    programme::{self, Order},
    random::Stream,
    sheet::Sheet,
    wagon::{Nuisances, TrueWagon},
};

/// One vehicle on its programme, with a departure and without.
pub struct Pair {
    pub sheet: Sheet,
    pub wagon: TrueWagon,
    pub parameters: Vec<(&'static str, f64)>,
    orders: Vec<Order>,
    kind: Kind,
    strength: f64,
    seed: u64,
}

impl Pair {
    pub fn new(id: &str, strength: f64) -> Self {
        let seed = 77;
        let kind = Kind::of(id).unwrap();
        let sheet = Sheet::draw(&mut Stream::new(seed, "sheet", 0), kind.needs_motor, kind.needs_sander);
        let wagon = TrueWagon::new(&sheet, &Nuisances::default());
        let orders = programme::orders(&sheet, seed);
        let (_, parameters) = kind.draw(strength, &mut Stream::new(seed, id, 0), &sheet);
        Self { sheet, wagon, parameters, orders, kind, strength, seed }
    }

    pub fn parameter(&self, name: &str) -> f64 {
        self.parameters.iter().find(|(key, _)| *key == name).unwrap().1
    }

    pub fn order(&self, name: &str) -> (usize, Order) {
        let index = self.orders.iter().position(|order| order.name == name).unwrap();
        (index, self.orders[index].clone())
    }

    /// The run with the departure.
    pub fn with(&self, name: &str) -> Run {
        let departure =
            self.kind.draw(self.strength, &mut Stream::new(self.seed, self.kind.id, 0), &self.sheet).0;
        self.drive(name, Departures(vec![departure]))
    }

    /// The same run without it.
    pub fn without(&self, name: &str) -> Run {
        self.drive(name, Departures::default())
    }

    fn drive(&self, name: &str, departures: Departures) -> Run {
        let (index, order) = self.order(name);
        Plant::new(&self.sheet, &self.wagon, departures, self.seed).drive(&order, index as u64)
    }

    /// Slip velocity (m/s, positive in sliding) of a wheelset.
    pub fn slide_m_s(&self, truth: &Truth, wheelset: usize) -> f64 {
        truth.v_m_s - self.wagon.radius_m[wheelset] * truth.wheel_speed_rad_s[wheelset]
    }
}

/// Mean of what the filter yields.
pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    assert!(count > 0.0, "nothing to average");
    sum / count
}

/// Mean effective pad friction of both wheelsets over the samples that pass.
pub fn pad_friction(run: &Run, pass: impl Fn(usize, &Truth) -> bool) -> f64 {
    let passing = run.truth.iter().enumerate().filter(|(sample, truth)| pass(*sample, truth));
    mean(passing.flat_map(|(_, truth)| truth.mu_b.into_iter().flatten()))
}

/// Retardation over the first seconds, before any brake, m/s².
pub fn coasting_retardation(run: &Run) -> f64 {
    let samples = 250;
    (run.truth[0].v_m_s - run.truth[samples].v_m_s) / (samples as f64 * SAMPLE_S)
}

/// Sample at which the brake is first ordered.
pub fn onset(run: &Run) -> usize {
    (run.order.demand[0].0 / SAMPLE_S).ceil() as usize
}
