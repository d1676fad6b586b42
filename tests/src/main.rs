//! The same program as `railgrip`, built inside the test package so that Cargo always hands the tests a fresh binary.

fn main() -> std::process::ExitCode {
    railgrip_cli::main()
}
