//! What describes a wagon and acts on it: states, inputs, constants, forces.

use crate::{Bogie, Contact, MAX_WHEELSETS, PerWheelset, Resistance, VehicleParameters};

/// Most speeds of a wagon, and most outputs that it has: the vehicle's, then each wheelset's.
pub const SPEEDS: usize = 1 + MAX_WHEELSETS;

/// Motion of a wagon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WagonState {
    /// Speed of the body, m/s.
    pub v_m_s: f64,
    /// Angular speed of each wheelset, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
}

/// What acts on a wagon during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WagonInput {
    /// Time at the start of the step, s.
    pub time_s: f64,
    /// Pressing force of each wheelset's pads as inferred from cylinder pressure, N.
    pub pressing_force_n: PerWheelset,
    /// Drive torque on each wheelset, N m, forward positive.
    pub drive_torque_nm: PerWheelset,
    /// Grade, rad, uphill positive.
    pub grade_rad: f64,
    /// Sanding demand, 0 to 1.
    pub sanding: f64,
    /// Position along the track, m.
    pub position_m: f64,
    /// Adhesion available (μ0) under each wheelset.
    pub adhesion_peak: PerWheelset,
    /// Pad friction of each wheelset relative to the model's.
    pub brake_friction_factor: PerWheelset,
    /// Headwind, m/s.
    pub wind_m_s: f64,
    /// Other force on the body (couplers), N, forward positive.
    pub body_force_n: f64,
}

impl Default for WagonInput {
    fn default() -> Self {
        Self {
            time_s: 0.0,
            pressing_force_n: [0.0; MAX_WHEELSETS],
            drive_torque_nm: [0.0; MAX_WHEELSETS],
            grade_rad: 0.0,
            sanding: 0.0,
            position_m: 0.0,
            adhesion_peak: [0.3; MAX_WHEELSETS],
            brake_friction_factor: [1.0; MAX_WHEELSETS],
            wind_m_s: 0.0,
            body_force_n: 0.0,
        }
    }
}

/// Constants of the equations after all effects had their say.
#[derive(Clone, Debug)]
pub struct Constants {
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Height of the centre of mass h that load transfer sees, m.
    pub com_height_m: f64,
    /// Positions of wheelsets ahead of the centre of mass, m.
    pub wheelset_positions_m: PerWheelset,
    /// Bogies, of a wagon with four wheelsets that has them.
    pub bogie: Option<Bogie>,
    /// Load of every wheelset where it does not follow from the mass (on a rig), N.
    pub fixed_load_n: Option<f64>,
    /// Moment of inertia of each wheelset, kg m².
    pub inertia_kg_m2: PerWheelset,
    /// Rolling radius of each wheelset, m.
    pub wheel_radius_m: PerWheelset,
    /// Friction radius r_B, m.
    pub brake_radius_m: f64,
    /// Pad friction level of each wheelset.
    pub brake_friction: PerWheelset,
    /// Running resistance.
    pub resistance: Resistance,
    /// Contact law.
    pub contact: Contact,
}

impl Constants {
    /// The constants of a vehicle file, before effects.
    pub fn of(parameters: &VehicleParameters) -> Self {
        Self {
            wheelsets: parameters.wheelsets(),
            mass_kg: parameters.body.mass_kg,
            com_height_m: parameters.body.com_height_m,
            wheelset_positions_m: parameters.wheelset_positions_m(),
            bogie: parameters.bogie.filter(|_| parameters.wheelsets() == 4),
            fixed_load_n: None,
            inertia_kg_m2: [parameters.wheelset.inertia_kg_m2; MAX_WHEELSETS],
            wheel_radius_m: [parameters.wheelset.radius_m; MAX_WHEELSETS],
            brake_radius_m: parameters.brake.radius_m,
            brake_friction: parameters.pad_friction(),
            resistance: parameters.resistance.clone(),
            contact: parameters.contact.clone(),
        }
    }
}

/// Forces and torques on a wagon at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forces {
    /// Contact force of each wheelset on the wagon, N.
    pub contact_n: PerWheelset,
    /// Normal load of each wheelset, N.
    pub load_n: PerWheelset,
    /// Torque of each brake as it acts, N m, signed (negative against forward rotation).
    pub brake_torque_nm: PerWheelset,
    /// Running resistance, N, positive against forward motion.
    pub resistance_n: f64,
    /// Grade, couplers and effects, N, forward positive.
    pub other_n: f64,
    /// Acceleration of the body, m/s².
    pub acceleration_m_s2: f64,
    /// Angular acceleration of each wheelset, rad/s².
    pub wheel_acceleration_rad_s2: PerWheelset,
}

impl Forces {
    /// Adhesion utilised by `wheelset`, signed like its contact force.
    pub fn adhesion_utilised(&self, wheelset: usize) -> f64 {
        if self.load_n[wheelset] > 0.0 { self.contact_n[wheelset] / self.load_n[wheelset] } else { 0.0 }
    }

    /// Adhesion utilised by the whole wagon, `Σ F_x / Σ F_z`, signed.
    pub fn wagon_adhesion_utilised(&self) -> f64 {
        self.contact_n.iter().sum::<f64>() / self.load_n.iter().sum::<f64>()
    }
}

/// What the laws of actuation, pad friction and rail give for one step; constant over the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loading {
    /// Force that arrives at the pads of each wheelset, N.
    pub pad_force_n: PerWheelset,
    /// Pad friction of each wheelset.
    pub brake_friction: PerWheelset,
    /// Torque that each brake can hold, N m, never negative.
    pub brake_torque_nm: PerWheelset,
    /// Drive torque, N m.
    pub drive_torque_nm: PerWheelset,
    /// Adhesion available under each wheelset.
    pub adhesion_peak: PerWheelset,
    /// Grade, couplers and effects, N, forward positive.
    pub other_n: f64,
    /// Headwind, m/s.
    pub wind_m_s: f64,
}
