//! Listener: one process a microphone. Blocks of audio wake it; it gathers windows of one second, says whether the rail
//! sounds dry or wet, and publishes that with its state. Audio that cannot be judged gets a named state, no number.
//!
//! [`window`] gathers, `railgrip_classifier` hears, [`advice`] sets what was heard beside what was measured.

mod advice;
mod refused;
mod window;

use crate::advice::Adviser;
use crate::refused::Refused;
use crate::window::{ABSENT_S, Gatherer, Second, level_db};
use railgrip_acoustics::AudioError;
use railgrip_bus::{
    AudioSubscriber, Bus, BusConfig, BusError, EstimateSubscriber, EventPublisher, HeardPublisher,
    HeartbeatPublisher, Lifecycle, monotonic_ns, now,
};
use railgrip_classifier::{Condition as HeardCondition, Ear, Hearing, Model, ModelError, Verdict, Window};
use railgrip_messages::{
    Checked, Condition, Estimate, Event, EventKind, Grade, Heard, HearingState, Heartbeat, NO_WHEELSET,
    ProcessKind, Stamp, Text,
};
use railgrip_settings::TrainSettings;
use std::time::{Duration, Instant};

/// Longest sleep: timers and the stop flag are looked at this often.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// Time between two heartbeats, and between two words about absent audio.
const SECOND: Duration = Duration::from_secs(1);
/// Time between two looks at the holder.
const HOLDER_CHECK: Duration = Duration::from_millis(500);
/// A speed older than this is not used, s.
const SPEED_STALE_S: f64 = 2.0;

