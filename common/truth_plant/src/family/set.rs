//! Sets of functional forms: what is calibrated on one is reported on another.

use serde::{Deserialize, Serialize};

/// A set of functional forms. What is calibrated on one set is reported on another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum FormSet {
    /// First forms.
    A,
    /// Second forms.
    B,
    /// Third forms.
    C,
}

impl FormSet {
    /// All sets.
    pub const ALL: [Self; 3] = [Self::A, Self::B, Self::C];

    /// Its letter.
    #[must_use]
    pub fn letter(self) -> char {
        match self {
            Self::A => 'a',
            Self::B => 'b',
            Self::C => 'c',
        }
    }
}

/// The sets from which a deck draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Forms {
    /// One set.
    Only(FormSet),
    /// All of them, one a case.
    All,
}

impl Forms {
    /// The sets.
    #[must_use]
    pub fn sets(self) -> &'static [FormSet] {
        match self {
            Self::Only(FormSet::A) => &[FormSet::A],
            Self::Only(FormSet::B) => &[FormSet::B],
            Self::Only(FormSet::C) => &[FormSet::C],
            Self::All => &FormSet::ALL,
        }
    }
}
