//! Wheels and what they roll on.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// One mode of vibration of a wheel or roller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Modal mass for unit motion at the contact, kg.
    pub mass_kg: f64,
    /// Loss factor while rolling on dry steel.
    pub loss_factor: f64,
    /// 1 if it moves as roughness pushes, 0 if along the axle.
    pub radial_share: f64,
}

/// What a wheel rolls on.
#[derive(Clone, Debug, PartialEq)]
pub enum Support {
    /// A rail on its pads.
    Track {
        /// Bending stiffness, N m².
        bending_n_m2: f64,
        /// Mass, kg/m.
        mass_kg_m: f64,
        /// Stiffness of pads and bed, N/m².
        stiffness_n_m2: f64,
        /// Their loss factor.
        loss_factor: f64,
    },
    /// A roller.
    Roller {
        /// Mass, kg.
        mass_kg: f64,
        /// Modes.
        modes: Vec<Mode>,
    },
}

/// A wheel, what it rolls on, and where the microphone stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// Name on the command line.
    pub name: &'static str,
    /// Radius of the wheel, m.
    pub wheel_radius_m: f64,
    /// Mass of the wheel with its share of the axle, kg.
    pub wheel_mass_kg: f64,
    /// Modes of the wheel, lowest first.
    pub modes: Vec<Mode>,
    /// What it rolls on.
    pub support: Support,
    /// Radius that stands for all curvatures of the contact, m.
    pub curvature_m: f64,
    /// Usual load of a wheel, N.
    pub load_n: f64,
    /// Speeds at which it runs, m/s.
    pub speed_m_s: (f64, f64),
    /// Usual roughness over that of a smooth rail, dB.
    pub roughness_db: f64,
    /// Distance of the microphone from the contact, m.
    pub microphone_m: f64,
    /// Loss factor that water adds, over that of a dry wheel.
    pub wet_damping: f64,
}

/// The rigs that railgrip can let sound.
pub static RIGS: &[fn() -> Rig] = &[bogie, roller, track, traction];

/// Their names, for people.
pub fn rig_names() -> String {
    RIGS.iter().map(|rig| rig().name).collect::<Vec<_>>().join(", ")
}

/// Axial and radial modes of an undamped wheel of 0.92 m: frequency in Hz and radial share. Rounded from the modes that
/// Thompson (2009, chapter 4) shows for freight wheels.
const WHEEL_MODES: [(f64, f64); 11] = [
    (430.0, 0.02),
    (1150.0, 0.05),
    (1650.0, 0.5),
    (2050.0, 0.15),
    (2400.0, 0.7),
    (3000.0, 0.2),
    (3250.0, 0.8),
    (4050.0, 0.25),
    (4350.0, 0.8),
    (5150.0, 0.3),
    (5500.0, 0.8),
];
/// Radius of that wheel, m.
const WHEEL_RADIUS_M: f64 = 0.46;
/// Modal mass of each, about a third of the wheel, kg (chosen).
const MODAL_MASS_KG: f64 = 110.0;
/// Loss factor of a wheel that rolls: the contact takes far more than the 1e-4 of a hanging wheel (Thompson: "rolling
/// damping"; value chosen).
const ROLLING_LOSS_FACTOR: f64 = 6e-3;

impl Rig {
    /// The rig of that name.
    pub fn named(name: &str) -> Option<Self> {
        RIGS.iter().map(|rig| rig()).find(|rig| rig.name == name)
    }

    /// Loss factor of a mode of the wheel.
    pub(crate) fn loss_factor(&self, mode: &Mode, wetness: f64) -> f64 {
        mode.loss_factor * (1.0 + self.wet_damping * wetness)
    }

    /// Another rig of the same kind: no two wheels are alike. Spreads are chosen: 3 % of
    /// frequency, 30 % of damping, 10 % of mass, 30 % of what water does.
    #[must_use]
    pub fn varied(mut self, random: &mut Pcg64Mcg) -> Self {
        let mut spread = |sigma: f64| {
            let normal: f64 = StandardNormal.sample(random);
            (sigma * normal.clamp(-2.5, 2.5)).exp()
        };
        let damping = spread(0.25);
        for mode in &mut self.modes {
            mode.frequency_hz *= spread(0.03);
            mode.loss_factor *= damping * spread(0.15);
            mode.mass_kg *= spread(0.2);
        }
        self.wheel_mass_kg *= spread(0.1);
        self.wet_damping *= spread(0.3);
        self.microphone_m *= spread(0.15);
        match &mut self.support {
            Support::Track { stiffness_n_m2, loss_factor, .. } => {
                *stiffness_n_m2 *= spread(0.4);
                *loss_factor *= spread(0.3);
            }
            Support::Roller { mass_kg, modes } => {
                *mass_kg *= spread(0.1);
                for mode in modes {
                    mode.frequency_hz *= spread(0.03);
                    mode.loss_factor *= spread(0.3);
                }
            }
        }
        self
    }
}

/// Modes of a wheel of another size but the same shape: frequencies go with 1/R, masses with R³.
fn wheel_modes(radius_m: f64) -> Vec<Mode> {
    let size = radius_m / WHEEL_RADIUS_M;
    let mode = |&(frequency_hz, radial_share): &(f64, f64)| Mode {
        frequency_hz: frequency_hz / size,
        mass_kg: MODAL_MASS_KG * size.powi(3),
        loss_factor: ROLLING_LOSS_FACTOR,
        radial_share,
    };
    WHEEL_MODES.iter().map(mode).collect()
}

