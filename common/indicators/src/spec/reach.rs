//! The figure of the wagon, those of its wheelsets, or both.

/// Which figures of an indicator something is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// None.
    Nowhere,
    /// That of the wagon.
    Wagon,
    /// Those of the wheelsets.
    Wheelsets,
    /// Both.
    Both,
}

impl Reach {
    /// True if that of the wagon is meant.
    #[must_use]
    pub const fn wagon(self) -> bool {
        matches!(self, Self::Wagon | Self::Both)
    }

    /// True if those of the wheelsets are meant.
    #[must_use]
    pub const fn wheelsets(self) -> bool {
        matches!(self, Self::Wheelsets | Self::Both)
    }
}
