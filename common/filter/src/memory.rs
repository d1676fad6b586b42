//! What the estimator of a wagon remembers beside the filter's belief.

use crate::hygiene::{HeldInput, SensorWatch, TimeBase};
use crate::output::MAX_OUTPUTS;
use railgrip_vehicle::MAX_WHEELSETS;
use serde::{Deserialize, Serialize};

/// What the estimator remembers beside the filter's belief.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    pub(crate) time: TimeBase,
    pub(crate) forces: [HeldInput; MAX_WHEELSETS],
    pub(crate) torques: [HeldInput; MAX_WHEELSETS],
    pub(crate) grade: HeldInput,
    pub(crate) sanding: HeldInput,
    pub(crate) position: HeldInput,
    pub(crate) watches: [SensorWatch; MAX_OUTPUTS],
    pub(crate) running_s: f64,
    pub(crate) started: bool,
    pub(crate) resumed: bool,
    /// Measurements that were believed against the filter, fading.
    pub(crate) quarrels: f64,
    /// Time left in which estimates are called diverged, s.
    pub(crate) diverged_s: f64,
}
