//! Features of many clips, on all cores.

use crate::Condition;
use crate::recipe::{Circumstances, Recipe, draw};
use railgrip_acoustics::synthesis::Synthesiser;
use railgrip_acoustics::{AudioState, FeatureExtractor, Features, SAMPLE_RATE_HZ};
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

/// The whole seconds of a recording whose condition is known; windows that are silent or clipped are left out.
pub fn of_recording(audio: &[f32], condition: Condition) -> Vec<Example> {
    let Ok(extractor) = FeatureExtractor::new(SAMPLE_RATE_HZ) else { return Vec::new() };
    let windows = audio.as_chunks::<{ SAMPLE_RATE_HZ as usize }>().0;
    let heard = windows.iter().filter_map(|window| match extractor.extract(window) {
        Ok((features, AudioState::Good)) => Some(Example { features, condition }),
        _ => None,
    });
    heard.collect()
}

/// Draws and hears `count` clips.
pub fn synthesise(circumstances: &Circumstances, count: usize, seed: u64) -> Vec<Example> {
    examples(&draw(circumstances, count, seed))
}
