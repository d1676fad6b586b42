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
    /// A file that cannot be read, is no TOML or names no wagon; a key that is misspelt; a number or a folder that two wagons have;
    /// a wagon without a recording.
    pub fn read(folder: &Path) -> Result<Self, SettingsError> {
        let file = folder.join("train.toml");
        let text = railgrip_recording::read_text(&file)
            .map_err(|source| SettingsError::Read { file: file.clone(), source })?;
        let at = ConfigText::new(&file, &text);
        let form: ConsistFile = at.parse()?;
        if form.wagon.is_empty() {
            return Err(at.refuse("wagon", "absent", "one [[wagon]] table a wagon"));
        }
        no_misspelt_key(&at)?;
        no_wagon_twice(&at, &form.wagon)?;
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
                at.refuse(
                    &format!("wagon.{}.folder", index + 1),
                    given,
                    "a folder with run.csv or run.parquet",
                )
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

/// Keys of a `[[wagon]]` table.
const OF_WAGON: [&str; 3] = ["number", "folder", "coupled"];
/// A key that differs from one of them by at most so many letters is a misspelt one; others are not ours.
const MISSPELT: usize = 2;

/// Refuses a key that is nearly one of ours: `copuled = false` would leave the wagon coupled, and nobody would hear of it.
fn no_misspelt_key(at: &ConfigText<'_>) -> Result<(), SettingsError> {
    let whole: toml::Table = at.parse()?;
    let wagons = whole.get("wagon").and_then(toml::Value::as_array).into_iter().flatten();
    for (index, table) in wagons.filter_map(toml::Value::as_table).enumerate() {
        let others = table.keys().filter(|key| !OF_WAGON.contains(&key.as_str()));
        for key in others {
            if let Some(meant) = OF_WAGON.iter().find(|known| strsim::levenshtein(key, known) <= MISSPELT) {
                return Err(at.refuse(&format!("wagon.{}.{key}", index + 1), "no key", format!("`{meant}`")));
            }
        }
    }
    Ok(())
}

/// Refuses a vehicle number or a folder that an earlier wagon has: an alert would be of either.
fn no_wagon_twice(at: &ConfigText<'_>, wagons: &[WagonTable]) -> Result<(), SettingsError> {
    for (index, table) in wagons.iter().enumerate() {
        let twice = |key: &str, value: &str, of: fn(&WagonTable) -> &str| {
            let first = wagons[..index].iter().position(|earlier| of(earlier) == value)?;
            let allowed = format!("one that wagon {} does not have", first + 1);
            Some(at.refuse(&format!("wagon.{}.{key}", index + 1), format!("{value:?}"), allowed))
        };
        let found = twice("number", &table.number, |wagon| &wagon.number)
            .or_else(|| twice("folder", &table.folder, |wagon| &wagon.folder));
        found.map_or(Ok(()), Err)?;
    }
    Ok(())
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

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        for wagon in ["w01", "w02"] {
            std::fs::create_dir_all(folder.path().join(wagon)).unwrap();
            std::fs::write(folder.path().join(wagon).join("run.csv"), "").unwrap();
        }
        let said = |text: &str| {
            std::fs::write(folder.path().join("train.toml"), text).unwrap();
            RecordedTrain::read(folder.path()).map(|train| train.wagons.len()).map_err(|e| e.to_string())
        };
        let two = "[[wagon]]\nnumber = \"1\"\nfolder = \"w01\"\n[[wagon]]\nnumber = \"2\"\nfolder = \"w02\"\ncoupled = false\n";
        assert_eq!(said(&format!("{two}length_m = 20.0\n")), Ok(2), "keys of others are theirs");
        for (right, wrong, named) in [
            ("coupled", "copuled", ["train.toml:7", "`wagon.2.copuled`", "`coupled`"]),
            ("w02", "w03", ["train.toml:6", "`wagon.2.folder`", "w03"]),
            ("w02", "w01", ["train.toml:6", "`wagon.2.folder`", "wagon 1"]),
            ("\"2\"", "\"1\"", ["train.toml:5", "`wagon.2.number`", "wagon 1"]),
        ] {
            let error = said(&two.replace(right, wrong)).unwrap_err();
            assert!(named.iter().all(|part| error.contains(part)), "{error}");
        }
    }
}
