//! Estimates of the wagons of coupled trains against the truth, wheelset by wheelset. The trains come from the plant that judges
//! alarms, which shares no formula with the filters; some of their wagons carry another payload than their file says. Beside
//! them the pads of a filter of the whole train ([`joint`]).

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

mod joint;

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
    /// The same by a filter of the whole train.
    joint: Held,
    /// The mean pad friction of a train, by its wagons' filters and by that of the whole train.
    means: [Held; 2],
}

/// Pad friction of a wheelset at an instant.
struct Pad {
    real: f64,
    /// By its wagon's filter.
    own: f64,
    /// By that of the whole train.
    joint: f64,
}

impl Score {
    /// Compares pad friction of a whole train, second by second, where its brakes are on.
    fn compare_pads(&mut self, estimates: &[Table], truths: &[Table], joint: &[joint::Pads]) {
        let (times, real_times) = (estimates[0].column("t_s"), truths[0].column("t_s"));
        for row in (0..truths[0].rows()).filter(|row| truths[0].column("v_m_s")[*row] > MOVING_M_S) {
            let t_s = real_times[row];
            let at = times.partition_point(|said_s| *said_s < t_s - 1e-6);
            // What was known before.
            let Some(known) = joint.partition_point(|pads| pads.t_s < t_s).checked_sub(1) else { continue };
            if at == times.len() {
                continue;
            }
            let pads = &joint[known];
            let (mut pressed, mut place) = (Vec::new(), 0);
            for (said, is) in estimates.iter().zip(truths) {
                for k in 1..=is.names().iter().filter(|name| name.starts_with("mu_b_")).count() {
                    let name = format!("mu_b_{k}");
                    let (real, own) = (is.column(&name)[row], said.column(&name)[at]);
                    let (joint, sigma) = (pads.friction[place], pads.sigma[place]);
                    place += 1;
                    if real.is_finite() {
                        self.joint.note(joint - real, sigma);
                        pressed.push(Pad { real, own, joint });
                    }
                }
            }
            if pressed.is_empty() || pressed.iter().any(|pad| !pad.own.is_finite()) {
                continue;
            }
            let mean = |of: fn(&Pad) -> f64| pressed.iter().map(of).sum::<f64>() / pressed.len() as f64;
            self.means[0].note(mean(|pad| pad.own - pad.real), 1.0);
            self.means[1].note(mean(|pad| pad.joint - pad.real), 1.0);
        }
    }

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
        let names: Vec<String> = (0..driven.len()).map(files::wagon_folder).collect();
        let tables = |folder: &Path| -> Vec<Table> {
            names.iter().map(|name| Table::read(&folder.join(format!("{name}.csv")))).collect()
        };
        let folders: Vec<_> = names.iter().map(|name| train.join(name)).collect();
        score.compare_pads(&tables(&out), &tables(&truth), &joint::filter(&folders));
        for (index, driven) in driven.into_iter().enumerate() {
            let name = format!("{}.csv", files::wagon_folder(index));
            score.compare(&out.join(&name), &truth.join(&name), driven);
        }
    }
    for (what, held) in [
        ("adhesion, driven wagons", &score.driven),
        ("adhesion, others", &score.trailing),
        ("pad friction in braking", &score.pads),
        ("pad friction in braking, filter of the whole train", &score.joint),
    ] {
        let (off, sigma) = held.rms();
        println!(
            "{what}: 95 % intervals held {:.3} of {}, rms error {off:.4}, rms sigma {sigma:.4}",
            held.share(),
            held.all
        );
    }
    let [own, joint] = score.means.each_ref().map(|held| held.rms().0);
    println!(
        "mean pad friction of a train: rms error {own:.4} by its wagons' filters, {joint:.4} by one of the whole train"
    );
    assert!(score.driven.share() > 0.9 && score.driven.rms().0 < 0.004);
    assert!(score.trailing.share() > 0.9 && score.trailing.rms().0 < 0.004);
    // The whole train's balance knows its mean; what single pads do lies in neither filter by much.
    assert!(score.joint.share() > 0.9 && joint < own && score.pads.rms().0 < 1.35 * score.joint.rms().0);
    // The prior says 10 % of nominal, and a coupled wagon tells little more.
    assert!(score.pads.share() > 0.9 && score.pads.rms().1 < 0.045);
}
