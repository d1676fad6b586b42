//! How the receivers are: what they have confirmed, what waits for them.

use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use utoipa::ToSchema;

/// A receiver of alerts.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct ReceiverView {
    /// Its name; `mqtt` is the broker.
    pub name: String,
    /// Notifications that wait for it.
    pub waiting: u64,
    /// Notifications it has confirmed, ever.
    pub delivered: u64,
    /// Notifications it would not take, ever.
    pub refused: u64,
    /// Notifications lost because too many waited, ever.
    pub dropped: u64,
    /// Why it cannot be reached at the moment; `null` if it can.
    pub trouble: Option<String>,
}

/// All receivers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct ReceiverList {
    /// The receivers.
    pub receivers: Vec<ReceiverView>,
}

/// What the threads of the receivers say, shared with the requests.
#[derive(Debug, Clone, Default)]
pub struct ReceiverStates(Arc<Mutex<BTreeMap<String, ReceiverView>>>);

impl ReceiverStates {
    /// Renews what is known of a receiver; true if it is newly in trouble.
    pub fn set(
        &self,
        name: &str,
        [waiting, delivered, refused, dropped]: [u64; 4],
        trouble: Option<String>,
    ) -> bool {
        let mut receivers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newly = trouble.is_some() && receivers.get(name).is_none_or(|before| before.trouble.is_none());
        let view = ReceiverView { name: name.to_owned(), waiting, delivered, refused, dropped, trouble };
        receivers.insert(name.to_owned(), view);
        newly
    }

    /// Forgets all receivers but those that `is_one` knows.
    pub fn keep(&self, is_one: impl Fn(&str) -> bool) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).retain(|name, _| is_one(name));
    }

    /// All receivers.
    #[must_use]
    pub fn view(&self) -> ReceiverList {
        let receivers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        ReceiverList { receivers: receivers.values().cloned().collect() }
    }
}
