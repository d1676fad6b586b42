//! Indicators on synthetic estimates whose answers are known.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_indicators::indicator::{
    ADHESION_AVAILABLE, ADHESION_UTILISED, ASYMMETRY, BRAKE_FRICTION, FILTER, RAIL, SANDING, SENSORS, SLIDES,
    WHEEL_FLAT, WSP_SHARE,
};
use railgrip_indicators::{IndicatorSettings, IndicatorState, Nominal, WagonIndicators};
use railgrip_messages::{Condition, Estimate, Event, EventKind, Grade, Sample, flags, valid};

const NOMINAL: Nominal = Nominal {
    brake_friction: 0.35,
    rail: [0.30, 0.12, 0.06],
    wheelsets: 2,
    mass_kg: 40e3,
    inertia_kg_m2: 120.0,
    wheel_radius_m: 0.44,
    brake_radius_m: 0.25,
    resistance: [400.0, 8.0, 4.0],
    coupled: false,
};
const DT_S: f64 = 0.01;
const BOTH: u32 = 0b11;

/// A wagon whose estimates are exactly as told.
struct Bench {
    indicators: WagonIndicators,
    events: Vec<Event>,
    sequence: u64,
    time_s: f64,
}

impl Bench {
    fn new() -> Self {
        let indicators = WagonIndicators::new(3, IndicatorSettings::default(), NOMINAL);
        Self { indicators, events: Vec::new(), sequence: 0, time_s: 0.0 }
    }

    fn run(&mut self, seconds: f64, change: impl Fn(&mut Sample, &mut Estimate)) -> &mut Self {
        for _ in 0..(seconds / DT_S).round() as usize {
            self.sequence += 1;
            self.time_s += DT_S;
            let (mut sample, mut estimate) = (sample(), braking());
            (estimate.sequence, estimate.time_s) = (self.sequence, self.time_s);
            change(&mut sample, &mut estimate);
            self.indicators.update(&sample, &estimate, &mut |event| self.events.push(event));
        }
        self
    }

    fn kinds(&self) -> Vec<EventKind> {
        self.events.iter().filter_map(Event::kind).collect()
    }
}

fn sample() -> Sample {
    let mut valid = valid::SPEED | valid::WSP;
    for wheelset in 0..2 {
        valid |= valid::wheel_speed(wheelset) | valid::pressing_force(wheelset);
    }
    Sample { wheelsets: 2, valid, ..Sample::default() }
}

/// Braking at 20 m/s on a good rail, everything as it should be.
fn braking() -> Estimate {
    Estimate {
        v_m_s: 20.0,
        mu_w: -0.10,
        mu_w_sigma: 0.002,
        mu_w_wheelset: [-0.10, -0.10, 0.0, 0.0],
        mu_w_wheelset_sigma: [0.002, 0.002, 0.0, 0.0],
        mu_b: [0.35, 0.35, 0.0, 0.0],
        mu_b_sigma: [0.005, 0.005, 0.0, 0.0],
        mu_b_mean: 0.35,
        mu_b_mean_sigma: 0.004,
        slip: [-0.002, -0.002, 0.0, 0.0],
        normal_load_n: [200e3, 190e3, 0.0, 0.0],
        pressing_force_n: [20e3, 20e3, 0.0, 0.0],
        nis: 3.0,
        nis_dof: 3,
        observable: BOTH,
        wheelsets: 2,
        ..Estimate::default()
    }
}

#[test]
fn a_sound_wagon_is_ok_in_every_respect() {
    let mut bench = Bench::new();
    let health = bench.run(60.0, |_, _| {}).indicators.health();
    for indicator in [
        BRAKE_FRICTION.of(&health),
        ASYMMETRY.of(&health),
        RAIL.of(&health),
        SLIDES.of(&health),
        SENSORS.of(&health),
        FILTER.of(&health),
    ] {
        println!("{:?}: {}", indicator.grade(), indicator.reason);
        assert_eq!(indicator.grade(), Grade::Ok, "{}", indicator.reason);
    }
    assert_eq!((health.grade(), health.wagon, health.samples, health.missed), (Grade::Ok, 3, 6000, 0));
    assert!((BRAKE_FRICTION.of(&health).value - 0.35).abs() < 1e-9);
    assert!(
        BRAKE_FRICTION.of(&health).low < 0.35
            && BRAKE_FRICTION.of(&health).high - BRAKE_FRICTION.of(&health).low < 0.03
    );
    assert!((health.braking_s - 60.0).abs() < 0.02);
    assert_eq!((WSP_SHARE.of(&health).value, health.adhesion_available_is_bound), (0.0, 1));
    assert!((ADHESION_UTILISED.of(&health).value - 0.10).abs() < 0.001);
    assert!(ADHESION_AVAILABLE.of(&health).value > 0.09 && ADHESION_AVAILABLE.of(&health).value < 0.10);
}

