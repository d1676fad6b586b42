//! The indicators of a wagon as they travel: figures, grades and reasons.

use crate::judge::{self, Available};
use crate::judge_brakes;
use crate::mean::{BlockMean, Mean};
use crate::rail_view::RailView;
use crate::slides::Slides;
use crate::wagon::WagonIndicators;
use railgrip_messages::{GRAVITY_M_S2, Grade, Health, Indicator, Text, WheelsetHealth};
use std::cmp::Ordering::Equal;

impl WagonIndicators {
    /// The indicators as of the last sample; `published_monotonic_ns` is left to whoever publishes.
    #[must_use]
    pub fn health(&self) -> Health {
        let (state, last, settings) = (&self.state, &self.last, &self.settings);
        let wheelsets = last.wheelset_count();
        let friction = state.friction.mean();
        let (available, is_bound) = self.available(&state.wagon);
        let (rail, condition) = judge::rail(state.wagon.belief.classes(&self.rail), &settings.adhesion);
        let mut health = Health {
            sequence: last.sequence,
            acquired: last.acquired,
            time_s: last.time_s,
            wagon: self.wagon,
            wheelsets: wheelsets as u32,
            condition: condition.code(),
            condition_probability: state.wagon.belief.classes(&self.rail),
            v_m_s: last.v_m_s,
            mu_w: last.mu_w,
            mu_w_sigma: last.mu_w_sigma,
            mu_b_mean: last.mu_b_mean,
            mu_b_mean_sigma: last.mu_b_mean_sigma,
            position_m: self.position_m,
            braking_s: state.braking_s,
            samples: state.samples,
            missed: state.missed,
            rejected: state.rejected,
            brake_friction: self.brake_friction(&state.friction, friction, "no braking yet"),
            asymmetry: judge::asymmetry(
                state.difference.mean(),
                state.difference.seconds,
                friction,
                &settings.asymmetry,
                settings.brake_friction.min_braking_s,
            ),
            adhesion_utilised: judge::utilised(state.wagon.window.largest(), &settings.adhesion),
            adhesion_available: available,
            rail,
            slides: judge::slides(&self.all_slides(wheelsets), &settings.slides),
            wsp_share: judge::wsp(state.wsp.mean(1.0), state.wsp_elsewhere.mean(1.0), settings),
            sensors: judge::sensors(
                state.missing.mean(0.5),
                state.refused.mean(0.5),
                state.dead.mean(0.5),
                judge_brakes::faulty(state.sensors.faulty(wheelsets)),
                settings,
            ),
            filter: judge::filter(state.nis.mean(0.5), settings),
            adhesion_available_is_bound: u32::from(is_bound),
            brake_friction_standard: self.judge_friction(
                state.standard.mean(self.nominal.brake_friction),
                state.standard.seconds,
                "no braking yet",
            ),
            response: judge_brakes::response(state.applications.response_s(), settings),
            dragging: judge_brakes::dragging(
                state.dragging.drag(),
                self.nominal.mass_kg * GRAVITY_M_S2,
                settings,
            ),
            sanding: judge_brakes::sanding(state.sanding.ratio(), settings),
            model: judge::unknown("watched over longer times by the estimator"),
            brake_applied: state.applications.began(),
            brake_applications: state.applications.count,
            pressing_force_n: last.pressing_force_n[..wheelsets].iter().sum(),
            sanding_now: self.sand,
            faulty_sensors: state.sensors.faulty(wheelsets).fold(0, |bits, faulty| bits | faulty.bit),
            ..Health::default()
        };
        for wheelset in 0..wheelsets {
            health.wheelset[wheelset] = self.wheelset(wheelset);
        }
        health.isolated = self.isolated(&health);
        if state.samples == 0 {
            health.slides = judge::unknown("no samples yet");
        }
        health.grade = worst(&health).code();
        health
    }

