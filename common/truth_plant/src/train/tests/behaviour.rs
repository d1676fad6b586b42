//! A train does what trains do.

use super::{
    super::{FaultWish, Journey, TrainOrder},
    Sample, drawn, healthy, mean, on_rail, run,
};

#[test]
fn slack_runs_out_in_traction_and_in_when_brakes_begin_at_the_head() {
    let spec = on_rail(healthy(11, "freight_p", Some(16), 0.25), 0.3);
    let slack_m: Vec<f64> = spec.couplers.iter().map(|gear| gear.slack_m).collect();
    let mut journey = Journey::new(spec);
    let (mut tension, mut buff) = (vec![0.0f64; slack_m.len()], vec![0.0f64; slack_m.len()]);
    let (mut longest_m, mut shortest_m) = (vec![0.0f64; slack_m.len()], vec![0.0f64; slack_m.len()]);
    while journey.advance() {
        for (i, coupler) in journey.motion().couplers.iter().enumerate() {
            tension[i] = tension[i].max(coupler.force_n);
            buff[i] = buff[i].min(coupler.force_n);
            longest_m[i] = longest_m[i].max(coupler.extension_m);
            shortest_m[i] = shortest_m[i].min(coupler.extension_m);
        }
    }
    println!("tension {tension:.0?}\nbuff {buff:.0?}");
    for i in 0..slack_m.len() {
        assert!(longest_m[i] > 0.5 * slack_m[i] && shortest_m[i] < -0.5 * slack_m[i], "coupler {i}");
    }
    let largest = tension.iter().chain(&buff).map(|force| force.abs()).fold(0.0, f64::max);
    assert!((5e4..8e5).contains(&largest), "largest coupler force {largest} N");
}

#[test]
fn wheel_loads_sum_to_the_weight_and_braking_loads_the_leading_wheelsets() {
    let spec = on_rail(healthy(5, "multiple_unit", Some(4), 0.2), 0.3);
    let masses: Vec<f64> = spec.wagons.iter().map(|wagon| wagon.real.mass_kg).collect();
    let (mut braked, mut spread) = (0, 0.0f64);
    for sample in run(spec) {
        for (truth, mass_kg) in sample.truths.iter().zip(&masses) {
            let sum: f64 = truth.load_n.iter().sum();
            assert!((sum / (mass_kg * 9.806_65) - 1.0).abs() < 1e-9);
            assert!(truth.load_n.iter().all(|load| *load > 0.5 * sum / 4.0));
        }
        let middle = &sample.truths[1];
        if sample.order > 0.3 && middle.acceleration_m_s2 < -0.4 && middle.v_m_s > 8.0 {
            braked += 1;
            let [first, second, third, last] = middle.load_n;
            assert!(first > second && third > last && first > third, "{:?}", middle.load_n);
            spread = spread.max((first - last) / (first + last));
        }
    }
    println!("largest spread of loads {spread:.3}");
    assert!(braked > 100 && (0.02..0.2).contains(&spread));
}

/// When the pads of each wagon first press after an order, s after the first.
fn arrivals(samples: &[Sample], threshold_n: f64) -> Vec<f64> {
    let from = samples
        .windows(2)
        .position(|pair| pair[0].order == 0.0 && pair[1].order > 0.0 && pair[1].truths[0].v_m_s > 5.0)
        .expect("a brake application");
    let wagons = samples[0].truths.len();
    let first = |wagon: usize| {
        let pressed = |sample: &&Sample| sample.truths[wagon].pad_force_n[0] > threshold_n;
        samples[from..].iter().find(pressed).map(|sample| sample.time_s - samples[from].time_s)
    };
    (0..wagons).map(|wagon| first(wagon).expect("it brakes")).collect()
}

#[test]
fn a_pipe_order_runs_along_the_train_and_a_wire_is_everywhere_at_once() {
    let mut spec = on_rail(healthy(2, "freight_g", Some(50), 0.25), 0.3);
    for wagon in &mut spec.wagons {
        wagon.real.distributor_s = 0.4;
    }
    let length_m: f64 = spec.wagons.iter().map(|wagon| wagon.real.length_m).sum();
    let arrivals_s = arrivals(&run(spec), 200.0);
    let (head_s, tail_s) =
        (arrivals_s[1..5].iter().sum::<f64>() / 4.0, arrivals_s[46..].iter().sum::<f64>() / 4.0);
    println!("{arrivals_s:.2?}");
    let wave_s = 0.9 * length_m / 250.0;
    assert!((wave_s..2.5 * wave_s).contains(&(tail_s - head_s)), "{head_s} s, {tail_s} s, {length_m} m");
    for pair in arrivals_s[1..].chunks(10).collect::<Vec<_>>().windows(2) {
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        assert!(mean(pair[1]) > mean(pair[0]));
    }
    let wire_s = arrivals(&run(on_rail(healthy(2, "multiple_unit", Some(8), 0.2), 0.3)), 200.0);
    let trailers = [wire_s[1], wire_s[2], wire_s[5], wire_s[6]];
    assert!(trailers.iter().all(|arrival| (arrival - trailers[0]).abs() < 0.5), "{trailers:?}");
}