#[test]
fn a_weak_rear_brake_is_found_on_the_rear() {
    let mut bench = Bench::new();
    bench.run(40.0, |_, estimate| {
        estimate.mu_b = [0.35, 0.21, 0.0, 0.0];
        estimate.mu_b_mean = 0.28;
    });
    let health = bench.indicators.health();
    println!(
        "{}\n{}\n{}",
        BRAKE_FRICTION.of_wheelset(&health, 0).reason,
        BRAKE_FRICTION.of_wheelset(&health, 1).reason,
        ASYMMETRY.of(&health).reason
    );
    assert_eq!(BRAKE_FRICTION.of_wheelset(&health, 0).grade(), Grade::Ok);
    assert_eq!(BRAKE_FRICTION.of_wheelset(&health, 1).grade(), Grade::Act);
    assert!((health.wheelset[1].brake_friction_ratio - 0.6).abs() < 1e-6);
    assert!((ASYMMETRY.of(&health).value - 0.5).abs() < 1e-6 && ASYMMETRY.of(&health).low > 0.3);
    assert_eq!((ASYMMETRY.of(&health).grade(), health.grade()), (Grade::Act, Grade::Act));
}

#[test]
fn what_is_not_observable_stays_unknown_whatever_the_estimate_says() {
    let mut bench = Bench::new();
    bench.run(40.0, |_, estimate| {
        estimate.observable = 0;
        estimate.mu_b = [0.5, 0.1, 0.0, 0.0];
    });
    let health = bench.indicators.health();
    assert_eq!(BRAKE_FRICTION.of_wheelset(&health, 0).grade(), Grade::Unknown);
    assert_eq!(BRAKE_FRICTION.of_wheelset(&health, 0).figure(), None);
    assert_eq!(ASYMMETRY.of(&health).grade(), Grade::Unknown);
    assert_eq!(
        BRAKE_FRICTION.of(&health).grade(),
        Grade::Ok,
        "the mean of the wagon is observable all the same"
    );
}

#[test]
fn a_slide_on_low_adhesion_tells_the_rail_and_is_counted() {
    let mut bench = Bench::new();
    bench.run(5.0, |_, _| {});
    assert_eq!(bench.indicators.health().condition, Condition::Dry.code());
    bench.run(4.0, |sample, estimate| {
        (sample.wsp_active, estimate.wsp_active, estimate.sliding) = (1, 1, 1);
        estimate.mu_w_wheelset = [-0.055, -0.06, 0.0, 0.0];
        estimate.mu_w = -0.0575;
        estimate.slip = [-0.2, -0.003, 0.0, 0.0];
    });
    bench.run(1.0, |_, estimate| estimate.mu_w = -0.05);
    let health = bench.indicators.health();
    let front = &health.wheelset[0];
    println!(
        "{}\n{}\n{}",
        RAIL.of(&health).reason,
        ADHESION_AVAILABLE.of_wheelset(&health, 0).reason,
        SLIDES.of_wheelset(&health, 0).reason
    );
    assert_eq!((health.condition, RAIL.of(&health).grade()), (Condition::Low.code(), Grade::Watch));
    assert_eq!(
        (
            SLIDES.of_wheelset(&health, 0).value,
            SLIDES.of_wheelset(&health, 1).value,
            SLIDES.of(&health).value
        ),
        (1.0, 0.0, 1.0)
    );
    let expected_j = 0.055 * 200e3 * 0.2 * 20.0 * 4.0;
    assert!((front.slide_energy_j / expected_j - 1.0).abs() < 1e-6);
    assert_eq!(front.adhesion_available_is_bound, 0);
    assert!((ADHESION_AVAILABLE.of_wheelset(&health, 0).value - 0.055).abs() < 0.002);
    assert!(
        ADHESION_AVAILABLE.of_wheelset(&health, 0).low <= 0.055
            && ADHESION_AVAILABLE.of_wheelset(&health, 0).high >= 0.055
    );
    assert!(
        (WSP_SHARE.of_wheelset(&health, 0).value - 0.4).abs() < 0.02,
        "{}",
        WSP_SHARE.of_wheelset(&health, 0).value
    );
    use EventKind::{ConditionChanged, SlideBegan, SlideEnded, WspBegan, WspEnded};
    let kinds = bench.kinds();
    println!("{kinds:?}");
    let condition: Vec<u32> = bench
        .events
        .iter()
        .filter(|event| event.kind() == Some(ConditionChanged))
        .map(|event| event.values[1] as u32)
        .collect();
    assert_eq!(condition, [Condition::Dry.code(), Condition::Low.code()]);
    for kind in [SlideBegan, SlideEnded, WspBegan, WspEnded] {
        assert_eq!(kinds.iter().filter(|seen| **seen == kind).count(), 1, "{kind}");
    }
    let ended = bench.events.iter().find(|event| event.kind() == Some(SlideEnded)).unwrap();
    assert_eq!((ended.wagon, ended.wheelset), (3, 0));
    assert!((ended.values[1] / expected_j - 1.0).abs() < 1e-6);
}

