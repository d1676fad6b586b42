//! Prometheus metrics. Names carry base units; what is stale is left out, but for its age.

use crate::api::figures::Figures;
use crate::api::grade::{Condition, DataState, Grade};
use crate::api::processes::ProcessView;
use crate::api::sources;
use crate::api::wagons::model::WagonView;
use crate::history::HistoryStatus;
use crate::shared::{Build, Shared};
use crate::store::Snapshot;
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;
use railgrip_indicators::train::capability::Capability;
use railgrip_indicators::{IndicatorSpec, Metric};
use std::sync::atomic::AtomicU64;

type Gauges<L> = Family<L, Gauge<f64, AtomicU64>>;
type Counters<L> = Family<L, Counter<f64, AtomicU64>>;

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfWagon {
    wagon: u32,
}

/// Who runs where: figures carry the place alone, so that their series stay short, and are joined with this.
#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Who {
    wagon: u32,
    name: String,
    vehicle_number: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfWheelset {
    wagon: u32,
    wheelset: u32,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfCondition {
    wagon: u32,
    condition: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfProcess {
    process: String,
    wagon: u32,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfQuantile {
    wagon: u32,
    quantile: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfSpeed {
    speed_km_h: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfGrade {
    grade: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfRefusal {
    payload: String,
    reason: String,
}

/// Metrics for Prometheus.
#[utoipa::path(get, path = "/metrics", tag = "service", responses((
    status = 200, content_type = "application/openmetrics-text", body = String, description = "OpenMetrics 1.0"
)))]
pub(crate) async fn metrics(State(shared): State<Shared>) -> Response {
    let kind = HeaderValue::from_static("application/openmetrics-text; version=1.0.0; charset=utf-8");
    let history = shared.history().map(|history| history.status());
    (
        [(header::CONTENT_TYPE, kind)],
        text(&shared.latest(), shared.requests(), history.as_ref(), shared.build()),
    )
        .into_response()
}

/// The metrics of a snapshot.
#[must_use]
pub fn text(snapshot: &Snapshot, requests: u64, history: Option<&HistoryStatus>, build: Build) -> String {
    let mut registry = Registry::with_prefix("railgrip");
    let mut wagons = OfWagons::register(&mut registry);
    snapshot.wagons.iter().for_each(|wagon| wagons.fill(wagon));
    of_table(&mut registry, snapshot);
    of_stops(&mut registry, &snapshot.whole.found);
    let processes = OfProcesses::register(&mut registry);
    snapshot.train.processes.iter().for_each(|process| processes.fill(process));
    let alerts: Gauges<OfGrade> = Family::default();
    registry.register("alerts_active", "Alerts that are active now", alerts.clone());
    let counts = snapshot.train.alerts;
    for (grade, count) in [("watch", counts.watch), ("act", counts.act)] {
        alerts.get_or_create(&OfGrade { grade }).set(f64::from(count));
    }
    let refused: Counters<OfRefusal> = Family::default();
    registry.register("payloads_refused", "Messages refused on receipt, by kind and reason", refused.clone());
    for one in &snapshot.train.refused {
        let label = OfRefusal { payload: one.payload.clone(), reason: one.reason.clone() };
        refused.get_or_create(&label).inc_by(one.count as f64);
    }
    sources::register(&mut registry, &snapshot.train.sources);
    registry.register("build", "From which version and commit this program is built", Info::new(build));
    let served: Counter<u64> = Counter::default();
    served.inc_by(requests);
    registry.register("http_requests", "Requests answered", served);
    if let Some(status) = history {
        of_history(&mut registry, status);
    }
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = encode(&mut text, &registry);
    text
}

/// Stopping distances by speed; what rests on assumptions alone is no figure of this train.
fn of_stops(registry: &mut Registry, found: &Capability) {
    let stops: Gauges<OfSpeed> = Family::default();
    registry.register("stopping_distance_meters", "Stopping distance now from a speed", stops.clone());
    for stop in found.stops.iter().filter(|_| found.known_wagons > 0) {
        let [distance_m, ..] = stop.distance_m;
        if distance_m.is_finite() {
            let speed_km_h = format!("{:.0}", stop.speed_km_h);
            stops.get_or_create(&OfSpeed { speed_km_h }).set(distance_m);
        }
    }
}

/// How well the train remembers.
fn of_history(registry: &mut Registry, status: &HistoryStatus) {
    let mut gauge = |name: &str, help: &str, value: f64| {
        let gauge = Gauge::<f64, AtomicU64>::default();
        gauge.set(value);
        registry.register(name, help, gauge);
    };
    gauge("history_up", "1 if the history is written", f64::from(u8::from(status.trouble.is_none())));
    gauge("history_size_bytes", "Size of the database of the history", status.size_bytes as f64);
    if let Some(unix_s) = status.written_until_unix_s {
        let help = "Up to here everything that arrived is on the medium, Unix time";
        gauge("history_written_until_timestamp_seconds", help, unix_s as f64);
    }
    let counters = [
        ("history_flushes", "Writes of the history", status.flushes),
        ("history_written_bytes", "Bytes of blocks written to the history", status.written_bytes),
        ("history_dropped", "Records lost because the disk refused them or was too slow", status.dropped),
    ];
    for (name, help, value) in counters {
        let counter: Counter<u64> = Counter::default();
        counter.inc_by(value);
        registry.register(name, help, counter);
    }
}

/// What the service itself says of wagons, beside the indicators.
struct OfWagons {
    info: Gauges<Who>,
    up: Gauges<OfWagon>,
    age: Gauges<OfWagon>,
    grade: Gauges<OfWagon>,
    speed: Gauges<OfWagon>,
    condition: Gauges<OfCondition>,
    heard_wet: Gauges<OfWagon>,
    samples: Counters<OfWagon>,
    missed: Counters<OfWagon>,
    slide_energy: Counters<OfWheelset>,
    slide_seconds: Counters<OfWheelset>,
}

impl OfWagons {
    fn register(registry: &mut Registry) -> Self {
        fn gauge<L>(registry: &mut Registry, name: &str, help: &str) -> Gauges<L>
        where
            L: Clone + std::hash::Hash + Eq + EncodeLabelSet + std::fmt::Debug + Send + Sync + 'static,
        {
            let family = Gauges::<L>::default();
            registry.register(name, help, family.clone());
            family
        }
        fn counter<L>(registry: &mut Registry, name: &str, help: &str) -> Counters<L>
        where
            L: Clone + std::hash::Hash + Eq + EncodeLabelSet + std::fmt::Debug + Send + Sync + 'static,
        {
            let family = Counters::<L>::default();
            registry.register(name, help, family.clone());
            family
        }
        let r = registry;
        Self {
            info: gauge(r, "wagon_info", "1, with the name and the vehicle number of the wagon"),
            up: gauge(r, "wagon_up", "1 if news of the wagon arrive"),
            age: gauge(r, "wagon_data_age_seconds", "Age of the last sample of the wagon"),
            grade: gauge(r, "wagon_grade", "Worst grade: 0 unknown, 1 ok, 2 watch, 3 act"),
            speed: gauge(r, "wagon_speed_meters_per_second", "Speed over ground"),
            condition: gauge(
                r,
                "rail_condition_probability_ratio",
                "Probability of each condition of the rail",
            ),
            heard_wet: gauge(r, "heard_wet_probability_ratio", "Probability by ear that the rail is wet"),
            samples: counter(r, "samples_received", "Samples taken in"),
            missed: counter(r, "samples_missed", "Samples that never arrived"),
            slide_energy: counter(r, "slide_energy_joules", "Energy of slides"),
            slide_seconds: counter(r, "slide_seconds", "Time of slides"),
        }
    }

    fn fill(&mut self, view: &WagonView) {
        let (name, vehicle_number) = (view.name.clone(), view.vehicle_number.clone().unwrap_or_default());
        self.info.get_or_create(&Who { wagon: view.id, name, vehicle_number }).set(1.0);
        let wagon = OfWagon { wagon: view.id };
        let set = |family: &Gauges<OfWagon>, value: Option<f64>| {
            if let Some(value) = value {
                family.get_or_create(&wagon).set(value);
            }
        };
        let live = view.state == DataState::Live;
        set(&self.up, Some(f64::from(u8::from(live))));
        set(&self.age, view.age_s);
        set(&self.grade, Some(grade_code(view.grade)));
        self.samples.get_or_create(&wagon).inc_by(view.samples as f64);
        self.missed.get_or_create(&wagon).inc_by(view.samples_missed as f64);
        for wheelset in &view.wheelsets {
            let label = OfWheelset { wagon: view.id, wheelset: wheelset.id };
            self.slide_energy.get_or_create(&label).inc_by(wheelset.slide_energy_j);
            self.slide_seconds.get_or_create(&label).inc_by(wheelset.slide_s);
        }
        set(&self.heard_wet, view.acoustic.as_ref().and_then(|acoustic| acoustic.wet_probability));
        if !live {
            return;
        }
        set(&self.speed, view.now.as_ref().and_then(|now| now.v_m_s));
        let conditions = [
            (Condition::Dry, view.rail_dry),
            (Condition::Wet, view.rail_wet),
            (Condition::Low, view.rail_low),
            (Condition::VeryLow, view.rail_very_low),
        ];
        for (condition, probability) in conditions {
            let label = OfCondition { wagon: view.id, condition: condition.word() };
            if let Some(probability) = probability {
                self.condition.get_or_create(&label).set(probability);
            }
        }
    }
}

/// Registers the metrics of the indicators, as the table names them, with what is known now.
fn of_table(registry: &mut Registry, snapshot: &Snapshot) {
    // What rests on assumptions alone is no figure of this train.
    let told = snapshot.whole.found.known_wagons > 0;
    for spec in snapshot.table.iter() {
        let Some(metric) = spec.metric else { continue };
        if spec.judge.train.is_some() {
            let judged = snapshot.whole.judged.iter().find(|(own, _)| own.id == spec.id);
            let gauge = Gauge::<f64, AtomicU64>::default();
            if let Some(value) =
                judged.and_then(|(_, indicator)| indicator.figure()).filter(|value| told && value.is_finite())
            {
                gauge.set(value);
                registry.register(metric.name, metric.help, gauge);
            }
            continue;
        }
        if metric.reach.wagon() {
            let of_wagon = |view: &WagonView| {
                let value = figure(view, &view.indicators, spec, metric)?;
                Some((OfWagon { wagon: view.id }, value))
            };
            let values = snapshot.wagons.iter().filter_map(of_wagon);
            register(registry, metric.name.to_owned(), metric, values);
        }
        if metric.reach.wheelsets() {
            let values = snapshot.wagons.iter().flat_map(|view| {
                view.wheelsets.iter().filter_map(move |wheelset| {
                    let value = figure(view, &wheelset.indicators, spec, metric)?;
                    Some((OfWheelset { wagon: view.id, wheelset: wheelset.id }, value))
                })
            });
            let name =
                if metric.counter { metric.name.to_owned() } else { format!("wheelset_{}", metric.name) };
            register(registry, name, metric, values);
        }
    }
}

/// The figure of an indicator for Prometheus. A gauge of a wagon that is not live is left out; a counter stays.
fn figure(view: &WagonView, figures: &Figures, spec: &IndicatorSpec, metric: Metric) -> Option<f64> {
    let value = figures.get(spec).and_then(|figure| figure.value);
    if metric.counter { Some(value.unwrap_or(0.0)) } else { value.filter(|_| view.state == DataState::Live) }
}

fn register<L>(registry: &mut Registry, name: String, metric: Metric, values: impl Iterator<Item = (L, f64)>)
where
    L: Clone + std::hash::Hash + Eq + EncodeLabelSet + std::fmt::Debug + Send + Sync + 'static,
{
    if metric.counter {
        let family = Counters::<L>::default();
        values.for_each(|(label, value)| {
            family.get_or_create(&label).inc_by(value);
        });
        registry.register(name, metric.help, family);
    } else {
        let family = Gauges::<L>::default();
        values.for_each(|(label, value)| {
            family.get_or_create(&label).set(value);
        });
        registry.register(name, metric.help, family);
    }
}

struct OfProcesses {
    uptime: Gauges<OfProcess>,
    unseen: Counters<OfProcess>,
    rejected: Counters<OfProcess>,
    late: Counters<OfProcess>,
    published: Counters<OfProcess>,
    step: Gauges<OfQuantile>,
    latency: Gauges<OfQuantile>,
}

impl OfProcesses {
    fn register(registry: &mut Registry) -> Self {
        let all = Self {
            uptime: Family::default(),
            unseen: Family::default(),
            rejected: Family::default(),
            late: Family::default(),
            published: Family::default(),
            step: Family::default(),
            latency: Family::default(),
        };
        registry.register("process_uptime_seconds", "Since the process started", all.uptime.clone());
        registry.register(
            "process_unseen",
            "Samples that were sent while no process of this kind and wagon was there, since the train has started",
            all.unseen.clone(),
        );
        registry.register(
            "process_rejected",
            "Samples or values refused by validation",
            all.rejected.clone(),
        );
        registry.register(
            "process_late",
            "Samples dropped because their time is not after that of the sample before",
            all.late.clone(),
        );
        registry.register("process_published", "Samples or estimates sent", all.published.clone());
        registry.register("estimator_step_seconds", "Duration of one step of the filter", all.step.clone());
        let help = "Time from acquisition of a sample to publication of its estimate";
        registry.register("estimator_latency_seconds", help, all.latency.clone());
        all
    }

    fn fill(&self, view: &ProcessView) {
        let wagon = view.wagon.unwrap_or(0);
        let label = OfProcess { process: view.process.clone(), wagon };
        self.uptime.get_or_create(&label).set(view.uptime_s);
        self.unseen.get_or_create(&label).inc_by(view.unseen as f64);
        self.rejected.get_or_create(&label).inc_by(view.rejected as f64);
        self.late.get_or_create(&label).inc_by(view.late as f64);
        self.published.get_or_create(&label).inc_by(view.published as f64);
        let times = [
            (&self.step, "0.5", view.step_p50_ns),
            (&self.step, "0.99", view.step_p99_ns),
            (&self.latency, "0.5", view.latency_p50_ns),
            (&self.latency, "0.99", view.latency_p99_ns),
        ];
        for (family, quantile, ns) in times.into_iter().filter(|(.., ns)| *ns > 0) {
            family.get_or_create(&OfQuantile { wagon, quantile }).set(ns as f64 * 1e-9);
        }
    }
}

fn grade_code(grade: Grade) -> f64 {
    match grade {
        Grade::Unknown => 0.0,
        Grade::Ok => 1.0,
        Grade::Watch => 2.0,
        Grade::Act => 3.0,
    }
}
