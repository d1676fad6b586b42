//! What the commands of `railgrip gap` share.

use std::io::IsTerminal;
use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use railgrip_diagnosis::data::case::Case;
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::wagon;
use railgrip_vehicle::effects;
use railgrip_words::Language;

use crate::CliError;
use crate::output::note;

/// How often it is said, where nobody looks on, how far a diagnosis is.
const TOLD_EVERY: Duration = Duration::from_secs(60);

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

    /// Does the work on as many threads as are asked for, and says how far it is: on a terminal all the time, elsewhere now and then.
    pub(crate) fn run<T: Send>(
        &self,
        work: impl FnOnce(&(dyn Fn(&'static str) + Sync)) -> T + Send,
    ) -> Result<T, CliError> {
        let bar = spinner();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, usize::from))
            .build()
            .map_err(CliError::failed)?;
        let part = Mutex::new("");
        let step = |what: &'static str| {
            *part.lock().unwrap_or_else(PoisonError::into_inner) = what;
            bar.set_message(what);
        };
        let (working, ended) = mpsc::channel::<()>();
        let answer = thread::scope(|scope| {
            if bar.is_hidden() {
                scope.spawn(|| tell(&bar, &part, ended));
            }
            let answer = pool.install(|| work(&step));
            drop(working);
            answer
        });
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

/// Says once in a while which part of the work is being done, until it has `ended`.
fn tell(bar: &ProgressBar, part: &Mutex<&'static str>, ended: mpsc::Receiver<()>) {
    while ended.recv_timeout(TOLD_EVERY) == Err(RecvTimeoutError::Timeout) {
        let part = *part.lock().unwrap_or_else(PoisonError::into_inner);
        note(&format!("diagnosing for {:.0} min: {part}", bar.elapsed().as_secs_f64() / 60.0));
    }
}

/// What turns on a terminal while something is being done, nothing elsewhere. How many parts are to come nobody knows before.
fn spinner() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed:>4} {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}
