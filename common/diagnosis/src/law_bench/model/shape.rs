//! Shapes that a dependence may have: how a level changes with one variable, relative to an anchor.
//!
//! A bench tells *which variable* a law depends on long before it tells the exact formula. Every candidate therefore
//! comes in several forms of two or three parameters and one flexible spline; the data pick the form, and the
//! first form of a candidate is preferred while no other is clearly better.

use crate::law_bench::data::point::Spread;

/// Number of free values of the spline.
pub const SPLINE_LEN: usize = 3;

/// Smallest factor that a form returns, so that a level never changes sign.
const FLOOR: f64 = 0.02;

/// A shape of dependence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// `A + (1 − A) exp(−x/x0)`: Stribeck, Polach's falling friction.
    Exponential,
    /// `1 + d exp(−x/x0)`: the catalogue's friction over speed; the anchor lies at infinity.
    Rise,
    /// `(1 + c anchor) / (1 + c x)`: the catalogue's adhesion over speed.
    Hyperbola,
    /// `(1 + A x/x0) / (1 + x/x0)`: Curtius & Kniffler, Karwatzki.
    Rational,
    /// `A + (1 − A) exp(−(x/x0)²)`.
    Gaussian,
    /// `1 − c (x − anchor)`.
    Linear,
    /// `1 − c (x − anchor) − d (x − anchor)²`.
    Quadratic,
    /// `1 − a / (1 + exp(−(x − xc)/w))`: a step over a soft edge.
    Step,
    /// `1 − c · softplus((x − xc)/w) · w`: nothing up to a threshold, then linear.
    Ramp,
    /// `(x / anchor)^−n`.
    Power,
    /// `exp(Σ β_i N_i(x))` with natural cubic splines over four knots.
    Spline,
    /// Not a factor: Polach's k_A and k_S themselves.
    CreepShape,
}

/// What a shape is anchored and scaled by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Value of x at which the factor is 1.
    pub anchor: f64,
    /// Spread of x in the fit data.
    pub spread: Spread,
}

/// A parameter of a form.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Name; the unit is in it.
    pub name: &'static str,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Whether the optimiser sees the logarithm.
    pub log: bool,
}

impl Shape {
    /// Number of parameters.
    pub const fn parameters(self) -> usize {
        match self {
            Self::Linear | Self::Power | Self::Hyperbola => 1,
            Self::Exponential | Self::Rise | Self::Rational | Self::Gaussian => 2,
            Self::Quadratic | Self::CreepShape => 2,
            Self::Step | Self::Ramp | Self::Spline => 3,
        }
    }

