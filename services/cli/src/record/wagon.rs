//! The files of one wagon.

use std::path::{Path, PathBuf};

use railgrip_bus::{Bus, EstimateSubscriber, SampleSubscriber};
use railgrip_messages::{Estimate, Sample, valid};
use railgrip_recording::{Optional, RecordingError, Row, RunWriter};

use super::estimates::EstimateWriter;
use crate::CliError;

/// Writes samples and estimates of one wagon.
pub(super) struct WagonRecorder {
    name: String,
    samples: SampleSubscriber,
    estimates: EstimateSubscriber,
    runs: Series<RunWriter>,
    estimate_files: Series<EstimateWriter>,
    scratch_samples: Vec<Sample>,
    scratch_estimates: Vec<Estimate>,
}

/// A series of files, of which the last is open.
struct Series<W> {
    folder: PathBuf,
    name: String,
    open: Option<(W, f64)>,
    files: u32,
    rows: u64,
}

impl<W> Series<W> {
    fn new(folder: &Path, name: &str) -> Self {
        Self { folder: folder.to_owned(), name: name.to_owned(), open: None, files: 0, rows: 0 }
    }

    /// The writer for a row at `time_s`; a time that does not go on begins a new file.
    fn writer(
        &mut self,
        time_s: f64,
        create: impl FnOnce(&Path) -> Result<W, CliError>,
        finish: impl FnOnce(W) -> Result<(), CliError>,
    ) -> Result<&mut W, CliError> {
        match self.open.take() {
            Some((writer, last_s)) if time_s <= last_s => finish(writer)?,
            open => self.open = open,
        }
        if self.open.is_none() {
            self.files += 1;
            let file = if self.files == 1 {
                format!("{}.csv", self.name)
            } else {
                format!("{}-{}.csv", self.name, self.files)
            };
            self.open = Some((create(&self.folder.join(file))?, time_s));
        }
        self.rows += 1;
        match &mut self.open {
            Some((writer, last_s)) => {
                *last_s = time_s;
                Ok(writer)
            }
            None => Err(CliError::failed("no file is open")),
        }
    }
}

impl WagonRecorder {
    pub(super) fn open(bus: &Bus, wagon: u32, name: &str, folder: &Path) -> Result<Self, CliError> {
        Ok(Self {
            name: name.to_owned(),
            samples: bus.sample_subscriber(wagon)?,
            estimates: bus.estimate_subscriber(wagon)?,
            runs: Series::new(folder, name),
            estimate_files: Series::new(&folder.join("estimates"), name),
            scratch_samples: Vec::new(),
            scratch_estimates: Vec::new(),
        })
    }

    /// Writes everything that arrived.
    pub(super) fn take(&mut self) -> Result<(), CliError> {
        let (samples, estimates) = (&mut self.scratch_samples, &mut self.scratch_estimates);
        samples.clear();
        estimates.clear();
        self.samples.receive(|batch| samples.extend_from_slice(batch))?;
        self.estimates.receive(|batch| estimates.extend_from_slice(batch))?;
        for sample in samples {
            let create = |path: &Path| {
                RunWriter::create(path, sample.wheelset_count(), optional(sample)).map_err(failed)
            };
            let writer = self.runs.writer(sample.time_s, create, |writer| writer.finish().map_err(failed))?;
            writer.push(&row(sample)).map_err(failed)?;
        }
        for estimate in estimates {
            let create = |path: &Path| EstimateWriter::create(path, estimate.wheelset_count());
            let writer = self.estimate_files.writer(estimate.time_s, create, EstimateWriter::finish)?;
            writer.push(estimate)?;
        }
        Ok(())
    }

    /// Gives the files their names and says what is in them.
    pub(super) fn finish(self) -> Result<String, CliError> {
        if let Some((writer, _)) = self.runs.open {
            writer.finish().map_err(failed)?;
        }
        if let Some((writer, _)) = self.estimate_files.open {
            writer.finish()?;
        }
        Ok(format!(
            "{}: {} samples in {} files ({} missed), {} estimates in {} files ({} missed)",
            self.name,
            self.runs.rows,
            self.runs.files,
            self.samples.missed(),
            self.estimate_files.rows,
            self.estimate_files.files,
            self.estimates.missed()
        ))
    }
}

fn failed(error: RecordingError) -> CliError {
    CliError::failed(error)
}

/// The optional columns that the first sample of a run brings.
fn optional(sample: &Sample) -> Optional {
    Optional {
        grade: sample.has(valid::GRADE),
        sanding: sample.has(valid::SANDING),
        position: sample.has(valid::POSITION),
        wsp: sample.has(valid::WSP),
    }
}

/// A missing value is NaN in a recording.
fn row(sample: &Sample) -> Row {
    let value = |bit: u32, value: f64| if sample.has(bit) { value } else { f64::NAN };
    let mut row = Row {
        t_s: sample.time_s,
        v_m_s: value(valid::SPEED, sample.v_m_s),
        grade_rad: value(valid::GRADE, sample.grade_rad),
        sanding: value(valid::SANDING, sample.sanding),
        position_m: value(valid::POSITION, sample.position_m),
        ..Row::default()
    };
    for i in 0..sample.wheelset_count() {
        row.wheel_speed_rad_s[i] = value(valid::wheel_speed(i), sample.wheel_speed_rad_s[i]);
        row.pressing_force_n[i] = value(valid::pressing_force(i), sample.pressing_force_n[i]);
        row.drive_torque_nm[i] = value(valid::drive_torque(i), sample.drive_torque_nm[i]);
        row.wsp_active[i] = value(valid::WSP, f64::from(sample.wsp_active >> i & 1));
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_value_becomes_nan_and_a_bit_its_wheelset() {
        let sample = Sample {
            wheelsets: 2,
            v_m_s: 12.5,
            grade_rad: 0.01,
            wsp_active: 0b10,
            valid: valid::SPEED | valid::WSP,
            ..Sample::default()
        };
        let row = row(&sample);
        assert_eq!(row.v_m_s, 12.5);
        assert!(row.grade_rad.is_nan() && row.wheel_speed_rad_s[0].is_nan());
        assert_eq!(row.wsp_active[..2], [0.0, 1.0]);
        assert!(!optional(&sample).grade && optional(&sample).wsp);
    }

    #[test]
    fn a_time_that_begins_again_begins_a_new_file() {
        let mut series: Series<Vec<f64>> = Series::new(Path::new("out"), "coach");
        let mut names = Vec::new();
        let mut finished = 0;
        for time_s in [0.0, 0.1, 0.2, 0.0, 0.1, 0.1] {
            let create = |path: &Path| {
                names.push(path.display().to_string());
                Ok(Vec::new())
            };
            let finish = |_| {
                finished += 1;
                Ok(())
            };
            series.writer(time_s, create, finish).unwrap().push(time_s);
        }
        assert_eq!(names, ["out/coach.csv", "out/coach-2.csv", "out/coach-3.csv"]);
        assert_eq!((finished, series.rows), (2, 6));
    }
}
