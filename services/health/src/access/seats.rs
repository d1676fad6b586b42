//! How many connections there may be at a time: of all clients, and of each.
//!
//! Clients on this machine have as many seats again to themselves, so that `railgrip status`, a probe or a proxy still
//! gets through when the network has taken all others.

use crate::access::limit::Client;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// All seats. Clones share.
#[derive(Clone)]
pub(super) struct Seats {
    taken: Arc<Mutex<Taken>>,
    all: usize,
    per_client: usize,
}

#[derive(Default)]
struct Taken {
    near: usize,
    far: usize,
    clients: HashMap<Client, usize>,
}

/// A taken seat, free again when dropped.
pub(super) struct Seat {
    seats: Seats,
    near: bool,
    client: Option<Client>,
}

impl Seats {
    pub(super) fn new(all: usize, per_client: usize) -> Self {
        Self { taken: Arc::default(), all, per_client }
    }

    /// A seat, `near` for somebody on this machine; `client` where the limit of one client holds.
    pub(super) fn take(&self, near: bool, client: Option<Client>) -> Option<Seat> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let group = if near { taken.near } else { taken.far };
        if group >= self.all {
            return None;
        }
        if let Some(client) = client {
            let count = taken.clients.entry(client).or_default();
            if *count >= self.per_client {
                return None;
            }
            *count += 1;
        }
        *taken.group(near) += 1;
        Some(Seat { seats: self.clone(), near, client })
    }
}

impl Taken {
    fn group(&mut self, near: bool) -> &mut usize {
        if near { &mut self.near } else { &mut self.far }
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut taken = self.seats.taken.lock().unwrap_or_else(PoisonError::into_inner);
        *taken.group(self.near) -= 1;
        if let Some(client) = self.client
            && let Some(count) = taken.clients.get_mut(&client)
        {
            *count -= 1;
            if *count == 0 {
                taken.clients.remove(&client);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seats_are_counted_and_given_back() {
        let seats = Seats::new(3, 2);
        let (one, two) = (Some(Client::V4(1)), Some(Client::V4(2)));
        let mut held = vec![seats.take(false, one).expect("1"), seats.take(false, one).expect("2")];
        assert!(seats.take(false, one).is_none(), "two a client");
        held.push(seats.take(false, two).expect("3"));
        assert!(seats.take(false, None).is_none(), "three in all");
        assert!(seats.take(true, None).is_some(), "this machine has its own");
        held.clear();
        assert!(seats.take(false, one).is_some());
        assert!(seats.taken.lock().expect("lock").clients.is_empty());
    }
}
