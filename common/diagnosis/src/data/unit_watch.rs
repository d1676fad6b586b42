//! Whether the columns of a live source can be in their units: the checks of [`units`] over the latest seconds of a wagon.

use super::units::{self, UnitError};
use railgrip_recording::{MAX_WHEELSETS, Optional, Recording, Row};
use railgrip_vehicle::VehicleParameters;
use std::collections::VecDeque;

/// Rows are kept this far apart, s: enough for ratios of speeds and for brake applications.
const STEP_S: f64 = 0.05;
/// So many seconds are judged, and no fewer than the second figure.
const KEPT_S: f64 = 30.0;
const LEAST_S: f64 = 15.0;
/// Speeds that are steadily wrong show after this time already, s.
const EARLY_S: f64 = 2.0;
/// Time between two looks, s: at first, and later.
const LOOKS_S: [f64; 2] = [0.5, 5.0];
/// Later the latest seconds are looked at by themselves, too: good rows before them would hide a unit that has changed.
const LATEST_S: f64 = 4.0;
const LATEST_LOOKS_S: f64 = 1.0;

/// The latest seconds of one wagon, and what they gave away.
#[derive(Debug)]
pub struct UnitWatch {
    vehicle: VehicleParameters,
    rows: VecDeque<Row>,
    looked_s: f64,
    looked_at_latest_s: f64,
    implausible: bool,
    /// It was the forces that gave the columns away.
    of_forces: bool,
}

impl UnitWatch {
    /// Nothing has come of this vehicle yet.
    #[must_use]
    pub fn new(vehicle: VehicleParameters) -> Self {
        Self {
            vehicle,
            rows: VecDeque::new(),
            looked_s: f64::NEG_INFINITY,
            looked_at_latest_s: f64::NEG_INFINITY,
            implausible: false,
            of_forces: false,
        }
    }

    /// True while the columns cannot be in their units.
    #[must_use]
    pub fn implausible(&self) -> bool {
        self.implausible
    }

    /// Forgets what belongs to another time base.
    pub fn begin(&mut self) {
        self.rows.clear();
        (self.looked_s, self.looked_at_latest_s) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    }

    /// Takes a row; gives a change of mind: what gives the columns away, or nothing once they are plausible again.
    pub fn take(&mut self, row: &Row, wheelsets: usize) -> Option<Option<String>> {
        if self.rows.back().is_some_and(|last| row.t_s - last.t_s < STEP_S) {
            return None;
        }
        let mut row = *row;
        // A trailer has no drive torques.
        row.drive_torque_nm = row.drive_torque_nm.map(|torque| if torque.is_nan() { 0.0 } else { torque });
        self.rows.push_back(row);
        while self.rows.front().is_some_and(|first| row.t_s - first.t_s > KEPT_S) {
            self.rows.pop_front();
        }
        let kept_s = self.rows.front().map_or(0.0, |first| row.t_s - first.t_s);
        let long = kept_s >= LEAST_S;
        if kept_s < EARLY_S {
            return None;
        }
        let found = if row.t_s - self.looked_s >= LOOKS_S[usize::from(long)] {
            (self.looked_s, self.looked_at_latest_s) = (row.t_s, row.t_s);
            let all = self.judge(
                wheelsets,
                f64::NEG_INFINITY,
                if long { units::check } else { units::check_early },
            );
            all.or_else(|| self.judge(wheelsets, row.t_s - LATEST_S, units::check_early))
        } else if long && !self.implausible && row.t_s - self.looked_at_latest_s >= LATEST_LOOKS_S {
            self.looked_at_latest_s = row.t_s;
            let latest = self.judge(wheelsets, row.t_s - LATEST_S, units::check_early);
            latest.as_ref()?;
            latest
        } else {
            return None;
        };
        // A wagon that stands shows nothing: what was wrong is wrong until the contrary is seen.
        if found.is_none() && self.implausible && !self.shows_units(wheelsets, row.t_s - LATEST_S) {
            return None;
        }
        if let Some(why) = &found {
            self.of_forces = why.contains("f_perp") || why.contains("force");
        }
        let changed = found.is_some() != self.implausible;
        self.implausible = found.is_some();
        changed.then_some(found)
    }

    /// Whether the latest rows show that the columns are in their units; of forces all rows, since a brake presses now and then.
    fn shows_units(&self, wheelsets: usize, latest_s: f64) -> bool {
        let from_s = if self.of_forces { f64::NEG_INFINITY } else { latest_s };
        units::are_shown(&self.recording(wheelsets, from_s), &self.vehicle, self.of_forces)
    }

