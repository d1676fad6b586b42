//! What vehicle buses carry: CAN frames as a DBC file describes them, and process data of TRDP (IEC 61375-2-3) as its XML
//! describes it. Both become rows of a wagon by the one mapping. Nothing here opens a socket or knows a clock.
//!
//! # Glossary
//! * **message**: a frame with an identifier (CAN) or a telegram with a ComId (TRDP).
//! * **cell**: where one value lies in the data of a message, and what its bits mean.
//! * **catalogue**: all messages that a file describes.
//! * **lane**: where a message came from: a CAN interface, or the address of a sender. The same message of another lane is of
//!   another wagon.
//! * **sample message**: the message whose arrival makes a row of what is known by then.

mod catalogue;
mod cell;
pub mod dbc;
mod error;
mod gather;
mod plan;
pub mod trdp;

pub use catalogue::{Catalogue, Found, Message};
pub use cell::{Cell, Kind, Order, Selector, Unread};
pub use error::FieldbusError;
pub use gather::{Gathering, Taken};
pub use plan::{Lanes, Plan};
