//! The effects that a vehicle file names, as the filters see them: as a factor on brake torque, a force on the body and
//! a correction of what the sensors read. Within a step they count as constant.

use crate::EstimatorOutput;
use crate::models::DrivenSample;
use railgrip_vehicle::brake::pad_torque_nm;
use railgrip_vehicle::effects::Operating;
use railgrip_vehicle::resistance::grade_acceleration;
use railgrip_vehicle::{VehicleParameters, WagonInput, WagonModel};

/// After a longer hole in the data, hidden states go on as if it had been this long, s.
const LONGEST_CATCH_UP_S: f64 = 2.0;

/// Brake torque over the wagon's weight and wheel radius below which it is too small to divide by.
const LEAST_TORQUE_SHARE: f64 = 0.001;

/// The model's laws along a run.
#[derive(Clone, Debug)]
pub(crate) struct Laws {
    model: WagonModel,
    period_s: f64,
    at: Operating,
    pub(crate) hidden: Vec<f64>,
    started: bool,
    /// The operating point has the wheelset speeds of an estimate.
    rolls: bool,
    /// Time that the hidden states are behind, s.
    behind_s: f64,
}

/// Time, place and track of one sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Place {
    pub(crate) time_s: f64,
    pub(crate) grade_rad: f64,
    pub(crate) position_m: f64,
}

impl Laws {
    pub(crate) fn new(vehicle: &VehicleParameters, model: WagonModel) -> Self {
        let period_s = 1.0 / vehicle.sensors.sample_rate_hz;
        Self {
            model,
            period_s,
            at: Operating::default(),
            hidden: Vec::new(),
            started: false,
            rolls: false,
            behind_s: 0.0,
        }
    }

    /// Takes up hidden states of a snapshot; false if they do not fit the model.
    pub(crate) fn restore(&mut self, hidden: &[f64]) -> bool {
        let expected: usize = self.model.effects().iter().map(|e| e.hidden_len(self.period_s)).sum();
        let fits = hidden.is_empty() || hidden.len() == expected;
        if fits && hidden.iter().all(|value| value.is_finite()) {
            self.started = !hidden.is_empty() || expected == 0;
            self.hidden = hidden.to_vec();
            return true;
        }
        false
    }

    /// Fills in what the model says about torque, body force and sensors at the last estimate.
    pub(crate) fn apply(&mut self, sample: &mut DrivenSample, place: &Place, last: &EstimatorOutput) {
        sample.other_acceleration_m_s2 = grade_acceleration(place.grade_rad);
        if self.model.effects().is_empty() {
            return;
        }
        let constants = self.model.constants();
        let weight_n = self.model.load_distribution().weight_n();
        self.at = Operating {
            time_s: place.time_s,
            v_m_s: last.v_m_s,
            position_m: place.position_m,
            wheelset_position_m: constants.wheelset_positions_m,
            sanding: sample.sanding,
            grade_rad: place.grade_rad,
            pressing_force_n: sample.step_force_n,
            drive_torque_nm: sample.drive_torque_nm,
            ..self.at
        };
        if !self.rolls {
            // Before the first estimate of slip a wheelset is taken to roll.
            for i in 0..constants.wheelsets {
                self.at.wheel_speed_rad_s[i] = last.v_m_s / constants.wheel_radius_m[i];
            }
        }
        if !self.started {
            self.hidden = self.model.start_hidden(&self.at, self.period_s);
            self.started = true;
        }
        let input = WagonInput {
            time_s: place.time_s,
            pressing_force_n: sample.step_force_n,
            drive_torque_nm: sample.drive_torque_nm,
            grade_rad: place.grade_rad,
            sanding: sample.sanding,
            position_m: place.position_m,
            ..WagonInput::default()
        };
        let loading = self.model.loading(&self.at, &input, self.period_s, &self.hidden);
        sample.other_acceleration_m_s2 = loading.other_n / constants.mass_kg;
        sample.wind_m_s = loading.wind_m_s;
        for i in 0..constants.wheelsets {
            let plain =
                pad_torque_nm(constants.brake_friction[i], sample.step_force_n[i], constants.brake_radius_m);
            let least = LEAST_TORQUE_SHARE * weight_n * constants.wheel_radius_m[i];
            if plain > least {
                sample.torque_factor[i] = loading.brake_torque_nm[i] / plain;
            } else {
                sample.torque_factor[i] = loading.brake_friction[i] / constants.brake_friction[i];
                let unasked = loading.brake_torque_nm[i] - sample.torque_factor[i] * plain;
                sample.drive_torque_nm[i] -= unasked.max(0.0);
            }
        }
        let reading = self.model.observe(&self.at, self.period_s, &self.hidden);
        sample.v_m_s -= reading.v_m_s - self.at.v_m_s;
        for i in 0..constants.wheelsets {
            sample.wheel_speed_rad_s[i] -= reading.wheel_speed_rad_s[i] - self.at.wheel_speed_rad_s[i];
        }
    }

    /// Lets temperatures, films and delays of the effects move on.
    pub(crate) fn advance(&mut self, sample: &DrivenSample, estimate: &EstimatorOutput, dt_s: f64) {
        if self.model.effects().is_empty() {
            return;
        }
        let constants = self.model.constants();
        self.at.acceleration_m_s2 = (estimate.v_m_s - self.at.v_m_s) / dt_s.max(1e-4);
        self.at.v_m_s = estimate.v_m_s;
        for i in 0..constants.wheelsets {
            let rim = estimate.v_m_s * (1.0 + estimate.slip[i]);
            let speed = rim / constants.wheel_radius_m[i];
            let torque =
                pad_torque_nm(estimate.mu_b[i], sample.pressing_force_n[i], constants.brake_radius_m);
            let force = estimate.mu_w_wheelset[i] * estimate.normal_load_n[i];
            self.at.wheel_speed_rad_s[i] = speed;
            self.at.brake_power_w[i] = (torque * speed).max(0.0);
            self.at.slip_power_w[i] = (force * (rim - estimate.v_m_s)).max(0.0);
        }
        self.rolls = true;
        // Hidden states advance by whole periods: delay lines have one place a period, and samples come a little early or late.
        self.behind_s = (self.behind_s + dt_s).min(LONGEST_CATCH_UP_S);
        while self.behind_s > 0.5 * self.period_s {
            self.model.advance_hidden(&self.at, self.period_s, &mut self.hidden);
            self.behind_s -= self.period_s;
        }
    }
}
