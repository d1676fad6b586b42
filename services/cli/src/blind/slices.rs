//! The score by slices: how far effects show, which forms they have, of which sort the case is, how the plant was built.

use std::{collections::BTreeMap, fmt::Write as _};

use railgrip_truth_plant::label::PlantOf;
use serde::Serialize;

use super::make::VISIBLE;
use super::outcome::{Outcome, Rate};

/// One row of a table of slices.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Slice {
    /// What the cases share.
    pub of: String,
    /// Cases in it.
    pub cases: usize,
    /// Answers that are right.
    pub right: Rate,
    /// First names that are right, of one effect.
    pub top_1: Rate,
    /// Right terms, of any effect.
    pub term: Rate,
    /// Unknowns called unknown.
    pub unknown: Rate,
    /// All effects named, of two and three.
    pub several: Rate,
    /// Cases of which nothing is said.
    pub says_none: Rate,
    /// First names that are wrong, of all cases.
    pub false_name: Rate,
}

impl Slice {
    fn of(of: String, outcomes: &[&Outcome]) -> Self {
        let all = || outcomes.iter().copied();
        let some =
            |kinds: &'static [&'static str]| all().filter(move |outcome| kinds.contains(&outcome.kind()));
        Self {
            of,
            cases: outcomes.len(),
            right: Rate::count(all(), Outcome::is_right),
            top_1: Rate::count(some(&["single"]), |outcome| outcome.first_is_right()),
            term: Rate::count(all().filter(|outcome| outcome.kind() != "none"), Outcome::term_is_right),
            unknown: Rate::count(some(&["withheld", "nameless"]), Outcome::says_unknown),
            several: Rate::count(some(&["pair", "triple"]), Outcome::all_are_named),
            says_none: Rate::count(all(), Outcome::says_none),
            false_name: Rate::count(all(), |outcome| {
                !outcome.effects().is_empty() && !outcome.first_is_right()
            }),
        }
    }
}

/// A named table of slices.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Table {
    /// By what the cases are parted.
    pub by: &'static str,
    /// Its rows.
    pub slices: Vec<Slice>,
}

impl Table {
    fn new(by: &'static str, outcomes: &[Outcome], key: impl Fn(&Outcome) -> Vec<String>) -> Self {
        let mut parts: BTreeMap<String, Vec<&Outcome>> = BTreeMap::new();
        for outcome in outcomes {
            for key in key(outcome) {
                parts.entry(key).or_default().push(outcome);
            }
        }
        Self { by, slices: parts.into_iter().map(|(of, part)| Slice::of(of, &part)).collect() }
    }
}

/// The bin of salience in which a case lies.
pub(super) fn salience_bin(outcome: &Outcome) -> &'static str {
    match outcome.made.label.salience() {
        _ if outcome.made.label.effects.is_empty() => "0 no effect",
        salience if salience < VISIBLE => "1 below 1.1 (cannot be seen)",
        salience if salience < 1.5 => "2 1.1 to 1.5",
        salience if salience < 3.0 => "3 1.5 to 3",
        _ => "4 above 3",
    }
}

/// All tables of slices.
pub(super) fn tables(outcomes: &[Outcome]) -> Vec<Table> {
    let plant = |outcome: &Outcome, read: &dyn Fn(&PlantOf) -> Vec<String>| {
        outcome.made.label.plant.as_ref().map(read).unwrap_or_default()
    };
    vec![
        Table::new("salience", outcomes, |outcome| vec![salience_bin(outcome).to_owned()]),
        Table::new("set of forms", outcomes, |outcome| plant(outcome, &|plant| vec![plant.set.clone()])),
        Table::new("kind", outcomes, |outcome| vec![outcome.kind().to_owned()]),
        Table::new("noise", outcomes, |outcome| plant(outcome, &|plant| plant.noise.clone())),
        Table::new("rate", outcomes, |outcome| {
            plant(outcome, &|plant| vec![format!("{:3} Hz", plant.rate_hz)])
        }),
        Table::new("wheelsets", outcomes, |outcome| {
            plant(outcome, &|plant| vec![plant.wheelsets.to_string()])
        }),
        Table::new("creep law", outcomes, |outcome| plant(outcome, &|plant| vec![plant.creep_law.clone()])),
        Table::new("integration", outcomes, |outcome| {
            plant(outcome, &|plant| vec![plant.integrator.clone()])
        }),
        Table::new("form of a visible single effect", outcomes, |outcome| {
            let single = outcome.kind() == "single" && outcome.is_visible();
            let forms = outcome.made.label.effects.iter();
            let name = |effect: &railgrip_truth_plant::label::LabelledEffect| {
                format!("{} {} ({})", effect.id, effect.form, effect.set)
            };
            if single { forms.map(name).collect() } else { Vec::new() }
        }),
    ]
}

/// The tables for people.
pub(super) fn markdown(tables: &[Table]) -> String {
    let mut text = String::new();
    for table in tables {
        let _ = write!(
            text,
            "\n## By {}\n\n| | cases | right | top-1, one effect | term | unknown called so | all of several named | says none | first name wrong |\n\
             | --- | ---: | --- | --- | --- | --- | --- | --- | --- |\n",
            table.by
        );
        for slice in &table.slices {
            let rates = [
                slice.right,
                slice.top_1,
                slice.term,
                slice.unknown,
                slice.several,
                slice.says_none,
                slice.false_name,
            ];
            let cells = rates.map(|rate| rate.to_string()).join(" | ");
            let _ = writeln!(text, "| {} | {} | {cells} |", slice.of, slice.cases);
        }
    }
    text
}
