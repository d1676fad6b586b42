//! Estimates as a file in the columns of `railgrip estimate`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use railgrip_messages::Estimate;

use crate::CliError;

/// Writes rows beside the file's place; [`EstimateWriter::finish`] gives it its name.
pub(super) struct EstimateWriter {
    path: PathBuf,
    beside: PathBuf,
    file: BufWriter<File>,
    wheelsets: usize,
}

impl EstimateWriter {
    pub(super) fn create(path: &Path, wheelsets: usize) -> Result<Self, CliError> {
        let beside = path.with_extension("csv.part");
        let file = File::create(&beside).map_err(|error| failed(&beside, &error))?;
        let mut writer = Self { path: path.to_owned(), beside, file: BufWriter::new(file), wheelsets };
        writer.line(&header(wheelsets))?;
        Ok(writer)
    }

    pub(super) fn push(&mut self, estimate: &Estimate) -> Result<(), CliError> {
        let line = line(estimate, self.wheelsets);
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

fn header(wheelsets: usize) -> String {
    let each = |form: &dyn Fn(&str) -> String| -> String {
        (0..wheelsets).map(|wheelset| form(&railgrip_recording::suffix(wheelset, wheelsets))).collect()
    };
    format!(
        "t_s,v_m_s,mu_w,mu_w_sigma{},nis{}",
        each(&|s| format!(",mu_b_{s},mu_b_{s}_sigma")) + &each(&|s| format!(",slip_{s}")),
        each(&|s| format!(",observable_{s}")),
    )
}

fn line(estimate: &Estimate, wheelsets: usize) -> String {
    let each = |form: &dyn Fn(usize) -> String| -> String { (0..wheelsets).map(form).collect() };
    format!(
        "{},{},{},{}{},{}{}",
        estimate.time_s,
        estimate.v_m_s,
        estimate.mu_w,
        estimate.mu_w_sigma,
        each(&|i| format!(",{},{}", estimate.mu_b[i], estimate.mu_b_sigma[i]))
            + &each(&|i| format!(",{}", estimate.slip[i])),
        estimate.nis,
        each(&|i| format!(",{}", estimate.observable >> i & 1)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_those_of_the_offline_estimator() {
        assert_eq!(
            header(2),
            "t_s,v_m_s,mu_w,mu_w_sigma,mu_b_f,mu_b_f_sigma,mu_b_r,mu_b_r_sigma,slip_f,slip_r,nis,observable_f,observable_r"
        );
        let estimate = Estimate { mu_b: [0.25, 0.5, 0.0, 0.0], observable: 0b10, ..Estimate::default() };
        assert_eq!(line(&estimate, 2), "0,0,0,0,0.25,0,0.5,0,0,0,0,0,1");
    }
}
