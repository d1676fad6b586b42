//! The verdict in one sentence, how far it reaches, how sure it is, and what a reader must know about the ranking.

use super::findings;
use super::format::{capital, gap, list, or_list, percent, plain, term};
use crate::answer::schema::{FoundEffect, Report, Verdict};

/// The verdict in one sentence, with its number.
pub fn headline(report: &Report) -> String {
    let holdout = &report.gap.holdout;
    let found: Vec<String> = report.effects.iter().map(findings::finding).collect();
    let found = format!(
        "{}: holdout gap {} → {}.",
        capital(&found.join("; ")),
        gap(holdout.calibrated),
        gap(holdout.extended)
    );
    match report.verdict {
        Verdict::None => format!(
            "Nothing is missing: tolerances and noise explain the difference between model and measurement, holdout gap {}.",
            gap(holdout.calibrated)
        ),
        Verdict::Effects => found,
        Verdict::Unknown => format!(
            "Something is missing in {}, and no known effect describes it: holdout gap {}.",
            place(report),
            gap(holdout.calibrated)
        ),
        Verdict::EffectsAndUnknown => format!("{found} Something else is missing in {}.", place(report)),
    }
}

/// Where something is missing, in words; several places where the recordings cannot tell them apart.
pub fn place(report: &Report) -> String {
    let named = report.unexplained.as_ref();
    match named.map(|rest| rest.terms.as_slice()) {
        Some(terms) if terms.len() > 1 => or_list(&terms.iter().map(|name| term(name)).collect::<Vec<_>>()),
        _ => {
            let one = named.map(|rest| rest.term.as_str()).or(report.location.term.as_deref());
            one.map_or_else(|| "the model".to_owned(), term)
        }
    }
}

/// How much of the gap the effects explain on runs that were only predicted, by the lower end of the interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// What they leave is small beside what was there.
    Explains,
    /// More than half of it.
    ExplainsMost,
    /// Some of it.
    ExplainsPart,
    /// The interval holds zero.
    NotShown,
    /// The gap grows.
    Worse,
}

/// Share of the squared excess gap that must be gone at least for "explains": the rest is then less than half of the gap.
const EXPLAINS: f64 = 0.8;
/// And for "explains most of": more than half.
const EXPLAINS_MOST: f64 = 0.5;

/// How far the effects reach. The share is that of the squared gap above the sensors' noise (a gap of one), at the less
/// favourable end of the reduction's 95 % interval.
pub fn reach(report: &Report) -> Reach {
    let holdout = &report.gap.holdout;
    if report.carries_over == Some(false) || holdout.extended > holdout.calibrated {
        return Reach::Worse;
    }
    let excess = |gap: f64| (gap * gap - 1.0).max(0.0);
    let share = |reduction: f64| {
        1.0 - excess(holdout.calibrated * (1.0 - reduction))
            / excess(holdout.calibrated).max(f64::MIN_POSITIVE)
    };
    let [low, _] = holdout.reduction_ci95;
    match share(low) {
        least if least >= EXPLAINS && report.verdict == Verdict::Effects => Reach::Explains,
        least if least >= EXPLAINS_MOST => Reach::ExplainsMost,
        least if least > 0.0 && low > 0.0 => Reach::ExplainsPart,
        _ => Reach::NotShown,
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
            "With its tolerances fitted, the model's error on runs that were only predicted is ".to_owned(),
            gap(holdout.calibrated),
            end.to_owned(),
        ];
    }
    let one = report.effects.len() == 1;
    let subject = if one { "This" } else { "Together they" };
    let (explain, do_not) = if one { ("explains", "does not") } else { ("explain", "do not") };
    let [low, high] = holdout.reduction_ci95.map(percent);
    let end = match reach(report) {
        Reach::Explains => format!("{subject} {explain} the gap."),
        Reach::ExplainsMost => format!("{subject} {explain} most of the gap."),
        Reach::ExplainsPart => format!("{subject} {explain} a part of the gap."),
        Reach::NotShown => format!(
            "That may be chance: the interval holds zero, so the runs do not show that {} the gap elsewhere.",
            if one { "this explains" } else { "these explain" }
        ),
        Reach::Worse => {
            format!("{subject} {do_not} carry over: on these runs the model predicts no better with it.")
        }
    };
    let verb = if holdout.reduction < 0.0 { "grows" } else { "shrinks" };
    vec![
        format!("On runs that were only predicted, the gap {verb} by "),
        percent(holdout.reduction.abs()),
        format!(" (95 % interval {low} to {high}). {end}"),
    ]
}

