//! Decisions: which effects are selected, what is beyond chance, what the verdict is and how sure.
//!
//! [`criteria`] holds every threshold. [`selection`] goes in rounds ([`round`]) and takes an effect by [`acceptance`], which
//! asks of a further one whether it only mends those before it ([`mending`]); what filters make little of is looked for in the
//! gap itself (`in_gap`). [`evidence`] gathers what the verdict rests on,
//! among it what chance would gain ([`significance`]); [`verdict`] decides by a table of rules, [`practice`] revises it by what becomes of
//! the gap; [`confidence`] says how sure
//! each named effect is, [`posterior`] how probable sets of them ([`sets`]) are ([`holds`]: none, known or unknown), [`spread`] how
//! far values may be off, [`test_run`] what a run made for the purpose says of such sets; [`learning`] takes all three from cases
//! with known answers.
//! [`baselines`] are two simpler ways to rank effects, to compare with.

pub mod acceptance;
pub mod baselines;
pub mod confidence;
pub mod criteria;
pub mod evidence;
pub mod holds;
mod imitation;
pub(crate) mod in_gap;
pub mod learning;
pub mod mending;
mod newton;
pub mod posterior;
pub mod practice;
pub mod round;
pub mod scaling;
pub mod selection;
pub mod sets;
pub mod significance;
pub mod spread;
pub mod test_run;
pub mod verdict;
