//! The published filter: Schwarz & Keck, "Simultaneous Estimation of Wheel-Rail Adhesion and Brake Friction
//! Behaviour" (2020), equations (12) to (15), with one adhesion μ_W for all wheelsets.
//!
//! State (13): `[ω_1 … ω_W, v, μ_B,1 … μ_B,W, μ_W]`; with one wheelset this is the state (19) of the roller rig.
//!
//! ```text
//! v̇   = μ_W g + F_TR/m                          F_TR: resistance, drag, grade, all signed forward
//! ω̇_i = (M_i − μ_B,i F_⊥,i r_B − r_W μ_W F_z,i)/J ,   F_z,i = m g/W ± (h/a) m v̇
//! ```
//!
//! Mended against the paper: g where it has g/2; the sign of the load transfer; and the load keeps the term
//! 2 (h/a) μ_W that (12) drops (`drop_adhesion_load` brings the paper's form back, to measure what that costs).
//! Its weakness stays: one μ_W splits the brake forces by axle load, with a certainty that nothing measured supports.

use super::physics::{IMPOSSIBLE_ADHESION, POSSIBLE_PAD_RATIO, WagonPhysics};
use super::{DrivenSample, FilterState, WagonFilter, dynamic, pack, unpack};
use crate::core::{Gaussian, ScalarUpdate};
use crate::observability::scaled_rank;
use crate::{EstimatorConfig, EstimatorOutput, FilterError, NoisePreset, SensorSigmas};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use railgrip_vehicle::brake::pad_torque_nm;
use railgrip_vehicle::motion::{body_acceleration_m_s2, wheelset_acceleration_rad_s2};
use railgrip_vehicle::resistance::{running_resistance, running_resistance_slope};
use railgrip_vehicle::{VehicleParameters, WagonModel, creepage};

/// Equations (12) for `W` wheelsets and `N = 2 + 2 W` states.
#[derive(Clone, Debug)]
pub struct PaperModel<const W: usize, const N: usize> {
    /// Constants.
    pub physics: WagonPhysics<W>,
    /// Drops 2 (h/a) μ_W against 1 in the load, as (12) does.
    pub drop_adhesion_load: bool,
}

/// What acts during one step: u and u_lin of (14).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperInput<const W: usize> {
    /// Length, s.
    pub dt_s: f64,
    /// F_⊥ r_B, N m.
    pub torque_per_friction_nm: [f64; W],
    /// M_W, N m.
    pub drive_torque_nm: [f64; W],
    /// Grade, couplers and effects, N, forward positive.
    pub other_force_n: f64,
    /// Headwind, m/s.
    pub wind_m_s: f64,
}

impl<const W: usize, const N: usize> PaperModel<W, N> {
    /// Index of the speed.
    pub const V: usize = {
        assert!(N == 2 + 2 * W, "the paper's filter has 2 + 2 W states");
        W
    };
    /// Index of the first pad friction.
    pub const PAD: usize = W + 1;
    /// Index of the adhesion.
    pub const ADHESION: usize = 2 * W + 1;

    /// State after a step (Euler) and its derivative with respect to the state before.
    #[inline]
    pub fn propagate(
        &self,
        x: &SVector<f64, N>,
        input: &PaperInput<W>,
    ) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
        let (physics, dt) = (&self.physics, input.dt_s);
        let (v, adhesion, mass) = (x[Self::V], x[Self::ADHESION], physics.mass_kg);
        let weight = physics.loads.weight_n();
        let resistance = running_resistance(&physics.resistance, v, input.wind_m_s);
        let per_speed = -running_resistance_slope(&physics.resistance, v, input.wind_m_s) / mass;
        let acceleration = body_acceleration_m_s2(mass, adhesion * weight, resistance, input.other_force_n);
        let (load_acceleration, per_adhesion) = if self.drop_adhesion_load {
            (body_acceleration_m_s2(mass, 0.0, resistance, input.other_force_n), 0.0)
        } else {
            (acceleration, weight / mass)
        };
        let mut next = *x;
        let mut f = SMatrix::<f64, N, N>::identity();
        next[Self::V] += dt * acceleration;
        f[(Self::V, Self::V)] += dt * per_speed;
        f[(Self::V, Self::ADHESION)] = dt * weight / mass;
        for i in 0..W {
            let (inertia, radius) = (physics.inertia_kg_m2[i], physics.wheel_radius_m[i]);
            let (load, transfer) = (physics.loads.load_n(i, load_acceleration), physics.loads.transfer_kg[i]);
            let per_friction = input.torque_per_friction_nm[i];
            let (drive, brake) = (input.drive_torque_nm[i], x[Self::PAD + i] * per_friction);
            next[i] += dt * wheelset_acceleration_rad_s2(inertia, radius, drive, brake, adhesion * load);
            let gain = dt / inertia;
            f[(i, Self::PAD + i)] = -gain * per_friction;
            f[(i, Self::ADHESION)] = -gain * radius * (load + adhesion * transfer * per_adhesion);
            f[(i, Self::V)] = -gain * radius * adhesion * transfer * per_speed;
        }
        (next, f)
    }
}

