//! What a file of unknown columns may mean: the figures of each column, and a mapping that fits its names and figures. A proposal for
//! people, who know their sensors.

mod proposal;
mod signs;
mod units;

use crate::columns::{Quantity, TIME, columns_of_run};
use crate::csv_form::Missing;
use crate::error::{Problem, RecordingError, Result};
use crate::mapping::quantity_of;
use crate::table::Table;
use crate::table_file::Form;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

pub use proposal::proposal;
pub use units::Guess;

/// The speed of the wagon in a run.
const SPEED: &str = "v_m_s";
/// Most columns that are looked at: a logger of a train has hundreds.
const MOST_COLUMNS: usize = 4096;
/// Rows that stand for the first minute where nothing is known of the time.
const FIRST_ROWS: usize = 6000;

/// A column of a file, with what is in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Surveyed {
    /// Its name.
    pub name: String,
    /// Cells with a number, and their least and largest; nothing for a column that holds no numbers.
    pub figures: Option<(usize, f64, f64)>,
    /// What it may be.
    pub guess: Option<Guess>,
}

/// The first minute of a column as it was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstMinute {
    /// Name of the column of a run.
    pub to: String,
    /// Name in the file.
    pub from: String,
    /// Unit of the column of a run.
    pub unit: &'static str,
    /// Times from the first row, s, and values in that unit.
    pub points: Vec<[f64; 2]>,
}

/// Looks at every column of a file.
///
/// # Errors
/// A file that is no table of either form.
pub fn survey(path: &Path) -> Result<Vec<Surveyed>> {
    let (names, source) = match Form::of(path)? {
        Form::Csv => read(path)?,
        Form::Parquet => (header(path)?, Source::ByColumn),
    };
    if names.len() > MOST_COLUMNS {
        let problem = Problem::TooManyColumns { found: names.len(), most: MOST_COLUMNS };
        return Err(RecordingError::new(path, problem));
    }
    let wheelsets = wheelsets(&names);
    let own = |name: &str| columns_of_run(wheelsets).into_iter().find(|(.., column)| column == name);
    let mut seen = BTreeSet::new();
    let mut taken: BTreeSet<String> = names.iter().filter_map(|name| own(name)).map(|(.., c)| c).collect();
    let mut surveyed = Vec::new();
    for name in names {
        let cells = source.cells(path, &name)?;
        let cells = cells.as_deref();
        let figures = cells.map(units::figures);
        let guess = cells.and_then(|cells| {
            if let Some((quantity, _, column)) = own(&name) {
                return seen.insert(column.clone()).then(|| Guess::own(column, quantity, cells));
            }
            let quantity = kind(&name)?;
            let places = if quantity.per_wheelset() { wheelsets } else { 1 };
            let column = (0..places).map(|i| quantity.column(i, wheelsets)).find(|c| !taken.contains(c))?;
            taken.insert(column.clone());
            Some(units::guess(column, quantity, &name, cells))
        });
        surveyed.push(Surveyed { name, figures, guess });
    }
    turn_signs(path, &source, &mut surveyed)?;
    Ok(surveyed)
}

/// How many wheelsets a file speaks of: as many as it has speeds, without any as its columns of a run say.
fn wheelsets(names: &[String]) -> usize {
    let own =
        |name: &str, number: usize| columns_of_run(number).into_iter().find(|(.., column)| column == name);
    let numbers = [2, 1, 3, 4];
    let is_speed = |name: &&String| {
        let own = numbers.iter().find_map(|number| own(name, *number));
        own.map_or_else(|| kind(name), |(quantity, ..)| Some(quantity)) == Some(Quantity::WheelSpeed)
    };
    let speaks_of = |number: &usize| {
        names.iter().filter_map(|name| own(name, *number)).any(|(quantity, ..)| quantity.per_wheelset())
    };
    match names.iter().filter(is_speed).count() {
        0 => numbers.into_iter().find(speaks_of).unwrap_or(1),
        speeds => speeds.min(4),
    }
}

/// Turns the sign of each column whose is the other way round, and says why.
fn turn_signs(path: &Path, source: &Source, surveyed: &mut [Surveyed]) -> Result<()> {
    let is_speed = |column: &&Surveyed| column.guess.as_ref().is_some_and(|guess| guess.to == SPEED);
    let speed = match surveyed.iter().find(is_speed) {
        Some(column) => source.cells(path, &column.name)?,
        None => None,
    };
    for column in surveyed {
        let Some(guess) = &mut column.guess else { continue };
        let Some(quantity) = quantity_of(&guess.to) else { continue };
        let Some(cells) = source.cells(path, &column.name)? else { continue };
        if let Some(why) = signs::turned(quantity, &cells, speed.as_deref()) {
            guess.turned = true;
            guess.doubts.push(why.to_owned());
        }
    }
    Ok(())
}

