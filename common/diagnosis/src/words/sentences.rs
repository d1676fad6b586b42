//! The verdict in one sentence, how far it reaches, how sure it is, and what a reader must know about the ranking.

use super::findings;
use super::format::{capital, decimals, gap, list, or_list, percent, plain, term};
use crate::answer::schema::{FoundEffect, HoldoutGap, PosteriorSet, Report, Verdict};
use crate::decide::criteria::Criteria;
use railgrip_words::{reword, say, t, word};
use std::fmt::Display;

/// The verdict in one sentence, with its number.
pub fn headline(report: &Report) -> String {
    let holdout = &report.gap.holdout;
    let found: Vec<String> =
        report.effects.iter().map(|effect| perhaps(effect, findings::finding(effect))).collect();
    let (before, after) = (gap(holdout.calibrated), gap(holdout.extended));
    let found = || {
        let found = capital(&found.join("; "));
        let fields: [(&str, &dyn Display); 3] = [("text", &found), ("before", &before), ("after", &after)];
        match reach(report) {
            Reach::Worse => say("{text}; this does not carry over: holdout gap {before} → {after}.", &fields),
            _ => say("{text}: holdout gap {before} → {after}.", &fields),
        }
    };
    match report.verdict {
        Verdict::None => match likelier(report) {
            Some((set, alone)) => say(
                "Nothing is shown to be missing, but {text} ({p}) is likelier than tolerances alone ({alone}): holdout gap {gap}.",
                &[
                    ("text", &set_name(set)),
                    ("p", &percent(set.p)),
                    ("alone", &percent(alone)),
                    ("gap", &before),
                ],
            ),
            None => say(
                "Nothing is missing: tolerances and noise explain the difference between model and measurement, holdout gap {gap}.",
                &[("gap", &before)],
            ),
        },
        Verdict::Effects => found(),
        Verdict::Unknown => say(
            "Something is missing in {place}, and no known effect describes it: holdout gap {gap}.",
            &[("place", &place(report)), ("gap", &before)],
        ),
        Verdict::EffectsAndUnknown => {
            let more = say("Something else is missing in {place}.", &[("place", &place(report))]);
            format!("{} {more}", found())
        }
    }
}

/// A finding as it is said of an effect that is less likely than not.
fn perhaps(effect: &FoundEffect, finding: String) -> String {
    if effect.confidence < EVEN { say("perhaps {text}", &[("text", &finding)]) } else { finding }
}

/// Probability from which something is more likely than not.
const EVEN: f64 = 0.5;

/// The verdict in a few words.
pub fn verdict(report: &Report) -> &'static str {
    match report.verdict {
        Verdict::None if likelier(report).is_some() => t("nothing settled"),
        Verdict::None => t("nothing missing"),
        Verdict::Effects => t("cause found"),
        Verdict::Unknown => t("cause unknown"),
        Verdict::EffectsAndUnknown => t("one cause found, another unknown"),
    }
}

/// A remark on the case. One on a recording begins with its name, which stays.
pub fn remark(note: &str) -> String {
    let whole = reword(note);
    match note.split_once(": ") {
        Some((file, rest)) if whole == note => format!("{file}: {}", reword(rest)),
        _ => whole,
    }
}

/// Where something is missing, in words; several places where the recordings cannot tell them apart.
pub fn place(report: &Report) -> String {
    let named = report.unexplained.as_ref();
    match named.map(|rest| rest.terms.as_slice()) {
        Some(terms) if terms.len() > 1 => or_list(&terms.iter().map(|name| term(name)).collect::<Vec<_>>()),
        _ => {
            let one = named.map(|rest| rest.term.as_str()).or(report.location.term.as_deref());
            one.map_or_else(|| t("the model").to_owned(), term)
        }
    }
}

