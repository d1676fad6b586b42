//! Features of many clips, on all cores.

use crate::Condition;
use crate::recipe::{Circumstances, Recipe, draw};
use railgrip_acoustics::synthesis::Synthesiser;
use railgrip_acoustics::{FeatureExtractor, Features, SAMPLE_RATE_HZ};
use rayon::prelude::*;

/// One clip as the network sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Example {
    /// Its features.
    pub features: Features,
    /// What it is.
    pub condition: Condition,
}

/// The sound of a recipe: one second.
pub fn sound(recipe: &Recipe) -> Vec<f32> {
    let mut audio = Vec::with_capacity(SAMPLE_RATE_HZ as usize);
    Synthesiser::new(recipe.rig.clone(), recipe.seed).render(
        &recipe.scene,
        SAMPLE_RATE_HZ as usize,
        &mut audio,
    );
    audio
}

/// Features of recipes, in their order. Clips without usable audio (there are none among [`draw`]'s) are left out.
pub fn examples(recipes: &[Recipe]) -> Vec<Example> {
    let extractor = FeatureExtractor::new(SAMPLE_RATE_HZ).ok();
    let one = |recipe: &Recipe| {
        let (features, _) = extractor.as_ref()?.extract(&sound(recipe)).ok()?;
        Some(Example { features, condition: recipe.condition })
    };
    recipes.par_iter().map(one).collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Draws and hears `count` clips.
pub fn synthesise(circumstances: &Circumstances, count: usize, seed: u64) -> Vec<Example> {
    examples(&draw(circumstances, count, seed))
}