/// The first minute of every column that was understood, as a mapping by the proposal reads it; without a time, the first rows.
///
/// # Errors
/// As [`survey`].
pub fn first_minute(path: &Path, surveyed: &[Surveyed]) -> Result<Vec<FirstMinute>> {
    let (_, source) = match Form::of(path)? {
        Form::Csv => read(path)?,
        Form::Parquet => (header(path)?, Source::ByColumn),
    };
    let understood = || surveyed.iter().filter_map(|column| Some((column, column.guess.as_ref()?)));
    let time = understood().find(|(_, guess)| guess.to == TIME);
    let times = match time {
        Some((column, guess)) => {
            source.cells(path, &column.name)?.map(|cells| minute(&cells, guess.factor()))
        }
        None => None,
    };
    let mut found = Vec::new();
    for (column, guess) in understood().filter(|(_, guess)| guess.to != TIME) {
        let Some(cells) = source.cells(path, &column.name)? else { continue };
        let value = |cell: &f64| cell * guess.factor();
        let points: Vec<[f64; 2]> = match &times {
            Some(times) => times.iter().zip(cells.iter()).map(|(t, cell)| [*t, value(cell)]).collect(),
            None => (0..FIRST_ROWS).zip(cells.iter()).map(|(row, cell)| [row as f64, value(cell)]).collect(),
        };
        let unit = quantity_of(&guess.to).map_or("", Quantity::unit);
        found.push(FirstMinute { to: guess.to.clone(), from: column.name.clone(), unit, points });
    }
    Ok(found)
}

/// Seconds since the first row, of the rows of the first minute.
fn minute(times: &[f64], factor: f64) -> Vec<f64> {
    let Some(first) = times.iter().find(|time| time.is_finite()) else { return Vec::new() };
    let since = times.iter().map(|time| (time - first) * factor);
    since.take_while(|since| since.is_nan() || *since <= 60.0).collect()
}

/// Where the cells of a column come from: of Parquet one column at a time is held, of text they are all read at once.
enum Source {
    Read(Table),
    ByColumn,
}

impl Source {
    /// The cells of a column, nothing for one that holds no numbers.
    fn cells(&self, path: &Path, name: &str) -> Result<Option<Cow<'_, [f64]>>> {
        match self {
            Self::Read(table) => Ok(table.column(name).map(Cow::Borrowed)),
            Self::ByColumn => {
                let choose = |header: &[String]| Ok(header.iter().map(|column| column == name).collect());
                match Table::read_chosen(path, &choose, Missing::AnyText) {
                    Ok(mut table) => Ok(table.take(name).map(Cow::Owned)),
                    Err(error) if matches!(error.problem, Problem::ColumnType(_)) => Ok(None),
                    Err(error) => Err(error),
                }
            }
        }
    }
}

fn header(path: &Path) -> Result<Vec<String>> {
    let names = std::cell::RefCell::new(Vec::new());
    let choose = |header: &[String]| {
        names.replace(header.to_vec());
        Ok(vec![false; header.len()])
    };
    Table::read_chosen(path, &choose, Missing::AnyText)?;
    Ok(names.into_inner())
}

/// The names of all columns of a text file, and those that hold numbers.
fn read(path: &Path) -> Result<(Vec<String>, Source)> {
    let mut text: BTreeSet<String> = BTreeSet::new();
    let names = std::cell::RefCell::new(Vec::new());
    let table = loop {
        let choose = |header: &[String]| {
            names.replace(header.to_vec());
            Ok(header.iter().map(|name| !text.contains(name)).collect())
        };
        match Table::read_chosen(path, &choose, Missing::AnyText) {
            Ok(table) => break table,
            Err(error) => match (&error.problem, error.column.clone()) {
                (Problem::NotANumber(_) | Problem::NotText, Some(column)) if !text.contains(&column) => {
                    text.insert(column);
                }
                _ => return Err(error),
            },
        }
    };
    Ok((names.into_inner(), Source::Read(table)))
}

