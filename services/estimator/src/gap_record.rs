//! Puts the latest minutes of a wagon that the model does not explain into a folder that `railgrip gap diagnose` takes.
//!
//! A diagnosis wants regular samples without holes, and one class of rail a run. The minutes are therefore cut into
//! *stretches*: where the rail changed, where samples were lost for longer than can be bridged, and where the position jumps
//! (a train that begins its programme anew). Each stretch becomes a run; some are left for the diagnosis to predict only.

use crate::gap_watch::{GapWatch, KeptRow};
use railgrip_messages::Condition;
use railgrip_recording::{Optional, RecordingError, Row, RunWriter};
use railgrip_vehicle::VehicleParameters;
use std::path::{Path, PathBuf};

/// Shortest recording that is worth keeping, s.
const LEAST_S: f64 = 20.0;
/// Shortest stretch that becomes a run, s.
const LEAST_STRETCH_S: f64 = 8.0;
/// Longest hole that is bridged by a straight line, samples.
const BRIDGED: usize = 5;
/// Share of a single stretch that a diagnosis may fit on; it predicts the rest.
const FIT_SHARE: f64 = 0.65;
/// A rail that is taken to be another for less than this, and then the former again, was not another, s.
const WAVERS_S: f64 = 3.0;
/// Worse rail is noticed late: so much before the change counts as neither, s.
const NOTICED_LATE_S: f64 = 4.0;
/// A position that jumps by more than this is that of another place, m.
const JUMP_M: f64 = 50.0;

/// Why nothing was kept.
#[derive(Debug, thiserror::Error)]
pub enum GapRecordError {
    /// A recording cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A folder or the vehicle file cannot be written.
    #[error("{}: {source}", path.display())]
    File {
        /// Folder or file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The vehicle cannot be put into a file.
    #[error("the vehicle cannot be written: {0}")]
    Vehicle(#[from] toml::ser::Error),
}

/// Regular samples without holes on one class of rail.
#[derive(Debug, Clone)]
struct Stretch {
    rail: &'static str,
    rows: Vec<Row>,
}

/// File in a case that will be written anew once more has been seen: a diagnosis does better to wait.
pub const GROWING: &str = "growing";

/// Writes `CASE/vehicle.toml`, `CASE/fit/*.csv` and `CASE/holdout/*.csv`, anew if they exist, and [`GROWING`] if it `grows`;
/// `false` if there is too little.
///
/// # Errors
/// If something cannot be written.
pub fn write(
    case: &Path,
    watch: &GapWatch,
    vehicle: &VehicleParameters,
    grows: bool,
) -> Result<bool, GapRecordError> {
    let mut kept: Vec<KeptRow> = watch.rows().collect();
    let Some(period_s) = period_s(&kept) else { return Ok(false) };
    steady(&mut kept, period_s);
    let rows_of = |seconds: f64| (seconds / period_s) as usize;
    let mut stretches = stretches(&kept, period_s, watch.wheelsets());
    stretches.retain(|stretch| stretch.rows.len() >= rows_of(LEAST_STRETCH_S));
    if stretches.iter().map(|stretch| stretch.rows.len()).sum::<usize>() < rows_of(LEAST_S) {
        return Ok(false);
    }
    let (fit, holdout) = divide(stretches);
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| GapRecordError::File { path, source }
    };
    // Nobody shall find half a case: it is written beside its place.
    let name = case.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let part = case.with_file_name(format!(".{name}"));
    let _ = std::fs::remove_dir_all(&part);
    for (name, stretches) in [("fit", fit), ("holdout", holdout)] {
        let folder = part.join(name);
        std::fs::create_dir_all(&folder).map_err(failed(&folder))?;
        for (index, stretch) in stretches.iter().enumerate() {
            let file = folder.join(format!("live_{:02}.{}.csv", index + 1, stretch.rail));
            write_run(&file, &stretch.rows, watch.wheelsets())?;
        }
    }
    let mut vehicle = vehicle.clone();
    vehicle.sensors.sample_rate_hz = (1.0 / period_s * 1e3).round() / 1e3;
    let path = part.join("vehicle.toml");
    std::fs::write(&path, toml::to_string(&vehicle)?).map_err(failed(&path))?;
    if grows {
        let path = part.join(GROWING);
        std::fs::write(&path, "written anew when more has been seen\n").map_err(failed(&path))?;
    }
    if case.exists() {
        std::fs::remove_dir_all(case).map_err(failed(case))?;
    }
    std::fs::rename(&part, case).map_err(failed(case))?;
    Ok(true)
}

/// Says that a case will not be written anew.
///
/// # Errors
/// If the mark cannot be taken away.
pub fn settle(case: &Path) -> Result<(), GapRecordError> {
    let path = case.join(GROWING);
    match std::fs::remove_file(&path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(GapRecordError::File { path, source })
        }
        _ => Ok(()),
    }
}

