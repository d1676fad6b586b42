//! The processes of one train, as `/proc` shows them.

use std::path::Path;

use rustix::process::{Pid, Signal, kill_process};

/// A running process of a train.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Process {
    /// Its id.
    pub pid: i32,
    /// `up`, `hold`, `ingest`, `estimator 3`, `health`, ...
    pub role: String,
}

impl Process {
    /// Sends a signal; a process that is gone already is fine.
    pub fn signal(&self, signal: Signal) {
        if let Some(pid) = Pid::from_raw(self.pid) {
            let _ = kill_process(pid, signal);
        }
    }

    /// Memory of its own and its share of what is shared (PSS), bytes; NaN if it is gone.
    #[must_use]
    pub fn memory_bytes(&self) -> f64 {
        let text = std::fs::read_to_string(format!("/proc/{}/smaps_rollup", self.pid)).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("Pss:"));
        let kilobytes = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
        kilobytes.map_or(f64::NAN, |kilobytes| 1024.0 * kilobytes)
    }

    /// `kill -9`.
    pub fn kill(&self) {
        self.signal(Signal::KILL);
    }
}

/// Every process whose command line names this instance folder, whoever its parent is.
#[must_use]
pub fn of_instance(dir: &Path) -> Vec<Process> {
    let Ok(entries) = std::fs::read_dir("/proc") else { return Vec::new() };
    let mut found: Vec<Process> = entries.flatten().filter_map(|entry| process(&entry.path(), dir)).collect();
    found.sort_by_key(|process| process.pid);
    found
}

fn process(proc: &Path, dir: &Path) -> Option<Process> {
    let pid = proc.file_name()?.to_str()?.parse().ok()?;
    let bytes = std::fs::read(proc.join("cmdline")).ok()?;
    let words: Vec<String> =
        bytes.split(|byte| *byte == 0).map(|word| String::from_utf8_lossy(word).into_owned()).collect();
    let named = words.windows(2).any(|pair| pair[0] == "--instance" && Path::new(&pair[1]) == dir);
    if !named || words.len() < 2 {
        return None;
    }
    let wagon = words.windows(2).find(|pair| pair[0] == "--wagon").map(|pair| format!(" {}", pair[1]));
    Some(Process { pid, role: format!("{}{}", words[1], wagon.unwrap_or_default()) })
}
