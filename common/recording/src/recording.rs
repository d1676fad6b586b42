//! One run of one wagon: measured columns over time.

use crate::checks::{Strictness, check_columns, check_header};
use crate::columns::{MAX_WHEELSETS, Quantity, columns_of_run, usual_name, wheelsets_of_header};
use crate::error::{Problem, RecordingError, Result};
use crate::mapped_table::mapped;
use crate::mapping::Mapping;
use crate::run_name::{RailClass, RunFile};
use crate::table::Table;
use std::path::Path;

/// One row of a run. NaN = not measured, or no such column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time on the recorder's base.
    pub t_s: f64,
    /// Vehicle speed.
    pub v_m_s: f64,
    /// Angular speed of each wheelset, front first.
    pub wheel_speed_rad_s: [f64; MAX_WHEELSETS],
    /// Pad pressing force of each wheelset.
    pub pressing_force_n: [f64; MAX_WHEELSETS],
    /// Drive torque of each wheelset.
    pub drive_torque_nm: [f64; MAX_WHEELSETS],
    /// Slope, uphill positive.
    pub grade_rad: f64,
    /// 1 while sand is laid.
    pub sanding: f64,
    /// Position by satellite.
    pub position_m: f64,
    /// 1 while wheel-slide protection controls the wheelset.
    pub wsp_active: [f64; MAX_WHEELSETS],
    /// Mass that load sensors report, kg.
    pub load_kg: f64,
    /// Brake that is ordered, 0 to 1.
    pub brake_demand: f64,
}

impl Default for Row {
    fn default() -> Self {
        let none = [f64::NAN; MAX_WHEELSETS];
        Self {
            t_s: f64::NAN,
            v_m_s: f64::NAN,
            wheel_speed_rad_s: none,
            pressing_force_n: none,
            drive_torque_nm: none,
            grade_rad: f64::NAN,
            sanding: f64::NAN,
            position_m: f64::NAN,
            wsp_active: none,
            load_kg: f64::NAN,
            brake_demand: f64::NAN,
        }
    }
}

impl Row {
    /// The value of one column.
    pub fn get(&self, quantity: Quantity, wheelset: usize) -> f64 {
        match quantity {
            Quantity::Time => self.t_s,
            Quantity::Speed => self.v_m_s,
            Quantity::WheelSpeed => self.wheel_speed_rad_s[wheelset],
            Quantity::PressingForce => self.pressing_force_n[wheelset],
            Quantity::DriveTorque => self.drive_torque_nm[wheelset],
            Quantity::Grade => self.grade_rad,
            Quantity::Sanding => self.sanding,
            Quantity::Position => self.position_m,
            Quantity::WspActive => self.wsp_active[wheelset],
            Quantity::Load => self.load_kg,
            Quantity::BrakeDemand => self.brake_demand,
        }
    }

    /// The value of one column, to change it.
    pub fn get_mut(&mut self, quantity: Quantity, wheelset: usize) -> &mut f64 {
        match quantity {
            Quantity::Time => &mut self.t_s,
            Quantity::Speed => &mut self.v_m_s,
            Quantity::WheelSpeed => &mut self.wheel_speed_rad_s[wheelset],
            Quantity::PressingForce => &mut self.pressing_force_n[wheelset],
            Quantity::DriveTorque => &mut self.drive_torque_nm[wheelset],
            Quantity::Grade => &mut self.grade_rad,
            Quantity::Sanding => &mut self.sanding,
            Quantity::Position => &mut self.position_m,
            Quantity::WspActive => &mut self.wsp_active[wheelset],
            Quantity::Load => &mut self.load_kg,
            Quantity::BrakeDemand => &mut self.brake_demand,
        }
    }
}

/// Which optional columns a run has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Optional {
    /// `grade_rad`.
    pub grade: bool,
    /// `sanding`.
    pub sanding: bool,
    /// `position_m`.
    pub position: bool,
    /// `wsp_f`, `wsp_r`.
    pub wsp: bool,
    /// `load_kg`.
    pub load: bool,
    /// `brake_demand`.
    pub brake_demand: bool,
}

impl Optional {
    /// No column that may be missing.
    pub const NONE: Self =
        Self { grade: false, sanding: false, position: false, wsp: false, load: false, brake_demand: false };
    /// The columns of most recordings: slope, sand and position.
    pub const MEASURED: Self = Self { grade: true, sanding: true, position: true, ..Self::NONE };
    /// Every column.
    pub const ALL: Self = Self { wsp: true, load: true, brake_demand: true, ..Self::MEASURED };

    pub(crate) const fn has(self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::Grade => self.grade,
            Quantity::Sanding => self.sanding,
            Quantity::Position => self.position,
            Quantity::WspActive => self.wsp,
            Quantity::Load => self.load,
            Quantity::BrakeDemand => self.brake_demand,
            _ => true,
        }
    }
}

