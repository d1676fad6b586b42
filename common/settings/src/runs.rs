//! The recordings of a replay: one run a wagon, each with the vehicle file that belongs to it.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// A recording that plays one wagon.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReplayRun {
    /// The recording.
    pub path: PathBuf,
    /// Vehicle file beside it or one level up, if there is one.
    pub vehicle_file: Option<PathBuf>,
    /// Name for people: what tells this run from the others.
    pub name: String,
}

/// Names of the vehicle or rig file that belongs to the recordings beside and below it.
const VEHICLE_FILES: [&str; 2] = ["vehicle.toml", "rig.toml"];

/// Finds the runs of `patterns`: recordings, folders of recordings, or globs of either, in the order in which they are named. What one
/// pattern finds is in the order of the paths; numbers in them count by value, so that wagon 10 follows wagon 9.
///
/// # Errors
/// In words: a pattern that is none, that finds nothing, or a folder without recordings.
pub(crate) fn find(patterns: &[String], base: &Path) -> Result<Vec<ReplayRun>, String> {
    let mut paths: Vec<PathBuf> = Vec::new();
    for pattern in patterns {
        let full = base.join(pattern);
        let text = full.to_string_lossy();
        let found: Vec<PathBuf> = if full.exists() {
            vec![full.clone()]
        } else {
            glob::glob(&text)
                .map_err(|error| format!("`{pattern}` is no pattern: {}", error.msg))?
                .filter_map(Result::ok)
                .collect()
        };
        if found.is_empty() {
            return Err(format!("`{}` finds no recording and no folder", full.display()));
        }
        let mut of_pattern = Vec::new();
        for path in found {
            if path.is_dir() { of_pattern.extend(in_folder(&path)?) } else { of_pattern.push(path) }
        }
        of_pattern.retain(|path| is_recording(path));
        of_pattern.sort_by(|a, b| natural(a, b));
        // What several patterns find stands where it was named first.
        for path in of_pattern {
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
    }
    if paths.is_empty() {
        return Err(format!("`{}`: no .csv or .parquet file", patterns.join("`, `")));
    }
    let names = names(&paths);
    Ok(paths
        .into_iter()
        .zip(names)
        .map(|(path, name)| ReplayRun { vehicle_file: vehicle_file(&path), path, name })
        .collect())
}

/// Compares paths as people sort them: part by part, and numbers in a part by their value.
fn natural(a: &Path, b: &Path) -> Ordering {
    let key = |path: &Path| -> Vec<Vec<Chunk>> {
        path.components().map(|part| chunks(&part.as_os_str().to_string_lossy())).collect()
    };
    key(a).cmp(&key(b)).then_with(|| a.cmp(b))
}

/// A piece of a name; a number stands before text.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Chunk {
    /// Digits without leading zeros, the longer of two being the larger number.
    Number(usize, String),
    Text(String),
}

fn chunks(name: &str) -> Vec<Chunk> {
    let mut chunks = Vec::new();
    let mut rest = name;
    while let Some(first) = rest.chars().next() {
        let digits = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        chunks.push(if digits {
            let value = piece.trim_start_matches('0');
            Chunk::Number(value.len(), value.to_owned())
        } else {
            Chunk::Text(piece.to_owned())
        });
        rest = after;
    }
    chunks
}

fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let runs: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| is_recording(path)).collect();
    if runs.is_empty() { Err(format!("{}: no .csv or .parquet file", folder.display())) } else { Ok(runs) }
}

fn is_recording(path: &Path) -> bool {
    let hidden = path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'));
    let name = path.to_string_lossy();
    let extension = [".csv", ".csv.gz", ".parquet"].iter().any(|ending| name.ends_with(ending));
    !hidden && extension && path.is_file()
}

fn vehicle_file(run: &Path) -> Option<PathBuf> {
    let folders = run.ancestors().skip(1).take(2);
    folders.flat_map(|folder| VEHICLE_FILES.map(|name| folder.join(name))).find(|file| file.is_file())
}

