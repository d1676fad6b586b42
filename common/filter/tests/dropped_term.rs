//! What the term costs that Schwarz & Keck (11) drops: 2 (h/a) μ_W against 1 in the load of a wheelset. The paper's filter
//! runs over one stop twice, with the exact load and with the term dropped as in (12), on the same noisy samples.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]

mod support;

use railgrip_filter::models::{DrivenSample, PaperFilter, WagonFilter, WagonPhysics};
use railgrip_filter::{EstimatorConfig, EstimatorOutput, WagonSample};
use railgrip_vehicle::WagonModel;
use support::Truth;
use support::plant::{dry_stop, vehicle};

/// Pressing force of the stop, N: an emergency brake on dry rail, about 1.2 m/s².
const FORCE_N: f64 = 1.4e5;
/// Judged from here on: the brake is applied and the filter has settled, s.
const FROM_S: f64 = 7.0;

/// Root mean square and largest of some errors.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    squares: f64,
    count: f64,
    worst: f64,
}

impl Errors {
    fn add(&mut self, error: f64) {
        self.squares += error * error;
        self.count += 1.0;
        self.worst = self.worst.max(error.abs());
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Errors of adhesion (absolute), and of loads and pads (relative).
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    adhesion: Errors,
    load: Errors,
    pads: Errors,
}

fn driven(sample: &WagonSample, before: &WagonSample) -> DrivenSample {
    DrivenSample {
        v_m_s: sample.v_m_s,
        wheel_speed_rad_s: sample.wheel_speed_rad_s,
        pressing_force_n: sample.pressing_force_n,
        step_force_n: [0, 1, 2, 3].map(|i| 0.5 * (sample.pressing_force_n[i] + before.pressing_force_n[i])),
        ..DrivenSample::default()
    }
}

/// Loads by the exact relation at the true adhesions, N.
fn true_loads_n(model: &WagonModel, truth: &Truth) -> [f64; 2] {
    let mut utilised = [0.0; 4];
    utilised[..2].copy_from_slice(&truth.mu_w_wheelset);
    let loads = model.load_distribution();
    let resistance = &model.constants().resistance;
    let against = railgrip_vehicle::resistance::running_resistance(resistance, truth.v_m_s, 0.0);
    let acceleration = loads.acceleration_m_s2(model.constants().mass_kg, &utilised, -against);
    [0, 1].map(|i| loads.load_n(i, acceleration))
}

/// Runs the filter over a stop whose pads hold `pads` of the nominal friction.
fn run(pads: [f64; 2], drop_adhesion_load: bool) -> Cost {
    let (vehicle, config) =
        (vehicle(), EstimatorConfig { filter: "paper".into(), ..EstimatorConfig::default() });
    let model = WagonModel::new(&vehicle).unwrap();
    let mut filter = PaperFilter::<2, 6>::new(&config, &vehicle, WagonPhysics::new(&model));
    filter.model.drop_adhesion_load = drop_adhesion_load;
    let (samples, truths) = dry_stop(3, FORCE_N, pads);
    filter.start(&driven(&samples[0], &samples[0]));
    let mut cost = Cost::default();
    for (pair, truth) in samples.windows(2).zip(&truths[1..]) {
        let sample = driven(&pair[1], &pair[0]);
        filter.predict(&sample, pair[1].time_s - pair[0].time_s);
        for output in 0..=2 {
            let update = filter.expect(output, sample.measured(output));
            filter.accept(output, &update);
        }
        if pair[1].time_s < FROM_S {
            continue;
        }
        let mut out = EstimatorOutput::default();
        filter.read(&sample, &mut out);
        cost.adhesion.add(out.mu_w - truth.mu_w);
        // What the step predicts with: (12) lets resistance alone shift the load.
        let other_n = -railgrip_vehicle::resistance::running_resistance(
            &filter.model.physics.resistance,
            truth.v_m_s,
            0.0,
        );
        let used = if drop_adhesion_load { other_n / 45e3 } else { f64::NAN };
        for (i, load_n) in true_loads_n(&model, truth).into_iter().enumerate() {
            let believed_n = match drop_adhesion_load {
                true => filter.model.physics.loads.load_n(i, used),
                false => out.normal_load_n[i],
            };
            cost.load.add(believed_n / load_n - 1.0);
            cost.pads.add(out.mu_b[i] / truth.mu_b[i] - 1.0);
        }
    }
    cost
}

fn line(what: &str, cost: &Cost) -> String {
    format!(
        "{what}: adhesion rms {:.5}, worst {:.5}; load rms {:.2} %, worst {:.2} %; pads rms {:.2} %, worst {:.2} %",
        cost.adhesion.rms(),
        cost.adhesion.worst,
        100.0 * cost.load.rms(),
        100.0 * cost.load.worst,
        100.0 * cost.pads.rms(),
        100.0 * cost.pads.worst,
    )
}

#[test]
fn the_dropped_term_costs_little_adhesion_and_splits_the_pads_wrongly() {
    // Pads that share as the loads do, so that both wheelsets utilise the one adhesion of (2): what differs is the term.
    let share = {
        let vehicle = vehicle();
        let utilised = 2.0 * FORCE_N * 0.35 * vehicle.brake.radius_m
            / vehicle.wheelset.radius_m
            / (vehicle.body.mass_kg * railgrip_vehicle::GRAVITY_M_S2);
        2.0 * vehicle.body.com_height_m / vehicle.body.wheelbase_m * utilised
    };
    let pads = [1.0 + share, 1.0 - share];
    let (exact, dropped) = (run(pads, false), run(pads, true));
    println!("2 (h/a) mu_W = {share:.4}");
    println!("{}", line("exact load  ", &exact));
    println!("{}", line("term dropped", &dropped));
    assert!((0.02..0.10).contains(&share), "a stop that shows the term");
    // The speed of the whole wagon tells the adhesion: the term hardly matters there.
    assert!((dropped.adhesion.rms() - exact.adhesion.rms()).abs() < 0.002);
    // The load of each wheelset is off by the term, and with it the split of the pads.
    assert!((0.5..1.5).contains(&(dropped.load.rms() / share)));
    assert!(exact.load.rms() < 0.2 * dropped.load.rms());
    assert!(exact.pads.rms() < dropped.pads.rms());
}
