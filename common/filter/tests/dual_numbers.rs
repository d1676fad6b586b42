//! Derivatives of the models against dual numbers: the equations are written down a second time here, in numbers that
//! carry their derivative, and must give the same values and the same Jacobian.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]

use nalgebra::{SMatrix, SVector};
use num_dual::{Dual64, DualNum};
use railgrip_filter::models::bogie_rig::{BogieModel, BogieNoise, BogieVector, STATES, index};
use railgrip_filter::models::{PaperInput, PaperModel, StepInput, WagonPhysics};
use railgrip_vehicle::{Resistance, VehicleParameters, WagonModel};
use rand::{RngExt, SeedableRng};

fn vehicle(wheelsets: usize) -> VehicleParameters {
    let positions = if wheelsets == 4 { "wheelset_positions_m = [9.5, 7.0, -7.0, -9.5]" } else { "" };
    toml::from_str(&format!(
        "schema = 1\nname = \"test\"\n[body]\nmass_kg = 45000.0\ncom_height_m = 1.7\nwheelbase_m = 11.0\n{positions}\n\
         [wheelset]\nradius_m = 0.45\ninertia_kg_m2 = 200.0\n[brake]\nradius_m = 0.25\nfriction_coefficient = 0.35\n\
         [resistance]\nconstant_n = 500.0\nlinear_n_s_per_m = 10.0\ndrag_n_s2_per_m2 = 4.0\n\
         [contact]\nstiffness_n = 6.0e6\nk_a = 1.0\nk_s = 0.4\n[rail]\ndry = 0.3\nwet = 0.12\nlow = 0.06\n\
         [sensors]\nsample_rate_hz = 100.0\nspeed_sigma_m_s = 0.03\nwheel_speed_sigma_rad_s = 0.03\npressing_force_sigma_n = 150.0\n"
    ))
    .unwrap()
}

/// Resistance of a moving wagon against the airspeed, N.
fn resistance(law: &Resistance, v: Dual64, wind: f64) -> Dual64 {
    let air = v + wind;
    v * law.linear_n_s_per_m + air * air * law.drag_n_s2_per_m2 * air.re.signum() + law.constant_n
}

/// (12) with the exact load, or with the term dropped as in the paper.
fn paper<const W: usize, const N: usize>(
    model: &PaperModel<W, N>,
    x: &[Dual64],
    u: &PaperInput<W>,
) -> Vec<Dual64> {
    let physics = &model.physics;
    let (v, adhesion) = (x[W], x[2 * W + 1]);
    let weight: f64 = physics.loads.static_load_n.iter().sum();
    let track = -resistance(&physics.resistance, v, u.wind_m_s) + u.other_force_n;
    let acceleration = (adhesion * weight + track) / physics.mass_kg;
    let carried = if model.drop_adhesion_load { track / physics.mass_kg } else { acceleration };
    let mut next = x.to_vec();
    next[W] = v + acceleration * u.dt_s;
    for i in 0..W {
        let load = carried * physics.loads.transfer_kg[i] + physics.loads.static_load_n[i];
        let torque = -x[W + 1 + i] * u.torque_per_friction_nm[i] + u.drive_torque_nm[i]
            - adhesion * load * physics.wheel_radius_m[i];
        next[i] = x[i] + torque / physics.inertia_kg_m2[i] * u.dt_s;
    }
    next
}

/// The step of the default filter: adhesions relax exactly towards what the torque balance asks for.
fn default_step<const W: usize>(physics: &WagonPhysics<W>, x: &[Dual64], u: &StepInput<W>) -> Vec<Dual64> {
    let (wheel, adhesion, pad, dt) = (1, 1 + W, 3 + 2 * W, u.dt_s);
    let (lag, disturbance, mass, slope, delay) = (1 + 2 * W, 2 + 2 * W, 3 + 4 * W, 4 + 4 * W, 5 + 4 * W);
    let acceleration = |adhesions: &[Dual64]| {
        let mut force = -resistance(&physics.resistance, x[0], u.wind_m_s) + u.other_force_n;
        let mut inertia = Dual64::from(physics.mass_kg);
        for i in 0..W {
            force += adhesions[i] * physics.loads.static_load_n[i];
            inertia -= adhesions[i] * physics.loads.transfer_kg[i];
        }
        force / inertia
    };
    let mut next = x.to_vec();
    let pure = acceleration(&x[adhesion..adhesion + W]);
    let unknown = x[disturbance] * u.disturbance_m_s2;
    let (mut mean, mut turn) = (Vec::new(), Vec::new());
    for i in 0..W {
        let (radius, inertia) = (physics.wheel_radius_m[i], physics.inertia_kg_m2[i]);
        let load = (pure * physics.loads.transfer_kg[i] + physics.loads.static_load_n[i]) * (x[mass] + 1.0);
        let brake = x[pad + i] * (-x[delay] * u.late_torque_nm[i] + u.torque_per_friction_nm[i]);
        let torque = -brake + u.drive_torque_nm[i] - (pure + unknown) * (inertia / radius);
        let target = torque / (load * radius) + x[lag];
        let apart = x[adhesion + i] - target;
        let exponent = (x[slope] * u.relaxation_per_slope[i] + u.relaxation_per_s[i]) * dt;
        let kept = (-exponent).exp();
        let share = if exponent.re.abs() < 1e-4 { -exponent * 0.5 + 1.0 } else { (-kept + 1.0) / exponent };
        next[adhesion + i] = target + apart * kept;
        mean.push(target + apart * share);
        turn.push(load * apart * share * (-dt * radius / inertia));
    }
    next[0] = x[0] + (acceleration(&mean) + unknown) * dt;
    for i in 0..W {
        next[wheel + i] = x[wheel + i] + (next[0] - x[0]) / physics.wheel_radius_m[i] + turn[i];
    }
    next[lag] = x[lag] * u.lag_kept;
    next[disturbance] = x[disturbance] * u.disturbance_kept;
    next
}

