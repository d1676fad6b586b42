//! Predicted outputs of the three models on the holdout runs, and the gaps that follow from them.

use crate::answer::schema::WorstWindow;
use crate::data::case::{Case, OUTPUTS, Run, output_names};
use crate::fit::windows::robust;
use crate::model::parameters::Built;
use crate::predict::open_loop::{self, Prediction, Tally, sigmas};
use railgrip_recording::{RecordingError, Table};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::path::Path;

/// The three models of a report.
pub const MODELS: [&str; 3] = ["nominal", "calibrated", "extended"];

/// A run with the predictions of the three models.
#[derive(Clone, Debug)]
pub struct Predicted {
    /// `NAME.RAIL`.
    pub name: String,
    /// Windows of each model.
    pub windows: [Vec<Prediction>; 3],
    /// Tallies of each model's windows.
    pub tallies: [Vec<Tally>; 3],
}

/// Predicts runs with three models. Outputs are rounded as the files hold them, so that the gaps follow from the files.
pub fn predict(case: &Case, runs: &[Run], models: [&Built; 3]) -> Vec<Predicted> {
    let sigma = sigmas(&case.vehicle.sensors);
    runs.par_iter()
        .map(|run| {
            let windows = models.map(|built| {
                let mut windows = open_loop::predict(built, run);
                windows.iter_mut().flat_map(|w| &mut w.outputs).flatten().for_each(|x| *x = rounded(*x));
                windows
            });
            let tallies = std::array::from_fn(|m| {
                windows[m].iter().map(|w| open_loop::tally(w, run, &sigma)).collect()
            });
            Predicted { name: run.name.clone(), windows, tallies }
        })
        .collect()
}

fn rounded(x: f64) -> f64 {
    if x.is_finite() { (x * 1e6).round() / 1e6 } else { 0.0 }
}

/// Total tally of each model over runs.
pub fn totals(predicted: &[Predicted]) -> [Tally; 3] {
    std::array::from_fn(|m| Tally::total(predicted.iter().flat_map(|p| &p.tallies[m])))
}

/// Gaps of the calibrated and the extended model over these runs without this share of their windows, at least one: those in
/// which that model errs most.
pub fn lasting_gaps(runs: [&[Predicted]; 2], share: f64) -> [f64; 2] {
    [1, 2].map(|model| {
        let mut windows: Vec<&Tally> = runs.into_iter().flatten().flat_map(|p| &p.tallies[model]).collect();
        windows.sort_by(|a, b| a.gap().total_cmp(&b.gap()));
        let few = (share * windows.len() as f64).ceil() as usize;
        let kept = windows.len().saturating_sub(few).max(1);
        Tally::total(windows.into_iter().take(kept)).gap()
    })
}

/// Gaps of the calibrated and the extended model over these runs, see [`robust`](crate::fit::windows::robust).
pub fn robust_gaps(predicted: &[Predicted]) -> [f64; 2] {
    [1, 2].map(|model| {
        let tallies: Vec<Tally> = predicted.iter().flat_map(|p| p.tallies[model].iter().copied()).collect();
        robust(&tallies)
    })
}

/// The window that makes [`ALONE`] of the squared errors of the extended model or more, if one of several does. `predicted` are
/// `runs` in their order.
pub fn worst_window(runs: &[Run], predicted: &[Predicted]) -> Option<WorstWindow> {
    let windows: Vec<(usize, usize)> = predicted
        .iter()
        .enumerate()
        .flat_map(|(r, run)| (0..run.tallies[2].len()).map(move |w| (r, w)))
        .collect();
    let squares = |(r, w): (usize, usize)| predicted[r].tallies[2][w].squares.iter().sum::<f64>();
    let worst = windows.iter().copied().max_by(|a, b| squares(*a).total_cmp(&squares(*b)))?;
    let share = squares(worst) / windows.iter().map(|w| squares(*w)).sum::<f64>().max(f64::MIN_POSITIVE);
    if windows.len() < FEWEST_WINDOWS || share < ALONE {
        return None;
    }
    let others = |model: usize| {
        let others = windows.iter().filter(|window| **window != worst);
        Tally::total(others.map(|(r, w)| &predicted[*r].tallies[model][*w])).gap()
    };
    let (run, window) = (runs.get(worst.0)?, predicted[worst.0].windows[2].get(worst.1)?);
    Some(WorstWindow {
        run: predicted[worst.0].name.clone(),
        start_s: *run.t_s.get(window.range.start)?,
        share,
        calibrated_without: others(1),
        extended_without: others(2),
    })
}

