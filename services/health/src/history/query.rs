//! What a request for stored data asks: `from`, `to`, `step`, `fields`.

use crate::api::problem::Problem;
use crate::time;
use crate::web::query::{refuse, value};
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
        let [from, to] = [from_s, to_s].map(time::rfc3339_s);
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
