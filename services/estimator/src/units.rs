//! Samples of other programs, which no ingest has looked through: those that cannot be in their units are withheld, and people are told.

use crate::worker::Worker;
use railgrip_bus::now;
use railgrip_diagnosis::data::unit_watch::UnitWatch;
use railgrip_filter::PlantKind;
use railgrip_messages::{EventKind, Grade, Sample, sample_flags, valid};
use railgrip_recording::Row;
use railgrip_settings::{Source, TrainSettings};
use railgrip_vehicle::VehicleParameters;
use std::time::{Duration, Instant};

/// How often it is said again what is wrong: who listens may have begun later.
const REPEATED: Duration = Duration::from_secs(10);

/// The units of one wagon's samples.
#[derive(Debug)]
pub(crate) struct Units {
    watch: UnitWatch,
    last_s: f64,
    /// What gives the columns away, while it does.
    wrong: Option<String>,
    /// To be told at once.
    changed: bool,
    told: Instant,
}

impl Units {
    /// The watch over a wagon whose samples come from another program; nothing where ingest has looked already.
    pub fn of(settings: &TrainSettings, worker: &Worker) -> Option<Self> {
        let watched = settings.source == Source::External && worker.plant.kind() == PlantKind::Wagon;
        watched.then(|| Self::new(worker.vehicle.clone()))
    }

    fn new(vehicle: VehicleParameters) -> Self {
        let watch = UnitWatch::new(vehicle);
        Self { watch, last_s: f64::NEG_INFINITY, wrong: None, changed: false, told: Instant::now() }
    }

    /// Whether the samples up to this one can be in their units.
    pub fn plausible(&mut self, sample: &Sample) -> bool {
        // Another program may begin anew without saying so.
        if sample.time_s < self.last_s || sample.flags & sample_flags::TIME_BASE_RESTARTED != 0 {
            self.watch.begin();
        }
        self.last_s = sample.time_s;
        if let Some(wrong) = self.watch.take(&row(sample), sample.wheelset_count()) {
            match &wrong {
                Some(why) => tracing::error!("the samples are withheld: {why}"),
                None => tracing::info!("the columns are plausible again"),
            }
            (self.wrong, self.changed) = (wrong, true);
        }
        !self.watch.implausible()
    }

    /// Tells people what has changed, and now and then what is wrong.
    pub fn tell(&mut self, worker: &mut Worker) {
        let again = self.wrong.is_some() && self.told.elapsed() >= REPEATED;
        if !self.changed && !again {
            return;
        }
        (self.changed, self.told) = (false, Instant::now());
        let (grade, text) = match &self.wrong {
            Some(why) => (Grade::Act, format!("samples withheld: {why}")),
            None => (Grade::Ok, "the columns are plausible again".to_owned()),
        };
        worker.event(EventKind::UnitsImplausible, now(), self.last_s, grade, [0.0; 4], &text);
    }
}

/// The row of a sample; NaN = missing.
fn row(sample: &Sample) -> Row {
    let value = |value: f64, bit: u32| if sample.has(bit) { value } else { f64::NAN };
    let mut row = Row { t_s: sample.time_s, v_m_s: value(sample.v_m_s, valid::SPEED), ..Row::default() };
    row.grade_rad = value(sample.grade_rad, valid::GRADE);
    for i in 0..sample.wheelset_count() {
        row.wheel_speed_rad_s[i] = value(sample.wheel_speed_rad_s[i], valid::wheel_speed(i));
        row.pressing_force_n[i] = value(sample.pressing_force_n[i], valid::pressing_force(i));
        row.drive_torque_nm[i] = value(sample.drive_torque_nm[i], valid::drive_torque(i));
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vehicle() -> VehicleParameters {
        toml::from_str(include_str!("../../../config/vehicle.toml")).expect("a vehicle")
    }

    fn rolling(k: u32, factor: f64) -> Sample {
        let vehicle = vehicle();
        let mut sample =
            Sample { sequence: u64::from(k), time_s: f64::from(k) * 0.01, wheelsets: 2, ..Sample::default() };
        sample.v_m_s = 16.0 * factor;
        sample.wheel_speed_rad_s[..2].fill(16.0 / vehicle.wheelset.radius_m);
        sample.valid = valid::SPEED
            | valid::wheel_speed(0)
            | valid::wheel_speed(1)
            | valid::pressing_force(0)
            | valid::pressing_force(1);
        sample
    }

    /// A program that published km/h on the channels once was believed for ever.
    #[test]
    fn another_programs_speed_in_km_per_hour_is_withheld_and_told() {
        let mut units = Units::new(vehicle());
        let taken = (0..4000).filter(|k| units.plausible(&rolling(*k, 3.6))).count();
        assert!(taken < 250, "{taken}");
        let mut worker =
            Worker::with(1, &Default::default(), Default::default(), vehicle()).expect("a worker");
        units.tell(&mut worker);
        units.tell(&mut worker);
        let [event] = &worker.events[..] else { panic!("told once: {:?}", worker.events) };
        let text = event.text.to_string();
        assert!(event.kind() == Some(EventKind::UnitsImplausible) && event.grade == Grade::Act.code());
        assert!(text.contains("withheld") && text.contains("v_m_s") && text.contains("km/h"), "{text}");
    }

    #[test]
    fn a_sound_program_is_believed_and_one_that_begins_anew_is_looked_at_anew() {
        let mut units = Units::new(vehicle());
        assert!((0..4000).all(|k| units.plausible(&rolling(k, 1.0))));
        let taken = (0..4000).filter(|k| units.plausible(&rolling(*k, 3.6))).count();
        assert!(taken < 250, "{taken}");
    }
}
