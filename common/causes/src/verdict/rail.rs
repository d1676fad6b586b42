//! Slides: the rail, and a slide protection that does nothing about them.

use super::limits::{SLIDING_WHEELSETS, STUCK_S};
use crate::cause::{Cause, Grade};
use crate::watch::TrainWatch;

impl TrainWatch {
    /// Looks at slides while they last.
    pub(crate) fn judge_slides(&mut self) {
        let mut sliding = Vec::new();
        for index in 0..self.wagons.len() {
            for k in 0..self.wagons[index].wheel.len() {
                if self.wagons[index].wheel[k].slid_ago_s < 5.0 && self.trusts(index, k) {
                    sliding.push((index, k));
                }
            }
        }
        for (index, k) in &sliding {
            let stuck_s = self.wagons[*index].wheel[*k].stuck_s;
            if stuck_s > STUCK_S {
                let reason = format!("slid deeply for {stuck_s:.0} s while its pressing force stayed");
                let how = (Grade::Act, 0.9, 1);
                self.suspect(Cause::WspValve, (*index, vec![*k]), how, &[], reason);
            }
        }
        if sliding.len() >= SLIDING_WHEELSETS {
            let reason = format!("{} wheelsets slide while the train brakes", sliding.len());
            self.suspect_wagons(Cause::LowAdhesion, (vec![], vec![]), (Grade::Watch, 0.93, 2), &[], reason);
        }
    }
}
