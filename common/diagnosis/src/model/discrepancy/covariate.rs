//! Variables over which a place of the equations can err.

use crate::data::case::{Case, Run};
use railgrip_vehicle::MAX_WHEELSETS;
use railgrip_vehicle::constants::{DISC_HEAT_CAPACITY_J_PER_K, DRY_RAIL_ADHESION, FRICTION_RING_COOLING_S};
use railgrip_vehicle::effects::Operating;

/// A variable over which a place is freed; those of a wheelset are its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Covariate {
    /// Vehicle speed, m/s.
    Speed,
    /// Position, m.
    Position,
    /// Time since the start of the run, s.
    Time,
    /// Acceleration of the vehicle, m/s².
    Acceleration,
    /// Angular acceleration of the wheelset, rad/s².
    WheelAcceleration,
    /// Sum of pressing forces, N.
    BrakeForce,
    /// Pressing force of the wheelset, N.
    PressingForce,
    /// Pressing force less what it was a moment ago, N.
    ForceChange,
    /// Time since the brake was applied, s; 0 while released.
    TimeInBraking,
    /// Rise of disc temperature by a lumped model, K.
    Temperature,
    /// Heat into the disc since the run began on wet or low rail, J.
    WetBrakeEnergy,
    /// Slip velocity, m/s.
    SlipVelocity,
    /// Power dissipated by slip, W.
    SlipPower,
    /// Energy dissipated by slip since the start of the run, J.
    SlipEnergy,
    /// Angle of the wheel within a revolution, rad.
    WheelAngle,
    /// Drive torque, N m.
    DriveTorque,
}

/// Hidden states of a curve: temperatures, times since onset, slip energies, lagged pressing forces, wet brake energies.
pub(super) const HIDDEN: usize = 5 * MAX_WHEELSETS;
/// Pressing force above which a brake counts as applied, N.
const APPLIED_N: f64 = 3e3;
/// How long ago "a moment ago" is, s.
const MOMENT_S: f64 = 0.3;
/// Time from one of the thinned samples to the next, s.
const THINNED_S: f64 = 0.2;
/// Fewest of the thinned samples at which a covariate must be at work: ten seconds of recordings.
const FEWEST: usize = 50;
/// Slip velocity below which a wheelset rolls, m/s.
const ROLLING_M_S: f64 = 0.1;

