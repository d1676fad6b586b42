//! The files of one wagon.

use std::path::{Path, PathBuf};

use railgrip_bus::{
    BogieSubscriber, Bus, BusError, EstimateSubscriber, MotorSubscriber, SampleSubscriber, Subscriber, now,
};
use railgrip_filter::PlantKind;
use railgrip_messages::{
    BogieSample, Checked, Estimate, MotorSample, Sample, bogie_valid, motor_valid, valid,
};
use railgrip_recording::{
    BogieRow, MotorRow, Optional, RecordingError, RigRow, RigRunWriter, Row, RunWriter,
};

use super::estimates::EstimateWriter;
use crate::CliError;

/// Writes samples and estimates of one wagon or rig.
pub(super) struct WagonRecorder {
    name: String,
    plant: PlantKind,
    samples: Samples,
    estimates: EstimateSubscriber,
    estimate_files: Series<EstimateWriter>,
    scratch_estimates: Vec<Estimate>,
    /// Samples and estimates that no reader takes.
    refused: u64,
}

/// The samples of a wagon or rig on their way into files.
enum Samples {
    Wagon { channel: SampleSubscriber, files: Box<Series<RunWriter>>, scratch: Vec<Sample> },
    Motor { channel: MotorSubscriber, files: Series<RigRunWriter<MotorRow>>, scratch: Vec<MotorSample> },
    Bogie { channel: BogieSubscriber, files: Series<RigRunWriter<BogieRow>>, scratch: Vec<BogieSample> },
}

impl Samples {
    fn open(bus: &Bus, wagon: u32, plant: PlantKind, folder: &Path, name: &str) -> Result<Self, BusError> {
        Ok(match plant {
            PlantKind::Traction => Self::Motor {
                channel: bus.motor_subscriber(wagon)?,
                files: Series::new(folder, name),
                scratch: Vec::new(),
            },
            PlantKind::Bogie => Self::Bogie {
                channel: bus.bogie_subscriber(wagon)?,
                files: Series::new(folder, name),
                scratch: Vec::new(),
            },
            PlantKind::Wagon | PlantKind::Roller => Self::Wagon {
                channel: bus.sample_subscriber(wagon)?,
                files: Box::new(Series::new(folder, name)),
                scratch: Vec::new(),
            },
        })
    }

    /// Writes everything that arrived.
    fn take(&mut self, refused: &mut u64) -> Result<(), CliError> {
        match self {
            Self::Wagon { channel, files, scratch } => {
                receive(channel, scratch, refused)?;
                for sample in scratch {
                    let create = |path: &Path| {
                        RunWriter::create(path, sample.wheelset_count(), optional(sample)).map_err(failed)
                    };
                    let finish = |writer: RunWriter| writer.finish().map_err(failed);
                    files.writer(sample.time_s, create, finish)?.push(&row(sample)).map_err(failed)?;
                }
            }
            Self::Motor { channel, files, scratch } => {
                take_rows(channel, files, scratch, refused, motor_row)?
            }
            Self::Bogie { channel, files, scratch } => {
                take_rows(channel, files, scratch, refused, bogie_row)?
            }
        }
        Ok(())
    }

    /// Gives the last file its name; rows, files and samples missed.
    fn finish(self) -> Result<(u64, u32, u64), CliError> {
        match self {
            Self::Wagon { channel, files, .. } => {
                let (rows, count) = (files.rows, files.files);
                if let Some((writer, _)) = files.open {
                    writer.finish().map_err(failed)?;
                }
                Ok((rows, count, channel.missed()))
            }
            Self::Motor { channel, files, .. } => finish_rows(channel.missed(), files),
            Self::Bogie { channel, files, .. } => finish_rows(channel.missed(), files),
        }
    }
}

/// Takes everything that arrived and is sound: nonsense in a channel neither gets into a recording nor ends it.
fn receive<T: Checked>(
    channel: &mut Subscriber<T>,
    into: &mut Vec<T>,
    refused: &mut u64,
) -> Result<(), CliError> {
    into.clear();
    let now = now();
    channel.receive(|batch| {
        let before = into.len();
        into.extend(batch.iter().filter(|item| item.validated(now).is_ok()));
        *refused += (batch.len() - (into.len() - before)) as u64;
    })?;
    Ok(())
}

/// Writes everything that arrived from a rig.
fn take_rows<T: Checked, R: RigRow>(
    channel: &mut Subscriber<T>,
    files: &mut Series<RigRunWriter<R>>,
    scratch: &mut Vec<T>,
    refused: &mut u64,
    row: fn(&T) -> R,
) -> Result<(), CliError> {
    receive(channel, scratch, refused)?;
    for sample in scratch {
        let row = row(sample);
        let create = |path: &Path| RigRunWriter::create(path).map_err(failed);
        let finish = |writer: RigRunWriter<R>| writer.finish().map_err(failed);
        files.writer(row.t_s(), create, finish)?.push(&row).map_err(failed)?;
    }
    Ok(())
}

