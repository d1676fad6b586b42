//! Forces along the track that do not come from the wagon itself.

use super::{Effect, EffectSpec, Operating, ParameterSpec, Term, Twin};
use crate::resistance::grade_acceleration;

/// A neighbour in the train pushes and pulls.
pub static COUPLER: EffectSpec = EffectSpec {
    id: "coupler_force",
    term: Term::LongitudinalForce,
    equation: "x'' = a + g i - r b + F/M, T db/dt = min(a + g i, 0) - b, F = -M (w^2 (x - s sgn x) + 2 zeta w x') beyond |x| = s, w = 2 pi f",
    source: "neighbour of mass M without motors on a spring and damper with slack s, whose brakes act T later and r times as much; coupler dynamics of 0.2 to 5 Hz, slack up to 30 mm; general knowledge",
    parameters: &[
        ParameterSpec {
            name: "mass_kg",
            unit: "kg",
            lower: 0.0,
            upper: 1e5,
            default: 3e3,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "frequency_hz",
            unit: "Hz",
            lower: 0.05,
            upper: 8.0,
            default: 0.5,
            starts: &[0.15, 1.5, 3.5],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "damping_ratio",
            lower: 0.01,
            upper: 2.0,
            default: 0.15,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "neighbour_lag_s",
            unit: "s",
            lower: 0.05,
            upper: 20.0,
            default: 1.5,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "neighbour_brake_ratio",
            lower: 0.0,
            upper: 2.0,
            default: 1.0,
            starts: &[0.75, 1.3],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "slack_m",
            unit: "m",
            lower: 0.0,
            upper: 0.03,
            default: 0.0,
            starts: &[0.008],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["x, m", "dx/dt, m/s", "b, m/s^2"],
    twins: &[Twin::look_alike("grade"), Twin::look_alike("running_resistance")],
    separated_by: "the wagon alone, uncoupled, in the same braking",
};

/// See [`COUPLER`].
#[derive(Debug)]
pub struct Coupler {
    mass_kg: f64,
    angular_rad_s: f64,
    damping_ratio: f64,
    neighbour_lag_s: f64,
    neighbour_brake_ratio: f64,
    slack_m: f64,
}

impl Coupler {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self {
            mass_kg: values[0],
            angular_rad_s: std::f64::consts::TAU * values[1],
            damping_ratio: values[2],
            neighbour_lag_s: values[3],
            neighbour_brake_ratio: values[4],
            slack_m: values[5],
        })
    }
}

/// The wagon's own acceleration by brakes, not positive: a neighbour without motors does not share the rest.
fn braking_m_s2(at: &Operating) -> f64 {
    (at.acceleration_m_s2 - grade_acceleration(at.grade_rad)).min(0.0)
}

impl Coupler {
    /// How far the coupler is stretched or pressed beyond its slack; `None` within.
    fn beyond_slack_m(&self, stretch_m: f64) -> Option<f64> {
        (stretch_m.abs() >= self.slack_m).then(|| stretch_m - self.slack_m.copysign(stretch_m))
    }
}

impl Effect for Coupler {
    fn spec(&self) -> &'static EffectSpec {
        &COUPLER
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        3
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        hidden[2] = braking_m_s2(at);
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        let w = self.angular_rad_s;
        let drive =
            at.acceleration_m_s2 - grade_acceleration(at.grade_rad) - self.neighbour_brake_ratio * hidden[2];
        let (x, speed) = (hidden[0], hidden[1]);
        // Implicit in the oscillator: stable at any frequency. Between its stops the coupler passes no force.
        hidden[1] = match self.beyond_slack_m(x) {
            Some(beyond_m) => {
                let implicit = 1.0 + dt_s * (2.0 * self.damping_ratio * w + dt_s * w * w);
                (speed + dt_s * (drive - w * w * beyond_m)) / implicit
            }
            None => speed + dt_s * drive,
        };
        hidden[0] = x + dt_s * hidden[1];
        hidden[2] += (braking_m_s2(at) - hidden[2]) * (1.0 - (-dt_s / self.neighbour_lag_s).exp());
    }

    fn body_force_n(&self, _at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        let w = self.angular_rad_s;
        self.beyond_slack_m(hidden[0]).map_or(force_n, |beyond_m| {
            force_n - self.mass_kg * (w * w * beyond_m + 2.0 * self.damping_ratio * w * hidden[1])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MASS_KG: f64 = 2e4;

    /// Force on the wagon after five seconds at a steady acceleration, N.
    fn settled_n(acceleration_m_s2: f64, ratio: f64, slack_m: f64) -> f64 {
        let coupler = Coupler::boxed(&[MASS_KG, 1.0, 0.7, 0.3, ratio, slack_m]);
        let mut hidden = [0.0; 3];
        coupler.start(&Operating::default(), &mut hidden);
        let at = Operating { acceleration_m_s2, ..Operating::default() };
        (0..500).for_each(|_| coupler.advance(&at, 0.01, &mut hidden));
        coupler.body_force_n(&at, &hidden, 0.0)
    }

    #[test]
    fn a_neighbour_is_pulled_in_traction_and_brakes_for_itself() {
        let pulled = settled_n(0.5, 1.0, 0.0);
        assert!((pulled / (-0.5 * MASS_KG) - 1.0).abs() < 0.01, "{pulled}");
        let alike = settled_n(-1.0, 1.0, 0.0);
        assert!(alike.abs() < 0.02 * MASS_KG, "{alike}");
        let weaker = settled_n(-1.0, 0.8, 0.0);
        assert!(
            (weaker / (0.2 * MASS_KG) - 1.0).abs() < 0.05,
            "a neighbour that brakes less pushes: {weaker}"
        );
    }

    #[test]
    fn slack_delays_but_does_not_change_a_steady_pull() {
        let (tight, slack) = (settled_n(0.5, 1.0, 0.0), settled_n(0.5, 1.0, 0.02));
        assert!((slack / tight - 1.0).abs() < 0.05, "{tight} {slack}");
        let coupler = Coupler::boxed(&[MASS_KG, 1.0, 0.7, 0.3, 1.0, 0.02]);
        assert_eq!(coupler.body_force_n(&Operating::default(), &[0.01, 0.1, 0.0], 5.0), 5.0);
    }
}