/// Whether something gained more than chance and was found to do next to nothing to the gap.
fn is_small(report: &Report) -> bool {
    report.rule.ends_with("next_to_nothing")
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
            Verdict::Unknown => t(
                " times the noise of the sensors. No effect was added to the model. The curve under “What is missing” shows what would close the gap.",
            ),
            _ if is_small(report) => t(
                " times the noise of the sensors. What gains more than chance makes that next to nothing smaller.",
            ),
            _ => t(" times the noise of the sensors. No effect improves on that by more than chance would."),
        };
        return vec![
            t("With its tolerances fitted, the model's error on runs that were only predicted is ")
                .to_owned(),
            gap(holdout.calibrated),
            end.to_owned(),
        ];
    }
    let one = report.effects.len() == 1;
    let either = |this: &'static str, these: &'static str| if one { this } else { these };
    let [low, high] = holdout.reduction_ci95.map(percent);
    let end = match reach(report) {
        Reach::Explains => either(t("This explains the gap."), t("Together they explain the gap.")),
        Reach::ExplainsMost => {
            either(t("This explains most of the gap."), t("Together they explain most of the gap."))
        }
        Reach::ExplainsPart => {
            either(t("This explains a part of the gap."), t("Together they explain a part of the gap."))
        }
        Reach::NotShown => either(
            t(
                "That may be chance: the interval holds zero, so the runs do not show that this explains the gap elsewhere.",
            ),
            t(
                "That may be chance: the interval holds zero, so the runs do not show that these explain the gap elsewhere.",
            ),
        ),
        Reach::Worse => either(
            t("This does not carry over: on these runs the model predicts no better with it."),
            t("Together they do not carry over: on these runs the model predicts no better with them."),
        ),
    };
    let change = match holdout.reduction < 0.0 {
        true => t("On runs that were only predicted, the gap grows by "),
        false => t("On runs that were only predicted, the gap shrinks by "),
    };
    let interval = say(" (95 % interval {low} to {high}). ", &[("low", &low), ("high", &high)]);
    vec![
        change.to_owned(),
        percent(holdout.reduction.abs()),
        interval + end + &alone(holdout) + &left(report),
    ]
}

/// What is said where one window makes most of what is left: the gap is open loop, and a wheelset at its limit that slides in the
/// model and held on the track outweighs all else.
fn alone(holdout: &HoldoutGap) -> String {
    let Some(worst) = &holdout.worst_window else { return String::new() };
    let words = " One window alone makes {share} of what is left ({run}, from {start} s); without it the gap is {calibrated} → {extended}. Mostly a wheelset slides there in the model that held on the track, or the other way round.";
    say(
        words,
        &[
            ("share", &percent(worst.share)),
            ("run", &worst.run),
            ("start", &format!("{:.0}", worst.start_s)),
            ("calibrated", &gap(worst.calibrated_without)),
            ("extended", &gap(worst.extended_without)),
        ],
    )
}

/// What is said of a gap that effects leave, where it is larger than tolerances and noise make it.
fn left(report: &Report) -> String {
    let most = report.gap.fit.extended.max(report.gap.holdout.extended);
    let limits = Criteria::default().verdict;
    if report.gap.left().map_or(most > limits.unnatural_gap, |left| left > limits.unnatural_ratio) {
        let words = " Up to {gap} times the noise of the sensors is left, more than tolerances and noise make: the form differs, or something else is at work as well.";
        say(words, &[("gap", &gap(most))])
    } else {
        String::new()
    }
}

/// How likely in words, as the IPCC's guidance note on uncertainties (2010) sets them.
pub fn likely(p: f64) -> &'static str {
    match p {
        p if p >= 0.99 => t("virtually certain"),
        p if p >= 0.95 => t("extremely likely"),
        p if p >= 0.90 => t("very likely"),
        p if p >= 0.66 => t("likely"),
        p if p > 0.50 => t("more likely than not"),
        p if p >= 0.33 => t("about as likely as not"),
        _ => t("unlikely"),
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
        let mut words = say(
            "{text} that {one} is at work (confidence {p}).",
            &[("text", &capital(likely(p))), ("one", &plain(&effect.id)), ("p", &decimals(p, 2))],
        );
        if !effect.equivalent.is_empty() {
            let tied: Vec<String> = effect.equivalent.iter().map(|id| plain(id)).collect();
            words += " ";
            words += &say("These runs cannot tell it from {names}.", &[("names", &or_list(&tied))]);
        }
        said.push(words);
    }
    if let Some(words) = sets(report) {
        said.push(words);
    }
    match report.verdict {
        Verdict::None => {
            let chance = t("Chance alone would make some candidate look as good as the best one does here.");
            said.push(chance.to_owned());
        }
        Verdict::Unknown => said.push(
            t("That something is missing is more than chance explains; what it is, these candidates do not say.")
                .to_owned(),
        ),
        Verdict::Effects | Verdict::EffectsAndUnknown => {}
    }
    said
}

