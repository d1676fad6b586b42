//! What arrives, and whether the filter expected it.

use super::Observed;
use railgrip_messages::{Estimate, Sample, valid};

/// A sample counts no more than this in the mean of innovations: a single value far off is a matter of the filter's gate and of the
/// sensors, and not of the model (hand-set).
const MOST_OF_A_SAMPLE: f64 = 25.0;

impl Observed {
    pub(super) fn count_sensors(&mut self, sample: &Sample, estimate: &Estimate, dt_s: f64) {
        let mut expected = valid::SPEED;
        for wheelset in 0..sample.wheelset_count() {
            expected |= valid::wheel_speed(wheelset) | valid::pressing_force(wheelset);
        }
        let count = f64::from(expected.count_ones());
        let missing = f64::from((expected & !sample.valid).count_ones()) / count;
        let rejected = estimate.rejected.count_ones();
        self.state.rejected += u64::from(rejected);
        // What the filter refuses on a coupled wagon is what couplers did, which it does not know of, and no sensor's fault.
        let rejected = if self.nominal.coupled { 0 } else { rejected };
        let estimate = Estimate { rejected: if rejected == 0 { 0 } else { estimate.rejected }, ..*estimate };
        let memory_s = self.settings.sensors.memory_s;
        self.state.missing.add(dt_s, missing, memory_s);
        self.state.refused.add(dt_s, f64::from(rejected) / count, memory_s);
        let braking = self.state.wheelset.iter().any(|wheelset| wheelset.since_demand_s <= 1.0);
        let radius_m = self.nominal.wheel_radius_m;
        let dead = self.state.sensors.add(dt_s.max(0.0), sample, &estimate, radius_m, braking, memory_s);
        self.state.dead.add(dt_s.max(0.0), dead, memory_s);
        let judged = estimate.v_m_s.abs() >= self.settings.filter.min_speed_m_s;
        if judged && estimate.nis_dof > 0 && estimate.nis.is_finite() {
            let most = MOST_OF_A_SAMPLE.max(2.0 * self.settings.filter.nis_act_high);
            let ratio = (estimate.nis / f64::from(estimate.nis_dof)).min(most);
            self.state.nis.add(dt_s, ratio, self.settings.filter.memory_s);
        }
    }
}