#[test]
fn slide_protection_is_judged_on_good_rail_only() {
    let mut bench = Bench::new();
    let slide = |adhesion: f64| {
        move |sample: &mut Sample, estimate: &mut Estimate| {
            (sample.wsp_active, estimate.wsp_active, estimate.sliding) = (BOTH, BOTH, BOTH);
            estimate.mu_w_wheelset = [-adhesion, -adhesion, 0.0, 0.0];
            estimate.mu_w = -adhesion;
            estimate.slip = [-0.2, -0.2, 0.0, 0.0];
        }
    };
    bench.run(20.0, |_, _| {}).run(40.0, slide(0.055));
    let health = bench.indicators.health();
    println!("{}", WSP_SHARE.of(&health).reason);
    assert!(WSP_SHARE.of(&health).value > 0.6 && WSP_SHARE.of(&health).grade() == Grade::Ok);
    let mut bench = Bench::new();
    bench.run(20.0, |_, _| {}).run(40.0, slide(0.25));
    let health = bench.indicators.health();
    println!("{}", WSP_SHARE.of(&health).reason);
    assert_eq!(WSP_SHARE.of(&health).grade(), Grade::Watch);
}

#[test]
fn a_wheelset_that_neither_brakes_nor_drives_cannot_slide() {
    let mut bench = Bench::new();
    bench.run(20.0, |_, estimate| {
        estimate.pressing_force_n = [0.0; 4];
        estimate.sliding = 1;
        (estimate.mu_w, estimate.mu_w_wheelset) = (-0.01, [-0.01, -0.01, 0.0, 0.0]);
    });
    let health = bench.indicators.health();
    println!("{}", RAIL.of(&health).reason);
    assert_eq!((SLIDES.of(&health).value, health.wheelset[0].slide_s), (0.0, 0.0));
    assert_ne!(RAIL.of(&health).grade(), Grade::Act);
}

#[test]
fn a_wheelset_without_a_speed_is_not_seen_to_slide() {
    let mut bench = Bench::new();
    // Its estimated speed has wandered off from standstill on; the other wheelset rolls and uses more than it.
    bench.run(20.0, |sample, estimate| {
        sample.valid &= !valid::wheel_speed(0);
        (estimate.sliding, estimate.slip[0]) = (1, -0.1);
        estimate.mu_w_wheelset = [-1e-5, -0.08, 0.0, 0.0];
        estimate.mu_w = -0.08;
    });
    let health = bench.indicators.health();
    let available = ADHESION_AVAILABLE.of_wheelset(&health, 0);
    println!("{}\n{}", available.reason, ADHESION_AVAILABLE.of(&health).reason);
    assert_eq!((SLIDES.of(&health).value, health.wheelset[0].sliding), (0.0, 0));
    assert_eq!((health.adhesion_available_is_bound, health.wheelset[0].adhesion_available_is_bound), (1, 1));
    assert!(ADHESION_AVAILABLE.of(&health).value > 0.07);
    // With single values missing it is seen as before.
    let mut bench = Bench::new();
    bench.run(20.0, |sample, estimate| {
        sample.valid &= if estimate.sequence % 3 == 0 { u32::MAX } else { !valid::wheel_speed(0) };
        (estimate.sliding, estimate.slip[0]) = (1, -0.1);
        estimate.mu_w_wheelset = [-0.055, -0.06, 0.0, 0.0];
    });
    let health = bench.indicators.health();
    assert_eq!((SLIDES.of(&health).value, health.wheelset[0].sliding), (1.0, 1));
}

