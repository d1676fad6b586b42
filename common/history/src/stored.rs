//! What is in the database, block by block, and how buckets are put together.

use crate::block::{Bucket, Buckets};
use crate::{Tier, key};
use rusqlite::{Connection, OptionalExtension, params};

/// The packed block, if there is one.
pub(crate) fn load(
    connection: &Connection,
    tier: Tier,
    wagon: u32,
    start_s: i64,
) -> rusqlite::Result<Option<Vec<u8>>> {
    connection
        .prepare_cached("SELECT packed FROM packed_block WHERE key = ?1")?
        .query_row([key::of(tier, start_s, wagon)], |row| row.get(0))
        .optional()
}

/// Start of the newest block of a tier that is not from the future: a clock that was wrong for a while must not make
/// the present look old.
pub(crate) fn newest_start(connection: &Connection, tier: Tier) -> rusqlite::Result<Option<i64>> {
    let now_s = std::time::SystemTime::UNIX_EPOCH.elapsed().map_or(0, |age| age.as_secs().cast_signed());
    let keys = key::range(tier, 0..now_s + tier.block_s());
    connection
        .prepare_cached("SELECT max(key) FROM packed_block WHERE key >= ?1 AND key < ?2")?
        .query_row(params![keys.start, keys.end], |row| row.get::<_, Option<i64>>(0))
        .map(|newest| newest.map(key::start_s))
}

pub(crate) fn merge_into(buckets: &mut Buckets, at: i64, bucket: &Bucket) {
    match buckets.get_mut(&at) {
        Some(known) => known.merge(bucket),
        None => {
            buckets.insert(at, bucket.clone());
        }
    }
}

/// Puts fresh buckets where they hold more samples than the known ones; true if any did.
pub(crate) fn take_larger(known: &mut Buckets, fresh: Buckets) -> bool {
    let mut changed = false;
    for (at, bucket) in fresh {
        if known.get(&at).is_none_or(|known| known.samples < bucket.samples) {
            known.insert(at, bucket);
            changed = true;
        }
    }
    changed
}
