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
    let text = serde_json::to_string_pretty(&train).map_err(CliError::failed)?;
    say(&text);
    Ok(())
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
