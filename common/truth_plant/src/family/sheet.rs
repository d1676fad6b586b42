//! The data sheet of a vehicle of the family: what a simulator would believe about it (`vehicle.toml`).

use std::fmt::Write as _;

use super::units::PerWheelset;
use crate::{
    random::Stream,
    sheet::{GRAVITY_M_S2, Rail},
};

/// The believed vehicle, in the units of `vehicle.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilySheet {
    /// Class of vehicle that it was drawn from.
    pub class: &'static str,
    /// Body and everything on it, kg.
    pub mass_kg: f64,
    /// One sigma of the relative error of the mass.
    pub mass_sigma: f64,
    /// Height of the centre of mass above the rail, m.
    pub com_height_m: f64,
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Place of each wheelset ahead of the middle, m.
    pub positions_m: PerWheelset,
    /// Wheelbase of a bogie and height of its pivot, m; two wheelsets have none.
    pub bogie_m: Option<(f64, f64)>,
    /// Rolling radius, m.
    pub radius_m: f64,
    /// Rotating inertia of one wheelset, kg m².
    pub inertia_kg_m2: f64,
    /// Effective radius of the brake discs, m.
    pub brake_radius_m: f64,
    /// Pad friction coefficient.
    pub pad_friction: f64,
    /// Constant, linear and quadratic running resistance (N, N s/m, N s²/m²).
    pub resistance: [f64; 3],
    /// Contact stiffness, N.
    pub stiffness_n: f64,
    /// Peak adhesion on dry, wet and low rail.
    pub rail: [f64; 3],
    /// Samples a second.
    pub rate_hz: f64,
    /// One sigma of the speed sensor, m/s.
    pub speed_sigma_m_s: f64,
    /// One sigma of the wheel-speed sensors, rad/s.
    pub wheel_speed_sigma_rad_s: f64,
    /// One sigma of the inferred pressing force, N.
    pub pressing_force_sigma_n: f64,
    /// Whether position is recorded.
    pub has_position: bool,
    /// Whether the state of the sanders is recorded; it is where there are sanders. Not part of the file.
    pub sander: bool,
    /// Largest drive torque of one wheelset, N m; zero for a trailer. Not part of the file.
    pub drive_nm: f64,
    /// Full-brake retardation over gravity that the brake is dimensioned for. Not part of the file.
    pub full_brake_ratio: f64,
    /// Usual top speed, m/s. Not part of the file.
    pub top_speed_m_s: f64,
}

/// Ranges of one class of vehicle.
struct Class {
    name: &'static str,
    wheelsets: usize,
    mass_kg: (f64, f64),
    radius_m: (f64, f64),
    inertia_kg_m2: (f64, f64),
    length_m: (f64, f64),
    bogie_m: (f64, f64),
    com_height_m: (f64, f64),
    drag: (f64, f64),
    drive_ratio: f64,
    full_brake_ratio: (f64, f64),
    top_speed_m_s: (f64, f64),
}

const PLAIN: Class = Class {
    name: "",
    wheelsets: 2,
    mass_kg: (0.0, 0.0),
    radius_m: (0.42, 0.46),
    inertia_kg_m2: (80.0, 130.0),
    length_m: (7.0, 10.0),
    bogie_m: (1.8, 2.6),
    com_height_m: (1.3, 1.7),
    drag: (3.0, 5.0),
    drive_ratio: 0.0,
    full_brake_ratio: (0.085, 0.112),
    top_speed_m_s: (24.0, 38.0),
};

