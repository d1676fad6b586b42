//! The plant: drives one ordered run with a real wagon, its departures, clutter and sensors, and records it.

use std::f64::consts::TAU;

use super::{
    moment::{Departure, Departures, Moment, Sensed},
    motion::{self, Action, Integrator, Motion},
    noise::{Channel, Noise},
    programme::FamilyOrder,
    protection::Protection,
    sheet::FamilySheet,
    units::PerWheelset,
    wagon::FamilyWagon,
};
use crate::{
    random::{Stream, Wander},
    sheet::GRAVITY_M_S2,
};

/// Clutter changes this often, s.
const CLUTTER_S: f64 = 0.05;
/// Slide protection decides this often, s.
const DECIDE_S: f64 = 0.01;

/// One recorded sample, as the file holds it; `NaN` where a cell is empty.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FamilyRow {
    /// Time, s.
    pub time_s: f64,
    /// Measured speed, m/s.
    pub v_m_s: f64,
    /// Measured wheel speeds, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
    /// Measured pressing forces, N.
    pub pressing_force_n: PerWheelset,
    /// Reported drive torques, N m.
    pub drive_torque_nm: f64,
    /// Mapped slope, rad.
    pub grade_rad: f64,
    /// Whether the sanders run.
    pub sanding: bool,
    /// Position by satellite, m.
    pub position_m: f64,
}

/// What no sensor sees at the same instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FamilyTruth {
    /// True speed, m/s.
    pub v_m_s: f64,
    /// True wheel speeds, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
    /// Contact forces, N.
    pub contact_n: PerWheelset,
}

/// A finished run.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyRun {
    /// What was ordered.
    pub order: FamilyOrder,
    /// The recording.
    pub rows: Vec<FamilyRow>,
    /// The truth beside it, sample by sample.
    pub truth: Vec<FamilyTruth>,
}

/// How a plant is built beside its equations.
#[derive(Debug, Clone, PartialEq)]
pub struct Build {
    /// Integration.
    pub integrator: Integrator,
    /// Sensors.
    pub noise: Noise,
    /// Whether it has slide protection.
    pub protected: bool,
}

/// A wagon with everything about it that is true.
pub struct FamilyPlant<'a> {
    sheet: &'a FamilySheet,
    wagon: FamilyWagon,
    build: &'a Build,
    departures: Departures,
    seed: u64,
}

/// Slow or random things that every run has and no model knows.
struct Clutter {
    pad: [Wander; 4],
    gust: Wander,
    pad_now: PerWheelset,
    gust_m_s: f64,
    next_s: f64,
}

impl Clutter {
    fn new(seed: u64, run: u64) -> Self {
        let mut stream = Stream::new(seed, "clutter", run);
        let (pad_s, gust_s) = (stream.uniform(4.0, 14.0), stream.uniform(2.0, 8.0));
        let wander = |k: u64| Wander::new(Stream::new(seed, "pad", 8 * run + k), 0.006, pad_s, CLUTTER_S);
        Self {
            pad: [wander(0), wander(1), wander(2), wander(3)],
            gust: Wander::new(Stream::new(seed, "gust", run), 0.5, gust_s, CLUTTER_S),
            pad_now: [0.0; 4],
            gust_m_s: 0.0,
            next_s: 0.0,
        }
    }

    fn at(&mut self, time_s: f64) {
        while time_s >= self.next_s {
            self.next_s += CLUTTER_S;
            self.gust_m_s = self.gust.advance();
            for (now, wander) in self.pad_now.iter_mut().zip(&mut self.pad) {
                *now = wander.advance();
            }
        }
    }
}

/// Sensors of one run.
struct Sensors {
    speed: Channel,
    wheels: [Channel; 4],
    forces: [Channel; 4],
    place: Stream,
    bias_m: f64,
    bias_period_s: f64,
}

