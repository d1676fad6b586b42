//! What a vehicle file says: the constants of the nominal model and of the sensors.

use crate::{GRAVITY_M_S2, MAX_WHEELSETS};
use serde::{Deserialize, Serialize};

/// A vehicle as its file describes it (`vehicle.toml`, schema 1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleParameters {
    /// Layout of the file; only 1 is known.
    pub schema: u32,
    /// Name for people.
    pub name: String,
    /// Car body.
    pub body: Body,
    /// `[bogie]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bogie: Option<Bogie>,
    /// Wheelset, the same for all.
    pub wheelset: Wheelset,
    /// Brake unit of one wheelset.
    pub brake: Brake,
    /// Running resistance.
    pub resistance: Resistance,
    /// Wheel–rail contact of one wheelset.
    pub contact: Contact,
    /// Adhesion available by rail class.
    pub rail: Rail,
    /// Declared accuracy of the sensors.
    pub sensors: Sensors,
    /// `[train]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub train: Option<Running>,
    /// Effects that the model carries beyond the nominal laws, applied in this order.
    #[serde(default, rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectEntry>,
}

/// Car body and load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Total mass m with wheelsets, kg.
    pub mass_kg: f64,
    /// Height of the centre of mass above the rail h, m.
    pub com_height_m: f64,
    /// Distance a between first and last wheelset, m.
    pub wheelbase_m: f64,
    /// Positions of the wheelsets ahead of the centre of mass, front first, m. Absent: two wheelsets at ± a/2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheelset_positions_m: Option<Vec<f64>>,
    /// Relative one sigma of the mass; wide where payload is not known. Absent: the mass is as a works plate has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_sigma: Option<f64>,
}

/// The bogies of a wagon that has them; `body.wheelbase_m` is then the distance of their pivots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bogie {
    /// Distance of the wheelsets of one bogie, m.
    pub wheelbase_m: f64,
    /// Height of the traction pivot above the rail, m.
    pub pivot_height_m: f64,
}

/// How the wagon runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Running {
    /// Whether it runs alone; false: it is coupled, and couplers pull and push it.
    pub free: bool,
}

/// One wheelset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wheelset {
    /// Rolling radius r_W, m.
    pub radius_m: f64,
    /// Moment of inertia J about the axle with everything that turns with it, kg m².
    pub inertia_kg_m2: f64,
}

/// Brake unit of one wheelset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Brake {
    /// Mean friction radius r_B, m.
    pub radius_m: f64,
    /// Nominal coefficient between pad and disc, dimensionless.
    pub friction_coefficient: f64,
    /// The same of each wheelset where they are known to differ, front first. Absent: all have the one above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_by_wheelset: Option<Vec<f64>>,
}

/// Running resistance `a + b v + k_d v|v|`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resistance {
    /// a, N.
    pub constant_n: f64,
    /// b, N/(m/s).
    pub linear_n_s_per_m: f64,
    /// k_d, N/(m/s)².
    pub drag_n_s2_per_m2: f64,
}

/// Wheel–rail contact of one wheelset after Polach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Creep stiffness K = G π a b C11 / 4, N.
    pub stiffness_n: f64,
    /// Reduction factor k_A in the area of adhesion.
    pub k_a: f64,
    /// Reduction factor k_S in the area of slip.
    pub k_s: f64,
    /// Ratio A of the friction at infinite slip velocity to its maximum; 1 is no falling friction.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub friction_ratio: f64,
    /// Decay B of friction with slip velocity, s/m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub friction_decay_s_per_m: f64,
}

fn one() -> f64 {
    1.0
}

fn is_one(value: &f64) -> bool {
    *value == 1.0
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Adhesion available (μ0) by rail class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rail {
    /// Dry rail.
    pub dry: f64,
    /// Wet rail.
    pub wet: f64,
    /// Contaminated rail.
    pub low: f64,
}

/// The rail classes a recording's name can carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RailClass {
    /// Dry rail.
    Dry,
    /// Wet rail.
    Wet,
    /// Contaminated rail.
    Low,
    /// Rail of which a recording's name says nothing. What it gives is not known; the model starts from dry rail.
    #[serde(skip)]
    Undeclared,
}

impl RailClass {
    /// The classes of a vehicle file, in its order.
    pub const ALL: [Self; 3] = [Self::Dry, Self::Wet, Self::Low];
    /// All of them and what a recording may be on beside them; each stands at its own number.
    pub const OF_RECORDINGS: [Self; 4] = [Self::Dry, Self::Wet, Self::Low, Self::Undeclared];

