//! Having a case diagnosed: a child process, in a folder of its own, that is given the case alone.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::atomic::{AtomicUsize, Ordering},
    thread,
    time::{Duration, Instant},
};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::{
    answer::Answer,
    args::{Args, Floor},
    make::{Made, case_folder, twin_folder},
    outcome::Outcome,
    rankings::Rankings,
    verify,
};
use crate::CliError;
use crate::sealed::{
    digest,
    files::{cannot_write, read, write},
};

/// Where cases are diagnosed.
pub(super) struct Surgery {
    program: PathBuf,
    program_sha256: String,
    out: PathBuf,
    time_limit: Duration,
    floor: Floor,
    ids: Vec<String>,
}

/// How a report came about; an interrupted run takes a report over if this is still so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Circumstances {
    program_sha256: String,
    recordings_sha256: String,
    without: Vec<String>,
}

/// What a child is to do with a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Task {
    Diagnose,
    /// Design the next run.
    Plan,
    /// Say what the run that was made says.
    Settle,
}

/// Circumstances, and how it went.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Visit {
    circumstances: Circumstances,
    /// How long it took, s.
    pub(super) seconds: f64,
    failure: Option<String>,
}

impl Task {
    /// The subcommand.
    fn word(self) -> &'static str {
        match self {
            Self::Diagnose => "diagnose",
            Self::Plan => "plan",
            Self::Settle => "settle",
        }
    }
}

impl Surgery {
    /// Prepares the diagnoses of a run.
    pub(super) fn new(args: &Args) -> Result<Self, CliError> {
        let program = std::env::current_exe().map_err(CliError::failed)?;
        let bytes = fs::read(&program).map_err(CliError::failed)?;
        let program_sha256 = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        let out = fs::canonicalize(&args.out).map_err(|error| cannot_write(&args.out, &error))?;
        let ids = library(&program)?;
        let time_limit = Duration::from_secs(args.time_limit);
        Ok(Self { program, program_sha256, out, time_limit, floor: args.floor, ids })
    }

    /// Diagnoses a case, and its twin for the floor.
    pub(super) fn outcome(&self, made: &Made) -> Result<Outcome, CliError> {
        let name = &made.label.case;
        let folder = case_folder(&self.out, name);
        let without: Vec<String> = made.withheld.iter().cloned().collect();
        let (visit, report) = self.visit(Task::Diagnose, &folder, name, &made.recordings_sha256, &without)?;
        let floor = match self.floor {
            _ if made.label.effects.is_empty() => None,
            Floor::Plant => Some(made.label.gap_without_the_effect.holdout),
            Floor::Diagnosis => {
                let twin = twin_folder(&self.out, name);
                let digest = digest::digest_of_folder(&twin)?;
                let (_, report) =
                    self.visit(Task::Diagnose, &twin, &format!("{name}.twin"), &digest, &self.ids)?;
                report.and_then(|report| report.pointer("/gap/holdout/calibrated").and_then(Value::as_f64))
            }
        };
        let predictions = self.predictions(name);
        let verified = report.as_ref().map(|report| verify::check(&folder, &predictions, report));
        let answer = report.as_ref().map(Answer::read);
        Ok(Outcome {
            made: made.clone(),
            answer,
            floor,
            verified,
            seconds: visit.seconds,
            failure: visit.failure,
            rankings: self.rankings(made)?,
        })
    }

    /// What mere rankings say of a case, or said before an interruption.
    fn rankings(&self, made: &Made) -> Result<Rankings, CliError> {
        let kept = self.out.join("rankings").join(format!("{}.json", made.label.case));
        let key = (&self.program_sha256, &made.recordings_sha256);
        if let Ok(text) = fs::read_to_string(&kept)
            && let Ok((program, recordings, rankings)) =
                serde_json::from_str::<(String, String, Rankings)>(&text)
            && (&program, &recordings) == key
        {
            return Ok(rankings);
        }
        let rankings = Rankings::of(&case_folder(&self.out, &made.label.case));
        write(&kept, &serde_json::to_string(&(key.0, key.1, &rankings)).map_err(CliError::failed)?)?;
        Ok(rankings)
    }

    fn report(&self, name: &str) -> PathBuf {
        self.out.join("reports").join(format!("{name}.json"))
    }

    fn predictions(&self, name: &str) -> PathBuf {
        self.out.join("predictions").join(name)
    }

    /// Folder of everything.
    pub(super) fn out(&self) -> &Path {
        &self.out
    }

