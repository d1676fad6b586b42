//! One wagon: what its file says of it, and what it really is.

use crate::random::Stream;

use super::{
    family::{BrakeLine, Family, WagonKind},
    gear::{GearPlan, Pads},
    pitch::Bogies,
    protection::ProtectionPlan,
    sensors::SensorPlan,
    units::PerWheelset,
};

/// What is believed of a wagon: the content of `vehicle.toml`.
#[derive(Debug, Clone)]
pub struct WagonFile {
    /// Kind of wagon.
    pub name: &'static str,
    /// Mass, kg, and how far it may be off, relative.
    pub mass_kg: f64,
    /// Relative one sigma of the mass.
    pub mass_sigma: f64,
    /// Height of the centre of mass, m.
    pub com_height_m: f64,
    /// Distance of the pivots, or of the wheelsets of a two-axle wagon, m.
    pub wheelbase_m: f64,
    /// Places of the wheelsets ahead of the middle, m, front first.
    pub positions_m: Vec<f64>,
    /// Wheelbase of a bogie and height of its pivot, m.
    pub bogie_m: Option<(f64, f64)>,
    /// Rolling radius, m.
    pub radius_m: f64,
    /// Inertia of one wheelset with what turns with it, kg m².
    pub inertia_kg_m2: f64,
    /// Radius at which the pads act, m.
    pub pad_radius_m: f64,
    /// Pad friction.
    pub pad_friction: f64,
    /// Running resistance: N, N s/m, N s²/m².
    pub resistance: [f64; 3],
    /// Contact stiffness, N.
    pub stiffness_n: f64,
    /// Pressing force of one wheelset at full brake, N. Not part of the file.
    pub full_force_n: f64,
}

/// What a wagon really is.
#[derive(Debug, Clone)]
pub struct RealWagon {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Height of the centre of mass of what rests on the bogies, m.
    pub body_height_m: f64,
    /// Height of the couplers, m.
    pub coupler_height_m: f64,
    /// Bogies, if it has them.
    pub bogies: Option<Bogies>,
    /// Frequency (rad/s) and damping of its pitching.
    pub pitching: (f64, f64),
    /// Length over couplers, m.
    pub length_m: f64,
    /// Rolling radii, m.
    pub radius_m: PerWheelset,
    /// Inertias, kg m².
    pub inertia_kg_m2: PerWheelset,
    /// Running resistance: N, N s/m, N s²/m².
    pub resistance: [f64; 3],
    /// Contact stiffness at the load of the file, N.
    pub stiffness_n: f64,
    /// Brake gear.
    pub gear: GearPlan,
    /// Slide protection.
    pub protection: ProtectionPlan,
    /// Delay of its distributor, s.
    pub distributor_s: f64,
    /// Largest traction force, electric braking force (N) and power (W).
    pub traction: (f64, f64, f64),
    /// Whether it has sanders.
    pub sander: bool,
}

/// A wagon of a train.
#[derive(Debug, Clone)]
pub struct Wagon {
    /// Vehicle number with its check digit.
    pub number: String,
    /// What is believed.
    pub file: WagonFile,
    /// What is true.
    pub real: RealWagon,
    /// Its sensors.
    pub sensors: SensorPlan,
}

/// What all wagons of a train share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Common {
    /// Contact stiffness over the file's.
    pub(crate) stiffness: f64,
    /// Whether payload is declared, and whether load is measured.
    pub(crate) declared: bool,
    pub(crate) load_measured: bool,
    /// Full brake, m/s².
    pub(crate) full_m_s2: f64,
    pub(crate) by_bogie: bool,
}

impl Wagon {
    pub(crate) fn draw(
        stream: &mut Stream,
        kind: &WagonKind,
        family: &Family,
        common: &Common,
        motored: bool,
    ) -> Self {
        let within = |stream: &mut Stream, range: (f64, f64)| stream.uniform(range.0, range.1);
        let tare_kg = within(stream, kind.tare_kg);
        // Full, empty and everything between.
        let filling: f64 = match stream.below(4) {
            0 => stream.uniform(0.0, 0.08),
            1 => stream.uniform(0.85, 1.0),
            _ => stream.uniform(0.0, 1.0),
        };
        let mass_kg = tare_kg + filling * kind.payload_kg;
        let (believed_kg, mass_sigma) = if common.declared {
            (mass_kg / (1.0 + 0.01 * stream.normal().clamp(-2.2, 2.2)), 0.015)
        } else {
            let middle_kg = tare_kg + 0.5 * kind.payload_kg;
            (middle_kg, (0.3 * kind.payload_kg / middle_kg).clamp(0.03, 0.3))
        };
        let height_m = kind.height_m.0 + filling * (kind.height_m.1 - kind.height_m.0);
        let file = file(stream, kind, digits(believed_kg), mass_sigma, height_m);
        let real = real(stream, kind, family, common, (&file, mass_kg, motored));
        let full_force_n = common.full_m_s2 * mass_kg * file.radius_m
            / (file.positions_m.len() as f64 * file.pad_radius_m * file.pad_friction);
        let mut wagon = Self {
            number: number(stream, kind.traction_n > 100e3),
            sensors: sensors(stream, common.load_measured),
            file: WagonFile { full_force_n, ..file },
            real,
        };
        wagon.real.gear.full_force_n = [full_force_n; 4].map(|force_n| force_n * stream.uniform(0.98, 1.02));
        wagon
    }

