//! What the service remembers: a thread that writes it, and the requests that read it.
//!
//! The thread that listens to the channels hands indicators to [`Recorder::take`], which never waits. The [`writer`]
//! thread puts them into buckets and writes those in batches. Requests read through [`History`], each on a connection
//! of its own, and see what was written. When the disk is full or read-only, everything live goes on, and
//! [`History::trouble`] says what is wrong until it is over.

pub mod columns;
pub mod consist;
pub(crate) mod events;
pub mod export;
pub mod query;
mod reader;
pub(crate) mod routes;
mod series;
pub(crate) mod watch;
mod writer;

pub use consist::Consist;
pub use events::{EventPage, EventView};
pub use reader::{History, HistoryStatus};
pub use series::{HistoryView, SeriesView};
pub use writer::{Recorder, start};