/// One run, column by column; all columns have the same length.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// `NAME.RAIL`, from the file's name.
    pub name: String,
    /// Rail class from the file's name.
    pub rail: Option<RailClass>,
    /// Number of wheelsets, 1 to [`MAX_WHEELSETS`].
    pub wheelsets: usize,
    /// Time.
    pub t_s: Vec<f64>,
    /// Vehicle speed.
    pub v_m_s: Vec<f64>,
    /// Angular speed, a column a wheelset, front first.
    pub wheel_speed_rad_s: Vec<Vec<f64>>,
    /// Pad pressing force, a column a wheelset.
    pub pressing_force_n: Vec<Vec<f64>>,
    /// Drive torque, a column a wheelset; zero throughout where the file has none, as of a trailer.
    pub drive_torque_nm: Vec<Vec<f64>>,
    /// Slope, uphill positive.
    pub grade_rad: Option<Vec<f64>>,
    /// 1 while sand is laid.
    pub sanding: Option<Vec<f64>>,
    /// Position by satellite.
    pub position_m: Option<Vec<f64>>,
    /// 1 while wheel-slide protection is active, a column a wheelset.
    pub wsp_active: Option<Vec<Vec<f64>>>,
    /// Mass that load sensors report, kg.
    pub load_kg: Option<Vec<f64>>,
    /// Brake that is ordered, 0 to 1.
    pub brake_demand: Option<Vec<f64>>,
}

impl Recording {
    /// An empty run to push rows into.
    pub fn empty(name: &str, rail: Option<RailClass>, wheelsets: usize, optional: Optional) -> Self {
        let column = |wanted: bool| wanted.then(Vec::new);
        let per_wheelset = || vec![Vec::new(); wheelsets];
        Self {
            name: name.to_owned(),
            rail,
            wheelsets,
            t_s: Vec::new(),
            v_m_s: Vec::new(),
            wheel_speed_rad_s: per_wheelset(),
            pressing_force_n: per_wheelset(),
            drive_torque_nm: per_wheelset(),
            grade_rad: column(optional.grade),
            sanding: column(optional.sanding),
            position_m: column(optional.position),
            wsp_active: optional.wsp.then(per_wheelset),
            load_kg: column(optional.load),
            brake_demand: column(optional.brake_demand),
        }
    }

    /// Reads and checks a run; the ending of `path` names the form.
    pub fn read(path: &Path, strictness: Strictness) -> Result<Self> {
        let name = RunFile::of(path)?;
        Self::from_table(Table::read_checked(path, &check_header)?, name, strictness)
    }

    /// Reads and checks a run whose columns have other names or units.
    pub fn read_mapped(path: &Path, mapping: &Mapping, strictness: Strictness) -> Result<Self> {
        if mapping.is_empty() {
            return Self::read(path, strictness);
        }
        let name = RunFile::of(path)?;
        Self::from_table(mapped(path, mapping)?, name, strictness)
    }

    /// Reads and checks CSV text from memory or a pipe; `label` stands for the file in messages and gives the name.
    pub fn read_csv(source: impl std::io::Read, label: &Path, strictness: Strictness) -> Result<Self> {
        Self::from_table(Table::read_csv(source, label, &check_header)?, RunFile::of(label)?, strictness)
    }

    fn from_table(mut table: Table, run: RunFile, strictness: Strictness) -> Result<Self> {
        let wheelsets = wheelsets_of_header(table.names());
        table.rename(|name| usual_name(name, wheelsets));
        check_columns(&table, wheelsets, strictness)?;
        let rows = table.rows();
        let mut recording = Self::empty(&run.name, run.rail, wheelsets, Optional::ALL);
        for (quantity, wheelset, name) in columns_of_run(wheelsets) {
            match table.take(&name) {
                Some(mut cells) => {
                    cells.iter_mut().filter(|cell| !cell.is_finite()).for_each(|cell| *cell = f64::NAN);
                    if let Some(column) = recording.column_mut(quantity, wheelset) {
                        *column = cells;
                    }
                }
                None if quantity == Quantity::DriveTorque => {
                    recording.drive_torque_nm[wheelset] = vec![0.0; rows];
                }
                None => recording.drop_optional(quantity),
            }
        }
        Ok(recording)
    }

    fn drop_optional(&mut self, quantity: Quantity) {
        match quantity {
            Quantity::Grade => self.grade_rad = None,
            Quantity::Sanding => self.sanding = None,
            Quantity::Position => self.position_m = None,
            Quantity::WspActive => self.wsp_active = None,
            Quantity::Load => self.load_kg = None,
            Quantity::BrakeDemand => self.brake_demand = None,
            _ => {}
        }
    }

