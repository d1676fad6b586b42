//! The description of the interface: OpenAPI 3.1 for programs, and `/docs`, the same for people, without any script.

use crate::shared::Shared;
use crate::time::{INSTANT, SPAN};
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use maud::{DOCTYPE, Markup, html};
use railgrip_indicators::{IndicatorSpec, Table};
use serde_json::{Value, json};
use utoipa::openapi::OpenApi;

/// Words of somebody: no control characters but line feeds, and not only blanks.
const WORDS: &str = "^[^\\x00-\\x09\\x0b-\\x1f\\x7f-\\x9f]*[^\\s\\x00-\\x1f\\x7f-\\x9f][^\\x00-\\x09\\x0b-\\x1f\\x7f-\\x9f]*$";
/// Old paths that still work, with those that replace them.
const DEPRECATED: [(&str, &str); 3] = [
    ("/api/v1/alerts/{id}/shelve", "/api/v1/alerts/{id}/silence"),
    ("/api/v1/alerts/{id}/unshelve", "/api/v1/alerts/{id}/unsilence"),
    ("/api/v1/delivery", "/api/v1/receivers"),
];
/// From the answer of one route to the next ones: path, method, and where in the answer their `id` is.
const LINKS: [(&str, &str, &str, &[&str]); 5] = [
    ("/api/v1/wagons", "get", "#/wagons/0/id", &["wagon", "history", "trends"]),
    ("/api/v1/alerts", "get", "#/alerts/0/id", &["alert", "acknowledge", "silence", "unsilence"]),
    ("/api/v1/alerts/{id}/acknowledge", "post", "#/id", &["alert", "silence"]),
    ("/api/v1/alerts/{id}/silence", "post", "#/id", &["alert", "unsilence", "acknowledge"]),
    ("/api/v1/alerts/{id}/unsilence", "post", "#/id", &["alert", "silence"]),
];
/// What a refusal by access control looks like; the same for every route.
const REFUSALS: [(&str, &str); 6] = [
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
                    _ => expand_patterns(entry, fields),
                }
            }
        }
        Value::Array(entries) => entries.iter_mut().for_each(|entry| expand_patterns(entry, fields)),
        _ => {}
    }
}

/// The description for people.
pub(crate) async fn page(State(shared): State<Shared>) -> Response {
    let bytes = shared.openapi().get().cloned().unwrap_or_default();
    let api: Value = serde_json::from_slice(&bytes).unwrap_or_default();
    let kind = [(header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"))];
    (kind, document(&api).into_string()).into_response()
}

fn document(api: &Value) -> Markup {
    let empty = serde_json::Map::new();
    let paths = api["paths"].as_object().unwrap_or(&empty);
    let schemas = api["components"]["schemas"].as_object().unwrap_or(&empty);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "railgrip – interface" }
                link rel="stylesheet" href="/docs.css";
            }
            body {
                header { h1 { "The interface of railgrip" } p { a href="/" { "The train" } " · " a href="/openapi.json" { "openapi.json" } } }
                main {
                    p { (text(&api["info"]["description"])) }
                    p { "Errors are " code { "application/problem+json" } " (RFC 9457). Answers carry an " code { "ETag" }
                        "; send it back as " code { "If-None-Match" } ". Long lists have " code { "limit" } " and "
                        code { "after" } ", and the next page in the header " code { "Link" } "." }
                    h2 { "Routes" }
                    @for (path, methods) in paths {
                        @for (method, route) in methods.as_object().into_iter().flatten() { (route_of(path, method, route)) }
                    }
                    h2 { "Forms" }
                    @for (name, schema) in schemas { (schema_of(name, schema)) }
                }
            }
        }
    }
}

fn route_of(path: &str, method: &str, route: &Value) -> Markup {
    let parameters = route["parameters"].as_array().map(Vec::as_slice).unwrap_or_default();
    let example = format!("curl http://127.0.0.1:8080{}", path.replace("{id}", "1"));
    html! {
        section {
            h3 { code { (method.to_uppercase()) " " (path) } @if route["deprecated"] == true { " deprecated" } }
            p { (text(&route["summary"])) " " (text(&route["description"])) }
            @if !parameters.is_empty() {
                table {
                    thead { tr { th scope="col" { "parameter" } th scope="col" { "in" } th scope="col" { "what it is" } } }
                    tbody {
                        @for parameter in parameters {
                            tr { td { code { (text(&parameter["name"])) } } td { (text(&parameter["in"])) }
                                 td { (text(&parameter["description"])) } }
                        }
                    }
                }
            }
            ul {
                @for (status, answer) in route["responses"].as_object().into_iter().flatten() {
                    @if !REFUSALS.iter().any(|(_, words)| *words == text(&answer["description"])) {
                        li { code { (status) } " " (text(&answer["description"])) " " (form_of(answer)) }
                    }
                }
            }
            @if method == "get" { pre { (example) } }
        }
    }
}

/// Media types of an answer, and where its form is described.
fn form_of(answer: &Value) -> Markup {
    html! {
        @for (kind, content) in answer["content"].as_object().into_iter().flatten() {
            @let reference = text(&content["schema"]["$ref"]).rsplit('/').next().unwrap_or_default().to_owned();
            span.kind { (kind) } " "
            @if !reference.is_empty() { a href={ "#" (reference) } { (reference) } " " }
        }
    }
}

fn schema_of(name: &str, schema: &Value) -> Markup {
    html! {
        section #(name) {
            h3 { (name) }
            p { (text(&schema["description"])) }
            @if let Some(words) = schema["enum"].as_array() {
                p { @for word in words { code { (text(word)) } " " } }
            }
            @if let Some(properties) = schema["properties"].as_object() {
                table {
                    thead { tr { th scope="col" { "name" } th scope="col" { "type" } th scope="col" { "what it is" } } }
                    tbody {
                        @for (name, property) in properties {
                            tr { td { code { (name) } } td { (type_of(property)) } td { (text(&property["description"])) } }
                        }
                    }
                }
            }
        }
    }
}

fn type_of(property: &Value) -> Markup {
    if let Some(reference) = property["$ref"].as_str() {
        let name = reference.rsplit('/').next().unwrap_or_default();
        return html! { a href={ "#" (name) } { (name) } };
    }
    if let Some(choices) = property["oneOf"].as_array().or_else(|| property["anyOf"].as_array()) {
        return html! { @for (at, choice) in choices.iter().enumerate() { @if at > 0 { " or " } (type_of(choice)) } };
    }
    let kind = match &property["type"] {
        Value::Array(kinds) => kinds.iter().map(text).collect::<Vec<_>>().join(" or "),
        kind => text(kind).to_owned(),
    };
    html! { (kind) @if property["items"].is_object() { " of " (type_of(&property["items"])) } }
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Its style.
pub(crate) async fn style() -> impl IntoResponse {
    let kind = [(header::CONTENT_TYPE, HeaderValue::from_static("text/css; charset=utf-8"))];
    (kind, include_str!("docs.css"))
}
