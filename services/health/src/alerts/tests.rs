use super::book::REMEMBERED;
use super::model::{AlertState, Change, Scope};
use super::*;
use crate::alerts::journal::Journal;
use crate::alerts::model::Alert;
use crate::alerts::model::{AcknowledgeRequest, SilenceRequest};
use crate::alerts::nflog::Receiver;
use crate::api::grade::Grade;
use crate::api::train::model::AlertCounts;
use railgrip_messages::Stamp;
use railgrip_settings::AlertSettings;
use std::path::PathBuf;

const SETTINGS: AlertSettings = AlertSettings {
    raise_after_s: 2.0,
    clear_after_s: 10.0,
    reopen_within_s: 600.0,
    group_share: 0.5,
    group_least: 3,
};

fn book() -> AlertBook {
    AlertBook::new(SETTINGS, 8, PathBuf::new())
}

fn at(seconds: f64) -> Stamp {
    let ns = (seconds * 1e9) as u64;
    Stamp { unix_ns: ns as i64, monotonic_ns: ns }
}

fn symptom(wagon: u32, wheelset: Option<u32>, rule: &'static str) -> Symptom {
    Symptom { wagon, wheelset, rule }
}

/// Judges some symptoms every half second; gives when which alert changed how.
fn play(
    book: &mut AlertBook,
    from_s: f64,
    until_s: f64,
    symptoms: &[(Symptom, Grade)],
) -> Vec<(f64, u64, Change)> {
    let mut told = Vec::new();
    for step in 0..((until_s - from_s) / 0.5) as usize {
        let now_s = from_s + 0.5 * step as f64;
        for (symptom, grade) in symptoms {
            book.judge(symptom.clone(), *grade, "as it is", at(now_s));
        }
        book.settle(at(now_s));
        let change = |alert: &Alert| alert.history.last().unwrap().change;
        told.extend(book.take_news().iter().map(|alert| (now_s, alert.id, change(alert))));
    }
    told
}

fn one(grade: Grade) -> [(Symptom, Grade); 1] {
    [(symptom(3, Some(2), "brake_friction"), grade)]
}

#[test]
fn an_alert_is_raised_when_its_cause_lasts_and_cleared_when_it_stays_away() {
    let mut book = book();
    assert_eq!(play(&mut book, 0.0, 1.5, &one(Grade::Watch)), []);
    assert_eq!(play(&mut book, 1.5, 2.0, &one(Grade::Ok)), [], "a short cause is forgotten");
    assert_eq!(play(&mut book, 2.0, 8.0, &one(Grade::Watch)), [(4.0, 1, Change::Raised)]);
    assert_eq!(play(&mut book, 8.0, 17.0, &one(Grade::Ok)), []);
    assert_eq!(play(&mut book, 17.0, 18.0, &one(Grade::Watch)), [], "it is the same alert");
    assert_eq!(play(&mut book, 18.0, 29.0, &one(Grade::Ok)), [(28.0, 1, Change::Cleared)]);
    let list = book.list();
    assert_eq!((list.len(), list[0].active, list[0].id), (1, false, 1));
    assert_eq!(book.counts(), AlertCounts::default());
}

/// An alert that waits for its cause to stay away does not contradict what is seen now.
#[test]
fn what_is_not_seen_any_more_says_since_when() {
    let mut book = book();
    let reason = |book: &AlertBook| book.list()[0].reason.clone();
    play(&mut book, 0.0, 4.0, &one(Grade::Watch));
    assert_eq!(reason(&book), "wheelset 2: as it is");
    play(&mut book, 4.0, 6.0, &one(Grade::Ok));
    assert_eq!(reason(&book), "wheelset 2: well since 1970-01-01T00:00:04.000Z; before: as it is");
    play(&mut book, 6.0, 7.0, &one(Grade::Watch));
    assert_eq!(reason(&book), "wheelset 2: as it is");
    play(&mut book, 7.0, 8.0, &one(Grade::Unknown));
    assert_eq!(reason(&book), "wheelset 2: unknown since 1970-01-01T00:00:07.000Z; before: as it is");
}

