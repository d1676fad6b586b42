//! The one stepping type: a sample in, an estimate out, with no clock, channel or file. The live estimator and the
//! offline command both use it, so that a replay equals an offline run sample for sample.

use crate::hygiene::{HeldInput, SensorWatch, TimeBase, TimeStep, Verdict, without_nonsense};
use crate::laws::{Laws, Place};
use crate::models::{DrivenSample, WagonFilter};
use crate::output::{InnovationRecord, MAX_OUTPUTS, flags};
use crate::{EstimatorConfig, EstimatorInput, EstimatorOutput, EstimatorSnapshot, FilterError};
use railgrip_vehicle::{GRAVITY_M_S2, MAX_WHEELSETS, VehicleParameters, WagonModel};
use serde::{Deserialize, Serialize};

/// Longest step of a prediction, s; gaps are cut into such steps.
const LONGEST_STEP_S: f64 = 0.05;
/// Time after a start in which estimates are marked as converging, s.
const CONVERGING_S: f64 = 1.0;

/// Estimator of one wagon.
pub struct WagonEstimator {
    config: EstimatorConfig,
    filter: Box<dyn WagonFilter>,
    laws: Laws,
    vehicle: String,
    wheelsets: usize,
    usual_step_s: f64,
    /// Change of wheelset speed that a believable jump of adhesion makes, rad/s².
    wheel_jump_rad_s2: [f64; MAX_WHEELSETS],
    wheel_radius_m: [f64; MAX_WHEELSETS],
    memory: Memory,
    last: EstimatorOutput,
}

/// What the estimator remembers beside the filter's belief.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    pub(crate) time: TimeBase,
    pub(crate) forces: [HeldInput; MAX_WHEELSETS],
    pub(crate) torques: [HeldInput; MAX_WHEELSETS],
    pub(crate) grade: HeldInput,
    pub(crate) sanding: HeldInput,
    pub(crate) position: HeldInput,
    pub(crate) watches: [SensorWatch; MAX_OUTPUTS],
    pub(crate) running_s: f64,
    pub(crate) started: bool,
    pub(crate) resumed: bool,
}

impl WagonEstimator {
    /// The estimator of `vehicle`.
    ///
    /// # Errors
    /// Settings or parameters out of range, an unknown filter or effect, or a filter that does not handle the vehicle.
    pub fn new(config: &EstimatorConfig, vehicle: &VehicleParameters) -> Result<Self, FilterError> {
        config.check()?;
        vehicle.check()?;
        let model = WagonModel::new(vehicle)?;
        let constants = model.constants();
        let load_n = constants.mass_kg * GRAVITY_M_S2 / constants.wheelsets as f64;
        let constructor = crate::models::find(&config.filter).ok_or_else(|| {
            crate::ConfigError::UnknownFilter { name: config.filter.clone(), known: crate::models::names() }
        })?;
        Ok(Self {
            config: config.clone(),
            filter: constructor(config, vehicle, &model)?,
            vehicle: format!("{} {} kg, {} wheelsets", vehicle.name, constants.mass_kg, constants.wheelsets),
            wheelsets: constants.wheelsets,
            usual_step_s: 1.0 / vehicle.sensors.sample_rate_hz,
            wheel_jump_rad_s2: std::array::from_fn(|i| {
                config.hygiene.gate_adhesion_jump * load_n * constants.wheel_radius_m[i]
                    / constants.inertia_kg_m2[i].max(1e-9)
            }),
            wheel_radius_m: constants.wheel_radius_m,
            laws: Laws::new(vehicle, model),
            memory: Memory::default(),
            last: EstimatorOutput::default(),
        })
    }

    /// Wheelsets of the vehicle.
    pub fn wheelsets(&self) -> usize {
        self.wheelsets
    }

    /// The last estimate.
    pub fn last(&self) -> &EstimatorOutput {
        &self.last
    }

