//! What the train remembers: indicators over time, in an embedded database on board.
//!
//! # Terms
//! * **column** – one indicator of a wagon (`mu_b_front`); a column keeps its place for the life of the database.
//! * **bucket** – one column's mean, smallest and largest value over one width of time.
//! * **tier** – all buckets of one width: 1 s, 1 min, 1 h. Coarser tiers are made of the finer one.
//! * **block** – the buckets of one wagon and tier over one minute, hour or day, compressed: the unit of writing. One
//!   row per block instead of one per value is what spares the flash.
//!
//! # Durability
//! A value is *kept* once [`Store::flush`] has returned `Ok` after it was pushed: SQLite in WAL mode with full
//! synchronisation has it on the medium. Only the second tier is written at every flush; the coarser ones are written
//! when a block is complete, and what a crash takes from them is computed again from the finer tier when the store is
//! opened. A full or read-only disk fails a flush and loses nothing that was kept before; blocks wait in memory, up
//! to a limit, for the next flush.
//!
//! Times are Unix seconds. When the wall clock jumps back, values are merged into the buckets that are there.

mod block;
mod error;
mod event;
mod key;
mod query;
mod query_rows;
mod retention;
mod schema;
mod store;
mod stored;
mod tier;
mod track_cell;
mod vehicles;

pub use block::{BlockError, Bucket, Cell, Keep};
pub use error::HistoryError;
pub use event::{Event, EventFilter, NumberedEvent};
pub use query::{Point, Reader};
pub use retention::{Limits, Retention};
pub use schema::{FormerName, SCHEMA_VERSION};
pub use store::{Flushed, Store};
pub use tier::Tier;
pub use vehicles::{FIRST_VEHICLE, Vehicle};
