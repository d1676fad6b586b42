//! What the processes below one process cost, as `/proc` tells.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// Processes of one role.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Group {
    /// First word of the command: `up`, `hold`, `estimator`, ...
    pub role: String,
    /// How many.
    pub number: usize,
    /// CPU time of all, % of one core.
    pub cpu_percent: f64,
    /// Mean proportional set size of one, MB.
    pub pss_mb: f64,
}

struct Process {
    pid: u32,
    role: String,
    cpu_s: f64,
}

/// Watches a process and its children for `span`; returns them by role, and the CPU time of all, % of one core.
pub(crate) fn watch(parent: u32, span: Duration) -> (Vec<Group>, f64) {
    let before = family(parent);
    let started = Instant::now();
    std::thread::sleep(span);
    let seconds = started.elapsed().as_secs_f64();
    let mut groups: BTreeMap<String, Group> = BTreeMap::new();
    for process in before {
        let Some((_, cpu_s)) = parent_and_cpu_s(process.pid) else { continue };
        let empty = || Group { role: process.role.clone(), number: 0, cpu_percent: 0.0, pss_mb: 0.0 };
        let group = groups.entry(process.role.clone()).or_insert_with(empty);
        group.number += 1;
        group.cpu_percent += (cpu_s - process.cpu_s) / seconds * 100.0;
        group.pss_mb += pss_mb(process.pid).unwrap_or(0.0);
    }
    let mut groups: Vec<Group> = groups.into_values().collect();
    groups.iter_mut().for_each(|group| group.pss_mb /= group.number as f64);
    let all = groups.iter().map(|group| group.cpu_percent).sum();
    (groups, all)
}

fn family(parent: u32) -> Vec<Process> {
    let Ok(entries) = std::fs::read_dir("/proc") else { return Vec::new() };
    let pids = entries.flatten().filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    pids.filter_map(|pid| {
        let (its_parent, cpu_s) = parent_and_cpu_s(pid)?;
        let ours = pid == parent || its_parent == parent;
        ours.then(|| role(pid).map(|role| Process { pid, role, cpu_s })).flatten()
    })
    .collect()
}

/// The processes of a role directly below one process.
pub(crate) fn children(parent: u32, role: &str) -> Vec<u32> {
    let below = family(parent).into_iter().filter(|process| process.role == role);
    below.map(|process| process.pid).collect()
}

fn role(pid: u32) -> Option<String> {
    let words = std::fs::read(Path::new("/proc").join(pid.to_string()).join("cmdline")).ok()?;
    let word = words.split(|byte| *byte == 0).nth(1)?;
    Some(String::from_utf8_lossy(word).into_owned())
}

/// Parent, and CPU time in user and system mode so far.
fn parent_and_cpu_s(pid: u32) -> Option<(u32, f64)> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program may contain anything, so count from the bracket after it: state, parent, ...
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some((fields.get(1)?.parse().ok()?, ticks / rustix::param::clock_ticks_per_second() as f64))
}

fn pss_mb(pid: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).ok()?;
    let line = text.lines().find(|line| line.starts_with("Pss:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

/// CPU time of a process so far, s.
pub(crate) fn cpu_s(pid: u32) -> Option<f64> {
    parent_and_cpu_s(pid).map(|(_, cpu_s)| cpu_s)
}

/// Largest resident memory of a process so far, MB.
pub(crate) fn peak_mb(pid: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}
