//! How a service and whoever runs it understand each other, without signals or systemd in the service.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Thread;

use railgrip_settings::TrainSettings;

/// Shared by a running service and its runner; clones speak about the same run.
///
/// The runner asks to stop; the service says when it is ready and beats while it makes progress. A runner under
/// systemd turns the beats into watchdog messages, so that a wedged loop is restarted.
#[derive(Debug, Clone, Default)]
pub struct Lifecycle {
    stop: Arc<AtomicBool>,
    ready: Arc<AtomicBool>,
    beats: Arc<AtomicU64>,
    offered: Arc<Mutex<Option<Box<TrainSettings>>>>,
    waiting: Arc<Mutex<Option<Thread>>>,
}

impl Lifecycle {
    /// A run that nobody has asked to stop.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the service to end in order.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Release);
    }

    /// True once the service shall end; loops look at it at least every 100 ms.
    #[must_use]
    pub fn should_stop(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// The flag behind [`Lifecycle::stop`], for a signal handler.
    #[must_use]
    pub fn stop_flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// The service has its ports (and its socket) and starts to work.
    pub fn ready(&self) {
        self.ready.store(true, Ordering::Release);
        if let Some(thread) = self.waiting.lock().unwrap_or_else(PoisonError::into_inner).take() {
            thread.unpark();
        }
    }

    /// Has [`Lifecycle::ready`] wake a parked thread, once.
    pub fn wake_when_ready(&self, thread: Thread) {
        *self.waiting.lock().unwrap_or_else(PoisonError::into_inner) = Some(thread);
    }

    /// True once the service works.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.ready.load(Ordering::Acquire)
    }

    /// The service went through its loop once more.
    pub fn beat(&self) {
        self.beats.fetch_add(1, Ordering::Relaxed);
    }

    /// Hands the service new settings. They differ only in what it can take over while it runs.
    pub fn offer(&self, settings: TrainSettings) {
        *self.offered.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(settings));
    }

    /// New settings to be taken over, once; of several the latest.
    #[must_use]
    pub fn offered(&self) -> Option<Box<TrainSettings>> {
        self.offered.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Beats so far.
    #[must_use]
    pub fn beats(&self) -> u64 {
        self.beats.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_one_run() {
        let runner = Lifecycle::new();
        let service = runner.clone();
        service.ready();
        service.beat();
        assert!(runner.is_ready() && runner.beats() == 1 && !service.should_stop());
        runner.stop();
        assert!(service.should_stop() && service.offered().is_none());
    }
}
