//! Effects on the coefficient between pad and disc.

use super::{Effect, EffectSpec, Operating, ParameterSpec, Term, Twin};
use crate::constants::{DISC_HEAT_CAPACITY_J_PER_K, DRY_RAIL_ADHESION, FRICTION_RING_COOLING_S};
use crate::wagon::Constants;
use crate::{MAX_WHEELSETS, PerWheelset};
use std::sync::OnceLock;

/// Friction that depends on the speed of the disc, and so on that of its wheelset: in a slide the disc is slower than the
/// vehicle and may stand.
pub static SPEED: EffectSpec = EffectSpec {
    id: "brake_friction_speed",
    term: Term::BrakeFriction,
    equation: "mu = mu0 (1 + d exp(-r |omega| / v_s))",
    source: "organic and cast-iron pads grip harder towards standstill; shape after PLOS ONE 10.1371/journal.pone.0135459, fig. 2; range of d and v_s is general knowledge",
    parameters: &[
        ParameterSpec {
            name: "rise",
            lower: -0.05,
            upper: 1.5,
            default: 0.1,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "decay_speed_m_s",
            unit: "m/s",
            lower: 1.5,
            upper: 60.0,
            default: 6.0,
            starts: &[20.0],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("brake_fade")],
    separated_by: "stops from two initial speeds: a law of speed gives the same friction at the same speed in both",
};

/// See [`SPEED`].
#[derive(Debug)]
pub struct Speed {
    rise: f64,
    decay_speed_m_s: f64,
    /// Rolling radius of each wheelset of the model, m, known once it is built.
    wheel_radius_m: OnceLock<PerWheelset>,
}

impl Speed {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { rise: values[0], decay_speed_m_s: values[1], wheel_radius_m: OnceLock::new() })
    }
}

impl Effect for Speed {
    fn spec(&self) -> &'static EffectSpec {
        &SPEED
    }

    fn constants(&self, constants: &mut Constants) {
        self.wheel_radius_m.get_or_init(|| constants.wheel_radius_m);
    }

    fn brake_friction(&self, wheelset: usize, at: &Operating, _hidden: &[f64], friction: f64) -> f64 {
        // At the rim, so that a rolling wheelset's is the vehicle's; without a model only that is known.
        let disc_m_s = match self.wheel_radius_m.get() {
            Some(radius_m) => radius_m[wheelset] * at.wheel_speed_rad_s[wheelset],
            None => at.v_m_s,
        };
        friction * (1.0 + self.rise * (-disc_m_s.abs() / self.decay_speed_m_s).exp()).max(0.05)
    }
}

/// Cast-iron blocks in place of pads.
pub static CAST_IRON: EffectSpec = EffectSpec {
    id: "cast_iron",
    term: Term::BrakeFriction,
    equation: "mu = mu0 (1 - s + s K(v, F) / K(50 km/h, F1)), K = (16 F/F1 + 100)/(80 F/F1 + 100) (v + 100)/(5 v + 100), v in km/h",
    source: "Karwatzki's formula for cast-iron blocks, Glasers Annalen 1950, as brake calculations use it (F/F1 is the block force in \
             tonnes-force); friction falls both with speed and with pressure",
    parameters: &[
        ParameterSpec {
            name: "share",
            lower: 0.0,
            upper: 1.3,
            default: 1.0,
            neutral: Some(0.0),
            starts: &[0.4],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "tonne_force_n",
            unit: "N",
            lower: 9e3,
            upper: 4e5,
            default: 4e4,
            starts: &[1.2e5],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("brake_friction_speed"), Twin::look_alike("brake_friction_pressure")],
    separated_by: "stops from high speed at full and at a third of the pressure: cast iron changes with both at once",
};

/// See [`CAST_IRON`].
#[derive(Debug)]
pub struct CastIron {
    share: f64,
    /// Pressing force of a wheelset at which each of its blocks is pressed with a tonne-force, N.
    tonne_force_n: f64,
    /// Rolling radius of each wheelset of the model, m, known once it is built.
    wheel_radius_m: OnceLock<PerWheelset>,
}

/// Speed at which cast iron is compared with the pad of the model, km/h.
const CAST_IRON_SPEED_KM_H: f64 = 50.0;

impl CastIron {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { share: values[0], tonne_force_n: values[1], wheel_radius_m: OnceLock::new() })
    }

    /// Karwatzki's law without its constant 0.6.
    fn law(speed_km_h: f64, tonnes: f64) -> f64 {
        (16.0 * tonnes + 100.0) / (80.0 * tonnes + 100.0) * (speed_km_h + 100.0) / (5.0 * speed_km_h + 100.0)
    }
}

