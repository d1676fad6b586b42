//! What the HTML report shows beyond the report itself.

use crate::answer::schema::{Interval, Report};
use crate::answer::supplement::{
    Alarm, Axis, CandidateDetail, Curve, CurvePoint, Detail, FreedPlace, ParameterRow, RunRow, Tie, Trace,
    TraceWindow,
};
use crate::data::case::{Case, Run};
use crate::decide::acceptance;
use crate::decide::criteria::Criteria;
use crate::decide::evidence::Judgement;
use crate::decide::selection::Selection;
use crate::fit::candidate::Fitted;
use crate::fit::solver::assemble;
use crate::fit::windows::{self, Models};
use crate::model::discrepancy::{Covariate, Place};
use crate::model::parameters::Built;
use crate::model::places;
use crate::predict::localise::PlaceEvidence;
use crate::predict::open_loop::{Tally, sigmas};
use crate::write::effect_curve::{FittedModel, effect_curve};
use crate::write::events;
use crate::write::predictions::Predicted;

/// Two-sided 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.96;
/// 95 % intervals of every parameter of the extended model.
pub(crate) fn intervals(selection: &Selection, models: &Models, widening: f64) -> Vec<Interval> {
    let best = &selection.best.fitted;
    let shape = &models.extended_shape;
    let wide = |i: usize| {
        let p = &shape.parameters()[i];
        [p.lower, p.upper]
    };
    if best.fit.theta.len() != models.extended.len() {
        return (0..models.extended.len()).map(wide).collect();
    }
    let (_, curvature) = assemble(best.shape.parameters(), &best.fit.theta, &best.fit.blocks);
    let n = best.fit.theta.len();
    let scaled = nalgebra::DMatrix::from_fn(n, n, |i, j| {
        let p = best.shape.parameters();
        curvature[(i, j)] * p[i].scale * p[j].scale + if i == j { 1e-9 } else { 0.0 }
    });
    let Some(inverse) = scaled.try_inverse() else { return (0..n).map(wide).collect() };
    (0..n)
        .map(|i| {
            let p = &best.shape.parameters()[i];
            let sigma = widening * inverse[(i, i)].max(0.0).sqrt() * p.scale;
            // The two fits see different noise: where they differ, both belong into the interval.
            let (a, b) = (models.extended[i], best.fit.theta[i]);
            let half = NORMAL_95 * sigma;
            [(a.min(b) - half).max(p.lower).min(a), (a.max(b) + half).min(p.upper).max(a)]
        })
        .collect()
}

/// Whether the intervals of an effect's strength all hold the value at which it does nothing.
pub(crate) fn may_do_nothing(selection: &Selection, models: &Models, effect: usize, widening: f64) -> bool {
    let all = intervals(selection, models, widening);
    let shape = &models.extended_shape;
    let own = &shape.effects[effect];
    let neutral = |name: &str| own.spec.parameters.iter().find(|p| p.name == name).and_then(|p| p.neutral);
    let strengths = own.parameters.iter().zip(shape.range_of(effect));
    let mut holds =
        strengths.filter_map(|(p, i)| neutral(&p.name).map(|n| (all[i][0]..=all[i][1]).contains(&n)));
    holds.next() == Some(true) && holds.all(|held| held)
}

/// Gap of the fitted runs, open loop, with a model as the errors of its filter fit it.
pub(crate) fn fit_gap(case: &Case, fitted: &Fitted) -> f64 {
    Tally::total(&windows::tallies(case, &fitted.shape, &fitted.fit.theta)).gap()
}

pub(crate) fn detail(
    case: &Case,
    selection: &Selection,
    judgement: &Judgement,
    models: &Models,
    report: &Report,
    criteria: &Criteria,
) -> Detail {
    let vehicle = &case.vehicle;
    Detail {
        subject: format!(
            "wagon \"{}\", {:.1} t, {} wheelsets",
            vehicle.name,
            vehicle.body.mass_kg / 1e3,
            vehicle.wheelsets()
        ),
        notes: notes(case),
        events: events::events(case),
        rule: judgement.decision.rule.words.to_owned(),
        parameters: parameters(selection, models, report, criteria.report.widening),
        candidates: candidate_details(selection, report),
        gap_without_any: Some(fit_gap(case, &selection.base.fitted)),
        ties: ties(report),
        freed: freed(case.wheelsets(), selection, report),
        missing_curve: missing_curve(judgement, report),
        alarm: judgement.chance.as_ref().map(|chance| Alarm {
            statistic: "log-likelihood of whitened innovations gained by the best candidate, where it is small without the few stretches that gain most"
                .into(),
            level: criteria.significance.level,
            threshold: chance.threshold(),
            observed: (selection.rounds[0].gains.iter())
                .map(|g| acceptance::counted_gain(&selection.base, g, criteria))
                .fold(0.0, f64::max),
            how: "the errors that the final model leaves got random signs, stretch by stretch, and every candidate was \
                  fitted to them in linear form"
                .into(),
            replicates: criteria.significance.replicates,
        }),
        ..Detail::default()
    }
}

