//! From findings to the report, its details and the prediction files.

use super::curves;
use super::estimates;
use super::figures;
use super::findings::Findings;
use super::predictions::tables;
use super::vehicle::Applied;
use super::words;
use crate::answer::schema::{
    Candidate, FoundEffect, Gap, HoldoutGap, Location, Regime, Report, RunGap, SCHEMA, SignalGap,
    SignalShare, ThreeGaps, Unexplained, Verdict,
};
use crate::answer::supplement::{Alarm, Curve, Detail, ParameterRow, Settings};
use crate::law_bench::data::error::LawCaseError;
use crate::law_bench::data::point::Covariate;
use crate::law_bench::decide::confidence::{confidence, tied};
use crate::law_bench::decide::selection::SelectedEffect;
use crate::law_bench::model::law::Model;
use crate::law_bench::outcome::{Options, Outcome};
use crate::law_bench::predict::gaps::{ModelAt, Predictions, reduction};
use crate::words::format::percent;
use std::collections::BTreeMap;
use std::time::Instant;

/// Writes everything up.
///
/// # Errors
/// A prediction table that cannot be made.
pub fn write(findings: &Findings, options: &Options, started: Instant) -> Result<Outcome, LawCaseError> {
    let Findings { case, noise, calibrated, .. } = findings;
    let extended = findings.extended();
    let plain = Model::new(case.nominal, &[]);
    let start = plain.nominal_values();
    let models = || {
        [
            ModelAt { model: &plain, values: &start },
            ModelAt { model: &calibrated.model, values: &calibrated.fit.values },
            ModelAt { model: &extended.model, values: &extended.fit.values },
        ]
    };
    let fit = Predictions::of(&case.fit, models(), noise.sigma);
    let holdout = Predictions::of(&case.holdout, models(), noise.sigma);
    let rows = estimates::rows(extended, noise);
    let variable = variable(findings);
    let regime = variable.and_then(|covariate| fit.regime(covariate));
    let curve = missing_curve(findings, regime.as_ref());
    let [nominal, calibrated, extended_gap] = fit.gaps(|_| true);
    let report = Report {
        schema: SCHEMA.to_owned(),
        verdict: findings.rule.verdict,
        rule: findings.rule.name.to_owned(),
        location: location(findings, &fit, calibrated, regime),
        effects: effects(findings, &rows),
        posterior: Vec::new(),
        verdict_set: Vec::new(),
        carries_over: None,
        candidates: candidates(findings),
        gap: Gap {
            fit: ThreeGaps { nominal, calibrated, extended: extended_gap },
            holdout: holdout_gap(&holdout, case.kind.signal(), options.seed),
            natural: None,
        },
        unexplained: unexplained(findings, extended_gap),
        next_run: words::next_run(findings),
        evidence: None,
        seconds: started.elapsed().as_secs_f64(),
        notes: Vec::new(),
    };
    let detail = Detail {
        missing_curve: curve.filter(|_| report.unexplained.is_some()),
        parameters: rows,
        ..detail(findings, options, &fit, &holdout, variable)
    };
    let applied = Applied::of(&extended.model, case.nominal, &extended.fit.values);
    Ok(Outcome { report, detail, predictions: tables(&holdout, case.kind)?, applied })
}

/// What the page shows, but for the curve of what is missing and the parameters.
fn detail(
    findings: &Findings,
    options: &Options,
    fit: &Predictions<'_>,
    holdout: &Predictions<'_>,
    variable: Option<Covariate>,
) -> Detail {
    let Findings { case, noise, selection, calibrated, criteria, .. } = findings;
    let named = findings.names_effects();
    let mut runs = figures::runs(fit, false);
    runs.extend(figures::runs(holdout, true));
    let curve = |form| curves::effect_curve(&selection.extended, calibrated, noise, &case.fit.points, form);
    let curves = selection.effects.iter().filter(|_| named).map(|effect| curve(effect.form));
    Detail {
        rule: findings.rule.words.to_owned(),
        case: case.name.clone(),
        subject: words::subject(findings),
        notes: words::notes(findings),
        runs,
        heat_map: figures::heat_map(case.kind, fit),
        freed: Vec::new(),
        events: Vec::new(),
        worst_window: None,
        scatters: figures::scatters(case.kind, holdout, variable, "holdout"),
        effect_curves: curves.collect(),
        missing_curve: None,
        parameters: Vec::new(),
        candidates: figures::candidates(selection),
        gap_without_any: None,
        ties: if named { words::ties(&selection.effects, criteria) } else { Vec::new() },
        alarm: Some(alarm(findings)),
        settings: settings(findings, options),
    }
}

