//! `railgrip acoustics train`: a model from synthesised noise or from recordings, judged on what it never heard.

use std::path::{Path, PathBuf};
use std::time::Instant;

use railgrip_acoustics::{SAMPLE_RATE_HZ, wav};
use railgrip_classifier::dataset::{Example, of_recording, synthesise};
use railgrip_classifier::recipe::{Circumstances, HELD_OUT_NOISE_DB, Noise, Speeds, TEST_RIGS, UNHEARD_RIG};
use railgrip_classifier::{Condition, Confusion, Model, ModelError, Training, train, train_from};

use crate::CliError;
use crate::output::{note, say};

/// Train a model and judge it on speeds, noise levels and a rig that it never heard.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Model file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Learn from recordings instead: a folder with WAV files in its folders `dry` and `wet`
    #[arg(long, value_name = "DIR", conflicts_with = "clips")]
    recordings: Option<PathBuf>,
    /// Seconds of noise to synthesise
    #[arg(long, value_name = "N", default_value_t = Training::default().clips)]
    clips: usize,
    /// Passes over the clips
    #[arg(long, value_name = "N", default_value_t = Training::default().epochs)]
    epochs: usize,
    /// Seed of everything random; the same seed makes the same model
    #[arg(long, value_name = "N", default_value_t = Training::default().seed)]
    seed: u64,
    /// Clips of each line of the table; 0: no table
    #[arg(long, value_name = "N", default_value_t = 300)]
    test_clips: usize,
    /// Write the table here as CSV too
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

/// Most clips that are synthesised.
const MOST_CLIPS: usize = 1_000_000;

/// Seed of the clips that judge; training never sees it.
const TEST_SEED: u64 = 0x7465_7374;

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    if !(1..=1000).contains(&args.epochs) {
        return Err(CliError::bad_input(format!("--epochs {}: allowed is 1 to 1000", args.epochs)));
    }
    for (option, given) in [("--clips", args.clips), ("--test-clips", args.test_clips)] {
        if given > MOST_CLIPS {
            return Err(CliError::bad_input(format!("{option} {given}: allowed are at most {MOST_CLIPS}")));
        }
    }
    let training = Training { clips: args.clips, epochs: args.epochs, seed: args.seed };
    let started = Instant::now();
    let progress = |epoch: usize, accuracy: f64| {
        note(&format!(
            "pass {epoch:>3} of {}: {:.1} % right of what was set aside",
            args.epochs,
            100.0 * accuracy
        ));
    };
    let model = match &args.recordings {
        None => {
            note(&format!("synthesising {} clips of one second", args.clips));
            train(&training, progress)
        }
        Some(folder) => {
            train_from(recorded(folder)?, vec![folder.display().to_string()], &training, progress)
        }
    };
    let model = model.map_err(|error| match error {
        ModelError::TooFew { .. } => CliError::bad_input(error),
        _ => CliError::failed(error),
    })?;
    model.save(&args.out).map_err(CliError::failed)?;
    let provenance = model.provenance();
    say(&format!(
        "wrote {}: {} clips, {} passes, seed {}, {:.1} % right of a fifth set aside, {:.0} s",
        args.out.display(),
        provenance.clips,
        provenance.epochs,
        provenance.seed,
        100.0 * provenance.validation_accuracy,
        started.elapsed().as_secs_f64()
    ));
    if args.test_clips > 0 {
        judge(&model, args)?;
    }
    Ok(())
}

/// Seconds of the recordings in `dry` and `wet`.
fn recorded(folder: &Path) -> Result<Vec<Example>, CliError> {
    let mut examples = Vec::new();
    for condition in [Condition::Dry, Condition::Wet] {
        let before = examples.len();
        let place = folder.join(condition.word());
        if !place.is_dir() {
            return Err(CliError::bad_input(format!(
                "{}: no such folder; allowed is a folder with WAV files in its folders `dry` and `wet`",
                place.display()
            )));
        }
        for file in super::files::wav_files(&place)? {
            let recording = wav::read(&file).map_err(CliError::bad_input)?;
            if recording.sample_rate_hz != SAMPLE_RATE_HZ {
                return Err(CliError::bad_input(format!(
                    "{}: sampled at {} Hz, allowed is {SAMPLE_RATE_HZ} Hz; resample it first",
                    file.display(),
                    recording.sample_rate_hz
                )));
            }
            examples.extend(of_recording(&recording.samples, condition));
        }
        if examples.len() == before {
            return Err(CliError::bad_input(format!(
                "{}: no second that is neither silent nor clipped",
                place.display()
            )));
        }
    }
    Ok(examples)
}

/// Confusion on held-out speeds at held-out levels of noise: the rigs of training, and one never heard.
fn judge(model: &Model, args: &Args) -> Result<(), CliError> {
    let mut csv = String::from("rigs,noise_db,dry_dry,dry_wet,wet_dry,wet_wet,accuracy,brier,unfamiliar\n");
    say(&format!(
        "{:<20} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>6} {:>10}",
        "held-out speeds of",
        "noise dB",
        "dry: dry",
        "dry: wet",
        "wet: dry",
        "wet: wet",
        "right",
        "Brier",
        "unfamiliar"
    ));
    let groups = [("rigs of training", TEST_RIGS.to_vec()), ("a rig never heard", vec![UNHEARD_RIG])];
    for (name, rigs) in groups {
        for noise_db in HELD_OUT_NOISE_DB {
            let circumstances =
                Circumstances { rigs: rigs.clone(), speeds: Speeds::HeldOut, noise: Noise::Level(noise_db) };
            let examples = synthesise(&circumstances, args.test_clips, TEST_SEED);
            let c = Confusion::of(model, &examples);
            say(&format!(
                "{name:<20} {noise_db:>8} {:>9} {:>9} {:>9} {:>9} {:>7.1} % {:>6.3} {:>10}",
                c.dry_dry,
                c.dry_wet,
                c.wet_dry,
                c.wet_wet,
                100.0 * c.accuracy(),
                c.brier,
                c.unfamiliar
            ));
            csv.push_str(&format!(
                "{name},{noise_db},{},{},{},{},{},{},{}\n",
                c.dry_dry,
                c.dry_wet,
                c.wet_dry,
                c.wet_wet,
                c.accuracy(),
                c.brier,
                c.unfamiliar
            ));
        }
    }
    if let Some(file) = &args.report {
        std::fs::write(file, csv)
            .map_err(|error| CliError::failed(format!("{}: {error}", file.display())))?;
        say(&format!("wrote {}", file.display()));
    }
    Ok(())
}
