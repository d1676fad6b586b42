//! Every departure changes the recordings in the way its physics says.

// Tests print the figures that they measure, from helpers too.
#![allow(clippy::print_stdout)]

mod common;

use common::{Pair, coasting_retardation, mean, onset, pad_friction};
use railgrip_truth_plant::plant::{Row, Run, SAMPLE_S, Truth};

/// Adhesion that a sliding wheelset gets, over the samples that pass.
fn sliding_adhesion(pair: &Pair, run: &Run, wheelset: usize, pass: impl Fn(f64, &Truth) -> bool) -> f64 {
    let slide = |truth: &&Truth| pass(pair.slide_m_s(truth, wheelset), truth);
    mean(run.truth.iter().filter(slide).map(|truth| truth.mu_w_wheelset[wheelset].abs()))
}

/// Mean of shown less true over the samples that pass.
fn shown_less_true(
    run: &Run,
    difference: impl Fn(&Row, &Truth) -> f64,
    pass: impl Fn(usize, &Truth) -> bool,
) -> f64 {
    let both = run.rows.iter().zip(&run.truth).enumerate();
    mean(
        both.filter(|(sample, (_, truth))| pass(*sample, truth))
            .map(|(_, (row, truth))| difference(row, truth)),
    )
}

/// Samples of steady braking: after build-up, before the end.
fn steady(run: &Run) -> impl Fn(usize, &Truth) -> bool {
    let (from, to) = (onset(run) + 300, run.truth.len() - 100);
    move |sample, _| (from..to).contains(&sample)
}

fn assert_above(what: &str, value: f64, bound: f64) {
    println!("{what}: {value:.4}, above {bound:.4}");
    assert!(value > bound, "{what}: {value} is not above {bound}");
}

#[test]
fn pads_grip_more_at_low_speed() {
    let run = Pair::new("brake_friction_speed", 1.5).with("dry_stop");
    let slow = pad_friction(&run, |_, truth| truth.v_m_s < 4.0);
    let fast = pad_friction(&run, |_, truth| truth.v_m_s > 15.0);
    assert_above("friction slow over fast", slow / fast, 1.08);
}

#[test]
fn hot_pads_fade() {
    let run = Pair::new("brake_fade", 1.5).with("dry_stop");
    let from = onset(&run) + 150;
    let early = pad_friction(&run, |sample, _| (from..from + 100).contains(&sample));
    let late = pad_friction(&run, |sample, _| sample > run.truth.len() - 200);
    assert_above("friction cold over hot", early / late, 1.05);
}

#[test]
fn pads_grip_less_under_force() {
    let pair = Pair::new("brake_friction_pressure", 1.5);
    let (full, partial) = (pair.with("dry_stop"), pair.with("dry_partial"));
    let ratio = pad_friction(&partial, steady(&partial)) / pad_friction(&full, steady(&full));
    assert_above("friction partial over full", ratio, 1.05);
}

#[test]
fn wet_discs_dry_in_the_first_braking() {
    let run = Pair::new("brake_wet_delay", 1.5).with("dry_stop");
    let from = onset(&run) + 20;
    let first = pad_friction(&run, |sample, _| (from..from + 50).contains(&sample));
    let last = pad_friction(&run, |sample, _| sample > run.truth.len() - 300);
    assert_above("friction dried over wet", last / first, 1.15);
}

#[test]
fn slow_rigging_lags_the_cylinder() {
    let pair = Pair::new("brake_lag", 1.0);
    let run = pair.with("dry_stop");
    let from = onset(&run);
    let early = |run: &Run| pad_friction(run, |sample, _| (from..from + 20).contains(&sample));
    assert_above("torque in time over late", early(&pair.without("dry_stop")) / early(&run), 2.0);
    let settled = pad_friction(&run, steady(&run)) / pad_friction(&pair.without("dry_stop"), steady(&run));
    println!("settled ratio {settled:.4}");
    assert!((settled - 1.0).abs() < 0.01, "once settled, nothing is missing");
}

