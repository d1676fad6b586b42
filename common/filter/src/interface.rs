//! The one interface of every filter: samples in, estimates and innovations out, whatever is watched.

use crate::trace::StepTrace;
use crate::{EstimatorInput, EstimatorOutput, EstimatorSnapshot, FilterError};

/// A filter with everything around it, for one wagon or rig. A step is pure: no clock, channel, file or allocation.
pub trait Estimator: Send {
    /// Takes one sample and says what is known after it. Never fails; what it did to bad data is in flags and state.
    fn step(&mut self, input: &EstimatorInput) -> EstimatorOutput;

    /// The last estimate.
    fn last(&self) -> &EstimatorOutput;

    /// Wheelsets of what is watched.
    fn wheelsets(&self) -> usize;

    /// Everything that a restart needs to go on from here.
    fn snapshot(&self) -> EstimatorSnapshot;

    /// Goes on from a snapshot. After an error the estimator is as before.
    ///
    /// # Errors
    /// A snapshot of another filter, vehicle or shape, or one that is not sound.
    fn restore(&mut self, snapshot: &EstimatorSnapshot) -> Result<(), FilterError>;

    /// A copy that goes on by itself.
    fn boxed_clone(&self) -> Box<dyn Estimator>;

    /// The same step with what a smoother needs on the way back; `None` if this filter cannot be smoothed.
    fn traced_step(&mut self, input: &EstimatorInput) -> Option<StepTrace>;

    /// The estimate of a traced step with another belief in its place.
    fn read_smoothed(&mut self, trace: &StepTrace, mean: &[f64], covariance: &[f64]) -> EstimatorOutput;
}
