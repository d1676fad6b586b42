//! A file whose columns have other names or units, as a table of the columns of a run.

use crate::checks::check_required;
use crate::columns::{columns_of_run, usual_name, wheelsets_of_header};
use crate::csv_form::Missing;
use crate::error::{Problem, Result};
use crate::mapping::{Mapping, Rule};
use crate::table::Table;
use std::path::Path;

/// Reads the columns that the mapping names, and those that have the names of a run already; others are left out.
pub(crate) fn mapped(path: &Path, mapping: &Mapping) -> Result<Table> {
    let choose = |names: &[String]| {
        if let Some(absent) = mapping.inputs().find(|input| !names.iter().any(|name| name == input)) {
            return Err((absent.to_owned(), Problem::missing_column(names)));
        }
        let targets = targets(names, mapping);
        check_required(&targets)?;
        let own =
            |name: &String| targets.contains(name) && !mapping.rules.iter().any(|rule| rule.to == *name);
        Ok(names.iter().map(|name| own(name) || mapping.inputs().any(|input| input == name)).collect())
    };
    let mut read = Table::read_chosen(path, &choose, Missing::AnyText)?;
    let (rows, targets) = (read.rows(), targets(read.names(), mapping));
    let mut columns = Vec::new();
    // Rules stand before the columns that stay as they are, which may be inputs too. An input goes with its last rule, so that a
    // large file is not held twice.
    for (index, name) in targets.iter().enumerate() {
        let Some(rule) = mapping.rules.get(index) else {
            columns.push(read.take(name).unwrap_or_default());
            continue;
        };
        let cell =
            |row: usize| rule.value(&mut |input| read.column(input).map_or(f64::NAN, |cells| cells[row]));
        columns.push((0..rows).map(cell).collect());
        let later: Vec<&str> = mapping.rules[index + 1..].iter().flat_map(Rule::inputs).collect();
        for input in rule.inputs().filter(|input| !later.contains(input)) {
            if !targets[mapping.rules.len()..].iter().any(|target| target == input) {
                read.remove(input);
            }
        }
    }
    read.replaced(targets, columns)
}

/// The columns of a run that a file has or that the mapping makes of it.
fn targets(names: &[String], mapping: &Mapping) -> Vec<String> {
    let mut targets: Vec<String> = mapping.rules.iter().map(|rule| rule.to.clone()).collect();
    let all: Vec<String> = names.iter().cloned().chain(targets.iter().cloned()).collect();
    let wheelsets = wheelsets_of_header(&all);
    let columns = columns_of_run(wheelsets);
    for name in names {
        let usual = usual_name(name, wheelsets);
        let of_run = columns.iter().any(|(_, _, column)| *column == usual);
        if of_run && !targets.iter().any(|target| usual_name(target, wheelsets) == usual) {
            targets.push(name.clone());
        }
    }
    targets
}
