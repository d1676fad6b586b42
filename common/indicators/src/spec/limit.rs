//! From where on a figure is worth a look or needs action.

/// From where on a figure is worth a look or needs action, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Ends of the scale on which it is drawn.
    pub scale: (f64, f64),
    /// Needs action below.
    pub act_low: Option<f64>,
    /// Worth a look below.
    pub watch_low: Option<f64>,
    /// Worth a look above.
    pub watch_high: Option<f64>,
    /// Needs action above.
    pub act_high: Option<f64>,
}

impl Limit {
    /// A scale without limits.
    #[must_use]
    pub const fn free(low: f64, high: f64) -> Self {
        Self { scale: (low, high), act_low: None, watch_low: None, watch_high: None, act_high: None }
    }

    /// Limits of a figure that is bad when large, on a scale from zero.
    #[must_use]
    pub const fn above(scale_high: f64, watch: f64, act: f64) -> Self {
        Self { watch_high: Some(watch), act_high: Some(act), ..Self::free(0.0, scale_high) }
    }

    /// The same in another unit.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        let of = |end: Option<f64>| end.map(|end| end * factor);
        Self {
            scale: (self.scale.0 * factor, self.scale.1 * factor),
            act_low: of(self.act_low),
            watch_low: of(self.watch_low),
            watch_high: of(self.watch_high),
            act_high: of(self.act_high),
        }
    }
}
