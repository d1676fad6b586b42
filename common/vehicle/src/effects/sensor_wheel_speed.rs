//! Effects on the measurement of wheelset speeds.

use super::delay::DelayLine;
use super::{Effect, EffectSpec, Lateness, Observation, Operating, ParameterSpec, Term, Twin};
use crate::MAX_WHEELSETS;

/// Once-per-revolution error of an encoder.
pub static ECCENTRICITY: EffectSpec = EffectSpec {
    id: "wheel_encoder_eccentricity",
    term: Term::SensorWheelSpeed,
    equation: "omega_read = omega (1 + s sin(theta) + c cos(theta) + s2 sin(2 theta) + c2 cos(2 theta))",
    source: "pole wheels run out by 0.1 to 0.5 %, and are a little oval; once-per-revolution theory after Kavanagh",
    parameters: &[
        ParameterSpec {
            name: "sine",
            lower: -0.05,
            upper: 0.05,
            default: 0.001,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "cosine",
            lower: -0.05,
            upper: 0.05,
            default: 0.001,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "second_sine",
            lower: -0.02,
            upper: 0.02,
            prior_sigma: 0.003,
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "second_cosine",
            lower: -0.02,
            upper: 0.02,
            prior_sigma: 0.003,
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "wheelset",
            lower: 0.0,
            upper: 4.0,
            default: 1.0,
            starts: &[1.0, 2.0, 3.0, 4.0, 0.0],
            discrete: true,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("axle_torsion")],
    separated_by: "coasting down slowly: the ripple follows the wheel angle, a resonance keeps its frequency",
};

/// See [`ECCENTRICITY`]; wheelset 0 means all alike.
#[derive(Debug)]
pub struct Eccentricity {
    first: [f64; 2],
    second: [f64; 2],
    wheelset: usize,
}

impl Eccentricity {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        let (first, second) = ([values[0], values[1]], [values[2], values[3]]);
        Box::new(Self { first, second, wheelset: values[4] as usize })
    }
}

impl Effect for Eccentricity {
    fn spec(&self) -> &'static EffectSpec {
        &ECCENTRICITY
    }

    fn observe(&self, at: &Operating, _hidden: &[f64], reading: &mut Observation) {
        for (i, speed) in reading.wheel_speed_rad_s.iter_mut().enumerate() {
            if self.wheelset == 0 || self.wheelset == i + 1 {
                let (sin, cos) = at.wheel_angle_rad[i].sin_cos();
                let (sin2, cos2) = (2.0 * sin * cos, cos * cos - sin * sin);
                let wave = |[s, c]: [f64; 2], sin: f64, cos: f64| s * sin + c * cos;
                *speed *= 1.0 + wave(self.first, sin, cos) + wave(self.second, sin2, cos2);
            }
        }
    }
}

/// Longest counting window that can be fitted, s.
const LONGEST_WINDOW_S: f64 = 1.0;

/// Speeds counted over a window.
pub static WINDOW: EffectSpec = EffectSpec {
    id: "wheel_encoder_window",
    term: Term::SensorWheelSpeed,
    equation: "omega_read(t) = mean of omega over [t - T, t]",
    source: "a counter read 8 times a second averages over 125 ms (Shrestha et al.)",
    parameters: &[ParameterSpec {
        name: "window_s",
        unit: "s",
        lower: 0.0,
        upper: LONGEST_WINDOW_S,
        default: 0.1,
        neutral: Some(0.0),
        starts: &[0.3],
        ..ParameterSpec::PLAIN
    }],
    hidden: &["past wheelset speeds, rad/s"],
    twins: &[
        Twin::look_alike("clock_skew"),
        Twin::look_alike("speed_latency"),
        Twin::look_alike("brake_lag"),
    ],
    separated_by: "WSP cycles: a mean over a window blunts the peaks, a shift in time does not",
};

/// See [`WINDOW`].
#[derive(Debug)]
pub struct Window {
    window_s: f64,
}

/// Sample period that the delay lines of the sensors assume where only the reading is at hand, s.
const SAMPLE_PERIOD_S: f64 = 0.01;

impl Window {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { window_s: values[0] })
    }
}

