//! Buckets, and blocks of them as they stand in the database.
//!
//! Layout of a block before compression, little endian: number of buckets `n` and of columns `c` (u16 each), the
//! buckets' places in the block (u16 × n), their sample counts (u32 × n), then for each column the means, and the
//! smallest and largest values as differences of their bit patterns to the mean's. Each array of 32-bit words is
//! stored byte plane by byte plane: signs and exponents of neighbours agree, so that they compress to almost nothing.

use crate::Tier;
use std::collections::BTreeMap;

/// Mean, smallest and largest value of one column; NaN where nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Mean.
    pub mean: f32,
    /// Smallest value.
    pub min: f32,
    /// Largest value.
    pub max: f32,
}

impl Cell {
    /// A cell that knows nothing.
    pub const EMPTY: Self = Self { mean: f32::NAN, min: f32::NAN, max: f32::NAN };

    /// A cell of one value.
    pub fn of(value: f32) -> Self {
        Self { mean: value, min: value, max: value }
    }

    /// Both cells together, weighted by their numbers of samples.
    pub fn merged(self, samples: u32, other: Self, other_samples: u32) -> Self {
        match (self.mean.is_nan(), other.mean.is_nan()) {
            (true, _) => other,
            (_, true) => self,
            _ => {
                let (a, b) = (f64::from(samples), f64::from(other_samples));
                let mean = (f64::from(self.mean) * a + f64::from(other.mean) * b) / (a + b);
                Self { mean: mean as f32, min: self.min.min(other.min), max: self.max.max(other.max) }
            }
        }
    }
}

/// One cell for each column over one width of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Bucket {
    /// Samples that went in.
    pub samples: u32,
    /// By column.
    pub cells: Vec<Cell>,
}

impl Bucket {
    /// Takes in another bucket's samples. Columns that only one side has are kept.
    pub fn merge(&mut self, other: &Self) {
        self.cells.resize(self.cells.len().max(other.cells.len()), Cell::EMPTY);
        for (cell, theirs) in self.cells.iter_mut().zip(&other.cells) {
            *cell = cell.merged(self.samples, *theirs, other.samples);
        }
        self.samples = self.samples.saturating_add(other.samples);
    }
}

