//! The perceptron: 26 features, two hidden layers of 512 with ReLU, two classes. Forward pass, gradient and optimiser.
//!
//! A batch is a matrix with an example in each column. The loss is the mean cross entropy of the softmax over the classes.

use crate::optimiser::{AdamW, Moments};
use nalgebra::{DMatrix, DVector};
use railgrip_acoustics::FEATURES;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Neurons of each layer.
pub(crate) const LAYERS: [usize; 4] = [FEATURES, 512, 512, 2];
/// Index of the wet class.
pub(crate) const WET: usize = 1;

/// A layer: weight (outputs × inputs) times input, plus bias (outputs).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    pub weight: DMatrix<f32>,
    pub bias: DVector<f32>,
}

impl Layer {
    fn forward(&self, inputs: &DMatrix<f32>) -> DMatrix<f32> {
        let mut outputs = &self.weight * inputs;
        for mut column in outputs.column_iter_mut() {
            column += &self.bias;
        }
        outputs
    }
}

/// The network.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Network {
    pub layers: Vec<Layer>,
}

impl Network {
    /// Random weights after He et al. 2015: uniform within √(6 / inputs); biases zero.
    pub fn random(random: &mut Pcg64Mcg) -> Self {
        let layers = LAYERS.windows(2).map(|pair| {
            let (inputs, outputs) = (pair[0], pair[1]);
            let bound = (6.0 / inputs as f32).sqrt();
            let weights = (0..inputs * outputs).map(|_| random.random_range(-bound..bound));
            Layer {
                weight: DMatrix::from_row_iterator(outputs, inputs, weights),
                bias: DVector::zeros(outputs),
            }
        });
        Self { layers: layers.collect() }
    }

    /// What each layer gives for a batch, the features first and the logits last.
    fn activations(&self, rows: &[[f32; FEATURES]]) -> Vec<DMatrix<f32>> {
        let mut all = vec![DMatrix::from_column_slice(FEATURES, rows.len(), rows.as_flattened())];
        for (number, layer) in self.layers.iter().enumerate() {
            let mut values = layer.forward(&all[number]);
            if number + 1 < self.layers.len() {
                values.apply(|value| *value = value.max(0.0));
            }
            all.push(values);
        }
        all
    }

    /// Probability of wet for each row of standardised features.
    pub fn wet(&self, rows: &[[f32; FEATURES]]) -> Vec<f64> {
        let activations = self.activations(rows);
        let logits = activations.last().into_iter().flat_map(|logits| logits.column_iter());
        logits.map(|logits| f64::from(softmax([logits[0], logits[1]])[WET])).collect()
    }

    /// Gradient of the mean cross entropy over a batch, layer by layer.
    fn gradient(&self, rows: &[[f32; FEATURES]], classes: &[usize]) -> Vec<Layer> {
        let mut activations = self.activations(rows);
        let mut slope = activations.pop().unwrap_or_default();
        for (mut logits, class) in slope.column_iter_mut().zip(classes) {
            let share = softmax([logits[0], logits[1]]);
            for output in 0..share.len() {
                let truth = f32::from(u8::from(output == *class));
                logits[output] = (share[output] - truth) / classes.len() as f32;
            }
        }
        let mut gradient = Vec::new();
        for (layer, inputs) in self.layers.iter().zip(activations).rev() {
            // Transposed whole: products of plain matrices run through a kernel several times as fast.
            gradient.push(Layer { weight: &slope * inputs.transpose(), bias: slope.column_sum() });
            slope = layer.weight.transpose() * slope;
            // Where the rectifier gave nothing, nothing comes back. The features have none, and their slope is not used.
            slope.zip_apply(&inputs, |slope, input| *slope *= f32::from(u8::from(input > 0.0)));
        }
        gradient.reverse();
        gradient
    }
}

/// Shares of the two classes.
fn softmax(logits: [f32; 2]) -> [f32; 2] {
    let largest = logits[0].max(logits[1]);
    let raised = logits.map(|logit| (logit - largest).exp());
    raised.map(|value| value / (raised[0] + raised[1]))
}

