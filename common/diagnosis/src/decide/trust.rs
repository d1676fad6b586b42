//! How far the likeliest set after a test is believed.
//!
//! What a test says of sets follows from the models that were fitted, and the truth may be none of them. A law of another form, or a second
//! effect that nobody named, makes one wrong model better than the other wrong ones; what is left of the gap then tells that
//! it is wrong. How far that goes is learnt from tests whose answer is known, by logistic regression.

use crate::decide::newton;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// What the likeliest set is believed by: one, its log-odds after the test, and ln of what its model leaves of the gap over what a
/// right model would leave; the last is zero for something unknown, which leaves whatever there is.
pub type Ground = Vector3<f64>;

/// Least distance of a probability from 0 and 1 whose log-odds count; set by hand.
const LEAST: f64 = 0.01;
/// ln of what is left of the gap over a right model's, within which it counts; set by hand.
const LEFT: [f64; 2] = [0.0, 1.6];

/// The grounds of a set of this probability whose model leaves `left` times what a right model would leave.
pub fn ground(p: f64, left: Option<f64>) -> Ground {
    let p = p.clamp(LEAST, 1.0 - LEAST);
    let left = left.filter(|left| left.is_finite() && *left > 0.0).map_or(0.0, f64::ln);
    Vector3::new(1.0, (p / (1.0 - p)).ln(), left.clamp(LEFT[0], LEFT[1]))
}

/// From grounds to a probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trust {
    /// Log-odds of a set that is as likely as not and leaves what a right model would.
    pub offset: f64,
    /// Log-odds for each unit of its log-odds.
    pub slope: f64,
    /// Log-odds for each factor of e that its model leaves beyond a right model's gap.
    pub left: f64,
}

impl Default for Trust {
    fn default() -> Self {
        Self::PLAIN
    }
}

impl Trust {
    /// What the test says, as it is.
    pub const PLAIN: Self = Self { offset: 0.0, slope: 1.0, left: 0.0 };
    /// Widths of the prior around it, set by hand: few tests move little.
    const WIDTHS: [f64; 3] = [1.0, 0.5, 1.0];

    /// Probability on these grounds.
    pub fn probability(&self, ground: &Ground) -> f64 {
        1.0 / (1.0 + (-Vector3::new(self.offset, self.slope, self.left).dot(ground)).exp())
    }

    /// The likeliest trust for sets of which it is known whether they were the truth (Newton's method).
    pub fn fit(likeliest: &[(Ground, bool)]) -> Self {
        let prior = Vector3::new(Self::PLAIN.offset, Self::PLAIN.slope, Self::PLAIN.left);
        let precision = Matrix3::from_diagonal(&Vector3::from(Self::WIDTHS).map(|width| width.powi(-2)));
        let cost = |at: &Vector3<f64>| {
            let off = at - prior;
            let of = |(ground, right): &(Ground, bool)| {
                let along = at.dot(ground);
                (if *right { -along } else { along }).exp().ln_1p()
            };
            0.5 * off.dot(&(precision * off)) + likeliest.iter().map(of).sum::<f64>()
        };
        let slopes = |at: &Vector3<f64>| {
            let (mut gradient, mut curvature) = (precision * (at - prior), precision);
            for (x, right) in likeliest {
                let p = 1.0 / (1.0 + (-at.dot(x)).exp());
                gradient += x * (p - f64::from(u8::from(*right)));
                curvature += x * x.transpose() * (p * (1.0 - p));
            }
            (gradient, curvature)
        };
        let at = newton::least(prior, cost, slopes);
        Self { offset: at[0], slope: at[1], left: at[2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn trust_is_learnt_and_few_tests_move_little() {
        let truth = Trust { offset: -0.4, slope: 0.6, left: -1.5 };
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let mut taught = |number: usize| -> Vec<(Ground, bool)> {
            let one = |_| {
                let at = ground(random.random(), Some((1.6 * random.random::<f64>()).exp()));
                (at, random.random::<f64>() < truth.probability(&at))
            };
            (0..number).map(one).collect()
        };
        let learnt = Trust::fit(&taught(4000));
        println!("{learnt:?} of {truth:?}");
        assert!((learnt.offset - truth.offset).abs() < 0.2);
        assert!((learnt.slope - truth.slope).abs() < 0.15);
        assert!((learnt.left - truth.left).abs() < 0.3);
        assert_eq!(Trust::fit(&[]), Trust::PLAIN);
        let few = Trust::fit(&taught(3));
        assert!((few.slope - 1.0).abs() < 0.5 && few.left.abs() < 1.0, "{few:?}");
    }

    #[test]
    fn what_is_not_known_of_a_gap_counts_nothing() {
        for left in [None, Some(f64::NAN), Some(f64::INFINITY), Some(0.0), Some(-1.0), Some(0.7)] {
            assert!(ground(0.5, left)[2].abs() < 1e-12, "{left:?}");
        }
        assert!((ground(0.5, Some(100.0))[2] - 1.6).abs() < 1e-12);
        assert!(ground(1.0, None)[1].is_finite() && ground(0.0, None)[1].is_finite());
        assert!((Trust::PLAIN.probability(&ground(0.8, Some(3.0))) - 0.8).abs() < 1e-12);
    }
}
