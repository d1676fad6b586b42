//! Work on several threads, and how far it is.

use std::{
    sync::atomic::{AtomicUsize, Ordering},
    thread,
};

use indicatif::{ProgressBar, ProgressStyle};

/// Runs `work` on every index on so many threads while `goes_on`, results in order.
pub(crate) fn parallel<T: Send>(
    threads: usize,
    count: usize,
    goes_on: impl Fn() -> bool + Sync,
    work: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let take = || {
        let mut done = Vec::new();
        loop {
            if !goes_on() {
                return done;
            }
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return done;
            }
            done.push((index, work(index)));
        }
    };
    let mut all: Vec<(usize, T)> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.min(count)).map(|_| scope.spawn(take)).collect();
        workers.into_iter().filter_map(|worker| worker.join().ok()).flatten().collect()
    });
    all.sort_by_key(|(index, _)| *index);
    all.into_iter().map(|(_, result)| result).collect()
}

/// How far so many pieces of work are: a bar where somebody looks on, else a line a tenth.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    what: &'static str,
    count: usize,
}

impl Progress {
    /// One piece is done.
    pub(crate) fn inc(&self) {
        self.bar.inc(1);
        let done = self.bar.position() as usize;
        let tenths = |done: usize| 10 * done / self.count.max(1);
        if self.bar.is_hidden() && tenths(done) > tenths(done.saturating_sub(1)) {
            let minutes = self.bar.elapsed().as_secs_f64() / 60.0;
            crate::output::note(&format!("{}: {done} of {} after {minutes:.1} min", self.what, self.count));
        }
    }

    /// All is done; the bar goes.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Progress of so many pieces of work.
pub(crate) fn progress(what: &'static str, count: usize) -> Progress {
    let style = ProgressStyle::with_template("{msg:14} {bar:40} {pos}/{len}  {elapsed} + {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(count as u64).with_style(style).with_message(what);
    Progress { bar, what, count }
}

/// As many threads as were asked for, else one a core.
pub(crate) fn threads(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from)).max(1)
}