impl Sensors {
    fn new(sheet: &FamilySheet, noise: &Noise, seed: u64, run: u64) -> Self {
        let sample_s = 1.0 / sheet.rate_hz;
        let channel = |purpose: &str, k: usize, sigma: f64, digit: f64| {
            Channel::new(noise, Stream::new(seed, purpose, 8 * run + k as u64), sigma, sample_s, digit)
        };
        // Pressure is white: its noise is no output of a model.
        let force = |k: usize| {
            let stream = Stream::new(seed, "force noise", 8 * run + k as u64);
            let noise = Noise { dropouts_per_min: 0.3 * noise.dropouts_per_min, ..Noise::WHITE };
            Channel::new(&noise, stream, sheet.pressing_force_sigma_n, sample_s, 1.0)
        };
        let mut place = Stream::new(seed, "place", run);
        Self {
            speed: channel("speed noise", 0, sheet.speed_sigma_m_s, 1e-4),
            wheels: std::array::from_fn(|k| channel("wheel noise", k, sheet.wheel_speed_sigma_rad_s, 1e-4)),
            forces: std::array::from_fn(force),
            bias_m: place.sign() * place.uniform(1.0, 2.0),
            bias_period_s: place.uniform(60.0, 140.0),
            place,
        }
    }
}

impl<'a> FamilyPlant<'a> {
    /// A plant; `seed` rules clutter, sensors and protection, not the wagon.
    #[must_use]
    pub fn new(
        sheet: &'a FamilySheet,
        wagon: &FamilyWagon,
        build: &'a Build,
        departures: Departures,
        seed: u64,
    ) -> Self {
        let mut wagon = wagon.clone();
        for departure in &departures.0 {
            departure.adapt(&mut wagon);
        }
        Self { sheet, wagon, build, departures, seed }
    }

    /// The wagon with its departures applied.
    #[must_use]
    pub fn wagon(&self) -> &FamilyWagon {
        &self.wagon
    }

    /// Drives one run, number `index` of its case.
    #[must_use]
    pub fn drive(&mut self, order: &FamilyOrder, index: usize) -> FamilyRun {
        let sample_s = 1.0 / self.sheet.rate_hz;
        let substeps = (sample_s / self.build.integrator.longest_step_s() - 1e-9).ceil().max(1.0);
        let step_s = sample_s / substeps;
        let full_n = self.sheet.full_force_n();
        let mut clutter = Clutter::new(self.seed, index as u64);
        let mut sensors = Sensors::new(self.sheet, &self.build.noise, self.seed, index as u64);
        let mut protection = Protection::new(
            &mut Stream::new(self.seed, "protection", 0),
            self.wagon.wheelsets,
            self.build.protected,
            self.sheet.sander,
        );
        protection.begin(order.demand(0.0) * full_n);
        self.departures.0.iter_mut().for_each(|departure| departure.begin());
        let mut now =
            self.start(order, index, step_s, protection.fill(0.0, order.demand(0.0) * full_n, full_n));
        let mut run = FamilyRun { order: order.clone(), rows: Vec::new(), truth: Vec::new() };
        let (mut decide_s, mut standing_s) = (0.0, 0.0);
        for sample in 0..=(order.longest_s / sample_s) as usize {
            for sub in 0..substeps as usize {
                now.time_s = sample as f64 * sample_s + sub as f64 * step_s;
                let demand_n = order.demand(now.time_s) * full_n;
                if now.time_s >= decide_s {
                    decide_s += DECIDE_S;
                    let rim_m_s = now.wheel_speed_rad_s.map(|rad_s| rad_s * self.sheet.radius_m);
                    protection.decide(now.time_s, now.v_m_s, rim_m_s, demand_n);
                    now.sanding = protection.sanding;
                }
                clutter.at(now.time_s);
                let torque_nm = order.drive(now.time_s) * self.sheet.drive_nm;
                now.drive_torque_nm[..self.wagon.wheelsets].fill(torque_nm);
                let action = self.act(&mut now, &clutter);
                if sub == 0 {
                    run.rows.push(self.show(&now, &mut sensors));
                }
                let motion = Motion { v_m_s: now.v_m_s, wheel_speed_rad_s: now.wheel_speed_rad_s };
                let stepped = motion::step(
                    &self.wagon,
                    &motion,
                    &action,
                    now.acceleration_m_s2,
                    step_s,
                    self.build.integrator,
                );
                if sub == 0 {
                    let contact_n = stepped.contact_n;
                    run.truth.push(FamilyTruth {
                        v_m_s: now.v_m_s,
                        wheel_speed_rad_s: now.wheel_speed_rad_s,
                        contact_n,
                    });
                }
                self.departures.0.iter_mut().for_each(|departure| departure.advance(&now));
                advance(&mut now, &action, &stepped);
                now.cylinder_force_n = protection.fill(step_s, demand_n, full_n);
            }
            let drives_again = order.drive.iter().any(|(from_s, _, _)| *from_s > now.time_s);
            standing_s += if now.v_m_s < 0.05 { sample_s } else { 0.0 };
            let ends =
                if order.to_standstill { standing_s > 2.5 } else { now.v_m_s < 2.0 && now.time_s > 5.0 };
            if ends
                && !drives_again
                && now.time_s > order.drive.first().map_or(0.0, |(from_s, _, _)| from_s + 4.0)
            {
                break;
            }
        }
        run
    }

