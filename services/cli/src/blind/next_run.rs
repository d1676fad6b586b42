//! Does the next run settle it? The vehicle of a case that was left in doubt makes the run that `gap plan` designs and, beside it,
//! any other of its programme; `gap settle` says what each makes of what the diagnosis left open.

use std::{fmt::Write as _, fs, path::PathBuf};

use railgrip_truth_plant::{
    FamilyCase,
    family::{AskedRun, NextRun, file_name, recording},
    sheet::Rail,
};
use serde::Serialize;
use serde_json::Value;

use super::{
    answer::Answer,
    diagnose::{Surgery, Task, copy},
    make::{Order, case_folder},
    outcome::{Outcome, Rate},
};
use crate::CliError;
use crate::sealed::{
    digest::digest_of_folder,
    files::{cannot_write, write},
};

/// An answer that is stated below this is in doubt; one at or above it that is right is settled.
const SURE: f64 = 0.8;

/// What was said of a case, once.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Said {
    /// In a word.
    pub word: String,
    /// How probable it was said to be.
    pub stated: f64,
    /// Entropy of the sets that it lists, nats.
    pub entropy: f64,
    /// Whether it is right.
    pub right: bool,
}

/// A case before and after one more run.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Next {
    /// Name of the case.
    pub case: String,
    /// Whether anything could be seen before that run.
    pub visible: bool,
    /// The designed run in words.
    pub plan: String,
    /// Time that the plan took, diagnosis included, one thread, s.
    pub plan_seconds: f64,
    /// Without that run, with the designed one, with any other of its length.
    pub before: Said,
    pub designed: Said,
    pub any: Said,
}

/// Whether an answer leaves doubt.
pub(super) fn is_in_doubt(outcome: &Outcome) -> bool {
    outcome.answer.as_ref().is_some_and(|answer| answer.stated() < SURE)
}

/// Has the next run of a case made, and any other; `None` where nothing is left to separate or a diagnosis failed.
///
/// # Errors
/// Files that cannot be read or written.
pub(super) fn of(surgery: &Surgery, outcome: &Outcome, order: &Order) -> Result<Option<Next>, CliError> {
    let made = &outcome.made;
    let name = &made.label.case;
    let without: Vec<String> = made.withheld.iter().cloned().collect();
    let folder = case_folder(surgery.out(), name);
    let (visit, plan) =
        surgery.visit(Task::Plan, &folder, &format!("{name}.plan"), &made.recordings_sha256, &without)?;
    let Some((plan, asked)) = plan.as_ref().and_then(|plan| Some((plan, asked(plan.get("run")?)?))) else {
        return Ok(None);
    };
    let length_s = asked.phases.last().map_or(0.0, |(until_s, ..)| *until_s);
    let again = |kind: &str, wanted: &NextRun| -> Result<Option<Said>, CliError> {
        let case = with_one_more(surgery, name, kind, order, wanted)?;
        let digest = digest_of_folder(&case)?;
        let (_, report) = surgery.visit(Task::Settle, &case, &format!("{name}.{kind}"), &digest, &without)?;
        let answer = report.as_ref().map(Answer::read);
        Ok(said(&Outcome { answer, ..outcome.clone() }))
    };
    let designed = again("designed", &NextRun::Asked(asked))?;
    let any = again("any", &NextRun::Any(length_s))?;
    let all = said(outcome).zip(designed).zip(any);
    Ok(all.map(|((before, designed), any)| Next {
        case: name.clone(),
        visible: outcome.is_visible(),
        plan: plan.get("words").and_then(Value::as_str).unwrap_or_default().to_owned(),
        plan_seconds: visit.seconds,
        before,
        designed,
        any,
    }))
}

fn said(outcome: &Outcome) -> Option<Said> {
    let answer = outcome.answer.as_ref()?;
    Some(Said {
        word: answer.word(),
        stated: answer.stated(),
        entropy: answer.entropy,
        right: outcome.is_right(),
    })
}

/// The run that a plan asks for, by the keys of its JSON; `None` of a plan without one.
fn asked(run: &Value) -> Option<AskedRun> {
    let rail = run.get("rail").and_then(Value::as_str)?;
    let phase = |phase: &Value| {
        let number = |key: &str| phase.get(key).and_then(Value::as_f64);
        Some((number("until_s")?, number("brake_demand")?, number("drive_demand")?))
    };
    Some(AskedRun {
        rail: [Rail::Dry, Rail::Wet, Rail::Low].into_iter().find(|one| one.name() == rail)?,
        start_m_s: run.get("v0_m_s").and_then(Value::as_f64)?,
        phases: run.get("phases")?.as_array()?.iter().map(phase).collect::<Option<Vec<_>>>()?,
    })
}

