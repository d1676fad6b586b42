//! A whole train of real processes, for a measurement: started in a folder of its own, asked over HTTP, stopped when it is dropped.

use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::CliError;

const START_PATIENCE: Duration = Duration::from_secs(30);
const VEHICLE: &str = include_str!("../../../config/vehicle.toml");

/// A running `railgrip up`.
pub(crate) struct Up {
    folder: PathBuf,
    child: Child,
    agent: ureq::Agent,
}

impl Up {
    /// Starts a train in a new folder, whose name begins so. `prepare` may lay files there and gives the text of the config, which
    /// finds the default vehicle beside it.
    pub fn start(
        name: &str,
        prepare: impl FnOnce(&Path) -> Result<String, CliError>,
        input: Stdio,
    ) -> Result<Self, CliError> {
        let folder = std::env::temp_dir().join(format!("{name}{}", std::process::id()));
        let started = spawn(&folder, prepare, input);
        let child = started.inspect_err(|_| drop(std::fs::remove_dir_all(&folder)))?;
        let agent =
            ureq::Agent::config_builder().timeout_global(Some(Duration::from_secs(10))).build().into();
        Ok(Self { folder, child, agent })
    }

    /// The id of its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Where its config and its instance lie.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its standard input, once, if that was piped.
    pub fn input(&mut self) -> Option<ChildStdin> {
        self.child.stdin.take()
    }

    /// Waits until every wagon is live.
    pub fn wait_ready(&self) -> Result<(), CliError> {
        self.wait("the train does not become ready", || self.text("/health/ready").is_ok())
    }

    /// Waits until something is so.
    pub fn wait(&self, otherwise: &str, so: impl Fn() -> bool) -> Result<(), CliError> {
        let started = Instant::now();
        while !so() {
            if started.elapsed() > START_PATIENCE {
                return Err(CliError::failed(otherwise));
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Ok(())
    }

    /// The address of a page.
    pub fn url(&self, path: &str) -> Result<String, CliError> {
        let file = self.folder.join("i").join("http.address");
        let started = Instant::now();
        while started.elapsed() < START_PATIENCE {
            match std::fs::read_to_string(&file) {
                Ok(text) if !text.trim().is_empty() => {
                    return Ok(format!("http://{}{path}", text.trim().trim_start_matches("http://")));
                }
                _ => std::thread::sleep(Duration::from_millis(50)),
            }
        }
        Err(CliError::failed("the train serves no HTTP"))
    }

    /// What it answers there.
    pub fn text(&self, path: &str) -> Result<String, CliError> {
        let mut answer = self.agent.get(self.url(path)?).call().map_err(CliError::failed)?;
        answer.body_mut().read_to_string().map_err(CliError::failed)
    }

    /// The same as JSON.
    pub fn json(&self, path: &str) -> Result<Value, CliError> {
        serde_json::from_str(&self.text(path)?).map_err(CliError::failed)
    }
}

impl Drop for Up {
    fn drop(&mut self) {
        let pid = rustix::process::Pid::from_child(&self.child);
        let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// The sum of one figure over all processes of a kind, as `/api/v1/train` says.
pub(crate) fn sum(train: &Value, process: &str, figure: &str) -> u64 {
    let processes = train["processes"].as_array().map(Vec::as_slice).unwrap_or_default();
    let wanted = processes.iter().filter(|one| one["process"] == process);
    wanted.filter_map(|one| one[figure].as_u64()).sum()
}

/// How many processes of a kind have shown themselves.
pub(crate) fn count(up: &Up, process: &str) -> usize {
    let Ok(train) = up.json("/api/v1/train") else { return 0 };
    let processes = train["processes"].as_array().map(Vec::as_slice).unwrap_or_default();
    processes.iter().filter(|one| one["process"] == process).count()
}

fn spawn(
    folder: &Path,
    prepare: impl FnOnce(&Path) -> Result<String, CliError>,
    input: Stdio,
) -> Result<Child, CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::failed)?;
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).map_err(CliError::failed);
    write("vehicle.toml", VEHICLE)?;
    write("train.toml", &prepare(folder)?)?;
    Command::new(std::env::current_exe().map_err(CliError::failed)?)
        .args(["up", "--listen", "127.0.0.1:0", "--config"])
        .arg(folder.join("train.toml"))
        .arg("--instance")
        .arg(folder.join("i"))
        .stdin(input)
        .stdout(Stdio::null())
        .spawn()
        .map_err(CliError::failed)
}
