//! The bogie rig's experiments meet their criteria; its filter is as accurate as it says and names bad input.
#![allow(clippy::unwrap_used)] // in functions that the tests share

use railgrip_experiments::bogie::controller::Control;
use railgrip_experiments::bogie::run::{Rail, Setup, simulate};
use railgrip_experiments::rigs::{RigFeed, RigRow};
use railgrip_filter::core::chi_square_mean_band;
use railgrip_filter::models::bogie_rig::{
    BogieFilter, BogieInputState, BogieModel, BogieNoise, BogieSample, BogieVector, STATES, index,
};
use railgrip_filter::{EstimateState, EstimatorConfig, EstimatorInput, Plant};
use railgrip_vehicle::bogie_rig::{BogieParameters, RailCondition};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

fn run(name: &str) -> railgrip_experiments::Report {
    let directory = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    railgrip_experiments::find(name).unwrap().run_into(&directory).unwrap()
}

#[test]
fn peaks_are_the_papers() {
    let report = run("shrestha-peak");
    println!("{}", report.markdown("shrestha-peak"));
    assert!(report.all_met());
}

#[test]
fn water_is_survived() {
    let report = run("shrestha-transition");
    println!("{}", report.markdown("shrestha-transition"));
    assert!(report.all_met());
}

#[test]
fn the_network_hears_the_water() {
    let report = run("shrestha-acoustics");
    println!("{}", report.markdown("shrestha-acoustics"));
    assert!(report.all_met());
}

#[test]
fn stops_are_the_papers() {
    let report = run("shrestha-stopping");
    println!("{}", report.markdown("shrestha-stopping"));
    assert!(report.all_met());
}

/// A held speed under the proposed controller.
fn held(v_m_s: f64, condition: RailCondition, end_s: f64, seed: u64) -> Setup {
    Setup {
        parameters: BogieParameters::default(),
        v_m_s,
        rail: Rail::Steady(condition),
        control: Control::Proposed,
        preset_torque_nm: 60.0,
        brake_from_s: 3.0,
        control_lag_s: 0.25,
        hold_s: f64::INFINITY,
        accuracy: 0.95,
        roughness: 1.0,
        end_s,
        seed,
    }
}

#[test]
fn filter_is_as_accurate_as_it_says() {
    const SEEDS: u64 = 60;
    const STEPS: u64 = 400;
    let model = BogieModel { parameters: BogieParameters::default(), noise: BogieNoise::default() };
    let load = model.parameters.load_n();
    let dt_s = 0.01;
    let f = BogieModel::transition(dt_s);
    let q = model.process_variance(dt_s, false, [false; 2]);
    let (mut nees, mut nis, mut values) = (0.0, 0.0, 0.0);
    for seed in 0..SEEDS {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut belief = model.prior();
        // In motion and braking, so that the loss is smooth: speeds 10 and 19 rad/s, adhesion -0.2.
        belief.mean[index::ROLLER_SPEED] = 10.0;
        belief.mean[index::WHEEL_SPEED[0]] = 19.0;
        belief.mean[index::WHEEL_SPEED[1]] = 19.5;
        belief.mean[index::ADHESION] = -0.2;
        for (state, sigma) in [(1, 0.3), (4, 0.3), (6, 0.3), (7, 0.05)] {
            belief.covariance[(state, state)] = sigma * sigma;
        }
        let start = belief.covariance.diagonal().map(f64::sqrt);
        let mut truth = belief.mean + BogieVector::from_fn(|i, _| start[i] * normal());
        for step in 1..=STEPS {
            truth = f * truth + BogieVector::from_fn(|i, _| q[i].sqrt() * normal());
            belief.predict_leading(f * belief.mean, &f, index::ADHESION, &q);
            let sigma_n = model_sigma(|| model.expect_load_cell(&belief, 0.0, load).2);
            let measured = BogieModel::load_cell_n(&truth, load) + sigma_n * normal();
            let (update, h, r) = model.expect_load_cell(&belief, measured, load);
            nis += update.nis();
            belief.update_row(&h, &update, r);
            let sigma_nm = model_sigma(|| model.expect_torque(&belief, 0.0, load).2);
            let measured = model.torque_nm(&truth, load) + sigma_nm * normal();
            let (update, h, r) = model.expect_torque(&belief, measured, load);
            nis += update.nis();
            belief.update_row(&h, &update, r);
            values += 2.0;
            for counter in 0..3 {
                if counter == 0 && step % 12 != 0 {
                    continue;
                }
                let pulse = model.pulse_rad(counter);
                let state = BogieModel::angle_of(counter);
                // The counter's error as the filter models it, here normal instead of uniform.
                let pulses = truth[state] / pulse - 0.5 + normal() / 12f64.sqrt();
                let (update, r) = model.expect_count(&belief, counter, pulses);
                nis += update.nis();
                values += 1.0;
                belief.update_component(state, &update, r);
                model.begin_anew(&mut belief, counter, pulses);
                truth[state] -= pulses * pulse;
            }
        }
        let error = truth - belief.mean;
        nees += error.dot(&belief.covariance.cholesky().unwrap().solve(&error));
    }
    let (nees, nis) = (nees / SEEDS as f64, nis / values);
    let nees_band = chi_square_mean_band(STATES as f64, SEEDS as f64, 3.0);
    let nis_band = chi_square_mean_band(1.0, values, 3.5);
    println!("{SEEDS} seeds: NEES {nees:.2} in {nees_band:?}, NIS a value {nis:.4} in {nis_band:?}");
    assert!(nees_band.holds(nees) && nis_band.holds(nis));
}

