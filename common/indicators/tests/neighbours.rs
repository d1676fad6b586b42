//! What the wagons of a train show about each other.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may end at what it does not expect, and prints"
)]

use railgrip_indicators::indicator::{BRAKE_DELAY, ISOLATED};
use railgrip_indicators::train::neighbours::Neighbours;
use railgrip_indicators::{IndicatorSettings, IndicatorSpec};
use railgrip_messages::{Grade, Health, Indicator, Stamp};

/// Eight wagons that brake for 12 s every 40 s; wagon 5 is cut off, wagon 3 begins late.
fn run(cut_off: Option<u32>, late: Option<(u32, f64)>) -> Neighbours {
    let settings = IndicatorSettings::default();
    let mut seen = Neighbours::default();
    let mut health: Vec<Health> =
        (1..=8).map(|wagon| Health { wagon, wheelsets: 2, ..Health::default() }).collect();
    for tenth in 0..2000_u64 {
        let t_s = 0.1 * tenth as f64;
        for one in &mut health {
            let delay_s = 0.1 * f64::from(one.wagon)
                + late.filter(|(wagon, _)| *wagon == one.wagon).map_or(0.0, |(_, s)| s);
            let in_cycle_s = (t_s % 40.0) - 5.0 - delay_s;
            let pressed = (0.0..12.0).contains(&in_cycle_s) && cut_off != Some(one.wagon);
            if pressed && one.pressing_force_n == 0.0 {
                one.brake_applications += 1;
                one.brake_applied = Stamp { unix_ns: 0, monotonic_ns: (1e9 * (t_s - in_cycle_s)) as u64 };
            }
            one.pressing_force_n = if pressed { 60_000.0 } else { 0.0 };
        }
        let live: Vec<&Health> = health.iter().collect();
        seen.take(&live, tenth * 100_000_000, 0.1, &settings);
    }
    seen
}

fn judged(spec: &IndicatorSpec, seen: &Neighbours, wagon: u32) -> Indicator {
    let judge = spec.judge.among.unwrap();
    judge(seen, wagon, &IndicatorSettings::default()).unwrap()
}

#[test]
fn a_wagon_that_is_cut_off_is_told_from_the_others() {
    let seen = run(Some(5), None);
    for wagon in 1..=8 {
        let figure = judged(&ISOLATED, &seen, wagon);
        println!("wagon {wagon}: {}", figure.reason);
        let expected = if wagon == 5 { Grade::Act } else { Grade::Ok };
        assert_eq!(figure.grade(), expected);
    }
}

#[test]
fn a_late_wagon_is_told_from_the_way_of_the_signal() {
    let seen = run(None, Some((3, 1.2)));
    for wagon in 1..=8 {
        let figure = judged(&BRAKE_DELAY, &seen, wagon);
        println!("wagon {wagon}: {}", figure.reason);
        let expected = if wagon == 3 { Grade::Watch } else { Grade::Ok };
        assert_eq!(figure.grade(), expected);
    }
    assert!((judged(&BRAKE_DELAY, &seen, 3).value - 1.2).abs() < 0.15);
    assert_eq!(judged(&BRAKE_DELAY, &Neighbours::default(), 1).grade(), Grade::Unknown);
}
