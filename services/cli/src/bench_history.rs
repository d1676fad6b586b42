//! `railgrip bench --history`: what remembering costs on this machine: bytes written to the medium a day, the size of what
//! is kept, and how long a month at one hour takes to answer.

use std::path::Path;
use std::time::{Duration, Instant};

use railgrip_health::history::query::Span;
use railgrip_health::history::{History, columns};
use railgrip_history::Store;
use railgrip_indicators::indicator::{
    ADHESION_AVAILABLE, ADHESION_UTILISED, ASYMMETRY, BRAKE_FRICTION, BRAKE_FRICTION_STANDARD, DRAGGING,
    FILTER, MODEL, RESPONSE, SENSORS, SLIDES, WSP_SHARE,
};
use railgrip_messages::{Grade, Health, Indicator, Stamp};

use crate::CliError;
use crate::output::say;

/// Wagons of the train whose writing is measured.
const WAGONS: u32 = 8;
/// So much of a train's life is written second by second, s.
const WRITTEN_S: i64 = 1800;
/// Times between two writes, s; the one in the middle is the default of `[history] flush_s`.
const FLUSHES_S: [i64; 3] = [10, 30, 60];
/// Indicators are recorded so often in a second.
const RECORDS_A_SECOND: i64 = 5;
const DAY_S: i64 = 86_400;
/// Days of the stored month, one wagon, a record a minute.
const DAYS: i64 = 30;
const QUERIES: usize = 40;
/// 2026-03-01.
const START_S: i64 = 1_772_323_200;

/// What was measured.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Report {
    wagons: u32,
    columns: usize,
    written_s: i64,
    written: Vec<Written>,
    month_p50_ms: f64,
    month_worst_ms: f64,
    month_answer_bytes: usize,
}

/// What writing at one interval costs.
#[derive(Debug, serde::Serialize)]
struct Written {
    flush_s: i64,
    /// Bytes that the kernel counts as written to the medium for this process.
    written_bytes: Option<u64>,
    megabytes_a_day: Option<f64>,
    blocks_megabytes_a_day: f64,
    kept_bytes: u64,
}

/// The report for people.
pub(crate) fn show(report: &Report) {
    say(&format!(
        "{} wagons, {} columns each, {RECORDS_A_SECOND} records a second, {} s of life",
        report.wagons, report.columns, report.written_s
    ));
    say("a write every   to the medium   of it blocks of indicators   size of the database");
    for written in &report.written {
        let medium =
            written.megabytes_a_day.map_or("not counted".to_owned(), |mb| format!("{mb:.0} MB a day"));
        say(&format!(
            "{:>11} s {medium:>15} {:>19.0} MB a day {:>19.2} MB",
            written.flush_s,
            written.blocks_megabytes_a_day,
            written.kept_bytes as f64 * 1e-6
        ));
    }
    say(&format!(
        "a month at 1 h, one wagon, all indicators as JSON ({} kB): {:.1} ms, at worst {:.1} ms",
        report.month_answer_bytes / 1000,
        report.month_p50_ms,
        report.month_worst_ms
    ));
}