#[test]
fn dahl_rigging_gives_less_rising_than_falling() {
    let run = Pair::new("rigging_hysteresis", 1.5).with("dry_steps");
    let change = |sample: usize| {
        let force = |at: usize| run.rows[at].pressing_force_n[0];
        if sample < 10 || sample + 10 >= run.rows.len() {
            0.0
        } else {
            force(sample + 10) - force(sample - 10)
        }
    };
    let held = |sample: usize| run.rows[sample].pressing_force_n[0] > 8e3;
    let rising = pad_friction(&run, |sample, _| held(sample) && change(sample) > 3e3);
    let falling = pad_friction(&run, |sample, _| held(sample) && change(sample) < -3e3);
    assert_above("friction falling over rising", falling / rising, 1.08);
}

#[test]
fn a_return_spring_takes_its_share_first() {
    let pair = Pair::new("pressing_force_offset", 1.5);
    let run = pair.with("dry_steps");
    let threshold_n = pair.parameter("threshold_n");
    let force = |sample: usize| run.rows[sample].pressing_force_n[0];
    let low = pad_friction(&run, |sample, _| (2e3..1.2 * threshold_n).contains(&force(sample)));
    let high = pad_friction(&run, |sample, _| force(sample) > 5.0 * threshold_n);
    assert_above("friction high over low force", high / low, 1.8);
}

#[test]
fn a_dragging_brake_holds_one_wheelset() {
    let pair = Pair::new("dragging_brake", 2.0);
    let run = pair.with("dry_stop");
    let wheelset = pair.parameter("wheelset") as usize;
    let coasting = &run.truth[50..250];
    let lag = mean(coasting.iter().map(|truth| truth.contact_n[1 - wheelset] - truth.contact_n[wheelset]));
    let expected = pair.parameter("torque_nm") / pair.wagon.radius_m[wheelset];
    println!("extra drag {lag:.0} N, expected {expected:.0} N");
    assert!((lag / expected - 1.0).abs() < 0.1);
}

#[test]
fn adhesion_falls_with_slip_velocity() {
    let pair = Pair::new("falling_friction", 1.5);
    let run = pair.with("low_stop");
    let gentle = sliding_adhesion(&pair, &run, 0, |slide, _| (0.1..0.5).contains(&slide));
    let deep = sliding_adhesion(&pair, &run, 0, |slide, truth| slide > 1.5 && truth.v_m_s > 5.0);
    assert_above("adhesion gentle over deep", gentle / deep, 1.15);
}

#[test]
fn the_rear_wheelset_finds_cleaner_rail() {
    let pair = Pair::new("self_cleaning", 1.5);
    let run = pair.with("low_stop");
    let largest = |k: usize| run.truth.iter().map(|truth| truth.mu_w_wheelset[k].abs()).fold(0.0, f64::max);
    assert_above("largest adhesion rear over leading", largest(1) / largest(0), 1.12);
}

#[test]
fn the_patch_is_slippery_and_stays_where_it_is() {
    let pair = Pair::new("low_adhesion_patch", 1.3);
    let run = pair.with("low_stop");
    let (from, to) = (pair.parameter("from_m") + 15.0, pair.parameter("to_m") - 15.0);
    let largest = |inside: bool| {
        let there =
            run.rows.iter().zip(&run.truth).filter(|(row, _)| (from..to).contains(&row.position_m) == inside);
        there.map(|(_, truth)| truth.mu_w_wheelset[0].abs()).fold(0.0, f64::max)
    };
    let limit = 0.065 * (1.0 - pair.parameter("loss"));
    println!("largest inside {:.4}, limit there {limit:.4}, outside {:.4}", largest(true), largest(false));
    assert!(largest(true) < 1.03 * limit);
    assert!(largest(false) > 0.05);
}

#[test]
fn adhesion_falls_with_speed() {
    let pair = Pair::new("adhesion_speed", 1.0);
    let run = pair.with("low_stop");
    let largest = |from: f64, to: f64| {
        let then = run.truth.iter().filter(|truth| (from..to).contains(&truth.v_m_s));
        then.map(|truth| truth.mu_w_wheelset[0].abs()).fold(0.0, f64::max)
    };
    let start = run.truth[onset(&run)].v_m_s;
    assert_above("largest adhesion slow over fast", largest(4.0, 10.0) / largest(start - 3.0, start), 1.08);
}

#[test]
fn sand_helps_while_it_lies() {
    let pair = Pair::new("sanding", 1.5);
    let (with, without) = (pair.with("low_stop"), pair.without("low_stop"));
    let largest = |run: &Run, sanding: bool| {
        let then = run.rows.iter().zip(&run.truth).filter(|(row, _)| row.sanding == sanding);
        then.map(|(_, truth)| truth.mu_w_wheelset[0].abs()).fold(0.0, f64::max)
    };
    assert_above(
        "largest adhesion with sand over without",
        largest(&with, true) / largest(&without, true),
        1.2,
    );
}

