//! The processes of the train, by their last heartbeats.

use crate::api::figure::{milliseconds, rounded};
use railgrip_messages::{Heartbeat, NO_WAGON};
use serde::Serialize;
use utoipa::ToSchema;

/// A process of the train.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ProcessView {
    /// `ingest`, `estimator`, ...
    pub process: String,
    /// The wagon it serves.
    pub wagon: Option<u32>,
    /// The number of its vehicle, as it is written; `null` without one.
    pub vehicle_number: Option<String>,
    /// Process id.
    pub pid: u32,
    /// Since its last sign of life, s.
    pub age_s: f64,
    /// Since it started, s.
    pub uptime_s: f64,
    /// Samples taken in.
    pub received: u64,
    /// Samples that never arrived.
    pub missed: u64,
    /// Samples that were sent while no process of this kind and wagon was there, since the train has started.
    pub unseen: u64,
    /// Samples or values refused.
    pub rejected: u64,
    /// Samples dropped because their time is not after that of the sample before.
    pub late: u64,
    /// Samples or estimates sent.
    pub published: u64,
    /// Median duration of one step of the filter, ns.
    pub step_p50_ns: u64,
    /// 99th percentile of the duration of one step of the filter, ns.
    pub step_p99_ns: u64,
    /// Median time from acquisition to publication, ns.
    pub latency_p50_ns: u64,
    /// 99th percentile of the time from acquisition to publication, ns.
    pub latency_p99_ns: u64,
}

/// A process by its last heartbeat, with the number of the vehicle that it serves.
pub(crate) fn process(beat: &Heartbeat, vehicle: Option<&str>, now_ns: u64) -> ProcessView {
    ProcessView {
        process: beat
            .process()
            .map_or_else(|| format!("kind {}", beat.process), |kind| kind.word().to_owned()),
        wagon: (beat.wagon != NO_WAGON).then_some(beat.wagon),
        vehicle_number: vehicle.map(str::to_owned),
        pid: beat.pid,
        age_s: milliseconds(beat.stamp.age_s(now_ns)),
        uptime_s: rounded(beat.uptime_s),
        received: beat.received,
        missed: beat.missed,
        unseen: u64::from(beat.unseen),
        rejected: beat.rejected,
        late: beat.late,
        published: beat.published,
        step_p50_ns: beat.step_p50_ns,
        step_p99_ns: beat.step_p99_ns,
        latency_p50_ns: beat.latency_p50_ns,
        latency_p99_ns: beat.latency_p99_ns,
    }
}
