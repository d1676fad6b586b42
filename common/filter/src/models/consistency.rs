//! Are the filters of Schwarz & Keck's equations as accurate as they say? The truth obeys each filter's own model, its
//! process noise and its sensors' noise drawn from 60 seeds, so that nothing but the filter can be at fault: NEES and
//! NIS must lie where χ² puts them.

use super::imm::ImmFilter;
use super::paper::PaperFilter;
use super::{DrivenSample, WagonFilter, WagonPhysics};
use crate::EstimatorConfig;
use crate::core::{Gaussian, chi_square_mean_band};
use nalgebra::SVector;
use railgrip_vehicle::{VehicleParameters, WagonModel};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

const SEEDS: u64 = 60;
const STEPS: usize = 500;
const DT_S: f64 = 0.01;

fn vehicle() -> VehicleParameters {
    toml::from_str(
        "schema = 1\nname = \"plant\"\n[body]\nmass_kg = 45000.0\ncom_height_m = 1.6\nwheelbase_m = 11.0\n\
         [wheelset]\nradius_m = 0.45\ninertia_kg_m2 = 180.0\n[brake]\nradius_m = 0.25\nfriction_coefficient = 0.35\n\
         [resistance]\nconstant_n = 450.0\nlinear_n_s_per_m = 9.0\ndrag_n_s2_per_m2 = 4.0\n\
         [contact]\nstiffness_n = 6.5e6\nk_a = 1.0\nk_s = 0.4\n[rail]\ndry = 0.3\nwet = 0.12\nlow = 0.06\n\
         [sensors]\nsample_rate_hz = 100.0\nspeed_sigma_m_s = 0.03\nwheel_speed_sigma_rad_s = 0.03\npressing_force_sigma_n = 150.0\n",
    )
    .unwrap()
}

fn normals(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    move || StandardNormal.sample(&mut random)
}

/// Both pads pressed, now hard, now less: pad friction is observable all the time.
fn sample(step: usize, wheelsets: usize) -> DrivenSample {
    let force_n = if step % 200 < 100 { 3e4 } else { 1.5e4 };
    let mut sample = DrivenSample { v_m_s: 30.0, ..DrivenSample::default() };
    for i in 0..wheelsets {
        sample.wheel_speed_rad_s[i] = 30.0 / 0.45;
        sample.pressing_force_n[i] = force_n;
        sample.step_force_n[i] = force_n;
    }
    sample
}

/// A truth drawn from a belief.
fn draw<const N: usize>(belief: &Gaussian<N>, normal: &mut impl FnMut() -> f64) -> SVector<f64, N> {
    let root = belief.covariance.cholesky().unwrap().l();
    belief.mean + root * SVector::<f64, N>::from_fn(|_, _| normal())
}

fn nees<const N: usize>(belief: &Gaussian<N>, truth: &SVector<f64, N>) -> f64 {
    let error = truth - belief.mean;
    error.dot(&belief.covariance.cholesky().unwrap().solve(&error))
}

/// Measures the truth with the noise of the sensors; NIS over all outputs.
fn measure<F: WagonFilter, const N: usize>(
    filter: &mut F,
    truth: &SVector<f64, N>,
    index: impl Fn(usize) -> usize,
    wheelsets: usize,
    normal: &mut impl FnMut() -> f64,
) -> f64 {
    let mut nis = 0.0;
    for output in 0..=wheelsets {
        let update = filter.expect(output, truth[index(output)] + 0.03 * normal());
        nis += update.nis();
        filter.accept(output, &update);
    }
    nis
}

