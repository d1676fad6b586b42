//! The filters of the traction rig behind the one interface: motor currents, voltages and speeds in, the same estimate
//! and innovation records out, and bad input named.
//!
//! | what | behaviour |
//! | --- | --- |
//! | no time, the same time, up to 1 s back | ignored; the estimate repeats the last one |
//! | time set back further, or a gap above [`LONGEST_GAP_S`] | started anew |
//! | a value missing | the others carry on; missing for [`MISSING_S`]: named state |
//! | a current or voltage that repeats one value while the motor turns | the same |
//! | a voltage vector beyond the inverter's limit, or beyond what current and speed allow | `voltage_implausible` |
//! | innovations far beyond their sigma for [`MISSING_S`] | `inputs_inconsistent` |
//! | current or voltage turning against the motor | `phases_swapped` |
//! | most samples at another rate than the rig's file says | `wrong_sample_rate` |
//!
//! In such a state no figure of the contact means anything; [`crate::EstimateState::is_fault`] says so.

use super::sample_rate::SampleRate;
use super::traction_rig::{
    Extended, OUTPUTS, STATES, State, TractionBelief, TractionEstimate, TractionFilter, TractionModel,
    TractionNoise, TractionSample, Unscented,
};
use super::{DrivenSample, FilterState};
use crate::core::Gaussian;
use crate::memory::Memory;
use crate::output::flags;
use crate::trace::StepTrace;
use crate::{
    EstimateState, Estimator, EstimatorInput, EstimatorOutput, EstimatorSnapshot, FilterError,
    TractionRigFile,
};
use nalgebra::{DMatrix, DVector, SMatrix};

/// Bad input that lasts so long is named, s.
const MISSING_S: f64 = 0.05;
/// A gap beyond which the belief is worthless, s.
const LONGEST_GAP_S: f64 = 0.2;
/// A step back in time up to this is a late sample, s.
const LATE_S: f64 = 1.0;
/// Longest step of a prediction, s: gaps are cut into such steps.
const LONGEST_STEP_S: f64 = 2e-3;
/// Below this speed of the motor currents and voltages need not change, rad/s.
const TURNING_RAD_S: f64 = 2.0;
/// Mean of normalised innovations squared over their number that no noise explains.
const INCONSISTENT: f64 = 30.0;
/// Voltage over the largest that a motor can have in steady state at this current and speed.
const TOO_MUCH_VOLTAGE: f64 = 1.5;
/// Creepage from which the wheel is said to spin.
const SPINS_FROM: f64 = 0.02;

/// Watch over the inputs of a driven rig.
#[derive(Clone, Copy, Debug, Default)]
struct InputWatch {
    last: [f64; OUTPUTS],
    absent_s: [f64; OUTPUTS],
    too_high_s: f64,
    surprise: f64,
}

/// A filter of the traction rig with everything around it.
#[derive(Clone)]
pub struct MotorEstimator<B> {
    /// The filter.
    pub filter: TractionFilter<B>,
    name: &'static str,
    rig: TractionRigFile,
    watch: InputWatch,
    rate: SampleRate,
    running_s: f64,
    resumed: bool,
    last: EstimatorOutput,
}

/// The unscented filter of a traction rig.
pub(super) fn boxed_ukf(rig: &TractionRigFile) -> Result<Box<dyn Estimator>, FilterError> {
    Ok(Box::new(MotorEstimator::<Unscented>::new("zhao", rig)?))
}

/// The extended filter of a traction rig.
pub(super) fn boxed_ekf(rig: &TractionRigFile) -> Result<Box<dyn Estimator>, FilterError> {
    Ok(Box::new(MotorEstimator::<Extended>::new("zhao_ekf", rig)?))
}

