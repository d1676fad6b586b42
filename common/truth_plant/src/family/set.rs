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
    /// Fourth forms, for judging alone: nothing is developed or calibrated on them.
    D,
}

impl FormSet {
    /// The sets to develop on. Forms d are none of them: they judge alone, and a deck of a fixed seed stays what it was.
    pub const ALL: [Self; 3] = [Self::A, Self::B, Self::C];
    /// Every set, the one for judging too.
    pub const EVERY: [Self; 4] = [Self::A, Self::B, Self::C, Self::D];

    /// Its letter.
    #[must_use]
    pub fn letter(self) -> char {
        match self {
            Self::A => 'a',
            Self::B => 'b',
            Self::C => 'c',
            Self::D => 'd',
        }
    }
}

/// The sets from which a deck draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Forms {
    /// One set.
    Only(FormSet),
    /// Any of those to develop on, one a case; never forms d.
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
            Self::Only(FormSet::D) => &[FormSet::D],
            Self::All => &FormSet::ALL,
        }
    }
}
