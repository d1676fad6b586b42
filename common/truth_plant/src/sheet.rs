//! The data sheet of a vehicle: what a simulator would believe about it (`vehicle.toml`), drawn at random from a family.

use std::fmt::Write as _;

use crate::random::Stream;

/// Standard gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.81;

/// Rail condition of a run; picks the adhesion level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rail {
    /// Clean dry rail.
    Dry,
    /// Rain.
    Wet,
    /// Leaves, oil, rust and the like.
    Low,
}

impl Rail {
    /// The word in file names and in `[rail]`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
            Self::Low => "low",
        }
    }
}

/// The believed vehicle, in the units of `vehicle.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Family it was drawn from.
    pub family: &'static str,
    /// Body and everything on it, kg.
    pub mass_kg: f64,
    /// Height of the centre of mass above the rail, m.
    pub com_height_m: f64,
    /// Distance of the wheelsets, m.
    pub wheelbase_m: f64,
    /// Rolling radius, m.
    pub radius_m: f64,
    /// Rotating inertia of one wheelset, kg m².
    pub inertia_kg_m2: f64,
    /// Effective radius of the brake discs, m.
    pub brake_radius_m: f64,
    /// Pad friction coefficient.
    pub pad_friction: f64,
    /// Constant running resistance, N.
    pub constant_n: f64,
    /// Linear running resistance, N s/m.
    pub linear_n_s_per_m: f64,
    /// Quadratic running resistance, N s²/m².
    pub drag_n_s2_per_m2: f64,
    /// Contact stiffness `K` of Polach's law, N.
    pub stiffness_n: f64,
    /// Polach's reduction factor of the adhesion area.
    pub k_a: f64,
    /// Polach's reduction factor of the slip area.
    pub k_s: f64,
    /// Peak adhesion on dry, wet and low rail.
    pub rail: [f64; 3],
    /// One sigma of the speed sensor, m/s.
    pub speed_sigma_m_s: f64,
    /// One sigma of the wheel-speed sensors, rad/s.
    pub wheel_speed_sigma_rad_s: f64,
    /// One sigma of the inferred pressing force, N.
    pub pressing_force_sigma_n: f64,
    /// Largest traction torque of one wheelset, N m; zero for a trailer. Not part of the file.
    pub traction_nm: f64,
    /// Whether the vehicle carries sanders. Not part of the file.
    pub sander: bool,
    /// Full-brake retardation over gravity that the brake is dimensioned for. Not part of the file.
    pub full_brake_ratio: f64,
    /// Usual top speed, m/s. Not part of the file.
    pub top_speed_m_s: f64,
}

/// Ranges of one family.
struct Family {
    name: &'static str,
    mass_kg: (f64, f64),
    radius_m: (f64, f64),
    inertia_kg_m2: (f64, f64),
    brake_radius_m: (f64, f64),
    wheelbase_m: (f64, f64),
    com_height_m: (f64, f64),
    drag: (f64, f64),
    traction_ratio: f64,
    full_brake_ratio: (f64, f64),
    top_speed_m_s: (f64, f64),
}

const FAMILIES: [Family; 5] = [
    Family {
        name: "coach",
        mass_kg: (34e3, 46e3),
        radius_m: (0.42, 0.46),
        inertia_kg_m2: (100.0, 160.0),
        brake_radius_m: (0.22, 0.27),
        wheelbase_m: (9.5, 14.0),
        com_height_m: (1.5, 1.8),
        drag: (2.8, 5.0),
        traction_ratio: 0.0,
        full_brake_ratio: (0.098, 0.112),
        top_speed_m_s: (28.0, 50.0),
    },
    Family {
        name: "motor",
        mass_kg: (46e3, 62e3),
        radius_m: (0.42, 0.46),
        inertia_kg_m2: (220.0, 340.0),
        brake_radius_m: (0.24, 0.28),
        wheelbase_m: (10.0, 13.0),
        com_height_m: (1.4, 1.75),
        drag: (3.0, 5.5),
        traction_ratio: 0.065,
        full_brake_ratio: (0.098, 0.112),
        top_speed_m_s: (30.0, 48.0),
    },
    Family {
        name: "freight",
        mass_kg: (20e3, 44e3),
        radius_m: (0.43, 0.47),
        inertia_kg_m2: (90.0, 135.0),
        brake_radius_m: (0.22, 0.26),
        wheelbase_m: (7.5, 10.0),
        com_height_m: (1.3, 1.75),
        drag: (3.8, 6.0),
        traction_ratio: 0.0,
        full_brake_ratio: (0.098, 0.115),
        top_speed_m_s: (26.0, 44.0),
    },
    Family {
        name: "tram",
        mass_kg: (18e3, 30e3),
        radius_m: (0.31, 0.37),
        inertia_kg_m2: (60.0, 130.0),
        brake_radius_m: (0.17, 0.21),
        wheelbase_m: (6.0, 8.5),
        com_height_m: (1.1, 1.4),
        drag: (2.5, 4.0),
        traction_ratio: 0.08,
        full_brake_ratio: (0.10, 0.12),
        top_speed_m_s: (22.0, 28.0),
    },
    Family {
        name: "railcar",
        mass_kg: (28e3, 42e3),
        radius_m: (0.38, 0.43),
        inertia_kg_m2: (130.0, 220.0),
        brake_radius_m: (0.20, 0.25),
        wheelbase_m: (8.0, 12.0),
        com_height_m: (1.35, 1.65),
        drag: (3.0, 4.8),
        traction_ratio: 0.07,
        full_brake_ratio: (0.10, 0.115),
        top_speed_m_s: (26.0, 40.0),
    },
];

