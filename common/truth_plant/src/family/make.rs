//! Making a case of the family in memory, with its twin and its label.

use super::{
    calibrate::calibrate,
    creep::CreepLaw,
    deck::FamilyRecipe,
    effects::effect,
    forms::{Effect, Form},
    moment::Departures,
    motion::Integrator,
    noise::Noise,
    plant::{Build, FamilyPlant, FamilyRun},
    programme::{self, FamilyOrder, NextRun},
    reference::gap,
    sheet::{FamilySheet, Needs},
    wagon::{FamilyNuisances, FamilyWagon},
};
use crate::{
    label::{Gaps, Label, LabelledEffect, PlantOf},
    random::Stream,
    sheet::Rail,
};

/// A recipe that cannot be followed.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// No effect has this id.
    #[error("no effect is called {0:?}")]
    Effect(String),
    /// The effect has no such form.
    #[error("{id} has no form {form:?}; it has {known}")]
    Form {
        /// The effect.
        id: String,
        /// What was asked for.
        form: String,
        /// Its forms.
        known: String,
    },
}

/// A finished case with its twin.
pub struct FamilyCase {
    /// The believed vehicle.
    pub sheet: FamilySheet,
    /// The tolerances that were drawn.
    pub nuisances: FamilyNuisances,
    /// The runs.
    pub runs: Vec<FamilyRun>,
    /// The same runs without the effects.
    pub twin: Vec<FamilyRun>,
    /// The answer.
    pub label: Label,
}

/// An effect in the form in which it is there.
struct Chosen {
    effect: &'static Effect,
    form: &'static Form,
    strength: f64,
    stream: Stream,
}

/// Rounds of the fit of the nuisances; the twin begins at its true ones.
const ROUNDS: usize = 3;
const ROUNDS_OF_TWIN: usize = 2;

impl FamilyCase {
    /// Makes a case; the same recipe gives the same case.
    ///
    /// # Errors
    /// An effect or a form that does not exist.
    pub fn make(recipe: &FamilyRecipe) -> Result<Self, RecipeError> {
        let chosen = choose(recipe)?;
        let vehicle = Vehicle::draw(recipe, &chosen);
        let twin = vehicle.drive(&[]);
        let floor = vehicle.calibrated(&twin, ROUNDS_OF_TWIN);
        let (runs, gaps) = if chosen.is_empty() {
            (twin.clone(), floor)
        } else {
            let runs = vehicle.drive(&chosen.iter().collect::<Vec<_>>());
            let gaps = vehicle.calibrated(&runs, ROUNDS);
            (runs, gaps)
        };
        let label_of = |(index, one): (usize, &Chosen)| {
            let others: Vec<&Chosen> =
                chosen.iter().enumerate().filter(|(k, _)| *k != index).map(|(_, other)| other).collect();
            let without = || vehicle.calibrated(&vehicle.drive(&others), ROUNDS);
            LabelledEffect { gap_without: (!others.is_empty()).then(without), ..one.label(&vehicle.sheet) }
        };
        let label = Label {
            case: recipe.name.clone(),
            vehicle: vehicle.sheet.class.to_owned(),
            effects: chosen.iter().enumerate().map(label_of).collect(),
            gap_calibrated: gaps,
            gap_without_the_effect: floor,
            plant: Some(vehicle.describe(recipe, &runs)),
        };
        Ok(Self { sheet: vehicle.sheet, nuisances: vehicle.nuisances, runs, twin, label })
    }
}

/// How large a case is: what a diagnosis of it takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaseSize {
    /// Wheelsets.
    pub wheelsets: usize,
    /// Samples a second.
    pub rate_hz: f64,
    /// Runs to fit on.
    pub fit_runs: usize,
}

impl FamilyCase {
    /// How large the case of a recipe is, which is not made for that.
    ///
    /// # Errors
    /// An effect or a form that does not exist.
    pub fn size(recipe: &FamilyRecipe) -> Result<CaseSize, RecipeError> {
        let vehicle = Vehicle::draw(recipe, &choose(recipe)?);
        Ok(CaseSize {
            wheelsets: vehicle.sheet.wheelsets,
            rate_hz: vehicle.sheet.rate_hz,
            fit_runs: vehicle.orders.iter().filter(|order| !order.holdout).count(),
        })
    }

    /// One run more by the vehicle of a case, effects and all, under this name; with the sheet that its recording is written by.
    ///
    /// # Errors
    /// An effect or a form that does not exist.
    pub fn one_more(
        recipe: &FamilyRecipe,
        name: &str,
        wanted: &NextRun,
    ) -> Result<(FamilySheet, FamilyRun), RecipeError> {
        let chosen = choose(recipe)?;
        let mut vehicle = Vehicle::draw(recipe, &chosen);
        let (sheet, seed, protected) = (&vehicle.sheet, vehicle.seed, vehicle.build.protected);
        let order = match wanted {
            NextRun::Asked(run) => programme::asked(run, sheet, seed, protected),
            NextRun::Any(longest_s) => {
                programme::another(sheet, &vehicle.orders, seed, protected, *longest_s)
            }
        };
        // What the earlier runs did to the vehicle is there.
        let last = vehicle.orders.len();
        vehicle.orders.push(FamilyOrder { name: name.to_owned(), ..order });
        let run = vehicle.drive(&chosen.iter().collect::<Vec<_>>()).swap_remove(last);
        Ok((vehicle.sheet, run))
    }
}