/// What a name speaks of, in English or German.
fn kind(name: &str) -> Option<Quantity> {
    let lower = name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| lower.contains(word));
    let parts: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).collect();
    let is = |words: &[&str]| parts.iter().any(|part| words.contains(part));
    if has(&["omega", "rpm", "drehzahl", "wheel", "axle", "achse"]) || is(&["n", "n1", "n2", "n3", "n4"]) {
        Some(Quantity::WheelSpeed)
    } else if has(&["press", "druck", "cyl", "f_perp", "brake_force", "bremskraft"]) {
        Some(Quantity::PressingForce)
    } else if has(&["time", "zeit", "stamp"]) || is(&["t", "ts"]) {
        Some(Quantity::Time)
    } else if has(&["speed", "geschw", "veloc", "km/h", "kmh"]) || is(&["v"]) {
        Some(Quantity::Speed)
    } else if has(&["torque", "moment"]) {
        Some(Quantity::DriveTorque)
    } else if has(&["grade", "slope", "neigung", "gradient"]) {
        Some(Quantity::Grade)
    } else if has(&["sand"]) {
        Some(Quantity::Sanding)
    } else if has(&["position", "chainage", "kilometer"]) {
        Some(Quantity::Position)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foreign_header_is_understood_and_what_is_missing_is_said() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.csv");
        let rows: String = (0..50)
            .map(|k| {
                format!("2026-03-01T12:00:00.{:03}Z;{};{};{};3,8;Ada\n", k * 10, 72 + k, 400 + k, 401 + k)
            })
            .collect();
        let header = "Zeitstempel;Geschwindigkeit km/h;Drehzahl 1;Drehzahl 2;p_cyl_1 bar;driver\n";
        std::fs::write(&path, format!("{header}{rows}")).expect("write");
        let surveyed = survey(&path).expect("a table");
        let said = proposal(&surveyed, str::to_owned);
        for line in [
            "t_s = { from = \"Zeitstempel\" }",
            "v_m_s = { from = \"Geschwindigkeit km/h\", unit = \"km/h\" }",
            "omega_f_rad_s = { from = \"Drehzahl 1\", unit = \"rpm\" }",
            "omega_r_rad_s = { from = \"Drehzahl 2\", unit = \"rpm\" }",
            "f_perp_f_n = { from = \"p_cyl_1 bar\", unit = \"bar\", scale = 0.0789 }",
            "# \"driver\": not used; no numbers",
        ] {
            assert!(said.contains(line), "{line}\n{said}");
        }
        std::fs::write(&path, "v\n1\n2\n").expect("write");
        let said = proposal(&survey(&path).expect("a table"), str::to_owned);
        assert!(
            said.contains("# missing: t_s (s)") && said.contains("v_m_s = { from = \"v\", unit = \"m/s\" }"),
            "{said}"
        );
        assert!(said.contains("# doubt: v_m_s"), "{said}");
    }

    fn proposed(header: &str, row: impl Fn(f64) -> String) -> String {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.csv");
        let rows: String = (0..100).map(|k| row(f64::from(k))).collect();
        std::fs::write(&path, format!("{header}\n{rows}")).expect("write");
        proposal(&survey(&path).expect("a table"), str::to_owned)
    }

    #[test]
    fn units_of_the_header_are_taken_without_doubt() {
        let said =
            proposed("time [ms],speed [km/h],n1 [1/min],n2_rpm,p_cyl (kPa),torque kNm,gradient ‰", |k| {
                format!("{},{},300,300,{},1,2\n", 10.0 * k, 20.0, 3.0 * k)
            });
        for line in [
            "t_s = { from = \"time [ms]\", unit = \"ms\" }",
            "v_m_s = { from = \"speed [km/h]\", unit = \"km/h\" }",
            "omega_f_rad_s = { from = \"n1 [1/min]\", unit = \"1/min\" }",
            "omega_r_rad_s = { from = \"n2_rpm\", unit = \"rpm\" }",
            "unit = \"kPa\", scale = 0.101",
            "unit = \"kNm\" }",
            "unit = \"‰\" }",
        ] {
            assert!(said.contains(line), "{line}\n{said}");
        }
        // Only how a pressure presses cannot stand in a header.
        assert_eq!(said.matches("# doubt: ").count(), 1, "{said}");
        assert!(said.contains("# doubt: f_perp"), "{said}");
    }

    #[test]
    fn without_a_unit_the_figures_propose_one_and_the_doubt_is_said() {
        for (header, most, unit) in [
            ("speed", 40.0, "m/s"),
            ("speed", 140.0, "km/h"),
            ("wheel", 90.0, "rad/s"),
            ("wheel", 900.0, "rpm"),
            ("pressure", 3.8, "bar"),
            ("pressure", 380.0, "kPa"),
            ("pressure", 3_800.0, "mbar"),
            ("pressure", 380_000.0, "Pa"),
            ("f_perp", 30.0, "kN"),
            ("f_perp", 30_000.0, "N"),
            ("torque", 2_000.0, "N m"),
            ("slope", 15.0, "‰"),
            ("slope", 0.015, "rad"),
        ] {
            let said = proposed(&format!("t_s,{header}"), |k| format!("{},{}\n", 0.01 * k, most * k / 99.0));
            let line =
                said.lines().find(|line| line.contains(&format!("from = \"{header}\""))).expect("told");
            assert!(line.contains(&format!("unit = \"{unit}\"")), "{header} up to {most}: {said}");
            assert!(!line.contains("scale = 1.0 "), "{said}");
            assert!(said.contains("# doubt: "), "{header} up to {most}: {said}");
        }
    }

    #[test]
    fn signs_that_are_the_other_way_round_are_turned_and_said() {
        let said = proposed("t_s,speed m/s,m_w_f_nm,Moment 2 kNm,omega_f_rad_s,omega_r_rad_s,p mbar", |k| {
            let (speed, torque) = if k < 50.0 { (10.0 + k * 0.1, 1.5) } else { (20.0 - k * 0.1, -1.5) };
            format!(
                "{},{speed},{},{torque},{},{},3800\n",
                0.1 * k,
                -1000.0 * torque,
                2.0 * speed,
                -2.0 * speed
            )
        });
        for line in [
            "m_w_f_nm = { from = \"m_w_f_nm\", sign = -1.0 }",
            "# doubt: m_w_f_nm, drives while the wagon loses speed",
            "m_w_r_nm = { from = \"Moment 2 kNm\", unit = \"kNm\" }",
            "# omega_f_rad_s: has its name already",
            "omega_r_rad_s = { from = \"omega_r_rad_s\", sign = -1.0 }",
            "# doubt: omega_r_rad_s, turns backward while the wagon runs forward",
        ] {
            assert!(said.contains(line), "{line}\n{said}");
        }
        assert_eq!(said.matches("sign = ").count(), 2, "{said}");
    }

    #[test]
    fn values_that_their_named_unit_makes_unusual_are_doubted() {
        for (header, most, doubt) in [
            (
                "m_w_f_nm",
                3.2,
                "m_w_f_nm, named to be in N m, where at most 3.2 would be unusual; kN m would be usual",
            ),
            (
                "Moment [Nm]",
                3.2,
                "named to be in Nm, where at most 3.2 would be unusual; kN m would be usual",
            ),
            ("v_m_s", 140.0, "named to be in m/s, where at most 140 would be unusual; km/h would be usual"),
            (
                "p_cyl Pa",
                3800.0,
                "named to be in Pa, where at most 3800 would be unusual; mbar would be usual",
            ),
            ("f_perp_f_n", 30.0, "named to be in N, where at most 30 would be unusual; kN would be usual"),
            ("grade_rad", 25.0, "named to be in rad, where at most 25 would be unusual; ‰ would be usual"),
        ] {
            let said = proposed(&format!("t_s,{header}"), |k| format!("{},{}\n", 0.01 * k, most * k / 99.0));
            assert!(said.contains(doubt), "{header}: {said}");
        }
        let said = proposed("t_s,v_m_s,m_w_f_nm,grade_rad", |k| format!("{},20,0,0.004\n", 0.01 * k));
        assert!(!said.contains("doubt"), "{said}");
    }

    #[test]
    fn what_is_proposed_is_a_mapping_that_reads_the_file_in_si_units() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.csv");
        let rows: String = (0..8000).map(|k| format!("{},{},{}\n", 10 * k, 72, k % 100)).collect();
        std::fs::write(&path, format!("time ms,speed km/h,p_cyl bar\n{rows}")).expect("write");
        let surveyed = survey(&path).expect("a table");
        let minute = first_minute(&path, &surveyed).expect("a table");
        let speed = minute.iter().find(|one| one.to == "v_m_s").expect("speed");
        assert_eq!((speed.points.len(), speed.unit, speed.points[6000][0]), (6001, "m/s", 60.0));
        assert!(speed.points.iter().all(|point| (point[1] - 20.0).abs() < 1e-9));
        let force = minute.iter().find(|one| one.to.starts_with("f_perp")).expect("force");
        let most = force.points.iter().map(|point| point[1]).fold(0.0, f64::max);
        assert!((29_000.0..31_000.0).contains(&most), "{most}");
    }
}