/// A network that learns.
pub(crate) struct Learner {
    pub network: Network,
    optimiser: AdamW,
    moments: Vec<(Moments, Moments)>,
}

impl Learner {
    /// A network of random weights.
    pub fn new(random: &mut Pcg64Mcg, weight_decay: f64) -> Self {
        let network = Network::random(random);
        let moments = |layer: &Layer| (Moments::zeros(layer.weight.len()), Moments::zeros(layer.bias.len()));
        Self {
            moments: network.layers.iter().map(moments).collect(),
            network,
            optimiser: AdamW::new(weight_decay),
        }
    }

    /// One step on a batch.
    pub fn step(&mut self, rows: &[[f32; FEATURES]], classes: &[usize], learning_rate: f64) {
        let gradient = self.network.gradient(rows, classes);
        let step = self.optimiser.next_step(learning_rate);
        for ((layer, slope), (weight, bias)) in
            self.network.layers.iter_mut().zip(&gradient).zip(&mut self.moments)
        {
            step.apply(layer.weight.as_mut_slice(), slope.weight.as_slice(), weight);
            step.apply(layer.bias.as_mut_slice(), slope.bias.as_slice(), bias);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    fn batch(random: &mut Pcg64Mcg) -> (Vec<[f32; FEATURES]>, Vec<usize>) {
        let rows = (0..6).map(|_| std::array::from_fn(|_| random.random_range(-2.0..2.0))).collect();
        (rows, vec![0, 1, 1, 0, 1, 0])
    }

    /// Mean cross entropy in double precision, apart from the code under test.
    fn loss(network: &Network, rows: &[[f32; FEATURES]], classes: &[usize]) -> f64 {
        let one = |(row, class): (&[f32; FEATURES], &usize)| {
            let mut values: Vec<f64> = row.iter().map(|value| f64::from(*value)).collect();
            for (number, layer) in network.layers.iter().enumerate() {
                let sum = |output: usize| {
                    let products = values.iter().enumerate();
                    let sum: f64 =
                        products.map(|(j, value)| f64::from(layer.weight[(output, j)]) * value).sum();
                    sum + f64::from(layer.bias[output])
                };
                let rectified = number + 1 < network.layers.len();
                values = (0..layer.bias.len())
                    .map(|output| if rectified { sum(output).max(0.0) } else { sum(output) })
                    .collect();
            }
            (values[0].exp() + values[1].exp()).ln() - values[*class]
        };
        rows.iter().zip(classes).map(one).sum::<f64>() / rows.len() as f64
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let network = Network::random(&mut random);
        let (rows, classes) = batch(&mut random);
        let gradient = network.gradient(&rows, &classes);
        let mut worst = 0.0_f64;
        for number in 0..network.layers.len() {
            for _ in 0..12 {
                let (outputs, inputs) = network.layers[number].weight.shape();
                let place = (random.random_range(0..outputs), random.random_range(0..inputs));
                let moved = |by: f32, bias: bool| {
                    let mut moved = network.clone();
                    let layer = &mut moved.layers[number];
                    if bias {
                        layer.bias[place.0] += by
                    } else {
                        layer.weight[place] += by
                    }
                    loss(&moved, &rows, &classes)
                };
                let step = 2.0_f32.powi(-10);
                for (bias, found) in
                    [(false, gradient[number].weight[place]), (true, gradient[number].bias[place.0])]
                {
                    let expected = (moved(step, bias) - moved(-step, bias)) / (2.0 * f64::from(step));
                    worst = worst.max((f64::from(found) - expected).abs());
                }
            }
        }
        assert!(worst < 2e-4, "{worst}");
    }

    #[test]
    fn probabilities_follow_from_the_loss_of_each_class() {
        let mut random = Pcg64Mcg::seed_from_u64(4);
        let network = Network::random(&mut random);
        let (rows, _) = batch(&mut random);
        for (row, wet) in rows.iter().zip(network.wet(&rows)) {
            let expected = (-loss(&network, &[*row], &[WET])).exp();
            assert!((wet - expected).abs() < 1e-5, "{wet} {expected}");
        }
    }
}
