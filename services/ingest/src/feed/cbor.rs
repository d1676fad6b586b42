//! Samples in CBOR (RFC 8949): maps with the same names and values as the lines of JSON, one after another or in an array. The
//! first byte tells the two apart: no text begins with one of 0x80 or more.

use super::Inlet;
use super::lines::parse_object;
use ciborium::Value;
use ciborium::value::Integer;
use serde_json::{Map, Value as Json};

/// Levels of maps and arrays in one message, at most.
const DEEPEST: usize = 16;
/// Bytes of arrays, maps and tags: all other first bytes begin a number, a text or a plain value.
const FIRST: u8 = 0x80;

/// Whether a message is CBOR, and not JSON.
pub(super) fn is_cbor(message: &[u8]) -> bool {
    message.first().is_some_and(|byte| *byte >= FIRST)
}

/// Puts every map of a message into the inlet; false once nobody takes them any more.
pub(super) fn put_all(mut message: &[u8], name: &str, inlet: &Inlet) -> bool {
    while !message.is_empty() {
        let value = match ciborium::de::from_reader_with_recursion_limit(&mut message, DEEPEST) {
            Ok(value) => value,
            // Where one item ends wrongly, nobody knows where the next begins.
            Err(error) => return inlet.put(Err(format!("{name}: no CBOR: {}", in_words(&error)))),
        };
        let items = match value {
            Value::Array(items) => items,
            one => vec![one],
        };
        for item in items {
            let row = match json(&item) {
                Some(Json::Object(object)) => parse_object(&object, inlet.layout()),
                _ => Err("no CBOR map with texts as keys, each once, and numbers, texts or maps as values"
                    .to_owned()),
            };
            if !inlet.put(row.map_err(|problem| format!("{name}: {problem}"))) {
                return false;
            }
        }
    }
    true
}

/// The one value of a message, as JSON.
///
/// # Errors
/// In words: what is no CBOR, or has no place in JSON.
pub(super) fn value(mut message: &[u8]) -> Result<Json, String> {
    let value = ciborium::de::from_reader_with_recursion_limit(&mut message, DEEPEST);
    let value = value.map_err(|error| format!("no CBOR: {}", in_words(&error)))?;
    let found = json(&value).filter(|_| message.is_empty());
    found.ok_or_else(|| "no single number, text or map of them in CBOR".to_owned())
}

/// What is wrong, and at which byte where that is known.
fn in_words(error: &ciborium::de::Error<std::io::Error>) -> String {
    use ciborium::de::Error;
    match error {
        Error::Io(_) => "it ends in the middle of an item".to_owned(),
        Error::Syntax(at) => format!("byte {at} begins no item"),
        Error::Semantic(_, why) => why.clone(),
        Error::RecursionLimitExceeded => "items in items, too deep".to_owned(),
    }
}

/// The same as JSON; nothing where JSON has no such thing. A number that is none (NaN) is a missing one.
fn json(value: &Value) -> Option<Json> {
    Some(match value {
        Value::Null => Json::Null,
        Value::Bool(flag) => Json::Bool(*flag),
        Value::Integer(number) => integer(*number),
        Value::Float(number) => Json::from(*number),
        Value::Text(text) => Json::String(text.clone()),
        // What a tag says of its value (an instant, for example), the name of the column says as well.
        Value::Tag(_, inner) => json(inner)?,
        Value::Array(items) => Json::Array(items.iter().map(json).collect::<Option<_>>()?),
        Value::Map(pairs) => {
            let pair = |(key, value): &(Value, Value)| Some((key.as_text()?.to_owned(), json(value)?));
            let object = pairs.iter().map(pair).collect::<Option<Map<_, _>>>()?;
            // Of a name that stands twice nobody knows which value is meant.
            (object.len() == pairs.len()).then_some(Json::Object(object))?
        }
        _ => return None,
    })
}

fn integer(number: Integer) -> Json {
    let wide = i128::from(number);
    i64::try_from(wide).map_or_else(|_| Json::from(wide as f64), Json::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::{Arrival, Feed, Live};
    use railgrip_filter::PlantKind;

    /// Times and speeds of what a message holds, and what was refused.
    fn taken(message: &[u8]) -> (Vec<(f64, f64)>, Vec<String>) {
        let vehicle =
            toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("the default vehicle");
        let mut live = Live::of("test", &[vehicle], &[PlantKind::Wagon]);
        let inlet = live.inlet().expect("the first");
        assert!(put_all(message, "test", &inlet));
        let (mut rows, mut refused) = (Vec::new(), Vec::new());
        live.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { row, .. } => rows.push((row.t_s, row.v_m_s)),
            Arrival::Refused(problem) => refused.push(problem),
            other => panic!("{other:?}"),
        });
        (rows, refused)
    }

    fn written(value: &Value) -> Vec<u8> {
        let mut bytes = Vec::new();
        ciborium::into_writer(value, &mut bytes).expect("a value can be written");
        bytes
    }

    fn sample(t_s: Value, v_m_s: Value) -> Value {
        Value::Map(vec![(Value::from("t_s"), t_s), (Value::from("v_m_s"), v_m_s)])
    }

    #[test]
    fn maps_arrays_of_maps_and_sequences_become_rows() {
        let first = sample(Value::from(1), Value::from(20.5));
        let second = sample(Value::Tag(1, Box::new(Value::from(2.5))), Value::from(f64::NAN));
        let mut message = written(&first);
        message.extend(written(&Value::Array(vec![second, sample(Value::from(3), Value::Null)])));
        assert!(is_cbor(&message) && !is_cbor(b"{\"t_s\": 1}") && !is_cbor(b""));
        let (rows, refused) = taken(&message);
        assert_eq!((rows[0], refused.len()), ((1.0, 20.5), 0), "{refused:?}");
        assert!(rows[1].0 == 2.5 && rows[1].1.is_nan() && rows[2].0 == 3.0 && rows[2].1.is_nan());
    }

    #[test]
    fn what_is_no_sample_is_refused_in_words() {
        let bytes = Value::Bytes(vec![1, 2]);
        let said = |value: &Value| taken(&written(value)).1.join("; ");
        assert!(said(&sample(bytes, Value::from(1))).contains("no CBOR map"));
        assert!(said(&Value::Map(vec![(Value::from(1), Value::from(1))])).contains("no CBOR map"));
        assert!(said(&sample(Value::from("noon"), Value::from(1))).contains("\"t_s\" is \"noon\""));
        assert!(said(&Value::Array(vec![Value::from(7)])).contains("no CBOR map"));
        let twice =
            Value::Map(vec![(Value::from("t_s"), Value::from(1)), (Value::from("t_s"), Value::from(2))]);
        assert!(said(&twice).contains("each once"));
        let deep = (0..40).fold(Value::Null, |inner, _| Value::Array(vec![inner]));
        assert!(said(&deep).contains("no CBOR"));
        // An array that claims four thousand million items, and a map that ends too early.
        assert!(taken(&[0x9a, 0xff, 0xff, 0xff, 0xff]).1[0].contains("no CBOR"));
        let cut = written(&sample(Value::from(1), Value::from(2)));
        assert!(taken(&cut[..cut.len() - 1]).1[0].contains("no CBOR"));
    }
}
