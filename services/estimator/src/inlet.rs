//! Where an estimator's samples come from: the channel of its wagon, or that of its rig's own sensors. Each sample is checked
//! as it comes in; what is wrong with its stamp or its form is refused and counted, and the values are the filter's to judge.

use crate::sight::Sight;
use crate::units::Units;
use crate::worker::Worker;
use railgrip_bus::{BogieSubscriber, Bus, BusError, MotorSubscriber, SampleSubscriber, Wake, now};
use railgrip_filter::PlantKind;
use railgrip_messages::{Checked, Refusal, Sample, valid};
use railgrip_settings::TrainSettings;
use std::collections::BTreeMap;
use std::time::Duration;

/// The receiving end of one wagon or rig, with what it refused.
pub(crate) struct Inlet {
    channel: Channel,
    refused: Refused,
    units: Option<Units>,
}

enum Channel {
    /// Speeds and pressing forces.
    Wagon(SampleSubscriber),
    /// Motor currents and voltages.
    Motor(MotorSubscriber),
    /// Torque, link force and pulses.
    Bogie(BogieSubscriber),
}

impl Inlet {
    /// Opens the channel that the worker's plant needs.
    pub fn open(bus: &Bus, settings: &TrainSettings, worker: &Worker) -> Result<Self, BusError> {
        let channel = match worker.plant.kind() {
            PlantKind::Traction => Channel::Motor(bus.motor_subscriber(worker.wagon)?),
            PlantKind::Bogie => Channel::Bogie(bus.bogie_subscriber(worker.wagon)?),
            PlantKind::Wagon | PlantKind::Roller => Channel::Wagon(bus.sample_subscriber(worker.wagon)?),
        };
        Ok(Self { channel, refused: Refused::default(), units: Units::of(settings, worker) })
    }

    /// Sleeps until something arrives or the time is over.
    pub fn wait(&self, timeout: Duration) -> Result<Wake, BusError> {
        match &self.channel {
            Channel::Wagon(samples) => samples.wait(timeout),
            Channel::Motor(samples) => samples.wait(timeout),
            Channel::Bogie(samples) => samples.wait(timeout),
        }
    }

    /// Hands everything that waits, and is sound, to the worker.
    pub fn receive(&mut self, worker: &mut Worker) -> Result<usize, BusError> {
        let (refused, units) = (&mut self.refused, &mut self.units);
        let received = match &mut self.channel {
            Channel::Wagon(samples) => samples.receive(|batch| {
                let mut fit = |sight: &mut Sight, sample: &Sample| {
                    if !sees(sight, sample) {
                        return Err(Refusal::NothingMeasured);
                    }
                    let plausible = units.as_mut().is_none_or(|units| units.plausible(sample));
                    if plausible { Ok(()) } else { Err(Refusal::UnitsImplausible) }
                };
                refused.hand_on_if(batch, &mut fit, |sample| worker.estimate(sample));
            }),
            Channel::Motor(samples) => {
                samples.receive(|batch| refused.hand_on(batch, |sample| worker.estimate_motor(sample)))
            }
            Channel::Bogie(samples) => {
                samples.receive(|batch| refused.hand_on(batch, |sample| worker.estimate_bogie(sample)))
            }
        };
        if let Some(units) = units {
            units.tell(worker);
        }
        received
    }

    /// Samples that never arrived.
    pub fn missed(&self) -> u64 {
        match &self.channel {
            Channel::Wagon(samples) => samples.missed(),
            Channel::Motor(samples) => samples.missed(),
            Channel::Bogie(samples) => samples.missed(),
        }
    }

    /// Samples that arrived and were refused.
    pub fn refused(&self) -> u64 {
        self.refused.counts.values().sum()
    }
}

/// How many samples were refused, by reason.
#[derive(Debug, Default)]
struct Refused {
    counts: BTreeMap<Refusal, u64>,
    sight: Sight,
}

