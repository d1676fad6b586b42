//! The thresholds of the config file, shown, and changed by role admin.
//!
//! A change goes through the whole check that the file goes through at a start; what it would refuse is not written. The file
//! keeps its comments and its order, gains one comment that says who changed what, when and why, and is replaced at once, so
//! that no reader sees half of it. It takes effect when the processes start again: estimators judge by what they started with.

mod change;
pub mod model;
pub mod routes;

pub use change::{ChangeError, change};
