//! What the truth holds where a verdict was given: nothing, known effects alone, or something unknown.
//!
//! A verdict says so by how often it did in cases with known answers; two signs lean it further: how much freeing the likeliest place of
//! the equations gains over the calibrated model, and how much more of the gap is left than a right model would leave. Where
//! both are nothing there is hardly anything, whatever cannot be named.

use crate::answer::schema::Report;
use crate::decide::newton;
use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};
use serde::{Deserialize, Serialize};

/// What is left of the gap over what a right model would leave, within which it counts; set by hand.
const LEFT: [f64; 2] = [0.9, 3.0];

/// ln of what the extended model leaves over what a right one would; `None` in reports that do not say.
pub(super) fn left_over(report: &Report) -> Option<f64> {
    report.gap.left().map(|left| left.clamp(LEFT[0], LEFT[1]).ln())
}

/// What the truth holds where a verdict was given; shares that add up to one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Holds {
    /// Nothing beyond tolerances that could be seen.
    pub none: f64,
    /// Effects that the library knows, and nothing else.
    pub known: f64,
    /// Something that the library does not know.
    pub unknown: f64,
    /// Mean of [`Signs::place`] of the cases that were counted.
    #[serde(default)]
    pub place: f64,
    /// Mean of their [`Signs::left`].
    #[serde(default)]
    pub left: f64,
}

impl Holds {
    /// Three alike, for a verdict that was never counted.
    pub const EVEN: Self =
        Self { none: 1.0 / 3.0, known: 1.0 / 3.0, unknown: 1.0 / 3.0, place: 0.0, left: 0.0 };

    /// None, known and unknown.
    pub(super) fn shares(&self) -> [f64; 3] {
        [self.none, self.known, self.unknown]
    }

    /// By how much the signs of a case exceed the mean; nothing where there is none.
    fn beyond(&self, signs: &Signs) -> Vector2<f64> {
        let over = |sign: Option<f64>, mean: f64| sign.map_or(0.0, |sign| sign - mean);
        Vector2::new(over(signs.place, self.place), over(signs.left, self.left))
    }

    /// The shares for a case with these signs; as they were counted where it has none.
    pub fn leant(&self, lean: &Lean, signs: &Signs) -> Self {
        let beyond = self.beyond(signs);
        let [none, known, unknown] = self.shares();
        let known = known * Vector2::new(lean.known, lean.known_left).dot(&beyond).exp();
        let unknown = unknown * Vector2::new(lean.unknown, lean.unknown_left).dot(&beyond).exp();
        let sum = none + known + unknown;
        Self { none: none / sum, known: known / sum, unknown: unknown / sum, ..*self }
    }
}

/// How signs lean the shares of a verdict: log-odds against none for each unit above the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lean {
    /// Of known effects, for each unit of [`Signs::place`].
    pub known: f64,
    /// Of something unknown.
    pub unknown: f64,
    /// Of known effects, for each unit of [`Signs::left`].
    #[serde(default)]
    pub known_left: f64,
    /// Of something unknown.
    #[serde(default)]
    pub unknown_left: f64,
}

/// What leans the shares of a verdict; absent in reports that do not say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signs {
    /// ln(1 + evidence) of the place whose freeing gains most over the calibrated model.
    pub place: Option<f64>,
    /// ln of the gap that the extended model leaves over that which a right model would leave.
    pub left: Option<f64>,
}

impl Signs {
    /// The signs of a report.
    pub fn of(report: &Report) -> Self {
        let place = report.evidence.map(|evidence| evidence.place_evidence.max(0.0).ln_1p());
        Self { place: place.filter(|place| place.is_finite()), left: left_over(report) }
    }
}

/// A case to learn from: the shares of its verdict, its signs, and which of the three it held.
pub type Held = (Holds, Signs, usize);

impl Lean {
    /// Widest prior around no lean.
    const WIDTHS: [f64; 2] = [0.7, 3.0];

    /// The likeliest lean for cases of which it is known what they held (Newton's method), with a prior of this share of the widest.
    pub fn fit(cases: &[Held], width: f64) -> Self {
        let widths = width * Vector4::new(Self::WIDTHS[0], Self::WIDTHS[0], Self::WIDTHS[1], Self::WIDTHS[1]);
        let precision = Matrix4::from_diagonal(&widths.map(|width| width.powi(-2)));
        let lean =
            |at: &Vector4<f64>| Self { known: at[0], unknown: at[1], known_left: at[2], unknown_left: at[3] };
        let shares = |at: &Vector4<f64>, (holds, signs, _): &Held| holds.leant(&lean(at), signs).shares();
        let cost = |at: &Vector4<f64>| {
            let of = |case: &Held| -shares(at, case)[case.2].max(f64::MIN_POSITIVE).ln();
            0.5 * at.dot(&(precision * at)) + cases.iter().map(of).sum::<f64>()
        };
        let slopes = |at: &Vector4<f64>| {
            let (mut gradient, mut curvature) = (precision * at, precision);
            for case in cases {
                let beyond = case.0.beyond(&case.1);
                let [_, known, unknown] = shares(at, case);
                let p = Vector2::new(known, unknown);
                let held = Vector2::new(f64::from(u8::from(case.2 == 1)), f64::from(u8::from(case.2 == 2)));
                gradient += beyond.kronecker(&(p - held));
                curvature += (beyond * beyond.transpose())
                    .kronecker(&(Matrix2::from_diagonal(&p) - p * p.transpose()));
            }
            (gradient, curvature)
        };
        lean(&newton::least(Vector4::zeros(), cost, slopes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    const NONE: Holds = Holds { none: 0.8, known: 0.12, unknown: 0.08, place: 1.0, left: 0.1 };

    fn signs(place: f64, left: f64) -> Signs {
        Signs { place: Some(place), left: Some(left) }
    }

    #[test]
    fn a_lean_is_learnt() {
        let truth = Lean { known: 0.6, unknown: 0.9, known_left: 1.0, unknown_left: 3.0 };
        let mut random = Pcg64Mcg::seed_from_u64(11);
        let cases: Vec<Held> = (0..6000)
            .map(|_| {
                let signs = signs(6.0 * random.random::<f64>(), random.random::<f64>());
                let [none, known, _] = NONE.leant(&truth, &signs).shares();
                let drawn = random.random::<f64>();
                (NONE, signs, if drawn < none { 0 } else { 1 + usize::from(drawn > none + known) })
            })
            .collect();
        let found = Lean::fit(&cases, 1.0);
        println!("{found:?}");
        assert!((found.known - truth.known).abs() < 0.08 && (found.unknown - truth.unknown).abs() < 0.08);
        assert!((found.known_left - 1.0).abs() < 0.3 && (found.unknown_left - 3.0).abs() < 0.3);
    }

    #[test]
    fn a_place_that_errs_and_a_gap_that_is_left_make_none_less_probable() {
        let lean = Lean { known: 0.5, unknown: 0.3, known_left: 0.5, unknown_left: 2.0 };
        let at = |place, left| NONE.leant(&lean, &signs(place, left));
        assert!(at(4.0, 0.1).none < NONE.none && NONE.none < at(0.0, 0.1).none);
        assert!(at(1.0, 0.6).none < NONE.none && NONE.none < at(1.0, -0.1).none);
        let sum: f64 = at(9.0, 0.4).shares().iter().sum();
        assert!(at(9.0, 0.4).unknown > NONE.unknown && (sum - 1.0).abs() < 1e-12);
        assert_eq!(NONE.leant(&lean, &Signs::default()), NONE, "a report without signs is as it was counted");
        assert!(Lean::fit(&[], 1.0) == Lean::default());
    }
}
