//! Kills ingest at work.

use std::time::Duration;

use crate::process_figures as figures;

/// Kills the ingest of a running train so often, spread over the time in which samples are sent; the last samples find one at work,
/// so that what was lost before is known.
pub(super) fn ingest(up: u32, times: u32, lasts: Duration) {
    for _ in 0..times {
        std::thread::sleep(lasts.mul_f64(0.8) / times);
        for pid in figures::children(up, "ingest") {
            if let Some(pid) = i32::try_from(pid).ok().and_then(rustix::process::Pid::from_raw) {
                let _ = rustix::process::kill_process(pid, rustix::process::Signal::KILL);
            }
        }
    }
}
