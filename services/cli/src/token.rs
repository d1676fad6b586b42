//! `railgrip token`: who may come in to the HTTP service. A running service sees a change within a second.

use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use railgrip_health::access::{Role, tokens};
use railgrip_health::time::rfc3339;

use crate::CliError;
use crate::output::{note, say};
use crate::train::TrainArgs;

/// Make, list and end the tokens of the HTTP service.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Make a token; it is shown once and kept as a hash only
    Add(Add),
    /// List the tokens: name, role, expiry
    List(List),
    /// End a token at once
    Revoke(Revoke),
    /// Give a token a new secret; the old one stays valid for a while
    Rotate(Rotate),
}

#[derive(Debug, clap::Args)]
struct Place {
    /// The token file [default: [http] token_file of the config]
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    #[command(flatten)]
    train: TrainArgs,
}

#[derive(Debug, clap::Args)]
struct Add {
    /// Who or what it is for: letters, digits, `-`, `_`, `.`
    name: String,
    /// What its owner may do: read, acknowledge (and silence alerts), admin
    #[arg(long, value_parser = role, default_value = "read")]
    role: Role,
    /// Lifetime, for example 12h, 90d; `never` for no end
    #[arg(long, value_name = "TIME", value_parser = span, default_value = "365d")]
    expires: Span,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, clap::Args)]
struct List {
    /// As JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, clap::Args)]
struct Revoke {
    /// The token
    name: String,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, clap::Args)]
struct Rotate {
    /// The token
    name: String,
    /// Time for which the old secret stays valid, for example 10m, 24h; 0s ends it at once
    #[arg(long, value_name = "TIME", value_parser = span, default_value = "24h")]
    overlap: Span,
    #[command(flatten)]
    place: Place,
}

/// A time span, s; none for `never`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Span(Option<i64>);

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Add(args) => {
            let file = args.place.file()?;
            if args.expires.0 == Some(0) {
                return Err(CliError::bad_input(
                    "--expires 0s: the token would never be valid; allowed is 1s or more",
                ));
            }
            let end = args.expires.0.map(|s| now_s().saturating_add(s));
            // Only the secret goes to the standard output, so that it can be piped into a file.
            say(&tokens::add(&file, &args.name, args.role, end)?);
            note(&format!(
                "token \"{}\" ({}) {} in {}; this is the only time that it is shown",
                args.name,
                args.role.word(),
                end.map_or_else(|| "without end".to_owned(), |end| format!("until {}", instant(end))),
                file.display()
            ));
        }
        Command::List(args) => list(args)?,
        Command::Revoke(args) => {
            tokens::revoke(&args.place.file()?, &args.name)?;
            note(&format!("token \"{}\" is ended", args.name));
        }
        Command::Rotate(args) => {
            let overlap_s = args.overlap.0.unwrap_or(i64::MAX / 4);
            let file = args.place.file()?;
            say(&tokens::rotate(&file, &args.name, overlap_s)?);
            let until = if overlap_s > 0 {
                format!("the old one counts until {}", instant(now_s().saturating_add(overlap_s)))
            } else {
                "the old one is ended".to_owned()
            };
            note(&format!("token \"{}\" has a new secret; {until}", args.name));
        }
    }
    Ok(())
}

fn list(args: &List) -> Result<(), CliError> {
    let file = args.place.file()?;
    if args.place.file.is_some() && !file.exists() {
        return Err(CliError::bad_input(format!("{}: there is no such file", file.display())));
    }
    let tokens = tokens::read(&file)?;
    let now_s = now_s();
    if args.json {
        let rows: Vec<serde_json::Value> = tokens
            .iter()
            .map(|token| {
                serde_json::json!({
                    "name": token.name,
                    "role": token.role.word(),
                    "created": instant(token.created_s),
                    "expires": token.expires_s.map(instant),
                    "valid": token.usable(now_s),
                })
            })
            .collect();
        say(&serde_json::to_string_pretty(&rows).map_err(CliError::failed)?);
        return Ok(());
    }
    say(&format!("{:<24} {:<12} {:<21} {:<21} {}", "name", "role", "created", "ends", "state"));
    for token in &tokens {
        let ends = token.expires_s.map_or_else(|| "never".to_owned(), instant);
        let state = if token.usable(now_s) { "valid" } else { "expired" };
        let (role, created) = (token.role.word(), instant(token.created_s));
        say(&format!("{:<24} {role:<12} {created:<21} {ends:<21} {state}", token.name));
    }
    Ok(())
}

impl Place {
    fn file(&self) -> Result<PathBuf, CliError> {
        if let Some(file) = &self.file {
            return Ok(file.clone());
        }
        let train = self.train.load()?;
        train.settings.access.token_file.clone().ok_or_else(|| {
            CliError::bad_input(format!(
                "{}: `http.token_file` is absent; name a file there, or give one with --file",
                train.settings.file.display()
            ))
        })
    }
}

fn role(text: &str) -> Result<Role, String> {
    let known = Role::ALL.into_iter().find(|role| role.word() == text);
    known.ok_or_else(|| "allowed are read, acknowledge and admin".to_owned())
}

fn span(text: &str) -> Result<Span, String> {
    let allowed = || "allowed is a number with s, m, h or d, for example 90d, or `never`".to_owned();
    if text == "never" {
        return Ok(Span(None));
    }
    let unit = text.chars().last().ok_or_else(allowed)?;
    let factor = match unit {
        's' => 1,
        'm' => 60,
        'h' => 3600,
        'd' => 86_400,
        _ => return Err(allowed()),
    };
    let number: u32 = text[..text.len() - 1].parse().map_err(|_| allowed())?;
    Ok(Span(Some(i64::from(number) * factor)))
}

fn now_s() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_secs()).unwrap_or(i64::MAX)
}

/// To the second.
fn instant(unix_s: i64) -> String {
    let text = rfc3339(unix_s.saturating_mul(1_000_000_000));
    format!("{}Z", &text[..19.min(text.len())])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_numbers_with_units() {
        assert_eq!(span("90d"), Ok(Span(Some(7_776_000))));
        assert_eq!(span("0s"), Ok(Span(Some(0))));
        assert_eq!(span("never"), Ok(Span(None)));
        for wrong in ["", "d", "90", "-1d", "1y", "1.5h", "9µ", "99999999999d"] {
            assert!(span(wrong).is_err(), "{wrong}");
        }
    }
}