    /// The law in one line, with `x` for the variable.
    pub const fn equation(self) -> &'static str {
        match self {
            Self::Exponential => "A + (1 - A) exp(-x/x0)",
            Self::Rise => "1 + d exp(-x/x0)",
            Self::Hyperbola => "(1 + c anchor) / (1 + c x)",
            Self::Rational => "(1 + A x/x0) / (1 + x/x0)",
            Self::Gaussian => "A + (1 - A) exp(-(x/x0)^2)",
            Self::Linear => "1 - c (x - anchor)",
            Self::Quadratic => "1 - c (x - anchor) - d (x - anchor)^2",
            Self::Step => "1 - a / (1 + exp(-(x - xc)/w))",
            Self::Ramp => "1 - c w ln(1 + exp((x - xc)/w))",
            Self::Power => "(x / anchor)^-n",
            Self::Spline => "exp(natural cubic spline of x, 4 knots)",
            Self::CreepShape => "k_A and k_S of Polach's law",
        }
    }

    /// The factor at `x`.
    pub fn factor(self, x: f64, values: &[f64], scale: &Scale) -> f64 {
        let raw = match self {
            Self::Exponential => values[0] + (1.0 - values[0]) * (-x * values[1]).exp(),
            Self::Rise => 1.0 + values[0] * (-x / values[1]).exp(),
            Self::Hyperbola => (1.0 + values[0] * scale.anchor) / (1.0 + values[0] * x).max(FLOOR),
            Self::Rational => (1.0 + values[0] * x / values[1]) / (1.0 + x / values[1]),
            Self::Gaussian => values[0] + (1.0 - values[0]) * (-(x / values[1]).powi(2)).exp(),
            Self::Linear => 1.0 - values[0] * (x - scale.anchor),
            Self::Quadratic => {
                let away = x - scale.anchor;
                1.0 - values[0] * away - values[1] * away * away
            }
            Self::Step => 1.0 - values[0] / (1.0 + (-(x - values[1]) / values[2]).exp()),
            Self::Ramp => 1.0 - values[0] * values[2] * softplus((x - values[1]) / values[2]),
            Self::Power => (x.max(1e-9 * scale.anchor) / scale.anchor).powf(-values[0]),
            Self::Spline => {
                let at = natural_spline(x, &scale.spread.quantiles);
                let anchor = natural_spline(scale.anchor, &scale.spread.quantiles);
                let exponent: f64 =
                    values.iter().zip(at.iter().zip(anchor)).map(|(b, (n, a))| b * (n - a)).sum();
                exponent.clamp(-4.0, 4.0).exp()
            }
            Self::CreepShape => 1.0,
        };
        raw.max(FLOOR)
    }

    /// Deterministic starting points, in units that suit the spread of x.
    pub fn starts(self, scale: &Scale) -> Vec<Vec<f64>> {
        let (low, high, width) = (scale.spread.low, scale.spread.high, scale.spread.width());
        let reach = high.abs().max(width);
        match self {
            Self::Exponential => product(&[0.6, 1.25], &[0.5, 3.0, 12.0].map(|turns| turns / reach)),
            Self::Rise => product(&[0.4, -0.15], &[0.1, 0.3, 1.5].map(|share| share * reach)),
            Self::Hyperbola => vec![vec![0.3 / reach], vec![-0.2 / reach]],
            Self::Rational => product(&[0.4, 1.4], &[0.05, 0.3, 1.5].map(|share| share * reach)),
            Self::Gaussian => product(&[0.6, 1.25], &[0.1, 0.4, 0.8].map(|share| share * reach)),
            Self::Linear => vec![vec![0.2 / width], vec![-0.1 / width]],
            Self::Quadratic => vec![vec![0.1 / width, 0.0], vec![0.0, 0.1 / (width * width)]],
            Self::Step => {
                [0.25, 0.5, 0.75].iter().map(|&share| vec![0.2, low + share * width, 0.1 * width]).collect()
            }
            Self::Ramp => [0.2, 0.5, 0.7]
                .iter()
                .map(|&share| vec![0.3 / width, low + share * width, 0.05 * width])
                .collect(),
            Self::Power => vec![vec![0.1], vec![-0.1]],
            Self::Spline => vec![vec![-0.1, 0.0, 0.0], vec![0.1, 0.0, 0.0]],
            Self::CreepShape => vec![vec![1.0, 0.4], vec![1.0, 1.0], vec![0.5, 0.3], vec![0.3, 0.1]],
        }
    }

    /// Directions of the shape near "no effect", for the test against chance: each is the derivative of the factor with
    /// respect to its amplitude at one value of the other parameters. The spline gives one block of directions.
    pub fn directions(self, scale: &Scale) -> Vec<Direction> {
        let single = |amplitude: Vec<Vec<f64>>, step: f64| {
            let small = |values: Vec<f64>| Direction { values: vec![values], step };
            amplitude.into_iter().map(small).collect::<Vec<_>>()
        };
        let (low, high, width) = (scale.spread.low, scale.spread.high, scale.spread.width());
        let reach = high.abs().max(width);
        let grid = |from: f64, to: f64, n: usize| -> Vec<f64> {
            (0..n).map(|i| from * (to / from).powf(i as f64 / (n - 1) as f64)).collect()
        };
        match self {
            Self::Exponential => {
                single(grid(0.3, 40.0, 8).into_iter().map(|turns| vec![0.99, turns / reach]).collect(), 0.01)
            }
            Self::Rise => {
                single(grid(0.03, 3.0, 8).into_iter().map(|share| vec![0.01, share * reach]).collect(), 0.01)
            }
            Self::Hyperbola => single(vec![vec![0.01 / reach]], 0.01),
            Self::Rational => {
                single(grid(0.02, 3.0, 6).into_iter().map(|s| vec![0.99, s * reach]).collect(), 0.01)
            }
            Self::Gaussian => {
                single(grid(0.05, 1.5, 6).into_iter().map(|s| vec![0.99, s * reach]).collect(), 0.01)
            }
            Self::Linear => single(vec![vec![0.01 / width]], 0.01),
            Self::Power => single(vec![vec![0.01]], 0.01),
            Self::Step => {
                let mut all = Vec::new();
                for share in [0.15, 0.3, 0.5, 0.7, 0.85] {
                    for soft in [0.03, 0.1, 0.3] {
                        all.push(vec![0.01, low + share * width, soft * width]);
                    }
                }
                single(all, 0.01)
            }
            Self::Ramp => {
                let shares = [0.1, 0.3, 0.5, 0.7, 0.85];
                single(shares.map(|s| vec![0.01 / width, low + s * width, 0.03 * width]).to_vec(), 0.01)
            }
            Self::Quadratic => {
                let values = vec![vec![0.01 / width, 0.0], vec![0.0, 0.01 / (width * width)]];
                vec![Direction { values, step: 0.01 }]
            }
            Self::Spline => {
                let values = (0..SPLINE_LEN)
                    .map(|i| (0..SPLINE_LEN).map(|j| if i == j { 0.01 } else { 0.0 }).collect())
                    .collect();
                vec![Direction { values, step: 0.01 }]
            }
            Self::CreepShape => Vec::new(),
        }
    }
}

