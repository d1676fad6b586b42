//! The fit of the nuisances to runs: Levenberg–Marquardt on a pseudo-Huber loss of the windows' RMS, robust against single
//! windows at the edge of adhesion.

use super::{
    creep::CreepLaw,
    plant::FamilyRun,
    reference::{residuals, windows},
    sheet::FamilySheet,
    wagon::{FamilyNuisances, FamilyWagon},
};

/// A nuisance that is fitted: its bound and its place.
#[derive(Clone, Copy)]
struct Knob {
    bound: f64,
    place: fn(&mut FamilyNuisances, usize) -> &mut f64,
    index: usize,
    /// Only runs of this rail class feel it.
    rail: Option<usize>,
}

fn knobs(sheet: &FamilySheet, runs: &[&FamilyRun]) -> Vec<Knob> {
    let knob = |bound: f64, place: fn(&mut FamilyNuisances, usize) -> &mut f64| Knob {
        bound,
        place,
        index: 0,
        rail: None,
    };
    let mut knobs: Vec<Knob> =
        (0..sheet.wheelsets).map(|index| Knob { index, ..knob(0.15, |n, k| &mut n.pad[k]) }).collect();
    for rail in 0..3 {
        if runs.iter().any(|run| run.order.rail as usize == rail) {
            knobs.push(Knob { index: rail, rail: Some(rail), ..knob(0.15, |n, k| &mut n.rail[k]) });
        }
    }
    knobs.push(knob(0.10, |n, _| &mut n.constant));
    knobs.push(knob(0.10, |n, _| &mut n.drag));
    knobs.push(knob(0.015, |n, _| &mut n.mass));
    knobs.push(knob(0.03, |n, _| &mut n.inertia));
    knobs.push(knob(0.05, |n, _| &mut n.stiffness));
    knobs
}

/// Residuals of every window of some runs.
type Residuals = Vec<Vec<f64>>;

struct Bench<'a> {
    sheet: &'a FamilySheet,
    windows: Vec<(&'a FamilyRun, (usize, usize))>,
}

impl Bench<'_> {
    fn residuals(
        &self,
        nuisances: &FamilyNuisances,
        concerned: impl Fn(&FamilyRun) -> bool,
        others: &Residuals,
    ) -> Residuals {
        let wagon = FamilyWagon::new(self.sheet, nuisances, CreepLaw::Sheet);
        let of = |(index, (run, window)): (usize, &(&FamilyRun, (usize, usize)))| {
            if !concerned(run) {
                return others[index].clone();
            }
            let mut values = Vec::with_capacity(others.get(index).map_or(0, Vec::len));
            residuals(self.sheet, &wagon, run, *window, &mut values);
            values
        };
        self.windows.iter().enumerate().map(of).collect()
    }
}

/// Fits the nuisances, from `start`, in at most so many rounds.
#[must_use]
pub fn calibrate(
    sheet: &FamilySheet,
    runs: &[&FamilyRun],
    start: &FamilyNuisances,
    rounds: usize,
) -> FamilyNuisances {
    let knobs = knobs(sheet, runs);
    let windows =
        runs.iter().flat_map(|run| windows(run, sheet).into_iter().map(move |window| (*run, window)));
    let bench = Bench { sheet, windows: windows.collect() };
    // What cannot be fitted here stays at the sheet's value.
    let mut fitted = FamilyNuisances::default();
    for knob in &knobs {
        let mut from = *start;
        *(knob.place)(&mut fitted, knob.index) = *(knob.place)(&mut from, knob.index);
    }
    let mut base = bench.residuals(&fitted, |_| true, &Vec::new());
    let mut damping = 1e-3;
    for _ in 0..rounds {
        let bend = 3.0 * median(base.iter().map(|window| rms(window))).max(1.0);
        let loss = |all: &Residuals| {
            all.iter().map(|w| w.len() as f64 * ((rms(w) / bend).hypot(1.0) - 1.0)).sum::<f64>()
        };
        let weight: Vec<f64> = base.iter().map(|window| 1.0 / (rms(window) / bend).hypot(1.0)).collect();
        let columns: Vec<Residuals> =
            knobs.iter().map(|knob| sensitivity(&bench, &fitted, knob, &base)).collect();
        let before = loss(&base);
        let mut improved = false;
        for _ in 0..3 {
            let change = solve(&columns, &base, &weight, &knobs, &fitted, damping);
            let mut trial = fitted;
            for (knob, change) in knobs.iter().zip(change) {
                let value = (knob.place)(&mut trial, knob.index);
                *value = (*value + change).clamp(-knob.bound, knob.bound);
            }
            let residual = bench.residuals(&trial, |_| true, &base);
            let after = loss(&residual);
            if after < before {
                improved = before - after > 5e-3 * before;
                (fitted, base) = (trial, residual);
                damping = (damping * 0.1).max(1e-4);
                break;
            }
            damping = (damping * 30.0).max(1e-2);
        }
        if !improved {
            break;
        }
    }
    fitted
}

/// Change of every residual with one nuisance.
fn sensitivity(bench: &Bench, at: &FamilyNuisances, knob: &Knob, base: &Residuals) -> Residuals {
    let mut moved = *at;
    let value = (knob.place)(&mut moved, knob.index);
    let nudge = if *value > 0.0 { -0.03 * knob.bound } else { 0.03 * knob.bound };
    *value += nudge;
    let concerned = |run: &FamilyRun| knob.rail.is_none_or(|rail| run.order.rail as usize == rail);
    let mut column = bench.residuals(&moved, concerned, base);
    for (window, base) in column.iter_mut().zip(base) {
        window.iter_mut().zip(base).for_each(|(value, base)| *value = (*value - base) / nudge);
    }
    column
}

/// Damped Gauss–Newton step with a wide prior on each nuisance.
fn solve(
    columns: &[Residuals],
    base: &Residuals,
    weight: &[f64],
    knobs: &[Knob],
    at: &FamilyNuisances,
    damping: f64,
) -> Vec<f64> {
    let count = columns.len();
    let dot = |a: &Residuals, b: &Residuals| -> f64 {
        let windows = a.iter().zip(b).zip(weight);
        windows.map(|((a, b), w)| w * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()).sum()
    };
    let mut normal = vec![vec![0.0; count]; count];
    let mut right = vec![0.0; count];
    let mut at = *at;
    for row in 0..count {
        for column in row..count {
            normal[row][column] = dot(&columns[row], &columns[column]);
            normal[column][row] = normal[row][column];
        }
        let prior = 1.0 / knobs[row].bound.powi(2);
        right[row] = -dot(&columns[row], base) - prior * *(knobs[row].place)(&mut at, knobs[row].index);
        normal[row][row] = normal[row][row] * (1.0 + damping) + prior;
    }
    cholesky_solve(normal, right)
}

fn cholesky_solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let count = b.len();
    for j in 0..count {
        for i in j..count {
            let inner: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            a[i][j] = if i == j { (a[j][j] - inner).max(1e-300).sqrt() } else { (a[i][j] - inner) / a[j][j] };
        }
    }
    for i in 0..count {
        let inner: f64 = (0..i).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - inner) / a[i][i];
    }
    for i in (0..count).rev() {
        let inner: f64 = (i + 1..count).map(|k| a[k][i] * b[k]).sum();
        b[i] = (b[i] - inner) / a[i][i];
    }
    b
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(1.0)
}
