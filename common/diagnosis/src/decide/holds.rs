//! What the truth holds where a verdict was given: nothing, known effects alone, or something unknown.
//!
//! A verdict says so by how often it did in cases with known answers; how much freeing the likeliest place of the equations gains
//! over the calibrated model leans it further. Where that is nothing there is hardly anything, whatever cannot be named.

use crate::answer::schema::Report;
use crate::decide::newton;
use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

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
    /// Mean of [`place_evidence`] of the cases that were counted.
    #[serde(default)]
    pub place: f64,
}

impl Holds {
    /// Three alike, for a verdict that was never counted.
    pub const EVEN: Self = Self { none: 1.0 / 3.0, known: 1.0 / 3.0, unknown: 1.0 / 3.0, place: 0.0 };

    /// None, known and unknown.
    fn shares(&self) -> [f64; 3] {
        [self.none, self.known, self.unknown]
    }

    /// The shares for a case with this [`place_evidence`]; as they were counted where there is none.
    pub fn leant(&self, lean: &Lean, place: Option<f64>) -> Self {
        let Some(place) = place else { return *self };
        let more = place - self.place;
        let [none, known, unknown] = self.shares();
        let (known, unknown) = (known * (lean.known * more).exp(), unknown * (lean.unknown * more).exp());
        let sum = none + known + unknown;
        Self { none: none / sum, known: known / sum, unknown: unknown / sum, place }
    }
}

/// How the evidence of the likeliest place leans the shares of a verdict: log-odds against none for each unit of
/// [`place_evidence`] above the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lean {
    /// Of known effects.
    pub known: f64,
    /// Of something unknown.
    pub unknown: f64,
}

/// ln(1 + evidence) of the place whose freeing gains most over the calibrated model; `None` where a report does not say.
pub fn place_evidence(report: &Report) -> Option<f64> {
    report.evidence.map(|evidence| evidence.place_evidence.max(0.0).ln_1p()).filter(|place| place.is_finite())
}

/// A case to learn from: the shares of its verdict, its [`place_evidence`], and which of the three it held.
pub type Held = (Holds, f64, usize);

impl Lean {
    /// Width of the prior around no lean.
    const WIDTH: f64 = 0.7;

    /// The likeliest lean for cases of which it is known what they held (Newton's method).
    pub fn fit(cases: &[Held]) -> Self {
        let precision = Self::WIDTH.powi(-2);
        let shares = |at: &Vector2<f64>, (holds, place, _): &Held| {
            holds.leant(&Self { known: at[0], unknown: at[1] }, Some(*place)).shares()
        };
        let cost = |at: &Vector2<f64>| {
            let of = |case: &Held| -shares(at, case)[case.2].max(f64::MIN_POSITIVE).ln();
            0.5 * precision * at.norm_squared() + cases.iter().map(of).sum::<f64>()
        };
        let slopes = |at: &Vector2<f64>| {
            let mut gradient = at * precision;
            let mut curvature = Matrix2::identity() * precision;
            for case in cases {
                let more = case.1 - case.0.place;
                let [_, known, unknown] = shares(at, case);
                let p = Vector2::new(known, unknown);
                let held = Vector2::new(f64::from(u8::from(case.2 == 1)), f64::from(u8::from(case.2 == 2)));
                gradient += (p - held) * more;
                curvature += (Matrix2::from_diagonal(&p) - p * p.transpose()) * more.powi(2);
            }
            (gradient, curvature)
        };
        let at = newton::least(Vector2::zeros(), cost, slopes);
        Self { known: at[0], unknown: at[1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    const NONE: Holds = Holds { none: 0.8, known: 0.12, unknown: 0.08, place: 1.0 };

    #[test]
    fn a_lean_is_learnt() {
        let truth = Lean { known: 0.6, unknown: 0.9 };
        let mut random = Pcg64Mcg::seed_from_u64(11);
        let cases: Vec<Held> = (0..6000)
            .map(|_| {
                let place = 6.0 * random.random::<f64>();
                let [none, known, _] = NONE.leant(&truth, Some(place)).shares();
                let drawn = random.random::<f64>();
                (NONE, place, if drawn < none { 0 } else { 1 + usize::from(drawn > none + known) })
            })
            .collect();
        let found = Lean::fit(&cases);
        println!("{found:?}");
        assert!((found.known - truth.known).abs() < 0.08 && (found.unknown - truth.unknown).abs() < 0.08);
    }

    #[test]
    fn a_place_that_errs_makes_none_less_probable() {
        let lean = Lean { known: 0.5, unknown: 0.3 };
        let at = |place| NONE.leant(&lean, Some(place));
        assert!(at(4.0).none < NONE.none && NONE.none < at(0.0).none);
        assert!(at(9.0).unknown > NONE.unknown && (at(9.0).shares().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(NONE.leant(&lean, None), NONE, "a report without evidence is as it was counted");
        assert!(Lean::fit(&[]) == Lean::default());
    }
}
