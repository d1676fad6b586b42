//! Microphones: which wagon has one, where its audio comes from, and how it is listened to.

use crate::SettingsError;
use crate::place::ConfigText;
use crate::source::Source;
use railgrip_acoustics::synthesis::{Rig, rig_names};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// How listeners listen.
#[derive(Debug, Clone, PartialEq)]
pub struct AcousticSettings {
    /// File of the model; absent: the one that is part of the program.
    pub model: Option<PathBuf>,
    /// A probability within so much of 0.5 keeps the condition before; 0 as in the paper.
    pub hysteresis: f64,
}

/// One microphone.
#[derive(Debug, Clone, PartialEq)]
pub struct MicrophoneSettings {
    /// The wagon that it hears.
    pub wagon: u32,
    /// Where its audio comes from.
    pub audio: AudioSource,
}

/// Where audio comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum AudioSource {
    /// Synthesised from how the simulated wagon rolls.
    Synthesised {
        /// What it sounds like: the name of a rig.
        rig: &'static str,
        /// Background over the dry rolling noise at half the rig's highest speed, dB.
        noise_db: f64,
        /// Seed of the noise.
        seed: u64,
    },
    /// WAV files, one after the other.
    Recordings {
        /// In the order in which they are heard.
        files: Vec<PathBuf>,
        /// Begin again at the end.
        repeat: bool,
    },
}

#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct AcousticTable {
    /// File of the model by which is listened; without it the one that is part of the program.
    model: Option<String>,
    /// A probability within so much of 0.5 keeps the condition before; 0 as in the paper.
    hysteresis: f64,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MicrophoneTable {
    /// Number of the wagon that it hears; required.
    wagon: u32,
    /// What synthesised noise sounds like: the name of a rig; without it `track`.
    rig: Option<String>,
    /// Background over the dry rolling noise at half the rig's highest speed, dB; without it -25.
    noise_db: Option<f64>,
    /// Seed of the noise; without it 1.
    seed: Option<u64>,
    /// WAV files or globs in place of synthesised noise.
    recordings: Option<Vec<String>>,
    /// Begin the recordings again at the end; without it true.
    #[serde(rename = "loop")]
    repeat: Option<bool>,
}

impl AcousticTable {
    pub(crate) fn check(&self, at: &ConfigText<'_>, base: &Path) -> AcousticSettings {
        AcousticSettings {
            model: self.model.as_ref().map(|file| base.join(file)),
            hysteresis: at.number("acoustics.hysteresis", self.hysteresis, 0.0..=0.49),
        }
    }
}

/// The `[[microphone]]` tables of a train with so many wagons; what is wrong with one is noted.
pub(crate) fn microphones(
    at: &ConfigText<'_>,
    tables: &[MicrophoneTable],
    wagons: u32,
    source: &Source,
    base: &Path,
) -> Vec<MicrophoneSettings> {
    let unsure = ["train", "wagon", "source"].iter().any(|table| at.doubts(table));
    let mut found: Vec<MicrophoneSettings> = Vec::with_capacity(tables.len());
    for (number, table) in (1..).zip(tables) {
        let key = |name: &str| format!("microphone.{number}.{name}");
        if table.wagon == 0 || (table.wagon > wagons && !unsure) {
            at.note(at.refuse(&key("wagon"), table.wagon, format!("1 to {wagons}")));
        }
        if found.iter().any(|other| other.wagon == table.wagon) {
            at.note(at.refuse(&key("wagon"), table.wagon, "a wagon without a microphone so far"));
        }
        let audio = match &table.recordings {
            Some(patterns) => recordings(at, &key, table, patterns, base),
            None if at.doubts("source") => continue,
            None => synthesised(at, &key, table, source),
        };
        match audio {
            Ok(audio) => found.push(MicrophoneSettings { wagon: table.wagon, audio }),
            Err(error) => at.note(error),
        }
    }
    found
}

