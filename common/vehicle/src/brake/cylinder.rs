//! Brake cylinder: pressure follows the demand with a fill or vent time and a limited rate.

/// A brake cylinder with first-order filling and venting.
///
/// UIC 540 gives 3–5 s to fill to 95 % in position P; a first-order lag reaches 95 % after three time constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakeCylinder {
    /// Time constant while pressure rises, s.
    pub fill_time_s: f64,
    /// Time constant while pressure falls, s.
    pub vent_time_s: f64,
    /// Pressure at full service braking, Pa.
    pub full_pressure_pa: f64,
    /// Pressing force of one wheelset at full pressure, N.
    pub full_pressing_force_n: f64,
    /// Pressure below which the return spring holds the pads off, Pa.
    pub spring_pressure_pa: f64,
}

impl BrakeCylinder {
    /// Pressure after `dt_s` from `pressure_pa` under a constant demand, Pa (exact for the first-order lag).
    pub fn step(&self, pressure_pa: f64, demand_pa: f64, dt_s: f64) -> f64 {
        let time = if demand_pa > pressure_pa { self.fill_time_s } else { self.vent_time_s };
        demand_pa + (pressure_pa - demand_pa) * (-dt_s / time).exp()
    }

    /// Pressing force of one wheelset at this cylinder pressure, N, never negative.
    pub fn pressing_force_n(&self, pressure_pa: f64) -> f64 {
        let span = self.full_pressure_pa - self.spring_pressure_pa;
        self.full_pressing_force_n * ((pressure_pa - self.spring_pressure_pa) / span).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::BrakeCylinder;

    const CYLINDER: BrakeCylinder = BrakeCylinder {
        fill_time_s: 1.2,
        vent_time_s: 0.8,
        full_pressure_pa: 3.8e5,
        full_pressing_force_n: 9e4,
        spring_pressure_pa: 3e4,
    };

    #[test]
    fn fills_to_95_percent_in_three_time_constants() {
        let pressure = (0..360).fold(0.0, |p, _| CYLINDER.step(p, 3.8e5, 0.01));
        assert!((pressure / 3.8e5 - 0.95).abs() < 0.002);
    }

    #[test]
    fn spring_holds_the_pads_off() {
        assert_eq!(CYLINDER.pressing_force_n(2e4), 0.0);
        assert!((CYLINDER.pressing_force_n(3.8e5) - 9e4).abs() < 1e-6);
    }
}
