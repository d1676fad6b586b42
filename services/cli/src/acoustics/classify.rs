//! `railgrip acoustics classify`: window for window, what is heard in recordings.

use std::path::{Path, PathBuf};

use railgrip_acoustics::wav;
use railgrip_classifier::{Ear, Verdict, Window};

use crate::CliError;
use crate::output::{apart, note, say};

/// Tell for every second of WAV recordings whether the rail is dry or wet.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// WAV files, or folders of them
    #[arg(required = true, value_name = "WAV")]
    recordings: Vec<PathBuf>,
    /// Model to use [default: the built-in one]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Speed of the vehicle, m/s; below 0.2 m/s nothing is judged
    #[arg(long, value_name = "M_S")]
    speed: Option<f64>,
    /// Keep the condition before while the probability is this close to 0.5; 0 as in the paper
    #[arg(long, value_name = "BAND", default_value_t = 0.0)]
    hysteresis: f64,
    /// Write CSV here instead of a table to the standard output
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    out: Option<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// One window.
#[derive(Debug, serde::Serialize)]
struct Line {
    file: String,
    /// Time at which the window begins, s.
    t_s: f64,
    /// Name of the state.
    state: &'static str,
    wet_probability: Option<f64>,
    condition: Option<&'static str>,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    if !(0.0..0.5).contains(&args.hysteresis) {
        return Err(CliError::bad_input(format!(
            "--hysteresis {}: allowed is 0 up to below 0.5",
            args.hysteresis
        )));
    }
    if args.speed.is_some_and(|speed| !speed.is_finite()) {
        return Err(CliError::bad_input("--speed: allowed is a finite number, m/s"));
    }
    let mut read: Vec<&Path> = args.recordings.iter().map(PathBuf::as_path).collect();
    read.extend(args.model.as_deref());
    apart(&[("--out", args.out.as_deref())], &read)?;
    let model = super::files::model(args.model.as_deref())?;
    let mut lines = Vec::new();
    for given in &args.recordings {
        for file in super::files::wav_files(given)? {
            // A new recording has no condition before.
            let mut ear = Ear::new(model.clone(), args.hysteresis).map_err(CliError::failed)?;
            classify(&file, &mut ear, args.speed, &mut lines)?;
        }
    }
    show(args, &lines)?;
    if lines.iter().all(|line| line.wet_probability.is_none()) {
        let state = lines.first().map_or("no window", |line| line.state);
        return Err(CliError::bad_input(format!("nothing could be judged ({state})")));
    }
    Ok(())
}

fn classify(
    file: &Path,
    ear: &mut Ear,
    speed_m_s: Option<f64>,
    lines: &mut Vec<Line>,
) -> Result<(), CliError> {
    let recording = wav::read(file).map_err(CliError::bad_input)?;
    let sample_rate_hz = recording.sample_rate_hz;
    if sample_rate_hz != railgrip_acoustics::SAMPLE_RATE_HZ {
        let expected = railgrip_acoustics::SAMPLE_RATE_HZ;
        note(&format!("{}: sampled at {sample_rate_hz} Hz; resample it to {expected} Hz", file.display()));
    }
    let second = (sample_rate_hz as usize).max(1);
    let whole = (recording.samples.len() / second).max(1);
    for (number, samples) in recording.samples.chunks(second).take(whole).enumerate() {
        let window = Window { sample_rate_hz, samples, speed_m_s };
        let Verdict { hearing, wet, condition } = ear.listen(&window);
        lines.push(Line {
            file: file.display().to_string(),
            t_s: number as f64,
            state: hearing.name(),
            wet_probability: wet,
            condition: condition.map(railgrip_classifier::Condition::word),
        });
    }
    Ok(())
}

fn show(args: &Args, lines: &[Line]) -> Result<(), CliError> {
    if args.json {
        say(&serde_json::to_string_pretty(lines).map_err(CliError::failed)?);
        return Ok(());
    }
    let probability = |line: &Line| line.wet_probability.map(|wet| format!("{wet:.4}")).unwrap_or_default();
    if let Some(out) = &args.out {
        let mut text = String::from("file,t_s,state,wet_probability,condition\n");
        for line in lines {
            let condition = line.condition.unwrap_or_default();
            text.push_str(&format!(
                "{},{},{},{},{condition}\n",
                quoted(&line.file),
                line.t_s,
                line.state,
                probability(line)
            ));
        }
        return std::fs::write(out, text)
            .map_err(|error| CliError::failed(format!("{}: {error}", out.display())));
    }
    say(&format!("{:>7} {:<18} {:>7} {:<9}  file", "t s", "state", "wet", "condition"));
    for line in lines {
        let condition = line.condition.unwrap_or("-");
        say(&format!(
            "{:>7} {:<18} {:>7} {condition:<9}  {}",
            line.t_s,
            line.state,
            probability(line),
            line.file
        ));
    }
    Ok(())
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