fn notes(case: &Case) -> Vec<String> {
    let mut notes = Vec::new();
    if case.fit.iter().any(|run| !run.has_position) {
        notes.push("Some runs have no positions: the integral of speed stands in for them.".to_owned());
    }
    notes
}

fn parameters(selection: &Selection, models: &Models, report: &Report, widening: f64) -> Vec<ParameterRow> {
    let shape = &models.extended_shape;
    let intervals = intervals(selection, models, widening);
    let owner = |i: usize| {
        (0..shape.effects.len())
            .find(|e| shape.range_of(*e).contains(&i))
            .map_or("nuisance", |e| shape.effects[e].spec.id)
    };
    let stated = |owner: &str, name: &str| {
        let effect = report.effects.iter().find(|effect| effect.id == owner)?;
        effect.parameters.get(name).map(|estimate| estimate.ci95)
    };
    shape
        .parameters()
        .iter()
        .enumerate()
        .map(|(i, p)| ParameterRow {
            owner: owner(i).to_owned(),
            name: p.name.clone(),
            nominal: (owner(i) == "nuisance").then_some(0.0),
            value: models.extended[i],
            ci95: stated(owner(i), &p.name).unwrap_or(intervals[i]),
            bounds: [p.lower, p.upper],
        })
        .collect()
}

fn candidate_details(selection: &Selection, report: &Report) -> Vec<CandidateDetail> {
    let Some(round) = selection.rounds.first() else { return Vec::new() };
    report
        .candidates
        .iter()
        .filter_map(|candidate| {
            let gain = round.of(&candidate.id)?;
            let effect = gain.fitted.shape.effects.last()?;
            let range = gain.fitted.shape.range_of(gain.fitted.shape.effects.len() - 1);
            let values = &gain.fitted.fit.theta[range];
            let near = |a: f64, b: f64, p: &crate::model::parameters::Parameter| {
                (a - b).abs() < 1e-6 * (p.upper - p.lower)
            };
            let on_bound = effect.parameters.iter().zip(values);
            let n = gain.by_run.len().max(2) as f64;
            let mean = gain.by_run.iter().sum::<f64>() / n;
            let spread = gain.by_run.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let scale = if gain.predictive != 0.0 { candidate.cv_gain / gain.predictive } else { 0.0 };
            let half = 2.0 * (spread * n).sqrt() * scale.abs();
            Some(CandidateDetail {
                id: candidate.id.clone(),
                cv_gain_interval: Some([candidate.cv_gain - half, candidate.cv_gain + half]),
                form: effect.spec.equation.to_owned(),
                on_bound: on_bound
                    .filter(|(p, v)| near(**v, p.lower, p) || near(**v, p.upper, p))
                    .map(|(p, _)| p.name.clone())
                    .collect(),
            })
        })
        .collect()
}

/// What freeing each place gains, before and after the effects.
fn freed(wheelsets: usize, selection: &Selection, report: &Report) -> Vec<FreedPlace> {
    let same = |a: &PlaceEvidence, b: &PlaceEvidence| a.place == b.place && a.scope == b.scope;
    let shown = |place: &PlaceEvidence| {
        let axis = missing_axis(place.place);
        let scope = match place.scope.words(wheelsets) {
            all if all.is_empty() => all,
            some => format!(", {some}"),
        };
        let after =
            selection.rest.iter().find(|rest| same(rest, place)).filter(|_| !report.effects.is_empty());
        FreedPlace {
            place: format!("{}{scope}", axis.label.trim_start_matches("missing ")),
            terms: terms_at(place.place),
            before: place.evidence,
            after: after.map(|rest| rest.evidence),
            size: place.amplitude,
            unit: axis.unit,
            time_s: place.time_s,
        }
    };
    selection.places.iter().map(shown).collect()
}

/// Terms of the catalogue whose effects show at a place.
fn terms_at(place: Place) -> Vec<String> {
    let mut terms: Vec<_> = railgrip_vehicle::effects::all()
        .iter()
        .map(|(spec, _)| spec.term)
        .filter(|term| places::of(*term).contains(&place))
        .collect();
    terms.sort_unstable();
    terms.dedup();
    terms.into_iter().map(|term| term.name().to_owned()).collect()
}

fn ties(report: &Report) -> Vec<Tie> {
    report
        .effects
        .iter()
        .filter(|e| !e.equivalent.is_empty())
        .map(|e| Tie {
            ids: std::iter::once(e.id.clone()).chain(e.equivalent.iter().cloned()).collect(),
            because: railgrip_vehicle::effects::find(&e.id)
                .map(|(spec, _)| {
                    format!("they predict the recordings equally well; separated by {}", spec.separated_by)
                })
                .unwrap_or_default(),
        })
        .collect()
}

