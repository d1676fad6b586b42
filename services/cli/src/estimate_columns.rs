//! The columns of a file of estimates, for `railgrip estimate` and for what `railgrip record` keeps beside recordings.
//!
//! | of | columns |
//! | --- | --- |
//! | a wagon | `t_s, v_m_s, mu_w, mu_w_sigma`, per wheelset `mu_b_*, mu_b_*_sigma`, then `slip_*`, `nis`, `observable_*` |
//! | the same in detail | and per wheelset `mu_w_*, mu_w_*_sigma, normal_load_*_n`, `mu_b_mean, mu_b_mean_sigma, state` |
//! | a wagon of a train (`drill replay`) | those of a wagon and per wheelset `mu_w_*, mu_w_*_sigma`; two wheelsets are numbered too |
//! | a roller rig | those of a wagon with one wheelset, and `state` |
//! | a traction rig | `t_s, v_m_s, mu_w, mu_w_sigma, mu_0, mu_0_sigma, creep_force_n, creep_force_n_sigma, slip_1, nis, observable_1, state` |
//!
//! | a bogie rig | those of a wagon, pad friction always empty, and `state` |
//!
//! `*` is `f` and `r` for two wheelsets, else numbers from the front. `state` is a word; on a traction or bogie rig a figure that
//! its state does not support is an empty cell. Until the filter of a wagon or roller rig has had its first measurements, all figures
//! are empty.

use railgrip_filter::PlantKind;
use railgrip_messages::{Estimate, EstimateState};
use railgrip_recording::suffix;

/// What stands in a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cell {
    /// A number; NaN is an empty cell.
    Number(f64),
    /// A word.
    Word(&'static str),
}

/// One column: its name, and what an estimate has to say there.
pub(crate) struct Column {
    /// Name in the header.
    pub(crate) name: String,
    wheelset: usize,
    read: fn(&Estimate, usize) -> Cell,
    /// Empty until the filter has begun: before, its figures are no more than zeros.
    waits: bool,
}

impl Column {
    fn new(name: impl Into<String>, read: fn(&Estimate, usize) -> Cell) -> Self {
        Self { name: name.into(), wheelset: 0, read, waits: false }
    }

    /// The cell of an estimate.
    pub(crate) fn cell(&self, estimate: &Estimate) -> Cell {
        // A filter that has begun knows the loads of the wheelsets.
        let begun = estimate.normal_load_n.iter().any(|load_n| *load_n > 0.0);
        if self.waits && !begun { Cell::Number(f64::NAN) } else { (self.read)(estimate, self.wheelset) }
    }
}

/// The columns for a plant.
pub(crate) fn columns(plant: PlantKind, wheelsets: usize, detail: bool) -> Vec<Column> {
    let mut columns = of_plant(plant, wheelsets, detail);
    if matches!(plant, PlantKind::Wagon | PlantKind::Roller) {
        let always = |name: &str| name == "t_s" || name == "state" || name.starts_with("observable_");
        columns.iter_mut().for_each(|column| column.waits = !always(&column.name));
    }
    columns
}

/// The columns of a wagon of a train: numbers only, and wheelsets by number, however many there are.
pub(crate) fn columns_of_train(wheelsets: usize) -> Vec<Column> {
    let mut columns = columns(PlantKind::Wagon, wheelsets, true);
    columns.retain(|column| {
        let name = column.name.as_str();
        name != "state" && !name.starts_with("normal_load") && !name.starts_with("mu_b_mean")
    });
    for column in &mut columns {
        let numbered = column.name.split('_').map(|part| match part {
            "f" => "1",
            "r" => "2",
            part => part,
        });
        column.name = numbered.collect::<Vec<_>>().join("_");
    }
    columns
}

