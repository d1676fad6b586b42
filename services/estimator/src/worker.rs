//! The work of an estimator process without its channels: samples in; estimates, innovations, indicators and events out.

use crate::convert;
use crate::gap_watch::{GapWatch, Mismatch};
use crate::timing::Histogram;
use railgrip_filter::{EstimatorConfig, FilterError, WagonEstimator};
use railgrip_indicators::{IndicatorSettings, Nominal, WagonIndicators};
use railgrip_messages::{
    Estimate, Event, EventKind, Grade, Health, Innovation, NO_WHEELSET, Sample, Stamp, Text, flags,
    sample_flags,
};
use railgrip_settings::TrainSettings;
use railgrip_vehicle::VehicleParameters;
use std::time::Instant;

/// Filter and indicators of one wagon, with what they made of the samples since the last [`Worker::clear`].
pub struct Worker {
    pub(crate) wagon: u32,
    config: EstimatorConfig,
    pub(crate) estimator: WagonEstimator,
    pub(crate) indicators: WagonIndicators,
    pub(crate) last: Option<(u64, Stamp)>,
    /// The filter knows something: it took a sample, or goes on from a snapshot.
    pub(crate) has_state: bool,
    /// Samples estimated whose estimates have not gone into the indicators yet, the latest of `estimates`.
    undigested: Vec<Sample>,
    /// Estimates of the samples taken, to be published.
    pub estimates: Vec<Estimate>,
    /// Innovations of the samples taken, to be published.
    pub innovations: Vec<Innovation>,
    /// What began and ended, to be published.
    pub events: Vec<Event>,
    /// Durations of single steps of the filter.
    pub step_ns: Histogram,
    /// Samples taken since the process started.
    pub taken: u64,
    /// Whether the model explains the data.
    pub gap: GapWatch,
    /// The mismatch that was told, while it lasts.
    pub told: Option<Mismatch>,
    pub(crate) vehicle: VehicleParameters,
    grades: Vec<Grade>,
}

impl Worker {
    /// The worker of wagon number `wagon`.
    ///
    /// # Errors
    /// A filter that does not handle the vehicle.
    pub fn new(settings: &TrainSettings, wagon: u32) -> Result<Self, FilterError> {
        let vehicle = settings.wagon(wagon).map(|wagon| wagon.vehicle.clone());
        let vehicle = vehicle.unwrap_or_else(|| settings.wagons[0].vehicle.clone());
        Self::with(wagon, &settings.estimator, settings.indicators, vehicle)
    }

    /// The worker of a wagon from its parts.
    ///
    /// # Errors
    /// A filter that does not handle the vehicle.
    pub fn with(
        wagon: u32,
        config: &EstimatorConfig,
        indicators: IndicatorSettings,
        vehicle: VehicleParameters,
    ) -> Result<Self, FilterError> {
        let nominal = Nominal {
            brake_friction: vehicle.brake.friction_coefficient,
            rail: [vehicle.rail.dry, vehicle.rail.wet, vehicle.rail.low],
        };
        Ok(Self {
            wagon,
            config: config.clone(),
            estimator: WagonEstimator::new(config, &vehicle)?,
            vehicle,
            indicators: WagonIndicators::new(wagon, indicators, nominal),
            last: None,
            has_state: false,
            undigested: Vec::new(),
            estimates: Vec::new(),
            innovations: Vec::new(),
            events: Vec::new(),
            step_ns: Histogram::default(),
            taken: 0,
            gap: GapWatch::new(indicators.filter.nis_watch_high),
            told: None,
            grades: Vec::new(),
        })
    }

    /// Takes one sample all the way: [`Self::estimate`], then [`Self::digest`].
    pub fn take(&mut self, sample: &Sample) {
        self.estimate(sample);
        self.digest();
    }

