//! Who did what, when, from where, and what came of it: one JSON object a line.
//!
//! Written down are requests that change something, logins and logouts, everything that was turned away, reads that need
//! `admin`, and start, stop and reloads of certificate and tokens; reads of figures are not. A thread of its own writes, so that a
//! slow disk holds nobody up. What strangers did lies in a file of its own beside that of the others, and cannot push theirs out. What cannot be written is counted, and the count stands in the next line that can be: a
//! full disk never stops the service. Turned-away requests are thinned to a few a second; the rest are counted, too.

use crate::access::audit_file::{Shelf, write_all};
use crate::access::peer::Peer;
use crate::time::rfc3339;
use railgrip_settings::AuditSettings;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Records that may wait for the disk.
const WAITING: usize = 1024;
/// Refusals written down a second in the long run, and at once.
const REFUSALS_PER_S: f64 = 5.0;
const REFUSALS_AT_ONCE: f64 = 50.0;
/// Longest path and method that are written down.
const MAX_PATH: usize = 256;
const MAX_METHOD: usize = 16;

/// A line of the log.
#[derive(Debug, Serialize)]
struct Line<'a> {
    at: String,
    train: &'a str,
    event: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    who: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    role: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    method: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    status: Option<u16>,
    #[serde(skip_serializing_if = "str::is_empty")]
    result: &'a str,
    /// Records that were lost before this one.
    #[serde(skip_serializing_if = "is_zero")]
    lost: u64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// One thing that happened.
pub(super) struct Record<'a> {
    pub event: &'a str,
    pub who: Option<&'a str>,
    pub role: Option<&'a str>,
    pub peer: &'a Peer,
    pub method: &'a str,
    pub path: &'a str,
    pub status: u16,
    pub result: &'a str,
}

/// The log of one service.
pub(super) struct Audit {
    train: String,
    file: PathBuf,
    lines: Option<SyncSender<(Shelf, String)>>,
    writer: Option<JoinHandle<()>>,
    lost: Arc<AtomicU64>,
    refusals: Mutex<(f64, Instant)>,
}

impl Audit {
    pub(super) fn start(settings: &AuditSettings, train: &str) -> Self {
        let (sender, receiver) = sync_channel(WAITING);
        let lost = Arc::new(AtomicU64::new(0));
        let writer = std::thread::Builder::new().name("audit".to_owned()).spawn({
            let (settings, lost) = (settings.clone(), Arc::clone(&lost));
            move || write_all(&settings, &receiver, &lost)
        });
        if let Err(error) = &writer {
            tracing::error!("no audit log: {error}");
        }
        let audit = Self {
            train: train.to_owned(),
            file: settings.file.clone(),
            lines: Some(sender),
            writer: writer.ok(),
            lost,
            refusals: Mutex::new((REFUSALS_AT_ONCE, Instant::now())),
        };
        audit.event("start", format!("process {}", std::process::id()));
        audit
    }

    /// The file that is written to.
    pub(super) fn file(&self) -> &Path {
        &self.file
    }

    /// Writes down what nobody asked for.
    pub(super) fn event(&self, event: &str, result: String) {
        self.send(
            Shelf::Known,
            &Line {
                at: now(),
                train: &self.train,
                event,
                who: None,
                role: None,
                from: None,
                method: None,
                path: None,
                status: None,
                result: &result,
                lost: 0,
            },
        );
    }

    /// Writes down a request.
    pub(super) fn request(&self, record: &Record<'_>) {
        self.write(Shelf::Known, record);
    }

    fn write(&self, shelf: Shelf, record: &Record<'_>) {
        let cut = record.path.floor_char_boundary(MAX_PATH);
        let method = record.method.floor_char_boundary(MAX_METHOD);
        self.send(
            shelf,
            &Line {
                at: now(),
                train: &self.train,
                event: record.event,
                who: record.who,
                role: record.role,
                from: Some(record.peer.to_string()),
                method: Some(&record.method[..method]),
                path: Some(&record.path[..cut]),
                status: Some(record.status),
                result: record.result,
                lost: 0,
            },
        );
    }

