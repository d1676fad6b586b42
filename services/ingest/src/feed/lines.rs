//! Samples as lines: one JSON object each, with the columns of a recording and the wagon, by its place in the train or by its
//! vehicle number. What a source calls them otherwise, or measures in other units, `[mapping]` says.
//!
//! `{"wagon": 1, "t_s": 0.01, "v_m_s": 22.4, "omega_f_rad_s": 51.2, "omega_r_rad_s": 51.1, "f_perp_f_n": 0, ...}`
//! A value that is absent or null is missing. A line that is wrong is refused with its number; nothing ends because of
//! it.

use super::{Inlet, Layout, json};
use railgrip_recording::{Mapping, Quantity, Row, instant_s};
use railgrip_settings::VehicleNumber;
use serde_json::{Map, Value};
use std::io::BufRead;

/// The longest line, bytes: more is no sample.
const LONGEST_LINE: usize = 64 * 1024;
/// What some programs write before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads lines to their end and puts their rows into the inlet; `name` stands for the source in messages.
pub(super) fn read(mut input: impl BufRead, name: &str, inlet: &Inlet) {
    let mut line = Vec::new();
    for number in 1_u64.. {
        line.clear();
        let item = match read_line(&mut input, &mut line) {
            Ok(None) => return,
            Ok(Some(false)) => Err(format!("longer than {LONGEST_LINE} bytes")),
            Ok(Some(true)) if line.iter().all(u8::is_ascii_whitespace) => continue,
            Ok(Some(true)) => parse_line(&line, inlet.layout()),
            Err(error) => {
                tracing::error!(%error, "{name} cannot be read");
                return;
            }
        };
        if !inlet.put(item.map_err(|problem| format!("{name}, line {number}: {problem}"))) {
            return;
        }
    }
}

/// Reads up to the end of the line; `Some(false)` for one that is too long (it is skipped), `None` at the end.
fn read_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> std::io::Result<Option<bool>> {
    let mut fits = true;
    loop {
        let available = input.fill_buf()?;
        if available.is_empty() {
            return Ok((!line.is_empty() || !fits).then_some(fits));
        }
        let end = available.iter().position(|byte| *byte == b'\n');
        let taken = end.unwrap_or(available.len());
        if line.len() + taken <= LONGEST_LINE {
            line.extend_from_slice(&available[..taken]);
        } else {
            fits = false;
        }
        input.consume(taken + usize::from(end.is_some()));
        if end.is_some() {
            return Ok(Some(fits));
        }
    }
}

/// Puts every line of a datagram or message into the inlet; false once nobody takes them any more.
pub(super) fn put_all(text: &[u8], name: &str, inlet: &Inlet) -> bool {
    let lines = text.split(|byte| *byte == b'\n').filter(|line| !line.iter().all(u8::is_ascii_whitespace));
    for line in lines {
        let item = parse_line(line, inlet.layout()).map_err(|problem| format!("{name}: {problem}"));
        if !inlet.put(item) {
            return false;
        }
    }
    true
}

/// The wagon (from 0) and the row of one line.
///
/// # Errors
/// In words: what is wrong, and what is allowed.
pub fn parse_line(line: &[u8], layout: &Layout) -> Result<(usize, Row), String> {
    let value = json::value(line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line))?;
    let Value::Object(object) = value else { return Err("no JSON object".to_owned()) };
    parse_object(&object, layout)
}

/// The wagon (from 0) and the row of one object.
pub(super) fn parse_object(object: &Map<String, Value>, layout: &Layout) -> Result<(usize, Row), String> {
    let wagon = wagon(object, layout)?;
    let count = layout.wheelsets[wagon];
    let mut row = Row::default();
    let mut known = usize::from(object.contains_key("wagon"));
    for quantity in Quantity::ALL {
        let places = if quantity.per_wheelset() { count } else { 1 };
        for wheelset in 0..places {
            let name = quantity.column(wheelset, count);
            known += usize::from(object.contains_key(&name));
            *row.get_mut(quantity, wheelset) = cell(object, &name, &layout.mapping, count)?;
        }
    }
    // Who maps names what is wanted of a source that may say more.
    if layout.mapping.is_empty() && known < object.len() {
        return Err(unknown_key(object, count));
    }
    if row.t_s.is_nan() {
        return Err("\"t_s\" is missing".to_owned());
    }
    Ok((wagon, row))
}

/// The wagon that a line is about: by its place in the train, or by its vehicle number.
fn wagon(object: &Map<String, Value>, layout: &Layout) -> Result<usize, String> {
    let wagons = layout.wheelsets.len();
    let found = match object.get("wagon") {
        None if wagons == 1 => return Ok(0),
        None => return Err("\"wagon\" is missing".to_owned()),
        Some(Value::String(text)) => {
            let key = VehicleNumber::new(text);
            let same = |own: &Option<VehicleNumber>| {
                own.as_ref().zip(key.as_ref()).is_some_and(|(own, key)| own.key() == key.key())
            };
            layout.numbers.iter().position(same)
        }
        Some(number) => number.as_u64().and_then(|number| usize::try_from(number).ok()?.checked_sub(1)),
    };
    found.filter(|wagon| *wagon < wagons).ok_or_else(|| {
        let given = object.get("wagon").map_or_else(String::new, Value::to_string);
        format!("\"wagon\" is {given}, allowed is 1 to {wagons}, or a vehicle number of the train in quotes")
    })
}

