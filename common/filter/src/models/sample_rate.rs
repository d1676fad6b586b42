//! Whether samples come at the rate that a rig's file says.

/// Period of the samples over that of the file, or the reverse, that is another rate.
const FACTOR: f64 = 1.5;
/// Samples over which the rate is judged, and the share of them that must be off: gaps are none of its business.
const OVER: f64 = 20.0;
const OFF_SHARE: f64 = 0.8;

/// Watch over the rate. A restart of the filter does not make it forget.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SampleRate {
    /// Share of the latest samples that came at another rate.
    pub off: f64,
}

impl SampleRate {
    /// Takes the time since the sample before.
    pub fn take(&mut self, gap_s: f64, rate_hz: f64) {
        let off = !(1.0 / FACTOR..FACTOR).contains(&(gap_s * rate_hz));
        self.off += (f64::from(u8::from(off)) - self.off) / OVER;
    }

    /// True if most samples come at another rate.
    pub fn is_wrong(&self) -> bool {
        self.off > OFF_SHARE
    }
}
