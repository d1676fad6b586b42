//! The default filter: an extended Kalman filter of a wagon with one adhesion and one pad friction a wheelset, which
//! does not claim what speeds cannot show.
//!
//! It mends what one common adhesion (Schwarz & Keck (2)) hides: while wheelsets roll, each contact force follows its
//! own brake, and speeds show only the sum of the brake torques. The split between wheelsets then enters through what
//! can be known: the difference of their creepages, as far as the creep law and the wheel radii (learnt while
//! coasting) are known; and in sliding, where each wheelset has a torque balance of its own. Everything constant but
//! unknown (radii, mass) is a state, so that the reported sigmas contain it.
//!
//! Files: `propagate` (equations of a step), `layout` (where a component stands), `schedule` (rolling or sliding), `noise`
//! (process noise), `tie` (creepage difference), `readout`.

mod layout;
mod load;
mod mean_slip;
mod noise;
mod pads;
mod propagate;
mod readout;
mod schedule;
mod tie;

pub use propagate::StepInput;

use super::physics::{IMPOSSIBLE_ADHESION, POSSIBLE_PAD_RATIO, WagonPhysics};
use super::{DrivenSample, FilterState, WagonFilter, dynamic, pack, unpack};
use crate::core::{Gaussian, ScalarUpdate};
use crate::{EstimatorConfig, EstimatorOutput, FilterError, SensorSigmas};
use layout::Layout;
use load::LoadSensor;
use mean_slip::MeanSlip;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use railgrip_vehicle::brake::pad_torque_nm;
use railgrip_vehicle::{VehicleParameters, WagonModel};
use schedule::{ChangeWatch, Contact};

/// Slip velocity below which the slope of adhesion over slip in sliding counts as if slip were this, m/s.
const LEAST_SLIDE_M_S: f64 = 0.2;

/// The default filter for `W` wheelsets and `N = 6 + 4 W` states.
#[derive(Clone, Debug)]
pub struct WagonEkf<const W: usize, const N: usize> {
    physics: WagonPhysics<W>,
    sensors: SensorSigmas,
    config: EstimatorConfig,
    /// Belief about the state.
    pub belief: Gaussian<N>,
    contacts: [Contact; W],
    watches: [ChangeWatch; W],
    mean_slips: [MeanSlip; W],
    /// Adhesion available on dry rail, after the vehicle file.
    dry_adhesion: f64,
    /// Brake torque per pad friction of each wheelset in the last step, N m.
    brake_torque_nm: [f64; W],
    step_s: f64,
    /// What came of the pressing force of late: its changes, each fading within the lag, N.
    late_force_n: [f64; W],
    since_tie_s: f64,
    tied: u32,
    untied_s: f64,
    /// Known torque drives the wagon: only then does its acceleration say something about its mass. In sliding the
    /// equations would claim to weigh the wagon by the inertia of its wheels, which is known less well than the mass.
    learns_mass: bool,
    /// Neighbours pull and push it: its acceleration says nothing about its own pads, nor about its mass.
    coupled: bool,
    /// One sigma of its mass at the start, relative.
    mass_sigma: f64,
    load_sensor: LoadSensor,
    /// Size of one unit of disturbance in the last step, m/s².
    disturbance_m_s2: f64,
    /// Derivative of the last prediction.
    sensitivity: SMatrix<f64, N, N>,
}

/// Builds the default filter for the wheelsets of `model`.
pub(super) fn boxed(
    config: &EstimatorConfig,
    vehicle: &VehicleParameters,
    model: &WagonModel,
) -> Result<Box<dyn WagonFilter>, FilterError> {
    match model.constants().wheelsets {
        1 => Ok(Box::new(WagonEkf::<1, 10>::new(config, vehicle, model))),
        2 => Ok(Box::new(WagonEkf::<2, 14>::new(config, vehicle, model))),
        3 => Ok(Box::new(WagonEkf::<3, 18>::new(config, vehicle, model))),
        4 => Ok(Box::new(WagonEkf::<4, 22>::new(config, vehicle, model))),
        wheelsets => Err(FilterError::Wheelsets { filter: "default", wheelsets }),
    }
}

