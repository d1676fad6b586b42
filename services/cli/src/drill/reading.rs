//! What a wagon measured, as the watch over a train takes it.

/// The reading of a row, be it of a recording or of the plant: both name their fields as the columns are named.
macro_rules! reading {
    ($row:expr) => {{
        let row = $row;
        railgrip_causes::Reading {
            v_m_s: row.v_m_s,
            wheel_speed_rad_s: row.wheel_speed_rad_s,
            pressing_force_n: row.pressing_force_n,
            drive_torque_nm: row.drive_torque_nm,
            grade_rad: row.grade_rad,
            load_kg: row.load_kg,
            brake_demand: row.brake_demand,
        }
    }};
}
pub(super) use reading;
