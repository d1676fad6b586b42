//! What goes when: by age, and by size.

use crate::key;
use crate::{HistoryError, Store, Tier};
use rusqlite::params;

/// What is kept of one tier; whichever limit is reached first counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Age at which blocks go, s.
    pub age_s: i64,
    /// Size of all blocks above which the oldest go, bytes.
    pub size_bytes: u64,
}

/// How long and how much is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retention {
    /// Of each tier, finest first.
    pub tiers: [Limits; 3],
    /// Age at which events go, s.
    pub event_s: i64,
}

impl Default for Retention {
    /// A week of seconds, a quarter of minutes, ten years of hours and events.
    fn default() -> Self {
        const DAY_S: i64 = 86_400;
        Self {
            tiers: [
                Limits { age_s: 7 * DAY_S, size_bytes: 2_000_000_000 },
                Limits { age_s: 92 * DAY_S, size_bytes: 1_000_000_000 },
                Limits { age_s: 3653 * DAY_S, size_bytes: 500_000_000 },
            ],
            event_s: 3653 * DAY_S,
        }
    }
}

/// Where the size of a tier is taken down to when it is above its limit, so that not every look finds it above again.
const SHRINK_TO: f64 = 0.95;

impl Store {
    /// Drops what is older than `retention` allows at `now_unix_s`; with no `now_unix_s` (when the clock is not to be
    /// trusted) nothing goes by age. Then the oldest of each tier that is too large. Returns how many blocks went.
    ///
    /// # Errors
    /// The database refuses.
    pub fn prune(&mut self, retention: &Retention, now_unix_s: Option<i64>) -> Result<u64, HistoryError> {
        let mut gone = 0;
        if let Some(now_unix_s) = now_unix_s {
            for (tier, limits) in Tier::ALL.into_iter().zip(retention.tiers) {
                let before_s = now_unix_s - limits.age_s - tier.block_s();
                gone += self.drop_until(tier, key::of(tier, before_s, 0))?;
            }
            self.connection()
                .execute("DELETE FROM event WHERE unix_ms < ?1", [(now_unix_s - retention.event_s) * 1000])
                .map_err(|source| self.fail(source))?;
        }
        let smallest = retention.tiers.iter().map(|limits| limits.size_bytes).min().unwrap_or(u64::MAX);
        // As long as the whole is below the smallest limit, no tier has to be measured.
        if self.size_bytes()? > smallest {
            for (tier, limits) in Tier::ALL.into_iter().zip(retention.tiers) {
                gone += self.shrink(tier, limits.size_bytes)?;
            }
        }
        self.connection()
            .execute_batch("PRAGMA incremental_vacuum(1000)")
            .map_err(|source| self.fail(source))?;
        Ok(gone)
    }

    fn drop_until(&self, tier: Tier, end: i64) -> Result<u64, HistoryError> {
        self.connection()
            .execute(
                "DELETE FROM packed_block WHERE key >= ?1 AND key < ?2",
                params![key::all(tier).start, end],
            )
            .map(|rows| rows as u64)
            .map_err(|source| self.fail(source))
    }

    /// Drops the oldest blocks until the tier is within its size.
    fn shrink(&self, tier: Tier, size_bytes: u64) -> Result<u64, HistoryError> {
        let range = key::all(tier);
        let sum = |sql: &str, end: i64| -> Result<u64, HistoryError> {
            self.connection()
                .query_row(sql, params![range.start, end], |row| row.get::<_, i64>(0))
                .map(|bytes| bytes.max(0) as u64)
                .map_err(|source| self.fail(source))
        };
        let all = "SELECT coalesce(sum(length(packed)), 0) FROM packed_block WHERE key >= ?1 AND key < ?2";
        let size = sum(all, range.end)?;
        if size <= size_bytes {
            return Ok(0);
        }
        let surplus = size - (size_bytes as f64 * SHRINK_TO) as u64;
        let end: Option<i64> = self.end_of_surplus(range.clone(), surplus)?;
        self.drop_until(tier, end.unwrap_or(range.end))
    }

    /// The key behind the oldest blocks that have so many bytes together.
    fn end_of_surplus(&self, range: std::ops::Range<i64>, surplus: u64) -> Result<Option<i64>, HistoryError> {
        let find = || -> rusqlite::Result<Option<i64>> {
            let mut select = self.connection().prepare(
                "SELECT key, length(packed) FROM packed_block WHERE key >= ?1 AND key < ?2 ORDER BY key",
            )?;
            let mut rows = select.query(params![range.start, range.end])?;
            let mut bytes = 0;
            while let Some(row) = rows.next()? {
                if bytes >= surplus {
                    return row.get(0).map(Some);
                }
                bytes += row.get::<_, i64>(1)?.max(0) as u64;
            }
            Ok(None)
        };
        find().map_err(|source| self.fail(source))
    }
}
