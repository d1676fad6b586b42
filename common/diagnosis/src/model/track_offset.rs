//! Offsets between what each recording shows as position and the track.
//!
//! Satellite positions are off by one to two metres, slowly, and by another amount in each recording. Where a rail begins to give
//! less, a wheelset that slides some hundredths of a second earlier or later is off by tens of sigmas, so that what a stretch of
//! track does to adhesion is fitted together with one offset a recording. Runs that are only predicted have none.

use railgrip_vehicle::Constants;
use railgrip_vehicle::effects::{Effect, EffectSpec, Lateness, Observation, Operating, Term};

/// Offset of a recording, one sigma, m: of the slow error of satellite positions, which the contract of cases says is 1 to 2 m.
pub(crate) const SIGMA_M: f64 = 1.5;
/// Largest offset, m.
pub(crate) const LARGEST_M: f64 = 6.0;
/// Size of an offset that matters, m; a fiftieth of it is the step of differences.
pub(crate) const SCALE_M: f64 = 10.0;

/// Longest stretch that changes adhesion, m: twice what leaves and oil are known to cover.
pub(crate) const LONGEST_M: f64 = 400.0;
/// The same as a share of the track: what acts nearly everywhere is another level of adhesion, not a stretch. Set by hand.
pub(crate) const LONGEST_SHARE: f64 = 0.5;

/// Whether an effect changes what wheelsets find at a place to the metre.
pub(crate) fn matters(spec: &EffectSpec) -> bool {
    spec.term == Term::Adhesion && spec.parameters.iter().any(|parameter| parameter.name == "start_m")
}

/// An effect that is asked where each recording really is.
#[derive(Debug)]
pub(crate) struct Shifted {
    inner: Box<dyn Effect>,
    /// What positions of each recording, in their order, fall short of the track's, m.
    offsets_m: Vec<f64>,
}

impl Shifted {
    pub(crate) fn new(inner: Box<dyn Effect>, offsets_m: Vec<f64>) -> Self {
        Self { inner, offsets_m }
    }

    /// The operating point at its place on the track.
    fn there(&self, at: &Operating) -> Operating {
        let offset = at.recording.checked_sub(1).and_then(|run| self.offsets_m.get(run));
        Operating { position_m: at.position_m + offset.copied().unwrap_or(0.0), ..*at }
    }
}

impl Effect for Shifted {
    fn spec(&self) -> &'static EffectSpec {
        self.inner.spec()
    }

    fn hidden_len(&self, sample_period_s: f64) -> usize {
        self.inner.hidden_len(sample_period_s)
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        self.inner.start(&self.there(at), hidden);
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        self.inner.advance(&self.there(at), dt_s, hidden);
    }

    fn join(&mut self, constants: &Constants) {
        self.inner.join(constants);
    }

    fn constants(&self, constants: &mut Constants) {
        self.inner.constants(constants);
    }

    fn adhesion_peak(&self, wheelset: usize, at: &Operating, hidden: &[f64], peak: f64) -> f64 {
        self.inner.adhesion_peak(wheelset, &self.there(at), hidden, peak)
    }

    fn observe(&self, at: &Operating, hidden: &[f64], reading: &mut Observation) {
        self.inner.observe(&self.there(at), hidden, reading);
    }

    fn lateness(&self, time_s: f64) -> Lateness {
        self.inner.lateness(time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_vehicle::effects;

    /// Adhesion under the first wheelset at a place, in a recording.
    fn adhesion(effect: &dyn Effect, position_m: f64, recording: usize) -> f64 {
        effect.adhesion_peak(0, &Operating { position_m, recording, ..Operating::default() }, &[], 0.1)
    }

    #[test]
    fn each_recording_finds_a_stretch_at_its_own_place() {
        let (spec, constructor) = effects::find("low_adhesion_patch").expect("it is in the catalogue");
        assert!(matters(spec));
        let values: Vec<f64> = spec.parameters.iter().map(|p| p.default).collect();
        let plain = constructor(&values);
        let shifted = Shifted::new(constructor(&values), vec![0.0, 4.0]);
        let start_m = values[0];
        for (recording, offset_m) in [(0, 0.0), (1, 0.0), (2, 4.0), (3, 0.0)] {
            let there = adhesion(&*plain, start_m + offset_m, 0);
            assert_eq!(adhesion(&shifted, start_m, recording), there, "recording {recording}");
        }
        assert!(adhesion(&shifted, start_m, 2) < adhesion(&shifted, start_m, 1));
    }

    #[test]
    fn what_acts_everywhere_needs_no_offset() {
        let (spec, _) = effects::find("falling_friction").expect("it is in the catalogue");
        assert!(!matters(spec));
    }
}
