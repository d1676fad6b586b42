//! The report as a short Markdown text for the terminal.

use super::advice::advice;
use super::format::{decimals, gap, p_value, part, term};
use super::parameters;
use super::regime::regime;
use super::sentences::{caution, certainty, evidence, headline, remark};
use crate::answer::schema::{Report, ThreeGaps};
use crate::answer::supplement::Detail;
use railgrip_words::{reword, say, t};
use std::fmt::{Display, Write};

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
    writeln!(text, "# {}: {}\n", detail.case, t(report.verdict.name()))?;
    writeln!(text, "**{}**\n\n{}\n", headline(report), evidence(report).concat())?;
    writeln!(text, "{}: {}\n", t("How sure"), certainty(report).join(" "))?;
    writeln!(text, "{}:", t("What to do"))?;
    for (index, step) in advice(report).iter().enumerate() {
        writeln!(text, "{}. {step}", index + 1)?;
    }
    writeln!(text)?;
    if !detail.rule.is_empty() {
        let rule: [(&str, &dyn Display); 2] = [("free", &report.rule), ("text", &reword(&detail.rule))];
        writeln!(text, "{}\n", say("Decided by the rule `{free}`: {text}", &rule))?;
    }
    gaps(text, report)?;
    location(text, report, detail)?;
    effects(text, report)?;
    candidates(text, report, detail)?;
    if let Some(rest) = &report.unexplained {
        let missing: [(&str, &dyn Display); 3] =
            [("place", &term(&rest.term)), ("free", &rest.term), ("gap", &gap(rest.gap))];
        let words = say(
            "Missing: something in {place} (`{free}`); the gap left on the fitted data is {gap}.",
            &missing,
        );
        writeln!(text, "{words}\n")?;
    }
    for note in &report.notes {
        writeln!(text, "- {}", remark(note))?;
    }
    if !report.notes.is_empty() {
        writeln!(text)?;
    }
    writeln!(text, "{} s", decimals(report.seconds, 1))
}

fn gaps(text: &mut String, report: &Report) -> std::fmt::Result {
    let holdout = &report.gap.holdout;
    let unseen =
        ThreeGaps { nominal: holdout.nominal, calibrated: holdout.calibrated, extended: holdout.extended };
    let natural = report.gap.natural;
    let sets = [
        (t("fit"), &report.gap.fit, natural.map(|gap| gap.fit)),
        (t("holdout"), &unseen, natural.and_then(|gap| gap.holdout)),
    ];
    let [of, nominal, calibrated, extended] = [t("gap"), t("nominal"), t("calibrated"), t("extended")];
    writeln!(text, "| {of} | {nominal} | {calibrated} | {extended} | {} |", t("a right model"))?;
    writeln!(text, "| --- | ---: | ---: | ---: | ---: |")?;
    for (name, gaps, natural) in sets {
        let [nominal, calibrated, extended] = [gaps.nominal, gaps.calibrated, gaps.extended].map(gap);
        let natural = natural.map(gap).unwrap_or_default();
        writeln!(text, "| {name} | {nominal} | {calibrated} | {extended} | {natural} |")?;
    }
    writeln!(text)
}

fn location(text: &mut String, report: &Report, detail: &Detail) -> std::fmt::Result {
    let place = &report.location;
    if let Some(name) = &place.term {
        write!(text, "{}: {} (`{name}`)", t("Where"), term(name))?;
        if let Some(found) = &place.regime {
            let (inside, outside) = (gap(found.gap_inside), gap(found.gap_outside));
            let words: [(&str, &dyn Display); 3] =
                [("text", &regime(found, &detail.heat_map)), ("inside", &inside), ("outside", &outside)];
            write!(text, "{}", say(", largest with {text}: {inside} there, {outside} elsewhere", &words))?;
        }
        writeln!(text, ".\n")?;
    }
    Ok(())
}

fn effects(text: &mut String, report: &Report) -> std::fmt::Result {
    for effect in &report.effects {
        write!(text, "- `{}` ({} {}", effect.id, t("confidence"), decimals(effect.confidence, 2))?;
        if !effect.equivalent.is_empty() {
            let others = effect.equivalent.join("`, `");
            write!(text, "{}", say("; the data cannot tell it from `{free}`", &[("free", &others)]))?;
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
    let names = [t("candidate"), t("fit gap"), t("gain on left-out data"), "p", t("settled")];
    writeln!(text, "| {} |", names.join(" | "))?;
    writeln!(text, "| --- | ---: | ---: | ---: | --- |")?;
    for candidate in report.candidates.iter().take(MOST_CANDIDATES) {
        writeln!(
            text,
            "| `{}` | {} | {} | {} | {} |",
            candidate.id,
            gap(candidate.fit_gap),
            part(candidate.cv_gain),
            p_value(candidate.p_value, replicates),
            if candidate.converged { t("yes") } else { t("no") }
        )?;
    }
    if let Some(without) = detail.gap_without_any {
        writeln!(text, "| {} | {} | | | |", t("tolerances alone"), gap(without))?;
    }
    if report.candidates.len() > MOST_CANDIDATES {
        let more = report.candidates.len() - MOST_CANDIDATES;
        writeln!(text, "\n{}", say("{count} more candidates in the report.", &[("count", &more)]))?;
    }
    writeln!(text)
}
