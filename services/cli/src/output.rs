//! What people and scripts read: results on the standard output, complaints on the standard error.

use std::io::{ErrorKind, Write};
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
