//! Samples as others send them: whatever brings them puts rows into an [`Inlet`], each with the time of its source, and the feed
//! stamps them by that time, counts what is late and refuses columns that cannot be in their units.

use super::heir::Heir;
use super::wagon::Wagon;
use super::{Account, Arrival, Feed, Layout, Next, SourceClock, Tally};
use railgrip_bus::monotonic_ns;
use railgrip_filter::PlantKind;
use railgrip_messages::SourceCount;
use railgrip_recording::Row;
use railgrip_settings::{MqttSource, Source, Subjects, TrainSettings};
use railgrip_vehicle::VehicleParameters;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};

/// Rows that may wait; beyond that whoever brings them waits.
const WAITING: usize = 4096;

/// A source of rows that come by themselves.
pub struct Live {
    name: String,
    received: Receiver<Item>,
    inlet: Option<Inlet>,
    wagons: Vec<Wagon>,
    tally: Tally,
    heir: Option<Heir>,
    /// Something came in since the last look.
    moved: bool,
}

/// Where rows come in; the source has ended when all of its inlets are gone.
#[derive(Clone)]
pub struct Inlet {
    sender: SyncSender<Item>,
    layout: Layout,
    tally: Tally,
}

enum Item {
    Row { wagon: usize, row: Box<Row>, arrived_ns: u64 },
    Refused(String),
}

impl Inlet {
    /// What a line may say.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// What the source has counted.
    #[must_use]
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Takes a row of a wagon (from 0), or the words about something that is none; waits while too many wait. False once
    /// nobody takes them any more.
    pub fn put(&self, row: Result<(usize, Row), String>) -> bool {
        self.tally.add(SourceCount::Arrived, 1);
        match row {
            Ok((wagon, row)) => self.sample(wagon, row, monotonic_ns()),
            Err(problem) => {
                self.tally.add(SourceCount::Unreadable, 1);
                self.refuse(problem)
            }
        }
    }

    /// Passes the words about something that is no sample and was counted already; waits and ends as [`Inlet::put`].
    pub fn refuse(&self, problem: String) -> bool {
        self.sender.send(Item::Refused(problem)).is_ok()
    }

    /// Takes a row of a wagon (from 0) that came of messages, the last of which arrived at an instant of our monotonic clock, ns;
    /// waits and ends as [`Inlet::put`].
    pub fn sample(&self, wagon: usize, row: Row, arrived_ns: u64) -> bool {
        self.sender.send(Item::Row { wagon, row: Box::new(row), arrived_ns }).is_ok()
    }
}

impl Live {
    /// The source of a train, with its mapping and vehicle numbers.
    #[must_use]
    pub fn new(settings: &TrainSettings) -> Self {
        let vehicles: Vec<_> = settings.wagons.iter().map(|wagon| wagon.vehicle.clone()).collect();
        let plants: Vec<_> = settings.wagons.iter().map(|wagon| wagon.plant.kind()).collect();
        let name = match &settings.source {
            Source::Tcp(address) => format!("TCP connections to {address}"),
            Source::Udp(address) => format!("UDP datagrams to {address}"),
            Source::Mqtt(broker) => format!("MQTT broker {}:{}", broker.host, broker.port),
            Source::Can(can) => match &can.log {
                Some(log) => format!("frames of {}", log.file.display()),
                None => format!("CAN {}", can.interfaces.join(", ")),
            },
            Source::Trdp(trdp) => format!("TRDP telegrams to {}", trdp.listen),
            _ => "standard input".to_owned(),
        };
        let mut live = Self::of(&name, &vehicles, &plants);
        if let Some(inlet) = &mut live.inlet {
            inlet.layout.mapping.clone_from(&settings.mapping);
            // What a log says is long past, and its pace is ours.
            let plan = match &settings.source {
                Source::Can(can) => Some((&can.messages.plan, can.log.is_none())),
                Source::Trdp(trdp) => Some((&trdp.messages.plan, true)),
                _ => None,
            };
            let topics = match &settings.source {
                Source::Mqtt(MqttSource { subjects: Subjects::Values(topics), .. }) => Some(&topics.wagons),
                _ => None,
            };
            let is_live = plan.is_none_or(|(_, live)| live);
            for (place, wagon) in live.wagons.iter_mut().enumerate() {
                let by_topics = topics.is_none_or(|wagons| wagons[place].carries_time());
                let times = plan.map_or(by_topics, |(plan, _)| plan.carries_time(place));
                wagon.own_clock = is_live && times;
                wagon.clock = SourceClock::of_kind(is_live);
                wagon.own_times = !is_live || times;
            }
            inlet.layout.numbers = settings.wagons.iter().map(|wagon| wagon.vehicle_number.clone()).collect();
        }
        // A log is played from its beginning again.
        let played = matches!(&settings.source, Source::Can(can) if can.log.is_some());
        live.heir = (!played).then(|| Heir::new(settings, &live.name));
        live
    }

