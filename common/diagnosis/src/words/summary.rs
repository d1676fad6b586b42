//! The report as a short Markdown text for the terminal.

use super::advice::advice;
use super::format::{gap, p_value, part, term};
use super::parameters;
use super::regime::regime;
use super::sentences::{caution, certainty, evidence, headline};
use crate::answer::schema::{Report, ThreeGaps};
use crate::answer::supplement::Detail;
use std::fmt::Write;

/// Candidates that the summary lists.
const MOST_CANDIDATES: usize = 8;

/// The summary.
pub fn summary(report: &Report, detail: &Detail) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut text, report, detail);
    text
}

fn write(text: &mut String, report: &Report, detail: &Detail) -> std::fmt::Result {
    writeln!(text, "# {}: {}\n", detail.case, report.verdict.name())?;
    writeln!(text, "**{}**\n\n{}\n", headline(report), evidence(report).concat())?;
    writeln!(text, "How sure: {}\n", certainty(report).join(" "))?;
    writeln!(text, "What to do:")?;
    for (index, step) in advice(report).iter().enumerate() {
        writeln!(text, "{}. {step}", index + 1)?;
    }
    writeln!(text)?;
    if !detail.rule.is_empty() {
        writeln!(text, "Decided by the rule `{}`: {}\n", report.rule, detail.rule)?;
    }
    gaps(text, report)?;
    location(text, report, detail)?;
    effects(text, report)?;
    candidates(text, report, detail)?;
    if let Some(rest) = &report.unexplained {
        writeln!(
            text,
            "Missing: something in {} (`{}`); the gap left on the fitted data is {}.\n",
            term(&rest.term),
            rest.term,
            gap(rest.gap)
        )?;
    }
    for note in &report.notes {
        writeln!(text, "- {note}")?;
    }
    if !report.notes.is_empty() {
        writeln!(text)?;
    }
    writeln!(text, "{:.1} s", report.seconds)
}

fn gaps(text: &mut String, report: &Report) -> std::fmt::Result {
    let holdout = &report.gap.holdout;
    let unseen =
        ThreeGaps { nominal: holdout.nominal, calibrated: holdout.calibrated, extended: holdout.extended };
    writeln!(text, "| gap | nominal | calibrated | extended |\n| --- | ---: | ---: | ---: |")?;
    for (name, gaps) in [("fit", &report.gap.fit), ("holdout", &unseen)] {
        let [nominal, calibrated, extended] = [gaps.nominal, gaps.calibrated, gaps.extended].map(gap);
        writeln!(text, "| {name} | {nominal} | {calibrated} | {extended} |")?;
    }
    writeln!(text)
}

fn location(text: &mut String, report: &Report, detail: &Detail) -> std::fmt::Result {
    let place = &report.location;
    if let Some(name) = &place.term {
        write!(text, "Where: {} (`{name}`)", term(name))?;
        if let Some(found) = &place.regime {
            write!(
                text,
                ", largest with {}: {} there, {} elsewhere",
                regime(found, &detail.heat_map),
                gap(found.gap_inside),
                gap(found.gap_outside)
            )?;
        }
        writeln!(text, ".\n")?;
    }
    Ok(())
}

fn effects(text: &mut String, report: &Report) -> std::fmt::Result {
    for effect in &report.effects {
        write!(text, "- `{}` (confidence {:.2}", effect.id, effect.confidence)?;
        if !effect.equivalent.is_empty() {
            write!(text, "; the data cannot tell it from `{}`", effect.equivalent.join("`, `"))?;
        }
        let values = effect.parameters.iter().map(|(name, estimate)| {
            format!("{} {}", parameters::name(name), parameters::estimate(&effect.id, name, estimate))
        });
        writeln!(text, "): {}", values.collect::<Vec<_>>().join(", "))?;
    }
    if report.effects.is_empty() { Ok(()) } else { writeln!(text) }
}

fn candidates(text: &mut String, report: &Report, detail: &Detail) -> std::fmt::Result {
    let replicates = detail.alarm.as_ref().map(|alarm| alarm.replicates);
    if report.candidates.is_empty() {
        return Ok(());
    }
    if let Some(words) = caution(report) {
        writeln!(text, "{words}\n")?;
    }
    writeln!(text, "| candidate | fit gap | gain on left-out data | p | settled |")?;
    writeln!(text, "| --- | ---: | ---: | ---: | --- |")?;
    for candidate in report.candidates.iter().take(MOST_CANDIDATES) {
        writeln!(
            text,
            "| `{}` | {} | {} | {} | {} |",
            candidate.id,
            gap(candidate.fit_gap),
            part(candidate.cv_gain),
            p_value(candidate.p_value, replicates),
            if candidate.converged { "yes" } else { "no" }
        )?;
    }
    if report.candidates.len() > MOST_CANDIDATES {
        writeln!(text, "\n{} more candidates in the report.", report.candidates.len() - MOST_CANDIDATES)?;
    }
    writeln!(text)
}
