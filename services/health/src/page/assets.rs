//! Style, scripts and the vendored chart library, built into the program.

use crate::api::problem::Problem;
use crate::web::encode::takes_gzip;
use axum::extract::Path;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use railgrip_words::{Language, in_language};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::sync::LazyLock;

/// A file that the pages load.
struct Asset {
    name: &'static str,
    kind: &'static str,
    text: String,
    /// The text as small as gzip makes it: it never changes, so that the effort is made once.
    packed: Vec<u8>,
}

impl Asset {
    fn new(name: &'static str, kind: &'static str, text: &str) -> Self {
        let text = if name.starts_with("uPlot") { text.to_owned() } else { bare(text) };
        let packed = packed(&text);
        Self { name, kind, text, packed }
    }
}

macro_rules! files {
    ($($file:literal),+) => {
        concat!($(include_str!(concat!("assets/", $file)), "\n"),+)
    };
}

macro_rules! asset {
    ($name:literal, $kind:expr, $($file:literal),+) => {
        Asset::new($name, $kind, files!($($file),+))
    };
}

const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Every sentence that the scripts write.
const WORDS: &str = files!("words.js");

/// What every page runs behind its words.
const EVERY_PAGE: &str = files!("clock.js", "live.js", "acts.js", "table.js", "map.js");

/// The script of every page. The words alone are translated: elsewhere `"watch"` is the name of a colour or a grade.
fn page_script(name: &'static str, language: Language) -> Asset {
    Asset::new(name, SCRIPT, &(in_language(WORDS, language) + EVERY_PAGE))
}

/// Without what only who writes them reads: indents and lines that are a comment.
fn bare(text: &str) -> String {
    let mut bare = String::with_capacity(text.len());
    for line in text.lines().map(str::trim_start) {
        let comment = line.starts_with("// ")
            || ((line.starts_with("/*") && line.ends_with("*/")) && line.matches("*/").count() == 1);
        if !comment && !line.is_empty() {
            bare.push_str(line);
            bare.push('\n');
        }
    }
    bare
}

/// Files that a page needs together come as one, so that a page on a slow line asks for few.
static ASSETS: LazyLock<Vec<Asset>> = LazyLock::new(|| {
    vec![
        asset!(
            "style.css",
            "text/css; charset=utf-8",
            "base.css",
            "parts.css",
            "tables.css",
            "charts.css",
            "print.css",
            "vendor/uPlot.min.css"
        ),
        asset!("theme.js", SCRIPT, "theme.js"),
        page_script("page.js", Language::English),
        page_script("page.de.js", Language::German),
        asset!("charts.js", SCRIPT, "plot.js", "charts.js", "view.js", "trends.js", "wagon.js", "notes.js"),
        asset!("settings.js", SCRIPT, "settings.js", "receivers.js"),
        asset!("uPlot.iife.min.js", SCRIPT, "vendor/uPlot.iife.min.js"),
        asset!("grades.svg", "image/svg+xml", "grades.svg"),
        asset!("icon.svg", "image/svg+xml", "icon.svg"),
        asset!("icon-watch.svg", "image/svg+xml", "icon-watch.svg"),
        asset!("icon-act.svg", "image/svg+xml", "icon-act.svg"),
    ]
});

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

fn packed(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    // Writing to memory fails for want of memory alone; the file then goes out as it is.
    match encoder.write_all(text.as_bytes()) {
        Ok(()) => encoder.finish().unwrap_or_default(),
        Err(_) => Vec::new(),
    }
}

pub(super) async fn asset(Path(name): Path<String>, headers: HeaderMap) -> Response {
    serve(&name, takes_gzip(&headers))
}

pub(super) async fn favicon() -> Response {
    serve("icon.svg", false)
}

fn serve(name: &str, gzip: bool) -> Response {
    let Some(asset) = ASSETS.iter().find(|asset| asset.name == name) else {
        return Problem::new(StatusCode::NOT_FOUND, format!("there is no asset \"{name}\"")).into_response();
    };
    let headers = [
        (header::CONTENT_TYPE, asset.kind),
        (header::CACHE_CONTROL, "public, max-age=31536000, immutable"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ];
    if gzip && !asset.packed.is_empty() {
        let coding = [(header::CONTENT_ENCODING, "gzip"), (header::VARY, "Accept-Encoding")];
        return (headers, coding, asset.packed.as_slice()).into_response();
    }
    (headers, asset.text.as_str()).into_response()
}
