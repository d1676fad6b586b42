//! Wheel loads: how longitudinal forces pitch the body on its springs and each bogie on its own.
//!
//! The moment that a force makes about the rail has to be carried by unequal loads. The body answers as an oscillator
//! of about 1 Hz (it overshoots), a bogie frame as a lag of some hundredths of a second. Loads of a wagon always sum to
//! its weight: heave is left out.

use super::units::{GRAVITY_M_S2, PerWheelset};

/// Lag of a bogie frame on its primary springs, s.
const FRAME_LAG_S: f64 = 0.04;
/// Height of a bogie's own centre of mass above the rail, m.
const FRAME_HEIGHT_M: f64 = 0.5;

/// A wagon's bogies.
#[derive(Debug, Clone, Copy)]
pub struct Bogies {
    /// Distance of the wheelsets of one bogie, m.
    pub wheelbase_m: f64,
    /// Height of the traction pivot above the rail, m.
    pub pivot_height_m: f64,
    /// Mass of one bogie with its wheelsets, kg.
    pub mass_kg: f64,
}

/// What pitches a wagon, all forward positive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Push<'a> {
    pub(crate) contact_n: &'a PerWheelset,
    pub(crate) coupler_n: f64,
    pub(crate) acceleration_m_s2: f64,
    /// `J ω̇` of each wheelset, N m.
    pub(crate) spin_nm: &'a PerWheelset,
}

/// Pitch of one wagon.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pitch {
    pub(crate) mass_kg: f64,
    /// Centre of mass of the wagon without bogies, above the rail, m.
    pub(crate) body_height_m: f64,
    pub(crate) coupler_height_m: f64,
    /// Distance of the pivots, or of the wheelsets of a wagon without bogies, m.
    pub(crate) base_m: f64,
    pub(crate) bogies: Option<Bogies>,
    /// Angular frequency of the body, rad/s, and its share of critical damping.
    pub(crate) body: (f64, f64),
    moment_nm: f64,
    moment_rate: f64,
    frame_nm: [f64; 2],
}

impl Pitch {
    pub(crate) fn new(
        mass_kg: f64,
        heights_m: (f64, f64),
        base_m: f64,
        bogies: Option<Bogies>,
        body: (f64, f64),
    ) -> Self {
        let (body_height_m, coupler_height_m) = heights_m;
        let rest = (0.0, 0.0, [0.0; 2]);
        let (moment_nm, moment_rate, frame_nm) = rest;
        Self {
            mass_kg,
            body_height_m,
            coupler_height_m,
            base_m,
            bogies,
            body,
            moment_nm,
            moment_rate,
            frame_nm,
        }
    }

    /// Advances the pitch and returns the wheel loads, N, front first.
    pub(crate) fn advance(&mut self, push: &Push<'_>, step_s: f64) -> PerWheelset {
        match self.bogies {
            None => self.two_axles(push, step_s),
            Some(bogies) => self.on_bogies(&bogies, push, step_s),
        }
    }

    fn two_axles(&mut self, push: &Push<'_>, step_s: f64) -> PerWheelset {
        let contact_n = push.contact_n[0] + push.contact_n[1];
        let moment_nm = -self.body_height_m * contact_n
            + (self.coupler_height_m - self.body_height_m) * push.coupler_n
            - push.spin_nm[0]
            - push.spin_nm[1];
        let shift_n = self.carried(moment_nm, step_s) / self.base_m;
        let half_n = 0.5 * self.mass_kg * GRAVITY_M_S2;
        let shift_n = shift_n.clamp(-0.9 * half_n, 0.9 * half_n);
        [half_n + shift_n, half_n - shift_n, 0.0, 0.0]
    }

    fn on_bogies(&mut self, bogies: &Bogies, push: &Push<'_>, step_s: f64) -> PerWheelset {
        let inertia_n = bogies.mass_kg * push.acceleration_m_s2;
        let pivot_n: [f64; 2] =
            std::array::from_fn(|j| push.contact_n[2 * j] + push.contact_n[2 * j + 1] - inertia_n);
        let above_pivot_m = self.body_height_m - bogies.pivot_height_m;
        let moment_nm = -above_pivot_m * (pivot_n[0] + pivot_n[1])
            + (self.coupler_height_m - self.body_height_m) * push.coupler_n;
        let shift_n = self.carried(moment_nm, step_s) / self.base_m;
        let half_n = 0.5 * self.mass_kg * GRAVITY_M_S2;
        let mut loads = [0.0; 4];
        for j in 0..2 {
            let moment_nm = -bogies.pivot_height_m * pivot_n[j]
                - FRAME_HEIGHT_M * inertia_n
                - push.spin_nm[2 * j]
                - push.spin_nm[2 * j + 1];
            self.frame_nm[j] += step_s / (FRAME_LAG_S + step_s) * (moment_nm - self.frame_nm[j]);
            let on_bogie_n = if j == 0 { half_n + shift_n } else { half_n - shift_n };
            let within_n =
                (self.frame_nm[j] / bogies.wheelbase_m).clamp(-0.45 * on_bogie_n, 0.45 * on_bogie_n);
            loads[2 * j] = 0.5 * on_bogie_n + within_n;
            loads[2 * j + 1] = 0.5 * on_bogie_n - within_n;
        }
        loads
    }

    /// The moment that the body's springs and dampers carry while the body answers to `moment_nm` (nose down positive).
    fn carried(&mut self, moment_nm: f64, step_s: f64) -> f64 {
        let (frequency, damping) = self.body;
        let pull = frequency * frequency * (moment_nm - self.moment_nm)
            - 2.0 * damping * frequency * self.moment_rate;
        self.moment_rate += step_s * pull;
        self.moment_nm += step_s * self.moment_rate;
        self.moment_nm + 2.0 * damping / frequency * self.moment_rate
    }
}