/// Share of the squared errors from which one window alone is said to make them.
const ALONE: f64 = 0.5;
/// Windows below which it is no wonder that one makes most of the errors.
const FEWEST_WINDOWS: usize = 4;

/// By how much the effects change what is predicted of these runs: RMS of extended minus calibrated over the sigmas of the sensors.
pub fn moved(case: &Case, predicted: &[Predicted]) -> f64 {
    let sigma = sigmas(&case.vehicle.sensors);
    let windows = predicted.iter().flat_map(|run| run.windows[1].iter().zip(&run.windows[2]));
    let rows = windows.flat_map(|(calibrated, extended)| calibrated.outputs.iter().zip(&extended.outputs));
    let outputs =
        predicted.iter().flat_map(|run| &run.tallies[1]).map(|tally| tally.outputs).max().unwrap_or(0);
    let square = |j: usize, [a, b]: [f64; 2]| ((b - a) / sigma[j]).powi(2);
    let of_row = |(a, b): (&[f64; OUTPUTS], &[f64; OUTPUTS])| {
        (0..outputs).map(|j| square(j, [a[j], b[j]])).sum::<f64>()
    };
    let (sum, count) = rows.fold((0.0, 0), |(sum, count), row| (sum + of_row(row), count + outputs));
    (sum / count.max(1) as f64).sqrt()
}

/// 95 % interval of `1 − extended / calibrated` by resampling windows.
pub fn reduction_interval(predicted: &[Predicted], seed: u64) -> [f64; 2] {
    let pairs: Vec<(Tally, Tally)> = predicted
        .iter()
        .flat_map(|p| p.tallies[1].iter().copied().zip(p.tallies[2].iter().copied()))
        .collect();
    if pairs.is_empty() {
        return [0.0, 0.0];
    }
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x5eed);
    let mut reductions: Vec<f64> = (0..500)
        .map(|_| {
            let (mut calibrated, mut extended) = (Tally::default(), Tally::default());
            for _ in 0..pairs.len() {
                let (c, e) = &pairs[random.random_range(0..pairs.len())];
                calibrated.add(c);
                extended.add(e);
            }
            reduction(calibrated.gap(), extended.gap())
        })
        .collect();
    reductions.sort_by(f64::total_cmp);
    [reductions[12], reductions[487]]
}

/// `1 − extended / calibrated`.
pub fn reduction(calibrated: f64, extended: f64) -> f64 {
    if calibrated > 0.0 { 1.0 - extended / calibrated } else { 0.0 }
}

/// The prediction files of runs, by their names; parts of one recording share one.
///
/// # Errors
/// Columns that do not fit together.
pub fn tables(runs: &[Run], predicted: &[Predicted]) -> Result<Vec<(String, Table)>, RecordingError> {
    let pairs: Vec<(&Run, &Predicted)> = runs.iter().zip(predicted).collect();
    let parts = pairs.chunk_by(|a, b| a.0.name == b.0.name);
    parts.map(|parts| Ok((parts[0].0.name.clone(), table(parts)?))).collect()
}

