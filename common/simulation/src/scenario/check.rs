//! Ranges of a scenario's values.

use super::{DemandTable, FaultKind, Scenario};
use railgrip_recording::{MAX_WHEELSETS, Quantity};
use std::ops::RangeInclusive;

/// A value that is not allowed.
#[derive(Debug)]
pub(super) struct Refusal {
    pub key: String,
    pub value: String,
    pub allowed: String,
}

type Checked = Result<(), Refusal>;

fn refuse(key: impl Into<String>, value: impl ToString, allowed: impl Into<String>) -> Checked {
    Err(Refusal { key: key.into(), value: value.to_string(), allowed: allowed.into() })
}

fn within(key: &str, value: f64, range: RangeInclusive<f64>) -> Checked {
    match range.contains(&value) {
        true => Ok(()),
        false => refuse(key, value, format!("{} to {}", range.start(), range.end())),
    }
}

/// Whether `after` is a number beyond `before`.
fn rises(before: f64, after: f64) -> bool {
    after > before && after.is_finite()
}

/// Most wagons of a simulated train.
const MAX_WAGONS: usize = 256;

impl Scenario {
    pub(super) fn check(&self) -> Checked {
        if self.schema != 1 {
            return refuse("schema", self.schema, "1");
        }
        within("duration_s", self.duration_s, 1.0..=1e6)?;
        if let Some(repeat_s) = self.repeat_s {
            within("repeat_s", repeat_s, 1.0..=1e6)?;
        }
        within("start_speed_m_s", self.start_speed_m_s, 0.0..=150.0)?;
        if !(1..=MAX_WAGONS).contains(&self.train.wagons) {
            return refuse("train.wagons", self.train.wagons, format!("1 to {MAX_WAGONS}"));
        }
        within("train.wagon_length_m", self.train.wagon_length_m, 5.0..=60.0)?;
        self.check_demands()?;
        self.check_equipment()?;
        self.check_wsp()?;
        self.check_track()?;
        self.check_chance()?;
        self.check_wagons()?;
        self.check_faults()
    }

    fn check_demands(&self) -> Checked {
        match self.demand.first() {
            None => return refuse("demand", "empty", "at least one [[demand]]"),
            Some(first) if first.from_s != 0.0 => {
                return refuse("demand.1.from_s", first.from_s, "0 in the first");
            }
            Some(_) => {}
        }
        for (index, demand) in self.demand.iter().enumerate() {
            let key = |name: &str| format!("demand.{}.{name}", index + 1);
            if index > 0 && !rises(self.demand[index - 1].from_s, demand.from_s) {
                return refuse(key("from_s"), demand.from_s, "later than the one before");
            }
            check_one_demand(demand, &key)?;
        }
        Ok(())
    }

    fn check_equipment(&self) -> Checked {
        let (traction, brake) = (&self.traction, &self.brake);
        within("traction.acceleration_m_s2", traction.acceleration_m_s2, 0.0..=3.0)?;
        within("traction.full_power_speed_m_s", traction.full_power_speed_m_s, 1.0..=150.0)?;
        within("traction.response_time_s", traction.response_time_s, 0.01..=20.0)?;
        within("brake.full_service_deceleration_m_s2", brake.full_service_deceleration_m_s2, 0.05..=5.0)?;
        within("brake.full_pressure_pa", brake.full_pressure_pa, 1e5..=2e6)?;
        within("brake.spring_pressure_pa", brake.spring_pressure_pa, 0.0..=0.5 * brake.full_pressure_pa)?;
        within("brake.propagation_speed_m_s", brake.propagation_speed_m_s, 10.0..=1e9)?;
        within("brake.dead_time_s", brake.dead_time_s, 0.0..=10.0)?;
        within("brake.fill_time_s", brake.fill_time_s, 0.01..=60.0)?;
        within("brake.vent_time_s", brake.vent_time_s, 0.01..=60.0)?;
        match &self.couplers {
            Some(couplers) => {
                within("couplers.stiffness_n_per_m", couplers.stiffness_n_per_m, 0.0..=1e8)?;
                within("couplers.damping_n_s_per_m", couplers.damping_n_s_per_m, 0.0..=1e7)
            }
            None => Ok(()),
        }
    }

