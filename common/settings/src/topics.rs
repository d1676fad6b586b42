//! Topics of a broker that carry one value, or an object of values, each: which wagon and which input of the mapping a topic means.
//!
//! # Glossary
//! * **input**: a name that a rule of `[mapping]` reads.
//! * **pattern**: a topic whose levels may hold `{wagon}`, `{name}` or be `+`.

use crate::SettingsError;
use crate::place::ConfigText;
use railgrip_recording::{Flag, Mapping, Quantity, Rule};
use serde::{Deserialize, Serialize};

/// A value counts for so long after its message, unless the config says otherwise, ms.
const HOLD_MS: f64 = 500.0;
/// The longest pattern, bytes, and most patterns.
const LONGEST: usize = 256;
const MOST: usize = 64;
const WAGON: &str = "{wagon}";
const NAME: &str = "{name}";
const ALLOWED: &str =
    "a topic such as train/{wagon}/bogie1/{name}: {wagon}, {name} or + once in a level, no #";

/// One pattern, as the config says it.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TopicTable {
    /// Pattern of topics; a level may be +, or hold {wagon} or {name}; required.
    pub topic: String,
    /// Wagon whose values these are; without it and without {wagon}: of all wagons.
    pub wagon: Option<u32>,
    /// Input of `[mapping]` that the value is; without it and without {name}: the keys of an object.
    pub name: Option<String>,
}

/// The keys of a source of topics.
pub(crate) struct TopicKeys<'a> {
    pub topics: &'a [TopicTable],
    pub sample_on: Option<&'a str>,
    pub hold_ms: Option<f64>,
}

/// Topics with a value each, and what becomes of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Topics {
    /// The first that a topic fits says what it means.
    pub patterns: Vec<TopicPattern>,
    /// A value counts for so long after its message, s.
    pub hold_s: f64,
    /// The input whose arrival makes the rows of a wagon, where the config names it.
    sample_on: Option<String>,
    /// What is wanted of each wagon.
    pub wagons: Vec<WantedInputs>,
}

/// What is wanted of the topics of one wagon.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WantedInputs {
    /// The mapping, with the number of this wagon in its names.
    pub mapping: Mapping,
    /// Names of all inputs, once each.
    pub inputs: Vec<String>,
    /// The input whose arrival makes a row.
    pub sample_on: String,
}

impl WantedInputs {
    /// Whether the time of a row is that of a message, and not that of its arrival.
    #[must_use]
    pub fn carries_time(&self) -> bool {
        self.mapping.rules.iter().any(|rule| rule.to == "t_s")
    }
}

/// A pattern of topics.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicPattern {
    levels: Vec<Level>,
    wagon: Option<usize>,
    name: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Level {
    Plain(String),
    Any,
    /// Text before and after what stands for a wagon or a name.
    Wagon(String, String),
    Name(String, String),
}

/// What a topic means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Meaning<'a> {
    /// Which wagon.
    pub wagon: OfWagon<'a>,
    /// Name of the input, or what stands before the keys of an object; empty where the keys are the names.
    pub name: String,
}

/// The wagon of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OfWagon<'a> {
    /// All wagons of the train.
    All,
    /// The wagon at this index.
    Index(usize),
    /// As the topic calls it.
    Called(&'a str),
}

impl TopicPattern {
    fn new(table: &TopicTable) -> Option<Self> {
        let levels: Vec<Level> = table.topic.split('/').map(Level::new).collect::<Option<_>>()?;
        let wagons = levels.iter().filter(|level| matches!(level, Level::Wagon(..))).count();
        let sound = (1..=LONGEST).contains(&table.topic.len()) && !table.topic.contains('\0') && wagons <= 1;
        let wagon = table.wagon.map(|wagon| wagon as usize - 1);
        sound.then(|| Self { levels, wagon, name: table.name.clone() })
    }

    /// The filter under which a broker hands out its topics.
    #[must_use]
    pub fn filter(&self) -> String {
        let level = |level: &Level| match level {
            Level::Plain(text) => text.clone(),
            _ => "+".to_owned(),
        };
        self.levels.iter().map(level).collect::<Vec<_>>().join("/")
    }

