//! What the commands of `railgrip gap` share.

use std::io::IsTerminal;
use std::path::Path;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use railgrip_vehicle::effects;

use crate::CliError;

pub(crate) fn write(path: &Path, text: &str) -> Result<(), CliError> {
    std::fs::write(path, text).map_err(|error| CliError::failed(format!("{}: {error}", path.display())))
}

pub(crate) fn check_ids(ids: &[String]) -> Result<(), CliError> {
    let all = effects::all();
    let known = |id: &&String| all.iter().all(|(spec, _)| spec.id != id.as_str());
    match ids.iter().find(known) {
        None => Ok(()),
        Some(id) => {
            let all: Vec<&str> = all.iter().map(|(spec, _)| spec.id).collect();
            Err(CliError::bad_input(format!(
                "--without {id}: not in the catalogue, known are {}",
                all.join(", ")
            )))
        }
    }
}

pub(crate) fn name_of(folder: &Path) -> String {
    let full = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    full.file_name().map_or_else(|| "case".to_owned(), |name| name.to_string_lossy().into_owned())
}

pub(crate) fn version() -> String {
    format!("railgrip {}", env!("CARGO_PKG_VERSION"))
}

/// A bar on a terminal, nothing elsewhere.
pub(crate) fn progress_bar() -> ProgressBar {
    // One round over the library, a second one when something was found, and the closing steps.
    let bar = ProgressBar::new(2 * effects::all().len() as u64 + 3);
    if !std::io::stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    if let Ok(style) = ProgressStyle::with_template("{elapsed:>4} [{bar:40}] {pos}/{len} {msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}