impl Effect for CastIron {
    fn spec(&self) -> &'static EffectSpec {
        &CAST_IRON
    }

    fn constants(&self, constants: &mut Constants) {
        self.wheel_radius_m.get_or_init(|| constants.wheel_radius_m);
    }

    fn brake_friction(&self, wheelset: usize, at: &Operating, _hidden: &[f64], friction: f64) -> f64 {
        let rim_m_s = match self.wheel_radius_m.get() {
            Some(radius_m) => radius_m[wheelset] * at.wheel_speed_rad_s[wheelset],
            None => at.v_m_s,
        };
        let tonnes = at.pressing_force_n[wheelset].max(0.0) / self.tonne_force_n;
        let relative = Self::law(3.6 * rim_m_s.abs(), tonnes) / Self::law(CAST_IRON_SPEED_KM_H, 1.0);
        friction * (1.0 + self.share * (relative - 1.0)).max(0.05)
    }
}

/// Thermal fade.
pub static FADE: EffectSpec = EffectSpec {
    id: "brake_fade",
    term: Term::BrakeFriction,
    equation: "mu = mu0 (1 - alpha max(0, T - T0 - T_on)), C d(T - T0)/dt = P_brake - C (T - T0) / tau, C = 60 kJ/K",
    source: "lumped disc temperature; organic pads lose 2e-4 to 1.5e-3 of their friction per kelvin (railwaynews.net/?p=221864 for the range of temperature)",
    parameters: &[
        ParameterSpec {
            name: "alpha_per_k",
            unit: "1/K",
            lower: 0.0,
            upper: 1e-2,
            default: 5e-4,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "onset_k",
            unit: "K",
            lower: 0.0,
            upper: 300.0,
            default: 0.0,
            starts: &[60.0],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "cooling_time_s",
            unit: "s",
            lower: 10.0,
            upper: 1000.0,
            default: FRICTION_RING_COOLING_S,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["temperature rise of each wheelset's discs, K"],
    twins: &[Twin::look_alike("brake_friction_speed"), Twin::look_alike("brake_wet_delay")],
    separated_by: "two stops from the same speed in quick succession, and one after a long cool-down",
};

/// See [`FADE`].
#[derive(Debug)]
pub struct Fade {
    alpha_per_k: f64,
    onset_k: f64,
    cooling_time_s: f64,
}

impl Fade {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { alpha_per_k: values[0], onset_k: values[1], cooling_time_s: values[2] })
    }
}

impl Effect for Fade {
    fn spec(&self) -> &'static EffectSpec {
        &FADE
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        MAX_WHEELSETS
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        let decay = (-dt_s / self.cooling_time_s).exp();
        for (rise, power) in hidden.iter_mut().zip(at.brake_power_w) {
            let steady = power * self.cooling_time_s / DISC_HEAT_CAPACITY_J_PER_K;
            *rise = steady + (*rise - steady) * decay;
        }
    }

    fn brake_friction(&self, wheelset: usize, _at: &Operating, hidden: &[f64], friction: f64) -> f64 {
        let hot = (hidden[wheelset] - self.onset_k).max(0.0);
        friction * (1.0 - self.alpha_per_k * hot).max(0.05)
    }
}

