//! Window for window: is this audio fit to be heard, how probable is wet, and what condition is assigned.

use crate::{Condition, Model};
use railgrip_acoustics::{AudioError, AudioState, FeatureExtractor, SAMPLE_RATE_HZ};

/// Speed below which nothing rolls loud enough to be judged, m/s.
const STANDSTILL_M_S: f64 = 0.2;

/// What came of listening to a window. Only [`Hearing::Heard`] comes with a probability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Hearing {
    /// Classified.
    Heard,
    /// Another sample rate than the features are defined for.
    WrongSampleRate,
    /// No sound: the microphone is off or dead.
    SilentMicrophone,
    /// Overdriven.
    Clipped,
    /// Samples that are not finite numbers.
    NotFinite,
    /// Less than a window.
    TooShort,
    /// The vehicle stands: nothing rolls.
    Standstill,
    /// Nothing like it was in training.
    Unfamiliar,
}

impl Hearing {
    /// The name in files and on interfaces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Heard => "heard",
            Self::WrongSampleRate => "wrong_sample_rate",
            Self::SilentMicrophone => "silent_microphone",
            Self::Clipped => "clipped",
            Self::NotFinite => "not_finite",
            Self::TooShort => "too_short",
            Self::Standstill => "standstill",
            Self::Unfamiliar => "unfamiliar",
        }
    }

    /// The words for people.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Heard => "heard",
            Self::WrongSampleRate => "wrong sample rate",
            Self::SilentMicrophone => "silent microphone",
            Self::Clipped => "clipped",
            Self::NotFinite => "not finite",
            Self::TooShort => "too short",
            Self::Standstill => "standstill",
            Self::Unfamiliar => "unfamiliar",
        }
    }
}

/// One second of audio.
#[derive(Clone, Copy, Debug)]
pub struct Window<'a> {
    /// Samples a second.
    pub sample_rate_hz: u32,
    /// Samples, full scale ±1.
    pub samples: &'a [f32],
    /// Speed of the vehicle, m/s, if known.
    pub speed_m_s: Option<f64>,
}

/// What is said about a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Whether it could be heard.
    pub hearing: Hearing,
    /// Probability of wet; absent unless heard.
    pub wet: Option<f64>,
    /// Condition assigned, with hysteresis; absent unless heard, and while no window has decided.
    pub condition: Option<Condition>,
}

/// Keeps the condition until the probability of another one exceeds a half.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hysteresis {
    band: f64,
    last: Option<Condition>,
}

impl Hysteresis {
    /// A probability within `band` of 0.5 keeps the last condition; with 0, as in the paper, exactly 0.5 does.
    pub const fn new(band: f64) -> Self {
        Self { band, last: None }
    }

    /// Takes a probability of wet; gives the condition assigned, none while nothing has decided.
    pub fn assign(&mut self, wet: f64) -> Option<Condition> {
        if wet > 0.5 + self.band {
            self.last = Some(Condition::Wet);
        } else if wet < 0.5 - self.band {
            self.last = Some(Condition::Dry);
        }
        self.last
    }

    /// The condition assigned last.
    pub const fn last(&self) -> Option<Condition> {
        self.last
    }
}

/// Listens.
pub struct Ear {
    model: Model,
    extractor: FeatureExtractor,
    hysteresis: Hysteresis,
}

impl Ear {
    /// An ear with that model; see [`Hysteresis::new`] for `band`.
    ///
    /// # Errors
    /// Never with the sample rate that models have.
    pub fn new(model: Model, band: f64) -> Result<Self, AudioError> {
        let extractor = FeatureExtractor::new(SAMPLE_RATE_HZ)?;
        Ok(Self { model, extractor, hysteresis: Hysteresis::new(band) })
    }

    /// Listens to a window. What cannot be heard changes no condition.
    pub fn listen(&mut self, window: &Window<'_>) -> Verdict {
        let (hearing, wet) = self.hear(window);
        let condition = wet.and_then(|wet| self.hysteresis.assign(wet));
        Verdict { hearing, wet, condition }
    }

    fn hear(&self, window: &Window<'_>) -> (Hearing, Option<f64>) {
        let no = |hearing| (hearing, None);
        if window.sample_rate_hz != SAMPLE_RATE_HZ {
            return no(Hearing::WrongSampleRate);
        }
        if window.samples.len() < SAMPLE_RATE_HZ as usize {
            return no(Hearing::TooShort);
        }
        let features = match self.extractor.extract(window.samples) {
            Ok((_, AudioState::Silent)) => return no(Hearing::SilentMicrophone),
            Ok((_, AudioState::Clipped)) => return no(Hearing::Clipped),
            Ok((features, AudioState::Good)) => features,
            Err(AudioError::SampleRate { .. }) => return no(Hearing::WrongSampleRate),
            Err(AudioError::TooShort { .. }) => return no(Hearing::TooShort),
            Err(AudioError::NotFinite { .. }) => return no(Hearing::NotFinite),
        };
        if window.speed_m_s.is_some_and(|speed| speed.abs() < STANDSTILL_M_S) {
            return no(Hearing::Standstill);
        }
        if !self.model.is_familiar(&features) {
            return no(Hearing::Unfamiliar);
        }
        (Hearing::Heard, self.model.wet_probabilities(&[features]).first().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exactly_a_half_keeps_the_condition_before() {
        let mut hysteresis = Hysteresis::new(0.0);
        assert_eq!(hysteresis.assign(0.5), None);
        let said = [0.2, 0.5, 0.51, 0.5, 0.49].map(|wet| hysteresis.assign(wet));
        use Condition::{Dry, Wet};
        assert_eq!(said, [Some(Dry), Some(Dry), Some(Wet), Some(Wet), Some(Dry)]);
        let mut wide = Hysteresis::new(0.1);
        assert_eq!(
            [0.9, 0.45, 0.41, 0.39].map(|wet| wide.assign(wet)),
            [Some(Wet), Some(Wet), Some(Wet), Some(Dry)]
        );
    }
}
