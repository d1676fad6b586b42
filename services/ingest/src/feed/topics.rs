//! Messages of a broker with one value, or an object of values, each: the latest values of a wagon become a row whenever its
//! sample input arrives.

use super::lines::{fits, number};
use super::{Inlet, Layout, cbor, json};
use railgrip_bus::monotonic_ns;
use railgrip_messages::SourceCount;
use railgrip_recording::{Quantity, Row};
use railgrip_settings::{OfWagon, Topics, VehicleNumber, WantedInputs};
use serde_json::{Map, Value};
use std::collections::HashMap;

/// The key under which a value stands that is no object.
const PLAIN: &str = "";

/// The latest value of an input.
#[derive(Debug, Clone, Copy)]
struct Held {
    value: f64,
    at_s: f64,
}

/// The latest values of all wagons.
pub(super) struct Values {
    topics: Topics,
    held: Vec<HashMap<String, Held>>,
    inlet: Inlet,
}

impl Values {
    /// Nothing has come yet.
    pub fn new(topics: &Topics, inlet: Inlet) -> Self {
        Self { topics: topics.clone(), held: vec![HashMap::new(); topics.wagons.len()], inlet }
    }

    /// Takes a message; false once nobody takes rows any more.
    pub fn take(&mut self, topic: &str, payload: &[u8], name: &str) -> bool {
        self.take_at(topic, payload, name, monotonic_ns())
    }

    fn take_at(&mut self, topic: &str, payload: &[u8], name: &str, arrived_ns: u64) -> bool {
        let Some((wagons, input)) = self.meaning(topic) else { return self.unwanted() };
        let object = match object(payload) {
            Ok(object) => object,
            Err(problem) => return self.inlet.put(Err(format!("{name}: {problem}"))),
        };
        let at_s = arrived_ns as f64 * 1e-9;
        let mut samples = Vec::new();
        let mut wanted = false;
        for wagon in wagons {
            match self.hold(wagon, &input, &object, at_s) {
                Ok(taken) => {
                    wanted |= taken.wanted;
                    samples.extend(taken.samples.then_some(wagon));
                }
                Err(problem) => return self.inlet.put(Err(format!("{name}: {problem}"))),
            }
        }
        if !wanted {
            return self.unwanted();
        }
        self.inlet.tally().add(SourceCount::Arrived, 1);
        samples.into_iter().all(|wagon| self.sample(wagon, at_s, arrived_ns, name))
    }

    /// The wagons (from 0) and the input that a topic means; nothing where it means none of this train.
    fn meaning(&self, topic: &str) -> Option<(Vec<usize>, String)> {
        let meant = self.topics.patterns.iter().find_map(|pattern| pattern.meaning(topic))?;
        let wagons = match meant.wagon {
            OfWagon::All => (0..self.held.len()).collect(),
            OfWagon::Index(index) => vec![index],
            OfWagon::Called(called) => vec![wagon(called, self.inlet.layout())?],
        };
        Some((wagons, meant.name))
    }

    fn unwanted(&self) -> bool {
        self.inlet.tally().add(SourceCount::Arrived, 1);
        self.inlet.tally().add(SourceCount::Unwanted, 1);
        true
    }

    /// Takes what a wagon wants of an object.
    fn hold(
        &mut self,
        wagon: usize,
        name: &str,
        object: &Map<String, Value>,
        at_s: f64,
    ) -> Result<Taken, String> {
        let WantedInputs { inputs, sample_on, mapping } = &self.topics.wagons[wagon];
        let count = self.inlet.layout().wheelsets[wagon];
        let mut taken = Taken::default();
        for input in inputs {
            let Some(key) = key_of(input, name) else { continue };
            if key == PLAIN && !object.contains_key(PLAIN) {
                continue;
            }
            // A broken value does not leave the one before in its place.
            let value = number(object, key)
                .and_then(|value| fits(object, key, input, mapping, count).map(|()| value));
            let held = Held { value: value.as_ref().copied().unwrap_or(f64::NAN), at_s };
            let there = held.value.is_finite() || value.is_err() || is_there(object, key);
            if there {
                self.held[wagon].insert(input.clone(), held);
                taken.wanted = true;
                taken.samples |= input == sample_on;
            }
            value?;
        }
        Ok(taken)
    }

