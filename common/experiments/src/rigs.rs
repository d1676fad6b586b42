//! The papers' rigs as sources of recordings: sensor rows with the truth beside them, and the file that describes each.

use crate::bogie::controller::Control;
use crate::bogie::run::{Instant as BogieInstant, Setup, simulate as simulate_bogie};
use crate::bogie::{stopping, transition};
use crate::roller::rig::{
    BRAKE_RADIUS_M, INERTIA_ERROR, INERTIA_KG_M2, LOAD_N, MASS_KG, NOMINAL_PAD_FRICTION, RADIUS_M, RigSample,
    RigSensors, SAMPLE_PERIOD_S, Test, nominal_model, simulate,
};
use crate::traction::run::{Case, DURATION_S, Instant, Run, SAMPLE_PERIOD_S as MOTOR_PERIOD_S, SENSOR_SIGMA};
use railgrip_filter::{
    BogieRigFile, BogieSample, EstimatorInput, Plant, Roller, RollerRigFile, TractionRigFile, TractionSample,
    WagonSample,
};
use railgrip_recording::{BogieRow, MotorRow, Row, TruthRow};
use railgrip_vehicle::bogie_rig::RailCondition;
use railgrip_vehicle::traction_rig::Surface;
use railgrip_vehicle::{Brake, Rail, Sensors, Wheelset};

/// One sample of a rig with its truth.
#[derive(Debug, Clone, Copy)]
pub enum RigRow {
    /// Of a roller rig: a wagon with one wheelset.
    Wagon {
        /// What the sensors said.
        row: Row,
        /// What they could not see.
        truth: TruthRow,
    },
    /// Of a traction rig.
    Motor {
        /// What the sensors said.
        row: MotorRow,
        /// What they could not see.
        truth: MotorTruth,
    },
    /// Of a bogie rig.
    Bogie {
        /// What the sensors said.
        row: BogieRow,
        /// What they could not see.
        truth: BogieTruth,
    },
}

/// What no sensor of a bogie rig sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BogieTruth {
    /// Time, s.
    pub t_s: f64,
    /// Speed of the rollers' rim, m/s.
    pub v_m_s: f64,
    /// Adhesion utilised by the bogie, negative in braking.
    pub mu_w: f64,
    /// The same of each wheelset.
    pub mu_w_wheelset: [f64; 2],
    /// Creepage of each wheelset, negative in braking.
    pub slip: [f64; 2],
    /// Acceleration of the rollers, rad/s².
    pub roller_acceleration_rad_s2: f64,
    /// Water between wheel and roller: 0 dry, 1 wet.
    pub wetness: f64,
}

impl BogieTruth {
    /// Names and values in the order of a file.
    #[must_use]
    pub const fn columns(&self) -> [(&'static str, f64); 9] {
        [
            ("t_s", self.t_s),
            ("v_m_s", self.v_m_s),
            ("mu_w", self.mu_w),
            ("mu_w_f", self.mu_w_wheelset[0]),
            ("mu_w_r", self.mu_w_wheelset[1]),
            ("slip_f", self.slip[0]),
            ("slip_r", self.slip[1]),
            ("roller_acceleration_rad_s2", self.roller_acceleration_rad_s2),
            ("wetness", self.wetness),
        ]
    }
}

/// What no sensor of a traction rig sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorTruth {
    /// Time, s.
    pub t_s: f64,
    /// Speed of the roller's rim, m/s.
    pub v_m_s: f64,
    /// Creep force over load.
    pub mu_w: f64,
    /// Creepage.
    pub creepage: f64,
    /// Creep force of one wheel, N.
    pub creep_force_n: f64,
    /// Friction coefficient μ0.
    pub mu_0: f64,
}

impl MotorTruth {
    /// Names and values in the order of a file.
    #[must_use]
    pub const fn columns(&self) -> [(&'static str, f64); 6] {
        [
            ("t_s", self.t_s),
            ("v_m_s", self.v_m_s),
            ("mu_w", self.mu_w),
            ("creepage", self.creepage),
            ("creep_force_n", self.creep_force_n),
            ("mu_0", self.mu_0),
        ]
    }
}

impl RigRow {
    /// Time on the recorder's base, s.
    #[must_use]
    pub const fn time_s(&self) -> f64 {
        match self {
            Self::Wagon { row, .. } => row.t_s,
            Self::Motor { row, .. } => row.t_s,
            Self::Bogie { row, .. } => row.t_s,
        }
    }

