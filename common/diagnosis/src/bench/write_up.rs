//! From findings to the report, its details and the prediction files.

use super::Diagnosis;
use super::apply::Applied;
use super::error::BenchError;
use super::estimates;
use super::figures;
use super::folds::Scheme;
use super::gaps::{Fitted, Predictions, reduction};
use super::model::Model;
use super::search::{Chosen, LIBRARY_LEVEL, Trial};
use super::verdict::missing_curve;
use super::{Options, Outcome, chance, input::Nominal};
use crate::answer::schema::{
    Candidate, FoundEffect, Gap, HoldoutGap, Location, Report, RunGap, SCHEMA, SignalGap, SignalShare,
    ThreeGaps, Unexplained, Verdict,
};
use crate::answer::supplement::{Alarm, Detail, ParameterRow, Settings, Tie};
use crate::html::words::number;
use std::collections::BTreeMap;
use std::time::Instant;

/// How much worse a rival may rank and still count as a candidate that the data cannot tell apart.
const TIE: f64 = 9.0;

/// Rank difference that counts as one unit of evidence; ranks are twice log-likelihoods, tempered for forms that are not exact.
const EVIDENCE: f64 = 5.0;

/// No verdict is surer than this.
const SUREST: f64 = 0.98;

/// Writes everything up.
pub fn write_up(diagnosis: &Diagnosis, options: &Options, started: Instant) -> Result<Outcome, BenchError> {
    let Diagnosis { case, noise, calibrated, found, judgement, .. } = diagnosis;
    let named = matches!(judgement.verdict, Verdict::Effects | Verdict::EffectsAndUnknown);
    let extended: &Trial = if named { &found.extended } else { calibrated };
    let plain = Model::new(case.nominal, &[]);
    let start = plain.nominal_values();
    let models = || {
        [
            Fitted { model: &plain, values: &start },
            Fitted { model: &calibrated.model, values: &calibrated.fit.values },
            Fitted { model: &extended.model, values: &extended.fit.values },
        ]
    };
    let fit = Predictions::of(&case.fit, models(), noise.sigma);
    let holdout = Predictions::of(&case.holdout, models(), noise.sigma);
    let rows = estimates::rows(extended, noise);
    let effects: Vec<FoundEffect> = if named {
        found.effects.iter().map(|chosen| effect(chosen, &rows, judgement.recovered)).collect()
    } else {
        Vec::new()
    };
    let variable = match judgement.verdict {
        Verdict::None => None,
        Verdict::Unknown => judgement.missing.as_ref().map(|group| group.covariate),
        _ => found.effects.first().map(|chosen| chosen.spec.covariate),
    };
    let regime = variable.and_then(|covariate| fit.regime(covariate));
    let curve = judgement
        .missing
        .as_ref()
        .map(|group| figures::missing(group, extended, &case.fit.points, noise, regime.as_ref()));
    let [nominal_fit, calibrated_fit, extended_fit] = fit.gaps(|_| true);
    let unexplained =
        matches!(judgement.verdict, Verdict::Unknown | Verdict::EffectsAndUnknown).then(|| Unexplained {
            gap: extended_fit,
            term: case.kind.term().to_owned(),
            curve: judgement
                .missing
                .iter()
                .flat_map(|group| missing_curve(group, extended, &case.fit.points, noise))
                .map(|[x, y, _]| [x, y])
                .collect(),
        });
    let location = Location {
        term: (judgement.verdict != Verdict::None).then(|| case.kind.term().to_owned()),
        signals: vec![SignalShare { name: case.kind.signal().to_owned(), gap: calibrated_fit, share: 1.0 }],
        regime,
        runs: figures::runs(&fit, false)
            .into_iter()
            .map(|run| RunGap { name: run.name, gap: run.calibrated })
            .collect(),
    };
    let ties = ties(&found.effects, named);
    let report = Report {
        schema: SCHEMA.to_owned(),
        verdict: judgement.verdict,
        location,
        effects,
        candidates: candidates(diagnosis),
        gap: Gap {
            fit: ThreeGaps { nominal: nominal_fit, calibrated: calibrated_fit, extended: extended_fit },
            holdout: holdout_gap(&holdout, case.kind.signal(), options.seed),
        },
        unexplained,
        next_run: next_run(diagnosis, named),
        seconds: started.elapsed().as_secs_f64(),
    };
    let mut runs = figures::runs(&fit, false);
    runs.extend(figures::runs(&holdout, true));
    let detail = Detail {
        case: case.name.clone(),
        subject: subject(diagnosis),
        notes: notes(diagnosis),
        runs,
        heat_map: figures::heat_map(case.kind, &fit),
        freed: Vec::new(),
        worst_window: None,
        scatters: figures::scatters(case.kind, &holdout, variable, "holdout"),
        effect_curves: if named {
            figures::effect_curves(found, calibrated, noise, &case.fit.points)
        } else {
            Vec::new()
        },
        missing_curve: curve.filter(|_| report.unexplained.is_some()),
        parameters: rows,
        candidates: figures::candidates(found),
        ties,
        alarm: Some(Alarm {
            statistic: "squared error over sigma² removed by the best candidate, less ln(points) a parameter"
                .to_owned(),
            level: LIBRARY_LEVEL,
            threshold: found.chance.threshold(LIBRARY_LEVEL),
            observed: found.alone.iter().map(|scored| scored.score).fold(0.0, f64::max),
            replicates: chance::REPLICATES,
        }),
        settings: Settings {
            version: options.version.clone(),
            command: options.command.clone(),
            seed: options.seed,
            without: options.without.clone(),
            more: vec![(
                "structure left by the best model".to_owned(),
                format!(
                    "{:.1}, threshold {:.1} (best of all flexible functions)",
                    judgement.rest_score, judgement.rest_threshold
                ),
            )],
        },
    };
    let applied = Applied::of(&extended.model, case.nominal, &extended.fit.values);
    Ok(Outcome { report, detail, predictions: holdout.tables(case.kind)?, applied })
}

