//! The perceptron: 26 features, two hidden layers of 512 with ReLU, two classes.

use crate::ModelError;
use candle_core::{DType, Device, Tensor, Var};
use candle_nn::{AdamW, Linear, Module, Optimizer, ParamsAdamW, loss, ops};
use railgrip_acoustics::FEATURES;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Neurons of each layer.
pub(crate) const LAYERS: [usize; 4] = [FEATURES, 512, 512, 2];
/// Index of the wet class.
pub(crate) const WET: usize = 1;

/// Weight and bias of a layer.
pub(crate) type Layer = (Tensor, Tensor);

/// The network.
#[derive(Clone, Debug)]
pub(crate) struct Network {
    layers: Vec<Linear>,
}

impl Network {
    /// A network of these layers.
    pub fn of(layers: &[Layer]) -> Self {
        let linear = |(weight, bias): &Layer| Linear::new(weight.clone(), Some(bias.clone()));
        Self { layers: layers.iter().map(linear).collect() }
    }

    /// Weights and biases.
    pub fn layers(&self) -> impl Iterator<Item = (&Tensor, Option<&Tensor>)> {
        self.layers.iter().map(|layer| (layer.weight(), layer.bias()))
    }

    fn logits(&self, inputs: &Tensor) -> Result<Tensor, ModelError> {
        let mut values = inputs.clone();
        for (number, layer) in self.layers.iter().enumerate() {
            values = layer.forward(&values)?;
            if number + 1 < self.layers.len() {
                values = values.relu()?;
            }
        }
        Ok(values)
    }

    /// Probability of wet for each row of standardised features.
    pub fn wet(&self, rows: &[[f32; FEATURES]]) -> Result<Vec<f64>, ModelError> {
        let inputs = Tensor::from_slice(rows.as_flattened(), (rows.len(), FEATURES), &Device::Cpu)?;
        let probabilities = ops::softmax(&self.logits(&inputs)?, 1)?;
        let wet = probabilities.narrow(1, WET, 1)?.flatten_all()?.to_dtype(DType::F64)?;
        Ok(wet.to_vec1::<f64>()?)
    }
}

/// A network that learns.
pub(crate) struct Learner {
    vars: Vec<(Var, Var)>,
    optimiser: AdamW,
    pub network: Network,
}

impl Learner {
    /// Random weights after He et al. 2015: uniform within √(6 / inputs); biases zero. Drawn here, because candle's own
    /// initialisation knows no seed.
    pub fn new(random: &mut Pcg64Mcg, weight_decay: f64) -> Result<Self, ModelError> {
        let mut vars = Vec::new();
        for pair in LAYERS.windows(2) {
            let (inputs, outputs) = (pair[0], pair[1]);
            let bound = (6.0 / inputs as f32).sqrt();
            let weights: Vec<f32> =
                (0..inputs * outputs).map(|_| random.random_range(-bound..bound)).collect();
            let weight = Var::from_vec(weights, (outputs, inputs), &Device::Cpu)?;
            vars.push((weight, Var::zeros(outputs, DType::F32, &Device::Cpu)?));
        }
        let layers: Vec<Layer> = vars
            .iter()
            .map(|(weight, bias)| (weight.as_tensor().clone(), bias.as_tensor().clone()))
            .collect();
        let all = vars.iter().flat_map(|(weight, bias)| [weight.clone(), bias.clone()]).collect();
        let optimiser = AdamW::new(all, ParamsAdamW { weight_decay, ..ParamsAdamW::default() })?;
        Ok(Self { vars, optimiser, network: Network::of(&layers) })
    }

    /// One step on a batch.
    pub fn step(
        &mut self,
        rows: &[[f32; FEATURES]],
        classes: &[u32],
        learning_rate: f64,
    ) -> Result<(), ModelError> {
        let inputs = Tensor::from_slice(rows.as_flattened(), (rows.len(), FEATURES), &Device::Cpu)?;
        let targets = Tensor::from_slice(classes, classes.len(), &Device::Cpu)?;
        let loss = loss::cross_entropy(&self.network.logits(&inputs)?, &targets)?;
        self.optimiser.set_learning_rate(learning_rate);
        self.optimiser.backward_step(&loss)?;
        Ok(())
    }

    /// A copy of the weights as they are now.
    pub fn layers(&self) -> Result<Vec<Layer>, ModelError> {
        let copy = |var: &Var| var.as_tensor().copy();
        self.vars.iter().map(|(weight, bias)| Ok((copy(weight)?, copy(bias)?))).collect()
    }
}
