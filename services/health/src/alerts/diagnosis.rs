//! What the diagnosis of a kept recording found, as `railgrip diagnoser` leaves it beside the recording.

use serde::{Deserialize, Serialize};
use std::path::Path;
use utoipa::ToSchema;

/// File with the answer in the folder of a recording.
pub const ANSWER: &str = "answer.json";
/// File with the report for people there.
pub const PAGE: &str = "report.html";
/// Longer answers are nobody's.
const MOST_BYTES: u64 = 64 << 10;
/// A page is shown up to this size.
const MOST_PAGE_BYTES: u64 = 16 << 20;

/// An effect that was named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Named {
    /// Its id, as `railgrip gap effects` lists it.
    pub id: String,
    /// Probability that it is at work.
    pub confidence: f64,
}

/// What a diagnosis found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Diagnosis {
    /// `none`, `effects`, `unknown` or `effects+unknown`; `too_poor`, `refused` or `given_up` where there is no finding.
    pub verdict: String,
    /// What was found, in one sentence.
    pub words: String,
    /// The term of the equations in which the gap lies.
    pub term: Option<String>,
    /// Effects that were named, the strongest first.
    pub effects: Vec<Named>,
    /// What the recording does not show, so that it could not be found.
    pub lacks: Vec<String>,
    /// Whether there is a report for people.
    pub has_page: bool,
    /// What it took, s.
    pub seconds: f64,
    /// Folder of the recording.
    #[serde(default)]
    pub recording: String,
}

/// The answer that lies beside a recording, if there is one that can be read.
pub(super) fn read(recording: &Path) -> Option<Diagnosis> {
    let file = recording.join(ANSWER);
    let length = file.metadata().ok()?.len();
    if length > MOST_BYTES {
        return None;
    }
    let text = std::fs::read_to_string(&file).ok()?;
    let answer: Diagnosis = serde_json::from_str(&text)
        .inspect_err(|error| tracing::warn!(file = %file.display(), %error, "no answer of a diagnosis"))
        .ok()?;
    let sensible = answer.effects.iter().all(|effect| (0.0..=1.0).contains(&effect.confidence));
    sensible.then(|| Diagnosis { recording: recording.display().to_string(), ..answer })
}

/// The report for people beside a recording.
pub(super) fn page(recording: &Path) -> Option<String> {
    let file = recording.join(PAGE);
    let small = file.metadata().ok()?.len() <= MOST_PAGE_BYTES;
    small.then(|| std::fs::read_to_string(&file).ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_read_and_nonsense_is_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |text: &str| std::fs::write(folder.path().join(ANSWER), text).expect("written");
        assert_eq!(read(folder.path()), None);
        let answer = Diagnosis {
            verdict: "effects".into(),
            words: "The brake answers late.".into(),
            term: Some("brake_actuation".into()),
            effects: vec![Named { id: "brake_lag".into(), confidence: 0.9 }],
            lacks: Vec::new(),
            has_page: true,
            seconds: 30.0,
            recording: folder.path().display().to_string(),
        };
        let text = serde_json::to_string(&answer).expect("JSON");
        write(&text);
        assert_eq!(read(folder.path()), Some(answer));
        write(&text.replace("0.9", "9.0"));
        assert_eq!(read(folder.path()), None, "a probability above one");
        write(&text[..text.len() / 2]);
        assert_eq!(read(folder.path()), None, "half an answer");
        write(&format!("{{\"verdict\": \"{}\"}}", "x".repeat(100_000)));
        assert_eq!(read(folder.path()), None, "too long");
    }
}
