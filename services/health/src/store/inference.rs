//! What the wagons show only together: who is without a brake or late, where the rail is low, how far the train needs to
//! stop.

use crate::api::adhesion_map::model::MapView;
use crate::api::capability::model::CapabilityView;
use crate::api::figure::{Figure, rounded};
use crate::api::grade::Grade;
use crate::api::wagons::model::{WagonRow, WagonView};
use crate::neighbours::Neighbours;
use crate::store::capability;
use crate::store::received::{Received, Wagon};
use railgrip_indicators::IndicatorSettings;
use railgrip_indicators::belief::{Evidence, Rail};
use railgrip_indicators::stopping::BrakedWagon;
use railgrip_indicators::track::{KeptCell, TrackMap};
use railgrip_messages::{Health, Stamp, WheelsetHealth};
use railgrip_settings::{CapabilitySettings, TrainSettings};
use std::sync::Arc;

/// Stopping distances and the map are worked out so often, ns.
const WHOLE_PERIOD_NS: u64 = 2_000_000_000;
/// Pressing force above which a sliding wheelset shows what the rail takes, N.
const BRAKED_N: f64 = 2000.0;

/// What is inferred about the train.
#[derive(Debug)]
pub(super) struct Inference {
    map: TrackMap,
    capability: CapabilitySettings,
    indicators: IndicatorSettings,
    neighbours: Neighbours,
    /// When the neighbours were last compared, monotonic, ns.
    compared_ns: Option<u64>,
    /// What is said of the whole train.
    whole: Option<Arc<Whole>>,
}

/// What the neighbours show of one wagon.
#[derive(Debug, Clone)]
pub(super) struct NeighbourFigures {
    /// How much later than its place explains it begins to brake.
    delay: Figure,
    /// How much of the latest braking of the train it had no pressing force.
    without: Option<Figure>,
}

/// What requests about the whole train need beside the wagons; renewed every few seconds.
#[derive(Debug, Clone)]
pub struct Whole {
    /// The wagons as they brake now, with those that are nominal.
    pub braked: Vec<(BrakedWagon, BrakedWagon)>,
    /// Wagons whose brakes are known now.
    pub known: usize,
    /// What full braking is.
    pub settings: CapabilitySettings,
    /// Stopping distances from the speeds of the config.
    pub capability: CapabilityView,
    /// Adhesion along the track.
    pub map: MapView,
    /// When this was worked out, monotonic, ns.
    pub at_ns: u64,
}

impl Inference {
    /// Nothing is known yet.
    pub fn new(settings: &TrainSettings) -> Self {
        let rail = settings.wagons.first().map_or([0.30, 0.12, 0.06], |wagon| {
            let rail = &wagon.vehicle.rail;
            [rail.dry, rail.wet, rail.low]
        });
        let capability = settings.capability.clone();
        let rail = Rail::new(rail, settings.indicators.adhesion.prior_dry, capability.map_memory_s);
        Self {
            map: TrackMap::new(rail, capability.cell_m, capability.most_cells as usize),
            capability,
            indicators: settings.indicators,
            neighbours: Neighbours::default(),
            compared_ns: None,
            whole: None,
        }
    }

    /// Goes on from cells of the map that were kept; returns how many there were.
    pub fn restore_map(&mut self, cells: &[(i64, Vec<u8>)], now: Stamp) -> usize {
        self.map.restore(cells, unix_ahead_s(now))
    }

    /// Cells of the map that have changed since this was last asked.
    pub fn changed_map(&mut self, now: Stamp) -> Vec<KeptCell> {
        self.map.take_changed(unix_ahead_s(now))
    }

    /// Puts what a wagon says onto the map, for the time since the message before.
    pub fn chart(&mut self, health: &Health, before: Option<&Health>) {
        // A position of 0 is unknown; NaN is, whatever it stands for.
        let known = health.position_m.abs() > 0.0
            && health.v_m_s > 0.5
            && health.mu_w_sigma > 0.0
            && health.mu_w.is_finite();
        let Some(before) = before.filter(|_| known) else { return };
        let elapsed_ns = health.acquired.monotonic_ns.saturating_sub(before.acquired.monotonic_ns);
        let seconds = elapsed_ns as f64 * 1e-9;
        if !(0.0..=1.0).contains(&seconds) || seconds == 0.0 {
            return;
        }
        let slides = |one: &&WheelsetHealth| {
            one.sliding != 0 && (one.wsp_active != 0 || one.pressing_force_n > BRAKED_N)
        };
        let wheelsets = &health.wheelset[..health.wheelset_count()];
        let (sum, number) = wheelsets
            .iter()
            .filter(slides)
            .filter(|one| one.mu_w.is_finite())
            .fold((0.0, 0.0), |(sum, number), one| (sum + one.mu_w.abs(), number + 1.0));
        let sliding = number > 0.0;
        let utilised = if sliding { sum / number } else { health.mu_w.abs() };
        let evidence = Evidence { utilised, sigma: health.mu_w_sigma, sliding };
        let now_s = health.acquired.monotonic_ns as f64 * 1e-9;
        self.map.add(health.wagon, health.position_m, now_s, seconds, evidence);
    }

