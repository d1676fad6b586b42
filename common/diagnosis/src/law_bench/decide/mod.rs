//! Which effect it is, if any: thresholds in [`criteria`], the effects in [`selection`], what speaks for and against them in
//! [`evidence`], the table of rules in [`verdict`].

pub mod chance;
pub mod confidence;
pub mod criteria;
pub mod evidence;
pub mod selection;
pub mod verdict;
