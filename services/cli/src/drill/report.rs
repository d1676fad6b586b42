//! The score as a Markdown table, and every alert as a line.

use std::{collections::BTreeMap, fmt::Write as _};

use super::drive::Driven;
use super::score::{Found, Score, at_place};

/// What stands where there is nothing to count.
const NONE: &str = "–";

/// What was true of a train and what was said of it.
pub(super) fn lines(driven: &Driven) -> String {
    let label = &driven.label;
    let fault = label.fault.as_ref().map_or_else(
        || "no fault".to_owned(),
        |fault| {
            format!(
                "{} {:.3} at {:.0} s, wagons {:?}, wheelsets {:?}",
                fault.id, fault.size, fault.onset_s, fault.places, fault.wheelsets
            )
        },
    );
    let mut text = format!(
        "{} (seed {}, {} of {}, {:.1} h): {fault}\n",
        label.train,
        label.seed,
        label.family,
        label.wagons.len(),
        label.hours
    );
    for alert in &driven.alerts {
        let from_one = |places: &[usize]| places.iter().map(|place| place + 1).collect::<Vec<_>>();
        let _ = writeln!(
            text,
            "  {:.0} s {} {} ({:.2}), wagons {:?}, wheelsets {:?}: {}",
            alert.raised_t_s,
            alert.grade.word(),
            alert.cause.word(),
            alert.probability,
            from_one(&alert.wagons),
            from_one(&alert.wheelsets),
            alert.reason
        );
    }
    text
}

/// The score for people.
pub(super) fn markdown(score: &Score, command: &str) -> String {
    let mut text = format!(
        "# Drill: are the alarms right?\n\n`{command}`: {} trains, {:.1} train-hours, {:.1} wagon-hours. The watch took {:.2} s of a core a train-hour, the train itself {:.1} s.\n\n",
        score.trains,
        score.hours,
        score.wagon_hours,
        score.watch_s / score.hours.max(1e-9),
        score.plant_s / score.hours.max(1e-9),
    );
    // Of hours that are none a rate is none either.
    let healthy = score.healthy_hours;
    let rate = |count: usize| match healthy >= 0.05 {
        true => format!("{:.0} ({count} in {healthy:.1} h)", 1000.0 * count as f64 / healthy),
        false => NONE.to_owned(),
    };
    let told: Vec<&Found> = score.found.iter().filter(|found| found.could_show()).collect();
    let gross: Vec<&Found> = told.iter().copied().filter(|found| found.fault.gross).collect();
    let there: Vec<&Found> =
        score.found.iter().filter(|found| found.was_there() && found.fault.gross).collect();
    let with: Vec<&Found> = told.iter().copied().filter(|found| found.first.is_some()).collect();
    let named: Vec<&Found> = told.iter().copied().filter(|found| found.right.is_some()).collect();
    let share = |part: usize, whole: usize| match whole {
        0 => NONE.to_owned(),
        _ => format!("{:.2} ({part} of {whole})", part as f64 / whole as f64),
    };
    let of = |list: &[&Found], test: &dyn Fn(&Found) -> bool| {
        share(list.iter().filter(|found| test(found)).count(), list.len())
    };
    let first_at_place =
        |found: &Found| found.first.as_ref().is_some_and(|alert| at_place(alert, &found.fault));
    let first_cause =
        |found: &Found| found.first.as_ref().is_some_and(|alert| alert.cause.word() == found.fault.cause);
    let wheelsets: Vec<bool> = named.iter().filter_map(|found| found.right_wheelset()).collect();
    let alerts: usize = with.iter().map(|found| found.alerts).sum();
    let _ = writeln!(text, "| figure | value | to reach |\n| --- | --- | --- |");
    let mut row = |what: &str, value: String, goal: &str| {
        let _ = writeln!(text, "| {what} | {value} | {goal} |");
    };
    let [watch, act] = score.false_alarms;
    row("false alarms of grade act per 1,000 healthy train-hours", rate(act), "≤ 1");
    row("false alarms of grade watch per 1,000 healthy train-hours", rate(watch), "≤ 10");
    row("gross faults found in time", of(&gross, &|found: &Found| found.in_time()), "≥ 0.95");
    row(
        "the same with fades and low stretches that never showed",
        of(&there, &|found: &Found| found.in_time()),
        "",
    );
    row("first alert after the onset on the right wagon", of(&with, &first_at_place), "≥ 0.98");
    row(
        "right wheelset among at most two",
        share(wheelsets.iter().filter(|right| **right).count(), wheelsets.len()),
        "≥ 0.90",
    );
    row("first alert names the right cause first", of(&with, &first_cause), "≥ 0.90");
    row(
        "alerts a fault that raised any",
        match with.len() {
            0 => NONE.to_owned(),
            faults => format!("{:.2}", alerts as f64 / faults as f64),
        },
        "≤ 1.1",
    );
    row(
        "expected calibration error of the probability",
        match score.stated.len() {
            0 => NONE.to_owned(),
            stated => format!("{:.2} over {stated} alerts", score.calibration_error()),
        },
        "≤ 0.05",
    );
    if !score.false_causes.is_empty() {
        let list: Vec<String> =
            score.false_causes.iter().map(|(cause, count)| format!("{cause} {count}")).collect();
        let _ = writeln!(text, "\nFalse alarms by cause: {}.", list.join(", "));
    }
    by_kind(&mut text, &told);
    confusion(&mut text, &told);
    text
}

/// Found in time and after how many applications, by kind of fault.
fn by_kind(text: &mut String, told: &[&Found]) {
    let mut kinds: BTreeMap<&str, Vec<&Found>> = BTreeMap::new();
    for found in told {
        kinds.entry(&found.fault.id).or_default().push(found);
    }
    text.push_str("\n| fault | gross: found in time | smaller: found in time | applications until found, size by size |\n| --- | ---: | ---: | --- |\n");
    for (id, mut list) in kinds {
        list.sort_by(|a, b| a.fault.size.abs().total_cmp(&b.fault.size.abs()));
        let count = |gross: bool| {
            let of = list.iter().filter(|found| found.fault.gross == gross);
            let (found, all) =
                of.fold((0, 0), |(found, all), one| (found + usize::from(one.in_time()), all + 1));
            format!("{found} of {all}")
        };
        let delay = |found: &&Found| {
            let after = found.after_brakings.map_or_else(|| "–".to_owned(), |count| count.to_string());
            format!("{:.3}: {after}", found.fault.size.abs())
        };
        let delays: Vec<String> = list.iter().map(delay).collect();
        let _ = writeln!(text, "| {id} | {} | {} | {} |", count(true), count(false), delays.join(", "));
    }
}

/// Which cause was named first for which, where the wagon was right.
fn confusion(text: &mut String, told: &[&Found]) {
    let mut table: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for found in told {
        let named = match &found.first {
            Some(alert) if at_place(alert, &found.fault) => alert.cause.word(),
            Some(_) => "another place",
            None => "nothing",
        };
        *table.entry((&found.fault.cause, named)).or_default() += 1;
    }
    text.push_str("\n| true cause | first named | times |\n| --- | --- | ---: |\n");
    for ((truth, named), count) in table {
        let _ = writeln!(text, "| {truth} | {named} | {count} |");
    }
}