/// Why a listener ended.
#[derive(Debug, thiserror::Error)]
pub enum ListenerError {
    /// The wagon has no microphone.
    #[error("wagon {wagon} has no [[microphone]]")]
    NoMicrophone {
        /// Its number.
        wagon: u32,
    },
    /// The model cannot be used.
    #[error(
        "{0}; `railgrip acoustics train --out FILE` makes a new one, without `acoustics.model` the built-in one is used"
    )]
    Model(ModelError),
    /// The ear cannot be built.
    #[error(transparent)]
    Audio(#[from] AudioError),
    /// The channels cannot be used.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Loads the model that the settings name.
///
/// # Errors
/// A file that cannot be read, is no model or is damaged.
pub fn model(settings: &TrainSettings) -> Result<Model, ListenerError> {
    match &settings.acoustics.model {
        Some(file) => Model::load(file),
        None => Model::built_in(),
    }
    .map_err(ListenerError::Model)
}

/// Runs until asked to stop.
///
/// # Errors
/// A wagon without a microphone, a model that cannot be used, or channels that cannot be used.
pub fn run(settings: &TrainSettings, wagon: u32, lifecycle: &Lifecycle) -> Result<(), ListenerError> {
    if settings.microphone(wagon).is_none() {
        return Err(ListenerError::NoMicrophone { wagon });
    }
    let ear = Ear::new(model(settings)?, settings.acoustics.hysteresis)?;
    let bus = Bus::open(BusConfig::of(settings), ProcessKind::Listener, wagon)?;
    let mut service = Service::open(&bus, settings, wagon, ear)?;
    service.event(EventKind::Started, Grade::Unknown, "listener has started")?;
    lifecycle.ready();
    tracing::info!("listener has started");
    while !lifecycle.should_stop() {
        service.audio.wait(LONGEST_WAIT)?;
        service.round()?;
        if service.checked.elapsed() >= HOLDER_CHECK {
            service.checked = Instant::now();
            bus.check_holder()?;
        }
        lifecycle.beat();
    }
    service.event(EventKind::Stopped, Grade::Unknown, "listener was asked to stop")?;
    tracing::info!(windows = service.sequence, missed = service.audio.missed(), "listener stops");
    Ok(())
}

/// The ends of the channels, the ear, and the timers.
struct Service {
    wagon: u32,
    ear: Ear,
    adviser: Option<Adviser>,
    audio: AudioSubscriber,
    estimates: EstimateSubscriber,
    heard: HeardPublisher,
    events: EventPublisher,
    heartbeats: HeartbeatPublisher,
    gatherer: Gatherer,
    speed: Option<(f64, Stamp)>,
    last_block: Instant,
    last_word: Instant,
    beaten: Option<Instant>,
    checked: Instant,
    started: Instant,
    state: HearingState,
    condition: Option<HeardCondition>,
    sequence: u64,
    beats: u64,
    event_sequence: u64,
    rejected: u64,
    refused: Refused,
    step_ns: u64,
}

impl Service {
    fn open(bus: &Bus, settings: &TrainSettings, wagon: u32, ear: Ear) -> Result<Self, BusError> {
        let instant = Instant::now();
        Ok(Self {
            wagon,
            ear,
            adviser: settings.wagon(wagon).map(|wagon| Adviser::of(&wagon.plant)),
            audio: bus.audio_subscriber(wagon)?,
            estimates: bus.estimate_subscriber(wagon)?,
            heard: bus.heard_publisher(wagon)?,
            events: bus.event_publisher()?,
            heartbeats: bus.heartbeat_publisher()?,
            gatherer: Gatherer::default(),
            speed: None,
            last_block: instant,
            last_word: instant,
            beaten: None,
            checked: instant,
            started: instant,
            state: HearingState::Starting,
            condition: None,
            sequence: 0,
            beats: 0,
            event_sequence: 0,
            rejected: 0,
            refused: Refused::default(),
            step_ns: 0,
        })
    }

    fn round(&mut self) -> Result<(), ListenerError> {
        let (speed, adviser) = (&mut self.speed, &mut self.adviser);
        let (refused, wagon, at) = (&mut self.refused, self.wagon, now());
        self.estimates.receive(|batch| {
            let mut sound =
                |estimate: &&Estimate| refused.passes(Estimate::NAME, estimate.validated(at).map(|_| ()));
            let Some(last) = batch.iter().rev().find(&mut sound) else { return };
            *speed = Some((last.v_m_s, last.acquired));
            if let Some(adviser) = adviser {
                adviser.take(last);
            }
        })?;
        let mut seconds = Vec::new();
        let gatherer = &mut self.gatherer;
        let last_block = &mut self.last_block;
        self.audio.receive(|header, block| {
            if refused.passes("audio", header.check(wagon, at)) {
                gatherer.take(header, block, &mut |second| seconds.push(second));
                *last_block = Instant::now();
            }
        })?;
        for second in &seconds {
            self.listen(second)?;
        }
        let absent = self.last_block.elapsed().as_secs_f64() > ABSENT_S;
        if absent && self.last_word.elapsed() >= SECOND {
            let nothing = Heard { acquired: now(), level_db: -200.0, ..Heard::default() };
            self.publish(nothing, HearingState::NoAudio, None)?;
        }
        if self.beaten.is_none_or(|beaten| beaten.elapsed() >= SECOND) {
            self.beat()?;
            self.heard.refresh()?;
        }
        Ok(())
    }

    fn listen(&mut self, second: &Second) -> Result<(), ListenerError> {
        let began = Instant::now();
        let fresh = |stamp: &Stamp| stamp.age_s(monotonic_ns()) < SPEED_STALE_S;
        let speed_m_s = self.speed.filter(|(speed, stamp)| speed.is_finite() && fresh(stamp));
        let window = Window {
            sample_rate_hz: second.sample_rate_hz,
            samples: &second.samples,
            speed_m_s: speed_m_s.map(|(speed, _)| speed),
        };
        let Verdict { hearing, wet, condition } = self.ear.listen(&window);
        let heard = Heard {
            acquired: second.acquired,
            known: u32::from(wet.is_some()),
            wet_probability: wet.unwrap_or(0.0),
            level_db: level_db(&second.samples),
            sample_rate_hz: second.sample_rate_hz,
            ..Heard::default()
        };
        self.step_ns = began.elapsed().as_nanos() as u64;
        self.publish(heard, state(hearing), condition)
    }

    fn publish(
        &mut self,
        mut heard: Heard,
        state: HearingState,
        condition: Option<HeardCondition>,
    ) -> Result<(), ListenerError> {
        heard.sequence = self.sequence;
        heard.wagon = self.wagon;
        heard.state = state.code();
        heard.condition = condition.map_or(u32::MAX, code);
        heard.missed = self.audio.missed();
        heard.decided_condition = u32::MAX;
        if let Some(adviser) = &mut self.adviser {
            adviser.advise(monotonic_ns(), &mut heard);
        }
        heard.published_monotonic_ns = monotonic_ns();
        self.sequence += 1;
        self.rejected += u64::from(heard.known == 0);
        self.last_word = Instant::now();
        self.heard.publish(&[heard])?;
        self.tell(state, condition)
    }

    /// Events of what changed.
    fn tell(&mut self, state: HearingState, condition: Option<HeardCondition>) -> Result<(), ListenerError> {
        if state != self.state {
            self.state = state;
            let normal = matches!(state, HearingState::Heard | HearingState::Standstill);
            let grade = if normal { Grade::Ok } else { Grade::Watch };
            self.event(EventKind::HearingChanged, grade, &format!("microphone: {state}"))?;
            tracing::info!(state = state.word(), "what the microphone hears has changed");
        }
        if condition.is_some() && condition != self.condition {
            self.condition = condition;
            let word = condition.map_or("", HeardCondition::word);
            self.event(EventKind::HearingChanged, Grade::Ok, &format!("the rail sounds {word}"))?;
        }
        Ok(())
    }

    fn event(&mut self, kind: EventKind, grade: Grade, text: &str) -> Result<(), BusError> {
        self.event_sequence += 1;
        self.events.publish(&[Event {
            sequence: self.event_sequence,
            stamp: now(),
            kind: kind.code(),
            wagon: self.wagon,
            wheelset: NO_WHEELSET,
            grade: grade.code(),
            text: Text::new(text),
            ..Event::default()
        }])
    }

    fn beat(&mut self) -> Result<(), BusError> {
        self.beaten = Some(Instant::now());
        self.beats += 1;
        self.heartbeats.publish(&[Heartbeat {
            sequence: self.beats,
            stamp: now(),
            process: ProcessKind::Listener.code(),
            wagon: self.wagon,
            pid: std::process::id(),
            received: self.sequence,
            missed: self.audio.missed(),
            rejected: self.rejected + self.refused.count(),
            published: self.sequence,
            step_p50_ns: self.step_ns,
            step_p99_ns: self.step_ns,
            uptime_s: self.started.elapsed().as_secs_f64(),
            ..Heartbeat::default()
        }])
    }
}

const fn state(hearing: Hearing) -> HearingState {
    match hearing {
        Hearing::Heard => HearingState::Heard,
        Hearing::WrongSampleRate => HearingState::WrongSampleRate,
        Hearing::SilentMicrophone => HearingState::SilentMicrophone,
        Hearing::Clipped => HearingState::Clipped,
        Hearing::NotFinite => HearingState::NotFinite,
        Hearing::TooShort => HearingState::TooShort,
        Hearing::Standstill => HearingState::Standstill,
        Hearing::Unfamiliar => HearingState::Unfamiliar,
    }
}

const fn code(condition: HeardCondition) -> u32 {
    match condition {
        HeardCondition::Dry => Condition::Dry.code(),
        HeardCondition::Wet => Condition::Wet.code(),
    }
}