fn write_run(file: &Path, rows: &[Row], wheelsets: usize) -> Result<(), GapRecordError> {
    let has = |value: fn(&Row) -> f64| rows.iter().all(|row| value(row).is_finite());
    let optional = Optional {
        grade: has(|row| row.grade_rad),
        sanding: has(|row| row.sanding),
        position: has(|row| row.position_m),
        ..Optional::NONE
    };
    let mut writer = RunWriter::create(file, wheelsets, optional)?;
    for row in rows {
        writer.push(row)?;
    }
    Ok(writer.finish()?)
}

/// The usual time from sample to sample, s.
fn period_s(kept: &[KeptRow]) -> Option<f64> {
    let mut steps: Vec<f64> = kept.windows(2).map(|pair| pair[1].row.t_s - pair[0].row.t_s).collect();
    steps.sort_by(f64::total_cmp);
    let median = *steps.get(steps.len() / 2)?;
    // Times carry the sender's rounding.
    (median > 0.0).then_some((median * 1e6).round() / 1e6)
}

fn class(rail: Condition) -> &'static str {
    match rail {
        Condition::Dry => "dry",
        Condition::Wet => "wet",
        Condition::Low | Condition::VeryLow => "low",
    }
}

/// From dry to low.
fn badness(rail: &str) -> usize {
    ["dry", "wet", "low"].iter().position(|class| *class == rail).unwrap_or(0)
}

/// Takes the wavering out of what the rail was taken to be: it would cut the minutes into pieces too short to keep.
fn steady(kept: &mut [KeptRow], period_s: f64) {
    let brief = (WAVERS_S / period_s) as usize;
    // Where each spell of one class begins, in whole.
    let begins = |kept: &[KeptRow], k: usize| k == 0 || class(kept[k].rail) != class(kept[k - 1].rail);
    let mut starts: Vec<usize> = (0..kept.len()).filter(|k| begins(kept, *k)).collect();
    starts.push(kept.len());
    for spell in 1..starts.len().saturating_sub(2) {
        let (from, to) = (starts[spell], starts[spell + 1]);
        let before = kept[from - 1].rail;
        if to - from < brief && class(before) == class(kept[to].rail) {
            kept[from..to].iter_mut().for_each(|row| row.rail = before);
        }
    }
}

fn stretches(kept: &[KeptRow], period_s: f64, wheelsets: usize) -> Vec<Stretch> {
    let mut all: Vec<Stretch> = Vec::new();
    for KeptRow { row, rail } in kept {
        let rail = class(*rail);
        let (missing, jumps, worsens) = match all
            .last()
            .and_then(|stretch| stretch.rows.last().map(|last| (stretch.rail, last)))
        {
            None => (0, true, false),
            Some((before, last)) => {
                let steps = (row.t_s - last.t_s) / period_s;
                let far = (row.position_m - last.position_m).abs() > JUMP_M;
                let regular = (steps - steps.round()).abs() < 0.2 && steps.round() >= 1.0;
                (steps.round() as usize, far || !regular || before != rail, badness(rail) > badness(before))
            }
        };
        if jumps || missing > BRIDGED + 1 {
            if worsens && let Some(stretch) = all.last_mut() {
                let late = (NOTICED_LATE_S / period_s) as usize;
                stretch.rows.truncate(stretch.rows.len().saturating_sub(late));
            }
            all.push(Stretch { rail, rows: Vec::new() });
        } else if let Some(stretch) = all.last_mut() {
            // Lost samples are empty rows for now.
            let begin = stretch.rows.last().map_or(row.t_s, |last| last.t_s);
            let empty = |k: usize| Row { t_s: begin + k as f64 * period_s, ..Row::default() };
            stretch.rows.extend((1..missing).map(empty));
        }
        if let Some(stretch) = all.last_mut() {
            stretch.rows.push(*row);
        }
    }
    all.into_iter().flat_map(|stretch| bridged(stretch, period_s, wheelsets)).collect()
}