    /// The sample as a filter takes it.
    #[must_use]
    pub fn input(&self) -> EstimatorInput {
        match self {
            Self::Wagon { row, .. } => EstimatorInput::Wagon(WagonSample {
                v_m_s: row.v_m_s,
                wheel_speed_rad_s: row.wheel_speed_rad_s,
                pressing_force_n: row.pressing_force_n,
                drive_torque_nm: row.drive_torque_nm,
                grade_rad: row.grade_rad,
                sanding: row.sanding,
                wsp_active: u32::from(row.wsp_active[0] > 0.5),
                ..WagonSample::missing(row.t_s)
            }),
            Self::Motor { row, .. } => EstimatorInput::Traction(traction_sample(row)),
            Self::Bogie { row, .. } => EstimatorInput::Bogie(bogie_sample(row)),
        }
    }
}

/// The sensors of a traction rig as a filter takes them.
#[must_use]
pub const fn traction_sample(row: &MotorRow) -> TractionSample {
    TractionSample {
        time_s: row.t_s,
        current_a: row.current_a,
        voltage_v: row.voltage_v,
        motor_speed_rad_s: row.motor_speed_rad_s,
        roller_speed_rad_s: row.roller_speed_rad_s,
        generator_current_a: row.generator_current_a,
    }
}

/// The sensors of a bogie rig as a filter takes them.
#[must_use]
pub const fn bogie_sample(row: &BogieRow) -> BogieSample {
    BogieSample {
        time_s: row.t_s,
        shaft_torque_nm: row.shaft_torque_nm,
        load_cell_n: row.load_cell_n,
        brake_pressure_pa: row.brake_pressure_pa,
        load_n: row.load_n,
        roller_pulses: row.roller_pulses,
        wheel_pulses: row.wheel_pulses,
    }
}

/// A rig under a published test, sample by sample.
pub struct RigFeed {
    source: Source,
    plant: Plant,
}

enum Source {
    Roller(std::vec::IntoIter<RigSample>),
    Traction(Box<Run>, u64),
    Bogie(Box<Setup>, std::vec::IntoIter<BogieInstant>),
}

impl RigFeed {
    /// Schwarz & Keck, Fig. 4, with the sensors of a train in service.
    #[must_use]
    pub fn slide_protection(seed: u64) -> Self {
        Self::roller(Test::SlideProtection, seed)
    }

    /// Schwarz & Keck, Figs. 5 and 6, likewise.
    #[must_use]
    pub fn sanding(seed: u64) -> Self {
        Self::roller(Test::Sanding, seed)
    }

    fn roller(test: Test, seed: u64) -> Self {
        let sensors = RigSensors::SERVICE;
        let samples = simulate(test, seed, sensors);
        Self {
            source: Source::Roller(samples.into_iter()),
            plant: Plant::Roller(roller_file(test, &sensors)),
        }
    }

    /// Zhao et al., a case of Table 2 (0 to 4) on a surface.
    #[must_use]
    pub fn traction(surface: Surface, case: usize, seed: u64) -> Self {
        let case = Case { surface, number: case.min(4) };
        let rig = case.rig();
        let name = format!("traction rig, {} case {}", surface.name(), case.number);
        let plant = Plant::Traction(TractionRigFile::of(&name, &rig.parameters, SENSOR_SIGMA));
        let count = (DURATION_S / MOTOR_PERIOD_S).round() as u64;
        Self { source: Source::Traction(Box::new(Run::new(case, seed, SENSOR_SIGMA)), count), plant }
    }

    /// Shrestha et al., Figs. 18 to 20: a stop from 4.14 m/s; `None` is no controller.
    #[must_use]
    pub fn bogie_stop(rail: RailCondition, control: Option<Control>, seed: u64) -> Self {
        let parameters = railgrip_vehicle::bogie_rig::BogieParameters::default();
        let control = control.unwrap_or_else(|| Control::none(&parameters));
        Self::bogie(stopping::from_full_speed(rail, control, seed))
    }

    /// Shrestha et al., Fig. 17: water under the wheelsets that the proposed controller brakes.
    #[must_use]
    pub fn bogie_water(seed: u64) -> Self {
        Self::bogie(transition::setup(Control::Proposed, 0.95, seed))
    }

    fn bogie(setup: Setup) -> Self {
        let rig = BogieRigFile::of("bogie rig", &setup.parameters);
        let instants = simulate_bogie(&setup);
        Self {
            source: Source::Bogie(Box::new(setup), instants.into_iter()),
            plant: Plant::Bogie(Box::new(rig)),
        }
    }

    /// What the rig is, as a filter may know it.
    #[must_use]
    pub const fn plant(&self) -> &Plant {
        &self.plant
    }
}

impl Iterator for RigFeed {
    type Item = RigRow;