/// The parts of each path that differ between the paths, joined; the file's stem alone where that suffices.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let parts = |path: &PathBuf| -> Vec<String> {
        path.with_extension("")
            .components()
            .map(|component| component.as_os_str().to_string_lossy().into_owned())
            .collect()
    };
    let all: Vec<Vec<String>> = paths.iter().map(parts).collect();
    let stems: std::collections::BTreeSet<&str> = all.iter().map(|path| from_end(path, 0)).collect();
    if stems.len() == all.len() {
        return stems_of(&all);
    }
    let depth = all.iter().map(Vec::len).min().unwrap_or(0);
    let differs: Vec<bool> = (0..depth)
        .map(|level| all.iter().any(|path| from_end(path, level) != from_end(&all[0], level)))
        .collect();
    let named = |path: &Vec<String>| {
        let telling = (0..depth).rev().filter(|level| *level == 0 || differs[*level]);
        telling.map(|level| from_end(path, level)).collect::<Vec<_>>().join("/")
    };
    all.iter().map(named).collect()
}

fn stems_of(paths: &[Vec<String>]) -> Vec<String> {
    paths.iter().map(|path| from_end(path, 0).to_owned()).collect()
}

fn from_end(path: &[String], level: usize) -> &str {
    &path[path.len() - 1 - level]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree() -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        for file in
            ["a/fit/x.dry.csv", "a/fit/y.wet.csv", "a/vehicle.toml", "b/fit/x.dry.csv", "b/fit/notes.txt"]
        {
            let path = dir.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        dir
    }

    #[test]
    fn a_glob_of_folders_gives_every_run_with_its_vehicle() {
        let dir = tree();
        let runs = find(&["*/fit".to_owned()], dir.path()).unwrap();
        let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        assert_eq!(names, ["a/x.dry", "a/y.wet", "b/x.dry"]);
        assert_eq!(runs[0].vehicle_file, Some(dir.path().join("a/vehicle.toml")));
        assert_eq!(runs[2].vehicle_file, None);
    }

    #[test]
    fn one_folder_and_one_file_are_patterns_too() {
        let dir = tree();
        let names = |pattern: &str| -> Vec<String> {
            find(&[pattern.to_owned()], dir.path()).unwrap().into_iter().map(|run| run.name).collect()
        };
        assert_eq!(names("a/fit"), ["x.dry", "y.wet"]);
        assert_eq!(names("b/fit/x.dry.csv"), ["x.dry"]);
    }

    #[test]
    fn wagon_10_follows_wagon_9() {
        let mut names = ["w10.csv", "w9.csv", "w1.wet.csv", "w1.dry.csv", "w010b.csv", "2/x.csv", "11/x.csv"];
        names.sort_by(|a, b| natural(Path::new(a), Path::new(b)));
        assert_eq!(
            names,
            ["2/x.csv", "11/x.csv", "w1.dry.csv", "w1.wet.csv", "w9.csv", "w10.csv", "w010b.csv"]
        );
    }

    #[test]
    fn runs_keep_the_order_in_which_they_were_named_and_those_of_a_pattern_are_sorted() {
        let dir = tempfile::tempdir().unwrap();
        for file in ["run2.csv", "run10.csv", "run1.csv", "b.csv", "a.csv"] {
            std::fs::write(dir.path().join(file), "").unwrap();
        }
        let names = |patterns: &[&str]| -> Vec<String> {
            let patterns: Vec<String> = patterns.iter().map(|pattern| (*pattern).to_owned()).collect();
            find(&patterns, dir.path()).unwrap().into_iter().map(|run| run.name).collect()
        };
        assert_eq!(names(&["b.csv", "a.csv", "run10.csv"]), ["b", "a", "run10"]);
        assert_eq!(names(&["b.csv", "run*.csv", "a.csv"]), ["b", "run1", "run2", "run10", "a"]);
        assert_eq!(names(&["run10.csv", "run*.csv"]), ["run10", "run1", "run2"]);
    }

    #[test]
    fn what_finds_nothing_is_named() {
        let dir = tree();
        let said = find(&["nowhere/*".to_owned()], dir.path()).unwrap_err();
        assert!(said.contains("nowhere/*"), "{said}");
        let said = find(&["a".to_owned()], dir.path()).unwrap_err();
        assert!(said.contains("no .csv or .parquet"), "{said}");
    }
}
