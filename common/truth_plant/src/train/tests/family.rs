//! The family as a whole: sound for any seed, repeatable, fast.

use std::time::Instant;

use super::super::{FaultWish, Journey, TrainOrder, TrainSpec, faults::FAULTS, files};
use super::{drawn, healthy};

#[test]
fn two_hundred_random_trains_hold_no_nonsense() {
    let order = TrainOrder { hours: 0.035, rate_hz: 20.0, ..TrainOrder::default() };
    let (mut coupled, mut healthy, mut moving) = (0, 0, 0);
    for seed in 0..200 {
        let spec = drawn(seed, &order);
        coupled += usize::from(spec.coupled);
        healthy += usize::from(spec.fault.is_none());
        let mut journey = Journey::new(spec);
        let mut fastest = 0.0f64;
        while journey.advance() {
            for (truth, wagon) in journey.truths().iter().zip(&journey.spec().wagons) {
                let wheelsets = 0..wagon.wheelsets();
                let sound = wheelsets.clone().all(|k| {
                    truth.contact_n[k].is_finite()
                        && truth.wheel_speed_rad_s[k].abs() < 300.0
                        && truth.load_n[k] > 0.0
                });
                assert!(sound && truth.v_m_s.is_finite() && truth.coupler_n.abs() < 2e6, "seed {seed}");
                fastest = fastest.max(truth.v_m_s);
            }
        }
        moving += usize::from(fastest > 0.5);
    }
    println!("{coupled} coupled, {healthy} healthy, {moving} moved in two minutes");
    assert!((130..190).contains(&coupled) && (40..110).contains(&healthy) && moving > 120);
}

#[test]
fn every_fault_can_be_drawn_and_stays_in_its_range() {
    for kind in &FAULTS {
        for seed in 0..20 {
            let order =
                TrainOrder { fault: FaultWish::Of(kind.id), coupled: Some(true), ..TrainOrder::default() };
            let spec = drawn(seed, &order);
            let fault = spec.fault.unwrap_or_else(|| panic!("{} is not placed", kind.id));
            let (smallest, largest) = kind.size;
            assert!((smallest..=largest * (1.0 + 1e-12)).contains(&fault.size.abs()), "{}", kind.id);
            assert!(fault.size > 0.0 || kind.signed);
            assert!(fault.wheelset < spec.wagons[fault.wagon].wheelsets());
        }
        assert!((kind.size.0..=kind.size.1).contains(&kind.gross), "{}", kind.id);
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_gives_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let written = |name: &str, seed: u64| {
        let order = TrainOrder { hours: 0.05, wagons: Some(5), ..TrainOrder::default() };
        let place = folder.path().join(name);
        let label =
            files::write_train("t", &place, &folder.path().join("truth").join(name), drawn(seed, &order))
                .expect("written");
        let read = |file: &str| std::fs::read(place.join(file)).expect("there");
        (read("w01/run.csv"), read("w05/run.csv"), read("w03/vehicle.toml"), read("train.toml"), label)
    };
    let first = written("a", 42);
    assert!(first == written("b", 42));
    assert!(first.0 != written("c", 43).0);
}

#[test]
fn what_cannot_be_is_refused_with_what_can() {
    let refused = |order: TrainOrder<'_>| TrainSpec::draw_to(1, &order).expect_err("refused").to_string();
    assert!(refused(TrainOrder { rate_hz: 33.0, ..TrainOrder::default() }).contains("100"));
    assert!(refused(TrainOrder { wagons: Some(70), ..TrainOrder::default() }).contains("4 to 64"));
    assert!(
        refused(TrainOrder { fault: FaultWish::Of("rust"), ..TrainOrder::default() }).contains("glazed_pad")
    );
    assert!(refused(TrainOrder { family: Some("tram"), ..TrainOrder::default() }).contains("railcar"));
}

#[test]
fn vehicle_numbers_carry_a_right_check_digit() {
    for wagon in &healthy(4, "freight_p", Some(20), 0.1).wagons {
        let digits: Vec<u32> = wagon.number.chars().filter_map(|c| c.to_digit(10)).collect();
        let weighted =
            digits[..11].iter().enumerate().map(|(at, digit)| if at % 2 == 0 { 2 * digit } else { *digit });
        let sum: u32 = weighted.map(|product| product / 10 + product % 10).sum();
        assert_eq!((digits.len(), (sum + digits[11]) % 10), (12, 0), "{}", wagon.number);
    }
}

#[test]
fn a_train_runs_much_faster_than_time() {
    for wagons in [8, 64] {
        let family = if wagons == 8 { "multiple_unit" } else { "freight_g" };
        let order = TrainOrder {
            family: Some(family),
            wagons: Some(wagons),
            hours: 0.1,
            rate_hz: 100.0,
            fault: FaultWish::None,
            ..TrainOrder::default()
        };
        let spec = drawn(1, &order);
        let (duration_s, start) = (spec.duration_s, Instant::now());
        let mut journey = Journey::new(spec);
        let mut samples = 0;
        while journey.advance() {
            samples += 1;
        }
        println!("{wagons} wagons at 100 Hz: {:.0} x real time", duration_s / start.elapsed().as_secs_f64());
        assert_eq!(samples, 36_000);
    }
}
