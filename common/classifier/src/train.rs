//! From clips to a model.

use crate::dataset::{self, Example};
use crate::model::Provenance;
use crate::network::Learner;
use crate::recipe::Circumstances;
use crate::standard::Standard;
use crate::{Condition, Model, ModelError};
use railgrip_acoustics::{FEATURES, Features};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

/// Share set aside to judge passes by (Shrestha et al.: 80 % to train, 20 % to test).
const SET_ASIDE: f64 = 0.2;
/// Clips of one step.
const BATCH: usize = 128;
/// Learning rate at its highest; it falls along a half cosine.
const LEARNING_RATE: f64 = 1e-3;
/// Pull of the weights towards zero.
const WEIGHT_DECAY: f64 = 0.02;
/// Noise on standardised features in each pass, so that single clips are not learnt by heart.
const JITTER: f64 = 0.05;

/// How a model is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Training {
    /// Clips to synthesise.
    pub clips: usize,
    /// Passes over them.
    pub epochs: usize,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for Training {
    /// What the built-in model was made with: many clips heard a few times each teach more about rigs never heard than
    /// fewer heard often.
    fn default() -> Self {
        Self { clips: 30_000, epochs: 12, seed: 1 }
    }
}

/// Fewest clips that make sense.
const LEAST_CLIPS: usize = 100;

/// Synthesises clips, learns from four fifths of them and keeps the pass that did best on the rest. `progress` hears of
/// every pass: its number (from 1) and the accuracy on what was set aside.
///
/// # Errors
/// Fewer than 100 clips.
pub fn train(training: &Training, progress: impl FnMut(usize, f64)) -> Result<Model, ModelError> {
    train_on(training, &Circumstances::training(), progress)
}

/// The same with other circumstances than the usual ones.
///
/// # Errors
/// As [`train`].
pub fn train_on(
    training: &Training,
    circumstances: &Circumstances,
    progress: impl FnMut(usize, f64),
) -> Result<Model, ModelError> {
    if training.clips < LEAST_CLIPS {
        return Err(ModelError::TooFew { clips: training.clips, least: LEAST_CLIPS });
    }
    let mut random = Pcg64Mcg::seed_from_u64(training.seed);
    let examples = dataset::synthesise(circumstances, training.clips, random.random_range(0..u64::MAX));
    let rigs = circumstances.rigs.iter().map(|rig| (*rig).to_owned()).collect();
    Ok(learn(examples, rigs, training, &mut random, progress))
}

/// Learns from examples that are there already, recordings for instance; `rigs` says for people where they come from.
///
/// # Errors
/// As [`train`].
pub fn train_from(
    examples: Vec<Example>,
    rigs: Vec<String>,
    training: &Training,
    progress: impl FnMut(usize, f64),
) -> Result<Model, ModelError> {
    if examples.len() < LEAST_CLIPS {
        return Err(ModelError::TooFew { clips: examples.len(), least: LEAST_CLIPS });
    }
    let clips = examples.len();
    let mut random = Pcg64Mcg::seed_from_u64(training.seed);
    Ok(learn(examples, rigs, &Training { clips, ..*training }, &mut random, progress))
}

fn learn(
    mut examples: Vec<Example>,
    rigs: Vec<String>,
    training: &Training,
    random: &mut Pcg64Mcg,
    mut progress: impl FnMut(usize, f64),
) -> Model {
    shuffle(&mut examples, random);
    let aside = examples.split_off(((1.0 - SET_ASIDE) * examples.len() as f64) as usize);
    let features: Vec<Features> = examples.iter().map(|example| example.features).collect();
    let standard = Standard::of(&features);
    let rows: Vec<[f32; FEATURES]> = features.iter().map(|features| standard.apply(features)).collect();
    let aside_rows: Vec<[f32; FEATURES]> =
        aside.iter().map(|example| standard.apply(&example.features)).collect();

    let mut learner = Learner::new(random, WEIGHT_DECAY);
    let mut order: Vec<usize> = (0..rows.len()).collect();
    let mut best = (f64::INFINITY, 0.0, learner.network.clone());
    for epoch in 0..training.epochs {
        shuffle(&mut order, random);
        let share = epoch as f64 / training.epochs as f64;
        let rate = LEARNING_RATE * (0.01 + 0.99 * 0.5 * (1.0 + (PI * share).cos()));
        for batch in order.chunks(BATCH) {
            let jittered: Vec<[f32; FEATURES]> =
                batch.iter().map(|index| jittered(&rows[*index], random)).collect();
            let classes: Vec<usize> = batch.iter().map(|index| class(&examples[*index])).collect();
            learner.step(&jittered, &classes, rate);
        }
        let (loss, accuracy) = judge(&aside, &learner.network.wet(&aside_rows));
        progress(epoch + 1, accuracy);
        if loss < best.0 {
            best = (loss, accuracy, learner.network.clone());
        }
    }
    let provenance = Provenance {
        seed: training.seed,
        clips: training.clips,
        epochs: training.epochs,
        rigs,
        validation_accuracy: best.1,
    };
    Model::of(standard, best.2, provenance)
}

fn class(example: &Example) -> usize {
    usize::from(example.condition == Condition::Wet)
}

/// Mean cross entropy and accuracy.
fn judge(examples: &[Example], wet: &[f64]) -> (f64, f64) {
    let (mut loss, mut right) = (0.0, 0.0);
    for (example, wet) in examples.iter().zip(wet) {
        let own = if example.condition == Condition::Wet { *wet } else { 1.0 - wet };
        loss -= own.max(1e-9).ln();
        right += f64::from(u8::from(own > 0.5));
    }
    let count = examples.len().max(1) as f64;
    (loss / count, right / count)
}

fn jittered(row: &[f32; FEATURES], random: &mut Pcg64Mcg) -> [f32; FEATURES] {
    row.map(|value| {
        let normal: f64 = StandardNormal.sample(random);
        value + (JITTER * normal) as f32
    })
}

/// Fisher and Yates.
fn shuffle<T>(items: &mut [T], random: &mut Pcg64Mcg) {
    for last in (1..items.len()).rev() {
        items.swap(last, random.random_range(0..=last));
    }
}