#[test]
fn another_run_is_on_another_rail() {
    let mut bench = Bench::new();
    bench.run(10.0, |_, estimate| {
        estimate.sliding = BOTH;
        estimate.mu_w_wheelset = [-0.055, -0.055, 0.0, 0.0];
    });
    assert_eq!(RAIL.of(&bench.indicators.health()).grade(), Grade::Watch);
    bench.run(DT_S, |_, estimate| {
        estimate.flags = flags::RESTARTED;
        estimate.mu_w_wheelset = [0.0; 4];
    });
    let health = bench.indicators.health();
    assert_eq!((RAIL.of(&health).grade(), health.adhesion_available_is_bound), (Grade::Unknown, 1));
    assert!(BRAKE_FRICTION.of(&health).known == 1, "what is known about the brakes stays");
}

#[test]
fn missing_values_and_a_wrong_model_are_seen() {
    let mut bench = Bench::new();
    bench.run(20.0, |sample, estimate| {
        sample.valid &= !valid::wheel_speed(1);
        estimate.nis = 30.0;
    });
    let health = bench.indicators.health();
    assert!((SENSORS.of(&health).value - 0.2).abs() < 1e-9);
    assert_eq!((SENSORS.of(&health).grade(), FILTER.of(&health).grade()), (Grade::Watch, Grade::Act));
    assert!((FILTER.of(&health).value - 10.0).abs() < 1e-9);
}

#[test]
fn one_value_far_off_says_nothing_against_the_model() {
    let mut bench = Bench::new();
    bench.run(20.0, |_, _| {});
    bench.run(DT_S, |_, estimate| estimate.nis = 1e9);
    let filter = *FILTER.of(&bench.run(1.0, |_, _| {}).indicators.health());
    assert_eq!(filter.grade(), Grade::Ok, "{}", filter.reason);
    // A value in ten is too many.
    for _ in 0..100 {
        bench.run(DT_S, |_, estimate| estimate.nis = 1e9).run(9.0 * DT_S, |_, _| {});
    }
    let filter = *FILTER.of(&bench.indicators.health());
    assert!(filter.grade() >= Grade::Watch, "{}", filter.reason);
}

#[test]
fn a_train_that_comes_to_rest_says_nothing_against_its_filter() {
    let mut bench = Bench::new();
    bench.run(20.0, |_, _| {});
    let before = *FILTER.of(&bench.indicators.health());
    bench.run(20.0, |_, estimate| {
        estimate.v_m_s = 0.4;
        estimate.nis = 30.0;
    });
    let filter = *FILTER.of(&bench.indicators.health());
    assert_eq!((filter.value, filter.grade()), (before.value, Grade::Ok));
}

#[test]
fn gaps_and_restarts_count_for_nothing() {
    let mut bench = Bench::new();
    bench.run(10.0, |_, _| {});
    bench.sequence += 500;
    bench.time_s += 60.0;
    bench.run(10.0, |_, _| {});
    bench.time_s = -5.0;
    bench.run(DT_S, |_, estimate| estimate.flags = flags::RESTARTED);
    bench.run(10.0, |_, _| {});
    let health = bench.indicators.health();
    assert!((health.braking_s - 30.0).abs() < 0.05, "{}", health.braking_s);
    assert_eq!(health.missed, 500);
}

#[test]
fn a_snapshot_goes_on_where_it_stopped_and_nonsense_is_refused() {
    let mut bench = Bench::new();
    bench.run(30.0, |_, estimate| estimate.mu_b_mean = 0.30);
    let mut resumed = WagonIndicators::new(3, IndicatorSettings::default(), NOMINAL);
    assert!(resumed.restore(bench.indicators.state()));
    resumed.update(&sample(), &Estimate { sequence: 3001, time_s: 30.01, ..braking() }, &mut |_| {});
    let (before, after) = (bench.indicators.health(), resumed.health());
    assert!((BRAKE_FRICTION.of(&before).value - BRAKE_FRICTION.of(&after).value).abs() < 1e-4);
    assert!((after.braking_s - before.braking_s - DT_S).abs() < 1e-6);
    println!("{} bytes of state", size_of::<IndicatorState>());
    let nonsense: IndicatorState = bytemuck::Zeroable::zeroed();
    assert!(!resumed.restore(&nonsense));
    assert_eq!(resumed.health().braking_s, after.braking_s);
}

#[test]
fn nothing_is_claimed_before_the_first_sample() {
    let health = WagonIndicators::new(1, IndicatorSettings::default(), NOMINAL).health();
    assert_eq!((health.grade(), health.samples), (Grade::Unknown, 0));
    assert_eq!(BRAKE_FRICTION.of(&health).figure(), None);
}

