//! Induction motor in the stator's αβ frame: Zhao et al. (3-4) to (3-8), after Bose, Modern Power Electronics and AC
//! Drives. Linear magnetics, squirrel cage.

use serde::{Deserialize, Serialize};

/// Constants of an induction motor, referred to the stator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorParameters {
    /// Stator resistance R_s, Ω.
    pub stator_resistance_ohm: f64,
    /// Rotor resistance R_r, Ω.
    pub rotor_resistance_ohm: f64,
    /// Stator inductance L_s (leakage + mutual), H.
    pub stator_inductance_h: f64,
    /// Rotor inductance L_r (leakage + mutual), H.
    pub rotor_inductance_h: f64,
    /// Mutual inductance L_m, H.
    pub mutual_inductance_h: f64,
    /// Number of pole *pairs*.
    pub pole_pairs: f64,
}

/// Stator currents and rotor fluxes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorState {
    /// Stator current (α, β), A.
    pub current_a: [f64; 2],
    /// Rotor flux linkage (α, β), Wb.
    pub flux_wb: [f64; 2],
}

/// An induction motor, with the coefficients of its equations worked out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    parameters: MotorParameters,
    /// R_s/(σ L_s) + (1 − σ)/(σ t_r), 1/s.
    current_decay: f64,
    /// L_m/(σ L_s L_r), A/(Wb).
    flux_to_current: f64,
    /// 1/t_r, 1/s.
    rotor_rate: f64,
    /// 1/(σ L_s), 1/H.
    voltage_gain: f64,
    /// 1.5 pairs L_m/L_r.
    torque_gain: f64,
}

impl Motor {
    /// The motor with these constants.
    pub fn new(parameters: MotorParameters) -> Self {
        let p = &parameters;
        let sigma = 1.0
            - p.mutual_inductance_h * p.mutual_inductance_h / (p.stator_inductance_h * p.rotor_inductance_h);
        let rotor_rate = p.rotor_resistance_ohm / p.rotor_inductance_h;
        let transient_inductance = sigma * p.stator_inductance_h;
        Self {
            parameters,
            current_decay: p.stator_resistance_ohm / transient_inductance
                + (1.0 - sigma) / sigma * rotor_rate,
            flux_to_current: p.mutual_inductance_h / (transient_inductance * p.rotor_inductance_h),
            rotor_rate,
            voltage_gain: 1.0 / transient_inductance,
            // (3-4): 0.75 with a number of poles is 1.5 with a number of pole pairs.
            torque_gain: 1.5 * p.pole_pairs * p.mutual_inductance_h / p.rotor_inductance_h,
        }
    }

    /// The constants.
    pub fn parameters(&self) -> &MotorParameters {
        &self.parameters
    }

    /// Electric torque T_e, N m.
    #[inline]
    pub fn torque_nm(&self, state: &MotorState) -> f64 {
        let MotorState { current_a: [ia, ib], flux_wb: [fa, fb] } = *state;
        self.torque_gain * (fa * ib - fb * ia)
    }

    /// Speed of the flux vector against the rotor (slip frequency), electrical rad/s; 0 without flux.
    #[inline]
    pub fn slip_frequency_rad_s(&self, state: &MotorState) -> f64 {
        let MotorState { current_a: [ia, ib], flux_wb: [fa, fb] } = *state;
        let square = fa * fa + fb * fb;
        if square < 1e-6 {
            return 0.0;
        }
        self.rotor_rate * self.parameters.mutual_inductance_h * (fa * ib - fb * ia) / square
    }

    /// (3-5) to (3-8): change of currents (A/s) and fluxes (V) at motor speed `speed_rad_s` (mechanical).
    #[inline]
    pub fn derivative(&self, state: &MotorState, speed_rad_s: f64, voltage_v: [f64; 2]) -> MotorState {
        let MotorState { current_a: [ia, ib], flux_wb: [fa, fb] } = *state;
        let omega = self.parameters.pole_pairs * speed_rad_s;
        let magnetising = self.rotor_rate * self.parameters.mutual_inductance_h;
        MotorState {
            current_a: [
                -self.current_decay * ia
                    + self.flux_to_current * (self.rotor_rate * fa + omega * fb)
                    + self.voltage_gain * voltage_v[0],
                -self.current_decay * ib
                    + self.flux_to_current * (self.rotor_rate * fb - omega * fa)
                    + self.voltage_gain * voltage_v[1],
            ],
            flux_wb: [
                magnetising * ia - self.rotor_rate * fa - omega * fb,
                magnetising * ib - self.rotor_rate * fb + omega * fa,
            ],
        }
    }

    /// State after `dt_s` (classic Runge–Kutta; the fastest rate is a few hundred per second) while the voltage moves
    /// from `from_v` over `middle_v` to `to_v`.
    #[inline]
    pub fn step(
        &self,
        state: &MotorState,
        speed_rad_s: f64,
        [from_v, middle_v, to_v]: [[f64; 2]; 3],
        dt_s: f64,
    ) -> MotorState {
        let k1 = self.derivative(state, speed_rad_s, from_v);
        let k2 = self.derivative(&state.plus(&k1, 0.5 * dt_s), speed_rad_s, middle_v);
        let k3 = self.derivative(&state.plus(&k2, 0.5 * dt_s), speed_rad_s, middle_v);
        let k4 = self.derivative(&state.plus(&k3, dt_s), speed_rad_s, to_v);
        state.plus(&k1, dt_s / 6.0).plus(&k2, dt_s / 3.0).plus(&k3, dt_s / 3.0).plus(&k4, dt_s / 6.0)
    }
}

