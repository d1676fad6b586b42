//! `railgrip gap`: why a simulator and recordings disagree.

use std::path::{Path, PathBuf};

use railgrip_diagnosis::answer::schema::Report;
use railgrip_diagnosis::answer::supplement::Detail;
use railgrip_diagnosis::html;
use railgrip_diagnosis::law_bench::{self, LawCaseError};
use railgrip_diagnosis::wagon;
use railgrip_diagnosis::words;
use railgrip_diagnosis::write::predictions;
use railgrip_vehicle::VehicleParameters;
use railgrip_vehicle::effects::{self, EffectSpec};
use railgrip_words::speak;
use serde_json::{Value, json};

use crate::gap_shared::{LanguageArgs, SearchArgs, name_of, version, write};
use crate::output::{apart, say};
use crate::{CliError, blind, gap_calibrate, gap_compare, gap_plan, gap_prepare, gap_settle};

/// Diagnose the gap between simulator and recordings.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Say where the gap of a case lies, which effect causes it, and how far it shrinks
    Diagnose(DiagnoseArgs),
    /// Design the run that would best tell apart what a diagnosis leaves open
    Plan(gap_plan::Args),
    /// Say what a test run makes of what a diagnosis leaves open
    Settle(gap_settle::Args),
    /// Compare two reports of one vehicle: what is new, what is gone, what has changed
    Compare(gap_compare::Args),
    /// Make runs of a case out of recordings as they are: regular rate, cut at gaps, columns mapped
    Prepare(gap_prepare::Args),
    /// List the effects that can be found
    Effects(EffectsArgs),
    /// Learn from simulated cases how probable findings are
    Calibrate(gap_calibrate::Args),
    /// Score the diagnosis on simulated cases whose effect is withheld
    Blind(blind::Args),
}

#[derive(Debug, clap::Args)]
struct DiagnoseArgs {
    /// Folder with vehicle.toml (or bench.toml), fit/ and holdout/
    #[arg(value_name = "CASE")]
    case: PathBuf,
    /// Where the report goes, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Where the report goes, as one self-contained page
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Folder for what the models predict of each holdout run
    #[arg(long, value_name = "DIR")]
    predictions: Option<PathBuf>,
    /// Where the vehicle goes with the effects found in it
    #[arg(long, value_name = "FILE")]
    apply: Option<PathBuf>,
    /// Vehicle onto which a law-level case is applied [default: vehicle.toml of the case, else the built-in vehicle]
    #[arg(long, value_name = "FILE", requires = "apply")]
    onto: Option<PathBuf>,
    #[command(flatten)]
    search: SearchArgs,
    #[command(flatten)]
    language: LanguageArgs,
}

#[derive(Debug, clap::Args)]
struct EffectsArgs {
    /// For programs
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Diagnose(args) => diagnose(args),
        Command::Prepare(args) => gap_prepare::run(args),
        Command::Plan(args) => gap_plan::run(args),
        Command::Settle(args) => gap_settle::run(args),
        Command::Compare(args) => gap_compare::run(args),
        Command::Effects(args) => {
            list_effects(args);
            Ok(())
        }
        Command::Calibrate(args) => gap_calibrate::run(args),
        Command::Blind(args) => blind::run(args),
    }
}

/// What a diagnosis of either kind leaves to write.
struct Answer {
    report: Report,
    detail: Detail,
    predictions: Vec<(String, railgrip_recording::Table)>,
    vehicle: VehicleParameters,
}

/// The vehicle of `config/vehicle.toml`, for law-level cases that come without one.
const DEFAULT_VEHICLE: &str = include_str!("../../../config/vehicle.toml");

fn diagnose(args: &DiagnoseArgs) -> Result<(), CliError> {
    if !args.case.is_dir() {
        return Err(CliError::bad_input(format!("{}: no such folder", args.case.display())));
    }
    let case = |name: &str| args.case.join(name);
    let read = [case("vehicle.toml"), case("bench.toml"), case("fit"), case("holdout")];
    let mut read: Vec<&Path> = read.iter().map(PathBuf::as_path).collect();
    read.extend(args.onto.as_deref());
    let written = [
        ("--json", args.json.as_deref()),
        ("--html", args.html.as_deref()),
        ("--apply", args.apply.as_deref()),
    ];
    apart(&written, &read)?;
    let language = args.language.chosen();
    let answer = if law_bench::is_law_case(&args.case) { of_law_case(args)? } else { of_wagon(args)? };
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&answer.report).map_err(CliError::failed)?;
        write(path, &(text + "\n"))?;
    }
    if let Some(path) = &args.html {
        write(path, &speak(language, || html::render(&answer.report, &answer.detail)))?;
    }
    if let Some(folder) = &args.predictions {
        std::fs::create_dir_all(folder)
            .map_err(|e| CliError::failed(format!("{}: {e}", folder.display())))?;
        predictions::write(&answer.predictions, folder).map_err(CliError::failed)?;
    }
    if let Some(path) = &args.apply {
        write(path, &toml::to_string(&answer.vehicle).map_err(CliError::failed)?)?;
    }
    say(&speak(language, || words::summary(&answer.report, &answer.detail)));
    Ok(())
}

