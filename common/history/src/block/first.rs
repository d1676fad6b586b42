//! Blocks of the first version of the database, with 32-bit words: read, and packed anew when they are written again.

use super::{BlockError, Bucket, Buckets, Cell};
use crate::Tier;

pub(super) fn decode(
    tier: Tier,
    start_s: i64,
    plain: &[u8],
    places: Option<&[Option<usize>]>,
) -> Result<Buckets, BlockError> {
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
    let cell = |column: usize, index: usize| {
        let mean = word(1 + 3 * column, index);
        Cell {
            mean: f32::from_bits(mean),
            min: f32::from_bits(word(2 + 3 * column, index) ^ mean),
            max: f32::from_bits(word(3 + 3 * column, index) ^ mean),
        }
    };
    let bucket = |index: usize| {
        let cells = match places {
            None => (0..columns).map(|column| cell(column, index)).collect(),
            Some(places) => places
                .iter()
                .map(|place| match place {
                    Some(column) if *column < columns => cell(*column, index),
                    _ => Cell::EMPTY,
                })
                .collect(),
        };
        let at = start_s + header(4 + 2 * index) as i64 * tier.bucket_s();
        (at, Bucket { samples: word(0, index), cells })
    };
    Ok((0..count).map(bucket).collect())
}
