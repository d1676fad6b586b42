//! `railgrip gap settle`: what a test run says of what a diagnosis leaves open.

use std::path::PathBuf;

use railgrip_diagnosis::data::load;
use railgrip_diagnosis::wagon;

use crate::CliError;
use crate::gap_shared::{SearchArgs, name_of, write};
use crate::output::{apart, say};

/// Arguments of `railgrip gap settle`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder with vehicle.toml, fit/ and holdout/
    #[arg(value_name = "CASE")]
    case: PathBuf,
    /// Folder with the test run or runs, which the diagnosis does not see [default: test/ of the case]
    #[arg(long, value_name = "DIR")]
    test: Option<PathBuf>,
    /// Where the answer goes, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    search: SearchArgs,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let test = args.test.clone().unwrap_or_else(|| args.case.join("test"));
    if !test.is_dir() {
        return Err(CliError::bad_input(format!(
            "{}: no such folder; it should hold the test run as NAME.RAIL.csv (`railgrip gap plan` designs one)",
            test.display()
        )));
    }
    let [vehicle, fit, holdout] = ["vehicle.toml", "fit", "holdout"].map(|name| args.case.join(name));
    apart(&[("--json", args.json.as_deref())], &[&vehicle, &fit, &holdout, &test])?;
    let case = args.search.read(&args.case)?;
    let test = load::load_test(&test, case.vehicle.clone()).map_err(CliError::bad_input)?;
    let options = args.search.options(&args.case, format!("railgrip gap settle {}", name_of(&args.case)));
    let (_, settled) = args.search.run(|step| wagon::settle(&case, &test, &options, step))?;
    let settled = settled.ok_or_else(|| CliError::failed("the diagnosis came to no end"))?;
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&settled).map_err(CliError::failed)?;
        write(path, &(text + "\n"))?;
    }
    for note in &test.notes {
        say(&format!("Note: {note}"));
    }
    say(&settled.words);
    Ok(())
}