    /// A source under that name for these wagons.
    #[must_use]
    pub fn of(name: &str, vehicles: &[VehicleParameters], plants: &[PlantKind]) -> Self {
        let (sender, received) = sync_channel(WAITING);
        let wheelsets = vehicles.iter().map(VehicleParameters::wheelsets).collect();
        let layout = Layout { wheelsets, ..Layout::default() };
        let tally = Tally::default();
        let wagons =
            vehicles.iter().zip(plants).map(|(vehicle, plant)| Wagon::new(vehicle, *plant)).collect();
        Self {
            name: name.to_owned(),
            received,
            inlet: Some(Inlet { sender, layout, tally: tally.clone() }),
            wagons,
            tally,
            heir: None,
            moved: false,
        }
    }

    /// The inlet, once: clones of it may go to several threads.
    #[must_use]
    pub fn inlet(&mut self) -> Option<Inlet> {
        self.inlet.take()
    }
}

impl Feed for Live {
    fn begin(&mut self) {
        if let Some(heir) = &mut self.heir {
            heir.inherit(&self.tally, &mut self.wagons);
        }
    }

    fn sending(&mut self) {
        if let Some(heir) = self.heir.as_mut().filter(|_| self.moved) {
            heir.leave(&self.tally, &self.wagons);
        }
    }

    fn sent(&mut self, wagons: usize) {
        if let Some(heir) = self.heir.as_mut().filter(|_| self.moved) {
            heir.sent(wagons);
        }
    }

