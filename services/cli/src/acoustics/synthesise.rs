//! `railgrip acoustics synthesise`: rolling noise as WAV files, one as described or many as training draws them.

use std::path::{Path, PathBuf};

use railgrip_acoustics::synthesis::{
    Rig, Rolling, Scene, Surroundings, Synthesiser, dry_level_db, rig_names,
};
use railgrip_acoustics::{SAMPLE_RATE_HZ, wav};
use railgrip_classifier::Condition;
use railgrip_classifier::dataset::sound;
use railgrip_classifier::recipe::{Circumstances, Noise, Speeds, draw};

use crate::CliError;
use crate::output::say;

/// Make WAV recordings of rolling noise: one recording as described, or with --clips a folder of single seconds as
/// training draws them, sorted into `dry` and `wet`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// WAV file to write; with --clips a folder
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// Rig whose noise is synthesised: bogie, roller, track or traction
    #[arg(long, value_name = "NAME", default_value = "bogie")]
    rig: String,
    /// Condition of the rail: dry or wet; for anything between see --wetness
    #[arg(long, value_name = "WORD", default_value = "dry")]
    condition: String,
    /// Wetness of the rail, 0 dry to 1 a closed film, instead of --condition
    #[arg(long, value_name = "SHARE", conflicts_with = "condition")]
    wetness: Option<f64>,
    /// Speed, m/s [default: the middle of the rig's range]
    #[arg(long, value_name = "M_S")]
    speed: Option<f64>,
    /// Creepage
    #[arg(long, value_name = "SHARE", default_value_t = 0.005)]
    creepage: f64,
    /// Background over the dry rolling noise at that speed, dB
    #[arg(long, value_name = "DB", default_value_t = -25.0, allow_negative_numbers = true)]
    noise_db: f64,
    /// Length, s
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    seconds: f64,
    /// Write so many single seconds of random circumstances instead
    #[arg(long, value_name = "N")]
    clips: Option<usize>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let rig = Rig::named(&args.rig).ok_or_else(|| {
        CliError::bad_input(format!("--rig \"{}\": not known, known are {}", args.rig, rig_names()))
    })?;
    check("--creepage", args.creepage, 0.0..=1.0, "0 to 1")?;
    check("--noise-db", args.noise_db, -100.0..=40.0, "-100 to 40")?;
    check("--seconds", args.seconds, 0.1..=3600.0, "0.1 to 3600")?;
    match args.clips {
        Some(count) => clips(&rig, count, args),
        None => one(rig, args),
    }
}

fn check(
    option: &str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    allowed: &str,
) -> Result<(), CliError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(CliError::bad_input(format!("{option} {value}: allowed is {allowed}")))
}

fn one(rig: Rig, args: &Args) -> Result<(), CliError> {
    let wetness = match (args.wetness, args.condition.as_str()) {
        (Some(wetness), _) => wetness,
        (None, "dry") => 0.0,
        (None, "wet") => 1.0,
        (None, other) => {
            return Err(CliError::bad_input(format!("--condition {other}: allowed is dry or wet")));
        }
    };
    check("--wetness", wetness, 0.0..=1.0, "0 to 1")?;
    let (low, high) = rig.speed_m_s;
    let speed_m_s = args.speed.unwrap_or(0.5 * (low + high));
    check("--speed", speed_m_s, 0.0..=100.0, "0 to 100")?;
    let level_db = dry_level_db(&rig, speed_m_s.max(low)) + args.noise_db;
    let scene = Scene {
        rolling: Rolling {
            speed_m_s,
            load_n: rig.load_n,
            creepage: args.creepage,
            wetness,
            roughness_db: rig.roughness_db,
            roughness_tilt_db: 0.0,
        },
        surroundings: Surroundings {
            background_db: level_db,
            hum_db: level_db - 10.0,
            hiss_db: level_db.min(level_db - args.noise_db - 12.0) - 8.0,
            ..Surroundings::default()
        },
    };
    let mut audio = Vec::new();
    let count = (args.seconds * f64::from(SAMPLE_RATE_HZ)).round() as usize;
    Synthesiser::new(rig, args.seed).render(&scene, count, &mut audio);
    wav::write(&args.out, SAMPLE_RATE_HZ, &audio).map_err(CliError::failed)?;
    say(&format!("wrote {}: {} s at {speed_m_s} m/s, wetness {wetness}", args.out.display(), args.seconds));
    Ok(())
}

fn clips(rig: &Rig, count: usize, args: &Args) -> Result<(), CliError> {
    if !(2..=100_000).contains(&count) {
        return Err(CliError::bad_input(format!("--clips {count}: allowed is 2 to 100000")));
    }
    let circumstances =
        Circumstances { rigs: vec![rig.name], speeds: Speeds::Training, noise: Noise::Training };
    for condition in [Condition::Dry, Condition::Wet] {
        create(&args.out.join(condition.word()))?;
    }
    let mut index = String::from("file,condition,speed_m_s,wetness,background_db\n");
    for (number, recipe) in draw(&circumstances, count, args.seed).iter().enumerate() {
        let name = format!("{}/clip{number:05}.wav", recipe.condition.word());
        wav::write(&args.out.join(&name), SAMPLE_RATE_HZ, &sound(recipe)).map_err(CliError::failed)?;
        let (rolling, surroundings) = (&recipe.scene.rolling, &recipe.scene.surroundings);
        index.push_str(&format!(
            "{name},{},{},{},{}\n",
            recipe.condition.word(),
            rolling.speed_m_s,
            rolling.wetness,
            surroundings.background_db
        ));
    }
    let file = args.out.join("index.csv");
    std::fs::write(&file, index).map_err(|error| CliError::failed(format!("{}: {error}", file.display())))?;
    say(&format!("wrote {count} clips and index.csv to {}", args.out.display()));
    Ok(())
}

fn create(folder: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(folder)
        .map_err(|error| CliError::failed(format!("{}: {error}", folder.display())))
}