/// Sigma from a variance.
fn model_sigma(variance: impl Fn() -> f64) -> f64 {
    variance().sqrt()
}

#[test]
fn on_the_rig_itself_errors_are_as_large_as_stated() {
    const SEEDS: u64 = 52;
    let (mut nis, mut values, mut adhesion, mut speed, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for seed in 0..SEEDS {
        let condition = RailCondition::ALL[seed as usize % 2];
        let setup = held([1.38, 2.76, 4.14][seed as usize % 3], condition, 12.0, seed);
        for instant in simulate(&setup).iter().filter(|instant| instant.sample.time_s > 6.0) {
            let estimate = &instant.estimate;
            nis += estimate.nis;
            values += f64::from(estimate.nis_dof);
            let error = estimate.mu_w + instant.adhesion(&setup.parameters);
            adhesion += (error / estimate.mu_w_sigma).powi(2);
            speed += ((estimate.v_m_s - instant.v_m_s) / estimate.v_sigma_m_s).powi(2);
            count += 1.0;
        }
    }
    let (nis, adhesion, speed) = (nis / values, adhesion / count, speed / count);
    println!(
        "{SEEDS} seeds on the rig: NIS a value {nis:.3}, normalised error of adhesion {adhesion:.3}, of speed {speed:.3}"
    );
    // The rig wanders less than the filter allows for, so it may be too careful, not too sure.
    assert!((0.6..1.25).contains(&nis));
    assert!((0.3..1.5).contains(&adhesion) && (0.3..1.5).contains(&speed));
}

#[test]
fn bad_input_gets_a_named_state() {
    let setup = held(2.76, RailCondition::Dry, 8.0, 7);
    let run = simulate(&setup);
    let last = |spoil: &dyn Fn(&BogieSample) -> BogieSample| {
        let mut filter = BogieFilter::new(setup.parameters.clone(), BogieNoise::default());
        run.iter().map(|instant| filter.step(&spoil(&instant.sample))).last().unwrap()
    };
    let after = 5.0;
    use BogieInputState as State;
    type Spoil = Box<dyn Fn(&BogieSample) -> BogieSample>;
    let from = move |change: fn(&mut BogieSample)| -> Spoil {
        Box::new(move |sample| {
            let mut sample = *sample;
            if sample.time_s > after {
                change(&mut sample);
            }
            sample
        })
    };
    let cases: Vec<(&str, Spoil, State)> = vec![
        ("nothing wrong", from(|_| {}), State::Braking),
        ("no load", from(|sample| sample.load_n = 0.0), State::ZeroLoad),
        ("load missing", from(|sample| sample.load_n = f64::NAN), State::ZeroLoad),
        ("torque missing", from(|sample| sample.shaft_torque_nm = f64::NAN), State::TorqueDead),
        ("torque stuck", from(|sample| sample.shaft_torque_nm = 41.0), State::TorqueDead),
        ("load cell stuck", from(|sample| sample.load_cell_n = 0.0), State::LoadCellDead),
        (
            "both forces missing",
            from(|sample| (sample.shaft_torque_nm, sample.load_cell_n) = (f64::NAN, f64::NAN)),
            State::ForcesDead,
        ),
        (
            "forces exchanged",
            from(|sample| {
                (sample.shaft_torque_nm, sample.load_cell_n) = (sample.load_cell_n, sample.shaft_torque_nm)
            }),
            State::ForcesSwapped,
        ),
        ("load cell reversed", from(|sample| sample.load_cell_n *= -1.0), State::ForcesDisagree),
        ("rollers' counter silent", from(|sample| sample.roller_pulses *= 0.0), State::RollerCounterDead),
        (
            "rollers' counter missing",
            from(|sample| sample.roller_pulses = f64::NAN),
            State::RollerCounterDead,
        ),
        (
            "wheelset counter missing",
            from(|sample| sample.wheel_pulses[1] = f64::NAN),
            State::WheelCounterDead,
        ),
    ];
    for (what, spoil, expected) in cases {
        let estimate = last(&*spoil);
        println!(
            "{what}: {}, adhesion {:.3} ± {:.4}, slip {:?}",
            estimate.state.name(),
            estimate.mu_w,
            estimate.mu_w_sigma,
            estimate.slip()
        );
        assert_eq!(estimate.state, expected, "{what}");
        assert_eq!(estimate.mu_w.is_finite(), estimate.state.tells_adhesion());
        assert_eq!(estimate.creepage[0].is_finite(), estimate.state.tells_slip());
    }
    // The wheelsets' encoders on the rollers' input and the other way round, while nothing brakes.
    let mut filter = BogieFilter::new(setup.parameters.clone(), BogieNoise::default());
    let rolling = run.iter().take_while(|instant| instant.sample.time_s < 2.9);
    let mut window = 0.0;
    let swapped = rolling.map(|instant| {
        let mut sample = instant.sample;
        window += sample.wheel_pulses[0];
        if sample.roller_pulses.is_finite() {
            sample.roller_pulses = std::mem::take(&mut window);
        }
        sample.wheel_pulses = [23.0, 23.0];
        filter.step(&sample).state
    });
    assert_eq!(swapped.last().unwrap(), State::CountersSwapped);
}

/// A stop on a dry rail under the proposed controller as the estimators get it, with the adhesion in truth.
fn stop_rows() -> (Plant, Vec<(EstimatorInput, f64)>) {
    let feed = RigFeed::bogie_stop(RailCondition::Dry, Some(Control::Proposed), 7);
    let plant = feed.plant().clone();
    let rows = feed.take_while(|row| row.time_s() < 12.0).map(|row| match &row {
        RigRow::Bogie { truth, .. } => (row.input(), truth.mu_w),
        _ => panic!("a bogie rig has its own rows"),
    });
    (plant, rows.collect())
}

#[test]
fn behind_the_interface_gaps_and_restarts_cost_no_accuracy() {
    let (plant, rows) = stop_rows();
    let config = EstimatorConfig::default();
    let build = || railgrip_filter::estimator(&config, &plant).unwrap();
    type Drop = fn(usize) -> bool;
    let cases: [(&str, Drop); 3] = [
        ("every sample", |_| false),
        ("one in twenty missing", |k| k % 20 == 7),
        ("0.3 s missing every 2 s", |k| k % 200 < 30),
    ];
    for (what, dropped) in cases {
        let mut estimator = build();
        let (mut squares, mut inside, mut count) = (0.0, 0.0, 0.0);
        for (k, (input, truth)) in rows.iter().enumerate().filter(|(k, _)| !dropped(*k)) {
            if k == 900 {
                // A successor goes on from what the predecessor left.
                let snapshot = estimator.snapshot();
                estimator = build();
                estimator.restore(&snapshot).unwrap();
            }
            let output = estimator.step(input);
            if output.state == EstimateState::Observable && input.time_s() > 4.0 {
                squares += (output.mu_w - truth).powi(2);
                inside += f64::from(u8::from((output.mu_w - truth).abs() < 1.96 * output.mu_w_sigma));
                count += 1.0;
            }
        }
        let (rmse, inside) = ((squares / count).sqrt(), inside / count);
        println!("{what}: {count} estimates, adhesion RMSE {rmse:.4}, {inside:.3} inside the 95 % interval");
        assert!(count > 500.0 && rmse < 0.01 && inside > 0.9, "{what}");
    }
}

#[test]
fn behind_the_interface_bad_input_has_a_name_too() {
    let (plant, rows) = stop_rows();
    let last = |spoil: &dyn Fn(&EstimatorInput) -> Option<EstimatorInput>| {
        let mut estimator = railgrip_filter::estimator(&EstimatorConfig::default(), &plant).unwrap();
        let mut last = *estimator.last();
        for input in rows.iter().filter_map(|(input, _)| spoil(input)) {
            last = estimator.step(&input);
            let finite = [last.mu_w, last.mu_w_sigma, last.v_m_s, last.slip[0], last.slip[1]];
            assert!(finite.iter().all(|value| value.is_finite()), "what is published is finite: {last:?}");
        }
        last
    };
    let from = |change: fn(&mut BogieSample)| {
        move |input: &EstimatorInput| {
            let EstimatorInput::Bogie(mut sample) = *input else { return None };
            if sample.time_s > 8.0 {
                change(&mut sample);
            }
            Some(EstimatorInput::Bogie(sample))
        }
    };
    use EstimateState as State;
    type Change = fn(&mut BogieSample);
    let cases: [(&str, Change, State); 7] = [
        ("nothing wrong", |_| {}, State::Observable),
        ("no load", |sample| sample.load_n = 0.0, State::ZeroLoad),
        ("torque frozen", |sample| sample.shaft_torque_nm = 71.0, State::TorqueMissing),
        ("load cell frozen", |sample| sample.load_cell_n = 2900.0, State::LoadCellMissing),
        ("nothing but the time", |sample| *sample = BogieSample::missing(sample.time_s), State::ZeroLoad),
        ("rollers' counter dead", |sample| sample.roller_pulses = f64::NAN, State::RollerCounterMissing),
        (
            "exchanged",
            |sample| {
                (sample.shaft_torque_nm, sample.load_cell_n) = (sample.load_cell_n, sample.shaft_torque_nm);
            },
            State::ForcesSwapped,
        ),
    ];
    for (what, change, expected) in cases {
        let output = last(&from(change));
        println!("{what}: {}", output.state.name());
        assert_eq!(output.state, expected, "{what}");
    }
    // Every other sample is lost somewhere: another rate than the file says.
    let half = last(&|input| ((input.time_s() * 100.0).round() as i64 % 2 == 0).then_some(*input));
    assert_eq!(half.state, State::WrongRate);
}
