//! The step of one sample against a fine implicit solution: no slide where nothing slides, from walking pace to 80 m/s and
//! from 20 to 200 Hz.

mod fine;

use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion, SampleInput};
use railgrip_vehicle::{
    Body, Brake, Constants, Contact, Loading, MAX_WHEELSETS, PerWheelset, Rail, Resistance, SampleStep,
    Sensors, VehicleParameters, WagonModel, WagonState, Wheelset,
};

fn vehicle(falling: bool) -> VehicleParameters {
    let (friction_ratio, friction_decay_s_per_m) = if falling { (0.4, 0.6) } else { (1.0, 0.0) };
    VehicleParameters {
        schema: 1,
        name: "coach".into(),
        body: Body {
            mass_kg: 38e3,
            com_height_m: 1.65,
            wheelbase_m: 9.8,
            wheelset_positions_m: None,
            mass_sigma: None,
        },
        wheelset: Wheelset { radius_m: 0.43, inertia_kg_m2: 130.0 },
        brake: Brake { radius_m: 0.24, friction_coefficient: 0.35, friction_by_wheelset: None },
        resistance: Resistance { constant_n: 400.0, linear_n_s_per_m: 7.0, drag_n_s2_per_m2: 4.5 },
        contact: Contact { stiffness_n: 6e6, k_a: 1.0, k_s: 0.4, friction_ratio, friction_decay_s_per_m },
        rail: Rail { dry: 0.31, wet: 0.115, low: 0.05 },
        sensors: Sensors {
            sample_rate_hz: 100.0,
            speed_sigma_m_s: 0.03,
            wheel_speed_sigma_rad_s: 0.03,
            pressing_force_sigma_n: 150.0,
        },
        bogie: None,
        train: None,
        effects: Vec::new(),
    }
}

/// What one case starts from and what acts on it.
#[derive(Clone, Debug)]
struct Start {
    state: WagonState,
    loading: Loading,
    load_n: PerWheelset,
    acceleration_m_s2: f64,
}

/// Braking (positive) or traction demand as adhesion on both wheelsets, the wheelsets off rolling by `off_rad_s`.
fn start(model: &WagonModel, v_m_s: f64, peak: f64, demand: f64, off_rad_s: [f64; 2]) -> Start {
    let constants = model.constants();
    let acceleration_m_s2 = -demand.clamp(-peak, peak) * 9.81;
    let load_n = model.load_distribution().loads_n(acceleration_m_s2);
    let mut loading = Loading { adhesion_peak: [peak; MAX_WHEELSETS], ..Loading::default() };
    let mut state = WagonState { v_m_s, ..WagonState::default() };
    for i in 0..constants.wheelsets {
        let torque = demand * 38e3 * 9.81 / 2.0 * constants.wheel_radius_m[i];
        loading.brake_torque_nm[i] = torque.max(0.0);
        loading.drive_torque_nm[i] = (-torque).max(0.0);
        state.wheel_speed_rad_s[i] = (v_m_s / constants.wheel_radius_m[i] + off_rad_s[i]).max(0.0);
    }
    Start { state, loading, load_n, acceleration_m_s2 }
}

/// Largest difference of speeds, of the vehicle in m/s and of its wheelsets in rad/s.
fn apart(a: &WagonState, b: &WagonState) -> (f64, f64) {
    let wheel = |i: usize| (a.wheel_speed_rad_s[i] - b.wheel_speed_rad_s[i]).abs();
    ((a.v_m_s - b.v_m_s).abs(), wheel(0).max(wheel(1)))
}

fn simulate(constants: &Constants, start: &Start, rate_hz: f64, samples: usize) -> WagonState {
    let step = SampleStep::<1>::new(constants, 1.0 / rate_hz);
    let (mut state, mut acceleration) = (start.state, start.acceleration_m_s2);
    for _ in 0..samples {
        let next = step.advance(&state, &start.load_n, &start.loading, acceleration).0;
        acceleration = (next.v_m_s - state.v_m_s) * rate_hz;
        state = next;
    }
    state
}

