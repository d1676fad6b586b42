//! Derivatives of the models against central differences, at random states of rolling and sliding.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]

use nalgebra::{SMatrix, SVector};
use railgrip_filter::models::{PaperInput, PaperModel, StepInput, WagonPhysics};
use railgrip_vehicle::{VehicleParameters, WagonModel};
use rand::{RngExt, SeedableRng};

fn vehicle(wheelsets: usize) -> VehicleParameters {
    let positions = match wheelsets {
        4 => "wheelset_positions_m = [9.5, 7.0, -7.0, -9.5]",
        _ => "",
    };
    toml::from_str(&format!(
        "schema = 1\nname = \"test\"\n[body]\nmass_kg = 45000.0\ncom_height_m = 1.7\nwheelbase_m = 11.0\n{positions}\n\
         [wheelset]\nradius_m = 0.45\ninertia_kg_m2 = 200.0\n[brake]\nradius_m = 0.25\nfriction_coefficient = 0.35\n\
         [resistance]\nconstant_n = 500.0\nlinear_n_s_per_m = 10.0\ndrag_n_s2_per_m2 = 4.0\n\
         [contact]\nstiffness_n = 6.0e6\nk_a = 1.0\nk_s = 0.4\n[rail]\ndry = 0.3\nwet = 0.12\nlow = 0.06\n\
         [sensors]\nsample_rate_hz = 100.0\nspeed_sigma_m_s = 0.03\nwheel_speed_sigma_rad_s = 0.03\npressing_force_sigma_n = 150.0\n"
    ))
    .unwrap()
}

/// Largest difference between `f` and central differences of `step`, relative to the row's largest entry.
fn worst<const N: usize>(
    x: &SVector<f64, N>,
    f: &SMatrix<f64, N, N>,
    scale: &SVector<f64, N>,
    step: impl Fn(&SVector<f64, N>) -> SVector<f64, N>,
) -> f64 {
    let mut worst = 0.0_f64;
    let mut numeric = SMatrix::<f64, N, N>::zeros();
    for column in 0..N {
        let h = 1e-5 * scale[column];
        let (mut up, mut down) = (*x, *x);
        up[column] += h;
        down[column] -= h;
        numeric.set_column(column, &((step(&up) - step(&down)) / (2.0 * h)));
    }
    for row in 0..N {
        for column in 0..N {
            let size = (0..N).map(|c| (f[(row, c)] * scale[c]).abs()).fold(0.0, f64::max);
            let difference = (f[(row, column)] - numeric[(row, column)]).abs() * scale[column];
            worst = worst.max(difference / size);
        }
    }
    worst
}

fn check_default<const W: usize, const N: usize>() {
    let physics = WagonPhysics::<W>::new(&WagonModel::new(&vehicle(W)).unwrap());
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(11);
    let mut scale = SVector::<f64, N>::repeat(0.1);
    (0..=W).for_each(|i| scale[i] = 10.0);
    let mut largest = 0.0_f64;
    for trial in 0..300 {
        let mut uniform = |low: f64, high: f64| random.random_range(low..high);
        let mut x = SVector::<f64, N>::zeros();
        x[0] = uniform(1.0, 50.0);
        for i in 0..W {
            x[1 + i] = x[0] / 0.45 * uniform(0.5, 1.05);
            x[1 + W + i] = uniform(-0.2, 0.1);
            x[3 + 2 * W + i] = uniform(0.2, 0.5);
        }
        x[1 + 2 * W] = uniform(-0.02, 0.02);
        x[2 + 2 * W] = uniform(-2.0, 2.0);
        x[3 + 4 * W] = uniform(-0.02, 0.02);
        x[4 + 4 * W] = uniform(-0.2, 0.2);
        x[5 + 4 * W] = uniform(-1.0, 1.0);
        let rolling = trial % 2 == 0;
        let input = StepInput::<W> {
            dt_s: uniform(0.001, 0.05),
            torque_per_friction_nm: std::array::from_fn(|_| uniform(0.0, 3e4)),
            late_torque_nm: std::array::from_fn(|_| uniform(-5e3, 5e3)),
            drive_torque_nm: std::array::from_fn(|_| uniform(-1e3, 8e3)),
            other_force_n: uniform(-3e3, 3e3),
            wind_m_s: uniform(-5.0, 5.0),
            disturbance_m_s2: 0.01,
            lag_kept: 0.9,
            disturbance_kept: 0.99,
            relaxation_per_s: std::array::from_fn(|_| {
                if rolling { uniform(50.0, 900.0) } else { uniform(0.0, 2.0) }
            }),
            relaxation_per_slope: std::array::from_fn(|_| if rolling { 0.0 } else { uniform(0.0, 8.0) }),
        };
        let (_, f) = physics.propagate(&x, &input);
        largest = largest.max(worst(&x, &f, &scale, |x| physics.propagate(x, &input).0));
    }
    println!("default filter, {W} wheelsets: derivative within {largest:.1e} of central differences");
    assert!(largest < 1e-6);
}

#[test]
fn default_model_derivative_is_right() {
    check_default::<2, 14>();
    check_default::<4, 22>();
}

#[test]
fn paper_model_derivative_is_right() {
    let physics = WagonPhysics::<2>::new(&WagonModel::new(&vehicle(2)).unwrap());
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(12);
    let scale = SVector::<f64, 6>::from([10.0, 10.0, 10.0, 0.1, 0.1, 0.1]);
    for drop_adhesion_load in [false, true] {
        let model = PaperModel::<2, 6> { physics: physics.clone(), drop_adhesion_load };
        for _ in 0..300 {
            let mut uniform = |low: f64, high: f64| random.random_range(low..high);
            let v = uniform(1.0, 50.0);
            let x = SVector::from([
                v / 0.45,
                v / 0.5,
                v,
                uniform(0.2, 0.5),
                uniform(0.2, 0.5),
                uniform(-0.3, 0.2),
            ]);
            let input = PaperInput {
                dt_s: 0.01,
                torque_per_friction_nm: [uniform(0.0, 3e4), uniform(0.0, 3e4)],
                drive_torque_nm: [uniform(0.0, 5e3), 0.0],
                other_force_n: uniform(-3e3, 3e3),
                wind_m_s: uniform(-5.0, 5.0),
            };
            let (_, f) = model.propagate(&x, &input);
            let worst = worst(&x, &f, &scale, |x| model.propagate(x, &input).0);
            assert!(worst < 1e-7, "{worst}");
        }
    }
}
