//! The product's own network at the rig: rolling noise is synthesised from how the rig rolls, and every second is heard.

use super::listener::{Moment, RigListener};
use crate::ExperimentError;
use railgrip_acoustics::SAMPLE_RATE_HZ;
use railgrip_acoustics::synthesis::{Rig, Rolling, Scene, Surroundings, Synthesiser, dry_level_db};
use railgrip_classifier::{Ear, Hearing, Model, Window};
use railgrip_filter::models::bogie_rig::RailListener;

/// Instants, of 100 a second, over which the noise stays the same.
const INSTANTS_A_PIECE: usize = 10;
/// Background over the dry rolling noise of the rig at 2 m/s, dB. Chosen: a hall with the drive running.
const NOISE_DB: f64 = -20.0;

/// What came of one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeardWindow {
    /// Time at its end, s.
    pub time_s: f64,
    /// Whether it could be heard.
    pub hearing: Hearing,
    /// Probability of wet, if so.
    pub wet: Option<f64>,
    /// Mean wetness in truth.
    pub wetness: f64,
}

/// An ear beside the simulated rig.
pub struct EarListener {
    ear: Ear,
    synthesiser: Synthesiser,
    background_db: f64,
    piece: Vec<Moment>,
    second: Vec<Moment>,
    audio: Vec<f32>,
    /// Every window so far.
    pub windows: Vec<HeardWindow>,
    /// Largest magnitude of each tenth of a second, with its time at the end, s.
    pub envelope: Vec<(f64, f64)>,
}

impl EarListener {
    /// An ear with the built-in model.
    ///
    /// # Errors
    /// Never, unless the program is damaged.
    pub fn new(seed: u64) -> Result<Self, ExperimentError> {
        let rig = railgrip_acoustics::synthesis::rig::bogie();
        let background_db = dry_level_db(&rig, 2.0) + NOISE_DB;
        let ear = Ear::new(Model::built_in()?, 0.0)?;
        Ok(Self {
            ear,
            synthesiser: Synthesiser::new(rig, seed),
            background_db,
            piece: Vec::new(),
            second: Vec::new(),
            audio: Vec::new(),
            windows: Vec::new(),
            envelope: Vec::new(),
        })
    }

    /// Lets the last tenth of a second sound.
    fn sound(&mut self) {
        let moment = mean(&self.piece);
        let scene = scene(self.synthesiser.rig(), &moment, self.background_db);
        let count = SAMPLE_RATE_HZ as usize * INSTANTS_A_PIECE / 100;
        let from = self.audio.len();
        self.synthesiser.render(&scene, count, &mut self.audio);
        let peak = self.audio[from..].iter().fold(0.0_f32, |peak, sample| peak.max(sample.abs()));
        let time_s = self.envelope.last().map_or(0.0, |(time_s, _)| *time_s) + INSTANTS_A_PIECE as f64 * 0.01;
        self.envelope.push((time_s, f64::from(peak)));
        self.second.append(&mut self.piece);
    }
}

fn mean(moments: &[Moment]) -> Moment {
    let of = |pick: fn(&Moment) -> f64| moments.iter().map(pick).sum::<f64>() / moments.len().max(1) as f64;
    Moment { v_m_s: of(|m| m.v_m_s), slip: of(|m| m.slip), wetness: of(|m| m.wetness) }
}

fn scene(rig: &Rig, moment: &Moment, background_db: f64) -> Scene {
    Scene {
        rolling: Rolling {
            speed_m_s: moment.v_m_s.max(0.0),
            load_n: rig.load_n,
            creepage: moment.slip.clamp(0.001, 1.0),
            wetness: moment.wetness,
            roughness_db: rig.roughness_db,
            roughness_tilt_db: 0.0,
        },
        surroundings: Surroundings {
            background_db,
            hum_db: background_db - 10.0,
            hiss_db: background_db - 8.0,
            ..Surroundings::default()
        },
    }
}

impl RigListener for &mut EarListener {
    fn pass(&mut self, moment: &Moment) {
        self.piece.push(*moment);
        if self.piece.len() == INSTANTS_A_PIECE {
            self.sound();
        }
    }
}

impl RailListener for &mut EarListener {
    fn dry_probability(&mut self, time_s: f64) -> Option<f64> {
        if self.audio.len() < SAMPLE_RATE_HZ as usize {
            return None;
        }
        let moment = mean(&self.second);
        let window = Window {
            sample_rate_hz: SAMPLE_RATE_HZ,
            samples: &self.audio[..SAMPLE_RATE_HZ as usize],
            speed_m_s: Some(moment.v_m_s),
        };
        let verdict = self.ear.listen(&window);
        self.audio.drain(..SAMPLE_RATE_HZ as usize);
        self.second.clear();
        let (hearing, wet) = (verdict.hearing, verdict.wet);
        self.windows.push(HeardWindow { time_s, hearing, wet, wetness: moment.wetness });
        wet.map(|wet| 1.0 - wet)
    }
}
