//! iceoryx2 alone, with our payload and our wake-up: the reference beside which the latency of the real way is measured.
//! No product code uses this.

use std::time::{Duration, Instant};

use iceoryx2::port::{notifier, publisher};
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, CallbackProgression, Node, SignalHandlingMode, WaitSetBuilder,
    ipc,
};
use iceoryx2::service::port_factory::{event, publish_subscribe};
use railgrip_messages::Sample;

use crate::{Bus, BusError, clock, node};

const NAME: &str = "bare";
const MAX_BATCH: usize = 32;
const PATIENCE: Duration = Duration::from_secs(3);
const BUFFER: usize = 64;

fn failed(error: impl std::fmt::Debug) -> BusError {
    BusError::transport(NAME, "measure", error)
}

/// Sends batches over a channel of its own.
pub struct BareSender {
    publisher: publisher::Publisher<ipc::Service, [Sample], ()>,
    notifier: notifier::Notifier<ipc::Service>,
    // The services outlive the ports: whoever receives opens them.
    _data: publish_subscribe::PortFactory<ipc::Service, [Sample], ()>,
    _event: event::PortFactory<ipc::Service>,
    _node: Node<ipc::Service>,
}

impl BareSender {
    /// Creates the channel in the instance that `bus` has joined.
    ///
    /// # Errors
    /// If iceoryx2 refuses.
    pub fn create(bus: &Bus) -> Result<Self, BusError> {
        let node = node::create(bus.config(), NAME)?;
        let name = node::service_name(NAME)?;
        let data = node.service_builder(&name).publish_subscribe::<[Sample]>();
        let data = data.subscriber_max_buffer_size(BUFFER).create().map_err(failed)?;
        let event = node.service_builder(&name).event().create().map_err(failed)?;
        let publisher = data
            .publisher_builder()
            .initial_max_slice_len(MAX_BATCH)
            .allocation_strategy(AllocationStrategy::Static)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(failed)?;
        let notifier = event.notifier_builder().create().map_err(failed)?;
        Ok(Self { publisher, notifier, _data: data, _event: event, _node: node })
    }

    /// Sends a batch and wakes the receiver.
    ///
    /// # Errors
    /// If iceoryx2 refuses.
    pub fn send(&self, batch: &[Sample]) -> Result<(), BusError> {
        let loan = self.publisher.loan_slice_uninit(batch.len()).map_err(failed)?;
        loan.write_from_slice(batch).send().map_err(failed)?;
        self.notifier.notify().map_err(failed)?;
        Ok(())
    }
}

/// Receives up to `batches` batches and returns the age of each batch's last sample on arrival, ns. It ends early if
/// nothing comes for three seconds.
///
/// # Errors
/// If iceoryx2 refuses.
pub fn receive(bus: &Bus, batches: usize) -> Result<Vec<u64>, BusError> {
    let node = node::create(bus.config(), NAME)?;
    let name = node::service_name(NAME)?;
    let event = node.service_builder(&name).event().open().map_err(failed)?;
    let data = node.service_builder(&name).publish_subscribe::<[Sample]>().open().map_err(failed)?;
    let listener = event.listener_builder().create().map_err(failed)?;
    let subscriber = data.subscriber_builder().create().map_err(failed)?;
    let waitset = WaitSetBuilder::new()
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .map_err(failed)?;
    let _attached = waitset.attach_notification(&listener).map_err(failed)?;
    let mut ages_ns = Vec::with_capacity(batches);
    let mut last = Instant::now();
    while ages_ns.len() < batches {
        let timeout = Duration::from_secs(1);
        waitset
            .wait_and_process_once_with_timeout(|_| CallbackProgression::Continue, timeout)
            .map_err(failed)?;
        listener.try_wait(|_| {}).map_err(failed)?;
        while let Some(batch) = subscriber.receive().map_err(failed)? {
            let now_ns = clock::monotonic_ns();
            if let Some(sample) = batch.payload().last() {
                ages_ns.push(now_ns.saturating_sub(sample.acquired.monotonic_ns));
            }
            last = Instant::now();
        }
        if last.elapsed() > PATIENCE {
            break;
        }
    }
    Ok(ages_ns)
}
