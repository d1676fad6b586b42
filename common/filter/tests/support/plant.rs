//! A small seeded wagon to try the estimator on: the vehicle model with sensor noise, no clutter.

use super::Truth;
use railgrip_filter::WagonSample;
use railgrip_vehicle::{VehicleParameters, WagonInput, WagonModel, WagonState};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// What is done to the wagon.
pub struct Order<'a> {
    pub seed: u64,
    pub start_m_s: f64,
    pub seconds: f64,
    /// Pressing force of front and rear at a time, N; the speeds of the wheelsets over that of the wagon are given, so that a
    /// slide protection can act.
    pub force_n: &'a mut dyn FnMut(f64, [f64; 2]) -> [f64; 2],
    /// Adhesion available at a time.
    pub adhesion: &'a dyn Fn(f64) -> f64,
    /// Pad friction of front and rear against nominal.
    pub pads: [f64; 2],
}

pub fn vehicle() -> VehicleParameters {
    toml::from_str(
        "schema = 1\nname = \"plant\"\n[body]\nmass_kg = 45000.0\ncom_height_m = 1.6\nwheelbase_m = 11.0\n\
         [wheelset]\nradius_m = 0.45\ninertia_kg_m2 = 180.0\n[brake]\nradius_m = 0.25\nfriction_coefficient = 0.35\n\
         [resistance]\nconstant_n = 450.0\nlinear_n_s_per_m = 9.0\ndrag_n_s2_per_m2 = 4.0\n\
         [contact]\nstiffness_n = 6.5e6\nk_a = 1.0\nk_s = 0.4\n[rail]\ndry = 0.3\nwet = 0.12\nlow = 0.06\n\
         [sensors]\nsample_rate_hz = 100.0\nspeed_sigma_m_s = 0.03\nwheel_speed_sigma_rad_s = 0.03\npressing_force_sigma_n = 150.0\n",
    )
    .unwrap()
}

/// Drives the order; samples at 100 Hz, integrated at 1 ms, until the time is over or the wagon is slower than 2 m/s.
pub fn drive(order: Order<'_>) -> (Vec<WagonSample>, Vec<Truth>) {
    let vehicle = vehicle();
    let model = WagonModel::new(&vehicle).unwrap();
    let radius_m = vehicle.wheelset.radius_m;
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(order.seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let wheel = order.start_m_s / radius_m;
    let mut state = WagonState { v_m_s: order.start_m_s, wheel_speed_rad_s: [wheel, wheel, 0.0, 0.0] };
    let (mut inputs, mut truths, mut acceleration) = (Vec::new(), Vec::new(), 0.0);
    for sample in 0..(order.seconds * 100.0) as usize {
        for sub in 0..10 {
            let time_s = 0.01 * sample as f64 + 0.001 * f64::from(sub);
            let ratio = [0, 1].map(|i| radius_m * state.wheel_speed_rad_s[i] / state.v_m_s.max(0.5));
            let [front, rear] = (order.force_n)(time_s, ratio);
            let input = WagonInput {
                time_s,
                pressing_force_n: [front, rear, 0.0, 0.0],
                adhesion_peak: [(order.adhesion)(time_s); 4],
                brake_friction_factor: [order.pads[0], order.pads[1], 1.0, 1.0],
                ..WagonInput::default()
            };
            let loading = model.loading(&model.operating(&state, &input), &input, 0.001, &[]);
            if sub == 0 {
                let forces = model.forces(&state, &loading);
                let pad = |i: usize| 0.35 * order.pads[i];
                truths.push(Truth {
                    v_m_s: state.v_m_s,
                    mu_w: forces.wagon_adhesion_utilised(),
                    mu_w_wheelset: [forces.adhesion_utilised(0), forces.adhesion_utilised(1)],
                    mu_b: [pad(0), pad(1)],
                });
                inputs.push(WagonSample {
                    v_m_s: state.v_m_s + 0.03 * normal(),
                    wheel_speed_rad_s: [
                        state.wheel_speed_rad_s[0] + 0.03 * normal(),
                        state.wheel_speed_rad_s[1] + 0.03 * normal(),
                        f64::NAN,
                        f64::NAN,
                    ],
                    pressing_force_n: [
                        (front + 150.0 * normal()).max(0.0),
                        (rear + 150.0 * normal()).max(0.0),
                        f64::NAN,
                        f64::NAN,
                    ],
                    drive_torque_nm: [0.0; 4],
                    grade_rad: 0.0,
                    sanding: 0.0,
                    ..WagonSample::missing(time_s)
                });
            }
            state = model.step(&state, &loading, 0.001, &mut acceleration);
        }
        if state.v_m_s < 2.0 {
            break;
        }
    }
    (inputs, truths)
}

/// A stop on good rail: 4 s of coasting, then the brake is applied to `force_n` within a second.
pub fn dry_stop(seed: u64, force_n: f64, pads: [f64; 2]) -> (Vec<WagonSample>, Vec<Truth>) {
    drive(Order {
        seed,
        start_m_s: 30.0,
        seconds: 30.0,
        force_n: &mut |time_s, _| [force_n * (time_s - 4.0).clamp(0.0, 1.0); 2],
        adhesion: &|_| 0.3,
        pads,
    })
}

/// A slide protection of the simplest kind: vents a wheelset that is slower than 0.93 of the wagon until it is above 0.98.
pub fn protected(target: impl Fn(f64) -> f64) -> impl FnMut(f64, [f64; 2]) -> [f64; 2] {
    let (mut force_n, mut venting) = ([0.0; 2], [false; 2]);
    move |time_s, ratio| {
        for i in 0..2 {
            venting[i] = if venting[i] { ratio[i] < 0.98 } else { ratio[i] < 0.93 };
            let aim: f64 = if venting[i] { 0.0 } else { target(time_s) };
            let rate = if venting[i] { 1.0 / 0.08 } else { 1.0 / 0.4 };
            force_n[i] += (aim - force_n[i]) * rate * 0.001;
        }
        force_n
    }
}