    fn wheelset(&self, wheelset: usize) -> WheelsetHealth {
        let (state, last, settings) = (&self.state.wheelset[wheelset], &self.last, &self.settings);
        let bit = |mask: u32| (mask >> wheelset) & 1;
        let (available, is_bound) = self.available(&state.rail);
        let nothing = "needs braking in which this wheelset is observable on its own";
        let brake_friction = self.brake_friction(&state.friction, state.friction.mean(), nothing);
        WheelsetHealth {
            brake_friction,
            adhesion_utilised: judge::utilised(state.rail.window.largest(), &settings.adhesion),
            adhesion_available: available,
            slides: judge::slides(&state.slides, &settings.slides),
            wsp_share: judge::wsp(state.wsp.mean(1.0), state.wsp_elsewhere.mean(1.0), settings),
            brake_friction_ratio: brake_friction.value / self.nominal.brake_friction,
            slide_energy_j: state.slides.energy_j,
            slide_s: state.slides.seconds,
            mu_b: last.mu_b[wheelset],
            mu_b_sigma: last.mu_b_sigma[wheelset],
            mu_w: last.mu_w_wheelset[wheelset],
            mu_w_sigma: last.mu_w_wheelset_sigma[wheelset],
            slip: last.slip[wheelset],
            adhesion_available_is_bound: u32::from(is_bound),
            observable: bit(last.observable),
            sliding: bit(last.sliding),
            wsp_active: bit(last.wsp_active),
            pressing_force_n: last.pressing_force_n[wheelset],
            brake_friction_standard: self.judge_friction(
                state.standard.mean.mean(),
                state.standard.mean.seconds,
                nothing,
            ),
            isolated: judge_brakes::isolated(
                self.state.isolation.share(wheelset),
                self.friction_ratio(&brake_friction),
                settings,
            ),
        }
    }

    fn brake_friction(&self, seen: &BlockMean, mean: Option<Mean>, nothing: &str) -> Indicator {
        self.judge_friction(mean, seen.seconds, nothing)
    }

    fn judge_friction(&self, mean: Option<Mean>, seconds: f64, nothing: &str) -> Indicator {
        let (nominal, settings) = (self.nominal.brake_friction, &self.settings.brake_friction);
        judge::brake_friction(mean, seconds, nominal, settings, nothing)
    }

    /// Friction and the upper end of its interval, over nominal.
    fn friction_ratio(&self, friction: &Indicator) -> Option<(f64, f64)> {
        let nominal = self.nominal.brake_friction;
        (friction.known != 0).then_some((friction.value / nominal, friction.high / nominal))
    }

    /// The wagon: its worst wheelset, or all of them when the wagon does not brake although it is pressed.
    fn isolated(&self, health: &Health) -> Indicator {
        let whole = judge_brakes::isolated(None, self.friction_ratio(&health.brake_friction), &self.settings);
        if whole.grade() == Grade::Act {
            return whole;
        }
        let wheelsets = health.wheelset[..health.wheelset_count()].iter().enumerate();
        let worst = wheelsets.max_by(|(_, a), (_, b)| {
            (a.isolated.grade, a.isolated.value)
                .partial_cmp(&(b.isolated.grade, b.isolated.value))
                .unwrap_or(Equal)
        });
        let Some((index, worst)) = worst else { return whole };
        let mut isolated = worst.isolated;
        if isolated.grade() > Grade::Ok {
            isolated.reason = Text::new(&format!("wheelset {}: {}", index + 1, isolated.reason));
        }
        isolated
    }

    fn available(&self, view: &RailView) -> (Indicator, bool) {
        let held = view.since_slide_s <= self.settings.adhesion.slide_hold_s;
        judge::available(&Available {
            slid: held.then_some((view.sliding_smoothed, view.since_slide_s)),
            utilised: view.window.largest(),
            low: view.belief.quantile(&self.rail, 0.025),
            high: view.belief.quantile(&self.rail, 0.975),
        })
    }

    fn all_slides(&self, wheelsets: usize) -> Slides {
        let mut sum = Slides::default();
        for slides in self.state.wheelset[..wheelsets].iter().map(|wheelset| &wheelset.slides) {
            sum.count += slides.count;
            sum.energy_j += slides.energy_j;
            sum.seconds += slides.seconds;
            // The worst wheelset decides: flats form on one wheel, not on the sum.
            sum.recent_energy_j = sum.recent_energy_j.max(slides.recent_energy_j);
            sum.recent_locked_s = sum.recent_locked_s.max(slides.recent_locked_s);
        }
        sum
    }
}

/// The worst grade of all indicators of a wagon.
fn worst(health: &Health) -> Grade {
    let wagon = [
        &health.brake_friction,
        &health.asymmetry,
        &health.rail,
        &health.slides,
        &health.wsp_share,
        &health.sensors,
        &health.filter,
        &health.response,
        &health.dragging,
        &health.isolated,
        &health.sanding,
    ];
    let wheelsets = health.wheelset[..health.wheelset_count()]
        .iter()
        .flat_map(|wheelset| [&wheelset.brake_friction, &wheelset.slides, &wheelset.wsp_share]);
    wagon.into_iter().chain(wheelsets).map(|indicator| indicator.grade()).max().unwrap_or(Grade::Unknown)
}