/// A dead sensor explains a filter that disagrees, also while it is not yet known to be sound for good.
#[test]
fn what_is_well_again_needs_no_action_and_explains_as_before() {
    let mut book = book();
    let both = |sensors| [(symptom(3, None, "sensors"), sensors), (symptom(3, None, "filter"), Grade::Watch)];
    assert_eq!(play(&mut book, 0.0, 130.0, &both(Grade::Act)), [(2.0, 1, Change::Raised)]);
    assert_eq!(play(&mut book, 130.0, 139.0, &both(Grade::Ok)), [], "neither better nor another alert");
    let alert = book.list()[0].clone();
    assert_eq!((alert.grade, alert.grade_now), (Grade::Act, Grade::Watch));
    assert_eq!(alert.places[0].well_since.as_deref(), Some("1970-01-01T00:02:10.000Z"));
    assert_eq!(book.counts(), AlertCounts { watch: 1, act: 0 });
    assert_eq!(play(&mut book, 139.0, 140.0, &both(Grade::Act)), [], "it is back, and as bad as it was");
    assert_eq!(book.counts(), AlertCounts { watch: 0, act: 1 });
}

#[test]
fn worse_is_told_when_it_lasts_and_unknown_changes_nothing() {
    let mut book = book();
    play(&mut book, 0.0, 4.0, &one(Grade::Watch));
    assert_eq!(play(&mut book, 4.0, 5.0, &one(Grade::Act)), [], "a moment of worse is nothing");
    play(&mut book, 5.0, 6.0, &one(Grade::Watch));
    assert_eq!(play(&mut book, 6.0, 10.0, &one(Grade::Act)), [(8.0, 1, Change::Worse)]);
    assert_eq!(play(&mut book, 10.0, 60.0, &one(Grade::Unknown)), []);
    assert_eq!(book.counts(), AlertCounts { watch: 0, act: 1 });
    let list = book.list();
    assert_eq!((list[0].wheelset, list[0].scope), (Some(2), Scope::Wagon));
    assert!(
        list[0].advice.contains("pads") && list[0].evidence.history.starts_with("/api/v1/wagons/3/history?")
    );
    assert_eq!(play(&mut book, 60.0, 72.0, &one(Grade::Watch)), [(70.0, 1, Change::Better)]);
}

#[test]
fn what_flaps_is_one_alert_that_is_told_less_and_less() {
    let mut book = book();
    let (mut told, mut now_s) = (Vec::new(), 0.0);
    // A naive alarm with the same two times would have been raised and cleared 40 times.
    for _ in 0..40 {
        told.extend(play(&mut book, now_s, now_s + 5.0, &one(Grade::Watch)));
        told.extend(play(&mut book, now_s + 5.0, now_s + 16.0, &one(Grade::Ok)));
        now_s += 16.0;
    }
    println!("40 comings and goings in {now_s} s were told as {told:?}");
    assert!(told.iter().all(|(_, id, _)| *id == 1) && told.len() <= 4, "{told:?}");
    assert_eq!(play(&mut book, now_s, now_s + 400.0, &one(Grade::Ok)).len(), 1, "it ends when it stays away");
}

#[test]
fn a_low_rail_is_one_alert_that_lists_the_wagons() {
    let mut book = book();
    let rail = |wagons: std::ops::RangeInclusive<u32>| -> Vec<(Symptom, Grade)> {
        (1..=8)
            .map(|wagon| {
                let grade = if wagons.contains(&wagon) { Grade::Watch } else { Grade::Ok };
                (symptom(wagon, None, "rail"), grade)
            })
            .collect()
    };
    let mut told = play(&mut book, 0.0, 4.0, &rail(1..=1));
    told.extend(play(&mut book, 4.0, 8.0, &rail(1..=4)));
    told.extend(play(&mut book, 8.0, 12.0, &rail(1..=8)));
    println!("{told:?}\n{}", book.list()[0].reason);
    assert_eq!(told.iter().filter(|(_, _, change)| *change == Change::Raised).count(), 1);
    let list = book.list();
    assert_eq!((list.len(), list[0].wagons.clone()), (1, (1..=8).collect()));
    assert_eq!(list[0].scope, Scope::Train);
    assert!(list[0].reason.starts_with("8 wagons (1-8), worst wagon 1"), "{}", list[0].reason);
    told.extend(play(&mut book, 12.0, 40.0, &rail(9..=9)));
    let delivered = told.iter().filter(|(_, _, change)| change.is_notified()).count();
    assert_eq!(delivered, 2, "raised once, cleared once, for eight wagons: {told:?}");
}