    fn check_wsp(&self) -> Checked {
        let wsp = &self.wsp;
        within("wsp.hold_slip", wsp.hold_slip, 0.005..=0.5)?;
        within("wsp.vent_slip", wsp.vent_slip, wsp.hold_slip..=0.9)?;
        within("wsp.rim_deceleration_m_s2", wsp.rim_deceleration_m_s2, 1.0..=50.0)?;
        within("wsp.minimum_speed_m_s", wsp.minimum_speed_m_s, 0.0..=10.0)?;
        within("wsp.valve_dead_time_s", wsp.valve_dead_time_s, 0.0..=0.5)?;
        within("wsp.valve_vent_time_s", wsp.valve_vent_time_s, 0.005..=5.0)?;
        within("wsp.valve_fill_time_s", wsp.valve_fill_time_s, 0.005..=5.0)?;
        within("wsp.apply_pulse_s", wsp.apply_pulse_s, 0.01..=5.0)?;
        within("wsp.apply_pause_s", wsp.apply_pause_s, 0.0..=5.0)
    }

    fn check_track(&self) -> Checked {
        let track = &self.track;
        within("track.transition_m", track.transition_m, 0.0..=1e4)?;
        within("track.adhesion_variation", track.adhesion_variation, 0.0..=0.5)?;
        within("track.variation_length_m", track.variation_length_m, 0.5..=1e4)?;
        within("track.sanding_gain", track.sanding_gain, 0.0..=10.0)?;
        within("track.sanding_time_s", track.sanding_time_s, 0.01..=60.0)?;
        within("track.headwind_m_s", track.headwind_m_s, -40.0..=40.0)?;
        within("track.friction_ratio", track.friction_ratio.unwrap_or(1.0), 0.05..=1.0)?;
        within("track.friction_decay_s_per_m", track.friction_decay_s_per_m.unwrap_or(0.0), 0.0..=10.0)?;
        for (index, rail) in self.rail.iter().enumerate() {
            let key = |name: &str| format!("rail.{}.{name}", index + 1);
            within(&key("from_m"), rail.from_m, -1e7..=1e7)?;
            if index > 0 && !rises(self.rail[index - 1].from_m, rail.from_m) {
                return refuse(key("from_m"), rail.from_m, "further along than the one before");
            }
            if let Some(adhesion) = rail.adhesion {
                within(&key("adhesion"), adhesion, 1e-3..=1.0)?;
            }
        }
        for (index, grade) in self.grade.iter().enumerate() {
            let key = |name: &str| format!("grade.{}.{name}", index + 1);
            within(&key("from_m"), grade.from_m, -1e7..=1e7)?;
            if index > 0 && !rises(self.grade[index - 1].from_m, grade.from_m) {
                return refuse(key("from_m"), grade.from_m, "further along than the one before");
            }
            within(&key("grade_rad"), grade.grade_rad, -0.2..=0.2)?;
        }
        Ok(())
    }

    fn check_chance(&self) -> Checked {
        let (slow, sensors) = (&self.disturbance, &self.sensors);
        within("disturbance.pad_friction_sigma", slow.pad_friction_sigma, 0.0..=0.2)?;
        within("disturbance.pad_friction_time_s", slow.pad_friction_time_s, 0.1..=1e5)?;
        within("disturbance.pad_friction_spread", slow.pad_friction_spread, 0.0..=0.3)?;
        within("disturbance.gust_sigma_m_s", slow.gust_sigma_m_s, 0.0..=20.0)?;
        within("disturbance.gust_time_s", slow.gust_time_s, 0.1..=1e5)?;
        within("sensors.noise_factor", sensors.noise_factor, 0.0..=100.0)?;
        within("sensors.speed_latency_s", sensors.speed_latency_s, 0.0..=2.0)?;
        within("sensors.wheel_speed_latency_s", sensors.wheel_speed_latency_s, 0.0..=2.0)?;
        within("sensors.pressing_force_latency_s", sensors.pressing_force_latency_s, 0.0..=2.0)?;
        within("sensors.speed_resolution_m_s", sensors.speed_resolution_m_s, 0.0..=10.0)?;
        within("sensors.wheel_speed_resolution_rad_s", sensors.wheel_speed_resolution_rad_s, 0.0..=50.0)?;
        within("sensors.pressing_force_resolution_n", sensors.pressing_force_resolution_n, 0.0..=1e5)?;
        within("sensors.position_sigma_m", sensors.position_sigma_m, 0.0..=1e3)?;
        within("sensors.position_bias_sigma_m", sensors.position_bias_sigma_m, 0.0..=1e3)?;
        within("sensors.position_bias_time_s", sensors.position_bias_time_s, 0.1..=1e6)?;
        within("sensors.missing_probability", sensors.missing_probability, 0.0..=1.0)?;
        within("sensors.spike_probability", sensors.spike_probability, 0.0..=1.0)?;
        within("sensors.spike_sigmas", sensors.spike_sigmas, 0.0..=1e6)
    }

