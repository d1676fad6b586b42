//! The contract's gap between a sheet and a recording, and the fit of the nuisances: enough to say how large an effect
//! is and what a perfect diagnosis would leave. This is bookkeeping of the plant, not a diagnosis.

use crate::{
    dynamics::{self, Action, Motion},
    plant::{Run, SAMPLE_S},
    sheet::Sheet,
    wagon::{Nuisances, TrueWagon},
};

/// Samples of a full window (10 s).
const WINDOW: usize = 1000;
/// Samples of the shortest window that counts (1 s).
const SHORTEST: usize = 100;
/// Integration steps in a sample; the method is L-stable, so two resolve what labels need.
const STEPS: usize = 2;
/// Every so many samples enter the fit.
const STRIDE: usize = 10;
/// Nuisances that are fitted.
const COUNT: usize = 9;
/// Their bounds, in the order of [`from_vector`].
const BOUNDS: [f64; COUNT] = [0.15, 0.15, 0.15, 0.15, 0.15, 0.10, 0.10, 0.015, 0.03];

fn from_vector(x: &[f64; COUNT]) -> Nuisances {
    Nuisances {
        pad: [x[0], x[1]],
        rail: [x[2], x[3], x[4]],
        constant: x[5],
        drag: x[6],
        mass: x[7],
        inertia: x[8],
    }
}

/// Gap of a set of runs: RMS of error over sigma, by signal (`v`, leading wheel, rear wheel) and over all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// By signal.
    pub by_signal: [f64; 3],
}

impl Gap {
    /// RMS over the signals.
    #[must_use]
    pub fn total(&self) -> f64 {
        (self.by_signal.iter().map(|gap| gap * gap).sum::<f64>() / 3.0).sqrt()
    }
}

/// Gap of a wagon without departures on runs.
#[must_use]
pub fn gap<'a>(sheet: &Sheet, wagon: &TrueWagon, runs: impl Iterator<Item = &'a Run>) -> Gap {
    let (mut squares, mut count) = ([0.0; 3], 0.0f64);
    for run in runs {
        for window in windows(run.rows.len()) {
            predict(sheet, wagon, run, window, 1, |error| {
                for (sum, error) in squares.iter_mut().zip(error) {
                    *sum += error * error;
                }
                count += 1.0;
            });
        }
    }
    Gap { by_signal: squares.map(|sum| (sum / count.max(1.0)).sqrt()) }
}

/// Fits the nuisances to runs, robustly against single windows at the edge of adhesion; `start` is a first guess.
/// Levenberg–Marquardt on a pseudo-Huber loss of the windows' RMS.
#[must_use]
pub fn calibrate(sheet: &Sheet, runs: &[&Run], start: &Nuisances, rounds: usize) -> Nuisances {
    let n = start;
    let mut x = [n.pad[0], n.pad[1], n.rail[0], n.rail[1], n.rail[2], n.constant, n.drag, n.mass, n.inertia];
    let mut base = residuals(sheet, runs, &x);
    let mut damping = 1e-3;
    for _ in 0..rounds {
        let bend = 3.0 * median(base.iter().map(|window| rms(window))).max(1.0);
        let loss = |all: &[Vec<f64>]| {
            all.iter().map(|w| w.len() as f64 * ((rms(w) / bend).hypot(1.0) - 1.0)).sum::<f64>()
        };
        let weight: Vec<f64> = base.iter().map(|window| 1.0 / (rms(window) / bend).hypot(1.0)).collect();
        let columns = sensitivities(sheet, runs, &x, &base);
        let before = loss(&base);
        let mut improved = false;
        for _ in 0..4 {
            let change = solve(&columns, &base, &weight, &x, damping);
            let trial: [f64; COUNT] =
                std::array::from_fn(|k| (x[k] + change[k]).clamp(-BOUNDS[k], BOUNDS[k]));
            let residual = residuals(sheet, runs, &trial);
            if loss(&residual) < before {
                improved = before - loss(&residual) > 2e-3 * before;
                (x, base) = (trial, residual);
                damping = (damping * 0.1).max(1e-4);
                break;
            }
            damping = (damping * 20.0).max(1e-2);
        }
        if !improved {
            break;
        }
    }
    from_vector(&x)
}

/// Change of every residual with every nuisance.
fn sensitivities(
    sheet: &Sheet,
    runs: &[&Run],
    x: &[f64; COUNT],
    base: &[Vec<f64>],
) -> [Vec<Vec<f64>>; COUNT] {
    std::array::from_fn(|k| {
        let mut moved = *x;
        let nudge = if x[k] > 0.0 { -0.02 * BOUNDS[k] } else { 0.02 * BOUNDS[k] };
        moved[k] += nudge;
        // A rail class concerns its own runs only.
        let concerned = |run: &Run| !(2..5).contains(&k) || run.order.rail as usize == k - 2;
        let mut column = residuals_of(sheet, runs, &moved, base, concerned);
        for (window, base) in column.iter_mut().zip(base) {
            for (value, base) in window.iter_mut().zip(base) {
                *value = (*value - base) / nudge;
            }
        }
        column
    })
}

