//! Bad data: every documented behaviour of the estimator, on a stop with known truth.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]

mod support;

use railgrip_filter::{EstimatorConfig, EstimatorOutput, FilterError, WagonEstimator, WagonSample, flags};
use support::Truth;
use support::plant::{drive, dry_stop, vehicle};

/// Braking steadily from 5 s to the end.
fn stop() -> (Vec<WagonSample>, Vec<Truth>) {
    dry_stop(99, 4e4, [0.95, 1.05])
}

fn estimator() -> WagonEstimator {
    WagonEstimator::new(&EstimatorConfig::default(), &vehicle()).unwrap()
}

fn estimate(inputs: &[WagonSample]) -> Vec<EstimatorOutput> {
    let mut estimator = estimator();
    inputs.iter().map(|input| estimator.step(input)).collect()
}

/// Largest errors of adhesion and speed over these samples.
fn worst(outputs: &[EstimatorOutput], truths: &[Truth], range: std::ops::Range<usize>) -> (f64, f64) {
    range.fold((0.0, 0.0), |(mu, v): (f64, f64), i| {
        (mu.max((outputs[i].mu_w - truths[i].mu_w).abs()), v.max((outputs[i].v_m_s - truths[i].v_m_s).abs()))
    })
}

/// Estimates with samples 800..900 changed, and the largest errors from there on.
fn disturbed(what: &str, change: impl Fn(usize, &mut WagonSample)) -> (Vec<EstimatorOutput>, (f64, f64)) {
    let (mut inputs, truths) = stop();
    (800..900).for_each(|i| change(i, &mut inputs[i]));
    let outputs = estimate(&inputs);
    let worst = worst(&outputs, &truths, 800..1100);
    println!("{what}: adhesion off by at most {:.4}, speed by {:.3} m/s", worst.0, worst.1);
    assert!(outputs.iter().all(|out| out.mu_w.is_finite() && out.mu_w_sigma.is_finite()));
    (outputs, worst)
}

#[test]
fn missing_sensors_are_carried_by_the_others() {
    let (outputs, worst) = disturbed("no vehicle speed for 1 s", |_, input| input.v_m_s = f64::NAN);
    assert!(worst.0 < 0.003 && worst.1 < 0.1);
    assert_eq!(outputs[850].nis_dof, 2);
    let (_, worst) = disturbed("no front wheelset for 1 s", |_, input| input.wheel_speed_rad_s[0] = f64::NAN);
    assert!(worst.0 < 0.003 && worst.1 < 0.1);
    let (outputs, worst) = disturbed("no speed at all for 1 s", |_, input| {
        input.v_m_s = f64::INFINITY;
        input.wheel_speed_rad_s = [f64::NAN; 4];
    });
    assert!(worst.0 < 0.003 && worst.1 < 0.1);
    assert_ne!(outputs[850].flags & flags::PREDICTED, 0);
    assert_eq!(outputs[850].nis_dof, 0);
}

#[test]
fn missing_inputs_are_held_then_given_up() {
    let (outputs, worst) =
        disturbed("no pressing force for 1 s", |_, input| input.pressing_force_n = [f64::NAN; 4]);
    assert!(worst.0 < 0.01 && worst.1 < 0.1);
    assert_ne!(outputs[820].flags & flags::HELD, 0);
    assert_eq!(outputs[880].observable, 0, "after the hold nothing is said about the pads");
    let (_, worst) = disturbed("no torque, grade, sand, position", |_, input| {
        input.drive_torque_nm = [f64::NAN; 4];
        (input.grade_rad, input.sanding, input.position_m) = (f64::NAN, f64::NAN, f64::NAN);
    });
    assert!(worst.0 < 0.003);
}

#[test]
fn spikes_are_refused() {
    let (outputs, worst) = disturbed("spikes", |i, input| {
        if i % 10 == 0 {
            input.v_m_s += 3.0;
        }
        if i % 10 == 5 {
            input.wheel_speed_rad_s[1] -= 20.0;
        }
    });
    assert!(worst.0 < 0.003 && worst.1 < 0.1);
    assert_eq!(outputs[810].rejected, 1);
    assert_eq!(outputs[815].rejected, 1 << 2);
    assert!(outputs[810].innovations.test_ratio[0] > 1.0);
    assert!(outputs[810].nis > 100.0, "refused innovations count");
}

