use super::*;
use nalgebra::{Matrix3, Vector2, Vector3};

fn belief() -> SquareRootBelief<3> {
    let root = Matrix3::new(1.0, 0.0, 0.0, 0.3, 0.8, 0.0, -0.2, 0.5, 1.7);
    SquareRootBelief { mean: Vector3::new(1.0, -2.0, 0.5), root }
}

/// The transform as the books write it, with full covariances and all weights.
fn textbook<const M: usize>(
    belief: &SquareRootBelief<3>,
    spread: &Spread,
    f: impl Fn(&Vector3<f64>) -> SVector<f64, M>,
) -> (SVector<f64, M>, SMatrix<f64, M, M>) {
    let reach = spread.reach_squared(3).sqrt();
    let mut points = vec![f(&belief.mean)];
    for sign in [1.0, -1.0] {
        for i in 0..3 {
            points.push(f(&(belief.mean + belief.root.column(i) * (sign * reach))));
        }
    }
    let outer = spread.outer_weight(3);
    let mut mean = points[0] * spread.central_mean_weight(3);
    points[1..].iter().for_each(|point| mean += point * outer);
    let mut covariance =
        (points[0] - mean) * (points[0] - mean).transpose() * spread.central_covariance_weight(3);
    for point in &points[1..] {
        covariance += (point - mean) * (point - mean).transpose() * outer;
    }
    (mean, covariance)
}

fn bent(x: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(x[0] + 0.4 * x[1] * x[1], (0.7 * x[2]).sin() + x[0], x[2] * x[0] - 0.3 * x[1])
}

#[test]
fn prediction_is_the_textbooks_for_wide_and_narrow_spreads() {
    let noise = Vector3::new(0.1, 0.2, 0.05);
    for (alpha, tolerance) in [(1.0, 1e-12), (0.1, 1e-11), (1e-3, 1e-6)] {
        let spread = Spread::new(alpha, 2.0, 0.0).unwrap();
        let (mean, mut covariance) = textbook(&belief(), &spread, bent);
        covariance += Matrix3::from_diagonal(&noise.component_mul(&noise));
        let mut ours = belief();
        ours.predict(&spread, &noise, bent);
        let error = (ours.covariance() - covariance).norm() / covariance.norm();
        println!("α = {alpha}: relative difference of covariance {error:.1e}");
        assert!(error < tolerance && (ours.mean - mean).norm() < 1e3 * tolerance);
    }
}

#[test]
fn a_linear_model_gives_the_kalman_filter() {
    let f = Matrix3::new(1.0, 0.1, -0.4, 0.0, 0.9, 0.2, 0.1, 0.0, 1.0);
    let q = Vector3::new(0.1, 0.2, 0.3);
    let (mut ours, mut joint) = (belief(), belief());
    let mut kalman = belief().gaussian();
    for k in 0..50 {
        let measured = Vector2::new((f64::from(k) * 0.3).sin(), 0.2);
        kalman.predict(f * kalman.mean, &f, &Matrix3::from_diagonal(&q.component_mul(&q)));
        for belief in [&mut ours, &mut joint] {
            belief.predict(&Spread::default(), &q, |x| f * x);
        }
        let sigma = Vector2::new(0.05, 0.7);
        let h = SMatrix::<f64, 2, 3>::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let r = SMatrix::<f64, 2, 2>::from_diagonal(&sigma.component_mul(&sigma));
        let by_kalman = kalman.update(measured - h * kalman.mean, &h, &r).unwrap();
        let by_joint = joint.update(&Spread::default(), &measured, &sigma, |x| h * x).unwrap();
        let mut nis = 0.0;
        for (slot, index) in [0, 2].into_iter().enumerate() {
            let update = ours.expect_component(index, measured[slot], r[(slot, slot)]);
            nis += update.nis();
            ours.update_component(index, &update, r[(slot, slot)]);
        }
        assert!(
            (nis / by_kalman.nis - 1.0).abs() < 1e-6 && (by_joint.nis / by_kalman.nis - 1.0).abs() < 1e-6
        );
    }
    for belief in [ours, joint] {
        assert!((belief.mean - kalman.mean).norm() < 1e-7, "{}", (belief.mean - kalman.mean).norm());
        assert!((belief.covariance() - kalman.covariance).norm() < 1e-8);
    }
}

#[test]
fn a_bent_measurement_is_the_textbooks() {
    let spread = Spread::new(0.5, 2.0, 0.0).unwrap();
    let h = |x: &Vector3<f64>| Vector2::new(x[0] * x[0] + x[1], x[2].exp());
    let (mean, mut covariance) = textbook(&belief(), &spread, h);
    covariance += SMatrix::<f64, 2, 2>::new(0.01, 0.0, 0.0, 0.04);
    let mut ours = belief();
    let update = ours.update(&spread, &Vector2::new(0.3, 1.0), &Vector2::new(0.1, 0.2), h).unwrap();
    assert!((update.innovation_covariance - covariance).norm() < 1e-10 * covariance.norm());
    assert!((Vector2::new(0.3, 1.0) - update.innovation - mean).norm() < 1e-11);
    assert!(ours.is_sound() && ours.sigma(2) < belief().sigma(2));
}

#[test]
fn nees_of_a_truth_one_sigma_away_is_one() {
    let belief = belief();
    let truth = belief.mean + belief.root.column(1);
    assert!((belief.nees(&truth) - 1.0).abs() < 1e-12);
}

#[test]
fn forgetting_a_component_leaves_the_others() {
    let mut ours = belief();
    ours.forget_component(1, 7.0, 3.0);
    let (before, after) = (belief().covariance(), ours.covariance());
    assert!((after[(0, 2)] - before[(0, 2)]).abs() < 1e-14 && (after[(2, 2)] - before[(2, 2)]).abs() < 1e-14);
    assert!(after[(0, 1)].abs() < 1e-14 && (after[(1, 1)] - 9.0).abs() < 1e-13);
    assert!(ours.mean[1] == 7.0 && ours.is_sound());
}