#[test]
fn symptoms_of_one_cause_make_one_alert_and_what_is_explained_makes_none() {
    let mut book = book();
    let symptoms = [
        (symptom(2, None, "brake_friction"), Grade::Watch),
        (symptom(2, Some(1), "brake_friction"), Grade::Act),
        (symptom(2, None, "asymmetry"), Grade::Act),
        (symptom(5, None, "sensors"), Grade::Act),
        (symptom(5, None, "filter"), Grade::Act),
        (symptom(5, None, "model"), Grade::Watch),
        (symptom(6, None, "model"), Grade::Watch),
        (symptom(6, None, "filter"), Grade::Watch),
    ];
    play(&mut book, 0.0, 5.0, &symptoms);
    let list = book.list();
    for alert in &list {
        println!("{} wagon {}: {} place(s)", alert.cause, alert.wagon, alert.places.len());
    }
    let causes: Vec<(&str, u32)> = list.iter().map(|alert| (alert.cause.as_str(), alert.wagon)).collect();
    assert_eq!(causes.len(), 3);
    for expected in [("brake_friction", 2), ("sensors", 5), ("filter", 6)] {
        assert!(causes.contains(&expected), "{causes:?}");
    }
}

#[test]
fn what_comes_with_every_slide_must_last_longer() {
    let mut book = book();
    let slide = [(symptom(1, None, "filter"), Grade::Watch), (symptom(2, None, "sensors"), Grade::Watch)];
    play(&mut book, 0.0, 25.0, &slide);
    assert_eq!(book.list(), Vec::new(), "a slide of 25 s raises nothing");
    play(&mut book, 25.0, 28.0, &[(symptom(3, None, "sensors"), Grade::Act)]);
    assert_eq!(book.list().len(), 1, "a dead sensor is told at once");
    play(&mut book, 28.0, 200.0, &slide);
    let causes: Vec<String> = book.list().into_iter().map(|alert| alert.cause).collect();
    assert!(causes.contains(&"filter".to_owned()), "what stays is told: {causes:?}");
}

#[test]
fn many_wagons_with_one_fault_become_one_alert_and_few_stay_apart() {
    let mut book = book();
    let weak = |count: u32| -> Vec<(Symptom, Grade)> {
        (1..=count).map(|wagon| (symptom(wagon, None, "brake_friction"), Grade::Watch)).collect()
    };
    play(&mut book, 0.0, 4.0, &weak(3));
    assert_eq!(book.list().iter().filter(|alert| alert.active).count(), 3);
    let told = play(&mut book, 4.0, 8.0, &weak(5));
    let active: Vec<Alert> = book.list().into_iter().filter(|alert| alert.active).collect();
    assert_eq!((active.len(), active[0].scope, active[0].wagons.len()), (1, Scope::Train, 5));
    assert_eq!(told.iter().filter(|(_, _, change)| *change == Change::Merged).count(), 3);
    assert!(active[0].advice.contains("before any single pad"), "{}", active[0].advice);
}

#[test]
fn an_alert_that_is_over_names_every_wagon_that_showed_it() {
    let mut book = book();
    let rail = |wagons: std::ops::RangeInclusive<u32>, grade| -> Vec<(Symptom, Grade)> {
        wagons.map(|wagon| (symptom(wagon, None, "rail"), grade)).collect()
    };
    play(&mut book, 0.0, 5.0, &rail(1..=8, Grade::Watch));
    // The low stretch ends for one wagon after the other.
    for wagon in 1..=8 {
        let from_s = 5.0 * f64::from(wagon);
        let now = [rail(1..=wagon, Grade::Ok), rail(wagon + 1..=8, Grade::Watch)].concat();
        play(&mut book, from_s, from_s + 5.0, &now);
    }
    play(&mut book, 45.0, 70.0, &rail(1..=8, Grade::Ok));
    let alert = book.get(1).unwrap();
    assert_eq!(alert.state, AlertState::Cleared);
    assert_eq!(alert.wagons, [1, 2, 3, 4, 5, 6, 7, 8], "not the last one alone");
}

