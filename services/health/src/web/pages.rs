//! Long lists, page by page: `limit` and `after` in the query, the way to the next page in the header `Link` (RFC 8288).

use crate::api::problem::Problem;
use crate::web::query::{refuse, value};
use axum::http::{HeaderValue, header};
use axum::response::Response;

/// Most entries of one page.
pub(crate) const MOST: usize = 1000;
/// Entries have no larger numbers: they are 64-bit numbers with a sign elsewhere.
const LAST_NUMBER: u64 = i64::MAX as u64;

/// The entries that a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Page {
    /// At most so many.
    pub limit: usize,
    /// Those behind the entry with this number.
    pub after: Option<u64>,
}

impl Page {
    /// What `limit` and `after` say.
    pub(crate) fn of(pairs: &[(String, String)], usual: usize) -> Result<Self, Problem> {
        let whole =
            |text: &str| text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse::<u64>().ok());
        let limit = match value(pairs, "limit") {
            None => usual,
            Some(text) => whole(text)
                .flatten()
                .map(|limit| limit as usize)
                .filter(|limit| (1..=MOST).contains(limit))
                .ok_or_else(|| refuse("limit", text, &format!("1 to {MOST}")))?,
        };
        let after = match value(pairs, "after") {
            None => None,
            Some(text) => {
                let number = whole(text).flatten().filter(|number| *number <= LAST_NUMBER);
                let allowed = "the number of the last entry of the page before";
                Some(number.ok_or_else(|| refuse("after", text, allowed))?)
            }
        };
        Ok(Self { limit, after })
    }

    /// The query of the page behind the entry `last`, all other parameters as they were.
    pub(crate) fn next(self, path: &str, pairs: &[(String, String)], last: u64) -> String {
        let mut next = format!("{path}?limit={}&after={last}", self.limit);
        for (name, value) in pairs.iter().filter(|(name, _)| name != "limit" && name != "after") {
            next.push('&');
            next.push_str(name);
            next.push('=');
            next.push_str(&encoded(value));
        }
        next
    }
}

/// Shows the way to the next page.
pub(crate) fn link(mut response: Response, next: Option<&str>) -> Response {
    if let Some(next) = next
        && let Ok(value) = HeaderValue::from_str(&format!("<{next}>; rel=\"next\""))
    {
        response.headers_mut().insert(header::LINK, value);
    }
    response
}

/// Text as the value of a query.
fn encoded(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_' | b'.' | b'~' | b':') {
            plain.push(char::from(byte));
        } else {
            plain.push_str(&format!("%{byte:02X}"));
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(pairs: &[(&str, &str)]) -> Result<Page, Problem> {
        let pairs: Vec<_> =
            pairs.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        Page::of(&pairs, 100)
    }

    #[test]
    fn limits_are_checked_and_the_next_page_keeps_the_rest_of_the_query() {
        assert_eq!(page(&[]).ok(), Some(Page { limit: 100, after: None }));
        assert_eq!(page(&[("limit", "5"), ("after", "7")]).ok(), Some(Page { limit: 5, after: Some(7) }));
        for wrong in ["0", "1001", "-1", "+5", "", "x", "99999999999999999999999"] {
            assert!(page(&[("limit", wrong)]).is_err(), "{wrong:?}");
        }
        for wrong in ["x", "-1", "9223372036854775808"] {
            assert!(page(&[("after", wrong)]).is_err(), "{wrong}");
        }
        let pairs = [
            ("limit".to_owned(), "5".to_owned()),
            ("from".to_owned(), "2026-03-01T12:00:00+01:00".to_owned()),
        ];
        let next = Page { limit: 5, after: None }.next("/api/v1/events", &pairs, 17);
        assert_eq!(next, "/api/v1/events?limit=5&after=17&from=2026-03-01T12:00:00%2B01:00");
    }
}
