//! Simulated law-level cases: laws written down here a second time, in other forms than the library's, with other numbers.

#![allow(dead_code, clippy::unwrap_used)]

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use std::fmt::Write;
use std::path::Path;

/// How the points of a brake or creep bench are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// Every variable drawn at random.
    Scattered,
    /// A full grid, one file for each value of the slowest variable.
    Grid,
    /// Stops or sweeps: one variable runs, the others follow it or are held.
    Sweeps,
}

pub const LAYOUTS: [Layout; 3] = [Layout::Scattered, Layout::Grid, Layout::Sweeps];

/// A law-level case before it is written to disk.
pub struct Simulated {
    pub toml: String,
    /// Set (`fit` or `holdout`), file name, text.
    pub files: Vec<(&'static str, String, String)>,
}

impl Simulated {
    /// Lets the first column wander slowly within each file by a share of itself.
    pub fn wander(&mut self, seed: u64, share: f64) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        for (_, _, text) in &mut self.files {
            let mut state = normal();
            let mut lines = text.lines();
            let mut changed = format!("{}\n", lines.next().unwrap());
            for line in lines {
                state = 0.95 * state + (1.0 - 0.95_f64.powi(2)).sqrt() * normal();
                let (first, rest) = line.split_once(',').unwrap();
                let value: f64 = first.parse().unwrap();
                writeln!(changed, "{},{rest}", value * (1.0 + share * state)).unwrap();
            }
            *text = changed;
        }
    }

    pub fn write(&self, folder: &Path) {
        std::fs::write(folder.join("bench.toml"), &self.toml).unwrap();
        for (set, name, text) in &self.files {
            std::fs::create_dir_all(folder.join(set)).unwrap();
            std::fs::write(folder.join(set).join(format!("{name}.csv")), text).unwrap();
        }
    }
}

/// Truth of a brake bench: friction at speed (m/s), temperature (°C) and force (N).
pub type BrakeTruth<'a> = &'a dyn Fn(f64, f64, f64) -> f64;

/// A brake bench with white noise; the nominal level is off by up to 20 %.
pub fn brake(seed: u64, layout: Layout, sigma: f64, with_sigma: bool, truth: BrakeTruth<'_>) -> Simulated {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let level = 0.28 + 0.14 * random.random::<f64>();
    let nominal = level * (1.0 + 0.2 * (2.0 * random.random::<f64>() - 1.0));
    let mut files = Vec::new();
    for (set, count) in [("fit", 5), ("holdout", 2)] {
        for file in 0..count {
            let mut text = "mu,speed_m_s,temperature_c,pressing_force_n\n".to_owned();
            for (v, t, f) in brake_points(layout, file, set == "holdout", &mut random) {
                let noise: f64 = StandardNormal.sample(&mut random);
                let mu = level * truth(v, t, f) + sigma * noise;
                writeln!(text, "{mu:.6},{v:.4},{t:.3},{f:.2}").unwrap();
            }
            files.push((set, format!("run{file}"), text));
        }
    }
    let sensors = if with_sigma { format!("[sensors]\nsigma = {sigma}\n") } else { String::new() };
    let toml =
        format!("schema = 1\nkind = \"brake\"\n[nominal]\nfriction_coefficient = {nominal:.5}\n{sensors}");
    Simulated { toml, files }
}

fn brake_points(layout: Layout, file: usize, holdout: bool, random: &mut Pcg64Mcg) -> Vec<(f64, f64, f64)> {
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let shift = if holdout { 0.5 } else { 0.0 };
    match layout {
        Layout::Scattered => {
            (0..60).map(|_| (uniform(1.0, 40.0), uniform(30.0, 350.0), uniform(4e3, 30e3))).collect()
        }
        Layout::Grid => {
            let force = 6e3 + 5e3 * (file as f64 + shift);
            let cell = |i: usize| (4.0 + 7.0 * (i % 5) as f64, 50.0 + 60.0 * ((i / 5) % 5) as f64, force);
            (0..75).map(cell).collect()
        }
        Layout::Sweeps => {
            let (top, force) = (uniform(20.0, 42.0), uniform(8e3, 26e3));
            let mut temperature = uniform(40.0, 220.0);
            (0..80)
                .map(|i| {
                    let v = top * (1.0 - i as f64 / 80.0);
                    temperature += 0.15 * v * force / 25e3 * uniform(0.8, 1.2);
                    (v, temperature, force * uniform(0.97, 1.03))
                })
                .collect()
        }
    }
}