#[test]
fn people_acknowledge_and_silence_and_worse_comes_back() {
    let mut book = book();
    play(&mut book, 0.0, 4.0, &one(Grade::Watch));
    let who = |by: &str| AcknowledgeRequest { by: by.to_owned(), note: None };
    assert_eq!(book.acknowledge(7, who("Ada"), at(4.0)), Err(Refusal::Unknown(7)));
    assert!(matches!(book.acknowledge(1, who(" "), at(4.0)), Err(Refusal::Invalid(_))));
    assert_eq!(book.acknowledge(1, who("Ada"), at(4.0)).unwrap().state, AlertState::Acknowledged);
    // Given to the wrong alert, it is taken back; twice makes no sense.
    let back = book.unacknowledge(1, who("Ada"), at(4.2)).unwrap();
    assert_eq!((back.state, back.acknowledged), (AlertState::Active, None));
    assert_eq!(book.unacknowledge(1, who("Ada"), at(4.3)), Err(Refusal::NotAcknowledged(1)));
    assert_eq!(book.acknowledge(1, who("Ada"), at(4.4)).unwrap().state, AlertState::Acknowledged);
    let silence =
        |duration_s| SilenceRequest { by: "Ada".to_owned(), why: "pads ordered".to_owned(), duration_s };
    assert!(matches!(book.silence(1, silence(1.0), at(5.0)), Err(Refusal::Invalid(_))));
    let silenced = book.silence(1, silence(60.0), at(5.0)).unwrap();
    assert_eq!((silenced.state, book.counts().watch), (AlertState::Silenced, 0));
    book.take_news();
    assert_eq!(play(&mut book, 5.0, 70.0, &one(Grade::Watch)), [(65.0, 1, Change::Unsilenced)]);
    book.silence(1, silence(3600.0), at(70.0)).unwrap();
    let told = play(&mut book, 70.0, 80.0, &one(Grade::Act));
    assert_eq!(told.last().unwrap().2, Change::Worse);
    let alert = book.get(1).unwrap();
    assert_eq!((alert.state, alert.acknowledged.clone()), (AlertState::Active, None));
    let lines: Vec<Change> = alert.history.iter().map(|line| line.change).collect();
    println!("{lines:?}");
    assert_eq!(book.unsilence(1, who("Ada"), at(80.0)), Err(Refusal::NotSilenced(1)));
    play(&mut book, 80.0, 120.0, &one(Grade::Ok));
    assert_eq!(book.acknowledge(1, who("Ada"), at(120.0)), Err(Refusal::Over(1)));
}

#[test]
fn everything_survives_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state/alerts.db");
    let receivers = || vec![Receiver { name: "depot".to_owned(), act_only: false }];
    let open = || Journal::open(&path, "demo", receivers(), 1000).unwrap();
    let mut first = book();
    let journal = open();
    first.keep_in(journal, Vec::new());
    play(&mut first, 0.0, 4.0, &one(Grade::Watch));
    let silence = SilenceRequest { by: "Ada".to_owned(), why: "pads ordered".to_owned(), duration_s: 600.0 };
    first.silence(1, silence, at(4.0)).unwrap();
    let before = first.list();
    // Nothing in order: as after kill -9.
    std::mem::forget(first);

    let mut second = book();
    let journal = open();
    assert_eq!(journal.counts("depot").unwrap()[0], 1, "the notification about it still waits");
    let kept = journal.alerts().unwrap();
    second.keep_in(journal, kept);
    assert_eq!(second.list(), before);
    assert_eq!(play(&mut second, 5.0, 30.0, &one(Grade::Watch)), [], "it is not raised again");
    let other = [(symptom(4, None, "sensors"), Grade::Act), one(Grade::Watch)[0].clone()];
    assert_eq!(play(&mut second, 30.0, 40.0, &other)[0].1, 2, "numbers go on");
    let told = play(&mut second, 40.0, 60.0, &one(Grade::Ok));
    assert_eq!((told[0].1, told[0].2), (1, Change::Cleared));
}

#[test]
fn a_damaged_database_is_set_aside_and_alerts_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alerts.db");
    let open = || Journal::open(&path, "demo", Vec::new(), 1000).unwrap();
    let mut book = book();
    book.keep_in(open(), Vec::new());
    play(&mut book, 0.0, 4.0, &one(Grade::Watch));
    drop(book);
    let sound = std::fs::read(&path).unwrap();
    let torn: Vec<u8> =
        sound.iter().enumerate().map(|(at, byte)| if at < 4096 { *byte } else { 0x5a }).collect();
    for (number, damaged) in
        [&b"no database at all, but long enough to look like a file"[..], &torn].iter().enumerate()
    {
        std::fs::write(&path, damaged).unwrap();
        assert_eq!(open().alerts().unwrap(), [], "nothing of it is believed");
        let aside = folder.path().join(format!("alerts.db.damaged-{}", number + 1));
        assert_eq!(&std::fs::read(aside).unwrap(), damaged, "and it is kept");
    }
}