fn finish_rows<R: RigRow>(missed: u64, files: Series<RigRunWriter<R>>) -> Result<(u64, u32, u64), CliError> {
    let (rows, count) = (files.rows, files.files);
    if let Some((writer, _)) = files.open {
        writer.finish().map_err(failed)?;
    }
    Ok((rows, count, missed))
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
        // A wagon that is named after its recording's folders gets a file, not folders.
        Self { folder: folder.to_owned(), name: name.replace('/', "-"), open: None, files: 0, rows: 0 }
    }

    /// The file of that number, 1 first.
    fn path(&self, number: u32) -> PathBuf {
        let suffix = if number == 1 { String::new() } else { format!("-{number}") };
        self.folder.join(format!("{}{suffix}.csv", self.name))
    }

    /// Fails if a file of this series is there already: what somebody recorded is never written over.
    fn check_new(&self) -> Result<(), CliError> {
        let first = format!("{}.csv", self.name);
        let further = format!("{}-", self.name);
        for entry in std::fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let number = name.strip_prefix(&further).and_then(|rest| rest.strip_suffix(".csv"));
            if name == first || number.is_some_and(|number| number.parse::<u32>().is_ok()) {
                return Err(exists(&entry.path()));
            }
        }
        Ok(())
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
            let path = self.path(self.files);
            if path.exists() {
                return Err(exists(&path));
            }
            self.open = Some((create(&path)?, time_s));
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

fn exists(path: &Path) -> CliError {
    CliError::bad_input(format!(
        "{} exists; recordings are not written over, name another --out",
        path.display()
    ))
}

impl WagonRecorder {
    pub(super) fn open(
        bus: &Bus,
        wagon: u32,
        plant: PlantKind,
        name: &str,
        folder: &Path,
    ) -> Result<Self, CliError> {
        Series::<RunWriter>::new(folder, name).check_new()?;
        Series::<EstimateWriter>::new(&folder.join("estimates"), name).check_new()?;
        Ok(Self {
            name: name.to_owned(),
            plant,
            samples: Samples::open(bus, wagon, plant, folder, name)?,
            estimates: bus.estimate_subscriber(wagon)?,
            estimate_files: Series::new(&folder.join("estimates"), name),
            scratch_estimates: Vec::new(),
            refused: 0,
        })
    }

    /// Writes everything that arrived.
    pub(super) fn take(&mut self) -> Result<(), CliError> {
        self.samples.take(&mut self.refused)?;
        let (plant, estimates) = (self.plant, &mut self.scratch_estimates);
        receive(&mut self.estimates, estimates, &mut self.refused)?;
        for estimate in estimates {
            let create = |path: &Path| EstimateWriter::create(path, plant, estimate.wheelset_count());
            let writer = self.estimate_files.writer(estimate.time_s, create, EstimateWriter::finish)?;
            writer.push(estimate)?;
        }
        Ok(())
    }

    /// Gives the files their names and says what is in them.
    pub(super) fn finish(self) -> Result<String, CliError> {
        let (rows, files, missed) = self.samples.finish()?;
        if let Some((writer, _)) = self.estimate_files.open {
            writer.finish()?;
        }
        let refused = match self.refused {
            0 => String::new(),
            count => format!(", {count} refused"),
        };
        Ok(format!(
            "{}: {rows} samples in {files} files ({missed} missed), {} estimates in {} files ({} missed){refused}",
            self.name,
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
        ..Optional::NONE
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

/// The same of a rig with a motor.
fn motor_row(sample: &MotorSample) -> MotorRow {
    let value = |bit: u32, value: f64| if sample.has(bit) { value } else { f64::NAN };
    MotorRow {
        t_s: sample.time_s,
        current_a: [0, 1].map(|axis| value(motor_valid::current(axis), sample.current_a[axis])),
        voltage_v: [0, 1].map(|axis| value(motor_valid::voltage(axis), sample.voltage_v[axis])),
        motor_speed_rad_s: value(motor_valid::MOTOR_SPEED, sample.motor_speed_rad_s),
        roller_speed_rad_s: value(motor_valid::ROLLER_SPEED, sample.roller_speed_rad_s),
        generator_current_a: value(motor_valid::GENERATOR_CURRENT, sample.generator_current_a),
    }
}

/// The same of a bogie rig.
fn bogie_row(sample: &BogieSample) -> BogieRow {
    let value = |bit: u32, value: f64| if sample.has(bit) { value } else { f64::NAN };
    BogieRow {
        t_s: sample.time_s,
        shaft_torque_nm: value(bogie_valid::SHAFT_TORQUE, sample.shaft_torque_nm),
        load_cell_n: value(bogie_valid::LOAD_CELL, sample.load_cell_n),
        brake_pressure_pa: value(bogie_valid::BRAKE_PRESSURE, sample.brake_pressure_pa),
        load_n: value(bogie_valid::LOAD, sample.load_n),
        roller_pulses: value(bogie_valid::ROLLER_PULSES, sample.roller_pulses),
        wheel_pulses: [0, 1].map(|i| value(bogie_valid::wheel_pulses(i), sample.wheel_pulses[i])),
    }
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
