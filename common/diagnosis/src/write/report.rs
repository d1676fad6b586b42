//! The report: puts what was found, how far it reaches and what it leaves into the form of `report.json`.

use crate::answer::schema::Regime;
use crate::answer::schema::{
    Candidate, FoundEffect, Gap, HoldoutGap, Location, NaturalGap, ParameterEstimate, Report, Rival, RunGap,
    SCHEMA, SignalGap, SignalShare, ThreeGaps, Unexplained, Verdict,
};
use crate::data::case::Case;
use crate::decide::acceptance;
use crate::decide::confidence::{self, Standing};
use crate::decide::criteria::Criteria;
use crate::decide::evidence::Judgement;
use crate::decide::posterior::Calibration;
use crate::decide::round::Gain;
use crate::decide::selection::Selection;
use crate::decide::verdict::{Decision, Missing};
use crate::fit::windows::Models;
use crate::model::discrepancy::{Covariate, Place};
use crate::model::places;
use crate::predict::open_loop::Tally;
use crate::words::findings::AMBIENT_C;
use crate::words::format::{plain, term};
use crate::write::details::{self, fit_gap};
use crate::write::predictions::{self, Predicted};
use rayon::prelude::*;

/// Rivals of an effect that are listed.
const RIVALS: usize = 4;

/// Writes the report but for its seconds. `fit` and `holdout` are what the three models predict, `regime` where the
/// calibrated model's gap stands out, `seed` that of the bootstraps.
pub(crate) fn report(
    case: &Case,
    seed: u64,
    selection: &Selection,
    judgement: &Judgement,
    models: &Models,
    [fit, holdout]: [&[Predicted]; 2],
    natural: Option<NaturalGap>,
    regime: Option<Regime>,
    criteria: &Criteria,
) -> Report {
    let Decision { verdict, rule } = judgement.decision;
    let fit_totals = predictions::totals(fit);
    let effects = if judgement.decision.names_effects() {
        effects(case, selection, judgement, models, criteria)
    } else {
        Vec::new()
    };
    // Where a curve explains much more at the place of one of several effects, that is the place.
    let by_curve = verdict == Verdict::Unknown || rule.missing == Missing::InsteadOfEffects;
    let term = match (&judgement.missing, verdict) {
        (_, Verdict::None) => None,
        (Some(missing), _) if by_curve => Some(missing.discrepancy.term.name().to_owned()),
        _ => effects.first().map(|e| e.term.clone()),
    };
    let mut report = Report {
        schema: SCHEMA.to_owned(),
        verdict,
        rule: rule.name.to_owned(),
        location: Location {
            term,
            signals: signals(case.output_names(), &fit_totals[1], &fit_totals[2], criteria.report.floor_gap),
            regime: regime.filter(|_| verdict != Verdict::None),
            runs: run_gaps(fit),
        },
        candidates: candidates(case, selection, judgement, criteria),
        gap: Gap {
            fit: ThreeGaps {
                nominal: fit_totals[0].gap(),
                calibrated: fit_totals[1].gap(),
                extended: fit_totals[2].gap(),
            },
            holdout: holdout_gap(case, holdout, seed),
            natural,
        },
        unexplained: unexplained(case, judgement, fit_totals[2].gap()),
        next_run: next_run(&effects, judgement),
        evidence: Some(judgement.evidence),
        carries_over: carries_over(case, &effects, holdout),
        effects,
        posterior: Vec::new(),
        verdict_set: Vec::new(),
        seconds: 0.0,
        notes: Vec::new(),
    };
    Calibration::shipped().settle(&mut report);
    report
}

/// Gap of the calibrated model on each recording, whose parts count together.
fn run_gaps(fit: &[Predicted]) -> Vec<RunGap> {
    let gap = |parts: &[Predicted]| Tally::total(parts.iter().flat_map(|p| &p.tallies[1])).gap();
    let parts = fit.chunk_by(|a, b| a.name == b.name);
    parts.map(|parts| RunGap { name: parts[0].name.clone(), gap: gap(parts) }).collect()
}

