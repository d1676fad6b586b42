//! The train in motion: momentum, energy, wheel-slide protection, standstill, faults, whole runs.

mod common;

use common::{coach, samples, scenario};
use railgrip_recording::Strictness;
use railgrip_simulation::{Scenario, Train, WagonSample, run};
use railgrip_vehicle::{EffectEntry, GRAVITY_M_S2};
use std::path::Path;

const FULL_BRAKE_ON_LOW: &str = "
[[demand]]
from_s = 0.0
coast = true
[[demand]]
from_s = 2.0
brake = 1.0
[[rail]]
from_m = -500.0
condition = \"low\"
";

fn rim_m_s(sample: &WagonSample, wheelset: usize) -> f64 {
    0.45 * sample.truth.wheel_speed_rad_s[wheelset]
}

/// Longest time, s, that any wheelset stands still while the wagon moves faster than 3 m/s.
fn longest_lock_s(samples: &[WagonSample]) -> f64 {
    let locked = |sample: &WagonSample, i: usize| sample.truth.row.v_m_s > 3.0 && rim_m_s(sample, i) < 0.3;
    let longest = |i: usize| {
        samples.split(|sample| !locked(sample, i)).map(<[WagonSample]>::len).max().unwrap_or_default()
    };
    0.01 * longest(0).max(longest(1)) as f64
}

/// Share of the adhesion that the rail offers while full braking asks for more, at more than 3 m/s.
fn adhesion_share(samples: &[WagonSample]) -> f64 {
    let sliding = samples.iter().filter(|s| s.truth.row.t_s > 6.0 && s.truth.row.v_m_s > 3.0);
    let (sum, count) = sliding.fold((0.0, 0.0), |(sum, count), s| {
        (
            sum + -s.truth.row.mu_w / (0.5 * (s.truth.adhesion_available[0] + s.truth.adhesion_available[1])),
            count + 1.0,
        )
    });
    sum / count
}

#[test]
fn slide_protection_prevents_locking_and_uses_the_adhesion() {
    for (name, track) in [
        ("constant friction", ""),
        ("falling friction", "[track]\nfriction_ratio = 0.4\nfriction_decay_s_per_m = 0.3\n"),
    ] {
        let with = samples(&scenario(70.0, 30.0, 1, &format!("{FULL_BRAKE_ON_LOW}{track}")), 3, 0);
        let without = samples(
            &scenario(70.0, 30.0, 1, &format!("{FULL_BRAKE_ON_LOW}{track}[wsp]\nenabled = false\n")),
            3,
            0,
        );
        let (kept, lost) = (longest_lock_s(&with), longest_lock_s(&without));
        let (used, used_locked) = (adhesion_share(&with), adhesion_share(&without));
        println!(
            "{name}: locked at most {kept:.2} s (without protection {lost:.2} s), adhesion used {used:.3} (without {used_locked:.3})"
        );
        assert!(lost > 5.0, "without protection the wheels must lock, or the test shows nothing");
        assert!(kept < 0.4, "a wheelset locked for {kept} s");
        assert!(used > 0.75, "only {used} of the adhesion is used");
        let active = |s: &WagonSample| s.row.wsp_active[0] > 0.0 || s.row.wsp_active[1] > 0.0;
        let share = with[600..4000].iter().filter(|s| active(s)).count() as f64 / 3400.0;
        assert!(share > 0.8, "protection is active {share} of the time");
        assert!(without.iter().all(|s| !active(s)));
    }
}

#[test]
fn slide_protection_stays_quiet_on_dry_rail() {
    let lines = "[[demand]]\nfrom_s = 0.0\nbrake = 1.0\n";
    let samples = samples(&scenario(40.0, 35.0, 1, lines), 3, 0);
    assert!(samples.iter().all(|s| s.row.wsp_active[0] == 0.0 && s.row.wsp_active[1] == 0.0));
    let fastest = samples.iter().map(|s| s.truth.acceleration_m_s2).fold(0.0, f64::min);
    println!("full service braking decelerates by {:.3} m/s²", -fastest);
    assert!((1.0..1.35).contains(&-fastest), "full service braking is declared as 1.1 m/s²");
}

