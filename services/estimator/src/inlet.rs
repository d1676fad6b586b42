//! Where an estimator's samples come from: the channel of its wagon, or that of its rig's own sensors.

use crate::worker::Worker;
use railgrip_bus::{BogieSubscriber, Bus, BusError, MotorSubscriber, SampleSubscriber, Wake};
use railgrip_filter::PlantKind;
use std::time::Duration;

/// The receiving end of one wagon or rig.
pub(crate) enum Inlet {
    /// Speeds and pressing forces.
    Wagon(SampleSubscriber),
    /// Motor currents and voltages.
    Motor(MotorSubscriber),
    /// Torque, link force and pulses.
    Bogie(BogieSubscriber),
}

impl Inlet {
    /// Opens the channel that the worker's plant needs.
    pub fn open(bus: &Bus, worker: &Worker) -> Result<Self, BusError> {
        Ok(match worker.plant.kind() {
            PlantKind::Traction => Self::Motor(bus.motor_subscriber(worker.wagon)?),
            PlantKind::Bogie => Self::Bogie(bus.bogie_subscriber(worker.wagon)?),
            PlantKind::Wagon | PlantKind::Roller => Self::Wagon(bus.sample_subscriber(worker.wagon)?),
        })
    }

    /// Sleeps until something arrives or the time is over.
    pub fn wait(&self, timeout: Duration) -> Result<Wake, BusError> {
        match self {
            Self::Wagon(samples) => samples.wait(timeout),
            Self::Motor(samples) => samples.wait(timeout),
            Self::Bogie(samples) => samples.wait(timeout),
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
            Self::Bogie(samples) => {
                samples.receive(|batch| batch.iter().for_each(|sample| worker.estimate_bogie(sample)))
            }
        }
    }

    /// Samples that never arrived.
    pub fn missed(&self) -> u64 {
        match self {
            Self::Wagon(samples) => samples.missed(),
            Self::Motor(samples) => samples.missed(),
            Self::Bogie(samples) => samples.missed(),
        }
    }
}
