//! Adam with decoupled weight decay: Loshchilov & Hutter 2019 (arXiv 1711.05101), algorithm 2, with the usual constants.

/// Share of the old mean of the gradient that a step keeps.
const BETA_1: f64 = 0.9;
/// Share of the old mean of its square that a step keeps.
const BETA_2: f64 = 0.999;
/// The same shares and what is left of one, rounded once.
const KEPT_1: f32 = BETA_1 as f32;
const NEW_1: f32 = (1.0 - BETA_1) as f32;
const KEPT_2: f32 = BETA_2 as f32;
const NEW_2: f32 = (1.0 - BETA_2) as f32;
/// Keeps the division bounded where a gradient was always zero.
const EPSILON: f32 = 1e-8;

/// Running means of the gradient of some weights and of its square.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Moments {
    pub fn zeros(count: usize) -> Self {
        Self { first: vec![0.0; count], second: vec![0.0; count] }
    }
}

/// The optimiser: counts steps.
#[derive(Clone, Debug)]
pub(crate) struct AdamW {
    weight_decay: f64,
    steps: i32,
}

impl AdamW {
    pub const fn new(weight_decay: f64) -> Self {
        Self { weight_decay, steps: 0 }
    }

    /// The next step, the same for all weights.
    pub fn next_step(&mut self, learning_rate: f64) -> Step {
        self.steps += 1;
        Step {
            rate: learning_rate as f32,
            kept: (1.0 - learning_rate * self.weight_decay) as f32,
            scale_first: (1.0 / (1.0 - BETA_1.powi(self.steps))) as f32,
            scale_second: (1.0 / (1.0 - BETA_2.powi(self.steps))) as f32,
        }
    }
}

/// One step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    rate: f32,
    /// Share of a weight that its decay leaves.
    kept: f32,
    /// Undo that the means began at zero.
    scale_first: f32,
    scale_second: f32,
}

impl Step {
    /// Moves weights against their gradient.
    pub fn apply(&self, weights: &mut [f32], gradient: &[f32], moments: &mut Moments) {
        let means = moments.first.iter_mut().zip(&mut moments.second);
        for ((weight, slope), (first, second)) in weights.iter_mut().zip(gradient).zip(means) {
            *first = KEPT_1 * *first + NEW_1 * slope;
            *second = KEPT_2 * *second + NEW_2 * slope * slope;
            let by = (*first * self.scale_first) / ((*second * self.scale_second).sqrt() + EPSILON);
            *weight = self.kept * *weight - self.rate * by;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_worked_out_by_hand() {
        let mut optimiser = AdamW::new(0.5);
        let (mut weights, mut moments) = ([1.0], Moments::zeros(1));
        // The first step goes by the whole rate whatever the slope is, after the decay.
        optimiser.next_step(0.1).apply(&mut weights, &[4.0], &mut moments);
        assert!((weights[0] - (0.95 - 0.1)).abs() < 1e-6, "{weights:?}");
        // Means 0.9·0.4 − 0.1·2 = 0.16 over 0.19 and 0.999·0.016 + 0.001·4 = 0.019984 over 0.001999.
        optimiser.next_step(0.1).apply(&mut weights, &[-2.0], &mut moments);
        let by = (0.16 / 0.19) / (0.019_984_f64 / 0.001_999).sqrt();
        assert!((f64::from(weights[0]) - (0.85 * 0.95 - 0.1 * by)).abs() < 1e-5, "{weights:?}");
    }
}