/// Whether a wheelset still slides ten samples after both were thrown off rolling.
fn slides(model: &WagonModel, v_m_s: f64, rate_hz: f64, off_rad_s: f64) -> [bool; 2] {
    let start = start(model, v_m_s, 0.31, 0.085, [off_rad_s, -off_rad_s]);
    let fast = simulate(model.constants(), &start, rate_hz, 10);
    let (mut plain, mut acceleration) = (start.state, start.acceleration_m_s2);
    for _ in 0..10 {
        plain = model.step(&plain, &start.loading, 1.0 / rate_hz, &mut acceleration);
    }
    [fast, plain].map(|state| {
        let slip = |i: usize| (0.43 * state.wheel_speed_rad_s[i] - state.v_m_s).abs();
        // Rolling at this demand slips by 0.25 % of the speed.
        slip(0).max(slip(1)) > 0.005 * state.v_m_s.max(0.5)
    })
}

/// Braking well within the adhesion of dry rail, thrown off rolling by up to a quarter of a radian per second: a linearly
/// implicit step in four parts is carried across by saturated creep force and slides on for ever in most of these cases.
#[test]
fn a_wheelset_thrown_off_rolls_again() {
    let model = WagonModel::new(&vehicle(false)).expect("model");
    let mut cases = 0;
    let mut sliding = [0; 2];
    for v in [0.2, 0.5, 1.0, 2.0, 3.3, 5.0, 8.0, 15.0, 30.0, 80.0] {
        for rate in [20.0, 50.0, 100.0, 200.0] {
            for k in -100..=100 {
                let [fast, plain] = slides(&model, v, rate, f64::from(k) * 0.0025);
                sliding = [sliding[0] + usize::from(fast), sliding[1] + usize::from(plain)];
                cases += 1;
            }
        }
    }
    println!("{cases} starts: the sample step slides on in {}, the plain step in {}", sliding[0], sliding[1]);
    assert_eq!(sliding, [0, 0]);
}

/// A number between 0 and 1 (Weyl sequences: even in every coordinate).
fn even(k: usize, coordinate: usize) -> f64 {
    let roots = [2.0_f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0];
    (k as f64 * roots[coordinate].sqrt()).fract()
}

fn pick<T: Copy>(list: &[T], at: f64) -> T {
    list[(at * list.len() as f64) as usize]
}

#[test]
fn one_sample_is_that_of_a_fine_implicit_solution() {
    let models = [false, true].map(|falling| WagonModel::new(&vehicle(falling)).expect("model"));
    let mut errors: Vec<((f64, f64), String)> = Vec::new();
    let mut on_edge = 0;
    for k in 0..2400 {
        let falling = k % 2;
        let v = pick(&[0.2, 0.35, 0.6, 1.0, 2.0, 3.3, 5.0, 8.0, 15.0, 30.0, 50.0, 80.0], even(k, 0));
        let rate = pick(&[20.0, 50.0, 100.0, 200.0], even(k, 1));
        let peak = pick(&[0.31, 0.12, 0.05, 0.02], even(k, 2));
        let demand = peak * pick(&[-1.5, -0.95, -0.3, 0.0, 0.1, 0.3, 0.7, 0.95, 1.1, 2.0], even(k, 3));
        let scale = pick(&[0.0, 0.01, 0.05, 0.25, 1.0, 5.0], even(k, 4));
        let off = [scale * (2.0 * even(k, 5) - 1.0), scale * (2.0 * even(k, 6) - 1.0)];
        let model = &models[falling];
        let start = start(model, v, peak, demand, off);
        let fine = |start: &Start| {
            fine::advance(model.constants(), &start.state, &start.load_n, &start.loading, 1.0 / rate)
        };
        let exact = fine(&start);
        let (v_error, wheel_error) = apart(&simulate(model.constants(), &start, rate, 1), &exact);
        if wheel_error > 2e-3 {
            // On the edge between catching and sliding on, a hair decides.
            let moved = |by: f64| {
                let mut start = start.clone();
                (0..2).for_each(|i| start.state.wheel_speed_rad_s[i] += by);
                apart(&fine(&start), &exact).1
            };
            if moved(1e-3).max(moved(-1e-3)) > 5e-3 {
                on_edge += 1;
                continue;
            }
        }
        let what = format!("v {v} rate {rate} peak {peak} demand {demand:.3} off {off:?} falling {falling}");
        errors.push(((v_error, wheel_error), what));
    }
    errors.sort_by(|a, b| a.0.1.total_cmp(&b.0.1));
    let share = |p: f64| errors[(p * (errors.len() - 1) as f64) as usize].0.1;
    let worst_v = errors.iter().map(|e| e.0.0).fold(0.0, f64::max);
    println!("errors of wheelsets, rad/s: median {:.1e}, 99 % {:.1e}", share(0.5), share(0.99));
    println!("of the vehicle: worst {worst_v:.1e} m/s; {on_edge} on the edge");
    errors.iter().rev().take(8).for_each(|e| println!("{:?} {}", e.0, e.1));
    // At worst below what a wheelset's sensor can tell.
    assert!(errors.len() > 2300 && share(0.99) < 5e-3 && share(1.0) < 0.03 && worst_v < 1e-3);
}