    fn take_due(&mut self, _until_s: f64, sink: &mut dyn FnMut(Arrival<'_>)) -> Next {
        self.moved = false;
        loop {
            match self.received.try_recv() {
                Ok(Item::Row { wagon, row, arrived_ns }) => {
                    self.moved = true;
                    if let Some(known) = self.wagons.get_mut(wagon) {
                        known.take(wagon, &row, arrived_ns, sink);
                    }
                }
                Ok(Item::Refused(problem)) => sink(Arrival::Refused(problem)),
                Err(TryRecvError::Empty) => return Next::More,
                Err(TryRecvError::Disconnected) => {
                    self.wagons.iter_mut().enumerate().for_each(|(wagon, known)| known.end(wagon, sink));
                    return Next::Ended;
                }
            }
        }
    }

    fn accounts(&self) -> Option<(Account, Vec<Account>)> {
        let whole = Account { counts: self.tally.counts(), drift_ppm: None };
        Some((whole, self.wagons.iter().map(Wagon::account).collect()))
    }

    fn speed(&self) -> f64 {
        1.0
    }

    fn describe(&self) -> String {
        self.name.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::When;

    fn coach() -> VehicleParameters {
        toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("the default vehicle")
    }

    /// Feeds 40 s of rolling at 100 Hz with a speed in units of `factor` m/s; counts rows taken and withheld, and what was told.
    fn rolled(factor: f64) -> (usize, usize, Vec<Option<String>>) {
        let vehicle = coach();
        let radius_m = vehicle.wheelset.radius_m;
        let mut live = Live::of("test", &[vehicle], &[PlantKind::Wagon]);
        let inlet = live.inlet().expect("the first");
        let (mut rows, mut withheld, mut told) = (0, 0, Vec::new());
        for k in 0..4000 {
            let mut row = Row { t_s: 0.01 * f64::from(k), v_m_s: 16.0 * factor, ..Row::default() };
            row.wheel_speed_rad_s[..2].fill(16.0 / radius_m);
            row.pressing_force_n[..2].fill(0.0);
            assert!(inlet.put(Ok((0, row))));
            live.take_due(0.0, &mut |arrival| match arrival {
                Arrival::Row { .. } => rows += 1,
                Arrival::Withheld { .. } => withheld += 1,
                Arrival::Implausible { why, .. } => told.push(why),
                other => panic!("{other:?}"),
            });
        }
        drop(inlet);
        assert_eq!(live.take_due(0.0, &mut |_| ()), Next::Ended);
        (rows, withheld, told)
    }

    #[test]
    fn a_speed_in_km_per_hour_is_withheld_once_it_is_seen_and_a_sound_one_never_is() {
        assert_eq!(rolled(1.0), (4000, 0, vec![]));
        let (rows, withheld, told) = rolled(3.6);
        assert!(rows < 250 && rows + withheld == 4000, "{rows} {withheld}");
        assert_eq!(told.len(), 1);
        let why = told[0].clone().expect("a reason");
        assert!(why.contains("v_m_s") && why.contains("km/h"), "{why}");
    }

    #[test]
    fn rows_of_one_packet_all_arrive_and_repeats_are_late() {
        let mut live = Live::of("test", &[coach()], &[PlantKind::Wagon]);
        let inlet = live.inlet().expect("the first");
        let (mut stamps, mut late) = (Vec::new(), 0);
        for t_s in [0.0, 0.01, 0.02, 0.02, 0.015, 0.03] {
            inlet.put(Ok((0, Row { t_s, ..Row::default() })));
        }
        live.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { when: When::At(at_ns), .. } => stamps.push(at_ns),
            Arrival::Late { wagon: 0 } => late += 1,
            other => panic!("{other:?}"),
        });
        assert_eq!((stamps.len(), late), (4, 2));
        assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]), "{stamps:?}");
    }

    /// Values that no sensor gives were counted nowhere by name, and a time of 1e300 s moved the base of all that followed.
    #[test]
    fn impossible_values_and_times_have_a_name_and_move_nothing() {
        let mut live = Live::of("test", &[coach()], &[PlantKind::Wagon]);
        let inlet = live.inlet().expect("the first");
        let row = |t_s: f64, v_m_s: f64| Row { t_s, v_m_s, ..Row::default() };
        for row in
            [row(0.0, 20.0), row(0.01, 1e9), row(1e300, 20.0), row(f64::NAN, 20.0), row(0.02, f64::INFINITY)]
        {
            inlet.put(Ok((0, row)));
        }
        let (mut times, mut begun, mut refused) = (Vec::new(), 0, 0);
        live.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { row, begins, .. } => {
                times.push(row.t_s);
                begun += u32::from(begins);
            }
            Arrival::Refused(_) => refused += 1,
            other => panic!("{other:?}"),
        });
        let counts = live.accounts().expect("accounts").1[0].counts;
        let count = |what: SourceCount| counts[what.code() as usize];
        assert_eq!((times, refused), (vec![0.0, 0.01, 0.02], 2));
        assert!(begun <= 1, "the base stays: {begun}");
        assert_eq!((count(SourceCount::OutOfRange), count(SourceCount::Unreadable)), (3, 1));
    }
}