/// A block that cannot be decoded.
#[derive(Debug, thiserror::Error)]
pub enum BlockError {
    /// The compressed data is damaged.
    #[error("damaged compressed block: {0}")]
    Compression(#[from] std::io::Error),
    /// The data does not have the length that its header promises.
    #[error("block of {found} bytes where its header promises {expected}")]
    Length {
        /// Bytes there.
        found: usize,
        /// Bytes promised.
        expected: usize,
    },
}

/// Buckets of a block by their start, Unix seconds.
pub(crate) type Buckets = BTreeMap<i64, Bucket>;

/// Largest decoded block accepted: a minute of seconds with more columns than any layout has.
const LARGEST_BLOCK: usize = 16 << 20;

/// Packs the buckets of the block that starts at `start_s`.
pub(crate) fn encode(tier: Tier, start_s: i64, buckets: &Buckets) -> Result<Vec<u8>, BlockError> {
    let columns = buckets.values().map(|bucket| bucket.cells.len()).max().unwrap_or(0);
    let mut plain = Vec::with_capacity(4 + buckets.len() * (6 + 12 * columns));
    plain.extend((buckets.len() as u16).to_le_bytes());
    plain.extend((columns as u16).to_le_bytes());
    for at in buckets.keys() {
        plain.extend((((at - start_s) / tier.bucket_s()) as u16).to_le_bytes());
    }
    push_planes(&mut plain, buckets.values().map(|bucket| bucket.samples));
    for column in 0..columns {
        let cells =
            || buckets.values().map(move |bucket| bucket.cells.get(column).copied().unwrap_or(Cell::EMPTY));
        push_planes(&mut plain, cells().map(|cell| cell.mean.to_bits()));
        push_planes(&mut plain, cells().map(|cell| cell.min.to_bits() ^ cell.mean.to_bits()));
        push_planes(&mut plain, cells().map(|cell| cell.max.to_bits() ^ cell.mean.to_bits()));
    }
    Ok(zstd::bulk::compress(&plain, 6)?)
}

/// Unpacks a block that starts at `start_s`.
pub(crate) fn decode(tier: Tier, start_s: i64, packed: &[u8]) -> Result<Buckets, BlockError> {
    let plain = zstd::bulk::decompress(packed, LARGEST_BLOCK)?;
    let header =
        |at: usize| plain.get(at..at + 2).map_or(0, |two| usize::from(u16::from_le_bytes([two[0], two[1]])));
    let (count, columns) = (header(0), header(2));
    let expected = 4 + count * (6 + 12 * columns);
    if plain.len() != expected {
        return Err(BlockError::Length { found: plain.len(), expected });
    }
    let word = |array: usize, index: usize| {
        let planes = 4 + 2 * count + 4 * count * array;
        u32::from_le_bytes([0, 1, 2, 3].map(|plane| plain[planes + plane * count + index]))
    };
    let bucket = |index: usize| {
        let cells = (0..columns).map(|column| {
            let mean = word(1 + 3 * column, index);
            Cell {
                mean: f32::from_bits(mean),
                min: f32::from_bits(word(2 + 3 * column, index) ^ mean),
                max: f32::from_bits(word(3 + 3 * column, index) ^ mean),
            }
        });
        let at = start_s + header(4 + 2 * index) as i64 * tier.bucket_s();
        (at, Bucket { samples: word(0, index), cells: cells.collect() })
    };
    Ok((0..count).map(bucket).collect())
}

fn push_planes(plain: &mut Vec<u8>, words: impl Iterator<Item = u32> + Clone) {
    for plane in 0..4 {
        plain.extend(words.clone().map(|word| word.to_le_bytes()[plane]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minute() -> Buckets {
        (0..60)
            .filter(|second| second % 7 != 3)
            .map(|second| {
                let x = second as f32;
                let cells = vec![
                    Cell { mean: 0.3 + 1e-3 * x, min: 0.29, max: 0.35 + 1e-3 * x },
                    Cell::EMPTY,
                    Cell::of(-x),
                ];
                (1_800_000_000 + second, Bucket { samples: 5, cells })
            })
            .collect()
    }

    #[test]
    fn a_block_comes_back_as_it_was() {
        let buckets = minute();
        let packed = encode(Tier::Second, 1_800_000_000, &buckets).expect("packs");
        let back = decode(Tier::Second, 1_800_000_000, &packed).expect("unpacks");
        assert_eq!(back.len(), buckets.len());
        for ((at, a), (bt, b)) in buckets.iter().zip(&back) {
            assert_eq!((at, a.samples), (bt, b.samples));
            let bits = |bucket: &Bucket| -> Vec<[u32; 3]> {
                bucket.cells.iter().map(|c| [c.mean.to_bits(), c.min.to_bits(), c.max.to_bits()]).collect()
            };
            assert_eq!(bits(a), bits(b));
        }
    }

    #[test]
    fn damage_is_an_error_and_never_a_panic() {
        let packed = encode(Tier::Second, 0, &minute()).expect("packs");
        for length in 0..packed.len() {
            assert!(decode(Tier::Second, 0, &packed[..length]).is_err());
        }
        let wrong = zstd::bulk::compress(&[9, 0, 9, 0, 1], 3).expect("packs");
        assert!(matches!(decode(Tier::Second, 0, &wrong), Err(BlockError::Length { .. })));
        let empty = zstd::bulk::compress(&[], 3).expect("packs");
        assert!(decode(Tier::Second, 0, &empty).is_err());
    }

    #[test]
    fn merging_weighs_by_samples_and_keeps_extremes() {
        let mut bucket = Bucket { samples: 3, cells: vec![Cell { mean: 1.0, min: 0.0, max: 2.0 }] };
        bucket.merge(&Bucket {
            samples: 1,
            cells: vec![Cell { mean: 5.0, min: 5.0, max: 6.0 }, Cell::of(1.0)],
        });
        assert_eq!(bucket.samples, 4);
        assert_eq!(bucket.cells[0], Cell { mean: 2.0, min: 0.0, max: 6.0 });
        assert_eq!(bucket.cells[1], Cell::of(1.0));
    }
}
