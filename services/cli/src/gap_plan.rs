//! `railgrip gap plan`: the run that would best tell apart what a diagnosis leaves open.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use railgrip_diagnosis::plan::{Limits, Plan};
use railgrip_diagnosis::wagon;
use railgrip_vehicle::RailClass;
use serde_json::json;

use crate::CliError;
use crate::gap_shared::{SearchArgs, name_of, write};
use crate::output::{apart, say};

/// Arguments of `railgrip gap plan`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder with vehicle.toml, fit/ and holdout/
    #[arg(value_name = "CASE")]
    case: PathBuf,
    /// Where the plan goes, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Where the run goes as a scenario, for `railgrip simulate`
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Highest speed, m/s [default: the highest of the recordings]
    #[arg(long, value_name = "M_S")]
    v_max: Option<f64>,
    /// Rail on which may be run: dry, wet, low [default: what the recordings were made on]
    #[arg(long, value_name = "RAILS", value_delimiter = ',')]
    rails: Vec<String>,
    /// Length of the run, s
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    length_s: f64,
    #[command(flatten)]
    search: SearchArgs,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let started = Instant::now();
    let limits = limits(args)?;
    let [vehicle, fit, holdout] = ["vehicle.toml", "fit", "holdout"].map(|name| args.case.join(name));
    let written = [("--json", args.json.as_deref()), ("--scenario", args.scenario.as_deref())];
    apart(&written, &[&vehicle, &fit, &holdout])?;
    let case = args.search.read(&args.case)?;
    let options = args.search.options(&args.case, format!("railgrip gap plan {}", name_of(&args.case)));
    let (_, plan) = args.search.run(|step| wagon::plan(&case, &options, &limits, step))?;
    if let Some(path) = &args.json {
        let value = match &plan {
            Some(plan) => serde_json::to_value(plan).map_err(CliError::failed)?,
            None => json!({
                "separates": [], "entropy_before": 0.0, "entropy_after": 0.0, "run": null,
                "words": NOTHING, "seconds": started.elapsed().as_secs_f64(),
            }),
        };
        let text = serde_json::to_string_pretty(&value).map_err(CliError::failed)?;
        write(path, &(text + "\n"))?;
    }
    let Some(plan) = plan else {
        say(NOTHING);
        return Ok(());
    };
    if let Some(path) = &args.scenario {
        write(path, &scenario(&plan))?;
    }
    say(&plan.words);
    say(
        "Once it is made, put it into CASE/test as NAME.RAIL.csv: `railgrip gap settle CASE` says what it decides.",
    );
    Ok(())
}

const NOTHING: &str = "Nothing is left to separate: no candidate comes near what was found.";

fn limits(args: &Args) -> Result<Limits, CliError> {
    if args.v_max.is_some_and(|v_max| !(5.0..=150.0).contains(&v_max)) {
        return Err(CliError::bad_input("--v-max: allowed is 5 to 150 m/s"));
    }
    if !(10.0..=600.0).contains(&args.length_s) {
        return Err(CliError::bad_input("--length-s: allowed is 10 to 600 s"));
    }
    let class = |name: &String| {
        RailClass::from_name(name.trim())
            .ok_or_else(|| CliError::bad_input(format!("--rails: no rail {name:?}; there are dry, wet, low")))
    };
    let rails = args.rails.iter().map(class).collect::<Result<Vec<_>, _>>()?;
    Ok(Limits { v_max_m_s: args.v_max, rails, length_s: args.length_s })
}

/// The run as a scenario of one wagon.
fn scenario(plan: &Plan) -> String {
    let run = &plan.run;
    let length_s = run.phases.last().map_or(0.0, |phase| phase.until_s);
    let mut text = format!(
        "# {}\nschema = 1\nname = \"planned\"\nduration_s = {length_s:?}\nstart_speed_m_s = {:?}\ntrain = {{ wagons = 1 }}\n\
         rail = [{{ from_m = -1000.0, condition = \"{}\" }}]\n",
        plan.words, run.v0_m_s, run.rail
    );
    let mut from_s = 0.0;
    for phase in &run.phases {
        let what = match (phase.brake_demand, phase.drive_demand) {
            (brake, _) if brake > 0.0 => format!("brake = {brake:?}"),
            (_, drive) if drive > 0.0 => format!("traction = {drive:?}"),
            _ => "coast = true".to_owned(),
        };
        let _ = write!(text, "\n[[demand]]\nfrom_s = {from_s:?}\n{what}\n");
        from_s = phase.until_s;
    }
    text
}