/// Means over the seeds: NEES at the end of a run, NIS over the run.
fn of_paper<const W: usize, const N: usize>() -> (f64, f64) {
    let physics = WagonPhysics::<W>::new(&WagonModel::new(&vehicle()).unwrap());
    let (mut nees_sum, mut nis_sum) = (0.0, 0.0);
    for seed in 0..SEEDS {
        let mut normal = normals(seed);
        let mut filter = PaperFilter::<W, N>::new(&EstimatorConfig::default(), &vehicle(), physics.clone());
        filter.start(&sample(0, W));
        let mut truth = draw(&filter.belief, &mut normal);
        for step in 0..STEPS {
            let sample = sample(step, W);
            let input = filter.step_input(&sample, DT_S);
            let sigma = (filter.q_per_s * DT_S).map(f64::sqrt);
            truth = filter.model.propagate(&truth, &input).0 + sigma.map(|sigma| sigma * normal());
            filter.predict_step(&input);
            nis_sum += measure(&mut filter, &truth, PaperFilter::<W, N>::index, W, &mut normal);
        }
        nees_sum += nees(&filter.belief, &truth);
    }
    (nees_sum / SEEDS as f64, nis_sum / (SEEDS as f64 * STEPS as f64))
}

fn assert_bands(name: &str, states: usize, outputs: usize, (nees, nis): (f64, f64)) {
    let nees_band = chi_square_mean_band(states as f64, SEEDS as f64, 3.0);
    let nis_band = chi_square_mean_band(outputs as f64, SEEDS as f64 * STEPS as f64, 3.5);
    println!("{name}: NEES {nees:.3} in {nees_band:?}, NIS {nis:.4} in {nis_band:?} over {SEEDS} seeds");
    assert!(nees_band.holds(nees) && nis_band.holds(nis), "{name}");
}

#[test]
fn paper_and_rig_are_as_accurate_as_they_say() {
    assert_bands("paper, two wheelsets", 6, 3, of_paper::<2, 6>());
    assert_bands("rig", 4, 2, of_paper::<1, 4>());
}

/// The truth jumps between the modes as the filter believes it does. A mixture is no Gaussian: what must hold is that
/// its mean and covariance are right (E[NEES] = N, E[NIS] = outputs), not the spread of χ². The bands are therefore
/// those of the scatter between seeds, 3.5 standard errors; and because merging beliefs after every step is an
/// approximation, 5 % are allowed beside.
#[test]
fn imm_is_as_accurate_as_it_says() {
    let physics = WagonPhysics::<2>::new(&WagonModel::new(&vehicle()).unwrap());
    let (mut all_nees, mut all_nis) = (Vec::new(), Vec::new());
    for seed in 0..SEEDS {
        let mut normal = normals(1000 + seed);
        let mut jumps = Pcg64Mcg::seed_from_u64(seed);
        let mut filter = ImmFilter::<2, 6>::new(&EstimatorConfig::default(), &vehicle(), physics.clone());
        filter.start(&sample(0, 2));
        let mut truth = draw(&filter.base.belief, &mut normal);
        let mut mode = jumps.random_range(0..4_usize);
        let (mut nees_sum, mut nis_sum, mut judged) = (0.0, 0.0, 0.0);
        for step in 0..STEPS {
            let sample = sample(step, 2);
            let change = filter.change_shares(DT_S);
            for (bit, share) in [(1, change[0]), (2, change[1])] {
                mode ^= if jumps.random_range(0.0..1.0) < share { bit } else { 0 };
            }
            filter.predict(&sample, DT_S);
            let input = filter.input(&sample, DT_S, mode);
            let sigma = (filter.q_per_s[mode & 1] * DT_S).map(f64::sqrt);
            truth = filter.base.model.propagate(&truth, &input).0 + sigma.map(|sigma| sigma * normal());
            let nis = measure(&mut filter, &truth, PaperFilter::<2, 6>::index, 2, &mut normal);
            if step >= 50 {
                judged += 1.0;
                nis_sum += nis;
                nees_sum += nees(&filter.base.belief, &truth);
            }
        }
        all_nees.push(nees_sum / judged);
        all_nis.push(nis_sum / judged);
    }
    for (name, expected, values) in [("NEES", 6.0, &all_nees), ("NIS", 3.0, &all_nis)] {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let spread = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let reach = 3.5 * (spread / count).sqrt() + 0.05 * expected;
        println!("imm {name}: {mean:.3}, expected {expected} ± {reach:.3} over {count} seeds");
        assert!((mean - expected).abs() < reach, "imm {name} {mean}");
    }
}
