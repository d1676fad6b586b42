//! A family of plants for `railgrip gap blind` and for calibration: single wagons of many classes, every effect in several
//! functional forms, several creep laws, integrations and kinds of sensor noise. It shares no formula and no constant with
//! the models under test.
//!
//! **Glossary.** *Effect*: an id of the contract or a nameless departure. *Form*: the functional shape in which it is there.
//! *Set*: forms A, B and C; what is calibrated on one is reported on another. *Twin*: the same case without its effects;
//! its calibrated gap is the floor. *Salience*: the calibrated gap over that floor.
//!
//! deck (which effects, how strong) → make (sheet, tolerances, programme) → plant (moment → motion → sensors) → reference
//! and calibrate (gaps for the label) → write.

mod calibrate;
mod creep;
mod deck;
mod effects;
mod forms;
mod law;
mod line;
mod make;
mod moment;
mod motion;
mod noise;
mod plant;
mod programme;
mod protection;
mod reference;
mod set;
mod sheet;
mod units;
mod wagon;
mod write;

pub use creep::CreepLaw;
pub use deck::{FamilyRecipe, OrderedEffect, STRENGTHS, family_deck};
pub use effects::{EFFECTS, effect};
pub use forms::{Draw, Effect, Form};
pub use make::{CaseSize, FamilyCase, RecipeError};
pub use moment::{Departure, Departures, Moment, Sensed};
pub use motion::{Action, Integrator, Motion, Stepped, step};
pub use noise::{Channel, Noise};
pub use plant::{Build, FamilyPlant, FamilyRow, FamilyRun, FamilyTruth};
pub use programme::{AskedRun, FamilyOrder, NextRun, orders};
pub use reference::windows;
pub use set::{FormSet, Forms};
pub use sheet::{FamilySheet, Needs};
pub use units::{MOST_WHEELSETS, PerWheelset};
pub use wagon::{FamilyNuisances, FamilyWagon};
pub use write::{file_name, recording, write_runs};