/// The filter (12)–(15): its belief, its noise, and what happens while the pads are off.
#[derive(Clone, Debug)]
pub struct PaperFilter<const W: usize, const N: usize> {
    /// Equations.
    pub model: PaperModel<W, N>,
    /// Belief about the state.
    pub belief: Gaussian<N>,
    config: EstimatorConfig,
    sensors: SensorSigmas,
    /// Q per second, diagonal.
    pub(super) q_per_s: SVector<f64, N>,
    /// R of speed and of wheelset speed.
    r: (f64, f64),
    sensitivity: SMatrix<f64, N, N>,
    step_s: f64,
}

/// Builds the paper's filter for the wheelsets of `model`.
pub(super) fn boxed(
    config: &EstimatorConfig,
    vehicle: &VehicleParameters,
    model: &WagonModel,
) -> Result<Box<dyn WagonFilter>, FilterError> {
    match model.constants().wheelsets {
        1 => Ok(Box::new(PaperFilter::<1, 4>::new(config, vehicle, WagonPhysics::new(model)))),
        2 => Ok(Box::new(PaperFilter::<2, 6>::new(config, vehicle, WagonPhysics::new(model)))),
        3 => Ok(Box::new(PaperFilter::<3, 8>::new(config, vehicle, WagonPhysics::new(model)))),
        4 => Ok(Box::new(PaperFilter::<4, 10>::new(config, vehicle, WagonPhysics::new(model)))),
        wheelsets => Err(FilterError::Wheelsets { filter: "paper", wheelsets }),
    }
}

impl<const W: usize, const N: usize> PaperFilter<W, N> {
    /// The filter with these constants.
    pub fn new(config: &EstimatorConfig, vehicle: &VehicleParameters, physics: WagonPhysics<W>) -> Self {
        let sensors = SensorSigmas::new(config, vehicle);
        let model = PaperModel { physics, drop_adhesion_load: false };
        let mut q_per_s = SVector::<f64, N>::zeros();
        let rates = &config.rates;
        let (wheel, speed, pad, adhesion, r) = match config.noise {
            NoisePreset::SchwarzKeck2020 => (1e1, 1e-5, 1e-3, 1e-1, (1e-7, 1e-9)),
            NoisePreset::Physical => (
                (rates.rim_speed_plain_per_sqrt_s / model.physics.wheel_radius_m[0]).powi(2),
                rates.speed_per_sqrt_s.powi(2),
                (rates.pad_common_per_sqrt_s * model.physics.brake_friction[0]).powi(2),
                rates.adhesion_plain_per_sqrt_s.powi(2),
                (sensors.speed_m_s.powi(2), sensors.wheel_speed_rad_s.powi(2)),
            ),
        };
        for i in 0..W {
            q_per_s[i] = wheel;
            q_per_s[PaperModel::<W, N>::PAD + i] = pad;
        }
        q_per_s[PaperModel::<W, N>::V] = speed;
        q_per_s[PaperModel::<W, N>::ADHESION] = adhesion;
        let belief = Gaussian { mean: SVector::zeros(), covariance: SMatrix::identity() };
        Self {
            model,
            belief,
            config: config.clone(),
            sensors,
            q_per_s,
            r,
            sensitivity: SMatrix::identity(),
            step_s: 0.0,
        }
    }

    /// Input of one step from a sample.
    pub fn step_input(&self, sample: &DrivenSample, dt_s: f64) -> PaperInput<W> {
        let standing = self.belief.mean[PaperModel::<W, N>::V].abs() < 0.3;
        let share = if standing { 0.0 } else { 1.0 };
        PaperInput {
            dt_s,
            torque_per_friction_nm: std::array::from_fn(|i| {
                let force_n = share * sample.step_force_n[i];
                pad_torque_nm(sample.torque_factor[i], force_n, self.model.physics.brake_radius_m)
            }),
            drive_torque_nm: std::array::from_fn(|i| share * sample.drive_torque_nm[i]),
            other_force_n: share * sample.other_acceleration_m_s2 * self.model.physics.mass_kg,
            wind_m_s: sample.wind_m_s,
        }
    }