    /// What a child answers, or answered before an interruption under the same circumstances.
    pub(super) fn visit(
        &self,
        task: Task,
        folder: &Path,
        name: &str,
        recordings_sha256: &str,
        without: &[String],
    ) -> Result<(Visit, Option<Value>), CliError> {
        let circumstances = Circumstances {
            program_sha256: self.program_sha256.clone(),
            recordings_sha256: recordings_sha256.to_owned(),
            without: without.to_vec(),
        };
        let minutes = self.out.join("visits").join(format!("{name}.json"));
        let before =
            fs::read_to_string(&minutes).ok().and_then(|text| serde_json::from_str::<Visit>(&text).ok());
        let visit = match before {
            Some(visit) if visit.circumstances == circumstances => visit,
            _ => {
                let visit = self.examine(task, folder, name, circumstances)?;
                write(&minutes, &serde_json::to_string_pretty(&visit).map_err(CliError::failed)?)?;
                visit
            }
        };
        if visit.failure.is_some() {
            return Ok((visit, None));
        }
        let report = serde_json::from_str(&read(&self.report(name))?).map_err(CliError::failed)?;
        Ok((visit, Some(report)))
    }

    /// Copies the case to a folder of its own and runs the child there.
    fn examine(
        &self,
        task: Task,
        folder: &Path,
        name: &str,
        circumstances: Circumstances,
    ) -> Result<Visit, CliError> {
        static ROOMS: AtomicUsize = AtomicUsize::new(0);
        let number = ROOMS.fetch_add(1, Ordering::Relaxed);
        let room = std::env::temp_dir().join(format!("railgrip-blind-{}-{number}", std::process::id()));
        let case = room.join("case");
        copy(folder, &case)?;
        let mut command = Command::new(&self.program);
        // The seed of the cases determines their labels: the child draws from its own default.
        command.current_dir(&room).args(["gap", task.word(), "case", "--json", "report.json"]);
        command.args(["--threads", "1"]);
        if task == Task::Diagnose {
            command.args(["--predictions", "predictions"]);
        }
        for id in &circumstances.without {
            command.args(["--without", id]);
        }
        let start = Instant::now();
        let failure = self.wait(&mut command, &room.join("complaint.txt"));
        let seconds = start.elapsed().as_secs_f64();
        let failure = failure.or_else(|| {
            let report = fs::copy(room.join("report.json"), prepared(&self.report(name)));
            let predictions = match task {
                Task::Diagnose => copy(&room.join("predictions"), &self.predictions(name)),
                Task::Plan | Task::Settle => Ok(()),
            };
            report
                .map_err(|error| error.to_string())
                .err()
                .or(predictions.map_err(|error| error.to_string()).err())
        });
        fs::remove_dir_all(&room).map_err(|error| cannot_write(&room, &error))?;
        Ok(Visit { circumstances, seconds, failure })
    }

    /// Runs a child to its end or to the time limit; says what went wrong.
    fn wait(&self, command: &mut Command, complaint: &Path) -> Option<String> {
        let stderr = match fs::File::create(complaint) {
            Ok(file) => file,
            Err(error) => return Some(error.to_string()),
        };
        let mut child = match command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(stderr).spawn() {
            Ok(child) => child,
            Err(error) => return Some(error.to_string()),
        };
        let deadline = Instant::now() + self.time_limit;
        loop {
            match child.try_wait() {
                Ok(Some(status)) if status.success() => return None,
                Ok(Some(status)) => {
                    let said = fs::read_to_string(complaint).unwrap_or_default();
                    return Some(format!("{status}: {}", said.trim()));
                }
                Ok(None) if Instant::now() < deadline => thread::sleep(Duration::from_millis(50)),
                Ok(None) => {
                    let killed = child.kill().and_then(|()| child.wait());
                    return Some(match killed {
                        Ok(_) => format!("not done after {} s", self.time_limit.as_secs()),
                        Err(error) => error.to_string(),
                    });
                }
                Err(error) => return Some(error.to_string()),
            }
        }
    }
}

/// Ids of the library, as `railgrip gap effects --json` lists them.
fn library(program: &Path) -> Result<Vec<String>, CliError> {
    let output =
        Command::new(program).args(["gap", "effects", "--json"]).output().map_err(CliError::failed)?;
    let catalogue: Value = serde_json::from_slice(&output.stdout)
        .map_err(|error| CliError::failed(format!("`railgrip gap effects --json` gave no JSON: {error}")))?;
    let entries = catalogue.as_array().or_else(|| catalogue.get("effects").and_then(Value::as_array));
    let id = |entry: &Value| entry.get("id").and_then(Value::as_str).map(str::to_owned);
    Ok(entries.map(|entries| entries.iter().filter_map(id).collect()).unwrap_or_default())
}

/// The path, with its folder made.
fn prepared(path: &Path) -> &Path {
    if let Some(parent) = path.parent() {
        // A folder that cannot be made shows as the error of the file that should go there.
        let _ = fs::create_dir_all(parent);
    }
    path
}