/// m v̇ = Σ F_x − R − m g sin(grade), integrated over the run, and the work of the same forces.
#[test]
fn momentum_and_energy_balance_over_a_run() {
    let lines = "
[[demand]]
from_s = 0.0
traction = 0.6
[[demand]]
from_s = 15.0
brake = 0.8
[[rail]]
from_m = -500.0
condition = \"dry\"
[[rail]]
from_m = 350.0
condition = \"low\"
[[grade]]
from_m = 0.0
grade_rad = 0.004
[disturbance]
gust_sigma_m_s = 0.0
";
    let samples = samples(&scenario(60.0, 15.0, 1, lines), 3, 0);
    let mass_kg = 41e3;
    let (mut impulse, mut work, mut scale) = (0.0, 0.0, 0.0);
    for pair in samples.windows(2) {
        let force = |s: &WagonSample| {
            let t = &s.truth;
            let contact: f64 = t.contact_force_n.iter().sum();
            contact - t.resistance_n - mass_kg * GRAVITY_M_S2 * 0.004f64.sin()
        };
        let (before, after) = (&pair[0], &pair[1]);
        impulse += 0.005 * (force(before) + force(after));
        work += 0.005 * (force(before) * before.truth.row.v_m_s + force(after) * after.truth.row.v_m_s);
        scale += 0.01 * force(before).abs();
    }
    let (first, last) = (samples[0].truth.row.v_m_s, samples[samples.len() - 1].truth.row.v_m_s);
    let momentum = mass_kg * (last - first);
    let energy = 0.5 * mass_kg * (last * last - first * first);
    println!("momentum {momentum:.0} N s, impulse {impulse:.0} N s; energy {energy:.0} J, work {work:.0} J");
    assert!((momentum - impulse).abs() < 2e-3 * scale);
    assert!((energy - work).abs() < 2e-3 * scale * first);
}

#[test]
fn a_braked_train_stands_still_and_starts_again() {
    let lines = "
[[demand]]
from_s = 0.0
brake = 0.7
[[demand]]
from_s = 30.0
traction = 0.5
[[grade]]
from_m = -100.0
grade_rad = 0.003
";
    let samples = samples(&scenario(45.0, 10.0, 1, lines), 3, 0);
    let standing = &samples[2000..2900];
    let crept = standing[899].truth.position_m - standing[0].truth.position_m;
    let fastest = standing.iter().map(|s| s.truth.row.v_m_s.abs()).fold(0.0, f64::max);
    println!("standing: crept {:.4} m in 9 s, fastest {fastest:.5} m/s", crept);
    assert!(crept.abs() < 0.02 && fastest < 5e-3);
    assert!(
        standing.iter().all(|s| s.truth.wheel_speed_rad_s[..2] == [0.0, 0.0]),
        "the brake holds the wheels"
    );
    assert!(samples.iter().all(|s| s.truth.row.v_m_s.is_finite() && s.truth.row.v_m_s > -0.01));
    assert!(samples[samples.len() - 1].truth.row.v_m_s > 3.0, "it leaves again");
}

#[test]
fn braking_starts_later_at_the_end_of_the_train() {
    let lines = "[[demand]]\nfrom_s = 0.0\ncoast = true\n[[demand]]\nfrom_s = 2.0\nbrake = 0.6\n";
    let scenario = scenario(8.0, 25.0, 8, lines);
    let onset_s = |wagon: usize| {
        let samples = samples(&scenario, 1, wagon);
        samples
            .iter()
            .find(|s| s.truth.pressing_force_n[0] > 1e3)
            .map(|s| s.truth.row.t_s)
            .expect("it brakes")
    };
    let delay_s = onset_s(7) - onset_s(0);
    println!("the eighth wagon brakes {delay_s:.2} s after the first");
    assert!((delay_s - 7.0 * 26.4 / 280.0).abs() < 0.03);
}

