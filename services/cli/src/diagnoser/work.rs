//! One diagnosis under way: a process of its own, so that a case which exhausts memory or never ends costs itself alone.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use railgrip_health::alerts::diagnosis::{ANSWER, Diagnosis, PAGE};

use super::answer;
use crate::{CliError, gap_shared, own_effects};

/// What the diagnosis says on its standard error while it runs.
const COMPLAINT: &str = "complaint.txt";
/// The whole report.
const REPORT: &str = "report.json";

pub(super) struct Work {
    case: PathBuf,
    child: Child,
    started: Instant,
}

impl Work {
    pub(super) fn begin(case: &Path) -> Result<Self, CliError> {
        let program = std::env::current_exe().map_err(CliError::failed)?;
        let complaint = case.join(COMPLAINT);
        let complaints = File::create(&complaint)
            .map_err(|e| CliError::failed(format!("{}: {e}", complaint.display())))?;
        let child = Command::new(program)
            .args(["gap", "diagnose", "--threads", "1"])
            .arg(case)
            .arg("--json")
            .arg(case.join(REPORT))
            .arg("--html")
            .arg(case.join(PAGE))
            .envs(own_effects::environment())
            .env_remove("NOTIFY_SOCKET")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(complaints)
            .spawn()
            .map_err(|error| CliError::failed(format!("cannot start a diagnosis: {error}")))?;
        tracing::info!(case = %case.display(), "a diagnosis begins");
        Ok(Self { case: case.to_owned(), child, started: Instant::now() })
    }

    pub(super) fn name(&self) -> String {
        gap_shared::name_of(&self.case)
    }

    /// The answer, once there is one; it is written into the case.
    pub(super) fn look(&mut self, limit: Duration) -> Result<Option<Diagnosis>, CliError> {
        let answer = match self.child.try_wait().map_err(CliError::failed)? {
            Some(status) => self.finished(status),
            None if self.started.elapsed() >= limit => {
                self.stop();
                answer::given_up(&self.case, limit.as_secs_f64())
            }
            None => return Ok(None),
        };
        leave(&self.case, &answer)?;
        Ok(Some(answer))
    }

    fn finished(&self, status: ExitStatus) -> Diagnosis {
        let complaint = self.case.join(COMPLAINT);
        let said = std::fs::read_to_string(&complaint).unwrap_or_default();
        let _ = std::fs::remove_file(&complaint);
        match answer::read(&self.case.join(REPORT)) {
            Some(report) if status.success() => answer::found(&self.case, &report),
            _ => answer::refused(&self.case, status, &said),
        }
    }

    fn stop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Writes an answer into its case.
pub(super) fn leave(case: &Path, answer: &Diagnosis) -> Result<(), CliError> {
    // Written beside its place first: nobody shall read half an answer.
    let part = case.join(format!(".{ANSWER}"));
    let text = serde_json::to_string_pretty(answer).map_err(CliError::failed)?;
    std::fs::write(&part, text + "\n")
        .and_then(|()| std::fs::rename(&part, case.join(ANSWER)))
        .map_err(|error| CliError::failed(format!("{}: {error}", part.display())))
}

impl Drop for Work {
    /// Whoever ends takes its child with it; the case is begun anew next time.
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            self.stop();
        }
    }
}