    /// Prediction of mean and covariance; the bare step that a benchmark times.
    #[inline]
    pub fn predict_step(&mut self, input: &PaperInput<W>) {
        let q_per_s = self.q_per_s;
        self.predict_with(input, &q_per_s);
    }

    /// The same with another Q per second.
    #[inline]
    pub(super) fn predict_with(&mut self, input: &PaperInput<W>, q_per_s: &SVector<f64, N>) {
        let (next, f) = self.model.propagate(&self.belief.mean, input);
        self.sensitivity = f;
        self.step_s = input.dt_s;
        self.belief.predict_leading(next, &f, W + 1, &(q_per_s * input.dt_s));
    }

    /// (17) cannot be solved for a pad that hardly presses: its friction is held and grows uncertain up to the prior.
    pub(super) fn age_pads(&mut self, sample: &DrivenSample, dt_s: f64) {
        let prior = self.pad_prior_variance();
        for i in 0..W {
            let at = PaperModel::<W, N>::PAD + i;
            let excess = self.belief.covariance[(at, at)] - prior;
            if sample.pressing_force_n[i] < self.force_floor_n(i) {
                let share = (2.0 * dt_s / self.config.rates.pad_forget_s).min(1.0);
                self.belief.covariance[(at, at)] += (-excess).max(0.0) * share;
            }
        }
    }

    pub(super) fn index(output: usize) -> usize {
        if output == 0 { PaperModel::<W, N>::V } else { output - 1 }
    }

    fn variance(&self, output: usize) -> f64 {
        if output == 0 { self.r.0 } else { self.r.1 }
    }

    /// Pressing force below which (17) has no solution for the pad friction of wheelset `i`, N.
    fn force_floor_n(&self, i: usize) -> f64 {
        self.model.physics.pressing_force_for_adhesion_n(i, self.config.priors.braking_adhesion)
    }

    fn pad_prior_variance(&self) -> f64 {
        let priors = &self.config.priors;
        (priors.pad_common.powi(2) + priors.pad_split.powi(2)) * self.model.physics.brake_friction[0].powi(2)
    }

    fn set_motion(&mut self, sample: &DrivenSample) {
        let physics = &self.model.physics;
        let v_m_s = sample.speed_or_rim_m_s(&physics.wheel_radius_m);
        let v_sigma = if sample.v_m_s.is_finite() { self.sensors.speed_m_s } else { 1.0 };
        for i in 0..W {
            let measured = sample.wheel_speed_rad_s[i];
            let rolling = v_m_s / physics.wheel_radius_m[i];
            let (speed, sigma) = if measured.is_finite() {
                (measured, self.sensors.wheel_speed_rad_s)
            } else {
                (rolling, 3.0)
            };
            self.belief.reset_component(i, speed, sigma);
        }
        self.belief.reset_component(PaperModel::<W, N>::V, v_m_s, v_sigma);
        self.belief.reset_component(PaperModel::<W, N>::ADHESION, 0.0, 0.1);
    }
}

impl<const W: usize, const N: usize> WagonFilter for PaperFilter<W, N> {
    fn start(&mut self, sample: &DrivenSample) {
        self.belief = Gaussian { mean: SVector::zeros(), covariance: SMatrix::identity() };
        for i in 0..W {
            let nominal = self.model.physics.brake_friction[i];
            self.belief.reset_component(
                PaperModel::<W, N>::PAD + i,
                nominal,
                self.pad_prior_variance().sqrt(),
            );
        }
        self.set_motion(sample);
    }

    fn restart_motion(&mut self, sample: &DrivenSample, gap_s: f64) {
        self.set_motion(sample);
        let prior = self.pad_prior_variance();
        for i in 0..W {
            let at = PaperModel::<W, N>::PAD + i;
            let room = (prior - self.belief.covariance[(at, at)]).max(0.0);
            self.belief.covariance[(at, at)] += room * (gap_s / self.config.rates.pad_forget_s).min(1.0);
        }
    }

    fn predict(&mut self, sample: &DrivenSample, dt_s: f64) {
        let input = self.step_input(sample, dt_s);
        self.predict_step(&input);
        self.age_pads(sample, dt_s);
    }