    /// Makes a row of what is known of a wagon; false once nobody takes rows any more.
    fn sample(&self, wagon: usize, at_s: f64, arrived_ns: u64, name: &str) -> bool {
        let wanted = &self.topics.wagons[wagon];
        let fresh = |input: &str| {
            let held = self.held[wagon].get(input).filter(|held| at_s - held.at_s <= self.topics.hold_s);
            held.map_or(f64::NAN, |held| held.value)
        };
        let count = self.inlet.layout().wheelsets[wagon];
        let mut row = Row::default();
        for quantity in Quantity::ALL {
            for wheelset in 0..if quantity.per_wheelset() { count } else { 1 } {
                let column = quantity.column(wheelset, count);
                *row.get_mut(quantity, wheelset) = wanted.mapping.value(&column, &mut |input| fresh(input));
            }
        }
        if !wanted.carries_time() {
            row.t_s = at_s;
        }
        if row.t_s.is_nan() {
            self.inlet.tally().add(SourceCount::Unreadable, 1);
            return self.inlet.refuse(format!("{name}: the input of \"t_s\" is missing"));
        }
        self.inlet.sample(wagon, row, arrived_ns)
    }
}

/// What an object brought to a wagon.
#[derive(Debug, Clone, Copy, Default)]
struct Taken {
    wanted: bool,
    /// The input that makes rows is among it.
    samples: bool,
}

/// The values of a message; a plain one stands under [`PLAIN`].
fn object(payload: &[u8]) -> Result<Map<String, Value>, String> {
    let value = if cbor::is_cbor(payload) { cbor::value(payload)? } else { json::value(payload)? };
    match value {
        Value::Object(object) => Ok(object),
        Value::Array(_) => {
            Err("an array, allowed is a number, a text with an instant, or an object".to_owned())
        }
        plain => Ok(Map::from_iter([(PLAIN.to_owned(), plain)])),
    }
}

/// The key of an input in an object that came under a name.
fn key_of<'a>(input: &'a str, name: &str) -> Option<&'a str> {
    if name.is_empty() {
        return Some(input);
    }
    let rest = input.strip_prefix(name)?;
    if rest.is_empty() { Some(PLAIN) } else { rest.strip_prefix('.') }
}

/// Whether an object says anything about a key, be it null.
fn is_there(object: &Map<String, Value>, key: &str) -> bool {
    let mut parts = key.split('.');
    let first = parts.next().and_then(|part| object.get(part));
    object.contains_key(key)
        || first.and_then(|first| parts.try_fold(first, |value, part| value.get(part))).is_some()
}