impl<const W: usize, const N: usize> WagonEkf<W, N> {
    /// The filter of a vehicle; `model` must have `W` wheelsets.
    pub fn new(config: &EstimatorConfig, vehicle: &VehicleParameters, model: &WagonModel) -> Self {
        let physics = WagonPhysics::new(model);
        let mass_sigma = vehicle.body.mass_sigma.unwrap_or(config.priors.mass);
        let belief = Self::prior(&physics, config, mass_sigma);
        Self {
            physics,
            sensors: SensorSigmas::new(config, vehicle),
            config: config.clone(),
            belief,
            contacts: [Contact { rolling: 1.0, secant: 1.0, slip_m_s: 0.0, excess_m_s: 0.0 }; W],
            watches: [ChangeWatch::default(); W],
            mean_slips: [MeanSlip::default(); W],
            dry_adhesion: vehicle.rail.dry,
            brake_torque_nm: [0.0; W],
            step_s: 0.0,
            late_force_n: [0.0; W],
            since_tie_s: 0.0,
            tied: 0,
            untied_s: 0.0,
            learns_mass: false,
            coupled: vehicle.is_coupled(),
            mass_sigma,
            load_sensor: LoadSensor::default(),
            disturbance_m_s2: 0.0,
            sensitivity: SMatrix::identity(),
        }
    }

    fn prior(physics: &WagonPhysics<W>, config: &EstimatorConfig, mass_sigma: f64) -> Gaussian<N> {
        let at = Layout::<W, N>::INDICES;
        let priors = &config.priors;
        let (mut mean, mut sigma) = (SVector::<f64, N>::zeros(), SVector::<f64, N>::repeat(1.0));
        sigma[at.lag] = 1e-3;
        sigma[at.mass] = mass_sigma;
        sigma[at.slope] = priors.sliding_slope;
        sigma[at.delay] = priors.brake_delay_s / config.rates.brake_lag_s;
        for i in 0..W {
            mean[at.pad + i] = physics.brake_friction[i];
            sigma[at.adhesion + i] = priors.adhesion;
            sigma[at.radius + i] = priors.wheel_radius;
        }
        let mut belief = Gaussian::independent(mean, &sigma);
        let (common, split) = pads::pad_prior_variances::<W>(priors, physics.brake_friction[0]);
        for i in 0..W {
            for j in 0..W {
                belief.covariance[(at.pad + i, at.pad + j)] = pads::pad_entry::<W>(common, split, i == j);
            }
        }
        belief
    }

    /// Puts the motion to what the sample says, and adhesions to unknown.
    fn set_motion(&mut self, sample: &DrivenSample) {
        let at = Layout::<W, N>::INDICES;
        let v_m_s = sample.speed_or_rim_m_s(&self.physics.wheel_radius_m);
        let v_sigma = if sample.v_m_s.is_finite() { self.sensors.speed_m_s } else { 1.0 };
        self.belief.reset_component(0, v_m_s, v_sigma);
        for i in 0..W {
            let measured = sample.wheel_speed_rad_s[i];
            let rolling = v_m_s / self.physics.wheel_radius_m[i];
            let (speed, sigma) = if measured.is_finite() {
                (measured, self.sensors.wheel_speed_rad_s)
            } else {
                (rolling, 3.0)
            };
            self.belief.reset_component(at.wheel + i, speed, sigma);
            let braking = sample.pressing_force_n[i] > self.force_floor_n(i);
            let sigma = if braking { 0.1 } else { self.config.priors.adhesion };
            self.belief.reset_component(at.adhesion + i, 0.0, sigma);
        }
        self.belief.reset_component(at.lag, 0.0, 1e-3);
        self.belief.reset_component(at.disturbance, self.belief.mean[at.disturbance], 1.0);
        self.watches = [ChangeWatch::default(); W];
        self.mean_slips = [MeanSlip::default(); W];
        self.late_force_n = [0.0; W];
        self.since_tie_s = 0.0;
    }

    /// Pressing force below which a sample says nothing about the pads of wheelset `i`, N.
    fn force_floor_n(&self, i: usize) -> f64 {
        self.physics.pressing_force_for_adhesion_n(i, self.config.priors.braking_adhesion)
    }

    /// Inputs of one step from a sample.
    fn step_input(&self, sample: &DrivenSample, dt_s: f64) -> StepInput<W> {
        let rates = &self.config.rates;
        let standing = self.is_standing();
        StepInput {
            dt_s,
            torque_per_friction_nm: std::array::from_fn(|i| {
                let force = if standing { 0.0 } else { sample.step_force_n[i] };
                pad_torque_nm(sample.torque_factor[i], force, self.physics.brake_radius_m)
            }),
            late_torque_nm: std::array::from_fn(|i| {
                pad_torque_nm(sample.torque_factor[i], self.late_force_n[i], self.physics.brake_radius_m)
            }),
            drive_torque_nm: std::array::from_fn(|i| if standing { 0.0 } else { sample.drive_torque_nm[i] }),
            other_force_n: if standing { 0.0 } else { sample.other_acceleration_m_s2 * self.physics.mass_kg },
            wind_m_s: if standing { 0.0 } else { sample.wind_m_s },
            disturbance_m_s2: self.disturbance_m_s2(sample),
            lag_kept: (-dt_s / rates.brake_lag_s).exp(),
            disturbance_kept: (-dt_s / if self.coupled { rates.coupler_s } else { rates.disturbance_s })
                .exp(),
            relaxation_per_s: std::array::from_fn(|i| {
                let known = if sample.knows_force(i) { 1.0 } else { 0.0 };
                let rolling = self.contacts[i].rolling * (1.0 - self.watches[i].certainty(dt_s));
                self.physics.rolling_relaxation_per_s(i, self.belief.mean[0]) * rolling * known
            }),
            relaxation_per_slope: std::array::from_fn(|i| self.relaxation_per_slope(i, dt_s)),
        }
    }