#[test]
fn rail_is_met_by_position_wheelset_after_wheelset() {
    let lines = "[[demand]]\nfrom_s = 0.0\ncoast = true\n[[rail]]\nfrom_m = -900.0\ncondition = \"dry\"\n\
                 [[rail]]\nfrom_m = 100.0\ncondition = \"wet\"\n[track]\ntransition_m = 0.0\n";
    let scenario = scenario(15.0, 20.0, 3, lines);
    let change_m = |wagon: usize, wheelset: usize| {
        let samples = samples(&scenario, 1, wagon);
        let met = samples
            .iter()
            .find(|s| s.truth.adhesion_available[wheelset] < 0.2)
            .expect("it meets the wet rail");
        (met.truth.position_m, met.truth.row.t_s)
    };
    let (front_m, front_s) = change_m(0, 0);
    let (rear_m, rear_s) = change_m(0, 1);
    assert!((front_m - 94.0).abs() < 0.3 && (rear_m - 106.0).abs() < 0.3, "{front_m} {rear_m}");
    assert!((rear_s - front_s - 12.0 / 20.0).abs() < 0.05);
    let (_, third_s) = change_m(2, 0);
    assert!((third_s - front_s - 52.8 / 20.0).abs() < 0.1, "{third_s}");
}

#[test]
fn one_wagon_can_differ_from_the_others() {
    let lines = format!(
        "{FULL_BRAKE_ON_LOW}[[wagon]]\nnumber = 2\nadhesion_factor = 6.0\npad_friction_factors = [1.0, 0.5]\n\
                         [disturbance]\npad_friction_sigma = 0.0\npad_friction_spread = 0.0\n"
    );
    let scenario = scenario(20.0, 25.0, 2, &lines);
    let (first, second) = (samples(&scenario, 1, 0), samples(&scenario, 1, 1));
    let end = |samples: &[WagonSample]| samples[samples.len() - 1];
    assert!(end(&second).truth.row.v_m_s < end(&first).truth.row.v_m_s - 3.0);
    let pads = end(&second).truth.row.mu_b;
    assert!((pads[0] - 0.35).abs() < 1e-9 && (pads[1] - 0.175).abs() < 1e-9, "{pads:?}");
    assert!(second.iter().all(|s| s.row.wsp_active[0] == 0.0));
}

#[test]
fn couplers_keep_wagons_together_and_cancel_out() {
    let base = format!("{FULL_BRAKE_ON_LOW}[[wagon]]\nnumber = 2\nadhesion_factor = 5.0\n");
    let coupled = format!("{base}[couplers]\nstiffness_n_per_m = 5.0e6\ndamping_n_s_per_m = 2.0e5\n");
    let spread = |lines: &str| {
        let scenario = scenario(20.0, 25.0, 3, lines);
        let speeds: Vec<f64> =
            (0..3).map(|wagon| samples(&scenario, 1, wagon)[1900].truth.row.v_m_s).collect();
        speeds.iter().copied().fold(f64::MIN, f64::max) - speeds.iter().copied().fold(f64::MAX, f64::min)
    };
    let (free, tied) = (spread(&base), spread(&coupled));
    println!("speeds differ by {free:.2} m/s uncoupled, {tied:.3} m/s coupled");
    assert!(free > 3.0 && tied < 0.2);
    // In a train of equals coupler forces vanish but for the delay of the brake command.
    let equal = scenario(
        20.0,
        25.0,
        3,
        "[[demand]]\nfrom_s = 0.0\ncoast = true\n[couplers]\nstiffness_n_per_m = 5.0e6\ndamping_n_s_per_m = 2.0e5\n[disturbance]\ngust_sigma_m_s = 0.0\n",
    );
    let last: Vec<f64> = (0..3).map(|wagon| samples(&equal, 1, wagon)[1900].truth.row.v_m_s).collect();
    assert!((last[0] - last[2]).abs() < 1e-9, "{last:?}");
}

