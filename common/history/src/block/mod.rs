//! Buckets of one wagon, tier and span of time, and how they are packed.
//!
//! Layout before compression, little endian: number of buckets `n` with [`PACKED_24`] set, number of columns `c` (u16
//! each), the buckets' places in the block (u16 × n), their sample counts (u32 × n, byte plane by byte plane). Then for
//! each column one byte that says what is stored of it: nothing, means, or means and extremes. Means are 24-bit words
//! ([`word`]) as differences to the one before, extremes as their distances from the mean, all byte plane by byte plane:
//! most planes are zero or nearly so, and compress to almost nothing.
//!
//! 24 bits keep sign, exponent and 15 bits after the leading one: 5 digits, better than any sensor here.
//! Blocks of the first version of the database ([`first`]) are still read.

mod bucket;
mod first;
mod word;

pub(crate) use bucket::Buckets;
pub use bucket::{BlockError, Bucket, Cell};

use crate::Tier;

/// What is kept of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Means, smallest and largest values.
    Extremes,
    /// Means only: for what changes slowly or is an interval around something else.
    Mean,
}

/// Largest decoded block accepted: a minute of seconds with more columns than any layout has.
const LARGEST_BLOCK: usize = 16 << 20;
/// Set in the number of buckets of a block with 24-bit words.
const PACKED_24: u16 = 0x8000;
const COMPRESSION_LEVEL: i32 = 9;

const NOTHING: u8 = 0;
const MEANS: u8 = 1;
const ALL: u8 = 2;

/// Packs the buckets of the block that starts at `start_s`. Columns without an entry in `keep` keep everything.
pub(crate) fn encode(
    tier: Tier,
    start_s: i64,
    buckets: &Buckets,
    keep: &[Keep],
) -> Result<Vec<u8>, BlockError> {
    let columns = buckets.values().map(|bucket| bucket.cells.len()).max().unwrap_or(0);
    let mut plain = Vec::with_capacity(4 + buckets.len() * (6 + 9 * columns));
    plain.extend((buckets.len() as u16 | PACKED_24).to_le_bytes());
    plain.extend((columns as u16).to_le_bytes());
    for at in buckets.keys() {
        plain.extend((((at - start_s) / tier.bucket_s()) as u16).to_le_bytes());
    }
    let samples: Vec<u32> = buckets.values().map(|bucket| bucket.samples).collect();
    push_planes(&mut plain, 4, &samples);
    for column in 0..columns {
        let cell = |bucket: &Bucket| bucket.cells.get(column).copied().unwrap_or(Cell::EMPTY);
        let cells: Vec<Cell> = buckets.values().map(cell).collect();
        push_column(&mut plain, &cells, keep.get(column).copied().unwrap_or(Keep::Extremes));
    }
    Ok(zstd::bulk::compress(&plain, COMPRESSION_LEVEL)?)
}

fn push_column(plain: &mut Vec<u8>, cells: &[Cell], keep: Keep) {
    if cells.iter().all(|cell| cell.mean.is_nan()) {
        return plain.push(NOTHING);
    }
    let means: Vec<u32> = cells.iter().map(|cell| word::of(cell.mean)).collect();
    let plainly = cells.iter().all(|cell| cell.mean.is_nan() || word::of(cell.min) == word::of(cell.max));
    let kind = if keep == Keep::Mean || plainly { MEANS } else { ALL };
    plain.push(kind);
    let mut before = 0;
    let differences: Vec<u32> = means
        .iter()
        .map(|&mean| {
            let difference = word::zigzag(mean, before);
            before = mean;
            difference
        })
        .collect();
    push_planes(plain, 3, &differences);
    if kind == ALL {
        let zip = || cells.iter().zip(&means);
        let below: Vec<u32> = zip().map(|(cell, mean)| word::zigzag(*mean, word::of(cell.min))).collect();
        let above: Vec<u32> = zip().map(|(cell, mean)| word::zigzag(word::of(cell.max), *mean)).collect();
        push_planes(plain, 3, &below);
        push_planes(plain, 3, &above);
    }
}

fn push_planes(plain: &mut Vec<u8>, planes: usize, words: &[u32]) {
    for plane in 0..planes {
        plain.extend(words.iter().map(|word| word.to_le_bytes()[plane]));
    }
}

