//! Names and the node: what holder and children share of iceoryx2.

use iceoryx2::prelude::{Node, NodeBuilder, NodeName, ServiceName, SignalHandlingMode, ipc};

use crate::{BusConfig, BusError};

/// Joins the instance whose configuration is installed. Signals stay with the program.
pub(crate) fn create(config: &BusConfig, name: &str) -> Result<Node<ipc::Service>, BusError> {
    let failed =
        |reason: String| BusError::Node { train: config.train.clone(), folder: config.dir.clone(), reason };
    let name = NodeName::new(name).map_err(|error| failed(format!("{error:?}")))?;
    NodeBuilder::new()
        .name(&name)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .map_err(|error| failed(format!("{error:?}")))
}

pub(crate) fn service_name(name: &str) -> Result<ServiceName, BusError> {
    ServiceName::new(name).map_err(|error| BusError::transport(name, "use this name", error))
}