/// Whether a filter goes on with a sample.
fn sees(sight: &mut Sight, sample: &Sample) -> bool {
    let wheels = (0..sample.wheelset_count()).any(|i| sample.has(valid::wheel_speed(i)));
    sight.goes_on(sample.time_s, wheels || sample.has(valid::SPEED))
}

impl Refused {
    fn hand_on<T: Checked>(&mut self, batch: &[T], take: impl FnMut(&T)) {
        self.hand_on_if(batch, |_, _| Ok(()), take);
    }

    fn hand_on_if<T: Checked>(
        &mut self,
        batch: &[T],
        mut fit: impl FnMut(&mut Sight, &T) -> Result<(), Refusal>,
        mut take: impl FnMut(&T),
    ) {
        let now = now();
        for sample in batch {
            match sample.validated(now) {
                Ok(sample) => match fit(&mut self.sight, &sample) {
                    Ok(()) => take(&sample),
                    Err(why) => self.count(T::NAME, why),
                },
                Err(why) => self.count(T::NAME, why),
            }
        }
    }

    fn count(&mut self, payload: &str, why: Refusal) {
        let count = self.counts.entry(why).or_insert(0);
        *count += 1;
        // Ever more rarely: a source that errs does so a thousand times a second.
        if count.is_power_of_two() {
            tracing::warn!(payload, why = why.word(), count = *count, "a sample is refused");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Stamp;

    /// A wagon whose every value was missing once was live for ever, with figures that nobody had measured.
    #[test]
    fn without_a_measured_speed_nothing_is_estimated_for_long() {
        let sample = |k: u32, valid: u32| Sample {
            acquired: now(),
            wheelsets: 2,
            time_s: f64::from(k) * 0.1,
            valid,
            ..Sample::default()
        };
        let speeds = valid::SPEED | valid::wheel_speed(0);
        let batch: Vec<Sample> =
            (0..100).map(|k| sample(k, if (30..80).contains(&k) { valid::GRADE } else { speeds })).collect();
        let (mut refused, mut taken) = (Refused::default(), Vec::new());
        let fit = |sight: &mut Sight, sample: &Sample| {
            if sees(sight, sample) { Ok(()) } else { Err(Refusal::NothingMeasured) }
        };
        refused.hand_on_if(&batch, fit, |sample| taken.push(sample.time_s));
        let missing = refused.counts[&Refusal::NothingMeasured];
        assert_eq!(
            (taken.len(), missing),
            (70, 30),
            "two seconds are gone through, then it is as if nothing came"
        );
        let again = [sample(0, valid::GRADE)];
        refused.hand_on_if(&again, fit, |sample| taken.push(sample.time_s));
        assert_eq!(taken.len(), 71, "another run");
    }

    #[test]
    fn samples_from_the_future_are_refused_and_counted_and_the_rest_goes_on() {
        let now = now();
        let at = |ahead_s: i64| Stamp {
            unix_ns: now.unix_ns,
            monotonic_ns: now.monotonic_ns.saturating_add_signed(ahead_s * 1_000_000_000),
        };
        let sample = |acquired| Sample { acquired, wheelsets: 2, ..Sample::default() };
        let batch = [
            sample(at(-1)),
            sample(at(3600)),
            sample(Stamp { monotonic_ns: u64::MAX, ..now }),
            Sample { time_s: f64::INFINITY, ..sample(now) },
            Sample { wheelsets: 77, ..sample(now) },
            sample(Stamp::default()),
            sample(now),
        ];
        let (mut refused, mut taken) = (Refused::default(), Vec::new());
        refused.hand_on(&batch, |sample| taken.push(sample.acquired));
        assert_eq!(taken, [at(-1), now]);
        let counts: Vec<(&str, u64)> =
            refused.counts.iter().map(|(why, count)| (why.word(), *count)).collect();
        assert_eq!(counts, [("future_stamp", 2), ("no_stamp", 1), ("not_finite", 1), ("wrong_count", 1)]);
    }
}