    /// Takes one sample and says what is known after it. Never fails; what it did to bad data is in the flags.
    pub fn step(&mut self, input: &EstimatorInput) -> EstimatorOutput {
        let input = without_nonsense(input);
        let previous = self.memory.clone();
        let step = self.memory.time.judge(input.time_s, self.usual_step_s, &self.config.hygiene);
        if step == TimeStep::Ignored || !self.can_start(&input) {
            self.memory.time = if step == TimeStep::Ignored { self.memory.time } else { previous.time };
            return EstimatorOutput {
                flags: (self.last.flags & flags::CONVERGING) | flags::IGNORED | flags::PREDICTED,
                innovations: InnovationRecord::default(),
                nis: 0.0,
                nis_dof: 0,
                rejected: 0,
                ..self.last
            };
        }
        let dt_s = match step {
            TimeStep::Regular(dt) | TimeStep::Gap(dt) | TimeStep::LongGap(dt) => dt,
            TimeStep::First | TimeStep::ClockSet | TimeStep::Ignored => self.usual_step_s,
        };
        let mut out =
            EstimatorOutput { time_s: input.time_s, wsp_active: input.wsp_active, ..Default::default() };
        let (mut sample, place) = self.drive(&input, dt_s, &mut out);
        self.laws.apply(&mut sample, &place, &self.last);
        self.advance(step, &sample, dt_s, &mut out);
        self.measure(&sample, dt_s, &mut out);
        self.filter.conclude(&sample, dt_s);
        self.filter.read(&sample, &mut out);
        out.pressing_force_n = sample.pressing_force_n;
        (out.nis, out.nis_dof) = out.innovations.nis();
        out.rejected = out.innovations.rejected;
        self.mark(&mut out, dt_s);
        self.laws.advance(&sample, &out, dt_s);
        self.last = out;
        out
    }

    /// A filter needs one speed to begin with.
    fn can_start(&self, input: &EstimatorInput) -> bool {
        let any_wheel = input.wheel_speed_rad_s[..self.wheelsets].iter().any(|speed| speed.is_finite());
        self.memory.started || input.v_m_s.is_finite() || any_wheel
    }

    /// Inputs of the prediction, held where they are missing.
    fn drive(
        &mut self,
        input: &EstimatorInput,
        dt_s: f64,
        out: &mut EstimatorOutput,
    ) -> (DrivenSample, Place) {
        let hold_s = self.config.hygiene.hold_s;
        let mut sample = DrivenSample {
            v_m_s: input.v_m_s,
            wheel_speed_rad_s: input.wheel_speed_rad_s,
            ..DrivenSample::default()
        };
        let mut held = false;
        for i in 0..self.wheelsets {
            let force = &mut self.memory.forces[i];
            let before = force.value;
            // Noise may carry a force of zero below it.
            let known = force.take(input.pressing_force_n[i], -1e5..=1e7, dt_s, hold_s);
            let now = force.value.max(0.0);
            if !known {
                sample.force_known &= !(1 << i);
            }
            let before = if self.memory.started { before.max(0.0) } else { now };
            sample.pressing_force_n[i] = now;
            sample.step_force_n[i] = 0.5 * (before + now);
            sample.force_change_n[i] = now - before;
            let torque = &mut self.memory.torques[i];
            let torque_known = torque.take(input.drive_torque_nm[i], -1e7..=1e7, dt_s, hold_s);
            sample.drive_torque_nm[i] = if torque_known { torque.value } else { 0.0 };
            held |= self.memory.forces[i].is_held();
        }
        let grade_known = self.memory.grade.take(input.grade_rad, -0.5..=0.5, dt_s, hold_s);
        let priors = &self.config.priors;
        sample.grade_sigma_rad = if grade_known { priors.grade_rad } else { priors.grade_unknown_rad };
        let sand_known = self.memory.sanding.take(input.sanding, 0.0..=1.0, dt_s, hold_s);
        sample.sanding = if sand_known { self.memory.sanding.value } else { 0.0 };
        let placed = self.memory.position.take(input.position_m, -1e9..=1e9, dt_s, hold_s);
        if !placed {
            self.memory.position.value += self.last.v_m_s * dt_s;
        }
        if held {
            out.flags |= flags::HELD;
        }
        let place = Place {
            time_s: input.time_s,
            grade_rad: if grade_known { self.memory.grade.value } else { 0.0 },
            position_m: self.memory.position.value,
        };
        (sample, place)
    }

