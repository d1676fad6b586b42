//! Is the default filter as accurate as it says, and as quick as it must be? On clean simulated data with known truth.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]

mod support;

use railgrip_filter::core::chi_square_mean_band;
use railgrip_filter::{EstimatorConfig, EstimatorOutput};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use support::plant::{Order, drive, dry_stop, protected, vehicle};
use support::{Truth, estimate};

fn adhesion_rmse(outputs: &[EstimatorOutput], truths: &[Truth]) -> f64 {
    let squares: f64 =
        outputs.iter().zip(truths).skip(100).map(|(out, truth)| (out.mu_w - truth.mu_w).powi(2)).sum();
    (squares / (outputs.len() - 100) as f64).sqrt()
}

/// NIS and NEES of the default filter over 60 seeds, pads drawn from its own prior (10 % together, 6.5 % apart).
///
/// The plant is not the filter's model with its noise: pads, wind and grade stand still here and the filter must allow
/// for their moving, so that it may be too careful (it is: late in a stop intervals are three times too wide) but not too
/// sure. NEES of the adhesion is therefore held below the upper χ² bound only; NIS, which sensor noise rules, on both
/// sides, with 3 % for the model's linear creep.
#[test]
fn default_is_as_accurate_as_it_says_over_sixty_seeds() {
    const SEEDS: u64 = 60;
    let (mut nis, mut count, mut nees) = (0.0, 0.0, [0.0; 3]);
    for seed in 0..SEEDS {
        let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(900 + seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let (common, apart) = (0.10 * normal(), 0.065 * normal());
        let (inputs, truths) = dry_stop(seed, 4e4, [1.0 + common + apart, 1.0 + common - apart]);
        let outputs = estimate(&EstimatorConfig::default(), &vehicle(), &inputs);
        nis += outputs.iter().skip(100).map(|out| out.nis).sum::<f64>();
        count += (outputs.len() - 100) as f64;
        // Coasting, braking, late in the stop: one instant each a seed, so that errors are independent.
        for (sum, at) in nees.iter_mut().zip([350, 800, 1400]) {
            let (out, truth) = (&outputs[at], &truths[at]);
            *sum += ((out.mu_w - truth.mu_w) / out.mu_w_sigma).powi(2) / SEEDS as f64;
        }
    }
    let band = chi_square_mean_band(3.0, count, 3.0);
    let upper = chi_square_mean_band(1.0, SEEDS as f64, 3.0).high;
    println!(
        "default over {SEEDS} seeds: mean NIS {:.3} (band {:.3} to {:.3}, 3 % beside), NEES of adhesion {nees:.2?} (at most {upper:.2})",
        nis / count,
        band.low,
        band.high
    );
    assert!((0.97 * band.low..=1.03 * band.high).contains(&(nis / count)));
    assert!(nees.iter().all(|nees| (0.0..=upper).contains(nees)));
}

#[test]
fn pads_and_adhesion_are_found_with_honest_intervals() {
    let (mut inside, mut count) = ([0.0; 2], 0.0);
    for seed in 20..26 {
        let (inputs, truths) = dry_stop(seed, 5e4, [0.9, 1.08]);
        let outputs = estimate(&EstimatorConfig::default(), &vehicle(), &inputs);
        let rmse = adhesion_rmse(&outputs, &truths);
        let last = outputs.last().unwrap();
        let mean = 0.35 * 0.99;
        println!(
            "seed {seed}: adhesion RMSE {rmse:.5}; pads {:.4} ± {:.4}, {:.4} ± {:.4}, mean {:.4} ± {:.4} (truth 0.3150, 0.3780, {mean:.4})",
            last.mu_b[0],
            last.mu_b_sigma[0],
            last.mu_b[1],
            last.mu_b_sigma[1],
            last.mu_b_mean,
            last.mu_b_mean_sigma
        );
        assert!(rmse < 0.0015);
        assert!((last.mu_b_mean - mean).abs() < 0.005);
        for (out, truth) in outputs.iter().zip(&truths).skip(100) {
            count += 1.0;
            inside[0] += f64::from(u8::from((out.mu_w - truth.mu_w).abs() < 1.96 * out.mu_w_sigma));
            let braking = out.pressing_force_n[0] > 3e4;
            let held = (out.mu_b[0] - truth.mu_b[0]).abs() < 1.96 * out.mu_b_sigma[0];
            inside[1] += f64::from(u8::from(!braking || held));
        }
    }
    println!("95 % intervals hold adhesion {:.3}, front pad {:.3}", inside[0] / count, inside[1] / count);
    assert!(inside[0] / count > 0.9);
    assert!(inside[1] / count > 0.9);
}

#[test]
fn pad_friction_is_held_and_flagged_while_the_brake_is_off() {
    let (inputs, _) = drive(Order {
        seed: 3,
        start_m_s: 45.0,
        seconds: 75.0,
        force_n: &mut |time_s, _| {
            let since_s = if time_s > 60.0 { time_s - 60.0 } else { time_s - 5.0 };
            let on = (5.0..12.0).contains(&time_s) || time_s > 60.0;
            [if on { 4e4 * (since_s / 0.7).min(1.0) } else { 0.0 }; 2]
        },
        adhesion: &|_| 0.3,
        pads: [1.05, 1.05],
    });
    let outputs = estimate(&EstimatorConfig::default(), &vehicle(), &inputs);
    let at = |time_s: f64| &outputs[(100.0 * time_s) as usize];
    let (end, held, late, again) = (at(11.9), at(13.0), at(59.0), at(64.0));
    println!(
        "mean pad sigma: end of braking {:.4}, 1 s later {:.4}, 47 s later {:.4}, braking again {:.4}; ranks {} {}",
        end.mu_b_mean_sigma,
        held.mu_b_mean_sigma,
        late.mu_b_mean_sigma,
        again.mu_b_mean_sigma,
        end.observability_rank,
        held.observability_rank
    );
    assert!((late.mu_b_mean - end.mu_b_mean).abs() < 0.01, "held: {} {}", late.mu_b_mean, end.mu_b_mean);
    assert!(late.mu_b_mean_sigma > 3.0 * end.mu_b_mean_sigma && late.mu_b_mean_sigma < 0.036);
    assert_eq!(held.observable | late.observable, 0);
    assert!(again.mu_b_mean_sigma < 1.5 * end.mu_b_mean_sigma);
    assert!((again.mu_b_mean - 0.35 * 1.05).abs() < 0.006);
    let best = outputs[500..1200].iter().map(|out| out.observability_rank).max();
    println!("best rank while braking {best:?}");
    assert_eq!((best, held.observability_rank), (Some(7), 5));
}

#[test]
fn a_jump_of_adhesion_is_followed_within_a_tenth_of_a_second() {
    for seed in 40..44 {
        // Sliding on a rail of 0.05 that becomes 0.10 at once, and back.
        let (inputs, truths) = drive(Order {
            seed,
            start_m_s: 33.0,
            seconds: 18.0,
            force_n: &mut protected(|time_s| if time_s > 3.0 { 1.1e5 } else { 0.0 }),
            adhesion: &|time_s| if (8.0..12.0).contains(&time_s) { 0.10 } else { 0.05 },
            pads: [1.0, 1.05],
        });
        let outputs = estimate(&EstimatorConfig::default(), &vehicle(), &inputs);
        let error = |index: usize| (outputs[index].mu_w - truths[index].mu_w).abs();
        // An excursion is a stretch of samples off by more than 0.02; the longest must end within 0.1 s.
        let (mut longest, mut present) = (0, 0);
        for index in 100..outputs.len() {
            present = if error(index) > 0.02 { present + 1 } else { 0 };
            longest = longest.max(present);
        }
        let rmse = adhesion_rmse(&outputs, &truths);
        let jump = (700..1300).map(|i| (truths[i].mu_w - truths[i - 10].mu_w).abs()).fold(0.0, f64::max);
        println!(
            "seed {seed}: RMSE {rmse:.5}, fastest change {jump:.3} in 0.1 s, longest excursion {longest} samples"
        );
        assert!(jump > 0.03, "the plant must jump for the test to mean something");
        assert!(longest <= 10);
        assert!(rmse < 0.006);
    }
}