#[test]
fn load_transfer_scales() {
    let pair = Pair::new("load_transfer", 2.0);
    let transfer = |run: &Run| {
        let load = |truth: &Truth, k: usize| truth.contact_n[k] / truth.mu_w_wheelset[k];
        let braking = &run.truth[onset(run) + 200..onset(run) + 400];
        mean(braking.iter().map(|truth| load(truth, 0) - load(truth, 1)))
    };
    let ratio = transfer(&pair.with("dry_stop")) / transfer(&pair.without("dry_stop"));
    println!("transfer ratio {ratio:.3}, factor {:.3}", pair.parameter("factor"));
    assert!((ratio - pair.parameter("factor")).abs() < 0.02);
}

#[test]
fn a_heavier_wagon_gains_less_from_the_same_torque() {
    let pair = Pair::new("mass_error", 1.5);
    let gain = |run: &Run| run.truth[1500].v_m_s - run.truth[320].v_m_s;
    let ratio = gain(&pair.without("mixed")) / gain(&pair.with("mixed"));
    println!("gain without over with {ratio:.3}, mass error {:.3}", pair.parameter("relative"));
    assert!((ratio - 1.0).signum() == pair.parameter("relative").signum());
    assert!((ratio - 1.0).abs() > 0.5 * pair.parameter("relative").abs());
}

#[test]
fn more_turning_mass_recovers_more_slowly() {
    let pair = Pair::new("rotating_inertia", 2.0);
    let fastest = |run: &Run| {
        let rate =
            |k: usize, pair: &[Truth]| (pair[1].wheel_speed_rad_s[k] - pair[0].wheel_speed_rad_s[k]).abs();
        let rates = run.truth.windows(2).flat_map(|pair| [rate(0, pair), rate(1, pair)]);
        rates.fold(0.0, f64::max) / SAMPLE_S
    };
    assert_above(
        "fastest wheel without over with",
        fastest(&pair.without("low_stop")) / fastest(&pair.with("low_stop")),
        1.1,
    );
}

#[test]
fn a_smaller_wheel_turns_faster() {
    let pair = Pair::new("wheel_radius", 1.0);
    let run = pair.with("dry_stop");
    let wheelset = pair.parameter("wheelset") as usize;
    let speeds = |truth: &Truth| truth.wheel_speed_rad_s[wheelset] / truth.wheel_speed_rad_s[1 - wheelset];
    let ratio = mean(run.truth[..250].iter().map(speeds));
    println!("ratio {ratio:.5}, radius error {:.5}", pair.parameter("relative"));
    assert!((ratio * (1.0 + pair.parameter("relative")) - 1.0).abs() < 2e-4);
}

#[test]
fn an_unmapped_slope_slows_or_speeds_the_wagon_there() {
    let pair = Pair::new("grade", 1.5);
    let speed_after = |run: &Run| {
        let after = run.rows.iter().position(|row| row.position_m > pair.parameter("to_m") + 20.0).unwrap();
        run.truth[after].v_m_s
    };
    let change = speed_after(&pair.with("dry_steps")) - speed_after(&pair.without("dry_steps"));
    println!("speed after the stretch {change:+.3} m/s, slope {:+.4}", pair.parameter("slope_rad"));
    assert!(change * pair.parameter("slope_rad") < 0.0 && change.abs() > 0.05);
}

#[test]
fn resistance_wind_and_cold_bearings_slow_a_coasting_wagon() {
    for id in ["running_resistance", "headwind", "cold_bearings"] {
        let pair = Pair::new(id, 1.5);
        let extra =
            coasting_retardation(&pair.with("dry_stop")) - coasting_retardation(&pair.without("dry_stop"));
        assert_above(id, extra, 0.005);
    }
}

#[test]
fn a_neighbour_that_brakes_harder_holds_the_wagon_back() {
    let pair = Pair::new("coupler_force", 1.5);
    let (with, without) = (pair.with("dry_stop"), pair.without("dry_stop"));
    let later = onset(&with) + 800;
    let change = with.truth[later].v_m_s - without.truth[later].v_m_s;
    println!("after 8 s {change:+.3} m/s, ratio {:.3}", pair.parameter("ratio"));
    assert!(change * (pair.parameter("ratio") - 1.0) < 0.0 && change.abs() > 0.05);
}

