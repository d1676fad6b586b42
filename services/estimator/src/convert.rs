//! Between messages and the filter: a missing value is a clear bit there and NaN here.

use railgrip_filter::{BogieRigFile, EstimatorOutput, TractionSample, WagonSample};
use railgrip_messages::{
    BogieSample, Estimate, Innovation, MotorSample, Sample, bogie_valid, motor_valid, valid,
};
use railgrip_vehicle::VehicleParameters;

/// A sample as the filter takes it.
#[must_use]
pub fn wagon_sample(sample: &Sample) -> WagonSample {
    let mut input = WagonSample::missing(sample.time_s);
    let value = |bit: u32, value: f64| if sample.has(bit) { value } else { f64::NAN };
    input.v_m_s = value(valid::SPEED, sample.v_m_s);
    input.grade_rad = value(valid::GRADE, sample.grade_rad);
    input.sanding = value(valid::SANDING, sample.sanding);
    input.position_m = value(valid::POSITION, sample.position_m);
    input.load_kg = value(valid::LOAD, sample.load_kg);
    for wheelset in 0..sample.wheelset_count() {
        input.wheel_speed_rad_s[wheelset] =
            value(valid::wheel_speed(wheelset), sample.wheel_speed_rad_s[wheelset]);
        input.pressing_force_n[wheelset] =
            value(valid::pressing_force(wheelset), sample.pressing_force_n[wheelset]);
        input.drive_torque_nm[wheelset] =
            value(valid::drive_torque(wheelset), sample.drive_torque_nm[wheelset]);
    }
    input.wsp_active = sample.wsp_active;
    input
}

/// A sample of a driven rig as the filter takes it.
#[must_use]
pub fn traction_sample(sample: &MotorSample) -> TractionSample {
    let value = |bit: u32, value: f64| if sample.has(bit) { value } else { f64::NAN };
    TractionSample {
        time_s: sample.time_s,
        current_a: [0, 1].map(|axis| value(motor_valid::current(axis), sample.current_a[axis])),
        voltage_v: [0, 1].map(|axis| value(motor_valid::voltage(axis), sample.voltage_v[axis])),
        motor_speed_rad_s: value(motor_valid::MOTOR_SPEED, sample.motor_speed_rad_s),
        roller_speed_rad_s: value(motor_valid::ROLLER_SPEED, sample.roller_speed_rad_s),
        generator_current_a: value(motor_valid::GENERATOR_CURRENT, sample.generator_current_a),
    }
}

/// A sample of a driven rig as that of a wagon with one wheelset, for the indicators: speed at the rim of the roller,
/// a brake that never presses, and the drive torque that carries the adhesion of the last estimate.
#[must_use]
pub fn as_wagon(
    sample: &MotorSample,
    vehicle: &VehicleParameters,
    rig: &railgrip_filter::TractionRigFile,
    last: &EstimatorOutput,
) -> Sample {
    let drive = &rig.drivetrain;
    let mut wagon = Sample {
        sequence: sample.sequence,
        acquired: sample.acquired,
        time_s: sample.time_s,
        v_m_s: sample.roller_speed_rad_s * drive.roller_radius_m,
        flags: sample.flags,
        wheelsets: 1,
        valid: valid::pressing_force(0) | valid::drive_torque(0),
        ..Sample::default()
    };
    wagon.wheel_speed_rad_s[0] = sample.motor_speed_rad_s / drive.gear_ratio;
    wagon.drive_torque_nm[0] = 2.0 * last.mu_w * drive.normal_load_n * vehicle.wheelset.radius_m;
    if sample.has(motor_valid::ROLLER_SPEED) {
        wagon.valid |= valid::SPEED;
    }
    if sample.has(motor_valid::MOTOR_SPEED) {
        wagon.valid |= valid::wheel_speed(0);
    }
    wagon
}

/// A sample of a bogie rig as the filter takes it.
#[must_use]
pub fn bogie_sample(sample: &BogieSample) -> railgrip_filter::BogieSample {
    let value = |bit: u32, value: f64| if sample.has(bit) { value } else { f64::NAN };
    railgrip_filter::BogieSample {
        time_s: sample.time_s,
        shaft_torque_nm: value(bogie_valid::SHAFT_TORQUE, sample.shaft_torque_nm),
        load_cell_n: value(bogie_valid::LOAD_CELL, sample.load_cell_n),
        brake_pressure_pa: value(bogie_valid::BRAKE_PRESSURE, sample.brake_pressure_pa),
        load_n: value(bogie_valid::LOAD, sample.load_n),
        roller_pulses: value(bogie_valid::ROLLER_PULSES, sample.roller_pulses),
        wheel_pulses: [0, 1].map(|i| value(bogie_valid::wheel_pulses(i), sample.wheel_pulses[i])),
    }
}

/// A sample of a bogie rig as that of a wagon, for the indicators: the speeds are those of the last estimate, because the
/// rig has pulses only, and the pressing forces follow from the pressure.
#[must_use]
pub fn bogie_as_wagon(sample: &BogieSample, rig: &BogieRigFile, last: &EstimatorOutput) -> Sample {
    let brake = rig.parameters().brake;
    let pressing_n =
        sample.brake_pressure_pa.max(0.0) * brake.torque_per_pressure_nm_pa() / brake.friction_radius_m;
    let wheelsets = rig.roller.wheelset_load_n.len();
    let mut wagon = Sample {
        sequence: sample.sequence,
        acquired: sample.acquired,
        time_s: sample.time_s,
        v_m_s: last.v_m_s,
        flags: sample.flags,
        wheelsets: wheelsets as u32,
        ..Sample::default()
    };
    let moves = last.state.tells_slip();
    if moves || last.state == railgrip_filter::EstimateState::Standstill {
        wagon.valid |= valid::SPEED;
    }
    for i in 0..wheelsets {
        wagon.wheel_speed_rad_s[i] = last.v_m_s * (1.0 + last.slip[i]) / rig.wheelset.radius_m;
        wagon.pressing_force_n[i] = pressing_n;
        wagon.valid |= valid::drive_torque(i);
        if moves && sample.has(bogie_valid::wheel_pulses(i)) {
            wagon.valid |= valid::wheel_speed(i);
        }
        if sample.has(bogie_valid::BRAKE_PRESSURE) {
            wagon.valid |= valid::pressing_force(i);
        }
    }
    wagon
}

