//! `railgrip gap prepare`: recordings as they are into runs that are fit for a diagnosis.

use std::path::PathBuf;

use railgrip_recording::{Mending, RailClass, Renamed, prepare};

use crate::CliError;
use crate::output::say;

/// Makes runs of a case out of recordings as they are.
///
/// Rows move to a regular rate; a recording is cut where it pauses, or where a force, torque, slope or sanding is empty, for
/// more than half a second; columns that no run has are left out. Speeds that were not measured stay empty. All of it is said.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A recording (.csv, .parquet) or a folder of them
    #[arg(value_name = "IN")]
    from: PathBuf,
    /// Folder into which the runs are written, such as CASE/fit; nothing that stands there is overwritten
    #[arg(value_name = "OUT")]
    to: PathBuf,
    /// Lower rate, Hz, of which the recorded one is a whole multiple
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// A column under another name or in another unit, such as train_speed=v_m_s or 'speed_kmh*0.277778=v_m_s'; may be repeated
    #[arg(long, value_name = "FROM[*FACTOR]=TO", value_parser = renamed)]
    map: Vec<Renamed>,
    /// A column that is left out; may be repeated
    #[arg(long, value_name = "COLUMN")]
    drop: Vec<String>,
    /// Rail (dry, wet, low) of recordings whose names declare none
    #[arg(long, value_parser = rail)]
    rail: Option<RailClass>,
}

fn renamed(text: &str) -> Result<Renamed, String> {
    let (left, to) = text.split_once('=').ok_or("a column is mapped by FROM=TO or FROM*FACTOR=TO")?;
    let (from, factor) = match left.rsplit_once('*') {
        Some((from, factor)) => {
            (from, factor.trim().parse().map_err(|_| format!("`{factor}` is no factor"))?)
        }
        None => (left, 1.0),
    };
    if !f64::is_normal(factor) {
        return Err(format!("`{factor}` is no factor"));
    }
    Ok(Renamed { from: from.trim().to_owned(), factor, to: to.trim().to_owned() })
}

fn rail(text: &str) -> Result<RailClass, String> {
    RailClass::parse(text).ok_or_else(|| "a rail is dry, wet or low".to_owned())
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let mending = Mending { renamed: args.map.clone(), dropped: args.drop.clone(), rate_hz: args.rate };
    for one in prepare(&args.from, &args.to, &mending, args.rail).map_err(CliError::bad_input)? {
        say(&format!("{}:", one.from.display()));
        for note in &one.notes {
            say(&format!("  {note}"));
        }
        for (path, rows, rate_hz) in &one.runs {
            say(&format!("  -> {}: {rows} rows at {rate_hz:.2} Hz", path.display()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_mapped_with_and_without_a_factor() {
        let plain = renamed("train_speed=v_m_s").expect("plain");
        assert_eq!((plain.from.as_str(), plain.factor, plain.to.as_str()), ("train_speed", 1.0, "v_m_s"));
        let scaled = renamed("speed_kmh*0.25=v_m_s").expect("scaled");
        assert_eq!((scaled.from.as_str(), scaled.factor), ("speed_kmh", 0.25));
        assert!(renamed("speed").is_err() && renamed("a*b=c").is_err() && renamed("a*0=c").is_err());
    }
}