/// The likeliest set where nothing is named and tolerances alone are less likely than it, with what they have.
pub fn likelier(report: &Report) -> Option<(&PosteriorSet, f64)> {
    let alone = |set: &&PosteriorSet| set.effects.is_empty() && !set.unknown;
    let p = report.posterior.iter().find(alone).map_or(0.0, |set| set.p);
    let first = report.posterior.iter().max_by(|a, b| a.p.total_cmp(&b.p))?;
    (report.verdict == Verdict::None && first.p > p).then_some((first, p))
}

/// A set of effects in words.
fn set_name(set: &PosteriorSet) -> String {
    let mut parts: Vec<String> = set.effects.iter().map(|id| plain(id)).collect();
    if set.unknown {
        parts.push(t("something unknown").to_owned());
    }
    if parts.is_empty() { t("tolerances alone").to_owned() } else { parts.join(t(" with ")) }
}

/// Sets that are listed one by one, and one more where it would be the only other.
const MOST_SETS: usize = 5;

/// The sets of effects among which the truth is in nine of ten cases, where they are more than one.
fn sets(report: &Report) -> Option<String> {
    let inside: Vec<_> = report.verdict_set.iter().filter_map(|at| report.posterior.get(*at)).collect();
    let name = |set: &&PosteriorSet| format!("{} ({})", set_name(set), percent(set.p));
    (inside.len() > 1).then(|| {
        let listed = if inside.len() == MOST_SETS + 1 { inside.len() } else { MOST_SETS };
        let mut names: Vec<String> = inside.iter().take(listed).map(name).collect();
        let count = inside.len() - names.len();
        if count > 0 {
            names.push(say("{count} others that are less likely", &[("count", &count)]));
        }
        let names = or_list(&names);
        say(
            "On simulated trains the truth was among these in about nine of ten such cases: {names}.",
            &[("names", &names)],
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
        (Verdict::None, _) if is_small(report) => t(
            "None of these gains is a finding: with none of them the gap is smaller by more than next to nothing.",
        ),
        (Verdict::None, 0) => t("None of these gains is a finding: chance would gain as much."),
        (Verdict::None, _) => t(
            "A small p alone is no finding, because p compares with chance only. A candidate must also gain more than a slightly wrong formula would, and it must gain on data left out of the fit. None does here.",
        ),
        _ => t(
            "These candidates imitate the unknown effect. None of them explains enough of what a free curve would explain.",
        ),
    };
    Some(words.to_owned())
}

/// Why an effect may stand first although the table of places does not: `None` where both agree.
pub fn disagreement(report: &Report, first: &crate::answer::supplement::FreedPlace) -> Option<String> {
    let named: Vec<&str> = report.location.term.as_deref().into_iter().collect();
    if first.terms.is_empty() || named.iter().all(|name| first.terms.iter().any(|term| term == name)) {
        return None;
    }
    let place = freed(&first.place);
    let mut why = match report.effects.as_slice() {
        [] => t(
            "A free error there takes up the same mismatch, but over time; the place above was chosen because a curve there, over the variable shown under “What is missing”, explains the most.",
        )
        .to_owned(),
        effects => {
            let names = list(&effects.iter().map(|effect| plain(&effect.id)).collect::<Vec<_>>());
            say(
                "A free error there takes up what {names} causes. Effects are chosen by how well they predict runs left out of the fit, not by this table.",
                &[("names", &names)],
            )
        }
    };
    if let Some(after) = first.after.filter(|_| !report.effects.is_empty()) {
        let [before, after] = [first.before, after].map(|gain| decimals(gain, 0));
        why += " ";
        why += &say(
            "With it in the model, the gain at {place} falls from {before} to {after}.",
            &[("place", &place), ("before", &before), ("after", &after)],
        );
    }
    let named = list(&named.iter().map(|name| term(name)).collect::<Vec<_>>());
    Some(say(
        "The first row, {place}, is not the place named above, {named}. {text}",
        &[("place", &place), ("named", &named), ("text", &why)],
    ))
}

/// A law in one line. Formulas stay; what is said of them and the variable are words.
pub fn law(equation: &str) -> String {
    let over = |formula: &str| match formula.rsplit_once(" over ") {
        // A formula that is known as a whole may have the word in it.
        Some((formula, variable)) if !variable.contains('[') => {
            format!("{} {} {}", word(formula), t("over"), word(variable))
        }
        _ => word(formula),
    };
    match equation.split_once("; factor ") {
        Some((meaning, formula)) => format!("{}; {} {}", word(meaning), t("factor"), over(formula)),
        None => over(equation),
    }
}

/// A place that was freed, with its wheelset behind a comma where it has one.
pub fn freed(place: &str) -> String {
    place.split(", ").map(reword).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::schema::{NaturalGap, PosteriorSet, WorstWindow};
    use crate::decide::posterior::tests::{named, report};

    #[test]
    fn a_large_rest_is_said_beside_the_share_that_is_explained() {
        let mut report = report(Verdict::Effects, vec![named("a", 3.0, &[])]);
        assert!(!evidence(&report).concat().contains("is left"), "one sigma is nothing");
        report.gap.fit.extended = 11.2;
        let told = evidence(&report).concat();
        assert!(told.contains("Up to 11.2 times"), "a report that does not say what is natural: {told}");
        report.gap.natural = Some(NaturalGap { fit: 10.5, holdout: Some(1.5) });
        assert!(!evidence(&report).concat().contains("is left"), "a right model would leave as much");
        report.gap.natural = Some(NaturalGap { fit: 1.6, holdout: Some(1.5) });
        assert!(evidence(&report).concat().contains("Up to 11.2 times the noise of the sensors is left"));
    }

    #[test]
    fn the_first_sentence_says_that_an_effect_does_not_carry_over() {
        let mut report = report(Verdict::Effects, vec![named("a", 3.0, &[])]);
        assert!(!headline(&report).contains("carry over"), "{}", headline(&report));
        report.gap.holdout.extended = 60.0;
        assert!(
            headline(&report).contains("this does not carry over: holdout gap 2.00 → 60.0"),
            "{}",
            headline(&report)
        );
    }

    #[test]
    fn a_window_that_alone_makes_what_is_left_is_named_with_the_gap_of_all_others() {
        let mut report = report(Verdict::Effects, vec![named("a", 3.0, &[])]);
        assert!(!evidence(&report).concat().contains("One window alone"));
        report.gap.holdout.worst_window = Some(WorstWindow {
            run: "stop.wet".to_owned(),
            start_s: 20.0,
            share: 0.97,
            calibrated_without: 9.2,
            extended_without: 3.4,
        });
        let said = evidence(&report).concat();
        assert!(
            said.contains("97 % of what is left (stop.wet, from 20 s); without it the gap is 9.20 → 3.40"),
            "{said}"
        );
    }

    #[test]
    fn what_is_less_likely_than_not_is_said_so() {
        let mut report = report(Verdict::Effects, vec![named("a", 3.0, &[]), named("b", 3.0, &[])]);
        (report.effects[0].confidence, report.effects[1].confidence) = (0.8, 0.2);
        let said = headline(&report);
        assert!(!said.starts_with("Perhaps") && said.matches("perhaps").count() == 1, "{said}");
    }

    #[test]
    fn a_verdict_of_nothing_that_is_less_likely_than_something_says_so() {
        let mut report = report(Verdict::None, Vec::new());
        let set = |unknown: bool, p: f64| PosteriorSet { effects: Vec::new(), unknown, p };
        report.posterior = vec![set(false, 0.6), set(true, 0.4)];
        assert!(headline(&report).starts_with("Nothing is missing"), "{}", headline(&report));
        report.posterior = vec![set(true, 0.71), set(false, 0.17)];
        let said = headline(&report);
        assert!(said.contains("something unknown (71 %) is likelier than tolerances alone (17 %)"), "{said}");
        report.posterior.clear();
        assert!(headline(&report).starts_with("Nothing is missing"), "a report without a posterior");
    }

    #[test]
    fn a_long_list_of_sets_is_cut() {
        let mut report = report(Verdict::Effects, vec![named("a", 3.0, &[])]);
        let set = |k: usize| PosteriorSet { effects: vec![format!("e{k}")], unknown: false, p: 0.1 };
        report.posterior = (0..9).map(set).collect();
        report.verdict_set = (0..9).collect();
        let said = sets(&report).unwrap_or_default();
        assert!(said.ends_with("e4 (10 %) or 4 others that are less likely."), "{said}");
        report.verdict_set.truncate(6);
        assert!(sets(&report).unwrap_or_default().ends_with("e4 (10 %) or e5 (10 %)."));
    }

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
