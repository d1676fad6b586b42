//! The rig under its speed profile, as its sensors see it.

use railgrip_filter::models::traction_rig::TractionSample;
use railgrip_vehicle::traction_rig::{
    Drive, DriveParameters, RigParameters, RigState, Surface, TractionRig, WheelContact,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Period of the drive's control and of the integrator, s.
pub const CONTROL_PERIOD_S: f64 = 1e-4;

/// Control periods in one sample: 1 kHz.
pub const CONTROLS_PER_SAMPLE: usize = 10;

/// Period of the samples, s.
pub const SAMPLE_PERIOD_S: f64 = CONTROL_PERIOD_S * CONTROLS_PER_SAMPLE as f64;

/// Length of a run, s.
pub const DURATION_S: f64 = 35.0;

/// One sigma of the sensors: currents (A), speeds (rad/s), voltages (V) – v_k of the paper read as standard
/// deviations.
pub const SENSOR_SIGMA: f64 = 1e-2;

/// One of the fifteen tests of Table 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// What lies between wheel and roller.
    pub surface: Surface,
    /// 0 (generator not connected) to 4.
    pub number: usize,
}

impl Case {
    /// All tests, surface by surface.
    pub fn all() -> Vec<Self> {
        Surface::ALL
            .into_iter()
            .flat_map(|surface| (0..5).map(move |number| Self { surface, number }))
            .collect()
    }

    /// Load resistance, Ω (Table 2).
    pub fn load_resistance_ohm(&self) -> f64 {
        let column = match self.surface {
            Surface::Base => [f64::INFINITY, 3.0, 1.5, 1.0, 0.0],
            Surface::Water => [f64::INFINITY, 4.5, 3.0, 1.5, 1.0],
            Surface::Oil => [f64::INFINITY, 7.0, 4.5, 3.0, 1.5],
        };
        column[self.number]
    }

    /// The rig set up for this test.
    pub fn rig(&self) -> TractionRig {
        TractionRig::new(RigParameters::new(self.surface, self.load_resistance_ohm()))
    }
}

/// ω*_motor of (5-5), rad/s.
pub fn speed_command_rad_s(time_s: f64) -> f64 {
    if (time_s / 5.0).floor() as i64 % 2 == 1 && time_s < 30.0 { 30.0 } else { 20.0 }
}

/// One instant of a run.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// What the sensors said.
    pub sample: TractionSample,
    /// Motion in truth.
    pub state: RigState,
    /// Contact in truth.
    pub contact: WheelContact,
    /// μ0 in truth.
    pub adhesion_peak: f64,
}

/// The rig under its speed profile, sample by sample.
#[derive(Clone, Debug)]
pub struct Run {
    case: Case,
    rig: TractionRig,
    drive: Drive,
    state: RigState,
    last_voltage_v: Option<[f64; 2]>,
    random: Pcg64Mcg,
    sensor_sigma: f64,
    samples: u64,
}

impl Run {
    /// A test with seeded sensor noise of `sensor_sigma`.
    pub fn new(case: Case, seed: u64, sensor_sigma: f64) -> Self {
        let rig = case.rig();
        let drive = Drive::new(DriveParameters::default(), &rig.motor);
        let state = drive.fluxed_state(&rig, speed_command_rad_s(0.0));
        let random = Pcg64Mcg::seed_from_u64(seed);
        Self { case, rig, drive, state, last_voltage_v: None, random, sensor_sigma, samples: 0 }
    }

    /// The next sample; the rig moves on to the one after it.
    pub fn next_instant(&mut self) -> Instant {
        let time_s = self.samples as f64 * SAMPLE_PERIOD_S;
        let peak = self.case.surface.adhesion_peak();
        let before = self.state;
        let mut measured_voltage_v = [0.0; 2];
        for inner in 0..CONTROLS_PER_SAMPLE {
            let command = speed_command_rad_s(time_s + inner as f64 * CONTROL_PERIOD_S);
            let voltage = self.drive.step(&self.state, command, CONTROL_PERIOD_S);
            if inner == 0 {
                // The sensor sees the mean of the two control periods that meet at the sample.
                let last = self.last_voltage_v.unwrap_or(voltage);
                measured_voltage_v = [0, 1].map(|axis| 0.5 * (voltage[axis] + last[axis]));
            }
            self.last_voltage_v = Some(voltage);
            self.state = self.rig.step(&self.state, voltage, peak, CONTROL_PERIOD_S);
        }
        self.samples += 1;
        let contact = self.rig.wheel_contact(before.motor_speed_rad_s, before.roller_speed_rad_s, peak);
        Instant {
            sample: self.measure(time_s, &before, measured_voltage_v),
            state: before,
            contact,
            adhesion_peak: peak,
        }
    }

    fn measure(&mut self, time_s: f64, state: &RigState, voltage_v: [f64; 2]) -> TractionSample {
        let mut noise = || -> f64 {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            self.sensor_sigma * normal
        };
        TractionSample {
            time_s,
            current_a: state.motor.current_a.map(|value| value + noise()),
            motor_speed_rad_s: state.motor_speed_rad_s + noise(),
            voltage_v: voltage_v.map(|value| value + noise()),
            roller_speed_rad_s: state.roller_speed_rad_s + noise(),
            generator_current_a: self.rig.generator().current_a(state.roller_speed_rad_s) + noise(),
        }
    }
}

/// Runs a test with seeded sensor noise of `sensor_sigma`.
pub fn simulate(case: Case, seed: u64, duration_s: f64, sensor_sigma: f64) -> Vec<Instant> {
    let mut run = Run::new(case, seed, sensor_sigma);
    (0..(duration_s / SAMPLE_PERIOD_S).round() as usize).map(|_| run.next_instant()).collect()
}