/// What a creep bench may get wrong.
#[derive(Clone, Copy)]
pub struct CreepTruth<'a> {
    /// Factor on adhesion over slip velocity (m/s), speed (m/s) and load (N).
    pub level: &'a dyn Fn(f64, f64, f64) -> f64,
    /// Factor on stiffness over load.
    pub stiffness: &'a dyn Fn(f64) -> f64,
    /// k_A and k_S.
    pub shape: (f64, f64),
}

/// No effect.
pub const PLAIN: CreepTruth<'static> =
    CreepTruth { level: &|_, _, _| 1.0, stiffness: &|_| 1.0, shape: (1.0, 0.4) };

/// A creep bench; the nominal level and stiffness are off by up to 20 %.
pub fn creep(
    seed: u64,
    layout: Layout,
    relative_sigma: f64,
    with_sigma: bool,
    truth: CreepTruth<'_>,
) -> Simulated {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mu0 = 0.2 + 0.3 * random.random::<f64>();
    let stiffness = 8e5 * (0.7 + 0.6 * random.random::<f64>());
    let mut off = || 1.0 + 0.2 * (2.0 * random.random::<f64>() - 1.0);
    let (nominal_mu, nominal_stiffness) = (mu0 * off(), stiffness * off());
    let sigma = relative_sigma * mu0 * 1e4;
    let mut files = Vec::new();
    for (set, count) in [("fit", 5), ("holdout", 2)] {
        for file in 0..count {
            let mut text = "creepage,load_n,force_n,speed_m_s\n".to_owned();
            for (s, q, v) in creep_points(layout, file, set == "holdout", &mut random) {
                let mu = mu0 * (truth.level)(s * v, v, q);
                let k = stiffness * (truth.stiffness)(q);
                let eps = k * s / (q * mu);
                let (a, b) = truth.shape;
                let share =
                    2.0 / std::f64::consts::PI * (a * eps / (1.0 + a * a * eps * eps) + (b * eps).atan());
                let noise: f64 = StandardNormal.sample(&mut random);
                let force = q * mu * share + sigma * noise;
                writeln!(text, "{s:.6},{q:.2},{force:.3},{v:.4}").unwrap();
            }
            files.push((set, format!("sweep{file}"), text));
        }
    }
    let sensors = if with_sigma { format!("[sensors]\nsigma = {sigma:.4}\n") } else { String::new() };
    let toml = format!(
        "schema = 1\nkind = \"creep\"\n[nominal]\nmu0 = {nominal_mu:.5}\nstiffness_n = {nominal_stiffness:.1}\nk_a = 1.0\nk_s = 0.4\n{sensors}"
    );
    Simulated { toml, files }
}

fn creep_points(layout: Layout, file: usize, holdout: bool, random: &mut Pcg64Mcg) -> Vec<(f64, f64, f64)> {
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    match layout {
        Layout::Scattered => (0..80)
            .map(|_| (10f64.powf(uniform(-3.0, -0.5)), uniform(4e3, 16e3), uniform(1.0, 25.0)))
            .collect(),
        Layout::Grid => {
            let loads = [5e3, 9e3, 14e3];
            let speed = [2.0, 6.0, 12.0, 18.0, 25.0][file] + if holdout { 1.7 } else { 0.0 };
            (0..75).map(|i| (0.0015 * 1.3f64.powi((i / 3) as i32 % 21), loads[i % 3], speed)).collect()
        }
        Layout::Sweeps => {
            let (load, speed) = (uniform(4e3, 16e3), uniform(2.0, 25.0));
            (0..80)
                .map(|i| {
                    let s = 0.001 + 0.2 * (i as f64 / 80.0).powi(2);
                    (s, load * uniform(0.97, 1.03), speed * uniform(0.98, 1.02))
                })
                .collect()
        }
    }
}
