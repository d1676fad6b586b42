//! The query of a request: names and values, and how wrong ones are refused.

use crate::api::problem::Problem;
use axum::http::StatusCode;

/// A value of the query that is not allowed, with what is.
pub(crate) fn refuse(parameter: &str, value: &str, allowed: &str) -> Problem {
    let detail = format!("query parameter `{parameter}` is \"{value}\"; allowed is {allowed}");
    Problem::new(StatusCode::BAD_REQUEST, detail)
}

/// Pairs of a query; what is not listed in `allowed`, or stands twice, is refused.
pub(crate) fn parameters(query: Option<&str>, allowed: &[&str]) -> Result<Vec<(String, String)>, Problem> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for pair in query.unwrap_or_default().split('&').filter(|pair| !pair.is_empty()) {
        let (name, value) = pair.split_once('=').unwrap_or((pair, ""));
        let (name, value) = (decoded(name), decoded(value));
        if !allowed.contains(&name.as_str()) {
            let listed = allowed.join("`, `");
            let detail = format!("there is no query parameter `{name}` here; allowed are `{listed}`");
            return Err(Problem::new(StatusCode::BAD_REQUEST, detail));
        }
        if pairs.iter().any(|(other, _)| *other == name) {
            return Err(refuse(&name, &value, "one value, and it was given twice"));
        }
        pairs.push((name, value));
    }
    Ok(pairs)
}

/// Undoes percent encoding; what is no UTF-8 then is replaced and will be refused as a value.
fn decoded(text: &str) -> String {
    let mut bytes = text.bytes();
    let mut plain = Vec::with_capacity(text.len());
    while let Some(byte) = bytes.next() {
        let hex = |digit: u8| char::from(digit).to_digit(16);
        match byte {
            b'+' => plain.push(b' '),
            b'%' => {
                let mut ahead = bytes.clone();
                match (ahead.next().and_then(hex), ahead.next().and_then(hex)) {
                    (Some(high), Some(low)) => {
                        plain.push((high * 16 + low) as u8);
                        bytes = ahead;
                    }
                    _ => plain.push(b'%'),
                }
            }
            other => plain.push(other),
        }
    }
    String::from_utf8_lossy(&plain).into_owned()
}

/// The value of that name, if there is one.
pub(crate) fn value<'a>(pairs: &'a [(String, String)], name: &str) -> Option<&'a str> {
    pairs.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_str())
}
