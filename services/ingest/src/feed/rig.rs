//! Simulated rigs as a source: a published test, one rig a wagon, each with a seed of its own.

use super::{Arrival, Feed, Next, Rolls, When};
use railgrip_experiments::bogie::controller::Control;
use railgrip_experiments::rigs::{RigFeed, RigRow};
use railgrip_settings::{BrakeController, RigProgramme};

/// A test that is run again begins this time after its last sample, s.
const PAUSE_S: f64 = 1.0;

/// Rigs that run in step with the clock.
pub struct Rigs {
    rigs: Vec<Player>,
    programme: RigProgramme,
    speed: f64,
    repeat: bool,
}

/// One rig.
struct Player {
    seed: u64,
    feed: RigFeed,
    next: Option<RigRow>,
    begin_s: f64,
    begins: bool,
    rolls: Option<Rolls>,
}

/// The rig under a programme.
#[must_use]
pub fn feed_of(programme: RigProgramme, seed: u64) -> RigFeed {
    match programme {
        RigProgramme::SchwarzWsp => RigFeed::slide_protection(seed),
        RigProgramme::SchwarzSanding => RigFeed::sanding(seed),
        RigProgramme::Zhao { surface, case } => RigFeed::traction(surface, usize::from(case), seed),
        RigProgramme::ShresthaStop { rail, controller } => {
            let control = match controller {
                BrakeController::None => None,
                BrakeController::Conventional => Some(Control::CONVENTIONAL),
                BrakeController::Proposed => Some(Control::Proposed),
            };
            RigFeed::bogie_stop(rail, control, seed)
        }
        RigProgramme::ShresthaWater => RigFeed::bogie_water(seed),
    }
}

impl Rigs {
    /// `count` rigs under a test.
    #[must_use]
    pub fn new(programme: RigProgramme, seed: u64, count: usize, speed: f64, repeat: bool) -> Self {
        let player = |index: u64| {
            let mut feed = feed_of(programme, seed + index);
            let next = feed.next();
            Player { seed: seed + index, feed, next, begin_s: 0.0, begins: true, rolls: None }
        };
        Self { rigs: (0..count as u64).map(player).collect(), programme, speed, repeat }
    }
}

impl Feed for Rigs {
    fn rolls(&self, wagon: usize) -> Option<Rolls> {
        self.rigs.get(wagon)?.rolls
    }

    fn take_due(&mut self, until_s: f64, sink: &mut dyn FnMut(Arrival<'_>)) -> Next {
        let mut next = Next::Ended;
        for (wagon, rig) in self.rigs.iter_mut().enumerate() {
            while let Some(row) = rig.next {
                let due_s = rig.begin_s + row.time_s();
                if due_s > until_s {
                    next = Next::More;
                    break;
                }
                let begins = std::mem::take(&mut rig.begins);
                match &row {
                    RigRow::Wagon { row, .. } => {
                        sink(Arrival::Row { wagon, row, wheelsets: 1, when: When::Due(due_s), begins });
                    }
                    RigRow::Motor { row, .. } => sink(Arrival::Motor { wagon, row, due_s, begins }),
                    RigRow::Bogie { row, truth } => {
                        let slip = truth.slip.iter().fold(0.0, |most: f64, slip| most.max(slip.abs()));
                        rig.rolls = Some(Rolls {
                            speed_m_s: truth.v_m_s.max(0.0),
                            creepage: slip.clamp(0.001, 1.0),
                            wetness: truth.wetness,
                        });
                        sink(Arrival::Bogie { wagon, row, due_s, begins });
                    }
                }
                rig.next = rig.feed.next();
                if rig.next.is_none() && self.repeat {
                    rig.feed = feed_of(self.programme, rig.seed);
                    rig.next = rig.feed.next();
                    (rig.begin_s, rig.begins) = (due_s + PAUSE_S, true);
                }
            }
        }
        next
    }

    fn speed(&self) -> f64 {
        self.speed
    }

    fn describe(&self) -> String {
        format!("simulated rigs, {}", self.programme.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_vehicle::traction_rig::Surface;

    #[test]
    fn a_motor_is_sampled_a_thousand_times_a_second() {
        let programme = RigProgramme::Zhao { surface: Surface::Water, case: 3 };
        let mut rigs = Rigs::new(programme, 1, 2, 1.0, false);
        let (mut count, mut begins) = ([0; 2], 0);
        let next = rigs.take_due(0.9995, &mut |arrival| {
            if let Arrival::Motor { wagon, begins: first, .. } = arrival {
                count[wagon] += 1;
                begins += u32::from(first);
            }
        });
        assert_eq!((count, begins, next), ([1000, 1000], 2, Next::More));
    }
}
