//! What waits to be sent for one wagon.

use crate::counters::Counters;
use crate::validate;
use railgrip_bus::{BogiePublisher, Bus, BusError, MotorPublisher, Publisher, SamplePublisher};
use railgrip_filter::PlantKind;
use railgrip_messages::{BogieSample, MotorSample, Payload, Sample, Stamp, sample_flags};
use railgrip_recording::{BogieRow, MotorRow, Row};

/// The batch of one wagon or rig.
pub(crate) struct Outbox {
    wagon: u32,
    line: Line,
    sequence: u64,
    last_time_s: f64,
    begins: bool,
    failing: bool,
}

/// The channel that it leaves by, with what waits.
enum Line {
    Wagon(SamplePublisher, Vec<Sample>),
    Motor(MotorPublisher, Vec<MotorSample>),
    Bogie(BogiePublisher, Vec<BogieSample>),
}

impl Outbox {
    /// Opens the channel that a wagon or rig needs.
    pub fn open(bus: &Bus, wagon: u32, plant: PlantKind) -> Result<Self, BusError> {
        let line = match plant {
            PlantKind::Traction => Line::Motor(bus.motor_publisher(wagon)?, Vec::new()),
            PlantKind::Bogie => Line::Bogie(bus.bogie_publisher(wagon)?, Vec::new()),
            PlantKind::Wagon | PlantKind::Roller => Line::Wagon(bus.sample_publisher(wagon)?, Vec::new()),
        };
        Ok(Self::new(wagon, line))
    }

    fn new(wagon: u32, line: Line) -> Self {
        Self { wagon, line, sequence: 0, last_time_s: f64::NEG_INFINITY, begins: true, failing: false }
    }

    /// Validates and stamps one row and puts it into the batch.
    pub fn take(
        &mut self,
        row: &Row,
        wheelsets: usize,
        begins: bool,
        acquired: Stamp,
        counters: &mut Counters,
    ) {
        self.begins |= begins;
        let (sample, refused) = validate::sample(row, wheelsets);
        counters.rejected += u64::from(refused);
        let Some(mut sample) = sample else { return };
        (sample.flags, sample.sequence) = self.number(sample.time_s, counters);
        sample.acquired = acquired;
        if let Line::Wagon(_, batch) = &mut self.line {
            batch.push(sample);
        }
    }

    /// The same with a row of a driven rig.
    pub fn take_motor(&mut self, row: &MotorRow, begins: bool, acquired: Stamp, counters: &mut Counters) {
        self.begins |= begins;
        let (sample, refused) = validate::motor_sample(row);
        counters.rejected += u64::from(refused);
        let Some(mut sample) = sample else { return };
        (sample.flags, sample.sequence) = self.number(sample.time_s, counters);
        sample.acquired = acquired;
        if let Line::Motor(_, batch) = &mut self.line {
            batch.push(sample);
        }
    }

    /// The same with a row of a bogie rig.
    pub fn take_bogie(&mut self, row: &BogieRow, begins: bool, acquired: Stamp, counters: &mut Counters) {
        self.begins |= begins;
        let (sample, refused) = validate::bogie_sample(row);
        counters.rejected += u64::from(refused);
        let Some(mut sample) = sample else { return };
        (sample.flags, sample.sequence) = self.number(sample.time_s, counters);
        sample.acquired = acquired;
        if let Line::Bogie(_, batch) = &mut self.line {
            batch.push(sample);
        }
    }

    /// Flags and running number of the next sample.
    fn number(&mut self, time_s: f64, counters: &mut Counters) -> (u32, u64) {
        let mut flags = 0;
        if self.begins {
            flags |= sample_flags::TIME_BASE_RESTARTED;
            self.begins = false;
        } else if time_s <= self.last_time_s {
            counters.late += 1;
        }
        self.last_time_s = time_s;
        self.sequence += 1;
        (flags, self.sequence - 1)
    }

    /// Sends the batch; gives the number of samples sent. Trouble with one wagon's channel does not stop the others,
    /// it is told once and shows as missed samples.
    pub fn send(&mut self) -> Result<u64, BusError> {
        let (sent, result) = match &mut self.line {
            Line::Wagon(publisher, batch) => send(publisher, batch),
            Line::Motor(publisher, batch) => send(publisher, batch),
            Line::Bogie(publisher, batch) => send(publisher, batch),
        };
        match result {
            Ok(()) => {
                self.failing = false;
                Ok(sent)
            }
            Err(error) => {
                if !self.failing {
                    tracing::warn!(wagon = self.wagon, %error, "a batch is lost");
                }
                self.failing = true;
                Ok(0)
            }
        }
    }
}

fn send<T: Payload>(publisher: &Publisher<T>, batch: &mut Vec<T>) -> (u64, Result<(), BusError>) {
    if batch.is_empty() {
        return (0, Ok(()));
    }
    let sent = batch.len() as u64;
    let result = publisher.publish(batch);
    batch.clear();
    (sent, result)
}