#[test]
fn stuck_sensors_are_refused_until_they_move() {
    let held = stop().0[799];
    let (outputs, worst) = disturbed("vehicle speed stuck for 1 s", |_, input| input.v_m_s = held.v_m_s);
    assert!(worst.0 < 0.006 && worst.1 < 0.12, "{worst:?}");
    assert_eq!(outputs[880].rejected & 1, 1);
    assert_eq!(outputs[960].rejected, 0);
    let (outputs, worst) = disturbed("front wheelset stuck for 1 s", |_, input| {
        input.wheel_speed_rad_s[0] = held.wheel_speed_rad_s[0];
    });
    assert!(worst.0 < 0.03, "{worst:?}");
    assert_eq!(outputs[880].rejected & 2, 2);
    assert_eq!(outputs[960].rejected, 0);
}

#[test]
fn late_and_repeated_samples_change_nothing() {
    let (inputs, _) = stop();
    let clean = estimate(&inputs);
    let mut estimator = estimator();
    for (i, input) in inputs.iter().enumerate() {
        let out = estimator.step(input);
        assert_eq!(out, clean[i], "sample {i}");
        if i % 7 == 3 {
            let again = estimator.step(input);
            assert_ne!(again.flags & flags::IGNORED, 0);
            assert_eq!(again.mu_w, out.mu_w);
        }
        if i % 11 == 5 && i > 20 {
            assert_ne!(estimator.step(&inputs[i - 9]).flags & flags::IGNORED, 0);
        }
        assert_ne!(estimator.step(&WagonSample { time_s: f64::NAN, ..*input }).flags & flags::IGNORED, 0);
    }
}

#[test]
fn gaps_are_bridged() {
    for (missing, allowed) in [(20, 0.01), (150, 0.02), (500, 0.05)] {
        let (inputs, truths) = stop();
        let kept: Vec<usize> = (0..inputs.len()).filter(|i| !(700..700 + missing).contains(i)).collect();
        let mut estimator = estimator();
        let outputs: Vec<_> = kept.iter().map(|&i| estimator.step(&inputs[i])).collect();
        let after = &outputs[700..720];
        let errors: Vec<f64> =
            after.iter().zip(700..).map(|(o, k)| (o.mu_w - truths[kept[k]].mu_w).abs()).collect();
        let settled = (outputs[800].mu_w - truths[kept[800]].mu_w).abs();
        let first = errors.iter().copied().fold(0.0, f64::max);
        println!("gap of {missing} samples: off by {first:.4} in the first 0.2 s, {settled:.4} after 1 s");
        assert_ne!(after[0].flags & flags::GAP, 0);
        assert!(first < allowed && settled < 0.003);
        assert!((outputs[800].mu_b_mean - outputs[690].mu_b_mean).abs() < 0.02, "pads survive the gap");
    }
}

#[test]
fn a_clock_that_is_set_back_only_renews_the_motion() {
    let (inputs, truths) = stop();
    let mut estimator = estimator();
    let mut outputs = Vec::new();
    for (i, input) in inputs.iter().enumerate() {
        let back_s = if i >= 900 { 5.0 } else { 0.0 };
        outputs.push(estimator.step(&WagonSample { time_s: input.time_s - back_s, ..*input }));
    }
    assert_ne!(outputs[900].flags & flags::GAP, 0);
    let (mu, _) = worst(&outputs, &truths, 930..1200);
    println!("clock set back by 5 s: off by {mu:.4} from 0.3 s after");
    assert!(mu < 0.004);
    assert!((outputs[1000].mu_b_mean - outputs[890].mu_b_mean).abs() < 0.01);
}

#[test]
fn a_restart_in_the_middle_of_braking_goes_on_from_its_snapshot() {
    let (inputs, truths) = stop();
    let mut first = estimator();
    inputs[..900].iter().for_each(|input| {
        first.step(input);
    });
    let text = serde_json::to_string(&first.snapshot()).unwrap();
    let snapshot = serde_json::from_str(&text).unwrap();
    let mut second = estimator();
    second.restore(&snapshot).unwrap();
    // The process was away for 0.8 s.
    let outputs: Vec<_> = inputs[980..].iter().map(|input| second.step(input)).collect();
    assert_ne!(outputs[0].flags & flags::RESUMED, 0);
    assert_eq!(outputs[1].flags & flags::RESUMED, 0);
    let worst = outputs.iter().zip(&truths[980..]).map(|(o, t)| (o.mu_w - t.mu_w).abs()).fold(0.0, f64::max);
    println!(
        "restart after 0.8 s: adhesion off by at most {worst:.4}, pad sigma {:.4}",
        outputs[0].mu_b_mean_sigma
    );
    assert!(worst < 0.004);
    assert!(outputs[0].mu_b_mean_sigma < 1.2 * first.last().mu_b_mean_sigma);
    assert!((outputs[0].mu_b_mean - 0.35).abs() < 0.01);
}