impl<B: TractionBelief + 'static> MotorEstimator<B> {
    /// The estimator of a traction rig.
    ///
    /// # Errors
    /// Parameters out of range.
    pub fn new(name: &'static str, rig: &TractionRigFile) -> Result<Self, FilterError> {
        rig.check()?;
        let sensors = &rig.sensors;
        let sigmas = [
            sensors.current_sigma_a,
            sensors.current_sigma_a,
            sensors.motor_speed_sigma_rad_s,
            sensors.voltage_sigma_v,
            sensors.voltage_sigma_v,
            sensors.roller_speed_sigma_rad_s,
            sensors.generator_current_sigma_a,
        ];
        let noise = TractionNoise { sensors: sigmas.into(), ..TractionNoise::default() };
        Ok(Self {
            filter: TractionFilter::new(TractionModel::new(rig.rig()), noise),
            name,
            rig: rig.clone(),
            watch: InputWatch::default(),
            rate: SampleRate::default(),
            running_s: 0.0,
            resumed: false,
            last: EstimatorOutput { wheelsets: 1, ..EstimatorOutput::default() },
        })
    }

    /// Names what is wrong with the input, if anything.
    fn judge_input(
        &mut self,
        sample: &TractionSample,
        estimate: &TractionEstimate,
        dt_s: f64,
    ) -> Option<EstimateState> {
        let turning = sample.motor_speed_rad_s.abs() > TURNING_RAD_S || !sample.motor_speed_rad_s.is_finite();
        let high = voltage(sample) > self.rig.sensors.voltage_limit_v
            || voltage(sample) > TOO_MUCH_VOLTAGE * self.most_voltage_v(sample);
        let watch = &mut self.watch;
        for (slot, value) in sample.outputs().into_iter().enumerate() {
            let alternating = matches!(slot, 0 | 1 | 3 | 4);
            let repeats = alternating && turning && value == watch.last[slot];
            watch.absent_s[slot] =
                if value.is_finite() && !repeats { 0.0 } else { watch.absent_s[slot] + dt_s };
            watch.last[slot] = value;
        }
        watch.too_high_s = if high { watch.too_high_s + dt_s } else { 0.0 };
        if estimate.nis_dof > 0 && self.running_s > 0.5 {
            let ratio = (estimate.nis / f64::from(estimate.nis_dof)).min(100.0 * INCONSISTENT);
            watch.surprise += (dt_s / MISSING_S).min(1.0) * (ratio - watch.surprise);
        }
        let absent = |slots: &[usize]| slots.iter().any(|slot| watch.absent_s[*slot] >= MISSING_S);
        if self.rate.is_wrong() {
            Some(EstimateState::WrongRate)
        } else if absent(&[0, 1]) {
            Some(EstimateState::CurrentMissing)
        } else if absent(&[3, 4]) {
            Some(EstimateState::VoltageMissing)
        } else if absent(&[2, 5]) {
            Some(EstimateState::SpeedMissing)
        } else if absent(&[6]) {
            Some(EstimateState::LoadCurrentMissing)
        } else if watch.too_high_s >= MISSING_S {
            Some(EstimateState::VoltageImplausible)
        } else if estimate.state == EstimateState::PhasesSwapped {
            Some(EstimateState::PhasesSwapped)
        } else if watch.surprise > INCONSISTENT {
            Some(EstimateState::Inconsistent)
        } else {
            None
        }
    }

    /// Largest steady voltage at this current and speed: u = R i + j ω (σ L i + (L_m/L_r) ψ) with |ψ| ≤ L_m |i|, so that
    /// |u| ≤ (R + ω L) |i|; ω is at most the speed of the rotor and as much slip as the drive uses.
    fn most_voltage_v(&self, sample: &TractionSample) -> f64 {
        let motor = &self.rig.motor;
        let current = sample.current_a[0].hypot(sample.current_a[1]);
        let slip = motor.rotor_resistance_ohm / motor.rotor_inductance_h * 4.0;
        let frequency = motor.pole_pairs * sample.motor_speed_rad_s.abs() + slip;
        let most = (motor.stator_resistance_ohm + frequency * motor.stator_inductance_h) * current;
        if most.is_finite() { most + 20.0 * self.rig.sensors.voltage_sigma_v } else { f64::INFINITY }
    }

    /// Brings the filter to the time of the sample and measures; what it says.
    fn advance(&mut self, sample: &TractionSample, gap_s: f64) -> TractionEstimate {
        // Samples without any value carry the belief over a gap.
        if gap_s > 2.5 / self.rig.sensors.sample_rate_hz {
            let from_s = self.filter.last_time_s();
            let parts = (gap_s / LONGEST_STEP_S).ceil().max(1.0);
            for part in 1..parts as usize {
                let time_s = from_s + gap_s * part as f64 / parts;
                self.filter.step(&TractionSample::missing(time_s));
            }
        }
        self.filter.step(sample)
    }

    fn output(&self, sample: &TractionSample, estimate: &TractionEstimate) -> EstimatorOutput {
        let drive = &self.rig.drivetrain;
        let load_n = drive.normal_load_n;
        let mut out = EstimatorOutput {
            time_s: sample.time_s,
            wheelsets: 1,
            state: estimate.state,
            ..Default::default()
        };
        let speed = match &self.filter.belief {
            Some(belief) => belief.mean()[super::traction_rig::index::ROLLER_SPEED],
            None => 0.0,
        };
        out.v_m_s = speed * drive.roller_radius_m;
        out.mu_w = estimate.creep_force_n / load_n;
        out.mu_w_sigma = estimate.creep_force_sigma_n / load_n;
        out.mu_w_wheelset[0] = out.mu_w;
        out.mu_w_wheelset_sigma[0] = out.mu_w_sigma;
        out.slip[0] = estimate.creepage;
        out.normal_load_n[0] = load_n;
        out.adhesion_peak = estimate.adhesion_peak;
        out.adhesion_peak_sigma = estimate.adhesion_peak_sigma;
        (out.nis, out.nis_dof) = (estimate.nis, estimate.nis_dof);
        out.rejected = estimate.rejected;
        out.innovations = estimate.innovations;
        if estimate.creepage.abs() > SPINS_FROM && out.v_m_s > 0.1 {
            out.sliding = 1;
        }
        out
    }

    /// The state, and the marks that follow from it.
    fn mark(&mut self, out: &mut EstimatorOutput, fault: Option<EstimateState>) {
        if let Some(fault) = fault {
            out.state = fault;
            out.flags |= flags::HELD;
            out.sliding = 0;
        }
        if out.state == EstimateState::Observable {
            out.observable = 1;
        }
        if out.innovations.fused == 0 {
            out.flags |= flags::PREDICTED;
        }
        if out.state == EstimateState::Starting {
            out.flags |= flags::CONVERGING;
        }
        if !out.state.tells_friction() {
            out.flags |= flags::HELD;
        }
        if std::mem::take(&mut self.resumed) {
            out.flags |= flags::RESUMED;
        }
        out.observability_rank = STATES as u32 - u32::from(out.observable == 0);
    }

    fn ignored(&self) -> EstimatorOutput {
        EstimatorOutput {
            flags: (self.last.flags & flags::CONVERGING) | flags::IGNORED | flags::PREDICTED,
            innovations: crate::InnovationRecord::default(),
            nis: 0.0,
            nis_dof: 0,
            rejected: 0,
            ..self.last
        }
    }
}

