//! Who runs where in the train, and under which numbers the history keeps them.

use railgrip_history::{FIRST_VEHICLE, HistoryError, Reader, Store, Vehicle};
use railgrip_settings::{TrainSettings, VehicleNumber};

/// Never kept and never found.
const NOWHERE: u32 = u32::MAX;

/// A wagon of the train and the number of its history.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Entry {
    place: u32,
    id: u32,
}

/// The wagons of the train with the numbers of their histories.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Consist {
    entries: Vec<Entry>,
    vehicles: Vec<Vehicle>,
    /// When the train was started, Unix s: what was kept before of a wagon without a number may be of another one.
    started_s: Option<i64>,
}

/// When the train was started, Unix s, where that is known.
#[must_use]
pub fn started_s(settings: &TrainSettings) -> Option<i64> {
    let nanoseconds: i64 = settings.instance.session().split(' ').next()?.parse().ok()?;
    Some(nanoseconds.div_euclid(1_000_000_000))
}

/// The vehicle numbers of a train by place, where it has them.
#[must_use]
pub fn numbers(settings: &TrainSettings) -> Vec<Option<VehicleNumber>> {
    settings.wagons.iter().map(|wagon| wagon.vehicle_number.clone()).collect()
}

impl Consist {
    /// As the database knows it; a vehicle that it does not know yet has no history.
    ///
    /// # Errors
    /// The database refuses.
    pub fn read(reader: &Reader, numbers: &[Option<VehicleNumber>]) -> Result<Self, HistoryError> {
        let vehicles = reader.vehicles()?;
        let id = |number: &VehicleNumber| {
            let known = vehicles.iter().find(|vehicle| vehicle.key == number.key());
            known.map_or(NOWHERE, |vehicle| vehicle.id)
        };
        let entries =
            (1..).zip(numbers).map(|(place, number)| Entry { place, id: number.as_ref().map_or(place, id) });
        Ok(Self { entries: entries.collect(), vehicles, started_s: None })
    }

    /// The same, and vehicles that are new get a history.
    ///
    /// # Errors
    /// The database refuses.
    pub fn enter(store: &Store, numbers: &[Option<VehicleNumber>]) -> Result<Self, HistoryError> {
        let mut entries = Vec::new();
        for (place, number) in (1..).zip(numbers) {
            let id = match number {
                None => place,
                Some(number) => store.vehicle(number.key(), number.written())?.unwrap_or_else(|| {
                    tracing::error!(
                        vehicle = number.written(),
                        "too many vehicles: no history is kept of it"
                    );
                    NOWHERE
                }),
            };
            entries.push(Entry { place, id });
        }
        Ok(Self { entries, vehicles: Vec::new(), started_s: None })
    }

    /// Under which the history of the wagon at a place is kept.
    #[must_use]
    pub fn id(&self, place: u32) -> u32 {
        self.entries.iter().find(|entry| entry.place == place).map_or(place, |entry| entry.id)
    }

    /// Where a wagon runs now; `None` for a vehicle that is not in the train. A place beyond the train keeps its number.
    #[must_use]
    pub fn place(&self, id: u32) -> Option<u32> {
        let here = self.entries.iter().find(|entry| entry.id == id).map(|entry| entry.place);
        let bare = id < FIRST_VEHICLE && self.entries.iter().all(|entry| entry.place != id);
        here.or(bare.then_some(id))
    }

    /// The same of a train that was started then, Unix s.
    #[must_use]
    pub fn started(self, started_s: Option<i64>) -> Self {
        Self { started_s, ..self }
    }

    /// From when on what is kept under a number is of the wagon that runs here now, Unix s: a wagon without a vehicle number is
    /// known since the train was started.
    #[must_use]
    pub fn known_from(&self, id: u32) -> i64 {
        self.started_s.filter(|_| id < FIRST_VEHICLE).unwrap_or(i64::MIN)
    }

    /// Where a wagon runs now of which something was kept at that instant, Unix s; likewise.
    #[must_use]
    pub fn place_then(&self, id: u32, unix_s: i64) -> Option<u32> {
        self.place(id).filter(|_| unix_s >= self.known_from(id))
    }

    /// The number of a vehicle as it is written.
    #[must_use]
    pub fn vehicle(&self, id: u32) -> Option<&str> {
        self.vehicles.iter().find(|vehicle| vehicle.id == id).map(|vehicle| vehicle.number.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_history::Keep;

    #[test]
    fn a_history_follows_its_vehicle_through_the_train() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("history.db");
        let mut store = Store::open(&path, &[("v", Keep::Mean)]).expect("store");
        let number = |text: &str| VehicleNumber::new(text);
        let before = [number("51 80 1"), None, number("51 80 2")];
        let first = Consist::enter(&store, &before).expect("entered");
        assert_eq!([1, 2, 3].map(|place| first.id(place)), [256, 2, 257]);
        for place in 1..=3 {
            store.push(first.id(place), 1_700_000_000, &[place as f32]).expect("pushed");
        }
        store.flush(true).expect("flushed");
        // The order has changed, the middle wagon is gone, another one has come.
        let after = [number("5180-2"), number("51 80 3"), number("51801")];
        assert_eq!(Consist::enter(&store, &after).expect("entered").id(2), 258);
        let reader = Reader::open(&path).expect("reader");
        let now = Consist::read(&reader, &after).expect("read");
        let seen = |place: u32| {
            let points = reader.query(now.id(place), &["v"], 1_700_000_000, 1_700_000_001, 1).expect("query");
            points.first().map(|point| point.cells[0].mean)
        };
        assert_eq!([1, 2, 3].map(seen), [Some(3.0), None, Some(1.0)]);
        assert_eq!((now.place(257), now.place(2), now.vehicle(256)), (Some(1), None, Some("51 80 1")));
        assert_eq!(Consist::default().place(300), None);
    }
}