/// The required cells of a row.
fn cells(row: &mut Row, wheelsets: usize) -> impl Iterator<Item = &mut f64> {
    let Row { v_m_s, wheel_speed_rad_s, pressing_force_n, drive_torque_nm, .. } = row;
    std::iter::once(v_m_s)
        .chain(wheel_speed_rad_s[..wheelsets].iter_mut())
        .chain(pressing_force_n[..wheelsets].iter_mut())
        .chain(drive_torque_nm[..wheelsets].iter_mut())
}

/// The optional cells of a row; they are bridged with the others, and a column without any value stays away.
fn optional_cells(row: &mut Row) -> [&mut f64; 3] {
    [&mut row.grade_rad, &mut row.sanding, &mut row.position_m]
}

/// A stretch with short holes filled, cut at long ones, on a regular time.
fn bridged(mut stretch: Stretch, period_s: f64, wheelsets: usize) -> Vec<Stretch> {
    let columns = cells(&mut Row::default(), wheelsets).count();
    for column in 0..columns + 3 {
        let at = |row: &mut Row| -> Option<f64> {
            let optional = column.checked_sub(columns);
            match optional {
                Some(index) => optional_cells(row).into_iter().nth(index).map(|cell| *cell),
                None => cells(row, wheelsets).nth(column).map(|cell| *cell),
            }
        };
        let values: Vec<f64> = stretch.rows.iter_mut().map(|row| at(row).unwrap_or(f64::NAN)).collect();
        for (k, value) in filled(&values) {
            let row = &mut stretch.rows[k];
            let cell = match column.checked_sub(columns) {
                Some(index) => optional_cells(row).into_iter().nth(index),
                None => cells(row, wheelsets).nth(column),
            };
            if let Some(cell) = cell {
                *cell = value;
            }
        }
    }
    let whole = |mut row: Row| cells(&mut row, wheelsets).all(|cell| cell.is_finite());
    let mut parts = vec![Stretch { rail: stretch.rail, rows: Vec::new() }];
    for row in stretch.rows {
        if !whole(row) {
            parts.push(Stretch { rail: stretch.rail, rows: Vec::new() });
        } else if let Some(part) = parts.last_mut() {
            part.rows.push(row);
        }
    }
    for part in &mut parts {
        let Some(begin) = part.rows.first().map(|row| row.t_s) else { continue };
        let on_grid = |k: usize| ((begin + k as f64 * period_s) * 1e6).round() / 1e6;
        part.rows.iter_mut().enumerate().for_each(|(k, row)| row.t_s = on_grid(k));
    }
    parts
}

/// Values for the holes of a column that are short enough, by index.
fn filled(values: &[f64]) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    let mut last: Option<usize> = None;
    for (k, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        if let Some(before) = last
            && (2..=BRIDGED + 1).contains(&(k - before))
        {
            let share = |at: usize| (at - before) as f64 / (k - before) as f64;
            let line = |at: usize| values[before] + share(at) * (value - values[before]);
            found.extend((before + 1..k).map(|at| (at, line(at))));
        }
        last = Some(k);
    }
    found
}

