//! What happens in the recordings beside ordinary running: wheelsets that slide, lock or spin.

use crate::answer::supplement::Event;
use crate::data::case::{Case, Run};

/// Creepage beyond which a wheelset slides or spins. Wheels that hold creep by less than 2 %, and their radius may be wrong
/// by as much again.
const SLIDES: f64 = 0.08;
/// Creepage that a slide or spin reaches at least, so that the noise of slow running is none.
const REACHES: f64 = 0.15;
/// Creepage beyond which a wheelset counts as locked: it turns at less than a tenth of the speed of rolling.
const LOCKS: f64 = 0.9;
/// Speed below which creepage means little, m/s.
const SLOWEST_M_S: f64 = 2.0;
/// Shortest event, s.
const SHORTEST_S: f64 = 0.3;
/// Events closer than this are one, s.
const PAUSE_S: f64 = 1.0;

/// Events of all runs, fit runs first.
pub(crate) fn events(case: &Case) -> Vec<Event> {
    let radius_m = case.vehicle.wheelset.radius_m;
    let of = |runs: &[Run], holdout| -> Vec<Event> {
        runs.iter().flat_map(|run| of_run(run, radius_m)).map(|event| Event { holdout, ..event }).collect()
    };
    [of(&case.fit, false), of(&case.holdout, true)].concat()
}

fn of_run(run: &Run, radius_m: f64) -> Vec<Event> {
    let mut events: Vec<Event> = (0..run.wheelsets)
        .flat_map(|i| {
            let creepage: Vec<f64> = run
                .samples
                .iter()
                .map(|s| match s.smooth[0] {
                    v if v > SLOWEST_M_S => (v - radius_m * s.smooth[1 + i]) / v,
                    _ => 0.0,
                })
                .collect();
            of_wheelset(run, i, &creepage)
        })
        .collect();
    events.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    events
}

fn of_wheelset(run: &Run, wheelset: usize, creepage: &[f64]) -> Vec<Event> {
    let samples = |seconds: f64| (seconds / run.dt_s).round() as usize;
    let name = match (run.wheelsets, wheelset) {
        (2, 0) => "front wheelset".to_owned(),
        (2, _) => "rear wheelset".to_owned(),
        _ => format!("wheelset {}", wheelset + 1),
    };
    stretches(creepage, samples(PAUSE_S), samples(SHORTEST_S))
        .into_iter()
        .map(|(from, to)| {
            let part = &creepage[from..to];
            let most = part.iter().fold(0.0_f64, |most, x| if x.abs() > most.abs() { *x } else { most });
            let locked = creepage[from..to].iter().position(|x| *x > LOCKS).map(|at| from + at);
            let (verb, from) = match (most, locked) {
                (_, Some(locked)) => ("locks", locked),
                (most, _) if most < 0.0 => ("spins", from),
                _ => ("slides", from),
            };
            Event {
                run: run.name.clone(),
                holdout: false,
                wheelset,
                from_s: run.t_s[from],
                to_s: run.t_s[to - 1],
                words: format!("{name} {verb}"),
                severity: most.abs().min(1.0),
            }
        })
        .collect()
}

/// Stretches in which a wheelset slides or spins; short pauses do not part them, and short stretches are left out.
fn stretches(creepage: &[f64], pause: usize, shortest: usize) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (k, _) in creepage.iter().enumerate().filter(|(_, x)| x.abs() > SLIDES) {
        match found.last_mut() {
            Some((_, to)) if k <= *to + pause => *to = k + 1,
            _ => found.push((k, k + 1)),
        }
    }
    let reaches = |from: usize, to: usize| creepage[from..to].iter().any(|x| x.abs() > REACHES);
    found.retain(|(from, to)| to - from >= shortest && reaches(*from, *to));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::case::Columns;
    use railgrip_vehicle::RailClass;

    /// Ten seconds at 20 m/s at 100 Hz; the front wheelset's creepage is given over time.
    fn run(creepage: impl Fn(f64) -> f64) -> Run {
        let t_s: Vec<f64> = (0..1000).map(|k| 30.0 + 0.01 * f64::from(k)).collect();
        let n = t_s.len();
        let rolling = vec![20.0 / 0.5; n];
        let front = t_s.iter().map(|t| (1.0 - creepage(*t)) * 20.0 / 0.5).collect();
        let columns = Columns {
            v_m_s: vec![20.0; n],
            wheel_speed_rad_s: vec![front, rolling],
            pressing_force_n: vec![vec![0.0; n]; 2],
            drive_torque_nm: vec![vec![0.0; n]; 2],
            t_s,
            ..Columns::default()
        };
        Run::new("low_stop.low".to_owned(), RailClass::Low, &columns)
    }

    /// A creepage over time, and the events that it holds.
    type Told<'a> = (&'a dyn Fn(f64) -> f64, &'a [(&'a str, f64)]);

    #[test]
    fn slides_locks_and_spins_are_told_apart_and_timed() {
        let between = |t: f64, from: f64, to: f64| (from..to).contains(&t);
        let cases: [Told<'_>; 5] = [
            (&|_| 0.01, &[]),
            (&|t| if between(t, 33.0, 35.0) { 0.3 } else { 0.0 }, &[("front wheelset slides", 33.0)]),
            (&|t| if between(t, 33.0, 33.1) { 0.3 } else { 0.0 }, &[]),
            (&|t| if between(t, 33.0, 35.0) { -0.3 } else { 0.0 }, &[("front wheelset spins", 33.0)]),
            (
                &|t| {
                    if between(t, 34.0, 36.0) {
                        1.0
                    } else if between(t, 33.0, 34.0) {
                        0.4
                    } else {
                        0.0
                    }
                },
                &[("front wheelset locks", 34.0)],
            ),
        ];
        for (creepage, expected) in cases {
            let events = of_run(&run(creepage), 0.5);
            let found: Vec<&str> = events.iter().map(|e| e.words.as_str()).collect();
            assert_eq!(found, expected.iter().map(|(words, _)| *words).collect::<Vec<_>>());
            for (event, (_, from_s)) in events.iter().zip(expected) {
                assert!((event.from_s - from_s).abs() < 0.2, "{event:?}");
            }
        }
    }
}
