//! State of an estimator at rest, for a restart.

use crate::memory::Memory;
use crate::models::FilterState;
use serde::{Deserialize, Serialize};

/// Layout of the snapshot.
pub(crate) const SCHEMA: u32 = 2;

/// State of an estimator; plain data for any serde format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimatorSnapshot {
    /// Layout of the snapshot.
    pub schema: u32,
    /// Name of the filter.
    pub filter: String,
    /// The vehicle in short; a snapshot of another vehicle is refused.
    pub vehicle: String,
    /// Belief of the filter.
    pub state: FilterState,
    /// Hidden states of the model's effects.
    pub hidden: Vec<f64>,
    /// Last estimate of the speed, m/s.
    pub v_m_s: f64,
    /// What the estimator remembers beside the belief.
    pub memory: Memory,
}