const CLASSES: [Class; 8] = [
    Class {
        name: "rail_bus",
        mass_kg: (12e3, 22e3),
        length_m: (5.5, 8.0),
        com_height_m: (1.1, 1.4),
        drive_ratio: 0.075,
        inertia_kg_m2: (60.0, 110.0),
        radius_m: (0.35, 0.42),
        full_brake_ratio: (0.095, 0.12),
        ..PLAIN
    },
    Class { name: "freight_two_axles", mass_kg: (12e3, 44e3), ..PLAIN },
    Class {
        name: "works_vehicle",
        mass_kg: (24e3, 46e3),
        drive_ratio: 0.06,
        inertia_kg_m2: (130.0, 240.0),
        ..PLAIN
    },
    Class {
        name: "tram",
        wheelsets: 4,
        mass_kg: (24e3, 42e3),
        radius_m: (0.29, 0.34),
        inertia_kg_m2: (45.0, 90.0),
        length_m: (7.0, 10.0),
        bogie_m: (1.7, 1.9),
        com_height_m: (1.1, 1.35),
        drive_ratio: 0.085,
        full_brake_ratio: (0.10, 0.125),
        top_speed_m_s: (17.0, 24.0),
        ..PLAIN
    },
    Class {
        name: "coach",
        wheelsets: 4,
        mass_kg: (34e3, 58e3),
        inertia_kg_m2: (90.0, 140.0),
        length_m: (16.0, 19.5),
        bogie_m: (2.4, 2.6),
        com_height_m: (1.5, 1.85),
        full_brake_ratio: (0.095, 0.115),
        top_speed_m_s: (30.0, 52.0),
        ..PLAIN
    },
    Class {
        name: "motor_car",
        wheelsets: 4,
        mass_kg: (42e3, 68e3),
        inertia_kg_m2: (160.0, 300.0),
        length_m: (14.0, 18.0),
        bogie_m: (2.2, 2.6),
        com_height_m: (1.4, 1.75),
        drive_ratio: 0.075,
        full_brake_ratio: (0.095, 0.115),
        top_speed_m_s: (28.0, 48.0),
        ..PLAIN
    },
    Class {
        name: "freight_bogies",
        wheelsets: 4,
        mass_kg: (22e3, 90e3),
        length_m: (8.0, 14.0),
        bogie_m: (1.8, 2.0),
        com_height_m: (1.3, 2.0),
        full_brake_ratio: (0.075, 0.10),
        drag: (4.0, 7.0),
        top_speed_m_s: (22.0, 33.0),
        ..PLAIN
    },
    Class {
        name: "locomotive",
        wheelsets: 4,
        mass_kg: (78e3, 120e3),
        radius_m: (0.52, 0.625),
        inertia_kg_m2: (450.0, 900.0),
        length_m: (9.0, 11.5),
        bogie_m: (2.6, 3.2),
        com_height_m: (1.5, 1.8),
        drag: (5.0, 8.0),
        drive_ratio: 0.11,
        full_brake_ratio: (0.08, 0.105),
        top_speed_m_s: (26.0, 44.0),
    },
];

/// What a vehicle must have so that an effect can be there at all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Needs {
    /// Motors.
    pub motor: bool,
    /// Sanders.
    pub sander: bool,
}

impl FamilySheet {
    /// Draws a vehicle that has what is needed.
    #[must_use]
    pub fn draw(stream: &mut Stream, needs: Needs) -> Self {
        let choices: Vec<&Class> = CLASSES.iter().filter(|c| !needs.motor || c.drive_ratio > 0.0).collect();
        let class = choices[stream.below(choices.len())];
        let rate_hz = [20.0, 50.0, 100.0, 100.0, 200.0][stream.below(5)];
        let two_or_more = |stream: &mut Stream, low: f64, high: f64| digits(stream.uniform(low, high), 2);
        // Payload makes light and heavy vehicles of one class equally usual on a logarithmic scale.
        let (light, heavy) = class.mass_kg;
        let mass_kg = four_digits((stream.uniform(light.ln(), heavy.ln())).exp());
        let sensors = [
            two_or_more(stream, 0.015, 0.04),
            two_or_more(stream, 0.03, 0.07),
            two_or_more(stream, 100.0, 300.0),
        ];
        let mut range = |(low, high): (f64, f64)| four_digits(stream.uniform(low, high));
        let (length_m, bogie_base_m) = (range(class.length_m), range(class.bogie_m));
        let (positions_m, bogie_m) = if class.wheelsets == 2 {
            ([length_m / 2.0, -length_m / 2.0, 0.0, 0.0], None)
        } else {
            let (outer, inner) = ((length_m + bogie_base_m) / 2.0, (length_m - bogie_base_m) / 2.0);
            ([outer, inner, -inner, -outer].map(four_digits), Some((bogie_base_m, range((0.4, 0.9)))))
        };
        let radius_m = range(class.radius_m);
        let constant_n = four_digits(mass_kg * range((0.009, 0.0135)));
        let axle_load_n = mass_kg * GRAVITY_M_S2 / class.wheelsets as f64;
        let sheet = Self {
            class: class.name,
            mass_kg,
            mass_sigma: 0.015,
            com_height_m: range(class.com_height_m),
            wheelsets: class.wheelsets,
            positions_m,
            bogie_m,
            radius_m,
            inertia_kg_m2: range(class.inertia_kg_m2),
            brake_radius_m: four_digits(radius_m * range((0.5, 0.6))),
            pad_friction: range((0.30, 0.40)),
            resistance: [constant_n, four_digits(constant_n * range((0.012, 0.028))), range(class.drag)],
            stiffness_n: four_digits(range((5.5e6, 8.5e6)) * (axle_load_n / 1e5).powf(2.0 / 3.0)),
            rail: [range((0.27, 0.36)), range((0.10, 0.15)), range((0.05, 0.08))],
            rate_hz,
            speed_sigma_m_s: sensors[0],
            wheel_speed_sigma_rad_s: sensors[1],
            pressing_force_sigma_n: sensors[2],
            has_position: true,
            sander: false,
            drive_nm: four_digits(class.drive_ratio * range((0.8, 1.1)) * axle_load_n * radius_m),
            full_brake_ratio: range(class.full_brake_ratio),
            top_speed_m_s: range(class.top_speed_m_s),
        };
        let (sander, has_position) = (needs.sander || stream.chance(0.3), stream.chance(0.8));
        Self { sander, has_position, ..sheet }
    }

