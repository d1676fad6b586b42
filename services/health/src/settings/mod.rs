//! The thresholds and receivers of the config file, shown, and changed by role admin.
//!
//! A change goes through the whole check that the file goes through at a start; what it would refuse is not written. The file
//! keeps its comments and its order, gains one comment that says who changed what, when and why, and is replaced at once, so
//! that no reader sees half of it. It takes effect when the processes start again, or read their config again (SIGHUP).

mod asked;
mod change;
mod file;
pub mod model;
pub mod receiver_routes;
mod receivers;
pub mod routes;

pub use change::change;
pub use file::ChangeError;
pub use receivers::change_receiver;