    /// Writes down a request that was turned away, or of somebody who shows nothing, unless too many were; in a file of their own, so
    /// that nobody can write out of the log what others did.
    pub(super) fn refusal(&self, record: &Record<'_>) {
        let mut bucket = self.refusals.lock().unwrap_or_else(PoisonError::into_inner);
        let (tokens, at) = *bucket;
        let now = Instant::now();
        let tokens = (tokens + now.duration_since(at).as_secs_f64() * REFUSALS_PER_S).min(REFUSALS_AT_ONCE);
        let enough = tokens >= 1.0;
        *bucket = (if enough { tokens - 1.0 } else { tokens }, now);
        drop(bucket);
        if enough {
            self.write(Shelf::Strangers, record);
        } else {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn send(&self, shelf: Shelf, line: &Line<'_>) {
        let lost = self.lost.swap(0, Ordering::Relaxed);
        let text =
            serde_json::to_string(&Line { lost, at: line.at.clone(), from: line.from.clone(), ..*line });
        let sent = text.ok().and_then(|text| self.lines.as_ref()?.try_send((shelf, text)).ok());
        if sent.is_none() {
            self.lost.fetch_add(lost + 1, Ordering::Relaxed);
        }
    }
}

impl Drop for Audit {
    fn drop(&mut self) {
        self.event("stop", String::new());
        self.lines = None;
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
    }
}

fn now() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    rfc3339(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::audit_file::latest;
    use serde_json::Value;

    fn settings(file: &Path, max_bytes: u64, keep: usize) -> AuditSettings {
        AuditSettings { file: file.to_owned(), max_bytes, keep }
    }

    fn record<'a>(peer: &'a Peer, path: &'a str) -> Record<'a> {
        Record {
            event: "change",
            who: Some("depot"),
            role: Some("acknowledge"),
            peer,
            method: "POST",
            path,
            status: 200,
            result: "",
        }
    }

    #[test]
    fn files_are_put_aside_by_size_and_the_oldest_goes() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("deep/audit.jsonl");
        let audit = Audit::start(&settings(&file, 2000, 3), "demo");
        let peer =
            Peer { address: Some("192.0.2.7:4711".parse().expect("address")), tls: true, behind: None };
        (0..100).for_each(|n| audit.request(&record(&peer, &format!("/api/v1/alerts/{n}/acknowledge"))));
        drop(audit);
        let mut names: Vec<String> = std::fs::read_dir(file.parent().expect("folder"))
            .expect("folder")
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        assert_eq!(names, ["audit.jsonl", "audit.jsonl.1", "audit.jsonl.2"]);
        assert!(std::fs::metadata(file.with_file_name("audit.jsonl.1")).expect("file").len() <= 2000);
        let lines: Vec<Value> = latest(&file, 3).expect("lines");
        println!("{}", lines[0]);
        assert_eq!(lines.last().expect("line")["event"], "stop");
        let change = &lines[lines.len() - 2];
        assert_eq!((&change["who"], &change["role"]), (&"depot".into(), &"acknowledge".into()));
        assert_eq!((&change["from"], &change["status"]), (&"192.0.2.7:4711".into(), &200.into()));
        assert_eq!(change["path"], "/api/v1/alerts/99/acknowledge");
    }

    #[test]
    fn refusals_are_thinned_and_counted() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("audit.jsonl");
        let audit = Audit::start(&settings(&file, 1_000_000, 2), "demo");
        let peer = Peer { address: None, tls: false, behind: None };
        (0..1000).for_each(|_| audit.refusal(&record(&peer, "/")));
        audit.request(&record(&peer, "/last"));
        drop(audit);
        let strangers: Vec<Value> = latest(&Shelf::Strangers.file(&file), 10_000).expect("lines");
        let lines: Vec<Value> = latest(&file, 10_000).expect("lines");
        assert!(strangers.iter().all(|line| line["path"] == "/"));
        let last = lines.iter().find(|line| line["path"] == "/last").expect("last");
        println!("{} lines, {} not written", lines.len(), last["lost"]);
        assert!(strangers.len() <= 60 && lines.len() == 3 && last["lost"].as_u64().expect("count") > 900);
    }

    /// Somebody without a token once wrote the whole log out in half a minute.
    #[test]
    fn strangers_write_nobody_out_of_the_log() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("audit.jsonl");
        let audit = Audit::start(&settings(&file, 3000, 2), "demo");
        let peer = Peer { address: None, tls: false, behind: None };
        audit.request(&record(&peer, "/meant"));
        let method = "A".repeat(15_800);
        for _ in 0..40 {
            audit.refusal(&Record { method: &method, ..record(&peer, "/") });
        }
        drop(audit);
        let lines: Vec<Value> = latest(&file, 10_000).expect("lines");
        assert!(lines.iter().any(|line| line["path"] == "/meant"), "{lines:?}");
        let strangers: Vec<Value> = latest(&Shelf::Strangers.file(&file), 10_000).expect("lines");
        assert!(
            strangers.iter().all(|line| line["method"].as_str().is_some_and(|word| word.len() == MAX_METHOD))
        );
    }

    #[test]
    fn a_disk_that_takes_nothing_stops_nobody() {
        let folder = tempfile::tempdir().expect("folder");
        let blocked = folder.path().join("file");
        std::fs::write(&blocked, "").expect("write");
        for file in [blocked.join("audit.jsonl"), PathBuf::from("/dev/full")] {
            let audit = Audit::start(&settings(&file, 1000, 2), "demo");
            let peer = Peer { address: None, tls: false, behind: None };
            (0..3000).for_each(|_| audit.request(&record(&peer, "/")));
            std::thread::sleep(std::time::Duration::from_millis(50));
            assert!(audit.lost.load(Ordering::Relaxed) > 0);
        }
    }

    #[test]
    fn a_line_cut_off_by_a_full_disk_spoils_no_other() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("audit.jsonl");
        std::fs::write(&file, "{\"at\":\"2026").expect("write");
        drop(Audit::start(&settings(&file, 1000, 2), "demo"));
        assert_eq!(latest::<Value>(&file, 10).expect("lines").len(), 2);
    }
}
