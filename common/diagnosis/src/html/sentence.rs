//! The verdict in one sentence, and the evidence behind it in a second.

use super::words::{gap, list, percent, plain, term};
use crate::answer::schema::{Report, Verdict};

/// The verdict in one sentence.
pub fn headline(report: &Report) -> String {
    let names: Vec<String> = report.effects.iter().map(|effect| plain(&effect.id)).collect();
    let subject = capital(&list(&names));
    let (before, after) = (gap(report.gap.holdout.calibrated), gap(report.gap.holdout.extended));
    let verb = if names.len() == 1 { "explains" } else { "explain" };
    let place = report.location.term.as_deref().map(term).unwrap_or_else(|| "the model".to_owned());
    match report.verdict {
        Verdict::None => {
            "Nothing is missing: the calibrated model predicts as well as the sensors and chance allow."
                .to_owned()
        }
        Verdict::Effects => {
            format!("{subject} {verb} the gap: on unseen runs it falls from {before} to {after}.")
        }
        Verdict::Unknown => {
            format!("Something is missing in {place} that no effect of the library describes.")
        }
        Verdict::EffectsAndUnknown => format!(
            "{subject} {verb} part of the gap, from {before} to {after} on unseen runs; something else is missing in {}.",
            report.unexplained.as_ref().map_or(place, |rest| term(&rest.term))
        ),
    }
}

/// The evidence in one or two sentences, as pieces of which every second is emphasised.
pub fn evidence(report: &Report) -> Vec<String> {
    let holdout = &report.gap.holdout;
    if report.effects.is_empty() {
        let mut pieces = vec!["The gap on unseen runs is ".to_owned(), gap(holdout.calibrated)];
        pieces.push(" sensor sigmas with fitted nuisances".to_owned());
        pieces.push(String::new());
        pieces.push(match report.verdict {
            Verdict::Unknown => {
                ". No candidate is added to the model; the curve below shows what is missing.".to_owned()
            }
            _ => ", and no candidate improves on that by more than chance and small errors of form would."
                .to_owned(),
        });
        return pieces;
    }
    let mut pieces = vec!["The gap shrinks by ".to_owned(), percent(holdout.reduction)];
    let [low, high] = holdout.reduction_ci95.map(percent);
    pieces.push(format!(" (95 % interval {low} to {high}). Confidence: "));
    let sure = report.effects.iter().map(|effect| format!("{} {:.2}", plain(&effect.id), effect.confidence));
    pieces.push(list(&sure.collect::<Vec<_>>()));
    let tied: Vec<String> =
        report.effects.iter().flat_map(|effect| effect.equivalent.iter().map(|id| plain(id))).collect();
    pieces.push(if tied.is_empty() {
        ".".to_owned()
    } else {
        format!("; the data cannot tell it from {}.", list(&tied))
    });
    pieces
}

/// Level of p below which a reader expects a finding.
const SMALL_P: f64 = 0.05;

/// What a reader of the ranking must know where nothing was found.
pub fn caution(report: &Report) -> Option<String> {
    if !report.effects.is_empty() || report.candidates.is_empty() {
        return None;
    }
    let small = report.candidates.iter().filter(|candidate| candidate.p_value < SMALL_P).count();
    let shares = "Gains are shares of what is left after calibration";
    Some(match (report.verdict, small) {
        (Verdict::None, 0) => {
            format!("{shares}, and that is no more than chance here: none of them is a finding.")
        }
        (Verdict::None, _) => format!(
            "{shares}. A small p alone is no finding: it compares with chance, and a candidate must also gain more than laws of \
             a slightly wrong form do, and on the runs left out, too. None does here."
        ),
        _ => format!(
            "{shares}. What these candidates gain is real but imitates: none recovers enough of what a free curve would."
        ),
    })
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