impl Sheet {
    /// Draws a vehicle; `motored` forces a family with traction.
    #[must_use]
    pub fn draw(stream: &mut Stream, motored: bool, sander: bool) -> Self {
        let choices: Vec<&Family> = FAMILIES.iter().filter(|f| !motored || f.traction_ratio > 0.0).collect();
        let family = choices[stream.below(choices.len())];
        let mut range = |(low, high): (f64, f64)| stream.uniform(low, high);
        let mass_kg = four_digits(range(family.mass_kg));
        let radius_m = four_digits(range(family.radius_m));
        let constant_n = four_digits(mass_kg * range((0.009, 0.0125)));
        let sheet = Self {
            family: family.name,
            mass_kg,
            com_height_m: four_digits(range(family.com_height_m)),
            wheelbase_m: four_digits(range(family.wheelbase_m)),
            radius_m,
            inertia_kg_m2: four_digits(range(family.inertia_kg_m2)),
            brake_radius_m: four_digits(range(family.brake_radius_m)),
            pad_friction: 0.35,
            constant_n,
            linear_n_s_per_m: four_digits(constant_n * range((0.012, 0.026))),
            drag_n_s2_per_m2: four_digits(range(family.drag)),
            stiffness_n: four_digits(range((5.5e6, 8.5e6))),
            k_a: 1.0,
            k_s: 0.4,
            rail: [0.3, 0.115, 0.065],
            speed_sigma_m_s: 0.03,
            wheel_speed_sigma_rad_s: 0.03,
            pressing_force_sigma_n: 150.0,
            traction_nm: four_digits(
                family.traction_ratio * range((0.85, 1.15)) * mass_kg * GRAVITY_M_S2 * radius_m / 2.0,
            ),
            sander: false,
            full_brake_ratio: range(family.full_brake_ratio),
            top_speed_m_s: range(family.top_speed_m_s),
        };
        Self { sander: sander || stream.chance(0.3), ..sheet }
    }

    /// Pressing force of one wheelset at full brake, N.
    #[must_use]
    pub fn full_force_n(&self) -> f64 {
        self.full_brake_ratio * self.mass_kg * GRAVITY_M_S2 * self.radius_m
            / (2.0 * self.brake_radius_m * self.pad_friction)
    }

    /// Peak adhesion of a rail class.
    #[must_use]
    pub fn rail_friction(&self, rail: Rail) -> f64 {
        self.rail[rail as usize]
    }

    /// The text of `vehicle.toml`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "schema = 1\nname = \"{}\"", self.family);
        let mut table = |name: &str, rows: &[(&str, f64)]| {
            let _ = writeln!(text, "\n[{name}]");
            for (key, value) in rows {
                let _ = writeln!(text, "{key} = {value:?}");
            }
        };
        table(
            "body",
            &[
                ("mass_kg", self.mass_kg),
                ("com_height_m", self.com_height_m),
                ("wheelbase_m", self.wheelbase_m),
            ],
        );
        table("wheelset", &[("radius_m", self.radius_m), ("inertia_kg_m2", self.inertia_kg_m2)]);
        table("brake", &[("radius_m", self.brake_radius_m), ("friction_coefficient", self.pad_friction)]);
        table(
            "resistance",
            &[
                ("constant_n", self.constant_n),
                ("linear_n_s_per_m", self.linear_n_s_per_m),
                ("drag_n_s2_per_m2", self.drag_n_s2_per_m2),
            ],
        );
        table("contact", &[("stiffness_n", self.stiffness_n), ("k_a", self.k_a), ("k_s", self.k_s)]);
        table("rail", &[("dry", self.rail[0]), ("wet", self.rail[1]), ("low", self.rail[2])]);
        table(
            "sensors",
            &[
                ("sample_rate_hz", 100.0),
                ("speed_sigma_m_s", self.speed_sigma_m_s),
                ("wheel_speed_sigma_rad_s", self.wheel_speed_sigma_rad_s),
                ("pressing_force_sigma_n", self.pressing_force_sigma_n),
            ],
        );
        text
    }
}

/// Data sheets carry four significant digits.
fn four_digits(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let scale = 10f64.powi(3 - value.abs().log10().floor() as i32);
    let rounded = (value * scale).round() / scale;
    // The division leaves a tail such as 0.30000000000000004; the shortest decimal of the same value does not.
    format!("{rounded:.6}").parse().unwrap_or(rounded)
}