#[test]
fn an_encoder_off_centre_ripples_with_speed_on_its_wheelset_only() {
    let pair = Pair::new("wheel_encoder_eccentricity", 1.5);
    let run = pair.with("dry_stop");
    let spread = |k: usize, fast: bool| {
        let square =
            |row: &Row, truth: &Truth| (row.wheel_speed_rad_s[k] - truth.wheel_speed_rad_s[k]).powi(2);
        shown_less_true(&run, square, |_, truth| (truth.v_m_s > 12.0) == fast).sqrt()
    };
    let wheelset = pair.parameter("wheelset") as usize;
    assert_above("ripple fast", spread(wheelset, true), 3.0 * spread(1 - wheelset, true));
    assert_above("ripple fast over slow", spread(wheelset, true) / spread(wheelset, false), 2.0);
}

#[test]
fn a_counting_window_lags_by_half_its_length() {
    let pair = Pair::new("wheel_encoder_window", 1.5);
    let run = pair.with("dry_stop");
    let error = |row: &Row, truth: &Truth| row.wheel_speed_rad_s[0] - truth.wheel_speed_rad_s[0];
    let slowing = mean(
        run.truth
            .windows(2)
            .enumerate()
            .filter(|(s, w)| steady(&run)(*s, &w[0]))
            .map(|(_, w)| (w[0].wheel_speed_rad_s[0] - w[1].wheel_speed_rad_s[0]) / SAMPLE_S),
    );
    let lag_s = shown_less_true(&run, error, steady(&run)) / slowing;
    let expected_s = (pair.parameter("window_s") - SAMPLE_S) / 2.0;
    println!("lag {lag_s:.4} s, expected {expected_s:.4} s");
    assert!((lag_s / expected_s - 1.0).abs() < 0.1);
}

#[test]
fn a_slow_clock_lags_more_and_more() {
    let pair = Pair::new("clock_skew", 2.0);
    let run = pair.with("dry_stop");
    let error = |row: &Row, truth: &Truth| row.wheel_speed_rad_s[1] - truth.wheel_speed_rad_s[1];
    let from = onset(&run) + 200;
    let early = shown_less_true(&run, error, |sample, _| (from..from + 300).contains(&sample));
    let late = shown_less_true(&run, error, |sample, _| sample > run.truth.len() - 300);
    assert_above("lag late over early", late / early, 1.5);
}

#[test]
fn a_late_speed_sensor_reads_high_in_braking() {
    let pair = Pair::new("speed_latency", 1.0);
    let run = pair.with("dry_stop");
    let reads = shown_less_true(&run, |row, truth| row.v_m_s - truth.v_m_s, steady(&run));
    let braking = &run.truth[onset(&run) + 300..run.truth.len() - 100];
    let slowing =
        (braking[0].v_m_s - braking[braking.len() - 1].v_m_s) / ((braking.len() - 1) as f64 * SAMPLE_S);
    println!("lag {:.4} s, latency {:.4} s", reads / slowing, pair.parameter("latency_s"));
    assert!((reads / slowing / pair.parameter("latency_s") - 1.0).abs() < 0.06);
}

#[test]
fn a_wrong_scale_is_proportional_to_speed() {
    let pair = Pair::new("speed_scale", 1.0);
    let run = pair.with("dry_stop");
    let ratio =
        shown_less_true(&run, |row, truth| row.v_m_s / truth.v_m_s - 1.0, |_, truth| truth.v_m_s > 10.0);
    println!("scale {ratio:.5}, drawn {:.5}", pair.parameter("relative"));
    assert!((ratio / pair.parameter("relative") - 1.0).abs() < 0.15);
}

#[test]
fn a_soft_shaft_rings_when_the_torque_changes() {
    let pair = Pair::new("axle_torsion", 1.5);
    let run = pair.with("low_stop");
    let ringing = |run: &Run| {
        let square =
            |row: &Row, truth: &Truth| (row.wheel_speed_rad_s[0] - truth.wheel_speed_rad_s[0]).powi(2);
        shown_less_true(run, square, |sample, _| sample > onset(run)).sqrt()
    };
    assert_above("ringing", ringing(&run), 2.0 * ringing(&pair.without("low_stop")));
}

