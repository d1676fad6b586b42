//! What people and scripts read: results on the standard output, complaints on the standard error.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::CliError;

/// Why the standard output did not take all of a result.
static CUT_SHORT: OnceLock<String> = OnceLock::new();

/// Writes a line to the standard output. A reader that went away (`| head`) is no error; any other failure is told by [`whole`].
pub(crate) fn say(line: &str) {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = writeln!(stdout, "{line}").and_then(|()| stdout.flush())
        && error.kind() != ErrorKind::BrokenPipe
    {
        let _ = CUT_SHORT.set(error.to_string());
    }
}

/// Fails if the standard output did not take all that was written, as on a full disk.
pub(crate) fn whole() -> Result<(), CliError> {
    match CUT_SHORT.get() {
        Some(problem) => {
            Err(CliError::failed(format!("standard output: {problem}; what it holds is not whole")))
        }
        None => Ok(()),
    }
}

/// Refuses files to be written that cannot be, before anything is computed for them: one that is read, or lies in a folder of which the
/// files are read, one that is written twice, one without its folder. Each is given with its option.
pub(crate) fn apart(written: &[(&str, Option<&Path>)], read: &[&Path]) -> Result<(), CliError> {
    let read: Vec<PathBuf> = read.iter().filter_map(|path| path.canonicalize().ok()).collect();
    let mut taken: Vec<(&str, PathBuf)> = Vec::new();
    for (option, path) in written.iter().filter_map(|(option, path)| Some((*option, (*path)?))) {
        let refuse = |why: &str| Err(CliError::bad_input(format!("{option} {}: {why}", path.display())));
        if path.is_dir() {
            return refuse("is a folder");
        }
        let Some(place) = place(path) else { return refuse("its folder is not there") };
        if read.iter().any(|input| place == *input || input.is_dir() && place.parent() == Some(input)) {
            return refuse("is read here, or lies among what is read; name another file");
        }
        if let Some((other, _)) = taken.iter().find(|(_, other)| *other == place) {
            return refuse(&format!("is the file of {other} too"));
        }
        taken.push((option, place));
    }
    Ok(())
}

/// Refuses a folder with recordings that no simulation made: what it made has its truth beside it. `description` names the file that says
/// what is simulated, with the text that it is to have; `is_own` tells recordings that would be removed.
pub(crate) fn only_own(
    folder: &Path,
    description: (&str, &str),
    is_own: impl Fn(&str) -> bool,
) -> Result<(), CliError> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    let truth = folder.join("truth");
    let names = entries.filter_map(Result::ok).filter(|entry| entry.path().is_file());
    let names: Vec<String> = names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let says_other =
        |name: &str| std::fs::read_to_string(folder.join(name)).ok().as_deref() != Some(description.1);
    let foreign = |name: &&String| match name.as_str() {
        name if name == description.0 => !truth.is_dir() && says_other(name),
        name => is_own(name) && !truth.join(name).is_file(),
    };
    match names.iter().find(foreign) {
        None => Ok(()),
        Some(name) => Err(CliError::bad_input(format!(
            "--out {}: {name} was not made by a simulation, and would be lost; name another folder",
            folder.display()
        ))),
    }
}

/// Where a file is, or would be; nothing without its folder.
fn place(path: &Path) -> Option<PathBuf> {
    if let Ok(place) = path.canonicalize() {
        return Some(place);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(folder.canonicalize().ok()?.join(path.file_name()?))
}

/// Writes a line for people to the standard error, where the standard output is for a program.
pub(crate) fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Writes why the program failed.
pub(crate) fn complain(error: &dyn std::error::Error) {
    let mut stderr = std::io::stderr().lock();
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        let cause_text = cause.to_string();
        if !text.contains(&cause_text) {
            text = format!("{text}: {cause_text}");
        }
        source = cause.source();
    }
    let _ = writeln!(stderr, "railgrip: {text}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_not_written() {
        let folder = tempfile::tempdir().expect("folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("fit")).expect("folder");
        for name in ["run.csv", "fit/a.csv"] {
            std::fs::write(at(name), "t_s").expect("write");
        }
        std::os::unix::fs::symlink(at("run.csv"), at("link.csv")).expect("link");
        let refused = |written: &[(&str, PathBuf)]| {
            let written: Vec<(&str, Option<&Path>)> =
                written.iter().map(|(option, path)| (*option, Some(path.as_path()))).collect();
            apart(&written, &[&at("run.csv"), &at("fit")]).err().map(|error| error.to_string())
        };
        assert_eq!(refused(&[("--out", at("new.csv")), ("--html", at("new.html"))]), None);
        for wrong in ["run.csv", "link.csv", "fit/../run.csv", "fit/a.csv", "fit/new.csv"] {
            let said = refused(&[("--out", at(wrong))]).expect(wrong);
            assert!(said.contains("is read here"), "{said}");
        }
        let said = refused(&[("--json", at("x")), ("--html", at("x"))]).expect("twice");
        assert!(said.contains("--html") && said.contains("is the file of --json too"), "{said}");
        assert!(refused(&[("--out", at("nowhere/x"))]).expect("no folder").contains("folder is not there"));
        assert!(refused(&[("--out", at("fit"))]).expect("a folder").contains("is a folder"));
    }
}
