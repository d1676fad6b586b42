//! What the API says of adhesion along the track, as types.

use crate::api::figure::rounded;
use railgrip_indicators::train::track::TrackMap;
use serde::Serialize;
use utoipa::ToSchema;

/// One stretch of track.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapCell {
    /// Where it begins, m.
    pub from_m: f64,
    /// Where it ends, m.
    pub to_m: f64,
    /// Adhesion available: the median.
    pub adhesion: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Probability that it is low or very low.
    pub low_probability: f64,
    /// Wagons that have passed it.
    pub wagons: u32,
    /// Observations of sliding wheelsets behind it.
    pub slides: u32,
    /// Since it was last passed, s.
    pub age_s: f64,
}

/// Adhesion along the track.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapView {
    /// Length of a cell, m.
    pub cell_m: f64,
    /// Passed cells in the order of position.
    pub cells: Vec<MapCell>,
}
impl MapView {
    /// The cells that somebody has passed.
    pub(crate) fn of(map: &TrackMap, cell_m: f64, now_s: f64) -> Self {
        let cells = map.view(now_s).into_iter().map(|cell| MapCell {
            from_m: cell.from_m,
            to_m: cell.from_m + cell_m,
            adhesion: rounded(cell.adhesion[0]),
            low: rounded(cell.adhesion[1]),
            high: rounded(cell.adhesion[2]),
            low_probability: rounded((cell.classes[2] + cell.classes[3]).min(1.0)),
            wagons: cell.wagons as u32,
            slides: cell.slides,
            age_s: rounded(cell.age_s),
        });
        Self { cell_m, cells: cells.collect() }
    }
}
