//! `railgrip gap compare`: two reports of one vehicle side by side.

use std::path::{Path, PathBuf};

use railgrip_diagnosis::answer::schema::{Report, SCHEMA};
use railgrip_diagnosis::html;
use railgrip_diagnosis::words::compare::{Named, summary};
use railgrip_words::speak;

use crate::CliError;
use crate::gap_shared::LanguageArgs;
use crate::output::{apart, say};

/// Compare two reports of one vehicle.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Earlier report, as `gap diagnose --json` wrote it
    #[arg(value_name = "A")]
    first: PathBuf,
    /// Later report
    #[arg(value_name = "B")]
    second: PathBuf,
    /// Where the comparison goes, as one self-contained page
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    language: LanguageArgs,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    apart(&[("--html", args.html.as_deref())], &[&args.first, &args.second])?;
    let (first, second) = (load(&args.first)?, load(&args.second)?);
    let names = names(&args.first, &args.second);
    let first = Named { name: &names[0], report: &first };
    let second = Named { name: &names[1], report: &second };
    let language = args.language.chosen();
    if let Some(path) = &args.html {
        let page = speak(language, || html::compare::render(first, second));
        std::fs::write(path, page)
            .map_err(|error| CliError::failed(format!("{}: {error}", path.display())))?;
    }
    say(&speak(language, || summary(first, second)));
    Ok(())
}

fn load(path: &Path) -> Result<Report, CliError> {
    let bad = |error: &dyn std::fmt::Display| CliError::bad_input(format!("{}: {error}", path.display()));
    let text = railgrip_recording::read_text(path).map_err(|error| bad(&error))?;
    let report: Report = serde_json::from_str(&text).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        bad(&format!("no report of `gap diagnose --json` of this version ({place})"))
    })?;
    if report.schema != SCHEMA {
        return Err(bad(&format!("schema is {:?}, this version reads {SCHEMA:?}", report.schema)));
    }
    Ok(report)
}

/// What the reports are called: their files without the ending, or their folders where the files are called alike.
fn names(first: &Path, second: &Path) -> [String; 2] {
    let stem = |path: &Path| path.file_stem().map(|name| name.to_string_lossy().into_owned());
    let folder =
        |path: &Path| path.parent().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let by = |name: &dyn Fn(&Path) -> Option<String>| Some([name(first)?, name(second)?]);
    let apart = |names: &[String; 2]| names[0] != names[1];
    by(&stem)
        .filter(apart)
        .or_else(|| by(&folder).filter(apart))
        .unwrap_or_else(|| ["A".to_owned(), "B".to_owned()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_called_by_what_tells_them_apart() {
        let of = |a: &str, b: &str| names(Path::new(a), Path::new(b));
        assert_eq!(of("may.json", "june.json"), ["may", "june"]);
        assert_eq!(of("may/report.json", "june/report.json"), ["may", "june"]);
        assert_eq!(of("report.json", "report.json"), ["A", "B"]);
    }
}