    /// Rate at which adhesion follows its target per slope of adhesion over slip, in sliding, 1/s: with
    /// d μ/d u = slope · μ/u, and u̇ = −(r² F_z/J)(μ − μ*).
    fn relaxation_per_slope(&self, i: usize, dt_s: f64) -> f64 {
        let (physics, contact) = (&self.physics, &self.contacts[i]);
        let radius = physics.wheel_radius_m[i];
        let adhesion = self.belief.mean[Layout::<W, N>::INDICES.adhesion + i].abs();
        let per_slip = radius * radius * physics.loads.static_load_n[i] / physics.inertia_kg_m2[i];
        let rate = per_slip * adhesion / contact.slip_m_s.abs().max(LEAST_SLIDE_M_S);
        ((1.0 - contact.rolling) * rate).min(0.5 / dt_s.max(1e-3))
    }

    /// Takes a reading of the load sensor, kg, which counts once a load.
    fn weigh(&mut self, load_kg: f64, dt_s: f64) {
        let sigma = self.config.priors.load_sensor;
        if let Some(mean) = self.load_sensor.take(load_kg / self.physics.mass_kg, sigma, dt_s) {
            let mass = Layout::<W, N>::INDICES.mass;
            self.belief.reset_component(mass, 0.0, self.mass_sigma);
            let update = self.belief.expect_component(mass, mean - 1.0, sigma * sigma);
            self.belief.update_component(mass, &update, sigma * sigma);
        }
    }

    /// Too slow for the balance of forces to mean anything: brakes hold the wagon.
    fn is_standing(&self) -> bool {
        self.belief.mean[0].abs() < 0.3
    }

    /// Wheelsets cannot turn backwards under their brake: a predicted reversal is a locked wheelset.
    fn hold_locked(&self, next: &mut SVector<f64, N>, f: &mut SMatrix<f64, N, N>) {
        let at = Layout::<W, N>::INDICES;
        for i in 0..W {
            if next[at.wheel + i] < 0.0 && self.belief.mean[0] > 0.3 {
                next[at.wheel + i] = 0.0;
                f.row_mut(at.wheel + i).fill(0.0);
                f[(at.wheel + i, at.wheel + i)] = 0.1;
            }
        }
    }
}

impl<const W: usize, const N: usize> WagonFilter for WagonEkf<W, N> {
    fn start(&mut self, sample: &DrivenSample) {
        self.belief = Self::prior(&self.physics, &self.config, self.mass_sigma);
        self.load_sensor = LoadSensor::default();
        self.set_motion(sample);
    }

    fn restart_motion(&mut self, sample: &DrivenSample, gap_s: f64) {
        self.set_motion(sample);
        self.age_pads(&[true; W], gap_s);
    }

    fn predict(&mut self, sample: &DrivenSample, dt_s: f64) {
        let at = Layout::<W, N>::INDICES;
        let kept = (-dt_s / self.config.rates.brake_lag_s).exp();
        for i in 0..W {
            self.late_force_n[i] = self.late_force_n[i] * kept + sample.force_change_n[i];
        }
        let pushed: f64 = sample.drive_torque_nm[..W].iter().sum::<f64>().abs();
        self.learns_mass = !self.coupled
            && pushed > 0.01 * self.physics.loads.weight_n() * self.physics.wheel_radius_m[0]
            && self.contacts.iter().all(|contact| contact.rolling > 0.3);
        let input = self.step_input(sample, dt_s);
        let (mut next, mut f) = self.physics.propagate(&self.belief.mean, &input);
        self.hold_locked(&mut next, &mut f);
        let q = self.process_noise(sample, &input, &next);
        self.brake_torque_nm = input.torque_per_friction_nm;
        self.step_s = dt_s;
        self.disturbance_m_s2 = input.disturbance_m_s2;
        self.sensitivity = f;
        self.belief.predict_leading(next, &f, at.moving, &q);
        let held: [bool; W] =
            std::array::from_fn(|i| self.is_standing() || sample.pressing_force_n[i] < self.force_floor_n(i));
        self.age_pads(&held, dt_s);
    }

