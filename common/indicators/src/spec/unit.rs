//! Units of figures, and how figures are written for people.

/// Unit of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A ratio, a share or a factor.
    Ratio,
    /// A number of things.
    Count,
    /// s.
    Seconds,
    /// N.
    Newtons,
    /// K, of a difference of temperatures.
    Kelvins,
}

impl Unit {
    /// Its symbol; empty for a ratio or a count.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Ratio | Self::Count => "",
            Self::Seconds => "s",
            Self::Newtons => "N",
            Self::Kelvins => "K",
        }
    }

    /// What names of fields end with.
    #[must_use]
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Ratio | Self::Count => "",
            Self::Seconds => "_s",
            Self::Newtons => "_n",
            Self::Kelvins => "_k",
        }
    }

    /// What names of Prometheus metrics end with: base units in words.
    #[must_use]
    pub const fn metric_suffix(self) -> &'static str {
        match self {
            Self::Ratio => "_ratio",
            Self::Count => "",
            Self::Seconds => "_seconds",
            Self::Newtons => "_newtons",
            Self::Kelvins => "_kelvin",
        }
    }
}

/// How a figure is written for people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// What the figure is multiplied with.
    pub factor: f64,
    /// Decimals.
    pub digits: usize,
    /// Unit behind it, with the space before it.
    pub unit: &'static str,
}

impl Form {
    /// A coefficient of friction.
    pub const COEFFICIENT: Self = Self { factor: 1.0, digits: 3, unit: "" };
    /// A share, as percent.
    pub const PERCENT: Self = Self { factor: 100.0, digits: 0, unit: "\u{202f}%" };
    /// A small share, as per mille.
    pub const PER_MILLE: Self = Self { factor: 1e3, digits: 2, unit: "\u{202f}‰" };
    /// A factor around 1.
    pub const FACTOR: Self = Self { factor: 1.0, digits: 2, unit: "" };
    /// A number of things.
    pub const COUNT: Self = Self { factor: 1.0, digits: 0, unit: "" };
    /// A time.
    pub const SECONDS: Self = Self { factor: 1.0, digits: 1, unit: "\u{202f}s" };
    /// A difference of temperatures.
    pub const KELVINS: Self = Self { factor: 1.0, digits: 0, unit: "\u{202f}K" };
    /// A force given in N, as kN.
    pub const KILONEWTONS: Self = Self { factor: 1e-3, digits: 1, unit: "\u{202f}kN" };
}
