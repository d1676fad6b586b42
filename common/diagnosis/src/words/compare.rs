//! What has changed between two reports of one vehicle, in sentences and as a text for the terminal.

use super::findings::finding;
use super::format::{capital, gap, plain, term};
use super::parameters;
use crate::answer::compare::{Change, EffectChange, ParameterChange, effects};
use crate::answer::schema::{ParameterEstimate, Report, Verdict};
use railgrip_words::{say, t};
use std::fmt::{Display, Write};

/// A report and what it is called.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// For people, such as the name of its file.
    pub name: &'a str,
    /// The report.
    pub report: &'a Report,
}

/// What has changed, in one sentence for each thing; the most important one first.
pub fn changes(first: Named<'_>, second: Named<'_>) -> Vec<String> {
    let all = effects(first.report, second.report);
    let mut said: Vec<String> = [Change::New, Change::Gone, Change::Moved, Change::Same]
        .iter()
        .flat_map(|change| all.iter().filter(move |effect| effect.change == *change))
        .map(effect)
        .collect();
    said.extend(missing(first.report, second.report));
    if said.is_empty() {
        said.push(t("Neither report finds anything missing: tolerances and noise explain both.").to_owned());
    }
    said
}

fn effect(change: &EffectChange) -> String {
    let found = |effect: &Option<crate::answer::schema::FoundEffect>| {
        effect.as_ref().map_or_else(|| plain(&change.id), finding)
    };
    let name = capital(&plain(&change.id));
    let said = |message, what: &dyn Display| say(message, &[("one", &name), ("text", what)]);
    match change.change {
        Change::New => said("{one} is new: {text}.", &found(&change.second)),
        Change::Gone => said("{one} is gone; before, {text}.", &found(&change.first)),
        Change::Moved => {
            let moved: Vec<String> =
                change.parameters.iter().filter(|p| p.differs).map(|p| moved(&change.id, p)).collect();
            said("{one} has changed: {text}.", &moved.join("; "))
        }
        Change::Same => said("{one} is as before, within the intervals: {text}.", &found(&change.second)),
    }
}

fn moved(id: &str, change: &ParameterChange) -> String {
    say(
        "{what} from {first} to {second}",
        &[
            ("what", &parameters::name(&change.name)),
            ("first", &value(id, &change.name, change.first.as_ref())),
            ("second", &value(id, &change.name, change.second.as_ref())),
        ],
    )
}

/// A value of a table; a dash where a report has none.
pub fn value(id: &str, name: &str, estimate: Option<&ParameterEstimate>) -> String {
    estimate.map_or_else(|| "–".to_owned(), |estimate| parameters::estimate(id, name, estimate))
}

/// What became of something that no candidate describes.
fn missing(first: &Report, second: &Report) -> Option<String> {
    let place = |report: &Report| {
        report
            .unexplained
            .as_ref()
            .map(|rest| term(&rest.term))
            .filter(|_| matches!(report.verdict, Verdict::Unknown | Verdict::EffectsAndUnknown))
    };
    match (place(first), place(second)) {
        (None, None) => None,
        (None, Some(after)) => Some(say("Something unknown is new, in {place}.", &[("place", &after)])),
        (Some(before), None) => Some(say("What was missing in {place} is no longer.", &[("place", &before)])),
        (Some(before), Some(after)) if before == after => {
            Some(say("Something unknown is missing in {place}, as before.", &[("place", &after)]))
        }
        (Some(before), Some(after)) => Some(say(
            "Something unknown was missing in {place}, and now in {what}.",
            &[("place", &before), ("what", &after)],
        )),
    }
}

/// The comparison as a short Markdown text for the terminal.
pub fn summary(first: Named<'_>, second: Named<'_>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut text, first, second);
    text
}

fn write(text: &mut String, first: Named<'_>, second: Named<'_>) -> std::fmt::Result {
    writeln!(text, "# {} → {}\n", first.name, second.name)?;
    for words in changes(first, second) {
        writeln!(text, "- {words}")?;
    }
    writeln!(
        text,
        "\n| {} | {} | {} | {} |\n| --- | ---: | ---: | ---: |",
        t("holdout gap"),
        t("nominal"),
        t("calibrated"),
        t("extended")
    )?;
    for Named { name, report } in [first, second] {
        let holdout = &report.gap.holdout;
        let [nominal, calibrated, extended] =
            [holdout.nominal, holdout.calibrated, holdout.extended].map(gap);
        writeln!(text, "| {name} | {nominal} | {calibrated} | {extended} |")?;
    }
    let all = effects(first.report, second.report);
    if all.is_empty() {
        return Ok(());
    }
    writeln!(
        text,
        "\n| {} | {} | {} | {} |\n| --- | --- | --- | --- |",
        t("parameter"),
        first.name,
        second.name,
        t("differs")
    )?;
    for effect in &all {
        for p in &effect.parameters {
            writeln!(
                text,
                "| {}: {} | {} | {} | {} |",
                plain(&effect.id),
                parameters::name(&p.name),
                value(&effect.id, &p.name, p.first.as_ref()),
                value(&effect.id, &p.name, p.second.as_ref()),
                differs(p)
            )?;
        }
    }
    Ok(())
}

/// Whether a parameter differs, in a word.
pub fn differs(p: &ParameterChange) -> &'static str {
    match (p.first.is_some() && p.second.is_some(), p.differs) {
        (false, _) => "–",
        (true, true) => t("yes"),
        (true, false) => t("no"),
    }
}