/// Worst disagreement of values and of derivatives, each relative to the largest term of its row.
fn worst<const N: usize>(
    x: &SVector<f64, N>,
    (next, f): (SVector<f64, N>, SMatrix<f64, N, N>),
    scale: &SVector<f64, N>,
    step: impl Fn(&[Dual64]) -> Vec<Dual64>,
) -> f64 {
    let mut worst = 0.0_f64;
    for column in 0..N {
        let seeded: Vec<Dual64> =
            (0..N).map(|i| Dual64::new(x[i], if i == column { 1.0 } else { 0.0 })).collect();
        let dual = step(&seeded);
        for row in 0..N {
            let size = (0..N).map(|c| (f[(row, c)] * scale[c]).abs()).fold(0.0, f64::max);
            worst = worst.max((f[(row, column)] - dual[row].eps).abs() * scale[column] / size);
            worst = worst.max((next[row] - dual[row].re).abs() / scale[row]);
        }
    }
    worst
}

fn check_default<const W: usize, const N: usize>() {
    let physics = WagonPhysics::<W>::new(&WagonModel::new(&vehicle(W)).unwrap());
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(21);
    let mut scale = SVector::<f64, N>::repeat(0.1);
    (0..=W).for_each(|i| scale[i] = 10.0);
    let mut largest = 0.0_f64;
    for trial in 0..300 {
        let mut uniform = |low: f64, high: f64| random.random_range(low..high);
        let mut x = SVector::<f64, N>::from_fn(|_, _| uniform(-0.02, 0.02));
        x[0] = uniform(1.0, 50.0);
        for i in 0..W {
            x[1 + i] = x[0] / 0.45 * uniform(0.5, 1.05);
            x[1 + W + i] = uniform(-0.2, 0.1);
            x[3 + 2 * W + i] = uniform(0.2, 0.5);
        }
        // Disturbance, slope and delay are states of the size of 1.
        x[2 + 2 * W] = uniform(-2.0, 2.0);
        x[4 + 4 * W] = uniform(-0.2, 0.2);
        x[5 + 4 * W] = uniform(-1.0, 1.0);
        let rolling = trial % 2 == 0;
        let input = StepInput::<W> {
            dt_s: uniform(0.001, 0.05),
            torque_per_friction_nm: std::array::from_fn(|_| uniform(0.0, 3e4)),
            late_torque_nm: std::array::from_fn(|_| uniform(-5e3, 5e3)),
            drive_torque_nm: std::array::from_fn(|_| uniform(-1e3, 8e3)),
            other_force_n: uniform(-3e3, 3e3),
            wind_m_s: uniform(-0.5, 5.0),
            disturbance_m_s2: 0.01,
            lag_kept: 0.9,
            disturbance_kept: 0.99,
            relaxation_per_s: std::array::from_fn(|_| {
                if rolling { uniform(50.0, 900.0) } else { uniform(0.0, 2.0) }
            }),
            relaxation_per_slope: std::array::from_fn(|_| if rolling { 0.0 } else { uniform(0.0, 8.0) }),
        };
        let got = physics.propagate(&x, &input);
        largest = largest.max(worst(&x, got, &scale, |x| default_step(&physics, x, &input)));
    }
    println!("default filter, {W} wheelsets: value and Jacobian within {largest:.1e} of dual numbers");
    assert!(largest < 1e-10);
}

#[test]
fn the_default_models_jacobian_is_that_of_dual_numbers() {
    check_default::<1, 10>();
    check_default::<2, 14>();
    check_default::<4, 22>();
}