/// Unpacks a block that starts at `start_s`; with `places` only the columns at these places, in their order.
pub(crate) fn decode(
    tier: Tier,
    start_s: i64,
    packed: &[u8],
    places: Option<&[Option<usize>]>,
) -> Result<Buckets, BlockError> {
    let plain = zstd::bulk::decompress(packed, LARGEST_BLOCK)?;
    let mut rest = Cursor { plain: &plain, at: 0 };
    let (count, columns) = (rest.short()?, usize::from(rest.short()?));
    if count & PACKED_24 == 0 {
        return first::decode(tier, start_s, &plain, places);
    }
    let count = usize::from(count & !PACKED_24);
    let starts: Vec<i64> = (0..count)
        .map(|_| rest.short().map(|place| start_s + i64::from(place) * tier.bucket_s()))
        .collect::<Result<_, _>>()?;
    let samples = rest.planes(4, count)?;
    let width = places.map_or(columns, <[_]>::len);
    let mut buckets: Vec<Bucket> =
        samples.iter().map(|&samples| Bucket { samples, cells: vec![Cell::EMPTY; width] }).collect();
    for column in 0..columns {
        let place = match places {
            None => Some(column),
            Some(places) => places.iter().position(|place| *place == Some(column)),
        };
        let kind = rest.byte()?;
        if kind == NOTHING {
            continue;
        }
        let Some(place) = place else {
            rest.bytes(3 * count * if kind == ALL { 3 } else { 1 })?;
            continue;
        };
        let differences = rest.planes(3, count)?;
        let extremes =
            if kind == ALL { Some((rest.planes(3, count)?, rest.planes(3, count)?)) } else { None };
        let mut mean = 0;
        for (index, bucket) in buckets.iter_mut().enumerate() {
            mean = word::unzigzag(differences[index], mean);
            let value = word::value(mean);
            bucket.cells[place] = match &extremes {
                None => Cell::of(value),
                Some((below, above)) => Cell {
                    mean: value,
                    min: word::value(word::before(below[index], mean)),
                    max: word::value(word::unzigzag(above[index], mean)),
                },
            };
        }
    }
    if rest.at != plain.len() {
        return Err(BlockError::Length { found: plain.len(), expected: rest.at });
    }
    Ok(starts.into_iter().zip(buckets).collect())
}

/// Reads from the front.
struct Cursor<'a> {
    plain: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], BlockError> {
        let end = self.at.saturating_add(count);
        let bytes = self.plain.get(self.at..end);
        self.at = end;
        bytes.ok_or(BlockError::Length { found: self.plain.len(), expected: end })
    }

    fn byte(&mut self) -> Result<u8, BlockError> {
        self.bytes(1).map(|bytes| bytes[0])
    }

    fn short(&mut self) -> Result<u16, BlockError> {
        self.bytes(2).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    fn planes(&mut self, planes: usize, count: usize) -> Result<Vec<u32>, BlockError> {
        let bytes = self.bytes(planes * count)?;
        let word = |index: usize| {
            (0..planes).fold(0, |word, plane| word | u32::from(bytes[plane * count + index]) << (8 * plane))
        };
        Ok((0..count).map(word).collect())
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
                    if second % 2 == 0 { Cell::EMPTY } else { Cell { mean: 0.0, min: -1.0, max: 1e6 } },
                ];
                (1_800_000_000 + second, Bucket { samples: 5, cells })
            })
            .collect()
    }

    fn close(a: f32, b: f32) -> bool {
        (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1.6e-5 * a.abs()
    }

    #[test]
    fn a_block_comes_back_to_five_digits() {
        let buckets = minute();
        let packed = encode(Tier::Second, 1_800_000_000, &buckets, &[]).expect("packs");
        println!("{} buckets of 4 columns in {} bytes", buckets.len(), packed.len());
        let back = decode(Tier::Second, 1_800_000_000, &packed, None).expect("unpacks");
        assert_eq!(back.len(), buckets.len());
        for ((at, a), (bt, b)) in buckets.iter().zip(&back) {
            assert_eq!((at, a.samples), (bt, b.samples));
            for (x, y) in a.cells.iter().zip(&b.cells) {
                assert!(close(x.mean, y.mean) && close(x.min, y.min) && close(x.max, y.max), "{x:?} {y:?}");
            }
        }
        let some = decode(Tier::Second, 1_800_000_000, &packed, Some(&[Some(2), None, Some(0)]));
        let some = some.expect("unpacks");
        for (at, bucket) in &back {
            let picked = &some[at].cells;
            assert_eq!((picked[0], picked[2]), (bucket.cells[2], bucket.cells[0]));
            assert!(picked[1].mean.is_nan());
        }
    }

    #[test]
    fn a_column_of_means_keeps_no_extremes() {
        let packed = encode(Tier::Second, 1_800_000_000, &minute(), &[Keep::Mean]).expect("packs");
        let back = decode(Tier::Second, 1_800_000_000, &packed, None).expect("unpacks");
        assert!(back.values().all(|bucket| bucket.cells[0].min == bucket.cells[0].max));
        assert!(back.values().any(|bucket| bucket.cells[3].min < bucket.cells[3].max));
    }

    #[test]
    fn damage_is_an_error_and_never_a_panic() {
        let packed = encode(Tier::Second, 0, &minute(), &[]).expect("packs");
        for length in 0..packed.len() {
            assert!(decode(Tier::Second, 0, &packed[..length], None).is_err());
        }
        let plain = zstd::bulk::decompress(&packed, 1 << 20).expect("unpacks");
        for length in 0..plain.len() {
            let cut = zstd::bulk::compress(&plain[..length], 1).expect("packs");
            assert!(decode(Tier::Second, 0, &cut, None).is_err(), "{length}");
        }
        for at in 0..plain.len() {
            let mut wrong = plain.clone();
            wrong[at] ^= 0x55;
            let wrong = zstd::bulk::compress(&wrong, 1).expect("packs");
            let _ = decode(Tier::Second, 0, &wrong, None);
        }
        let empty = zstd::bulk::compress(&[], 3).expect("packs");
        assert!(decode(Tier::Second, 0, &empty, None).is_err());
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