    fn recording(&self, wheelsets: usize, from_s: f64) -> Recording {
        let mut recording = Recording::empty("live", None, wheelsets.min(MAX_WHEELSETS), Optional::NONE);
        self.rows.iter().filter(|row| row.t_s >= from_s).for_each(|row| recording.push(row));
        recording
    }

    fn judge(
        &self,
        wheelsets: usize,
        from_s: f64,
        check: fn(&Recording, &VehicleParameters) -> Result<(), UnitError>,
    ) -> Option<String> {
        let recording = self.recording(wheelsets, from_s);
        check(&recording, &self.vehicle).err().map(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wagon in km/h once was served again as soon as it stood.
    #[test]
    fn what_stands_is_not_plausible_again() {
        let vehicle: VehicleParameters =
            toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("a vehicle");
        let radius_m = vehicle.wheelset.radius_m;
        let mut watch = UnitWatch::new(vehicle);
        let told: Vec<(f64, bool)> = (0..12_000)
            .filter_map(|k| {
                let t_s = f64::from(k) * 0.01;
                let v = if t_s < 20.0 { 20.0 } else { 0.0 };
                let mut row = Row { t_s, v_m_s: 3.6 * v, ..Row::default() };
                row.wheel_speed_rad_s = [v / radius_m; MAX_WHEELSETS];
                watch.take(&row, 2).map(|change| (t_s, change.is_some()))
            })
            .collect();
        println!("{told:?}");
        assert!(told.len() == 1 && told[0].1 && watch.implausible());
    }

    /// After twenty good seconds, speeds in km/h once were live for as long again.
    #[test]
    fn a_unit_that_changes_during_a_run_shows_soon() {
        let vehicle: VehicleParameters =
            toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("a vehicle");
        let radius_m = vehicle.wheelset.radius_m;
        let mut watch = UnitWatch::new(vehicle);
        let mut told = Vec::new();
        for k in 0..6000 {
            let t_s = f64::from(k) * 0.01;
            let kmh = (20.0..45.0).contains(&t_s);
            let mut row = Row { t_s, v_m_s: if kmh { 72.0 } else { 20.0 }, ..Row::default() };
            row.wheel_speed_rad_s = [20.0 / radius_m; MAX_WHEELSETS];
            if let Some(change) = watch.take(&row, 2) {
                told.push((t_s, change.is_some()));
            }
        }
        println!("{told:?}");
        let [(shown_s, true), (again_s, false)] = told[..] else { panic!("{told:?}") };
        assert!((22.0..27.0).contains(&shown_s) && (47.0..80.0).contains(&again_s));
    }

    /// A wagon that brakes now and then, its forces multiplied.
    fn told(factor: f64) -> Vec<(f64, Option<String>)> {
        let vehicle: VehicleParameters =
            toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("a vehicle");
        let (radius_m, mass_kg) = (vehicle.wheelset.radius_m, vehicle.body.mass_kg);
        let pads: Vec<f64> = vehicle.pad_friction().to_vec();
        let lever = vehicle.brake.radius_m / radius_m / mass_kg;
        let mut watch = UnitWatch::new(vehicle);
        let (mut v, mut told) = (30.0_f64, Vec::new());
        for k in 0..9000 {
            let t_s = f64::from(k) * 0.01;
            let pressed =
                (20.0 * (t_s % 30.0 - 8.0)).clamp(0.0, 60.0) * f64::from(u8::from(t_s % 30.0 < 20.0)) / 60.0;
            let force = 6e4 * pressed;
            v = (v - 0.01 * pads.iter().take(2).map(|pad| pad * lever * force).sum::<f64>()).max(0.0);
            let mut row = Row { t_s, v_m_s: v, ..Row::default() };
            row.wheel_speed_rad_s = [v / radius_m; MAX_WHEELSETS];
            row.pressing_force_n = [factor * force; MAX_WHEELSETS];
            told.extend(watch.take(&row, 2).map(|change| (t_s, change)));
        }
        told
    }

    /// Forces a thousand times too large, and negative ones, once were served.
    #[test]
    fn forces_that_cannot_be_are_told_and_right_ones_are_not() {
        assert_eq!(told(1.0), []);
        for (factor, within_s) in [(1e3, 10.0), (-1.0, 10.0), (1e-3, 25.0)] {
            let told = told(factor);
            println!("{factor}: {told:?}");
            let Some((at_s, Some(why))) = told.first() else { panic!("{factor}: {told:?}") };
            assert!(why.contains("f_perp_f_n") && *at_s < 8.0 + within_s, "{factor}: {at_s} s, {why}");
        }
    }
}