/// Rolls with brakes off at 20 m/s; the second wheel is a polygon of `corners` whose radius falls by `depth` in the middle of
/// each side, so that its speed over a turn is known.
fn roll_on_a_polygon(bench: &mut Bench, seconds: f64, corners: f64, depth: f64) {
    let (start_s, radius_m) = (bench.time_s, NOMINAL.wheel_radius_m);
    let omega = 20.0 / radius_m;
    bench.run(seconds, |sample, estimate| {
        let angle = omega * (estimate.time_s - start_s);
        // The sensors' noise, as a sum of tones that come back with no turn.
        let noise = 0.03 * (912.3 * estimate.time_s).sin() + 0.03 * (617.7 * estimate.time_s).cos();
        let variation = depth * (corners * angle).cos();
        sample.wheel_speed_rad_s = [omega + noise, omega * (1.0 + variation) + noise, 0.0, 0.0];
        estimate.pressing_force_n = [0.0; 4];
        estimate.slip = [0.0; 4];
    });
}

#[test]
fn a_wheel_that_is_not_round_is_watched_and_after_hard_slides_acted_on() {
    let judged = |bench: &Bench, index: usize| *WHEEL_FLAT.of_wheelset(&bench.indicators.health(), index);
    let mut bench = Bench::new();
    roll_on_a_polygon(&mut bench, 20.0, 3.0, 1e-3);
    assert_eq!(judged(&bench, 1).figure(), None, "twenty seconds are too few turns");
    roll_on_a_polygon(&mut bench, 100.0, 3.0, 1e-3);
    let (round, polygon) = (judged(&bench, 0), judged(&bench, 1));
    println!("{}\n{}", round.reason, polygon.reason);
    assert_eq!((round.grade(), polygon.grade()), (Grade::Ok, Grade::Watch));
    // RMS of a cosine of that depth.
    let truth = 1e-3 / f64::sqrt(2.0);
    assert!(polygon.low <= truth && truth <= polygon.high && polygon.high - polygon.low < 0.2 * truth);
    // The same wheel after it was locked for two seconds: slide energy and variation together make a wheel flat.
    bench.run(2.0, |_, estimate| {
        estimate.slip = [-0.002, -1.0, 0.0, 0.0];
        estimate.sliding = 0b10;
    });
    let after = judged(&bench, 1);
    println!("{}", after.reason);
    assert!(after.grade() == Grade::Act && after.reason.as_str().starts_with("likely a wheel flat"));
    assert_eq!(judged(&bench, 0).grade(), Grade::Ok, "the other wheelset rolled");
}

#[test]
fn an_encoder_off_its_centre_is_no_wheel_flat() {
    let mut bench = Bench::new();
    roll_on_a_polygon(&mut bench, 120.0, 1.0, 5e-3);
    let judged = *WHEEL_FLAT.of_wheelset(&bench.indicators.health(), 1);
    println!("{}", judged.reason);
    assert!(judged.grade() == Grade::Ok && judged.value < 1e-4, "{}", judged.reason);
}

#[test]
fn sand_in_a_slide_is_a_test_of_the_sanders_that_stays() {
    const DAY_NS: i64 = 1_772_366_400_000_000_000;
    let slide = |sand: f64, adhesion: f64| {
        move |sample: &mut Sample, estimate: &mut Estimate| {
            sample.valid |= valid::SANDING;
            (sample.sanding, sample.acquired.unix_ns) = (sand, DAY_NS);
            (estimate.slip, estimate.sliding) = ([-0.1, -0.1, 0.0, 0.0], BOTH);
            let wobble = 1.0 + 0.03 * (7.0 * estimate.time_s).sin();
            estimate.mu_w_wheelset = [-adhesion * wobble, -adhesion * wobble, 0.0, 0.0];
        }
    };
    for (gain, grade) in [(1.5, Grade::Ok), (1.0, Grade::Watch)] {
        let mut bench = Bench::new();
        bench.run(6.0, slide(0.0, 0.06)).run(6.0, slide(1.0, 0.06 * gain));
        // An hour without a slide: the comparison is forgotten, its result is not.
        bench.run(3600.0, |sample, _| {
            sample.valid |= valid::SANDING;
            sample.acquired.unix_ns = DAY_NS;
        });
        let tested = *SANDING.of(&bench.indicators.health());
        println!("{}", tested.reason);
        assert!(
            tested.low <= gain && gain <= tested.high && tested.high - tested.low < 0.2,
            "{}",
            tested.reason
        );
        assert_eq!(tested.grade(), grade);
        assert!(tested.reason.as_str().ends_with("; tested on 2026-03-01"), "{}", tested.reason);
    }
}
