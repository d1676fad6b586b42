//! The plant: drives one ordered run with a real wagon, its departures, clutter and sensors, and records it at 100 Hz.

use crate::{
    departure::{Departures, Moment, Sensed},
    dynamics::{self, Action, Motion},
    programme::{END_SPEED_M_S, LONGEST_S, Order},
    protection::Protection,
    random::{Stream, Wander},
    sheet::Sheet,
    wagon::TrueWagon,
};

/// Sample interval of the recordings, s.
pub const SAMPLE_S: f64 = 0.01;
/// Integration steps in a sample.
pub const STEPS_PER_SAMPLE: usize = 20;
/// Integration step, s.
pub const STEP_S: f64 = SAMPLE_S / STEPS_PER_SAMPLE as f64;

/// One recorded sample, as the file holds it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Row {
    /// Time, s.
    pub time_s: f64,
    /// Measured speed, m/s.
    pub v_m_s: f64,
    /// Measured wheel speeds, rad/s.
    pub wheel_speed_rad_s: [f64; 2],
    /// Measured pressing forces, N.
    pub pressing_force_n: [f64; 2],
    /// Known traction torques, N m.
    pub drive_torque_nm: [f64; 2],
    /// Mapped slope, rad.
    pub grade_rad: f64,
    /// Whether the sanders run.
    pub sanding: bool,
    /// Position by satellite, m.
    pub position_m: f64,
}

/// What no sensor sees at the same instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// True speed, m/s.
    pub v_m_s: f64,
    /// Utilised adhesion of the wagon, signed like the force.
    pub mu_w: f64,
    /// Utilised adhesion of each wheelset.
    pub mu_w_wheelset: [f64; 2],
    /// Effective pad friction; `None` below 2 kN.
    pub mu_b: [Option<f64>; 2],
    /// True wheel speeds, rad/s.
    pub wheel_speed_rad_s: [f64; 2],
    /// Contact forces, N.
    pub contact_n: [f64; 2],
}

/// A finished run.
#[derive(Debug, Clone)]
pub struct Run {
    /// What was ordered.
    pub order: Order,
    /// The recording.
    pub rows: Vec<Row>,
    /// The truth beside it, sample by sample.
    pub truth: Vec<Truth>,
}

/// Slow or random things that every run has and no model knows.
struct Clutter {
    pad: [Wander; 2],
    gust: Wander,
    noise: Stream,
    bias_m: f64,
    bias_period_s: f64,
}

impl Clutter {
    fn new(seed: u64, index: u64) -> Self {
        let mut stream = Stream::new(seed, "clutter", index);
        let correlation_s = stream.uniform(4.0, 14.0);
        let wander = |purpose| Wander::new(Stream::new(seed, purpose, index), 0.006, correlation_s, SAMPLE_S);
        let gust_s = stream.uniform(2.0, 8.0);
        Self {
            pad: [wander("pad leading"), wander("pad rear")],
            gust: Wander::new(Stream::new(seed, "gust", index), 0.5, gust_s, SAMPLE_S),
            noise: Stream::new(seed, "noise", index),
            bias_m: stream.sign() * stream.uniform(1.0, 2.0),
            bias_period_s: stream.uniform(60.0, 140.0),
        }
    }
}

/// A wagon with everything about it that is true.
pub struct Plant {
    sheet: Sheet,
    wagon: TrueWagon,
    departures: Departures,
    seed: u64,
}

impl Plant {
    /// A plant; `seed` rules clutter and protection, not the wagon.
    #[must_use]
    pub fn new(sheet: &Sheet, wagon: &TrueWagon, departures: Departures, seed: u64) -> Self {
        let mut wagon = wagon.clone();
        for departure in &departures.0 {
            departure.adapt(&mut wagon);
        }
        Self { sheet: sheet.clone(), wagon, departures, seed }
    }

    /// The wagon with its departures applied.
    #[must_use]
    pub fn wagon(&self) -> &TrueWagon {
        &self.wagon
    }

