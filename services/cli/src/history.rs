//! `railgrip history`: what a train remembers, as tables for pandas, DuckDB and spreadsheets. Works on the database itself,
//! whether the train runs or not.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use railgrip_health::history::export::{self, ExportError, Form, Wanted};
use railgrip_health::history::{Consist, columns, consist};
use railgrip_health::time::{self, rfc3339};
use railgrip_history::{EventFilter, HistoryError, Reader};
use railgrip_messages::MAX_WHEELSETS;

use crate::CliError;
use crate::output::{apart, note, say};
use crate::train::TrainArgs;

/// Export what a train remembers.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Write stored indicators to a CSV or Parquet file: one row a wagon and step
    Export(Export),
    /// Show what happened, the latest last
    Events(Events),
}

#[derive(Debug, clap::Args)]
struct Place {
    /// The database [default: history.db in the folder that [history] dir of the config names]
    #[arg(long, value_name = "FILE")]
    database: Option<PathBuf>,
    #[command(flatten)]
    train: TrainArgs,
}

#[derive(Debug, clap::Args)]
struct Export {
    /// The file to write; `-` for the standard output
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// csv or parquet [default: by the ending of the file, else csv]
    #[arg(long, value_parser = form)]
    format: Option<Form>,
    /// Begin: RFC 3339, Unix seconds, `now`, or an age, for example 30d [default: everything]
    #[arg(long, value_name = "TIME", value_parser = instant, allow_hyphen_values = true)]
    from: Option<i64>,
    /// End: RFC 3339, Unix seconds, or an age such as 7d [default: now]
    #[arg(long, value_name = "TIME", value_parser = instant, allow_hyphen_values = true)]
    to: Option<i64>,
    /// Width of a step: seconds, or a number with s, m, h or d
    #[arg(long, value_name = "TIME", value_parser = span, default_value = "60s")]
    step: i64,
    /// Only these wagons, separated by commas
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',')]
    wagons: Vec<u32>,
    /// Only these indicators, separated by commas, for example brake_friction,wheelset_1.slides
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    fields: Option<Vec<String>>,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, clap::Args)]
struct Events {
    /// At most so many
    #[arg(long, default_value_t = 50)]
    limit: usize,
    /// As JSON, one object a line
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    place: Place,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Export(args) => export(args),
        Command::Events(args) => events(args),
    }
}

impl Place {
    /// The file of the database.
    fn file(&self) -> Result<PathBuf, CliError> {
        match &self.database {
            Some(file) => Ok(file.clone()),
            None => Ok(self.train.load()?.settings.history.database()),
        }
    }

    /// The database, and who runs where in the train; with `--database` alone nobody knows where vehicles run.
    fn reader(&self) -> Result<(Reader, Consist), CliError> {
        let (database, numbers, started_s) = match &self.database {
            Some(file) => (file.clone(), Vec::new(), None),
            None => {
                let settings = self.train.load()?.settings;
                let started_s = consist::started_s(&settings);
                (settings.history.database(), consist::numbers(&settings), started_s)
            }
        };
        if !database.exists() {
            let said = format!("{}: there is no such database; name one with --database", database.display());
            return Err(CliError::bad_input(said));
        }
        let former = columns::former(&columns::all(MAX_WHEELSETS));
        let reader = Reader::open(&database).map_err(of_history)?.with_names(&former);
        let consist = Consist::read(&reader, &numbers).map_err(of_history)?;
        Ok((reader, consist.started(started_s)))
    }
}

