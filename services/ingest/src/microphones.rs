//! Microphones as sources: WAV recordings at their own pace, or noise synthesised from how a simulated wagon rolls.

use crate::feed::{Feed, InputError, Rolls};
use crate::pace::Pace;
use railgrip_acoustics::synthesis::{Rig, Rolling, Scene, Surroundings, Synthesiser, dry_level_db};
use railgrip_acoustics::{SAMPLE_RATE_HZ, wav};
use railgrip_bus::{AudioPublisher, Bus, BusError, MAX_AUDIO_BLOCK};
use railgrip_messages::{AudioHeader, sample_flags};
use railgrip_settings::{AudioSource, MicrophoneSettings, TrainSettings};
use std::path::PathBuf;

/// Blocks a second.
const BLOCKS_PER_S: u32 = 10;
/// Hum under the background, and hiss under the larger of background and a usual brake's, dB.
const HUM_DB: f64 = -10.0;
const HISS_DB: f64 = -8.0;

/// All microphones of a train.
pub(crate) struct Microphones {
    all: Vec<Microphone>,
}

struct Microphone {
    wagon: u32,
    publisher: AudioPublisher,
    sound: Sound,
    sequence: u64,
    begins: bool,
    failing: bool,
}

/// Where the next block comes from, and when it is due.
enum Sound {
    Synthesised { synthesiser: Box<Synthesiser>, noise_db: f64, blocks: u64 },
    Recorded(Player),
}

/// Recordings one after the other.
struct Player {
    files: Vec<PathBuf>,
    repeat: bool,
    number: usize,
    recording: wav::Recording,
    taken: usize,
    begin_s: f64,
    begins: bool,
}

/// A microphone's audio before the channels are opened: what is wrong with it shows first.
pub(crate) struct Prepared {
    wagon: u32,
    sound: Sound,
}

/// Reads what is to be heard.
///
/// # Errors
/// A recording that is no WAV file.
pub(crate) fn prepare(settings: &TrainSettings) -> Result<Vec<Prepared>, InputError> {
    settings
        .microphones
        .iter()
        .map(|microphone| Ok(Prepared { wagon: microphone.wagon, sound: Sound::of(microphone)? }))
        .collect()
}

impl Microphones {
    /// Opens the channels.
    pub fn open(bus: &Bus, prepared: Vec<Prepared>) -> Result<Self, BusError> {
        let open = |Prepared { wagon, sound }| {
            let publisher = bus.audio_publisher(wagon)?;
            Ok(Microphone { wagon, publisher, sound, sequence: 0, begins: true, failing: false })
        };
        Ok(Self { all: prepared.into_iter().map(open).collect::<Result<_, BusError>>()? })
    }

    /// Sends every block that is due up to `until_s`; says how many.
    pub fn send_due(&mut self, until_s: f64, feed: &dyn Feed, pace: &Pace) -> u64 {
        let mut sent = 0;
        for microphone in &mut self.all {
            let rolls = feed.rolls(microphone.wagon.saturating_sub(1) as usize);
            while let Some(block) = microphone.sound.next(until_s, rolls) {
                sent += u64::from(microphone.send(&block, pace));
            }
        }
        sent
    }
}

impl Microphone {
    /// Trouble with one microphone stops nothing else; it is told once.
    fn send(&mut self, block: &Block, pace: &Pace) -> bool {
        let begins = std::mem::take(&mut self.begins) || block.begins;
        let header = AudioHeader {
            sequence: self.sequence,
            acquired: pace.stamp(block.due_s),
            wagon: self.wagon,
            sample_rate_hz: block.sample_rate_hz,
            flags: if begins { sample_flags::TIME_BASE_RESTARTED } else { 0 },
            reserved: 0,
        };
        self.sequence += 1;
        let result = self.publisher.publish(header, &block.samples);
        if let Err(error) = &result
            && !self.failing
        {
            tracing::warn!(wagon = self.wagon, %error, "a block of audio is lost");
        }
        self.failing = result.is_err();
        result.is_ok()
    }
}

/// Samples that are due together.
struct Block {
    samples: Vec<f32>,
    sample_rate_hz: u32,
    due_s: f64,
    begins: bool,
}

