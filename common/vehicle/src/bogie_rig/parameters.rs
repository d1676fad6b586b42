//! Constants of the rig. The paper gives radii, gear, encoder, voltage law and brake sizes; the rest is chosen, each
//! with its reason.

use super::{BOGIE_WHEELSETS, BrakeParameters, DriveParameters, SensorParameters};
use crate::adhesion::{ContactForce, creep_force_at};
use crate::{Contact, GRAVITY_M_S2};

/// Speed that creepage is referred to at least, m/s.
const SPEED_FLOOR_M_S: f64 = 0.05;

/// What lies between wheel and roller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RailCondition {
    /// Dry.
    #[default]
    Dry,
    /// Wet.
    Wet,
}

impl RailCondition {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Dry, Self::Wet];

    /// Name for people and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
        }
    }
}

/// Contact law of one wheelset, (4) to (8) of the paper.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLaw {
    /// Stiffness, reduction factors and falling friction.
    pub contact: Contact,
    /// μ0: friction at zero slip velocity.
    pub friction_at_rest: f64,
}

impl ContactLaw {
    /// The law under a condition.
    ///
    /// The paper's Table 2 is not in its text. Its measured curves fix what it says: dry peaks of 0.45, 0.40 and 0.35
    /// at 0.69, 1.388 and 4.14 m/s, that at 1.388 m/s at slip 0.08 (Figs. 13, 16); wet, half of it at slip 0.15 (Fig. 15).
    ///
    /// * μ0 = 0.55 dry, A = 0.4: Polach, Wear 258 (2005), Table 1.
    /// * B = 2.4 and 0.8 s/m: Polach's 0.6 and 0.2 s/m times four, because the rig's slip velocities are a quarter of
    ///   those of the vehicle at the same creepage.
    /// * Stiffness G π a b C11 / 4 of two wheels: Hertz for 2.03 kN on R = 0.1 and 0.2 m with a lateral radius of 75 mm
    ///   (a quarter of the rail head's 300 mm): a ≈ b ≈ 0.98 mm, C11 = 4.2 after Kalker.
    /// * Identified from the curves, as the paper did with its own: k_S (k_A = 2.5 k_S as in Polach's dry set) and
    ///   the wet μ0.
    pub fn of(condition: RailCondition) -> Self {
        let stiffness_n = 2.0 * 2.6e5;
        let (friction_at_rest, friction_decay_s_per_m, k_s) = match condition {
            RailCondition::Dry => (0.55, 2.4, 0.13),
            RailCondition::Wet => (0.241, 0.8, 0.051),
        };
        let contact =
            Contact { stiffness_n, k_a: 2.5 * k_s, k_s, friction_ratio: 0.4, friction_decay_s_per_m };
        Self { contact, friction_at_rest }
    }

    /// A law between dry (0) and wet (1).
    pub fn blend(wetness: f64) -> Self {
        let (dry, wet) = (Self::of(RailCondition::Dry), Self::of(RailCondition::Wet));
        let mix = |dry: f64, wet: f64| dry + wetness * (wet - dry);
        Self {
            contact: Contact {
                stiffness_n: mix(dry.contact.stiffness_n, wet.contact.stiffness_n),
                k_a: mix(dry.contact.k_a, wet.contact.k_a),
                k_s: mix(dry.contact.k_s, wet.contact.k_s),
                friction_ratio: mix(dry.contact.friction_ratio, wet.contact.friction_ratio),
                friction_decay_s_per_m: mix(
                    dry.contact.friction_decay_s_per_m,
                    wet.contact.friction_decay_s_per_m,
                ),
            },
            friction_at_rest: mix(dry.friction_at_rest, wet.friction_at_rest),
        }
    }

    /// Contact force on the bogie at a slip velocity r ω − v, N, and its slope.
    #[inline]
    pub fn force(&self, slip_velocity_m_s: f64, v_m_s: f64, load_n: f64, level: f64) -> ContactForce {
        let reference = v_m_s.max(SPEED_FLOOR_M_S);
        creep_force_at(&self.contact, slip_velocity_m_s, reference, load_n, level * self.friction_at_rest)
    }

    /// Adhesion utilised at the paper's slip λ and roller speed v: μ(λ), positive in braking.
    #[inline]
    pub fn adhesion(&self, slip: f64, v_m_s: f64, load_n: f64) -> f64 {
        let v = v_m_s.max(SPEED_FLOOR_M_S);
        -self.force(-slip * v, v, load_n, 1.0).force_n / load_n
    }
}

/// The whole rig. [`Default`] is the paper's.
#[derive(Clone, Debug, PartialEq)]
pub struct BogieParameters {
    /// r, m.
    pub wheel_radius_m: f64,
    /// R, m.
    pub roller_radius_m: f64,
    /// i: motor speed over roller speed.
    pub gear_ratio: f64,
    /// Normal load of each wheelset, N.
    pub wheelset_load_n: [f64; BOGIE_WHEELSETS],
    /// J_w, kg m².
    pub wheelset_inertia_kg_m2: f64,
    /// J_r: both pairs of rollers with shafts and belt, at the roller shaft, kg m².
    pub roller_inertia_kg_m2: f64,
    /// J_s: what turns with the motor beyond the transducer (coupling half, gear input), kg m².
    pub shaft_inertia_kg_m2: f64,
    /// J_m, kg m².
    pub motor_inertia_kg_m2: f64,
    /// Loss of bearings and belt at the roller shaft, N m.
    pub loss_nm: f64,
    /// Its growth with roller speed, N m s/rad.
    pub loss_nm_s: f64,
    /// Drive.
    pub drive: DriveParameters,
    /// Brakes.
    pub brake: BrakeParameters,
    /// Sensors.
    pub sensors: SensorParameters,
}

