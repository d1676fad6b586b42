//! `railgrip completions SHELL`.

use clap_complete::Shell;

/// Print completions for a shell.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The shell, for example bash: railgrip completions bash > /usr/share/bash-completion/completions/railgrip
    #[arg(value_enum)]
    shell: Shell,
}

pub(crate) fn run(args: &Args, command: &mut clap::Command) {
    clap_complete::generate(args.shell, command, "railgrip", &mut std::io::stdout());
}
