//! How a brake order travels: by wire, or as a wave along the brake pipe.

use super::{family::BrakeLine, spec::TrainSpec, wagon::Wagon};

/// Speed of the pressure wave, m/s.
const WAVE_M_S: f64 = 250.0;
/// Time constant of the pipe at the head, s, and its growth along the train, s/m.
const HEAD_LAG_S: f64 = 0.15;
const LAG_S_PER_M: f64 = 0.0012;
/// A release travels as fast but fills so many times more slowly.
const RELEASE: f64 = 1.8;
/// Longest delay that is kept, s.
const LONGEST_S: f64 = 16.0;

/// The order as it passes each wagon.
#[derive(Debug, Clone)]
pub(crate) struct Pipe {
    orders: Vec<f64>,
    next: usize,
    tick_s: f64,
    stations: Vec<Station>,
}

#[derive(Debug, Clone, Copy)]
struct Station {
    delay_s: f64,
    lag_s: f64,
    release: f64,
    shut: bool,
    pressure: f64,
}

impl Pipe {
    pub(crate) fn new(spec: &TrainSpec, tick_s: f64) -> Self {
        let by_pipe = spec.brake_line == BrakeLine::Pipe;
        let mut behind_m = 0.0;
        let mut station = |wagon: &Wagon| {
            let at_m = behind_m + 0.5 * wagon.real.length_m;
            behind_m += wagon.real.length_m;
            let (wave_s, lag_s, release) = if by_pipe {
                (at_m / WAVE_M_S, HEAD_LAG_S + LAG_S_PER_M * at_m, RELEASE)
            } else {
                (0.0, 0.05, 1.0)
            };
            Station { delay_s: wave_s + wagon.real.distributor_s, lag_s, release, shut: false, pressure: 0.0 }
        };
        let stations = spec.wagons.iter().map(&mut station).collect();
        Self { orders: vec![0.0; (LONGEST_S / tick_s) as usize], next: 0, tick_s, stations }
    }

    /// Keeps the order of this tick.
    pub(crate) fn advance(&mut self, order: f64) {
        self.orders[self.next] = order;
        self.next = (self.next + 1) % self.orders.len();
    }

    /// What the distributor of a wagon hears now, when it is late by `extra_s` itself. Once a tick and wagon.
    pub(crate) fn heard(&mut self, wagon: usize, extra_s: f64) -> f64 {
        let station = &mut self.stations[wagon];
        let count = self.orders.len();
        let back = (((station.delay_s + extra_s) / self.tick_s).round() as usize).min(count - 1) + 1;
        let order = if station.shut { 0.0 } else { self.orders[(self.next + count - back) % count] };
        let lag_s = if order < station.pressure { station.lag_s * station.release } else { station.lag_s };
        station.pressure += self.tick_s / (self.tick_s + lag_s) * (order - station.pressure);
        station.pressure
    }

    /// Shuts the cock ahead of a wagon: nothing is heard from there on.
    pub(crate) fn shut(&mut self, wagon: usize) {
        self.stations[wagon..].iter_mut().for_each(|station| station.shut = true);
    }
}
