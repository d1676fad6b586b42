//! Which vehicle runs at which place: wherever an alert names a wagon, it names the vehicle, too.

use super::model::{Alert, AlertPlace};

/// The vehicle numbers of a train by place, as they are written; nothing for a wagon without one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Vehicles(Vec<Option<String>>);

impl Vehicles {
    /// Those of a train, wagon 1 first.
    #[must_use]
    pub fn new(numbers: Vec<Option<String>>) -> Self {
        Self(numbers)
    }

    /// The number of the vehicle at a place.
    #[must_use]
    pub fn at(&self, wagon: u32) -> Option<String> {
        self.0.get((wagon as usize).checked_sub(1)?)?.clone()
    }

    /// Says of a place which vehicle it is on.
    pub(super) fn name_place(&self, place: &mut AlertPlace) {
        place.vehicle_number = self.at(place.wagon);
    }

    /// Says of an alert which vehicles it is about. One whose wagons have all left the train keeps what it knows of them.
    pub(super) fn name(&self, alert: &mut Alert) {
        if alert.wagon > 0 && alert.wagons.is_empty() {
            return;
        }
        alert.vehicle_number = self.at(alert.wagon);
        alert.vehicle_numbers = alert.wagons.iter().map(|wagon| self.at(*wagon)).collect();
        alert.places.iter_mut().for_each(|place| self.name_place(place));
    }
}
