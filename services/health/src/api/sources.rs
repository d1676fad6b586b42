//! What the source of samples has counted, for JSON and for Prometheus.

use crate::api::figure::rounded;
use crate::api::train::model::SourceView;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::Registry;
use railgrip_messages::{NO_WAGON, SourceCount, SourceState};
use std::sync::atomic::AtomicU64;

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfCount {
    wagon: u32,
    kind: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfWagon {
    wagon: u32,
}

/// What a message of ingest says, with the number of the vehicle that it is about.
pub(crate) fn source(state: &SourceState, vehicle: Option<&str>) -> SourceView {
    let counted = SourceCount::ALL.iter().map(|what| (what.word().to_owned(), state.count(*what)));
    SourceView {
        wagon: (state.wagon != NO_WAGON).then_some(state.wagon),
        vehicle_number: vehicle.map(str::to_owned),
        clock_drift_ppm: (state.drift_known != 0).then(|| rounded(state.drift_ppm)),
        counts: counted.filter(|(_, count)| *count > 0).collect(),
    }
}

/// Its metrics; wagon 0 is the source as a whole.
pub(crate) fn register(registry: &mut Registry, sources: &[SourceView]) {
    if sources.is_empty() {
        return;
    }
    let counts: Family<OfCount, Counter<f64, AtomicU64>> = Family::default();
    let help = "What the source of samples has counted, by kind; wagon 0 is the source as a whole";
    registry.register("source_events", help, counts.clone());
    let drifts: Family<OfWagon, Gauge<f64, AtomicU64>> = Family::default();
    let help = "How much faster our clock runs than that of the source of a wagon";
    registry.register("source_clock_drift_ratio", help, drifts.clone());
    for view in sources {
        let wagon = view.wagon.unwrap_or(NO_WAGON);
        for (kind, count) in &view.counts {
            counts.get_or_create(&OfCount { wagon, kind: kind.clone() }).inc_by(*count as f64);
        }
        if let Some(ppm) = view.clock_drift_ppm {
            drifts.get_or_create(&OfWagon { wagon }).set(ppm * 1e-6);
        }
    }
}
