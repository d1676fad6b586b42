//! Decisions: which effects are selected, what is beyond chance, what the verdict is and how sure.

pub mod baselines;
pub mod confidence;
pub mod selection;
pub mod significance;
pub mod verdict;
