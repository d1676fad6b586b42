//! The table over HTTP, sent while it is read.

use super::table::{ExportError, Form, Wanted};
use super::turn::Turn;
use super::write::write;
use crate::api::problem::Problem;
use crate::history::consist::Consist;
use crate::history::query;
use crate::history::routes::{available, wagon};
use crate::shared::Shared;
use crate::web::accept::quality;
use crate::web::encode::takes_gzip;
use crate::web::query::{parameters, refuse, value};
use axum::body::{Body, Bytes};
use axum::extract::{RawQuery, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use futures_util::stream;
use railgrip_history::Reader;
use std::io::{self, Write};
use std::time::Duration;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// Pieces of the answer that wait for a slow receiver.
const WAITING_PIECES: usize = 8;
/// How often it is looked whether a slow receiver has made room.
const POLL: Duration = Duration::from_millis(5);
/// Least length of a piece.
const PIECE_BYTES: usize = 32 * 1024;
/// Without `from`, so much before `to`, s.
const USUAL_SPAN_S: i64 = 86_400;

/// Stored indicators as one table, CSV or Parquet, for pandas, DuckDB and spreadsheets.
///
/// One row a wagon and step: `time`, `wagon` (where it runs now; empty for a vehicle that is not in the train), `vehicle` (its
/// number, where it has one), `samples`, then for each indicator `NAME`, `NAME_low`, `NAME_high` where an
/// interval is stored, `NAME_min`, `NAME_max`. Dots in names become `_`. Steps without samples have no row.
#[utoipa::path(get, path = "/api/v1/history/export", tag = "history",
    params(
        ("format" = Option<String>, Query, description = "`csv` or `parquet`; default: by the header `Accept`, else csv",
            pattern = "^(csv|parquet)$"),
        ("wagon" = Option<String>, Query, description = "Numbers of wagons, separated by commas; default: all",
            pattern = "^[1-9][0-9]{0,2}(,[1-9][0-9]{0,2})*$"),
        ("from" = Option<String>, Query, description = "Begin: RFC 3339, Unix seconds, or an age such as `7d`; default: a day before `to`",
            pattern = "instant"),
        ("to" = Option<String>, Query, description = "End, exclusive: RFC 3339, Unix seconds, an age such as `7d`, or `now`, the default",
            pattern = "instant"),
        ("step" = Option<String>, Query, description = "Width of a step: seconds, or a number with s, m, h or d; default 60",
            pattern = "step"),
        ("fields" = Option<String>, Query, pattern = "fields", description = "Indicators, separated by commas; default: all"),
    ),
    responses(
        (status = 200, description = "The table", content(
            (String = "text/csv"), (String = "application/vnd.apache.parquet"))),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
        (status = 404, description = "There is no such wagon, or no history"),
        (status = 409, description = "`from` and `to` contradict each other"),
        (status = 406, description = "Neither form is acceptable"),
        (status = 503, description = "The database refuses, or another export is under way"),
    ))]
pub(crate) async fn export(
    State(shared): State<Shared>,
    headers: HeaderMap,
    RawQuery(query): RawQuery,
) -> Result<Response, Problem> {
    let pairs = parameters(query.as_deref(), &["format", "wagon", "from", "to", "step", "fields"])?;
    let form = form(&pairs, &headers)?;
    let wagons = match value(&pairs, "wagon") {
        None => Vec::new(),
        Some(text) => text.split(',').map(|one| wagon(&shared, one)).collect::<Result<_, _>>()?,
    };
    let now_s = shared.now().unix_ns.div_euclid(1_000_000_000);
    let (from_s, to_s) = query::ends(&pairs, now_s, USUAL_SPAN_S)?;
    let step_s = value(&pairs, "step").map_or(Ok(60), |text| query::duration("step", text))?;
    let fields = value(&pairs, "fields").map(|text| text.split(',').map(str::to_owned).collect());
    let history = available(&shared)?;
    let mut wanted = Wanted { wagons, consist: Consist::default(), fields, from_s, to_s, step_s };
    if let Some(fields) = &wanted.fields {
        crate::history::routes::check_fields(&history, fields)?;
    }
    let turn = history.exports.take().ok_or_else(|| {
        let detail = "another export is under way; try again when it is done";
        Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail)
    })?;
    let refused =
        |error: &dyn std::fmt::Display| Problem::new(StatusCode::SERVICE_UNAVAILABLE, error.to_string());
    let open = move || {
        let reader = history.open()?;
        let consist = history.consist(&reader)?;
        Ok::<_, railgrip_history::HistoryError>((reader, consist))
    };
    let opened = tokio::task::spawn_blocking(open).await;
    let (reader, consist) = opened.map_err(|error| refused(&error))?.map_err(|error| refused(&error))?;
    wanted.consist = consist;
    let gzip = form == Form::Csv && takes_gzip(&headers);
    let (sender, receiver) = channel(WAITING_PIECES);
    tokio::task::spawn_blocking(move || {
        let pieces = Pieces { sender: sender.clone(), piece: Vec::with_capacity(PIECE_BYTES), turn };
        if let Err(error) = run(&reader, &wanted, form, gzip, pieces) {
            // What has been sent cannot be taken back; a connection that breaks off says that it is not whole.
            tracing::debug!(%error, "an export broke off");
            // The turn is over by now, so that waiting for a slow receiver holds nobody up.
            let _ = sender.blocking_send(Err(io::Error::other(error.to_string())));
        }
    });
    Ok(answer(form, gzip, from_s, to_s, receiver))
}