/// Friction that depends on the pressing force.
pub static PRESSURE: EffectSpec = EffectSpec {
    id: "brake_friction_pressure",
    term: Term::BrakeFriction,
    equation: "mu = mu0 ((F + F1) / (50 kN + F1))^-n",
    source: "speed, pressure and braked mass are the regressors of 10.3390/ma14164766; n of 0.05 to 0.2 is general knowledge; \
             n = 1 with F1 is a hyperbola, as Karwatzki's",
    parameters: &[
        ParameterSpec {
            name: "exponent",
            lower: -0.3,
            upper: 2.0,
            default: 0.1,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "levelling_force_n",
            unit: "N",
            lower: 0.0,
            upper: 5e5,
            prior_sigma: 5e4,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("pressing_force_offset")],
    separated_by: "steady braking at three or more pressing forces from light to full",
};

/// See [`PRESSURE`].
#[derive(Debug)]
pub struct Pressure {
    exponent: f64,
    levelling_force_n: f64,
}

/// Force at which the pressure law leaves the friction as it is, N.
const REFERENCE_FORCE_N: f64 = 5e4;
/// Below this force the law stays at its value here, N.
const SMALLEST_FORCE_N: f64 = 2e3;

impl Pressure {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { exponent: values[0], levelling_force_n: values[1] })
    }
}

impl Effect for Pressure {
    fn spec(&self) -> &'static EffectSpec {
        &PRESSURE
    }

    fn brake_friction(&self, wheelset: usize, at: &Operating, _hidden: &[f64], friction: f64) -> f64 {
        let force = at.pressing_force_n[wheelset].max(SMALLEST_FORCE_N);
        let ratio = (force + self.levelling_force_n) / (REFERENCE_FORCE_N + self.levelling_force_n);
        friction * ratio.powf(-self.exponent)
    }
}

/// Wet pads that grip late.
pub static WET_DELAY: EffectSpec = EffectSpec {
    id: "brake_wet_delay",
    term: Term::BrakeFriction,
    equation: "mu = mu0 (1 - d exp(-E / E0)), dE/dt = P_brake",
    source: "recovery of wet and iced pads with braking energy (Wear 523, 204764); d of 0.2 to 0.6 and E0 of 0.3 to 1 MJ are general knowledge",
    parameters: &[
        ParameterSpec {
            name: "loss",
            lower: 0.0,
            upper: 0.98,
            default: 0.3,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "drying_energy_j",
            unit: "J",
            lower: 2e4,
            upper: 6e6,
            default: 4e5,
            starts: &[1.5e6],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "on_dry_rail_too",
            lower: 0.0,
            upper: 1.0,
            default: 1.0,
            starts: &[1.0, 0.0],
            discrete: true,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["energy braked since the run began, of each wheelset, J"],
    twins: &[Twin::look_alike("brake_lag"), Twin::look_alike("brake_fade")],
    separated_by: "two brake applications in one run: dry pads grip at once in the second, a lag returns in both",
};

/// See [`WET_DELAY`].
#[derive(Debug)]
pub struct WetDelay {
    loss: f64,
    drying_energy_j: f64,
    on_dry_rail_too: bool,
}

impl WetDelay {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { loss: values[0], drying_energy_j: values[1], on_dry_rail_too: values[2] > 0.5 })
    }
}

impl Effect for WetDelay {
    fn spec(&self) -> &'static EffectSpec {
        &WET_DELAY
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        MAX_WHEELSETS
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        hidden.iter_mut().zip(at.brake_power_w).for_each(|(energy, power)| *energy += power * dt_s);
    }

    fn brake_friction(&self, wheelset: usize, at: &Operating, hidden: &[f64], friction: f64) -> f64 {
        if !self.on_dry_rail_too && at.adhesion_peak[wheelset] > DRY_RAIL_ADHESION {
            return friction;
        }
        friction * (1.0 - self.loss * (-hidden[wheelset] / self.drying_energy_j).exp())
    }
}
