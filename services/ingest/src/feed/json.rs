//! Values in JSON in which each name stands once: of a name that stands twice, nobody knows which value is meant.

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

/// A value of JSON whose objects have each name once.
struct Distinct(Value);

/// The value that a text says.
///
/// # Errors
/// In words: what is no JSON, or which name stands twice.
pub(super) fn value(text: &[u8]) -> Result<Value, String> {
    let value: Distinct = serde_json::from_slice(text).map_err(|error| match error.classify() {
        serde_json::error::Category::Data => error.to_string(),
        _ => format!("no JSON: {error}"),
    })?;
    Ok(value.0)
}

impl<'de> Deserialize<'de> for Distinct {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader).map(Self)
    }
}

struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = Value;

    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("a value of JSON")
    }

    fn visit_bool<E: Error>(self, flag: bool) -> Result<Value, E> {
        Ok(flag.into())
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Value, E> {
        Ok(text.into())
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Distinct(item)) = items.next_element()? {
            list.push(item);
        }
        Ok(Value::Array(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut pairs: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some((name, Distinct(value))) = pairs.next_entry::<String, Distinct>()? {
            if object.contains_key(&name) {
                return Err(Error::custom(format_args!("\"{name}\" stands twice")));
            }
            object.insert(name, value);
        }
        Ok(Value::Object(object))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_as_anybody_reads_them() {
        let text = r#"{"a": [1, -2, 2.5, true, null, "x\n"], "b": {"a": 18446744073709551615}}"#;
        assert_eq!(value(text.as_bytes()), Ok(serde_json::from_str(text).unwrap()));
        assert!(value(b"{\"a\": 1e400}").unwrap_err().starts_with("no JSON"));
    }

    #[test]
    fn a_name_that_stands_twice_is_refused_at_any_depth() {
        for text in [r#"{"a": 1, "b": 2, "a": 1}"#, r#"{"x": [{"a": 1, "a": 2}]}"#] {
            let said = value(text.as_bytes()).unwrap_err();
            assert!(said.starts_with("\"a\" stands twice"), "{text}: {said}");
        }
    }
}
