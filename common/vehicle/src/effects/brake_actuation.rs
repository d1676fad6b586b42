//! Effects between measured cylinder pressure and the force on the pad.

use super::delay::DelayLine;
use super::{Effect, EffectSpec, Operating, ParameterSpec, Term, Twin};
use crate::wagon::Constants;
use crate::{MAX_WHEELSETS, PerWheelset};
use std::sync::OnceLock;

/// Longest dead time that can be fitted, s.
const LONGEST_DEAD_TIME_S: f64 = 1.0;

/// The pad force follows the measured pressure late.
pub static LAG: EffectSpec = EffectSpec {
    id: "brake_lag",
    term: Term::BrakeActuation,
    equation: "tau dF_pad/dt = F(t - t_d) - F_pad",
    source: "first order and dead time as in 10.1243/0954409041319632 and 10.1080/23248378.2021.2006808; 0.05 to 0.5 s between cylinder and pad is general knowledge",
    parameters: &[
        ParameterSpec {
            name: "time_constant_s",
            unit: "s",
            lower: 0.0,
            upper: 3.0,
            default: 0.2,
            neutral: Some(0.0),
            starts: &[0.03],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "dead_time_s",
            unit: "s",
            lower: 0.0,
            upper: LONGEST_DEAD_TIME_S,
            default: 0.05,
            neutral: Some(0.0),
            starts: &[0.25],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["delayed and lagged pad force of each wheelset, N"],
    twins: &[
        Twin::look_alike("brake_wet_delay"),
        Twin::look_alike("speed_latency"),
        Twin::look_alike("rigging_hysteresis"),
    ],
    separated_by: "several applications and releases at two rates; a torque cell shows force without torque",
};

/// See [`LAG`].
#[derive(Debug)]
pub struct Lag {
    time_constant_s: f64,
    dead_time_s: f64,
    /// Share of the force of this very step that arrives within it.
    fresh: f64,
}

impl Lag {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        let fresh = (-(values[0] + values[1]) / 0.005).exp();
        Box::new(Self { time_constant_s: values[0], dead_time_s: values[1], fresh })
    }
}

impl Effect for Lag {
    fn spec(&self) -> &'static EffectSpec {
        &LAG
    }

    fn hidden_len(&self, sample_period_s: f64) -> usize {
        MAX_WHEELSETS + DelayLine::len(LONGEST_DEAD_TIME_S, sample_period_s)
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        let (lagged, line) = hidden.split_at_mut(MAX_WHEELSETS);
        lagged.copy_from_slice(&at.pressing_force_n);
        DelayLine::fill(line, &at.pressing_force_n);
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        let (lagged, line) = hidden.split_at_mut(MAX_WHEELSETS);
        DelayLine::push(line, &at.pressing_force_n);
        let share = 1.0 - (-dt_s / self.time_constant_s.max(1e-6)).exp();
        let delayed = DelayLine::read(line, self.dead_time_s / dt_s);
        lagged.iter_mut().zip(delayed).for_each(|(force, target)| *force += (target - *force) * share);
    }

    fn pad_force_n(&self, wheelset: usize, _at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        // Without lag the state holds the sample before this step: hand through what the step adds to it.
        hidden[wheelset] + self.fresh * (force_n - hidden[wheelset])
    }
}

/// Friction and play of the rigging: the pad force depends on whether pressure rises or falls.
pub static HYSTERESIS: EffectSpec = EffectSpec {
    id: "rigging_hysteresis",
    term: Term::BrakeActuation,
    equation: "F_pad stays within [F (1 - h) - H, F (1 + h) + H] and moves only when pushed by its ends",
    source: "caliper efficiency measured with load cells, 10.1177/1687814015616086; 3 to 10 % is general knowledge",
    parameters: &[
        ParameterSpec {
            name: "relative_half_width",
            lower: 0.0,
            upper: 0.4,
            default: 0.05,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "half_width_n",
            unit: "N",
            lower: 0.0,
            upper: 2e4,
            default: 500.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["pad force of each wheelset, N"],
    twins: &[Twin::look_alike("brake_lag")],
    separated_by: "pressure ramps up and down at two rates: the loop of hysteresis does not depend on the rate",
};

/// See [`HYSTERESIS`].
#[derive(Debug)]
pub struct Hysteresis {
    relative_half_width: f64,
    half_width_n: f64,
}

impl Hysteresis {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { relative_half_width: values[0], half_width_n: values[1] })
    }

    fn hold(&self, pad_force_n: f64, force_n: f64) -> f64 {
        // A fit may step a hair below none, and a sensor at rest may read less than nothing.
        let half = (self.relative_half_width * force_n + self.half_width_n).max(0.0);
        pad_force_n.clamp((force_n - half).max(0.0), (force_n + half).max(0.0))
    }
}

impl Effect for Hysteresis {
    fn spec(&self) -> &'static EffectSpec {
        &HYSTERESIS
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        MAX_WHEELSETS
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        hidden.iter_mut().zip(at.pressing_force_n).for_each(|(pad, force)| *pad = self.hold(0.0, force));
    }

    fn advance(&self, at: &Operating, _dt_s: f64, hidden: &mut [f64]) {
        hidden.iter_mut().zip(at.pressing_force_n).for_each(|(pad, force)| *pad = self.hold(*pad, force));
    }

    fn pad_force_n(&self, wheelset: usize, _at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        self.hold(hidden[wheelset], force_n)
    }
}