#[test]
fn a_track_brake_helps_at_full_braking_only() {
    let pair = Pair::new("track_brake_at_full_braking", 2.0);
    let slower = |name: &str| {
        let (with, without) = (pair.with(name), pair.without(name));
        let later = onset(&with) + 500;
        without.truth[later].v_m_s - with.truth[later].v_m_s
    };
    assert_above("slower by full braking", slower("dry_stop"), 0.2);
    let partial = slower("dry_partial");
    println!("slower by partial braking: {partial:.4}");
    assert!(partial < 0.1 * slower("dry_stop"));
}

#[test]
fn fresh_pads_bite_at_every_application() {
    let run = Pair::new("initial_bite", 1.5).with("dry_steps");
    let applications = run.order.demand.iter().filter(|(_, share)| *share > 0.0).take(3);
    for (from_s, _) in applications {
        let from = (from_s / SAMPLE_S) as usize;
        let first = pad_friction(&run, |sample, _| (from + 20..from + 70).contains(&sample));
        let later = pad_friction(&run, |sample, _| (from + 320..from + 390).contains(&sample));
        assert_above("bite", first / later, 1.05);
    }
}

#[test]
fn an_uneven_disc_swings_around_its_level() {
    let pair = Pair::new("pad_friction_periodic_with_wheel_angle", 1.5);
    let (with, without) = (pair.with("dry_stop"), pair.without("dry_stop"));
    let spread = |run: &Run| {
        let level = pad_friction(run, steady(run));
        let all = run.truth.iter().enumerate().filter(|(sample, truth)| steady(run)(*sample, truth));
        mean(all.flat_map(|(_, truth)| truth.mu_b[0]).map(|friction| (friction / level - 1.0).powi(2))).sqrt()
    };
    assert_above("swing", spread(&with), 5.0 * spread(&without));
}

#[test]
fn sliding_conditions_the_contact() {
    let pair = Pair::new("contact_conditioning_by_sliding", 2.0);
    let largest = |run: &Run| run.truth.iter().map(|truth| truth.mu_w_wheelset[0].abs()).fold(0.0, f64::max);
    assert_above("adhesion", largest(&pair.with("low_stop")) / largest(&pair.without("low_stop")), 1.1);
}

#[test]
fn a_radar_swings_with_the_place() {
    let pair = Pair::new("speed_ripple_with_position", 1.0);
    let run = pair.with("dry_stop");
    let square = |row: &Row, truth: &Truth| (row.v_m_s - truth.v_m_s).powi(2);
    let swing = shown_less_true(&run, square, |_, truth| truth.v_m_s > 12.0).sqrt();
    assert_above("swing", swing, 0.06);
}

#[test]
fn a_disturbed_tachometer_reads_low_under_the_brake() {
    let pair = Pair::new("tachometer_disturbed_by_braking", 1.0);
    let run = pair.with("dry_stop");
    let k = pair.parameter("wheelset") as usize;
    let relative = |row: &Row, truth: &Truth| 1.0 - row.wheel_speed_rad_s[k] / truth.wheel_speed_rad_s[k];
    let reads = shown_less_true(&run, relative, steady(&run));
    println!("reads low by {reads:.4}, drawn {:.4}", pair.parameter("relative"));
    assert!((reads / pair.parameter("relative") - 1.0).abs() < 0.2);
}

#[test]
fn a_weak_drive_gains_less_than_its_torque_says() {
    let pair = Pair::new("drive_torque_short_of_command", 1.0);
    let gain = |run: &Run| run.truth[1500].v_m_s - run.truth[320].v_m_s;
    assert_above(
        "gain as commanded over real",
        gain(&pair.without("mixed")) / gain(&pair.with("mixed")),
        1.08,
    );
}

#[test]
fn a_leaking_cylinder_presses_less_and_less() {
    let pair = Pair::new("leaking_cylinder", 1.0);
    let run = pair.with("dry_stop");
    let k = pair.parameter("wheelset") as usize;
    let level =
        |from: usize, to: usize, k: usize| mean(run.truth[from..to].iter().filter_map(|truth| truth.mu_b[k]));
    let (from, last) = (onset(&run) + 100, run.truth.len() - 1);
    let fall = |k: usize| level(from, from + 100, k) / level(last - 100, last, k);
    assert_above("fall of the leaking side", fall(k), 1.1);
    assert!((fall(1 - k) - 1.0).abs() < 0.03);
}
