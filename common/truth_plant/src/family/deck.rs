//! Which cases there are: which effects, in which form, how strong, on which plant.

use serde::{Deserialize, Serialize};

use super::{
    effects::EFFECTS,
    forms::Effect,
    set::{FormSet, Forms},
};
use crate::random::Stream;

/// An effect as it is ordered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrderedEffect {
    /// Its id.
    pub id: String,
    /// Name of its form; none: any of the case's set.
    pub form: Option<String>,
    /// Size over the usual one.
    pub strength: f64,
}

/// A case as it is ordered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FamilyRecipe {
    /// Name of the folder.
    pub name: String,
    /// Everything random follows from this.
    pub seed: u64,
    /// Forms of plant and effects.
    pub set: FormSet,
    /// The effects; empty for a case that holds nuisances and clutter only.
    pub effects: Vec<OrderedEffect>,
}

/// Shares of the kinds of case in a deck; the rest has one named effect each.
const NONE_SHARE: f64 = 0.15;
const NAMELESS_SHARE: f64 = 0.14;
const PAIR_SHARE: f64 = 0.13;
const TRIPLE_SHARE: f64 = 0.05;

/// Weakest and strongest size over the usual one: from what cannot be seen to what is gross.
pub const STRENGTHS: (f64, f64) = (0.05, 2.5);

/// A deck of `count` cases of the family. Every id comes equally often, sizes are uniform on a logarithmic scale, and no case
/// is chosen by what can be seen in it.
#[must_use]
pub fn family_deck(count: usize, seed: u64, forms: Forms) -> Vec<FamilyRecipe> {
    let mut stream = Stream::new(seed, "family deck", 0);
    let share = |share: f64| (share * count as f64).round() as usize;
    let mut named = Supply::new(|effect| effect.named);
    let mut nameless = Supply::new(|effect| !effect.named);
    let mut drawn: Vec<Vec<&'static str>> = vec![Vec::new(); share(NONE_SHARE)];
    drawn.extend((0..share(NAMELESS_SHARE)).map(|_| vec![nameless.next(&mut stream).id]));
    for (share, several) in [(share(PAIR_SHARE), 2), (share(TRIPLE_SHARE), 3)] {
        drawn.extend((0..share).map(|_| unlike(&mut named, several, &mut stream)));
    }
    while drawn.len() < count {
        drawn.push(vec![named.next(&mut stream).id]);
    }
    drawn.truncate(count);
    stream.shuffle(&mut drawn);
    let sets = forms.sets();
    let recipe = |(index, ids): (usize, Vec<&'static str>)| {
        let mut stream = Stream::new(seed, "recipe", index as u64);
        let set = sets[stream.below(sets.len())];
        let effects = ids
            .into_iter()
            .map(|id| OrderedEffect {
                id: id.to_owned(),
                form: None,
                strength: stream.uniform(STRENGTHS.0.ln(), STRENGTHS.1.ln()).exp(),
            })
            .collect();
        FamilyRecipe { name: format!("case{index:04}"), seed: stream.seed(), set, effects }
    };
    drawn.into_iter().enumerate().map(recipe).collect()
}

/// Several named effects of different terms that do not look alike.
fn unlike(named: &mut Supply, several: usize, stream: &mut Stream) -> Vec<&'static str> {
    let mut chosen: Vec<&Effect> = vec![named.next(stream)];
    while chosen.len() < several {
        let next = named.next(stream);
        if !chosen.iter().any(|other| alike(other, next)) {
            chosen.push(next);
        }
    }
    chosen.into_iter().map(|effect| effect.id).collect()
}

/// Effects of one term, or of the pairs that look alike across terms, make no fair pair.
fn alike(first: &Effect, second: &Effect) -> bool {
    const ALIKE: [[&str; 2]; 3] = [
        ["wheel_radius", "speed_scale"],
        ["clock_skew", "speed_latency"],
        ["brake_lag", "wheel_encoder_window"],
    ];
    let pair = |pair: &[&str; 2]| pair.contains(&first.id) && pair.contains(&second.id);
    first.term == second.term || ALIKE.iter().any(pair)
}

/// Hands out effects in random order, each once before any comes again.
struct Supply {
    all: Vec<&'static Effect>,
    left: Vec<&'static Effect>,
}

impl Supply {
    fn new(wanted: impl Fn(&Effect) -> bool) -> Self {
        Self { all: EFFECTS.iter().filter(|effect| wanted(effect)).collect(), left: Vec::new() }
    }

    fn next(&mut self, stream: &mut Stream) -> &'static Effect {
        if self.left.is_empty() {
            self.left.clone_from(&self.all);
            stream.shuffle(&mut self.left);
        }
        self.left.pop().unwrap_or(self.all[0])
    }
}
