//! Sentences of the interface in the language that a program asks for by `Accept-Language`; English for all others.

use axum::body::{Body, to_bytes};
use axum::extract::Request;
use axum::http::{HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;
use railgrip_words::{Language, reword, speak};
use serde_json::Value;

/// Fields that hold sentences for people; every other text is a word of the interface and stays.
const SENTENCES: [&str; 7] = ["reason", "reasons", "advice", "text", "detail", "title", "faulty_sensors"];
/// No answer with sentences is longer, bytes.
const LONGEST: usize = 64 << 20;

/// Puts the sentences of an answer into the language that was asked for.
pub(crate) async fn translate(request: Request, next: Next) -> Response {
    let language = request.extensions().get::<Language>().copied().unwrap_or_default();
    let of_interface = request.uri().path().starts_with("/api/");
    let response = next.run(request).await;
    let kind = response.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    let is_json = kind.is_some_and(|kind| kind.starts_with("application/") && kind.contains("json"));
    if !of_interface || !is_json {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    parts.headers.append(header::VARY, HeaderValue::from_static("Accept-Language"));
    if language == Language::English {
        return Response::from_parts(parts, body);
    }
    let Ok(bytes) = to_bytes(body, LONGEST).await else {
        return Response::from_parts(parts, Body::empty());
    };
    let Ok(mut value) = serde_json::from_slice::<Value>(&bytes) else {
        return Response::from_parts(parts, Body::from(bytes));
    };
    speak(language, || sentences(&mut value, false));
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.insert(header::CONTENT_LANGUAGE, HeaderValue::from_static(language.tag()));
    Response::from_parts(parts, Body::from(value.to_string()))
}

fn sentences(value: &mut Value, is_sentence: bool) {
    match value {
        Value::String(text) if is_sentence => *text = reword(text),
        Value::Array(all) => all.iter_mut().for_each(|one| sentences(one, is_sentence)),
        Value::Object(fields) => {
            fields.iter_mut().for_each(|(name, one)| sentences(one, SENTENCES.contains(&name.as_str())));
        }
        _ => {}
    }
}