    /// Number of wheelsets.
    #[must_use]
    pub fn wheelsets(&self) -> usize {
        self.file.positions_m.len()
    }

    /// Whether it drives.
    #[must_use]
    pub fn is_motored(&self) -> bool {
        self.real.traction.0 > 0.0
    }
}

fn file(stream: &mut Stream, kind: &WagonKind, mass_kg: f64, mass_sigma: f64, height_m: f64) -> WagonFile {
    let length_m = stream.uniform(kind.length_m.0, kind.length_m.1);
    let base_m = digits(length_m * if kind.two_axles { 0.58 } else { 0.68 });
    let axle_m = digits(if kind.traction_n > 100e3 { 2.8 } else { stream.uniform(1.8, 2.5) });
    let half_m = 0.5 * base_m;
    let positions_m = if kind.two_axles {
        vec![half_m, -half_m]
    } else {
        let side = 0.5 * axle_m;
        vec![half_m + side, half_m - side, -half_m + side, -half_m - side].into_iter().map(digits).collect()
    };
    let radius_m = digits(stream.uniform(kind.radius_m.0, kind.radius_m.1));
    let constant_n = digits(mass_kg * stream.uniform(0.008, 0.013));
    WagonFile {
        name: kind.name,
        mass_kg,
        mass_sigma: digits(mass_sigma),
        com_height_m: digits(height_m * stream.uniform(0.97, 1.03)),
        wheelbase_m: base_m,
        positions_m,
        bogie_m: (!kind.two_axles).then(|| (axle_m, digits(stream.uniform(0.55, 0.75)))),
        radius_m,
        inertia_kg_m2: digits(stream.uniform(kind.inertia_kg_m2.0, kind.inertia_kg_m2.1)),
        pad_radius_m: digits(radius_m * stream.uniform(kind.pad_radius.0, kind.pad_radius.1 + 1e-9)),
        pad_friction: kind.pad_friction,
        resistance: [
            constant_n,
            digits(constant_n * stream.uniform(0.012, 0.026)),
            digits(stream.uniform(kind.drag.0, kind.drag.1)),
        ],
        stiffness_n: digits(stream.uniform(5.5e6, 8.0e6)),
        full_force_n: 0.0,
    }
}

fn real(
    stream: &mut Stream,
    kind: &WagonKind,
    family: &Family,
    common: &Common,
    (file, mass_kg, motored): (&WagonFile, f64, bool),
) -> RealWagon {
    let bogies = file.bogie_m.map(|(wheelbase_m, pivot_height_m)| Bogies {
        wheelbase_m,
        pivot_height_m,
        mass_kg: if kind.traction_n > 100e3 { 14e3 } else { stream.uniform(4.2e3, 6.5e3) },
    });
    // The bogies are low; what rests on them is higher than the whole.
    let bogie_kg = bogies.map_or(0.0, |bogies| 2.0 * bogies.mass_kg);
    let body_height_m = (mass_kg * file.com_height_m - bogie_kg * 0.5) / (mass_kg - bogie_kg);
    let inertia = file.inertia_kg_m2 * stream.uniform(0.97, 1.03);
    let resistance = [
        file.resistance[0] * mass_kg / file.mass_kg * stream.uniform(0.9, 1.1),
        file.resistance[1],
        file.resistance[2] * stream.uniform(0.9, 1.1),
    ];
    let mut gear = gear(stream, family, file);
    if kind.traction_n > 100e3 {
        // The direct brake of a locomotive is fast whatever the train's is.
        (gear.fill_s, gear.release_s) = (gear.fill_s.min(3.5), gear.release_s.min(4.0));
    }
    let powered = if motored { 1.0 } else { 0.0 };
    let traction = (powered * kind.traction_n, powered * kind.electric_n, powered * kind.power_w);
    RealWagon {
        mass_kg,
        body_height_m,
        coupler_height_m: 1.04,
        bogies,
        pitching: (stream.uniform(5.5, 8.5), stream.uniform(0.15, 0.35)),
        length_m: file.wheelbase_m / if kind.two_axles { 0.58 } else { 0.68 },
        radius_m: [0.0; 4].map(|_| file.radius_m * (1.0 + 0.0012 * stream.normal().clamp(-2.0, 2.0))),
        inertia_kg_m2: [inertia; 4],
        resistance,
        stiffness_n: file.stiffness_n * common.stiffness,
        gear,
        protection: ProtectionPlan {
            vent_share: stream.uniform(0.05, 0.10),
            vent_m_s: stream.uniform(0.5, 0.9),
            by_bogie: common.by_bogie && !kind.two_axles,
        },
        distributor_s: match family.line {
            BrakeLine::Electric => stream.uniform(0.05, 0.25),
            BrakeLine::Pipe => stream.uniform(0.2, 0.8),
        },
        traction,
        sander: stream.chance(kind.sander),
    }
}

