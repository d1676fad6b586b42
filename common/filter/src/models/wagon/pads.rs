//! The pads of all wheelsets in the covariance: what they have in common, and what sets one apart.

use crate::PriorSettings;

/// Variances of the prior of pad friction: of the mean over the wheelsets, and of one against that mean.
pub(super) fn pad_prior_variances<const W: usize>(priors: &PriorSettings, nominal: f64) -> (f64, f64) {
    let split = if W > 1 { priors.pad_split * nominal } else { 0.0 };
    ((priors.pad_common * nominal).powi(2), split * split)
}

/// Entry of the covariance of the pads from the variances of mean and deviation.
#[inline]
pub(super) fn pad_entry<const W: usize>(common: f64, split: f64, diagonal: bool) -> f64 {
    if diagonal { common + split } else { common - split / (W as f64 - 1.0) }
}