    /// Estimates one sample. One that was taken before (a late joiner gets the last few once more) changes nothing.
    pub fn estimate(&mut self, sample: &Sample) {
        if self.last.is_some_and(|(_, stamp)| sample.acquired.monotonic_ns <= stamp.monotonic_ns) {
            return;
        }
        let begins = sample.flags & sample_flags::TIME_BASE_RESTARTED != 0;
        if begins && self.has_state {
            self.begin_anew(sample);
        }
        self.last = Some((sample.sequence, sample.acquired));
        self.has_state = true;
        self.taken += 1;
        let input = convert::input(sample);
        let before = Instant::now();
        let output = self.estimator.step(&input);
        self.step_ns.add(u64::try_from(before.elapsed().as_nanos()).unwrap_or(u64::MAX));
        let mut estimate = convert::estimate(sample, &output);
        if begins {
            estimate.flags |= flags::RESTARTED;
        }
        self.estimates.push(estimate);
        self.innovations.push(convert::innovation(sample, &output));
        self.undigested.push(*sample);
    }

    /// Takes what was estimated into the indicators: apart from estimating, so that estimates need not wait for it.
    pub fn digest(&mut self) {
        let from = self.estimates.len() - self.undigested.len();
        let fresh = self.estimates[from..].iter().zip(&self.innovations[from..]);
        for (sample, (estimate, innovation)) in self.undigested.iter().zip(fresh) {
            let events = &mut self.events;
            self.indicators.update(sample, estimate, &mut |event| events.push(event));
            self.gap.take(sample, estimate, innovation);
        }
        self.undigested.clear();
    }

    /// What the filter knew belongs to another run.
    fn begin_anew(&mut self, sample: &Sample) {
        match WagonEstimator::new(&self.config, &self.vehicle) {
            Ok(estimator) => self.estimator = estimator,
            Err(error) => tracing::error!(%error, "the filter cannot start anew and goes on"),
        }
        let text = "the time base of the samples began anew";
        self.event(
            EventKind::FilterRestarted,
            sample.acquired,
            sample.time_s,
            Grade::Unknown,
            [0.0; 4],
            text,
        );
    }

    /// The indicators as of now; a changed grade becomes an event.
    pub fn health(&mut self) -> Health {
        let mut health = self.indicators.health();
        self.watch_gap(&mut health);
        let named = [
            ("brake friction", health.brake_friction),
            ("asymmetry", health.asymmetry),
            ("rail", health.rail),
            ("slides", health.slides),
            ("slide protection", health.wsp_share),
            ("sensors", health.sensors),
            ("filter", health.filter),
        ];
        let known = !self.grades.is_empty();
        self.grades.resize(named.len(), Grade::Unknown);
        for (index, (name, indicator)) in named.iter().enumerate() {
            let (old, new) = (self.grades[index], indicator.grade());
            if old == new {
                continue;
            }
            self.grades[index] = new;
            if known {
                let values = [f64::from(old.code()), f64::from(new.code()), indicator.value, 0.0];
                let text = format!("{name} {new}: {}", indicator.reason);
                self.event(EventKind::GradeChanged, health.acquired, health.time_s, new, values, &text);
            }
        }
        health
    }

    /// A mismatch that lasts shows in the indicator of the filter, and is told once.
    fn watch_gap(&mut self, health: &mut Health) {
        let Some(found) = self.gap.mismatch() else {
            self.told = None;
            return;
        };
        let text = format!(
            "model and data disagree (ratio {:.1}, ideal 1), most for {}: suspect {}",
            found.ratio, found.place, found.term
        );
        let grade = health.filter.grade().max(Grade::Watch);
        health.filter.grade = grade.code();
        health.filter.reason = Text::new(&text);
        health.grade = health.grade().max(grade).code();
        if self.told.as_ref().is_none_or(|told| told.term != found.term) {
            let values = [found.ratio, found.seconds, 0.0, 0.0];
            self.event(EventKind::ModelMismatch, health.acquired, health.time_s, grade, values, &text);
            self.told = Some(found);
        }
    }

    fn event(
        &mut self,
        kind: EventKind,
        stamp: Stamp,
        time_s: f64,
        grade: Grade,
        values: [f64; 4],
        text: &str,
    ) {
        self.events.push(Event {
            sequence: 0,
            stamp,
            time_s,
            kind: kind.code(),
            wagon: self.wagon,
            wheelset: NO_WHEELSET,
            grade: grade.code(),
            values,
            text: Text::new(text),
        });
    }

    /// Takes whatever sample comes next, whenever it was acquired.
    pub fn forget_stamp(&mut self) {
        self.last = None;
    }

    /// Forgets what has been published.
    pub fn clear(&mut self) {
        self.digest();
        self.estimates.clear();
        self.innovations.clear();
        self.events.clear();
    }
}
