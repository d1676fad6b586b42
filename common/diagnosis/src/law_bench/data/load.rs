//! Reads and checks a law-level case: `bench.toml`, `fit/*.csv`, `holdout/*.csv`.

use super::case::{Kind, LawCase, Nominal, PointSet};
use super::error::LawCaseError;
use super::point::Point;
use railgrip_recording::{Problem, RecordingError, Table, expect_columns, runs_in};
use serde::Deserialize;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// Fewest points on which anything can be said.
const FEWEST_POINTS: usize = 12;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BenchFile {
    schema: Spanned<u32>,
    kind: Spanned<String>,
    #[serde(rename = "nominal")]
    _nominal: toml::Table,
    #[serde(default)]
    sensors: SensorsTable,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorsTable {
    sigma: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Head<N> {
    #[serde(rename = "schema")]
    _schema: u32,
    #[serde(rename = "kind")]
    _kind: String,
    nominal: N,
    #[serde(default, rename = "sensors")]
    _sensors: SensorsTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CreepTable {
    mu0: Spanned<f64>,
    stiffness_n: Spanned<f64>,
    k_a: Spanned<f64>,
    k_s: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BrakeTable {
    friction_coefficient: Spanned<f64>,
}

/// A column with its allowed range.
struct Column {
    name: &'static str,
    low: f64,
    high: f64,
    unit: &'static str,
    required: bool,
    put: fn(&mut Point, f64),
}

const CREEP_COLUMNS: &[Column] = &[
    Column { name: "creepage", low: -2.0, high: 2.0, unit: "", required: true, put: |p, x| p.creepage = x },
    Column { name: "load_n", low: 1e-3, high: 1e6, unit: "N", required: true, put: |p, x| p.load_n = x },
    Column { name: "force_n", low: -1e6, high: 1e6, unit: "N", required: true, put: |p, x| p.measured = x },
    Column {
        name: "speed_m_s",
        low: -200.0,
        high: 200.0,
        unit: "m/s",
        required: false,
        put: |p, x| p.speed_m_s = x,
    },
];

const BRAKE_COLUMNS: &[Column] = &[
    Column { name: "mu", low: -0.5, high: 2.0, unit: "", required: true, put: |p, x| p.measured = x },
    Column {
        name: "speed_m_s",
        low: -200.0,
        high: 200.0,
        unit: "m/s",
        required: false,
        put: |p, x| p.speed_m_s = x,
    },
    Column {
        name: "temperature_c",
        low: -100.0,
        high: 2000.0,
        unit: "°C",
        required: false,
        put: |p, x| p.temperature_c = x,
    },
    Column {
        name: "pressing_force_n",
        low: 0.0,
        high: 1e6,
        unit: "N",
        required: false,
        put: |p, x| p.pressing_force_n = x,
    },
];

/// Reads and checks a case.
pub fn load(folder: &Path) -> Result<LawCase, LawCaseError> {
    let file = folder.join("bench.toml");
    let text = railgrip_recording::read_text(&file)
        .map_err(|source| LawCaseError::Io { file: file.clone(), source })?;
    let toml = Source { file: &file, text: &text };
    let (kind, nominal, sigma) = toml.read()?;
    let columns = match kind {
        Kind::Creep => CREEP_COLUMNS,
        Kind::Brake => BRAKE_COLUMNS,
    };
    let mut names = None;
    let fit = read_set(&folder.join("fit"), columns, &mut names)?;
    let holdout = read_set(&folder.join("holdout"), columns, &mut names)?;
    if fit.points.len() < FEWEST_POINTS {
        let (folder, found) = (folder.join("fit"), fit.points.len());
        return Err(LawCaseError::TooFew { folder, found, needed: FEWEST_POINTS });
    }
    let name = folder
        .canonicalize()
        .ok()
        .as_deref()
        .unwrap_or(folder)
        .file_name()
        .map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned());
    Ok(LawCase { name, kind, nominal, sigma, fit, holdout })
}

struct Source<'a> {
    file: &'a Path,
    text: &'a str,
}

impl Source<'_> {
    fn parse<T: serde::de::DeserializeOwned>(&self) -> Result<T, LawCaseError> {
        toml::from_str(self.text).map_err(|error| {
            let (line, column) = self.position(error.span().map_or(0, |span| span.start));
            let message = error.message().replace('\n', "; ");
            LawCaseError::Form { file: self.file.to_owned(), line, column, message }
        })
    }

    fn position(&self, offset: usize) -> (usize, usize) {
        let before = &self.text[..self.text.floor_char_boundary(offset)];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[start..].chars().count() + 1)
    }

    fn refuse(&self, key: &'static str, at: Range<usize>, value: String, allowed: &str) -> LawCaseError {
        let line = self.position(at.start).0;
        LawCaseError::Value { file: self.file.to_owned(), line, key, value, allowed: allowed.to_owned() }
    }

    fn within(
        &self,
        key: &'static str,
        value: &Spanned<f64>,
        low: f64,
        high: f64,
    ) -> Result<f64, LawCaseError> {
        let x = *value.get_ref();
        if (low..=high).contains(&x) {
            return Ok(x);
        }
        Err(self.refuse(key, value.span(), x.to_string(), &format!("{low} to {high}")))
    }

    fn read(&self) -> Result<(Kind, Nominal, Option<f64>), LawCaseError> {
        let head: BenchFile = self.parse()?;
        if *head.schema.get_ref() != 1 {
            return Err(self.refuse("schema", head.schema.span(), head.schema.get_ref().to_string(), "1"));
        }
        let (kind, nominal) = match head.kind.get_ref().as_str() {
            "creep" => (Kind::Creep, self.creep()?),
            "brake" => (Kind::Brake, self.brake()?),
            other => {
                return Err(self.refuse(
                    "kind",
                    head.kind.span(),
                    format!("\"{other}\""),
                    "\"creep\" or \"brake\"",
                ));
            }
        };
        let high = if kind == Kind::Creep { 1e5 } else { 1.0 };
        let sigma = head.sensors.sigma.map(|sigma| self.within("sensors.sigma", &sigma, 1e-9, high));
        Ok((kind, nominal, sigma.transpose()?))
    }

    fn creep(&self) -> Result<Nominal, LawCaseError> {
        let table = self.parse::<Head<CreepTable>>()?.nominal;
        Ok(Nominal::Creep {
            mu0: self.within("nominal.mu0", &table.mu0, 1e-3, 2.0)?,
            stiffness_n: self.within("nominal.stiffness_n", &table.stiffness_n, 1e2, 1e10)?,
            k_a: self.within("nominal.k_a", &table.k_a, 1e-3, 10.0)?,
            k_s: self.within("nominal.k_s", &table.k_s, 1e-3, 10.0)?,
        })
    }

    fn brake(&self) -> Result<Nominal, LawCaseError> {
        let table = self.parse::<Head<BrakeTable>>()?.nominal;
        let friction_coefficient =
            self.within("nominal.friction_coefficient", &table.friction_coefficient, 1e-3, 2.0)?;
        Ok(Nominal::Brake { friction_coefficient })
    }
}