fn voltage(sample: &TractionSample) -> f64 {
    let amplitude = sample.voltage_v[0].hypot(sample.voltage_v[1]);
    if amplitude.is_nan() { 0.0 } else { amplitude }
}

impl<B: TractionBelief + 'static> Estimator for MotorEstimator<B> {
    fn step(&mut self, input: &EstimatorInput) -> EstimatorOutput {
        let EstimatorInput::Traction(sample) = *input else { return self.ignored() };
        let gap_s = sample.time_s - self.filter.last_time_s();
        let started = self.filter.belief.is_some();
        let late = (-LATE_S..1e-6).contains(&gap_s);
        if !sample.time_s.is_finite() || (started && late) {
            return self.ignored();
        }
        if started && gap_s > 0.0 {
            self.rate.take(gap_s, self.rig.sensors.sample_rate_hz);
        }
        let mut restarted = false;
        if started && !(0.0..=LONGEST_GAP_S).contains(&gap_s) {
            self.filter = TractionFilter::new(self.filter.model.clone(), self.filter.noise);
            self.watch = InputWatch::default();
            self.running_s = 0.0;
            restarted = true;
        }
        let usual_s = 1.0 / self.rig.sensors.sample_rate_hz;
        let dt_s = if started && !restarted { gap_s } else { usual_s };
        self.running_s += dt_s;
        let estimate = self.advance(&sample, if restarted { 0.0 } else { gap_s });
        let fault = self.judge_input(&sample, &estimate, dt_s);
        let mut out = self.output(&sample, &estimate);
        if restarted || (!started && self.filter.belief.is_some()) {
            out.flags |= flags::RESTARTED;
        }
        if gap_s > 2.5 * usual_s {
            out.flags |= flags::GAP;
        }
        self.mark(&mut out, fault);
        self.last = out;
        out
    }

    fn last(&self) -> &EstimatorOutput {
        &self.last
    }

    fn wheelsets(&self) -> usize {
        1
    }

    fn snapshot(&self) -> EstimatorSnapshot {
        let (mean, covariance) = match &self.filter.belief {
            Some(belief) => {
                let gaussian = belief.gaussian();
                (gaussian.mean.iter().copied().collect(), gaussian.covariance.iter().copied().collect())
            }
            None => (Vec::new(), Vec::new()),
        };
        let mut memory = self.filter.memory();
        memory.push(self.running_s);
        memory.extend(self.watch.last);
        memory.extend(self.watch.absent_s);
        memory.extend([self.watch.too_high_s, self.watch.surprise, self.rate.off]);
        EstimatorSnapshot {
            schema: crate::snapshot::SCHEMA,
            filter: self.name.into(),
            vehicle: self.rig.name.clone(),
            state: FilterState { mean, covariance, memory },
            hidden: Vec::new(),
            v_m_s: self.last.v_m_s,
            memory: Memory::default(),
        }
    }

    fn restore(&mut self, snapshot: &EstimatorSnapshot) -> Result<(), FilterError> {
        if snapshot.schema != crate::snapshot::SCHEMA || snapshot.vehicle != self.rig.name {
            return Err(FilterError::SnapshotVehicle);
        }
        if snapshot.filter != self.name {
            let (expected, found) = (self.name.to_owned(), snapshot.filter.clone());
            return Err(FilterError::SnapshotFilter { expected, found });
        }
        let state = &snapshot.state;
        let own = self.filter.memory().len();
        let shape = FilterError::SnapshotShape { expected: STATES, found: state.mean.len() };
        let empty = state.mean.is_empty() && state.covariance.is_empty();
        if !empty && (state.mean.len() != STATES || state.covariance.len() != STATES * STATES)
            || state.memory.len() != own + 4 + 2 * OUTPUTS
        {
            return Err(shape);
        }
        let mut filter = self.filter.clone();
        if !empty {
            let gaussian = Gaussian::<STATES> {
                mean: State::from_column_slice(&state.mean),
                covariance: SMatrix::from_column_slice(&state.covariance),
            };
            let blank = B::independent(gaussian.mean, &State::repeat(1.0), &filter.spread);
            filter.belief = Some(blank.of_gaussian(&gaussian).ok_or(FilterError::SnapshotUnsound)?);
        }
        if !filter.remember(&state.memory[..own]) {
            return Err(shape);
        }
        self.filter = filter;
        let rest = &state.memory[own..];
        self.running_s = rest[0];
        self.watch.last.copy_from_slice(&rest[1..=OUTPUTS]);
        self.watch.absent_s.copy_from_slice(&rest[1 + OUTPUTS..=2 * OUTPUTS]);
        (self.watch.too_high_s, self.watch.surprise) = (rest[1 + 2 * OUTPUTS], rest[2 + 2 * OUTPUTS]);
        self.rate.off = rest[3 + 2 * OUTPUTS];
        self.last.v_m_s = snapshot.v_m_s;
        self.resumed = !empty;
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn Estimator> {
        Box::new(self.clone())
    }

    fn traced_step(&mut self, input: &EstimatorInput) -> Option<StepTrace> {
        if !matches!(input, EstimatorInput::Traction(_)) {
            return None;
        }
        let before = self.filter.belief.clone();
        let dt_s = input.time_s() - self.filter.last_time_s();
        let sound = before.is_some() && dt_s > 0.0 && dt_s <= 2.5 / self.rig.sensors.sample_rate_hz;
        let mut ahead = before.clone();
        let cross = match (&mut ahead, &before, sound) {
            (Some(ahead), Some(before), true) => {
                ahead.predict(&self.filter.model, &self.filter.noise.over(dt_s), dt_s);
                before.cross(&self.filter.model, dt_s)
            }
            _ => SMatrix::zeros(),
        };
        let output = self.step(input);
        let ignored = output.flags & flags::IGNORED != 0;
        let after = match &self.filter.belief {
            Some(belief) => belief.gaussian(),
            None => Gaussian::independent(State::zeros(), &State::repeat(1.0)),
        };
        let predicted = ahead.map_or(after, |belief| belief.gaussian());
        let begins = !sound && !ignored
            || self.filter.is_settling(input.time_s())
            || output.flags & flags::RESTARTED != 0;
        let whole = |matrix: &SMatrix<f64, STATES, STATES>| {
            DMatrix::from_column_slice(STATES, STATES, matrix.as_slice())
        };
        Some(StepTrace {
            begins,
            predicted_mean: DVector::from_column_slice(predicted.mean.as_slice()),
            predicted_covariance: whole(&predicted.covariance),
            mean: DVector::from_column_slice(after.mean.as_slice()),
            covariance: whole(&after.covariance),
            cross: if ignored { whole(&after.covariance) } else { whole(&cross) },
            output,
            sample: DrivenSample::default(),
            memory: Vec::new(),
        })
    }

    fn read_smoothed(&mut self, trace: &StepTrace, mean: &[f64], covariance: &[f64]) -> EstimatorOutput {
        let gaussian = Gaussian::<STATES> {
            mean: State::from_column_slice(mean),
            covariance: SMatrix::from_column_slice(covariance),
        };
        let belief = self.filter.belief.as_ref().and_then(|belief| belief.of_gaussian(&gaussian));
        let Some(belief) = belief else { return trace.output };
        let mut estimate = TractionEstimate::default();
        self.filter.read_belief(&belief, trace.output.time_s, &mut estimate);
        let load_n = self.rig.drivetrain.normal_load_n;
        let speed = belief.mean()[super::traction_rig::index::ROLLER_SPEED];
        let mu_w = estimate.creep_force_n / load_n;
        let mu_w_sigma = estimate.creep_force_sigma_n / load_n;
        let mut out = EstimatorOutput {
            v_m_s: speed * self.rig.drivetrain.roller_radius_m,
            mu_w,
            mu_w_sigma,
            adhesion_peak: estimate.adhesion_peak,
            adhesion_peak_sigma: estimate.adhesion_peak_sigma,
            ..trace.output
        };
        out.slip[0] = estimate.creepage;
        (out.mu_w_wheelset[0], out.mu_w_wheelset_sigma[0]) = (mu_w, mu_w_sigma);
        out
    }
}
