//! The filters on a test's samples, and what comes out of them.

use super::run::{Case, DURATION_S, Instant, SENSOR_SIGMA, simulate};
use railgrip_filter::models::traction_rig::{
    TractionBelief, TractionEkf, TractionEstimate, TractionFilter, TractionModel, TractionNoise,
    TractionState, TractionUkf,
};
use railgrip_vehicle::adhesion::creep_force_at;
use railgrip_vehicle::traction_rig::TractionRig;

/// Estimates before this time are not judged, s.
pub const JUDGED_FROM_S: f64 = 2.0;

/// The first acceleration and braking are over, s: μ0 is no longer the prior's.
pub const SECOND_ROUND_S: f64 = 12.0;

/// Estimates of one filter on one test, summed up.
#[derive(Clone, Copy, Debug, Default)]
pub struct Summary {
    /// Mean of μ0 over the test.
    pub adhesion_peak: f64,
    /// Root mean square of its error.
    pub adhesion_peak_rms: f64,
    /// Root mean square of what the filter says about that error.
    pub adhesion_peak_sigma: f64,
    /// Root mean square error of the creep force, N.
    pub creep_force_rms_n: f64,
    /// The same from [`SECOND_ROUND_S`] on.
    pub creep_force_rms_late_n: f64,
    /// Mean creep force in truth from then on, N.
    pub creep_force_late_n: f64,
    /// Root mean square error of the creepage.
    pub creepage_rms: f64,
    /// Mean normalised innovation squared, seven values a step.
    pub nis: f64,
    /// Share of samples in which μ0 was not called unobservable.
    pub seen: f64,
    /// Mean of μ0 over those samples; NaN if there are none.
    pub adhesion_peak_seen: f64,
    /// Number of those samples.
    pub seen_samples: f64,
    /// Mean creepage in truth.
    pub creepage: f64,
    /// Largest creepage in truth.
    pub creepage_max: f64,
}

/// One test with all its filters.
#[derive(Clone, Debug)]
pub struct CaseResult {
    /// Which.
    pub case: Case,
    /// The run.
    pub run: Vec<Instant>,
    /// Estimates of the unscented filter.
    pub ukf: Vec<TractionEstimate>,
    /// The unscented filter.
    pub ukf_summary: Summary,
    /// The extended filter on the same samples.
    pub ekf_summary: Summary,
    /// The unscented filter with the paper's noise and a voltage that stands still between samples.
    pub paper_summary: Summary,
}

impl CaseResult {
    /// Runs a test and all filters on it.
    pub fn new(case: Case, seed: u64) -> Self {
        let run = simulate(case, seed, DURATION_S, SENSOR_SIGMA);
        let model = TractionModel::new(case.rig());
        let paper_model =
            TractionModel { voltage_turns: false, friction_memory_s: f64::INFINITY, ..model.clone() };
        let ukf = estimate(TractionUkf::new(model.clone(), TractionNoise::default()), &run);
        let ekf = estimate(TractionEkf::new(model, TractionNoise::default()), &run);
        let paper = estimate(TractionUkf::new(paper_model, TractionNoise::zhao2014()), &run);
        let summary = |estimates: &[TractionEstimate]| summarise(case, &run, estimates);
        let (ukf_summary, ekf_summary, paper_summary) = (summary(&ukf), summary(&ekf), summary(&paper));
        Self { case, run, ukf, ukf_summary, ekf_summary, paper_summary }
    }

    /// What to call the whole test: nothing seen in most of its samples means that its mean says nothing.
    pub fn state(&self) -> TractionState {
        if self.ukf_summary.seen < 0.5 {
            TractionState::Unobservable
        } else if self.ukf_summary.adhesion_peak_sigma > 0.15 * self.ukf_summary.adhesion_peak {
            TractionState::Weak
        } else {
            TractionState::Observable
        }
    }
}

/// Runs a filter over the samples.
pub fn estimate<B: TractionBelief>(mut filter: TractionFilter<B>, run: &[Instant]) -> Vec<TractionEstimate> {
    run.iter().map(|instant| filter.step(&instant.sample)).collect()
}

