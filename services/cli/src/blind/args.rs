//! What `railgrip gap blind` is asked for.

use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};
use railgrip_truth_plant::family::{FormSet, Forms};

/// Arguments of `railgrip gap blind`.
#[derive(Debug, Clone, ClapArgs)]
pub struct Args {
    /// Number of cases
    #[arg(long, default_value_t = 100)]
    pub(super) cases: usize,
    /// Seed of the cases. Sealed cases follow from seed and salt together, so that nobody can make them again before the
    /// salt is opened; with --open-labels they follow from the seed alone
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Salt of an earlier run, to make its cases again [default: fresh from the operating system]
    #[arg(long, value_name = "HEX")]
    pub(super) salt: Option<String>,
    /// Functional forms of plants and effects: calibrate on one set, report on another
    #[arg(long, value_enum, default_value_t = FormsArg::All)]
    pub(super) forms: FormsArg,
    /// Make the cases and diagnose none
    #[arg(long)]
    pub(super) make_only: bool,
    /// Write the labels to this file at once, unsealed (with --make-only, for calibration)
    #[arg(long, value_name = "FILE", requires = "make_only")]
    pub(super) open_labels: Option<PathBuf>,
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
    /// Of so many cases that are left in doubt let the vehicle make the run that `gap plan` designs, and any other beside it, and
    /// see which of them settles the doubt
    // Both conflicts are named: beside an option that conflicts with it, the parser would not ask for --make-only.
    #[arg(long, value_name = "CASES", default_value_t = 0, conflicts_with_all = ["make_only", "open_labels"])]
    pub(super) next_runs: usize,
    /// Begin no diagnosis after this many minutes, and score those that are done; the same command continues later
    #[arg(long)]
    pub(super) minutes: Option<f64>,
}

/// Sets of functional forms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum FormsArg {
    /// First forms.
    A,
    /// Second forms.
    B,
    /// Third forms.
    C,
    /// Fourth forms, for judging alone: calibrate nothing on them.
    D,
    /// Each case from any one of a, b and c.
    All,
}

impl FormsArg {
    /// The sets from which the deck draws.
    pub(super) fn forms(self) -> Forms {
        match self {
            Self::A => Forms::Only(FormSet::A),
            Self::B => Forms::Only(FormSet::B),
            Self::C => Forms::Only(FormSet::C),
            Self::D => Forms::Only(FormSet::D),
            Self::All => Forms::All,
        }
    }

    /// The word of the command line.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::B => "b",
            Self::C => "c",
            Self::D => "d",
            Self::All => "all",
        }
    }
}

/// Who calibrates the nominal model on the twin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Floor {
    /// The diagnosis, with its whole library taken out.
    Diagnosis,
    /// The plant, with its own fit of the nuisances.
    Plant,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Debug, clap::Parser)]
    struct Blind {
        #[command(flatten)]
        args: Args,
    }

    #[test]
    fn what_would_be_passed_over_is_refused() {
        let parsed = |words: &str| {
            Blind::try_parse_from(["blind", "--out", "deck"].into_iter().chain(words.split_whitespace()))
        };
        let open = "--open-labels labels.json";
        for (words, said) in [
            (open.to_owned(), "--make-only"),
            ("--next-runs 3 --make-only".to_owned(), "--next-runs"),
            (format!("{open} --next-runs 3"), "--next-runs"),
        ] {
            let error = parsed(&words).unwrap_err().to_string();
            assert!(error.contains(said), "{words}: {error}");
        }
        for words in ["", "--make-only", "--make-only --open-labels labels.json", "--next-runs 3"] {
            assert_eq!(parsed(words).unwrap().args.make_only, words.contains("--make-only"));
        }
    }
}