/// Writes a while of a train's life and a month of one wagon, and reads the month.
pub(crate) fn run() -> Result<Report, CliError> {
    // Not under /tmp, which may be in memory: the medium is what is measured.
    let folder = std::env::current_dir()
        .map_err(CliError::failed)?
        .join(format!("bench-history-{}", std::process::id()));
    std::fs::create_dir(&folder).map_err(CliError::failed)?;
    let result = measure(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    result
}

fn measure(folder: &Path) -> Result<Report, CliError> {
    let all = columns::all(2);
    let names = columns::stored(&all);
    let names: Vec<_> = names.iter().map(|(name, keep)| (name.as_str(), *keep)).collect();
    let written = FLUSHES_S.map(|flush_s| write(folder, &all, &names, flush_s));
    let (mut took_ms, month_answer_bytes) = month(folder, &all, &names)?;
    took_ms.sort_by(f64::total_cmp);
    Ok(Report {
        wagons: WAGONS,
        columns: names.len(),
        written_s: WRITTEN_S,
        written: written.into_iter().collect::<Result<_, _>>()?,
        month_p50_ms: took_ms[took_ms.len() / 2],
        month_worst_ms: took_ms[took_ms.len() - 1],
        month_answer_bytes,
    })
}

/// Writes a while of a train's life.
fn write(
    folder: &Path,
    all: &[columns::Column],
    names: &[(&str, railgrip_history::Keep)],
    flush_s: i64,
) -> Result<Written, CliError> {
    let mut store =
        Store::open(&folder.join(format!("train-{flush_s}.db")), names).map_err(CliError::failed)?;
    let (before, mut blocks) = (written(), 0);
    for second in 0..WRITTEN_S {
        for part in 0..RECORDS_A_SECOND {
            let at_s = second as f64 + part as f64 / RECORDS_A_SECOND as f64;
            for wagon in 1..=WAGONS {
                let values = columns::values(all, &health(wagon, at_s));
                store.push(wagon, START_S + second, &values).map_err(CliError::failed)?;
            }
        }
        if second % flush_s == flush_s - 1 {
            blocks += store.flush(false).map_err(CliError::failed)?.bytes;
        }
    }
    let kept_bytes = store.size_bytes().map_err(CliError::failed)?;
    drop(store);
    let written_bytes = before.zip(written()).map(|(before, after)| after - before);
    let a_day = |bytes: u64| bytes as f64 * 1e-6 * DAY_S as f64 / WRITTEN_S as f64;
    Ok(Written {
        flush_s,
        written_bytes,
        megabytes_a_day: written_bytes.map(a_day),
        blocks_megabytes_a_day: a_day(blocks),
        kept_bytes,
    })
}

/// Times of the queries, ms, and the length of an answer.
fn month(
    folder: &Path,
    all: &[columns::Column],
    names: &[(&str, railgrip_history::Keep)],
) -> Result<(Vec<f64>, usize), CliError> {
    let database = folder.join("month.db");
    let mut store = Store::open(&database, names).map_err(CliError::failed)?;
    for minute in 0..DAYS * 1440 {
        let values = columns::values(all, &health(1, minute as f64 * 60.0));
        store.push(1, START_S + minute * 60, &values).map_err(CliError::failed)?;
        if minute % 720 == 719 {
            store.flush(false).map_err(CliError::failed)?;
        }
    }
    store.flush(true).map_err(CliError::failed)?;
    let history = History::new(database, 2);
    let span = Span { from_s: START_S, to_s: START_S + DAYS * DAY_S, step_s: 3600 };
    let (mut took_ms, mut length) = (Vec::new(), 0);
    for _ in 0..QUERIES {
        let asked = Instant::now();
        let view = history.view(1, span, None).map_err(CliError::failed)?;
        length = serde_json::to_vec(&view).map_err(CliError::failed)?.len();
        took_ms.push(asked.elapsed().as_secs_f64() * 1e3);
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok((took_ms, length))
}

/// Bytes that this process has had written to the medium so far.
fn written() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/io").ok()?;
    text.lines().find_map(|line| line.strip_prefix("write_bytes:")?.trim().parse().ok())
}

/// Figures that move and rustle as those of a wagon in service do.
fn health(wagon: u32, at_s: f64) -> Health {
    let noise = |seed: f64| ((at_s * 12.9898 + seed * 78.233).sin() * 43_758.547).fract();
    let slow = |seed: f64| (at_s / (600.0 + 37.0 * seed)).sin();
    let judged = |seed: f64, value: f64| {
        let value = value * (1.0 + 0.02 * slow(seed) + 0.001 * noise(seed));
        Indicator {
            value,
            low: value * 0.97,
            high: value * 1.03,
            grade: Grade::Ok.code(),
            known: 1,
            reason: "".into(),
        }
    };
    let unix_ns = START_S * 1_000_000_000 + (at_s * 1e9) as i64;
    let mut health = Health {
        wagon,
        wheelsets: 2,
        acquired: Stamp { unix_ns, monotonic_ns: (at_s * 1e9) as u64 },
        v_m_s: 25.0 + 8.0 * slow(f64::from(wagon)) + 0.05 * noise(1.0),
        mu_w: -0.05 + 0.04 * slow(2.0) + 0.001 * noise(2.0),
        mu_w_sigma: 0.002 + 0.0001 * noise(3.0),
        mu_b_mean: 0.35 + 0.002 * noise(4.0),
        mu_b_mean_sigma: 0.004,
        position_m: at_s * 25.0,
        pressing_force_n: 20_000.0 + 5000.0 * slow(3.0),
        condition_probability: [0.6 + 0.2 * slow(4.0), 0.3 - 0.2 * slow(4.0), 0.08, 0.02],
        ..Health::default()
    };
    for (spec, indicator) in [
        (&BRAKE_FRICTION, judged(5.0, 0.35)),
        (&ASYMMETRY, judged(6.0, 0.02)),
        (&ADHESION_UTILISED, judged(7.0, 0.08)),
        (&ADHESION_AVAILABLE, judged(8.0, 0.2)),
        (&SLIDES, judged(9.0, 3.0)),
        (&WSP_SHARE, judged(10.0, 0.1)),
        (&SENSORS, judged(11.0, 0.001)),
        (&FILTER, judged(12.0, 1.0)),
        (&BRAKE_FRICTION_STANDARD, judged(13.0, 0.34)),
        (&RESPONSE, judged(14.0, 2.1)),
        (&DRAGGING, judged(15.0, 40.0)),
        (&MODEL, judged(16.0, 1.0)),
    ] {
        spec.put(&mut health, indicator);
    }
    for index in 0..2 {
        let seed = 20.0 + index as f64;
        BRAKE_FRICTION.put_wheelset(&mut health, index, judged(seed, 0.35));
        ADHESION_AVAILABLE.put_wheelset(&mut health, index, judged(seed + 2.0, 0.2));
        SLIDES.put_wheelset(&mut health, index, judged(seed + 6.0, 2.0));
        health.wheelset[index].slip = -0.004 * (1.0 + noise(seed + 4.0));
    }
    health
}
