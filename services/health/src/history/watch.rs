//! Turns what arrives into events: slides as they end, processes that come and go, what becomes of alerts.

use crate::alerts::model::{Alert, Scope};
use railgrip_history::Event;
use railgrip_indicators::indicator::SLIDES;
use railgrip_messages::{EventKind, Grade, Health, Heartbeat, NO_WAGON, NO_WHEELSET, ProcessKind, Text};
use std::collections::BTreeMap;

/// Slides of a wheelset that follow each other so closely are one event, ns.
const PAUSE_NS: u64 = 3_000_000_000;
/// Slides that go on and on are told after this time, ns.
const LONGEST_NS: u64 = 60_000_000_000;
/// A process that has been quiet for this long is gone, ns.
const GONE_NS: u64 = 10_000_000_000;

/// What a wheelset had slid when it was last told, and what it does now.
#[derive(Debug, Clone, Copy)]
struct Slides {
    told: Sum,
    seen: Sum,
    began_ns: u64,
    last_ns: u64,
    from_m_s: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Sum {
    number: f64,
    energy_j: f64,
    seconds: f64,
}

#[derive(Debug)]
struct Alive {
    pid: u32,
    seen_ns: u64,
}

/// Watches what arrives.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    slides: BTreeMap<(u32, usize), Slides>,
    processes: BTreeMap<(u32, u32), Alive>,
    /// What was told last, by kind and wagon: what lasts is said again and again.
    told: BTreeMap<(u32, u32), Text>,
}

impl Watch {
    /// Slides that are over, as events.
    pub(crate) fn health(&mut self, health: &Health) -> Vec<Event> {
        let now_ns = health.acquired.monotonic_ns;
        let mut events = Vec::new();
        for (index, wheelset) in health.wheelset[..health.wheelset_count()].iter().enumerate() {
            let number = SLIDES.of_wheelset(health, index).figure().unwrap_or(0.0);
            let seen = Sum { number, energy_j: wheelset.slide_energy_j, seconds: wheelset.slide_s };
            let first =
                Slides { told: seen, seen, began_ns: now_ns, last_ns: now_ns, from_m_s: health.v_m_s };
            let known = self.slides.entry((health.wagon, index)).or_insert(first);
            if seen.number < known.seen.number {
                // The estimator began anew.
                *known = first;
                continue;
            }
            if seen != known.seen {
                if known.seen == known.told {
                    (known.began_ns, known.from_m_s) = (now_ns, health.v_m_s);
                }
                (known.seen, known.last_ns) = (seen, now_ns);
            }
            let over = now_ns.saturating_sub(known.last_ns) > PAUSE_NS;
            let long = now_ns.saturating_sub(known.began_ns) > LONGEST_NS;
            if known.seen.number > known.told.number && (over || long) {
                events.push(slid(health, index, known));
                (known.told, known.began_ns, known.from_m_s) = (known.seen, now_ns, health.v_m_s);
            }
        }
        events
    }

    /// What another process tells and nothing else here shows.
    pub(crate) fn told(&mut self, event: &railgrip_messages::Event) -> Option<Event> {
        let kind = event.kind()?;
        let shows = matches!(
            kind,
            EventKind::UnitsImplausible
                | EventKind::ClockDrifts
                | EventKind::FilterRestarted
                | EventKind::ModelMismatch
                | EventKind::HearingChanged
                | EventKind::SourceChanged
        );
        let before = shows.then(|| self.told.insert((event.kind, event.wagon), event.text))?;
        let lasts = matches!(kind, EventKind::UnitsImplausible | EventKind::ClockDrifts);
        (!lasts || before != Some(event.text)).then(|| Event {
            unix_ms: event.stamp.unix_ns.div_euclid(1_000_000),
            kind: kind.to_string().replace(' ', "_"),
            wagon: (event.wagon != NO_WAGON).then_some(event.wagon),
            wheelset: (event.wheelset != NO_WHEELSET).then(|| event.wheelset.saturating_add(1)),
            grade: (event.grade() != Grade::Unknown).then(|| event.grade().to_string()),
            cause: kind.to_string().replace(' ', "_"),
            text: event.text.as_str().to_owned(),
        })
    }

    /// A process that began.
    pub(crate) fn heartbeat(&mut self, beat: &Heartbeat) -> Option<Event> {
        let (key, seen_ns) = ((beat.process, beat.wagon), beat.stamp.monotonic_ns);
        let before = self.processes.insert(key, Alive { pid: beat.pid, seen_ns });
        let text = match before {
            Some(before) if before.pid == beat.pid => return None,
            Some(before) => format!("{} runs as process {} instead of {}", role(key), beat.pid, before.pid),
            None => format!("{} runs as process {}", role(key), beat.pid),
        };
        Some(of_process("process_started", key, text, beat.stamp.unix_ns))
    }

    /// Processes that have been quiet for long.
    pub(crate) fn gone(&mut self, monotonic_ns: u64, unix_ns: i64) -> Vec<Event> {
        let is_gone = |alive: &Alive| monotonic_ns.saturating_sub(alive.seen_ns) > GONE_NS;
        let gone: Vec<(u32, u32)> =
            self.processes.iter().filter(|(_, alive)| is_gone(alive)).map(|(key, _)| *key).collect();
        let told = gone.into_iter().filter_map(|key| {
            let pid = self.processes.remove(&key)?.pid;
            Some(of_process("process_gone", key, format!("{} (process {pid}) is silent", role(key)), unix_ns))
        });
        told.collect()
    }
}