    /// Pressing force of one wheelset at full brake, N.
    #[must_use]
    pub fn full_force_n(&self) -> f64 {
        self.full_brake_ratio * self.mass_kg * GRAVITY_M_S2 * self.radius_m
            / (self.wheelsets as f64 * self.brake_radius_m * self.pad_friction)
    }

    /// Peak adhesion of a rail class.
    #[must_use]
    pub fn rail_friction(&self, rail: Rail) -> f64 {
        self.rail[rail as usize]
    }

    /// Distance of the outer wheelsets, m.
    #[must_use]
    pub fn span_m(&self) -> f64 {
        self.positions_m[0] - self.positions_m[self.wheelsets - 1]
    }

    /// Whether it reports drive torque.
    #[must_use]
    pub fn is_motored(&self) -> bool {
        self.drive_nm > 0.0
    }

    /// The text of `vehicle.toml`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("schema = 1\nname = \"{}\"\n", self.class);
        let mut table = |name: &str, rows: &[(&str, f64)]| {
            let _ = writeln!(text, "\n[{name}]");
            for (key, value) in rows {
                let _ = writeln!(text, "{key} = {value:?}");
            }
            if name == "body" && self.wheelsets > 2 {
                let _ = writeln!(text, "wheelset_positions_m = {:?}", &self.positions_m[..self.wheelsets]);
            }
        };
        table(
            "body",
            &[
                ("mass_kg", self.mass_kg),
                ("mass_sigma", self.mass_sigma),
                ("com_height_m", self.com_height_m),
                ("wheelbase_m", four_digits(self.span_m())),
            ],
        );
        if let Some((wheelbase_m, pivot_height_m)) = self.bogie_m {
            table("bogie", &[("wheelbase_m", wheelbase_m), ("pivot_height_m", pivot_height_m)]);
        }
        table("wheelset", &[("radius_m", self.radius_m), ("inertia_kg_m2", self.inertia_kg_m2)]);
        table("brake", &[("radius_m", self.brake_radius_m), ("friction_coefficient", self.pad_friction)]);
        let [constant, linear, drag] = self.resistance;
        table(
            "resistance",
            &[("constant_n", constant), ("linear_n_s_per_m", linear), ("drag_n_s2_per_m2", drag)],
        );
        table("contact", &[("stiffness_n", self.stiffness_n), ("k_a", 1.0), ("k_s", 0.4)]);
        table("rail", &[("dry", self.rail[0]), ("wet", self.rail[1]), ("low", self.rail[2])]);
        table(
            "sensors",
            &[
                ("sample_rate_hz", self.rate_hz),
                ("speed_sigma_m_s", self.speed_sigma_m_s),
                ("wheel_speed_sigma_rad_s", self.wheel_speed_sigma_rad_s),
                ("pressing_force_sigma_n", self.pressing_force_sigma_n),
            ],
        );
        text
    }
}

/// Data sheets carry four significant digits.
pub(super) fn four_digits(value: f64) -> f64 {
    digits(value, 4)
}

/// So many significant digits.
fn digits(value: f64, count: i32) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let scale = 10f64.powi(count - 1 - value.abs().log10().floor() as i32);
    let rounded = (value * scale).round() / scale;
    // The division leaves a tail such as 0.30000000000000004; the shortest decimal of the same value does not.
    format!("{rounded:.6}").parse().unwrap_or(rounded)
}