impl MotorState {
    #[inline]
    fn plus(&self, rate: &Self, time_s: f64) -> Self {
        Self {
            current_a: [
                self.current_a[0] + time_s * rate.current_a[0],
                self.current_a[1] + time_s * rate.current_a[1],
            ],
            flux_wb: [self.flux_wb[0] + time_s * rate.flux_wb[0], self.flux_wb[1] + time_s * rate.flux_wb[1]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traction_rig::RigParameters;
    use std::f64::consts::PI;

    fn steady(motor: &Motor, amplitude_v: f64, frequency_rad_s: f64, speed_rad_s: f64) -> MotorState {
        let dt = 1e-4;
        let mut state = MotorState::default();
        let at =
            |t: f64| [amplitude_v * (frequency_rad_s * t).cos(), amplitude_v * (frequency_rad_s * t).sin()];
        for k in 0..40_000 {
            let t = f64::from(k) * dt;
            state = motor.step(&state, speed_rad_s, [at(t), at(t + 0.5 * dt), at(t + dt)], dt);
        }
        state
    }

    /// Torque of the per-phase equivalent circuit (any text on machines): 3 I_r² R_r / (s ω_sync).
    fn circuit_torque(p: &MotorParameters, amplitude_v: f64, frequency_rad_s: f64, slip: f64) -> f64 {
        let leak_s = frequency_rad_s * (p.stator_inductance_h - p.mutual_inductance_h);
        let leak_r = frequency_rad_s * (p.rotor_inductance_h - p.mutual_inductance_h);
        let x_m = frequency_rad_s * p.mutual_inductance_h;
        // Thévenin equivalent of stator and magnetising branch.
        let square = p.stator_resistance_ohm.powi(2) + (leak_s + x_m).powi(2);
        let v_th = amplitude_v / 2f64.sqrt() * x_m / square.sqrt();
        let r_th = x_m * x_m * p.stator_resistance_ohm / square;
        let x_th = x_m * (p.stator_resistance_ohm.powi(2) + leak_s * (leak_s + x_m)) / square;
        let r_r = p.rotor_resistance_ohm / slip;
        let current_square = v_th * v_th / ((r_th + r_r).powi(2) + (x_th + leak_r).powi(2));
        3.0 * current_square * r_r / (frequency_rad_s / p.pole_pairs)
    }

    #[test]
    fn erratum_5_torque_counts_pole_pairs_with_1_5_and_poles_with_0_75() {
        let motor = Motor::new(RigParameters::default().motor);
        let p = *motor.parameters();
        // Rated point of the nameplate: 400 V line to line, 50 Hz, 1430 rpm, 4 kW.
        let (amplitude, frequency, speed) = (400.0 * (2.0f64 / 3.0).sqrt(), 100.0 * PI, 1430.0 * PI / 30.0);
        let state = steady(&motor, amplitude, frequency, speed);
        let torque = motor.torque_nm(&state);
        let slip = 1.0 - p.pole_pairs * speed / frequency;
        let circuit = circuit_torque(&p, amplitude, frequency, slip);
        println!("rated torque: αβ model {torque:.2} N m, equivalent circuit {circuit:.2}, nameplate 26.71");
        assert!((torque / circuit - 1.0).abs() < 2e-3);
        assert!((torque / 26.71 - 1.0).abs() < 0.1);
        let poles = 2.0 * p.pole_pairs;
        let with_poles = 0.75 * poles * p.mutual_inductance_h / p.rotor_inductance_h
            * (state.flux_wb[0] * state.current_a[1] - state.flux_wb[1] * state.current_a[0]);
        assert!((with_poles / torque - 1.0).abs() < 1e-12);
    }

    #[test]
    fn electric_power_is_shaft_power_plus_copper_loss() {
        let motor = Motor::new(RigParameters::default().motor);
        let p = *motor.parameters();
        let (frequency, speed) = (80.0, 35.0);
        let state = steady(&motor, 90.0, frequency, speed);
        let angle = frequency * 4.0;
        let u = [90.0 * f64::cos(angle), 90.0 * f64::sin(angle)];
        let [ia, ib] = state.current_a;
        let electric = 1.5 * (u[0] * ia + u[1] * ib);
        let rotor_current =
            |k: usize| (state.flux_wb[k] - p.mutual_inductance_h * state.current_a[k]) / p.rotor_inductance_h;
        let copper = 1.5
            * (p.stator_resistance_ohm * (ia * ia + ib * ib)
                + p.rotor_resistance_ohm * (rotor_current(0).powi(2) + rotor_current(1).powi(2)));
        let shaft = motor.torque_nm(&state) * speed;
        println!("electric {electric:.2} W, shaft {shaft:.2} W, copper {copper:.2} W");
        assert!((electric - shaft - copper).abs() < 1e-3 * electric.abs());
    }

    #[test]
    fn slip_frequency_is_that_of_the_supply_less_the_rotor() {
        let motor = Motor::new(RigParameters::default().motor);
        let state = steady(&motor, 90.0, 80.0, 35.0);
        assert!((motor.slip_frequency_rad_s(&state) - 10.0).abs() < 1e-2);
        assert_eq!(motor.slip_frequency_rad_s(&MotorState::default()), 0.0);
    }
}
