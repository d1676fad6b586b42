//! Creep laws of the plants: how the force between wheel and rail saturates with creepage.
//!
//! Every law is a curve `g(x)` of the strain `x = K s / Q μ` (stiffness, creepage, load, friction) that rises from 0 to 1.
//! A data sheet states Polach's curve with `k_A = 1`, `k_S = 0.4`; each law here has a form of its own whose constants
//! bring it within 2 % of that curve, as a simulator's law is within a few percent of a measured one.

use super::set::FormSet;

/// Speed that bounds creepage near standstill, m/s.
const CREEPAGE_FLOOR_M_S: f64 = 0.3;

/// A curve of its own form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CreepLaw {
    /// A hyperbolic tangent beside a hyperbola.
    TangentAndHyperbola,
    /// Two strips that saturate as `x / √(1 + x²)`.
    TwoRoots,
    /// A cubic that ends (full slip after Johnson and Vermeulen) beside a hyperbola.
    CubicAndHyperbola,
    /// Three exponentials.
    ThreeExponentials,
    /// `x / (1 + x⁴)^¼` beside a hyperbola.
    QuarticAndHyperbola,
    /// `x / √(1 + x²)` beside a hyperbola.
    RootAndHyperbola,
    /// A parabola that ends (full slip after Carter) beside Langevin's function.
    ParabolaAndLangevin,
    /// A quotient of two quadratics.
    Quotient,
    /// The arctangent curve that data sheets state; for the reference model, never for a plant.
    Sheet,
}

/// Value and slope of a hyperbola `x / (1 + x)`.
fn hyperbola(x: f64) -> (f64, f64) {
    (x / (1.0 + x), 1.0 / ((1.0 + x) * (1.0 + x)))
}

/// Value and slope of `x / √(1 + x²)`.
fn root(x: f64) -> (f64, f64) {
    let root = (1.0 + x * x).sqrt();
    (x / root, 1.0 / (root * root * root))
}

/// Value and slope of `1 − e^{−x}`.
fn exponential(x: f64) -> (f64, f64) {
    let rest = (-x).exp();
    (1.0 - rest, rest)
}

/// Value and slope of Langevin's function `coth x − 1/x`.
fn langevin(x: f64) -> (f64, f64) {
    // Near zero the two terms cancel.
    if x < 0.01 {
        return (x / 3.0 - x * x * x / 45.0, 1.0 / 3.0 - x * x / 15.0);
    }
    let coth = 1.0 / x.tanh();
    (coth - 1.0 / x, 1.0 / (x * x) - (coth * coth - 1.0))
}

/// A curve: its value and slope at a strain.
type Curve = fn(f64) -> (f64, f64);

/// A weighted sum of curves, each of its own softness `(weight, softness, curve)`.
#[inline]
fn mix<const N: usize>(x: f64, parts: [(f64, f64, Curve); N]) -> (f64, f64) {
    parts.iter().fold((0.0, 0.0), |(value, slope), (weight, softness, curve)| {
        let (part, part_slope) = curve(softness * x);
        (value + weight * part, slope + weight * softness * part_slope)
    })
}

impl CreepLaw {
    /// The laws that plants have.
    pub const ALL: [Self; 8] = [
        Self::TangentAndHyperbola,
        Self::TwoRoots,
        Self::CubicAndHyperbola,
        Self::ThreeExponentials,
        Self::QuarticAndHyperbola,
        Self::RootAndHyperbola,
        Self::ParabolaAndLangevin,
        Self::Quotient,
    ];