impl Sound {
    fn of(settings: &MicrophoneSettings) -> Result<Self, InputError> {
        Ok(match &settings.audio {
            AudioSource::Synthesised { rig, noise_db, seed } => {
                let rig = Rig::named(rig).unwrap_or_else(railgrip_acoustics::synthesis::rig::track);
                let synthesiser = Box::new(Synthesiser::new(rig, *seed));
                Self::Synthesised { synthesiser, noise_db: *noise_db, blocks: 0 }
            }
            AudioSource::Recordings { files, repeat } => {
                // All are read once, so that a bad one is named now and not in an hour.
                let mut first = None;
                for file in files {
                    let recording = wav::read(file)?;
                    first.get_or_insert(recording);
                }
                let recording = first.unwrap_or(wav::Recording {
                    sample_rate_hz: SAMPLE_RATE_HZ,
                    samples: Vec::new(),
                    channels: 1,
                });
                let (files, repeat) = (files.clone(), *repeat);
                Self::Recorded(Player {
                    files,
                    repeat,
                    number: 0,
                    recording,
                    taken: 0,
                    begin_s: 0.0,
                    begins: true,
                })
            }
        })
    }

    fn next(&mut self, until_s: f64, rolls: Option<Rolls>) -> Option<Block> {
        match self {
            Self::Synthesised { synthesiser, noise_db, blocks } => {
                let due_s = (*blocks + 1) as f64 / f64::from(BLOCKS_PER_S);
                if due_s > until_s {
                    return None;
                }
                *blocks += 1;
                let scene = scene(synthesiser.rig(), rolls?, *noise_db);
                let mut samples = Vec::new();
                synthesiser.render(&scene, (SAMPLE_RATE_HZ / BLOCKS_PER_S) as usize, &mut samples);
                Some(Block { samples, sample_rate_hz: SAMPLE_RATE_HZ, due_s, begins: false })
            }
            Self::Recorded(player) => player.next(until_s),
        }
    }
}

impl Player {
    fn next(&mut self, until_s: f64) -> Option<Block> {
        let rate = f64::from(self.recording.sample_rate_hz.max(1));
        if self.taken >= self.recording.samples.len() {
            self.begin_s += self.recording.samples.len() as f64 / rate;
            self.turn_over()?;
            self.begins = true;
        }
        let rate = f64::from(self.recording.sample_rate_hz.max(1));
        let length =
            (self.recording.sample_rate_hz.div_ceil(BLOCKS_PER_S) as usize).clamp(1, MAX_AUDIO_BLOCK);
        let end = (self.taken + length).min(self.recording.samples.len());
        let due_s = self.begin_s + end as f64 / rate;
        if due_s > until_s {
            return None;
        }
        let samples = self.recording.samples.get(self.taken..end)?.to_vec();
        self.taken = end;
        let begins = std::mem::take(&mut self.begins);
        Some(Block { samples, sample_rate_hz: self.recording.sample_rate_hz, due_s, begins })
    }

    /// The next file, or the first again; `None` once all is over, or if a file has become unreadable meanwhile.
    fn turn_over(&mut self) -> Option<()> {
        if self.number + 1 >= self.files.len() && !self.repeat {
            return None;
        }
        self.number = (self.number + 1) % self.files.len().max(1);
        self.taken = 0;
        if self.files.len() == 1 {
            return Some(());
        }
        match wav::read(self.files.get(self.number)?) {
            Ok(recording) => {
                self.recording = recording;
                Some(())
            }
            Err(error) => {
                tracing::warn!(%error, "a microphone falls silent");
                self.repeat = false;
                self.number = self.files.len();
                self.recording.samples.clear();
                None
            }
        }
    }
}

/// What is to be heard of a wagon that rolls like this. Other machines do not care how fast it is.
fn scene(rig: &Rig, rolls: Rolls, noise_db: f64) -> Scene {
    let usual_db = dry_level_db(rig, 0.5 * rig.speed_m_s.1);
    let background_db = usual_db + noise_db;
    Scene {
        rolling: Rolling {
            speed_m_s: rolls.speed_m_s,
            load_n: rig.load_n,
            creepage: rolls.creepage,
            wetness: rolls.wetness,
            roughness_db: rig.roughness_db,
            roughness_tilt_db: 0.0,
        },
        surroundings: Surroundings {
            background_db,
            hum_db: background_db + HUM_DB,
            hiss_db: usual_db + noise_db.min(-12.0) + HISS_DB,
            ..Surroundings::default()
        },
    }
}
