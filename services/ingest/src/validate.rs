//! From a row of numbers to a sample: what is not a finite value in its physical range is missing.

use railgrip_messages::{BogieSample, MAX_WHEELSETS, MotorSample, Sample, valid};
use railgrip_recording::{BogieRow, MotorRow, Quantity, RIG_VALUES, RigRow, Row};

/// The sample of a row, without sequence and stamp, and how many values were refused because they are out of range.
/// `None` if the row has no time.
#[must_use]
pub fn sample(row: &Row, wheelsets: usize) -> (Option<Sample>, u32) {
    if !row.t_s.is_finite() {
        return (None, 1);
    }
    let wheelsets = wheelsets.min(MAX_WHEELSETS);
    let mut sample = Sample { time_s: row.t_s, wheelsets: wheelsets as u32, ..Sample::default() };
    let mut refused = 0;
    let mut take = |quantity: Quantity, wheelset: usize, bit: u32| {
        let value = row.get(quantity, wheelset);
        if quantity.allowed().contains(&value) {
            sample.valid |= bit;
            return value;
        }
        refused += u32::from(!value.is_nan());
        0.0
    };
    let v_m_s = take(Quantity::Speed, 0, valid::SPEED);
    let grade_rad = take(Quantity::Grade, 0, valid::GRADE);
    let sanding = take(Quantity::Sanding, 0, valid::SANDING);
    let position_m = take(Quantity::Position, 0, valid::POSITION);
    let load_kg = take(Quantity::Load, 0, valid::LOAD);
    let brake_demand = take(Quantity::BrakeDemand, 0, valid::BRAKE_DEMAND);
    let mut wheel_speed_rad_s = [0.0; MAX_WHEELSETS];
    let mut pressing_force_n = [0.0; MAX_WHEELSETS];
    let mut drive_torque_nm = [0.0; MAX_WHEELSETS];
    let mut wsp_active = 0;
    for wheelset in 0..wheelsets {
        wheel_speed_rad_s[wheelset] = take(Quantity::WheelSpeed, wheelset, valid::wheel_speed(wheelset));
        pressing_force_n[wheelset] = take(Quantity::PressingForce, wheelset, valid::pressing_force(wheelset));
        drive_torque_nm[wheelset] = take(Quantity::DriveTorque, wheelset, valid::drive_torque(wheelset));
        wsp_active |= u32::from(take(Quantity::WspActive, wheelset, valid::WSP) > 0.5) << wheelset;
    }
    sample.v_m_s = v_m_s;
    sample.grade_rad = grade_rad;
    sample.sanding = sanding;
    sample.position_m = position_m;
    (sample.load_kg, sample.brake_demand) = (load_kg, brake_demand);
    sample.wheel_speed_rad_s = wheel_speed_rad_s;
    sample.pressing_force_n = pressing_force_n;
    sample.drive_torque_nm = drive_torque_nm;
    sample.wsp_active = wsp_active;
    (Some(sample), refused)
}

/// Values of a row that no sensor can give; its time does not count, and what is missing is no value.
#[must_use]
pub fn impossible(row: &Row, wheelsets: usize) -> u64 {
    let values = Quantity::ALL.into_iter().filter(|quantity| *quantity != Quantity::Time);
    let wrong = values.flat_map(|quantity| {
        let places = if quantity.per_wheelset() { wheelsets.min(MAX_WHEELSETS) } else { 1 };
        (0..places).map(move |wheelset| (quantity, row.get(quantity, wheelset)))
    });
    wrong.filter(|(quantity, value)| !value.is_nan() && !quantity.allowed().contains(value)).count() as u64
}

/// The sample of a row of a driven rig, likewise.
#[must_use]
pub fn motor_sample(row: &MotorRow) -> (Option<MotorSample>, u32) {
    if !row.t_s.is_finite() {
        return (None, 1);
    }
    let (clean, valid, refused) = plausible(row);
    let mut sample = MotorSample { time_s: row.t_s, valid, ..MotorSample::default() };
    sample.current_a = [clean[0], clean[1]];
    sample.voltage_v = [clean[2], clean[3]];
    sample.motor_speed_rad_s = clean[4];
    sample.roller_speed_rad_s = clean[5];
    sample.generator_current_a = clean[6];
    (Some(sample), refused)
}

/// The sample of a row of a bogie rig, likewise.
#[must_use]
pub fn bogie_sample(row: &BogieRow) -> (Option<BogieSample>, u32) {
    if !row.t_s.is_finite() {
        return (None, 1);
    }
    let (clean, valid, refused) = plausible(row);
    let sample = BogieSample {
        time_s: row.t_s,
        shaft_torque_nm: clean[0],
        load_cell_n: clean[1],
        brake_pressure_pa: clean[2],
        load_n: clean[3],
        roller_pulses: clean[4],
        wheel_pulses: [clean[5], clean[6]],
        valid,
        ..BogieSample::default()
    };
    (Some(sample), refused)
}

