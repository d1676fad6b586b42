//! What a line of a live source may say.

use railgrip_recording::Mapping;
use railgrip_settings::VehicleNumber;

/// What a line may say: the wagons of the train, and what the source calls the columns of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layout {
    /// Wheelsets of each wagon.
    pub wheelsets: Vec<usize>,
    /// Vehicle number of each wagon, where it has one.
    pub numbers: Vec<Option<VehicleNumber>>,
    /// What the columns are called.
    pub mapping: Mapping,
}