fn check_paper<const W: usize, const N: usize>() {
    let physics = WagonPhysics::<W>::new(&WagonModel::new(&vehicle(W)).unwrap());
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(22);
    let mut scale = SVector::<f64, N>::repeat(0.1);
    (0..=W).for_each(|i| scale[i] = 10.0);
    let mut largest = 0.0_f64;
    for drop_adhesion_load in [false, true] {
        let model = PaperModel::<W, N> { physics: physics.clone(), drop_adhesion_load };
        for _ in 0..300 {
            let mut uniform = |low: f64, high: f64| random.random_range(low..high);
            let mut x = SVector::<f64, N>::from_fn(|_, _| uniform(0.2, 0.5));
            x[W] = uniform(1.0, 50.0);
            (0..W).for_each(|i| x[i] = x[W] / 0.45 * uniform(0.5, 1.05));
            x[2 * W + 1] = uniform(-0.3, 0.2);
            let input = PaperInput::<W> {
                dt_s: uniform(0.001, 0.05),
                torque_per_friction_nm: std::array::from_fn(|_| uniform(0.0, 3e4)),
                drive_torque_nm: std::array::from_fn(|_| uniform(-1e3, 5e3)),
                other_force_n: uniform(-3e3, 3e3),
                wind_m_s: uniform(-0.5, 5.0),
            };
            let got = model.propagate(&x, &input);
            largest = largest.max(worst(&x, got, &scale, |x| paper(&model, x, &input)));
        }
    }
    println!("paper's filter, {W} wheelsets: value and Jacobian within {largest:.1e} of dual numbers");
    assert!(largest < 1e-10);
}

#[test]
fn the_papers_models_jacobian_is_that_of_dual_numbers() {
    check_paper::<1, 4>();
    check_paper::<2, 6>();
    check_paper::<4, 10>();
}

/// (3) with inertia and loss: what the transducer and the load cell say, and how the motion goes on.
fn bogie(model: &BogieModel, x: &[Dual64], load_n: f64, dt_s: f64) -> (Dual64, Dual64, Vec<Dual64>) {
    let p = &model.parameters;
    let (speed, acceleration) = (x[index::ROLLER_SPEED], x[index::ROLLER_ACCELERATION]);
    let loss = speed * p.loss_nm_s + p.loss_nm;
    let inertia = p.roller_inertia_kg_m2 + p.gear_ratio * p.gear_ratio * p.shaft_inertia_kg_m2;
    let contact = x[index::ADHESION] * load_n * p.roller_radius_m;
    let torque = (acceleration * inertia - contact + loss) / p.gear_ratio + x[index::TORQUE_OFFSET];
    let link = -x[index::ADHESION] * load_n + x[index::LOAD_CELL_OFFSET];
    let mut next = x.to_vec();
    next[index::ROLLER_ANGLE] += (speed + acceleration * (0.5 * dt_s)) * dt_s;
    next[index::ROLLER_SPEED] += acceleration * dt_s;
    for i in 0..2 {
        next[index::WHEEL_ANGLE[i]] += x[index::WHEEL_SPEED[i]] * dt_s;
    }
    (torque, link, next)
}

#[test]
fn the_bogie_rigs_derivatives_are_those_of_dual_numbers() {
    let model = BogieModel { parameters: Default::default(), noise: BogieNoise::default() };
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(23);
    let scale = BogieVector::from([0.1, 10.0, 5.0, 0.1, 10.0, 0.1, 10.0, 0.1, 1.0, 30.0]);
    let mut largest = 0.0_f64;
    for _ in 0..300 {
        let mut uniform = |low: f64, high: f64| random.random_range(low..high);
        // In motion: the loss that fades out at standstill is no measurement of speed.
        let mut x = BogieVector::from_fn(|i, _| scale[i] * uniform(-1.0, 1.0));
        x[index::ROLLER_SPEED] = uniform(2.0, 20.0);
        let (load_n, dt_s) = (uniform(1e3, 1e4), uniform(0.001, 0.05));
        let step = |x: &[Dual64]| {
            let (torque, link, mut next) = bogie(&model, x, load_n, dt_s);
            // The measurements stand in the places of the states that a step keeps.
            (next[index::TORQUE_OFFSET], next[index::LOAD_CELL_OFFSET]) = (torque, link);
            next
        };
        let mut f = BogieModel::transition(dt_s);
        let mut next = f * x;
        f.set_row(index::TORQUE_OFFSET, &model.torque_row(load_n).transpose());
        f.set_row(index::LOAD_CELL_OFFSET, &BogieModel::load_cell_row(load_n).transpose());
        next[index::TORQUE_OFFSET] = model.torque_nm(&x, load_n);
        next[index::LOAD_CELL_OFFSET] = BogieModel::load_cell_n(&x, load_n);
        largest = largest.max(worst::<STATES>(&x, (next, f), &scale, step));
    }
    println!("bogie rig: value and derivative within {largest:.1e} of dual numbers");
    assert!(largest < 1e-10);
}