/// Looks effects and forms up; a form that is not named is drawn from the case's set.
fn choose(recipe: &FamilyRecipe) -> Result<Vec<Chosen>, RecipeError> {
    let choose = |(index, ordered): (usize, &super::deck::OrderedEffect)| {
        let effect = effect(&ordered.id).ok_or_else(|| RecipeError::Effect(ordered.id.clone()))?;
        let mut stream = Stream::new(recipe.seed, effect.id, index as u64);
        let of_set: Vec<&'static Form> = effect.forms_of(recipe.set).collect();
        let drawn = stream.below(of_set.len());
        let wanted = ordered.form.as_ref();
        let form = match wanted {
            Some(name) => effect.forms.iter().find(|form| form.name == name),
            None => of_set.get(drawn).copied(),
        };
        let unknown = || RecipeError::Form {
            id: ordered.id.clone(),
            form: wanted.cloned().unwrap_or_else(|| format!("of set {}", recipe.set.letter())),
            known: effect.forms.iter().map(|form| form.name).collect::<Vec<_>>().join(", "),
        };
        Ok(Chosen { effect, form: form.ok_or_else(unknown)?, strength: ordered.strength, stream })
    };
    recipe.effects.iter().enumerate().map(choose).collect()
}

impl Chosen {
    fn label(&self, sheet: &FamilySheet) -> LabelledEffect {
        let (_, parameters) = self.form.draw(self.strength, self.stream.clone(), sheet);
        LabelledEffect {
            id: self.effect.id.to_owned(),
            term: self.effect.term.to_owned(),
            named: self.effect.named,
            form: self.form.name.to_owned(),
            set: self.form.set.letter().to_string(),
            strength: self.strength,
            parameters: parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
            gap_without: None,
        }
    }
}

/// A vehicle with its tolerances and ordered runs.
struct Vehicle {
    sheet: FamilySheet,
    nuisances: FamilyNuisances,
    wagon: FamilyWagon,
    build: Build,
    orders: Vec<FamilyOrder>,
    seed: u64,
}

impl Vehicle {
    fn draw(recipe: &FamilyRecipe, chosen: &[Chosen]) -> Self {
        let seed = recipe.seed;
        let needs = Needs {
            motor: chosen.iter().any(|chosen| chosen.effect.needs.motor),
            sander: chosen.iter().any(|chosen| chosen.effect.needs.sander),
        };
        let sheet = FamilySheet::draw(&mut Stream::new(seed, "sheet", 0), needs);
        let nuisances = FamilyNuisances::draw(&mut Stream::new(seed, "nuisances", 0), sheet.wheelsets);
        let mut stream = Stream::new(seed, "build", 0);
        let laws: Vec<CreepLaw> = CreepLaw::ALL.into_iter().filter(|law| law.set() == recipe.set).collect();
        let law = laws[stream.below(laws.len())];
        let integrator = Integrator::ALL[stream.below(Integrator::ALL.len())];
        let protected = sheet.sander || !sheet.class.starts_with("freight") || stream.chance(0.7);
        let low_rail = chosen.iter().any(|chosen| chosen.effect.low_rail) && stream.chance(0.85);
        let noise = Noise::draw(&mut Stream::new(seed, "noise", 0));
        let orders = programme::orders(&sheet, seed, low_rail, protected);
        let wagon = FamilyWagon::new(&sheet, &nuisances, law);
        Self { sheet, nuisances, wagon, build: Build { integrator, noise, protected }, orders, seed }
    }

    fn drive(&self, chosen: &[&Chosen]) -> Vec<FamilyRun> {
        let draw = |chosen: &&Chosen| chosen.form.draw(chosen.strength, chosen.stream.clone(), &self.sheet).0;
        let departures = Departures(chosen.iter().map(draw).collect());
        let mut plant = FamilyPlant::new(&self.sheet, &self.wagon, &self.build, departures, self.seed);
        self.orders.iter().enumerate().map(|(index, order)| plant.drive(order, index)).collect()
    }

    /// The calibrated nominal model on these runs, fitted on their fit part from the true tolerances.
    fn calibrated(&self, runs: &[FamilyRun], rounds: usize) -> Gaps {
        let fit: Vec<&FamilyRun> = runs.iter().filter(|run| !run.order.holdout).collect();
        let nuisances = calibrate(&self.sheet, &fit, &self.nuisances, rounds);
        let part = |holdout: bool| {
            gap(&self.sheet, &nuisances, runs.iter().filter(|run| run.order.holdout == holdout))
        };
        Gaps { fit: part(false), holdout: part(true) }
    }

    fn describe(&self, recipe: &FamilyRecipe, runs: &[FamilyRun]) -> PlantOf {
        let rails = [Rail::Dry, Rail::Wet, Rail::Low].into_iter();
        let met = |rail: &Rail| runs.iter().any(|run| run.order.rail == *rail);
        let samples: usize = runs.iter().map(|run| run.rows.len()).sum();
        PlantOf {
            set: recipe.set.letter().to_string(),
            creep_law: self.wagon.law.name().to_owned(),
            integrator: self.build.integrator.name().to_owned(),
            noise: self.build.noise.kinds().into_iter().map(str::to_owned).collect(),
            noise_level: self.build.noise.level,
            rate_hz: self.sheet.rate_hz,
            wheelsets: self.sheet.wheelsets,
            mass_kg: self.sheet.mass_kg,
            motored: self.sheet.is_motored(),
            has_position: self.sheet.has_position,
            protected: self.build.protected,
            rails: rails.filter(met).map(|rail| rail.name().to_owned()).collect(),
            fit_runs: runs.iter().filter(|run| !run.order.holdout).count(),
            holdout_runs: runs.iter().filter(|run| run.order.holdout).count(),
            seconds: samples as f64 / self.sheet.rate_hz,
        }
    }
}
