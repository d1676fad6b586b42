//! What a file of unknown columns may mean: the figures of each column, and a mapping that fits its names and figures. A proposal for
//! people, who know their sensors.

use crate::columns::{Quantity, columns_of_run};
use crate::csv_form::Missing;
use crate::error::{Problem, Result};
use crate::table::Table;
use crate::table_file::Form;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

/// A column of a file, with what is in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Surveyed {
    /// Its name.
    pub name: String,
    /// Cells with a number, and their least and largest; nothing for a column that holds no numbers.
    pub figures: Option<(usize, f64, f64)>,
    /// The column of a run that it may be, and in which unit.
    pub guess: Option<(String, Option<&'static str>)>,
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
    let wheelsets = names.iter().filter(|name| kind(name) == Some(Quantity::WheelSpeed)).count().clamp(1, 4);
    let mut seen = std::collections::BTreeMap::new();
    let mut taken = BTreeSet::new();
    let surveyed = names.into_iter().map(|name| {
        let cells = source.cells(path, &name)?;
        let cells = cells.as_deref();
        let figures = cells.map(figures);
        let guess = cells.and_then(|cells| {
            let own = columns_of_run(wheelsets).into_iter().find(|(.., column)| *column == name);
            if let Some((_, _, column)) = own {
                return taken.insert(column.clone()).then_some((column, None));
            }
            let quantity = kind(&name)?;
            let number = seen.entry(quantity.column(0, 1)).or_insert(0_usize);
            let wheelset = if quantity.per_wheelset() { *number } else { 0 };
            *number += 1;
            let column = quantity.column(wheelset, wheelsets);
            let fits = (quantity.per_wheelset() && wheelset < wheelsets) || *number == 1;
            (fits && taken.insert(column.clone())).then(|| (column, unit(quantity, &name, cells)))
        });
        Ok(Surveyed { name, figures, guess })
    });
    surveyed.collect()
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

fn figures(cells: &[f64]) -> (usize, f64, f64) {
    let known = || cells.iter().copied().filter(|cell| cell.is_finite());
    (known().count(), known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max))
}

/// What a name speaks of, in English or German.
fn kind(name: &str) -> Option<Quantity> {
    let lower = name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| lower.contains(word));
    let parts: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).collect();
    let is = |words: &[&str]| parts.iter().any(|part| words.contains(part));
    if has(&["omega", "rpm", "drehzahl", "wheel", "axle", "achse"]) || is(&["n", "n1", "n2", "n3", "n4"]) {
        Some(Quantity::WheelSpeed)
    } else if has(&["press", "druck", "cyl", "f_perp"]) {
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

/// In which unit a column may be, by its name and figures; nothing where it may be in that of a run.
fn unit(quantity: Quantity, name: &str, cells: &[f64]) -> Option<&'static str> {
    let lower = name.to_lowercase();
    let (_, _, most) = figures(cells);
    match quantity {
        Quantity::Time => {
            let mut steps: Vec<f64> = cells.windows(2).map(|pair| pair[1] - pair[0]).collect();
            steps.sort_by(f64::total_cmp);
            let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
            [(1e6, "ns"), (1e3, "us"), (0.9, "ms")]
                .into_iter()
                .find(|(least, _)| step >= *least)
                .map(|(_, unit)| unit)
        }
        Quantity::Speed => (lower.contains("km") || most > 70.0).then_some("km/h"),
        Quantity::WheelSpeed if lower.contains("km") => Some("km/h"),
        Quantity::WheelSpeed => {
            (lower.contains("rpm") || lower.contains("min") || most > 250.0).then_some("rpm")
        }
        Quantity::PressingForce if lower.contains("kn") => Some("kN"),
        Quantity::PressingForce => (lower.contains("bar") || most < 20.0).then_some("bar"),
        Quantity::DriveTorque => lower.contains("kn").then_some("kN m"),
        Quantity::Position => lower.contains("km").then_some("km"),
        _ => None,
    }
}

/// The proposal as the table `[mapping]` of a config, with the figures of each column beside it.
#[must_use]
pub fn proposal(surveyed: &[Surveyed]) -> String {
    let mut lines = vec!["[mapping]".to_owned()];
    for column in surveyed {
        let figures = match column.figures {
            Some((count, least, most)) if count > 0 => format!("{count} numbers, {least} to {most}"),
            Some(_) => "empty".to_owned(),
            None => "no numbers".to_owned(),
        };
        let from = column.name.replace('\\', "\\\\").replace('"', "\\\"");
        lines.push(match &column.guess {
            Some((to, None)) if *to == column.name => format!("# {to}: has its name already; {figures}"),
            Some((to, unit)) => {
                let unit = unit.map_or_else(String::new, |unit| format!(", unit = \"{unit}\""));
                let scale = match unit.contains("bar") {
                    true => ", scale = 1.0",
                    false => "",
                };
                let hint =
                    if scale.is_empty() { "" } else { "; scale: m² of the cylinder × rigging ratio" };
                format!("{to} = {{ from = \"{from}\"{unit}{scale} }}    # {figures}{hint}")
            }
            None => format!("# \"{from}\": not used; {figures}"),
        });
    }
    let has = |quantity: Quantity| {
        let of = |to: &str| (1..=4).any(|wheelsets| quantity.column(0, wheelsets) == to);
        surveyed.iter().filter_map(|column| column.guess.as_ref()).any(|(to, _)| of(to))
    };
    for quantity in Quantity::ALL.into_iter().filter(|quantity| quantity.required() && !has(*quantity)) {
        lines.push(format!("# missing: {} ({})", quantity.column(0, 2), quantity.unit()));
    }
    lines.join("\n")
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
        let said = proposal(&surveyed);
        for line in [
            "t_s = { from = \"Zeitstempel\" }",
            "v_m_s = { from = \"Geschwindigkeit km/h\", unit = \"km/h\" }",
            "omega_f_rad_s = { from = \"Drehzahl 1\", unit = \"rpm\" }",
            "omega_r_rad_s = { from = \"Drehzahl 2\", unit = \"rpm\" }",
            "f_perp_f_n = { from = \"p_cyl_1 bar\", unit = \"bar\", scale = 1.0 }",
            "# \"driver\": not used; no numbers",
        ] {
            assert!(said.contains(line), "{line}\n{said}");
        }
        std::fs::write(&path, "v\n1\n2\n").expect("write");
        let said = proposal(&survey(&path).expect("a table"));
        assert!(said.contains("# missing: t_s (s)") && said.contains("v_m_s = { from = \"v\" }"), "{said}");
    }
}
