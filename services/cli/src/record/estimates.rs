//! Estimates as a file in the columns of `railgrip estimate`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use railgrip_filter::PlantKind;
use railgrip_messages::Estimate;

use crate::CliError;
use crate::estimate_columns::{Cell, Column, columns};

/// Writes rows beside the file's place; [`EstimateWriter::finish`] gives it its name.
pub(super) struct EstimateWriter {
    path: PathBuf,
    beside: PathBuf,
    file: BufWriter<File>,
    columns: Vec<Column>,
}

impl EstimateWriter {
    pub(super) fn create(path: &Path, plant: PlantKind, wheelsets: usize) -> Result<Self, CliError> {
        let beside = path.with_extension("csv.part");
        let file = File::create(&beside).map_err(|error| failed(&beside, &error))?;
        let columns = columns(plant, wheelsets, false);
        let header = header(&columns);
        let mut writer = Self { path: path.to_owned(), beside, file: BufWriter::new(file), columns };
        writer.line(&header)?;
        Ok(writer)
    }

    pub(super) fn push(&mut self, estimate: &Estimate) -> Result<(), CliError> {
        let line = line(estimate, &self.columns);
        self.line(&line)
    }

    pub(super) fn finish(mut self) -> Result<(), CliError> {
        self.file
            .flush()
            .and_then(|()| std::fs::rename(&self.beside, &self.path))
            .map_err(|error| failed(&self.path, &error))
    }

    fn line(&mut self, line: &str) -> Result<(), CliError> {
        writeln!(self.file, "{line}").map_err(|error| failed(&self.beside, &error))
    }
}

fn failed(path: &Path, error: &std::io::Error) -> CliError {
    CliError::failed(format!("{}: {error}", path.display()))
}

fn header(columns: &[Column]) -> String {
    columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(",")
}

/// Numbers as a table writes them: the shortest text with the same bits, nothing for what is not a number.
fn line(estimate: &Estimate, columns: &[Column]) -> String {
    let text = |column: &Column| match column.cell(estimate) {
        Cell::Number(value) if value.is_nan() => String::new(),
        Cell::Number(value) => format!("{value:?}"),
        Cell::Word(word) => word.to_owned(),
    };
    columns.iter().map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_those_of_the_offline_estimator() {
        let columns = columns(PlantKind::Wagon, 2, false);
        assert_eq!(
            header(&columns),
            "t_s,v_m_s,mu_w,mu_w_sigma,mu_b_f,mu_b_f_sigma,mu_b_r,mu_b_r_sigma,slip_f,slip_r,nis,observable_f,observable_r"
        );
        let estimate = Estimate {
            mu_b: [0.25, 0.5, 0.0, 0.0],
            observable: 0b10,
            normal_load_n: [2e5; 4],
            ..Estimate::default()
        };
        assert_eq!(line(&estimate, &columns), "0.0,0.0,0.0,0.0,0.25,0.0,0.5,0.0,0.0,0.0,0.0,0.0,1.0");
    }
}
