//! What the pages show of the config: the limits by which the indicators are judged, and who is notified.

use crate::notes::Whose;
use railgrip_indicators::train::capability::FullBraking;
use railgrip_indicators::{INDICATORS, IndicatorSettings, IndicatorSpec, Limit, Nominal, Table};
use railgrip_settings::{CapabilitySettings, ReceiverSettings, TrainSettings, WagonSettings};
use std::path::PathBuf;

/// The limits of one train.
#[derive(Debug, Clone)]
pub struct Limits {
    /// The indicators.
    pub table: Table,
    /// What each wagon is, wagon 1 first.
    nominal: Vec<Nominal>,
    /// How indicators are computed and judged.
    pub settings: IndicatorSettings,
    /// What full braking is, and the adhesion map.
    pub capability: Option<CapabilitySettings>,
    /// What a vehicle is remembered by, wagon 1 first.
    vehicles: Vec<Whose>,
    /// Who is notified of alerts.
    pub receivers: Vec<ReceiverSettings>,
    /// The config file, where there is one.
    pub file: Option<PathBuf>,
}

impl Default for Limits {
    /// Of no wagon.
    fn default() -> Self {
        Self {
            table: INDICATORS,
            nominal: Vec::new(),
            settings: IndicatorSettings::default(),
            capability: None,
            vehicles: Vec::new(),
            receivers: Vec::new(),
            file: None,
        }
    }
}

impl Limits {
    /// Those of a train.
    #[must_use]
    pub fn of(settings: &TrainSettings) -> Self {
        let start = settings.instance.session();
        let nominal = settings.wagons.iter().map(|wagon| railgrip_settings::nominal(&wagon.vehicle));
        Self {
            table: INDICATORS,
            nominal: nominal.collect(),
            settings: settings.indicators,
            capability: Some(settings.capability.clone()),
            vehicles: settings.wagons.iter().map(|wagon| remembered_by(wagon, &start)).collect(),
            receivers: settings.notify.receivers.clone(),
            file: settings.file.is_file().then(|| settings.file.clone()),
        }
    }

    /// The same by another table.
    #[must_use]
    pub fn with(self, table: Table) -> Self {
        Self { table, ..self }
    }

    /// The limits of an indicator on a wagon, in its unit.
    pub(crate) fn limit(&self, spec: &IndicatorSpec, wagon: u32) -> Option<Limit> {
        let nominal = self.nominal.get((wagon as usize).checked_sub(1)?)?;
        spec.limit.map(|limit| limit(&self.settings, nominal))
    }

    /// What the vehicle at a place is remembered by.
    pub(crate) fn remembered(&self, wagon: u32) -> Option<&Whose> {
        self.vehicles.get((wagon as usize).checked_sub(1)?)
    }

    /// What full braking is; zeros where that is not known.
    pub(crate) fn full_braking(&self) -> FullBraking {
        self.capability.as_ref().map(CapabilitySettings::full_braking).unwrap_or_default()
    }
}

/// A number however it is written; the name of a wagon without one belongs to its place in this start of the train.
fn remembered_by(wagon: &WagonSettings, start: &str) -> Whose {
    match &wagon.vehicle_number {
        Some(number) => Whose { vehicle: number.key().to_owned(), start: None },
        None => Whose { vehicle: wagon.name.clone(), start: (!start.is_empty()).then(|| start.to_owned()) },
    }
}
