//! What the wagons show only together: who is without a brake or late, where the rail is low, how far the train needs to
//! stop.

use crate::alerts::Vehicles;
use crate::api::adhesion_map::model::MapView;
use crate::api::capability::model::CapabilityView;
use crate::api::figure::{Freshness, figure, rounded};
use crate::api::grade::Grade;
use crate::api::wagons::model::{WagonRow, WagonView};
use crate::store::judgement::Judgement;
use crate::store::received::{Received, Wagon};
use railgrip_indicators::belief::Rail;
use railgrip_indicators::train::braked;
use railgrip_indicators::train::capability::Capability;
use railgrip_indicators::train::neighbours::Neighbours;
use railgrip_indicators::train::stopping::BrakedWagon;
use railgrip_indicators::train::track::{KeptCell, TrackMap};
use railgrip_indicators::{IndicatorSettings, IndicatorSpec, Table};
use railgrip_messages::{Health, Indicator, Stamp};
use railgrip_settings::{CapabilitySettings, TrainSettings};
use std::sync::Arc;

/// Stopping distances and the map are worked out so often, ns.
const WHOLE_PERIOD_NS: u64 = 2_000_000_000;
/// What is inferred about the train.
#[derive(Debug)]
pub(super) struct Inference {
    table: Table,
    map: TrackMap,
    capability: CapabilitySettings,
    indicators: IndicatorSettings,
    neighbours: Neighbours,
    /// When the neighbours were last compared, monotonic, ns.
    compared_ns: Option<u64>,
    /// What is said of the whole train.
    whole: Option<Arc<Whole>>,
}