fn summarise(case: Case, run: &[Instant], estimates: &[TractionEstimate]) -> Summary {
    let mut sum = Summary::default();
    let truth = case.surface.adhesion_peak();
    let judged = run.iter().zip(estimates).filter(|(instant, _)| instant.sample.time_s >= JUDGED_FROM_S);
    let (mut count, mut late) = (0.0, 0.0);
    for (instant, estimate) in judged {
        count += 1.0;
        sum.adhesion_peak += estimate.adhesion_peak;
        sum.adhesion_peak_rms += (estimate.adhesion_peak - truth).powi(2);
        sum.adhesion_peak_sigma += estimate.adhesion_peak_sigma.powi(2);
        sum.creep_force_rms_n += (estimate.creep_force_n - instant.contact.force.force_n).powi(2);
        if instant.sample.time_s >= SECOND_ROUND_S {
            late += 1.0;
            sum.creep_force_rms_late_n += (estimate.creep_force_n - instant.contact.force.force_n).powi(2);
            sum.creep_force_late_n += instant.contact.force.force_n.abs();
        }
        sum.creepage_rms += (estimate.creepage - instant.contact.creepage).powi(2);
        sum.nis += estimate.nis;
        sum.creepage += instant.contact.creepage;
        sum.creepage_max = sum.creepage_max.max(instant.contact.creepage);
        if matches!(estimate.state, TractionState::Weak | TractionState::Observable) {
            sum.seen_samples += 1.0;
            sum.adhesion_peak_seen += estimate.adhesion_peak;
        }
    }
    Summary {
        adhesion_peak: sum.adhesion_peak / count,
        adhesion_peak_rms: (sum.adhesion_peak_rms / count).sqrt(),
        adhesion_peak_sigma: (sum.adhesion_peak_sigma / count).sqrt(),
        creep_force_rms_n: (sum.creep_force_rms_n / count).sqrt(),
        creep_force_rms_late_n: (sum.creep_force_rms_late_n / late).sqrt(),
        creep_force_late_n: sum.creep_force_late_n / late,
        creepage_rms: (sum.creepage_rms / count).sqrt(),
        nis: sum.nis / count,
        seen: sum.seen_samples / count,
        adhesion_peak_seen: sum.adhesion_peak_seen / sum.seen_samples,
        seen_samples: sum.seen_samples,
        creepage: sum.creepage / count,
        creepage_max: sum.creepage_max,
    }
}

/// One point of the creep curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// γ.
    pub creepage: f64,
    /// V, m/s.
    pub speed_m_s: f64,
    /// F_γ, N.
    pub creep_force_n: f64,
}

/// The (γ, F_γ) points of a filter, means over 100 ms each.
pub fn curve_points(result: &CaseResult) -> Vec<CurvePoint> {
    const MEAN_OVER: usize = 100;
    let rig = result.case.rig();
    let from = (JUDGED_FROM_S / super::run::SAMPLE_PERIOD_S) as usize;
    let pairs: Vec<_> = result.run.iter().zip(&result.ukf).skip(from).collect();
    let mut points = Vec::with_capacity(pairs.len() / MEAN_OVER);
    for chunk in pairs.chunks_exact(MEAN_OVER) {
        let mut point = CurvePoint { creepage: 0.0, speed_m_s: 0.0, creep_force_n: 0.0 };
        for (instant, estimate) in chunk {
            let sample = &instant.sample;
            point.creepage += estimate.creepage / MEAN_OVER as f64;
            point.speed_m_s +=
                rig.speeds_m_s(sample.motor_speed_rad_s, sample.roller_speed_rad_s).1 / MEAN_OVER as f64;
            point.creep_force_n += estimate.creep_force_n / MEAN_OVER as f64;
        }
        points.push(point);
    }
    points
}

/// Creep force of Polach's law at a point, N.
pub fn polach_n(rig: &TractionRig, creepage: f64, speed_m_s: f64, adhesion_peak: f64) -> f64 {
    let load = rig.parameters.drivetrain.normal_load_n;
    creep_force_at(rig.contact(), creepage * speed_m_s, speed_m_s, load, adhesion_peak).force_n
}

/// μ0 of Polach's law that fits the points best (least squares in the force), by golden-section search in ln μ0.
pub fn fit_adhesion_peak(rig: &TractionRig, points: &[CurvePoint]) -> f64 {
    let cost = |ln_peak: f64| -> f64 {
        points
            .iter()
            .map(|point| {
                let law = polach_n(rig, point.creepage, point.speed_m_s, ln_peak.exp());
                (point.creep_force_n - law).powi(2)
            })
            .sum()
    };
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.005f64.ln(), 1f64.ln());
    while high - low > 1e-6 {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if cost(left) < cost(right) { high = right } else { low = left }
    }
    (0.5 * (low + high)).exp()
}