#[test]
fn truth_is_consistent_with_itself() {
    for sample in samples(&scenario(40.0, 30.0, 1, FULL_BRAKE_ON_LOW), 3, 0) {
        let truth = &sample.truth;
        let loads: f64 = truth.normal_load_n.iter().sum();
        assert!((loads / (41e3 * GRAVITY_M_S2) - 1.0).abs() < 1e-9);
        let mean: f64 =
            (0..2).map(|i| truth.row.mu_w_wheelset[i] * truth.normal_load_n[i]).sum::<f64>() / loads;
        assert!((truth.row.mu_w - mean).abs() < 1e-12);
        for i in 0..2 {
            let limit = truth.adhesion_available[i] * 1.02;
            assert!(truth.row.mu_w_wheelset[i].abs() <= limit, "more adhesion than there is");
            assert_eq!(truth.row.mu_b[i].is_nan(), truth.pressing_force_n[i] <= 2e3);
        }
    }
}

#[test]
fn faults_strike_where_and_when_they_are_ordered() {
    let lines = "
[[demand]]
from_s = 0.0
brake = 0.3
[[fault]]
wagon = 2
signal = \"omega_f_rad_s\"
kind = \"stuck\"
from_s = 3.0
until_s = 5.0
[[fault]]
wagon = 2
kind = \"silent\"
from_s = 6.0
until_s = 7.0
";
    let scenario = scenario(10.0, 25.0, 2, lines);
    let (first, second) = (samples(&scenario, 1, 0), samples(&scenario, 1, 1));
    let stuck = second[300].row.wheel_speed_rad_s[0];
    assert!(second[300..500].iter().all(|s| s.row.wheel_speed_rad_s[0] == stuck));
    assert!(second[500].row.wheel_speed_rad_s[0] != stuck && second[298].row.wheel_speed_rad_s[0] != stuck);
    assert!(second[600..700].iter().all(|s| !s.present) && second[700].present && second[599].present);
    assert!(
        first.iter().all(|s| s.present)
            && first[301].row.wheel_speed_rad_s[0] != first[302].row.wheel_speed_rad_s[0]
    );
    let runs = run(&scenario, &[coach(), coach()], 1, |_| {}).expect("runs");
    assert_eq!((runs[0].recording.len(), runs[1].recording.len(), runs[1].truth.len()), (1001, 901, 901));
}

#[test]
fn a_repeating_programme_returns_to_its_start() {
    let scenario = scenario(
        70.0,
        20.0,
        2,
        "repeat\n[[demand]]\nfrom_s = 0.0\nbrake = 0.2\n[[demand]]\nfrom_s = 5.0\ncruise_m_s = 20.0\n",
    );
    let samples = samples(&scenario, 1, 1);
    for round in [3000, 6000] {
        assert!(samples[round - 1].truth.position_m > 400.0);
        assert!((samples[round].truth.position_m - -26.4).abs() < 1e-9);
        let jump = samples[round].truth.row.v_m_s - samples[round - 1].truth.row.v_m_s;
        assert!(jump.abs() < 0.02, "the speed goes on");
        assert!(samples[round + 300].truth.pressing_force_n[0] > 1e3, "it brakes again");
    }
    assert!(samples.windows(2).all(|pair| pair[1].row.t_s > pair[0].row.t_s));
}

