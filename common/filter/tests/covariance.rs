//! The covariance stays symmetric and positive definite through ten million random steps: predictions of huge and tiny
//! length, updates by exact and by worthless sensors, missing data, refused data, forgotten components.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]

use nalgebra::{SMatrix, SVector};
use railgrip_filter::core::Gaussian;
use rand::{Rng, RngExt, SeedableRng};

const STEPS: usize = 10_000_000;
const STATES: usize = 4;

/// A wandering model: two states drive two others, with rates that change now and then.
fn model(random: &mut impl Rng, dt_s: f64) -> (SMatrix<f64, STATES, STATES>, SVector<f64, STATES>) {
    let mut f = SMatrix::<f64, STATES, STATES>::identity();
    for row in 0..2 {
        for column in 2..STATES {
            f[(row, column)] = dt_s.min(1.0) * random.random_range(-20.0..20.0);
        }
        f[(row, row)] = (-dt_s * random.random_range(0.0..5.0)).exp();
    }
    let q = SVector::from_fn(|row, _| dt_s * if row < 2 { 1e-4 } else { 1e-2 });
    (f, q)
}

#[test]
fn ten_million_random_steps_leave_a_sound_covariance() {
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(2020);
    let sigma = SVector::from([1.0, 1.0, 0.1, 0.1]);
    let mut belief = Gaussian::<STATES>::independent(SVector::zeros(), &sigma);
    let (mut f, mut q) = model(&mut random, 0.01);
    let mut r = 1e-3;
    let (mut refused, mut missing, mut worst) = (0_u64, 0_u64, f64::INFINITY);
    for step in 0..STEPS {
        if step % 64 == 0 {
            // From a microsecond to a quarter of an hour, from an exact to a worthless sensor.
            let dt_s = 10_f64.powf(random.random_range(-6.0..3.0));
            (f, q) = model(&mut random, dt_s);
            r = 10_f64.powf(random.random_range(-9.0..3.0));
        }
        belief.predict_leading(f * belief.mean, &f, 2, &q);
        let draw: u32 = random.random();
        if draw & 7 == 0 {
            missing += 1;
        } else {
            let component = (draw >> 3) as usize % 2;
            let noise = f64::from(draw >> 8) / 8_388_608.0 - 1.0;
            let update = belief.expect_component(component, noise, r);
            if update.nis() > 25.0 {
                refused += 1;
            } else {
                belief.update_component(component, &update, r);
            }
        }
        if draw >> 20 == 77 {
            belief.reset_component((draw & 3) as usize, 0.0, 1.0);
        }
        // A belief that grows without bound says nothing about rounding; components are bounded as a filter's priors do it.
        for i in 0..STATES {
            if belief.covariance[(i, i)] > 1e8 {
                belief.reset_component(i, 0.0, 1.0);
            }
        }
        if step % 16 == 0 {
            let p = belief.covariance;
            assert_eq!(p, p.transpose(), "symmetric at step {step}");
            let factor = p.cholesky();
            assert!(factor.is_some() && belief.is_sound(), "positive definite at step {step}: {p}");
            let scaled =
                SMatrix::<f64, STATES, STATES>::from_fn(|i, j| p[(i, j)] / (p[(i, i)] * p[(j, j)]).sqrt());
            if step % 1024 == 0 {
                worst = worst.min(scaled.symmetric_eigenvalues().min());
            }
        }
    }
    println!(
        "{STEPS} steps, {missing} without data, {refused} refused; least eigenvalue of the correlation {worst:.2e}"
    );
    assert!(missing > 1_000_000 && refused > 1_000);
    assert!(worst > 0.0);
}
