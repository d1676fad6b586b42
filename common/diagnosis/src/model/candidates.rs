//! The library of candidates: every effect of the catalogue as a candidate, with the starts from which it is fitted.

use crate::data::case::Case;
use crate::model::parameters::FittedEffect;
use crate::model::track_offset;
use railgrip_vehicle::effects::{self, Constructor, EffectSpec, ParameterSpec, Term};
use rayon::prelude::*;

/// A candidate: one effect, its forms (values of discrete parameters) and starts.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// One entry for each start of a fit.
    pub starts: Vec<FittedEffect>,
}

impl Candidate {
    /// Whether it acts on a stretch of track, which is to be found.
    pub(crate) fn is_stretch(&self) -> bool {
        start_of_stretch(self.spec).is_some()
    }

    /// The effect on many stretches of the track of a case, short ones and long ones, each overlapping the next by half; none if it
    /// does not act on a stretch.
    pub(crate) fn scan(&self, case: &Case) -> Vec<FittedEffect> {
        let Some(first) = self.starts.first().filter(|_| self.is_stretch()) else { return Vec::new() };
        let (from, to) = track(case);
        let on = |(begin, share): (f64, f64)| {
            let mut effect = first.clone();
            for parameter in &mut effect.parameters {
                let value = match parameter.name.as_str() {
                    "start_m" => from + begin * (to - from),
                    "length_m" => share * (to - from),
                    "edge_m" => EDGE_SHARE * share * (to - from),
                    _ => continue,
                };
                parameter.start = value.clamp(parameter.lower, parameter.upper);
            }
            effect
        };
        let of_length = |share: f64| {
            let number = (2.0 * (1.0 - share) / share).ceil() as usize;
            (0..=number).map(move |index| ((0.5 * share * index as f64).min(1.0 - share), share))
        };
        SCANNED.into_iter().flat_map(of_length).map(on).collect()
    }
}

impl Candidate {
    /// Where a fit of an oscillation starts: the frequency that costs least of many, and at that the best share of what swings,
    /// because a fit finds neither from afar. `None` if the effect does not swing.
    pub(crate) fn nearest(&self, cost: &(dyn Fn(&FittedEffect) -> f64 + Sync)) -> Option<FittedEffect> {
        let least = |effects: Vec<FittedEffect>| {
            let costs: Vec<f64> = effects.par_iter().map(cost).collect();
            let all = costs.into_iter().zip(effects);
            all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, effect)| effect)
        };
        let frequency = least(self.frequencies())?;
        least(INERTIA_FACTORS.iter().filter_map(|factor| at_same_frequency(&frequency, *factor)).collect())
    }

    /// The effect in each of its forms with many frequencies, if it swings, at half of the inertia that it can have and damped so
    /// well that a frequency nearby is told; none otherwise.
    fn frequencies(&self) -> Vec<FittedEffect> {
        let mut forms: Vec<&FittedEffect> = Vec::new();
        for start in &self.starts {
            let is_known = |form: &&FittedEffect| {
                form.fixed.iter().map(|v| v.to_bits()).eq(start.fixed.iter().map(|v| v.to_bits()))
            };
            if !forms.iter().any(is_known) {
                forms.push(start);
            }
        }
        let frequencies: Vec<f64> = std::iter::successors(Some(LEAST_HZ), |hz| Some(FREQUENCY_RATIO * hz))
            .take_while(|hz| *hz < MOST_HZ)
            .collect();
        forms.into_iter().flat_map(|form| frequencies.iter().filter_map(|hz| swinging(form, *hz))).collect()
    }
}

fn position(effect: &FittedEffect, name: &str) -> Option<usize> {
    effect.parameters.iter().position(|p| p.name == name)
}

/// Holds what swings to its largest share of a wheelset's moment of inertia, kg m².
fn hold_within_wheelset(effect: &mut FittedEffect, wheelset_kg_m2: f64) {
    let Some(heavy) = position(effect, INERTIA) else { return };
    let parameter = &mut effect.parameters[heavy];
    let largest = effects::LARGEST_DISC_SHARE * wheelset_kg_m2;
    parameter.upper = parameter.upper.min(largest).max(parameter.lower);
    parameter.start = parameter.start.min(parameter.upper);
}

