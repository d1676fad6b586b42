//! Process data of a train network (TRDP, IEC 61375-2-3): telegrams in UDP datagrams.

use super::overrun::{self, Overruns};
use super::{Inlet, InputError, Tally};
use railgrip_bus::monotonic_ns;
use railgrip_fieldbus::Gathering;
use railgrip_fieldbus::trdp::{Followed, HEADER_BYTES, LARGEST_DATA, Malformed, Sequence, Telegram, parse};
use railgrip_messages::SourceCount;
use railgrip_settings::TrdpSource;
use rustix::net::sockopt::set_socket_recv_buffer_size;
use std::collections::HashMap;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::thread::spawn;
use std::time::Duration;

/// Pause after a datagram that could not be received.
const PAUSE: Duration = Duration::from_secs(1);
/// Counters that are followed; without a list of senders anybody can claim one.
const MOST_COUNTERS: usize = 4096;

/// Starts to listen.
///
/// # Errors
/// An address that cannot be listened on, a group that cannot be joined.
pub(super) fn start(source: &TrdpSource, inlet: Inlet) -> Result<(), InputError> {
    let address = source.listen;
    let failed = |source| InputError::Listen { address, source };
    let socket = UdpSocket::bind(address).map_err(failed)?;
    if let Err(error) = set_socket_recv_buffer_size(&socket, overrun::ROOM) {
        tracing::warn!(%error, "the queue of the socket stays as it is");
    }
    let interface = match address.ip() {
        IpAddr::V4(own) => own,
        IpAddr::V6(_) => Ipv4Addr::UNSPECIFIED,
    };
    for group in &source.groups {
        let refused = |source| InputError::Group { group: *group, source };
        socket.join_multicast_v4(group, &interface).map_err(refused)?;
    }
    socket.set_read_timeout(Some(overrun::PERIOD)).map_err(failed)?;
    let mut telegrams = Telegrams::new(source, inlet);
    spawn(move || {
        // One byte more than the longest telegram: what fills it is longer than that.
        let mut datagram = [0; HEADER_BYTES + LARGEST_DATA + 1];
        let mut overruns = Overruns::new();
        loop {
            overruns.look(&socket, &telegrams.tally);
            match socket.recv_from(&mut datagram) {
                Ok((length, sender)) => {
                    if !telegrams.take(&datagram[..length], sender, monotonic_ns()) {
                        return;
                    }
                }
                Err(error) if overrun::is_pause(&error) => {}
                Err(error) => {
                    tracing::warn!(%error, "a telegram cannot be received");
                    std::thread::sleep(PAUSE);
                }
            }
        }
    });
    Ok(())
}

/// What takes the telegrams.
pub(super) struct Telegrams {
    gathering: Gathering,
    senders: Vec<IpAddr>,
    counters: HashMap<(IpAddr, u32), Sequence>,
    topology: Option<(u32, u32)>,
    tally: Tally,
    inlet: Inlet,
}

impl Telegrams {
    /// Nothing has come yet.
    pub fn new(source: &TrdpSource, inlet: Inlet) -> Self {
        Self {
            gathering: Gathering::new(source.messages.plan.clone(), source.messages.hold_s),
            senders: source.senders.clone(),
            counters: HashMap::new(),
            topology: None,
            tally: inlet.tally().clone(),
            inlet,
        }
    }

    /// Takes a datagram that arrived at an instant of our clock; false once nobody takes rows any more.
    pub fn take(&mut self, datagram: &[u8], sender: SocketAddr, arrived_ns: u64) -> bool {
        self.tally.add(SourceCount::Arrived, 1);
        let telegram = match parse(datagram) {
            Ok(telegram) => telegram,
            Err(why) => {
                self.tally.add(name_of(why), 1);
                return true;
            }
        };
        let lane = match self.senders.as_slice() {
            [] => 0,
            known => match known.iter().position(|known| *known == sender.ip()) {
                Some(lane) => lane,
                None => {
                    self.tally.add(SourceCount::ForeignSender, 1);
                    return true;
                }
            },
        };
        if !self.gathering.wants(lane, telegram.com_id) {
            self.tally.add(SourceCount::Unwanted, 1);
            return true;
        }
        if !self.follow(&telegram, sender.ip()) {
            return true;
        }
        let mut open = true;
        let inlet = &self.inlet;
        let at_s = arrived_ns as f64 * 1e-9;
        let taken = self.gathering.take(lane, telegram.com_id, telegram.data, at_s, &mut |wagon, row| {
            open &= inlet.sample(wagon, row, arrived_ns);
        });
        self.tally.add(SourceCount::Short, u64::from(taken.short));
        self.tally.add(SourceCount::OutOfRange, u64::from(taken.out_of_range));
        open
    }

    /// Follows the counter of a telegram and the topography of the train; false for a telegram that is to be dropped.
    fn follow(&mut self, telegram: &Telegram<'_>, sender: IpAddr) -> bool {
        let key = (sender, telegram.com_id);
        if self.counters.len() >= MOST_COUNTERS && !self.counters.contains_key(&key) {
            self.tally.add(SourceCount::ForeignSender, 1);
            return false;
        }
        let known = self.counters.contains_key(&key);
        match self.counters.entry(key).or_default().take(telegram.sequence) {
            Followed::After { lost } => self.tally.add(SourceCount::Lost, u64::from(lost)),
            Followed::First => self.tally.add(SourceCount::SenderRestarts, u64::from(known)),
            Followed::Old => {
                self.tally.add(SourceCount::Old, 1);
                return false;
            }
        }
        let topology = (telegram.etb_topo_count, telegram.op_train_topo_count);
        // Zeros mean that the sender does not care.
        let changed =
            topology != (0, 0) && self.topology.replace(topology).is_some_and(|before| before != topology);
        if changed {
            self.tally.add(SourceCount::TopologyChanges, 1);
            tracing::warn!(?topology, "the topography of the train has changed: wagons may stand elsewhere");
        }
        true
    }
}

fn name_of(why: Malformed) -> SourceCount {
    match why {
        Malformed::Short => SourceCount::HeaderShort,
        Malformed::Crc => SourceCount::HeaderCrc,
        Malformed::Version => SourceCount::ProtocolVersion,
        Malformed::Kind => SourceCount::TelegramKind,
        Malformed::Length => SourceCount::TelegramLength,
    }
}
