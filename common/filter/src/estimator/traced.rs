//! The estimator of speeds behind the one interface, with what smoothing needs.

use super::{WagonEstimator, flags};
use crate::models::DrivenSample;
use crate::trace::StepTrace;
use crate::{Estimator, EstimatorInput, EstimatorOutput, EstimatorSnapshot, FilterError};
use nalgebra::{DMatrix, DVector};

impl Estimator for WagonEstimator {
    fn step(&mut self, input: &EstimatorInput) -> EstimatorOutput {
        match input {
            EstimatorInput::Wagon(sample) => Self::step(self, sample),
            EstimatorInput::Traction(_) | EstimatorInput::Bogie(_) => self.ignored(),
        }
    }

    fn last(&self) -> &EstimatorOutput {
        Self::last(self)
    }

    fn wheelsets(&self) -> usize {
        Self::wheelsets(self)
    }

    fn snapshot(&self) -> EstimatorSnapshot {
        Self::snapshot(self)
    }

    fn restore(&mut self, snapshot: &EstimatorSnapshot) -> Result<(), FilterError> {
        Self::restore(self, snapshot)
    }

    fn boxed_clone(&self) -> Box<dyn Estimator> {
        Box::new(self.clone())
    }

    fn traced_step(&mut self, input: &EstimatorInput) -> Option<StepTrace> {
        let EstimatorInput::Wagon(input) = input else { return None };
        let (mean_before, covariance_before) = self.filter.0.belief()?;
        let size = mean_before.len();
        let mut transition = DMatrix::identity(size, size);
        let mut predicted: Option<(DVector<f64>, DMatrix<f64>)> = None;
        let mut seen = DrivenSample::default();
        let was_started = self.memory.started;
        let output = self.step_watched(input, &mut |filter, sample| {
            transition = filter.transition() * &transition;
            predicted = filter.belief();
            seen = *sample;
        });
        let (mean, covariance) = self.filter.0.belief()?;
        let ignored = output.flags & flags::IGNORED != 0;
        // Where nothing was predicted the motion was measured anew, unless the sample was ignored.
        let begins = !was_started
            || output.flags & flags::RESTARTED != 0
            || (predicted.is_none() && !ignored)
            || self.believed;
        let (predicted_mean, predicted_covariance) =
            predicted.unwrap_or_else(|| (mean_before, covariance_before.clone()));
        Some(StepTrace {
            begins,
            predicted_mean,
            predicted_covariance,
            mean,
            covariance,
            cross: covariance_before * transition.transpose(),
            output,
            sample: seen,
            memory: self.filter.0.save().memory,
        })
    }

    fn read_smoothed(&mut self, trace: &StepTrace, mean: &[f64], covariance: &[f64]) -> EstimatorOutput {
        let mut filter = self.filter.clone();
        let state = crate::FilterState {
            mean: mean.to_vec(),
            covariance: covariance.to_vec(),
            memory: trace.memory.clone(),
        };
        // A covariance that rounding made unsound says less than that of the way forward.
        if trace.output.flags & flags::IGNORED != 0 || filter.0.load(&state).is_err() {
            return trace.output;
        }
        let mut read = EstimatorOutput::default();
        filter.0.read(&trace.sample, &mut read);
        EstimatorOutput {
            v_m_s: read.v_m_s,
            mu_w: read.mu_w,
            mu_w_sigma: read.mu_w_sigma,
            mu_w_wheelset: read.mu_w_wheelset,
            mu_w_wheelset_sigma: read.mu_w_wheelset_sigma,
            mu_b: read.mu_b,
            mu_b_sigma: read.mu_b_sigma,
            mu_b_mean: read.mu_b_mean,
            mu_b_mean_sigma: read.mu_b_mean_sigma,
            normal_load_n: read.normal_load_n,
            observable: read.observable,
            ..trace.output
        }
    }
}
