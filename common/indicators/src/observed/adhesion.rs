//! Adhesion and the condition of the rail, as each wheelset and the wagon see it.

use super::{Observed, STANDSTILL_M_S};
use crate::belief::CLASSES;
use crate::measure::rail_view::RailView;
use railgrip_messages::{Condition, Estimate, Event, EventKind, MAX_WHEELSETS, NO_WHEELSET};

/// A change of the rail's condition is told when it is at least so probable.
const SURE_OF_CHANGE: f64 = 0.7;

/// What is known of the adhesion available.
pub(crate) struct Available {
    /// What the last slide showed: the adhesion utilised in it, and its age in s.
    pub slid: Option<(f64, f64)>,
    /// Largest adhesion utilised while rolling, with its 1 σ.
    pub utilised: Option<(f64, f64)>,
    /// 95 % range of the belief.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl Observed {
    /// The adhesion available as a wheelset, or the wagon, sees it.
    pub(crate) fn available(&self, view: &RailView) -> Available {
        let held = view.since_slide_s <= self.settings.adhesion.slide_hold_s;
        Available {
            slid: held.then_some((view.sliding_smoothed, view.since_slide_s)),
            utilised: view.window.largest(),
            low: view.belief.quantile(&self.rail, 0.025),
            high: view.belief.quantile(&self.rail, 0.975),
        }
    }

    /// Probability of dry, wet, low and very low rail.
    pub(crate) fn rail_classes(&self) -> [f64; CLASSES] {
        self.state.wagon.belief.classes(&self.rail)
    }

    /// The most probable condition of the rail.
    pub(crate) fn condition(&self) -> Condition {
        let classes = self.rail_classes();
        let best = (0..CLASSES).max_by(|a, b| classes[*a].total_cmp(&classes[*b])).unwrap_or(0);
        Condition::ALL[best]
    }

    /// After a gap the rail is another one; what is known about the brakes stays.
    pub(super) fn leave_rail(&mut self, gap_s: f64) {
        let rail = &self.rail;
        let views = self.state.wheelset.iter_mut().map(|wheelset| &mut wheelset.rail);
        for view in views.chain([&mut self.state.wagon]) {
            if gap_s > self.settings.adhesion.window_s {
                *view = RailView::new(rail);
            } else {
                view.belief.update(rail, gap_s, None);
            }
        }
    }

    /// True when the belief of the wagon was renewed.
    pub(super) fn adhesion(&mut self, estimate: &Estimate, dt_s: f64) -> bool {
        let moving = estimate.v_m_s > STANDSTILL_M_S;
        let count = estimate.wheelset_count();
        let (settings, rail) = (&self.settings.adhesion, &self.rail);
        let slides: [bool; MAX_WHEELSETS] = std::array::from_fn(|wheelset| self.slides(wheelset, estimate));
        let sliding = |wheelset: usize| slides[wheelset];
        for wheelset in 0..count {
            let (value, sigma) =
                (estimate.mu_w_wheelset[wheelset].abs(), estimate.mu_w_wheelset_sigma[wheelset]);
            self.state.wheelset[wheelset].rail.add(
                rail,
                settings,
                dt_s,
                (value, sigma),
                sliding(wheelset),
                moving,
            );
        }
        // The wagon: what its sliding wheelsets show, else what all of them utilise.
        let (slide_sum, number) = (0..count)
            .filter(|wheelset| sliding(*wheelset))
            .fold((0.0, 0u32), |(sum, n), wheelset| (sum + estimate.mu_w_wheelset[wheelset].abs(), n + 1));
        let any_slides = number > 0;
        let value = if any_slides { slide_sum / f64::from(number) } else { estimate.mu_w.abs() };
        self.state.wagon.add(rail, settings, dt_s, (value, estimate.mu_w_sigma), any_slides, moving)
    }

    pub(super) fn watch_condition(&mut self, estimate: &Estimate, event: &mut dyn FnMut(Event)) {
        let classes = self.rail_classes();
        self.state.rail_is_low = u64::from(classes[2] + classes[3] > 0.5);
        let condition = self.condition();
        let probability = classes[condition.code() as usize];
        let (old, new) = (self.state.condition, u64::from(condition.code()));
        if new == old || probability < SURE_OF_CHANGE {
            return;
        }
        self.state.condition = new;
        let values = [old as f64, new as f64, probability, 0.0];
        let text = format!("rail is {condition}, {:.0} % sure", 100.0 * probability);
        event(self.event(EventKind::ConditionChanged, NO_WHEELSET, estimate, values, &text));
    }
}
