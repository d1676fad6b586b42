//! Reproducibility, independence of wagons, and noise and errors of sensors that are what they are declared to be.

mod common;

use common::{coach, samples, scenario};
use railgrip_simulation::{Train, WagonSample};
use railgrip_vehicle::EffectEntry;

const BRAKING: &str = "
[[demand]]
from_s = 0.0
traction = 0.3
[[demand]]
from_s = 3.0
brake = 0.8
[[rail]]
from_m = -500.0
condition = \"dry\"
[[rail]]
from_m = 150.0
condition = \"low\"
[track]
adhesion_variation = 0.05
";

/// Bits of everything in a sample; NaN has bits too.
fn bits(samples: &[WagonSample]) -> String {
    samples.iter().map(|sample| format!("{sample:?}")).collect()
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_does_not() {
    let scenario = scenario(20.0, 25.0, 2, BRAKING);
    let first = bits(&samples(&scenario, 5, 1));
    assert!(first == bits(&samples(&scenario, 5, 1)), "a rerun differs");
    assert!(first != bits(&samples(&scenario, 6, 1)), "the seed has no effect");
}

#[test]
fn a_wagon_does_not_feel_how_many_others_there_are() {
    let alone = bits(&samples(&scenario(20.0, 25.0, 1, BRAKING), 5, 0));
    let among_others = bits(&samples(&scenario(20.0, 25.0, 6, BRAKING), 5, 0));
    assert!(alone == among_others, "the first wagon differs in a longer train");
    let third = bits(&samples(&scenario(20.0, 25.0, 3, BRAKING), 5, 2));
    let third_of_six = bits(&samples(&scenario(20.0, 25.0, 6, BRAKING), 5, 2));
    assert!(third == third_of_six, "the third wagon differs in a longer train");
}

#[test]
fn a_faster_sample_rate_leaves_the_motion_as_it_is() {
    let quiet = format!("{BRAKING}[disturbance]\npad_friction_sigma = 0.0\ngust_sigma_m_s = 0.0\n");
    let scenario = scenario(20.0, 25.0, 1, &quiet);
    let at = |rate_hz: f64| {
        let mut train = Train::new(&scenario, &[coach()], 5, Some(rate_hz)).expect("a train");
        let last = (15.0 * rate_hz) as usize;
        (0..last).for_each(|_| {
            train.step();
        });
        train.step().wagons[0].truth.row.v_m_s
    };
    let (slow, fast) = (at(100.0), at(1000.0));
    println!("after 15 s: {slow:.6} m/s at 100 Hz, {fast:.6} m/s at 1 kHz");
    assert!((slow - fast).abs() < 1e-6);
}

/// Mean and standard deviation.
fn moments(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// Noise is white, without bias, and of the declared sigma, within the 4-sigma sampling error. Returns the figures.
fn check_noise(what: &str, sigma: f64, errors: &[f64]) -> String {
    let count = errors.len() as f64;
    let (mean, deviation) = moments(errors.iter().copied());
    let lag_one =
        errors.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / (count * deviation * deviation);
    assert!(mean.abs() < 4.0 * sigma / count.sqrt(), "{what} is biased by {mean}");
    assert!((deviation / sigma - 1.0).abs() < 4.0 / (2.0 * count).sqrt(), "{what} has sigma {deviation}");
    assert!(lag_one.abs() < 4.0 / count.sqrt(), "{what} is not white: {lag_one}");
    format!("{what}: mean {mean:.5}, deviation {deviation:.5} of {sigma}, correlation {lag_one:.4}")
}

#[test]
fn noise_is_what_the_vehicle_file_declares() {
    let lines = "[[demand]]\nfrom_s = 0.0\nbrake = 0.25\n";
    let samples = samples(&scenario(80.0, 40.0, 1, lines), 9, 0);
    let braking = &samples[1000..7000];
    let errors = |error: &dyn Fn(&WagonSample) -> f64| braking.iter().map(error).collect::<Vec<f64>>();
    println!("{}", check_noise("speed", 0.03, &errors(&|s| s.row.v_m_s - s.truth.row.v_m_s)));
    for i in 0..2 {
        let wheel = errors(&|s| s.row.wheel_speed_rad_s[i] - s.truth.wheel_speed_rad_s[i]);
        println!("{}", check_noise("wheel speed", 0.04, &wheel));
        let force = errors(&|s| s.row.pressing_force_n[i] - s.truth.pressing_force_n[i]);
        println!("{}", check_noise("pressing force", 150.0, &force));
    }
    let jumps = braking.windows(2).map(|pair| {
        let error = |s: &WagonSample| s.row.position_m - s.truth.position_m;
        (error(&pair[1]) - error(&pair[0])) / 2f64.sqrt()
    });
    let (_, position) = moments(jumps);
    println!("position: deviation from sample to sample {position:.4} of 0.3 m");
    assert!((position / 0.3 - 1.0).abs() < 0.04);
    assert!(braking.iter().all(|s| (s.row.position_m - s.truth.position_m).abs() < 8.0));
}

#[test]
fn values_have_the_digits_of_a_recorder() {
    let samples = samples(&scenario(5.0, 20.0, 1, "[[demand]]\nfrom_s = 0.0\nbrake = 0.5\n"), 2, 0);
    for sample in &samples {
        for text in [sample.row.v_m_s, sample.row.wheel_speed_rad_s[0]].map(|value| format!("{value}")) {
            assert!(text.split('.').nth(1).is_none_or(|digits| digits.len() <= 4), "{text}");
        }
        assert_eq!(sample.row.pressing_force_n[0].fract(), 0.0);
        assert!(sample.row.pressing_force_n[0] >= 0.0 && sample.row.wheel_speed_rad_s[2].is_nan());
    }
}

#[test]
fn late_sensors_show_the_past() {
    let lines = "[[demand]]\nfrom_s = 0.0\nbrake = 0.8\n[sensors]\nnoise_factor = 0.0\nspeed_resolution_m_s = 0.0\n\
                 speed_latency_s = 0.15\npressing_force_latency_s = 0.02\npressing_force_resolution_n = 0.0\n";
    let samples = samples(&scenario(10.0, 30.0, 1, lines), 2, 0);
    for at in 100..samples.len() {
        let late = samples[at].row.v_m_s - samples[at - 15].truth.row.v_m_s;
        assert!(late.abs() < 2e-3, "speed at sample {at} is off by {late}");
        let force = samples[at].row.pressing_force_n[0] - samples[at - 2].truth.pressing_force_n[0];
        assert!(force.abs() < 100.0, "pressing force at sample {at} is off by {force}");
        assert!((samples[at].row.wheel_speed_rad_s[0] - samples[at].truth.wheel_speed_rad_s[0]).abs() < 1e-4);
    }
}

#[test]
fn holes_and_spikes_come_as_often_as_asked() {
    let lines = "[[demand]]\nfrom_s = 0.0\ncoast = true\n[sensors]\nmissing_probability = 0.02\nspike_probability = 0.01\n";
    let samples = samples(&scenario(100.0, 20.0, 1, lines), 4, 0);
    let share = |test: &dyn Fn(&WagonSample) -> bool| {
        samples.iter().filter(|sample| test(sample)).count() as f64 / samples.len() as f64
    };
    let missing = share(&|s| s.row.v_m_s.is_nan());
    let spikes = share(&|s| (s.row.v_m_s - s.truth.row.v_m_s).abs() > 10.0 * 0.03);
    println!("missing {missing:.4} of 0.02, spikes {spikes:.4} of 0.01");
    assert!((missing - 0.02).abs() < 4.0 * (0.02f64 / 1e4).sqrt());
    assert!((spikes - 0.0098).abs() < 4.0 * (0.01f64 / 1e4).sqrt());
}

#[test]
fn an_eccentric_encoder_wobbles_once_a_turn() {
    let share = 0.02;
    let mut vehicle = coach();
    vehicle.effects.push(EffectEntry {
        id: "wheel_encoder_eccentricity".into(),
        parameters: [("sine", share), ("cosine", 0.0), ("wheelset", 1.0)]
            .map(|(name, value)| (name.to_owned(), value))
            .into(),
    });
    let mut train = Train::new(
        &scenario(
            12.0,
            20.0,
            1,
            "[[demand]]\nfrom_s = 0.0\nbrake = 0.0\n[[rail]]\nfrom_m = -500.0\ncondition = \"dry\"\n",
        ),
        &[vehicle],
        3,
        None,
    )
    .expect("a train");
    let period_s = train.sample_period_s();
    let (mut angle_rad, mut before) = (0.0, None);
    // Per wheelset: what goes with the sine of the first wheel's angle, relative to its speed.
    let (mut moment, mut weight) = ([0.0; 2], 0.0);
    for _ in 0..(10.0 / period_s) as usize {
        let sample = train.step().wagons[0];
        let truth = sample.truth.wheel_speed_rad_s;
        angle_rad +=
            0.5 * (truth[0] + before.unwrap_or(truth[0])) * period_s * f64::from(u8::from(before.is_some()));
        before = Some(truth[0]);
        weight += angle_rad.sin().powi(2);
        for k in 0..2 {
            moment[k] += (sample.row.wheel_speed_rad_s[k] / truth[k] - 1.0) * angle_rad.sin();
        }
    }
    let [eccentric, sound] = moment.map(|moment| moment / weight);
    assert!((eccentric - share).abs() < 0.05 * share, "{eccentric}");
    assert!(sound.abs() < 0.02 * share, "{sound}");
}
