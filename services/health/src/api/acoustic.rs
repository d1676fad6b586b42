//! What a microphone heard, as the API says it.

use crate::api::figure::rounded;
use crate::api::grade::Condition;
use crate::time::rfc3339;
use railgrip_messages::{Condition as Code, Heard};
use serde::Serialize;
use utoipa::ToSchema;

/// What the microphone of a wagon hears, window by window of one second. Advice only: nothing drives a brake.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct AcousticView {
    /// `heard`, or why there is no probability: `starting`, `no_audio`, `silent_microphone`, `clipped`,
    /// `wrong_sample_rate`, `not_finite`, `too_short`, `standstill`, `unfamiliar`; `silent` if its listener is.
    pub state: String,
    /// Age of the last window, s; `null` before the first.
    pub age_s: Option<f64>,
    /// When its last sample was taken, RFC 3339.
    pub acquired_at: Option<String>,
    /// Probability that the rail is wet; `null` unless `heard`.
    pub wet_probability: Option<f64>,
    /// Condition assigned; `null` unless `heard`.
    pub condition: Option<Condition>,
    /// Level under full scale, dB.
    pub level_db: Option<f64>,
    /// Blocks of audio that never arrived.
    pub missed: u64,
    /// What the decision-maker makes of it with slip and adhesion as measured; `null` while they say nothing.
    pub decision: Option<DecisionView>,
}

/// Heard condition set beside measured slip and adhesion (Shrestha et al., section 3.3).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct DecisionView {
    /// Condition to go by.
    pub condition: Option<Condition>,
    /// True if curve and measurement differ by more than 0.2, so that the decision before stands.
    pub kept: bool,
    /// Adhesion to go by.
    pub adhesion: f64,
    /// Slip at which the curve of that condition peaks at this speed.
    pub optimum_slip: f64,
    /// Adhesion there.
    pub optimum_adhesion: f64,
}
/// The view of a wagon's microphone; what is older than `stale_after_s` beyond its second says nothing about the present.
pub(crate) fn acoustic(heard: Option<&Heard>, now_ns: u64, stale_after_s: f64) -> AcousticView {
    let nothing = AcousticView {
        state: "silent".to_owned(),
        age_s: None,
        acquired_at: None,
        wet_probability: None,
        condition: None,
        level_db: None,
        missed: 0,
        decision: None,
    };
    let Some(heard) = heard else { return nothing };
    let age_s = heard.acquired.age_s(now_ns);
    let seen = AcousticView {
        age_s: Some((age_s * 1000.0).round() / 1000.0),
        acquired_at: Some(rfc3339(heard.acquired.unix_ns)),
        missed: heard.missed,
        ..nothing
    };
    if age_s > stale_after_s + 1.0 {
        return seen;
    }
    AcousticView {
        state: heard
            .state()
            .map_or_else(|| format!("state {}", heard.state), |state| state.word().to_owned()),
        wet_probability: heard.wet().map(rounded),
        condition: heard.condition().map(Condition::from),
        level_db: (heard.sample_rate_hz > 0).then(|| rounded(heard.level_db)),
        decision: decided(heard).then(|| DecisionView {
            condition: Code::from_code(heard.decided_condition).map(Condition::from),
            kept: heard.kept != 0,
            adhesion: rounded(heard.decided_adhesion),
            optimum_slip: rounded(heard.optimum_slip),
            optimum_adhesion: rounded(heard.optimum_adhesion),
        }),
        ..seen
    }
}

/// True if there is a decision, and every figure of it is known.
fn decided(heard: &Heard) -> bool {
    let figures = [heard.decided_adhesion, heard.optimum_slip, heard.optimum_adhesion];
    heard.decided != 0 && figures.iter().all(|figure| figure.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::{HearingState, Stamp};

    #[test]
    fn a_figure_needs_a_fresh_window_that_was_heard() {
        let second = 1_000_000_000;
        let acquired = Stamp { unix_ns: 0, monotonic_ns: 10 * second };
        let heard = Heard {
            acquired,
            state: HearingState::Heard.code(),
            known: 1,
            wet_probability: 0.9,
            condition: Code::Wet.code(),
            ..Heard::default()
        };
        let fresh = acoustic(Some(&heard), 11 * second, 2.0);
        assert_eq!((fresh.state.as_str(), fresh.wet_probability), ("heard", Some(0.9)));
        assert_eq!(fresh.condition, Some(Condition::Wet));
        let stale = acoustic(Some(&heard), 14 * second, 2.0);
        assert_eq!((stale.state.as_str(), stale.wet_probability, stale.age_s), ("silent", None, Some(4.0)));
        let state = HearingState::SilentMicrophone.code();
        let dead = Heard { state, known: 0, condition: u32::MAX, ..heard };
        let dead = acoustic(Some(&dead), 11 * second, 2.0);
        assert_eq!(
            (dead.state.as_str(), dead.wet_probability, dead.condition),
            ("silent_microphone", None, None)
        );
        assert_eq!(acoustic(None, 0, 2.0).state, "silent");
    }
}
