//! How often one client may ask: a bucket of tokens a client, refilled at a steady rate.
//!
//! A hundred lines of our own instead of a crate: the ready ones bring a concurrent map, a clock and a header parser for
//! addresses that a client can invent, and none bounds the number of clients that it remembers.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Clients that are remembered; beyond that strangers share one bucket.
const MAX_CLIENTS: usize = 4096;

/// What counts as one client: an IPv4 address, or the network that one IPv6 customer gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Client {
    V4(u32),
    V6(u64),
    /// Whoever comes while too many are remembered.
    Crowd,
}

impl Client {
    pub(super) fn of(address: IpAddr) -> Self {
        match address.to_canonical() {
            IpAddr::V4(address) => Self::V4(address.to_bits()),
            IpAddr::V6(address) => Self::V6((address.to_bits() >> 64) as u64),
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Bucket {
    tokens: f64,
    at: Instant,
}

/// The buckets of all clients.
pub(super) struct Limiter {
    rate_per_s: f64,
    burst: f64,
    buckets: Mutex<HashMap<Client, Bucket>>,
}

impl Limiter {
    /// `rate_per_s` 0 sets no limit.
    pub(super) fn new(rate_per_s: f64, burst: f64) -> Self {
        Self { rate_per_s, burst, buckets: Mutex::default() }
    }

    /// Takes `cost` from the bucket of a client, or says how long it has to wait.
    pub(super) fn take(&self, client: Client, cost: f64, now: Instant) -> Result<(), Duration> {
        if self.rate_per_s == 0.0 {
            return Ok(());
        }
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        let full = |bucket: &Bucket| self.filled(bucket, now) >= self.burst;
        let client = if buckets.len() < MAX_CLIENTS || buckets.contains_key(&client) {
            client
        } else {
            buckets.retain(|_, bucket| !full(bucket));
            if buckets.len() < MAX_CLIENTS { client } else { Client::Crowd }
        };
        let bucket = buckets.entry(client).or_insert(Bucket { tokens: self.burst, at: now });
        let tokens = self.filled(bucket, now);
        let cost = cost.min(self.burst);
        *bucket = Bucket { tokens: if tokens >= cost { tokens - cost } else { tokens }, at: now };
        if tokens >= cost {
            return Ok(());
        }
        Err(Duration::from_secs_f64((cost - tokens) / self.rate_per_s))
    }

    /// Takes `cost` from the bucket of a client even if it does not hold so much: it has to be paid back before the next request.
    pub(super) fn fine(&self, client: Client, cost: f64, now: Instant) {
        if self.rate_per_s == 0.0 {
            return;
        }
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bucket) = buckets.get_mut(&client) {
            let tokens = (self.filled(bucket, now) - cost).max(-self.burst);
            *bucket = Bucket { tokens, at: now };
        }
    }

    fn filled(&self, bucket: &Bucket, now: Instant) -> f64 {
        let passed_s = now.saturating_duration_since(bucket.at).as_secs_f64();
        (bucket.tokens + passed_s * self.rate_per_s).min(self.burst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv6Addr;

    #[test]
    fn a_client_gets_its_burst_then_its_rate_and_nobody_elses() {
        let limiter = Limiter::new(10.0, 5.0);
        let start = Instant::now();
        let (one, other) = (Client::V4(1), Client::V4(2));
        assert_eq!((0..20).filter(|_| limiter.take(one, 1.0, start).is_ok()).count(), 5);
        let wait = limiter.take(one, 1.0, start).expect_err("empty");
        assert!((wait.as_secs_f64() - 0.1).abs() < 1e-9, "{wait:?}");
        assert!(limiter.take(other, 1.0, start).is_ok());
        let later = start + Duration::from_millis(350);
        assert_eq!((0..20).filter(|_| limiter.take(one, 1.0, later).is_ok()).count(), 3);
        assert!(Limiter::new(0.0, 1.0).take(one, 1e9, start).is_ok());
    }

    #[test]
    fn a_fine_is_paid_back_before_anything_else() {
        let limiter = Limiter::new(10.0, 5.0);
        let (one, start) = (Client::V4(1), Instant::now());
        (0..5).for_each(|_| assert!(limiter.take(one, 1.0, start).is_ok()));
        limiter.fine(one, 4.0, start);
        let wait = limiter.take(one, 1.0, start).expect_err("four are owed");
        assert!((wait.as_secs_f64() - 0.5).abs() < 1e-9, "{wait:?}");
        (0..100).for_each(|_| limiter.fine(one, 4.0, start));
        assert!(limiter.take(one, 1.0, start + Duration::from_secs(1)).is_ok(), "a debt is bounded");
    }

    #[test]
    fn memory_is_bounded_and_a_crowd_shares() {
        let limiter = Limiter::new(1.0, 2.0);
        let start = Instant::now();
        let taken = (0..20_000).filter(|n| limiter.take(Client::V6(*n), 1.0, start).is_ok()).count();
        let remembered = limiter.buckets.lock().expect("lock").len();
        println!("{taken} of 20000 strangers served, {remembered} remembered");
        assert!(remembered <= MAX_CLIENTS + 1 && taken <= MAX_CLIENTS + 2);
        assert!(limiter.take(Client::V6(99_999), 1.0, start + Duration::from_secs(5)).is_ok());
        assert!(limiter.buckets.lock().expect("lock").len() <= 2);
    }

    #[test]
    fn one_network_is_one_client() {
        let of = |text: &str| Client::of(text.parse().expect("address"));
        assert_eq!(of("2001:db8:0:1::1"), of("2001:db8:0:1:ffff::2"));
        assert_ne!(of("2001:db8:0:1::1"), of("2001:db8:0:2::1"));
        assert_eq!(Client::of(IpAddr::V6(Ipv6Addr::LOCALHOST)), Client::V6(0));
        assert_eq!(of("::ffff:192.0.2.1"), of("192.0.2.1"));
    }
}
