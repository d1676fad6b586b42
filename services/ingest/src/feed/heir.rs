//! What a live source leaves to the ingest that comes after this one, however it ends: where the time of each wagon stood, so that
//! what is lost between the two is counted; how the clocks were tied, so that what waited meanwhile does not look new; and all counts.

use super::steps::Steps;
use super::wagon::Wagon;
use super::{SourceClock, Tally};
use railgrip_bus::Ledger;
use railgrip_messages::MAX_SOURCE_COUNTS;
use railgrip_settings::TrainSettings;
use std::path::PathBuf;

/// Figures of one wagon: its counts, its steps, its clock.
const WAGON_WORDS: usize = MAX_SOURCE_COUNTS + 2 + SourceClock::WORDS;

/// Keeps it in a file of the instance.
pub(super) struct Heir {
    file: PathBuf,
    /// What the figures are about: this start of the train, and the vehicles in it.
    about: String,
    ledger: Option<Ledger>,
    failing: bool,
    figures: Vec<u64>,
}

impl Heir {
    /// For the source of that name of a train; nothing is opened yet.
    pub fn new(settings: &TrainSettings, source: &str) -> Self {
        let numbers = settings.wagons.iter().map(|wagon| wagon.vehicle_number.as_ref());
        let vehicles: Vec<_> = numbers.map(|number| number.map_or("", |number| number.key())).collect();
        Self {
            file: settings.instance.dir.join("source.ledger"),
            about: format!("1 {} {source} {vehicles:?}", settings.instance.session()),
            ledger: None,
            failing: false,
            figures: Vec::new(),
        }
    }

    /// Takes over what a predecessor has left.
    pub fn inherit(&mut self, whole: &Tally, wagons: &mut [Wagon]) {
        let words = MAX_SOURCE_COUNTS + wagons.len() * WAGON_WORDS;
        let (ledger, left) = match Ledger::open(&self.file, &self.about, words) {
            Ok(opened) => opened,
            Err(error) => {
                tracing::warn!(file = %self.file.display(), %error, "a successor will not know what was lost before it");
                return;
            }
        };
        self.ledger = Some(ledger);
        let Some(left) = left else { return };
        whole.go_on_from(&left.latest[..MAX_SOURCE_COUNTS]);
        let of_wagons = |figures: &[u64]| -> Vec<Vec<u64>> {
            figures[MAX_SOURCE_COUNTS..].chunks_exact(WAGON_WORDS).map(<[u64]>::to_vec).collect()
        };
        let (latest, before) = (of_wagons(&left.latest), left.before.as_deref().map(of_wagons));
        for (place, wagon) in wagons.iter_mut().enumerate() {
            // What was about to be sent, and was not, is as if it had never come in.
            let known = if left.done > place as u64 {
                latest.get(place)
            } else {
                before.as_ref().and_then(|before| before.get(place))
            };
            let Some((counts, rest)) = known.map(|known| known.split_at(MAX_SOURCE_COUNTS)) else { continue };
            let (steps, clock) = rest.split_at(2);
            wagon.tally.go_on_from(counts);
            wagon.steps = Steps::of([steps[0], steps[1]].map(f64::from_bits));
            wagon.clock = SourceClock::of(clock);
        }
    }

    /// Writes down how things will stand once what is waiting has been sent; trouble is told once, until it works again.
    pub fn leave(&mut self, whole: &Tally, wagons: &[Wagon]) {
        let Some(ledger) = &mut self.ledger else { return };
        self.figures.clear();
        self.figures.extend(whole.counts());
        for wagon in wagons {
            self.figures.extend(wagon.tally.counts());
            self.figures.extend(wagon.steps.known().map(f64::to_bits));
            self.figures.extend(wagon.clock.words());
        }
        let result = ledger.write(&self.figures);
        if let (Err(error), false) = (&result, self.failing) {
            tracing::warn!(file = %self.file.display(), %error, "a successor will not know what was lost before it");
        }
        self.failing = result.is_err();
    }

    /// So many wagons have been sent since.
    pub fn sent(&mut self, wagons: usize) {
        if let Some(ledger) = self.ledger.as_mut().filter(|_| !self.failing) {
            self.failing = ledger.mark(wagons as u64).is_err();
        }
    }
}