/// A brake stops a wheelset and holds it: on a grade, while the wagon stops, and whatever noise a filter adds to rest.
/// Held by its brakes, thrown off standstill as noise of the sensors does it: one sample ends where two hundred short ones do. A brake
/// that hardly holds lets wheelsets turn on for a while, which is followed less closely.
#[test]
fn a_wagon_that_its_brakes_hold_stands_as_in_fine_steps() {
    let models = [false, true].map(|falling| WagonModel::new(&vehicle(falling)).expect("model"));
    for (demand, allowed_m_s) in [(0.3, 1e-4), (0.05, 2.5e-3)] {
        let (mut worst, mut cases) = ((0.0, 0.0), 0);
        for (k, v) in [-0.06, -0.01, -1e-4, 0.0, 0.003, 0.02, 0.09].into_iter().enumerate() {
            for off in [[0.0, 0.0], [0.05, -0.08], [-0.02, 0.03]] {
                for (peak, push_n) in [(0.31, 0.0), (0.31, 900.0), (0.05, -600.0), (0.31, 4e3)] {
                    let model = &models[k % 2];
                    let mut start = start(model, 0.0, 0.31, demand, [0.0, 0.0]);
                    (start.state.v_m_s, start.acceleration_m_s2) = (v, 0.0);
                    start.state.wheel_speed_rad_s[..2].copy_from_slice(&off);
                    start.loading.adhesion_peak = [peak; MAX_WHEELSETS];
                    start.loading.other_n = push_n;
                    for rate_hz in [20.0, 50.0, 100.0] {
                        let once = simulate(model.constants(), &start, rate_hz, 1);
                        let fine = simulate(model.constants(), &start, 200.0 * rate_hz, 200);
                        let (body, wheels) = apart(&once, &fine);
                        worst = (f64::max(worst.0, body), f64::max(worst.1, wheels));
                        cases += 1;
                    }
                }
            }
        }
        println!(
            "brake {demand}: {cases} starts, at worst {:.1e} m/s and {:.1e} rad/s apart",
            worst.0, worst.1
        );
        assert!(worst.0 < allowed_m_s && worst.1 < 0.01 && cases == 252, "{worst:?}");
    }
}

#[test]
fn a_braked_wheelset_never_turns_backwards() {
    let model = WagonModel::new(&vehicle(false)).expect("model");
    let mut lowest = f64::INFINITY;
    for (v, rate, grade_n) in [(1.0, 100.0, 0.0), (0.3, 20.0, -3e3), (2.0, 50.0, 3e3), (0.05, 200.0, -3e3)] {
        let mut start = start(&model, v, 0.31, 0.085, [0.0, 0.0]);
        start.loading.other_n = grade_n;
        for samples in [1, 3, 10, 50, 300] {
            let end = simulate(model.constants(), &start, rate, samples);
            lowest = lowest.min(end.wheel_speed_rad_s[0]).min(end.wheel_speed_rad_s[1]);
        }
        let end = simulate(model.constants(), &start, rate, 1000);
        assert!(end.v_m_s.abs() < 1e-3 && end.wheel_speed_rad_s == [0.0; MAX_WHEELSETS], "{end:?}");
    }
    assert!(lowest >= 0.0, "{lowest}");
}

