//! What `railgrip gap blind` is asked for.

use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};

/// Arguments of `railgrip gap blind`.
#[derive(Debug, Clone, ClapArgs)]
pub struct Args {
    /// Number of cases
    #[arg(long, default_value_t = 100)]
    pub(super) cases: usize,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Folder for cases, reports, labels and the score; an interrupted run continues there
    #[arg(long)]
    pub(super) out: PathBuf,
    /// Cases diagnosed at the same time (default: one a core)
    #[arg(long)]
    pub(super) threads: Option<usize>,
    /// Who calibrates the nominal model for the floor of the gap: the diagnosis (a second process for each case) or the plant (at once)
    #[arg(long, value_enum, default_value_t = Floor::Diagnosis)]
    pub(super) floor: Floor,
    /// Longest diagnosis of one case, s; a longer one counts as failed
    #[arg(long, default_value_t = 600)]
    pub(super) time_limit: u64,
    /// Begin no diagnosis after this many minutes, and score those that are done; the same command continues later
    #[arg(long)]
    pub(super) minutes: Option<f64>,
}

/// Who calibrates the nominal model on the twin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Floor {
    /// The diagnosis, with its whole library taken out.
    Diagnosis,
    /// The plant, with its own fit of the nuisances.
    Plant,
}
