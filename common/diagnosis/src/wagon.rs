//! The diagnosis of a wagon's case from recordings to report.

use crate::case::{Case, OUTPUT_NAMES, OUTPUTS};
use crate::engine::{self, Acceptance, Found};
use crate::html::detail::Detail;
use crate::parameters::Shape;
use crate::report::{
    Candidate, FoundEffect, Gap, HoldoutGap, Location, ParameterEstimate, Report, RunGap, SCHEMA, SignalGap,
    SignalShare, ThreeGaps, Unexplained, Verdict,
};
use crate::verdict::{self, Judgement};
use crate::{details, flexible, metric, polish, predictions, regime, wander};
use railgrip_recording::Table;
use railgrip_vehicle::{EffectEntry, VehicleParameters};
use std::time::Instant;

/// What a diagnosis is told beside its case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Name of the case for people.
    pub case: String,
    /// Candidates to leave out.
    pub without: Vec<String>,
    /// Seed of the bootstraps.
    pub seed: u64,
    /// Program and version, for the report's settings.
    pub version: String,
    /// The command line, for the report's settings.
    pub command: String,
}

/// What a diagnosis gives.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `report.json`.
    pub report: Report,
    /// What the HTML report shows beside it.
    pub detail: Detail,
    /// The prediction file of each holdout run: its name without ending, and the table.
    pub predictions: Vec<(String, Table)>,
    /// The vehicle with fitted nuisances and the effects found.
    pub vehicle: VehicleParameters,
}

/// The three models of a report as parameters of their shapes.
pub(crate) struct Models {
    pub(crate) nominal: Shape,
    pub(crate) calibrated: Vec<f64>,
    pub(crate) extended_shape: Shape,
    pub(crate) extended: Vec<f64>,
}

