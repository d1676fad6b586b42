//! CSV files as columns of numbers.

use std::path::Path;

/// Named columns of equal length; an empty cell is NaN.
#[derive(Debug, Clone, Default)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// Reads a file.
    ///
    /// # Panics
    /// If it cannot be read or a cell is no number.
    #[must_use]
    pub fn read(path: &Path) -> Self {
        let text =
            std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut lines = text.lines();
        let names: Vec<String> = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for line in lines {
            for (column, cell) in columns.iter_mut().zip(line.split(',')) {
                let number = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
                column.push(number.unwrap_or_else(|_| panic!("{}: \"{cell}\"", path.display())));
            }
        }
        Self { names, columns }
    }

    /// The names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// A column.
    ///
    /// # Panics
    /// If there is none of this name.
    #[must_use]
    pub fn column(&self, name: &str) -> &[f64] {
        let index = self.names.iter().position(|other| other == name);
        &self.columns[index.unwrap_or_else(|| panic!("no column {name}: {:?}", self.names))]
    }

    /// How many rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}
