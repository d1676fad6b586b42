//! What an experiment leaves behind, and how it is told.

use crate::table::{Criterion, Table};
use std::path::PathBuf;

/// What an experiment leaves behind.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Paper against ours.
    pub table: Table,
    /// What must hold, and whether it does.
    pub criteria: Vec<Criterion>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

impl Report {
    /// Table and criteria as Markdown.
    pub fn markdown(&self, title: &str) -> String {
        let mut text = format!("# {title}\n\n{}", self.table.markdown());
        if !self.criteria.is_empty() {
            text.push_str("\n## Criteria\n\n");
            for criterion in &self.criteria {
                let verdict = if criterion.met { "met" } else { "NOT MET" };
                text.push_str(&format!("- {verdict}: {} ({})\n", criterion.name, criterion.figure));
            }
        }
        text
    }

    /// True if every criterion is met.
    pub fn all_met(&self) -> bool {
        self.criteria.iter().all(|criterion| criterion.met)
    }
}
