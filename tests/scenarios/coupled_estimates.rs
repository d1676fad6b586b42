//! Estimates of the wagons of coupled trains against the truth, wheelset by wheelset. The trains come from the plant that judges
//! alarms, which shares no formula with the filters; some of their wagons carry another payload than their file says.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::Path;
use std::process::Command;

use railgrip_tests::{Table, program};
use railgrip_truth_plant::train::{FaultWish, TrainOrder, TrainSpec, files};

const SEEDS: std::ops::Range<u64> = 20_261_125..20_261_131;
/// Below this speed a wagon is about to stand, m/s.
const MOVING_M_S: f64 = 2.0;

/// How often intervals held the truth, how wide they were, and by how much the estimate was off.
#[derive(Default)]
struct Held {
    inside: usize,
    all: usize,
    squares: f64,
    variances: f64,
}

impl Held {
    fn note(&mut self, error: f64, sigma: f64) {
        if error.is_finite() && sigma.is_finite() {
            self.all += 1;
            self.inside += usize::from(error.abs() < 1.96 * sigma);
            self.squares += error * error;
            self.variances += sigma * sigma;
        }
    }

    fn share(&self) -> f64 {
        self.inside as f64 / self.all as f64
    }

    fn rms(&self) -> (f64, f64) {
        ((self.squares / self.all as f64).sqrt(), (self.variances / self.all as f64).sqrt())
    }
}

/// Adhesion of driven and of other wheelsets, and pad friction.
#[derive(Default)]
struct Score {
    driven: Held,
    trailing: Held,
    pads: Held,
}

impl Score {
    /// Compares the estimates of a wagon with its truth, row by row of the latter.
    fn compare(&mut self, estimates: &Path, truth: &Path, driven: bool) {
        let (said, is) = (Table::read(estimates), Table::read(truth));
        let times = said.column("t_s");
        let rows = (0..is.rows()).filter(|row| is.column("v_m_s")[*row] > MOVING_M_S);
        let pairs: Vec<(usize, usize)> = rows
            .map(|row| (row, times.partition_point(|t_s| *t_s < is.column("t_s")[row] - 1e-6)))
            .filter(|(_, at)| *at < times.len())
            .collect();
        for k in 1..=said.names().iter().filter(|name| name.starts_with("slip_")).count() {
            let adhesion = if driven { &mut self.driven } else { &mut self.trailing };
            for (name, held) in [("mu_w", adhesion), ("mu_b", &mut self.pads)] {
                let name = format!("{name}_{k}");
                let (value, sigma) = (said.column(&name), said.column(&format!("{name}_sigma")));
                let real = is.column(&name);
                pairs.iter().for_each(|(row, at)| held.note(value[*at] - real[*row], sigma[*at]));
            }
        }
    }
}

/// A driven wagon pulls its train, a trailer is pulled: that is no adhesion of theirs that the filter does not know of, and no
/// change of their pads.
#[test]
fn intervals_of_coupled_wagons_hold_the_truth() {
    let mut score = Score::default();
    for seed in SEEDS {
        let order = TrainOrder {
            coupled: Some(true),
            wagons: Some(5),
            hours: 0.15,
            rate_hz: 25.0,
            fault: FaultWish::None,
            ..TrainOrder::default()
        };
        let spec = TrainSpec::draw_to(seed, &order).expect("a train");
        let folder = tempfile::tempdir().expect("a folder");
        let driven: Vec<bool> = spec.wagons.iter().map(|wagon| wagon.is_motored()).collect();
        let (train, truth) = (folder.path().join("train"), folder.path().join("truth"));
        files::write_train("five", &train, &truth, spec).expect("written");
        let out = folder.path().join("estimates");
        let mut replay = Command::new(program!());
        replay.args(["drill", "replay"]).arg(&train).arg("--json").arg(folder.path().join("alerts.json"));
        assert!(replay.arg("--estimates").arg(&out).output().expect("start").status.success());
        for (index, driven) in driven.into_iter().enumerate() {
            let name = format!("{}.csv", files::wagon_folder(index));
            score.compare(&out.join(&name), &truth.join(&name), driven);
        }
    }
    for (what, held) in [
        ("adhesion, driven wagons", &score.driven),
        ("adhesion, others", &score.trailing),
        ("pad friction in braking", &score.pads),
    ] {
        let (off, sigma) = held.rms();
        println!(
            "{what}: 95 % intervals held {:.3} of {}, rms error {off:.4}, rms sigma {sigma:.4}",
            held.share(),
            held.all
        );
    }
    assert!(score.driven.share() > 0.9 && score.driven.rms().0 < 0.004);
    assert!(score.trailing.share() > 0.9 && score.trailing.rms().0 < 0.004);
    // The prior says 10 % of nominal, and a coupled wagon tells little more.
    assert!(score.pads.share() > 0.9 && score.pads.rms().1 < 0.045);
}
