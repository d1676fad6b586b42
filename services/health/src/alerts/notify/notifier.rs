//! A way to a receiver, and how an attempt ends.

use crate::alerts::nflog::Queued;
use std::time::Duration;

/// Longest wait for a receiver's answer.
pub(super) const ANSWER: Duration = Duration::from_secs(10);

/// How an attempt ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The receiver has confirmed it.
    Confirmed,
    /// It could not be reached, or is not well; later.
    Later(String),
    /// It says that it will not take this notification.
    Refused(String),
}

/// A way to a receiver.
pub trait Notifier {
    /// Tries once.
    fn notify(&mut self, notification: &Queued) -> Outcome;
}
