//! Brake controllers. They ask a simulated actuator for a torque; nothing in railgrip drives a real brake.
//!
//! Two of them keep the slip of the wheelset that slips most inside a zone: below it the torque rises, inside it
//! stays, above it it is let go the faster the further the slip is out. The *conventional* zone is fixed where no rail
//! slides; the *proposed* zone moves with the optimum slip of speed and condition, and the torque is bounded by the
//! adhesion that the heard condition can give.

use railgrip_filter::models::bogie_rig::{BogieEstimate, Decision};
use railgrip_vehicle::bogie_rig::BogieParameters;

/// Which controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// A constant torque a wheelset, N m.
    Open {
        /// That torque, N m.
        torque_nm: f64,
    },
    /// A torque that grows until a slip is reached, and is let go then: the identification tests of section 4.1.
    Ramp {
        /// Growth, N m/s.
        rate_nm_s: f64,
        /// Slip that ends it.
        release_at: f64,
    },
    /// Conventional: a fixed zone of slip.
    FixedZone {
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// Proposed: a zone around the optimum slip.
    Proposed,
}

impl Control {
    /// The conventional zone: at the low end, where the curve of every condition and speed still rises. Chosen so that
    /// the dry stop from 4.14 m/s takes about the paper's 82 s.
    pub const CONVENTIONAL: Self = Self::FixedZone { low: 0.008, high: 0.0125 };

    /// No controller: a fixed effort just below what a dry rail gives from 4.14 m/s. Chosen.
    pub fn none(parameters: &BogieParameters) -> Self {
        Self::Open { torque_nm: 0.34 * parameters.wheelset_load_n[0] * parameters.wheel_radius_m }
    }
}

/// Ends of the proposed zone as shares of the optimum slip. Chosen: on the rising side, where adhesion is within 3 % of
/// its peak, because beyond the peak slip doubles every 20 ms.
const PROPOSED_ZONE: (f64, f64) = (0.5, 0.8);

/// Torque of the proposed controller over what the heard curve's peak can carry, at most.
const CEILING: f64 = 1.03;

/// Rise of torque, N m/s a wheelset.
const RISE_NM_S: f64 = 60.0;

/// Time in which torque above the zone is let go, s.
const RELEASE_S: f64 = 0.1;

/// Time over which the conventional controller averages slip, s: its zone is as narrow as the counters are coarse.
const AVERAGE_S: f64 = 0.5;

/// Pace of torque on averaged slip, over that on slip itself.
const AVERAGED_PACE: f64 = 0.15;

/// Slip over the conventional zone's upper end at which it is not waited for the average.
const RUN_AWAY: f64 = 10.0;

/// Speed of the rollers below which slip is too coarse to act upon, m/s.
const SPEED_MIN_M_S: f64 = 0.15;

/// The same for the conventional zone, which is narrower than one pulse of the rollers' counter there, m/s.
const CONVENTIONAL_SPEED_MIN_M_S: f64 = 0.6;

/// A controller in use.
#[derive(Clone, Copy, Debug)]
pub struct BrakeController {
    control: Control,
    torque_nm: f64,
    average_slip: f64,
    done: bool,
}

impl BrakeController {
    /// A controller that begins with this torque a wheelset.
    pub fn new(control: Control, torque_nm: f64) -> Self {
        Self { control, torque_nm, average_slip: 0.0, done: false }
    }

    /// True once a ramp has reached its slip.
    pub fn is_done(&self) -> bool {
        self.done
    }

    /// Torque asked of each wheelset over the next `dt_s`, N m.
    pub fn step(
        &mut self,
        parameters: &BogieParameters,
        estimate: &BogieEstimate,
        decision: &Decision,
        dt_s: f64,
    ) -> f64 {
        let slip = estimate.slip().filter(|_| estimate.v_m_s > SPEED_MIN_M_S);
        match self.control {
            Control::Open { torque_nm } => self.torque_nm = torque_nm,
            Control::Ramp { rate_nm_s, release_at } => {
                self.done |= slip.is_some_and(|slip| slip >= release_at);
                self.torque_nm = if self.done { 0.0 } else { self.torque_nm + rate_nm_s * dt_s };
            }
            Control::FixedZone { low, high } => {
                let [front, rear] = estimate.creepage;
                let told = slip.filter(|_| estimate.v_m_s > CONVENTIONAL_SPEED_MIN_M_S);
                let mean = told.map(|_| -0.5 * (front + rear));
                self.average_slip +=
                    dt_s / AVERAGE_S * (mean.unwrap_or(self.average_slip) - self.average_slip);
                // Gently, because an average comes late, unless a wheelset runs away.
                let runs_away = told.is_some_and(|slip| slip > RUN_AWAY * high);
                let (acted_on, pace) =
                    if runs_away { (slip, 1.0) } else { (mean.map(|_| self.average_slip), AVERAGED_PACE) };
                self.keep(acted_on, low, high, f64::INFINITY, pace * dt_s);
            }
            Control::Proposed => {
                let optimum = decision.optimum;
                let load = parameters.wheelset_load_n[0];
                let ceiling = CEILING * optimum.adhesion * load * parameters.wheel_radius_m;
                self.keep(
                    slip,
                    PROPOSED_ZONE.0 * optimum.slip,
                    PROPOSED_ZONE.1 * optimum.slip,
                    ceiling,
                    dt_s,
                );
            }
        }
        self.torque_nm
    }

    fn keep(&mut self, slip: Option<f64>, low: f64, high: f64, ceiling_nm: f64, dt_s: f64) {
        let Some(slip) = slip else { return };
        if slip < low {
            let share = (2.0 * (low - slip) / low).min(1.0);
            self.torque_nm += share * RISE_NM_S * dt_s;
        } else if slip > high {
            let how_far = ((slip - high) / high).clamp(0.1, 2.0);
            self.torque_nm *= (-how_far * dt_s / RELEASE_S).exp();
        }
        self.torque_nm = self.torque_nm.clamp(0.0, ceiling_nm);
    }
}