fn export(args: &Export) -> Result<(), CliError> {
    let (reader, consist) = args.place.reader()?;
    let ending = args.out.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let form = args.format.or_else(|| Form::of_word(ending)).unwrap_or(Form::Csv);
    let wanted = Wanted {
        wagons: args.wagons.clone(),
        consist,
        fields: args.fields.clone(),
        from_s: args.from.unwrap_or(0),
        to_s: args.to.unwrap_or_else(|| now_s() + 1),
        step_s: args.step,
    };
    if wanted.from_s >= wanted.to_s {
        return Err(CliError::bad_input("--from must be before --to"));
    }
    let failed = |error: ExportError| match error {
        ExportError::Unknown { .. } => CliError::bad_input(format!("--fields: {error}")),
        ExportError::History(error) => of_history(error),
        other => CliError::failed(format!("{}: {other}", args.out.display())),
    };
    if args.out == Path::new("-") {
        export::write(&reader, &wanted, form, std::io::stdout()).map_err(failed)?;
        return Ok(());
    }
    apart(&[("--out", Some(args.out.as_path()))], &[args.place.file()?.as_path()])?;
    // Under another name until it is whole.
    let mut beside = args.out.clone().into_os_string();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    let io = |error: std::io::Error| CliError::failed(format!("{}: {error}", args.out.display()));
    let file = std::fs::File::create(&beside).map_err(io)?;
    let mut out = std::io::BufWriter::new(file);
    let written = export::write(&reader, &wanted, form, &mut out)
        .and_then(|rows| Ok(out.flush().map(|()| rows)?))
        .map_err(failed)
        .and_then(|rows| std::fs::rename(&beside, &args.out).map(|()| rows).map_err(io));
    if written.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    note(&format!("{}: {} rows", args.out.display(), written?));
    Ok(())
}

fn events(args: &Events) -> Result<(), CliError> {
    let (reader, consist) = args.place.reader()?;
    let events = reader.events(&EventFilter::default(), args.limit).map_err(of_history)?;
    for numbered in events.into_iter().rev() {
        let mut event = numbered.event;
        let vehicle = event.wagon.and_then(|id| consist.vehicle(id));
        let unix_s = event.unix_ms.div_euclid(1000);
        event.wagon = event.wagon.and_then(|id| consist.place_then(id, unix_s));
        let at = rfc3339(event.unix_ms.saturating_mul(1_000_000));
        if args.json {
            let line = serde_json::json!({
                "id": numbered.id, "at": at, "kind": event.kind, "wagon": event.wagon, "vehicle": vehicle, "wheelset": event.wheelset,
                "grade": event.grade, "cause": event.cause, "text": event.text,
            });
            say(&line.to_string());
        } else {
            let wagon = match (event.wagon, vehicle) {
                (_, Some(vehicle)) => format!("vehicle {vehicle}"),
                (Some(wagon), None) => format!("wagon {wagon}"),
                (None, None) => String::new(),
            };
            let place = match event.wheelset {
                _ if wagon.is_empty() => String::new(),
                Some(wheelset) => format!("{wagon}, wheelset {wheelset}: "),
                None => format!("{wagon}: "),
            };
            say(&format!("{at}  {:<18} {place}{}", event.kind, event.text));
        }
    }
    Ok(())
}

/// A file that is no history is bad input; what else fails is not.
fn of_history(error: HistoryError) -> CliError {
    match error.is_of_the_file() {
        true => CliError::bad_input(error),
        false => CliError::failed(error),
    }
}

fn form(text: &str) -> Result<Form, String> {
    Form::of_word(text).ok_or_else(|| "allowed are csv and parquet".to_owned())
}

fn span(text: &str) -> Result<i64, String> {
    time::span_s(text).ok_or_else(|| format!("allowed is {}", time::SPAN_ALLOWED))
}

fn instant(text: &str) -> Result<i64, String> {
    time::instant_s(text, now_s()).ok_or_else(|| format!("allowed is {}", time::INSTANT_ALLOWED))
}

fn now_s() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_secs()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_and_spans_are_read() {
        assert_eq!(instant("2026-03-01T12:00:00Z"), Ok(1_772_366_400));
        assert_eq!(instant("1772366400"), Ok(1_772_366_400));
        let ago = instant("30d").expect("ago");
        assert!((now_s() - ago - 30 * 86_400).abs() <= 1);
        assert_eq!(span("90"), Ok(90));
        assert_eq!(instant("-30d"), instant("30d"));
        for wrong in ["", "x", "-1", "0s", "1y", "99999d"] {
            assert!(span(wrong).is_err(), "{wrong}");
        }
        assert!(instant("yesterday").is_err());
    }
}
