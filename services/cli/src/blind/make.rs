//! Which cases there are, and making them on disk with their twins.

use std::{
    fs,
    path::{Path, PathBuf},
};

use railgrip_truth_plant::{Case, Label, Recipe, case, files, random::Stream};
use serde::{Deserialize, Serialize};

use crate::CliError;
use crate::sealed::{digest::digest_of_folder, files::cannot_write};

/// Share of all cases whose id is taken out of the library.
const WITHHELD_SHARE: f64 = 0.12;
/// Each spans the model of the other, so that taking one out leaves the right answer in the library.
const NEVER_WITHHELD: [&str; 2] = ["headwind", "running_resistance"];

/// A case to be made.
pub(super) struct Order {
    recipe: Recipe,
    withheld: Option<String>,
}

/// A case on disk: what the score needs to know about it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Made {
    /// The answer.
    pub label: Label,
    /// Id that the diagnosis must do without.
    pub withheld: Option<String>,
    /// SHA-256 over the recordings, so that the seal ties labels to data.
    pub recordings_sha256: String,
}

impl Made {
    /// What a perfect diagnosis would name.
    pub(super) fn nameable(&self) -> Vec<&str> {
        let named = self.label.effects.iter().filter(|effect| effect.named);
        named.map(|effect| effect.id.as_str()).filter(|id| self.withheld.as_deref() != Some(id)).collect()
    }

    /// Whether the right answer holds an `unknown`.
    pub(super) fn is_unknown(&self) -> bool {
        self.withheld.is_some() || self.label.has_nameless()
    }
}

/// Folder of a case, of its twin.
pub(super) fn case_folder(out: &Path, name: &str) -> PathBuf {
    out.join("cases").join(name)
}

pub(super) fn twin_folder(out: &Path, name: &str) -> PathBuf {
    out.join("twins").join(name)
}

/// The deck of the plant, with some ids withheld.
pub(super) fn orders(cases: usize, seed: u64) -> Vec<Order> {
    let deck = case::deck(cases, seed);
    let named = |id: &str| railgrip_truth_plant::departures::Kind::of(id).is_some_and(|kind| kind.named);
    let may = |recipe: &Recipe| match recipe.departures.as_slice() {
        [id] => named(id) && !NEVER_WITHHELD.contains(&id.as_str()),
        _ => false,
    };
    let mut candidates: Vec<usize> = (0..deck.len()).filter(|index| may(&deck[*index])).collect();
    Stream::new(seed, "withheld", 0).shuffle(&mut candidates);
    candidates.truncate((WITHHELD_SHARE * cases as f64).round() as usize);
    let order = |(index, recipe): (usize, Recipe)| {
        let withheld = candidates.contains(&index).then(|| recipe.departures[0].clone());
        Order { recipe, withheld }
    };
    deck.into_iter().enumerate().map(order).collect()
}

/// Makes a case and its twin on disk. Labels stay in memory until they are opened.
pub(super) fn make(out: &Path, order: &Order) -> Result<Made, CliError> {
    let name = &order.recipe.name;
    let case = Case::make(&order.recipe).map_err(CliError::failed)?;
    let folder = case_folder(out, name);
    for stale in [folder.clone(), twin_folder(out, name)] {
        if stale.exists() {
            fs::remove_dir_all(&stale).map_err(|error| cannot_write(&stale, &error))?;
        }
    }
    let vehicle = case.sheet.to_toml();
    files::write_case(&folder, &vehicle, &case.runs).map_err(CliError::failed)?;
    files::write_case(&twin_folder(out, name), &vehicle, &case.twin).map_err(CliError::failed)?;
    let recordings_sha256 = digest_of_folder(&folder)?;
    Ok(Made { label: case.label, withheld: order.withheld.clone(), recordings_sha256 })
}