    /// Name in labels.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::TangentAndHyperbola => "tangent_and_hyperbola",
            Self::TwoRoots => "two_roots",
            Self::CubicAndHyperbola => "cubic_and_hyperbola",
            Self::ThreeExponentials => "three_exponentials",
            Self::QuarticAndHyperbola => "quartic_and_hyperbola",
            Self::RootAndHyperbola => "root_and_hyperbola",
            Self::ParabolaAndLangevin => "parabola_and_langevin",
            Self::Quotient => "quotient",
            Self::Sheet => "sheet",
        }
    }

    /// The set of forms to which the law belongs.
    #[must_use]
    pub fn set(self) -> FormSet {
        match self {
            Self::TangentAndHyperbola | Self::TwoRoots | Self::Sheet => FormSet::A,
            Self::CubicAndHyperbola | Self::ThreeExponentials => FormSet::B,
            Self::QuarticAndHyperbola | Self::RootAndHyperbola => FormSet::C,
            Self::ParabolaAndLangevin | Self::Quotient => FormSet::D,
        }
    }

    /// The curve and its slope at a strain that is not negative; `tail` scales the softness of the part that saturates last.
    #[inline]
    #[must_use]
    pub fn curve(self, x: f64, tail: f64) -> (f64, f64) {
        match self {
            Self::TangentAndHyperbola => {
                let tangent = |x: f64| {
                    let value = x.tanh();
                    (value, 1.0 - value * value)
                };
                mix(x, [(0.36, 1.633, tangent), (0.64, 0.539 * tail, hyperbola)])
            }
            Self::TwoRoots => mix(x, [(0.661, 1.301, root), (0.339, 0.108 * tail, root)]),
            Self::CubicAndHyperbola => {
                let cubic = |x: f64| {
                    let left = (1.0 - x / 3.0).max(0.0);
                    (1.0 - left * left * left, left * left)
                };
                mix(x, [(0.341, 1.874, cubic), (0.659, 0.56 * tail, hyperbola)])
            }
            Self::ThreeExponentials => mix(
                x,
                [
                    (0.616, 1.619, exponential),
                    (0.324, 0.191 * tail, exponential),
                    (0.06, 0.023 * tail, exponential),
                ],
            ),
            Self::QuarticAndHyperbola => {
                let quartic = |x: f64| {
                    let inner = 1.0 + x * x * x * x;
                    let value = inner.sqrt().sqrt();
                    (x / value, 1.0 / (value * inner))
                };
                mix(x, [(0.296, 1.567, quartic), (0.704, 0.63 * tail, hyperbola)])
            }
            Self::RootAndHyperbola => mix(x, [(0.496, 1.463, root), (0.504, 0.404 * tail, hyperbola)]),
            Self::ParabolaAndLangevin => {
                let parabola = |x: f64| {
                    let left = (1.0 - 0.5 * x).max(0.0);
                    (1.0 - left * left, left)
                };
                mix(x, [(0.475, 1.691, parabola), (0.525, 0.628 * tail, langevin)])
            }
            Self::Quotient => {
                let (rise, middle, late) = (1.217, 1.405, 0.177 * tail);
                let below = 1.0 + x * (middle + late * x);
                let slope = (rise + late * x * (2.0 + (middle - rise) * x)) / (below * below);
                (x * (rise + late * x) / below, slope)
            }
            Self::Sheet => {
                let (s, scale) = (0.4 * tail * x, std::f64::consts::FRAC_2_PI);
                let area = 1.0 + x * x;
                let slope = (1.0 - x * x) / (area * area) + 0.4 * tail / (1.0 + s * s);
                (scale * (x / area + s.atan()), scale * slope)
            }
        }
    }

    /// Force on the wagon (forward positive, N) and its slope with slip velocity (N s/m), for a limit `Q μ` (N).
    #[inline]
    #[must_use]
    pub fn force(self, limit_n: f64, stiffness_n: f64, tail: f64, slip_m_s: f64, v_m_s: f64) -> (f64, f64) {
        let limit_n = limit_n.max(1.0);
        let reference_m_s = (v_m_s * v_m_s + CREEPAGE_FLOOR_M_S * CREEPAGE_FLOOR_M_S).sqrt();
        let strain_s_per_m = stiffness_n / (limit_n * reference_m_s);
        let (share, slope) = self.curve(strain_s_per_m * slip_m_s.abs(), tail);
        (limit_n * share.copysign(slip_m_s), limit_n * strain_s_per_m * slope)
    }
}