#[test]
fn a_healthy_train_brakes_as_it_is_asked_to() {
    for (family, wagons) in [("multiple_unit", 8), ("coaches", 7), ("freight_p", 12)] {
        let spec = on_rail(healthy(21, family, Some(wagons), 0.4), 0.3);
        let full_m_s2 = spec.full_brake_m_s2();
        let samples = run(spec);
        let window = 80;
        let steady = samples.windows(window).step_by(20).filter(|part| {
            part.iter().all(|sample| {
                (sample.order - part[0].order).abs() < 0.06
                    && sample.order > 0.2
                    && sample.truths[0].v_m_s > 6.0
            })
        });
        // Grade and running resistance are not the brake's.
        let kept = |part: &[Sample]| {
            let last = part.last()?;
            let head = &last.truths[0];
            let grade =
                last.readings.iter().map(|reading| 9.81 * reading.grade_rad).sum::<f64>() / wagons as f64;
            let running = 0.012 + 4e-5 * head.v_m_s * head.v_m_s;
            Some((-head.acceleration_m_s2 - grade - running) / (last.order * full_m_s2))
        };
        let ratio = mean(steady.filter_map(kept)).expect("steady braking");
        println!("{family}: retardation over what was asked {ratio:.3}");
        assert!((0.82..1.15).contains(&ratio), "{family}: {ratio}");
    }
}

#[test]
fn trains_stop_at_their_stations_as_a_driver_would() {
    for family in ["multiple_unit", "coaches", "freight_p", "freight_g", "railcar", "light_railcar"] {
        let spec = on_rail(healthy(8, family, None, 0.5), 0.3);
        let stations_m = spec.line.stations_m.clone();
        let top_m_s = spec.line.limits.iter().map(|limit| limit.1).fold(0.0, f64::max);
        let samples = run(spec);
        let stops: Vec<f64> = samples
            .windows(2)
            .filter(|pair| pair[0].truths[0].v_m_s >= 0.05 && pair[1].truths[0].v_m_s < 0.05)
            .map(|pair| pair[1].truths[0].head_m)
            .collect();
        let off =
            |stop: &f64| stations_m.iter().map(|station| (station - stop).abs()).fold(f64::MAX, f64::min);
        let worst = stops.iter().map(off).fold(0.0, f64::max);
        let fastest = samples.iter().map(|sample| sample.truths[0].v_m_s).fold(0.0, f64::max);
        let hardest = samples
            .windows(20)
            .map(|part| part.iter().map(|sample| -sample.truths[0].acceleration_m_s2).sum::<f64>() / 20.0)
            .fold(0.0, f64::max);
        println!(
            "{family}: {} stops, worst {worst:.0} m off, up to {fastest:.1} m/s, {hardest:.2} m/s²",
            stops.len()
        );
        assert!(stops.len() >= 2 && fastest < top_m_s + 3.0 && (0.2..1.4).contains(&hardest));
        assert!(samples.iter().all(|sample| sample.truths[0].v_m_s > -0.3), "{family} rolls back");
    }
}

#[test]
fn slide_protection_prevents_locking_and_a_dead_valve_lets_it_happen() {
    let slowest_share = |fault: FaultWish<'_>| {
        let order = TrainOrder {
            family: Some("multiple_unit"),
            wagons: Some(4),
            hours: 0.4,
            rate_hz: 20.0,
            fault,
            ..TrainOrder::default()
        };
        let mut spec = on_rail(drawn(31, &order), 0.14);
        spec.weather.dry = 0.05;
        spec.wagons.iter_mut().for_each(|wagon| wagon.real.sander = false);
        if let Some(fault) = &mut spec.fault {
            (fault.onset_s, fault.wagon, fault.wheelset) = (60.0, 2, 1);
        }
        let mut sliding = 0;
        let mut slowest = 1.0f64;
        for sample in run(spec) {
            let truth = &sample.truths[2];
            sliding += usize::from(truth.sliding);
            if truth.v_m_s > 6.0 && sample.onset == (fault != FaultWish::None) {
                slowest = slowest.min(1.0 + truth.slip_m_s[1] / truth.v_m_s);
            }
        }
        (slowest, sliding)
    };
    let (protected, sliding) = slowest_share(FaultWish::None);
    let (dead, _) = slowest_share(FaultWish::Of("slide_valve_dead"));
    println!(
        "slowest wheel over speed: protected {protected:.2}, dead valve {dead:.2}; {sliding} samples at work"
    );
    assert!(sliding > 100 && protected > 0.5, "{protected}");
    assert!(dead < 0.05, "{dead}");
}