fn of_plant(plant: PlantKind, wheelsets: usize, detail: bool) -> Vec<Column> {
    match plant {
        PlantKind::Traction => traction(),
        PlantKind::Wagon if !detail => wagon(wheelsets),
        PlantKind::Wagon => in_detail(wheelsets),
        PlantKind::Roller if !detail => {
            let mut columns = wagon(wheelsets);
            columns.push(Column::new("state", state));
            columns
        }
        PlantKind::Roller => in_detail(wheelsets),
        PlantKind::Bogie => bogie(wheelsets, detail),
    }
}

/// A name's parts before and after its suffix, and what is read into the column.
type Part<'a> = (&'a str, &'a str, fn(&Estimate, usize) -> Cell);

/// Columns of each wheelset.
fn each(columns: &mut Vec<Column>, wheelsets: usize, parts: &[Part<'_>]) {
    for wheelset in 0..wheelsets {
        for (before, after, read) in parts {
            let name = format!("{before}{}{after}", suffix(wheelset, wheelsets));
            columns.push(Column { name, wheelset, read: *read, waits: false });
        }
    }
}

fn motion() -> Vec<Column> {
    vec![
        Column::new("t_s", |e, _| Cell::Number(e.time_s)),
        Column::new("v_m_s", |e, _| Cell::Number(e.v_m_s)),
        Column::new("mu_w", |e, _| Cell::Number(e.mu_w)),
        Column::new("mu_w_sigma", |e, _| Cell::Number(e.mu_w_sigma)),
    ]
}

fn wagon(wheelsets: usize) -> Vec<Column> {
    let mut columns = motion();
    each(
        &mut columns,
        wheelsets,
        &[
            ("mu_b_", "", |e, i| Cell::Number(e.mu_b[i])),
            ("mu_b_", "_sigma", |e, i| Cell::Number(e.mu_b_sigma[i])),
        ],
    );
    each(&mut columns, wheelsets, &[("slip_", "", |e, i| Cell::Number(e.slip[i]))]);
    columns.push(Column::new("nis", |e, _| Cell::Number(e.nis)));
    each(&mut columns, wheelsets, &[("observable_", "", observable)]);
    columns
}

fn in_detail(wheelsets: usize) -> Vec<Column> {
    let mut columns = wagon(wheelsets);
    each(
        &mut columns,
        wheelsets,
        &[
            ("mu_w_", "", |e, i| Cell::Number(e.mu_w_wheelset[i])),
            ("mu_w_", "_sigma", |e, i| Cell::Number(e.mu_w_wheelset_sigma[i])),
            ("normal_load_", "_n", |e, i| Cell::Number(e.normal_load_n[i])),
        ],
    );
    columns.push(Column::new("mu_b_mean", |e, _| Cell::Number(e.mu_b_mean)));
    columns.push(Column::new("mu_b_mean_sigma", |e, _| Cell::Number(e.mu_b_mean_sigma)));
    columns.push(Column::new("state", state));
    columns
}

fn traction() -> Vec<Column> {
    let mut columns = motion();
    for column in &mut columns[2..] {
        column.read = match column.name.as_str() {
            "mu_w" => |e, _| unless_fault(e, e.mu_w),
            _ => |e, _| unless_fault(e, e.mu_w_sigma),
        };
    }
    columns.extend([
        Column::new("mu_0", |e, _| if_seen(e, e.adhesion_peak)),
        Column::new("mu_0_sigma", |e, _| if_seen(e, e.adhesion_peak_sigma)),
        Column::new("creep_force_n", |e, _| unless_fault(e, e.mu_w * e.normal_load_n[0])),
        Column::new("creep_force_n_sigma", |e, _| unless_fault(e, e.mu_w_sigma * e.normal_load_n[0])),
        Column::new("slip_1", |e, _| unless_fault(e, e.slip[0])),
        Column::new("nis", |e, _| Cell::Number(e.nis)),
        Column::new("observable_1", observable),
        Column::new("state", state),
    ]);
    columns
}

/// Figures by their state: no pad friction, and adhesion and slip each where they are told.
fn bogie(wheelsets: usize, detail: bool) -> Vec<Column> {
    let mut columns = if detail { in_detail(wheelsets) } else { wagon(wheelsets) };
    for column in &mut columns {
        let name = column.name.as_str();
        column.read = match name {
            _ if name.starts_with("mu_b") => |_, _| Cell::Number(f64::NAN),
            // Without the roller's counter the speed is one of before.
            "v_m_s" => |e, _| {
                use railgrip_filter::EstimateState as S;
                where_told(e, e.v_m_s, |state| {
                    !matches!(state, S::Starting | S::RollerCounterMissing | S::CountersSwapped)
                })
            },
            "mu_w" => |e, _| if_adhesion(e, e.mu_w),
            "mu_w_sigma" => |e, _| if_adhesion(e, e.mu_w_sigma),
            _ if name.starts_with("mu_w_") && name.ends_with("_sigma") => {
                |e, i| if_adhesion(e, e.mu_w_wheelset_sigma[i])
            }
            _ if name.starts_with("mu_w_") => |e, i| if_adhesion(e, e.mu_w_wheelset[i]),
            _ if name.starts_with("slip_") => |e, i| if_slip(e, e.slip[i]),
            _ => column.read,
        };
    }
    if !detail {
        columns.push(Column::new("state", state));
    }
    columns
}

fn observable(estimate: &Estimate, wheelset: usize) -> Cell {
    Cell::Number(f64::from(estimate.observable >> wheelset & 1))
}

fn state(estimate: &Estimate, _wheelset: usize) -> Cell {
    Cell::Word(estimate.state().map_or("unknown", EstimateState::word))
}

/// The number, where the state says that it is one.
fn where_told(estimate: &Estimate, value: f64, tells: fn(railgrip_filter::EstimateState) -> bool) -> Cell {
    let state = railgrip_filter::EstimateState::ALL.iter().find(|state| state.code() == estimate.state);
    Cell::Number(if state.is_some_and(|state| tells(*state)) { value } else { f64::NAN })
}

/// Bad input has a name and no figure.
fn unless_fault(estimate: &Estimate, value: f64) -> Cell {
    where_told(estimate, value, |state| !state.is_fault())
}

/// μ0 that nothing in the data speaks about is no figure.
fn if_seen(estimate: &Estimate, value: f64) -> Cell {
    where_told(estimate, value, railgrip_filter::EstimateState::tells_friction)
}

fn if_adhesion(estimate: &Estimate, value: f64) -> Cell {
    where_told(estimate, value, |state| state.tells_adhesion() && has_begun(state))
}

fn if_slip(estimate: &Estimate, value: f64) -> Cell {
    where_told(estimate, value, |state| state.tells_slip() && has_begun(state))
}

/// Before its first measurements a filter's figures are no more than zeros.
fn has_begun(state: railgrip_filter::EstimateState) -> bool {
    state != railgrip_filter::EstimateState::Starting
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(plant: PlantKind, wheelsets: usize, detail: bool) -> String {
        let columns = columns(plant, wheelsets, detail);
        columns.into_iter().map(|column| column.name).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn columns_are_those_of_the_design() {
        assert_eq!(
            names(PlantKind::Wagon, 2, false),
            "t_s, v_m_s, mu_w, mu_w_sigma, mu_b_f, mu_b_f_sigma, mu_b_r, mu_b_r_sigma, slip_f, slip_r, nis, \
             observable_f, observable_r"
        );
        assert!(names(PlantKind::Wagon, 2, true).ends_with("mu_b_mean, mu_b_mean_sigma, state"));
        assert!(names(PlantKind::Roller, 1, false).ends_with("slip_1, nis, observable_1, state"));
        assert_eq!(
            names(PlantKind::Traction, 1, false),
            "t_s, v_m_s, mu_w, mu_w_sigma, mu_0, mu_0_sigma, creep_force_n, creep_force_n_sigma, slip_1, nis, \
             observable_1, state"
        );
    }

    #[test]
    fn wheelsets_of_a_train_are_numbered() {
        let names: Vec<String> = columns_of_train(2).into_iter().map(|column| column.name).collect();
        assert_eq!(
            names.join(", "),
            "t_s, v_m_s, mu_w, mu_w_sigma, mu_b_1, mu_b_1_sigma, mu_b_2, mu_b_2_sigma, slip_1, slip_2, nis, \
             observable_1, observable_2, mu_w_1, mu_w_1_sigma, mu_w_2, mu_w_2_sigma"
        );
    }

    #[test]
    fn before_the_first_measurement_cells_are_empty_and_never_zero() {
        let columns = columns(PlantKind::Wagon, 2, true);
        let numbers = |estimate: &Estimate| -> Vec<&str> {
            let filled = columns
                .iter()
                .filter(|column| matches!(column.cell(estimate), Cell::Number(v) if !v.is_nan()));
            filled.map(|column| column.name.as_str()).collect()
        };
        assert_eq!(numbers(&Estimate::default()), ["t_s", "observable_f", "observable_r"]);
        let begun = Estimate { normal_load_n: [2e5, 2e5, 0.0, 0.0], ..Estimate::default() };
        assert_eq!(numbers(&begun).len(), columns.len() - 1);
    }

    #[test]
    fn a_bogies_figures_are_told_one_by_one() {
        let columns = columns(PlantKind::Bogie, 2, true);
        let told = |state: EstimateState| -> Vec<String> {
            let estimate = Estimate { state: state.code(), ..Estimate::default() };
            let told = columns
                .iter()
                .filter(|column| matches!(column.cell(&estimate), Cell::Number(value) if !value.is_nan()));
            told.map(|column| column.name.clone()).collect()
        };
        let has = |state, name: &str| told(state).contains(&name.to_owned());
        assert!(has(EstimateState::Observable, "mu_w") && has(EstimateState::Observable, "slip_r"));
        assert!(has(EstimateState::LoadCellMissing, "mu_w_f") && !has(EstimateState::ZeroLoad, "mu_w_f"));
        assert!(has(EstimateState::ForcesMissing, "slip_f") && !has(EstimateState::ForcesMissing, "mu_w"));
        assert!(has(EstimateState::Standstill, "mu_w") && !has(EstimateState::Standstill, "slip_f"));
        assert!(!has(EstimateState::Observable, "mu_b_f") && !has(EstimateState::Observable, "mu_b_mean"));
        assert!(has(EstimateState::Observable, "v_m_s") && has(EstimateState::Standstill, "v_m_s"));
        assert!(!has(EstimateState::Starting, "v_m_s") && !has(EstimateState::RollerCounterMissing, "v_m_s"));
        assert!(!has(EstimateState::WrongRate, "mu_w") && !has(EstimateState::WrongRate, "slip_f"));
    }

    #[test]
    fn a_state_that_says_nothing_leaves_no_figure() {
        let columns = columns(PlantKind::Traction, 1, false);
        let empty = |state: EstimateState| -> Vec<String> {
            let estimate =
                Estimate { state: state.code(), mu_w: 0.1, adhesion_peak: 0.2, ..Estimate::default() };
            let empty = columns
                .iter()
                .filter(|column| matches!(column.cell(&estimate), Cell::Number(value) if value.is_nan()));
            empty.map(|column| column.name.clone()).collect()
        };
        assert!(empty(EstimateState::Observable).is_empty());
        assert_eq!(empty(EstimateState::NoLoad), ["mu_0", "mu_0_sigma"]);
        let swapped = empty(EstimateState::PhasesSwapped);
        assert!(swapped.contains(&"creep_force_n".to_owned()) && swapped.contains(&"mu_w".to_owned()));
    }
}
