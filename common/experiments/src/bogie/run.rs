//! The rig in closed loop.
//!
//! The rig computer counts the rollers' pulses at 8 Hz and sets the drive's speed. While a stop is emulated, it lowers
//! the reference as a mass would slow down under the force of the load cell. At 100 Hz it filters the sensors, decides,
//! and asks the brakes for a pressure.

use super::controller::{BrakeController, Control};
use super::listener::{Moment, RigListener, SimulatedListener};
use railgrip_filter::models::bogie_rig::{
    BogieEstimate, BogieFilter, BogieNoise, BogieSample, Decision, DecisionMaker,
};
use railgrip_vehicle::bogie_rig::{
    BogieParameters, BogieRig, BogieRigStep, BogieSensors, ContactLaw, HydraulicBrake, RailCondition,
    RollerDrive, rpm_from_rad_s,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

/// Step of the integrator, s.
pub const STEP_S: f64 = 1e-3;

/// Mass that the drive emulates in a stop, kg. The paper does not give it. Its dry stops need 24 to 28 t under the
/// adhesion of its Fig. 16; the 26.5 t of the full-size axle load is taken.
pub const EMULATED_MASS_KG: f64 = 26.5e3;

/// Level of the contact's friction along the rollers: relative sigma and length over which it changes, m. Chosen.
const ROUGHNESS: (f64, f64) = (0.015, 0.3);

/// What lies between wheels and rollers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rail {
    /// The same all the time.
    Steady(RailCondition),
    /// Dry until water is injected.
    Water {
        /// When, s.
        at_s: f64,
        /// Time in which it spreads, s.
        spread_s: f64,
        /// Share of it that sliding wipes off in the end.
        wiped: f64,
        /// Work of sliding that wipes most of that off, J.
        wiping_j: f64,
    },
}

/// One test.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Constants of the rig.
    pub parameters: BogieParameters,
    /// Speed at the start, m/s.
    pub v_m_s: f64,
    /// Surface.
    pub rail: Rail,
    /// Controller.
    pub control: Control,
    /// Torque a wheelset that is applied before the controller acts, N m.
    pub preset_torque_nm: f64,
    /// Brakes are applied from here, s.
    pub brake_from_s: f64,
    /// The controller acts that long after, s.
    pub control_lag_s: f64,
    /// The emulated mass is let go that long after the brakes are applied, s; infinite: the speed is held.
    pub hold_s: f64,
    /// Share of windows that the listener hears right.
    pub accuracy: f64,
    /// Relative roughness of the friction, times that of [`ROUGHNESS`].
    pub roughness: f64,
    /// End at the latest, s.
    pub end_s: f64,
    /// Seed.
    pub seed: u64,
}

/// One instant, 100 a second.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// What the sensors said.
    pub sample: BogieSample,
    /// What the filter made of it.
    pub estimate: BogieEstimate,
    /// What was decided.
    pub decision: Decision,
    /// Probability of "dry" of the window that ended here.
    pub heard: Option<f64>,
    /// Torque asked of each wheelset, N m.
    pub torque_nm: f64,
    /// Motion and forces in truth.
    pub truth: BogieRigStep,
    /// Slip λ in truth.
    pub slip: [f64; 2],
    /// Speed of the rollers' rim in truth, m/s.
    pub v_m_s: f64,
    /// Way of the rollers' rim since the brakes were applied, m.
    pub way_m: f64,
    /// Water in truth: 0 dry, 1 wet.
    pub wetness: f64,
}

impl Instant {
    /// Adhesion utilised in truth, positive in braking.
    pub fn adhesion(&self, parameters: &BogieParameters) -> f64 {
        -self.truth.mu_w(parameters)
    }

    /// Slip λ of the wheelset that slips most.
    pub fn slip_max(&self) -> f64 {
        self.slip[0].max(self.slip[1])
    }
}

/// Time and way of a stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stop {
    /// Time since the brakes were applied, s.
    pub time_s: f64,
    /// Way since then, m.
    pub way_m: f64,
    /// Time with a wheelset locked while the rollers turned at more than 0.2 m/s, s.
    pub locked_s: f64,
}

/// What `instants` say of the stop they end with.
pub fn stop(setup: &Setup, instants: &[Instant]) -> Stop {
    let Some(last) = instants.last() else { return Stop::default() };
    let locked = instants.iter().filter(|instant| instant.v_m_s > 0.2 && instant.slip_max() > 0.95).count();
    Stop {
        time_s: last.sample.time_s - setup.brake_from_s,
        way_m: last.way_m,
        locked_s: locked as f64 * setup.parameters.sensors.sample_period_s,
    }
}

