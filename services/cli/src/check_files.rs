//! Files that a config names and that a train opens only once it runs: each is opened and read now.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use railgrip_acoustics::wav;
use railgrip_diagnosis::data::units;
use railgrip_fieldbus::dbc;
use railgrip_filter::PlantKind;
use railgrip_mqtt::Authorities;
use railgrip_recording::{BogieRecording, MotorRecording, Recording, Strictness};
use railgrip_settings::{
    AudioSource, BrokerTls, ReceiverWay, ReplayRun, Source, TrainSettings, WagonSettings,
};
use socketcan::Frame;

/// Lines of a CAN log that are looked at: enough to see that it is one.
const LINES: usize = 100_000;
/// A secret is no longer than this, bytes.
const LONGEST_SECRET: u64 = 64 << 10;

/// What is wrong with them, each with the key that names the file.
pub(crate) fn wrong(settings: &TrainSettings) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut look = |key: &str, result: Result<(), String>| {
        if let Err(problem) = result {
            found.push((key.to_owned(), problem));
        }
    };
    match &settings.source {
        Source::Replay { runs, .. } => {
            for wagon in &settings.wagons {
                let Some(run) = runs.get(wagon.number as usize - 1) else { continue };
                look("source.runs", recording(run, wagon, settings));
            }
        }
        Source::Can(source) => {
            if let Some(log) = &source.log {
                look("source.file", can_log(&log.file, &source.messages.plan.keys()));
            }
        }
        Source::Mqtt(broker) => {
            look("source.password_file", secret(broker.password_file.as_deref()));
            look("source.ca_file", authorities(broker.tls.as_ref()));
        }
        _ => {}
    }
    for (number, receiver) in (1..).zip(&settings.notify.receivers) {
        let key = |name: &str| format!("receiver.{number}.{name}");
        match &receiver.way {
            ReceiverWay::Webhook(webhook) => {
                look(&key("token_file"), secret(webhook.token_file.as_deref()));
            }
            ReceiverWay::Mqtt(broker) => {
                look(&key("password_file"), secret(broker.password_file.as_deref()));
                look(&key("ca_file"), authorities(broker.tls.as_ref()));
            }
        }
    }
    for (number, microphone) in (1..).zip(&settings.microphones) {
        if let AudioSource::Recordings { files, .. } = &microphone.audio {
            for file in files {
                let read = wav::read(file).map(|_| ()).map_err(|error| error.to_string());
                look(&format!("microphone.{number}.recordings"), read);
            }
        }
    }
    if settings.acoustics.model.is_some() {
        look("acoustics.model", railgrip_listener::model(settings).map(|_| ()).map_err(|e| e.to_string()));
    }
    found
}

/// A recording as a replay reads it.
fn recording(run: &ReplayRun, wagon: &WagonSettings, settings: &TrainSettings) -> Result<(), String> {
    let (kind, wheelsets, vehicle) = (wagon.plant.kind(), wagon.plant.wheelsets(), &wagon.vehicle);
    let said = |error: railgrip_recording::RecordingError| error.to_string();
    match kind {
        PlantKind::Traction => {
            MotorRecording::read(&run.path, Strictness::Tolerant).map(|_| ()).map_err(said)
        }
        PlantKind::Bogie => BogieRecording::read(&run.path, Strictness::Tolerant).map(|_| ()).map_err(said),
        PlantKind::Wagon | PlantKind::Roller => {
            let read = Recording::read_mapped(&run.path, &settings.mapping, Strictness::Tolerant);
            let read = read.map_err(said)?;
            let found = read.wheelsets;
            if found != wheelsets {
                return Err(format!(
                    "{} has {found} wheelsets, its vehicle file {wheelsets}",
                    run.path.display()
                ));
            }
            match kind {
                PlantKind::Wagon => units::check(&read, vehicle)
                    .map_err(|error| format!("{}, at {:.2} s, {error}", run.path.display(), error.t_s)),
                _ => Ok(()),
            }
        }
    }
}

/// A log in the form of `candump -L`, of which the beginning is read: it must hold a frame that is wanted.
fn can_log(file: &Path, wanted: &[u32]) -> Result<(), String> {
    let said = |problem: String| format!("{}: {problem}", file.display());
    // Opening a pipe would wait for whoever fills it.
    match std::fs::metadata(file).map_err(|error| said(error.to_string()))?.file_type() {
        kind if kind.is_dir() => return Err(said("is a folder".to_owned())),
        kind if !kind.is_file() => return Ok(()),
        _ => {}
    }
    let open = File::open(file).map_err(|error| said(error.to_string()))?;
    let mut reader = socketcan::dump::Reader::from_reader(BufReader::new(open));
    let mut others = 0_usize;
    for _ in 0..LINES {
        match reader.next_record() {
            Ok(Some(record)) if wanted.contains(&dbc::key_of(record.frame.id_word())) => return Ok(()),
            Ok(Some(_)) => others += 1,
            Ok(None) if others == 0 => {
                return Err(said("holds no frame in the form of `candump -L`".to_owned()));
            }
            Ok(None) => break,
            Err(_) => {}
        }
    }
    if others > 0 {
        let problem =
            format!("none of its first {others} frames has an identifier that the mapping asks for");
        return Err(said(problem));
    }
    Err(said(format!("none of its first {LINES} lines is a frame in the form of `candump -L`")))
}

fn secret(file: Option<&Path>) -> Result<(), String> {
    let Some(file) = file else { return Ok(()) };
    let said = |problem: &str| format!("{}: {problem}", file.display());
    let size = std::fs::metadata(file).map_err(|error| said(&error.to_string()))?.len();
    if size > LONGEST_SECRET {
        return Err(said("too long for a secret"));
    }
    let text = std::fs::read_to_string(file).map_err(|error| said(&error.to_string()))?;
    if text.trim().is_empty() { Err(said("is empty")) } else { Ok(()) }
}

fn authorities(tls: Option<&BrokerTls>) -> Result<(), String> {
    let Some(file) = tls.and_then(|tls| tls.ca_file.as_deref()) else { return Ok(()) };
    Authorities::File(file).check().map_err(|error| error.to_string())
}
