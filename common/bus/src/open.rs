//! How every process but the holder joins a train.

use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, Config, MessagingPattern, Node, Service as _, ipc,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::{event, publish_subscribe};
use railgrip_messages::{AUDIO_TYPE_NAME, AudioHeader, NO_WAGON, Payload, ProcessKind};

use crate::audio::MAX_AUDIO_BLOCK;
use crate::folder::own_folder;
use crate::ports::{Publisher, Subscriber, waking};
use crate::presence::{self, Kind, Lock, Membership};
use crate::{
    AudioPublisher, AudioSubscriber, BogiePublisher, BogieSubscriber, BusConfig, BusError, Channel,
    EstimatePublisher, EstimateSubscriber, EventPublisher, EventSubscriber, HealthPublisher,
    HealthSubscriber, HeardPublisher, HeardSubscriber, HeartbeatPublisher, HeartbeatSubscriber,
    InnovationPublisher, InnovationSubscriber, MotorPublisher, MotorSubscriber, SamplePublisher,
    SampleSubscriber, SourcePublisher, SourceSubscriber, VerdictPublisher, VerdictSubscriber, channel, node,
};

/// How long to wait for a holder that is still creating, and for places of dead processes to come free.
const PATIENCE: Duration = Duration::from_secs(5);
const RETRY: Duration = Duration::from_millis(10);

type Data<T> = publish_subscribe::PortFactory<ipc::Service, [T], ()>;
type Audio = publish_subscribe::PortFactory<ipc::Service, [f32], AudioHeader>;

/// The membership of one process in a train; gives out ports.
pub struct Bus {
    node: Node<ipc::Service>,
    config: BusConfig,
    incarnation: String,
    member: Arc<Membership>,
}

impl Bus {
    /// Joins the train of `config` as `process` (of `wagon`, or 0).
    ///
    /// # Errors
    /// [`BusError::NoHolder`] if no holder runs; what the system or iceoryx2 refused otherwise.
    pub fn open(config: BusConfig, process: ProcessKind, wagon: u32) -> Result<Self, BusError> {
        config.validate()?;
        if config.dir.exists() {
            own_folder(&config.dir)?;
        }
        let name = presence::role_name(process, wagon);
        let no_holder = || BusError::NoHolder { train: config.train.clone(), folder: config.dir.clone() };
        let deadline = Instant::now() + PATIENCE;
        loop {
            if !presence::holder_alive(&config)? {
                return Err(no_holder());
            }
            let presence = Lock::acquire(&presence::ports_lock_file(&config), Kind::Shared, RETRY)?;
            if let (Some(lock), Some(incarnation)) = (presence, presence::incarnation(&config)) {
                config.install()?;
                let role = role(&config, process, &name)?;
                let node = node::create(&config, &name)?;
                let member = Arc::new(Membership { _ports: lock, _role: role });
                return Ok(Self { node, config, incarnation, member });
            }
            if Instant::now() >= deadline {
                return Err(no_holder());
            }
            std::thread::sleep(RETRY);
        }
    }

    /// The instance that this process has joined.
    #[must_use]
    pub const fn config(&self) -> &BusConfig {
        &self.config
    }

    /// Fails once the holder that created our channels is gone: whatever we publish then reaches nobody.
    /// Costs a few system calls; call it about every 500 ms.
    ///
    /// # Errors
    /// [`BusError::HolderGone`]; the process shall leave.
    pub fn check_holder(&self) -> Result<(), BusError> {
        let same = presence::incarnation(&self.config).as_deref() == Some(self.incarnation.as_str());
        if same && presence::holder_alive(&self.config)? {
            return Ok(());
        }
        Err(BusError::HolderGone { train: self.config.train.clone() })
    }

    /// Sends samples of one wagon.
    ///
    /// # Errors
    /// As for every port: no such channel, another version, no place free, refused by iceoryx2.
    pub fn sample_publisher(&self, wagon: u32) -> Result<SamplePublisher, BusError> {
        self.publisher("samples", wagon)
    }

