//! `railgrip check`: everything that is wrong with a config and with the files that it names, at once.

use std::path::{Path, PathBuf};

use railgrip_health::access::Access;
use railgrip_settings::{Overrides, TrainSettings, examine, wrong_file};

use crate::output::say;
use crate::{CliError, check_files, logging};

/// Checks the text of a config as completely as a start of the train does.
///
/// # Errors
/// All mistakes, each in words of its own.
pub(crate) fn completely(
    file: &Path,
    text: &str,
    overrides: &Overrides,
) -> Result<TrainSettings, Vec<String>> {
    looked_at(file, text, overrides, |_| Vec::new())
}

/// The settings, or every mistake: of the config, of what it names for access and logging, and of what `more` finds.
fn looked_at(
    file: &Path,
    text: &str,
    overrides: &Overrides,
    more: impl Fn(&TrainSettings) -> Vec<(String, String)>,
) -> Result<TrainSettings, Vec<String>> {
    let (mut found, settings) = examine(file, text, overrides);
    if let Some(settings) = &settings {
        let access = Access::wrong(settings);
        let mut named: Vec<_> =
            access.into_iter().map(|(key, error)| (key.to_owned(), error.to_string())).collect();
        named.extend(more(settings));
        if let Err(error) = logging::check(&settings.logging.level) {
            named.push(("logging.level".to_owned(), error.to_string()));
        }
        found.extend(named.iter().map(|(key, problem)| wrong_file(file, text, key, problem)));
        found.sort_by_key(|error| error.line().unwrap_or(usize::MAX));
    }
    match settings {
        Some(settings) if found.is_empty() => Ok(settings),
        _ => Err(found.iter().map(ToString::to_string).collect()),
    }
}

/// Check a config and the files that it names: all mistakes at once.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Config of a train
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let file = &args.config;
    let (_, text) = TrainSettings::text(Some(file))?;
    let look = |settings: &TrainSettings| check_files::wrong(settings);
    let settings = looked_at(file, &text, &Overrides::default(), look).map_err(|found| {
        let number = found.len();
        let noun = if number == 1 { "mistake" } else { "mistakes" };
        CliError::bad_input(format!("{number} {noun}\n{}", found.join("\n")))
    })?;
    let named = settings.wagons.iter().filter(|wagon| wagon.vehicle_number.is_some()).count();
    say(&format!(
        "{}: sound; train \"{}\", {} wagons, {named} of them with a vehicle number",
        file.display(),
        settings.name,
        settings.wagons.len()
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_named_are_opened_and_told_with_their_keys() {
        let folder = tempfile::tempdir().expect("folder");
        let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect(name);
        put("vehicle.toml", include_str!("../../../config/vehicle.toml"));
        put("run.csv", "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n\n0.0,ten,1,1,1,1\n");
        put("ca.pem", "-----BEGIN CERTIFICATE-----\nnothing\n");
        put("empty", "");
        put("model.bin", "no model");
        put("noise.wav", "no noise");
        let text = "schema = 1\n[train]\nname = \"t\"\n[source]\nkind = \"replay\"\nruns = [\"run.csv\"]\n\
            [http]\ntoken_file = \"gone.toml\"\nrefresh_ms = 1.0\n[http.tls]\ncertificate = \"gone.pem\"\nkey = \"gone.key\"\n\
            [[receiver]]\nkind = \"webhook\"\nurl = \"https://depot/a\"\ntoken_file = \"gone\"\n\
            [[receiver]]\nkind = \"mqtt\"\nhost = \"depot\"\ntls = true\nca_file = \"ca.pem\"\nuser = \"u\"\npassword_file = \"empty\"\n\
            [[microphone]]\nwagon = 1\nrecordings = [\"noise.wav\"]\n[acoustics]\nmodel = \"model.bin\"\n\
            [logging]\nlevel = \"inof\"\n";
        let file = folder.path().join("x.toml");
        let found = looked_at(&file, text, &Overrides::default(), check_files::wrong).expect_err("all wrong");
        for (key, words) in [
            ("source.runs", "run.csv, line 2, column v_m_s"),
            ("http.token_file", "gone.toml"),
            ("http.refresh_ms", "is 1"),
            ("http.tls", "gone.pem"),
            ("receiver.1.token_file", "gone"),
            ("receiver.2.ca_file", "ca.pem"),
            ("receiver.2.password_file", "is empty"),
            ("microphone.1.recordings", "noise.wav"),
            ("acoustics.model", "model.bin"),
            ("logging.level", "inof"),
        ] {
            let told = |said: &&String| said.contains(&format!("`{key}`")) && said.contains(words);
            assert_eq!(found.iter().filter(told).count(), 1, "{key}: {found:#?}");
        }
        assert_eq!(found.len(), 10, "{found:#?}");
        let log = "schema = 1\n[train]\nname = \"t\"\nwagons = 1\nvehicle = \"vehicle.toml\"\n[source]\nkind = \"can\"\n\
            file = \"empty\"\ndatabase = \"gone.dbc\"\n";
        let found = looked_at(&file, log, &Overrides::default(), check_files::wrong).expect_err("no log");
        assert!(found.len() == 1 && found[0].contains("`source.database`"), "{found:#?}");
    }
}
