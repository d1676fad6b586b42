//! A cell of the map in bytes, so that it outlives the process.
//!
//! Little endian: version (u8), length of the cells of its map (f64, m), when it was last passed (f64, Unix s), observations
//! of sliding wheelsets (u32), probabilities (f32 each), wagons that have passed it (u32 each).

use super::cell::Cell;
use crate::belief::{Belief, CELLS};

const VERSION: u8 = 1;
/// Wagons that are remembered of a cell.
const MOST_WAGONS: usize = 256;

pub(super) fn pack(cell: &Cell, cell_m: f64, unix_ahead_s: f64) -> Vec<u8> {
    let mut packed = vec![VERSION];
    packed.extend(cell_m.to_le_bytes());
    packed.extend((cell.seen_s + unix_ahead_s).to_le_bytes());
    packed.extend(cell.slides.to_le_bytes());
    cell.belief.probabilities().iter().for_each(|p| packed.extend((*p as f32).to_le_bytes()));
    cell.wagons.iter().take(MOST_WAGONS).for_each(|wagon| packed.extend(wagon.to_le_bytes()));
    packed
}

/// `None` for what is no cell of this version and length.
pub(super) fn unpack(packed: &[u8], cell_m: f64, unix_ahead_s: f64) -> Option<Cell> {
    let (version, rest) = packed.split_first()?;
    let (length_m, rest) = rest.split_first_chunk()?;
    let (seen_unix_s, rest) = rest.split_first_chunk()?;
    let (slides, rest) = rest.split_first_chunk()?;
    let (probabilities, wagons) = rest.split_at_checked(4 * CELLS)?;
    let seen_s = f64::from_le_bytes(*seen_unix_s) - unix_ahead_s;
    if *version != VERSION || f64::from_le_bytes(*length_m) != cell_m || !seen_s.is_finite() {
        return None;
    }
    let mut probability = [0.0; CELLS];
    for (probability, bytes) in probability.iter_mut().zip(probabilities.as_chunks().0) {
        *probability = f64::from(f32::from_le_bytes(*bytes));
    }
    Some(Cell {
        belief: Belief::of(probability)?,
        seen_s,
        slides: u32::from_le_bytes(*slides),
        wagons: wagons.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect(),
    })
}
