//! Effects on the adhesion available and on its shape over slip.

use super::{Effect, EffectSpec, Operating, ParameterSpec, Term, Twin, window_share};
use crate::adhesion::{ASYMPTOTE_SHARE, SPEED_DECAY_S_PER_M, share_of_standstill};
use crate::wagon::Constants;

/// Friction that falls with slip velocity.
pub static FALLING: EffectSpec = EffectSpec {
    id: "falling_friction",
    term: Term::Adhesion,
    equation: "mu = mu0 [(1 - A) exp(-B w) + A], w = |r omega - v|",
    source: "Polach, Wear 258 (2005): A = 0.4, B = 0.6 / 0.2 / 0.2 / 0.1 s/m on dry / wet / low / very low rail",
    parameters: &[
        ParameterSpec {
            name: "friction_ratio",
            lower: 0.05,
            upper: 1.0,
            default: 0.6,
            neutral: Some(1.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "friction_decay_s_per_m",
            unit: "s/m",
            lower: 0.02,
            upper: 5.0,
            default: 0.3,
            starts: &[1.5],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("adhesion_speed"), Twin::look_alike("self_cleaning")],
    separated_by: "deep slides at constant speed: a law of slip velocity retraces its path, cleaning makes a loop",
};

/// See [`FALLING`].
#[derive(Debug)]
pub struct Falling {
    friction_ratio: f64,
    friction_decay_s_per_m: f64,
}

impl Falling {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { friction_ratio: values[0], friction_decay_s_per_m: values[1] })
    }
}

impl Effect for Falling {
    fn spec(&self) -> &'static EffectSpec {
        &FALLING
    }

    fn constants(&self, constants: &mut Constants) {
        constants.contact.friction_ratio = self.friction_ratio;
        constants.contact.friction_decay_s_per_m = self.friction_decay_s_per_m;
    }
}

/// Following wheelsets find cleaner rail.
pub static SELF_CLEANING: EffectSpec = EffectSpec {
    id: "self_cleaning",
    term: Term::Adhesion,
    equation: "mu0 of following wheelsets times 1 + k0 + k1 (1 - exp(-P_slip,front / 5 kW))",
    source: "cleaning by slip energy, 10.1007/s11012-013-9839-z and 10.1080/00423114.2014.961488; gains of 0 to 50 % are general knowledge",
    parameters: &[
        ParameterSpec {
            name: "gain",
            lower: 0.0,
            upper: 2.0,
            default: 0.1,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "gain_in_slip",
            lower: 0.0,
            upper: 2.0,
            default: 0.05,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("load_transfer"), Twin::look_alike("falling_friction")],
    separated_by: "the same braking with the other end leading, or on dry rail where there is nothing to clean",
};

/// See [`SELF_CLEANING`].
#[derive(Debug)]
pub struct SelfCleaning {
    gain: f64,
    gain_in_slip: f64,
}

/// Slip power at which the front wheelset cleans well, W.
const CLEANING_POWER_W: f64 = 5e3;

impl SelfCleaning {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { gain: values[0], gain_in_slip: values[1] })
    }
}

impl Effect for SelfCleaning {
    fn spec(&self) -> &'static EffectSpec {
        &SELF_CLEANING
    }

    fn adhesion_peak(&self, wheelset: usize, at: &Operating, _hidden: &[f64], peak: f64) -> f64 {
        if wheelset == 0 {
            return peak;
        }
        let cleaned = 1.0 - (-at.slip_power_w[0] / CLEANING_POWER_W).exp();
        peak * (1.0 + self.gain + self.gain_in_slip * cleaned).max(0.05)
    }
}