impl Effect for Window {
    fn spec(&self) -> &'static EffectSpec {
        &WINDOW
    }

    fn hidden_len(&self, sample_period_s: f64) -> usize {
        1 + DelayLine::len(LONGEST_WINDOW_S, sample_period_s)
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        hidden[0] = SAMPLE_PERIOD_S;
        DelayLine::fill(&mut hidden[1..], &at.wheel_speed_rad_s);
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        hidden[0] = dt_s;
        DelayLine::push(&mut hidden[1..], &at.wheel_speed_rad_s);
    }

    fn observe(&self, _at: &Operating, hidden: &[f64], reading: &mut Observation) {
        // The line ends one sample before the reading: mean over the rest of the window, and the present value.
        let samples = self.window_s / hidden[0];
        if samples < 1e-9 {
            return;
        }
        let past = DelayLine::mean(&hidden[1..], samples);
        let fresh = 1.0 / (1.0 + samples);
        for i in 0..MAX_WHEELSETS {
            reading.wheel_speed_rad_s[i] += (past[i] - reading.wheel_speed_rad_s[i]) * (1.0 - fresh);
        }
    }

    fn lateness(&self, _time_s: f64) -> Lateness {
        Lateness { wheel_speed_s: 0.5 * self.window_s, wheel_speed_mean_s: self.window_s, v_s: 0.0 }
    }

    fn correct(&self, at: &Operating, _hidden: &[f64], state: &mut Observation) {
        for i in 0..MAX_WHEELSETS {
            state.wheel_speed_rad_s[i] += 0.5 * self.window_s * at.wheel_acceleration_rad_s2[i];
        }
    }
}

/// Longest lag between the two clocks that can be fitted, s.
const LONGEST_SKEW_S: f64 = 2.0;

/// The clock of the wheel-speed channels drifts against the clock of vehicle speed.
pub static CLOCK_SKEW: EffectSpec = EffectSpec {
    id: "clock_skew",
    term: Term::SensorWheelSpeed,
    equation: "omega_read(t) = omega(t - t0 - d t)",
    source: "oscillators drift by 10 to 100 ppm, loggers that resample by far more; deliveries differ by 10 to 30 ms",
    parameters: &[
        ParameterSpec {
            name: "drift",
            lower: -0.05,
            upper: 0.05,
            default: 1e-3,
            neutral: Some(0.0),
            starts: &[-1e-3],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "offset_s",
            unit: "s",
            lower: -0.5,
            upper: 1.0,
            default: 0.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["past wheelset speeds, rad/s"],
    twins: &[Twin::look_alike("wheel_encoder_window"), Twin::look_alike("speed_latency")],
    separated_by: "one long run: a skew grows with time, a latency does not",
};

/// See [`CLOCK_SKEW`].
#[derive(Debug)]
pub struct ClockSkew {
    drift: f64,
    offset_s: f64,
}

impl ClockSkew {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { drift: values[0], offset_s: values[1] })
    }

    fn lag_s(&self, time_s: f64) -> f64 {
        self.offset_s + self.drift * time_s
    }
}

impl Effect for ClockSkew {
    fn spec(&self) -> &'static EffectSpec {
        &CLOCK_SKEW
    }

    fn hidden_len(&self, sample_period_s: f64) -> usize {
        1 + DelayLine::len(LONGEST_SKEW_S, sample_period_s)
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        hidden[0] = SAMPLE_PERIOD_S;
        DelayLine::fill(&mut hidden[1..], &at.wheel_speed_rad_s);
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        hidden[0] = dt_s;
        DelayLine::push(&mut hidden[1..], &at.wheel_speed_rad_s);
    }

    fn observe(&self, at: &Operating, hidden: &[f64], reading: &mut Observation) {
        let lag = self.lag_s(at.time_s);
        let samples = lag / hidden[0];
        if samples <= 0.0 {
            for i in 0..MAX_WHEELSETS {
                reading.wheel_speed_rad_s[i] -= lag * at.wheel_acceleration_rad_s2[i];
            }
            return;
        }
        // The newest entry of the line is one sample old.
        let (past, share) = if samples < 1.0 {
            (DelayLine::read(&hidden[1..], 0.0), samples)
        } else {
            (DelayLine::read(&hidden[1..], samples - 1.0), 1.0)
        };
        for i in 0..MAX_WHEELSETS {
            reading.wheel_speed_rad_s[i] += (past[i] - reading.wheel_speed_rad_s[i]) * share;
        }
    }

    fn lateness(&self, time_s: f64) -> Lateness {
        Lateness { wheel_speed_s: self.lag_s(time_s), ..Lateness::default() }
    }

    fn correct(&self, at: &Operating, _hidden: &[f64], state: &mut Observation) {
        let lag = self.lag_s(at.time_s);
        for i in 0..MAX_WHEELSETS {
            state.wheel_speed_rad_s[i] += lag * at.wheel_acceleration_rad_s2[i];
        }
    }
}