/// Diagnoses a case. `progress` is told what has just been done; threads are those of the surrounding rayon pool.
pub fn diagnose(case: &Case, options: &Options, progress: &(dyn Fn(&'static str) + Sync)) -> Outcome {
    let started = Instant::now();
    let acceptance = Acceptance::default();
    let found = engine::search(case, &options.without, acceptance, progress);
    progress("verdict");
    let judgement = verdict::judge(case, &found, acceptance, options.seed);
    progress("fit on windows");
    let models = fit_models(case, &found, &judgement);
    progress("report");
    write_up(case, options, started, &found, &judgement, &models)
}

fn named(judgement: &Judgement) -> bool {
    matches!(judgement.verdict, Verdict::Effects | Verdict::EffectsAndUnknown)
}

fn fit_models(case: &Case, found: &Found, judgement: &Judgement) -> Models {
    let nominal = Shape::nominal(case);
    let calibrated = polish::fit(case, &nominal, &[found.base.fitted.fit.theta.clone(), nominal.start()]);
    if !named(judgement) {
        return Models { extended_shape: nominal.clone(), extended: calibrated.clone(), nominal, calibrated };
    }
    let best = &found.best.fitted;
    let extended = polish::fit(case, &best.shape, std::slice::from_ref(&best.fit.theta));
    Models { nominal, calibrated, extended_shape: best.shape.clone(), extended }
}

fn write_up(
    case: &Case,
    options: &Options,
    started: Instant,
    found: &Found,
    judgement: &Judgement,
    models: &Models,
) -> Outcome {
    let built = [
        models.nominal.build(&models.nominal.start()),
        models.nominal.build(&models.calibrated),
        models.extended_shape.build(&models.extended),
    ];
    let three = [&built[0], &built[1], &built[2]];
    let fit = predictions::predict(case, &case.fit, three);
    let holdout = predictions::predict(case, &case.holdout, three);
    let (heat_map, regime) = regime::locate(case, three[1], three[2]);
    let fit_totals = predictions::totals(&fit);
    let effects = if named(judgement) { effects(found, judgement, models) } else { Vec::new() };
    let term = match judgement.verdict {
        Verdict::None => None,
        Verdict::Unknown => judgement.missing.as_ref().map(|m| m.flexible.term.name().to_owned()),
        _ => effects.first().map(|e| e.term.clone()),
    };
    let report = Report {
        schema: SCHEMA.to_owned(),
        verdict: judgement.verdict,
        location: Location {
            term,
            signals: signals(&fit_totals[1], &fit_totals[2]),
            regime: regime.filter(|_| judgement.verdict != Verdict::None),
            runs: fit
                .iter()
                .map(|p| RunGap { name: p.name.clone(), gap: metric::Tally::total(&p.tallies[1]).gap() })
                .collect(),
        },
        candidates: candidates(case, found, judgement),
        gap: Gap {
            fit: ThreeGaps {
                nominal: fit_totals[0].gap(),
                calibrated: fit_totals[1].gap(),
                extended: fit_totals[2].gap(),
            },
            holdout: holdout_gap(&holdout, options.seed),
        },
        unexplained: unexplained(case, judgement, fit_totals[2].gap()),
        next_run: next_run(&effects, judgement),
        effects,
        seconds: 0.0,
    };
    let mut detail = details::detail(case, options, found, judgement, models, &report);
    detail.heat_map = heat_map;
    details::add_runs(&mut detail, case, &fit, &holdout);
    detail.effect_curves = details::effect_curves(case, found, models, three[1], &report);
    let tables = case.holdout.iter().zip(&holdout).filter_map(|(run, predicted)| {
        predictions::table(run, predicted).ok().map(|table| (run.name.clone(), table))
    });
    let predictions = tables.collect();
    let vehicle = vehicle(models);
    let report = Report { seconds: started.elapsed().as_secs_f64(), ..report };
    Outcome { report, detail, predictions, vehicle }
}

fn signals(calibrated: &metric::Tally, extended: &metric::Tally) -> Vec<SignalShare> {
    // What the best model still misses is not what is being located; a gap of one is the sensors'.
    let floor = |j: usize| extended.signal(j).clamp(1.0, 2.0).powi(2);
    let mut excess: Vec<f64> =
        (0..OUTPUTS).map(|j| (calibrated.signal(j).powi(2) - floor(j)).max(0.0)).collect();
    let total: f64 = excess.iter().sum();
    if total > 0.0 {
        excess.iter_mut().for_each(|e| *e /= total);
    }
    let share = |(j, share): (usize, f64)| SignalShare {
        name: OUTPUT_NAMES[j].to_owned(),
        gap: calibrated.signal(j),
        share,
    };
    excess.into_iter().enumerate().map(share).collect()
}

fn effects(found: &Found, judgement: &Judgement, models: &Models) -> Vec<FoundEffect> {
    let shape = &models.extended_shape;
    let total = (found.base.evidence_cost() - found.best.evidence_cost()).max(1.0);
    let worth = &found.worth;
    let mut effects: Vec<(f64, FoundEffect)> = (0..shape.effects.len())
        .map(|e| {
            let spec = shape.effects[e].spec;
            // The round that accepted the effect tried it against its rivals.
            let round = &found.rounds[e.min(found.rounds.len() - 1)];
            let rivals = verdict::rivals(round, spec.id);
            let equivalent = verdict::equivalents(round, spec.id, spec.twins);
            let rival = rivals
                .iter()
                .filter(|(g, _)| !equivalent.iter().any(|id| id == g.id))
                .map(|(_, ratio)| *ratio)
                .next()
                .unwrap_or(0.0);
            let gain = round.settled_gain(spec.id).unwrap_or(total);
            let range = shape.range_of(e);
            let intervals = details::intervals(found, models);
            let fitted = shape.effects[e].parameters.iter().zip(range).map(|(p, i)| {
                (p.name.clone(), ParameterEstimate { value: models.extended[i], ci95: intervals[i] })
            });
            // Which wheelset, which form: chosen, not estimated.
            let chosen = spec.parameters.iter().zip(&shape.effects[e].fixed).filter(|(p, _)| p.discrete);
            let chosen =
                chosen.map(|(p, v)| (p.name.to_owned(), ParameterEstimate { value: *v, ci95: [*v, *v] }));
            let parameters = fitted.chain(chosen).collect();
            let found = FoundEffect {
                id: spec.id.to_owned(),
                term: spec.term.name().to_owned(),
                confidence: verdict::confidence(verdict::Standing {
                    recovered: judgement.recovered,
                    left: judgement.left,
                    rival,
                    gain,
                    mends: shape.effects[..e]
                        .iter()
                        .any(|before| wander::may_share_place(before.spec.term, spec.term)),
                }),
                equivalent,
                parameters,
            };
            // What counts most comes first, which need not be what was found first.
            (worth.get(e).copied().unwrap_or(gain), found)
        })
        .collect();
    effects.sort_by(|a, b| b.0.total_cmp(&a.0));
    effects.into_iter().map(|(_, effect)| effect).collect()
}

fn candidates(case: &Case, found: &Found, judgement: &Judgement) -> Vec<Candidate> {
    let Some(round) = found.rounds.first() else { return Vec::new() };
    let expected = 0.5 * found.base.fitted.residuals.len() as f64;
    let excess = (found.base.fitted.predictive_cost() - expected).max(1.0);
    let mut order: Vec<&engine::Gain> = round.gains.iter().collect();
    order.sort_by(|a, b| b.predictive.total_cmp(&a.predictive));
    let sigma = metric::sigmas(&case.vehicle.sensors);
    order
        .into_iter()
        .map(|g| {
            let built = g.fitted.shape.build(&g.fitted.fit.theta);
            let tallies: Vec<metric::Tally> =
                case.fit.iter().flat_map(|run| metric::tallies(&built, run, &sigma)).collect();
            Candidate {
                id: g.id.to_owned(),
                fit_gap: metric::Tally::total(&tallies).gap(),
                cv_gain: g.predictive / excess,
                p_value: judgement.chance.as_ref().map_or(1.0, |chance| chance.p_value(g.gain)),
                converged: g.converged,
            }
        })
        .collect()
}

fn holdout_gap(holdout: &[predictions::Predicted], seed: u64) -> HoldoutGap {
    let [nominal, calibrated, extended] = predictions::totals(holdout);
    let by_signal = OUTPUT_NAMES.iter().enumerate().map(|(j, name)| {
        ((*name).to_owned(), SignalGap { calibrated: calibrated.signal(j), extended: extended.signal(j) })
    });
    HoldoutGap {
        nominal: nominal.gap(),
        calibrated: calibrated.gap(),
        extended: extended.gap(),
        reduction: predictions::reduction(calibrated.gap(), extended.gap()),
        reduction_ci95: predictions::reduction_interval(holdout, seed),
        by_signal: by_signal.collect(),
    }
}

fn unexplained(case: &Case, judgement: &Judgement, gap: f64) -> Option<Unexplained> {
    let missing = judgement.missing.as_ref()?;
    let shape = &missing.fitted.shape;
    let range = shape.range_of(shape.effects.len() - 1);
    let values = &missing.fitted.fit.theta[range];
    let reference = match missing.flexible.place {
        flexible::Place::PadFriction => case.vehicle.brake.friction_coefficient,
        _ => 1.0,
    };
    let curve = missing.flexible.curve(values).into_iter().map(|[x, y]| [x, y * reference]).collect();
    Some(Unexplained { gap, term: missing.flexible.term.name().to_owned(), curve })
}

fn next_run(effects: &[FoundEffect], judgement: &Judgement) -> Option<String> {
    let tied = effects.iter().find(|e| !e.equivalent.is_empty());
    if let Some(effect) = tied {
        let (spec, _) = railgrip_vehicle::effects::find(&effect.id)?;
        return Some(format!(
            "To tell {} from {}: {}.",
            effect.id,
            effect.equivalent.join(", "),
            spec.separated_by
        ));
    }
    let missing = judgement.missing.as_ref()?;
    Some(format!(
        "What is missing acts on {} over {}: repeat the run in which that varies most, with everything else held, at two levels of it.",
        missing.flexible.term.name(),
        missing.flexible.covariate.name()
    ))
}

/// The vehicle file of the extended model: fitted nuisances, each pad's own level, and the effects found.
fn vehicle(models: &Models) -> VehicleParameters {
    let shape = &models.extended_shape;
    let (mut vehicle, factors) = shape.vehicle(&models.extended);
    let pads: Vec<f64> = factors.iter().zip(vehicle.pad_friction()).map(|(f, pad)| f * pad).collect();
    vehicle.brake.friction_coefficient = pads.iter().sum::<f64>() / pads.len() as f64;
    vehicle.brake.friction_by_wheelset = Some(pads);
    for (e, effect) in shape.effects.iter().enumerate() {
        let values = effect.values(&models.extended[shape.range_of(e)]);
        let parameters =
            effect.spec.parameters.iter().zip(values).map(|(p, v)| (p.name.to_owned(), v)).collect();
        vehicle.effects.push(EffectEntry { id: effect.spec.id.to_owned(), parameters });
    }
    vehicle
}
