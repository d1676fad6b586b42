//! The description of the interface: OpenAPI 3.1 for programs. `/docs` shows the same to people.

use crate::time::{INSTANT, SPAN};
use railgrip_indicators::{IndicatorSpec, Table};
use serde_json::{Value, json};
use utoipa::openapi::OpenApi;

/// Words of somebody: no control characters but line feeds, and not only blanks.
const WORDS: &str = "^[^\\x00-\\x09\\x0b-\\x1f\\x7f-\\x9f]*[^\\s\\x00-\\x1f\\x7f-\\x9f][^\\x00-\\x09\\x0b-\\x1f\\x7f-\\x9f]*$";
/// The same on one line.
const LINE: &str = "^[^\\x00-\\x1f\\x7f-\\x9f]*[^\\s\\x00-\\x1f\\x7f-\\x9f][^\\x00-\\x1f\\x7f-\\x9f]*$";
/// Old paths that still work, with those that replace them.
pub(super) const DEPRECATED: [(&str, &str); 3] = [
    ("/api/v1/alerts/{id}/shelve", "/api/v1/alerts/{id}/silence"),
    ("/api/v1/alerts/{id}/unshelve", "/api/v1/alerts/{id}/unsilence"),
    ("/api/v1/delivery", "/api/v1/receivers"),
];
/// From the answer of one route to the next ones: path, method, and where in the answer their `id` is.
const LINKS: [(&str, &str, &str, &[&str]); 6] = [
    ("/api/v1/wagons", "get", "#/wagons/0/id", &["wagon", "history", "trends"]),
    ("/api/v1/alerts", "get", "#/alerts/0/id", &["alert", "acknowledge", "silence", "unsilence"]),
    ("/api/v1/alerts/{id}/acknowledge", "post", "#/id", &["alert", "unacknowledge", "silence"]),
    ("/api/v1/alerts/{id}/unacknowledge", "post", "#/id", &["alert", "acknowledge", "silence"]),
    ("/api/v1/alerts/{id}/silence", "post", "#/id", &["alert", "unsilence", "acknowledge"]),
    ("/api/v1/alerts/{id}/unsilence", "post", "#/id", &["alert", "silence"]),
];
/// What a refusal by access control looks like; the same for every route.
pub(super) const REFUSALS: [(&str, &str); 6] = [
    ("401", "A token is needed, or it is wrong"),
    ("403", "The role does not allow this"),
    ("406", "The header `Accept` does not allow the form of the answer"),
    ("421", "The service is not known by that name"),
    ("429", "Too many requests; the header `Retry-After` says when to try again"),
    ("503", "There was no answer in time"),
];

/// The description as JSON, with what access control adds to every route, where one route leads to others, and the form of
/// whatever is refused. `fields` are the indicators that the history holds, `table` those of wagons and wheelsets.
pub(crate) fn describe(api: &OpenApi, fields: &[String], table: Table) -> Vec<u8> {
    let mut api = serde_json::to_value(api).unwrap_or_default();
    add_figures(&mut api["components"]["schemas"]["WagonView"], of_wagon(table));
    add_figures(&mut api["components"]["schemas"]["WheelsetView"], table.of_wheelset());
    let fields = fields.join("|").replace('.', "\\.");
    expand_patterns(&mut api, &format!("^({fields})(,({fields}))*$"));
    api["components"]["securitySchemes"] = json!({
        "token": { "type": "http", "scheme": "bearer", "description":
            "Asked for where [http] token_file is set; made by `railgrip token add`. Roles: read, acknowledge, admin." }
    });
    // A token, or none where none is asked for.
    api["security"] = json!([{}, { "token": [] }]);
    let Some(paths) = api["paths"].as_object_mut() else { return Vec::new() };
    for (path, methods) in paths.iter_mut() {
        for method in methods.as_object_mut().into_iter().flat_map(|methods| methods.values_mut()) {
            if path.starts_with("/health/") {
                method["security"] = json!([]);
            }
            if DEPRECATED.iter().any(|(old, _)| old == path) {
                method["deprecated"] = true.into();
            }
            let Some(responses) = method["responses"].as_object_mut() else { continue };
            for (status, description) in REFUSALS {
                responses.entry(status).or_insert_with(|| json!({ "description": description }));
            }
            let refusals = responses.iter_mut().filter(|(status, _)| status.starts_with(['4', '5']));
            refusals.for_each(|(_, refusal)| {
                refusal.as_object_mut().map(|refusal| refusal.entry("content").or_insert_with(problem));
            });
        }
    }
    for (path, method, id, next) in LINKS {
        let link = |name: &&str| {
            (
                (*name).to_owned(),
                json!({ "operationId": name, "parameters": { "id": format!("$response.body{id}") } }),
            )
        };
        let links: serde_json::Map<String, Value> = next.iter().map(link).collect();
        api["paths"][path][method]["responses"]["200"]["links"] = links.into();
    }
    serde_json::to_vec(&api).unwrap_or_default()
}

/// Entries of the table that a wagon shows.
fn of_wagon(table: Table) -> impl Iterator<Item = &'static IndicatorSpec> {
    table.iter().filter(|spec| spec.judge.wagon.is_some() || spec.judge.among.is_some())
}

/// Adds the indicators to the form of a wagon or a wheelset, as its figures are written.
fn add_figures(schema: &mut Value, table: impl Iterator<Item = &'static IndicatorSpec>) {
    for spec in table {
        let form = json!({ "$ref": "#/components/schemas/Figure", "description": spec.meaning.definition });
        schema["properties"][spec.field()] = form;
        if let Some(required) = schema["required"].as_array_mut() {
            required.push(spec.field().into());
        }
    }
}

fn problem() -> Value {
    json!({ "application/problem+json": { "schema": { "$ref": "#/components/schemas/Problem" } } })
}

/// Puts the long patterns in the place of their names.
fn expand_patterns(part: &mut Value, fields: &str) {
    match part {
        Value::Object(entries) => {
            for (key, entry) in entries.iter_mut() {
                match entry.as_str().filter(|_| key == "pattern") {
                    Some("instant") => *entry = INSTANT.into(),
                    Some("step") => *entry = SPAN.into(),
                    Some("fields") => *entry = fields.into(),
                    Some("words") => *entry = WORDS.into(),
                    Some("line") => *entry = LINE.into(),
                    _ => expand_patterns(entry, fields),
                }
            }
        }
        Value::Array(entries) => entries.iter_mut().for_each(|entry| expand_patterns(entry, fields)),
        _ => {}
    }
}
