//! The standard input as a source: one JSON object a line, with the columns of a recording and the wagon's number.
//!
//! `{"wagon": 1, "t_s": 0.01, "v_m_s": 22.4, "omega_f_rad_s": 51.2, "omega_r_rad_s": 51.1, "f_perp_f_n": 0, ...}`
//! A value that is absent or null is missing. A line that is wrong is refused with its number; nothing ends because of
//! it.

use super::Inlet;
use railgrip_recording::{Quantity, Row};
use serde_json::Value;
use std::io::BufRead;

/// The longest line, bytes: more is no sample.
const LONGEST_LINE: usize = 64 * 1024;

/// Reads lines to their end and puts their rows into the inlet; `name` stands for the source in messages.
pub(super) fn read(mut input: impl BufRead, name: &str, inlet: &Inlet) {
    let mut line = Vec::new();
    for number in 1_u64.. {
        line.clear();
        let item = match read_line(&mut input, &mut line) {
            Ok(None) => return,
            Ok(Some(false)) => Err(format!("longer than {LONGEST_LINE} bytes")),
            Ok(Some(true)) if line.iter().all(u8::is_ascii_whitespace) => continue,
            Ok(Some(true)) => parse_line(&line, inlet.wheelsets()),
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

/// The wagon (from 0) and the row of one line; `wheelsets` of each wagon.
///
/// # Errors
/// In words: what is wrong, and what is allowed.
pub fn parse_line(line: &[u8], wheelsets: &[usize]) -> Result<(usize, Row), String> {
    let value: Value = serde_json::from_slice(line).map_err(|error| format!("no JSON: {error}"))?;
    let Value::Object(object) = value else { return Err("no JSON object".to_owned()) };
    let wagon = match object.get("wagon") {
        None if wheelsets.len() == 1 => 0,
        None => return Err("\"wagon\" is missing".to_owned()),
        Some(number) => number
            .as_u64()
            .and_then(|number| usize::try_from(number).ok()?.checked_sub(1))
            .filter(|wagon| *wagon < wheelsets.len())
            .ok_or_else(|| format!("\"wagon\" is {number}, allowed is 1 to {}", wheelsets.len()))?,
    };
    let mut row = Row::default();
    let count = wheelsets[wagon];
    let mut known = usize::from(object.contains_key("wagon"));
    for quantity in Quantity::ALL {
        let places = if quantity.per_wheelset() { count } else { 1 };
        for wheelset in 0..places {
            let name = quantity.column(wheelset, count);
            let Some(value) = object.get(&name) else { continue };
            known += 1;
            if !value.is_null() {
                *row.get_mut(quantity, wheelset) = value
                    .as_f64()
                    .ok_or_else(|| format!("\"{name}\" is {value}, allowed is a number or null"))?;
            }
        }
    }
    if known < object.len() {
        return Err(unknown_key(&object, count));
    }
    if row.t_s.is_nan() {
        return Err("\"t_s\" is missing".to_owned());
    }
    Ok((wagon, row))
}

fn unknown_key(object: &serde_json::Map<String, Value>, count: usize) -> String {
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

    #[test]
    fn a_line_is_a_sample() {
        let line = br#"{"wagon": 2, "t_s": 0.5, "v_m_s": 20, "omega_f_rad_s": 45.5, "omega_r_rad_s": null}"#;
        let (wagon, row) = parse_line(line, &[2, 2]).unwrap();
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
            (
                r#"{"wagon": 1, "t_s": 1, "speed": 3}"#,
                "unknown key \"speed\", allowed are wagon, t_s, v_m_s, omega_f",
            ),
        ];
        for (line, words) in cases {
            let said = parse_line(line.as_bytes(), &[2, 2]).unwrap_err();
            assert!(said.starts_with(words), "{line}: {said}");
        }
    }

    #[test]
    fn bad_lines_are_numbered_and_nothing_ends_because_of_them() {
        let mut text = b"{\"t_s\": 1, \"v_m_s\": 5}\n\nnonsense\n".to_vec();
        text.extend(vec![b'x'; LONGEST_LINE + 1]);
        text.extend(b"\n\xff\xfe\n{\"t_s\": 2, \"v_m_s\": 6}");
        let vehicle = toml::from_str(include_str!("../../../../config/vehicle.toml")).unwrap();
        let mut live = Live::new("test", &[vehicle], &[PlantKind::Wagon]);
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
