//! Long recordings: how much of them is fitted.

use crate::data::case::{Case, Run};

impl Case {
    /// The case with no more than `longest_s` of recordings to fit on, s: of each run its beginning, short ones whole and all others
    /// equally long. `None` where there is no more. A fit keeps errors and slopes of every sample for each candidate, so that
    /// a day of recordings would need more memory than a computer has.
    ///
    /// Beginnings, because what a run did before (heat in the discs, a film on the rail) acts on all that follows.
    pub fn within(&self, longest_s: f64) -> Option<Self> {
        let recorded_s: f64 = self.fit.iter().map(Run::duration_s).sum();
        if recorded_s <= longest_s {
            return None;
        }
        let each_s = level(self.fit.iter().map(Run::duration_s).collect(), longest_s);
        let fit = self.fit.iter().map(|run| run.beginning(each_s)).collect();
        let note = format!(
            "the runs to fit on last {recorded_s:.0} s; of each the first {each_s:.0} s are used, {longest_s:.0} s in all: cut out what \
             matters most where it comes later"
        );
        let notes = self.notes.iter().cloned().chain([note]).collect();
        Some(Self {
            vehicle: self.vehicle.clone(),
            fit,
            holdout: self.holdout.clone(),
            noise: self.noise,
            notes,
        })
    }
}

/// The longest that each may be so that together they are as long as `whole`, which all of them exceed.
fn level(mut lengths: Vec<f64>, whole: f64) -> f64 {
    lengths.sort_by(f64::total_cmp);
    let mut left = whole;
    for (k, length) in lengths.iter().enumerate() {
        let share = left / (lengths.len() - k) as f64;
        if *length >= share {
            return share;
        }
        left -= length;
    }
    left
}

impl Run {
    /// How long it is, s.
    pub fn duration_s(&self) -> f64 {
        self.len() as f64 * self.dt_s
    }

    /// Its first `longest_s`, s.
    fn beginning(&self, longest_s: f64) -> Self {
        let count = ((longest_s / self.dt_s) as usize).min(self.len());
        let unbroken = self.unbroken.iter().map(|range| range.start..range.end.min(count));
        Self {
            samples: self.samples[..count].to_vec(),
            t_s: self.t_s[..count].to_vec(),
            unbroken: unbroken.filter(|range| !range.is_empty()).collect(),
            name: self.name.clone(),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::case::Columns;
    use crate::data::noise::SensorNoise;
    use railgrip_vehicle::{RailClass, VehicleParameters};

    /// A run at 10 m/s, 10 samples a second; nothing is measured in its sixth second.
    fn run(name: &str, seconds: usize) -> Run {
        let count = 10 * seconds;
        let steady = |value: f64| vec![value; count];
        let speed = (0..count).map(|k| if (50..60).contains(&k) { f64::NAN } else { 10.0 }).collect();
        let columns = Columns {
            t_s: (0..count).map(|k| 0.1 * k as f64).collect(),
            v_m_s: speed,
            wheel_speed_rad_s: vec![steady(20.0); 2],
            pressing_force_n: vec![steady(0.0); 2],
            drive_torque_nm: vec![steady(0.0); 2],
            ..Columns::default()
        };
        Run::new(name.to_owned(), RailClass::Dry, &columns)
    }

    fn case() -> Case {
        let vehicle: VehicleParameters =
            toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("a vehicle");
        let fit = vec![run("short", 5), run("long", 100), run("longer", 300)];
        let noise = SensorNoise::of_file(&vehicle.sensors);
        Case { vehicle, fit, holdout: vec![run("predicted", 200)], noise, notes: vec!["a note".to_owned()] }
    }

    #[test]
    fn short_runs_stay_whole_and_long_ones_share_the_rest() {
        let case = case();
        assert!(case.within(405.0).is_none());
        let cut = case.within(65.0).expect("too long");
        assert_eq!(cut.fit.iter().map(Run::len).collect::<Vec<_>>(), [50, 300, 300]);
        assert_eq!(cut.holdout[0].len(), 2000, "what is predicted stays");
        assert_eq!(cut.fit[2].unbroken, [0..50, 60..300]);
        assert_eq!(cut.fit[2].t_s.last(), case.fit[2].t_s.get(299));
        assert_eq!(
            cut.notes,
            [
                "a note",
                "the runs to fit on last 405 s; of each the first 30 s are used, 65 s in all: cut out what matters most where it comes later"
            ]
        );
    }
}