    /// Writes the run atomically; the ending of `path` names the form.
    pub fn write(&self, path: &Path) -> Result<()> {
        let columns = columns_of_run(self.wheelsets)
            .into_iter()
            .filter_map(|(quantity, wheelset, name)| Some((name, self.column(quantity, wheelset)?.to_vec())));
        Table::new(columns.collect()).and_then(|table| table.write(path)).map_err(|mut error| {
            error.file = path.to_owned();
            error
        })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Time from the first row to the last.
    pub fn duration_s(&self) -> f64 {
        self.t_s.last().zip(self.t_s.first()).map_or(0.0, |(last, first)| last - first)
    }

    /// Mean sample rate; 0 for less than two rows.
    pub fn sample_rate_hz(&self) -> f64 {
        let duration_s = self.duration_s();
        if duration_s > 0.0 { (self.len() - 1) as f64 / duration_s } else { 0.0 }
    }

    /// One row; panics when `row` is not below [`Recording::len`].
    pub fn row(&self, row: usize) -> Row {
        let spread = |columns: &[Vec<f64>]| {
            let mut values = [f64::NAN; MAX_WHEELSETS];
            for (value, column) in values.iter_mut().zip(columns) {
                *value = column[row];
            }
            values
        };
        let maybe = |column: &Option<Vec<f64>>| column.as_ref().map_or(f64::NAN, |column| column[row]);
        Row {
            t_s: self.t_s[row],
            v_m_s: self.v_m_s[row],
            wheel_speed_rad_s: spread(&self.wheel_speed_rad_s),
            pressing_force_n: spread(&self.pressing_force_n),
            drive_torque_nm: spread(&self.drive_torque_nm),
            grade_rad: maybe(&self.grade_rad),
            sanding: maybe(&self.sanding),
            position_m: maybe(&self.position_m),
            wsp_active: self.wsp_active.as_deref().map_or([f64::NAN; MAX_WHEELSETS], spread),
            load_kg: maybe(&self.load_kg),
            brake_demand: maybe(&self.brake_demand),
        }
    }

    /// All rows in order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = Row> + '_ {
        (0..self.len()).map(|row| self.row(row))
    }

    /// Adds a row; values of columns that this run has not are left out.
    pub fn push(&mut self, row: &Row) {
        for quantity in Quantity::ALL {
            let count = if quantity.per_wheelset() { self.wheelsets } else { 1 };
            for wheelset in 0..count {
                if let Some(column) = self.column_mut(quantity, wheelset) {
                    column.push(row.get(quantity, wheelset));
                }
            }
        }
    }

    /// One column, if the run has it.
    pub fn column(&self, quantity: Quantity, wheelset: usize) -> Option<&[f64]> {
        let column = match quantity {
            Quantity::Time => Some(&self.t_s),
            Quantity::Speed => Some(&self.v_m_s),
            Quantity::WheelSpeed => self.wheel_speed_rad_s.get(wheelset),
            Quantity::PressingForce => self.pressing_force_n.get(wheelset),
            Quantity::DriveTorque => self.drive_torque_nm.get(wheelset),
            Quantity::Grade => self.grade_rad.as_ref(),
            Quantity::Sanding => self.sanding.as_ref(),
            Quantity::Position => self.position_m.as_ref(),
            Quantity::WspActive => self.wsp_active.as_ref().and_then(|columns| columns.get(wheelset)),
            Quantity::Load => self.load_kg.as_ref(),
            Quantity::BrakeDemand => self.brake_demand.as_ref(),
        };
        column.map(Vec::as_slice)
    }

    pub(crate) fn column_mut(&mut self, quantity: Quantity, wheelset: usize) -> Option<&mut Vec<f64>> {
        match quantity {
            Quantity::Time => Some(&mut self.t_s),
            Quantity::Speed => Some(&mut self.v_m_s),
            Quantity::WheelSpeed => self.wheel_speed_rad_s.get_mut(wheelset),
            Quantity::PressingForce => self.pressing_force_n.get_mut(wheelset),
            Quantity::DriveTorque => self.drive_torque_nm.get_mut(wheelset),
            Quantity::Grade => self.grade_rad.as_mut(),
            Quantity::Sanding => self.sanding.as_mut(),
            Quantity::Position => self.position_m.as_mut(),
            Quantity::WspActive => self.wsp_active.as_mut().and_then(|columns| columns.get_mut(wheelset)),
            Quantity::Load => self.load_kg.as_mut(),
            Quantity::BrakeDemand => self.brake_demand.as_mut(),
        }
    }

    /// Moves all cells out in the order of a file's columns; the run stays, empty.
    pub(crate) fn take_columns(&mut self) -> Vec<Vec<f64>> {
        let mut columns = Vec::new();
        for (quantity, wheelset, _) in columns_of_run(self.wheelsets) {
            columns.extend(self.column_mut(quantity, wheelset).map(std::mem::take));
        }
        columns
    }

    /// Fails unless the run was sampled at `expected_hz`, give or take 1 %.
    pub fn require_rate(&self, file: &Path, expected_hz: f64) -> Result<()> {
        let found_hz = self.sample_rate_hz();
        if (found_hz / expected_hz - 1.0).abs() <= 0.01 {
            return Ok(());
        }
        Err(RecordingError::new(file, Problem::Rate { found_hz, expected_hz }))
    }
}