#[test]
fn a_state_of_no_sense_ends_the_step_as_well() {
    let model = WagonModel::new(&vehicle(true)).expect("model");
    for (v, off) in [(f64::NAN, 0.0), (1e12, -1e11), (-40.0, 3.0), (3.0, 1e9)] {
        let start = start(&model, v, 0.31, 0.2, [off, 0.0]);
        let end = simulate(model.constants(), &start, 100.0, 3);
        assert!(end.v_m_s.is_finite() == v.is_finite(), "{v} {off}: {end:?}");
    }
}

/// The step of filters comes back to rolling without crossing it, from wherever noise throws a wheelset, and is as far off
/// as that noise is large at most.
#[test]
fn a_quick_step_comes_back_to_rolling() {
    let model = WagonModel::new(&vehicle(false)).expect("model");
    let mut worst: f64 = 0.0;
    for v in [1.0, 3.3, 8.0, 15.0, 30.0, 80.0] {
        for k in -20..=20 {
            let off = f64::from(k) * 0.01;
            let start = start(&model, v, 0.31, 0.085, [off, -off]);
            let step = SampleStep::<1>::new(model.constants(), 0.01);
            let exact = step.advance(&start.state, &start.load_n, &start.loading, start.acceleration_m_s2).0;
            let quick =
                step.quick().advance(&start.state, &start.load_n, &start.loading, start.acceleration_m_s2).0;
            let (v_error, wheel_error) = apart(&quick, &exact);
            worst = worst.max(wheel_error / off.abs().max(0.01)).max(v_error / 1e-2);
        }
    }
    println!("a quick step is off by at most {worst:.2} of what threw the wheelset off");
    assert!(worst < 0.5, "{worst}");
}

/// The step of filters follows a slide as the exact one does, to a small part of what their sensors' noise is.
#[test]
fn a_quick_step_slides_on_where_the_exact_one_slides() {
    let (mut worst, mut slides): (f64, usize) = (0.0, 0);
    for falling in [false, true] {
        let model = WagonModel::new(&vehicle(falling)).expect("model");
        for (rate_hz, v, demand) in [20.0, 50.0, 100.0].into_iter().flat_map(|rate| {
            [3.3, 8.0, 20.0, 60.0]
                .into_iter()
                .flat_map(move |v| [0.07, -0.07].map(|demand| (rate, v, demand)))
        }) {
            let mut start = start(&model, v, 0.05, demand, [0.0; 2]);
            let exact = SampleStep::<1>::new(model.constants(), 1.0 / rate_hz);
            let quick = exact.clone().quick();
            for _ in 0..12 {
                let step = |step: &SampleStep<1>| {
                    step.advance(&start.state, &start.load_n, &start.loading, start.acceleration_m_s2).0
                };
                let next = step(&exact);
                let (v_error, wheel_error) = apart(&step(&quick), &next);
                worst = worst.max(v_error / NOISE).max(wheel_error / NOISE);
                start.state = next;
                let radius_m = model.constants().wheel_radius_m[0];
                slides += usize::from((next.v_m_s - radius_m * next.wheel_speed_rad_s[0]).abs() > 0.1);
            }
        }
    }
    println!(
        "a quick step of a slide is off by at most {worst:.3} of a sensor's noise; {slides} of 576 slide"
    );
    assert!(worst < 0.2 && slides > 200, "{worst} {slides}");
}

/// Noise of the sensors: m/s and rad/s.
const NOISE: f64 = 0.03;

