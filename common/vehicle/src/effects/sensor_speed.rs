//! Effects on the measurement of vehicle speed.

use super::delay::DelayLine;
use super::{Effect, EffectSpec, Lateness, Observation, Operating, ParameterSpec, Term, Twin};

/// Longest latency that can be fitted, s.
const LONGEST_LATENCY_S: f64 = 1.5;

/// Vehicle speed comes late.
pub static LATENCY: EffectSpec = EffectSpec {
    id: "speed_latency",
    term: Term::SensorSpeed,
    equation: "v_read(t) = v(t - tau)",
    source: "satellite receivers give Doppler speed about 0.15 s late",
    parameters: &[ParameterSpec {
        name: "latency_s",
        unit: "s",
        lower: 0.0,
        upper: LONGEST_LATENCY_S,
        default: 0.15,
        neutral: Some(0.0),
        starts: &[0.5],
        ..ParameterSpec::PLAIN
    }],
    hidden: &["past vehicle speed relative to now, m/s"],
    twins: &[
        Twin::look_alike("clock_skew"),
        Twin::look_alike("wheel_encoder_window"),
        Twin::look_alike("brake_lag"),
    ],
    separated_by: "abrupt changes of deceleration at known times, with wheelset speeds beside",
};

/// See [`LATENCY`].
#[derive(Debug)]
pub struct Latency {
    latency_s: f64,
}

impl Latency {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { latency_s: values[0] })
    }

    /// How much the speed changed over the latency.
    fn change_m_s(&self, hidden: &[f64]) -> f64 {
        let total = hidden[1];
        total - DelayLine::read(&hidden[2..], self.latency_s / hidden[0])[0]
    }
}

impl Effect for Latency {
    fn spec(&self) -> &'static EffectSpec {
        &LATENCY
    }

    fn hidden_len(&self, sample_period_s: f64) -> usize {
        2 + DelayLine::len(LONGEST_LATENCY_S, sample_period_s)
    }

    fn start(&self, _at: &Operating, hidden: &mut [f64]) {
        hidden[0] = 0.01;
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        // The line holds the integral of acceleration: the speed's past without the noise and offset of its sensor.
        hidden[0] = dt_s;
        hidden[1] += at.acceleration_m_s2 * dt_s;
        let total = hidden[1];
        DelayLine::push(&mut hidden[2..], &[total, 0.0, 0.0, 0.0]);
    }

    fn observe(&self, _at: &Operating, hidden: &[f64], reading: &mut Observation) {
        reading.v_m_s -= self.change_m_s(hidden);
    }

    fn lateness(&self, _time_s: f64) -> Lateness {
        Lateness { v_s: self.latency_s, ..Lateness::default() }
    }

    fn correct(&self, _at: &Operating, hidden: &[f64], state: &mut Observation) {
        state.v_m_s += self.change_m_s(hidden);
    }
}

/// Vehicle speed has a wrong scale.
pub static SCALE: EffectSpec = EffectSpec {
    id: "speed_scale",
    term: Term::SensorSpeed,
    equation: "v_read = v (1 + e)",
    source: "a radar read up to 0.47 km/h off at 130 km/h (mtt.org); general knowledge for 0.2 to 2 %",
    parameters: &[ParameterSpec {
        name: "relative_error",
        lower: -0.1,
        upper: 0.1,
        default: 0.005,
        neutral: Some(0.0),
        ..ParameterSpec::PLAIN
    }],
    hidden: &[],
    twins: &[Twin::look_alike("wheel_radius")],
    separated_by: "coasting past two points of known distance",
};

/// See [`SCALE`].
#[derive(Debug)]
pub struct Scale {
    relative_error: f64,
}

impl Scale {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { relative_error: values[0] })
    }
}

impl Effect for Scale {
    fn spec(&self) -> &'static EffectSpec {
        &SCALE
    }

    fn observe(&self, _at: &Operating, _hidden: &[f64], reading: &mut Observation) {
        reading.v_m_s *= 1.0 + self.relative_error;
    }

    fn correct(&self, _at: &Operating, _hidden: &[f64], state: &mut Observation) {
        state.v_m_s /= 1.0 + self.relative_error;
    }
}