    fn start(&self, order: &FamilyOrder, index: usize, step_s: f64, cylinder_force_n: PerWheelset) -> Moment {
        let wagon = &self.wagon;
        let rolling = |k: usize| if k < wagon.wheelsets { order.start_m_s / wagon.radius_m[k] } else { 0.0 };
        Moment {
            step_s,
            sample_s: 1.0 / self.sheet.rate_hz,
            time_s: 0.0,
            run: index,
            rail: order.rail,
            line: order.line,
            wheelsets: wagon.wheelsets,
            v_m_s: order.start_m_s,
            acceleration_m_s2: 0.0,
            position_m: 0.0,
            wheel_speed_rad_s: std::array::from_fn(rolling),
            wheel_angle_rad: [0.0; 4],
            contact_m: std::array::from_fn(|k| wagon.positions_m[k] - wagon.positions_m[0]),
            slip_m_s: [0.0; 4],
            sliding_power_w: [0.0; 4],
            cylinder_force_n,
            brake_torque_nm: [0.0; 4],
            drive_torque_nm: [0.0; 4],
            sanding: false,
        }
    }

    /// What acts on the wagon now; completes the moment with the brake torques.
    fn act(&self, now: &mut Moment, clutter: &Clutter) -> Action {
        let (wagon, departures, seen) = (&self.wagon, &self.departures, *now);
        let mass_kg = wagon.mass_kg + departures.sum(|departure| departure.extra_mass_kg(&seen));
        let transfer = departures.product(|departure| departure.load_transfer(&seen));
        let mut action = Action {
            mass_kg,
            load_n: wagon.loads_n(mass_kg, seen.acceleration_m_s2, transfer),
            ..Action::default()
        };
        for k in 0..wagon.wheelsets {
            let friction = wagon.pad_friction[k]
                * (1.0 + clutter.pad_now[k])
                * departures.product(|departure| departure.pad_friction(k, &seen));
            let cylinder_n = seen.cylinder_force_n[k];
            let pads = departures.0.iter().map(AsRef::as_ref);
            let force_n =
                pads.fold(cylinder_n, |force_n, pad: &dyn Departure| pad.pad_force_n(k, force_n, &seen));
            let force_n = force_n.max(0.0);
            let drag_nm = departures.sum(|departure| departure.drag_torque_nm(k, &seen));
            action.brake_nm[k] = friction.max(0.0) * force_n * wagon.brake_radius_m + drag_nm.max(0.0);
            now.brake_torque_nm[k] = action.brake_nm[k];
            action.torque_nm[k] = seen.drive_torque_nm[k]
                * departures.product(|departure| departure.drive(k, &seen))
                - drag_nm.min(0.0);
            let shaft_nm = action.torque_nm[k] - action.brake_nm[k];
            let mut shafts =
                departures.0.iter().filter_map(|departure| departure.shaft_torque_nm(k, shaft_nm, &seen));
            if let Some(transmitted_nm) = shafts.next_back() {
                (action.torque_nm[k], action.brake_nm[k]) = (transmitted_nm, 0.0);
            }
            action.radius_m[k] =
                wagon.radius_m[k] * departures.product(|departure| departure.radius(k, &seen));
            action.inertia_kg_m2[k] =
                wagon.inertia_kg_m2[k] * departures.product(|departure| departure.inertia(k, &seen));
            action.peak[k] = wagon.rail_friction(seen.rail)
                * departures.product(|departure| departure.rail_friction(k, &seen)).max(0.02);
        }
        let [constant, linear, drag] = wagon.resistance;
        let air_m_s =
            seen.v_m_s + clutter.gust_m_s + departures.sum(|departure| departure.headwind_m_s(&seen));
        let grade_rad = seen.line.grade_rad(seen.position_m)
            + departures.sum(|departure| departure.grade_error_rad(&seen));
        action.resisting_n = constant + linear * seen.v_m_s;
        action.outer_n = departures.sum(|departure| departure.body_force_n(&seen))
            - drag * air_m_s * air_m_s.abs()
            - mass_kg * GRAVITY_M_S2 * grade_rad.sin();
        action
    }

