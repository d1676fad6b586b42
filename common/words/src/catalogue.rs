//! The table of messages in one other language.

use super::number::is_number;
use super::pattern::{Pattern, fill};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::LazyLock;

/// The file, as it stands in the source.
const GERMAN_PO: &str = include_str!("../de.po");

/// German.
pub(super) static GERMAN: LazyLock<Catalogue> = LazyLock::new(|| Catalogue::read(GERMAN_PO));

/// The table of messages: English and German, as it stands in the source (PO).
#[must_use]
pub const fn table() -> &'static str {
    GERMAN_PO
}

/// The German of an English sentence; `None` if some of it is no message of the table.
#[must_use]
pub fn german(sentence: &str) -> Option<String> {
    GERMAN.sentence(sentence)
}

/// A sentence can hold another, a reason for example; none holds more of them.
const DEEPEST: usize = 6;

/// Names of arguments that are words or sentences themselves. Of the others `names` are several of them between commas, `free` and
/// `text` anything, `at` an instant, `list` lists of numbers, and the rest are numbers.
const SENTENCES: &[&str] = &[
    "cause",
    "change",
    "class",
    "condition",
    "end",
    "indicator",
    "more",
    "one",
    "place",
    "process",
    "reason",
    "sensor",
    "total",
    "verdict",
    "what",
    "when",
    "why",
];
/// Longer ones are none of ours, bytes.
const LONGEST: usize = 500;

/// One sentence that is being understood, with what its parts were found to be: parts are met again and again.
struct Reading<'a> {
    catalogue: &'a Catalogue,
    known: RefCell<HashMap<String, Option<String>>>,
}

pub(super) struct Catalogue {
    exact: HashMap<&'static str, &'static str>,
    /// Messages with arguments, those with the most words of their own first.
    patterns: Vec<(Pattern, &'static str)>,
}

impl Catalogue {
    /// Of a PO file; one that cannot be read leaves everything in English, and a test fails.
    fn read(text: &str) -> Self {
        let mut all = Self { exact: HashMap::new(), patterns: Vec::new() };
        let Ok(file) = polib::po_file::parse_from_reader(text.as_bytes()) else { return all };
        for message in file.messages() {
            // Read once and kept for as long as the program runs.
            let english: &'static str = message.msgid().to_owned().leak();
            let other: &'static str = message.msgstr().unwrap_or_default().to_owned().leak();
            if english.is_empty() || other.is_empty() {
                continue;
            }
            all.exact.insert(english, other);
            // Those of the scripts, with numbers for names, are filled in there and met nowhere else.
            let pattern = Pattern::new(english).filter(|_| !english.contains("{0}"));
            all.patterns.extend(pattern.map(|pattern| (pattern, other)));
        }
        all.patterns.sort_by_key(|(pattern, _)| std::cmp::Reverse(pattern.weight()));
        all
    }

    /// A message as it stands in the table.
    pub fn exact(&self, message: &str) -> Option<&'static str> {
        self.exact.get(message).copied()
    }

    /// A sentence in English, in this language; `None` if some of it is no message.
    pub fn sentence(&self, sentence: &str) -> Option<String> {
        if sentence.len() > LONGEST {
            return None;
        }
        Reading { catalogue: self, known: RefCell::default() }.understand(sentence, 0)
    }
}

impl Reading<'_> {
    fn understand(&self, sentence: &str, depth: usize) -> Option<String> {
        if let Some(exact) = self.catalogue.exact(sentence) {
            return Some(exact.to_owned());
        }
        if depth > DEEPEST {
            return None;
        }
        if let Some(known) = self.known.borrow().get(sentence) {
            return known.clone();
        }
        // A sentence begins with a large letter where it stands alone, and with a small one behind another.
        let found = self.patterned(sentence, depth).or_else(|| {
            let (text, large) = otherwise_begun(sentence)?;
            let exact = self.catalogue.exact(&text).map(str::to_owned);
            Some(begun(&exact.or_else(|| self.patterned(&text, depth))?, large))
        });
        self.known.borrow_mut().insert(sentence.to_owned(), found.clone());
        found
    }

    fn patterned(&self, sentence: &str, depth: usize) -> Option<String> {
        self.catalogue.patterns.iter().find_map(|(pattern, other)| {
            let found = pattern.find(sentence, &mut |name, argument| self.argument(name, argument, depth))?;
            Some(fill(other, |name| {
                found.iter().find(|(own, _)| *own == name).map_or("", |(_, text)| text.as_str())
            }))
        })
    }

    /// What is filled in: a number, a name or a time that stays as it is, or a sentence.
    fn argument(&self, name: &str, argument: &str, depth: usize) -> Option<String> {
        if is_number(argument) {
            return Some(argument.replace('.', ","));
        }
        match name {
            _ if SENTENCES.contains(&name) => self.understand(argument, depth + 1),
            "free" | "text" => Some(argument.to_owned()),
            "at" => (!argument.contains(' ')).then(|| argument.to_owned()),
            "names" => {
                let each = argument.split(", ").map(|one| self.understand(one, depth + 1));
                Some(each.collect::<Option<Vec<_>>>()?.join(", "))
            }
            "list" => {
                let of_list = |c: char| c.is_ascii_digit() || matches!(c, '-' | '–' | ',' | ' ');
                argument.chars().all(of_list).then(|| argument.to_owned())
            }
            _ => None,
        }
    }
}

/// The same sentence with its first letter small if it is large, or the other way round; true if it was large.
fn otherwise_begun(sentence: &str) -> Option<(String, bool)> {
    let first = sentence.chars().next()?;
    let large = first.is_uppercase();
    let other: String = if large { first.to_lowercase().collect() } else { first.to_uppercase().collect() };
    Some((other + &sentence[first.len_utf8()..], large))
}

/// Begins with a large letter where the English did; German nouns are large anyway.
fn begun(text: &str, large: bool) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) if large => first.to_uppercase().chain(letters).collect(),
        _ => text.to_owned(),
    }
}
