//! How large errors are, where, and how long they last.

use super::rig::{RigSample, SAMPLE_PERIOD_S};

/// The paper's bound on the error of adhesion.
pub const BOUND: f64 = 0.02;

/// Time in which the filter settles after its start, s ("the first few tenths of a second").
pub const SETTLED_FROM_S: f64 = 0.5;

/// Time after an event in which the protection's effect on the estimate is counted to it, s.
const AFTER_EVENT_S: f64 = 0.2;

/// Errors of adhesion in a test.
#[derive(Clone, Copy, Debug, Default)]
pub struct Judgement {
    /// Largest outside of what the slide protection does.
    pub largest_outside: f64,
    /// Largest while it acts.
    pub largest_inside: f64,
    /// Root mean square of all.
    pub rms: f64,
    /// Root mean square while the wheelset comes back over the peak after a release.
    pub rms_reversing: f64,
    /// Longest time above [`BOUND`] at a stretch, s.
    pub longest_above_s: f64,
    /// Share of samples above [`BOUND`].
    pub share_above: f64,
}

/// Judges estimated adhesion against the truth.
pub fn judge(samples: &[RigSample], adhesion: impl Fn(usize) -> f64) -> Judgement {
    let mut judgement = Judgement::default();
    let (mut above_s, mut since_event_s) = (0.0f64, f64::INFINITY);
    let (mut count, mut reversing) = (0.0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        since_event_s =
            if sample.wsp_active || sample.reversing { 0.0 } else { since_event_s + SAMPLE_PERIOD_S };
        if sample.time_s < SETTLED_FROM_S {
            continue;
        }
        let error = (adhesion(k) - sample.adhesion).abs();
        count += 1.0;
        judgement.rms += error * error;
        if sample.reversing {
            reversing += 1.0;
            judgement.rms_reversing += error * error;
        }
        if since_event_s > AFTER_EVENT_S {
            judgement.largest_outside = judgement.largest_outside.max(error);
        } else {
            judgement.largest_inside = judgement.largest_inside.max(error);
        }
        above_s = if error > BOUND { above_s + SAMPLE_PERIOD_S } else { 0.0 };
        judgement.share_above += f64::from(error > BOUND);
        judgement.longest_above_s = judgement.longest_above_s.max(above_s);
    }
    judgement.rms = (judgement.rms / count).sqrt();
    judgement.rms_reversing = (judgement.rms_reversing / f64::max(reversing, 1.0)).sqrt();
    judgement.share_above /= count;
    judgement
}

impl Judgement {
    /// Several runs as one: the worst of what is largest, the mean of squares of what is a root mean square.
    pub fn pooled(of: &[Self]) -> Self {
        let mean = |pick: &dyn Fn(&Self) -> f64| of.iter().map(pick).sum::<f64>() / of.len().max(1) as f64;
        let worst = |pick: &dyn Fn(&Self) -> f64| of.iter().map(pick).fold(0.0, f64::max);
        Self {
            largest_outside: worst(&|one| one.largest_outside),
            largest_inside: worst(&|one| one.largest_inside),
            rms: mean(&|one| one.rms * one.rms).sqrt(),
            rms_reversing: mean(&|one| one.rms_reversing * one.rms_reversing).sqrt(),
            longest_above_s: worst(&|one| one.longest_above_s),
            share_above: mean(&|one| one.share_above),
        }
    }
}