impl Default for BogieParameters {
    /// From the paper: wheel and roller diameters 200 and 400 mm, gear 7.68. Chosen:
    ///
    /// * Load: 26.5 t axle load at 1:4 with masses as the cube of length, 414 kg a wheelset. It fits the paper's
    ///   sensors: at adhesion 0.4 the link carries 331 kg of its 500 kg, the shaft 85 N m of its 100 N m.
    /// * Inertias: four steel rollers of 400 mm, 60 mm wide, with shafts; wheelset of 200 mm wheels and two discs (a
    ///   full-size wheelset's 100 kg m² over 4⁵ gives the same); motor of 7.5 kW, four poles.
    /// * Loss: 1 % of adhesion, typical of bearings and a timing belt of that load.
    fn default() -> Self {
        let load_n = 26.5e3 / 64.0 * GRAVITY_M_S2;
        Self {
            wheel_radius_m: 0.1,
            roller_radius_m: 0.2,
            gear_ratio: 7.68,
            wheelset_load_n: [load_n; BOGIE_WHEELSETS],
            wheelset_inertia_kg_m2: 0.1,
            roller_inertia_kg_m2: 5.0,
            shaft_inertia_kg_m2: 0.005,
            motor_inertia_kg_m2: 0.04,
            loss_nm: 6.0,
            loss_nm_s: 0.5,
            drive: DriveParameters::default(),
            brake: BrakeParameters::default(),
            sensors: SensorParameters::default(),
        }
    }
}

impl BogieParameters {
    /// Normal load of the bogie N, N.
    pub fn load_n(&self) -> f64 {
        self.wheelset_load_n.iter().sum()
    }

    /// J_r' = J_r + i² J_s: what the transducer's torque accelerates, at the roller shaft, kg m².
    pub fn inertia_beyond_transducer_kg_m2(&self) -> f64 {
        self.roller_inertia_kg_m2 + self.gear_ratio * self.gear_ratio * self.shaft_inertia_kg_m2
    }

    /// What the motor's torque accelerates, at the roller shaft, kg m².
    pub fn inertia_beyond_motor_kg_m2(&self) -> f64 {
        self.inertia_beyond_transducer_kg_m2() + self.gear_ratio * self.gear_ratio * self.motor_inertia_kg_m2
    }

    /// Loss at a roller speed, N m; it fades out at standstill.
    pub fn loss_at_nm(&self, roller_speed_rad_s: f64) -> f64 {
        self.loss_nm * (roller_speed_rad_s / 0.05).tanh() + self.loss_nm_s * roller_speed_rad_s
    }

    /// Roller speed for a speed of its rim, rad/s.
    pub fn roller_speed_rad_s(&self, v_m_s: f64) -> f64 {
        v_m_s / self.roller_radius_m
    }

    /// Speed of the motor for a speed of the rollers' rim, rpm.
    pub fn motor_speed_rpm_at(&self, v_m_s: f64) -> f64 {
        super::rpm_from_rad_s(self.gear_ratio * self.roller_speed_rad_s(v_m_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peak(condition: RailCondition, v_m_s: f64) -> (f64, f64) {
        let law = ContactLaw::of(condition);
        let load_n = BogieParameters::default().wheelset_load_n[0];
        (1..6000)
            .map(|k| f64::from(k) * 1e-4)
            .map(|slip| (slip, law.adhesion(slip, v_m_s, load_n)))
            .fold((0.0, 0.0), |best, at| if at.1 > best.1 { at } else { best })
    }

    #[test]
    fn laws_have_the_papers_peaks() {
        let table = [
            (RailCondition::Dry, 0.69, 0.45, 0.012, None),
            (RailCondition::Dry, 1.388, 0.40, 0.015, Some((0.08, 0.008))),
            (RailCondition::Dry, 4.14, 0.35, 0.012, None),
            (RailCondition::Wet, 1.388, 0.20, 0.005, Some((0.15, 0.015))),
        ];
        for (condition, v_m_s, wanted, scatter, at) in table {
            let (slip, adhesion) = peak(condition, v_m_s);
            println!(
                "{} {v_m_s} m/s: {adhesion:.4} at slip {slip:.4}, paper {wanted} {at:?}",
                condition.name()
            );
            assert!((adhesion - wanted).abs() < scatter);
            assert!(at.is_none_or(|(paper, scatter)| (slip - paper).abs() < scatter));
        }
    }

    #[test]
    fn a_blend_ends_at_both_laws() {
        assert_eq!(ContactLaw::blend(0.0), ContactLaw::of(RailCondition::Dry));
        let (near, wet) = (ContactLaw::blend(1.0), ContactLaw::of(RailCondition::Wet));
        assert!((near.friction_at_rest - wet.friction_at_rest).abs() < 1e-12);
        assert!((near.contact.k_s - wet.contact.k_s).abs() < 1e-12);
    }
}