fn slid(health: &Health, index: usize, slides: &Slides) -> Event {
    let number = slides.seen.number - slides.told.number;
    let (energy_j, seconds) =
        (slides.seen.energy_j - slides.told.energy_j, slides.seen.seconds - slides.told.seconds);
    let noun = if number > 1.0 { "slides" } else { "slide" };
    Event {
        unix_ms: health.acquired.unix_ns.div_euclid(1_000_000),
        kind: "slides".to_owned(),
        wagon: Some(health.wagon),
        wheelset: Some(index as u32 + 1),
        grade: None,
        cause: "slides".to_owned(),
        text: format!(
            "{number:.0} {noun} from {:.0} km/h: {:.1} kJ in {seconds:.1} s of sliding",
            slides.from_m_s * 3.6,
            energy_j * 1e-3
        ),
    }
}

fn role((process, wagon): (u32, u32)) -> String {
    let word = ProcessKind::from_code(process).map_or("process", ProcessKind::word);
    if wagon == NO_WAGON { word.to_owned() } else { format!("{word} of wagon {wagon}") }
}

fn of_process(kind: &str, key: (u32, u32), text: String, unix_ns: i64) -> Event {
    Event {
        unix_ms: unix_ns.div_euclid(1_000_000),
        kind: kind.to_owned(),
        wagon: (key.1 != NO_WAGON).then_some(key.1),
        wheelset: None,
        grade: None,
        cause: ProcessKind::from_code(key.0).map_or("process", ProcessKind::word).to_owned(),
        text,
    }
}

/// What has become of an alert.
pub(crate) fn of_alert(alert: &Alert, unix_ns: i64) -> Event {
    let last = alert.history.last();
    let change = last.map_or("changed", |line| line.change.word());
    let by = last.and_then(|line| line.by.as_deref()).map_or_else(String::new, |by| format!(" by {by}"));
    let note = last.and_then(|line| line.note.as_deref()).filter(|note| *note != alert.reason);
    let note = note.map_or_else(String::new, |note| format!(" ({note})"));
    let one = alert.scope == Scope::Wagon && alert.wagon > 0;
    Event {
        unix_ms: unix_ns.div_euclid(1_000_000),
        kind: format!("alert_{change}"),
        wagon: one.then_some(alert.wagon),
        wheelset: alert.wheelset,
        grade: Some(alert.grade_now.word().to_owned()),
        cause: alert.cause.clone(),
        text: format!("alert {} {change}{by}: {}{note}", alert.id, alert.reason),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_indicators::indicator::judging;
    use railgrip_messages::Grade;
    use railgrip_messages::Stamp;

    fn at(tenths: u64, slides: f64, energy_j: f64) -> Health {
        let acquired = Stamp { unix_ns: tenths as i64 * 100_000_000, monotonic_ns: tenths * 100_000_000 };
        let mut health = Health { wagon: 3, wheelsets: 2, acquired, v_m_s: 25.0, ..Health::default() };
        SLIDES.put_wheelset(&mut health, 1, judging::known(slides, slides, slides, Grade::Ok, ""));
        (health.wheelset[1].slide_energy_j, health.wheelset[1].slide_s) = (energy_j, energy_j * 1e-4);
        health
    }

    #[test]
    fn slides_that_follow_each_other_are_one_event() {
        let mut watch = Watch::default();
        let mut events = Vec::new();
        for tenths in 0..200 {
            let slides = match tenths {
                0..20 => 4.0,
                20..35 => 5.0,
                _ => 7.0,
            };
            events.extend(watch.health(&at(tenths, slides, slides * 1000.0)));
        }
        println!("{events:?}");
        assert_eq!(events.len(), 1);
        assert_eq!((events[0].wagon, events[0].wheelset), (Some(3), Some(2)));
        assert!(events[0].text.starts_with("3 slides from 90 km/h: 3.0 kJ in 0.3 s"), "{}", events[0].text);
        assert_eq!(events[0].unix_ms, 6_600);
        assert!(
            watch.health(&at(300, 0.0, 0.0)).is_empty(),
            "an estimator that begins anew has slid nothing"
        );
    }

    #[test]
    fn processes_come_and_go() {
        let mut watch = Watch::default();
        let beat = |pid, seconds: u64| Heartbeat {
            process: ProcessKind::Estimator.code(),
            wagon: 2,
            pid,
            stamp: Stamp { unix_ns: 0, monotonic_ns: seconds * 1_000_000_000 },
            ..Heartbeat::default()
        };
        let first = watch.heartbeat(&beat(7, 1)).expect("new");
        assert_eq!((first.kind.as_str(), first.wagon), ("process_started", Some(2)));
        assert_eq!(watch.heartbeat(&beat(7, 2)), None);
        assert!(watch.heartbeat(&beat(8, 3)).expect("another").text.contains("8 instead of 7"));
        assert!(watch.gone(12_000_000_000, 0).is_empty());
        let gone = watch.gone(14_000_000_000, 0);
        assert!(gone.len() == 1 && gone[0].text.contains("process 8"), "{gone:?}");
        assert!(watch.gone(15_000_000_000, 0).is_empty());
    }
}
