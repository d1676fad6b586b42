//! What a diagnosis weighed, as a table: `explain CASE [--without ID]... [--only ID...]`.
//!
//! For whoever works on the diagnosis: evidence of the filters, the candidates' gains in every round, the flexible
//! discrepancies by place, and the test against chance.
#![allow(clippy::print_stdout, reason = "a table for people")]

use railgrip_diagnosis::data::align::Alignments;
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::decide::criteria::Criteria;
use railgrip_diagnosis::decide::round::{Gain, Round};
use railgrip_diagnosis::decide::{evidence, selection};
use railgrip_diagnosis::fit::discrepancies::FittedDiscrepancy;
use railgrip_diagnosis::fit::frozen::FrozenFit;
use railgrip_diagnosis::predict::localise::PlaceEvidence;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("usage: explain CASE [--without ID]... [--only ID...]")?;
    let rest: Vec<String> = arguments.collect();
    let (only, rest): (Vec<String>, Vec<String>) = match rest.iter().position(|a| a == "--only") {
        Some(at) => (rest[at + 1..].to_vec(), rest[..at].to_vec()),
        None => (Vec::new(), rest),
    };
    let mut without: Vec<String> = rest.into_iter().filter(|a| a != "--without").collect();
    if !only.is_empty() {
        let ids = railgrip_vehicle::effects::CATALOGUE.iter().map(|(spec, _)| spec.id.to_owned());
        without.extend(ids.filter(|id| !only.contains(id)));
    }
    let folder = std::path::Path::new(&folder);
    let vehicle = toml::from_str(&std::fs::read_to_string(folder.join("vehicle.toml"))?)?;
    let case = load::load(folder, vehicle)?;
    let started = Instant::now();
    let criteria = Criteria::default();
    let alignments = Alignments::default();
    let thinned = case.thinned(criteria.pursuit.rate_hz);
    let case = thinned.as_ref().unwrap_or(&case);
    let mut base = selection::calibrate(case);
    let heard = selection::heard(&base, &criteria);
    let case = heard.as_ref().unwrap_or(case);
    if heard.is_some() {
        base = selection::calibrate(case);
    }
    println!("{:.1} s  noise {:.4?}", started.elapsed().as_secs_f64(), case.noise);
    let places = selection::localise(&base, &criteria);
    let selection = selection::select((case, &alignments), base, places, &without, &criteria, &|_| ());
    let names = |frozen: &FrozenFit| {
        let ids: Vec<&str> = frozen.fitted.shape.effects.iter().map(|e| e.spec.id).collect();
        ids.join(" + ")
    };
    println!(
        "{:.1} s  base tolerance {} cost {:.0} of {}, best [{}] tolerance {} cost {:.0}, evidence gained {:.0}",
        started.elapsed().as_secs_f64(),
        selection.base.tolerance,
        selection.base.fitted.fit.total(),
        selection.base.fitted.residuals.len() / 2,
        names(&selection.best),
        selection.best.tolerance,
        selection.best.fitted.fit.total(),
        selection.base.evidence_cost() - selection.best.evidence_cost(),
    );
    for (index, effect) in selection.best.fitted.shape.effects.iter().enumerate() {
        let values = &selection.best.fitted.fit.theta[selection.best.fitted.shape.range_of(index)];
        println!("  {} {values:.4?}", effect.spec.id);
    }
    for round in &selection.rounds {
        show(round);
    }
    let judgement = evidence::judge(&selection, &criteria, 0);
    let (decision, weighed) = (&judgement.decision, &judgement.evidence);
    println!("{:.1} s  selection stopped: {:?}", started.elapsed().as_secs_f64(), selection.stop);
    println!("{} by the rule {}: {}", decision.verdict.name(), decision.rule.name, decision.rule.words);
    println!("recovered {:.2}, {weighed:#?}", weighed.recovered());
    println!("lost without each effect {:.0?}", selection.lost_without);
    for (what, places) in [("before", &selection.places), ("after", &selection.rest)] {
        println!("{what}");
        for w in places.iter().take(4) {
            let PlaceEvidence { place, scope, evidence, amplitude, time_s } = w;
            println!("  {place:?} {scope:?} evidence {evidence:.0} amplitude {amplitude:.4} over {time_s} s");
        }
    }
    if let Some(missing) = &judgement.missing {
        println!("missing");
        line(missing);
    }
    for (what, fitted) in [("beside", &judgement.beside), ("instead", &judgement.instead)] {
        println!("{what}");
        fitted.iter().for_each(line);
    }
    Ok(())
}

fn show(round: &Round) {
    println!("  {:?}", round.own_filter_gains);
    let mut gains: Vec<&Gain> = round.gains.iter().collect();
    gains.sort_by(|a, b| b.score.total_cmp(&a.score));
    for gain in gains.iter().take(7) {
        let Some((effect, values)) = gain.own() else { continue };
        let fixed: Vec<&f64> = effect.fixed.iter().filter(|v| !v.is_nan()).collect();
        let mark = if gain.converged { ' ' } else { '~' };
        println!(
            "  {:26} gain {:9.1} left out {:9.1} {:.0?} {mark} {fixed:?} {values:.4?}",
            gain.id, gain.gain, gain.predictive, gain.by_run
        );
    }
    println!();
}

fn line(fitted: &FittedDiscrepancy) {
    let f = &fitted.discrepancy;
    let (term, covariate) = (f.term.name(), f.covariate.name());
    println!(
        "  {term:20} {:?} {:?} over {covariate}: gain {:.1} left out {:.1}",
        f.place, f.scope, fitted.gain, fitted.predictive
    );
}