fn answer(form: Form, gzip: bool, from_s: i64, to_s: i64, receiver: Receiver<io::Result<Bytes>>) -> Response {
    let pieces =
        stream::unfold(receiver, |mut receiver| async move { Some((receiver.recv().await?, receiver)) });
    let mut response = Body::from_stream(pieces).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(form.media_type()));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-cache"));
    headers.insert(header::VARY, HeaderValue::from_static("Accept, Accept-Encoding"));
    let name = format!("attachment; filename=\"railgrip-{from_s}-{to_s}.{}\"", form.word());
    if let Ok(name) = HeaderValue::from_str(&name) {
        headers.insert(header::CONTENT_DISPOSITION, name);
    }
    if gzip {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    response
}

fn run(reader: &Reader, wanted: &Wanted, form: Form, gzip: bool, to: Pieces) -> Result<(), ExportError> {
    if gzip {
        let mut packer = GzEncoder::new(to, Compression::fast());
        write(reader, wanted, form, &mut packer)?;
        packer.finish()?.flush()?;
    } else {
        write(reader, wanted, form, to)?;
    }
    Ok(())
}

/// Hands what is written to the connection, in pieces; waits while the receiver is slow.
struct Pieces {
    sender: Sender<io::Result<Bytes>>,
    piece: Vec<u8>,
    turn: Turn,
}

impl Write for Pieces {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.piece.extend_from_slice(bytes);
        if self.piece.len() >= PIECE_BYTES {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.piece.is_empty() {
            return Ok(());
        }
        let piece = std::mem::replace(&mut self.piece, Vec::with_capacity(PIECE_BYTES));
        let length = piece.len();
        let mut waits = Ok(piece.into());
        loop {
            if self.turn.is_over() {
                let why = "another export waits, and this receiver is slow";
                return Err(io::Error::new(io::ErrorKind::TimedOut, why));
            }
            waits = match self.sender.try_send(waits) {
                Ok(()) => break,
                Err(TrySendError::Closed(_)) => {
                    return Err(io::Error::new(io::ErrorKind::BrokenPipe, "the receiver is gone"));
                }
                Err(TrySendError::Full(waits)) => waits,
            };
            std::thread::sleep(POLL);
        }
        self.turn.sent(length);
        Ok(())
    }
}

/// What `format` says, else what `Accept` prefers, else CSV.
fn form(pairs: &[(String, String)], headers: &HeaderMap) -> Result<Form, Problem> {
    if let Some(word) = value(pairs, "format") {
        return Form::of_word(word).ok_or_else(|| refuse("format", word, "csv or parquet"));
    }
    let wish = |form: Form| {
        let kind = form.media_type().split(';').next().unwrap_or_default();
        quality(headers, header::ACCEPT, kind).unwrap_or(1.0)
    };
    // Parquet only for those who ask for it more than for CSV.
    let (csv, parquet) = (wish(Form::Csv), wish(Form::Parquet));
    if csv == 0.0 && parquet == 0.0 {
        let detail = "the header `Accept` allows neither text/csv nor application/vnd.apache.parquet";
        return Err(Problem::new(StatusCode::NOT_ACCEPTABLE, detail));
    }
    Ok(if parquet > csv { Form::Parquet } else { Form::Csv })
}
