//! A reference for pad friction on coupled trains: one Kalman filter over the whole train, whose couplers are forces within it and
//! so fall out of its balance of forces. It knows nothing of slides and of what wheelsets creep.

use std::path::Path;

use nalgebra::{DMatrix, DVector};
use railgrip_tests::Table;
use railgrip_vehicle::{GRAVITY_M_S2, VehicleParameters};

/// Time over which samples are averaged, s.
const STEP_S: f64 = 0.5;
/// Steps to each side over which the speed's slope is taken.
const REACH: usize = 3;
/// What surges of the wagons leave in that slope, one sigma, m/s².
const SLOPE_SIGMA_M_S2: f64 = 0.03;
/// Relative sigma of new pads, as the estimators have it.
const PAD_SIGMA: f64 = 0.1;
/// Relative sigma of the train's mass beside that of its wagons.
const MASS_SIGMA: f64 = 0.005;
/// Slower than this, nothing is weighed, m/s.
const LEAST_SPEED_M_S: f64 = 5.0;
/// What is further off than this is left out, sigmas.
const GATE: f64 = 6.0;

/// Pad friction of all wheelsets at an instant, front first, with sigmas.
pub(crate) struct Pads {
    pub(crate) t_s: f64,
    pub(crate) friction: Vec<f64>,
    pub(crate) sigma: Vec<f64>,
}

/// A wagon as it was recorded, in means over a step.
struct Wagon {
    vehicle: VehicleParameters,
    v_m_s: Vec<f64>,
    grade_rad: Vec<f64>,
    /// By wheelset.
    pressing_n: Vec<Vec<f64>>,
    drive_nm: Vec<Vec<f64>>,
    /// Mean of its load sensor, kg.
    load_kg: Option<f64>,
}

impl Wagon {
    fn read(folder: &Path) -> (Self, Vec<f64>) {
        let vehicle = railgrip_settings::vehicle::load(&folder.join("vehicle.toml")).expect("a vehicle");
        let run = Table::read(&folder.join("run.csv"));
        let times = run.column("t_s");
        let rows = (STEP_S / (times[1] - times[0])).round() as usize;
        let means = |name: &str| -> Option<Vec<f64>> {
            run.names()
                .iter()
                .any(|known| known == name)
                .then(|| run.column(name).chunks_exact(rows).map(mean).collect())
        };
        let steps = times.len() / rows;
        let nothing = || vec![0.0; steps];
        let of = |before: &str, after: &str| -> Vec<Vec<f64>> {
            let name = |k: usize| match vehicle.wheelsets() {
                2 => format!("{before}{}{after}", ["f", "r"][k]),
                _ => format!("{before}{}{after}", k + 1),
            };
            let numbered = |k: usize| format!("{before}{}{after}", k + 1);
            let column = |k| means(&name(k)).or_else(|| means(&numbered(k)));
            (0..vehicle.wheelsets()).map(|k| column(k).unwrap_or_else(nothing)).collect()
        };
        let wagon = Self {
            v_m_s: means("v_m_s").unwrap_or_else(|| vec![f64::NAN; steps]),
            grade_rad: means("grade_rad").unwrap_or_else(nothing),
            pressing_n: of("f_perp_", "_n"),
            drive_nm: of("m_w_", "_nm"),
            load_kg: means("load_kg").map(|loads| mean(&loads)).filter(|load| load.is_finite()),
            vehicle,
        };
        (wagon, times.chunks_exact(rows).map(|times| times[0]).collect())
    }

    fn mass_kg(&self) -> f64 {
        self.load_kg.unwrap_or(self.vehicle.body.mass_kg)
    }

    /// One sigma of its mass, kg.
    fn mass_sigma_kg(&self) -> f64 {
        let of_file = self.vehicle.body.mass_sigma.unwrap_or(0.01);
        self.mass_kg() * if self.load_kg.is_some() { 0.03 } else { of_file }
    }
}

/// Mean of what was measured; NaN of nothing.
fn mean(values: &[f64]) -> f64 {
    let measured = || values.iter().filter(|value| value.is_finite());
    measured().sum::<f64>() / measured().count() as f64
}

