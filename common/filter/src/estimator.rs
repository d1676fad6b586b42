//! The one stepping type: a sample in, an estimate out, with no clock, channel or file. The live estimator and the
//! offline command both use it, so that a replay equals an offline run sample for sample.

mod traced;

use crate::hygiene::{TimeStep, Verdict, without_nonsense};
use crate::laws::{Laws, Place};
use crate::memory::Memory;
use crate::models::{Build, DrivenSample, WagonFilter};
use crate::output::{InnovationRecord, flags};
use crate::{EstimateState, EstimatorConfig, EstimatorOutput, EstimatorSnapshot, FilterError, WagonSample};
use railgrip_vehicle::{MAX_WHEELSETS, VehicleParameters, WagonModel};

/// Longest step of a prediction, s; gaps are cut into such steps.
const LONGEST_STEP_S: f64 = 0.05;
/// Time after a start in which estimates are marked as converging, s.
const CONVERGING_S: f64 = 1.0;

/// So long after it was started anew because it contradicted its sensors, an estimate is called diverged, s.
const DIVERGED_S: f64 = 0.5;
/// Measurements believed after all within [`QUARREL_S`] that mean that the filter has lost its way.
const QUARRELS: f64 = 3.0;
/// Time over which such measurements count, s.
const QUARREL_S: f64 = 1.0;

/// Estimator of one wagon.
#[derive(Clone)]
pub struct WagonEstimator {
    config: EstimatorConfig,
    filter: BoxedFilter,
    laws: Laws,
    vehicle: String,
    wheelsets: usize,
    usual_step_s: f64,
    /// Change of wheelset speed that a believable jump of adhesion makes, rad/s².
    wheel_jump_rad_s2: [f64; MAX_WHEELSETS],
    wheel_radius_m: [f64; MAX_WHEELSETS],
    memory: Memory,
    /// A measurement of the last sample was believed against the filter.
    believed: bool,
    last: EstimatorOutput,
}

/// A filter of any kind, with a copy that goes on by itself.
struct BoxedFilter(Box<dyn WagonFilter>);

impl Clone for BoxedFilter {
    fn clone(&self) -> Self {
        Self(self.0.boxed_clone())
    }
}

impl WagonEstimator {
    /// The estimator of `vehicle`.
    ///
    /// # Errors
    /// Settings or parameters out of range, an unknown filter or effect, or a filter that does not handle the vehicle.
    pub fn new(config: &EstimatorConfig, vehicle: &VehicleParameters) -> Result<Self, FilterError> {
        vehicle.check()?;
        Self::with_model(config, vehicle, WagonModel::new(vehicle)?)
    }