/// A steel roller: in-plane modes of a disc on a hub (chosen for 0.2 m: 3.4, 5.9 and 8.8 kHz), frequencies with 1/R.
fn roller_support(radius_m: f64, mass_kg: f64) -> Support {
    let modes = [3400.0, 5900.0, 8800.0].map(|frequency_hz| Mode {
        frequency_hz: frequency_hz * 0.2 / radius_m,
        mass_kg: 0.3 * mass_kg,
        loss_factor: 0.01,
        radial_share: 1.0,
    });
    Support::Roller { mass_kg, modes: modes.into() }
}

/// Bogie rig of Shrestha et al. (section 2.1): scale 1:4, wheels of 200 mm on rollers of 400 mm. The load is that of a
/// 26.5 t axle at 1:4 (mass by the cube of scale); masses are those of steel discs of that size, roughness and microphone
/// are chosen.
pub fn bogie() -> Rig {
    Rig {
        name: "bogie",
        wheel_radius_m: 0.1,
        wheel_mass_kg: 9.0,
        modes: wheel_modes(0.1),
        support: roller_support(0.2, 60.0),
        curvature_m: 0.06,
        load_n: 2030.0,
        speed_m_s: (0.3, 4.3),
        roughness_db: 6.0,
        microphone_m: 0.15,
        wet_damping: 4.0,
    }
}

/// Roller rig of full size as that of Schwarz & Keck; masses, roughness and microphone are chosen.
pub fn roller() -> Rig {
    Rig {
        name: "roller",
        wheel_radius_m: 0.46,
        wheel_mass_kg: 500.0,
        modes: wheel_modes(0.46),
        support: roller_support(0.75, 2500.0),
        curvature_m: 0.3,
        load_n: 50e3,
        speed_m_s: (3.0, 55.0),
        roughness_db: -1.0,
        microphone_m: 0.6,
        wet_damping: 4.0,
    }
}

/// Wheel radii that [`any`] never draws, m: that of the traction rig lies in the middle, so that it stays unheard.
pub const UNHEARD_RADII_M: (f64, f64) = (0.12, 0.19);
/// Smallest and largest wheel that [`any`] draws, m.
const ANY_RADII_M: (f64, f64) = (0.08, 0.55);

/// A rig of any size, load, speed and shape: what a network must hear if it shall not learn single rigs by heart.
///
/// Masses, loads and speeds grow with the wheel as between the rigs of this file (powers 2.6, 2.1 and 1.7 of its
/// radius), each with a spread of its own; modes lie up to a fifth beside those of the usual shape.
pub fn any(random: &mut Pcg64Mcg) -> Rig {
    let wheel_radius_m = loop {
        let radius_m = ANY_RADII_M.0 * (ANY_RADII_M.1 / ANY_RADII_M.0).powf(random.random_range(0.0..1.0));
        if !(UNHEARD_RADII_M.0..=UNHEARD_RADII_M.1).contains(&radius_m) {
            break radius_m;
        }
    };
    let mut spread = |octaves: f64| random.random_range(-octaves..octaves).exp2();
    let size = wheel_radius_m / 0.1;
    let wheel_mass_kg = 9.0 * size.powf(2.6) * spread(0.6);
    let on_track = wheel_radius_m > 0.3 && spread(1.0) > 1.0;
    let support = if on_track {
        Support::Track {
            bending_n_m2: 5e6 * spread(0.5),
            mass_kg_m: 55.0 * spread(0.2),
            stiffness_n_m2: 1e8 * spread(1.5),
            loss_factor: 0.2 * spread(0.7),
        }
    } else {
        roller_support(1.5 * wheel_radius_m * spread(0.6), 3.5 * wheel_mass_kg * spread(1.0))
    };
    let top_m_s = 4.5 * size.powf(1.7) * spread(0.7);
    let mut modes = wheel_modes(wheel_radius_m * spread(0.15));
    for mode in &mut modes {
        mode.frequency_hz *= spread(0.26);
        mode.mass_kg *= spread(0.7);
        mode.loss_factor *= spread(0.3);
        mode.radial_share = (mode.radial_share * spread(0.7)).min(1.0);
    }
    Rig {
        name: "any",
        wheel_radius_m,
        wheel_mass_kg,
        modes,
        support,
        curvature_m: 0.6 * wheel_radius_m * spread(0.4),
        load_n: 2000.0 * size.powf(2.1) * spread(0.7),
        speed_m_s: (0.07 * top_m_s, top_m_s),
        roughness_db: 3.0 + 4.0 * spread(0.8).log2() / 0.8,
        microphone_m: 0.15 * size.powf(0.95) * spread(0.7),
        wet_damping: 4.0 * spread(0.3),
    }
}

/// A wagon on track: 60 kg/m rail (EI 6.4 MN m²) on pads of 100 MN/m² (values usual in rolling-noise models).
pub fn track() -> Rig {
    Rig {
        name: "track",
        wheel_radius_m: 0.44,
        wheel_mass_kg: 500.0,
        modes: wheel_modes(0.44),
        support: Support::Track {
            bending_n_m2: 6.4e6,
            mass_kg_m: 60.0,
            stiffness_n_m2: 1e8,
            loss_factor: 0.2,
        },
        curvature_m: 0.33,
        load_n: 50e3,
        speed_m_s: (2.0, 45.0),
        roughness_db: 6.0,
        microphone_m: 0.8,
        wet_damping: 4.0,
    }
}

/// Traction rig of Zhao et al., scale 1/5; masses, roughness and microphone are chosen.
pub fn traction() -> Rig {
    Rig {
        name: "traction",
        wheel_radius_m: 0.15,
        wheel_mass_kg: 25.0,
        modes: wheel_modes(0.15),
        support: roller_support(0.16, 45.0),
        curvature_m: 0.08,
        load_n: 2000.0,
        speed_m_s: (0.8, 12.0),
        roughness_db: 4.0,
        microphone_m: 0.25,
        wet_damping: 4.0,
    }
}