fn effect(chosen: &Chosen, rows: &[ParameterRow], recovered: f64) -> FoundEffect {
    let weights: f64 = chosen.rivals.iter().map(|(_, deficit)| (-deficit / EVIDENCE).exp()).sum();
    let confidence = (1.0 - chosen.p_value) * recovered.clamp(0.0, 1.0) / (1.0 + weights);
    FoundEffect {
        id: chosen.spec.id.to_owned(),
        term: chosen.spec.term.to_owned(),
        confidence: confidence.clamp(0.02, SUREST),
        equivalent: equivalents(chosen),
        parameters: estimates::by_name(rows, chosen.spec.id),
    }
}

fn equivalents(chosen: &Chosen) -> Vec<String> {
    let close = chosen.rivals.iter().filter(|(_, deficit)| *deficit < TIE);
    close.map(|(rival, _)| rival.id.to_owned()).collect()
}

fn candidates(diagnosis: &Diagnosis) -> Vec<Candidate> {
    let unit = diagnosis.case.fit.points.len() as f64;
    let alone = diagnosis.found.alone.iter();
    alone
        .map(|scored| Candidate {
            id: scored.spec.id.to_owned(),
            fit_gap: (scored.trial.fit.chi2 / unit).sqrt(),
            cv_gain: scored.cv_gain,
            p_value: scored.p_value,
            converged: scored.trial.fit.converged,
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
    }
}

fn ties(effects: &[Chosen], named: bool) -> Vec<Tie> {
    let tied = effects.iter().filter(|chosen| named && !equivalents(chosen).is_empty());
    tied.map(|chosen| {
        let mut ids = vec![chosen.spec.id.to_owned()];
        ids.extend(equivalents(chosen));
        let close = chosen.rivals.iter().filter(|(_, deficit)| *deficit < TIE);
        let rivals: Vec<&str> = close.map(|(rival, _)| rival.meaning).collect();
        let because = format!(
            "On these points \"{}\" and \"{}\" move the prediction alike.",
            chosen.spec.meaning,
            rivals.join("\" and \"")
        );
        Tie { ids, because }
    })
    .collect()
}

fn next_run(diagnosis: &Diagnosis, named: bool) -> Option<String> {
    if !named {
        let group = diagnosis.judgement.missing.as_ref()?;
        let variable = group.covariate.name().replace('_', " ");
        return Some(match group.second {
            Some(second) => format!(
                "Measure a grid of {variable} and {} with all else held: their joint influence is what is missing.",
                second.name().replace('_', " ")
            ),
            None => format!(
                "Vary {variable} alone over its whole range, up and down, with all else held: this shows the missing law and whether it has a memory."
            ),
        });
    }
    let tied = diagnosis.found.effects.iter().find(|chosen| !equivalents(chosen).is_empty())?;
    let (rival, _) = tied.rivals.first()?;
    Some(format!("To tell {} from {}: {}; and {}.", tied.spec.id, rival.id, tied.spec.isolate, rival.isolate))
}

fn subject(diagnosis: &Diagnosis) -> String {
    let law = match diagnosis.case.nominal {
        Nominal::Creep { mu0, stiffness_n, k_a, k_s } => {
            format!(
                "creep bench; nominal law: Polach with mu0 {mu0}, K {stiffness_n} N, k_A {k_a}, k_S {k_s}"
            )
        }
        Nominal::Brake { friction_coefficient } => {
            format!("brake bench; nominal law: constant friction {friction_coefficient}")
        }
    };
    let case = &diagnosis.case;
    format!("{law}; {} points to fit on, {} to predict", case.fit.points.len(), case.holdout.points.len())
}

fn notes(diagnosis: &Diagnosis) -> Vec<String> {
    let noise = &diagnosis.noise;
    let unit = if diagnosis.case.kind == super::Kind::Creep { " N" } else { "" };
    let sigma = number(noise.sigma);
    let mut notes = vec![format!("Sigma {sigma}{unit} is {}.", diagnosis.sigma_source)];
    if noise.excess > 1.15 {
        notes.push(format!(
            "Points scatter {:.2} sigma about the smoothest model that follows all variables; evidence is weighed by that scatter.",
            noise.excess
        ));
    }
    if noise.correlation > 0.0 {
        notes.push(format!(
            "Neighbouring points are correlated ({:.2}); evidence and intervals allow for it.",
            noise.correlation
        ));
    }
    notes.push(match diagnosis.scheme {
        Scheme::Files => "Left-out data: one file at a time.".to_owned(),
        Scheme::Blocks => {
            "Left-out data: blocks of neighbouring rows, because leaving out whole files would extrapolate."
                .to_owned()
        }
    });
    notes
}
