//! Which figures of a wagon are remembered, and under which names: the table of indicators, then the signals.

use railgrip_history::{FormerName, Keep};
use railgrip_indicators::signals::{OF_WAGON, OF_WHEELSET, Signal};
use railgrip_indicators::{INDICATORS, IndicatorSpec, Stored, Table};
use railgrip_messages::{Health, Indicator, WheelsetHealth};

/// One remembered figure, up to three columns of the database: the value, and the ends of its interval as `.low` and
/// `.high`.
#[derive(Debug, Clone)]
pub struct Column {
    /// Its name as in the live API, for example `brake_friction` or `wheelset_1.slides`.
    pub name: String,
    /// Its unit; empty for a ratio, a number or a code.
    pub unit: &'static str,
    /// Whether an interval is remembered with it.
    pub interval: bool,
    /// The indicator that it is; `None` for a signal.
    pub spec: Option<&'static IndicatorSpec>,
    /// The wheelset that it is of, index, 0 leading; `None` for the wagon.
    pub wheelset: Option<usize>,
    /// Names under which older versions kept it.
    formerly: Vec<String>,
    read: Read,
}

#[derive(Debug, Clone, Copy)]
enum Read {
    /// The indicator in this place of the message.
    Indicator(usize),
    Wagon(fn(&Health) -> [f64; 3]),
    Wheelset(fn(&WheelsetHealth) -> [f64; 3]),
}

impl Column {
    /// Value, low and high; NaN where nothing is known.
    #[must_use]
    pub fn read(&self, health: &Health) -> [f64; 3] {
        match (self.wheelset, self.read) {
            (Some(index), _) if index >= health.wheelset_count() => [f64::NAN; 3],
            (None, Read::Indicator(place)) => judged(&health.indicator[place]),
            (Some(index), Read::Indicator(place)) => judged(&health.wheelset[index].indicator[place]),
            (_, Read::Wagon(read)) => read(health),
            (index, Read::Wheelset(read)) => read(&health.wheelset[index.unwrap_or(0)]),
        }
    }

    /// The columns of the database, in the order of [`Self::read`].
    #[must_use]
    pub fn stored(&self) -> Vec<(String, Keep)> {
        let value = (self.name.clone(), Keep::Extremes);
        let ends = ENDS.map(|end| (format!("{}{end}", self.name), Keep::Mean));
        std::iter::once(value).chain(ends.into_iter().filter(|_| self.interval)).collect()
    }

    fn of_spec(spec: &'static IndicatorSpec, place: usize, wheelset: Option<usize>) -> Option<Self> {
        (spec.stored != Stored::Nothing).then(|| Self {
            name: placed(&spec.field(), wheelset),
            unit: spec.unit.symbol(),
            interval: spec.stored == Stored::Interval,
            spec: Some(spec),
            wheelset,
            formerly: spec.formerly.iter().map(|name| placed(name, wheelset)).collect(),
            read: Read::Indicator(place),
        })
    }

    fn of_signal<T>(signal: &Signal<T>, wheelset: Option<usize>, read: Read) -> Self {
        Self {
            name: placed(signal.field, wheelset),
            unit: signal.unit,
            interval: signal.interval,
            spec: None,
            wheelset,
            formerly: signal.formerly.iter().map(|name| placed(name, wheelset)).collect(),
            read,
        }
    }
}

/// What the names of the ends of an interval end with.
const ENDS: [&str; 2] = [".low", ".high"];

/// The name of a figure of a wagon or of one of its wheelsets.
fn placed(field: &str, wheelset: Option<usize>) -> String {
    wheelset.map_or_else(|| field.to_owned(), |index| format!("wheelset_{}.{field}", index + 1))
}

fn judged(indicator: &Indicator) -> [f64; 3] {
    if indicator.known == 0 {
        return [f64::NAN; 3];
    }
    [indicator.value, indicator.low, indicator.high]
}

/// Everything that is remembered of wagons with at most so many wheelsets.
#[must_use]
pub fn all(wheelsets: usize) -> Vec<Column> {
    of(INDICATORS, wheelsets)
}

/// The same by another table.
#[must_use]
pub fn of(table: Table, wheelsets: usize) -> Vec<Column> {
    let signals = OF_WAGON.iter().map(|signal| Column::of_signal(signal, None, Read::Wagon(signal.read)));
    let judged = table.of_wagon().enumerate();
    let judged = judged.filter_map(|(place, spec)| Column::of_spec(spec, place, None));
    let of_wheelset = |index: usize| {
        let judged = table.of_wheelset().enumerate();
        let judged = judged.filter_map(move |(place, spec)| Column::of_spec(spec, place, Some(index)));
        let signals = OF_WHEELSET.iter();
        judged.chain(
            signals.map(move |signal| Column::of_signal(signal, Some(index), Read::Wheelset(signal.read))),
        )
    };
    signals.chain(judged).chain((0..wheelsets).flat_map(of_wheelset)).collect()
}

/// All values of a wagon in the order of the columns of the database; NaN where nothing is known.
#[must_use]
pub fn values(columns: &[Column], health: &Health) -> Vec<f32> {
    let mut values = Vec::with_capacity(columns.len() * 3);
    for column in columns {
        let read = column.read(health);
        let parts = if column.interval { 3 } else { 1 };
        values.extend(read[..parts].iter().map(|value| *value as f32));
    }
    values
}

/// Names of the columns of the database, in the order of [`values`].
#[must_use]
pub fn stored(columns: &[Column]) -> Vec<(String, Keep)> {
    columns.iter().flat_map(Column::stored).collect()
}

/// Columns of databases that older versions wrote, with their names of today.
#[must_use]
pub fn former(columns: &[Column]) -> Vec<FormerName> {
    let of_column = |column: &Column| {
        let ends: Vec<&str> = if column.interval { vec!["", ENDS[0], ENDS[1]] } else { vec![""] };
        let name = |then: &str, end: &str| FormerName {
            then: format!("{then}{end}"),
            now: format!("{}{end}", column.name),
        };
        let all = column.formerly.iter().flat_map(|then| ends.iter().map(|end| name(then, end)));
        all.collect::<Vec<FormerName>>()
    };
    columns.iter().flat_map(of_column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_every_name_has_a_value() {
        let columns = all(4);
        let names: Vec<String> = stored(&columns).into_iter().map(|(name, _)| name).collect();
        let unique: std::collections::BTreeSet<&String> = names.iter().collect();
        assert_eq!(unique.len(), names.len());
        let health = Health { wheelsets: 2, v_m_s: 20.0, ..Health::default() };
        let values = values(&columns, &health);
        assert_eq!(values.len(), names.len());
        let value = |name: &str| values[names.iter().position(|other| other == name).unwrap()];
        assert_eq!(value("v_m_s"), 20.0);
        assert_eq!(value("wheelset_2.slide_energy_j"), 0.0);
        assert!(value("wheelset_3.slide_energy_j").is_nan() && value("brake_friction").is_nan());
    }
}
