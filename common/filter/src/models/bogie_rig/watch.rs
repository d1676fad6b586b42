//! Which sensors can be believed: dead, exchanged or contradicting ones get a name instead of a number.

use super::sample::{BogieInputState, BogieSample};
use super::slip_based::{self, RollerCounts};
use railgrip_vehicle::bogie_rig::{BOGIE_WHEELSETS, BogieParameters};

/// A noisy value that stays exactly the same, or is missing, for that long is dead, s.
const DEAD_AFTER_S: f64 = 0.3;

/// Pressure below which the brakes are released, Pa.
const RELEASED_PA: f64 = 2e4;

/// The pads need that long to let go, s.
const RELEASE_S: f64 = 0.5;

/// Share of the rig's load below which there is none to speak of.
const LOAD_SHARE_MIN: f64 = 0.05;

/// Capacity of a sensor times this is out of its range.
const OUT_OF_RANGE: f64 = 1.5;

/// Slip while nothing brakes beyond which the pulses cannot be those of this rig.
const ROLLING_SLIP_MAX: f64 = 0.3;

/// Adhesion by which torque and link force may differ in the mean over [`AGREE_S`].
const DISAGREEMENT: f64 = 0.08;

/// Time over which they are compared, s.
const AGREE_S: f64 = 0.5;

/// Speed of the rollers' rim below which the rig stands, m/s.
const STANDSTILL_M_S: f64 = 0.05;

/// Slip above which a braked wheelset counts as locked.
const LOCKED_SLIP: f64 = 0.95;

/// Watches one value for signs of life.
#[derive(Clone, Copy, Debug)]
struct Life {
    last: f64,
    unchanged_s: f64,
}

impl Life {
    const NEW: Self = Self { last: f64::NAN, unchanged_s: 0.0 };

    fn watch(&mut self, value: f64, dt_s: f64) {
        if value.is_finite() && value != self.last {
            self.unchanged_s = 0.0;
            self.last = value;
        } else {
            self.unchanged_s += dt_s;
        }
    }

    fn is_dead(&self) -> bool {
        self.unchanged_s > DEAD_AFTER_S
    }
}

/// What the filter knows about the motion when the data are judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub v_m_s: f64,
    pub slip: [f64; BOGIE_WHEELSETS],
    pub offsets: (f64, f64),
}

/// Memory of the watch.
#[derive(Clone, Copy, Debug)]
pub(super) struct InputWatch {
    torque: Life,
    load_cell: Life,
    roller_missing_s: f64,
    wheel_missing_s: [f64; BOGIE_WHEELSETS],
    wheel_silent_s: [f64; BOGIE_WHEELSETS],
    roller_silent_s: f64,
    released_s: f64,
    odd_slip_s: f64,
    difference: f64,
    swapped: bool,
    /// By counts alone: the filter's acceleration gives way where the forces contradict each other.
    counts: RollerCounts,
}

impl InputWatch {
    pub(super) const NEW: Self = Self {
        torque: Life::NEW,
        load_cell: Life::NEW,
        roller_missing_s: 0.0,
        wheel_missing_s: [0.0; BOGIE_WHEELSETS],
        wheel_silent_s: [0.0; BOGIE_WHEELSETS],
        roller_silent_s: 0.0,
        released_s: 0.0,
        odd_slip_s: 0.0,
        difference: 0.0,
        swapped: false,
        counts: RollerCounts::NEW,
    };

    /// Looks at a sample before the filter does; after a gap the window of the rollers' counter is torn.
    pub(super) fn look(
        &mut self,
        parameters: &BogieParameters,
        sample: &BogieSample,
        dt_s: f64,
        torn_window: bool,
    ) {
        self.torque.watch(sample.shaft_torque_nm, dt_s);
        self.load_cell.watch(sample.load_cell_n, dt_s);
        let grow = |time: &mut f64, bad: bool| *time = if bad { *time + dt_s } else { 0.0 };
        grow(&mut self.roller_missing_s, !sample.roller_pulses.is_finite());
        for i in 0..BOGIE_WHEELSETS {
            grow(&mut self.wheel_missing_s[i], !sample.wheel_pulses[i].is_finite());
            grow(&mut self.wheel_silent_s[i], sample.wheel_pulses[i] == 0.0);
        }
        if torn_window {
            self.counts.tear();
        }
        self.counts.take(parameters, sample, dt_s);
        if sample.roller_pulses.is_finite() {
            self.roller_silent_s = if sample.roller_pulses == 0.0 {
                self.roller_silent_s + parameters.sensors.roller_window_s
            } else {
                0.0
            };
        }
        // A pressure that is not measured may be a brake.
        grow(&mut self.released_s, sample.brake_pressure_pa <= RELEASED_PA);
        let limit = OUT_OF_RANGE * parameters.sensors.torque_capacity_nm;
        let torque_is_a_force = sample.shaft_torque_nm.abs() > limit;
        if torque_is_a_force && sample.load_cell_n.abs() < limit {
            self.swapped = true;
        } else if sample.load_cell_n.abs() > limit {
            self.swapped = false;
        }
    }

