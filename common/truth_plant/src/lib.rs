//! Independent wagons and trains, to judge a diagnosis and alarms with: they share no formula code with the models under
//! test. [`train`] holds the trains, [`family`] single wagons in many forms; everything else here is the first plant, of single
//! wagons in one form.
//!
//! **Glossary.** *Sheet*: what a simulator believes about a vehicle. *Nuisances*: tolerances that every real wagon has.
//! *Departure*: one way in which the wagon is not what its sheet says, in this plant's own functional form. *Clutter*:
//! wander, gusts and noise. *Order*: a run before it is driven. *Case*: a sheet and ten runs. *Twin*: the same case, the
//! same clutter, without the departure; what is left of the gap there is the floor that no diagnosis can beat.
//!
//! **Invariants.** Depends on no crate of this workspace. Everything follows from one seed.

pub mod case;
pub mod departure;
pub mod departures;
pub mod dynamics;
pub mod family;
pub mod files;
pub mod gap;
pub mod label;
pub mod plant;
pub mod programme;
pub mod protection;
pub mod random;
pub mod sheet;
pub mod train;
pub mod wagon;

pub use case::{Case, Recipe};
pub use family::{FamilyCase, FamilyRecipe};
pub use label::Label;