/// A folder with the case and a test run beside it.
fn with_one_more(
    surgery: &Surgery,
    name: &str,
    kind: &str,
    order: &Order,
    wanted: &NextRun,
) -> Result<PathBuf, CliError> {
    let folder = surgery.out().join("next").join(format!("{name}.{kind}"));
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|error| cannot_write(&folder, &error))?;
    }
    copy(&case_folder(surgery.out(), name), &folder)?;
    let (sheet, run) = FamilyCase::one_more(&order.recipe, "one_more", wanted).map_err(CliError::failed)?;
    write(&folder.join("test").join(file_name(&run)), &recording(&sheet, &run))?;
    Ok(folder)
}

/// A figure of the table, and of what it counts.
type Row = (&'static str, fn(&Said) -> bool);

/// What came of it, for people; nothing where it was not asked.
pub(super) fn markdown(next: &[Next]) -> String {
    if next.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\n## The next run\n\nAnswers that were stated below {SURE} ({} cases), with the run that `gap plan` designs, and with any other of its length.\n\n\
         | | before | designed | any other |\n| --- | ---: | ---: | ---: |\n",
        next.len()
    );
    let rows: [Row; 3] = [
        ("right", |said| said.right),
        ("settled: right, and stated at 0.8 or more", |said| said.right && said.stated >= SURE),
        ("wrong, and stated at 0.8 or more", |said| !said.right && said.stated >= SURE),
    ];
    let columns: [fn(&Next) -> &Said; 3] = [|next| &next.before, |next| &next.designed, |next| &next.any];
    for (what, test) in rows {
        let rate = |of: fn(&Next) -> &Said| {
            next.iter().fold(Rate::default(), |rate, one| rate.and(test(of(one)))).to_string()
        };
        let _ = writeln!(text, "| {what} | {} |", columns.map(rate).join(" | "));
    }
    let mean = |of: &dyn Fn(&Next) -> f64| next.iter().map(of).sum::<f64>() / next.len() as f64;
    let entropies = columns.map(|of| format!("{:.2}", mean(&|one| of(one).entropy))).join(" | ");
    let _ = writeln!(text, "| entropy of the sets, nats, mean | {entropies} |");
    let longest = next.iter().map(|one| one.plan_seconds).fold(0.0, f64::max);
    let _ = writeln!(
        text,
        "\nA plan took {:.0} s on average, {longest:.0} s at most, with its diagnosis, on one thread.",
        mean(&|one| one.plan_seconds)
    );
    text.push_str("\n| case | before | designed | any other | the run |\n| --- | --- | --- | --- | --- |\n");
    for one in next {
        let said = columns.map(|of| {
            let said = of(one);
            let right = if said.right { "right" } else { "wrong" };
            format!("{} {:.2}, {right}", said.word, said.stated)
        });
        let _ = writeln!(text, "| {} | {} | {} |", one.case, said.join(" | "), one.plan);
    }
    text
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_planned_run_is_read_by_its_keys_and_one_of_an_unknown_rail_is_none() {
        let run = |rail: &str| {
            json!({"v0_m_s": 20.0, "rail": rail, "phases": [
                {"until_s": 6.0, "brake_demand": 0.0, "drive_demand": 0.7},
                {"until_s": 60.0, "brake_demand": 1.0, "drive_demand": 0.0}]})
        };
        let asked = asked(&run("wet")).unwrap();
        assert_eq!((asked.rail, asked.start_m_s), (Rail::Wet, 20.0));
        assert_eq!(asked.phases, [(6.0, 0.0, 0.7), (60.0, 1.0, 0.0)]);
        assert_eq!(super::asked(&run("icy")), None);
        assert_eq!(super::asked(&Value::Null), None);
    }

    #[test]
    fn the_table_counts_what_is_settled() {
        let said = |right, stated| Said { word: "grade".into(), stated, entropy: 0.5, right };
        let next = Next {
            case: "case0001".into(),
            visible: true,
            plan: "On dry rail.".into(),
            plan_seconds: 40.0,
            before: said(true, 0.5),
            designed: said(true, 0.9),
            any: said(false, 0.9),
        };
        let text = markdown(&[next]);
        assert!(
            text.contains(
                "| settled: right, and stated at 0.8 or more | 0.00 (0/1) | 1.00 (1/1) | 0.00 (0/1) |"
            ),
            "{text}"
        );
        assert!(text.contains("| wrong, and stated at 0.8 or more | 0.00 (0/1) | 0.00 (0/1) | 1.00 (1/1) |"));
        assert_eq!(markdown(&[]), "");
    }
}