/// An effect that swings so many times a second; `None` if it does not swing, or not at that frequency.
fn swinging(form: &FittedEffect, hz: f64) -> Option<FittedEffect> {
    let (soft, heavy, damped) =
        (position(form, COMPLIANCE)?, position(form, INERTIA)?, position(form, DAMPING)?);
    let mut effect = form.clone();
    let inertia = 0.5 * effect.parameters[heavy].upper;
    let compliance = 1e3 / (inertia * (std::f64::consts::TAU * hz).powi(2));
    for (index, value) in [(soft, compliance), (heavy, inertia), (damped, WELL_DAMPED)] {
        let parameter = &mut effect.parameters[index];
        if !(parameter.lower..parameter.upper).contains(&value) {
            return None;
        }
        parameter.start = value;
    }
    Some(effect)
}

/// An effect that swings as often, with so many times the inertia: the more inertia, the less a torque makes it swing.
fn at_same_frequency(effect: &FittedEffect, factor: f64) -> Option<FittedEffect> {
    let (soft, heavy) = (position(effect, COMPLIANCE)?, position(effect, INERTIA)?);
    let mut effect = effect.clone();
    for (index, factor) in [(soft, factor.recip()), (heavy, factor)] {
        let parameter = &mut effect.parameters[index];
        parameter.start = (factor * parameter.start).clamp(parameter.lower, parameter.upper);
    }
    Some(effect)
}

/// The parameter by which a shaft is soft.
const COMPLIANCE: &str = "compliance_rad_per_knm";
/// What swings on it.
const INERTIA: &str = "disc_inertia_kg_m2";
/// How soon that ends.
const DAMPING: &str = "damping_ratio";
/// Inertias that are scanned, relative to half of the largest.
const INERTIA_FACTORS: [f64; 4] = [1.0, 1.9, 0.5, 0.25];
/// Damping ratio during a scan.
const WELL_DAMPED: f64 = 0.1;
/// Frequencies that are scanned, Hz: from where nobody would drive on to where samples cannot follow.
const LEAST_HZ: f64 = 1.5;
const MOST_HZ: f64 = 25.0;
/// Between one and the next.
const FREQUENCY_RATIO: f64 = 1.12;

/// Index of the parameter that says where a stretch of track begins.
fn start_of_stretch(spec: &EffectSpec) -> Option<usize> {
    spec.parameters.iter().position(|parameter| parameter.name == "start_m")
}

/// All candidates but those in `without`: the catalogue in its order, then own effects. What only pushes the body of a
/// coupled wagon is not to be told from its couplers, and no candidate.
pub fn all(case: &Case, without: &[String]) -> Vec<Candidate> {
    let hidden = |term| case.is_coupled() && matches!(term, Term::Resistance | Term::LongitudinalForce);
    let known = effects::all().into_iter().filter(|(spec, _)| without.iter().all(|id| id != spec.id));
    let known = known.filter(|(spec, _)| !hidden(spec.term));
    known.map(|(spec, constructor)| candidate(case, spec, constructor)).collect()
}

fn candidate(case: &Case, spec: &'static EffectSpec, constructor: Constructor) -> Candidate {
    let track = track(case);
    let values: Vec<Vec<f64>> = match start_of_stretch(spec) {
        Some(start) => stretches(spec, start, track),
        None => grid(spec),
    };
    let values = with_discrete(spec, case.wheelsets(), values);
    let start = |values: &Vec<f64>| {
        let mut effect = FittedEffect::of_catalogue(spec, constructor, values);
        hold_within_wheelset(&mut effect, case.vehicle.wheelset.inertia_kg_m2);
        match track_offset::matters(spec) {
            true => effect.within_track(track).with_track_offsets(case.fit.len()),
            false => effect,
        }
    };
    Candidate { spec, starts: values.iter().map(start).collect() }
}

/// The parameter that numbers a wheelset.
const WHEELSET: &str = "wheelset";

/// Strength of the weakest start, as a share of the default: from one that is far too strong a few steps lead nowhere.
const WEAK: f64 = 0.1;

