//! The judged figures of a wagon, a wheelset or the train, by the table of indicators.

use crate::api::figure::Figure;
use railgrip_indicators::IndicatorSpec;
use serde::ser::{Serialize, SerializeMap, Serializer};

/// Figures with what they are, in the order of the table; in JSON each stands under the name of its field.
#[derive(Debug, Clone, Default)]
pub struct Figures(pub(crate) Vec<(&'static IndicatorSpec, Figure)>);

impl PartialEq for Figures {
    fn eq(&self, other: &Self) -> bool {
        let ids = |figures: &Self| figures.0.iter().map(|(spec, _)| spec.id).collect::<Vec<_>>();
        ids(self) == ids(other) && self.iter().zip(other.iter()).all(|((_, one), (_, two))| one == two)
    }
}

impl Figures {
    /// The figures in the order of the table.
    pub fn iter(&self) -> impl Iterator<Item = (&'static IndicatorSpec, &Figure)> {
        self.0.iter().map(|(spec, figure)| (*spec, figure))
    }

    /// The figure of an indicator, if it is judged here.
    #[must_use]
    pub fn get(&self, spec: &IndicatorSpec) -> Option<&Figure> {
        self.iter().find(|(own, _)| own.id == spec.id).map(|(_, figure)| figure)
    }
}

impl Serialize for Figures {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (spec, figure) in self.iter() {
            map.serialize_entry(&spec.field(), figure)?;
        }
        map.end()
    }
}