    /// What a topic means, if it fits.
    #[must_use]
    pub fn meaning<'a>(&self, topic: &'a str) -> Option<Meaning<'a>> {
        let given: Vec<&str> = topic.split('/').collect();
        if given.len() != self.levels.len() {
            return None;
        }
        let mut wagon = self.wagon.map_or(OfWagon::All, OfWagon::Index);
        let mut names: Vec<&str> = self.name.as_deref().into_iter().collect();
        for (level, given) in self.levels.iter().zip(given) {
            let between = |before: &str, after: &str| {
                given.strip_prefix(before)?.strip_suffix(after).filter(|found| !found.is_empty())
            };
            match level {
                Level::Plain(text) if text != given => return None,
                Level::Plain(_) | Level::Any => {}
                Level::Wagon(before, after) => wagon = OfWagon::Called(between(before, after)?),
                Level::Name(before, after) => names.push(between(before, after)?),
            }
        }
        Some(Meaning { wagon, name: names.join(".") })
    }

    /// Whether it can bring an input to a wagon.
    fn may_bring(&self, input: &str, wagon: usize) -> bool {
        let names = self.levels.iter().filter(|level| matches!(level, Level::Name(..))).count();
        let of_wagon = self.wagon.is_none_or(|own| own == wagon);
        let named = match &self.name {
            None => true,
            Some(name) => {
                input.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            }
        };
        let parts = names + self.name.as_ref().map_or(0, |name| name.split('.').count());
        of_wagon && named && input.split('.').count() >= parts.max(1)
    }
}

impl Level {
    fn new(text: &str) -> Option<Self> {
        let plain = |part: &str| !part.contains(['{', '}', '+', '#']);
        if text == "+" {
            return Some(Self::Any);
        }
        if let Some((before, after)) = text.split_once(WAGON) {
            (plain(before) && plain(after)).then(|| Self::Wagon(before.to_owned(), after.to_owned()))
        } else if let Some((before, after)) = text.split_once(NAME) {
            (plain(before) && plain(after)).then(|| Self::Name(before.to_owned(), after.to_owned()))
        } else {
            plain(text).then(|| Self::Plain(text.to_owned()))
        }
    }
}

/// Settles the patterns; what is wanted of them is known once the wagons are.
pub(crate) fn topics(at: &ConfigText<'_>, keys: &TopicKeys<'_>) -> Result<Topics, SettingsError> {
    if keys.topics.is_empty() || keys.topics.len() > MOST {
        let value = format!("a list of {}", keys.topics.len());
        return Err(at.refuse("source.topics", value, format!("1 to {MOST} topics")));
    }
    let patterns = keys.topics.iter().zip(1..).map(|(table, number)| pattern(at, table, number));
    let patterns = patterns.collect::<Result<_, _>>()?;
    let hold_ms = at.within("source.hold_ms", keys.hold_ms.unwrap_or(HOLD_MS), 1.0..=60_000.0)?;
    let sample_on = keys.sample_on.map(str::to_owned);
    Ok(Topics { patterns, hold_s: hold_ms * 1e-3, sample_on, wagons: Vec::new() })
}

fn pattern(at: &ConfigText<'_>, table: &TopicTable, number: usize) -> Result<TopicPattern, SettingsError> {
    let key = |name: &str| format!("source.topics.{number}.{name}");
    if table.wagon == Some(0) {
        return Err(at.refuse(&key("wagon"), 0, "the place of a wagon, from 1"));
    }
    if table.wagon.is_some() && table.topic.contains(WAGON) {
        return Err(at.refuse(&key("wagon"), "given", "nothing beside {wagon} in the topic"));
    }
    if table.name.as_deref().is_some_and(|name| name.split('.').any(str::is_empty)) {
        return Err(at.refuse(&key("name"), "empty", "the name of an input, or the first parts of one"));
    }
    let found = TopicPattern::new(table);
    found.ok_or_else(|| at.refuse(&key("topic"), format!("{:?}", table.topic), ALLOWED))
}

/// Settles what is wanted of each wagon of a train with so many wheelsets each.
pub(crate) fn resolve(
    at: &ConfigText<'_>,
    topics: &mut Topics,
    mapping: &Mapping,
    wheelsets: &[usize],
) -> Result<(), SettingsError> {
    let beyond = |pattern: &TopicPattern| pattern.wagon.is_some_and(|wagon| wagon >= wheelsets.len());
    if let Some(index) = topics.patterns.iter().position(beyond) {
        let given = topics.patterns[index].wagon.map_or(0, |wagon| wagon + 1);
        let allowed = format!("1 to {}", wheelsets.len());
        return Err(at.refuse(&format!("source.topics.{}.wagon", index + 1), given, allowed));
    }
    for (wagon, wheelsets) in wheelsets.iter().enumerate() {
        let wanted = wanted(at, topics, mapping, wagon, *wheelsets)?;
        topics.wagons.push(wanted);
    }
    Ok(())
}