    #[inline]
    fn expect(&self, output: usize, measured: f64) -> ScalarUpdate {
        self.belief.expect_component(Self::index(output), measured, self.variance(output))
    }

    #[inline]
    fn accept(&mut self, output: usize, update: &ScalarUpdate) {
        self.belief.update_component(Self::index(output), update, self.variance(output));
    }

    fn believe(&mut self, output: usize, measured: f64) {
        let sigma = self.variance(output).sqrt();
        self.belief.reset_component(Self::index(output), measured, 3.0 * sigma);
        let at = PaperModel::<W, N>::ADHESION;
        self.belief.covariance[(at, at)] += 0.05 * 0.05;
    }

    fn conclude(&mut self, _sample: &DrivenSample, _dt_s: f64) {}

    fn read(&self, sample: &DrivenSample, out: &mut EstimatorOutput) {
        let physics = &self.model.physics;
        let x = &self.belief.mean;
        let (v, adhesion) = (x[PaperModel::<W, N>::V], x[PaperModel::<W, N>::ADHESION]);
        let other_n = sample.other_acceleration_m_s2 * physics.mass_kg;
        let resistance = running_resistance(&physics.resistance, v, sample.wind_m_s);
        let contact_n = adhesion * physics.loads.weight_n();
        let loads = physics.loads_n(body_acceleration_m_s2(physics.mass_kg, contact_n, resistance, other_n));
        let sigma = self.belief.sigma(PaperModel::<W, N>::ADHESION);
        let brakes = (0..W).any(|i| sample.pressing_force_n[i] > self.force_floor_n(i));
        let weight = |i: usize| if brakes { sample.pressing_force_n[i] } else { 1.0 };
        let pressing: f64 = (0..W).map(weight).sum();
        let mut pads = SVector::<f64, N>::zeros();
        out.wheelsets = W as u32;
        (out.v_m_s, out.mu_w, out.mu_w_sigma) = (v, adhesion, sigma);
        for i in 0..W {
            let pad = PaperModel::<W, N>::PAD + i;
            pads[pad] = sample.torque_factor[i] * weight(i) / pressing;
            (out.mu_w_wheelset[i], out.mu_w_wheelset_sigma[i]) = (adhesion, sigma);
            out.mu_b[i] = sample.torque_factor[i] * x[pad];
            out.mu_b_sigma[i] = sample.torque_factor[i] * self.belief.sigma(pad);
            let slip_m_s = physics.wheel_radius_m[i] * x[i] - v;
            out.slip[i] = creepage(physics.wheel_radius_m[i] * x[i], v);
            out.normal_load_n[i] = loads[i];
            if slip_m_s.abs() > 0.05 * v.max(4.0) {
                out.sliding |= 1 << i;
            }
            if sample.pressing_force_n[i] > self.force_floor_n(i) {
                out.observable |= 1 << i;
            }
        }
        out.mu_b_mean = pads.dot(x);
        out.mu_b_mean_sigma = self.belief.sigma_along(&pads);
        if self.step_s > 0.0 {
            let prior = self.pad_prior_variance().sqrt();
            let scaled = SMatrix::<f64, N, N>::from_fn(|row, column| {
                if row > W || column <= W {
                    return 0.0;
                }
                let range = if column == PaperModel::<W, N>::ADHESION { 0.05 } else { prior };
                let sigma = self.variance(if row == W { 0 } else { row + 1 }).sqrt();
                self.sensitivity[(row, column)] * range / self.step_s / sigma
            });
            out.observability_rank = 1 + W as u32 + scaled_rank(scaled, N, N);
        }
    }

    fn save(&self) -> FilterState {
        pack(&self.belief, Vec::new())
    }

    fn load(&mut self, state: &FilterState) -> Result<(), FilterError> {
        self.belief = unpack(state, 0)?;
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

    /// No contact transmits nine tenths of its load, and no pad rubs at a quarter or at three times its nominal
    /// friction.
    fn has_diverged(&self) -> bool {
        let x = &self.belief.mean;
        let pads = (0..W).any(|i| {
            let ratio = x[PaperModel::<W, N>::PAD + i] / self.model.physics.brake_friction[i];
            !POSSIBLE_PAD_RATIO.contains(&ratio)
        });
        pads || x[PaperModel::<W, N>::ADHESION].abs() > IMPOSSIBLE_ADHESION
            || !x.iter().all(|v| v.is_finite())
    }
}
