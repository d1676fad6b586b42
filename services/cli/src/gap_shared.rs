//! What the commands of `railgrip gap` share.

use std::io::IsTerminal;
use std::path::Path;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use railgrip_diagnosis::data::case::Case;
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::wagon;
use railgrip_vehicle::effects;
use railgrip_words::Language;

use crate::CliError;

/// How the library is searched.
#[derive(Debug, clap::Args)]
pub(crate) struct SearchArgs {
    /// Leave a candidate out of the library; may be repeated
    #[arg(long, value_name = "ID")]
    pub(crate) without: Vec<String>,
    /// Seed of the bootstraps
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Threads (default: one a core); the answer does not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl SearchArgs {
    /// The case of a wagon in this folder.
    pub(crate) fn read(&self, folder: &Path) -> Result<Case, CliError> {
        check_ids(&self.without)?;
        let vehicle = railgrip_settings::vehicle::load(&folder.join("vehicle.toml"));
        load::load(folder, vehicle.map_err(CliError::bad_input)?).map_err(CliError::bad_input)
    }

    /// What the diagnosis of a case in this folder is told beside it.
    pub(crate) fn options(&self, folder: &Path, command: String) -> wagon::Options {
        let (case, without) = (name_of(folder), self.without.clone());
        wagon::Options { case, without, seed: self.seed, version: version(), command }
    }

    /// Does the work on as many threads as are asked for, with a bar on a terminal that each step moves on.
    pub(crate) fn run<T: Send>(
        &self,
        work: impl FnOnce(&(dyn Fn(&'static str) + Sync)) -> T + Send,
    ) -> Result<T, CliError> {
        let bar = progress_bar();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, usize::from))
            .build()
            .map_err(CliError::failed)?;
        let step = |what: &'static str| {
            bar.set_message(what);
            bar.inc(1);
        };
        let answer = pool.install(|| work(&step));
        bar.finish_and_clear();
        Ok(answer)
    }
}

/// In which language people read.
#[derive(Debug, clap::Args)]
pub(crate) struct LanguageArgs {
    /// Language of the page and of what is printed: en or de; files for programs stay English [default: that of the locale]
    #[arg(long, value_name = "LANGUAGE", value_parser = language)]
    language: Option<Language>,
}

impl LanguageArgs {
    /// The one that was asked for, else that of the locale.
    pub(crate) fn chosen(&self) -> Language {
        self.language.unwrap_or_else(|| Language::of_locale(|name| std::env::var(name).ok()))
    }
}

fn language(tag: &str) -> Result<Language, String> {
    let known = || Language::ALL.map(|(language, name)| format!("{} ({name})", language.tag())).join(", ");
    Language::parse(tag).ok_or_else(|| format!("known are {}", known()))
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), CliError> {
    std::fs::write(path, text).map_err(|error| CliError::failed(format!("{}: {error}", path.display())))
}

fn check_ids(ids: &[String]) -> Result<(), CliError> {
    let all = effects::all();
    let known = |id: &&String| all.iter().all(|(spec, _)| spec.id != id.as_str());
    match ids.iter().find(known) {
        None => Ok(()),
        Some(id) => {
            let all: Vec<&str> = all.iter().map(|(spec, _)| spec.id).collect();
            Err(CliError::bad_input(format!(
                "--without {id}: not in the catalogue, known are {}",
                all.join(", ")
            )))
        }
    }
}

pub(crate) fn name_of(folder: &Path) -> String {
    let full = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    full.file_name().map_or_else(|| "case".to_owned(), |name| name.to_string_lossy().into_owned())
}

pub(crate) fn version() -> String {
    format!("railgrip {}", env!("CARGO_PKG_VERSION"))
}

/// A bar on a terminal, nothing elsewhere.
fn progress_bar() -> ProgressBar {
    // One round over the library, a second one when something was found, and the closing steps.
    let bar = ProgressBar::new(2 * effects::all().len() as u64 + 3);
    if !std::io::stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    if let Ok(style) = ProgressStyle::with_template("{elapsed:>4} [{bar:40}] {pos}/{len} {msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}