    /// Looks at what the filter made of it.
    pub(super) fn compare(
        &mut self,
        parameters: &BogieParameters,
        sample: &BogieSample,
        motion: &Motion,
        dt_s: f64,
    ) {
        let odd = self.released()
            && motion.v_m_s > STANDSTILL_M_S
            && motion.slip.iter().all(|slip| slip.abs() > ROLLING_SLIP_MAX);
        self.odd_slip_s = if odd { self.odd_slip_s + dt_s } else { 0.0 };
        let by_torque = slip_based::by_torque_with_inertia(
            parameters,
            sample.shaft_torque_nm - motion.offsets.0,
            motion.v_m_s / parameters.roller_radius_m,
            self.counts.acceleration_rad_s2,
            sample.load_n,
        );
        let by_load_cell = slip_based::by_load_cell(sample.load_cell_n - motion.offsets.1, sample.load_n);
        if let (Some(by_torque), Some(by_load_cell)) = (by_torque, by_load_cell) {
            let difference = by_torque - by_load_cell;
            if difference.is_finite() {
                self.difference +=
                    (dt_s / AGREE_S).min(1.0) * (difference.clamp(-1.0, 1.0) - self.difference);
            }
        }
    }

    /// True if nothing has braked for long enough that the pads are off.
    pub(super) fn released(&self) -> bool {
        self.released_s > RELEASE_S
    }

    /// True if a torque can be used.
    pub(super) fn torque_usable(&self, parameters: &BogieParameters, sample: &BogieSample) -> bool {
        let limit = OUT_OF_RANGE * parameters.sensors.torque_capacity_nm;
        sample.shaft_torque_nm.abs() <= limit && !self.torque.is_dead() && !self.swapped
    }

    /// True if a link force can be used.
    pub(super) fn load_cell_usable(&self, parameters: &BogieParameters, sample: &BogieSample) -> bool {
        let limit = OUT_OF_RANGE * parameters.sensors.load_cell_capacity_n;
        sample.load_cell_n.abs() <= limit && !self.load_cell.is_dead() && !self.swapped
    }

    /// True if there is load on the wheelsets.
    pub(super) fn loaded(parameters: &BogieParameters, sample: &BogieSample) -> bool {
        sample.load_n.is_finite() && sample.load_n > LOAD_SHARE_MIN * parameters.load_n()
    }

    /// The name of what the data are.
    pub(super) fn judge(
        &self,
        parameters: &BogieParameters,
        sample: &BogieSample,
        motion: &Motion,
    ) -> BogieInputState {
        let window = parameters.sensors.roller_window_s;
        let torque_dead = self.torque.is_dead() || !self.torque_in_range(parameters);
        let load_cell_dead = self.load_cell.is_dead() || !self.load_cell_in_range(parameters);
        let roller_dead = self.roller_missing_s > DEAD_AFTER_S + window
            || (self.roller_silent_s > 2.0 * window && self.wheel_silent_s.iter().any(|time| *time < window));
        let wheel_dead = (0..BOGIE_WHEELSETS).any(|i| {
            self.wheel_missing_s[i] > DEAD_AFTER_S
                || (self.wheel_silent_s[i] > DEAD_AFTER_S
                    && self.released()
                    && motion.v_m_s > 4.0 * STANDSTILL_M_S)
        });
        // A load that is not measured counts as none: neither adhesion nor slip is told then, whatever else is missing.
        if !Self::loaded(parameters, sample) {
            BogieInputState::ZeroLoad
        } else if self.swapped {
            BogieInputState::ForcesSwapped
        } else if torque_dead && load_cell_dead {
            BogieInputState::ForcesDead
        } else if roller_dead {
            BogieInputState::RollerCounterDead
        } else if wheel_dead {
            BogieInputState::WheelCounterDead
        } else if self.odd_slip_s > DEAD_AFTER_S {
            BogieInputState::CountersSwapped
        } else if torque_dead {
            BogieInputState::TorqueDead
        } else if load_cell_dead {
            BogieInputState::LoadCellDead
        } else if self.difference.abs() > DISAGREEMENT {
            BogieInputState::ForcesDisagree
        } else if motion.v_m_s < STANDSTILL_M_S {
            BogieInputState::Standstill
        } else if self.released() {
            BogieInputState::Rolling
        } else if motion.slip.iter().any(|slip| *slip > LOCKED_SLIP) {
            BogieInputState::WheelLocked
        } else {
            BogieInputState::Braking
        }
    }

    fn torque_in_range(&self, parameters: &BogieParameters) -> bool {
        self.torque.last.abs() <= OUT_OF_RANGE * parameters.sensors.torque_capacity_nm
    }

    fn load_cell_in_range(&self, parameters: &BogieParameters) -> bool {
        self.load_cell.last.abs() <= OUT_OF_RANGE * parameters.sensors.load_cell_capacity_n
    }
}