    /// Compares the live wagons with each other.
    pub fn compare(&mut self, received: &Received, now_ns: u64) {
        let before_ns = self.compared_ns.replace(now_ns).unwrap_or(now_ns);
        let live: Vec<&Health> =
            received.wagons.iter().filter_map(|wagon| received.fresh(wagon, now_ns)).collect();
        let dt_s = now_ns.saturating_sub(before_ns) as f64 * 1e-9;
        self.neighbours.take(&live, now_ns, dt_s, &self.indicators);
    }

    /// What the other wagons show of one, and by which settings that is judged.
    pub fn neighbours(&self) -> (&Neighbours, &IndicatorSettings) {
        (&self.neighbours, &self.indicators)
    }

    /// What the neighbours show of a wagon.
    pub fn neighbour_figures(&self, wagon: u32) -> NeighbourFigures {
        NeighbourFigures {
            delay: self.neighbours.delay(wagon, &self.indicators),
            without: self.neighbours.without(wagon, &self.indicators),
        }
    }

    /// What is said of the whole train; worked out anew every few seconds.
    pub fn whole(&mut self, received: &Received, now_ns: u64) -> Arc<Whole> {
        if let Some(whole) = &self.whole
            && now_ns.saturating_sub(whole.at_ns) < WHOLE_PERIOD_NS
        {
            return Arc::clone(whole);
        }
        let map = MapView::of(&self.map, self.capability.cell_m, now_ns as f64 * 1e-9);
        let whole = Arc::new(Whole::new(received, self.capability.clone(), map, now_ns));
        self.whole = Some(Arc::clone(&whole));
        whole
    }
}

impl Whole {
    fn new(received: &Received, settings: CapabilitySettings, map: MapView, at_ns: u64) -> Self {
        let fresh = |wagon| received.fresh(wagon, at_ns);
        let braked: Vec<(BrakedWagon, BrakedWagon)> =
            received.wagons.iter().map(|wagon| (braked(wagon, fresh(wagon)), wagon.nominal)).collect();
        let known = received
            .wagons
            .iter()
            .filter_map(fresh)
            .filter(|health| health.brake_friction.known != 0)
            .count();
        let capability = capability::judge(&braked, known, &settings, &settings.speeds_km_h);
        Self { braked, known, settings, capability, map, at_ns }
    }

    /// The same some time later, when nothing new has come.
    pub(super) fn aged(&self, received: &Received, now_ns: u64) -> Self {
        let mut map = self.map.clone();
        let passed_s = now_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        map.cells.iter_mut().for_each(|cell| cell.age_s = rounded(cell.age_s + passed_s));
        Self::new(received, self.settings.clone(), map, now_ns)
    }
}

impl NeighbourFigures {
    /// Adds what the neighbours show to what a live wagon says of itself.
    pub fn amend(&self, row: &mut WagonRow, view: &mut WagonView) {
        view.brake_delay = self.delay.clone();
        if let Some(without) = &self.without
            && (without.grade > view.isolated.grade || view.isolated.value.is_none())
        {
            view.isolated = without.clone();
        }
        for (name, figure) in [("isolated", &view.isolated), ("late", &view.brake_delay)] {
            if figure.grade > row.grade && figure.grade >= Grade::Watch {
                row.grade = figure.grade;
                row.reason = format!("{name}: {}", figure.reason);
            }
        }
        (view.grade, view.reason) = (row.grade, row.reason.clone());
    }
}

/// A wagon as it brakes now; what is stale or unknown is nominal with a wide interval.
fn braked(wagon: &Wagon, fresh: Option<&Health>) -> BrakedWagon {
    let mut now = wagon.nominal;
    now.friction_ratio = [1.0, 0.7, 1.1];
    let Some(health) = fresh else { return now };
    let friction = &health.brake_friction;
    if friction.known != 0 {
        now.friction_ratio =
            [friction.value, friction.low, friction.high].map(|value| value / wagon.nominal_friction);
    }
    let available = &health.adhesion_available;
    if available.known != 0 && health.adhesion_available_is_bound == 0 {
        now.adhesion = [available.value, available.low, available.high];
    } else if available.known != 0 {
        // No slide of late: the mean over what the rail may be, within what is known of it.
        let classes = wagon.rail.iter().zip(health.condition_probability);
        let mean: f64 = classes.map(|(adhesion, share)| adhesion * share).sum();
        let high = available.high.max(available.low);
        now.adhesion = [mean.clamp(available.low, high), available.low, high];
    }
    let wheelsets = &health.wheelset[..health.wheelset_count()];
    let isolated = wheelsets.iter().map(|one| &one.isolated);
    let without: f64 = isolated.filter(|one| one.known != 0).map(|one| one.value).sum();
    if !wheelsets.is_empty() {
        now.braked_share = (1.0 - without / wheelsets.len() as f64).clamp(0.0, 1.0);
    }
    now
}

/// What the wall clock is ahead of the monotonic one, s.
fn unix_ahead_s(now: Stamp) -> f64 {
    now.unix_ns as f64 * 1e-9 - now.monotonic_ns as f64 * 1e-9
}
