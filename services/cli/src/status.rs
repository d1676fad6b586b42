//! `railgrip status`: what the HTTP service of a running train says, as a table.

use std::time::Duration;

use serde_json::Value;

use crate::CliError;
use crate::output::say;
use crate::train::TrainArgs;

/// How long the service may take to answer.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Show what the HTTP service of a running train says.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    train: TrainArgs,
    /// Ask this service instead of the one that runs here, for example http://192.0.2.7:8080
    #[arg(long, value_name = "URL")]
    url: Option<String>,
    /// Print the service's answer as it is
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let base = match &args.url {
        Some(url) => url.trim_end_matches('/').to_owned(),
        None => local_service(&args.train)?,
    };
    let train = get(&base, "/api/v1/train")?;
    let wagons = get(&base, "/api/v1/wagons")?;
    if args.json {
        let both = serde_json::json!({ "train": train, "wagons": wagons["wagons"] });
        say(&serde_json::to_string_pretty(&both).map_err(CliError::failed)?);
    } else {
        table(&base, &train, &wagons).iter().for_each(|line| say(line));
    }
    Ok(())
}

/// One line about the train, one a wagon.
fn table(base: &str, train: &Value, wagons: &Value) -> Vec<String> {
    let rows = wagons["wagons"].as_array().map(Vec::as_slice).unwrap_or_default();
    let name = wagons["train"].as_str().unwrap_or("?");
    let mut lines = vec![format!("train {name}: {}, {} wagons ({base})", word(&train["grade"]), rows.len())];
    lines.push(format!(
        "{:>3}  {:<20} {:<6} {:>6}  {:<7} {:>7} {:>8} {:>9} {:<9} {:>8} {:>9}  {}",
        "no",
        "wagon",
        "news",
        "age s",
        "grade",
        "km/h",
        "adhesion",
        "available",
        "rail",
        "pad",
        "asym %",
        "why"
    ));
    lines.extend(rows.iter().map(row));
    lines
}

fn row(wagon: &Value) -> String {
    let bound = if wagon["adhesion_available_is_lower_bound"] == true { "≥" } else { "" };
    let available = figure(&wagon["adhesion_available"], 1.0, 3);
    let available = if available == UNKNOWN { available } else { format!("{bound}{available}") };
    format!(
        "{:>3}  {:<20} {:<6} {:>6}  {:<7} {:>7} {:>8} {:>9} {:<9} {:>8} {:>9}  {}",
        wagon["id"].as_u64().unwrap_or_default(),
        word(&wagon["name"]),
        word(&wagon["state"]),
        figure(&wagon["age_s"], 1.0, 1),
        word(&wagon["grade"]),
        figure(&wagon["v_m_s"], 3.6, 1),
        figure(&wagon["adhesion_utilised"], 1.0, 3),
        available,
        word(&wagon["condition"]).replace('_', " "),
        figure(&wagon["brake_friction"], 1.0, 3),
        figure(&wagon["asymmetry"], 100.0, 1),
        wagon["reason"].as_str().unwrap_or_default(),
    )
    .trim_end()
    .to_owned()
}

/// What stands in the table where nothing is known.
const UNKNOWN: &str = "-";

fn word(value: &Value) -> &str {
    value.as_str().unwrap_or(UNKNOWN)
}

fn figure(value: &Value, scale: f64, decimals: usize) -> String {
    value.as_f64().map_or_else(|| UNKNOWN.to_owned(), |value| format!("{:.decimals$}", value * scale))
}

/// The address that the health service of the train on this machine wrote.
fn local_service(train: &TrainArgs) -> Result<String, CliError> {
    let train = train.load()?;
    let file = train.settings.instance.http_address_file();
    let text = std::fs::read_to_string(&file).map_err(|error| {
        let name = &train.settings.name;
        CliError::failed(format!(
            "train \"{name}\" serves no HTTP on this machine ({}: {error}); start it with `railgrip up`",
            file.display()
        ))
    })?;
    Ok(format!("http://{}", text.trim().trim_start_matches("http://")))
}

fn get(base: &str, path: &str) -> Result<Value, CliError> {
    let url = format!("{base}{path}");
    let failed = |error: ureq::Error| CliError::failed(format!("{url}: {error}"));
    let agent: ureq::Agent = ureq::Agent::config_builder().timeout_global(Some(TIMEOUT)).build().into();
    agent.get(&url).call().map_err(failed)?.body_mut().read_json().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_shows_known_figures_and_dashes() {
        let train = serde_json::json!({ "grade": "watch" });
        let wagons = serde_json::json!({ "train": "demo", "wagons": [
            { "id": 1, "name": "coach-1", "state": "live", "age_s": 0.12, "grade": "watch", "v_m_s": 10.0,
              "adhesion_utilised": 0.0812, "adhesion_available": 0.1, "adhesion_available_is_lower_bound": true,
              "condition": "very_low", "brake_friction": 0.35, "asymmetry": -0.051, "reason": "asymmetry" },
            { "id": 2, "name": "coach-2", "state": "silent", "age_s": null, "grade": "unknown", "reason": "" },
        ]});
        let lines = table("http://x", &train, &wagons);
        assert_eq!(lines[0], "train demo: watch, 2 wagons (http://x)");
        for part in ["coach-1", "36.0", "0.081", "≥0.100", "very low", "0.350", "-5.1", "asymmetry"] {
            assert!(lines[2].contains(part), "{part}: {}", lines[2]);
        }
        assert!(lines[3].contains("silent") && !lines[3].contains("0.0"), "{}", lines[3]);
    }
}