/// How one wagon is judged among its neighbours, by the entries of the table that do so.
#[derive(Debug, Clone)]
pub(super) struct Among(pub Vec<(&'static IndicatorSpec, Indicator)>);

/// What requests about the whole train need beside the wagons; renewed every few seconds.
#[derive(Debug, Clone)]
pub struct Whole {
    table: Table,
    /// The wagons as they brake now, with those that are nominal.
    pub braked: Vec<(BrakedWagon, BrakedWagon)>,
    /// Which vehicles they are.
    pub vehicles: Vehicles,
    /// What full braking is.
    pub settings: CapabilitySettings,
    /// Stopping distances from the speeds of the config.
    pub found: Capability,
    /// The same as the API says it.
    pub capability: CapabilityView,
    /// How the train is judged, with what judges it.
    pub judged: Vec<(&'static IndicatorSpec, Indicator)>,
    /// Adhesion along the track.
    pub map: MapView,
    /// When this was worked out, monotonic, ns.
    pub at_ns: u64,
}

impl Inference {
    /// Nothing is known yet.
    pub fn new(settings: &TrainSettings, table: Table) -> Self {
        let rail = settings.wagons.first().map_or([0.30, 0.12, 0.06], |wagon| {
            let rail = &wagon.vehicle.rail;
            [rail.dry, rail.wet, rail.low]
        });
        let capability = settings.capability.clone();
        let rail = Rail::new(rail, settings.indicators.adhesion.prior_dry, capability.map_memory_s);
        Self {
            table,
            map: TrackMap::new(rail, capability.cell_m, capability.most_cells as usize),
            capability,
            indicators: settings.indicators,
            neighbours: Neighbours::default(),
            compared_ns: None,
            whole: None,
        }
    }

    /// Compares wagons by other settings from now on.
    pub fn judge_by(&mut self, indicators: IndicatorSettings) {
        self.indicators = indicators;
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
        self.map.take(health, before.map(|before| before.acquired.monotonic_ns));
    }

    /// Compares the live wagons with each other.
    pub fn compare(&mut self, received: &Received, now_ns: u64) {
        let before_ns = self.compared_ns.replace(now_ns).unwrap_or(now_ns);
        let live: Vec<&Health> =
            received.wagons.iter().filter_map(|wagon| received.fresh(wagon, now_ns)).collect();
        let dt_s = now_ns.saturating_sub(before_ns) as f64 * 1e-9;
        self.neighbours.take(&live, now_ns, dt_s, &self.indicators);
    }

    /// How a wagon is judged among its neighbours.
    pub fn among(&self, wagon: u32) -> Among {
        let judge = |spec: &'static IndicatorSpec| {
            let indicator = spec.judge.among?(&self.neighbours, wagon, &self.indicators)?;
            Some((spec, indicator))
        };
        Among(self.table.iter().filter_map(judge).collect())
    }

    /// What is said of the whole train; worked out anew every few seconds.
    pub fn whole(&mut self, received: &Received, judgement: &Judgement, now_ns: u64) -> Arc<Whole> {
        if let Some(whole) = &self.whole
            && now_ns.saturating_sub(whole.at_ns) < WHOLE_PERIOD_NS
        {
            return Arc::clone(whole);
        }
        let map = MapView::of(&self.map, self.capability.cell_m, now_ns as f64 * 1e-9);
        let whole =
            Arc::new(Whole::new(self.table, received, judgement, self.capability.clone(), map, now_ns));
        self.whole = Some(Arc::clone(&whole));
        whole
    }
}

impl Whole {
    fn new(
        table: Table,
        received: &Received,
        judgement: &Judgement,
        settings: CapabilitySettings,
        map: MapView,
        at_ns: u64,
    ) -> Self {
        let of_wagon = |wagon: &Wagon| {
            let nominal = braked::nominally(&wagon.nominal);
            let now = match judgement.is_together() {
                true => judgement.braked(wagon.number, &wagon.nominal, nominal),
                false => braked::now(&wagon.nominal, received.fresh(wagon, at_ns)),
            };
            (now, nominal)
        };
        let braked: Vec<(BrakedWagon, BrakedWagon)> = received.wagons.iter().map(of_wagon).collect();
        let fresh = received.wagons.iter().filter_map(|wagon| received.fresh(wagon, at_ns));
        let known = fresh.filter(|health| judgement.is_together() || braked::is_known(health)).count();
        let full = settings.full_braking();
        let found = Capability::of(&braked, known, &full, &settings.speeds_km_h);
        let judged = table.iter().filter_map(|spec| Some((spec, spec.judge.train?(&found)))).collect();
        let vehicles = Vehicles::new(received.wagons.iter().map(|wagon| wagon.vehicle.clone()).collect());
        let capability = CapabilityView::of(&found, &full, &vehicles);
        Self { table, braked, vehicles, settings, found, capability, judged, map, at_ns }
    }

    /// The same some time later, when nothing new has come.
    pub(super) fn aged(&self, received: &Received, judgement: &Judgement, now_ns: u64) -> Self {
        let mut map = self.map.clone();
        let passed_s = now_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        map.cells.iter_mut().for_each(|cell| cell.age_s = rounded(cell.age_s + passed_s));
        Self::new(self.table, received, judgement, self.settings.clone(), map, now_ns)
    }
}

impl Among {
    /// Adds what the neighbours show to what a live wagon says of itself.
    pub fn amend(&self, row: &mut WagonRow, view: &mut WagonView, fresh: Freshness, judgement: &Judgement) {
        for (spec, indicator) in self.0.iter().filter(|(spec, _)| judgement.grades(spec)) {
            let shown = view.indicators.0.iter_mut().find(|(own, _)| own.id == spec.id);
            let Some((_, shown)) = shown else { continue };
            let figure = figure(indicator, fresh);
            if spec.judge.wagon.is_none() || figure.grade > shown.grade || shown.value.is_none() {
                *shown = figure;
            }
            if shown.grade > row.grade && shown.grade >= Grade::Watch {
                row.grade = shown.grade;
                row.reason = format!("{}: {}", spec.name(), shown.reason);
            }
        }
        (view.grade, view.reason) = (row.grade, row.reason.clone());
    }
}

/// What the wall clock is ahead of the monotonic one, s.
fn unix_ahead_s(now: Stamp) -> f64 {
    now.unix_ns as f64 * 1e-9 - now.monotonic_ns as f64 * 1e-9
}