    fn next(&mut self) -> Option<RigRow> {
        match &mut self.source {
            Source::Roller(samples) => samples.next().map(|sample| of_roller(&sample)),
            Source::Traction(run, left) => {
                *left = left.checked_sub(1)?;
                let Plant::Traction(rig) = &self.plant else { return None };
                Some(of_traction(&run.next_instant(), rig))
            }
            Source::Bogie(setup, instants) => instants.next().map(|instant| of_bogie(&instant, setup)),
        }
    }
}

/// The file of the roller rig, with the inertia that a filter believes.
#[must_use]
pub fn roller_file(test: Test, sensors: &RigSensors) -> RollerRigFile {
    RollerRigFile {
        schema: 1,
        kind: "roller".into(),
        name: "roller rig".into(),
        wheelset: Wheelset { radius_m: RADIUS_M, inertia_kg_m2: INERTIA_KG_M2 * INERTIA_ERROR },
        brake: Brake {
            radius_m: BRAKE_RADIUS_M,
            friction_coefficient: NOMINAL_PAD_FRICTION,
            friction_by_wheelset: None,
        },
        roller: Roller { load_n: LOAD_N, equivalent_mass_kg: MASS_KG },
        contact: nominal_model(test).constants().contact.clone(),
        rail: Rail { dry: 0.3, wet: 0.1, low: 0.05 },
        sensors: Sensors {
            sample_rate_hz: 1.0 / SAMPLE_PERIOD_S,
            speed_sigma_m_s: sensors.speed_m_s,
            wheel_speed_sigma_rad_s: sensors.wheel_speed_rad_s,
            pressing_force_sigma_n: sensors.pressing_force_n,
        },
    }
}

/// Pressing force below which pad friction is no truth, N.
const PRESSES_FROM_N: f64 = 2e3;

/// A sample of the roller rig as a row of a wagon with one wheelset.
#[must_use]
pub fn of_roller(sample: &RigSample) -> RigRow {
    let mut row = Row { t_s: sample.time_s, v_m_s: sample.v_m_s, grade_rad: 0.0, ..Row::default() };
    row.wheel_speed_rad_s[0] = sample.wheel_speed_rad_s;
    row.pressing_force_n[0] = sample.pressing_force_n;
    row.drive_torque_nm[0] = 0.0;
    row.wsp_active[0] = f64::from(u8::from(sample.wsp_active));
    let mut truth = TruthRow {
        t_s: sample.time_s,
        v_m_s: sample.v_true_m_s,
        mu_w: sample.adhesion,
        mu_w_wheelset: [f64::NAN; 4],
        mu_b: [f64::NAN; 4],
    };
    truth.mu_w_wheelset[0] = sample.adhesion;
    truth.mu_b[0] = if sample.pressing_force_n > PRESSES_FROM_N { sample.pad_friction } else { f64::NAN };
    RigRow::Wagon { row, truth }
}

fn of_bogie(instant: &BogieInstant, setup: &Setup) -> RigRow {
    let (sample, truth, p) = (&instant.sample, &instant.truth, &setup.parameters);
    let row = BogieRow {
        t_s: sample.time_s,
        shaft_torque_nm: sample.shaft_torque_nm,
        load_cell_n: sample.load_cell_n,
        brake_pressure_pa: sample.brake_pressure_pa,
        load_n: sample.load_n,
        roller_pulses: sample.roller_pulses,
        wheel_pulses: sample.wheel_pulses,
    };
    let truth = BogieTruth {
        t_s: sample.time_s,
        v_m_s: instant.v_m_s,
        mu_w: truth.mu_w(p),
        mu_w_wheelset: [0, 1].map(|i| truth.force_n[i] / p.wheelset_load_n[i]),
        slip: instant.slip.map(|slip| -slip),
        roller_acceleration_rad_s2: truth.roller_acceleration_rad_s2,
        wetness: instant.wetness,
    };
    RigRow::Bogie { row, truth }
}

fn of_traction(instant: &Instant, rig: &TractionRigFile) -> RigRow {
    let sample = &instant.sample;
    let row = MotorRow {
        t_s: sample.time_s,
        current_a: sample.current_a,
        voltage_v: sample.voltage_v,
        motor_speed_rad_s: sample.motor_speed_rad_s,
        roller_speed_rad_s: sample.roller_speed_rad_s,
        generator_current_a: sample.generator_current_a,
    };
    let truth = MotorTruth {
        t_s: sample.time_s,
        v_m_s: instant.state.roller_speed_rad_s * rig.drivetrain.roller_radius_m,
        mu_w: instant.contact.force.force_n / rig.drivetrain.normal_load_n,
        creepage: instant.contact.creepage,
        creep_force_n: instant.contact.force.force_n,
        mu_0: instant.adhesion_peak,
    };
    RigRow::Motor { row, truth }
}
