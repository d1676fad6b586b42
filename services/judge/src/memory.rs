//! What the judge leaves on disk so that its successor goes on where it stopped.
//!
//! It belongs to this consist: the same vehicles in the same order, the same end first, the same vehicle files. Where a wagon has
//! no vehicle number it holds within one start of the train only, because nobody knows whether the next one has the same wagon there.

use railgrip_bus::{KeptError, keep, kept, now};
use railgrip_causes::{TrainWatch, WagonFile};
use railgrip_settings::TrainSettings;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// First line of the file: its form. Changes whenever the layout of the state does.
const FORM: &str = "railgrip judge 6";
/// Kept at the latest so long after the last time, while nothing is found.
const LONGEST: Duration = Duration::from_secs(60);
/// Kept no sooner than that, whatever happens.
const SHORTEST: Duration = Duration::from_secs(5);

/// Written with a borrowed watch, read with one of its own.
#[derive(Serialize, Deserialize)]
struct State<W> {
    consist: Vec<String>,
    session: String,
    unix_ns: i64,
    watch: W,
}

/// The file, whose it is, and when it was last written.
pub(crate) struct Memory {
    file: PathBuf,
    consist: Vec<String>,
    session: String,
    kept: Instant,
    /// Applications and alerts, raised and standing, that the file knows.
    known: (u32, usize, usize),
    failing: bool,
}

impl Memory {
    /// Nothing is kept yet for this train.
    pub(crate) fn of(settings: &TrainSettings) -> Self {
        let name = |wagon: &railgrip_settings::WagonSettings| {
            let key = wagon.vehicle_number.as_ref().map_or("", |number| number.key());
            format!("{key}{}", if wagon.turned { " turned" } else { "" })
        };
        Self {
            file: settings.instance.judgement_file(),
            consist: settings.wagons.iter().map(name).collect(),
            session: settings.instance.session(),
            kept: Instant::now(),
            known: (0, 0, 0),
            failing: false,
        }
    }

    /// The watch of a predecessor, and its age in s; `None` if there is none that can be used.
    pub(crate) fn restore(&mut self, files: &[WagonFile]) -> Option<(TrainWatch, f64)> {
        if let Some(folder) = self.file.parent()
            && let Err(error) = std::fs::create_dir_all(folder)
        {
            tracing::warn!(folder = %folder.display(), %error, "nothing can be kept: the folder cannot be made");
        }
        match self.read(files) {
            Ok(found) => {
                let (watch, age_s) = found?;
                self.known = known(&watch);
                tracing::info!(age_s, brakings = watch.brakings(), "judge goes on from what was learnt");
                Some((watch, age_s))
            }
            Err(error) => {
                tracing::warn!(%error, "what was learnt is refused; the judge starts fresh");
                None
            }
        }
    }

    fn read(&self, files: &[WagonFile]) -> Result<Option<(TrainWatch, f64)>, KeptError> {
        let Some(bytes) = kept(&self.file, FORM)? else { return Ok(None) };
        let problem = |problem| KeptError::form(&self.file, problem);
        let state: State<TrainWatch> =
            postcard::from_bytes(&bytes).map_err(|_| problem("not a snapshot of this version"))?;
        if state.consist != self.consist {
            return Err(problem("of another consist"));
        }
        let anonymous = |name: &String| name.is_empty() || name.starts_with(' ');
        if state.session != self.session && self.consist.iter().any(anonymous) {
            return Err(problem("of an earlier start; without vehicle numbers it may be of other wagons"));
        }
        let watch = state.watch.go_on(files).ok_or_else(|| problem("of other vehicle files"))?;
        Ok(Some((watch, (now().unix_ns - state.unix_ns) as f64 * 1e-9)))
    }

    /// Keeps what is known if it is time to.
    pub(crate) fn keep_in_time(&mut self, watch: &TrainWatch) {
        let since = self.kept.elapsed();
        if since >= LONGEST || (since >= SHORTEST && known(watch) != self.known) {
            self.keep(watch);
        }
    }

    /// Keeps what is known. A disk that refuses is told once; the judge goes on.
    pub(crate) fn keep(&mut self, watch: &TrainWatch) {
        (self.kept, self.known) = (Instant::now(), known(watch));
        match self.write(&self.file, watch) {
            Ok(()) => self.failing = false,
            Err(error) => {
                if !self.failing {
                    tracing::warn!(%error, "nothing is kept: a restart would start fresh");
                }
                self.failing = true;
            }
        }
    }

    fn write(&self, file: &Path, watch: &TrainWatch) -> Result<(), KeptError> {
        let (consist, session, unix_ns) = (self.consist.clone(), self.session.clone(), now().unix_ns);
        let state = State { consist, session, unix_ns, watch };
        let bytes = postcard::to_stdvec(&state)
            .map_err(|_| KeptError::form(file, "the state cannot be put into bytes"))?;
        keep(file, FORM, &bytes)
    }
}

fn known(watch: &TrainWatch) -> (u32, usize, usize) {
    let standing = watch.alerts().iter().filter(|alert| alert.cleared_t_s.is_none());
    (watch.brakings(), watch.alerts().len(), standing.count())
}
