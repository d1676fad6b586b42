//! Creates the services of iceoryx2 behind the channels; knows none of them by name.

use std::any::Any;

use iceoryx2::prelude::{Node, ipc};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeCreateError;
use railgrip_messages::{AudioHeader, Payload};

use crate::audio::AUDIO_BUFFER;
use crate::{BusError, Limits, node};

/// Processes that may have one channel open at a time, beside its publishers and subscribers.
const SPARE_NODES: usize = 8;

/// A created channel, kept for the sake of its existence.
pub(crate) type Kept = Box<dyn Any>;

/// What is created for one channel of one wagon, or of the train.
pub(crate) struct Service {
    /// Name in iceoryx2.
    pub name: String,
    /// Processes that may publish at a time.
    pub publishers: usize,
    /// Batches that a late joiner gets.
    pub history: usize,
}

/// Creates channels on the node of the holder.
pub(crate) struct Creator<'a> {
    pub node: &'a Node<ipc::Service>,
    pub limits: &'a Limits,
}

impl Creator<'_> {
    /// Creates the channel that carries `T`.
    pub(crate) fn channel<T: Payload>(&self, service: &Service) -> Result<Kept, BusError> {
        let name = &service.name;
        let limits = self.limits;
        let created = self
            .node
            .service_builder(&node::service_name(name)?)
            .publish_subscribe::<[T]>()
            .max_publishers(service.publishers)
            .max_subscribers(limits.subscribers)
            .max_nodes(service.publishers + limits.subscribers + SPARE_NODES)
            .history_size(service.history)
            .subscriber_max_buffer_size(limits.buffer)
            .subscriber_max_borrowed_samples(1)
            .enable_safe_overflow(true)
            .create()
            .map_err(|error: PublishSubscribeCreateError| BusError::transport(name, "create it", error))?;
        Ok(Box::new(created))
    }

    /// Creates a channel of audio blocks.
    pub(crate) fn audio(&self, service: &Service) -> Result<Kept, BusError> {
        let name = &service.name;
        let limits = self.limits;
        let created = self
            .node
            .service_builder(&node::service_name(name)?)
            .publish_subscribe::<[f32]>()
            .user_header::<AudioHeader>()
            .max_publishers(service.publishers)
            .max_subscribers(limits.subscribers)
            .max_nodes(service.publishers + limits.subscribers + SPARE_NODES)
            .history_size(service.history)
            .subscriber_max_buffer_size(AUDIO_BUFFER)
            .subscriber_max_borrowed_samples(1)
            .enable_safe_overflow(true)
            .create()
            .map_err(|error: PublishSubscribeCreateError| BusError::transport(name, "create it", error))?;
        Ok(Box::new(created))
    }

    /// Creates the event by which readers of a channel are woken.
    pub(crate) fn wake(&self, service: &Service) -> Result<Kept, BusError> {
        let name = &service.name;
        let limits = self.limits;
        let created = self
            .node
            .service_builder(&node::service_name(name)?)
            .event()
            .max_notifiers(service.publishers)
            .max_listeners(limits.subscribers)
            .max_nodes(service.publishers + limits.subscribers + SPARE_NODES)
            .create()
            .map_err(|error| BusError::transport(name, "create its event", error))?;
        Ok(Box::new(created))
    }
}