/// Pad friction of a recorded train, instant by instant.
pub(crate) fn filter(folders: &[std::path::PathBuf]) -> Vec<Pads> {
    let (wagons, times): (Vec<Wagon>, Vec<Vec<f64>>) =
        folders.iter().map(|folder| Wagon::read(folder)).unzip();
    let times = &times[0];
    let mass_kg: f64 = wagons.iter().map(Wagon::mass_kg).sum();
    let mass_sigma = wagons.iter().map(|wagon| wagon.mass_sigma_kg().powi(2)).sum::<f64>().sqrt() / mass_kg;
    let rotating_kg: f64 = wagons
        .iter()
        .map(|w| {
            w.vehicle.wheelsets() as f64 * w.vehicle.wheelset.inertia_kg_m2
                / w.vehicle.wheelset.radius_m.powi(2)
        })
        .sum();
    let nominal: Vec<f64> = wagons
        .iter()
        .flat_map(|wagon| wagon.vehicle.pad_friction().into_iter().take(wagon.vehicle.wheelsets()))
        .collect();
    let pads = nominal.len();
    // Pad frictions, then by how much the train is heavier than its files.
    let mut x = DVector::from_iterator(pads + 1, nominal.iter().copied().chain([0.0]));
    let sigmas = nominal.iter().map(|friction| PAD_SIGMA * friction).chain([mass_sigma.hypot(MASS_SIGMA)]);
    let mut p = DMatrix::from_diagonal(&DVector::from_iterator(pads + 1, sigmas.map(|sigma| sigma.powi(2))));
    let speed = |k: usize| mean(&wagons.iter().map(|wagon| wagon.v_m_s[k]).collect::<Vec<f64>>());
    let mut told = Vec::new();
    for k in REACH..times.len().saturating_sub(REACH) {
        let v = speed(k);
        let span = || k - REACH..=k + REACH;
        let around = |values: &[f64]| mean(&values[k - REACH..=k + REACH]);
        let slope = (speed(k + REACH) - speed(k - REACH)) / (2.0 * REACH as f64 * STEP_S);
        if v > LEAST_SPEED_M_S && slope.is_finite() && span().all(|k| speed(k).is_finite()) {
            let levers = wagons.iter().flat_map(|wagon| {
                let lever = wagon.vehicle.brake.radius_m / wagon.vehicle.wheelset.radius_m;
                wagon.pressing_n.iter().map(move |pressing| (lever, pressing))
            });
            let pressed: Vec<f64> = levers.map(|(lever, pressing)| lever * around(pressing)).collect();
            let other: f64 = wagons
                .iter()
                .map(|wagon| {
                    let drive: f64 = wagon.drive_nm.iter().map(|torque| around(torque)).sum();
                    let r = &wagon.vehicle.resistance;
                    let resistance = r.constant_n + r.linear_n_s_per_m * v + r.drag_n_s2_per_m2 * v * v;
                    let grade = wagon.mass_kg() * GRAVITY_M_S2 * around(&wagon.grade_rad);
                    drive / wagon.vehicle.wheelset.radius_m - resistance - grade
                })
                .sum();
            let whole_kg = (mass_kg + rotating_kg) * (1.0 + x[pads]);
            let braking: f64 = pressed.iter().zip(x.iter()).map(|(force, friction)| force * friction).sum();
            let predicted = (other - braking) / whole_kg;
            let row = pressed.iter().map(|force| -force / whole_kg).chain([-predicted / (1.0 + x[pads])]);
            let h = DVector::from_iterator(pads + 1, row);
            // Slopes of neighbouring steps share most of their samples.
            let noise = SLOPE_SIGMA_M_S2.powi(2) * 2.0 * REACH as f64;
            let variance = h.dot(&(&p * &h)) + noise;
            let innovation = slope - predicted;
            if innovation.abs() < GATE * variance.sqrt() && innovation.is_finite() {
                let gain = &p * &h / variance;
                x += &gain * innovation;
                p -= &gain * gain.transpose() * variance;
            }
        }
        told.push(Pads {
            // The slope reaches ahead of the step; so much later it was known.
            t_s: times[k + REACH] + STEP_S,
            friction: x.iter().take(pads).copied().collect(),
            sigma: (0..pads).map(|i| p[(i, i)].max(0.0).sqrt()).collect(),
        });
    }
    told
}