    /// The class as it stands in a recording's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
            Self::Low => "low",
            Self::Undeclared => "undeclared",
        }
    }

    /// The class of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }
}

impl Rail {
    /// Adhesion available on rail of this class; on undeclared rail that of dry rail, for want of better.
    pub fn adhesion(&self, class: RailClass) -> f64 {
        match class {
            RailClass::Dry | RailClass::Undeclared => self.dry,
            RailClass::Wet => self.wet,
            RailClass::Low => self.low,
        }
    }
}

/// Declared one-sigma accuracy of the sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensors {
    /// Samples per second, Hz.
    pub sample_rate_hz: f64,
    /// Vehicle speed, m/s.
    pub speed_sigma_m_s: f64,
    /// Wheelset speed, rad/s.
    pub wheel_speed_sigma_rad_s: f64,
    /// Pressing force, N.
    pub pressing_force_sigma_n: f64,
}

/// An effect in a vehicle file: its id in the catalogue and its parameters by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectEntry {
    /// Id in the catalogue.
    pub id: String,
    /// Values by parameter name; the unit is in the name. Parameters left out take their default.
    #[serde(default)]
    pub parameters: std::collections::BTreeMap<String, f64>,
}

/// A parameter that makes no physical sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` is {value}, allowed is {allowed}")]
pub struct ParameterError {
    /// Dotted key in the vehicle file.
    pub key: &'static str,
    /// What stands there.
    pub value: f64,
    /// What may stand there.
    pub allowed: &'static str,
}

impl VehicleParameters {
    /// True if neighbours pull and push it: where the file does not say, it runs alone.
    #[must_use]
    pub fn is_coupled(&self) -> bool {
        self.train.is_some_and(|running| !running.free)
    }

    /// Number of wheelsets.
    pub fn wheelsets(&self) -> usize {
        self.body.wheelset_positions_m.as_ref().map_or(2, Vec::len)
    }

    /// Position of each wheelset ahead of the centre of mass, m.
    pub fn wheelset_positions_m(&self) -> [f64; MAX_WHEELSETS] {
        let mut positions = [0.0; MAX_WHEELSETS];
        match &self.body.wheelset_positions_m {
            Some(given) => positions.iter_mut().zip(given).for_each(|(slot, &x)| *slot = x),
            None => {
                positions[0] = 0.5 * self.body.wheelbase_m;
                positions[1] = -positions[0];
            }
        }
        positions
    }

    /// Normal load of each wheelset at rest, N.
    pub fn axle_load_n(&self) -> f64 {
        self.body.mass_kg * GRAVITY_M_S2 / self.wheelsets() as f64
    }

    /// Nominal pad friction of each wheelset.
    pub fn pad_friction(&self) -> [f64; MAX_WHEELSETS] {
        let mut pads = [self.brake.friction_coefficient; MAX_WHEELSETS];
        if let Some(given) = &self.brake.friction_by_wheelset {
            pads.iter_mut().zip(given).for_each(|(slot, &pad)| *slot = pad);
        }
        pads
    }

