//! The contract's gap between a sheet and recordings, and a fit of the nuisances: enough to say how large an effect is
//! and what a perfect diagnosis would leave. This is bookkeeping of the plant, not a diagnosis.

use super::{
    creep::CreepLaw,
    motion::{self, Action, Integrator, Motion},
    plant::{FamilyRow, FamilyRun},
    sheet::FamilySheet,
    wagon::{FamilyNuisances, FamilyWagon},
};
use crate::sheet::GRAVITY_M_S2;

/// Longest window and shortest that counts, s.
const WINDOW_S: f64 = 10.0;
const SHORTEST_S: f64 = 1.0;
/// A window reaches over no gap longer than this, s.
const LONGEST_GAP_S: f64 = 0.5;
/// A window starts from the mean of so long, s.
const START_S: f64 = 0.05;
/// Longest steps of the integration, s: for figures and for fits.
const FINE_S: f64 = 0.01;
const COARSE_S: f64 = 0.04;

/// Samples `[from, to)` of each window of a run.
#[must_use]
pub fn windows(run: &FamilyRun, sheet: &FamilySheet) -> Vec<(usize, usize)> {
    let sample_s = 1.0 / sheet.rate_hz;
    let (length, shortest) =
        ((WINDOW_S / sample_s).round() as usize, (SHORTEST_S / sample_s).round() as usize);
    let longest_gap = (LONGEST_GAP_S / sample_s).round() as usize;
    let complete = |row: &FamilyRow| {
        row.v_m_s.is_finite()
            && row.wheel_speed_rad_s[..sheet.wheelsets].iter().all(|w| w.is_finite())
            && row.pressing_force_n[..sheet.wheelsets].iter().all(|f| f.is_finite())
    };
    let mut pieces: Vec<(usize, usize)> = Vec::new();
    for (index, _) in run.rows.iter().enumerate().filter(|(_, row)| complete(row)) {
        match pieces.last_mut() {
            Some((_, to)) if index - *to <= longest_gap => *to = index + 1,
            _ => pieces.push((index, index + 1)),
        }
    }
    let cut = |(from, to): (usize, usize)| {
        (from..to).step_by(length).map(move |start| (start, (start + length).min(to)))
    };
    pieces.into_iter().flat_map(cut).filter(|(from, to)| to - from >= shortest).collect()
}

/// Gap of a set of runs: RMS over all signals of error over sigma.
#[must_use]
pub fn gap<'a>(
    sheet: &FamilySheet,
    nuisances: &FamilyNuisances,
    runs: impl Iterator<Item = &'a FamilyRun>,
) -> f64 {
    let wagon = FamilyWagon::new(sheet, nuisances, CreepLaw::Sheet);
    let (mut squares, mut count) = ([0.0; 5], [0.0f64; 5]);
    for run in runs {
        for window in windows(run, sheet) {
            predict(sheet, &wagon, run, window, FINE_S, |signal, error| {
                squares[signal] += error * error;
                count[signal] += 1.0;
            });
        }
    }
    let signals = 1 + sheet.wheelsets;
    (squares.iter().zip(count).take(signals).map(|(sum, count)| sum / count.max(1.0)).sum::<f64>()
        / signals as f64)
        .sqrt()
}

/// Runs the sheet's model open loop through one window and reports `(signal, error over sigma)` of every recorded value
/// that a step meets.
fn predict(
    sheet: &FamilySheet,
    wagon: &FamilyWagon,
    run: &FamilyRun,
    (from, to): (usize, usize),
    longest_s: f64,
    mut report: impl FnMut(usize, f64),
) {
    let sample_s = 1.0 / sheet.rate_hz;
    let every = ((longest_s / sample_s) as usize).max(1);
    let substeps = (sample_s * every as f64 / longest_s - 1e-9).ceil().max(1.0) as usize;
    let step_s = sample_s * every as f64 / substeps as f64;
    let first = ((START_S / sample_s).round() as usize).max(1);
    // Where a channel is silent at the start, its first readings stand in.
    let mean = |value: &dyn Fn(&FamilyRow) -> f64| {
        let present = || run.rows[from..to].iter().map(value).filter(|value| value.is_finite());
        let count =
            run.rows[from..(from + first).min(to)].iter().map(value).filter(|v| v.is_finite()).count().max(1);
        (present().take(count).sum::<f64>() / count as f64).max(0.0)
    };
    let mut motion = Motion { v_m_s: mean(&|row| row.v_m_s), wheel_speed_rad_s: [0.0; 4] };
    for k in 0..sheet.wheelsets {
        motion.wheel_speed_rad_s[k] = mean(&|row| row.wheel_speed_rad_s[k]);
    }
    let (mut acceleration_m_s2, mut force_n) = (0.0, [0.0; 4]);
    let peak = wagon.rail_friction(run.order.rail);
    let [constant, linear, drag] = wagon.resistance;
    for index in (from..to).step_by(every) {
        let row = &run.rows[index];
        let next = &run.rows[(index + every).min(to - 1)];
        report_errors(sheet, row, &motion, &mut report);
        let mut action = Action {
            mass_kg: wagon.mass_kg,
            peak: [peak; 4],
            radius_m: wagon.radius_m,
            inertia_kg_m2: wagon.inertia_kg_m2,
            torque_nm: [row.drive_torque_nm; 4],
            ..Action::default()
        };
        for k in 0..sheet.wheelsets {
            let ends = [row.pressing_force_n[k], next.pressing_force_n[k]];
            match ends.map(f64::is_finite) {
                [true, true] => force_n[k] = 0.5 * (ends[0] + ends[1]),
                [true, false] => force_n[k] = ends[0],
                [false, true] => force_n[k] = ends[1],
                [false, false] => {}
            }
            action.brake_nm[k] = wagon.pad_friction[k] * force_n[k] * wagon.brake_radius_m;
        }
        for _ in 0..substeps {
            let v = motion.v_m_s;
            action.load_n = wagon.loads_n(wagon.mass_kg, acceleration_m_s2, 1.0);
            action.resisting_n = constant + linear * v;
            action.outer_n = -drag * v * v - wagon.mass_kg * GRAVITY_M_S2 * row.grade_rad.sin();
            let stepped =
                motion::step(wagon, &motion, &action, acceleration_m_s2, step_s, Integrator::Implicit);
            (motion, acceleration_m_s2) = (stepped.motion, stepped.acceleration_m_s2);
        }
    }
}

fn report_errors(sheet: &FamilySheet, row: &FamilyRow, motion: &Motion, report: &mut impl FnMut(usize, f64)) {
    if row.v_m_s.is_finite() {
        report(0, (motion.v_m_s - row.v_m_s) / sheet.speed_sigma_m_s);
    }
    for k in 0..sheet.wheelsets {
        if row.wheel_speed_rad_s[k].is_finite() {
            let error_rad_s = motion.wheel_speed_rad_s[k] - row.wheel_speed_rad_s[k];
            report(1 + k, error_rad_s / sheet.wheel_speed_sigma_rad_s);
        }
    }
}

/// Residuals over sigma of one window on the coarse grid.
pub(super) fn residuals(
    sheet: &FamilySheet,
    wagon: &FamilyWagon,
    run: &FamilyRun,
    window: (usize, usize),
    values: &mut Vec<f64>,
) {
    values.clear();
    predict(sheet, wagon, run, window, COARSE_S, |_, error| values.push(error));
}
