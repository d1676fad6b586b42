//! What the map remembers of one cell of the track.

use crate::belief::Belief;

/// One cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cell {
    pub belief: Belief,
    pub seen_s: f64,
    pub slides: u32,
    pub wagons: Vec<u32>,
}
