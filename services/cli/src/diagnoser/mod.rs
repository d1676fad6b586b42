//! `railgrip diagnoser`: diagnoses by itself what estimators keep of mismatches.
//!
//! Where the model does not explain a wagon for long, its estimator keeps the latest minutes as a case of `railgrip gap
//! diagnose`. This process takes one case after the other, at the lowest priority and on one thread, and leaves beside the
//! recordings what was found: `report.json`, `report.html`, and `answer.json`, which the HTTP service joins to the alert.

mod answer;
mod queue;
mod work;

use std::path::Path;
use std::time::{Duration, Instant};

use railgrip_bus::Lifecycle;
use rustix::process::setpriority_process;

use crate::output::say;
use crate::reload::{Member, Role};
use crate::train::TrainArgs;
use crate::{CliError, runner};
use work::Work;

/// How often signals and a diagnosis under way are looked at.
const POLL: Duration = Duration::from_millis(100);
/// How often new cases are looked for.
const LOOK: Duration = Duration::from_secs(2);
/// How long to wait after a case could not be begun or its answer not be written.
const AFTER_TROUBLE: Duration = Duration::from_secs(60);
/// The estimators and the service come first, always.
const LOWEST_PRIORITY: i32 = 19;

/// Diagnose by itself what the model does not explain on a running train.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    train: TrainArgs,
    /// Diagnose what is there, and end
    #[arg(long)]
    once: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let train = args.train.load()?;
    let _span = tracing::info_span!("diagnoser").entered();
    // Children inherit it. A system that forbids it runs the diagnosis at the usual priority.
    if let Err(error) = setpriority_process(None, LOWEST_PRIORITY) {
        tracing::warn!(%error, "diagnoses run at the usual priority");
    }
    let gaps = train.settings.instance.gap_folder();
    let limit = Duration::from_secs_f64(train.settings.diagnosis.time_limit_s);
    runner::run(Some(Member::of(&args.train, &train, Role::Diagnoser)), |lifecycle| {
        diagnose_all(&gaps, limit, args.once, lifecycle)
    })
}

fn diagnose_all(gaps: &Path, limit: Duration, once: bool, lifecycle: &Lifecycle) -> Result<(), CliError> {
    lifecycle.ready();
    let (mut looked, mut pause): (Option<Instant>, Duration) = (None, LOOK);
    let mut work: Option<Work> = None;
    while !lifecycle.should_stop() {
        lifecycle.beat();
        let stepped = match &mut work {
            Some(under_way) => go_on(under_way, limit, once).map(|done| done.then_some(None)),
            None if looked.is_none_or(|looked| looked.elapsed() >= pause) => {
                (looked, pause) = (Some(Instant::now()), LOOK);
                match queue::next(gaps) {
                    Some(case) => begin(&case).map(Some),
                    None if once => return Ok(()),
                    None => Ok(None),
                }
            }
            None => Ok(None),
        };
        match stepped {
            Ok(Some(next)) => {
                work = next;
                looked = if once { None } else { looked };
            }
            Ok(None) => {}
            Err(error) if once => return Err(error),
            // A full disk is no reason to end: the train runs on, and the case is tried again.
            Err(error) => {
                tracing::warn!(%error, "a diagnosis failed and is tried again later");
                (work, looked, pause) = (None, Some(Instant::now()), AFTER_TROUBLE);
            }
        }
        std::thread::sleep(POLL);
    }
    Ok(())
}

/// The work on a case; none if it is too poor, which is its answer.
fn begin(case: &Path) -> Result<Option<Work>, CliError> {
    let Some(answer) = answer::too_poor(case) else { return Work::begin(case).map(Some) };
    tracing::info!(case = %case.display(), verdict = answer.verdict, "{}", answer.words);
    work::leave(case, &answer)?;
    Ok(None)
}

/// Looks after a diagnosis; true once it is done.
fn go_on(work: &mut Work, limit: Duration, once: bool) -> Result<bool, CliError> {
    let Some(answer) = work.look(limit)? else { return Ok(false) };
    tracing::info!(case = work.name(), verdict = answer.verdict, "{}", answer.words);
    if once {
        say(&format!("{}: {}", work.name(), answer.words));
    }
    Ok(true)
}
