//! The score as a Markdown table and as JSON.

use std::{collections::BTreeMap, fmt::Write as _};

use serde_json::json;

use super::next_run::Next;
use super::outcome::{Outcome, Rate};
use super::score::Score;
use super::slices;
use crate::CliError;

/// What stands above a score.
pub(super) struct Head<'a> {
    /// Cases that were made.
    pub cases: usize,
    /// Seed of the command line.
    pub seed: u64,
    /// Sets of forms.
    pub forms: &'a str,
    /// Hash of the seal.
    pub digest: &'a str,
}

/// The score for people.
pub(super) fn markdown(score: &Score, outcomes: &[Outcome], head: &Head) -> String {
    let Head { cases, seed, forms, digest } = *head;
    let left = match cases - outcomes.len().min(cases) {
        0 => String::new(),
        _ => format!("; {} of its cases, the labels of the others still sealed", outcomes.len()),
    };
    let mut text = format!(
        "# Blind test of the gap diagnosis\n\n`railgrip gap blind --cases {cases} --seed {seed} --forms {forms}`{left}; labels sealed as \
         SHA-256 `{digest}`. The first table is about the {} cases in which there is nothing or something to see (salience \
         of 1.1 and more).\n\n| figure | diagnosis | RMSE ranking | one-shot correlation | to reach |\n| --- | --- | --- | --- | --- |\n",
        outcomes.iter().filter(|outcome| outcome.is_visible()).count()
    );
    let baselines = [&score.baseline_rmse, &score.baseline_correlation];
    let mut row = |what: &str, value: String, baseline: [String; 2], goal: &str| {
        let [rmse, correlation] = baseline;
        let _ = writeln!(text, "| {what} | {value} | {rmse} | {correlation} | {goal} |");
    };
    let nothing = || [String::new(), String::new()];
    row("top-1, one effect", rate(score.top_1), baselines.map(|baseline| rate(baseline.top_1)), "≥ 0.92");
    row("top-1 or a declared equivalent", rate(score.top_1_or_equivalent), nothing(), "≥ 0.95");
    for left in &score.left {
        let value = format!("{}; {}", rate(left.top_1), rate(left.top_1_or_equivalent));
        row(
            &format!("… both, of which the calibration under test leaves {:.1} times the floor", left.times),
            value,
            nothing(),
            "",
        );
    }
    row("term, one effect", rate(score.term), nothing(), "≥ 0.97");
    row(
        "false alarms where there is no effect",
        rate(score.false_alarms),
        baselines.map(|b| rate(b.false_alarms)),
        "≤ 0.03",
    );
    row(
        "unknown called unknown",
        rate(score.unknown_called_unknown),
        baselines.map(|b| rate(b.unknown_called_unknown)),
        "≥ 0.90",
    );
    for left in &score.left {
        let value = rate(left.unknown_called_unknown);
        row(
            &format!("… of which the calibration under test leaves {:.1} times the floor", left.times),
            value,
            nothing(),
            "",
        );
    }
    row("… and no effect named beside it", rate(score.unknown_and_nothing_else), nothing(), "");
    row("… with the right term", rate(score.unknown_with_right_term), nothing(), "≥ 0.80");
    row("… whose id was withheld", rate(score.withheld_called_unknown), nothing(), "");
    row("… that no id names", rate(score.nameless_called_unknown), nothing(), "");
    row(
        "both of a pair named",
        rate(score.pairs_both_named),
        baselines.map(|b| rate(b.pairs_both_named)),
        "≥ 0.75",
    );
    row("all of three named", rate(score.triples_all_named), nothing(), "≥ 0.5");
    row(
        "of two and three: effects that show beside the others, named",
        rate(score.each_that_shows),
        nothing(),
        "",
    );
    row("of two and three: all that show named", rate(score.all_that_show), nothing(), "");
    row("`unknown` beside one nameable effect", rate(score.unknown_beside_a_right_name), nothing(), "");
    row("a name too many beside one effect", rate(score.name_too_many), nothing(), "");
    row(
        &format!("closure on holdout, median of {}", score.closure_cases),
        two(score.closure_median),
        nothing(),
        "≥ 0.95",
    );
    row("closure on holdout, lower decile", two(score.closure_lower_decile), nothing(), "≥ 0.50");
    row("parameter error where forms agree, median", two(score.parameter_error_median), nothing(), "");
    row("truth in the 95 % interval", rate(score.in_ci95), nothing(), "");
    row("truth in the 90 % interval", rate(score.in_90), nothing(), "0.85–0.95");
    row(
        "holdout gaps follow from the prediction files",
        rate(score.gaps_follow_from_files),
        nothing(),
        "all",
    );
    let beliefs = &score.beliefs;
    row(
        &format!("calibration error of {} names, all cases", beliefs.names),
        two(beliefs.calibration_error),
        nothing(),
        "≤ 0.05",
    );
    row("verdict set holds the truth, all cases", rate(beliefs.sets_hold), nothing(), "0.88–0.93");
    row("sets in a verdict set, mean", two(beliefs.mean_size), nothing(), "≤ 1.5");
    row("area of the probability of something unknown", two(beliefs.unknown_area), nothing(), "≥ 0.95");
    let seconds = format!("{:.1} / {:.1}", score.seconds_median, score.seconds_longest);
    row("seconds a case, median / longest, one thread", seconds, nothing(), "≤ 10 / 30 on 2 cores");
    row("diagnoses that failed", score.failed.to_string(), nothing(), "0");

    text.push_str("\n## What confidence means\n\n| stated | mean | right |\n| --- | --- | --- |\n");
    for bin in score.confidence.iter().filter(|bin| bin.right.of > 0) {
        let (low, high) = bin.range;
        let _ = writeln!(text, "| {low:.2}–{high:.2} | {:.2} | {} |", bin.stated, rate(bin.right));
    }
    text.push_str("\n## Who is taken for whom\n\nOnly answers that are not right.\n\n| truth | answer | times |\n| --- | --- | --- |\n");
    for ((truth, answer), times) in confusion(outcomes.iter().filter(|outcome| !outcome.is_right())) {
        let _ = writeln!(text, "| {truth} | {answer} | {times} |");
    }
    text + &slices::markdown(&slices::tables(outcomes))
}