    /// Drives one run, number `index` of its case.
    #[must_use]
    pub fn drive(&mut self, order: &Order, index: u64) -> Run {
        let mut clutter = Clutter::new(self.seed, index);
        let mut protection = Protection::new(&mut Stream::new(self.seed, "protection", 0), self.sheet.sander);
        for departure in &mut self.departures.0 {
            departure.begin();
        }
        let mut state = State::rolling(&self.wagon, order.start_m_s);
        let mut run = Run { order: order.clone(), rows: Vec::new(), truth: Vec::new() };
        for sample in 0..=(LONGEST_S / SAMPLE_S).round() as usize {
            let time_s = sample as f64 * SAMPLE_S;
            let demand_n = order.demand(time_s) * self.sheet.full_force_n();
            let rim_m_s = state.motion.wheel_speed_rad_s.map(|w| w * self.sheet.radius_m);
            protection.decide(time_s, state.motion.v_m_s, rim_m_s, demand_n);
            let wander = [clutter.pad[0].advance(), clutter.pad[1].advance()];
            let gust_m_s = clutter.gust.advance();
            for sub in 0..STEPS_PER_SAMPLE {
                let mut now =
                    state.moment(&self.wagon, order, time_s + sub as f64 * STEP_S, protection.sanding);
                let action = self.act(&mut now, order, wander, gust_m_s);
                let friction = |k: usize, slip_m_s: f64| {
                    self.wagon.rail_friction(order.rail)
                        * self.departures.product(|departure| departure.rail_friction(k, slip_m_s, &now))
                };
                let (next, rates) =
                    dynamics::step(&self.wagon, &state.motion, &action, state.lagged_m_s2, STEP_S, &friction);
                if sub == 0 {
                    let row = self.show(&now, order, &mut clutter);
                    run.truth.push(truth(&self.wagon, &now, &rates, &row));
                    run.rows.push(row);
                }
                for departure in &mut self.departures.0 {
                    departure.advance(&now);
                }
                state.advance(&self.wagon, &now, &next, &rates);
                state.cylinder_n = protection.fill(STEP_S, demand_n);
            }
            if state.motion.v_m_s < END_SPEED_M_S {
                break;
            }
        }
        run
    }

    /// Completes the moment with the torques and says what acts on the wagon.
    fn act(&self, now: &mut Moment, order: &Order, wander: [f64; 2], gust_m_s: f64) -> Action {
        let departures = &self.departures;
        let seen = *now;
        for k in 0..2 {
            let friction = self.wagon.pad_friction[k]
                * (1.0 + wander[k])
                * departures.product(|departure| departure.pad_friction(k, &seen));
            let force_n = departures.chain(seen.cylinder_force_n[k], |departure, force_n| {
                departure.pad_force_n(k, force_n, &seen)
            });
            let turning = dynamics::direction(seen.wheel_speed_rad_s[k] / 0.2);
            now.brake_torque_nm[k] = friction * force_n.max(0.0) * self.wagon.brake_radius_m * turning
                + departures.sum(|departure| departure.drag_torque_nm(k, &seen));
            now.drive_torque_nm[k] =
                order.traction_nm(seen.time_s) * departures.product(|departure| departure.drive(k, &seen));
        }
        let now = *now;
        Action {
            shaft_torque_nm: std::array::from_fn(|k| {
                let torque_nm = now.drive_torque_nm[k] - now.brake_torque_nm[k];
                departures
                    .chain(torque_nm, |departure, torque_nm| departure.shaft_torque_nm(k, torque_nm, &now))
            }),
            grade_rad: order.line.grade_rad(now.position_m)
                + departures.sum(|departure| departure.grade_error_rad(&now)),
            headwind_m_s: gust_m_s + departures.sum(|departure| departure.headwind_m_s(&now)),
            body_force_n: departures.sum(|departure| departure.body_force_n(&now)),
            load_transfer: departures.product(|departure| departure.load_transfer(&now)),
        }
    }