/// Everything that moves in a test.
struct Loop<'a> {
    setup: &'a Setup,
    rig: BogieRig,
    drive: RollerDrive,
    brake: HydraulicBrake,
    sensors: BogieSensors,
    filter: BogieFilter,
    maker: DecisionMaker,
    controller: BrakeController,
    listener: Box<dyn RigListener + 'a>,
    random: Pcg64Mcg,
    level: [f64; 2],
    step: BogieRigStep,
    reference_m_s: f64,
    window_began_s: f64,
    window_force_n: (f64, f64),
    pressure_command_pa: f64,
    wiped_j: f64,
    wetness: f64,
    way_m: f64,
}

/// Runs a test until the rollers stand, a ramp is done, or its time is over.
pub fn simulate(setup: &Setup) -> Vec<Instant> {
    simulate_with(setup, SimulatedListener::new(setup.accuracy, setup.seed))
}

/// The same with another listener; lend it to ask it afterwards.
pub fn simulate_with<'a>(setup: &'a Setup, listener: impl RigListener + 'a) -> Vec<Instant> {
    let mut run = Loop::new(setup, Box::new(listener));
    let p = &setup.parameters;
    let inner = (p.sensors.sample_period_s / STEP_S).round() as u64;
    let mut instants = Vec::new();
    for k in 0..(setup.end_s / STEP_S) as u64 {
        let time_s = k as f64 * STEP_S;
        if k.is_multiple_of(inner) {
            let instant = run.instant(time_s);
            instants.push(instant);
            let released = run.controller.is_done() && instant.slip_max() < 0.01;
            let stopped = time_s > setup.brake_from_s && run.reference_m_s <= 0.0 && instant.v_m_s < 0.02;
            if stopped || released && run.brake.pressure_pa < 1e4 {
                break;
            }
        }
        run.advance(time_s);
    }
    instants
}