/// A vehicle file's effects act in the train: pads that fade lose friction as they heat up.
#[test]
fn effects_of_the_vehicle_file_act() {
    let scenario = scenario(
        30.0,
        35.0,
        1,
        "[[demand]]\nfrom_s = 0.0\nbrake = 0.9\n[disturbance]\npad_friction_sigma = 0.0\npad_friction_spread = 0.0\n",
    );
    let mut fading = coach();
    let parameters = [("alpha_per_k".to_owned(), 8e-4)].into();
    fading.effects.push(EffectEntry { id: "brake_fade".to_owned(), parameters });
    let mut train = Train::new(&scenario, &[fading, coach()], 1, None).expect("a train");
    let last = (0..2800).map(|_| train.step().wagons.clone()).last().expect("samples");
    let (faded, plain) = (last[0].truth.row.mu_b[0], last[1].truth.row.mu_b[0]);
    println!("pad friction {faded:.3} with fade, {plain:.3} without");
    assert!((plain - 0.35).abs() < 1e-9 && faded < 0.33);
    assert!(last[0].truth.row.v_m_s > last[1].truth.row.v_m_s + 0.5, "it brakes less");
}

#[test]
fn four_wheelsets_are_data() {
    let mut vehicle = coach();
    vehicle.body.wheelset_positions_m = Some(vec![9.5, 7.0, -7.0, -9.5]);
    vehicle.body.wheelbase_m = 19.0;
    let scenario = scenario(10.0, 20.0, 1, "[[demand]]\nfrom_s = 0.0\nbrake = 0.5\n");
    let mut train = Train::new(&scenario, &[vehicle.clone()], 1, None).expect("a train");
    let sample = (0..600).map(|_| train.step().wagons[0]).last().expect("samples");
    assert_eq!(sample.wheelsets, 4);
    assert!(sample.row.wheel_speed_rad_s.iter().all(|omega| omega.is_finite()));
    assert!((-0.75..-0.4).contains(&sample.truth.acceleration_m_s2), "{}", sample.truth.acceleration_m_s2);
    let runs = run(&scenario, &[vehicle], 1, |_| {}).expect("runs");
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join(format!("{}.csv", runs[0].recording.name));
    runs[0].recording.write(&path).expect("write");
    let text = std::fs::read_to_string(&path).expect("text");
    assert!(text.starts_with("t_s,v_m_s,omega_1_rad_s,omega_2_rad_s,"), "{}", &text[..60]);
    railgrip_recording::Recording::read(&path, Strictness::Strict).expect("a strict reader takes it");
}

/// The tests of Schwarz & Keck: what the scenarios promise of adhesion and slide protection.
#[test]
fn the_published_tests_are_in_their_ranges() {
    let all = |name: &str| {
        let scenario = Scenario::load(name, Path::new("")).expect("built in");
        samples(&scenario, 1, 0)
    };
    let wsp = all("schwarz_keck_wsp");
    assert!((wsp[0].truth.row.v_m_s * 3.6 - 120.0).abs() < 0.1);
    let sliding = &wsp[4500..9500];
    let active = sliding.iter().filter(|s| s.row.wsp_active[0] > 0.0 && s.row.wsp_active[1] > 0.0).count();
    let low: Vec<f64> = sliding.iter().map(|s| -s.truth.row.mu_w).collect();
    let (least, most) = (low.iter().copied().fold(1.0, f64::min), low.iter().copied().fold(0.0, f64::max));
    println!(
        "protection active in {active} of 5000 samples, adhesion {least:.3} to {most:.3}, end {:.1} m/s",
        sliding[4999].truth.row.v_m_s
    );
    assert!(active > 4500 && least > 0.015 && most < 0.06);
    let applications = wsp[1800..3300]
        .windows(2)
        .filter(|pair| pair[0].truth.pressing_force_n[0] <= 5e3 && pair[1].truth.pressing_force_n[0] > 5e3);
    assert_eq!(applications.count(), 3);

    let sanding = all("schwarz_keck_sanding");
    assert!((sanding[0].truth.row.v_m_s * 3.6 - 200.0).abs() < 0.1);
    let used = |from_s: f64, to_s: f64| {
        sanding[(100.0 * from_s) as usize..(100.0 * to_s) as usize].iter().map(|s| -s.truth.row.mu_w)
    };
    let peak = used(4.0, 5.5).fold(0.0, f64::max);
    let slid = used(5.5, 7.0).fold(1.0, f64::min);
    let again = used(7.0, 8.5).fold(0.0, f64::max);
    let gone = used(9.0, 11.0).map(f64::abs).fold(0.0, f64::max);
    println!("sanding: {peak:.3}, {slid:.3}, {again:.3}, {gone:.3}");
    assert!(
        (peak - 0.1).abs() < 0.015
            && (slid - 0.05).abs() < 0.01
            && (again - 0.1).abs() < 0.02
            && gone < 0.005
    );
}