    fn expect(&self, output: usize, measured: f64) -> ScalarUpdate {
        self.belief.expect_component(output, measured, self.sensors.variance(output))
    }

    fn accept(&mut self, output: usize, update: &ScalarUpdate) {
        let at = Layout::<W, N>::INDICES;
        let r = self.sensors.variance(output);
        let mass = std::iter::once(at.mass);
        if self.coupled && !(output > 0 && self.contacts[output - 1].slides()) {
            // Couplers move the wagon, and how much a rolling wheel creeps is the rail's matter as much as the brake's: neither
            // says how large a force is. What wheelsets creep beside each other does (`tie`).
            let pads = at.pad..at.pad + W;
            self.belief.update_component_considering(output, update, r, pads.chain(mass));
        } else if self.learns_mass {
            self.belief.update_component(output, update, r);
        } else {
            self.belief.update_component_considering(output, update, r, mass);
        }
        if output > 0 {
            let normalised = update.innovation / update.innovation_variance.sqrt();
            self.watches[output - 1].note(normalised, self.step_s);
        }
    }

    fn believe(&mut self, output: usize, measured: f64) {
        let at = Layout::<W, N>::INDICES;
        let sigma = self.sensors.variance(output).sqrt();
        self.belief.reset_component(output, measured, 3.0 * sigma);
        if output > 0 {
            let adhesion = at.adhesion + output - 1;
            self.belief.covariance[(adhesion, adhesion)] += 0.05 * 0.05;
        }
    }

    fn conclude(&mut self, sample: &DrivenSample, dt_s: f64) {
        let delay = Layout::<W, N>::INDICES.delay;
        if self.belief.mean[delay] < 0.0 {
            self.belief.constrain_component(delay, 0.0);
        }
        for i in 0..W {
            self.contacts[i] = schedule::judge(&self.physics, &self.belief, i);
            let force =
                self.belief.mean[Layout::<W, N>::INDICES.adhesion + i] * self.physics.loads.static_load_n[i];
            let creep = self.physics.rolling_slip_m_s(force, self.belief.mean[0]);
            self.mean_slips[i].note(self.contacts[i].slip_m_s, creep, dt_s);
        }
        self.tie_when_due(sample, dt_s);
        self.weigh(sample.load_kg, dt_s);
    }

    fn read(&self, sample: &DrivenSample, out: &mut EstimatorOutput) {
        self.read_out(sample, out);
    }

    fn save(&self) -> FilterState {
        let mut memory: Vec<f64> = self.watches.iter().map(|watch| watch.mean).collect();
        memory.extend(self.contacts.iter().flat_map(|c| [c.rolling, c.secant, c.slip_m_s, c.excess_m_s]));
        memory.extend(self.late_force_n);
        memory.extend(self.mean_slips.iter().flat_map(|mean| [mean.slip_m_s, mean.creep_m_s]));
        memory.extend([self.since_tie_s, f64::from(self.tied), self.untied_s]);
        memory.extend(self.load_sensor.save());
        pack(&self.belief, memory)
    }

    fn load(&mut self, state: &FilterState) -> Result<(), FilterError> {
        self.belief = unpack(state, 8 * W + 3 + LoadSensor::SAVED)?;
        for i in 0..W {
            self.watches[i].mean = state.memory[i];
            let c = &state.memory[W + 4 * i..];
            let mean = &state.memory[6 * W + 2 * i..];
            self.mean_slips[i] = MeanSlip { slip_m_s: mean[0], creep_m_s: mean[1] };
            self.late_force_n[i] = state.memory[5 * W + i];
            self.contacts[i] = Contact { rolling: c[0], secant: c[1], slip_m_s: c[2], excess_m_s: c[3] };
        }
        self.since_tie_s = state.memory[8 * W];
        self.tied = state.memory[8 * W + 1] as u32;
        self.untied_s = state.memory[8 * W + 2];
        self.load_sensor = LoadSensor::load(&state.memory[8 * W + 3..]);
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn WagonFilter> {
        Box::new(self.clone())
    }

    fn belief(&self) -> Option<(DVector<f64>, DMatrix<f64>)> {
        Some(dynamic(&self.belief))
    }

    fn transition(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(N, N, self.sensitivity.as_slice())
    }

    /// Its bounds are wide: pads and adhesion of this filter are tied to what they can be.
    fn has_diverged(&self) -> bool {
        let at = Layout::<W, N>::INDICES;
        let x = &self.belief.mean;
        let pads =
            (0..W).any(|i| !POSSIBLE_PAD_RATIO.contains(&(x[at.pad + i] / self.physics.brake_friction[i])));
        pads || (0..W).any(|i| x[at.adhesion + i].abs() > IMPOSSIBLE_ADHESION)
            || !x.iter().all(|value| value.is_finite())
    }
}
