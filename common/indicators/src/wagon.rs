//! All indicators of one wagon: samples and estimates in, a state that [`crate::report`] puts into words.

use crate::applications::Applications;
use crate::belief::Rail;
use crate::dead::Sensors;
use crate::dragging::Dragging;
use crate::isolation::Isolation;
use crate::judge;
use crate::mean::{BlockMean, FadingMean};
use crate::rail_view::RailView;
use crate::sanding::Sanding;
use crate::settings::IndicatorSettings;
use crate::slides::{Change, Motion, Slides};
use crate::standard::{Standard, WheelsetStandard};
use bytemuck::{Pod, Zeroable};
use railgrip_messages::{
    Estimate, Event, EventKind, Grade, MAX_WHEELSETS, NO_WHEELSET, Sample, Text, flags, valid,
};

/// Longer steps are gaps and count for nothing, s.
const LONGEST_STEP_S: f64 = 0.5;
/// A wheelset can only slide while it brakes or drives, and for so long after that, s; what looks like a slide otherwise
/// is an error of a wheel's radius or of a sensor.
const SLIDE_NEEDS_DEMAND_S: f64 = 2.0;
/// A wheelset drives from this torque on, N m.
const DRIVES_FROM_NM: f64 = 200.0;
/// A change of the rail's condition is told when it is at least so probable.
const SURE_OF_CHANGE: f64 = 0.7;
/// Slower than this nothing about adhesion is learnt, m/s.
pub(crate) const STANDSTILL_M_S: f64 = 0.5;

/// What a wagon is by its vehicle file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nominal {
    /// Pad friction.
    pub brake_friction: f64,
    /// Adhesion of dry, wet and low rail.
    pub rail: [f64; 3],
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Mass of the wagon, kg.
    pub mass_kg: f64,
    /// Rotating inertia of a wheelset, kg m².
    pub inertia_kg_m2: f64,
    /// Radius of the wheels, m.
    pub wheel_radius_m: f64,
    /// Radius at which the pads act, m.
    pub brake_radius_m: f64,
    /// Running resistance: constant N, N s/m, N s²/m².
    pub resistance: [f64; 3],
}

/// Everything that a restart needs to go on; plain bytes for a snapshot.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct IndicatorState {
    pub(crate) samples: u64,
    pub(crate) missed: u64,
    pub(crate) rejected: u64,
    pub(crate) condition: u64,
    /// 1 while low or very low rail is more probable than not.
    pub(crate) rail_is_low: u64,
    pub(crate) last_sequence: u64,
    /// 1 once a sample has come in.
    pub(crate) running: u64,
    pub(crate) last_time_s: f64,
    pub(crate) braking_s: f64,
    pub(crate) friction: BlockMean,
    pub(crate) difference: BlockMean,
    pub(crate) missing: FadingMean,
    pub(crate) refused: FadingMean,
    pub(crate) nis: FadingMean,
    pub(crate) wsp: FadingMean,
    /// The same where the rail is not low.
    pub(crate) wsp_elsewhere: FadingMean,
    pub(crate) dead: FadingMean,
    pub(crate) wagon: RailView,
    pub(crate) standard: Standard,
    pub(crate) applications: Applications,
    pub(crate) dragging: Dragging,
    pub(crate) isolation: Isolation,
    pub(crate) sanding: Sanding,
    pub(crate) sensors: Sensors,
    pub(crate) wheelset: [WheelsetState; MAX_WHEELSETS],
}

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct WheelsetState {
    pub(crate) friction: BlockMean,
    pub(crate) standard: WheelsetStandard,
    pub(crate) rail: RailView,
    pub(crate) slides: Slides,
    pub(crate) wsp: FadingMean,
    /// The same where the rail is not low.
    pub(crate) wsp_elsewhere: FadingMean,
    pub(crate) wsp_was_active: f64,
    pub(crate) since_demand_s: f64,
}

/// The indicators of one wagon.
#[derive(Debug, Clone)]
pub struct WagonIndicators {
    pub(crate) settings: IndicatorSettings,
    pub(crate) nominal: Nominal,
    pub(crate) rail: Rail,
    pub(crate) wagon: u32,
    pub(crate) state: IndicatorState,
    pub(crate) last: Estimate,
    pub(crate) position_m: f64,
    pub(crate) sand: f64,
}

