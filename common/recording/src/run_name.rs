//! Names of runs: `NAME.RAIL.csv`, and the runs of a folder.

use crate::error::{Problem, RecordingError, Result};
use crate::table_file::Form;
use std::fmt;
use std::path::{Path, PathBuf};

/// Condition of the rail that a run's name declares; picks the adhesion level in a vehicle file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RailClass {
    /// Dry rail.
    Dry,
    /// Wet rail.
    Wet,
    /// Low adhesion: leaves, oil, ice.
    Low,
}

impl RailClass {
    /// All classes, best adhesion first.
    pub const ALL: [Self; 3] = [Self::Dry, Self::Wet, Self::Low];

    /// The class as it stands in names and files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
            Self::Low => "low",
        }
    }

    /// The class of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }
}

impl fmt::Display for RailClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A file that holds a run.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct RunFile {
    /// `NAME.RAIL`, or `NAME` where the name declares no rail.
    pub name: String,
    /// Rail class that the name declares.
    pub rail: Option<RailClass>,
    /// The file.
    pub path: PathBuf,
}

impl RunFile {
    /// Reads the name of a file; the file need not exist. Fails for an ending other than `.csv` or `.parquet`.
    pub fn of(path: &Path) -> Result<Self> {
        Form::of(path)?;
        let mut name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        if path.extension().is_some_and(|ending| ending == "gz") {
            name.truncate(name.strip_suffix(".csv").map_or(name.len(), str::len));
        }
        let rail = name.rsplit_once('.').and_then(|(_, rail)| RailClass::parse(rail));
        Ok(Self { name, rail, path: path.to_owned() })
    }

    /// The rail class, or the error that the name lacks it.
    pub fn require_rail(&self) -> Result<RailClass> {
        self.rail.ok_or_else(|| RecordingError::new(&self.path, Problem::RailClass))
    }
}

/// The runs of a folder in the order of their names. Other files, hidden ones and sub-folders are not runs; a folder without any
/// run, and a run that stands there in both forms, are errors.
pub fn runs_in(folder: &Path) -> Result<Vec<RunFile>> {
    let io = |e| RecordingError::new(folder, Problem::Io(e));
    let mut runs = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if !hidden && path.is_file() && Form::of(&path).is_ok() {
            runs.push(RunFile::of(&path)?);
        }
    }
    runs.sort();
    if runs.is_empty() {
        return Err(RecordingError::new(folder, Problem::NoRuns));
    }
    match runs.windows(2).find(|pair| pair[0].name == pair[1].name) {
        Some(pair) => Err(RecordingError::new(&pair[1].path, Problem::RunTwice)),
        None => Ok(runs),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rail_class_is_the_last_word_of_the_name() {
        let run = RunFile::of(Path::new("x/a.b.wet.csv")).expect("a run");
        assert_eq!((run.name.as_str(), run.rail), ("a.b.wet", Some(RailClass::Wet)));
        let packed = RunFile::of(Path::new("a.dry.csv.gz")).expect("a run");
        assert_eq!((packed.name.as_str(), packed.rail), ("a.dry", Some(RailClass::Dry)));
        let other = RunFile::of(Path::new("wagon1.parquet")).expect("a run without rail");
        assert_eq!(other.rail, None);
        let error = other.require_rail().expect_err("no rail").to_string();
        assert!(error.contains("wagon1.parquet") && error.contains("dry, wet or low"), "{error}");
        assert!(RunFile::of(Path::new("run.dry.txt")).is_err());
    }

    #[test]
    fn a_folder_lists_its_runs_in_order_and_refuses_twins() {
        let folder = tempfile::tempdir().expect("folder");
        assert!(matches!(runs_in(folder.path()).expect_err("empty").problem, Problem::NoRuns));
        for name in ["b.dry.csv", "a.low.parquet", ".hidden.csv", "vehicle.toml"] {
            std::fs::write(folder.path().join(name), "x").expect("write");
        }
        std::fs::create_dir(folder.path().join("truth")).expect("truth");
        let names: Vec<String> =
            runs_in(folder.path()).expect("runs").into_iter().map(|run| run.name).collect();
        assert_eq!(names, ["a.low", "b.dry"]);
        std::fs::write(folder.path().join("b.dry.parquet"), "x").expect("write");
        assert!(matches!(runs_in(folder.path()).expect_err("twins").problem, Problem::RunTwice));
    }
}