fn signals(
    names: &[&str],
    calibrated: &Tally,
    extended: &Tally,
    [least, most]: [f64; 2],
) -> Vec<SignalShare> {
    // What the best model still misses is not what is being located; a gap of one is the sensors'.
    let floor = |j: usize| extended.signal(j).clamp(least, most).powi(2);
    let mut excess: Vec<f64> =
        (0..names.len()).map(|j| (calibrated.signal(j).powi(2) - floor(j)).max(0.0)).collect();
    let total: f64 = excess.iter().sum();
    if total > 0.0 {
        excess.iter_mut().for_each(|e| *e /= total);
    }
    let share = |(j, share): (usize, f64)| SignalShare {
        name: names[j].to_owned(),
        gap: calibrated.signal(j),
        share,
    };
    excess.into_iter().enumerate().map(share).collect()
}

fn effects(
    case: &Case,
    selection: &Selection,
    judgement: &Judgement,
    models: &Models,
    criteria: &Criteria,
) -> Vec<FoundEffect> {
    let shape = &models.extended_shape;
    let total = (selection.base.evidence_cost() - selection.best.evidence_cost()).max(1.0);
    let mut effects: Vec<(f64, FoundEffect)> = (0..shape.effects.len())
        .map(|e| {
            let spec = shape.effects[e].spec;
            let round = selection.accepted_in(spec.id);
            let rivals = round.map_or_else(Vec::new, |round| confidence::rivals(round, spec.id));
            let equivalent =
                round.map_or_else(Vec::new, |round| confidence::equivalents(round, spec, &criteria.ties));
            let rival = rivals
                .iter()
                .filter(|(g, _)| !equivalent.iter().any(|id| id == g.id))
                .map(|(_, ratio)| *ratio)
                .next()
                .unwrap_or(0.0);
            let rivals = rivals.iter().take(RIVALS);
            let rivals = rivals.map(|(g, share)| Rival { id: g.id.to_owned(), share: *share }).collect();
            let gain = round.and_then(|round| round.own_filter_gain(spec.id)).unwrap_or(total);
            let range = shape.range_of(e);
            let intervals = details::intervals(selection, models, criteria.report.widening);
            // Offsets of single runs belong to these recordings and not to the effect.
            let own = shape.effects[e].parameters.iter().zip(range).filter(|(p, _)| p.run.is_none());
            let fitted = own.map(|(p, i)| {
                let by_noise = Some(intervals[i]);
                (
                    p.name.clone(),
                    ParameterEstimate { value: models.extended[i], ci95: intervals[i], by_noise },
                )
            });
            // Which wheelset, which form: chosen, not estimated.
            let chosen = spec.parameters.iter().zip(&shape.effects[e].fixed).filter(|(p, _)| p.discrete);
            let chosen = chosen.map(|(p, v)| (p.name.to_owned(), ParameterEstimate::new(*v, [*v, *v])));
            let parameters = fitted.chain(chosen).collect();
            let standing = Standing {
                recovered: judgement.evidence.recovered(),
                left: judgement.evidence.left,
                rival,
                gain,
                at_same_place: shape.effects[..e]
                    .iter()
                    .any(|before| places::may_share(before.spec.term, spec.term)),
            };
            let found = FoundEffect {
                id: spec.id.to_owned(),
                term: spec.term.name().to_owned(),
                confidence: f64::NAN,
                p: None,
                score: Some(confidence::score(standing, &criteria.confidence)),
                gap_grows_without: (!case.is_coupled()).then(|| models.grows_without(case, e)),
                equivalent,
                rivals,
                parameters,
            };
            // What counts most comes first, which need not be what was found first.
            (selection.lost_without.get(e).copied().unwrap_or(gain), found)
        })
        .collect();
    effects.sort_by(|a, b| b.0.total_cmp(&a.0));
    effects.into_iter().map(|(_, effect)| effect).collect()
}

