//! Slides and slide protection, with what is told of them.

use super::{Observed, STANDSTILL_M_S};
use crate::measure::slides::{Change, Motion};
use railgrip_messages::{Estimate, Event, EventKind, Sample, valid};

/// A wheelset can only slide while it brakes or drives, and for so long after that, s; what looks like a slide otherwise
/// is an error of a wheel's radius or of a sensor.
const SLIDE_NEEDS_DEMAND_S: f64 = 2.0;
/// What a wheelset does whose speed has been missing for so long, s, is the model's guess: it is not seen to slide.
const SLIDE_NEEDS_SPEED_S: f64 = 0.5;
/// A wheelset drives from this torque on, N m.
const DRIVES_FROM_NM: f64 = 200.0;

impl Observed {
    pub(super) fn demand(&mut self, wheelset: usize, sample: &Sample, estimate: &Estimate, dt_s: f64) {
        let brakes = estimate.pressing_force_n[wheelset] >= self.settings.brake_friction.min_pressing_force_n;
        let drives = sample.drive_torque_nm[wheelset].abs() >= DRIVES_FROM_NM;
        let protected = estimate.wsp_active & (1 << wheelset) != 0;
        let since_s = &mut self.state.wheelset[wheelset].since_demand_s;
        *since_s = if brakes || drives || protected { 0.0 } else { *since_s + dt_s };
    }

    /// True if the filter says that the wheelset slides or spins, and it can and is seen to.
    pub(crate) fn slides(&self, wheelset: usize, estimate: &Estimate) -> bool {
        estimate.sliding & (1 << wheelset) != 0
            && estimate.v_m_s > STANDSTILL_M_S
            && self.state.wheelset[wheelset].since_demand_s <= SLIDE_NEEDS_DEMAND_S
            && self.unmeasured_s[wheelset] <= SLIDE_NEEDS_SPEED_S
    }

    pub(super) fn slide(
        &mut self,
        wheelset: usize,
        estimate: &Estimate,
        dt_s: f64,
        event: &mut dyn FnMut(Event),
    ) {
        let motion = Motion {
            v_m_s: estimate.v_m_s,
            creepage: estimate.slip[wheelset],
            utilised: estimate.mu_w_wheelset[wheelset].abs(),
            normal_load_n: estimate.normal_load_n[wheelset],
            sliding: self.slides(wheelset, estimate),
        };
        let settings = &self.settings.slides;
        let slides = &mut self.state.wheelset[wheelset].slides;
        let change = slides.add(dt_s, motion, settings.min_duration_s, settings.memory_s);
        self.tell_slide(wheelset, estimate, change, event);
    }

    pub(super) fn roundness(&mut self, wheelset: usize, sample: &Sample, estimate: &Estimate, dt_s: f64) {
        let rolls = (estimate.sliding | estimate.wsp_active) & (1 << wheelset) == 0;
        let present = sample.has(valid::wheel_speed(wheelset));
        let speed_rad_s = present.then(|| sample.wheel_speed_rad_s[wheelset]);
        let memory_s = self.settings.wheel_flat.memory_s;
        let roundness = &mut self.state.wheelset[wheelset].roundness;
        roundness.add(dt_s, speed_rad_s, estimate.v_m_s, rolls, memory_s);
    }

    pub(super) fn tell_slide(
        &self,
        wheelset: usize,
        estimate: &Estimate,
        change: Option<Change>,
        event: &mut dyn FnMut(Event),
    ) {
        match change {
            None => {}
            Some(Change::Began) => {
                let text = format!("slides at {:.0} km/h", 3.6 * estimate.v_m_s);
                event(self.event(
                    EventKind::SlideBegan,
                    wheelset as u32,
                    estimate,
                    [estimate.v_m_s, 0.0, 0.0, 0.0],
                    &text,
                ));
            }
            Some(Change::Ended(slide)) => {
                let values = [slide.seconds, slide.energy_j, slide.creepage, slide.utilised];
                let text = format!("slid for {:.1} s, {:.0} kJ", slide.seconds, slide.energy_j * 1e-3);
                event(self.event(EventKind::SlideEnded, wheelset as u32, estimate, values, &text));
            }
        }
    }

    pub(super) fn wsp(
        &mut self,
        wheelset: usize,
        sample: &Sample,
        estimate: &Estimate,
        dt_s: f64,
        event: &mut dyn FnMut(Event),
    ) {
        let active = estimate.wsp_active & (1 << wheelset) != 0;
        let value = f64::from(u8::from(active));
        let least_n = self.settings.brake_friction.min_pressing_force_n;
        let brakes = estimate.pressing_force_n[wheelset] >= least_n || active;
        let memory_s = self.settings.wsp.memory_s;
        let low = self.state.rail_is_low == 1;
        let state = &mut self.state.wheelset[wheelset];
        let changed = state.wsp_was_active != value;
        state.wsp_was_active = value;
        if brakes && estimate.v_m_s > STANDSTILL_M_S {
            state.wsp.add(dt_s, value, memory_s);
            if !low {
                state.wsp_elsewhere.add(dt_s, value, memory_s);
            }
            if wheelset == 0 {
                let any = f64::from(u8::from(estimate.wsp_active != 0));
                self.state.wsp.add(dt_s, any, memory_s);
                if !low {
                    self.state.wsp_elsewhere.add(dt_s, any, memory_s);
                }
            }
        }
        if changed && sample.has(valid::WSP) {
            let (kind, text) = if active {
                (EventKind::WspBegan, "slide protection acts")
            } else {
                (EventKind::WspEnded, "slide protection rests")
            };
            event(self.event(kind, wheelset as u32, estimate, [0.0; 4], text));
        }
    }
}
