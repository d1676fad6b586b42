//! `[capability]`: what full braking of the train is, for stopping distances and the adhesion map.

use crate::place::ConfigText;
use railgrip_indicators::train::capability::FullBraking;
use serde::{Deserialize, Serialize};

/// What full braking of this train is, for the braking capability.
#[derive(Debug, Clone, PartialEq)]
pub struct CapabilitySettings {
    /// Deceleration that full braking would give with nominal pads on good rail, m/s².
    pub full_deceleration_m_s2: f64,
    /// From the driver's action until the brakes act in full, as a dead time, s.
    pub response_s: f64,
    /// Speeds for which stopping distances are given, km/h.
    pub speeds_km_h: Vec<f64>,
    /// Length of a cell of the adhesion map, m.
    pub cell_m: f64,
    /// What a cell of the map knows fades to nothing in about this time, s.
    pub map_memory_s: f64,
    /// The map is handed to the history so often, s.
    pub map_save_s: f64,
    /// Most cells that are kept.
    pub most_cells: u32,
}

impl CapabilitySettings {
    /// What full braking of this train is.
    #[must_use]
    pub const fn full_braking(&self) -> FullBraking {
        FullBraking { deceleration_m_s2: self.full_deceleration_m_s2, response_s: self.response_s }
    }
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct CapabilityTable {
    /// Deceleration that full braking would give with nominal pads on good rail, m/s².
    full_deceleration_m_s2: f64,
    /// From the driver's action until the brakes act in full, as a dead time, s.
    response_s: f64,
    /// Speeds for which stopping distances are given, km/h.
    speeds_km_h: Vec<f64>,
    /// Length of a cell of the adhesion map, m.
    cell_m: f64,
    /// What a cell of the map knows fades to nothing in about this time, s.
    map_memory_s: f64,
    /// The map is handed to the history so often, s.
    map_save_s: f64,
    /// Most cells that are kept.
    most_cells: u32,
}

impl Default for CapabilityTable {
    fn default() -> Self {
        Self {
            full_deceleration_m_s2: 1.1,
            response_s: 2.0,
            speeds_km_h: vec![40.0, 80.0, 120.0, 160.0],
            cell_m: 50.0,
            map_memory_s: 1800.0,
            map_save_s: 30.0,
            most_cells: 4000,
        }
    }
}

impl CapabilityTable {
    pub(crate) fn check(self, at: &ConfigText<'_>) -> CapabilitySettings {
        let key = "capability.speeds_km_h";
        if !(1..=20).contains(&self.speeds_km_h.len()) {
            at.note(at.refuse(key, format!("{} speeds", self.speeds_km_h.len()), "1 to 20 speeds"));
        }
        for speed in &self.speeds_km_h {
            at.number(key, *speed, 1.0..=500.0);
        }
        at.number("capability.most_cells", f64::from(self.most_cells), 10.0..=100_000.0);
        CapabilitySettings {
            full_deceleration_m_s2: at.number(
                "capability.full_deceleration_m_s2",
                self.full_deceleration_m_s2,
                0.1..=5.0,
            ),
            response_s: at.number("capability.response_s", self.response_s, 0.0..=60.0),
            speeds_km_h: self.speeds_km_h,
            cell_m: at.number("capability.cell_m", self.cell_m, 5.0..=1000.0),
            map_memory_s: at.number("capability.map_memory_s", self.map_memory_s, 10.0..=1e7),
            map_save_s: at.number("capability.map_save_s", self.map_save_s, 0.5..=3600.0),
            most_cells: self.most_cells,
        }
    }
}
