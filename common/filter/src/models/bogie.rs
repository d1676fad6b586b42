//! The filter of the bogie rig behind the one interface: torque, link force and pulses in, the same estimate and
//! innovation records out, and bad input named.
//!
//! | what | behaviour |
//! | --- | --- |
//! | no time, the same time, up to 1 s back | ignored; the estimate repeats the last one |
//! | time set back further, or a gap above 1 s | the motion is measured anew, zero errors are kept |
//! | samples missing in between | predicted; counters whose window is torn begin anew |
//! | most samples at another rate than the rig's file says | `wrong_sample_rate` |
//! | no load, a frozen, missing or exchanged sensor, forces that contradict each other | see [`super::bogie_rig`] |
//!
//! Outputs of the innovation record: torque (N m), link force (N), angles of the rollers and of each wheelset (rad).
//! Pad friction is not estimated: it stays nominal and is never called observable.

use super::bogie_rig::{
    BogieEstimate, BogieFilter, BogieInputState, BogieNoise, BogieSample, GATE_SIGMA, OUTPUTS, STATES,
};
use super::sample_rate::SampleRate;
use super::{FilterState, pack, unpack};
use crate::memory::Memory;
use crate::output::flags;
use crate::trace::StepTrace;
use crate::{
    BogieRigFile, EstimateState, Estimator, EstimatorInput, EstimatorOutput, EstimatorSnapshot, FilterError,
    InnovationRecord,
};
use railgrip_vehicle::bogie_rig::BOGIE_WHEELSETS;

/// Name of the filter.
const NAME: &str = "shrestha";
/// A step back in time up to this is a late sample, s.
const LATE_S: f64 = 1.0;
/// Slip beyond the peak of every curve of adhesion: the wheelset slides.
const SLIDES_FROM: f64 = 0.2;
/// How much the wheelsets' shares of the adhesion may differ, 1 σ as a share of it: one circuit presses both, their
/// pads differ. Chosen.
const SHARE_SIGMA: f64 = 0.05;
/// 1 σ of the pad friction that is not estimated, as a share of the nominal one.
const PAD_SIGMA: f64 = 0.2;

/// The filter of a bogie rig with everything around it.
#[derive(Clone)]
pub struct BogieEstimator {
    /// The filter.
    pub filter: BogieFilter,
    rig: BogieRigFile,
    rate: SampleRate,
    resumed: bool,
    last: EstimatorOutput,
}

/// The filter of a bogie rig.
pub(super) fn boxed(rig: &BogieRigFile) -> Result<Box<dyn Estimator>, FilterError> {
    Ok(Box::new(BogieEstimator::new(rig)?))
}

impl BogieEstimator {
    /// The estimator of a bogie rig.
    ///
    /// # Errors
    /// Parameters out of range.
    pub fn new(rig: &BogieRigFile) -> Result<Self, FilterError> {
        rig.check()?;
        let wheelsets = BOGIE_WHEELSETS as u32;
        Ok(Self {
            filter: BogieFilter::new(rig.parameters(), BogieNoise::default()),
            rig: rig.clone(),
            rate: SampleRate::default(),
            resumed: false,
            last: EstimatorOutput { wheelsets, ..EstimatorOutput::default() },
        })
    }

    fn output(&self, sample: &BogieSample, estimate: &BogieEstimate) -> EstimatorOutput {
        let told = |new: f64, before: f64| if new.is_finite() { new } else { before };
        let (p, last) = (&self.filter.model.parameters, &self.last);
        let mut out = EstimatorOutput {
            time_s: sample.time_s,
            wheelsets: BOGIE_WHEELSETS as u32,
            state: state_of(estimate.state),
            v_m_s: told(estimate.v_m_s, last.v_m_s),
            mu_w: told(estimate.mu_w, last.mu_w),
            mu_w_sigma: told(estimate.mu_w_sigma, last.mu_w_sigma),
            mu_b_mean: self.rig.brake.friction_coefficient,
            mu_b_mean_sigma: PAD_SIGMA * self.rig.brake.friction_coefficient,
            nis: estimate.nis,
            nis_dof: estimate.nis_dof,
            rejected: estimate.rejected,
            innovations: record(estimate),
            observability_rank: STATES as u32,
            ..EstimatorOutput::default()
        };
        let pressure =
            if sample.brake_pressure_pa.is_finite() { sample.brake_pressure_pa.max(0.0) } else { 0.0 };
        let press_n = pressure * p.brake.torque_per_pressure_nm_pa() / p.brake.friction_radius_m;
        let nominal_n = p.load_n();
        let load = if sample.load_n.is_finite() { sample.load_n.max(0.0) / nominal_n } else { 1.0 };
        for i in 0..BOGIE_WHEELSETS {
            out.mu_w_wheelset[i] = out.mu_w;
            out.mu_w_wheelset_sigma[i] = out.mu_w_sigma.hypot(SHARE_SIGMA * out.mu_w);
            (out.mu_b[i], out.mu_b_sigma[i]) = (out.mu_b_mean, out.mu_b_mean_sigma);
            out.slip[i] = told(estimate.creepage[i], last.slip[i]);
            out.normal_load_n[i] = load * p.wheelset_load_n[i];
            out.pressing_force_n[i] = press_n;
            if estimate.state.tells_slip() && out.slip[i] < -SLIDES_FROM {
                out.sliding |= 1 << i;
            }
        }
        out
    }

