//! The table of messages is whole: nothing is missing, and nothing is left over.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]
#![allow(clippy::print_stdout, reason = "tests print the figures they measure")]

use railgrip_words::table;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Who speaks by the table.
const SPEAKERS: [&str; 2] = ["services/health/src", "common/diagnosis/src"];
const SCRIPT: &str = "services/health/src/page/assets/words.js";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The table: English to German.
fn messages() -> BTreeMap<String, String> {
    let file = polib::po_file::parse_from_reader(table().as_bytes()).unwrap();
    let pairs = file.messages().map(|one| (one.msgid().to_owned(), one.msgstr().unwrap().to_owned()));
    pairs.collect()
}

/// Source as one line of words: strings that go over several lines and comments of settings are joined.
fn joined(text: &str) -> String {
    let text = text.replace("\\\"", "\"");
    let mut all = String::new();
    for line in text.lines() {
        match all.strip_suffix('\\') {
            Some(before) => all = before.to_owned() + line.trim_start(),
            None if line.trim_start().starts_with("///") && all.ends_with('\u{1}') => {
                all.pop();
                all.push_str(line.trim_start().trim_start_matches("///"));
            }
            None => all.push_str(line),
        }
        all.push(if line.trim_start().starts_with("///") { '\u{1}' } else { '\n' });
        if all.ends_with("\\\n") {
            all.pop();
        }
    }
    all
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

/// Literals in `t("…")`, `say("…"` and what else fills in a message.
fn asked_for() -> BTreeSet<String> {
    let mut all = Vec::new();
    SPEAKERS.iter().for_each(|folder| files(&root().join(folder), &mut all));
    let mut found = BTreeSet::new();
    for file in &all {
        let text = std::fs::read_to_string(file).unwrap();
        for call in ["t(", "say(", "filled(", "said("] {
            for (at, _) in text.match_indices(call) {
                let before = text[..at].chars().next_back();
                let rest = text[at + call.len()..].trim_start();
                let Some(rest) = rest
                    .strip_prefix('"')
                    .filter(|_| before.is_some_and(|c| !c.is_alphanumeric() && c != '_' && c != '.'))
                else {
                    continue;
                };
                found.insert(rest[..rest.find('"').unwrap()].to_owned());
            }
        }
    }
    found
}

#[test]
fn no_message_is_missing() {
    let asked = asked_for();
    assert!(asked.len() > 500, "{} messages are asked for", asked.len());
    let script = std::fs::read_to_string(root().join(SCRIPT)).unwrap();
    let script: Vec<String> = script.split('"').skip(3).step_by(2).map(str::to_owned).collect();
    let letters = |text: &str| text.chars().any(char::is_alphabetic);
    let all = asked.into_iter().chain(script.into_iter().filter(|text| letters(text)));
    let messages = messages();
    let missing: Vec<String> = all.filter(|message| !messages.contains_key(message)).collect();
    assert_eq!(missing, Vec::<String>::new(), "without German");
}

#[test]
fn both_languages_fill_in_the_same() {
    let names = |text: &str| -> BTreeSet<String> {
        let open = text.split('{').skip(1);
        open.filter_map(|rest| rest.split_once('}')).map(|(name, _)| name.to_owned()).collect()
    };
    let mut count = 0;
    for (english, german) in messages() {
        assert_eq!(names(&english), names(&german), "{english:?} and {german:?}");
        assert!(!german.trim().is_empty(), "{english:?} has no German");
        count += 1;
    }
    println!("{count} messages");
    assert!(count > 1000);
}

/// Each message stands in the file that its comment names: nothing in the table is unused.
#[test]
fn no_message_is_left_over() {
    let file = polib::po_file::parse_from_reader(table().as_bytes()).unwrap();
    let mut sources: BTreeMap<String, String> = BTreeMap::new();
    let mut left_over = Vec::new();
    for message in file.messages() {
        let source = message.source().trim().to_owned();
        let text = sources
            .entry(source.clone())
            .or_insert_with(|| joined(&std::fs::read_to_string(root().join(&source)).unwrap_or_default()));
        let punctuation = |c: char| c.is_whitespace() || ",:;.()".contains(c);
        let mut pieces: Vec<&str> = Vec::new();
        let mut rest = message.msgid();
        while let Some((before, behind)) = rest.split_once('{') {
            pieces.push(before.trim_matches(punctuation));
            rest = behind.split_once('}').map_or("", |(_, behind)| behind);
        }
        pieces.push(rest.trim_matches(punctuation));
        let longest = pieces.into_iter().max_by_key(|piece| piece.len()).unwrap_or_default();
        // Names of effects and parameters stand as ids there.
        if !text.contains(longest) && !text.contains(&longest.replace(' ', "_")) {
            left_over.push(format!("{source}: {}", message.msgid()));
        }
    }
    assert_eq!(left_over, Vec::<String>::new(), "not in the file that they name");
}
