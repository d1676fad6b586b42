//! What a block holds before it is packed.

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
