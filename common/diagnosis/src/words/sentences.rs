//! The verdict in one sentence, the evidence behind it, and what a reader must know about the ranking.

use super::format::{capital, gap, list, percent, plain, term};
use crate::answer::schema::{Report, Verdict};

/// The verdict in one sentence.
pub fn headline(report: &Report) -> String {
    let names: Vec<String> = report.effects.iter().map(|effect| plain(&effect.id)).collect();
    let subject = capital(&list(&names));
    let (before, after) = (gap(report.gap.holdout.calibrated), gap(report.gap.holdout.extended));
    let verb = if names.len() == 1 { "explains" } else { "explain" };
    let place = report.location.term.as_deref().map_or_else(|| "the model".to_owned(), term);
    match report.verdict {
        Verdict::None => {
            "Nothing is missing: tolerances and noise explain the difference between model and measurement."
                .to_owned()
        }
        Verdict::Effects => {
            format!(
                "{subject} {verb} the gap: on data that were not fitted it falls from {before} to {after}."
            )
        }
        Verdict::Unknown => {
            format!("Something is missing in {place}, and no known effect describes it.")
        }
        Verdict::EffectsAndUnknown => format!(
            "{subject} {verb} part of the gap: on data that were not fitted it falls from {before} to {after}. Something \
             else is missing in {}.",
            report.unexplained.as_ref().map_or(place, |rest| term(&rest.term))
        ),
    }
}

/// The evidence in a few sentences, as pieces of which every second is emphasised.
pub fn evidence(report: &Report) -> Vec<String> {
    let holdout = &report.gap.holdout;
    if report.effects.is_empty() {
        let end = match report.verdict {
            Verdict::Unknown => {
                " times the noise of the sensors. No effect was added to the model. The curve under “What is missing” \
                 shows what would close the gap."
            }
            _ => " times the noise of the sensors. No effect improves on that by more than chance would.",
        };
        return vec![
            "With its tolerances fitted, the model's error on data that were not fitted is ".to_owned(),
            gap(holdout.calibrated),
            end.to_owned(),
        ];
    }
    let [low, high] = holdout.reduction_ci95.map(percent);
    let sure = report.effects.iter().map(|effect| format!("{} {:.2}", plain(&effect.id), effect.confidence));
    let sure = list(&sure.collect::<Vec<_>>());
    let mut end = format!(" (95 % interval {low} to {high}). Confidence that this is a cause: {sure}.");
    for effect in report.effects.iter().filter(|effect| !effect.equivalent.is_empty()) {
        let tied: Vec<String> = effect.equivalent.iter().map(|id| plain(id)).collect();
        end += &format!(" The data cannot tell {} from {}.", plain(&effect.id), list(&tied));
    }
    vec!["The gap shrinks by ".to_owned(), percent(holdout.reduction), end]
}

/// p below which a reader expects a finding: the usual 5 %.
const SMALL_P: f64 = 0.05;

/// What a reader of the ranking must know where nothing was found.
pub fn caution(report: &Report) -> Option<String> {
    if !report.effects.is_empty() || report.candidates.is_empty() {
        return None;
    }
    let small = report.candidates.iter().filter(|candidate| candidate.p_value < SMALL_P).count();
    let words = match (report.verdict, small) {
        (Verdict::None, 0) => "None of these gains is a finding: chance would gain as much.",
        (Verdict::None, _) => {
            "A small p alone is no finding, because p compares with chance only. A candidate must also gain more than a \
             slightly wrong formula would, and it must gain on data left out of the fit. None does here."
        }
        _ => {
            "These candidates imitate the unknown effect. None of them explains enough of what a free curve would explain."
        }
    };
    Some(words.to_owned())
}