/// Reads a folder; `first` holds the column names of the first file, which all files must have.
fn read_set(
    folder: &Path,
    columns: &[Column],
    first: &mut Option<Vec<String>>,
) -> Result<PointSet, LawCaseError> {
    let pick = |required: bool| -> Vec<&'static str> {
        columns.iter().filter(|column| column.required == required).map(|column| column.name).collect()
    };
    let (required, optional) = (pick(true), pick(false));
    let check = expect_columns(&required, &optional);
    let mut set = PointSet::default();
    for run in runs_in(folder)? {
        let table = Table::read_checked(&run.path, &check)?;
        let mut names = table.names().to_vec();
        names.sort();
        let wanted = first.get_or_insert_with(|| names.clone());
        if let Some(name) = wanted.iter().find(|name| !names.contains(name)) {
            let problem = Problem::MissingColumn { found: table.names().join(", ") };
            return Err(table.cell_error(0, name, problem).into());
        }
        if let Some(name) = names.iter().find(|name| !wanted.contains(name)) {
            let problem = Problem::UnknownColumn { allowed: wanted.join(", ") + " as in the first file" };
            return Err(table.cell_error(0, name, problem).into());
        }
        append(&mut set, &table, columns)?;
        set.files.push(run.name);
    }
    Ok(set)
}

fn append(set: &mut PointSet, table: &Table, columns: &[Column]) -> Result<(), LawCaseError> {
    let rows = table.rows();
    if rows == 0 {
        let file = table.file().to_owned();
        return Err(RecordingError { file, place: None, column: None, problem: Problem::EmptyRun }.into());
    }
    let file = set.files.len();
    let start = set.points.len();
    set.points.extend((0..rows).map(|row| Point {
        file,
        sequence: row as f64 / (rows.max(2) - 1) as f64,
        creepage: f64::NAN,
        load_n: f64::NAN,
        speed_m_s: f64::NAN,
        temperature_c: f64::NAN,
        pressing_force_n: f64::NAN,
        measured: f64::NAN,
    }));
    for column in columns {
        let Some(cells) = table.column(column.name) else { continue };
        table.require_finite(column.name)?;
        for (row, &value) in cells.iter().enumerate() {
            if !(column.low..=column.high).contains(&value) {
                let (low, high, unit) = (column.low, column.high, column.unit);
                let problem = Problem::OutOfRange { value, low, high, unit };
                return Err(table.cell_error(row, column.name, problem).into());
            }
            (column.put)(&mut set.points[start + row], value);
        }
    }
    Ok(())
}
