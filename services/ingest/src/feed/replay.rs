//! Recordings as a source, one a wagon.

use super::{Arrival, Feed, InputError, Next, When};
use railgrip_diagnosis::data::units;
use railgrip_filter::PlantKind;
use railgrip_recording::{BogieRecording, Mapping, MotorRecording, Recording, Strictness};
use railgrip_settings::ReplayRun;
use railgrip_vehicle::VehicleParameters;

/// A run that is played again begins this time after its last sample, s.
const PAUSE_S: f64 = 1.0;

/// Recordings that are played in step with the clock.
pub struct Replay {
    players: Vec<Player>,
    speed: f64,
}

/// A recording of either kind.
enum Tape {
    Wagon(Box<Recording>),
    Motor(MotorRecording),
    Bogie(BogieRecording),
}

impl Tape {
    fn len(&self) -> usize {
        match self {
            Self::Wagon(recording) => recording.len(),
            Self::Motor(recording) => recording.rows.len(),
            Self::Bogie(recording) => recording.rows.len(),
        }
    }

    fn time_s(&self, row: usize) -> f64 {
        match self {
            Self::Wagon(recording) => recording.t_s[row],
            Self::Motor(recording) => recording.rows[row].t_s,
            Self::Bogie(recording) => recording.rows[row].t_s,
        }
    }
}

/// One recording while it plays.
struct Player {
    tape: Tape,
    row: usize,
    /// When its first row is due; moves on with each round.
    begin_s: f64,
    /// Latest time so far: a row with an earlier time is due at once.
    latest_s: f64,
    repeat: bool,
}

impl Replay {
    /// Reads all recordings.
    ///
    /// # Errors
    /// A recording that cannot be read or does not fit its vehicle.
    pub fn open(
        runs: &[ReplayRun],
        vehicles: &[VehicleParameters],
        plants: &[PlantKind],
        mapping: &Mapping,
        speed: f64,
        repeat: bool,
    ) -> Result<Self, InputError> {
        let mut players = Vec::with_capacity(runs.len());
        for (run, (vehicle, plant)) in runs.iter().zip(vehicles.iter().zip(plants)) {
            let tape = match plant {
                PlantKind::Traction => Tape::Motor(MotorRecording::read(&run.path, Strictness::Tolerant)?),
                PlantKind::Bogie => Tape::Bogie(BogieRecording::read(&run.path, Strictness::Tolerant)?),
                PlantKind::Wagon | PlantKind::Roller => {
                    let recording = Recording::read_mapped(&run.path, mapping, Strictness::Tolerant)?;
                    let (found, expected) = (recording.wheelsets, vehicle.wheelsets());
                    if found != expected {
                        return Err(InputError::Wheelsets { file: run.path.clone(), found, expected });
                    }
                    if *plant == PlantKind::Wagon {
                        units::check(&recording, vehicle)
                            .map_err(|source| InputError::Units { file: run.path.clone(), source })?;
                    }
                    Tape::Wagon(Box::new(recording))
                }
            };
            players.push(Player::new(tape, repeat));
        }
        Ok(Self { players, speed })
    }
}

impl Player {
    fn new(tape: Tape, repeat: bool) -> Self {
        Self { tape, row: 0, begin_s: 0.0, latest_s: 0.0, repeat }
    }

    fn take_due(&mut self, wagon: usize, until_s: f64, sink: &mut dyn FnMut(Arrival<'_>)) -> Next {
        let first_s = if self.tape.len() == 0 { 0.0 } else { self.tape.time_s(0) };
        while self.row < self.tape.len() {
            let due_s = (self.begin_s + self.tape.time_s(self.row) - first_s).max(self.latest_s);
            if due_s > until_s {
                return Next::More;
            }
            let begins = self.row == 0;
            match &self.tape {
                Tape::Wagon(recording) => {
                    let (row, wheelsets) = (recording.row(self.row), recording.wheelsets);
                    sink(Arrival::Row { wagon, row: &row, wheelsets, when: When::Due(due_s), begins });
                }
                Tape::Motor(recording) => {
                    sink(Arrival::Motor { wagon, row: &recording.rows[self.row], due_s, begins });
                }
                Tape::Bogie(recording) => {
                    sink(Arrival::Bogie { wagon, row: &recording.rows[self.row], due_s, begins });
                }
            }
            self.latest_s = due_s;
            self.row += 1;
            if self.row == self.tape.len() && self.repeat {
                self.row = 0;
                self.begin_s = due_s + PAUSE_S;
            }
        }
        Next::Ended
    }
}

impl Feed for Replay {
    fn take_due(&mut self, until_s: f64, sink: &mut dyn FnMut(Arrival<'_>)) -> Next {
        let mut next = Next::Ended;
        for (wagon, player) in self.players.iter_mut().enumerate() {
            if player.take_due(wagon, until_s, sink) == Next::More {
                next = Next::More;
            }
        }
        next
    }

    fn speed(&self) -> f64 {
        self.speed
    }

    fn describe(&self) -> String {
        format!("{} recordings", self.players.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_recording::{Optional, Row};

    fn recording(times_s: &[f64]) -> Recording {
        let mut recording = Recording::empty("run", None, 2, Optional::MEASURED);
        for t_s in times_s {
            recording.push(&Row { t_s: *t_s, ..Row::default() });
        }
        recording
    }

    fn replay(runs: &[&[f64]], repeat: bool) -> Replay {
        let players = runs
            .iter()
            .map(|times_s| Player::new(Tape::Wagon(Box::new(recording(times_s))), repeat))
            .collect();
        Replay { players, speed: 1.0 }
    }

    fn due(replay: &mut Replay, until_s: f64) -> (Vec<(usize, f64, f64, bool)>, Next) {
        let mut taken = Vec::new();
        let next = replay.take_due(until_s, &mut |arrival| {
            if let Arrival::Row { wagon, row, when: When::Due(due_s), begins, .. } = arrival {
                taken.push((wagon, row.t_s, due_s, begins));
            }
        });
        (taken, next)
    }

    #[test]
    fn rows_come_when_they_are_due_and_the_end_is_the_last_of_all() {
        let mut replay = replay(&[&[5.0, 5.125, 5.25], &[0.0]], false);
        let (taken, next) = due(&mut replay, 0.125);
        assert_eq!(taken, [(0, 5.0, 0.0, true), (0, 5.125, 0.125, false), (1, 0.0, 0.0, true)]);
        assert_eq!(next, Next::More);
        assert_eq!(due(&mut replay, 0.15).0, vec![]);
        let (rest, next) = due(&mut replay, 10.0);
        assert_eq!((rest.len(), next), (1, Next::Ended));
    }

    #[test]
    fn a_loop_begins_anew_after_a_pause_and_says_so() {
        let mut replay = replay(&[&[0.0, 0.5]], true);
        let (taken, next) = due(&mut replay, 3.0);
        let expected = vec![
            (0, 0.0, 0.0, true),
            (0, 0.5, 0.5, false),
            (0, 0.0, 1.5, true),
            (0, 0.5, 2.0, false),
            (0, 0.0, 3.0, true),
        ];
        assert_eq!((taken, next), (expected, Next::More));
    }

    #[test]
    fn a_time_that_goes_back_is_due_at_once() {
        let mut replay = replay(&[&[0.0, 1.0, 0.2, 1.1]], false);
        let (taken, _) = due(&mut replay, 1.05);
        let due_s: Vec<f64> = taken.iter().map(|row| row.2).collect();
        assert_eq!(due_s, [0.0, 1.0, 1.0]);
    }
}