/// A stretch of slippery rail.
pub static PATCH: EffectSpec = EffectSpec {
    id: "low_adhesion_patch",
    term: Term::Adhesion,
    equation: "mu0 times 1 - d for x in [x0, x0 + L] with edges of length e, at each wheelset's own position",
    source: "leaves and oil leave 0.02 to 0.08 over 10 to 200 m; general knowledge",
    parameters: &[
        ParameterSpec {
            name: "start_m",
            unit: "m",
            lower: -50.0,
            upper: 20000.0,
            default: 150.0,
            starts: &[50.0, 300.0, 500.0],
            // A wheelset feels where a stretch begins to less than a metre.
            scale: Some(25.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "length_m",
            unit: "m",
            lower: 4.0,
            upper: 2000.0,
            default: 60.0,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "loss",
            lower: 0.0,
            upper: 0.97,
            default: 0.3,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        // How sharply leaves or oil begin is not known.
        ParameterSpec {
            name: "edge_m",
            unit: "m",
            lower: 1.0,
            upper: 100.0,
            default: 3.0,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
        // Who keeps one position for a whole wagon, as some simulators do, finds the stretch under all wheelsets at once.
        ParameterSpec {
            name: "spread",
            lower: 0.0,
            upper: 1.0,
            default: 1.0,
            starts: &[0.0],
            scale: Some(1.0),
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("grade")],
    separated_by: "a second pass over the stretch at another speed, and one without braking: only a grade acts then",
};

/// See [`PATCH`].
#[derive(Debug)]
pub struct Patch {
    start_m: f64,
    length_m: f64,
    loss: f64,
    edge_m: f64,
    /// How far wheelsets are from the position of the wagon, relative to where they are: one, or zero for one position for all.
    spread: f64,
}

impl Patch {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self {
            start_m: values[0],
            length_m: values[1],
            loss: values[2],
            edge_m: values[3],
            spread: values[4],
        })
    }
}

impl Effect for Patch {
    fn spec(&self) -> &'static EffectSpec {
        &PATCH
    }

    fn adhesion_peak(&self, wheelset: usize, at: &Operating, _hidden: &[f64], peak: f64) -> f64 {
        let position_m = at.position_m + self.spread * at.wheelset_position_m[wheelset];
        let inside = window_share(position_m, self.start_m, self.length_m, self.edge_m);
        peak * (1.0 - self.loss * inside)
    }
}

/// Adhesion that falls with vehicle speed, towards an asymptote and not towards zero.
pub static SPEED: EffectSpec = EffectSpec {
    id: "adhesion_speed",
    term: Term::Adhesion,
    equation: "mu0 times f(v) / f(15 m/s), f = a + (1 - a) / (1 + v c)",
    source: "Curtius & Kniffler (1944), 7.5 / (3.6 v + 44) + 0.161: a = 0.486, c = 0.082 s/m",
    parameters: &[
        ParameterSpec {
            name: "decay_s_per_m",
            unit: "s/m",
            lower: 0.0,
            upper: 1.0,
            default: SPEED_DECAY_S_PER_M,
            neutral: Some(0.0),
            starts: &[0.02],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "asymptote_share",
            lower: 0.0,
            upper: 0.95,
            default: ASYMPTOTE_SHARE,
            // Wide enough for a rail that keeps next to nothing at speed, if the runs say so.
            prior_sigma: 0.2,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("falling_friction")],
    separated_by: "slides of the same depth at high and at low speed",
};

/// See [`SPEED`].
#[derive(Debug)]
pub struct Speed {
    decay_s_per_m: f64,
    asymptote_share: f64,
}

/// Speed at which the law leaves the adhesion as it is, m/s.
const REFERENCE_SPEED_M_S: f64 = 15.0;

impl Speed {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { decay_s_per_m: values[0], asymptote_share: values[1] })
    }
}

impl Effect for Speed {
    fn spec(&self) -> &'static EffectSpec {
        &SPEED
    }

    fn adhesion_peak(&self, _wheelset: usize, at: &Operating, _hidden: &[f64], peak: f64) -> f64 {
        let share = |v_m_s: f64| share_of_standstill(v_m_s, self.decay_s_per_m, self.asymptote_share);
        peak * share(at.v_m_s.max(0.0)) / share(REFERENCE_SPEED_M_S)
    }
}

/// Sand between wheel and rail.
pub static SANDING: EffectSpec = EffectSpec {
    id: "sanding",
    term: Term::Adhesion,
    equation: "mu0 times 1 + g s, tau ds/dt = sanding - s",
    source: "adhesion recovers within seconds of sanding (Schwarz & Keck; 10.3390/2075-4442/13/6/270 for amounts)",
    parameters: &[
        ParameterSpec {
            name: "gain",
            lower: 0.0,
            upper: 5.0,
            default: 0.3,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "build_up_s",
            unit: "s",
            lower: 0.01,
            upper: 10.0,
            default: 0.3,
            starts: &[2.0],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["sand on the rail, 0 to 1"],
    twins: &[Twin::look_alike("self_cleaning")],
    separated_by: "the same slide with and without sand",
};

/// See [`SANDING`].
#[derive(Debug)]
pub struct Sanding {
    gain: f64,
    build_up_s: f64,
}

impl Sanding {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { gain: values[0], build_up_s: values[1] })
    }
}

impl Effect for Sanding {
    fn spec(&self) -> &'static EffectSpec {
        &SANDING
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        1
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        hidden[0] = at.sanding;
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        hidden[0] += (at.sanding - hidden[0]) * (1.0 - (-dt_s / self.build_up_s).exp());
    }

    fn adhesion_peak(&self, _wheelset: usize, _at: &Operating, hidden: &[f64], peak: f64) -> f64 {
        peak * (1.0 + self.gain * hidden[0])
    }
}
