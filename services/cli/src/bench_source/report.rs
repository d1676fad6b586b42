//! What became of the samples of each source.

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::Value;

use crate::CliError;
use crate::bench_up::{self, Up};
use crate::output::say;

/// Names that say once for each sample that it did not become an estimate. The others of a source say why, and count lines,
/// telegrams or frames.
const OF_SAMPLES: [&str; 2] = ["skipped", "withheld"];
/// The same of estimators.
const OF_ESTIMATORS: [&str; 3] = ["missed", "rejected", "late"];
/// Names that do not speak of losses.
const NO_LOSS: [&str; 2] = ["arrived", "samples"];

/// What was measured.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Report {
    pub wagons: usize,
    pub samples_a_second_and_wagon: u32,
    /// Processor time of the same train whose samples come from this process, without an ingest, % of one core.
    pub reference_cpu_percent: f64,
    pub lines: Vec<Line>,
}

/// One source.
#[derive(Debug, Clone, serde::Serialize)]
pub(crate) struct Line {
    source: &'static str,
    /// Why it was not measured.
    skipped: Option<String>,
    sent: u64,
    received: u64,
    /// Samples that were sent and that no estimator has received.
    lost: u64,
    /// Names under which samples that did not arrive were counted, and how many.
    counted: BTreeMap<String, u64>,
    /// Names that say why, not by samples.
    why: BTreeMap<String, u64>,
    /// Lost, and counted under no name; negative where more were counted than were lost.
    uncounted: i64,
    /// How often ingest was killed.
    kills: u32,
    /// Processor time of the train, % of one core; for the reference see the report.
    pub cpu_percent: f64,
    ingest_cpu_percent: f64,
}

/// The counts of a train.
pub(crate) struct Ledger {
    received: u64,
    counted: BTreeMap<String, u64>,
    why: BTreeMap<String, u64>,
}

impl Ledger {
    /// Reads the counts once they stand still.
    pub fn settled(up: &Up, pause: Duration) -> Result<Self, CliError> {
        let mut before = up.json("/api/v1/train")?;
        loop {
            std::thread::sleep(pause);
            let now = up.json("/api/v1/train")?;
            let moved = ["received", "missed"].iter().any(|name| {
                bench_up::sum(&now, "estimator", name) != bench_up::sum(&before, "estimator", name)
            });
            if !moved {
                return Ok(Self::of(&now));
            }
            before = now;
        }
    }

    fn of(train: &Value) -> Self {
        let (mut counted, mut why) = (BTreeMap::new(), BTreeMap::new());
        for source in train["sources"].as_array().map(Vec::as_slice).unwrap_or_default() {
            for (name, count) in source["counts"].as_object().into_iter().flatten() {
                let count = count.as_u64().unwrap_or(0);
                if count == 0 || NO_LOSS.contains(&name.as_str()) {
                    continue;
                }
                let book = if OF_SAMPLES.contains(&name.as_str()) { &mut counted } else { &mut why };
                *book.entry(name.clone()).or_insert(0) += count;
            }
        }
        for name in OF_ESTIMATORS {
            let count = bench_up::sum(train, "estimator", name);
            if count > 0 {
                counted.insert(format!("{name} by estimators"), count);
            }
        }
        Self { received: bench_up::sum(train, "estimator", "received"), counted, why }
    }
}

impl Line {
    pub fn new(
        source: &'static str,
        sent: u64,
        kills: u32,
        ledger: &Ledger,
        cpu_percent: f64,
        ingest_cpu_percent: f64,
    ) -> Self {
        let lost = sent.saturating_sub(ledger.received);
        let counted: u64 = ledger.counted.values().sum();
        Self {
            source,
            skipped: None,
            sent,
            received: ledger.received,
            lost,
            counted: ledger.counted.clone(),
            why: ledger.why.clone(),
            uncounted: lost.cast_signed() - counted.cast_signed(),
            kills,
            cpu_percent,
            ingest_cpu_percent,
        }
    }

    /// A source that cannot be measured here.
    pub fn skipped(source: &'static str, why: &str) -> Self {
        let nothing = Ledger { received: 0, counted: BTreeMap::new(), why: BTreeMap::new() };
        Self { skipped: Some(why.to_owned()), ..Self::new(source, 0, 0, &nothing, 0.0, 0.0) }
    }
}

/// The report for people.
pub(crate) fn show(report: &Report) {
    say(&format!(
        "{} wagons at {} Hz; the same train without an ingest: {:.1} % of one core",
        report.wagons, report.samples_a_second_and_wagon, report.reference_cpu_percent
    ));
    say("source         sent   received     lost  uncounted  kills   CPU, %   of it ingest   counted as");
    for line in &report.lines {
        if let Some(why) = &line.skipped {
            say(&format!("{:<10} not measured: {why}", line.source));
            continue;
        }
        let names = |book: &BTreeMap<String, u64>| {
            book.iter().map(|(name, count)| format!("{name} {count}")).collect::<Vec<_>>().join(", ")
        };
        let mut words = names(&line.counted);
        if !line.why.is_empty() {
            words.push_str(&format!(" ({})", names(&line.why)));
        }
        say(&format!(
            "{:<10} {:>8} {:>10} {:>8} {:>10} {:>6} {:>8.1} {:>14.1}   {words}",
            line.source,
            line.sent,
            line.received,
            line.lost,
            line.uncounted,
            line.kills,
            line.cpu_percent,
            line.ingest_cpu_percent
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_missing_is_held_against_what_was_counted() {
        let train = json!({
            "processes": [
                {"process": "ingest", "received": 99, "missed": 0, "rejected": 7, "late": 1},
                {"process": "estimator", "received": 40, "missed": 2, "rejected": 0, "late": 0},
                {"process": "estimator", "received": 30, "missed": 1, "rejected": 0, "late": 0},
            ],
            "sources": [
                {"wagon": null, "counts": {"arrived": 90, "overrun": 4, "lost": 0}},
                {"wagon": 1, "counts": {"samples": 40, "skipped": 5}},
                {"wagon": 2, "counts": {"samples": 30, "skipped": 2, "late": 3}},
            ],
        });
        let ledger = Ledger::of(&train);
        let line = Line::new("tcp", 82, 1, &ledger, 1.0, 1.0);
        assert_eq!((line.received, line.lost, line.uncounted), (70, 12, 2));
        assert_eq!(line.counted.get("skipped"), Some(&7));
        assert_eq!(line.counted.get("missed by estimators"), Some(&3));
        assert_eq!(line.why.keys().collect::<Vec<_>>(), ["late", "overrun"]);
        assert_eq!(Line::new("tcp", 80, 1, &ledger, 1.0, 1.0).uncounted, 0);
    }
}
