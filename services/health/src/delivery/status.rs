//! How delivery is, receiver by receiver.

use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use utoipa::ToSchema;

/// A receiver of alerts.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct TargetView {
    /// Its name; `mqtt` is the broker.
    pub name: String,
    /// Letters that wait for it.
    pub waiting: u64,
    /// Letters it has confirmed, ever.
    pub delivered: u64,
    /// Letters it would not take, ever.
    pub refused: u64,
    /// Letters lost because too many waited, ever.
    pub dropped: u64,
    /// Why it cannot be reached at the moment; `null` if it can.
    pub trouble: Option<String>,
}

/// All receivers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct DeliveryView {
    /// The receivers.
    pub receivers: Vec<TargetView>,
}

/// What the postmen say, shared with the requests.
#[derive(Debug, Clone, Default)]
pub struct Mailbox(Arc<Mutex<BTreeMap<String, TargetView>>>);

impl Mailbox {
    /// Renews what is known of a receiver; true if it is newly in trouble.
    pub fn set(
        &self,
        name: &str,
        [waiting, delivered, refused, dropped]: [u64; 4],
        trouble: Option<String>,
    ) -> bool {
        let mut receivers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newly = trouble.is_some() && receivers.get(name).is_none_or(|before| before.trouble.is_none());
        let view = TargetView { name: name.to_owned(), waiting, delivered, refused, dropped, trouble };
        receivers.insert(name.to_owned(), view);
        newly
    }

    /// All receivers.
    #[must_use]
    pub fn view(&self) -> DeliveryView {
        let receivers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        DeliveryView { receivers: receivers.values().cloned().collect() }
    }
}
