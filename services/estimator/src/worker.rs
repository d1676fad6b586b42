//! The work of an estimator process without its channels: samples in; estimates, innovations, indicators and events out.

use crate::convert;
use crate::gap_watch::{GapWatch, Mismatch};
use crate::timing::Histogram;
use railgrip_filter::{Estimator, EstimatorConfig, EstimatorInput, FilterError, Plant};
use railgrip_indicators::indicator::{ADHESION_AVAILABLE, FILTER, MODEL, judging};
use railgrip_indicators::{INDICATORS, IndicatorSettings, WagonIndicators};
use railgrip_messages::{
    BogieSample, Condition, Estimate, EstimateState, Event, EventKind, Grade, Health, Indicator, Innovation,
    MotorSample, NO_WHEELSET, Sample, Stamp, Text, flags, sample_flags,
};
use railgrip_settings::{TrainSettings, VehicleNumber};
use railgrip_vehicle::VehicleParameters;
use std::time::Instant;

/// Samples for whose results there is always room.
const MOST_ROOM: usize = 64;

/// Filter and indicators of one wagon, with what they made of the samples since the last [`Worker::clear`].
pub struct Worker {
    pub(crate) wagon: u32,
    /// Who the wagon is, where anybody has said.
    pub(crate) vehicle_number: Option<VehicleNumber>,
    /// Its last wheelset leads.
    pub(crate) turned: bool,
    /// The start of the train that this process belongs to.
    pub(crate) session: String,
    config: EstimatorConfig,
    pub(crate) plant: Plant,
    pub(crate) estimator: Box<dyn Estimator>,
    pub(crate) indicators: WagonIndicators,
    pub(crate) last: Option<(u64, Stamp)>,
    /// The first sample that this process got.
    pub(crate) first: Option<(u64, Stamp)>,
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
    /// New samples that were not taken, because their stamp is not newer than that of the sample before.
    pub not_newer: u64,
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
        let own = settings.wagon(wagon).unwrap_or(&settings.wagons[0]);
        let mut config = settings.estimator.clone();
        if let Some(filter) = &own.filter {
            config.filter.clone_from(filter);
        }
        // Tests change the vehicle of a wagon; a rig is what its file says.
        let plant = match &own.plant {
            Plant::Wagon(_) => Plant::Wagon(own.vehicle.clone()),
            rig => rig.clone(),
        };
        let worker = Self::of_plant(wagon, &config, settings.indicators, plant)?;
        Ok(Self {
            vehicle_number: own.vehicle_number.clone(),
            turned: own.turned,
            session: settings.instance.session(),
            ..worker
        })
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
        Self::of_plant(wagon, config, indicators, Plant::Wagon(vehicle))
    }

    /// The worker of a wagon or rig from its parts.
    ///
    /// # Errors
    /// A filter that does not handle it.
    pub fn of_plant(
        wagon: u32,
        config: &EstimatorConfig,
        indicators: IndicatorSettings,
        plant: Plant,
    ) -> Result<Self, FilterError> {
        let vehicle = plant.as_vehicle();
        let nominal = railgrip_settings::nominal(&vehicle);
        Ok(Self {
            wagon,
            vehicle_number: None,
            turned: false,
            session: String::new(),
            config: config.clone(),
            estimator: railgrip_filter::estimator(config, &plant)?,
            plant,
            vehicle,
            indicators: WagonIndicators::new(wagon, indicators, nominal),
            last: None,
            first: None,
            has_state: false,
            undigested: Vec::new(),
            estimates: Vec::new(),
            innovations: Vec::new(),
            events: Vec::new(),
            step_ns: Histogram::default(),
            taken: 0,
            not_newer: 0,
            gap: GapWatch::new(indicators.filter.nis_watch_high),
            told: None,
            grades: Vec::new(),
        })
    }

    /// Judges by other thresholds from now on; what is known of the wagon stays.
    pub fn judge_by(&mut self, indicators: IndicatorSettings) {
        self.indicators.judge_by(indicators);
        self.gap.judge_by(indicators.filter.nis_watch_high);
    }

    /// Name of the filter as the config has it.
    #[must_use]
    pub fn filter(&self) -> &str {
        &self.config.filter
    }

    /// Takes one sample all the way: [`Self::estimate`], then [`Self::digest`].
    pub fn take(&mut self, sample: &Sample) {
        self.estimate(sample);
        self.digest();
    }

    /// Estimates one sample. One that was taken before (a late joiner gets the last few once more) changes nothing.
    pub fn estimate(&mut self, sample: &Sample) {
        self.estimate_input(sample, &EstimatorInput::Wagon(convert::wagon_sample(sample)));
    }

    /// Estimates one sample of a driven rig, likewise.
    pub fn estimate_motor(&mut self, sample: &MotorSample) {
        if let Plant::Traction(rig) = &self.plant {
            let wagon = convert::as_wagon(sample, &self.vehicle, rig, self.estimator.last());
            self.estimate_input(&wagon, &EstimatorInput::Traction(convert::traction_sample(sample)));
        }
    }

    /// Estimates one sample of a bogie rig, likewise.
    pub fn estimate_bogie(&mut self, sample: &BogieSample) {
        if let Plant::Bogie(rig) = &self.plant {
            let wagon = convert::bogie_as_wagon(sample, rig, self.estimator.last());
            self.estimate_input(&wagon, &EstimatorInput::Bogie(convert::bogie_sample(sample)));
        }
    }

    fn estimate_input(&mut self, sample: &Sample, input: &EstimatorInput) {
        self.first.get_or_insert((sample.sequence, sample.acquired));
        if let Some((sequence, stamp)) = self.last
            && sample.acquired.monotonic_ns <= stamp.monotonic_ns
        {
            // A late joiner gets the last few once more; a new sample with an old stamp is one that is lost.
            self.not_newer += u64::from(sample.sequence > sequence);
            return;
        }
        let begins = sample.flags & sample_flags::TIME_BASE_RESTARTED != 0;
        if begins && self.has_state {
            self.begin_anew(sample);
        }
        self.last = Some((sample.sequence, sample.acquired));
        self.has_state = true;
        self.taken += 1;
        let before = Instant::now();
        let output = self.estimator.step(input);
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
            // What it names and keeps for a diagnosis are the terms and speeds of a wagon.
            if matches!(self.plant, Plant::Wagon(_) | Plant::Roller(_)) {
                self.gap.take(sample, estimate, innovation);
            }
        }
        self.undigested.clear();
    }

    /// What the filter knew belongs to another run.
    fn begin_anew(&mut self, sample: &Sample) {
        match railgrip_filter::estimator(&self.config, &self.plant) {
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
        health.vehicle =
            self.vehicle_number.as_ref().map_or_else(Text::default, |number| Text::new(number.written()));
        self.name_state(&mut health);
        self.watch_gap(&mut health);
        let known = !self.grades.is_empty();
        let judged = INDICATORS.of_wagon().zip(&health.indicator);
        let judged: Vec<_> = judged.filter(|(spec, _)| spec.alert.is_some()).collect();
        self.grades.resize(judged.len(), Grade::Unknown);
        for (index, (spec, indicator)) in judged.into_iter().enumerate() {
            let (old, new) = (self.grades[index], indicator.grade());
            if old == new {
                continue;
            }
            self.grades[index] = new;
            // The watch over the model tells its mismatches itself.
            if known && spec.id != MODEL.id {
                let values = [f64::from(old.code()), f64::from(new.code()), indicator.value, 0.0];
                let text = format!("{} {new}: {}", spec.name(), indicator.reason);
                self.event(EventKind::GradeChanged, health.acquired, health.time_s, new, values, &text);
            }
        }
        health
    }

    /// A driven rig estimates the adhesion available itself; a named state stands where there is no figure.
    fn name_state(&mut self, health: &mut Health) {
        let last = self.estimator.last();
        let Some(state) = EstimateState::from_code(last.state.code()) else { return };
        if matches!(self.plant, Plant::Traction(_)) {
            let known = last.state.tells_friction();
            let (value, reach) = (last.adhesion_peak, 1.96 * last.adhesion_peak_sigma);
            let text = match known {
                true => format!("μ0 {value:.3} ± {:.3}: {state}", last.adhesion_peak_sigma),
                false => format!("no figure: {state}"),
            };
            let (value, low, high) =
                if known { (value, value - reach, value + reach) } else { (0.0, 0.0, 0.0) };
            let reason = Text::new(&text);
            let grade = ADHESION_AVAILABLE.of(health).grade;
            let available = Indicator { value, low, high, grade, known: u32::from(known), reason };
            ADHESION_AVAILABLE.put(health, available);
            ADHESION_AVAILABLE.put_wheelset(health, 0, available);
            health.wheelset[0].adhesion_available_is_bound = 0;
        }
        if last.state.is_fault() {
            let mut filter = *FILTER.of(health);
            let grade = filter.grade().max(Grade::Watch);
            (filter.grade, filter.reason) = (grade.code(), Text::new(&format!("the input is bad: {state}")));
            FILTER.put(health, filter);
            health.grade = health.grade().max(grade).code();
        }
    }

    /// A mismatch that lasts shows in the indicator of the model, and is told once.
    fn watch_gap(&mut self, health: &mut Health) {
        self.gap.on_rail(Condition::from_code(health.condition).unwrap_or(Condition::Dry));
        if let Some(ratio) = self.gap.ratio() {
            let words = format!(
                "the model explains the data: innovation ratio {ratio:.2} over the latest minute, ideal 1"
            );
            MODEL.put(health, judging::known(ratio, ratio, ratio, Grade::Ok, &words));
        }
        let Some(found) = self.gap.mismatch().cloned() else {
            self.told = None;
            return;
        };
        let text = format!(
            "model and data disagree (ratio {:.1}, ideal 1), most for {}: suspect {}",
            found.ratio,
            found.place,
            found.term.replace('_', " ")
        );
        let grade = Grade::Watch;
        let mut model = *MODEL.of(health);
        (model.grade, model.reason) = (grade.code(), Text::new(&text));
        MODEL.put(health, model);
        health.grade = health.grade().max(grade).code();
        if self.told.as_ref().is_none_or(|told| told.term != found.term) {
            let values = [found.ratio, found.seconds, 0.0, 0.0];
            self.event(EventKind::ModelMismatch, health.acquired, health.time_s, grade, values, &text);
            self.told = Some(found);
        }
    }

    /// Notes an event of this wagon, to be published.
    pub(crate) fn event(
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
        // What a backlog took once is not kept for ever.
        self.estimates.shrink_to(MOST_ROOM);
        self.innovations.shrink_to(MOST_ROOM);
        self.undigested.shrink_to(MOST_ROOM);
    }
}