/// What the filter says, as it travels; whoever publishes adds the time of publication.
#[must_use]
pub fn estimate(sample: &Sample, output: &EstimatorOutput) -> Estimate {
    Estimate {
        sequence: sample.sequence,
        acquired: sample.acquired,
        published_monotonic_ns: 0,
        time_s: output.time_s,
        v_m_s: output.v_m_s,
        mu_w: output.mu_w,
        mu_w_sigma: output.mu_w_sigma,
        mu_w_wheelset: output.mu_w_wheelset,
        mu_w_wheelset_sigma: output.mu_w_wheelset_sigma,
        mu_b: output.mu_b,
        mu_b_sigma: output.mu_b_sigma,
        mu_b_mean: output.mu_b_mean,
        mu_b_mean_sigma: output.mu_b_mean_sigma,
        slip: output.slip,
        normal_load_n: output.normal_load_n,
        pressing_force_n: output.pressing_force_n,
        adhesion_peak: output.adhesion_peak,
        adhesion_peak_sigma: output.adhesion_peak_sigma,
        nis: output.nis,
        nis_dof: output.nis_dof,
        observable: output.observable,
        sliding: output.sliding,
        wsp_active: output.wsp_active,
        rejected: output.rejected,
        observability_rank: output.observability_rank,
        flags: output.flags,
        wheelsets: output.wheelsets,
        state: output.state.code(),
        reserved: 0,
    }
}

/// What came beside what the filter expected, as it travels.
#[must_use]
pub fn innovation(sample: &Sample, output: &EstimatorOutput) -> Innovation {
    Innovation {
        sequence: sample.sequence,
        time_s: output.time_s,
        innovation: output.innovations.innovation,
        innovation_variance: output.innovations.innovation_variance,
        test_ratio: output.innovations.test_ratio,
        rejected: output.innovations.rejected,
        fused: output.innovations.fused,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clear_bit_is_not_a_number() {
        let valid = valid::SPEED | valid::wheel_speed(1);
        let mut sample = Sample { time_s: 2.0, v_m_s: 20.0, valid, wheelsets: 2, ..Sample::default() };
        sample.wheel_speed_rad_s = [45.0, 46.0, 47.0, 48.0];
        let input = wagon_sample(&sample);
        assert_eq!((input.time_s, input.v_m_s, input.wheel_speed_rad_s[1]), (2.0, 20.0, 46.0));
        assert!(input.wheel_speed_rad_s[0].is_nan() && input.wheel_speed_rad_s[2].is_nan());
        assert!(input.grade_rad.is_nan() && input.pressing_force_n[0].is_nan());
    }

    #[test]
    fn states_mean_the_same_on_both_sides() {
        let ours = railgrip_filter::EstimateState::ALL.iter().map(|state| (state.code(), state.name()));
        let theirs = railgrip_messages::EstimateState::ALL.iter().map(|state| (state.code(), state.word()));
        assert!(ours.eq(theirs));
    }

    #[test]
    fn a_missing_current_is_not_a_number() {
        let valid = motor_valid::current(1) | motor_valid::MOTOR_SPEED;
        let sample =
            MotorSample { valid, current_a: [1.0, 2.0], motor_speed_rad_s: 20.0, ..MotorSample::default() };
        let motor = traction_sample(&sample);
        assert!(motor.current_a[0].is_nan() && motor.current_a[1] == 2.0 && motor.motor_speed_rad_s == 20.0);
        assert!(motor.generator_current_a.is_nan());
    }

    #[test]
    fn a_window_that_goes_on_is_not_a_number() {
        let valid = bogie_valid::LOAD_CELL | bogie_valid::wheel_pulses(1);
        let sample =
            BogieSample { valid, load_cell_n: 1e3, wheel_pulses: [4.0, 5.0], ..BogieSample::default() };
        let bogie = bogie_sample(&sample);
        assert!(
            bogie.roller_pulses.is_nan() && bogie.shaft_torque_nm.is_nan() && bogie.wheel_pulses[0].is_nan()
        );
        assert_eq!((bogie.load_cell_n, bogie.wheel_pulses[1]), (1e3, 5.0));
    }

    #[test]
    fn gravity_is_the_same_on_both_sides() {
        assert_eq!(railgrip_messages::GRAVITY_M_S2, railgrip_vehicle::GRAVITY_M_S2);
    }

    #[test]
    fn flags_mean_the_same_on_both_sides() {
        use railgrip_filter::flags as filter;
        use railgrip_messages::flags as message;
        assert_eq!(
            [
                filter::HELD,
                filter::PREDICTED,
                filter::RESTARTED,
                filter::GAP,
                filter::RESUMED,
                filter::CONVERGING
            ],
            [
                message::HELD,
                message::PREDICTED,
                message::RESTARTED,
                message::GAP,
                message::RESUMED,
                message::CONVERGING
            ]
        );
    }
}