fn recordings(
    at: &ConfigText<'_>,
    key: &dyn Fn(&str) -> String,
    table: &MicrophoneTable,
    patterns: &[String],
    base: &Path,
) -> Result<AudioSource, SettingsError> {
    let others = [
        ("rig", table.rig.is_some()),
        ("noise_db", table.noise_db.is_some()),
        ("seed", table.seed.is_some()),
    ];
    if let Some((name, _)) = others.into_iter().find(|(_, given)| *given) {
        return Err(at.refuse(&key(name), "given", "nothing here beside `recordings`"));
    }
    let mut files = Vec::new();
    for pattern in patterns {
        let full = base.join(pattern);
        let found = glob::glob(&full.to_string_lossy())
            .map_err(|error| at.refuse(&key("recordings"), pattern, error.msg))?;
        let mut found: Vec<PathBuf> = found.filter_map(Result::ok).filter(|path| path.is_file()).collect();
        if found.is_empty() {
            let allowed = format!("WAV files or globs; {} finds none", full.display());
            return Err(at.refuse(&key("recordings"), format!("{pattern:?}"), allowed));
        }
        found.sort();
        files.append(&mut found);
    }
    if files.is_empty() {
        return Err(at.refuse(&key("recordings"), "empty", "one WAV file or more"));
    }
    Ok(AudioSource::Recordings { files, repeat: table.repeat.unwrap_or(true) })
}

fn synthesised(
    at: &ConfigText<'_>,
    key: &dyn Fn(&str) -> String,
    table: &MicrophoneTable,
    source: &Source,
) -> Result<AudioSource, SettingsError> {
    let rolls = match source {
        Source::Simulate { .. } => true,
        Source::Rig { programme, .. } => programme.plant() == railgrip_filter::PlantKind::Bogie,
        Source::Replay { .. }
        | Source::Stdin
        | Source::Tcp(_)
        | Source::Udp(_)
        | Source::Mqtt(_)
        | Source::Can(_)
        | Source::Trdp(_)
        | Source::External => false,
    };
    if !rolls {
        let allowed = "WAV files; noise is synthesised for a simulated train or bogie rig only";
        return Err(at.refuse(&key("recordings"), "absent", allowed));
    }
    if table.repeat.is_some() {
        return Err(at.refuse(&key("loop"), "given", "nothing here without `recordings`"));
    }
    let name = table.rig.as_deref().unwrap_or("track");
    let noise_db = table.noise_db.unwrap_or(-25.0);
    let noise_db = at.number(&key("noise_db"), noise_db, -100.0..=40.0);
    let rig = Rig::named(name).ok_or_else(|| at.refuse(&key("rig"), format!("{name:?}"), rig_names()))?;
    Ok(AudioSource::Synthesised { rig: rig.name, noise_db, seed: table.seed.unwrap_or(1) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Overrides, TrainSettings};

    fn parse(microphones: &str) -> Result<TrainSettings, SettingsError> {
        // A config that is the default one is given the vehicle and scenario that are built in.
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
        let text = std::fs::read_to_string(&file).expect("the default config");
        TrainSettings::parse(&file, &format!("{text}\n{microphones}"), &Overrides::default())
    }

    #[test]
    fn microphones_are_read() {
        let settings = parse("[[microphone]]\nwagon = 2\nrig = \"bogie\"\n[acoustics]\nhysteresis = 0.1\n");
        let settings = settings.expect("good");
        let audio = AudioSource::Synthesised { rig: "bogie", noise_db: -25.0, seed: 1 };
        assert_eq!(settings.microphones, [MicrophoneSettings { wagon: 2, audio }]);
        assert_eq!(settings.acoustics, AcousticSettings { model: None, hysteresis: 0.1 });
        assert!(settings.microphone(2).is_some() && settings.microphone(1).is_none());
    }

    #[test]
    fn what_is_wrong_with_a_microphone_is_named() {
        for (text, key, allowed) in [
            ("[[microphone]]\nwagon = 9\n", "microphone.1.wagon", "1 to 8"),
            (
                "[[microphone]]\nwagon = 1\n[[microphone]]\nwagon = 1\n",
                "microphone.2.wagon",
                "without a microphone",
            ),
            ("[[microphone]]\nwagon = 1\nrig = \"tram\"\n", "microphone.1.rig", "bogie, roller"),
            ("[[microphone]]\nwagon = 1\nloop = true\n", "microphone.1.loop", "without `recordings`"),
            (
                "[[microphone]]\nwagon = 1\nrecordings = [\"none.wav\"]\n",
                "microphone.1.recordings",
                "finds none",
            ),
            ("[acoustics]\nhysteresis = 0.5\n", "acoustics.hysteresis", "0 to 0.49"),
            ("[acoustics]\nmodell = \"x\"\n", "modell", "unknown field"),
        ] {
            let error = parse(text).expect_err(text).to_string();
            println!("{error}");
            assert!(error.contains(key) && error.contains(allowed), "{error}");
        }
    }
}