    /// One row of the recording: sensor departures, white noise, rounding as in the files.
    fn show(&mut self, now: &Moment, order: &Order, clutter: &mut Clutter) -> Row {
        let mut shown = Sensed { v_m_s: now.v_m_s, wheel_speed_rad_s: now.wheel_speed_rad_s };
        for departure in &mut self.departures.0 {
            departure.sense(now, &mut shown);
        }
        let noise = &mut clutter.noise;
        let sheet = &self.sheet;
        let mut force_n =
            |true_n: f64| (true_n + sheet.pressing_force_sigma_n * noise.normal()).max(0.0).round();
        let pressing_force_n = now.cylinder_force_n.map(&mut force_n);
        let bias_m = clutter.bias_m * (std::f64::consts::TAU * now.time_s / clutter.bias_period_s).sin();
        let mut wheel =
            |true_rad_s: f64| rounded(true_rad_s + sheet.wheel_speed_sigma_rad_s * noise.normal(), 1e4);
        Row {
            time_s: rounded(now.time_s, 1e2),
            wheel_speed_rad_s: shown.wheel_speed_rad_s.map(&mut wheel),
            v_m_s: rounded(shown.v_m_s + sheet.speed_sigma_m_s * noise.normal(), 1e4),
            pressing_force_n,
            drive_torque_nm: [order.traction_nm(now.time_s); 2],
            grade_rad: rounded(order.line.grade_rad(now.position_m), 1e5),
            sanding: now.sanding,
            position_m: rounded(now.position_m + bias_m + 0.3 * noise.normal(), 1e2),
        }
    }
}

/// What the next step takes over from the one before.
struct State {
    motion: Motion,
    position_m: f64,
    angle_rad: [f64; 2],
    lagged_m_s2: f64,
    cylinder_n: [f64; 2],
    brake_nm: [f64; 2],
    sliding_w: [f64; 2],
}

impl State {
    fn rolling(wagon: &TrueWagon, v_m_s: f64) -> Self {
        Self {
            motion: Motion { v_m_s, wheel_speed_rad_s: wagon.radius_m.map(|radius| v_m_s / radius) },
            position_m: 0.0,
            angle_rad: [0.0; 2],
            lagged_m_s2: 0.0,
            cylinder_n: [0.0; 2],
            brake_nm: [0.0; 2],
            sliding_w: [0.0; 2],
        }
    }

    /// The moment before its torques are known; brake torques are those of the step before.
    fn moment(&self, wagon: &TrueWagon, order: &Order, time_s: f64, sanding: bool) -> Moment {
        Moment {
            step_s: STEP_S,
            time_s,
            rail: order.rail,
            v_m_s: self.motion.v_m_s,
            acceleration_m_s2: self.lagged_m_s2,
            position_m: self.position_m,
            wheel_speed_rad_s: self.motion.wheel_speed_rad_s,
            wheel_angle_rad: self.angle_rad,
            contact_m: [self.position_m, self.position_m - wagon.wheelbase_m],
            cylinder_force_n: self.cylinder_n,
            brake_torque_nm: self.brake_nm,
            drive_torque_nm: [0.0; 2],
            sliding_power_w: self.sliding_w,
            sanding,
        }
    }

    fn advance(&mut self, wagon: &TrueWagon, now: &Moment, next: &Motion, rates: &dynamics::Rates) {
        self.brake_nm = now.brake_torque_nm;
        self.lagged_m_s2 = rates.acceleration_m_s2;
        self.position_m += STEP_S * 0.5 * (self.motion.v_m_s + next.v_m_s);
        for k in 0..2 {
            let before_rad_s = self.motion.wheel_speed_rad_s[k];
            let slip_m_s = wagon.radius_m[k] * before_rad_s - self.motion.v_m_s;
            self.sliding_w[k] = (rates.contact_n[k] * slip_m_s).abs();
            self.angle_rad[k] += STEP_S * 0.5 * (before_rad_s + next.wheel_speed_rad_s[k]);
        }
        self.motion = Motion { wheel_speed_rad_s: next.wheel_speed_rad_s.map(|w| w.max(0.0)), ..*next };
    }
}

fn truth(wagon: &TrueWagon, now: &Moment, rates: &dynamics::Rates, row: &Row) -> Truth {
    let load_n: f64 = rates.load_n.iter().sum();
    Truth {
        v_m_s: now.v_m_s,
        mu_w: rates.contact_n.iter().sum::<f64>() / load_n,
        mu_w_wheelset: std::array::from_fn(|k| rates.contact_n[k] / rates.load_n[k]),
        mu_b: std::array::from_fn(|k| {
            let force_n = row.pressing_force_n[k];
            (force_n > 2e3).then(|| now.brake_torque_nm[k] / (wagon.brake_radius_m * force_n))
        }),
        wheel_speed_rad_s: now.wheel_speed_rad_s,
        contact_n: rates.contact_n,
    }
}

fn rounded(value: f64, digits: f64) -> f64 {
    (value * digits).round() / digits
}