/// The wagon (from 0) that a topic names, by its vehicle number or by its place.
fn wagon(called: &str, layout: &Layout) -> Option<usize> {
    let key = VehicleNumber::new(called);
    let same = |own: &Option<VehicleNumber>| {
        own.as_ref().zip(key.as_ref()).is_some_and(|(own, key)| own.key() == key.key())
    };
    let place =
        || called.parse::<usize>().ok()?.checked_sub(1).filter(|wagon| *wagon < layout.wheelsets.len());
    layout.numbers.iter().position(same).or_else(place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::{Arrival, Feed, Live};
    use railgrip_settings::{MqttSource, Overrides, Source, Subjects, TrainSettings};
    use std::path::Path;

    /// A train of two wagons, the second with a number of its own.
    fn values(more: &str) -> (Values, Live) {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/x.toml");
        let text = format!(
            "schema = 1\n[train]\nname = \"m\"\nvehicle = \"vehicle.toml\"\n[[wagon]]\n[[wagon]]\nnumber = \"51 80 7\"\n\
             [source]\nkind = \"mqtt\"\nhost = \"localhost\"\ntopics = [\n\
             {{ topic = \"train/{{wagon}}/bogie1/{{name}}\" }}, {{ topic = \"loco/gps\", name = \"gps\" }}]\n\
             [mapping]\nomega_f_rad_s = {{ from = \"axle1\", unit = \"rpm\" }}\nv_m_s = {{ from = \"gps.v\", unit = \"km/h\" }}\n{more}"
        );
        let settings = TrainSettings::parse(Path::new(file), &text, &Overrides::default()).expect("sound");
        let Source::Mqtt(MqttSource { subjects: Subjects::Values(topics), .. }) = &settings.source else {
            panic!("{:?}", settings.source)
        };
        let mut live = Live::new(&settings);
        let inlet = live.inlet().expect("the first");
        (Values::new(topics, inlet), live)
    }

    fn rows(live: &mut Live) -> (Vec<(usize, Row)>, Vec<String>) {
        let (mut rows, mut refused) = (Vec::new(), Vec::new());
        live.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { wagon, row, .. } => rows.push((wagon, *row)),
            Arrival::Refused(problem) => refused.push(problem),
            other => panic!("{other:?}"),
        });
        (rows, refused)
    }

    const S: u64 = 1_000_000_000;

    #[test]
    fn values_of_several_topics_become_the_rows_of_their_wagons() {
        let (mut values, mut live) = values("");
        assert!(values.take_at("loco/gps", br#"{"v": 72, "satellites": 9}"#, "t", 5 * S));
        assert!(values.take_at("train/1/bogie1/axle1", b"300", "t", 5 * S + 10));
        assert!(values.take_at("train/51-80-7/bogie1/axle1", b"150", "t", 5 * S + 20));
        let (found, refused) = rows(&mut live);
        let [(0, first), (1, second)] = &found[..] else { panic!("{found:?} {refused:?}") };
        assert!((first.v_m_s - 20.0).abs() < 1e-9 && (second.v_m_s - 20.0).abs() < 1e-9);
        assert!((first.wheel_speed_rad_s[0] - 31.415_926_5).abs() < 1e-6);
        assert!((second.wheel_speed_rad_s[0] - 15.707_963_3).abs() < 1e-6);
        // What is older than hold_ms is missing.
        assert!(values.take_at("train/1/bogie1/axle1", b"300", "t", 6 * S));
        assert!(rows(&mut live).0[0].1.v_m_s.is_nan());
    }

    #[test]
    fn what_is_no_value_is_counted_and_leaves_nothing_old_in_its_place() {
        let (mut values, mut live) = values("");
        values.take_at("loco/gps", br#"{"v": 72}"#, "t", 5 * S);
        values.take_at("loco/gps", br#"{"v": "fast"}"#, "t", 5 * S);
        for wrong in [&b"NaN"[..], b"\"fast\"", b"[1]", b"", b"\xff\xfe", b"\x9a\xff\xff\xff\xff", b"1 2"] {
            assert!(values.take_at("train/1/bogie1/axle1", wrong, "t", 5 * S), "{wrong:?}");
        }
        for foreign in ["train/3/bogie1/axle1", "train/0/bogie1/axle1", "train/1/bogie1/other", "else", ""] {
            assert!(values.take_at(foreign, b"1", "t", 5 * S), "{foreign}");
        }
        values.take_at("train/1/bogie1/axle1", b"300", "t", 5 * S + 10);
        let (found, refused) = rows(&mut live);
        assert_eq!((found.len(), refused.len()), (1, 8), "{refused:#?}");
        assert!(found[0].1.v_m_s.is_nan());
        let tally = values.inlet.tally();
        let counts = [SourceCount::Unreadable, SourceCount::Unwanted, SourceCount::Arrived];
        assert_eq!(counts.map(|what| tally.count(what)), [8, 5, 15]);
    }

    #[test]
    fn what_is_true_or_an_instant_measures_nothing() {
        let (mut values, mut live) = values("sanding = { from = \"sand\" }\n");
        let take = |values: &mut Values, topic: &str, payload: &[u8]| {
            assert!(values.take_at(topic, payload, "t", 5 * S), "{topic}");
        };
        take(&mut values, "loco/gps", br#"{"v": "2026-03-01T12:00:00Z"}"#);
        take(&mut values, "train/1/bogie1/axle1", b"true");
        let (found, refused) = rows(&mut live);
        assert!(found.is_empty(), "{found:?}");
        let starts = [
            "t: \"v\" is \"2026-03-01T12:00:00Z\", allowed is a number",
            "t: \"\" is true, allowed is a number",
        ];
        assert!(refused.iter().zip(starts).all(|(said, start)| said.starts_with(start)), "{refused:?}");
        take(&mut values, "train/1/bogie1/sand", b"true");
        take(&mut values, "train/1/bogie1/axle1", b"300");
        let (found, refused) = rows(&mut live);
        assert_eq!((found.len(), found[0].1.sanding), (1, 1.0), "{refused:?}");
    }

    #[test]
    fn a_time_comes_from_the_message_that_a_rule_names() {
        let (mut values, mut live) = values("t_s = { from = \"axle1.at\", unit = \"ms\" }\n");
        // The plain form has no time: such a row has none.
        values.take_at("train/1/bogie1/axle1", b"300", "t", 5 * S);
        values.take_at("train/1/bogie1/axle1", br#"{"at": 2500, "": 1}"#, "t", 5 * S);
        let (found, refused) = rows(&mut live);
        assert_eq!((found.len(), found[0].1.t_s, refused.len()), (1, 2.5, 1), "{refused:?}");
        assert!(refused[0].contains("t_s"), "{refused:?}");
    }
}
