//! What people and scripts read: results on the standard output, complaints on the standard error.

use std::io::Write;

/// Writes a line to the standard output. A reader that went away (`| head`) is no error.
pub(crate) fn say(line: &str) {
    let _ = writeln!(std::io::stdout().lock(), "{line}");
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
