//! Style, scripts and the vendored chart library, built into the program.

use crate::api::problem::Problem;
use axum::extract::Path;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::LazyLock;

/// A file that the pages load.
struct Asset {
    name: &'static str,
    kind: &'static str,
    text: &'static str,
}

macro_rules! asset {
    ($name:literal, $kind:literal, $file:literal) => {
        Asset { name: $name, kind: $kind, text: include_str!(concat!("assets/", $file)) }
    };
}

static ASSETS: [Asset; 12] = [
    asset!("base.css", "text/css; charset=utf-8", "base.css"),
    asset!("parts.css", "text/css; charset=utf-8", "parts.css"),
    asset!("theme.js", "text/javascript; charset=utf-8", "theme.js"),
    asset!("live.js", "text/javascript; charset=utf-8", "live.js"),
    asset!("acts.js", "text/javascript; charset=utf-8", "acts.js"),
    asset!("charts.js", "text/javascript; charset=utf-8", "charts.js"),
    asset!("trends.js", "text/javascript; charset=utf-8", "trends.js"),
    asset!("notes.js", "text/javascript; charset=utf-8", "notes.js"),
    asset!("map.js", "text/javascript; charset=utf-8", "map.js"),
    asset!("icon.svg", "image/svg+xml", "icon.svg"),
    asset!("uPlot.iife.min.js", "text/javascript; charset=utf-8", "vendor/uPlot.iife.min.js"),
    asset!("uPlot.min.css", "text/css; charset=utf-8", "vendor/uPlot.min.css"),
];

/// Changes whenever a file does, so that browsers may keep them for as long as they like.
static VERSION: LazyLock<String> = LazyLock::new(|| {
    let mut hasher = DefaultHasher::new();
    ASSETS.iter().for_each(|asset| asset.text.hash(&mut hasher));
    format!("{:016x}", hasher.finish())
});

/// Version of all files together.
pub(super) fn version() -> &'static str {
    &VERSION
}

/// Where a page finds a file.
pub(super) fn path(name: &str) -> String {
    format!("/assets/{name}?v={}", *VERSION)
}

pub(super) async fn asset(Path(name): Path<String>) -> Response {
    serve(&name)
}

pub(super) async fn favicon() -> Response {
    serve("icon.svg")
}

fn serve(name: &str) -> Response {
    let Some(asset) = ASSETS.iter().find(|asset| asset.name == name) else {
        return Problem::new(StatusCode::NOT_FOUND, format!("there is no asset \"{name}\"")).into_response();
    };
    let headers = [
        (header::CONTENT_TYPE, asset.kind),
        (header::CACHE_CONTROL, "public, max-age=31536000, immutable"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ];
    (headers, asset.text).into_response()
}
