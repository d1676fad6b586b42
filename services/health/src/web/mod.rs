//! What HTTP asks of every route of the interface, whatever it serves.
//!
//! * An answer in a form that the client does not take is 406; a body in a form that we do not take is 415.
//! * An answer that can be kept has an `ETag`, and asking for it again costs a line instead of a body (304).
//! * Long answers are compressed for whoever says that they take gzip.
//! * Sentences come in the language that is asked for (`Accept-Language`).
//! * A long answer holds its room in memory until its reader has taken it.
//! * Every refusal is `application/problem+json`, also those that the libraries below us make.

pub(crate) mod accept;
pub(crate) mod encode;
pub(crate) mod json;
pub(crate) mod language;
pub(crate) mod pages;
pub(crate) mod query;
pub(crate) mod room;
mod translate;

use axum::Router;
use axum::middleware::from_fn;

/// Puts all this around the routes.
pub(crate) fn around(router: Router) -> Router {
    let router = router.layer(from_fn(translate::translate)).layer(from_fn(encode::encode));
    router.layer(from_fn(accept::negotiate)).layer(from_fn(language::choose))
}
