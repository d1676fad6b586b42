//! What no sensor sees, written beside a simulated run: `t_s, v_m_s, mu_w, mu_w_f, mu_w_r, mu_b_f, mu_b_r`.

use crate::columns::{MAX_WHEELSETS, TIME, suffix};
use crate::error::{Problem, Result};
use crate::table::Table;
use std::path::Path;

/// Columns before those of the wheelsets.
const FIXED: usize = 3;

/// One row of truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruthRow {
    /// Time on the recorder's base.
    pub t_s: f64,
    /// Vehicle speed.
    pub v_m_s: f64,
    /// Utilised adhesion of the wagon: sum of contact forces over sum of loads, negative in braking.
    pub mu_w: f64,
    /// Utilised adhesion of each wheelset, signed like its contact force.
    pub mu_w_wheelset: [f64; MAX_WHEELSETS],
    /// Effective pad friction of each wheelset: brake torque / (r_B · measured pressing force); NaN below 2 kN.
    pub mu_b: [f64; MAX_WHEELSETS],
}

/// The truth of one run, column by column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Truth {
    /// Time.
    pub t_s: Vec<f64>,
    /// Vehicle speed.
    pub v_m_s: Vec<f64>,
    /// Utilised adhesion of the wagon.
    pub mu_w: Vec<f64>,
    /// Utilised adhesion, a column a wheelset, front first.
    pub mu_w_wheelset: Vec<Vec<f64>>,
    /// Effective pad friction, a column a wheelset; NaN where the pressing force is below 2 kN.
    pub mu_b: Vec<Vec<f64>>,
}

impl Truth {
    /// Truth without rows.
    pub fn empty(wheelsets: usize) -> Self {
        let columns = vec![Vec::new(); wheelsets];
        Self { mu_w_wheelset: columns.clone(), mu_b: columns, ..Self::default() }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Adds a row.
    pub fn push(&mut self, row: &TruthRow) {
        self.t_s.push(row.t_s);
        self.v_m_s.push(row.v_m_s);
        self.mu_w.push(row.mu_w);
        for (wheelset, column) in self.mu_w_wheelset.iter_mut().enumerate() {
            column.push(row.mu_w_wheelset[wheelset]);
        }
        for (wheelset, column) in self.mu_b.iter_mut().enumerate() {
            column.push(row.mu_b[wheelset]);
        }
    }

    /// Reads a truth file of either form. Every cell but those of the pad friction must hold a finite number.
    pub fn read(path: &Path) -> Result<Self> {
        let mut table = Table::read_checked(path, &|names| {
            let wheelsets = wheelsets_of(names);
            let expected = names_of(wheelsets);
            if let Some(unknown) = names.iter().find(|name| !expected.contains(name)) {
                return Err((unknown.clone(), Problem::UnknownColumn { allowed: expected.join(", ") }));
            }
            match expected.iter().find(|name| !names.contains(name)) {
                Some(absent) => Err((absent.clone(), Problem::missing_column(names))),
                None => Ok(()),
            }
        })?;
        let wheelsets = wheelsets_of(table.names());
        let names = names_of(wheelsets);
        for name in &names[..FIXED + wheelsets] {
            table.require_finite(name)?;
        }
        let mut columns = names.iter().map(|name| table.take(name).unwrap_or_default());
        let mut next = || columns.next().unwrap_or_default();
        Ok(Self {
            t_s: next(),
            v_m_s: next(),
            mu_w: next(),
            mu_w_wheelset: (0..wheelsets).map(|_| next()).collect(),
            mu_b: (0..wheelsets).map(|_| next()).collect(),
        })
    }

    /// Writes the truth atomically; the ending of `path` names the form.
    pub fn write(&self, path: &Path) -> Result<()> {
        let cells =
            [&self.t_s, &self.v_m_s, &self.mu_w].into_iter().chain(&self.mu_w_wheelset).chain(&self.mu_b);
        let columns = names_of(self.mu_w_wheelset.len()).into_iter().zip(cells.cloned()).collect();
        Table::new(columns)?.write(path)
    }
}

fn names_of(wheelsets: usize) -> Vec<String> {
    let each = |what: &'static str| (0..wheelsets).map(move |at| format!("{what}_{}", suffix(at, wheelsets)));
    let fixed = [TIME, "v_m_s", "mu_w"].into_iter().map(str::to_owned);
    fixed.chain(each("mu_w")).chain(each("mu_b")).collect()
}

fn wheelsets_of(names: &[String]) -> usize {
    let numbered = |wheelset: &usize| names.contains(&format!("mu_w_{}", wheelset + 1));
    (0..MAX_WHEELSETS).rev().find(numbered).map_or(2, |highest| highest + 1)
}