/// The plausible values of a rig's row with 0 for the others, their bits, which stand in the order of the values, and
/// how many were refused.
fn plausible<R: RigRow>(row: &R) -> ([f64; RIG_VALUES], u32, u32) {
    let (values, mut valid, mut refused) = (row.values(), 0, 0);
    let clean = std::array::from_fn(|index| {
        if row.is_plausible(index) {
            valid |= 1 << index;
            return values[index];
        }
        refused += u32::from(!values[index].is_nan());
        0.0
    });
    (clean, valid, refused)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Row {
        let mut row = Row { t_s: 1.5, v_m_s: 20.0, grade_rad: 0.001, ..Row::default() };
        row.wheel_speed_rad_s[..2].copy_from_slice(&[45.0, 45.1]);
        row.pressing_force_n[..2].copy_from_slice(&[20e3, 0.0]);
        row.drive_torque_nm[..2].copy_from_slice(&[0.0, 0.0]);
        row.wsp_active[..2].copy_from_slice(&[0.0, 1.0]);
        row
    }

    #[test]
    fn present_values_have_their_bits_and_absent_ones_do_not() {
        let (found, refused) = sample(&row(), 2);
        let sample = found.unwrap();
        assert_eq!((refused, sample.wheelsets, sample.wsp_active, sample.time_s), (0, 2, 0b10, 1.5));
        assert!(sample.has(valid::SPEED | valid::GRADE | valid::WSP | valid::wheel_speed(1)));
        assert!(
            !sample.has(valid::POSITION) && !sample.has(valid::SANDING) && !sample.has(valid::wheel_speed(2))
        );
        assert_eq!(sample.position_m, 0.0);
    }

    #[test]
    fn nonsense_is_missing_and_counted_and_a_gap_is_only_missing() {
        let mut wrong = row();
        wrong.v_m_s = 1e9;
        wrong.wheel_speed_rad_s[0] = f64::INFINITY;
        wrong.pressing_force_n[1] = f64::NAN;
        let (found, refused) = sample(&wrong, 2);
        let sample = found.unwrap();
        assert_eq!((refused, impossible(&wrong, 2)), (2, 2));
        assert!(!sample.has(valid::SPEED) && !sample.has(valid::wheel_speed(0)));
        assert!(!sample.has(valid::pressing_force(1)) && sample.has(valid::pressing_force(0)));
        assert_eq!((sample.v_m_s, sample.wheel_speed_rad_s[0]), (0.0, 0.0));
    }

    #[test]
    fn a_motors_missing_and_impossible_values_have_no_bit() {
        let row = MotorRow {
            t_s: 1.0,
            current_a: [1.0, f64::NAN],
            voltage_v: [1e9, 4.0],
            motor_speed_rad_s: 20.0,
            roller_speed_rad_s: 3.3,
            generator_current_a: 0.0,
        };
        let (found, refused) = motor_sample(&row);
        let sample = found.unwrap();
        assert_eq!((refused, sample.current_a, sample.voltage_v), (1, [1.0, 0.0], [0.0, 4.0]));
        use railgrip_messages::motor_valid as bits;
        let expected = bits::current(0)
            | bits::voltage(1)
            | bits::MOTOR_SPEED
            | bits::ROLLER_SPEED
            | bits::GENERATOR_CURRENT;
        assert_eq!(sample.valid, expected);
    }

    #[test]
    fn a_bogies_bits_stand_for_what_is_there() {
        let row = BogieRow {
            t_s: 1.0,
            shaft_torque_nm: 40.0,
            load_cell_n: 1e9,
            brake_pressure_pa: 8e5,
            load_n: f64::NAN,
            roller_pulses: f64::NAN,
            wheel_pulses: [40.0, 41.0],
        };
        use railgrip_messages::bogie_valid as bits;
        let (found, refused) = bogie_sample(&row);
        let sample = found.unwrap();
        let expected =
            bits::SHAFT_TORQUE | bits::BRAKE_PRESSURE | bits::wheel_pulses(0) | bits::wheel_pulses(1);
        assert_eq!((refused, sample.valid, sample.load_cell_n), (1, expected, 0.0));
        assert_eq!((sample.shaft_torque_nm, sample.wheel_pulses), (40.0, [40.0, 41.0]));
    }

    #[test]
    fn a_row_without_time_is_refused() {
        assert_eq!(sample(&Row { t_s: f64::NAN, ..row() }, 2), (None, 1));
    }
}