/// Runs to fit on and runs to predict: the last of each class of which there are several, else the end of the longest.
fn divide(mut stretches: Vec<Stretch>) -> (Vec<Stretch>, Vec<Stretch>) {
    let mut holdout = Vec::new();
    for class in ["dry", "wet", "low"] {
        let of_class = |stretch: &Stretch| stretch.rail == class;
        if stretches.iter().filter(|stretch| of_class(stretch)).count() > 1
            && let Some(last) = stretches.iter().rposition(of_class)
        {
            holdout.push(stretches.remove(last));
        }
    }
    let total = |all: &[Stretch]| all.iter().map(|stretch| stretch.rows.len()).sum::<usize>();
    let longest = (0..stretches.len()).max_by_key(|index| stretches[*index].rows.len());
    if total(&holdout) * 4 < total(&stretches)
        && let Some(longest) = longest.map(|index| &mut stretches[index])
    {
        let rows = longest.rows.split_off((FIT_SHARE * longest.rows.len() as f64) as usize);
        holdout.push(Stretch { rail: longest.rail, rows });
    }
    (stretches, holdout)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(seconds: std::ops::Range<f64>, rail: Condition, hole: Option<f64>) -> Vec<KeptRow> {
        let count = ((seconds.end - seconds.start) * 100.0).round() as usize;
        let times = (0..count).map(|k| seconds.start + k as f64 * 0.01);
        times
            .filter(|t| hole.is_none_or(|hole| (t - hole).abs() > 0.021))
            .map(|t_s| {
                let row = Row {
                    t_s,
                    v_m_s: 20.0 - 0.1 * t_s,
                    wheel_speed_rad_s: [40.0; 4],
                    pressing_force_n: [1e4; 4],
                    drive_torque_nm: [0.0; 4],
                    position_m: 20.0 * t_s,
                    ..Row::default()
                };
                KeptRow { row, rail }
            })
            .collect()
    }

    #[test]
    fn rail_changes_and_long_holes_cut_and_short_holes_are_bridged() {
        let mut rows = kept(0.0..30.0, Condition::Dry, Some(10.0));
        rows.extend(kept(30.0..50.0, Condition::Low, None));
        rows.extend(kept(52.0..70.0, Condition::Low, None));
        let stretches = stretches(&rows, 0.01, 2);
        let lengths: Vec<(&str, usize)> = stretches.iter().map(|s| (s.rail, s.rows.len())).collect();
        println!("{lengths:?}");
        // The dry stretch has its five lost samples back and ends four seconds before the rail was called low.
        assert_eq!(lengths, [("dry", 2600), ("low", 2000), ("low", 1800)]);
        let lost = &stretches[0].rows[1000];
        assert!((lost.t_s - 10.0).abs() < 1e-9 && (lost.v_m_s - 19.0).abs() < 1e-9, "{lost:?}");
        for stretch in &stretches {
            assert!(stretch.rows.windows(2).all(|pair| (pair[1].t_s - pair[0].t_s - 0.01).abs() < 1e-9));
        }
        let (fit, holdout) = divide(stretches);
        assert_eq!((fit.len(), holdout.len(), holdout[0].rail), (2, 1, "low"));
    }

    #[test]
    fn a_rail_that_wavers_cuts_nothing_and_one_that_changes_does() {
        let mut rows = kept(0.0..10.0, Condition::Dry, None);
        for (seconds, rail) in [
            (10.0..12.0, Condition::Wet),
            (12.0..13.0, Condition::Dry),
            (13.0..15.0, Condition::Low),
            (15.0..30.0, Condition::Dry),
            (30.0..45.0, Condition::VeryLow),
            (45.0..46.0, Condition::Wet),
        ] {
            rows.extend(kept(seconds, rail, None));
        }
        steady(&mut rows, 0.01);
        let spells: Vec<(&str, usize)> =
            stretches(&rows, 0.01, 2).iter().map(|s| (s.rail, s.rows.len())).collect();
        println!("{spells:?}");
        // Each end of a spell on better rail lies four seconds before worse rail was noticed; the last second is no return.
        assert_eq!(spells, [("dry", 2600), ("low", 1500), ("wet", 100)]);
    }

    #[test]
    fn one_stretch_is_divided_and_a_jump_of_position_cuts() {
        let one = stretches(&kept(0.0..40.0, Condition::Wet, None), 0.01, 2);
        let (fit, holdout) = divide(one);
        assert_eq!((fit[0].rows.len(), holdout[0].rows.len()), (2600, 1400));
        let mut rows = kept(0.0..20.0, Condition::Dry, None);
        rows.iter_mut().skip(1200).for_each(|kept| kept.row.position_m -= 200.0);
        assert_eq!(stretches(&rows, 0.01, 2).len(), 2);
    }
}