/// The score for machines, with every case.
pub(super) fn json(
    score: &Score,
    outcomes: &[Outcome],
    next: &[Next],
    head: &Head,
) -> Result<String, CliError> {
    let matrix: Vec<_> = confusion(outcomes.iter())
        .into_iter()
        .map(|((truth, answer), times)| json!({"truth": truth, "answer": answer, "times": times}))
        .collect();
    let all = json!({
        "schema": "railgrip.gap.blind/1", "cases": head.cases, "scored": outcomes.len(), "seed": head.seed,
        "forms": head.forms, "sealed_sha256": head.digest, "slices": slices::tables(outcomes),
        "score": score, "confusion": matrix, "outcomes": outcomes, "next_runs": next,
    });
    serde_json::to_string_pretty(&all).map_err(CliError::failed)
}

fn confusion<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> BTreeMap<(String, String), usize> {
    let mut matrix = BTreeMap::new();
    for outcome in outcomes {
        let answer = match &outcome.answer {
            Some(answer) => answer.word(),
            None => "no answer".to_owned(),
        };
        *matrix.entry((truth(outcome), answer)).or_default() += 1;
    }
    matrix
}

fn truth(outcome: &Outcome) -> String {
    let label = &outcome.made.label;
    let ids: Vec<&str> = label.effects.iter().map(|effect| effect.id.as_str()).collect();
    match label.effects.as_slice() {
        [] => "none".to_owned(),
        [effect] if outcome.made.is_unknown() => {
            let why = if effect.named { "withheld" } else { "nameless" };
            format!("{why} {} ({})", effect.id, effect.term)
        }
        _ => ids.join(" + "),
    }
}

fn rate(rate: Rate) -> String {
    rate.to_string()
}

fn two(value: f64) -> String {
    if value.is_nan() { "–".to_owned() } else { format!("{value:.2}") }
}