/// Pads touch only above a threshold of measured force.
pub static OFFSET: EffectSpec = EffectSpec {
    id: "pressing_force_offset",
    term: Term::BrakeActuation,
    equation: "F_pad = max(0, F - F0)",
    source: "return springs and zero error of the pressure sensor, 1 to 2 % of full scale; general knowledge",
    parameters: &[ParameterSpec {
        name: "threshold_n",
        unit: "N",
        lower: 0.0,
        upper: 4e4,
        default: 3e3,
        neutral: Some(0.0),
        ..ParameterSpec::PLAIN
    }],
    hidden: &[],
    twins: &[Twin::look_alike("brake_friction_pressure")],
    separated_by: "very light brake applications around the threshold, and steady braking at three levels",
};

/// See [`OFFSET`].
#[derive(Debug)]
pub struct Offset {
    threshold_n: f64,
}

impl Offset {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { threshold_n: values[0] })
    }
}

impl Effect for Offset {
    fn spec(&self) -> &'static EffectSpec {
        &OFFSET
    }

    fn pad_force_n(&self, _wheelset: usize, _at: &Operating, _hidden: &[f64], force_n: f64) -> f64 {
        // A negative threshold (the sensor reads low) adds only where the brake is applied at all.
        let applied = if self.threshold_n < 0.0 { (force_n / -self.threshold_n).min(1.0) } else { 1.0 };
        (force_n - self.threshold_n * applied).max(0.0)
    }
}

/// A brake that does not release.
pub static DRAGGING: EffectSpec = EffectSpec {
    id: "dragging_brake",
    term: Term::BrakeActuation,
    equation: "T_B,i = mu F r_B + T_drag on one wheelset, always",
    source: "hot-wheel detectors find tens to hundreds of newton metres; general knowledge",
    parameters: &[
        ParameterSpec {
            name: "torque_nm",
            unit: "N m",
            lower: 0.0,
            upper: 8e3,
            default: 200.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        WHEELSET,
    ],
    hidden: &[],
    twins: &[Twin::look_alike("running_resistance")],
    separated_by: "coasting with one wheelset on a low-adhesion rail or lifted: only the dragging one slows by itself",
};

/// Slide protection that vents the cylinder behind the pressure sensor.
pub static DUMP: EffectSpec = EffectSpec {
    id: "pressure_dump",
    term: Term::BrakeActuation,
    equation: "F_pad = F (1 - d x), dx/dt = (1 - x)/T while the wheelset slides by more than 5 %, -x/(3 T) else",
    source: "dump valves between sensor and cylinder vent within tenths of a second and fill more slowly (EN 15595 asks for less than \
             0.25 s of venting); general knowledge",
    parameters: &[
        ParameterSpec {
            name: "depth",
            lower: 0.0,
            upper: 1.0,
            default: 0.4,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "venting_time_s",
            unit: "s",
            lower: 0.05,
            upper: 2.0,
            default: 0.3,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["share that is vented of each wheelset"],
    twins: &[Twin::look_alike("falling_friction"), Twin::look_alike("low_adhesion_patch")],
    separated_by: "a slide with the slide protection switched off",
};

/// See [`DUMP`].
#[derive(Debug)]
pub struct Dump {
    depth: f64,
    venting_time_s: f64,
    /// Rolling radius of each wheelset of the model, m, known once it is built.
    wheel_radius_m: OnceLock<PerWheelset>,
}

/// Creepage from which the slide protection vents.
const VENTS: f64 = 0.05;
/// Filling takes so many times as long as venting.
const FILLS_SLOWER: f64 = 3.0;
/// Vehicle speed below which slide protection is off, m/s.
const PROTECTED_M_S: f64 = 1.5;

impl Dump {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { depth: values[0], venting_time_s: values[1], wheel_radius_m: OnceLock::new() })
    }
}

impl Effect for Dump {
    fn spec(&self) -> &'static EffectSpec {
        &DUMP
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        MAX_WHEELSETS
    }

    fn constants(&self, constants: &mut Constants) {
        self.wheel_radius_m.get_or_init(|| constants.wheel_radius_m);
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        let Some(radius_m) = self.wheel_radius_m.get() else { return };
        let (vent, fill) =
            ((-dt_s / self.venting_time_s).exp(), (-dt_s / (FILLS_SLOWER * self.venting_time_s)).exp());
        for (i, vented) in hidden.iter_mut().enumerate() {
            let slide_m_s = at.v_m_s - radius_m[i] * at.wheel_speed_rad_s[i];
            let slides = at.v_m_s > PROTECTED_M_S && slide_m_s > VENTS * at.v_m_s;
            *vented = if slides { 1.0 - (1.0 - *vented) * vent } else { *vented * fill };
        }
    }

    fn pad_force_n(&self, wheelset: usize, _at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        force_n * (1.0 - self.depth * hidden[wheelset])
    }
}

/// Which wheelset, counted from the front.
pub(super) const WHEELSET: ParameterSpec = ParameterSpec {
    name: "wheelset",
    lower: 1.0,
    upper: 4.0,
    default: 1.0,
    starts: &[1.0, 2.0, 3.0, 4.0],
    discrete: true,
    ..ParameterSpec::PLAIN
};

/// See [`DRAGGING`].
#[derive(Debug)]
pub struct Dragging {
    torque_nm: f64,
    wheelset: usize,
}

impl Dragging {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { torque_nm: values[0], wheelset: values[1] as usize - 1 })
    }
}

impl Effect for Dragging {
    fn spec(&self) -> &'static EffectSpec {
        &DRAGGING
    }

    fn brake_torque_nm(&self, wheelset: usize, _at: &Operating, _hidden: &[f64], torque_nm: f64) -> f64 {
        if wheelset == self.wheelset { torque_nm + self.torque_nm } else { torque_nm }
    }
}