/// `t_s, window`, and each output measured (empty where it was not) and by the three models.
fn table(parts: &[(&Run, &Predicted)]) -> Result<Table, RecordingError> {
    let mut columns: Vec<(String, Vec<f64>)> =
        vec![("t_s".into(), Vec::new()), ("window".into(), Vec::new())];
    let outputs = parts.first().map_or(&[] as &[&str], |(run, _)| output_names(run.wheelsets));
    for output in outputs {
        columns.push(((*output).into(), Vec::new()));
        columns.extend(MODELS.map(|model| (format!("{output}_{model}"), Vec::new())));
    }
    let windows = parts
        .iter()
        .flat_map(|(run, predicted)| (0..predicted.windows[0].len()).map(move |w| (*run, *predicted, w)));
    for (number, (run, predicted, w)) in windows.enumerate() {
        for (row, k) in predicted.windows[0][w].range.clone().enumerate() {
            columns[0].1.push(run.t_s[k]);
            columns[1].1.push(number as f64);
            for j in 0..run.outputs() {
                columns[2 + 4 * j].1.push(run.samples[k].as_measured(j));
                for m in 0..MODELS.len() {
                    columns[3 + 4 * j + m].1.push(predicted.windows[m][w].outputs[row][j]);
                }
            }
        }
    }
    Table::new(columns)
}

/// Writes one table a run into `folder`, named `NAME.RAIL.csv`.
///
/// # Errors
/// A folder that cannot be made or written.
pub fn write(tables: &[(String, Table)], folder: &Path) -> Result<(), RecordingError> {
    for (name, table) in tables {
        table.write(&folder.join(format!("{name}.csv")))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::case::Columns;
    use railgrip_vehicle::RailClass;

    /// A run of 50 s that stands, and what three models miss of the speed in each of its five windows, in sigmas.
    fn run_and(missed: [[f64; 5]; 3]) -> (Run, Predicted) {
        let n = 5000;
        let still = vec![vec![0.0; n]; 2];
        let columns = Columns {
            t_s: (0..n).map(|k| 100.0 + 0.01 * k as f64).collect(),
            v_m_s: vec![0.0; n],
            wheel_speed_rad_s: still.clone(),
            pressing_force_n: still.clone(),
            drive_torque_nm: still,
            ..Columns::default()
        };
        let range = |w: usize| 1000 * w..1000 * (w + 1);
        let window = |w: usize| Prediction { range: range(w), outputs: vec![[0.0; OUTPUTS]; 1000] };
        let tally = |sigmas: f64| {
            let mut tally = Tally { outputs: 3, count: 1000, ..Tally::default() };
            tally.squares[0] = 3.0 * 1000.0 * sigmas * sigmas;
            tally
        };
        let predicted = Predicted {
            name: "stop.wet".to_owned(),
            windows: std::array::from_fn(|_| (0..5).map(window).collect()),
            tallies: missed.map(|windows| windows.map(tally).to_vec()),
        };
        (Run::new("stop".to_owned(), RailClass::Wet, &columns), predicted)
    }

    #[test]
    fn a_window_is_named_where_it_alone_makes_most_of_the_errors() {
        let (run, predicted) = run_and([[9.0; 5], [8.0, 8.0, 2.0, 8.0, 8.0], [1.0, 1.0, 60.0, 1.0, 1.0]]);
        let worst = worst_window(std::slice::from_ref(&run), std::slice::from_ref(&predicted)).expect("one");
        assert_eq!((worst.run.as_str(), worst.start_s), ("stop.wet", 120.0));
        assert!((worst.share - 3600.0 / 3604.0).abs() < 1e-12, "{worst:?}");
        assert!((worst.calibrated_without - 8.0).abs() < 1e-9, "{worst:?}");
        assert!((worst.extended_without - 1.0).abs() < 1e-9, "{worst:?}");

        let (run, predicted) = run_and([[9.0; 5], [8.0; 5], [1.0, 1.0, 1.5, 1.0, 1.0]]);
        assert_eq!(worst_window(&[run], &[predicted]), None, "no window makes most of the errors");
    }
}
