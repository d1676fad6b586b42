//! The config file while it is edited: checked as at a start, replaced as a whole, with comments that say who and why.

use railgrip_settings::{Overrides, SettingsError, TrainSettings};
use std::path::Path;
use toml_edit::DocumentMut;

/// Why the file was not changed.
#[derive(Debug, thiserror::Error)]
pub enum ChangeError {
    /// There is no such setting.
    #[error("there is no setting `{0}` below [indicators]; GET /api/v1/settings lists them")]
    Unknown(String),
    /// There is no such receiver.
    #[error("there is no [[receiver]] `{0}`; GET /api/v1/settings/receivers lists them")]
    NoReceiver(String),
    /// The file that would come of it is refused.
    #[error("{0}")]
    Refused(SettingsError),
    /// The file is not written as TOML tables that can be edited, or the change makes no sense there.
    #[error("{0}")]
    Form(String),
    /// The file cannot be read or written.
    #[error("{0}")]
    Disk(#[from] std::io::Error),
}

/// Beginning of the comments that changes of thresholds leave.
pub(crate) const CHANGED: &str = "changed from ";
/// … of those about receivers.
pub(super) const RECEIVER: &str = "receiver ";

/// Reads the file, has `edit` change its text, checks what comes of it as a start would, and replaces the file.
///
/// # Errors
/// What `edit` or the check refuses, or a file that cannot be read or written. The file is then as before.
pub(super) fn rewrite(
    file: &Path,
    edit: impl FnOnce(&str) -> Result<String, ChangeError>,
) -> Result<(), ChangeError> {
    let edited = edit(&std::fs::read_to_string(file)?)?;
    TrainSettings::parse(file, &edited, &Overrides::default()).map_err(ChangeError::Refused)?;
    write_whole(file, &edited)?;
    Ok(())
}

/// The text as a document that keeps its comments.
pub(super) fn document(text: &str) -> Result<DocumentMut, ChangeError> {
    text.parse().map_err(|error| ChangeError::Form(format!("{error}")))
}

/// `note` as the comment above a key or a table, in the place of the one that the change before this one left: the audit log
/// keeps them all.
pub(super) fn noted(before: &str, beginning: &str, note: &str) -> String {
    let older = |line: &&str| {
        line.trim_start().strip_prefix('#').is_some_and(|words| words.trim_start().starts_with(beginning))
    };
    let others: String = before.split_inclusive('\n').filter(|line| !older(line)).collect();
    format!("{others}# {note}\n")
}

/// Writes beside the file and renames, so that it is whole at any time, also after a power cut.
fn write_whole(file: &Path, text: &str) -> std::io::Result<()> {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    let beside = file.with_file_name(name);
    let write = || {
        let mut new = std::fs::File::create(&beside)?;
        std::io::Write::write_all(&mut new, text.as_bytes())?;
        new.set_permissions(std::fs::metadata(file)?.permissions())?;
        new.sync_all()?;
        std::fs::rename(&beside, file)
    };
    write().inspect_err(|_| {
        let _ = std::fs::remove_file(&beside);
    })
}