fn of_wagon(args: &DiagnoseArgs) -> Result<Answer, CliError> {
    let case = args.search.read(&args.case)?;
    let options = args.search.options(&args.case, command(args));
    let outcome = args.search.run(|step| wagon::diagnose(&case, &options, step))?;
    Ok(Answer {
        report: outcome.report,
        detail: outcome.detail,
        predictions: outcome.predictions,
        vehicle: outcome.vehicle,
    })
}

fn of_law_case(args: &DiagnoseArgs) -> Result<Answer, CliError> {
    let options = law_bench::Options {
        without: args.search.without.clone(),
        seed: args.search.seed,
        version: version(),
        command: command(args),
    };
    let vehicle = law_case_vehicle(args)?;
    let outcome = law_bench::diagnose(&args.case, &options)
        .map_err(|error: LawCaseError| CliError::bad_input(error))?;
    let applied = outcome.applied.onto(&vehicle);
    if args.apply.is_some() {
        applied.check().map_err(CliError::failed)?;
        for why in &outcome.applied.left_out {
            tracing::warn!("not in the vehicle: {why}");
        }
    }
    Ok(Answer {
        report: outcome.report,
        detail: outcome.detail,
        predictions: outcome.predictions,
        vehicle: applied,
    })
}

/// The vehicle onto which a law-level case is applied.
fn law_case_vehicle(args: &DiagnoseArgs) -> Result<VehicleParameters, CliError> {
    let beside = Some(args.case.join("vehicle.toml")).filter(|path| path.is_file());
    let vehicle = match args.onto.clone().or(beside) {
        Some(path) => railgrip_settings::vehicle::load(&path),
        None => railgrip_settings::vehicle::parse(Path::new("built-in vehicle"), DEFAULT_VEHICLE),
    };
    vehicle.map_err(CliError::bad_input)
}

fn command(args: &DiagnoseArgs) -> String {
    let without: String = args.search.without.iter().map(|id| format!(" --without {id}")).collect();
    format!("railgrip gap diagnose {} --seed {}{without}", name_of(&args.case), args.search.seed)
}

fn list_effects(args: &EffectsArgs) {
    if args.json {
        let all: Vec<Value> = effects::all().iter().map(|(spec, _)| entry(spec)).collect();
        say(&serde_json::to_string_pretty(&all).unwrap_or_default());
        return;
    }
    for (spec, _) in effects::all() {
        say(&format!("{}  ({})\n    {}", spec.id, spec.term.name(), spec.equation));
        for p in spec.parameters {
            say(&format!("    {:<26} {:>10} to {:<10} {}", p.name, p.lower, p.upper, p.unit));
        }
        say(&format!("    source: {}", spec.source));
        if !spec.twins.is_empty() {
            say(&format!("    twins: {}; separated by {}", twins(spec).join(", "), spec.separated_by));
        }
        say("");
    }
}

/// Ids of the effects that look like this one.
fn twins(spec: &EffectSpec) -> Vec<&'static str> {
    spec.twins.iter().map(|twin| twin.id).collect()
}

fn entry(spec: &EffectSpec) -> Value {
    let parameters: Vec<Value> = spec
        .parameters
        .iter()
        .map(|p| {
            json!({
                "name": p.name, "unit": p.unit, "lower": p.lower, "upper": p.upper, "default": p.default,
                "neutral": p.neutral, "discrete": p.discrete,
                "prior_sigma": p.prior_sigma.is_finite().then_some(p.prior_sigma),
            })
        })
        .collect();
    json!({
        "id": spec.id, "term": spec.term.name(), "equation": spec.equation, "source": spec.source,
        "parameters": parameters, "hidden": spec.hidden, "twins": twins(spec), "separated_by": spec.separated_by,
    })
}
