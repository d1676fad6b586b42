//! Which cases there are, and making them on disk with their twins.

use std::{
    fs,
    path::{Path, PathBuf},
};

use railgrip_diagnosis::decide::learning::Truth;
use railgrip_truth_plant::{
    FamilyCase, FamilyRecipe, Label,
    family::{Forms, effect, family_deck},
    random::Stream,
};
use railgrip_vehicle::effects;
use serde::{Deserialize, Serialize};

use super::meaning;
use crate::CliError;
use crate::sealed::{digest::digest_of_folder, files::cannot_write};

/// Salience from which an effect can be seen at all.
pub(crate) const VISIBLE: f64 = 1.1;
/// The same of one that shows clearly.
pub(super) const CLEAR: f64 = 1.4;
/// Share of all cases whose id is taken out of the library.
const WITHHELD_SHARE: f64 = 0.12;
/// Another one spans the model of each, so that taking it out leaves the right answer in the library: wheels that are all worn
/// read as a vehicle speed of another scale.
const NEVER_WITHHELD: [&str; 3] = ["headwind", "running_resistance", "speed_scale"];
/// Ids of the plant that are a value of a discrete parameter in the library: wheelset 0 is all of them.
const CALLED: [(&str, &str); 1] = [("wheel_radius_all", "wheel_radius")];

/// A case to be made.
pub(super) struct Order {
    /// What is wrong with which vehicle.
    pub(super) recipe: FamilyRecipe,
    withheld: Option<String>,
}

/// A case on disk: what the score needs to know about it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Made {
    /// The answer.
    pub label: Label,
    /// Id that the diagnosis must do without.
    pub withheld: Option<String>,
    /// SHA-256 over the recordings, so that the seal ties labels to data.
    pub recordings_sha256: String,
}

impl Made {
    /// What was at work, for whoever learns from it.
    pub(crate) fn truth(&self) -> Truth {
        let visible = !self.label.effects.is_empty() && self.label.salience() >= VISIBLE;
        let owned = |ids: Vec<&str>| ids.into_iter().map(str::to_owned).collect::<Vec<String>>();
        let showing = self.showing();
        let hidden = self.nameable().into_iter().filter(|id| !showing.contains(id)).collect();
        Truth {
            effects: owned(self.nameable()),
            hidden: owned(hidden),
            unknown: self.is_unknown(),
            visible,
            values: self.label.effects.iter().filter_map(meaning::true_value).collect(),
        }
    }

    /// What a perfect diagnosis would name and what shows beside the others: without one of them the gap is smaller by a tenth.
    /// Where nothing stands beside it, an effect shows as far as it does.
    pub(super) fn showing(&self) -> Vec<&str> {
        let label = &self.label;
        let shows = |id: &&str| {
            label.effects.iter().any(|effect| {
                effect.id == *id && (label.effects.len() == 1 || label.salience_of(effect) >= VISIBLE)
            })
        };
        self.nameable().into_iter().filter(shows).collect()
    }

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

/// Whether an effect of the plant has an id in the library: the contract's, and what the catalogue has gained since.
fn is_named(id: &str) -> bool {
    effect(id).is_some_and(|effect| effect.named) || effects::find(id).is_some()
}

/// The deck of the family, with some ids withheld.
pub(super) fn orders(cases: usize, seed: u64, forms: Forms) -> Vec<Order> {
    let deck = family_deck(cases, seed, forms);
    let may = |recipe: &FamilyRecipe| match recipe.effects.as_slice() {
        [effect] => is_named(&effect.id) && !NEVER_WITHHELD.contains(&effect.id.as_str()),
        _ => false,
    };
    let mut candidates: Vec<usize> = (0..deck.len()).filter(|index| may(&deck[*index])).collect();
    Stream::new(seed, "withheld", 0).shuffle(&mut candidates);
    candidates.truncate((WITHHELD_SHARE * cases as f64).round() as usize);
    let order = |(index, recipe): (usize, FamilyRecipe)| {
        let withheld = candidates.contains(&index).then(|| recipe.effects[0].id.clone());
        Order { recipe, withheld }
    };
    deck.into_iter().enumerate().map(order).collect()
}

/// Makes a case on disk, and its twin where it is wanted. Labels stay in memory until they are opened.
pub(super) fn make(out: &Path, order: &Order, with_twin: bool) -> Result<Made, CliError> {
    let name = &order.recipe.name;
    let mut case = FamilyCase::make(&order.recipe).map_err(CliError::failed)?;
    let (folder, twin) = (case_folder(out, name), twin_folder(out, name));
    for stale in [&folder, &twin] {
        if stale.exists() {
            fs::remove_dir_all(stale).map_err(|error| cannot_write(stale, &error))?;
        }
    }
    let with_twin = with_twin && !order.recipe.effects.is_empty();
    case.write(&folder, with_twin.then_some(twin.as_path())).map_err(CliError::failed)?;
    for effect in &mut case.label.effects {
        if let Some((_, called)) = CALLED.iter().find(|(of_plant, _)| *of_plant == effect.id) {
            effect.id = (*called).to_owned();
        }
        effect.named = is_named(&effect.id);
    }
    let recordings_sha256 = digest_of_folder(&folder)?;
    Ok(Made { label: case.label, withheld: order.withheld.clone(), recordings_sha256 })
}

#[cfg(test)]
mod tests {
    use railgrip_truth_plant::family::FormSet;

    use super::*;

    #[test]
    fn withheld_are_single_named_effects() {
        let orders = orders(200, 3, Forms::Only(FormSet::A));
        let withheld: Vec<&Order> = orders.iter().filter(|order| order.withheld.is_some()).collect();
        assert_eq!(withheld.len(), 24);
        for order in withheld {
            assert_eq!(order.recipe.effects.len(), 1);
            assert!(is_named(&order.recipe.effects[0].id));
        }
        assert!(!is_named("cold_bearings") && is_named("brake_fade"));
        assert!(CALLED.iter().all(|(of_plant, called)| !is_named(of_plant) && is_named(called)));
    }
}