/// The defaults, each parameter's further starts one at a time, and the defaults at a weak strength.
fn grid(spec: &EffectSpec) -> Vec<Vec<f64>> {
    let default = |p: &ParameterSpec| p.default;
    let mut starts = vec![spec.parameters.iter().map(default).collect::<Vec<f64>>()];
    for (i, p) in spec.parameters.iter().enumerate().filter(|(_, p)| !p.discrete) {
        for &value in p.starts {
            let mut start = starts[0].clone();
            start[i] = value;
            starts.push(start);
        }
    }
    let weak = |p: &ParameterSpec| p.neutral.map_or(p.default, |none| none + WEAK * (p.default - none));
    let weak: Vec<f64> = spec.parameters.iter().map(weak).collect();
    if weak != starts[0] {
        starts.push(weak);
    }
    starts
}

/// All of `starts` for each value of each discrete parameter.
fn with_discrete(spec: &EffectSpec, wheelsets: usize, mut starts: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for (i, p) in spec.parameters.iter().enumerate().filter(|(_, p)| p.discrete) {
        // Wheelsets that the wagon has not got are not to blame.
        let exists = |value: &&f64| p.name != WHEELSET || **value <= wheelsets as f64;
        starts = p
            .starts
            .iter()
            .filter(exists)
            .flat_map(|&value| {
                let with = |start: &Vec<f64>| {
                    let mut start = start.clone();
                    start[i] = value;
                    start
                };
                starts.iter().map(with).collect::<Vec<_>>()
            })
            .collect();
    }
    starts
}

/// Stretches of a quarter of the track at its beginning, ..., at its end, with the first spread of wheelsets and with each other.
fn stretches(spec: &EffectSpec, start: usize, (from, to): (f64, f64)) -> Vec<Vec<f64>> {
    let length = to - from;
    let placed: Vec<Vec<f64>> = STRETCHES
        .iter()
        .map(|&(begin, share)| {
            let mut values: Vec<f64> = spec.parameters.iter().map(|p| p.default).collect();
            values[start] = from + begin * length;
            values[start + 1] = share * length;
            // Wide edges lead a fit to its place from afar.
            if let Some(edge) = spec.parameters.iter().position(|p| p.name == "edge_m") {
                values[edge] = EDGE_SHARE * share * length;
            }
            let clamp = |(v, p): (&f64, &ParameterSpec)| v.clamp(p.lower, p.upper);
            values.iter().zip(spec.parameters).map(clamp).collect()
        })
        .collect();
    let Some(spread) = spec.parameters.iter().position(|p| p.name == "spread") else { return placed };
    let with = |values: &Vec<f64>, other: f64| {
        let mut values = values.clone();
        values[spread] = other;
        values
    };
    let others = spec.parameters[spread].starts.iter();
    let spread_otherwise: Vec<Vec<f64>> = others
        .flat_map(|other| placed.iter().map(|values| with(values, *other)).collect::<Vec<_>>())
        .collect();
    placed.into_iter().chain(spread_otherwise).collect()
}

/// Length of the edges from which a fit starts, as a share of the stretch.
const EDGE_SHARE: f64 = 0.3;

/// Begin and length of the stretches tried, as shares of the track.
const STRETCHES: [(f64, f64); 6] =
    [(0.02, 0.15), (0.15, 0.15), (0.3, 0.15), (0.45, 0.2), (0.65, 0.2), (0.2, 0.5)];

/// Lengths of the stretches that are scanned, as shares of the track.
const SCANNED: [f64; 4] = [0.06, 0.12, 0.25, 0.5];

/// The stretch of track that the runs to fit on cover.
fn track(case: &Case) -> (f64, f64) {
    let positions = || case.fit.iter().flat_map(|run| [run.samples.first(), run.samples.last()]).flatten();
    let from = positions().map(|s| s.input.position_m).fold(f64::INFINITY, f64::min);
    let to = positions().map(|s| s.input.position_m).fold(f64::NEG_INFINITY, f64::max);
    if to > from { (from, to) } else { (0.0, 100.0) }
}
