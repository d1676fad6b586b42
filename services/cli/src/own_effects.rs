//! `--effects FILE`: effects of the user's own, for every command and for the processes that `up` starts.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::CliError;

/// The variable that names the file where the option does not.
pub(crate) const VARIABLE: &str = "RAILGRIP_EFFECTS";

static FILE: OnceLock<PathBuf> = OnceLock::new();

/// Reads the file of the option, else that of the variable, if there is one.
pub(crate) fn read(option: Option<&Path>) -> Result<(), CliError> {
    let variable = || std::env::var_os(VARIABLE).filter(|path| !path.is_empty()).map(PathBuf::from);
    let Some(path) = option.map(Path::to_owned).or_else(variable) else { return Ok(()) };
    railgrip_settings::own_effects::load(&path).map_err(CliError::bad_input)?;
    // Processes that are started may stand in another folder.
    let path = path.canonicalize().unwrap_or(path);
    let _ = FILE.set(path);
    Ok(())
}

/// What a process that is started needs to know the same effects.
pub(crate) fn environment() -> Option<(&'static str, OsString)> {
    FILE.get().map(|path| (VARIABLE, path.clone().into_os_string()))
}