/// A block of directions: the factor minus one at `values`, over `step`.
#[derive(Clone, Debug)]
pub struct Direction {
    /// Parameter values close to "no effect", one vector for each direction of the block.
    pub values: Vec<Vec<f64>>,
    /// Size of the deviation.
    pub step: f64,
}

fn product(first: &[f64], second: &[f64]) -> Vec<Vec<f64>> {
    first.iter().flat_map(|&a| second.iter().map(move |&b| vec![a, b])).collect()
}

fn softplus(x: f64) -> f64 {
    if x > 30.0 { x } else { x.exp().ln_1p() }
}

/// Natural cubic spline basis without its constant, on knots scaled to [0, 1]: linear beyond the outer knots.
///
/// Source: Hastie, Tibshirani & Friedman, The Elements of Statistical Learning, eqs. (5.4), (5.5).
pub fn natural_spline(x: f64, knots: &[f64; 4]) -> [f64; SPLINE_LEN] {
    let width = knots[3] - knots[0];
    let z = (x - knots[0]) / width;
    let knot = knots.map(|k| (k - knots[0]) / width);
    let cube = |k: f64| (z - k).max(0.0).powi(3);
    let d = |k: usize| (cube(knot[k]) - cube(knot[3])) / (knot[3] - knot[k]);
    [z, d(0) - d(2), d(1) - d(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(anchor: f64) -> Scale {
        let spread = Spread { low: 0.0, median: 10.0, high: 20.0, quantiles: [1.0, 7.0, 13.0, 19.0] };
        Scale { anchor, spread }
    }

    #[test]
    fn every_factor_is_one_at_its_anchor() {
        let zero = scale(0.0);
        assert!((Shape::Exponential.factor(0.0, &[0.4, 0.3], &zero) - 1.0).abs() < 1e-12);
        assert!((Shape::Rational.factor(0.0, &[0.4, 3.0], &zero) - 1.0).abs() < 1e-12);
        assert!((Shape::Gaussian.factor(0.0, &[0.4, 3.0], &zero) - 1.0).abs() < 1e-12);
        let ten = scale(10.0);
        assert!((Shape::Linear.factor(10.0, &[0.02], &ten) - 1.0).abs() < 1e-12);
        assert!((Shape::Power.factor(10.0, &[0.2], &ten) - 1.0).abs() < 1e-12);
        assert!((Shape::Spline.factor(10.0, &[0.2, -0.3, 0.4], &ten) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_rational_form_holds_curtius_and_kniffler() {
        let ratio = railgrip_vehicle::adhesion::curtius_kniffler(20.0)
            / railgrip_vehicle::adhesion::curtius_kniffler(0.0);
        let asymptote = 0.161 / (7.5 / 44.0 + 0.161);
        let ours = Shape::Rational.factor(20.0, &[asymptote, 44.0 / 3.6], &scale(0.0));
        assert!((ours - ratio).abs() < 1e-12, "{ours} {ratio}");
    }

    #[test]
    fn the_spline_is_straight_beyond_its_knots() {
        let knots = [1.0, 7.0, 13.0, 19.0];
        for i in 0..SPLINE_LEN {
            let at = |x: f64| natural_spline(x, &knots)[i];
            assert!((at(30.0) - 2.0 * at(25.0) + at(20.0)).abs() < 1e-9);
        }
    }
}
