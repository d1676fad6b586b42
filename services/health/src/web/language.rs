//! Which language somebody reads: what the address asks for, then what was chosen before, then what the browser says.

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;
use railgrip_words::Language;

/// Keeps a choice.
const COOKIE: &str = "lang";
/// A choice is kept for a year, s.
const KEPT_S: u32 = 31_536_000;

/// The language of a page: by its address, by what was chosen before, by the browser.
pub(crate) fn of_page(query: Option<&str>, headers: &HeaderMap) -> Language {
    asked(query).or_else(|| kept(headers)).unwrap_or_else(|| accepted(headers))
}

/// The language that the header `Accept-Language` likes best.
fn accepted(headers: &HeaderMap) -> Language {
    let values = headers.get_all(header::ACCEPT_LANGUAGE).iter();
    Language::accepted(values.filter_map(|value| value.to_str().ok()))
}

/// `lang` of the query.
fn asked(query: Option<&str>) -> Option<Language> {
    let mut pairs = query.unwrap_or_default().split('&').filter_map(|pair| pair.split_once('='));
    pairs.find(|(name, _)| *name == COOKIE).and_then(|(_, tag)| Language::parse(tag))
}

/// What was chosen before.
fn kept(headers: &HeaderMap) -> Option<Language> {
    let all = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    all.flat_map(|cookies| cookies.split(';')).find_map(|cookie| {
        let (name, tag) = cookie.trim().split_once('=')?;
        (name == COOKIE).then(|| Language::parse(tag)).flatten()
    })
}

/// Finds the language of a request, for handlers that take `Extension<Language>`, and keeps what the address asks for.
/// Programs have no cookies of ours: for the interface only what they say themselves counts.
pub(crate) async fn choose(mut request: Request, next: Next) -> Response {
    let asked = asked(request.uri().query());
    let of_interface = request.uri().path().starts_with("/api/");
    let language = if of_interface {
        accepted(request.headers())
    } else {
        of_page(request.uri().query(), request.headers())
    };
    request.extensions_mut().insert(language);
    let mut response = next.run(request).await;
    if let Some(asked) = asked.filter(|_| !of_interface) {
        let text = format!("{COOKIE}={}; Path=/; Max-Age={KEPT_S}; SameSite=Lax", asked.tag());
        if let Ok(value) = HeaderValue::from_str(&text) {
            response.headers_mut().append(header::SET_COOKIE, value);
        }
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_address_and_the_choice_are_read() {
        assert_eq!(asked(Some("range=900&lang=de")), Some(Language::German));
        assert_eq!(asked(Some("lang=xx")), None);
        let mut headers = HeaderMap::new();
        headers.insert(header::COOKIE, HeaderValue::from_static("a=b; lang=de"));
        assert_eq!(kept(&headers), Some(Language::German));
    }
}