#[test]
fn resuming_without_a_pause_changes_nothing() {
    for filter in ["default", "paper", "rig"] {
        let config = EstimatorConfig { filter: filter.into(), ..EstimatorConfig::default() };
        let (inputs, _) = stop();
        let mut first = WagonEstimator::new(&config, &vehicle()).unwrap();
        inputs[..900].iter().for_each(|input| {
            first.step(input);
        });
        let mut second = WagonEstimator::new(&config, &vehicle()).unwrap();
        second.restore(&first.snapshot()).unwrap();
        for input in &inputs[900..] {
            let (a, b) = (first.step(input), second.step(input));
            assert_eq!(EstimatorOutput { flags: 0, ..a }, EstimatorOutput { flags: 0, ..b }, "{filter}");
        }
    }
}

#[test]
fn a_start_without_snapshot_in_the_middle_of_braking_converges() {
    let (inputs, truths) = stop();
    let outputs = estimate(&inputs[900..]);
    let settled = worst(&outputs, &truths[900..], 50..300);
    println!("cold start in braking: off by {:.4} from 0.5 s on", settled.0);
    assert!(settled.0 < 0.02);
    assert_ne!(outputs[0].flags & (flags::RESTARTED | flags::CONVERGING), 0);
    let pads = (outputs[300].mu_b_mean - 0.35).abs();
    assert!(pads < 0.01, "{pads}");
}

#[test]
fn foreign_snapshots_are_refused() {
    let (inputs, _) = stop();
    let mut first = estimator();
    inputs[..300].iter().for_each(|input| {
        first.step(input);
    });
    let good = first.snapshot();
    let paper = EstimatorConfig { filter: "paper".into(), ..EstimatorConfig::default() };
    let mut other = WagonEstimator::new(&paper, &vehicle()).unwrap();
    assert!(matches!(other.restore(&good), Err(FilterError::SnapshotFilter { .. })));
    let mut heavier = vehicle();
    heavier.body.mass_kg += 1.0;
    let mut other = WagonEstimator::new(&EstimatorConfig::default(), &heavier).unwrap();
    assert_eq!(other.restore(&good), Err(FilterError::SnapshotVehicle));
    let mut broken = good.clone();
    broken.state.covariance[0] = -1.0;
    assert_eq!(estimator().restore(&broken), Err(FilterError::SnapshotUnsound));
    broken.state.covariance.pop();
    assert!(matches!(estimator().restore(&broken), Err(FilterError::SnapshotShape { .. })));
}

#[test]
fn standing_and_starting_again_is_quiet() {
    let standing = WagonSample {
        v_m_s: 0.01,
        wheel_speed_rad_s: [0.0, 0.0, f64::NAN, f64::NAN],
        pressing_force_n: [8e4, 8e4, f64::NAN, f64::NAN],
        drive_torque_nm: [0.0; 4],
        grade_rad: 0.005,
        ..WagonSample::missing(0.0)
    };
    let mut estimator = estimator();
    let mut last = EstimatorOutput::default();
    for i in 0..2000 {
        last = estimator.step(&WagonSample { time_s: 0.01 * f64::from(i), ..standing });
        assert!(last.mu_w.is_finite() && last.mu_w_sigma.is_finite());
    }
    assert!(last.v_m_s.abs() < 0.05 && last.mu_w.abs() < 0.01, "{last:?}");
}

#[test]
fn nothing_measured_yet_is_no_start() {
    let mut estimator = estimator();
    let out = estimator.step(&WagonSample::missing(0.0));
    assert_ne!(out.flags & flags::PREDICTED, 0);
    let (inputs, _) = drive(support::plant::Order {
        seed: 1,
        start_m_s: 20.0,
        seconds: 2.0,
        force_n: &mut |_, _| [0.0; 2],
        adhesion: &|_| 0.3,
        pads: [1.0; 2],
    });
    assert_ne!(estimator.step(&inputs[0]).flags & flags::RESTARTED, 0);
}