impl Covariate {
    /// Name in the report.
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Position => "position",
            Self::Time => "time",
            Self::Acceleration => "acceleration",
            Self::WheelAcceleration => "wheel_acceleration",
            Self::BrakeForce => "brake_force",
            Self::PressingForce => "pressing_force",
            Self::ForceChange => "change_of_pressing_force",
            Self::TimeInBraking => "time_since_brake_onset",
            Self::Temperature => "temperature",
            Self::WetBrakeEnergy => "brake_energy_on_wet_rail",
            Self::SlipVelocity => "slip_velocity",
            Self::SlipPower => "slip_power",
            Self::SlipEnergy => "slip_energy",
            Self::WheelAngle => "wheel_angle",
            Self::DriveTorque => "drive_torque",
        }
    }

    /// Unit for people.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed | Self::SlipVelocity => "m/s",
            Self::Position => "m",
            Self::Time | Self::TimeInBraking => "s",
            Self::Acceleration => "m/s²",
            Self::WheelAcceleration => "rad/s²",
            Self::BrakeForce | Self::PressingForce | Self::ForceChange => "N",
            Self::Temperature => "°C",
            Self::SlipPower => "W",
            Self::SlipEnergy | Self::WetBrakeEnergy => "J",
            Self::WheelAngle => "rad",
            Self::DriveTorque => "N m",
        }
    }

    /// Whether a sample at this value says anything about a curve: a released brake says nothing of a brake.
    fn is_at_work(self, value: f64) -> bool {
        match self {
            Self::BrakeForce
            | Self::PressingForce
            | Self::TimeInBraking
            | Self::Temperature
            | Self::WetBrakeEnergy => value > 0.0,
            Self::SlipPower | Self::SlipEnergy | Self::DriveTorque => value.abs() > 10.0,
            Self::SlipVelocity => value > ROLLING_M_S,
            Self::ForceChange => value.abs() > 200.0,
            _ => true,
        }
    }

    /// Whether zero is where nothing happens, so that a curve must pass through it.
    pub(super) fn vanishes_at_zero(self) -> bool {
        matches!(self, Self::ForceChange | Self::Acceleration | Self::WheelAcceleration | Self::DriveTorque)
    }

    /// Knots at quantiles of the covariate where it is at work; `None` where it hardly varies.
    pub(super) fn knots(self, case: &Case, count: usize) -> Option<Vec<f64>> {
        if self == Self::WheelAngle {
            return Some((0..count).map(|k| k as f64 * std::f64::consts::TAU / count as f64).collect());
        }
        let mut values = self.samples(case);
        values.sort_by(f64::total_cmp);
        let n = values.len();
        let at = |share: f64| values[((n - 1) as f64 * share) as usize];
        // A constant torque differs from none.
        let varies = |values: f64| values >= 1e-3 * at(0.98).abs().max(1e-9);
        if n < FEWEST || !(self.vanishes_at_zero() || varies(at(0.98) - at(0.02))) {
            return None;
        }
        let (low, high) = (at(0.01), at(0.99));
        if self.vanishes_at_zero() {
            return Some(around_zero(low, high));
        }
        // Between quantiles and an even grid: neither crowded at a plateau nor empty where little was recorded.
        let knot = |k: usize| {
            let share = k as f64 / (count - 1) as f64;
            0.5 * (low + share * (high - low)) + 0.5 * at(0.01 + 0.98 * share)
        };
        let mut knots: Vec<f64> = (0..count).map(knot).collect();
        knots.dedup_by(|a, b| (*a - *b).abs() < 1e-6 * (high - low));
        (knots.len() >= 3).then_some(knots)
    }

    /// Values along the recordings, thinned.
    fn samples(self, case: &Case) -> Vec<f64> {
        let step = |run: &Run| ((THINNED_S / run.dt_s).round() as usize).max(1);
        let along = case.fit.iter().flat_map(|run| along(case, run, self).into_iter().step_by(step(run)));
        along.filter(|value| self.is_at_work(*value)).collect()
    }
}

/// Knots on both sides of zero (or one, if all lies on it), where nothing happens.
fn around_zero(low: f64, high: f64) -> Vec<f64> {
    let size = low.abs().max(high.abs());
    let mut knots = Vec::new();
    if low < -0.02 * size {
        knots.extend([low, 0.4 * low]);
    }
    knots.push(0.0);
    if high > 0.02 * size {
        knots.extend([0.4 * high, high]);
    }
    knots
}