/// What is missing at a place of the equations, in words.
fn missing_axis(place: Place) -> Axis {
    let (label, unit) = match place {
        Place::BodyForce => ("missing force on the body", "N"),
        Place::WheelTorque => ("missing torque on wheelsets", "N m"),
        Place::PadFriction => ("missing share of pad friction", ""),
        Place::Adhesion => ("missing share of adhesion", ""),
        Place::WheelSensor => ("missing error of wheelset speed", "rad/s"),
        Place::LoadShift => ("missing share of load on the front wheelset", ""),
        Place::WheelScale => ("missing share of wheelset speed", ""),
        Place::SpeedSensor => ("missing error of vehicle speed", "m/s"),
        Place::DriveTorque => ("missing share of drive torque", ""),
    };
    Axis { label: label.to_owned(), unit: unit.to_owned() }
}

fn missing_curve(judgement: &Judgement, report: &Report) -> Option<Curve> {
    let missing = judgement.missing.as_ref()?;
    let unexplained = report.unexplained.as_ref()?;
    let covariate = missing.discrepancy.covariate;
    let (factor, unit) = match covariate.unit() {
        "N" => (1e-3, "kN"),
        "W" => (1e-3, "kW"),
        "J" => (1e-6, "MJ"),
        unit => (1.0, unit),
    };
    Some(Curve {
        title: format!("missing in {}", unexplained.term),
        equation: String::new(),
        x: Axis {
            label: if covariate == Covariate::Temperature { "disc temperature" } else { covariate.name() }
                .into(),
            unit: unit.into(),
        },
        y: missing_axis(missing.discrepancy.place),
        points: unexplained
            .curve
            .iter()
            .map(|p| CurvePoint { x: factor * p[0], y: p[1], low: f64::NAN, high: f64::NAN })
            .collect(),
        reference: [unexplained.curve.first(), unexplained.curve.last()]
            .into_iter()
            .flatten()
            .map(|p| [factor * p[0], 0.0])
            .collect(),
        data: Vec::new(),
        region: report.location.regime.as_ref().filter(|r| r.variable == covariate.name()).map(|r| r.range),
    })
}

/// Adds the table of runs and the window in which the calibrated model is worst.
pub(crate) fn add_runs(detail: &mut Detail, case: &Case, fit: &[Predicted], holdout: &[Predicted]) {
    let mut worst: Option<(f64, &Run, &Predicted, usize, bool)> = None;
    for (runs, predicted, is_holdout) in [(&case.fit, fit, false), (&case.holdout, holdout, true)] {
        for (run, p) in runs.iter().zip(predicted) {
            let gap = |m: usize| Tally::total(&p.tallies[m]).gap();
            detail.runs.push(RunRow {
                name: run.name.clone(),
                holdout: is_holdout,
                samples: run.len(),
                duration_s: Some(run.len() as f64 * run.dt_s),
                nominal: gap(0),
                calibrated: gap(1),
                extended: gap(2),
            });
            for (w, tally) in p.tallies[1].iter().enumerate() {
                // Runs that were only predicted are the proof: a fit run is shown where there are none.
                let better = |(gap, .., holdout): &(f64, &Run, &Predicted, usize, bool)| {
                    (is_holdout && !holdout) || tally.gap() > *gap
                };
                if worst.as_ref().is_none_or(better) {
                    worst = Some((tally.gap(), run, p, w, is_holdout));
                }
            }
        }
    }
    let Some((_, run, predicted, w, is_holdout)) = worst else { return };
    let sigma = sigmas(&case.vehicle.sensors);
    let range = predicted.windows[0][w].range.clone();
    let trace = |j: usize| {
        let model = |m: usize| predicted.windows[m][w].outputs.iter().map(|row| row[j]).collect();
        Trace {
            name: case.output_names()[j].into(),
            unit: if j == 0 { "m/s" } else { "rad/s" }.into(),
            sigma: sigma[j],
            measured: run.samples[range.clone()].iter().map(|s| s.outputs[j]).collect(),
            nominal: model(0),
            calibrated: model(1),
            extended: model(2),
        }
    };
    detail.worst_window = Some(TraceWindow {
        run: run.name.clone(),
        window: w,
        holdout: is_holdout,
        t_s: run.t_s[range.clone()].to_vec(),
        traces: (0..case.outputs()).map(trace).collect(),
    });
}

/// The curves of the effects found, in the order of the report.
pub(crate) fn effect_curves(
    case: &Case,
    selection: &Selection,
    models: &Models,
    calibrated: &Built,
    report: &Report,
    widening: f64,
) -> Vec<Curve> {
    let best = &selection.best.fitted;
    if best.fit.theta.len() != models.extended.len() {
        return Vec::new();
    }
    let fitted = FittedModel {
        shape: &models.extended_shape,
        theta: &models.extended,
        blocks: &best.fit.blocks,
        widening,
    };
    report.effects.iter().filter_map(|effect| effect_curve(case, &fitted, calibrated, &effect.id)).collect()
}