    /// Checks every value against what is physically possible.
    ///
    /// # Errors
    /// The first value out of its range, with its key.
    pub fn check(&self) -> Result<(), ParameterError> {
        let ranges: [(&'static str, f64, f64, f64, &'static str); 21] = [
            ("schema", f64::from(self.schema), 1.0, 1.0, "1"),
            ("body.mass_kg", self.body.mass_kg, 100.0, 5e5, "100 to 500000"),
            ("body.com_height_m", self.body.com_height_m, 0.0, 5.0, "0 to 5"),
            ("body.wheelbase_m", self.body.wheelbase_m, 0.5, 40.0, "0.5 to 40"),
            ("wheelset.radius_m", self.wheelset.radius_m, 0.05, 1.5, "0.05 to 1.5"),
            ("wheelset.inertia_kg_m2", self.wheelset.inertia_kg_m2, 1e-3, 1e4, "0.001 to 10000"),
            ("brake.radius_m", self.brake.radius_m, 0.01, 1.5, "0.01 to 1.5"),
            ("brake.friction_coefficient", self.brake.friction_coefficient, 0.01, 1.5, "0.01 to 1.5"),
            ("resistance.constant_n", self.resistance.constant_n, 0.0, 1e5, "0 to 100000"),
            ("resistance.linear_n_s_per_m", self.resistance.linear_n_s_per_m, 0.0, 1e4, "0 to 10000"),
            ("resistance.drag_n_s2_per_m2", self.resistance.drag_n_s2_per_m2, 0.0, 1e3, "0 to 1000"),
            ("contact.stiffness_n", self.contact.stiffness_n, 1e3, 1e9, "1e3 to 1e9"),
            ("contact.k_a", self.contact.k_a, 1e-3, 1.0, "0.001 to 1"),
            ("contact.k_s", self.contact.k_s, 1e-3, 1.0, "0.001 to 1"),
            ("contact.friction_ratio", self.contact.friction_ratio, 0.05, 1.0, "0.05 to 1"),
            ("contact.friction_decay_s_per_m", self.contact.friction_decay_s_per_m, 0.0, 10.0, "0 to 10"),
            ("rail.dry", self.rail.dry, 1e-3, 1.0, "0.001 to 1"),
            ("rail.wet", self.rail.wet, 1e-3, 1.0, "0.001 to 1"),
            ("rail.low", self.rail.low, 1e-3, 1.0, "0.001 to 1"),
            ("sensors.sample_rate_hz", self.sensors.sample_rate_hz, 1.0, 1e4, "1 to 10000"),
            ("sensors.speed_sigma_m_s", self.sensors.speed_sigma_m_s, 1e-6, 5.0, "1e-6 to 5"),
        ];
        for (key, value, low, high, allowed) in ranges {
            if !(low..=high).contains(&value) {
                return Err(ParameterError { key, value, allowed });
            }
        }
        let wheel = self.sensors.wheel_speed_sigma_rad_s;
        if !(1e-6..=20.0).contains(&wheel) {
            let key = "sensors.wheel_speed_sigma_rad_s";
            return Err(ParameterError { key, value: wheel, allowed: "1e-6 to 20" });
        }
        let force = self.sensors.pressing_force_sigma_n;
        if !(0.0..=1e5).contains(&force) {
            let key = "sensors.pressing_force_sigma_n";
            return Err(ParameterError { key, value: force, allowed: "0 to 100000" });
        }
        let bogie = self.bogie.map_or((2.0, 0.5), |bogie| (bogie.wheelbase_m, bogie.pivot_height_m));
        let optional = [
            ("body.mass_sigma", self.body.mass_sigma.unwrap_or(0.01), 1e-4, 1.0, "0.0001 to 1"),
            ("bogie.wheelbase_m", bogie.0, 0.5, 6.0, "0.5 to 6"),
            ("bogie.pivot_height_m", bogie.1, 0.0, 3.0, "0 to 3"),
        ];
        for (key, value, low, high, allowed) in optional {
            if !(low..=high).contains(&value) {
                return Err(ParameterError { key, value, allowed });
            }
        }
        self.check_pads()?;
        self.check_positions()
    }

    fn check_pads(&self) -> Result<(), ParameterError> {
        let Some(pads) = &self.brake.friction_by_wheelset else { return Ok(()) };
        let key = "brake.friction_by_wheelset";
        if pads.len() != self.wheelsets() {
            return Err(ParameterError {
                key,
                value: pads.len() as f64,
                allowed: "one value for each wheelset",
            });
        }
        match pads.iter().find(|pad| !(0.01..=1.5).contains(*pad)) {
            Some(&value) => Err(ParameterError { key, value, allowed: "0.01 to 1.5" }),
            None => Ok(()),
        }
    }

    fn check_positions(&self) -> Result<(), ParameterError> {
        let Some(positions) = &self.body.wheelset_positions_m else { return Ok(()) };
        let key = "body.wheelset_positions_m";
        if !(2..=MAX_WHEELSETS).contains(&positions.len()) {
            return Err(ParameterError { key, value: positions.len() as f64, allowed: "2 to 4 positions" });
        }
        let sum: f64 = positions.iter().sum();
        if !sum.is_finite() || sum.abs() > 1e-6 * self.body.wheelbase_m {
            return Err(ParameterError { key, value: sum, allowed: "positions whose sum is 0" });
        }
        if let Some(pair) = positions.windows(2).find(|pair| pair[0] <= pair[1]) {
            return Err(ParameterError { key, value: pair[1], allowed: "positions from front to rear" });
        }
        Ok(())
    }
}
