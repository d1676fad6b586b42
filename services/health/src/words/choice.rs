//! Which language somebody reads: what the address asks for, then what was chosen before, then what the browser says.

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;

/// Keeps a choice.
const COOKIE: &str = "lang";
/// A choice is kept for a year, s.
const KEPT_S: u32 = 31_536_000;

/// A language of the pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Language {
    /// British English.
    #[default]
    English,
    /// German.
    German,
}

impl Language {
    /// All of them, with their own names.
    pub const ALL: [(Self, &'static str); 2] = [(Self::English, "English"), (Self::German, "Deutsch")];

    /// Its tag, as in `<html lang>`.
    #[must_use]
    pub const fn tag(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
        }
    }

    /// From a tag such as `de` or `de-AT`.
    #[must_use]
    pub fn parse(tag: &str) -> Option<Self> {
        let first = tag.split(['-', '_']).next().unwrap_or_default();
        Self::ALL.into_iter().map(|(one, _)| one).find(|one| first.eq_ignore_ascii_case(one.tag()))
    }

    /// The language of a page: by its address, by what was chosen before, by the browser.
    pub(crate) fn of_page(query: Option<&str>, headers: &HeaderMap) -> Self {
        asked(query).or_else(|| kept(headers)).unwrap_or_else(|| Self::accepted(headers))
    }

    /// The language that the header `Accept-Language` likes best; English where it names none that there is.
    pub(crate) fn accepted(headers: &HeaderMap) -> Self {
        let values = headers.get_all(header::ACCEPT_LANGUAGE).iter().filter_map(|value| value.to_str().ok());
        let mut best = (0.0, Self::English);
        for range in values.flat_map(|value| value.split(',')) {
            let mut parts = range.split(';').map(str::trim);
            let language = parts.next().and_then(Self::parse);
            let weight = parts.find_map(|part| part.strip_prefix("q=")).map_or(Ok(1.0), str::parse);
            if let (Some(language), Ok(weight)) = (language, weight)
                && weight > best.0
            {
                best = (weight, language);
            }
        }
        best.1
    }
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
        Language::accepted(request.headers())
    } else {
        Language::of_page(request.uri().query(), request.headers())
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
    fn the_header_is_weighed() {
        for (accept, language) in [
            ("de-DE,de;q=0.9,en;q=0.8", Language::German),
            ("en-GB,en;q=0.9,de;q=0.8", Language::English),
            ("fr-FR,fr;q=0.9", Language::English),
            ("fr, de;q=0.3", Language::German),
            ("de;q=0", Language::English),
            ("", Language::English),
        ] {
            let mut headers = HeaderMap::new();
            headers.insert(header::ACCEPT_LANGUAGE, HeaderValue::from_static(accept));
            assert_eq!(Language::accepted(&headers), language, "{accept:?}");
        }
    }

    #[test]
    fn the_address_and_the_choice_are_read() {
        assert_eq!(asked(Some("range=900&lang=de")), Some(Language::German));
        assert_eq!(asked(Some("lang=xx")), None);
        let mut headers = HeaderMap::new();
        headers.insert(header::COOKIE, HeaderValue::from_static("a=b; lang=de"));
        assert_eq!(kept(&headers), Some(Language::German));
    }
}