    fn check_wagons(&self) -> Checked {
        for (index, wagon) in self.wagon.iter().enumerate() {
            let key = |name: &str| format!("wagon.{}.{name}", index + 1);
            if !(1..=MAX_WAGONS).contains(&wagon.number) {
                return refuse(key("number"), wagon.number, format!("1 to {MAX_WAGONS}"));
            }
            if self.wagon[..index].iter().any(|other| other.number == wagon.number) {
                return refuse(key("number"), wagon.number, "each number once");
            }
            within(&key("adhesion_factor"), wagon.adhesion_factor, 0.01..=10.0)?;
            within(&key("mass_factor"), wagon.mass_factor, 0.2..=5.0)?;
            within(&key("brake_delay_s"), wagon.brake_delay_s, 0.0..=60.0)?;
            within(&key("fill_time_factor"), wagon.fill_time_factor, 0.1..=50.0)?;
            within(&key("dragging_force_n"), wagon.dragging_force_n, 0.0..=1e6)?;
            for number in &wagon.isolated_wheelsets {
                if !(1..=MAX_WHEELSETS).contains(number) {
                    return refuse(key("isolated_wheelsets"), number, format!("1 to {MAX_WHEELSETS}"));
                }
            }
            if wagon.pad_friction_factors.len() > MAX_WHEELSETS {
                return refuse(
                    key("pad_friction_factors"),
                    wagon.pad_friction_factors.len(),
                    "at most 4 values",
                );
            }
            for factor in &wagon.pad_friction_factors {
                within(&key("pad_friction_factors"), *factor, 0.0..=3.0)?;
            }
        }
        Ok(())
    }

    fn check_faults(&self) -> Checked {
        for (index, fault) in self.fault.iter().enumerate() {
            let key = |name: &str| format!("fault.{}.{name}", index + 1);
            if !(1..=MAX_WAGONS).contains(&fault.wagon) {
                return refuse(key("wagon"), fault.wagon, format!("1 to {MAX_WAGONS}"));
            }
            if !rises(fault.from_s, fault.until_s) {
                return refuse(key("until_s"), fault.until_s, "later than from_s");
            }
            match (&fault.signal, fault.kind) {
                (Some(signal), FaultKind::Silent) => {
                    return refuse(key("signal"), signal, "no signal when silent");
                }
                (None, FaultKind::Silent) => {}
                (None, _) => return refuse(key("signal"), "absent", "a column such as omega_f_rad_s"),
                (Some(signal), _) if signal_of(signal).is_none() => {
                    return refuse(
                        key("signal"),
                        signal,
                        "a column of a recording other than t_s, such as omega_f_rad_s",
                    );
                }
                (Some(_), _) => {}
            }
        }
        Ok(())
    }
}

fn check_one_demand(demand: &DemandTable, key: &dyn Fn(&str) -> String) -> Checked {
    let given =
        [demand.traction.is_some(), demand.brake.is_some(), demand.cruise_m_s.is_some(), demand.coast];
    if given.iter().filter(|given| **given).count() != 1 {
        return refuse(
            key("from_s"),
            demand.from_s,
            "a phase with exactly one of traction, brake, cruise_m_s and coast = true",
        );
    }
    within(&key("traction"), demand.traction.unwrap_or_default(), 0.0..=1.0)?;
    within(&key("brake"), demand.brake.unwrap_or_default(), 0.0..=1.0)?;
    within(&key("cruise_m_s"), demand.cruise_m_s.unwrap_or_default(), 0.0..=150.0)?;
    within(&key("sanding"), demand.sanding, 0.0..=1.0)
}

/// The quantity and wheelset of a column name, for two wheelsets or numbered.
pub(crate) fn signal_of(name: &str) -> Option<(Quantity, usize)> {
    for wheelsets in [2, MAX_WHEELSETS] {
        for quantity in Quantity::ALL.into_iter().filter(|quantity| *quantity != Quantity::Time) {
            let found = (0..wheelsets).find(|wheelset| quantity.column(*wheelset, wheelsets) == name);
            if let Some(wheelset) = found {
                return Some((quantity, wheelset));
            }
        }
    }
    None
}