    /// Brings the filter to the time of the sample.
    fn advance(&mut self, step: TimeStep, sample: &DrivenSample, dt_s: f64, out: &mut EstimatorOutput) {
        if !self.memory.started {
            self.filter.start(sample);
            self.memory.started = true;
            self.memory.running_s = 0.0;
            out.flags |= flags::RESTARTED;
            return;
        }
        match step {
            TimeStep::LongGap(gap_s) => {
                self.filter.restart_motion(sample, gap_s);
                self.memory.watches = Default::default();
                out.flags |= flags::GAP;
            }
            TimeStep::ClockSet => {
                self.filter.restart_motion(sample, 0.0);
                self.memory.watches = Default::default();
                out.flags |= flags::GAP;
            }
            _ => {
                if matches!(step, TimeStep::Gap(_)) {
                    out.flags |= flags::GAP;
                }
                let parts = (dt_s / LONGEST_STEP_S).ceil().max(1.0);
                for _ in 0..parts as usize {
                    self.filter.predict(sample, dt_s / parts);
                }
            }
        }
    }

    /// Compares every measured value with what the filter expects, and uses it or not.
    fn measure(&mut self, sample: &DrivenSample, dt_s: f64, out: &mut EstimatorOutput) {
        let settings = &self.config.hygiene;
        for output in 0..=self.wheelsets {
            let measured = sample.measured(output);
            if !measured.is_finite() {
                continue;
            }
            let update = self.filter.expect(output, measured);
            let sigma = update.innovation_variance.sqrt();
            let (jump, recover_s) = match output {
                0 => (0.0, settings.speed_recover_s),
                wheel => (self.wheel_jump_rad_s2[wheel - 1] * dt_s.min(0.05), settings.wheel_recover_s),
            };
            let gate = settings.gate_sigma * sigma + jump;
            let test_ratio = (update.innovation / gate).powi(2);
            let watch = &mut self.memory.watches[output];
            let rolling = if output == 0 { 1.0 } else { 1.0 / self.wheel_radius_m[output - 1] };
            watch.note(measured, self.last.v_m_s * rolling, dt_s);
            let record = &mut out.innovations;
            record.innovation[output] = update.innovation;
            record.innovation_variance[output] = update.innovation_variance;
            record.test_ratio[output] = test_ratio;
            match watch.judge(update.innovation, sigma, test_ratio, dt_s, recover_s, settings) {
                Verdict::Use => {
                    self.filter.accept(output, &update);
                    record.fused |= 1 << output;
                }
                Verdict::Refuse => record.rejected |= 1 << output,
                Verdict::Believe => {
                    self.filter.believe(output, measured);
                    record.fused |= 1 << output;
                }
            }
        }
    }

    fn mark(&mut self, out: &mut EstimatorOutput, dt_s: f64) {
        self.memory.running_s += dt_s;
        if out.innovations.fused == 0 {
            out.flags |= flags::PREDICTED;
        }
        if self.memory.running_s < CONVERGING_S {
            out.flags |= flags::CONVERGING;
        }
        if std::mem::take(&mut self.memory.resumed) {
            out.flags |= flags::RESUMED;
        }
        let wheelsets = (1_u32 << self.wheelsets) - 1;
        if out.observable & wheelsets != wheelsets {
            out.flags |= flags::HELD;
        }
    }

    /// Everything that a restart needs to go on from here.
    pub fn snapshot(&self) -> EstimatorSnapshot {
        EstimatorSnapshot {
            schema: crate::snapshot::SCHEMA,
            filter: self.config.filter.clone(),
            vehicle: self.vehicle.clone(),
            state: self.filter.save(),
            hidden: self.laws.hidden.clone(),
            v_m_s: self.last.v_m_s,
            memory: self.memory.clone(),
        }
    }

    /// Goes on from a snapshot. After an error the estimator is as before.
    ///
    /// # Errors
    /// A snapshot of another filter, vehicle or shape, or one that is not sound.
    pub fn restore(&mut self, snapshot: &EstimatorSnapshot) -> Result<(), FilterError> {
        if snapshot.schema != crate::snapshot::SCHEMA || snapshot.vehicle != self.vehicle {
            return Err(FilterError::SnapshotVehicle);
        }
        if snapshot.filter != self.config.filter {
            return Err(FilterError::SnapshotFilter {
                expected: self.config.filter.clone(),
                found: snapshot.filter.clone(),
            });
        }
        if !self.laws.restore(&snapshot.hidden) {
            return Err(FilterError::SnapshotVehicle);
        }
        self.filter.load(&snapshot.state)?;
        self.memory = snapshot.memory.clone();
        self.memory.resumed = self.memory.started;
        self.last.v_m_s = snapshot.v_m_s;
        Ok(())
    }
}
