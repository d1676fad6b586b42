//! The widths of buckets and blocks.

/// One resolution of the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tier {
    /// Buckets of one second, blocks of one minute.
    Second,
    /// Buckets of one minute, blocks of one hour.
    Minute,
    /// Buckets of one hour, blocks of one day.
    Hour,
}

impl Tier {
    /// All tiers, finest first.
    pub const ALL: [Self; 3] = [Self::Second, Self::Minute, Self::Hour];

    /// Width of a bucket, s.
    pub fn bucket_s(self) -> i64 {
        match self {
            Self::Second => 1,
            Self::Minute => 60,
            Self::Hour => 3600,
        }
    }

    /// Width of a block, s.
    pub fn block_s(self) -> i64 {
        match self {
            Self::Second => 60,
            Self::Minute => 3600,
            Self::Hour => 86_400,
        }
    }

    /// The tier that this one is made of.
    pub fn finer(self) -> Option<Self> {
        match self {
            Self::Second => None,
            Self::Minute => Some(Self::Second),
            Self::Hour => Some(Self::Minute),
        }
    }

    /// The tier with this word.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|tier| tier.word() == word)
    }

    /// Its word in APIs: `second`, `minute`, `hour`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Second => "second",
            Self::Minute => "minute",
            Self::Hour => "hour",
        }
    }

    /// Number under which the database knows the tier.
    pub(crate) fn code(self) -> i64 {
        self as i64
    }

    /// Start of the block that holds `unix_s`.
    pub(crate) fn block_start(self, unix_s: i64) -> i64 {
        unix_s.div_euclid(self.block_s()) * self.block_s()
    }

    /// Start of the bucket that holds `unix_s`.
    pub(crate) fn bucket_start(self, unix_s: i64) -> i64 {
        unix_s.div_euclid(self.bucket_s()) * self.bucket_s()
    }
}