/// The value of a column, by the mapping; NaN where nothing is said.
fn cell(object: &Map<String, Value>, column: &str, mapping: &Mapping, count: usize) -> Result<f64, String> {
    let mut wrong = None;
    let value = mapping.value(column, &mut |name| {
        let value =
            number(object, name).and_then(|value| fits(object, name, name, mapping, count).map(|()| value));
        value.unwrap_or_else(|problem| {
            wrong = Some(problem);
            f64::NAN
        })
    });
    wrong.map_or(Ok(value), Err)
}

/// Whether what stands under a name of an object can be that of an input of a wagon with `count` wheelsets: an instant is a time and
/// nothing else, true or false says whether something is on and measures nothing.
///
/// # Errors
/// In words.
pub(super) fn fits(
    object: &Map<String, Value>,
    name: &str,
    input: &str,
    mapping: &Mapping,
    count: usize,
) -> Result<(), String> {
    let becomes = |quantity: Quantity| {
        let places = if quantity.per_wheelset() { count } else { 1 };
        (0..places).any(|wheelset| mapping.reads(&quantity.column(wheelset, count), input))
    };
    let Some(value) = entry(object, name) else { return Ok(()) };
    let fits = match value {
        Value::Bool(_) => {
            mapping.is_flag(input)
                || Quantity::ALL.into_iter().any(|quantity| is_switch(quantity) && becomes(quantity))
        }
        Value::String(_) => becomes(Quantity::Time),
        _ => true,
    };
    if fits { Ok(()) } else { Err(refusal(name, value)) }
}

/// Whether a quantity says that something is on (1) or off (0), be it in part.
fn is_switch(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::Sanding | Quantity::WspActive | Quantity::BrakeDemand)
}

/// A number by its name, or by the way to it through objects, `a.b`; NaN where there is none.
pub(super) fn number(object: &Map<String, Value>, name: &str) -> Result<f64, String> {
    match entry(object, name) {
        None | Some(Value::Null) => Ok(f64::NAN),
        Some(Value::Bool(flag)) => Ok(f64::from(u8::from(*flag))),
        Some(value @ Value::String(text)) => instant_s(text).ok_or_else(|| refusal(name, value)),
        Some(value) => value.as_f64().ok_or_else(|| refusal(name, value)),
    }
}

/// What stands under a name, or under the way to it through objects, `a.b`.
fn entry<'a>(object: &'a Map<String, Value>, name: &str) -> Option<&'a Value> {
    let nested = || {
        let mut parts = name.split('.');
        let first = object.get(parts.next()?)?;
        parts.try_fold(first, |value, part| value.get(part))
    };
    object.get(name).or_else(nested)
}

fn refusal(name: &str, value: &Value) -> String {
    format!("\"{name}\" is {value}, allowed is a number or null")
}