fn alarm(findings: &Findings) -> Alarm {
    let level = findings.criteria.library_level;
    Alarm {
        statistic: "squared error, in units of sigma², that the best candidate removes, minus ln(number of points) for each of its parameters"
            .to_owned(),
        level,
        threshold: findings.selection.chance.library_threshold(level),
        observed: findings.selection.alone.iter().map(|scored| scored.score).fold(0.0, f64::max),
        how: "noise of the estimated size and colour was drawn at the measured points, and every candidate was fitted to it in \
              linear form"
            .to_owned(),
        replicates: findings.criteria.replicates,
    }
}

fn settings(findings: &Findings, options: &Options) -> Settings {
    let (score, threshold) = (findings.structure_score, findings.structure_threshold);
    let level = percent(findings.criteria.structure_level);
    Settings {
        version: options.version.clone(),
        command: options.command.clone(),
        seed: options.seed,
        without: options.without.clone(),
        more: vec![(
            "Structure left by the extended model".to_owned(),
            format!("{score:.1} for the best free curve; chance reaches {threshold:.1} in {level} of cases"),
        )],
    }
}

/// The variable over which the gap is shown.
fn variable(findings: &Findings) -> Option<Covariate> {
    match findings.rule.verdict {
        Verdict::None => None,
        Verdict::Unknown => findings.missing.as_ref().map(|discrepancy| discrepancy.covariate),
        _ => findings.selection.effects.first().map(|effect| effect.spec.covariate),
    }
}

fn missing_curve(findings: &Findings, regime: Option<&Regime>) -> Option<Curve> {
    let points = &findings.case.fit.points;
    let discrepancy = findings.missing.as_ref()?;
    Some(curves::missing(discrepancy, findings.extended(), points, &findings.noise, regime))
}

fn unexplained(findings: &Findings, gap: f64) -> Option<Unexplained> {
    let missing = matches!(findings.rule.verdict, Verdict::Unknown | Verdict::EffectsAndUnknown);
    let points = &findings.case.fit.points;
    let curve =
        |discrepancy| curves::missing_curve(discrepancy, findings.extended(), points, &findings.noise);
    missing.then(|| Unexplained {
        gap,
        term: findings.case.kind.term().to_owned(),
        terms: Vec::new(),
        curve: findings.missing.iter().flat_map(curve).map(|[x, y, _]| [x, y]).collect(),
    })
}

fn location(findings: &Findings, fit: &Predictions<'_>, gap: f64, regime: Option<Regime>) -> Location {
    let kind = findings.case.kind;
    let runs = figures::runs(fit, false).into_iter();
    Location {
        term: (findings.rule.verdict != Verdict::None).then(|| kind.term().to_owned()),
        signals: vec![SignalShare { name: kind.signal().to_owned(), gap, share: 1.0 }],
        regime,
        runs: runs.map(|run| RunGap { name: run.name, gap: run.calibrated }).collect(),
    }
}

fn effects(findings: &Findings, rows: &[ParameterRow]) -> Vec<FoundEffect> {
    let criteria = &findings.criteria;
    let effect = |selected: &SelectedEffect| FoundEffect {
        id: selected.spec.id.to_owned(),
        term: selected.spec.term.to_owned(),
        confidence: confidence(selected, findings.recovered, criteria),
        p: None,
        score: None,
        gap_grows_without: None,
        rivals: Vec::new(),
        equivalent: tied(selected, criteria).iter().map(|rival| rival.id.to_owned()).collect(),
        parameters: estimates::by_name(rows, selected.spec.id),
    };
    let named = findings.selection.effects.iter().filter(|_| findings.names_effects());
    named.map(effect).collect()
}

fn candidates(findings: &Findings) -> Vec<Candidate> {
    let points = findings.case.fit.points.len() as f64;
    let alone = findings.selection.alone.iter();
    alone
        .map(|scored| Candidate {
            id: scored.spec.id.to_owned(),
            fit_gap: (scored.fitted.fit.chi2 / points).sqrt(),
            cv_gain: scored.cv_gain,
            p_value: scored.p_value,
            converged: scored.fitted.fit.converged,
        })
        .collect()
}

fn holdout_gap(predictions: &Predictions<'_>, signal: &str, seed: u64) -> HoldoutGap {
    let [nominal, calibrated, extended] = predictions.gaps(|_| true);
    HoldoutGap {
        nominal,
        calibrated,
        extended,
        reduction: reduction(calibrated, extended),
        reduction_ci95: predictions.reduction_interval(seed),
        by_signal: BTreeMap::from([(signal.to_owned(), SignalGap { calibrated, extended })]),
        worst_window: None,
    }
}