/// A covariate at each sample of a run, from what was recorded; the front wheelset's where each has its own.
pub fn along(case: &Case, run: &Run, covariate: Covariate) -> Vec<f64> {
    let vehicle = &case.vehicle;
    let adhesion = vehicle.rail.adhesion(run.rail);
    let mut memory = [0.0; HIDDEN];
    if let Some(first) = run.samples.first() {
        start(
            &Operating { pressing_force_n: first.input.pressing_force_n, ..Operating::default() },
            &mut memory,
        );
    }
    run.samples
        .iter()
        .map(|sample| {
            let mut at = Operating {
                time_s: sample.input.time_s,
                v_m_s: sample.smooth[0],
                acceleration_m_s2: sample.slopes[0],
                position_m: sample.input.position_m,
                pressing_force_n: sample.input.pressing_force_n,
                adhesion_peak: [adhesion; MAX_WHEELSETS],
                ..Operating::default()
            };
            for i in 0..run.wheelsets {
                let omega = sample.smooth[1 + i];
                at.drive_torque_nm[i] = sample.input.mid_drive_torque_nm[i];
                at.wheel_speed_rad_s[i] = omega;
                at.wheel_acceleration_rad_s2[i] = sample.slopes[1 + i];
                at.wheel_angle_rad[i] = sample.input.wheel_angle_rad[i];
                let torque = vehicle.brake.friction_coefficient
                    * vehicle.brake.radius_m
                    * sample.input.pressing_force_n[i];
                at.brake_power_w[i] = (torque * omega).max(0.0);
                let slip = sample.smooth[0] - vehicle.wheelset.radius_m * omega;
                let limit = adhesion * vehicle.axle_load_n();
                at.slip_power_w[i] = if slip.abs() > ROLLING_M_S { slip.abs() * limit } else { 0.0 };
            }
            advance(&at, run.dt_s, &mut memory);
            value(covariate, &at, &memory, 0, vehicle.wheelset.radius_m)
        })
        .collect()
}

/// Sets the hidden states at the start of a run.
pub(super) fn start(at: &Operating, hidden: &mut [f64]) {
    hidden.fill(0.0);
    hidden[3 * MAX_WHEELSETS..4 * MAX_WHEELSETS].copy_from_slice(&at.pressing_force_n);
}

/// Advances the hidden states over a sample.
pub(super) fn advance(at: &Operating, dt_s: f64, hidden: &mut [f64]) {
    let [heat, onset, slip, lagged, wet] = rows(hidden);
    for i in 0..MAX_WHEELSETS {
        heat[i] +=
            dt_s * (at.brake_power_w[i] / DISC_HEAT_CAPACITY_J_PER_K - heat[i] / FRICTION_RING_COOLING_S);
        onset[i] = if at.pressing_force_n[i] > APPLIED_N { onset[i] + dt_s } else { 0.0 };
        slip[i] += dt_s * at.slip_power_w[i];
        lagged[i] += dt_s / MOMENT_S * (at.pressing_force_n[i] - lagged[i]);
        if at.adhesion_peak[i] <= DRY_RAIL_ADHESION {
            wet[i] += dt_s * at.brake_power_w[i];
        }
    }
}

fn rows(hidden: &mut [f64]) -> [&mut [f64]; 5] {
    let mut rows = hidden.chunks_exact_mut(MAX_WHEELSETS);
    std::array::from_fn(|_| rows.next().unwrap_or_default())
}

/// The covariate's value.
pub(super) fn value(
    covariate: Covariate,
    at: &Operating,
    hidden: &[f64],
    wheelset: usize,
    radius_m: f64,
) -> f64 {
    let row = |k: usize| hidden[k * MAX_WHEELSETS + wheelset];
    match covariate {
        Covariate::Speed => at.v_m_s,
        Covariate::Position => at.position_m,
        Covariate::Time => at.time_s,
        Covariate::Acceleration => at.acceleration_m_s2,
        Covariate::WheelAcceleration => at.wheel_acceleration_rad_s2[wheelset],
        Covariate::BrakeForce => at.pressing_force_n.iter().sum(),
        Covariate::PressingForce => at.pressing_force_n[wheelset],
        Covariate::ForceChange => at.pressing_force_n[wheelset] - row(3),
        Covariate::Temperature => row(0),
        Covariate::TimeInBraking => row(1),
        Covariate::WetBrakeEnergy => row(4),
        Covariate::SlipVelocity => (at.v_m_s - radius_m * at.wheel_speed_rad_s[wheelset]).abs(),
        Covariate::SlipPower => at.slip_power_w[wheelset],
        Covariate::SlipEnergy => row(2),
        Covariate::WheelAngle => at.wheel_angle_rad[wheelset].rem_euclid(std::f64::consts::TAU),
        Covariate::DriveTorque => at.drive_torque_nm[wheelset],
    }
}
