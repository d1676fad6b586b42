//! The roller rig's experiments meet the paper's criteria.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // in functions that the tests share

use nalgebra::{SMatrix, SVector, Vector4};
use railgrip_experiments::roller::filter::Tuning;
use railgrip_experiments::roller::rig::{SAMPLE_PERIOD_S, Test, nominal_model};
use railgrip_filter::core::{Gaussian, chi_square_mean_band};
use railgrip_filter::models::{PaperInput, RigModel, WagonPhysics};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

fn run(name: &str) {
    let directory = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let start = std::time::Instant::now();
    let report = railgrip_experiments::find(name).unwrap().run_into(&directory).unwrap();
    println!("{}\n{:.1} s", report.markdown(name), start.elapsed().as_secs_f64());
    assert!(report.all_met());
}

#[test]
fn adhesion_is_followed_through_slide_protection() {
    run("schwarz-wsp");
}

#[test]
fn adhesion_is_followed_while_sanding() {
    run("schwarz-sanding");
}

#[test]
fn wheel_speed_must_be_trusted_where_the_branch_reverses() {
    run("schwarz-noise");
}

#[test]
fn multiple_models_and_smoothing_go_beyond_the_paper() {
    run("schwarz-beyond");
}

/// NEES and NIS of the 4-state filter whose model the truth obeys, noise included: means over seeds.
fn consistency(tuning: &Tuning, seeds: u64) -> (f64, f64) {
    let physics = WagonPhysics::new(&nominal_model(Test::SlideProtection));
    let model = RigModel { physics, drop_adhesion_load: false };
    let q = SVector::from(tuning.q) * SAMPLE_PERIOD_S;
    let sigma0 = Vector4::new(0.05, 0.02, 0.03, 0.02);
    let start = Vector4::new(50.0, 25.0, 0.33, -0.04);
    let steps = 300;
    let (mut nees, mut nis) = (0.0, 0.0);
    for seed in 0..seeds {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut belief = Gaussian::independent(start, &sigma0);
        let mut truth = start + Vector4::from_fn(|i, _| sigma0[i] * normal());
        for k in 0..steps {
            let force_n = if k % 100 < 50 { 1.5e4 } else { 6e3 };
            let input = PaperInput {
                dt_s: SAMPLE_PERIOD_S,
                torque_per_friction_nm: [force_n * model.physics.brake_radius_m],
                drive_torque_nm: [0.0],
                other_force_n: 0.0,
                wind_m_s: 0.0,
            };
            truth = model.propagate(&truth, &input).0 + Vector4::from_fn(|i, _| q[i].sqrt() * normal());
            let (next, f) = model.propagate(&belief.mean, &input);
            belief.predict(next, &f, &SMatrix::from_diagonal(&q));
            for index in 0..2 {
                let r = tuning.r[index];
                let update = belief.expect_component(index, truth[index] + r.sqrt() * normal(), r);
                nis += update.nis() / (steps as f64 * seeds as f64);
                belief.update_component(index, &update, r);
            }
        }
        let error = truth - belief.mean;
        nees += error.dot(&belief.covariance.cholesky().unwrap().solve(&error)) / seeds as f64;
    }
    (nees, nis)
}

#[test]
fn the_4_state_filter_is_as_accurate_as_it_says() {
    const SEEDS: u64 = 100;
    let service = Tuning { q: [1e-1, 1e-5, 1e-4, 1e-2], r: [9e-4, 9e-4] };
    for (name, tuning) in [("(20)", Tuning::PAPER), ("service", service)] {
        let (nees, nis) = consistency(&tuning, SEEDS);
        let nees_band = chi_square_mean_band(4.0, SEEDS as f64, 3.0);
        let nis_band = chi_square_mean_band(2.0, SEEDS as f64 * 300.0, 3.5);
        println!("{name}: NEES {nees:.3} in {nees_band:?}, NIS {nis:.4} in {nis_band:?}");
        assert!(nees_band.holds(nees) && nis_band.holds(nis));
    }
}
