//! Where an estimator's samples come from: the channel of its wagon, or that of its rig's motor.

use crate::worker::Worker;
use railgrip_bus::{Bus, BusError, MotorSubscriber, SampleSubscriber, Wake};
use railgrip_filter::PlantKind;
use std::time::Duration;

/// The receiving end of one wagon or rig.
pub(crate) enum Inlet {
    /// Speeds and pressing forces.
    Wagon(SampleSubscriber),
    /// Motor currents and voltages.
    Motor(MotorSubscriber),
}

impl Inlet {
    /// Opens the channel that the worker's plant needs.
    pub fn open(bus: &Bus, worker: &Worker) -> Result<Self, BusError> {
        Ok(match worker.plant.kind() {
            PlantKind::Traction => Self::Motor(bus.motor_subscriber(worker.wagon)?),
            _ => Self::Wagon(bus.sample_subscriber(worker.wagon)?),
        })
    }

    /// Sleeps until something arrives or the time is over.
    pub fn wait(&self, timeout: Duration) -> Result<Wake, BusError> {
        match self {
            Self::Wagon(samples) => samples.wait(timeout),
            Self::Motor(samples) => samples.wait(timeout),
        }
    }

    /// Hands everything that waits to the worker.
    pub fn receive(&mut self, worker: &mut Worker) -> Result<usize, BusError> {
        match self {
            Self::Wagon(samples) => {
                samples.receive(|batch| batch.iter().for_each(|sample| worker.estimate(sample)))
            }
            Self::Motor(samples) => {
                samples.receive(|batch| batch.iter().for_each(|sample| worker.estimate_motor(sample)))
            }
        }
    }

    /// Samples that never arrived.
    pub fn missed(&self) -> u64 {
        match self {
            Self::Wagon(samples) => samples.missed(),
            Self::Motor(samples) => samples.missed(),
        }
    }
}
