//! Dry or wet, by ear: the network that turns the features of rolling noise into a probability, and what is made of it.
//!
//! Shrestha et al. (section 3.2) classify windows of one second by a perceptron with two hidden layers of 512 neurons
//! on 26 standardised features; a probability of exactly 0.5 keeps the condition before. Here the network learns from
//! synthesised noise ([`recipe`]). The file of a trained [`Model`] holds standardisation and weights and is guarded by a checksum; [`Model::built_in`] needs no file.
//!
//! * [`recipe`] – random circumstances of a second of noise, and which of them are kept from training.
//! * [`dataset`] – their features.
//! * [`train`] – from features to a model.
//! * [`Ear`] – window for window: state of the audio, probability, condition with hysteresis.
//!
//! # Glossary
//! * **clip** – one second of noise with what is known about it.
//! * **unfamiliar** – farther from the training clips, in Mahalanobis distance, than twice any but a thousandth of them.

pub mod dataset;
mod ear;
mod error;
mod file;
mod judge;
mod model;
mod network;
mod optimiser;
pub mod recipe;
mod standard;
mod train;

pub use ear::{Ear, Hearing, Hysteresis, Verdict, Window};
pub use error::ModelError;
pub use judge::Confusion;
pub use model::{Model, Provenance};
pub use train::{Training, train, train_from, train_on};

/// What the network tells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Condition {
    /// Dry rail.
    Dry,
    /// Wet rail.
    Wet,
}

impl Condition {
    /// The word for people.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
        }
    }
}
