//! From the sensors of all wagons of a train to the one cause that explains what they show: pure arithmetic, no clock, no
//! channel, no file. README.md beside this crate says what can be seen, what cannot, and why.
//!
//! [`TrainWatch`] takes the readings of all wagons of one instant and keeps one open [`Alert`] a fault. It judges in this
//! order, so that a wrong sensor is never called a wrong brake:
//!
//! | step | file | what is compared |
//! | --- | --- | --- |
//! | seconds | `second` | means, slopes and ripple of each channel over a second |
//! | sensors | `sensors` | missing, late, eccentric and ringing tachometers; speed against the train's |
//! | pressure | `pressure`, `timing` | pressing forces of a wagon's wheelsets beside one another and against the order; when they rise and fall |
//! | creepage | `creepage`, `within`, `grip` | wheel speed over train speed against the forces, wheelset by wheelset, against its own past; within the wagon second by second, and the wagon beside the train application by application |
//! | balance | `balance` | deceleration of a wagon that runs alone against its forces |
//! | verdict | `verdict`, `book` | one alert a place: the cause that explains all, with probability and runner-up |
//!
//! # Glossary
//! *Second*: one second of samples, summarised. *Application*: from the order to brake to its end. *Creep compliance*:
//! creepage over force, 1/N. *Own past*: what the same wheelset showed before, with the train's common change removed.

mod balance;
mod book;
mod braking;
mod cause;
mod creepage;
mod grip;
mod input;
mod pressure;
mod robust;
mod second;
mod sensors;
mod timing;
mod verdict;
mod watch;
mod within;

pub use book::{Alert, Runner};
pub use cause::{Cause, Grade};
pub use input::{MAX_WHEELSETS, Reading, WagonFile};
pub use watch::TrainWatch;
