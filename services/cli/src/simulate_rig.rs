//! `railgrip simulate` with a published test of a rig: `DIR/NAME.csv` is the recording, `DIR/truth/NAME.csv` what no
//! sensor saw, row for row, and `DIR/rig.toml` the rig as a filter may know it. The folder can be replayed as it is.

use std::path::Path;

use railgrip_experiments::rigs::RigRow;
use railgrip_filter::{Plant, PlantKind};
use railgrip_recording::{BogieRecording, MotorRecording, Optional, Recording, RecordingError, Table, Truth};
use railgrip_settings::RigProgramme;

use crate::CliError;
use crate::output::{only_own, say};

/// Columns of a roller rig: its sand and its place are no sensors.
const ROLLER: Optional = Optional { grade: true, wsp: true, ..Optional::NONE };

/// Runs the test into a folder; `ending` is the form of the files.
pub(crate) fn run(programme: RigProgramme, seed: u64, out: &Path, ending: &str) -> Result<(), CliError> {
    let feed = railgrip_ingest::feed::feed_of(programme, seed);
    let plant = feed.plant().clone();
    only_own(out, ("rig.toml", &rig_file(&plant)?), is_own)?;
    let rows: Vec<RigRow> = feed.collect();
    let truth = out.join("truth");
    let failed =
        |path: &Path, error: std::io::Error| CliError::failed(format!("{}: {error}", path.display()));
    std::fs::create_dir_all(&truth).map_err(|error| failed(&truth, error))?;
    for folder in [out, &truth] {
        remove_earlier(folder).map_err(|error| failed(folder, error))?;
    }
    let file = format!("{}.{ending}", programme.name());
    match plant.kind() {
        PlantKind::Traction => write_motor(&rows, &out.join(&file), &truth.join(&file)),
        PlantKind::Bogie => write_bogie(&rows, &out.join(&file), &truth.join(&file)),
        PlantKind::Wagon | PlantKind::Roller => write_roller(&rows, &out.join(&file), &truth.join(&file)),
    }
    .map_err(CliError::failed)?;
    let rig = out.join("rig.toml");
    std::fs::write(&rig, rig_file(&plant)?).map_err(|error| failed(&rig, error))?;
    let seconds = rows.last().map_or(0.0, RigRow::time_s);
    say(&format!("{}: {} samples over {seconds:.1} s, seed {seed}", programme.name(), rows.len()));
    say(&format!("written to {}: {file}, truth/{file}, rig.toml", out.display()));
    Ok(())
}

/// The text of a rig's file.
fn rig_file(plant: &Plant) -> Result<String, CliError> {
    match plant {
        Plant::Roller(rig) => toml::to_string(rig).map_err(CliError::failed),
        Plant::Traction(rig) => toml::to_string(rig).map_err(CliError::failed),
        Plant::Bogie(rig) => toml::to_string(rig).map_err(CliError::failed),
        Plant::Wagon(vehicle) => toml::to_string(vehicle).map_err(CliError::failed),
    }
}

fn write_motor(rows: &[RigRow], run: &Path, truth: &Path) -> Result<(), RecordingError> {
    let mut recording = MotorRecording::default();
    let mut truths = Vec::with_capacity(rows.len());
    for row in rows {
        if let RigRow::Motor { row, truth } = row {
            recording.rows.push(*row);
            truths.push(truth.columns());
        }
    }
    recording.write(run)?;
    write_truth(&truths, truth)
}

fn write_bogie(rows: &[RigRow], run: &Path, truth: &Path) -> Result<(), RecordingError> {
    let mut recording = BogieRecording::default();
    let mut truths = Vec::with_capacity(rows.len());
    for row in rows {
        if let RigRow::Bogie { row, truth } = row {
            recording.rows.push(*row);
            truths.push(truth.columns());
        }
    }
    recording.write(run)?;
    write_truth(&truths, truth)
}

fn write_truth<const N: usize>(
    truths: &[[(&'static str, f64); N]],
    path: &Path,
) -> Result<(), RecordingError> {
    let names = truths.first().map_or([""; N], |truth| truth.map(|(name, _)| name));
    let columns = names
        .iter()
        .enumerate()
        .map(|(index, name)| ((*name).to_owned(), truths.iter().map(|truth| truth[index].1).collect()));
    Table::new(columns.collect())?.write(path)
}

fn write_roller(rows: &[RigRow], run: &Path, truth: &Path) -> Result<(), RecordingError> {
    let mut recording = Recording::empty("rig", None, 1, ROLLER);
    let mut truths = Truth::empty(1);
    for row in rows {
        if let RigRow::Wagon { row, truth } = row {
            recording.push(row);
            truths.push(truth);
        }
    }
    recording.write(run)?;
    truths.write(truth)
}

/// Removes the rigs of an earlier simulation, whose file `rig.toml` would no longer describe.
fn remove_earlier(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_file() && path.file_name().is_some_and(|name| is_own(&name.to_string_lossy())) {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// Whether a file is named as this command names the run of a rig.
fn is_own(name: &str) -> bool {
    let Some((stem, ending)) = name.rsplit_once('.') else { return false };
    matches!(ending, "csv" | "parquet") && RigProgramme::from_name(stem).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_recording::Strictness;

    #[test]
    fn every_rigs_folder_can_be_read_back() {
        let folder = tempfile::tempdir().expect("folder");
        let read = |name: &str, ending: &str| {
            let out = folder.path().join(name);
            run(RigProgramme::from_name(name).expect("known"), 3, &out, ending).expect("simulated");
            let plant = railgrip_settings::plant::load(&out.join("rig.toml")).expect("rig file");
            (plant, out.join(format!("{name}.{ending}")), out.join(format!("truth/{name}.{ending}")))
        };
        let (plant, run, truth) = read("zhao-water-3", "parquet");
        let recording = MotorRecording::read(&run, Strictness::Strict).expect("strict");
        let truth = Table::read(&truth).expect("truth");
        assert_eq!((plant.kind(), recording.rows.len(), truth.rows()), (PlantKind::Traction, 35_000, 35_000));
        let (plant, run, truth) = read("shrestha-wet-proposed", "csv");
        let recording = BogieRecording::read(&run, Strictness::Strict).expect("strict");
        let truth = Table::read(&truth).expect("truth");
        assert_eq!((plant.kind(), truth.rows()), (PlantKind::Bogie, recording.rows.len()));
        assert!(recording.rows.len() > 5000);
        let (plant, run, truth) = read("schwarz-wsp", "csv");
        let recording = Recording::read(&run, Strictness::Strict).expect("strict");
        let truth = Truth::read(&truth).expect("truth");
        assert_eq!((plant.kind(), recording.wheelsets), (PlantKind::Roller, 1));
        assert!(recording.len() > 10_000 && recording.len() == truth.len());
    }
}
