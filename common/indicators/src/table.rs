//! The one table of indicators, and where each stands in the messages.

use crate::indicator;
use crate::spec::{IndicatorSpec, Reach};
use railgrip_messages::{Grade, Health, Indicator, MAX_INDICATORS, MAX_WHEELSET_INDICATORS};

/// All indicators, in the order in which people read them; where several have the worst grade, the first of them speaks
/// for the wagon.
pub static INDICATORS: Table = Table(&[
    &indicator::BRAKE_FRICTION,
    &indicator::BRAKE_FRICTION_STANDARD,
    &indicator::ASYMMETRY,
    &indicator::RESPONSE,
    &indicator::BRAKE_DELAY,
    &indicator::DRAGGING,
    &indicator::ISOLATED,
    &indicator::ADHESION_UTILISED,
    &indicator::ADHESION_AVAILABLE,
    &indicator::RAIL,
    &indicator::SLIDES,
    &indicator::WHEEL_FLAT,
    &indicator::WSP_SHARE,
    &indicator::SANDING,
    &indicator::DISC_RISE,
    &indicator::SENSORS,
    &indicator::FILTER,
    &indicator::MODEL,
    &indicator::STOPPING_DISTANCE,
]);

/// What stands where an indicator has no place.
static NOTHING: std::sync::LazyLock<Indicator> = std::sync::LazyLock::new(Indicator::default);

/// Indicators in an order. Their places in a message follow from it: all processes of a train are one program.
#[derive(Debug, Clone, Copy)]
pub struct Table(pub &'static [&'static IndicatorSpec]);

/// A judged figure of a wagon, with what it is.
#[derive(Debug, Clone, Copy)]
pub struct Judged<'a> {
    /// Its entry in the table.
    pub spec: &'static IndicatorSpec,
    /// The wheelset, 1 leading; `None` for the wagon.
    pub wheelset: Option<u32>,
    /// The figure.
    pub indicator: &'a Indicator,
}

impl IndicatorSpec {
    /// Whether its cause lies in the line or the train and never in a wagon.
    #[must_use]
    pub fn is_of_train(&self) -> bool {
        self.alert.is_some_and(|alert| alert.of_train)
    }

    /// What a wagon says of it, by the table of the program.
    #[must_use]
    pub fn of<'a>(&self, health: &'a Health) -> &'a Indicator {
        INDICATORS.wagon(health, self)
    }

    /// What a wagon says of it about one of its wheelsets (index, 0 leading).
    #[must_use]
    pub fn of_wheelset<'a>(&self, health: &'a Health, index: usize) -> &'a Indicator {
        INDICATORS.wheelset(health, index, self)
    }

    /// Lets a wagon say this of it; nothing happens if it is not judged on wagons.
    pub fn put(&self, health: &mut Health, indicator: Indicator) {
        if let Some(place) = INDICATORS.wagon_mut(health, self) {
            *place = indicator;
        }
    }

    /// Lets a wagon say this of it about one of its wheelsets; nothing happens if it is not judged on wheelsets.
    pub fn put_wheelset(&self, health: &mut Health, index: usize, indicator: Indicator) {
        if let Some(place) = INDICATORS.wheelset_mut(health, index, self) {
            *place = indicator;
        }
    }
}

impl Table {
    /// All entries.
    pub fn iter(self) -> impl Iterator<Item = &'static IndicatorSpec> {
        self.0.iter().copied()
    }

    /// The entry with this id.
    #[must_use]
    pub fn find(self, id: &str) -> Option<&'static IndicatorSpec> {
        self.iter().find(|spec| spec.id == id)
    }

    /// Entries that are judged on the wagon, each at its place in the message.
    pub fn of_wagon(self) -> impl Iterator<Item = &'static IndicatorSpec> {
        self.iter().filter(|spec| spec.judge.wagon.is_some()).take(MAX_INDICATORS)
    }

    /// Entries that are judged on each wheelset, each at its place in the message.
    pub fn of_wheelset(self) -> impl Iterator<Item = &'static IndicatorSpec> {
        self.iter().filter(|spec| spec.judge.wheelset.is_some()).take(MAX_WHEELSET_INDICATORS)
    }

    /// What a wagon says of an indicator.
    #[must_use]
    pub fn wagon<'a>(self, health: &'a Health, spec: &IndicatorSpec) -> &'a Indicator {
        let place = self.of_wagon().position(|other| other.id == spec.id);
        place.map_or(&*NOTHING, |place| &health.indicator[place])
    }

    /// What a wagon says of an indicator of one of its wheelsets (index, 0 leading).
    #[must_use]
    pub fn wheelset<'a>(self, health: &'a Health, index: usize, spec: &IndicatorSpec) -> &'a Indicator {
        let place = self.of_wheelset().position(|other| other.id == spec.id);
        let wheelset = health.wheelset.get(index);
        place.zip(wheelset).map_or(&*NOTHING, |(place, wheelset)| &wheelset.indicator[place])
    }

    /// Where an indicator of a wagon stands in the message; `None` if it is not judged on wagons.
    pub fn wagon_mut<'a>(self, health: &'a mut Health, spec: &IndicatorSpec) -> Option<&'a mut Indicator> {
        let place = self.of_wagon().position(|other| other.id == spec.id)?;
        Some(&mut health.indicator[place])
    }

    /// Where an indicator of a wheelset stands in the message; `None` if it is not judged on wheelsets.
    pub fn wheelset_mut<'a>(
        self,
        health: &'a mut Health,
        index: usize,
        spec: &IndicatorSpec,
    ) -> Option<&'a mut Indicator> {
        let place = self.of_wheelset().position(|other| other.id == spec.id)?;
        Some(&mut health.wheelset.get_mut(index)?.indicator[place])
    }

    /// What raises alerts, in the order of the table, the wagon before its wheelsets.
    #[must_use]
    pub fn judged(self, health: &Health) -> Vec<Judged<'_>> {
        let raises = |spec: &IndicatorSpec| spec.alert.map_or(Reach::Nowhere, |alert| alert.raised_by);
        let wagon = self.of_wagon().zip(&health.indicator).filter(|(spec, _)| raises(spec).wagon());
        let mut all: Vec<Judged<'_>> =
            wagon.map(|(spec, indicator)| Judged { spec, wheelset: None, indicator }).collect();
        for (index, wheelset) in health.wheelset[..health.wheelset_count()].iter().enumerate() {
            let own =
                self.of_wheelset().zip(&wheelset.indicator).filter(|(spec, _)| raises(spec).wheelsets());
            let number = Some(index as u32 + 1);
            all.extend(own.map(|(spec, indicator)| Judged { spec, wheelset: number, indicator }));
        }
        all
    }

    /// The worst grade of a wagon: of all its indicators that have a rule for alerts, but for what lies in the line or the
    /// train. A rail that is low is no fault of the wagons that run on it.
    #[must_use]
    pub fn worst(self, health: &Health) -> Grade {
        let ruled = |spec: &IndicatorSpec| spec.alert.is_some() && !spec.is_of_train();
        let wagon = self.of_wagon().zip(&health.indicator).filter(|(spec, _)| ruled(spec));
        let own = wagon.map(|(_, indicator)| indicator.grade());
        let judged = self.judged(health).into_iter().filter(|judged| !judged.spec.is_of_train());
        own.chain(judged.map(|judged| judged.indicator.grade())).max().unwrap_or(Grade::Unknown)
    }
}
