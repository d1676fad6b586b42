//! Which of the kept recordings of mismatches belong to an alert.

use super::model::Alert;
use std::path::{Path, PathBuf};

/// A recording is begun at most this time before its alert is raised, s.
const BEFORE_S: i64 = 600;

/// The recordings that estimators keep: a folder each, `wagon-N-S` of the wagon at place N, begun at the Unix second S.
#[derive(Debug, Clone, Default)]
pub(super) struct Recordings {
    /// Where they lie.
    pub folder: PathBuf,
    /// When the train was started, Unix s, where that is known: whatever was kept before may be of another wagon in that place.
    pub started_s: Option<i64>,
}

impl Recordings {
    /// Those of the wagon of an alert around its time, the latest first.
    pub fn of(&self, alert: &Alert) -> Vec<PathBuf> {
        // Its vehicle has left the train; another one may run there.
        if alert.wagon > 0 && alert.wagons.is_empty() {
            return Vec::new();
        }
        let at_s = alert.unix_ns.div_euclid(1_000_000_000);
        // One of another day explains nothing of today.
        let from_s = self.started_s.unwrap_or(i64::MIN).max(at_s.saturating_sub(BEFORE_S));
        let to_s = if alert.active { i64::MAX } else { at_s };
        let prefix = format!("wagon-{}-", alert.wagon);
        let folders = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let begun = |path: &Path| path.file_name()?.to_str()?.strip_prefix(&prefix)?.parse::<i64>().ok();
        let of_wagon = folders.filter_map(|folder| Some((begun(&folder.path())?, folder.path())));
        let mut own: Vec<_> = of_wagon.filter(|(begun_s, _)| (from_s..=to_s).contains(begun_s)).collect();
        own.sort();
        own.into_iter().rev().map(|(_, path)| path).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]
mod tests {
    use super::super::model::Scope;
    use super::*;
    use railgrip_messages::Stamp;

    const NOW_S: i64 = 1_772_366_400;

    fn alert(wagon: u32) -> Alert {
        let now = Stamp { unix_ns: NOW_S * 1_000_000_000, monotonic_ns: 1 };
        let mut alert = Alert::new(1, "model_mismatch", Scope::Wagon, "look", Vec::new(), now);
        (alert.wagon, alert.wagons) = (wagon, vec![wagon]);
        alert
    }

    /// Names of those found in a folder that holds these.
    fn found(recordings: &Recordings, alert: &Alert) -> Vec<String> {
        let name = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
        recordings.of(alert).iter().map(name).collect()
    }

    /// Recordings of an earlier start once explained an alert of whoever runs in that place now, and what was found today an alert
    /// that was over long ago.
    #[test]
    fn a_recording_belongs_to_the_wagon_and_the_time_of_its_alert() {
        let folder = tempfile::tempdir().unwrap();
        for (wagon, after_s) in [(3, -700), (3, -300), (3, -100), (3, 50), (30, -10), (4, -10)] {
            std::fs::create_dir(folder.path().join(format!("wagon-{wagon}-{}", NOW_S + after_s))).unwrap();
        }
        std::fs::create_dir(folder.path().join("wagon-3-of-somebody")).unwrap();
        let mut recordings = Recordings { folder: folder.path().to_owned(), started_s: None };
        let named = |all: &[i64]| all.iter().map(|s| format!("wagon-3-{}", NOW_S + s)).collect::<Vec<_>>();
        let mut alert = alert(3);
        assert_eq!(found(&recordings, &alert), named(&[50, -100, -300]));
        recordings.started_s = Some(NOW_S - 200);
        assert_eq!(found(&recordings, &alert), named(&[50, -100]), "since the train was started");
        alert.active = false;
        assert_eq!(found(&recordings, &alert), named(&[-100]), "it was over by then");
        (alert.active, alert.wagons) = (true, Vec::new());
        assert_eq!(found(&recordings, &alert), named(&[]), "the vehicle has left the train");
    }

    /// A recording that an alert names is its own, however long ago it was begun and wherever its vehicle runs now.
    #[test]
    fn what_was_found_in_its_own_recording_is_joined_later() {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join(format!("wagon-7-{}", NOW_S - 5000));
        std::fs::create_dir(&own).unwrap();
        let recordings = Recordings { folder: folder.path().to_owned(), started_s: Some(NOW_S - 200) };
        let mut alert = alert(3);
        alert.evidence.recording = Some(own.display().to_string());
        assert!(!alert.find_diagnosis(&recordings), "nothing was found yet");
        let answer = r#"{"verdict": "none", "words": "nothing", "term": null, "effects": [], "lacks": [], "has_page": false, "seconds": 1.0}"#;
        std::fs::write(own.join(super::super::diagnosis::ANSWER), answer).unwrap();
        assert!(alert.find_diagnosis(&recordings));
        assert_eq!(alert.evidence.diagnosis.unwrap().recording, own.display().to_string());
    }
}
