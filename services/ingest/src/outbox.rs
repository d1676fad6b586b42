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
    /// Something was sent for which nobody was woken.
    sent: bool,
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
        Self {
            wagon,
            line,
            sequence: 0,
            last_time_s: f64::NEG_INFINITY,
            begins: true,
            failing: false,
            sent: false,
        }
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

    /// Sends the batch; gives the number of samples sent. Readers sleep until [`Outbox::wake`]. Trouble with one wagon's channel
    /// does not stop the others, it is told once and shows as missed samples.
    pub fn send(&mut self) -> u64 {
        let (count, result) = match &mut self.line {
            Line::Wagon(publisher, batch) => send(publisher, batch),
            Line::Motor(publisher, batch) => send(publisher, batch),
            Line::Bogie(publisher, batch) => send(publisher, batch),
        };
        self.sent = count > 0 && result.is_ok();
        if self.sent {
            return count;
        }
        self.tell(result);
        0
    }

    /// Wakes who reads what was sent.
    pub fn wake(&mut self) {
        if !std::mem::take(&mut self.sent) {
            return;
        }
        let result = match &self.line {
            Line::Wagon(publisher, _) => publisher.wake(),
            Line::Motor(publisher, _) => publisher.wake(),
            Line::Bogie(publisher, _) => publisher.wake(),
        };
        self.tell(result);
    }

    fn tell(&mut self, result: Result<(), BusError>) {
        if let (Err(error), false) = (&result, self.failing) {
            tracing::warn!(wagon = self.wagon, %error, "a batch is lost, or late");
        }
        self.failing = result.is_err();
    }
}

fn send<T: Payload>(publisher: &Publisher<T>, batch: &mut Vec<T>) -> (u64, Result<(), BusError>) {
    let result = publisher.send(batch);
    let count = batch.len() as u64;
    batch.clear();
    (count, result)
}
