//! Which figures of a wagon are remembered, and under which names.

use railgrip_history::Keep;
use railgrip_messages::{Health, Indicator};

/// One remembered figure, up to three columns of the database: the value, and the ends of its interval as `.low` and
/// `.high`.
#[derive(Debug, Clone)]
pub struct Column {
    /// Its name, for example `brake_friction` or `wheelset_1.slides`.
    pub name: String,
    /// Its unit; empty for a ratio, a number or a code.
    pub unit: &'static str,
    /// Whether an interval is remembered with it.
    pub interval: bool,
    read: Read,
}

#[derive(Debug, Clone, Copy)]
enum Read {
    Wagon(fn(&Health) -> [f64; 3]),
    Wheelset(usize, fn(&Health, usize) -> [f64; 3]),
}

impl Column {
    /// Value, low and high; NaN where nothing is known.
    #[must_use]
    pub fn read(&self, health: &Health) -> [f64; 3] {
        match self.read {
            Read::Wagon(read) => read(health),
            Read::Wheelset(index, read) if index < health.wheelset_count() => read(health, index),
            Read::Wheelset(..) => [f64::NAN; 3],
        }
    }

    /// The columns of the database, in the order of [`Self::read`].
    #[must_use]
    pub fn stored(&self) -> Vec<(String, Keep)> {
        let value = (self.name.clone(), Keep::Extremes);
        let ends = [".low", ".high"].map(|end| (format!("{}{end}", self.name), Keep::Mean));
        std::iter::once(value).chain(ends.into_iter().filter(|_| self.interval)).collect()
    }
}

fn judged(indicator: &Indicator) -> [f64; 3] {
    if indicator.known == 0 {
        return [f64::NAN; 3];
    }
    [indicator.value, indicator.low, indicator.high]
}

/// Mean and 95 % interval of a normal distribution.
fn normal(mean: f64, sigma: f64) -> [f64; 3] {
    [mean, mean - 1.96 * sigma, mean + 1.96 * sigma]
}

fn only(value: f64) -> [f64; 3] {
    [value, f64::NAN, f64::NAN]
}

type OfWagon = (&'static str, &'static str, bool, fn(&Health) -> [f64; 3]);
type OfWheelset = (&'static str, &'static str, bool, fn(&Health, usize) -> [f64; 3]);

const OF_WAGON: &[OfWagon] = &[
    ("grade", "", false, |health| only(f64::from(health.grade))),
    ("speed", "m/s", false, |health| only(health.v_m_s)),
    ("position", "m", false, |health| only(health.position_m)),
    ("adhesion", "", true, |health| normal(health.mu_w, health.mu_w_sigma)),
    ("brake_friction_now", "", true, |health| normal(health.mu_b_mean, health.mu_b_mean_sigma)),
    ("brake_friction", "", true, |health| judged(&health.brake_friction)),
    ("asymmetry", "", true, |health| judged(&health.asymmetry)),
    ("adhesion_utilised", "", true, |health| judged(&health.adhesion_utilised)),
    ("adhesion_available", "", true, |health| judged(&health.adhesion_available)),
    ("rail_dry", "", false, |health| only(health.condition_probability[0])),
    ("rail_wet", "", false, |health| only(health.condition_probability[1])),
    ("rail_low", "", false, |health| only(health.condition_probability[2])),
    ("rail_very_low", "", false, |health| only(health.condition_probability[3])),
    ("slides", "", false, |health| judged(&health.slides)),
    ("wsp_share", "", false, |health| judged(&health.wsp_share)),
    ("sensors", "", false, |health| judged(&health.sensors)),
    ("filter", "", false, |health| judged(&health.filter)),
    ("braking", "s", false, |health| only(health.braking_s)),
    ("brake_friction_standard", "", true, |health| judged(&health.brake_friction_standard)),
    ("response", "s", true, |health| judged(&health.response)),
    ("dragging", "N", true, |health| judged(&health.dragging)),
    ("isolated", "", false, |health| judged(&health.isolated)),
    ("sanding", "", true, |health| judged(&health.sanding)),
    ("model", "", false, |health| judged(&health.model)),
    ("pressing_force", "N", false, |health| only(health.pressing_force_n)),
    ("sand", "", false, |health| only(health.sanding_now)),
];

const OF_WHEELSET: &[OfWheelset] = &[
    ("brake_friction", "", true, |health, index| judged(&health.wheelset[index].brake_friction)),
    ("adhesion_available", "", false, |health, index| judged(&health.wheelset[index].adhesion_available)),
    ("creepage", "", false, |health, index| only(health.wheelset[index].slip)),
    ("slides", "", false, |health, index| judged(&health.wheelset[index].slides)),
    ("slide_energy", "J", false, |health, index| only(health.wheelset[index].slide_energy_j)),
    ("slide_time", "s", false, |health, index| only(health.wheelset[index].slide_s)),
    ("wsp_share", "", false, |health, index| judged(&health.wheelset[index].wsp_share)),
    ("brake_friction_standard", "", true, |health, index| {
        judged(&health.wheelset[index].brake_friction_standard)
    }),
    ("isolated", "", false, |health, index| judged(&health.wheelset[index].isolated)),
    ("adhesion_utilised", "", true, |health, index| judged(&health.wheelset[index].adhesion_utilised)),
];

/// Everything that is remembered of wagons with at most so many wheelsets.
#[must_use]
pub fn all(wheelsets: usize) -> Vec<Column> {
    let of_wagon = OF_WAGON.iter().map(|&(name, unit, interval, read)| Column {
        name: name.to_owned(),
        unit,
        interval,
        read: Read::Wagon(read),
    });
    let of_wheelsets = (0..wheelsets).flat_map(|index| {
        OF_WHEELSET.iter().map(move |&(name, unit, interval, read)| Column {
            name: format!("wheelset_{}.{name}", index + 1),
            unit,
            interval,
            read: Read::Wheelset(index, read),
        })
    });
    of_wagon.chain(of_wheelsets).collect()
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
        assert_eq!(value("speed"), 20.0);
        assert_eq!(value("wheelset_2.slide_energy"), 0.0);
        assert!(value("wheelset_3.slide_energy").is_nan() && value("brake_friction").is_nan());
    }
}