/// Copies a folder with all that is in it.
pub(super) fn copy(from: &Path, to: &Path) -> Result<(), CliError> {
    fs::create_dir_all(to).map_err(|error| cannot_write(to, &error))?;
    let entries =
        fs::read_dir(from).map_err(|error| CliError::failed(format!("{}: {error}", from.display())))?;
    for entry in entries {
        let path = entry.map_err(CliError::failed)?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &target)?;
        } else {
            fs::copy(&path, &target).map_err(|error| cannot_write(&target, &error))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use railgrip_truth_plant::{Case, Recipe};
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    /// A program in the place of `railgrip`: it predicts what was recorded, says `none`, and refuses anything it
    /// should not have been given.
    const PROGRAM: &str = r#"#!/bin/sh
[ "$1 $2 $3" = "gap diagnose case" ] || exit 2
[ "$(ls)" = "case
complaint.txt" ] || { echo "more than the case: $(ls)" >&2; exit 1; }
[ "$(ls case)" = "fit
holdout
vehicle.toml" ] || { echo "more than a case: $(ls case)" >&2; exit 1; }
mkdir predictions
for run in case/holdout/*.csv; do
  awk -F, 'NR == 1 { printf "t_s,window"; for (i = 2; i < 5; i++) printf ",%s,%s_nominal,%s_calibrated,%s_extended", $i, $i, $i, $i; print ""; next }
           { printf "%s,0", $1; for (i = 2; i < 5; i++) printf ",%s,%s,%s,%.6f", $i, $i + 0.06, $i + 0.03, $i; print "" }' \
    "$run" > "predictions/$(basename "$run")"
done
by='{"calibrated": 1.0, "extended": 0.0}'
cat > report.json <<END
{"verdict": "none", "effects": [], "gap": {"holdout": {"nominal": 2.0, "calibrated": GAP, "extended": 0.0,
 "by_signal": {"v_m_s": $by, "omega_f_rad_s": $by, "omega_r_rad_s": $by}}}}
END
"#;

    fn surgery(folder: &Path, stated_gap: &str) -> Surgery {
        let program = folder.join("program");
        fs::write(&program, PROGRAM.replace("GAP", stated_gap)).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        Surgery {
            program,
            program_sha256: stated_gap.to_owned(),
            out: folder.to_path_buf(),
            time_limit: Duration::from_secs(60),
            floor: Floor::Plant,
            ids: Vec::new(),
        }
    }

    fn made(folder: &Path) -> Made {
        let case = Case::make(&Recipe { name: "case000".into(), seed: 9, departures: Vec::new() }).unwrap();
        let place = case_folder(folder, "case000");
        railgrip_truth_plant::files::write_case(&place, &case.sheet.to_toml(), &case.runs).unwrap();
        let recordings_sha256 = digest::digest_of_folder(&place).unwrap();
        Made { label: case.label, withheld: None, recordings_sha256 }
    }

    #[test]
    fn a_case_is_diagnosed_alone_and_its_gaps_are_recomputed() {
        let folder = tempfile::tempdir().unwrap();
        let made = made(folder.path());
        let honest = surgery(folder.path(), "1.0").outcome(&made).unwrap();
        assert_eq!(honest.failure, None);
        assert_eq!(honest.verified, Some(Ok(())));
        assert!(honest.is_right());
        let flattering = surgery(folder.path(), "0.9").outcome(&made).unwrap();
        let complaint = flattering.verified.unwrap().unwrap_err();
        println!("{complaint}");
        assert!(complaint.contains("/gap/holdout/calibrated"));
    }

    #[test]
    fn an_effect_is_left_where_the_calibration_leaves_a_tenth_more_than_the_twin() {
        let folder = tempfile::tempdir().unwrap();
        let outcome = surgery(folder.path(), "1.0").outcome(&made(folder.path())).unwrap();
        let floor = outcome.made.label.gap_without_the_effect.fit;
        let is_left = |gap: f64| {
            let mut told = outcome.clone();
            told.answer.as_mut().unwrap().calibrated_fit = gap;
            told.is_left_by_calibration(super::super::make::VISIBLE)
        };
        assert!(is_left(1.2 * floor) && !is_left(1.05 * floor));
        assert!(!is_left(f64::NAN), "a report that does not say it");
    }

    #[test]
    fn an_interrupted_run_takes_reports_over_under_the_same_circumstances() {
        let folder = tempfile::tempdir().unwrap();
        let made = made(folder.path());
        let surgery = surgery(folder.path(), "1.0");
        let first = surgery.outcome(&made).unwrap();
        fs::write(&surgery.program, "#!/bin/sh\nexit 1\n").unwrap();
        assert_eq!(surgery.outcome(&made).unwrap().seconds, first.seconds, "not diagnosed again");
        let other = Made { recordings_sha256: "other".into(), ..made };
        assert!(surgery.outcome(&other).unwrap().failure.is_some(), "other recordings are diagnosed again");
    }
}
