//! The report for people: one self-contained HTML file.

pub mod detail;
