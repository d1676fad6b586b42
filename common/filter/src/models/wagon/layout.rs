//! Where each component of the default filter's state stands.

/// Indices of the state for `W` wheelsets and `N` components; see [`super::propagate`] for the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Indices {
    /// First wheelset speed.
    pub wheel: usize,
    /// First adhesion.
    pub adhesion: usize,
    /// Lag.
    pub lag: usize,
    /// Disturbance.
    pub disturbance: usize,
    /// First pad friction.
    pub pad: usize,
    /// First wheel radius.
    pub radius: usize,
    /// Mass.
    pub mass: usize,
    /// Slope of adhesion over slip in sliding.
    pub slope: usize,
    /// Delay of the pads.
    pub delay: usize,
    /// Rows of F before this one differ from the identity.
    pub moving: usize,
}

/// The layout for `W` wheelsets; refuses at compile time an `N` that does not fit.
pub(crate) struct Layout<const W: usize, const N: usize>;

impl<const W: usize, const N: usize> Layout<W, N> {
    /// The indices.
    pub(crate) const INDICES: Indices = {
        assert!(N == 6 + 4 * W, "the default filter has 6 + 4 W states");
        Indices {
            wheel: 1,
            adhesion: 1 + W,
            lag: 1 + 2 * W,
            disturbance: 2 + 2 * W,
            pad: 3 + 2 * W,
            radius: 3 + 3 * W,
            mass: 3 + 4 * W,
            slope: 4 + 4 * W,
            delay: 5 + 4 * W,
            moving: 3 + 2 * W,
        }
    };
}
