//! The sim-to-real gap: where it lies, which unmodelled effect causes it, and how far it shrinks with the effect added.
//!
//! * [`wagon::diagnose`] answers for recordings of a wagon, [`bench::diagnose`] for a law measured alone.
//! * [`kernel`] simulates, [`metric`] is the gap in one number, [`innovations`] the whitened objective that selects effects,
//!   [`polish`] the fit on the metric's own windows.
//! * [`library`] lists the candidates, [`search`] fits them, [`engine`] selects, [`flexible`] is what could be explained at
//!   all, [`chance`] what the best of a library gains by luck, [`verdict`] weighs the three.
//! * [`report`] is the form of `report.json`, [`html`] shows it, [`baselines`] are two simpler ways to compare with.
//!
//! Everything is deterministic: results are collected in the order of the library whatever the threads, random numbers
//! come from the seed, and sums run in a fixed order.

pub mod baselines;
pub mod bench;
pub mod case;
pub mod chance;
mod details;
pub mod engine;
pub mod flexible;
pub mod html;
pub mod innovations;
pub mod kernel;
pub mod library;
pub mod load;
pub mod metric;
pub mod objective;
pub mod parameters;
pub mod polish;
pub mod predictions;
pub mod regime;
pub mod report;
pub mod search;
pub mod solver;
pub mod units;
pub mod verdict;
pub mod wagon;
pub mod wander;