/// Slopes are those of the step itself, by central differences, rolling and sliding.
#[test]
fn slopes_are_those_of_the_step() {
    let mut worst: f64 = 0.0;
    for falling in [false, true] {
        let model = WagonModel::new(&vehicle(falling)).expect("model");
        let step = SampleStep::<1>::new(model.constants(), 0.01);
        for (v, peak, demand) in
            [(30.0, 0.31, 0.085), (15.0, 0.31, -0.05), (20.0, 0.05, 0.12), (60.0, 0.12, 0.0)]
        {
            let mut start = start(&model, v, peak, demand, [0.0; 2]);
            // To rolling, or well into a slide.
            for _ in 0..20 {
                start.state =
                    step.advance(&start.state, &start.load_n, &start.loading, start.acceleration_m_s2).0;
            }
            let next = |start: &Start| {
                let end =
                    step.advance(&start.state, &start.load_n, &start.loading, start.acceleration_m_s2).0;
                [end.v_m_s, end.wheel_speed_rad_s[0], end.wheel_speed_rad_s[1]]
            };
            let slopes =
                step.slopes::<2, 3>(&start.state, &start.load_n, &start.loading, start.acceleration_m_s2);
            let mut check = |size: f64, expected: [f64; 3], change: &dyn Fn(&mut Start, f64)| {
                let (mut up, mut down) = (start.clone(), start.clone());
                change(&mut up, size);
                change(&mut down, -size);
                let (up, down) = (next(&up), next(&down));
                for j in 0..3 {
                    let numeric = (up[j] - down[j]) / 2.0;
                    worst = worst.max((expected[j] * size - numeric).abs() / NOISE);
                }
            };
            let column = |of: &dyn Fn(usize) -> f64| [of(0), of(1), of(2)];
            check(1e-3, column(&|j| slopes.by_speed[j][0]), &|s, by| s.state.v_m_s += by);
            for i in 0..2 {
                check(1e-3, column(&|j| slopes.by_speed[j][1 + i]), &|s, by| {
                    s.state.wheel_speed_rad_s[i] += by
                });
                check(50.0, column(&|j| slopes.by_torque[j][i]), &|s, by| s.loading.drive_torque_nm[i] += by);
                check(1e-3, column(&|j| slopes.by_adhesion[j][i]), &|s, by| s.loading.adhesion_peak[i] += by);
            }
            check(1e3, column(&|j| slopes.by_force[j]), &|s, by| s.loading.other_n += by);
        }
    }
    println!(
        "slopes are off by at most {worst:.3} of a sensor's noise over a change that it would hardly notice"
    );
    assert!(worst < 0.02, "{worst}");
}

/// Four wheelsets on bogies, one of them sliding: the same, through the fast wagon.
#[test]
fn slopes_of_four_wheelsets_are_those_of_their_step() {
    let mut vehicle = vehicle(false);
    vehicle.body.wheelset_positions_m = Some(vec![9.0, 6.5, -6.5, -9.0]);
    vehicle.bogie = Some(railgrip_vehicle::Bogie { wheelbase_m: 2.5, pivot_height_m: 0.6 });
    let model = WagonModel::new(&vehicle).expect("model");
    let wagon = FastWagon::new(&model, 0.1, 0.01);
    let brake = |wheelset: usize| if wheelset == 2 { 0.14 } else { 0.05 };
    let per_n = vehicle.brake.radius_m * vehicle.brake.friction_coefficient;
    let torque = |i: usize| brake(i) * vehicle.axle_load_n() * vehicle.wheelset.radius_m;
    let pressing: [f64; 4] = std::array::from_fn(|i| torque(i) / per_n);
    let input =
        SampleInput { pressing_force_n: pressing, mid_pressing_force_n: pressing, ..Default::default() };
    let mut motion = Motion::default();
    motion.state.fill(20.0 / vehicle.wheelset.radius_m);
    motion.state[0] = 20.0;
    for _ in 0..40 {
        wagon.step(&mut motion, &input, &Disturbance::default(), &mut []);
    }
    let slide_m_s = motion.state[0] - vehicle.wheelset.radius_m * motion.state[3];
    assert!(slide_m_s > 0.5, "the third wheelset slides by {slide_m_s:.2} m/s");
    let loading = wagon.loading_at(&motion, &input, &Disturbance::default(), &[]);
    let slopes = wagon.slopes::<4, 5>(&motion, &loading);
    let mut worst: f64 = 0.0;
    for column in 0..5 {
        let after = |by: f64| {
            let mut changed = motion;
            changed.state[column] += by;
            wagon.step(&mut changed, &input, &Disturbance::default(), &mut []);
            changed.state
        };
        let (up, down) = (after(1e-3), after(-1e-3));
        for row in 0..5 {
            let numeric = (up[row] - down[row]) / 2.0;
            worst = worst.max((1e-3 * slopes.by_speed[row][column] - numeric).abs() / NOISE);
        }
    }
    println!("off by at most {worst:.3} of a sensor's noise; the third slides by {slide_m_s:.2} m/s");
    assert!(worst < 0.02, "{worst}");
}
