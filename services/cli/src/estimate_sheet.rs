//! The estimates of a recording as a table: cells as they come, and how many rows say anything.

use std::collections::BTreeMap;

use railgrip_messages::{Estimate, EstimateState};
use railgrip_recording::Table;

use crate::CliError;
use crate::estimate_columns::{Cell, Column};

/// The estimates of a recording, column by column.
pub(crate) struct Sheet {
    columns: Vec<Column>,
    numbers: Vec<Vec<f64>>,
    words: Vec<Vec<&'static str>>,
    counted: Counted,
}

/// How many rows have an estimate, and what the estimator said of the others.
#[derive(Debug, Clone, Default)]
pub(crate) struct Counted {
    /// Rows with an estimate.
    pub(crate) told: usize,
    /// Rows without.
    pub(crate) silent: usize,
    /// Rows whose data the model does not explain.
    pub(crate) diverged: usize,
    said: BTreeMap<&'static str, usize>,
}

impl Counted {
    /// The state of most of the rows without an estimate.
    pub(crate) fn most_said(&self) -> &'static str {
        self.said.iter().max_by_key(|(_, rows)| **rows).map_or("nothing", |(state, _)| state)
    }
}

impl Sheet {
    /// An empty sheet with room for so many rows.
    pub(crate) fn new(columns: Vec<Column>, rows: usize) -> Self {
        let numbers = columns.iter().map(|_| Vec::with_capacity(rows)).collect();
        let words = columns.iter().map(|_| Vec::new()).collect();
        Self { columns, numbers, words, counted: Counted::default() }
    }

    /// Adds a row.
    pub(crate) fn take(&mut self, estimate: &Estimate) {
        let cells = self.numbers.iter_mut().zip(&mut self.words);
        let mut told = false;
        for (column, (numbers, words)) in self.columns.iter().zip(cells) {
            match column.cell(estimate) {
                Cell::Number(value) => {
                    told |= column.name == "mu_w_sigma" && value > 0.0;
                    numbers.push(value);
                }
                Cell::Word(word) => words.push(word),
            }
        }
        self.counted.diverged += usize::from(estimate.state() == Some(EstimateState::Diverged));
        if told {
            self.counted.told += 1;
        } else {
            self.counted.silent += 1;
            let state = estimate.state().map_or("nothing", EstimateState::word);
            *self.counted.said.entry(state).or_default() += 1;
        }
    }

    /// What was taken so far.
    pub(crate) const fn counted(&self) -> &Counted {
        &self.counted
    }

    /// The table, with further columns at its end.
    pub(crate) fn table(self, further: Vec<(String, Vec<f64>)>) -> Result<Table, CliError> {
        let (mut numbers, mut words) = (Vec::new(), Vec::new());
        for (column, (cells, names)) in self.columns.into_iter().zip(self.numbers.into_iter().zip(self.words))
        {
            if names.is_empty() {
                numbers.push((column.name, cells))
            } else {
                words.push((column.name, names))
            }
        }
        numbers.extend(further);
        let table = Table::new(numbers).map_err(CliError::failed)?;
        words
            .into_iter()
            .try_fold(table, |table, (name, cells)| table.with_words(&name, cells))
            .map_err(CliError::failed)
    }
}