fn unknown_key(object: &Map<String, Value>, count: usize) -> String {
    let mut names = vec!["wagon".to_owned()];
    for quantity in Quantity::ALL {
        let places = if quantity.per_wheelset() { count } else { 1 };
        names.extend((0..places).map(|wheelset| quantity.column(wheelset, count)));
    }
    let unknown = object.keys().find(|key| !names.contains(key)).map_or("", String::as_str);
    format!("unknown key \"{unknown}\", allowed are {}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::{Arrival, Feed, Live, Next};
    use railgrip_filter::PlantKind;
    use railgrip_recording::{Combine, Rule, unit};

    fn two() -> Layout {
        let numbers = vec![VehicleNumber::new("51 80 7"), None];
        Layout { wheelsets: vec![2, 2], numbers, mapping: Mapping::default() }
    }

    #[test]
    fn a_mapped_line_has_its_own_names_units_and_extras() {
        let (factor, _) = unit("km/h").unwrap();
        let rule = |to: &str, from: &str, factor: f64| Rule {
            to: to.to_owned(),
            from: vec![from.to_owned()],
            combine: Combine::First,
            factor,
            offset: 0.0,
            flag: None,
        };
        let rules = vec![rule("t_s", "at", 1.0), rule("v_m_s", "gps.speed", factor)];
        let layout = Layout { mapping: Mapping { rules }, ..two() };
        let line = br#"{"wagon": "51-80-7", "at": "2026-03-01T12:00:00.5Z", "gps": {"speed": 72}, "driver": "Ada", "sanding": true}"#;
        let (wagon, row) = parse_line(line, &layout).unwrap();
        assert_eq!((wagon, row.t_s, row.v_m_s, row.sanding), (0, 1_772_366_400.5, 20.0, 1.0));
        let said = parse_line(br#"{"wagon": 1, "at": "noon"}"#, &layout).unwrap_err();
        assert!(said.starts_with("\"at\" is \"noon\""), "{said}");
        let said = parse_line(br#"{"wagon": "99", "at": 1}"#, &layout).unwrap_err();
        assert!(said.contains("a vehicle number of the train"), "{said}");
    }

    /// A flag says true or false of a value that is a number.
    #[test]
    fn a_flag_is_true_or_false_and_what_it_is_about_a_number() {
        let rule = Rule {
            to: "v_m_s".to_owned(),
            from: vec!["speed".to_owned()],
            combine: Combine::First,
            factor: 1.0,
            offset: 0.0,
            flag: Some(railgrip_recording::Flag { from: "ok".to_owned(), is: 1.0 }),
        };
        let layout = Layout { mapping: Mapping { rules: vec![rule] }, ..two() };
        let read = |line: &str| parse_line(line.as_bytes(), &layout).map(|(_, row)| row.v_m_s);
        assert_eq!(read(r#"{"wagon": 1, "t_s": 1, "speed": 16, "ok": true}"#), Ok(16.0));
        assert!(read(r#"{"wagon": 1, "t_s": 1, "speed": 16, "ok": false}"#).unwrap().is_nan());
        let said = read(r#"{"wagon": 1, "t_s": 1, "speed": true, "ok": true}"#).unwrap_err();
        assert!(said.starts_with("\"speed\" is true"), "{said}");
    }

    #[test]
    fn a_mark_of_the_byte_order_and_an_end_of_windows_are_no_part_of_a_line() {
        let (_, row) =
            parse_line(b"\xef\xbb\xbf{\"wagon\": 1, \"t_s\": 1, \"v_m_s\": 16}\r", &two()).unwrap();
        assert_eq!((row.t_s, row.v_m_s), (1.0, 16.0));
    }

    #[test]
    fn a_line_is_a_sample() {
        let line = br#"{"wagon": 2, "t_s": 0.5, "v_m_s": 20, "omega_f_rad_s": 45.5, "omega_r_rad_s": null}"#;
        let (wagon, row) = parse_line(line, &two()).unwrap();
        assert_eq!((wagon, row.t_s, row.v_m_s, row.wheel_speed_rad_s[0]), (1, 0.5, 20.0, 45.5));
        assert!(row.wheel_speed_rad_s[1].is_nan() && row.grade_rad.is_nan());
    }

    #[test]
    fn what_is_wrong_is_named() {
        let cases = [
            (r#"{"wagon": 1"#, "no JSON"),
            ("[1, 2]", "no JSON object"),
            (r#"{"t_s": 1}"#, "\"wagon\" is missing"),
            (r#"{"wagon": 3, "t_s": 1}"#, "\"wagon\" is 3, allowed is 1 to 2"),
            (r#"{"wagon": 1, "v_m_s": 3}"#, "\"t_s\" is missing"),
            (r#"{"wagon": 1, "t_s": "soon"}"#, "\"t_s\" is \"soon\""),
            (r#"{"wagon": 1, "t_s": 1, "v_m_s": true}"#, "\"v_m_s\" is true, allowed is a number or null"),
            (
                r#"{"wagon": 1, "t_s": 1, "v_m_s": "2026-03-01T12:00:00Z"}"#,
                "\"v_m_s\" is \"2026-03-01T12:00:00Z\"",
            ),
            (r#"{"wagon": 1, "t_s": 1, "v_m_s": 16, "v_m_s": 61}"#, "\"v_m_s\" stands twice"),
            (
                r#"{"wagon": 1, "t_s": 1, "speed": 3}"#,
                "unknown key \"speed\", allowed are wagon, t_s, v_m_s, omega_f",
            ),
        ];
        for (line, words) in cases {
            let said = parse_line(line.as_bytes(), &two()).unwrap_err();
            assert!(said.starts_with(words), "{line}: {said}");
        }
    }

    #[test]
    fn bad_lines_are_numbered_and_nothing_ends_because_of_them() {
        let mut text = b"{\"t_s\": 1, \"v_m_s\": 5}\n\nnonsense\n".to_vec();
        text.extend(vec![b'x'; LONGEST_LINE + 1]);
        text.extend(b"\n\xff\xfe\n{\"t_s\": 2, \"v_m_s\": 6}");
        let vehicle = toml::from_str(include_str!("../../../../config/vehicle.toml")).unwrap();
        let mut live = Live::of("test", &[vehicle], &[PlantKind::Wagon]);
        read(std::io::Cursor::new(text), "standard input", &live.inlet().unwrap());
        let (mut times, mut problems) = (Vec::new(), Vec::new());
        let mut sink = |arrival: Arrival<'_>| match arrival {
            Arrival::Row { row, .. } => times.push(row.t_s),
            Arrival::Refused(problem) => problems.push(problem),
            other => panic!("{other:?}"),
        };
        assert_eq!(live.take_due(0.0, &mut sink), Next::Ended);
        println!("{problems:?}");
        assert_eq!(times, [1.0, 2.0]);
        let starts = [
            "standard input, line 3: no JSON",
            "standard input, line 4: longer than",
            "standard input, line 5: no JSON",
        ];
        assert_eq!(problems.len(), starts.len());
        assert!(problems.iter().zip(starts).all(|(said, start)| said.starts_with(start)));
    }
}
