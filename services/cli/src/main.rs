//! The binary `railgrip`: everything is in the library, so that the end-to-end tests can link the same code.

fn main() -> std::process::ExitCode {
    railgrip_cli::main()
}