fn candidates(
    case: &Case,
    selection: &Selection,
    judgement: &Judgement,
    criteria: &Criteria,
) -> Vec<Candidate> {
    let Some(round) = selection.rounds.first() else { return Vec::new() };
    let expected = 0.5 * selection.base.fitted.residuals.len() as f64;
    // Robust costs may lie below what is expected of white noise: there is at least as much to remove as the best one removes.
    let most = round.gains.iter().map(|g| g.predictive).fold(1.0, f64::max);
    let excess = (selection.base.fitted.fit.cost - expected).max(most);
    let mut order: Vec<&Gain> = round.gains.iter().collect();
    order.sort_by(|a, b| b.predictive.total_cmp(&a.predictive));
    // What one named effect gains by its own filter was held against chance; the table says the same of it.
    let effects = &selection.best.fitted.shape.effects;
    let is_decided = |g: &Gain| {
        judgement.decision.names_effects() && matches!(&effects[..], [only] if only.spec.id == g.id)
    };
    let gain = |g: &Gain| match is_decided(g) {
        true => judgement.evidence.gain,
        false => acceptance::counted_gain(&selection.base, g, criteria),
    };
    order
        .into_par_iter()
        .map(|g| Candidate {
            id: g.id.to_owned(),
            fit_gap: fit_gap(case, &g.fitted),
            cv_gain: g.predictive / excess,
            p_value: judgement.chance.as_ref().map_or(1.0, |chance| chance.p_value(gain(g))),
            converged: g.converged,
        })
        .collect()
}

/// Whether the extended model predicts the holdout runs better than the calibrated one; `None` where there is nothing to compare,
/// and for a coupled wagon, which open loop follows its couplers.
fn carries_over(case: &Case, effects: &[FoundEffect], holdout: &[Predicted]) -> Option<bool> {
    let [_, calibrated, extended] = predictions::totals(holdout);
    (!case.holdout.is_empty() && !effects.is_empty() && !case.is_coupled())
        .then(|| extended.gap() < calibrated.gap())
}

fn holdout_gap(case: &Case, holdout: &[Predicted], seed: u64) -> HoldoutGap {
    let [nominal, calibrated, extended] = predictions::totals(holdout);
    let by_signal = case.output_names().iter().enumerate().map(|(j, name)| {
        ((*name).to_owned(), SignalGap { calibrated: calibrated.signal(j), extended: extended.signal(j) })
    });
    HoldoutGap {
        nominal: nominal.gap(),
        calibrated: calibrated.gap(),
        extended: extended.gap(),
        reduction: predictions::reduction(calibrated.gap(), extended.gap()),
        reduction_ci95: predictions::reduction_interval(holdout, seed),
        by_signal: by_signal.collect(),
        worst_window: predictions::worst_window(&case.holdout, holdout),
    }
}

fn unexplained(case: &Case, judgement: &Judgement, gap: f64) -> Option<Unexplained> {
    let missing = judgement.missing.as_ref()?;
    let shape = &missing.fitted.shape;
    let range = shape.range_of(shape.effects.len() - 1);
    let values = &missing.fitted.fit.theta[range];
    let reference = match missing.discrepancy.place {
        Place::PadFriction => case.vehicle.brake.friction_coefficient,
        _ => 1.0,
    };
    // The discrepancy knows the rise of the disc's temperature; reports give temperatures in °C.
    let shift = if missing.discrepancy.covariate == Covariate::Temperature { AMBIENT_C } else { 0.0 };
    let shown = |[x, y]: [f64; 2]| [x + shift, y * reference];
    let curve = missing.discrepancy.curve(values).into_iter().map(shown).collect();
    let terms = judgement.missing_terms.iter().map(|term| term.name().to_owned()).collect();
    Some(Unexplained { gap, term: missing.discrepancy.term.name().to_owned(), terms, curve })
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
    let (place, variable) =
        (term(missing.discrepancy.term.name()), plain(missing.discrepancy.covariate.name()));
    Some(format!(
        "What is missing in {place} changes with {variable}. Make two runs that differ in {variable} and in nothing else."
    ))
}