fn wanted(
    at: &ConfigText<'_>,
    topics: &Topics,
    mapping: &Mapping,
    wagon: usize,
    wheelsets: usize,
) -> Result<WantedInputs, SettingsError> {
    let brings = |input: &str| topics.patterns.iter().any(|pattern| pattern.may_bring(input, wagon));
    let mapping = of_wagon(mapping, wagon);
    for rule in &mapping.rules {
        let inputs = rule.from.iter().chain(rule.flag.as_ref().map(|flag| &flag.from));
        if let Some(input) = inputs.into_iter().find(|input| !brings(input)) {
            let given = format!("{input:?}, which no topic brings to wagon {}", wagon + 1);
            return Err(at.refuse(
                &format!("mapping.{}.from", rule.to),
                given,
                "what `source.topics` can bring",
            ));
        }
    }
    let mut inputs: Vec<String> = mapping.inputs().map(str::to_owned).collect();
    // The time is that of the arrival, unless a rule says which input it is.
    for quantity in Quantity::ALL.into_iter().filter(|quantity| *quantity != Quantity::Time) {
        for wheelset in 0..if quantity.per_wheelset() { wheelsets } else { 1 } {
            let column = quantity.column(wheelset, wheelsets);
            if !mapping.rules.iter().any(|rule| rule.to == column) {
                inputs.push(column);
            }
        }
    }
    inputs.sort_unstable();
    inputs.dedup();
    let first = |quantity: Quantity| {
        let column = quantity.column(0, wheelsets);
        let rule = mapping.rules.iter().find(|rule| rule.to == column);
        let input = rule.map_or(Some(&column), |rule| rule.from.first())?;
        brings(input).then(|| input.clone())
    };
    let usual = || first(Quantity::WheelSpeed).or_else(|| first(Quantity::Speed));
    let named = topics.sample_on.as_ref().map(|name| with_number(name, wagon));
    let allowed = "an input of `[mapping]` that a topic brings";
    let refuse = |value: String| at.refuse("source.sample_on", value, allowed);
    let sample_on = named.or_else(usual).ok_or_else(|| refuse(format!("absent for wagon {}", wagon + 1)))?;
    if !inputs.contains(&sample_on) || !brings(&sample_on) {
        return Err(refuse(format!("{sample_on:?}")));
    }
    Ok(WantedInputs { mapping, inputs, sample_on })
}

/// The mapping with the number of a wagon (from 0) in its names.
fn of_wagon(mapping: &Mapping, wagon: usize) -> Mapping {
    let rule = |rule: &Rule| Rule {
        from: rule.from.iter().map(|name| with_number(name, wagon)).collect(),
        flag: rule.flag.as_ref().map(|flag| Flag { from: with_number(&flag.from, wagon), is: flag.is }),
        ..rule.clone()
    };
    Mapping { rules: mapping.rules.iter().map(rule).collect() }
}

fn with_number(name: &str, wagon: usize) -> String {
    let number = wagon + 1;
    name.replace(WAGON, &number.to_string()).replace("{wagon:02}", &format!("{number:02}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(topic: &str, wagon: Option<u32>, name: Option<&str>) -> Option<TopicPattern> {
        TopicPattern::new(&TopicTable { topic: topic.to_owned(), wagon, name: name.map(str::to_owned) })
    }

    #[test]
    fn a_pattern_says_wagon_and_name() {
        let bogie = pattern("train/w{wagon}/{name}/{name}", None, None).expect("sound");
        assert_eq!(bogie.filter(), "train/+/+/+");
        let meant = bogie.meaning("train/w7/bogie1/speed").expect("fits");
        assert_eq!((meant.wagon, meant.name.as_str()), (OfWagon::Called("7"), "bogie1.speed"));
        for other in ["train/7/bogie1/speed", "train/w7/bogie1", "train/w/bogie1/speed", "bus/w7/a/b", ""] {
            assert_eq!(bogie.meaning(other), None, "{other}");
        }
        let fixed = pattern("loco/+/gps", Some(2), Some("gps")).expect("sound");
        let meant = fixed.meaning("loco/any/gps").expect("fits");
        assert_eq!((meant.wagon, meant.name.as_str()), (OfWagon::Index(1), "gps"));
        let whole = pattern("train/state", None, None).expect("sound");
        assert_eq!(whole.meaning("train/state").map(|meant| meant.wagon), Some(OfWagon::All));
    }

    #[test]
    fn what_is_no_pattern_is_refused() {
        for topic in ["", "a/#", "a/b+", "{wagon}/{wagon}", "a/{wagn}", "{wagon}{name}", "a/\0"] {
            assert_eq!(pattern(topic, None, None), None, "{topic:?}");
        }
    }

    #[test]
    fn what_a_pattern_can_bring_is_known_before_it_comes() {
        let gps = pattern("gps", Some(1), Some("gps")).expect("sound");
        assert!(gps.may_bring("gps", 0) && gps.may_bring("gps.speed", 0));
        assert!(!gps.may_bring("gpsx", 0) && !gps.may_bring("gps", 1) && !gps.may_bring("speed", 0));
        let two = pattern("{name}/{name}", None, None).expect("sound");
        assert!(two.may_bring("a.b", 3) && two.may_bring("a.b.c", 3) && !two.may_bring("a", 3));
    }
}
