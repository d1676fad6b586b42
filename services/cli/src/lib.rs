//! The command line of railgrip: dispatches to the services and tools, and supervises `up`.

use std::process::ExitCode;

/// Entry point of the binary.
pub fn main() -> ExitCode {
    ExitCode::SUCCESS
}