#[test]
fn a_disk_that_refuses_stops_nothing_and_nothing_is_lost_when_it_works_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alerts.db");
    let mut book = book();
    let receivers = vec![Receiver { name: "depot".to_owned(), act_only: false }];
    book.keep_in(Journal::open(&path, "demo", receivers.clone(), 1000).unwrap(), Vec::new());
    // Somebody else holds the database for longer than a writer waits.
    let blocker = rusqlite::Connection::open(&path).unwrap();
    blocker.execute_batch("ALTER TABLE alert RENAME TO elsewhere").unwrap();
    play(&mut book, 0.0, 4.0, &one(Grade::Act));
    println!("{:?}", book.trouble());
    assert!(book.trouble().is_some());
    assert_eq!(book.counts().act, 1);
    blocker.execute_batch("ALTER TABLE elsewhere RENAME TO alert").unwrap();
    play(&mut book, 4.0, 12.0, &one(Grade::Act));
    assert_eq!(book.trouble(), None);
    let journal = Journal::open(&path, "demo", receivers, 1000).unwrap();
    assert_eq!((journal.alerts().unwrap().len(), journal.counts("depot").unwrap()[0]), (1, 1));
}

#[test]
fn the_list_of_the_past_and_the_outbox_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alerts.db");
    let settings = AlertSettings { raise_after_s: 0.0, clear_after_s: 0.0, reopen_within_s: 0.0, ..SETTINGS };
    let mut book = AlertBook::new(settings, 8, PathBuf::new());
    let receivers = vec![Receiver { name: "depot".to_owned(), act_only: false }];
    book.keep_in(Journal::open(&path, "demo", receivers.clone(), 100).unwrap(), Vec::new());
    for second in 0..300 {
        for grade in [Grade::Act, Grade::Ok] {
            let now_s = f64::from(second) + if grade == Grade::Ok { 0.5 } else { 0.0 };
            play(&mut book, now_s, now_s + 0.5, &one(grade));
        }
    }
    assert_eq!((book.list().len(), book.list()[0].id), (REMEMBERED, 300));
    let journal = Journal::open(&path, "demo", receivers, 100).unwrap();
    assert_eq!(journal.alerts().unwrap().len(), REMEMBERED);
    let [waiting, _, _, dropped] = journal.counts("depot").unwrap();
    assert_eq!((waiting, dropped), (100, 500));
}

#[test]
fn a_journal_that_calls_a_silence_a_shelf_stays_readable() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alerts.db");
    let journal = Journal::open(&path, "demo", Vec::new(), 1000).unwrap();
    let old = r#"{
        "id": 7, "cause": "brake_friction", "scope": "wagon", "wagon": 3, "wheelset": 2, "wagons": [3],
        "places": [{"wagon": 3, "wheelset": 2, "indicator": "brake_friction", "grade": "watch", "reason": "low"}],
        "grade": "watch", "grade_now": "watch", "reason": "low", "advice": "look",
        "evidence": {"history": "/api/v1/wagons/3/history", "recording": null}, "active": true, "state": "shelved",
        "acknowledged": null,
        "shelved": {"by": "Ada", "at": "2026-03-01T12:00:00.000Z", "why": "pads ordered",
                    "until": "2026-03-02T12:00:00.000Z", "until_unix_ns": 60000000000},
        "times": 1, "raised_at": "2026-03-01T11:00:00.000Z", "cleared_at": null,
        "history": [{"at": "a", "change": "raised", "grade": "watch", "by": null, "note": null},
                    {"at": "b", "change": "shelved", "grade": "watch", "by": "Ada", "note": "pads ordered"},
                    {"at": "c", "change": "unshelved", "grade": "watch", "by": "Ada", "note": null},
                    {"at": "d", "change": "shelved", "grade": "watch", "by": "Ada", "note": "pads ordered"}],
        "changes": 4, "unix_ns": 1000000000 }"#;
    let written = rusqlite::Connection::open(&path).unwrap();
    written.execute("INSERT INTO alert (id, body) VALUES (7, ?1)", [old]).unwrap();
    let kept = journal.alerts().unwrap();
    assert_eq!(kept.len(), 1);
    let silence = kept[0].silenced.as_ref().unwrap();
    assert_eq!(
        (kept[0].state, silence.by.as_str(), silence.why.as_str()),
        (AlertState::Silenced, "Ada", "pads ordered")
    );
    assert_eq!(
        (kept[0].history[1].change, kept[0].history[2].change),
        (Change::Silenced, Change::Unsilenced)
    );
    let mut book = book();
    book.keep_in(journal, kept);
    assert_eq!(book.counts().watch, 0, "it is still silenced");
    assert_eq!(play(&mut book, 50.0, 70.0, &one(Grade::Watch)), [(60.0, 7, Change::Unsilenced)]);
    let said = serde_json::to_value(book.get(7).unwrap()).unwrap();
    assert!(said.get("shelved").is_none() && said["history"][1]["change"] == "silenced", "{said}");
}
