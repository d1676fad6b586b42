//! The indicators of one wagon: what is observed of it, judged by the table.

use crate::indicator::BRAKE_FRICTION;
use crate::nominal::Nominal;
use crate::observed::{IndicatorState, Instant, Observed};
use crate::settings::IndicatorSettings;
use crate::table::{INDICATORS, Table};
use railgrip_messages::{Estimate, Event, Health, Sample, WheelsetHealth};

/// The indicators of one wagon.
#[derive(Debug, Clone)]
pub struct WagonIndicators {
    table: Table,
    observed: Observed,
}

impl WagonIndicators {
    /// Nothing is known yet about wagon number `wagon`.
    #[must_use]
    pub fn new(wagon: u32, settings: IndicatorSettings, nominal: Nominal) -> Self {
        Self::with(INDICATORS, wagon, settings, nominal)
    }

    /// The same by another table.
    #[must_use]
    pub fn with(table: Table, wagon: u32, settings: IndicatorSettings, nominal: Nominal) -> Self {
        Self { table, observed: Observed::new(wagon, settings, nominal) }
    }

    /// Computes and judges by other settings from now on; what was observed so far stays.
    pub fn judge_by(&mut self, settings: IndicatorSettings) {
        self.observed.judge_by(settings);
    }

    /// What a snapshot keeps.
    #[must_use]
    pub const fn state(&self) -> &IndicatorState {
        &self.observed.state
    }

    /// Goes on from a snapshot; `false`, and nothing changes, if it holds no sense.
    pub fn restore(&mut self, state: &IndicatorState) -> bool {
        self.observed.restore(state)
    }

    /// Takes in a sample with its estimate; tells `event` what began and ended.
    pub fn update(&mut self, sample: &Sample, estimate: &Estimate, event: &mut dyn FnMut(Event)) {
        let dt_s = self.observed.update(sample, estimate, event);
        if dt_s <= 0.0 {
            return;
        }
        let Observed { settings, nominal, state, .. } = &mut self.observed;
        for (spec, memory) in self.table.of_wagon().zip(&mut state.memory) {
            if let Some(take) = spec.judge.take {
                take(memory, &Instant { sample, estimate, dt_s, nominal, settings });
            }
        }
    }

    /// The indicators as of the last sample; `published_monotonic_ns` is left to whoever publishes.
    #[must_use]
    pub fn health(&self) -> Health {
        let observed = &self.observed;
        let mut health = present(observed);
        for ((spec, place), memory) in
            self.table.of_wagon().zip(&mut health.indicator).zip(&observed.state.memory)
        {
            if let Some(judge) = spec.judge.wagon {
                *place = judge(observed, memory);
            }
        }
        for (index, wheelset) in health.wheelset[..observed.last.wheelset_count()].iter_mut().enumerate() {
            *wheelset = present_wheelset(observed, index);
            for (spec, place) in self.table.of_wheelset().zip(&mut wheelset.indicator) {
                if let Some(judge) = spec.judge.wheelset {
                    *place = judge(observed, index);
                }
            }
        }
        for index in 0..health.wheelset_count() {
            let friction = self.table.wheelset(&health, index, &BRAKE_FRICTION).value;
            health.wheelset[index].brake_friction_ratio = friction / observed.nominal.brake_friction;
        }
        health.grade = self.table.worst(&health).code();
        health
    }
}

/// What a wagon does now and has counted so far, without a verdict.
fn present(observed: &Observed) -> Health {
    let Observed { state, last, .. } = observed;
    let wheelsets = last.wheelset_count();
    Health {
        sequence: last.sequence,
        acquired: last.acquired,
        time_s: last.time_s,
        wagon: observed.wagon,
        wheelsets: wheelsets as u32,
        condition: observed.condition().code(),
        condition_probability: observed.rail_classes(),
        v_m_s: last.v_m_s,
        mu_w: last.mu_w,
        mu_w_sigma: last.mu_w_sigma,
        mu_b_mean: last.mu_b_mean,
        mu_b_mean_sigma: last.mu_b_mean_sigma,
        position_m: observed.position_m,
        braking_s: state.braking_s,
        samples: state.samples,
        missed: state.missed,
        rejected: state.rejected,
        adhesion_available_is_bound: u32::from(observed.available(&state.wagon).slid.is_none()),
        brake_applied: state.applications.began(),
        brake_applications: state.applications.count,
        pressing_force_n: last.pressing_force_n[..wheelsets].iter().sum(),
        sanding_now: observed.sand,
        faulty_sensors: state.sensors.faulty(wheelsets).fold(0, |bits, faulty| bits | faulty.bit),
        ..Health::default()
    }
}

fn present_wheelset(observed: &Observed, index: usize) -> WheelsetHealth {
    let (state, last) = (&observed.state.wheelset[index], &observed.last);
    let bit = |mask: u32| (mask >> index) & 1;
    WheelsetHealth {
        slide_energy_j: state.slides.energy_j,
        slide_s: state.slides.seconds,
        mu_b: last.mu_b[index],
        mu_b_sigma: last.mu_b_sigma[index],
        mu_w: last.mu_w_wheelset[index],
        mu_w_sigma: last.mu_w_wheelset_sigma[index],
        slip: last.slip[index],
        adhesion_available_is_bound: u32::from(observed.available(&state.rail).slid.is_none()),
        observable: bit(last.observable),
        sliding: u32::from(observed.slides(index, last)),
        wsp_active: bit(last.wsp_active),
        pressing_force_n: last.pressing_force_n[index],
        ..WheelsetHealth::default()
    }
}