impl WagonIndicators {
    /// Nothing is known yet about wagon number `wagon`.
    #[must_use]
    pub fn new(wagon: u32, settings: IndicatorSettings, nominal: Nominal) -> Self {
        let rail = Rail::new(nominal.rail, settings.adhesion.prior_dry, settings.adhesion.memory_s);
        let view = RailView::new(&rail);
        let mut state = IndicatorState::zeroed();
        state.condition = u64::from(u32::MAX);
        state.wagon = view;
        state.applications = Applications::default();
        for wheelset in &mut state.wheelset {
            (wheelset.rail, wheelset.since_demand_s) = (view, f64::INFINITY);
        }
        Self { settings, nominal, rail, wagon, state, last: Estimate::default(), position_m: 0.0, sand: 0.0 }
    }

    /// What a snapshot keeps.
    #[must_use]
    pub const fn state(&self) -> &IndicatorState {
        &self.state
    }

    /// Goes on from a snapshot; `false`, and nothing changes, if it holds no sense.
    pub fn restore(&mut self, state: &IndicatorState) -> bool {
        let views = state.wheelset.iter().map(|wheelset| &wheelset.rail).chain([&state.wagon]);
        let sound = views.into_iter().all(|view| view.belief.is_valid() && view.smoothed.is_finite())
            && state.last_time_s.is_finite()
            && state.standard.is_sound()
            && state.applications.is_sound()
            && state.braking_s.is_finite();
        if sound {
            self.state = *state;
        }
        sound
    }

    /// Takes in a sample with its estimate; tells `event` what began and ended.
    pub fn update(&mut self, sample: &Sample, estimate: &Estimate, event: &mut dyn FnMut(Event)) {
        let dt_s = self.step_s(estimate, event);
        self.last = *estimate;
        if sample.has(valid::POSITION) {
            self.position_m = sample.position_m;
        }
        self.sand = if sample.has(valid::SANDING) { sample.sanding } else { 0.0 };
        self.count_sensors(sample, estimate, dt_s);
        if dt_s <= 0.0 {
            return;
        }
        let converging = estimate.flags & flags::CONVERGING != 0;
        if !converging {
            self.brakes(estimate, dt_s);
            self.standard(estimate, dt_s);
        }
        self.brake_behaviour(sample, estimate, dt_s);
        for wheelset in 0..estimate.wheelset_count() {
            self.demand(wheelset, sample, estimate, dt_s);
            self.slide(wheelset, estimate, dt_s, event);
            self.wsp(wheelset, sample, estimate, dt_s, event);
        }
        if !converging && self.adhesion(estimate, dt_s) {
            self.watch_condition(estimate, event);
        }
    }

    /// Time since the last sample; 0 over gaps and where the time base begins anew.
    fn step_s(&mut self, estimate: &Estimate, event: &mut dyn FnMut(Event)) -> f64 {
        let state = &mut self.state;
        let began_anew = estimate.flags & flags::RESTARTED != 0 || state.running == 0;
        let dt_s = estimate.time_s - state.last_time_s;
        state.missed += match estimate.sequence.checked_sub(state.last_sequence) {
            Some(step @ 1..) if state.running == 1 => step - 1,
            _ => 0,
        };
        state.running = 1;
        state.last_time_s = estimate.time_s;
        state.last_sequence = estimate.sequence;
        state.samples += 1;
        if !began_anew && (0.0..=LONGEST_STEP_S).contains(&dt_s) {
            return dt_s;
        }
        self.leave_rail(if began_anew { f64::INFINITY } else { dt_s.abs() });
        for wheelset in 0..estimate.wheelset_count() {
            let change = self.state.wheelset[wheelset].slides.end(self.settings.slides.min_duration_s);
            self.tell_slide(wheelset, estimate, change, event);
        }
        0.0
    }