    /// The marks that follow from state and sample.
    fn mark(&mut self, out: &mut EstimatorOutput, gap_s: f64, started: bool) {
        if self.rate.is_wrong() {
            out.state = EstimateState::WrongRate;
            out.sliding = 0;
        }
        // Nothing here tells the pads' friction.
        out.flags |= flags::HELD;
        if out.innovations.fused == 0 {
            out.flags |= flags::PREDICTED;
        }
        if out.state == EstimateState::Starting {
            out.flags |= flags::CONVERGING;
        }
        if gap_s > 1.5 * self.filter.model.parameters.sensors.sample_period_s {
            out.flags |= flags::GAP;
        }
        if !started {
            out.flags |= flags::RESTARTED;
        }
        if std::mem::take(&mut self.resumed) {
            out.flags |= flags::RESUMED;
        }
    }

    fn ignored(&self) -> EstimatorOutput {
        EstimatorOutput {
            flags: (self.last.flags & flags::CONVERGING) | flags::IGNORED | flags::PREDICTED,
            innovations: InnovationRecord::default(),
            nis: 0.0,
            nis_dof: 0,
            rejected: 0,
            ..self.last
        }
    }
}

/// What came beside what was expected. Counts have no gate: their ratio is against that of the forces.
fn record(estimate: &BogieEstimate) -> InnovationRecord {
    let mut record = InnovationRecord { rejected: estimate.rejected, ..InnovationRecord::default() };
    for i in 0..OUTPUTS {
        let (innovation, variance) = (estimate.innovation[i], estimate.innovation_variance[i]);
        record.innovation[i] = innovation;
        record.innovation_variance[i] = variance;
        if variance > 0.0 {
            record.test_ratio[i] = innovation * innovation / (variance * GATE_SIGMA * GATE_SIGMA);
            record.fused |= (1 << i) & !estimate.rejected;
        }
    }
    record
}

/// The state under the name that all filters share.
const fn state_of(state: BogieInputState) -> EstimateState {
    use BogieInputState as B;
    match state {
        B::Starting => EstimateState::Starting,
        B::Rolling | B::Braking | B::WheelLocked => EstimateState::Observable,
        B::Standstill => EstimateState::Standstill,
        B::ZeroLoad => EstimateState::ZeroLoad,
        B::TorqueDead => EstimateState::TorqueMissing,
        B::LoadCellDead => EstimateState::LoadCellMissing,
        B::ForcesDead => EstimateState::ForcesMissing,
        B::RollerCounterDead => EstimateState::RollerCounterMissing,
        B::WheelCounterDead => EstimateState::WheelCounterMissing,
        B::ForcesSwapped => EstimateState::ForcesSwapped,
        B::CountersSwapped => EstimateState::CountersSwapped,
        B::ForcesDisagree => EstimateState::ForcesDisagree,
    }
}

impl Estimator for BogieEstimator {
    fn step(&mut self, input: &EstimatorInput) -> EstimatorOutput {
        let EstimatorInput::Bogie(sample) = *input else { return self.ignored() };
        let started = self.filter.belief.is_some();
        let gap_s = if started { sample.time_s - self.filter.last_time_s() } else { 0.0 };
        if !sample.time_s.is_finite() || (started && (-LATE_S..1e-6).contains(&gap_s)) {
            return self.ignored();
        }
        if gap_s < 0.0 {
            self.filter.forget_time();
        } else if started {
            self.rate.take(gap_s, self.rig.sensors.sample_rate_hz);
        }
        let estimate = self.filter.step(&sample);
        let mut out = self.output(&sample, &estimate);
        self.mark(&mut out, gap_s, started && gap_s > 0.0);
        self.last = out;
        out
    }

    fn last(&self) -> &EstimatorOutput {
        &self.last
    }

    fn wheelsets(&self) -> usize {
        BOGIE_WHEELSETS
    }

    /// Belief and time; what the watch over the sensors saw is seen anew within half a second.
    fn snapshot(&self) -> EstimatorSnapshot {
        let state = match &self.filter.belief {
            Some(belief) => pack(belief, vec![self.filter.last_time_s(), self.rate.off]),
            None => FilterState { mean: Vec::new(), covariance: Vec::new(), memory: Vec::new() },
        };
        EstimatorSnapshot {
            schema: crate::snapshot::SCHEMA,
            filter: NAME.into(),
            vehicle: self.rig.name.clone(),
            state,
            hidden: Vec::new(),
            v_m_s: self.last.v_m_s,
            memory: Memory::default(),
        }
    }

    fn restore(&mut self, snapshot: &EstimatorSnapshot) -> Result<(), FilterError> {
        if snapshot.schema != crate::snapshot::SCHEMA || snapshot.vehicle != self.rig.name {
            return Err(FilterError::SnapshotVehicle);
        }
        if snapshot.filter != NAME {
            let (expected, found) = (NAME.to_owned(), snapshot.filter.clone());
            return Err(FilterError::SnapshotFilter { expected, found });
        }
        if snapshot.state.mean.is_empty() {
            return Ok(());
        }
        let belief = unpack::<STATES>(&snapshot.state, 2)?;
        self.filter.resume(belief, snapshot.state.memory[0]);
        self.rate.off = snapshot.state.memory[1];
        self.last.v_m_s = snapshot.v_m_s;
        self.resumed = true;
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn Estimator> {
        Box::new(self.clone())
    }

    /// Not smoothed: its counters begin anew with every reading, and noise grows while a sample is used.
    fn traced_step(&mut self, _input: &EstimatorInput) -> Option<StepTrace> {
        None
    }

    fn read_smoothed(&mut self, trace: &StepTrace, _mean: &[f64], _covariance: &[f64]) -> EstimatorOutput {
        trace.output
    }
}
