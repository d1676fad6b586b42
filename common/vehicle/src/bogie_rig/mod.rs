//! The 1:4 bogie roller rig of Shrestha, Spiryagin & Wu (Railway Engineering Science 29, 2021): a motor drives two
//! coupled pairs of rollers through a gear, two braked wheelsets roll on them, a link holds the bogie in place.
//!
//! ```text
//! wheelset  J_w ω̇_i = −M_b,i − r F_i
//! rollers   (J_r + i² (J_s + J_m)) ω̇_r = i T_m + R (F_1 + F_2) − loss(ω_r)
//! shaft     i T_e = J_r' ω̇_r − R (F_1 + F_2) + loss(ω_r) ,  J_r' = J_r + i² J_s
//! link      load cell = −(F_1 + F_2)
//! ```
//!
//! The rollers stand for the rail: `v = R ω_r`. Contact forces `F_i` act on the bogie, forward positive, so braking
//! makes them negative; the paper's slip λ (2) is the negative creepage. `T_e` is what the torque transducer sees: it
//! sits between motor and gear, so the motor's inertia `J_m` lies outside its balance and the rollers' inside.
//! The calipers hang on the bogie, so their reaction stays inside it and the link feels the contact forces alone.
//!
//! # What the paper leaves open or contradicts
//! * Section 2.2 couples motor and rollers directly, (3) uses a gear of 7.68: with the gear, 4.14 m/s is 1518 rpm,
//!   which is the "1500 rpm" of its Fig. 16. The gear is taken.
//! * Its voltage limit of 1.8 V ends at 1389 rpm by (1), 3.79 m/s: the tests from 4.14 m/s need 1.97 V.
//! * "Multiplied by 32,768 and added to 32,768" would leave the 16 bits from 1 V on; full scale is 10 V, so the
//!   voltage is divided by that first.
//! * (3) holds in steady state only; [`BogieRig`] keeps the inertia terms.
//!
//! # Glossary
//! * *condition* – what lies between wheel and roller: dry or wet;
//! * *law* – contact law under a condition: Polach with falling friction, (4) to (8);
//! * *pulses* – counts of an encoder in one window.

mod brake;
mod drive;
mod parameters;
mod rig;
mod sensor_parameters;
mod sensors;

pub use brake::{BrakeParameters, HydraulicBrake};
pub use drive::{
    DriveParameters, RollerDrive, dac_voltage_v, motor_speed_rpm, rad_s_from_rpm, rpm_from_rad_s, voltage_v,
};
pub use parameters::{BogieParameters, ContactLaw, RailCondition};
pub use rig::{BogieRig, BogieRigState, BogieRigStep};
pub use sensor_parameters::SensorParameters;
pub use sensors::{BogieSensors, PulseCounter};

/// Wheelsets of the bogie.
pub const BOGIE_WHEELSETS: usize = 2;