    /// After a gap the rail is another one; what is known about the brakes stays.
    fn leave_rail(&mut self, gap_s: f64) {
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

    fn count_sensors(&mut self, sample: &Sample, estimate: &Estimate, dt_s: f64) {
        let mut expected = valid::SPEED;
        for wheelset in 0..sample.wheelset_count() {
            expected |= valid::wheel_speed(wheelset) | valid::pressing_force(wheelset);
        }
        let count = f64::from(expected.count_ones());
        let missing = f64::from((expected & !sample.valid).count_ones()) / count;
        let rejected = estimate.rejected.count_ones();
        self.state.rejected += u64::from(rejected);
        let memory_s = self.settings.sensors.memory_s;
        self.state.missing.add(dt_s, missing, memory_s);
        self.state.refused.add(dt_s, f64::from(rejected) / count, memory_s);
        let braking = self.state.wheelset.iter().any(|wheelset| wheelset.since_demand_s <= 1.0);
        let radius_m = self.nominal.wheel_radius_m;
        let dead = self.state.sensors.add(dt_s.max(0.0), sample, estimate, radius_m, braking, memory_s);
        self.state.dead.add(dt_s.max(0.0), dead, memory_s);
        let judged = estimate.v_m_s.abs() >= self.settings.filter.min_speed_m_s;
        if judged && estimate.nis_dof > 0 && estimate.nis.is_finite() {
            let ratio = estimate.nis / f64::from(estimate.nis_dof);
            self.state.nis.add(dt_s, ratio, self.settings.filter.memory_s);
        }
    }

    fn brakes(&mut self, estimate: &Estimate, dt_s: f64) {
        let settings = &self.settings.brake_friction;
        let count = estimate.wheelset_count();
        let brakes = |wheelset: usize| estimate.pressing_force_n[wheelset] >= settings.min_pressing_force_n;
        let moving = estimate.v_m_s > STANDSTILL_M_S;
        if !moving || !(0..count).any(brakes) {
            return;
        }
        self.state.braking_s += dt_s;
        let (block_s, memory_s) = (settings.correlation_s, settings.memory_s);
        self.state.friction.add(dt_s, estimate.mu_b_mean, estimate.mu_b_mean_sigma, block_s, memory_s);
        let observed = |wheelset: usize| brakes(wheelset) && estimate.observable & (1 << wheelset) != 0;
        for wheelset in (0..count).filter(|wheelset| observed(*wheelset)) {
            let (value, sigma) = (estimate.mu_b[wheelset], estimate.mu_b_sigma[wheelset]);
            self.state.wheelset[wheelset].friction.add(dt_s, value, sigma, block_s, memory_s);
        }
        if count >= 2 && (0..count).all(observed) {
            let half = count / 2;
            let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
            let (front, rear) = (0..half, count - half..count);
            let value = mean(&estimate.mu_b[front.clone()]) - mean(&estimate.mu_b[rear.clone()]);
            // The errors of front and rear are opposite where only their sum is known: they add up.
            let sigma = mean(&estimate.mu_b_sigma[front]) + mean(&estimate.mu_b_sigma[rear]);
            self.state.difference.add(dt_s, value, sigma, block_s, memory_s);
        }
    }

    fn demand(&mut self, wheelset: usize, sample: &Sample, estimate: &Estimate, dt_s: f64) {
        let brakes = estimate.pressing_force_n[wheelset] >= self.settings.brake_friction.min_pressing_force_n;
        let drives = sample.drive_torque_nm[wheelset].abs() >= DRIVES_FROM_NM;
        let protected = estimate.wsp_active & (1 << wheelset) != 0;
        let since_s = &mut self.state.wheelset[wheelset].since_demand_s;
        *since_s = if brakes || drives || protected { 0.0 } else { *since_s + dt_s };
    }

    /// True if the filter says that the wheelset slides or spins, and it can.
    pub(crate) fn slides(&self, wheelset: usize, estimate: &Estimate) -> bool {
        estimate.sliding & (1 << wheelset) != 0
            && estimate.v_m_s > STANDSTILL_M_S
            && self.state.wheelset[wheelset].since_demand_s <= SLIDE_NEEDS_DEMAND_S
    }

    fn slide(&mut self, wheelset: usize, estimate: &Estimate, dt_s: f64, event: &mut dyn FnMut(Event)) {
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

    fn tell_slide(
        &self,
        wheelset: usize,
        estimate: &Estimate,
        change: Option<Change>,
        event: &mut dyn FnMut(Event),
    ) {
        match change {
            None => {}
            Some(Change::Began) => {
                let text = format!("slides at {:.1} m/s", estimate.v_m_s);
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

    fn wsp(
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

    /// True when the belief of the wagon was renewed.
    fn adhesion(&mut self, estimate: &Estimate, dt_s: f64) -> bool {
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

    fn watch_condition(&mut self, estimate: &Estimate, event: &mut dyn FnMut(Event)) {
        let classes = self.state.wagon.belief.classes(&self.rail);
        self.state.rail_is_low = u64::from(classes[2] + classes[3] > 0.5);
        let (_, condition) = judge::rail(classes, &self.settings.adhesion);
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

    fn event(
        &self,
        kind: EventKind,
        wheelset: u32,
        estimate: &Estimate,
        values: [f64; 4],
        text: &str,
    ) -> Event {
        Event {
            sequence: 0,
            stamp: estimate.acquired,
            time_s: estimate.time_s,
            kind: kind.code(),
            wagon: self.wagon,
            wheelset,
            grade: Grade::Unknown.code(),
            values,
            text: Text::new(text),
        }
    }
}