#[test]
fn the_demo_meets_every_rail_within_a_minute_and_slides() {
    let scenario = Scenario::load("demo", Path::new("")).expect("built in");
    for wagon in [0, 7] {
        let samples = samples(&scenario, 1, wagon);
        let first =
            |test: &dyn Fn(&WagonSample) -> bool| samples.iter().position(test).map(|at| 0.01 * at as f64);
        let braking = first(&|s| s.truth.pressing_force_n[0] > 3e4).expect("it brakes");
        let wet = first(&|s| s.truth.rail == railgrip_vehicle::RailClass::Wet).expect("it meets wet rail");
        let slide = first(&|s| s.row.wsp_active[0] > 0.0).expect("it slides");
        println!("wagon {}: brakes at {braking:.1} s, wet at {wet:.1} s, slides at {slide:.1} s", wagon + 1);
        assert!(braking < 10.0 && wet < 40.0 && slide < 75.0);
        let end = samples[samples.len() - 1].truth.row.v_m_s;
        assert!((end - 27.0).abs() < 1.0, "the programme must end as it begins, not at {end} m/s");
        assert!(longest_lock_s(&samples) < 0.4);
    }
}

#[test]
fn bad_scenarios_name_line_key_and_range() {
    let good = "schema = 1\nname = \"x\"\nduration_s = 5.0\n[train]\nwagons = 1\n[[demand]]\nfrom_s = 0.0\ncoast = true\n";
    let cases = [
        (
            good.replace("duration_s = 5.0", "duration_s = -5.0"),
            "x.toml:3: `duration_s` is -5, allowed is 1 to 1000000",
        ),
        (good.replace("wagons = 1", "wagons = 0"), "x.toml:5: `train.wagons` is 0, allowed is 1 to 256"),
        (good.replace("coast = true", "brake = 1.5"), "x.toml:8: `demand.1.brake` is 1.5, allowed is 0 to 1"),
        (
            good.replace("coast = true", ""),
            "x.toml:7: `demand.1.from_s` is 0, allowed is a phase with exactly one of",
        ),
        (
            format!("{good}[brake]\nfill_tim_s = 1.0\n"),
            "x.toml:10: unknown field `fill_tim_s`, expected one of",
        ),
        (
            format!("{good}[wsp]\nhold_slip = 0.2\nvent_slip = 0.1\n"),
            "x.toml:11: `wsp.vent_slip` is 0.1, allowed is 0.2 to 0.9",
        ),
        (
            format!(
                "{good}[[fault]]\nwagon = 1\nkind = \"stuck\"\nsignal = \"speed\"\nfrom_s = 1.0\nuntil_s = 2.0\n"
            ),
            "x.toml:12: `fault.1.signal` is speed",
        ),
        (
            format!("{good}[[rail]]\nfrom_m = 0.0\ncondition = \"icy\"\n"),
            "unknown variant `icy`, expected one of `dry`, `wet`, `low`",
        ),
        (format!("{good}[track]\nheadwind_m_s = nan\n"), "x.toml:10: `track.headwind_m_s` is NaN"),
    ];
    for (text, expected) in cases {
        let error = Scenario::parse(Path::new("x.toml"), &text).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}\nis not\n{expected}");
    }
}
