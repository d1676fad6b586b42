//! The two ways in which the question is usually answered, to compare with: mere rankings.

use std::path::Path;

use railgrip_diagnosis::data::load;
use railgrip_diagnosis::decide::baselines;
use serde::{Deserialize, Serialize};

/// Ids by each baseline, best first; empty where the case cannot be loaded.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Rankings {
    /// By the gap that each effect at its default strength leaves after calibration of the nuisances alone.
    pub rmse: Vec<String>,
    /// By correlation of the calibrated model's residuals with one-shot sensitivities.
    pub correlation: Vec<String>,
}

impl Rankings {
    /// Ranks the library for a case.
    pub(super) fn of(folder: &Path) -> Self {
        let Ok(vehicle) = railgrip_settings::vehicle::load(&folder.join("vehicle.toml")) else {
            return Self::default();
        };
        let Ok(case) = load::load(folder, vehicle) else { return Self::default() };
        let owned = |ids: Vec<&'static str>| ids.into_iter().map(str::to_owned).collect();
        Self {
            rmse: owned(baselines::calibrated_rmse_ranking(&case)),
            correlation: owned(baselines::correlation_ranking(&case)),
        }
    }
}
