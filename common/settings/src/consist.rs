//! A recorded train in a folder: `train.toml` names its wagons, each with a folder that holds `vehicle.toml` and
//! `run.csv` or `run.parquet`.

use crate::SettingsError;
use crate::place::ConfigText;
use crate::runs::ReplayRun;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A recorded train.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedTrain {
    /// Its name: that of the folder, with what a name may not hold left out.
    pub name: String,
    /// Its wagons, front first.
    pub wagons: Vec<RecordedWagon>,
}

/// A wagon of a recorded train.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedWagon {
    /// Its vehicle number.
    pub number: String,
    /// Name of its folder.
    pub name: String,
    /// It is coupled to the one before or behind it.
    pub coupled: bool,
    /// The recording.
    pub run: PathBuf,
    /// What is believed of it.
    pub vehicle: PathBuf,
}

/// `train.toml`; which line it runs on and what its couplers are is not needed here.
#[derive(Debug, Deserialize)]
struct ConsistFile {
    #[serde(default)]
    wagon: Vec<WagonTable>,
}

#[derive(Debug, Deserialize)]
struct WagonTable {
    number: String,
    folder: String,
    /// To the one before it; where nothing is said, it is.
    coupled: Option<bool>,
}

impl RecordedTrain {
    /// Reads `train.toml` of a folder and finds the files that it names.
    ///
    /// # Errors
    /// A file that cannot be read, is no TOML or names no wagon; a wagon without a recording or a vehicle file.
    pub fn read(folder: &Path) -> Result<Self, SettingsError> {
        let file = folder.join("train.toml");
        let text = std::fs::read_to_string(&file)
            .map_err(|source| SettingsError::Read { file: file.clone(), source })?;
        let at = ConfigText::new(&file, &text);
        let form: ConsistFile = at.parse()?;
        if form.wagon.is_empty() {
            return Err(at.refuse("wagon", "absent", "one [[wagon]] table a wagon"));
        }
        let to_the_one_before: Vec<bool> = form
            .wagon
            .iter()
            .enumerate()
            .map(|(index, table)| index > 0 && table.coupled.unwrap_or(true))
            .chain([false])
            .collect();
        let wagon = |(index, table): (usize, WagonTable)| {
            let place = folder.join(&table.folder);
            let runs = ["run.parquet", "run.csv", "run.csv.gz"].map(|name| place.join(name));
            let run = runs.into_iter().find(|run| run.is_file()).ok_or_else(|| {
                let given = format!("{:?}", table.folder);
                at.refuse("wagon.folder", given, "a folder with run.csv or run.parquet")
            })?;
            Ok(RecordedWagon {
                number: table.number,
                name: plain(&table.folder, "wagon"),
                coupled: to_the_one_before[index] || to_the_one_before[index + 1],
                run,
                vehicle: place.join("vehicle.toml"),
            })
        };
        let wagons = form.wagon.into_iter().enumerate().map(wagon).collect::<Result<_, SettingsError>>()?;
        let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        let last = whole.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self { name: plain(&last, "train"), wagons })
    }

    /// Its recordings, for a replay.
    pub(crate) fn runs(&self) -> Vec<ReplayRun> {
        let run = |wagon: &RecordedWagon| ReplayRun {
            path: wagon.run.clone(),
            vehicle_file: Some(wagon.vehicle.clone()),
            name: wagon.name.clone(),
        };
        self.wagons.iter().map(run).collect()
    }
}

/// What of a name may stand in a name of ours; `otherwise` where nothing may.
fn plain(name: &str, otherwise: &str) -> String {
    let kept = name.chars().filter(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.'));
    let kept: String = kept.skip_while(|c| *c == '.').take(32).collect();
    if kept.is_empty() { otherwise.to_owned() } else { kept }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_train_is_found_in_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path().join("train 7");
        std::fs::create_dir_all(at.join("w01")).unwrap();
        let wagon = "[[wagon]]\nnumber = \"50 80 20-75 123-4\"\nfolder = \"w01\"\ncoupled = false\n";
        std::fs::write(at.join("train.toml"), wagon).unwrap();
        let said = RecordedTrain::read(&at).unwrap_err().to_string();
        assert!(said.contains("run.csv") && said.contains("w01"), "{said}");
        std::fs::write(at.join("w01/run.csv"), "").unwrap();
        let train = RecordedTrain::read(&at).unwrap();
        assert_eq!((train.name.as_str(), train.wagons[0].number.as_str()), ("train7", "50 80 20-75 123-4"));
        std::fs::write(at.join("train.toml"), "[line]\nid = \"L1\"\n").unwrap();
        assert!(RecordedTrain::read(&at).unwrap_err().to_string().contains("[[wagon]]"));
    }
}