    /// The estimator of what has this model; `vehicle` gives its sensors and names it.
    ///
    /// # Errors
    /// Settings out of range, an unknown filter, or one that does not handle the model.
    pub fn with_model(
        config: &EstimatorConfig,
        vehicle: &VehicleParameters,
        model: WagonModel,
    ) -> Result<Self, FilterError> {
        config.out_of_range().into_iter().next().map_or(Ok(()), Err)?;
        let constants = model.constants();
        let load_n = model.load_distribution().static_load_n[0];
        let entry = crate::models::find(&config.filter).ok_or_else(|| crate::ConfigError::UnknownFilter {
            name: config.filter.clone(),
            known: crate::models::names(),
        })?;
        let Build::Wagon(build) = entry.build else {
            return Err(FilterError::Plant {
                filter: entry.name,
                plant: crate::PlantKind::Wagon.name(),
                known: "\"default\", \"paper\", \"rig\", \"imm\"".into(),
            });
        };
        Ok(Self {
            config: config.clone(),
            filter: BoxedFilter(build(config, vehicle, &model)?),
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
            believed: false,
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
    pub fn step(&mut self, input: &WagonSample) -> EstimatorOutput {
        self.step_watched(input, &mut |_, _| {})
    }

    /// A step that shows every prediction to `watch`: the filter after it, and the sample.
    fn step_watched(
        &mut self,
        input: &WagonSample,
        watch: &mut dyn FnMut(&dyn WagonFilter, &DrivenSample),
    ) -> EstimatorOutput {
        let input = without_nonsense(input);
        let previous = self.memory.clone();
        let step = self.memory.time.judge(input.time_s, self.usual_step_s, &self.config.hygiene);
        if step == TimeStep::Ignored || !self.can_start(&input) {
            self.memory.time = if step == TimeStep::Ignored { self.memory.time } else { previous.time };
            return self.ignored();
        }
        let dt_s = match step {
            TimeStep::Regular(dt) | TimeStep::Gap(dt) | TimeStep::LongGap(dt) => dt,
            TimeStep::First | TimeStep::ClockSet | TimeStep::Ignored => self.usual_step_s,
        };
        let mut out =
            EstimatorOutput { time_s: input.time_s, wsp_active: input.wsp_active, ..Default::default() };
        let (mut sample, place) = self.drive(&input, dt_s, &mut out);
        self.laws.apply(&mut sample, &place, &self.last);
        self.advance(step, &sample, dt_s, &mut out, watch);
        self.measure(&sample, dt_s, &mut out);
        self.filter.0.conclude(&sample, dt_s);
        self.restart_if_diverged(&sample, dt_s, &mut out);
        self.filter.0.read(&sample, &mut out);
        out.pressing_force_n = sample.pressing_force_n;
        (out.nis, out.nis_dof) = out.innovations.nis();
        out.rejected = out.innovations.rejected;
        self.mark(&mut out, dt_s);
        self.laws.advance(&sample, &out, dt_s);
        self.last = out;
        out
    }

    /// What is said of a sample that is no new instant, or not of a wagon: the last estimate once more.
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

    /// A filter whose belief contradicts physics, or that had to give way to its sensors again and again, starts anew
    /// from its priors; for a while its estimates are called diverged.
    fn restart_if_diverged(&mut self, sample: &DrivenSample, dt_s: f64, out: &mut EstimatorOutput) {
        self.memory.diverged_s = (self.memory.diverged_s - dt_s).max(0.0);
        self.memory.quarrels *= (1.0 - dt_s / QUARREL_S).max(0.0);
        if self.memory.quarrels > QUARRELS || self.filter.0.has_diverged() {
            self.filter.0.start(sample);
            self.memory.watches = Default::default();
            self.memory.quarrels = 0.0;
            self.memory.diverged_s = DIVERGED_S;
            out.flags |= flags::RESTARTED;
        }
    }

    /// A filter needs one speed to begin with.
    fn can_start(&self, input: &WagonSample) -> bool {
        let any_wheel = input.wheel_speed_rad_s[..self.wheelsets].iter().any(|speed| speed.is_finite());
        self.memory.started || input.v_m_s.is_finite() || any_wheel
    }

    /// Inputs of the prediction, held where they are missing.
    fn drive(&mut self, input: &WagonSample, dt_s: f64, out: &mut EstimatorOutput) -> (DrivenSample, Place) {
        let hold_s = self.config.hygiene.hold_s;
        let mut sample = DrivenSample {
            v_m_s: input.v_m_s,
            wheel_speed_rad_s: input.wheel_speed_rad_s,
            load_kg: input.load_kg,
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
    fn advance(
        &mut self,
        step: TimeStep,
        sample: &DrivenSample,
        dt_s: f64,
        out: &mut EstimatorOutput,
        watch: &mut dyn FnMut(&dyn WagonFilter, &DrivenSample),
    ) {
        if !self.memory.started {
            self.filter.0.start(sample);
            self.memory.started = true;
            self.memory.running_s = 0.0;
            out.flags |= flags::RESTARTED;
            return;
        }
        match step {
            TimeStep::LongGap(gap_s) => {
                self.filter.0.restart_motion(sample, gap_s);
                self.memory.watches = Default::default();
                out.flags |= flags::GAP;
            }
            TimeStep::ClockSet => {
                self.filter.0.restart_motion(sample, 0.0);
                self.memory.watches = Default::default();
                out.flags |= flags::GAP;
            }
            _ => {
                if matches!(step, TimeStep::Gap(_)) {
                    out.flags |= flags::GAP;
                }
                let parts = (dt_s / LONGEST_STEP_S).ceil().max(1.0);
                for _ in 0..parts as usize {
                    self.filter.0.predict(sample, dt_s / parts);
                    watch(&*self.filter.0, sample);
                }
            }
        }
    }

    /// Compares every measured value with what the filter expects, and uses it or not.
    fn measure(&mut self, sample: &DrivenSample, dt_s: f64, out: &mut EstimatorOutput) {
        let settings = &self.config.hygiene;
        self.believed = false;
        for output in 0..=self.wheelsets {
            let measured = sample.measured(output);
            if !measured.is_finite() {
                continue;
            }
            let update = self.filter.0.expect(output, measured);
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
                    self.filter.0.accept(output, &update);
                    record.fused |= 1 << output;
                }
                Verdict::Refuse => record.rejected |= 1 << output,
                Verdict::Believe => {
                    self.filter.0.believe(output, measured);
                    self.believed = true;
                    if output > 0 {
                        self.memory.quarrels += 1.0;
                    }
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
        let seen = out.observable & wheelsets;
        if seen != wheelsets {
            out.flags |= flags::HELD;
        }
        out.state = if self.memory.diverged_s > 0.0 {
            EstimateState::Diverged
        } else if out.flags & flags::PREDICTED != 0 {
            EstimateState::NoMeasurement
        } else if out.flags & flags::CONVERGING != 0 {
            EstimateState::Starting
        } else if seen == wheelsets {
            EstimateState::Observable
        } else if seen != 0 {
            EstimateState::Weak
        } else {
            EstimateState::Unobservable
        };
    }

    /// Everything that a restart needs to go on from here.
    pub fn snapshot(&self) -> EstimatorSnapshot {
        EstimatorSnapshot {
            schema: crate::snapshot::SCHEMA,
            filter: self.config.filter.clone(),
            vehicle: self.vehicle.clone(),
            state: self.filter.0.save(),
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
        self.filter.0.load(&snapshot.state)?;
        self.memory = snapshot.memory.clone();
        self.memory.resumed = self.memory.started;
        self.last.v_m_s = snapshot.v_m_s;
        Ok(())
    }
}