/// How likely in words, as the IPCC's guidance note on uncertainties (2010) sets them.
pub fn likely(p: f64) -> &'static str {
    match p {
        p if p >= 0.99 => "virtually certain",
        p if p >= 0.95 => "extremely likely",
        p if p >= 0.90 => "very likely",
        p if p >= 0.66 => "likely",
        p if p > 0.50 => "more likely than not",
        p if p >= 0.33 => "about as likely as not",
        _ => "unlikely",
    }
}

/// Probability of an effect: that of the posterior where there is one.
fn probability(effect: &FoundEffect) -> f64 {
    effect.p.unwrap_or(effect.confidence)
}

/// How sure the answer is, one sentence for each thing that matters.
pub fn certainty(report: &Report) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    for effect in &report.effects {
        let p = probability(effect);
        let mut words =
            format!("{} that {} is at work (confidence {p:.2}).", capital(likely(p)), plain(&effect.id));
        if !effect.equivalent.is_empty() {
            let tied: Vec<String> = effect.equivalent.iter().map(|id| plain(id)).collect();
            words += &format!(" These runs cannot tell it from {}.", or_list(&tied));
        }
        said.push(words);
    }
    if let Some(words) = sets(report) {
        said.push(words);
    }
    match report.verdict {
        Verdict::None => {
            said.push("Chance alone would make some candidate look as good as the best one does here.".to_owned());
        }
        Verdict::Unknown => said.push(
            "That something is missing is more than chance explains; what it is, these candidates do not say."
                .to_owned(),
        ),
        Verdict::Effects | Verdict::EffectsAndUnknown => {}
    }
    said
}

/// The sets of effects among which the truth is in nine of ten cases, where they are more than one.
fn sets(report: &Report) -> Option<String> {
    let inside: Vec<_> = report.verdict_set.iter().filter_map(|at| report.posterior.get(*at)).collect();
    let name = |set: &&crate::answer::schema::PosteriorSet| {
        let mut parts: Vec<String> = set.effects.iter().map(|id| plain(id)).collect();
        if set.unknown {
            parts.push("something unknown".to_owned());
        }
        let parts = if parts.is_empty() { "tolerances alone".to_owned() } else { parts.join(" with ") };
        format!("{parts} ({})", percent(set.p))
    };
    (inside.len() > 1).then(|| {
        format!(
            "In nine of ten such cases the truth is among these: {}.",
            or_list(&inside.iter().map(name).collect::<Vec<_>>())
        )
    })
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

/// Why an effect may stand first although the table of places does not: `None` where both agree.
pub fn disagreement(report: &Report, first: &crate::answer::supplement::FreedPlace) -> Option<String> {
    let named: Vec<&str> = report.location.term.as_deref().into_iter().collect();
    if first.terms.is_empty() || named.iter().all(|name| first.terms.iter().any(|term| term == name)) {
        return None;
    }
    let why = match (report.effects.as_slice(), first.after) {
        ([], _) => "A free error there takes up the same mismatch, but over time; the place above was chosen because a \
                    curve there, over the variable shown under “What is missing”, explains the most."
            .to_owned(),
        (effects, after) => {
            let names = list(&effects.iter().map(|effect| plain(&effect.id)).collect::<Vec<_>>());
            let left = after.map_or_else(String::new, |after| {
                format!(" With it in the model, the gain at {} falls from {:.0} to {after:.0}.", first.place, first.before)
            });
            format!(
                "A free error there takes up what {names} causes. Effects are chosen by how well they predict runs left \
                 out of the fit, not by this table.{left}"
            )
            .replace("to -", "to −")
        }
    };
    Some(format!(
        "The first row, {}, is not the place named above, {}. {why}",
        first.place,
        list(&named.iter().map(|name| term(name)).collect::<Vec<_>>())
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn likelihoods_have_their_words() {
        let words =
            [(0.995, "virtually certain"), (0.98, "extremely likely"), (0.9, "very likely"), (0.7, "likely")];
        for (p, said) in words {
            assert_eq!(likely(p), said);
        }
        assert_eq!(
            [0.6, 0.5, 0.1].map(likely),
            ["more likely than not", "about as likely as not", "unlikely"]
        );
    }
}