impl<'a> Loop<'a> {
    fn new(setup: &'a Setup, listener: Box<dyn RigListener + 'a>) -> Self {
        let p = &setup.parameters;
        let rig = BogieRig::new(p.clone());
        let mut random = Pcg64Mcg::seed_from_u64(setup.seed);
        let phases = [0; 3].map(|_| {
            let normal: f64 = StandardNormal.sample(&mut random);
            (0.25 * TAU * normal).rem_euclid(TAU)
        });
        let begin = match setup.rail {
            Rail::Steady(condition) => condition,
            Rail::Water { .. } => RailCondition::Dry,
        };
        let [dry, wet] = RailCondition::ALL.map(ContactLaw::of);
        let step = BogieRigStep { state: rig.rolling(setup.v_m_s), ..BogieRigStep::default() };
        Self {
            setup,
            drive: RollerDrive::turning(p.drive, p.motor_speed_rpm_at(setup.v_m_s)),
            brake: HydraulicBrake::released(p.brake),
            sensors: BogieSensors::new(p.sensors, p.gear_ratio, phases),
            filter: BogieFilter::new(p.clone(), BogieNoise::default()),
            maker: DecisionMaker::new(dry, wet, p.wheelset_load_n[0], begin),
            controller: BrakeController::new(setup.control, setup.preset_torque_nm),
            listener,
            rig,
            random,
            level: [1.0; 2],
            step,
            reference_m_s: setup.v_m_s,
            window_began_s: 0.0,
            window_force_n: (0.0, 0.0),
            pressure_command_pa: 0.0,
            wiped_j: 0.0,
            wetness: if begin == RailCondition::Wet { 1.0 } else { 0.0 },
            way_m: 0.0,
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// Samples, filters, decides and asks for a pressure.
    fn instant(&mut self, time_s: f64) -> Instant {
        let sample = self.sample(time_s);
        let estimate = self.filter.step(&sample);
        let slip = self.rig.slip(&self.step.state);
        self.listener.pass(&Moment {
            v_m_s: self.rig.v_m_s(&self.step.state),
            slip: slip[0].max(slip[1]),
            wetness: self.wetness,
        });
        let heard = self.listener.dry_probability(time_s);
        let v = if estimate.v_m_s.is_finite() { estimate.v_m_s } else { self.setup.v_m_s };
        let decision = self.maker.decide(estimate.slip(), v, estimate.adhesion_utilised(), heard);
        let p = &self.setup.parameters;
        let since_s = time_s - self.setup.brake_from_s;
        let torque_nm = if since_s < 0.0 {
            0.0
        } else if since_s < self.setup.control_lag_s {
            self.setup.preset_torque_nm
        } else {
            self.controller.step(p, &estimate, &decision, p.sensors.sample_period_s)
        };
        self.pressure_command_pa = p.brake.pressure_pa(torque_nm);
        Instant {
            sample,
            estimate,
            decision,
            heard,
            torque_nm,
            truth: self.step,
            slip: self.rig.slip(&self.step.state),
            v_m_s: self.rig.v_m_s(&self.step.state),
            way_m: self.way_m,
            wetness: self.wetness,
        }
    }

    /// What the sensors say; the drive takes its turn when the rollers' counter is read.
    fn sample(&mut self, time_s: f64) -> BogieSample {
        let (torque_noise, force_noise) = (self.normal(), self.normal());
        let p = &self.setup.parameters;
        let load_cell_n = self.sensors.load_cell_n(&self.step, force_noise);
        self.window_force_n = (self.window_force_n.0 + load_cell_n, self.window_force_n.1 + 1.0);
        // At 100 Hz a window of 0.125 s is twelve or thirteen samples long.
        let windows = |time_s: f64| ((time_s + 1e-9) / p.sensors.roller_window_s).floor();
        let over = windows(time_s) > windows(self.window_began_s);
        BogieSample {
            time_s,
            shaft_torque_nm: self.sensors.torque_nm(&self.step, torque_noise),
            load_cell_n,
            brake_pressure_pa: self.brake.pressure_pa,
            load_n: p.load_n(),
            roller_pulses: if over { self.turn_drive(time_s) } else { f64::NAN },
            wheel_pulses: self.sensors.wheel_pulses(&self.step),
        }
    }

    /// The rig computer's turn: pulses to speed, emulated mass, PI loop.
    fn turn_drive(&mut self, time_s: f64) -> f64 {
        let p = &self.setup.parameters;
        let dt_s = time_s - self.window_began_s;
        self.window_began_s = time_s;
        let pulses = self.sensors.roller_pulses(&self.step);
        let measured_rpm = rpm_from_rad_s(pulses * TAU / p.sensors.roller_pulses_per_rev / dt_s);
        let force_n = self.window_force_n.0 / self.window_force_n.1.max(1.0);
        self.window_force_n = (0.0, 0.0);
        if time_s >= self.setup.brake_from_s + self.setup.hold_s {
            self.reference_m_s = (self.reference_m_s - force_n.max(0.0) * dt_s / EMULATED_MASS_KG).max(0.0);
        }
        self.drive.control(p.motor_speed_rpm_at(self.reference_m_s), measured_rpm, dt_s);
        pulses
    }

    /// Moves the rig on by one step.
    fn advance(&mut self, time_s: f64) {
        let p = &self.setup.parameters;
        let v = self.rig.v_m_s(&self.step.state);
        let slip_power: f64 = (0..2)
            .map(|i| {
                let rim = p.wheel_radius_m * self.step.state.wheel_speed_rad_s[i];
                self.step.force_n[i] * (rim - v)
            })
            .sum();
        self.wet(time_s, slip_power);
        let keep = (-v * STEP_S / ROUGHNESS.1).exp();
        let sigma = ROUGHNESS.0 * self.setup.roughness * (1.0 - keep * keep).sqrt();
        for i in 0..2 {
            self.level[i] = 1.0 + keep * (self.level[i] - 1.0) + sigma * self.normal();
        }
        let law = ContactLaw::blend(self.wetness);
        let p = &self.setup.parameters;
        let motor_speed = p.gear_ratio * self.step.state.roller_speed_rad_s;
        let motor_torque = self.drive.torque_nm(motor_speed, STEP_S);
        let brakes = self.brake.step(self.pressure_command_pa, STEP_S);
        self.step = self.rig.step(&self.step.state, motor_torque, brakes, &law, self.level, STEP_S);
        if time_s >= self.setup.brake_from_s {
            self.way_m += 0.5 * STEP_S * (v + self.rig.v_m_s(&self.step.state));
        }
    }

    fn wet(&mut self, time_s: f64, slip_power_w: f64) {
        let Rail::Water { at_s, spread_s, wiped, wiping_j } = self.setup.rail else { return };
        if time_s < at_s {
            return;
        }
        self.wiped_j += slip_power_w * STEP_S;
        let spread = 1.0 - (-(time_s - at_s) / spread_s).exp();
        self.wetness = spread * (1.0 - wiped * (1.0 - (-self.wiped_j / wiping_j).exp()));
    }
}
