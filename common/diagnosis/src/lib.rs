//! railgrip diagnosis.

pub mod html;
pub mod report;
