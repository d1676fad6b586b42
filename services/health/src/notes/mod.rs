//! What people write down about a vehicle: notes, and that its brake pads were changed.
//!
//! Notes belong to the vehicle, not to its place in the train. They are kept as lines of JSON beside the journal of alerts:
//! a note counts once its line is on the disk, nothing is ever rewritten, and a line that a power cut left half is skipped.
//! A wagon without a vehicle number is known within one start of the train only: its notes stay in the file and are told no more
//! after the next, when another wagon may run in its place.
//! After a change of pads the trends of pad friction begin anew: what the old pads did says nothing of the new ones.

mod book;
pub mod model;
pub mod routes;

pub use book::{NoteBook, Whose};
