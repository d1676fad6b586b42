//! What a request for stored data asks: `from`, `to`, `step`, `fields`.

use crate::problem::Problem;
use crate::time;
use axum::http::StatusCode;

/// Most steps of one answer.
pub const MOST_STEPS: i64 = 20_000;
/// Steps of an answer that asks for none in particular, at most.
const USUAL_STEPS: i64 = 500;
/// Without `from`, so much before `to`, s.
const USUAL_SPAN_S: i64 = 3600;
/// Steps that read well.
const STEPS_S: [i64; 14] = [1, 2, 5, 10, 30, 60, 300, 600, 1800, 3600, 10_800, 21_600, 43_200, 86_400];

/// A span of time in steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// Begin of the first step, Unix s, a multiple of the step.
    pub from_s: i64,
    /// End, Unix s, exclusive.
    pub to_s: i64,
    /// Width of a step, s.
    pub step_s: i64,
}

impl Span {
    /// Steps of the span.
    #[must_use]
    pub const fn steps(&self) -> usize {
        ((self.to_s - self.from_s + self.step_s - 1) / self.step_s) as usize
    }
}

/// Values that are fine one by one, but contradict each other: a conflict, while 400 stays for what no description of
/// the interface allows.
fn contradict(detail: String) -> Problem {
    Problem::new(StatusCode::CONFLICT, detail)
}

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

pub(crate) fn value<'a>(pairs: &'a [(String, String)], name: &str) -> Option<&'a str> {
    pairs.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_str())
}

/// An instant as [`time::instant_s`] takes it.
pub(crate) fn instant(name: &str, text: &str, now_unix_s: i64) -> Result<i64, Problem> {
    // A plus that was not encoded arrives as a space.
    let repaired = text.replace(' ', "+");
    time::instant_s(&repaired, now_unix_s).ok_or_else(|| refuse(name, text, time::INSTANT_ALLOWED))
}

/// A span as [`time::span_s`] takes it.
pub(crate) fn duration(name: &str, text: &str) -> Result<i64, Problem> {
    time::span_s(text).ok_or_else(|| refuse(name, text, time::SPAN_ALLOWED))
}

/// Begin and end that `from` and `to` ask for; without `from`, `usual_s` before the end.
pub(crate) fn ends(pairs: &[(String, String)], now_unix_s: i64, usual_s: i64) -> Result<(i64, i64), Problem> {
    let get = |name| value(pairs, name);
    let to_s = get("to").map(|text| instant("to", text, now_unix_s)).transpose()?;
    let from_s = get("from").map(|text| instant("from", text, now_unix_s)).transpose()?;
    let to_s = to_s.unwrap_or_else(|| (now_unix_s + 1).max(from_s.unwrap_or(0) + 1));
    let from_s = from_s.unwrap_or_else(|| (to_s - usual_s).max(0));
    if from_s >= to_s {
        let [from, to] = [from_s, to_s].map(|unix_s| time::rfc3339(unix_s * 1_000_000_000));
        return Err(contradict(format!(
            "`from` is {from}; allowed is an instant before `to`, which is {to}"
        )));
    }
    Ok((from_s, to_s))
}

/// The span that `from`, `to` and `step` ask for.
pub(crate) fn span(pairs: &[(String, String)], now_unix_s: i64) -> Result<Span, Problem> {
    let get = |name| value(pairs, name);
    let (from_s, to_s) = ends(pairs, now_unix_s, USUAL_SPAN_S)?;
    let step_s = match get("step") {
        Some(text) => duration("step", text)?,
        None => {
            let fits = |step: &i64| (to_s - from_s) / step <= USUAL_STEPS;
            STEPS_S.into_iter().find(fits).unwrap_or(((to_s - from_s) / USUAL_STEPS / 86_400 + 1) * 86_400)
        }
    };
    let span = Span { from_s: from_s.div_euclid(step_s) * step_s, to_s, step_s };
    if span.steps() as i64 > MOST_STEPS {
        let least = (to_s - from_s) / MOST_STEPS + 1;
        return Err(contradict(format!(
            "`step` is {step_s} s; allowed are {least} s and more for this span: an answer has {MOST_STEPS} steps at most"
        )));
    }
    Ok(span)
}