    /// Receives samples of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn sample_subscriber(&self, wagon: u32) -> Result<SampleSubscriber, BusError> {
        self.subscriber("samples", wagon)
    }

    /// Sends motor samples of one rig.
    ///
    /// # Errors
    /// As for every port.
    pub fn motor_publisher(&self, wagon: u32) -> Result<MotorPublisher, BusError> {
        self.publisher("motors", wagon)
    }

    /// Receives motor samples of one rig.
    ///
    /// # Errors
    /// As for every port.
    pub fn motor_subscriber(&self, wagon: u32) -> Result<MotorSubscriber, BusError> {
        self.subscriber("motors", wagon)
    }

    /// Sends samples of one bogie rig.
    ///
    /// # Errors
    /// As for every port.
    pub fn bogie_publisher(&self, wagon: u32) -> Result<BogiePublisher, BusError> {
        self.publisher("bogies", wagon)
    }

    /// Receives samples of one bogie rig.
    ///
    /// # Errors
    /// As for every port.
    pub fn bogie_subscriber(&self, wagon: u32) -> Result<BogieSubscriber, BusError> {
        self.subscriber("bogies", wagon)
    }

    /// Sends estimates of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn estimate_publisher(&self, wagon: u32) -> Result<EstimatePublisher, BusError> {
        self.publisher("estimates", wagon)
    }

    /// Receives estimates of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn estimate_subscriber(&self, wagon: u32) -> Result<EstimateSubscriber, BusError> {
        self.subscriber("estimates", wagon)
    }

    /// Sends innovations of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn innovation_publisher(&self, wagon: u32) -> Result<InnovationPublisher, BusError> {
        self.publisher("innovations", wagon)
    }

    /// Receives innovations of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn innovation_subscriber(&self, wagon: u32) -> Result<InnovationSubscriber, BusError> {
        self.subscriber("innovations", wagon)
    }

    /// Sends the audio of the microphone of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn audio_publisher(&self, wagon: u32) -> Result<AudioPublisher, BusError> {
        let (name, data) = self.audio(wagon)?;
        let port = patiently(&name, "publisher", || {
            data.publisher_builder()
                .initial_max_slice_len(MAX_AUDIO_BLOCK)
                .max_loaned_samples(1)
                .allocation_strategy(AllocationStrategy::Static)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        })?;
        let notifier = self.notifier(&name)?;
        Ok(AudioPublisher::new(name, port, notifier, self.member()))
    }

    /// Receives the audio of the microphone of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn audio_subscriber(&self, wagon: u32) -> Result<AudioSubscriber, BusError> {
        let (name, data) = self.audio(wagon)?;
        let waking = waking(&name, self.listener(&name)?)?;
        let port = patiently(&name, "subscriber", || data.subscriber_builder().create())?;
        Ok(AudioSubscriber::new(name, port, waking, self.member()))
    }

    /// Sends what the microphone of one wagon heard.
    ///
    /// # Errors
    /// As for every port.
    pub fn heard_publisher(&self, wagon: u32) -> Result<HeardPublisher, BusError> {
        self.publisher("heard", wagon)
    }

    /// Receives what the microphone of one wagon heard.
    ///
    /// # Errors
    /// As for every port.
    pub fn heard_subscriber(&self, wagon: u32) -> Result<HeardSubscriber, BusError> {
        self.subscriber("heard", wagon)
    }

    /// Sends the indicators of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn health_publisher(&self, wagon: u32) -> Result<HealthPublisher, BusError> {
        self.publisher("health", wagon)
    }

    /// Receives the indicators of one wagon.
    ///
    /// # Errors
    /// As for every port.
    pub fn health_subscriber(&self, wagon: u32) -> Result<HealthSubscriber, BusError> {
        self.subscriber("health", wagon)
    }

    /// Sends what is wrong with the train.
    ///
    /// # Errors
    /// As for every port.
    pub fn verdict_publisher(&self) -> Result<VerdictPublisher, BusError> {
        self.publisher("verdicts", NO_WAGON)
    }

    /// Receives what is wrong with the train.
    ///
    /// # Errors
    /// As for every port.
    pub fn verdict_subscriber(&self) -> Result<VerdictSubscriber, BusError> {
        self.subscriber("verdicts", NO_WAGON)
    }

    /// Sends events.
    ///
    /// # Errors
    /// As for every port.
    pub fn event_publisher(&self) -> Result<EventPublisher, BusError> {
        self.publisher("events", NO_WAGON)
    }

    /// Receives the events of all processes.
    ///
    /// # Errors
    /// As for every port.
    pub fn event_subscriber(&self) -> Result<EventSubscriber, BusError> {
        self.subscriber("events", NO_WAGON)
    }

    /// Sends how the source of samples fares.
    ///
    /// # Errors
    /// As for every port.
    pub fn source_publisher(&self) -> Result<SourcePublisher, BusError> {
        self.publisher("sources", NO_WAGON)
    }

    /// Receives how the source of samples fares.
    ///
    /// # Errors
    /// As for every port.
    pub fn source_subscriber(&self) -> Result<SourceSubscriber, BusError> {
        self.subscriber("sources", NO_WAGON)
    }

    /// Sends heartbeats.
    ///
    /// # Errors
    /// As for every port.
    pub fn heartbeat_publisher(&self) -> Result<HeartbeatPublisher, BusError> {
        self.publisher("heartbeats", NO_WAGON)
    }

    /// Receives the heartbeats of all processes.
    ///
    /// # Errors
    /// As for every port.
    pub fn heartbeat_subscriber(&self) -> Result<HeartbeatSubscriber, BusError> {
        self.subscriber("heartbeats", NO_WAGON)
    }

    fn publisher<T: Payload>(&self, channel_name: &str, wagon: u32) -> Result<Publisher<T>, BusError> {
        let (row, name, data) = self.data::<T>(channel_name, wagon)?;
        let max_batch = row.max_batch(&self.config.limits);
        let port = patiently(&name, "publisher", || {
            data.publisher_builder()
                .initial_max_slice_len(max_batch)
                .max_loaned_samples(1)
                .allocation_strategy(AllocationStrategy::Static)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        })?;
        let notifier = if row.wakes { Some(self.notifier(&name)?) } else { None };
        Ok(Publisher::new(name, port, notifier, max_batch, self.member()))
    }

    fn subscriber<T: Payload>(&self, channel_name: &str, wagon: u32) -> Result<Subscriber<T>, BusError> {
        let (row, name, data) = self.data::<T>(channel_name, wagon)?;
        // The listener comes first: whatever arrives from the first moment on wakes.
        let listener = if row.wakes { Some(self.listener(&name)?) } else { None };
        let port = patiently(&name, "subscriber", || data.subscriber_builder().create())?;
        Subscriber::new(name, port, listener, row.counted, self.member())
    }

    fn member(&self) -> Arc<Membership> {
        Arc::clone(&self.member)
    }

    fn notifier(&self, name: &str) -> Result<Notifier<ipc::Service>, BusError> {
        let event = self.event(name)?;
        patiently(name, "notifier", || event.notifier_builder().create())
    }

    fn listener(&self, name: &str) -> Result<Listener<ipc::Service>, BusError> {
        let event = self.event(name)?;
        patiently(name, "listener", || event.listener_builder().create())
    }

    fn event(&self, name: &str) -> Result<event::PortFactory<ipc::Service>, BusError> {
        let service_name = node::service_name(name)?;
        patiently(name, "process", || self.node.service_builder(&service_name).event().open())
    }

    fn audio(&self, wagon: u32) -> Result<(String, Audio), BusError> {
        let missing =
            |name: &str| BusError::NoChannel { channel: name.to_owned(), train: self.config.train.clone() };
        let row = channel("audio").ok_or_else(|| missing("audio"))?;
        let name = row.service_name(wagon);
        let service_name = node::service_name(&name)?;
        let opened = patiently(&name, "process", || {
            let builder = self.node.service_builder(&service_name).publish_subscribe::<[f32]>();
            match builder.user_header::<AudioHeader>().open() {
                Err(PublishSubscribeOpenError::IncompatibleTypes) => Ok(Err(BusError::Version {
                    channel: name.clone(),
                    ours: AUDIO_TYPE_NAME.to_owned(),
                    theirs: "another payload".to_owned(),
                })),
                Err(PublishSubscribeOpenError::DoesNotExist) => Ok(Err(missing(&name))),
                Err(error) => Err(error),
                Ok(data) => Ok(Ok(data)),
            }
        })?;
        opened.map(|data| (name, data))
    }

    fn data<T: Payload>(
        &self,
        channel_name: &str,
        wagon: u32,
    ) -> Result<(&'static Channel, String, Data<T>), BusError> {
        let missing =
            |name: &str| BusError::NoChannel { channel: name.to_owned(), train: self.config.train.clone() };
        let row = channel(channel_name).ok_or_else(|| missing(channel_name))?;
        let name = row.service_name(wagon);
        let service_name = node::service_name(&name)?;
        let opened = patiently(&name, "process", || {
            match self.node.service_builder(&service_name).publish_subscribe::<[T]>().open() {
                Err(PublishSubscribeOpenError::IncompatibleTypes) => Ok(Err(self.version_error::<T>(&name))),
                Err(PublishSubscribeOpenError::DoesNotExist) => Ok(Err(missing(&name))),
                Err(error) => Err(error),
                Ok(data) => Ok(Ok(data)),
            }
        })?;
        opened.map(|data| (row, name, data))
    }

    fn version_error<T: Payload>(&self, name: &str) -> BusError {
        let theirs = node::service_name(name).ok().and_then(|service_name| {
            let pattern = MessagingPattern::PublishSubscribe;
            let details = ipc::Service::details(&service_name, Config::global_config(), pattern).ok()??;
            let payload = &details.static_details.publish_subscribe().message_type_details().payload;
            Some(format!("{} ({} bytes)", payload.type_name(), payload.size()))
        });
        BusError::Version {
            channel: name.to_owned(),
            ours: format!("{} ({} bytes)", T::TYPE_NAME, size_of::<T>()),
            theirs: theirs.unwrap_or_else(|| "an unknown payload".to_owned()),
        }
    }
}

/// Makes this process the only one of its kind, for its wagon; a predecessor that is about to leave gets some time.
fn role(config: &BusConfig, process: ProcessKind, name: &str) -> Result<Option<Lock>, BusError> {
    let Some(file) = presence::role_lock_file(config, process, name) else { return Ok(None) };
    match Lock::acquire(&file, Kind::Exclusive, PATIENCE)? {
        Some(lock) => Ok(Some(lock)),
        None => Err(BusError::RoleTaken { train: config.train.clone(), role: name.to_owned(), file }),
    }
}

/// Repeats what fails because the places of dead processes are not cleaned up yet.
fn patiently<P, E: std::fmt::Debug>(
    channel: &str,
    port: &'static str,
    mut attempt: impl FnMut() -> Result<P, E>,
) -> Result<P, BusError> {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let error = match attempt() {
            Ok(port) => return Ok(port),
            Err(error) => error,
        };
        let reason = format!("{error:?}");
        if !reason.starts_with("Exceeds") {
            return Err(BusError::transport(channel, "open it", error));
        }
        if Instant::now() >= deadline {
            return Err(BusError::NoPlace { channel: channel.to_owned(), port });
        }
        std::thread::sleep(RETRY);
    }
}
