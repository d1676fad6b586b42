//! Adhesion as one wheelset, or the wagon, sees it: what is utilised, and what that says about the rail.

use crate::belief::{Belief, Evidence, Rail};
use crate::measure::window::WindowMaximum;
use crate::settings::AdhesionSettings;
use bytemuck::{Pod, Zeroable};

/// The belief about the rail is renewed in steps of this, s.
const BELIEF_STEP_S: f64 = 0.1;
/// Adhesion utilised is smoothed over about so long before its maximum is taken, s: noise has maxima too.
const SMOOTHING_S: f64 = 0.1;
/// A slide after so long a pause is a new one: its adhesion starts afresh, s.
const NEW_SLIDE_AFTER_S: f64 = 2.0;

/// Adhesion as one wheelset, or the wagon, sees it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct RailView {
    pub belief: Belief,
    pub window: WindowMaximum,
    pub smoothed: f64,
    /// Adhesion utilised in the latest slide.
    pub sliding_smoothed: f64,
    /// Infinite before the first slide.
    pub since_slide_s: f64,
    since_belief_s: f64,
}

impl RailView {
    /// Nothing is known yet.
    pub fn new(rail: &Rail) -> Self {
        Self {
            belief: Belief::prior(rail),
            window: WindowMaximum::default(),
            smoothed: 0.0,
            sliding_smoothed: 0.0,
            since_slide_s: f64::INFINITY,
            since_belief_s: 0.0,
        }
    }

    /// Takes in an adhesion utilised (magnitude and 1 σ) that holds for `dt_s`; true when the belief was renewed.
    pub fn add(
        &mut self,
        rail: &Rail,
        settings: &AdhesionSettings,
        dt_s: f64,
        (value, sigma): (f64, f64),
        sliding: bool,
        moving: bool,
    ) -> bool {
        if !value.is_finite() || !sigma.is_finite() {
            return false;
        }
        let blend = (dt_s / SMOOTHING_S).min(1.0);
        self.smoothed += blend * (value - self.smoothed);
        if sliding {
            let again = self.since_slide_s > NEW_SLIDE_AFTER_S;
            self.sliding_smoothed = if again {
                value
            } else {
                self.sliding_smoothed + 0.2 * blend * (value - self.sliding_smoothed)
            };
            self.since_slide_s = 0.0;
        } else {
            self.since_slide_s += dt_s;
        }
        self.window.add(dt_s, if moving { self.smoothed } else { 0.0 }, sigma, settings.window_s);
        self.since_belief_s += dt_s;
        let renew = self.since_belief_s >= BELIEF_STEP_S;
        if renew {
            let evidence = moving.then_some(Evidence { utilised: self.smoothed, sigma, sliding });
            self.belief.update(rail, self.since_belief_s, evidence);
            self.since_belief_s = 0.0;
        }
        renew
    }
}