fn gear(stream: &mut Stream, family: &Family, file: &WagonFile) -> GearPlan {
    let level = file.pad_friction * (1.0 + stream.uniform(-0.10, 0.10));
    let spread = |stream: &mut Stream, range: (f64, f64)| stream.uniform(range.0, range.1);
    GearPlan {
        pads: Pads {
            friction: [level; 4].map(|level| level * (1.0 + stream.uniform(-0.045, 0.045))),
            speed_loss: stream.uniform(-0.04, 0.08),
            pressing_loss: stream.uniform(0.0, 0.06),
            heat_loss: stream.uniform(0.0, 0.02),
            wander: (stream.uniform(0.004, 0.012), stream.uniform(15.0, 60.0)),
            heat_j_per_k: stream.uniform(7e4, 1.2e5),
        },
        full_force_n: [0.0; 4],
        pad_radius_m: file.pad_radius_m,
        gain: stream.uniform(0.96, 1.04),
        fill_s: spread(stream, family.fill_s),
        release_s: spread(stream, family.release_s),
    }
}

fn sensors(stream: &mut Stream, load_measured: bool) -> SensorPlan {
    SensorPlan {
        noise: stream.uniform(0.7, 1.2),
        colour: (stream.uniform(0.0, 0.5), stream.uniform(0.05, 0.2)),
        v_scale: 0.0006 * stream.normal().clamp(-2.0, 2.0),
        lag_s: (stream.uniform(0.005, 0.03), stream.uniform(0.003, 0.015)),
        eccentricity: [0.0; 4].map(|_| stream.uniform(0.0, 0.0006)),
        pressing_offset_n: ([0.0; 4].map(|_| 60.0 * stream.normal()), 25.0 * stream.normal()),
        torque_scale: 0.008 * stream.normal().clamp(-2.0, 2.0),
        position_bias: (stream.sign() * stream.uniform(1.0, 2.0), stream.uniform(60.0, 140.0)),
        load_scale: load_measured.then(|| 0.02 * stream.normal().clamp(-2.0, 2.0)),
        resolution: ([0.001, 0.005, 0.01, 0.02][stream.below(4)], [1.0, 10.0, 50.0][stream.below(3)]),
        sigma: (0.03, 0.03, 150.0),
    }
}

/// A vehicle number of twelve digits, the last of them a check digit (weights 2 and 1 in turn, sum of digits).
fn number(stream: &mut Stream, locomotive: bool) -> String {
    let mut digits: Vec<usize> = if locomotive { vec![9, 1, 8, 0] } else { vec![5, 0, 8, 0] };
    digits.extend((0..7).map(|_| stream.below(10)));
    let doubled = |(at, digit): (usize, &usize)| {
        let product = if at % 2 == 0 { 2 * digit } else { *digit };
        product / 10 + product % 10
    };
    let sum: usize = digits.iter().enumerate().map(doubled).sum();
    let text: String = digits.iter().map(usize::to_string).collect();
    let check = (10 - sum % 10) % 10;
    format!("{} {} {}-{} {}-{check}", &text[0..2], &text[2..4], &text[4..6], &text[6..8], &text[8..11])
}

/// Files carry four significant digits.
fn digits(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let scale = 10f64.powi(3 - value.abs().log10().floor() as i32);
    let rounded = (value * scale).round() / scale;
    format!("{rounded:.6}").parse().unwrap_or(rounded)
}
