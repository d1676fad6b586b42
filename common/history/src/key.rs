//! Where a block stands in its table: one number of tier, time and wagon.
//!
//! Time goes before the wagon, so that the blocks of one flush are neighbours: they share pages, and a flush of a long
//! train touches few of them. What is too old stands at the beginning of its tier and goes as one range.

use crate::Tier;
use std::ops::Range;

const WAGON_BITS: u32 = 12;
const TIER_BITS_FROM: u32 = 56;
/// Most wagons of one database.
pub(crate) const MOST_WAGONS: u32 = 1 << WAGON_BITS;
/// Blocks start before this instant, Unix s.
pub(crate) const LAST_START_S: i64 = 1 << (TIER_BITS_FROM - WAGON_BITS - 1);

/// The key of a block.
pub(crate) fn of(tier: Tier, start_s: i64, wagon: u32) -> i64 {
    (tier.code() << TIER_BITS_FROM) + (start_s.clamp(0, LAST_START_S) << WAGON_BITS) + i64::from(wagon)
}

/// Keys of all blocks of a tier that start in a span.
pub(crate) fn range(tier: Tier, starts_s: Range<i64>) -> Range<i64> {
    of(tier, starts_s.start, 0)..of(tier, starts_s.end, 0)
}

/// Keys of all blocks of a tier.
pub(crate) fn all(tier: Tier) -> Range<i64> {
    range(tier, 0..LAST_START_S)
}

/// Start of the block with this key, Unix s.
pub(crate) fn start_s(key: i64) -> i64 {
    (key & ((1 << TIER_BITS_FROM) - 1)) >> WAGON_BITS
}

/// Wagon of the block with this key.
pub(crate) fn wagon(key: i64) -> u32 {
    (key & i64::from(MOST_WAGONS - 1)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_lead_back_and_sort_by_tier_and_time() {
        let key = of(Tier::Minute, 1_800_000_000, 64);
        assert_eq!((start_s(key), wagon(key)), (1_800_000_000, 64));
        assert!(of(Tier::Second, LAST_START_S, 4095) < of(Tier::Minute, 0, 0));
        assert!(of(Tier::Hour, 60, 4095) < of(Tier::Hour, 120, 0));
        assert!(all(Tier::Hour).contains(&of(Tier::Hour, 4_000_000_000, 3)));
    }
}
