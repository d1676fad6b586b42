//! The HTTP interface: one place a resource, with what it says (`model`), how that comes from the messages (`view`) and who
//! asks for it (`routes`). [`router`] puts all routes together and can be tested without a socket.
//!
//! Resources with a life of their own bring their routes along: [`crate::alerts`], [`crate::history`],
//! [`crate::access`].

pub mod acoustic;
pub mod adhesion_map;
pub(crate) mod answer;
pub mod capability;
pub mod checks;
mod docs;
mod docs_page;
pub mod figure;
pub mod figures;
pub mod grade;
pub mod metrics;
pub mod problem;
pub mod processes;
mod router;
pub(crate) mod sources;
mod stream;
pub mod train;
pub mod trends;
pub mod wagons;

pub use router::router;
