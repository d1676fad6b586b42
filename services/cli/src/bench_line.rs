//! One line of the benchmark: what was timed, and beside what.

use std::time::Instant;

/// Time spent on each line, s.
const SECONDS_A_LINE: f64 = 0.4;

/// One line of the table.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Line {
    pub what: &'static str,
    pub nanoseconds: f64,
    pub reference: &'static str,
    pub reference_nanoseconds: f64,
    pub ratio: f64,
}

/// Nanoseconds of one call: the best of several rounds, which is what the machine can do undisturbed.
pub(crate) fn time(mut call: impl FnMut()) -> f64 {
    let started = Instant::now();
    let (mut best, mut batch) = (f64::INFINITY, 64_u32);
    while started.elapsed().as_secs_f64() < SECONDS_A_LINE {
        let round = Instant::now();
        (0..batch).for_each(|_| call());
        let taken = round.elapsed().as_secs_f64();
        best = best.min(taken / f64::from(batch));
        if taken < 1e-3 {
            batch *= 2;
        }
    }
    best * 1e9
}

/// A line of `nanoseconds` beside those of a reference.
pub(crate) fn line(
    what: &'static str,
    nanoseconds: f64,
    reference: &'static str,
    reference_nanoseconds: f64,
) -> Line {
    Line { what, nanoseconds, reference, reference_nanoseconds, ratio: nanoseconds / reference_nanoseconds }
}