    /// One row of the recording.
    fn show(&mut self, now: &Moment, sensors: &mut Sensors) -> FamilyRow {
        let mut shown = Sensed { v_m_s: now.v_m_s, wheel_speed_rad_s: now.wheel_speed_rad_s };
        self.departures.0.iter_mut().for_each(|departure| departure.sense(now, &mut shown));
        let count = self.wagon.wheelsets;
        let mut row = FamilyRow {
            time_s: (now.time_s * 1e4).round() / 1e4,
            v_m_s: sensors.speed.read(shown.v_m_s),
            drive_torque_nm: now.drive_torque_nm[0],
            grade_rad: (now.line.grade_rad(now.position_m) * 1e5).round() / 1e5,
            sanding: now.sanding,
            ..FamilyRow::default()
        };
        for k in 0..count {
            row.wheel_speed_rad_s[k] = sensors.wheels[k].read(shown.wheel_speed_rad_s[k]);
            row.pressing_force_n[k] =
                sensors.forces[k].read(now.cylinder_force_n[k]).clamp(0.0, f64::INFINITY);
        }
        let bias_m = sensors.bias_m * (TAU * now.time_s / sensors.bias_period_s).sin();
        row.position_m = ((now.position_m + bias_m + 0.3 * sensors.place.normal()) * 1e2).round() / 1e2;
        row
    }
}

/// The moment that begins the next step.
fn advance(now: &mut Moment, action: &Action, stepped: &motion::Stepped) {
    let (step_s, next) = (now.step_s, &stepped.motion);
    let moved_m = step_s * 0.5 * (now.v_m_s + next.v_m_s);
    now.position_m += moved_m;
    for k in 0..now.wheelsets {
        now.contact_m[k] += moved_m;
        now.wheel_angle_rad[k] += step_s * 0.5 * (now.wheel_speed_rad_s[k] + next.wheel_speed_rad_s[k]);
        now.slip_m_s[k] = action.radius_m[k] * next.wheel_speed_rad_s[k] - next.v_m_s;
        now.sliding_power_w[k] = (stepped.contact_n[k] * now.slip_m_s[k]).abs();
    }
    now.v_m_s = next.v_m_s;
    now.wheel_speed_rad_s = next.wheel_speed_rad_s;
    now.acceleration_m_s2 = stepped.acceleration_m_s2;
}
