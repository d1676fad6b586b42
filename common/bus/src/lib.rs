//! The channels between the processes of a train, and the only user of the iceoryx2 runtime.
//!
//! # Who does what
//! * The **holder** ([`Holder`], one process a train) creates every channel of [`CHANNELS`] and outlives all others.
//!   Creating channels is not safe against `SIGKILL` in iceoryx2 0.10, opening them is; so exactly one process
//!   creates, under an instance lock, after wiping what a predecessor left.
//! * **Every other process** opens a [`Bus`] and takes typed ports from it. A missing or dead holder and a payload of
//!   another version are refused in words.
//!
//! # What can be relied on
//! * Nothing blocks a publisher: overflow drops the oldest batch of a slow reader, a dead reader costs nothing.
//! * A reader of a channel that counts its items knows what it missed: [`Subscriber::missed`].
//! * Any number of trains and test runs share a machine: each has its own folder and prefix ([`BusConfig`]).
//! * If the holder dies, [`Bus::check_holder`] fails; a process that sees this leaves, and its supervisor restarts all.
//!
//! # How a service is built on it
//! The service libraries expose
//! `railgrip_ingest::run(&TrainSettings, &Lifecycle)`, `railgrip_estimator::run(&TrainSettings, wagon, &Lifecycle)` and
//! `railgrip_health::run(&TrainSettings, &Lifecycle)`, each `-> Result<(), its Error>`; the command line calls them with
//! a [`Lifecycle`] that signals and systemd drive. Ingest returns `Ok` when its source ends. They call, in this order: open the bus, take
//! the ports, [`Lifecycle::ready`], then loop until [`Lifecycle::should_stop`], each round at most 100 ms long:
//! [`Subscriber::wait`], [`Subscriber::receive`], publish, [`Lifecycle::beat`], and about every 500 ms
//! [`Bus::check_holder`]. Publishers of channels with history call [`Publisher::refresh`] about every 100 ms, so that
//! late joiners get the last value soon. Ports stay on the thread that opened them.
//!
//! # Glossary
//! * **instance**: one running train on this machine: its folder, lock, channels.
//! * **batch**: the slice of items that one message carries.
//! * **history**: the last batches of a publisher, delivered to those who join late.

mod audio;
pub mod bare;
mod channels;
mod clock;
mod config;
mod creator;
mod error;
mod folder;
mod holder;
mod kept;
mod ledger;
mod lifecycle;
mod node;
mod open;
mod ports;
mod presence;
mod shared_memory;

pub use audio::{AudioPublisher, AudioSubscriber, MAX_AUDIO_BLOCK};
pub use channels::{CHANNELS, Channel, Scope, channel};
pub use clock::{monotonic_ns, now};
pub use config::{BusConfig, Limits};
pub use error::BusError;
pub use folder::own_folder;
pub use holder::{Holder, holder_pid};
pub use kept::{KeptError, keep, kept};
pub use ledger::{Ledger, Left};
pub use lifecycle::Lifecycle;
pub use open::Bus;
pub use ports::{
    BogiePublisher, BogieSubscriber, EstimatePublisher, EstimateSubscriber, EventPublisher, EventSubscriber,
    HealthPublisher, HealthSubscriber, HeardPublisher, HeardSubscriber, HeartbeatPublisher,
    HeartbeatSubscriber, InnovationPublisher, InnovationSubscriber, MotorPublisher, MotorSubscriber,
    Publisher, SamplePublisher, SampleSubscriber, SourcePublisher, SourceSubscriber, Subscriber,
    VerdictPublisher, VerdictSubscriber, Wake,
};
pub use presence::{Turn, take_turn};