/// Damped Gauss–Newton step with a wide prior on each nuisance.
fn solve(
    columns: &[Vec<Vec<f64>>; COUNT],
    base: &[Vec<f64>],
    weight: &[f64],
    x: &[f64; COUNT],
    damping: f64,
) -> [f64; COUNT] {
    let mut normal = [[0.0; COUNT]; COUNT];
    let mut right = [0.0; COUNT];
    let dot = |a: &[Vec<f64>], b: &[Vec<f64>]| -> f64 {
        let windows = a.iter().zip(b).zip(weight);
        windows.map(|((a, b), w)| w * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()).sum()
    };
    for row in 0..COUNT {
        for column in row..COUNT {
            normal[row][column] = dot(&columns[row], &columns[column]);
            normal[column][row] = normal[row][column];
        }
        let prior = 1.0 / BOUNDS[row].powi(2);
        right[row] = -dot(&columns[row], base) - prior * x[row];
        normal[row][row] = normal[row][row] * (1.0 + damping) + prior;
    }
    cholesky_solve(normal, right)
}

fn cholesky_solve(mut a: [[f64; COUNT]; COUNT], mut b: [f64; COUNT]) -> [f64; COUNT] {
    for j in 0..COUNT {
        for i in j..COUNT {
            let inner: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            a[i][j] = if i == j { (a[j][j] - inner).max(1e-300).sqrt() } else { (a[i][j] - inner) / a[j][j] };
        }
    }
    for i in 0..COUNT {
        let inner: f64 = (0..i).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - inner) / a[i][i];
    }
    for i in (0..COUNT).rev() {
        let inner: f64 = (i + 1..COUNT).map(|k| a[k][i] * b[k]).sum();
        b[i] = (b[i] - inner) / a[i][i];
    }
    b
}

/// Residuals over sigma, window by window.
fn residuals(sheet: &Sheet, runs: &[&Run], x: &[f64; COUNT]) -> Vec<Vec<f64>> {
    residuals_of(sheet, runs, x, &[], |_| true)
}

/// The same, with the residuals of `others` for runs that are not concerned.
fn residuals_of(
    sheet: &Sheet,
    runs: &[&Run],
    x: &[f64; COUNT],
    others: &[Vec<f64>],
    concerned: impl Fn(&Run) -> bool,
) -> Vec<Vec<f64>> {
    let wagon = TrueWagon::new(sheet, &from_vector(x));
    let mut all = Vec::new();
    for run in runs {
        for window in windows(run.rows.len()) {
            if !concerned(run) {
                all.push(others[all.len()].clone());
                continue;
            }
            let mut values = Vec::with_capacity(3 * WINDOW / STRIDE);
            predict(sheet, &wagon, run, window, STRIDE, |error| values.extend(error));
            all.push(values);
        }
    }
    all
}

fn windows(samples: usize) -> impl Iterator<Item = (usize, usize)> {
    let starts = (0..samples).step_by(WINDOW);
    starts.map(move |from| (from, (from + WINDOW).min(samples))).filter(|(from, to)| to - from >= SHORTEST)
}

/// Runs the wagon open loop through one window and reports every `stride`-th error over sigma.
fn predict(
    sheet: &Sheet,
    wagon: &TrueWagon,
    run: &Run,
    (from, to): (usize, usize),
    stride: usize,
    mut report: impl FnMut([f64; 3]),
) {
    let first = &run.rows[from..(from + 5).min(to)];
    let mean =
        |value: fn(&crate::plant::Row) -> f64| first.iter().map(value).sum::<f64>() / first.len() as f64;
    let mut motion = Motion {
        v_m_s: mean(|row| row.v_m_s),
        wheel_speed_rad_s: [mean(|row| row.wheel_speed_rad_s[0]), mean(|row| row.wheel_speed_rad_s[1])],
    };
    let mut lagged_m_s2 = 0.0;
    let peak = wagon.rail_friction(run.order.rail);
    for (offset, row) in run.rows[from..to].iter().enumerate() {
        if offset % stride == 0 {
            let wheel = |k: usize| {
                (motion.wheel_speed_rad_s[k] - row.wheel_speed_rad_s[k]) / sheet.wheel_speed_sigma_rad_s
            };
            report([(motion.v_m_s - row.v_m_s) / sheet.speed_sigma_m_s, wheel(0), wheel(1)]);
        }
        for _ in 0..STEPS {
            let torque = |k: usize| {
                let turning = dynamics::direction(motion.wheel_speed_rad_s[k] / 0.2);
                let brake_nm = wagon.pad_friction[k] * row.pressing_force_n[k] * wagon.brake_radius_m;
                row.drive_torque_nm[k] - brake_nm * turning
            };
            let action = Action {
                shaft_torque_nm: [torque(0), torque(1)],
                grade_rad: row.grade_rad,
                headwind_m_s: 0.0,
                body_force_n: 0.0,
                load_transfer: 1.0,
            };
            let step_s = SAMPLE_S / STEPS as f64;
            let (next, rates) = dynamics::step(wagon, &motion, &action, lagged_m_s2, step_s, &|_, _| peak);
            lagged_m_s2 = rates.acceleration_m_s2;
            motion = Motion { wheel_speed_rad_s: next.wheel_speed_rad_s.map(|w| w.max(0.0)), ..next };
        }
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(1.0)
}
