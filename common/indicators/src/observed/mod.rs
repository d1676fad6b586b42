//! All that was observed of one wagon: samples and estimates in, a state that the indicators are judged from.

mod adhesion;
mod brakes;
mod sensors;
mod sliding;

pub(crate) use adhesion::Available;

use crate::belief::Rail;
use crate::measure::applications::Applications;
use crate::measure::dragging::Dragging;
use crate::measure::isolation::Isolation;
use crate::measure::mean::{BlockMean, FadingMean};
use crate::measure::rail_view::RailView;
use crate::measure::roundness::Roundness;
use crate::measure::sanding::Sanding;
use crate::measure::sensors::Sensors;
use crate::measure::slides::Slides;
use crate::measure::standard::{Standard, WheelsetStandard};
use crate::nominal::Nominal;
use crate::settings::IndicatorSettings;
use bytemuck::{Pod, Zeroable};
use railgrip_messages::{
    Estimate, Event, EventKind, Grade, MAX_INDICATORS, MAX_WHEELSETS, Sample, Text, flags, valid,
};

/// Longer steps are gaps and count for nothing, s.
const LONGEST_STEP_S: f64 = 0.5;
/// Slower than this nothing about adhesion is learnt, m/s.
pub(crate) const STANDSTILL_M_S: f64 = 0.5;

/// What an indicator may remember between two instants, zeros at first; it outlives a restart.
pub type Memory = [f64; 8];

/// One instant of a wagon, for an indicator with a memory of its own.
#[derive(Debug, Clone, Copy)]
pub struct Instant<'a> {
    /// What the sensors say.
    pub sample: &'a Sample,
    /// What the filter makes of it.
    pub estimate: &'a Estimate,
    /// For so long it holds, s; never 0.
    pub dt_s: f64,
    /// What the wagon is.
    pub nominal: &'a Nominal,
    /// How indicators are computed and judged.
    pub settings: &'a IndicatorSettings,
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
    /// Of indicators with a memory of their own.
    pub(crate) memory: [Memory; MAX_INDICATORS],
    pub(crate) wheelset: [WheelsetState; MAX_WHEELSETS],
}

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct WheelsetState {
    pub(crate) friction: BlockMean,
    pub(crate) standard: WheelsetStandard,
    pub(crate) rail: RailView,
    pub(crate) slides: Slides,
    pub(crate) roundness: Roundness,
    pub(crate) wsp: FadingMean,
    /// The same where the rail is not low.
    pub(crate) wsp_elsewhere: FadingMean,
    pub(crate) wsp_was_active: f64,
    pub(crate) since_demand_s: f64,
}

/// All that was observed of one wagon.
#[derive(Debug, Clone)]
pub struct Observed {
    /// How indicators are computed and judged.
    pub settings: IndicatorSettings,
    /// What the wagon is.
    pub nominal: Nominal,
    /// The latest estimate.
    pub last: Estimate,
    pub(crate) rail: Rail,
    pub(crate) wagon: u32,
    pub(crate) state: IndicatorState,
    pub(crate) position_m: f64,
    pub(crate) sand: f64,
    /// Since when the speed of each wheelset has not been measured, s.
    pub(crate) unmeasured_s: [f64; MAX_WHEELSETS],
}

/// What is known of the rail beforehand.
fn rail(nominal: &Nominal, settings: &IndicatorSettings) -> Rail {
    Rail::new(nominal.rail, settings.adhesion.prior_dry, settings.adhesion.memory_s)
}

impl Observed {
    /// Nothing is known yet about wagon number `wagon`.
    pub(crate) fn new(wagon: u32, settings: IndicatorSettings, nominal: Nominal) -> Self {
        let rail = rail(&nominal, &settings);
        let view = RailView::new(&rail);
        let mut state = IndicatorState::zeroed();
        state.condition = u64::from(u32::MAX);
        state.wagon = view;
        state.applications = Applications::default();
        for wheelset in &mut state.wheelset {
            (wheelset.rail, wheelset.since_demand_s) = (view, f64::INFINITY);
        }
        let (last, unmeasured_s) = (Estimate::default(), [f64::INFINITY; MAX_WHEELSETS]);
        Self { settings, nominal, rail, wagon, state, last, position_m: 0.0, sand: 0.0, unmeasured_s }
    }

    /// Goes on by other settings.
    pub(crate) fn judge_by(&mut self, settings: IndicatorSettings) {
        self.rail = rail(&self.nominal, &settings);
        self.settings = settings;
    }

    /// Goes on from a snapshot; `false`, and nothing changes, if it holds no sense.
    pub(crate) fn restore(&mut self, state: &IndicatorState) -> bool {
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

    /// Takes in a sample with its estimate; tells `event` what began and ended. Returns for how long it holds, s; 0 over
    /// gaps.
    pub(crate) fn update(
        &mut self,
        sample: &Sample,
        estimate: &Estimate,
        event: &mut dyn FnMut(Event),
    ) -> f64 {
        let dt_s = self.step_s(estimate, event);
        self.last = *estimate;
        if sample.has(valid::POSITION) {
            self.position_m = sample.position_m;
        }
        self.sand = if sample.has(valid::SANDING) { sample.sanding } else { 0.0 };
        self.count_sensors(sample, estimate, dt_s);
        if dt_s <= 0.0 {
            return 0.0;
        }
        let converging = estimate.flags & flags::CONVERGING != 0;
        if !converging {
            self.brakes(estimate, dt_s);
            self.standard(estimate, dt_s);
        }
        self.brake_behaviour(sample, estimate, dt_s);
        for wheelset in 0..estimate.wheelset_count() {
            let since_s = &mut self.unmeasured_s[wheelset];
            *since_s = if sample.has(valid::wheel_speed(wheelset)) { 0.0 } else { *since_s + dt_s };
            self.demand(wheelset, sample, estimate, dt_s);
            self.slide(wheelset, estimate, dt_s, event);
            self.wsp(wheelset, sample, estimate, dt_s, event);
            self.roundness(wheelset, sample, estimate, dt_s);
        }
        if !converging && self.adhesion(estimate, dt_s) {
            self.watch_condition(estimate, event);
        }
        dt_s
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
            self.state.wheelset[wheelset].roundness.lose();
        }
        0.0
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
