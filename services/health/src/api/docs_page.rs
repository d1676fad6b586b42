//! `/docs`: the description of the interface for people, made from the OpenAPI document, without any script. What it says of
//! routes and forms is in the language of the page.

use super::docs::{DEPRECATED, REFUSALS};
use crate::page::{POLICY, style_sheet};
use crate::shared::Shared;
use axum::Extension;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, Uri, header};
use axum::response::{IntoResponse, Response};
use maud::{DOCTYPE, Markup, html};
use railgrip_words::{Language, reword, say, speak, spoken, t};
use serde_json::{Map, Value, json};

/// Groups of routes in the order of the contents, with their headings.
const GROUPS: [(&str, &str); 7] = [
    ("train", "The train"),
    ("wagons", "Wagons"),
    ("alerts", "Alerts"),
    ("history", "History"),
    ("stream", "What changes, as it changes"),
    ("health", "Health of the service"),
    ("service", "The service"),
];

/// One route of the document.
struct Route<'a> {
    path: &'a str,
    method: &'a str,
    about: &'a Value,
}

impl Route<'_> {
    fn id(&self) -> &str {
        text(&self.about["operationId"])
    }

    fn is_old(&self) -> bool {
        DEPRECATED.iter().any(|(old, _)| *old == self.path)
    }
}

/// The page; its examples name the address at which it was asked for.
pub(crate) async fn page(
    State(shared): State<Shared>,
    Extension(language): Extension<Language>,
    uri: Uri,
    headers: HeaderMap,
) -> Response {
    let bytes = shared.openapi().get().cloned().unwrap_or_default();
    let api: Value = serde_json::from_slice(&bytes).unwrap_or_default();
    let kind = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
        // Said here, so that a 304, which has no type, carries it, too: a stricter one would take the style from the page.
        (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
    ];
    let page = speak(language, || document(&api, &base(&uri, &headers)).into_string());
    let said = [
        (header::CONTENT_LANGUAGE, HeaderValue::from_static(language.tag())),
        (header::VARY, HeaderValue::from_static("Accept-Language, Cookie")),
    ];
    (kind, said, page).into_response()
}

/// Scheme and authority of the request, for examples that work where they are read. A request does not say whether it came by
/// TLS; beyond loopback the service asks for it.
fn base(uri: &Uri, headers: &HeaderMap) -> String {
    let named = headers.get(header::HOST).and_then(|host| host.to_str().ok());
    let authority = uri.authority().map(|authority| authority.as_str()).or(named).unwrap_or("127.0.0.1:8080");
    let on_loopback = ["127.", "localhost", "[::1]"].iter().any(|start| authority.starts_with(start));
    format!("{}://{authority}", if on_loopback { "http" } else { "https" })
}

fn document(api: &Value, base: &str) -> Markup {
    let empty = Map::new();
    let schemas = api["components"]["schemas"].as_object().unwrap_or(&empty);
    let routes: Vec<Route<'_>> =
        api["paths"].as_object().unwrap_or(&empty).iter().flat_map(methods).collect();
    html! {
        (DOCTYPE)
        html lang=(spoken().tag()) {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (t("Interface")) " – railgrip" }
                link rel="icon" type="image/svg+xml" href="/favicon.ico";
                link rel="stylesheet" href=(style_sheet());
                link rel="stylesheet" href="/docs.css";
            }
            body .docs {
                header .top {
                    a .brand href="/" { "railgrip" }
                    nav aria-label=(t("Pages")) { a href="/" { (t("Train")) } a href="/openapi.json" { "openapi.json" } }
                }
                main {
                    (contents(&routes, schemas))
                    div .text {
                        h1 { (t("The interface")) }
                        p { (told(&api["info"]["description"])) }
                        (rules())
                        @for (tag, heading) in GROUPS { (group(tag, heading, &routes, schemas, base)) }
                        h2 #forms { (t("Forms")) }
                        @for (name, schema) in schemas { (form(name, schema)) }
                    }
                }
            }
        }
    }
}

fn methods<'a>((path, methods): (&'a String, &'a Value)) -> Vec<Route<'a>> {
    let methods = methods.as_object().into_iter().flatten();
    methods.map(|(method, about)| Route { path, method, about }).collect()
}

/// What holds for every route.
fn rules() -> Markup {
    html! {
        ul .rules {
            li { (t("Errors are application/problem+json (RFC 9457); their detail says what is wrong and what is allowed.")) }
            li { (t("Answers carry an ETag; send it back as If-None-Match and get 304 while nothing has changed.")) }
            li { (t("Long lists have limit and after, and the next page in the header Link.")) }
            li { (t("What is unknown is null, never 0. Units stand at the end of a name: dragging_n, age_s.")) }
            li { (t("Where tokens are asked for:")) " " code { "Authorization: Bearer railgrip_…" } }
        }
    }
}

fn of_group<'a, 'b>(routes: &'b [Route<'a>], tag: &str) -> Vec<&'b Route<'a>> {
    let mut own: Vec<&Route<'_>> = routes.iter().filter(|route| route.about["tags"][0] == tag).collect();
    own.sort_by_key(|route| route.is_old());
    own
}

fn contents(routes: &[Route<'_>], schemas: &Map<String, Value>) -> Markup {
    html! {
        nav .contents-of aria-label=(t("Contents")) {
            @for (tag, heading) in GROUPS {
                h2 { (t(heading)) }
                ul {
                    @for route in of_group(routes, tag).into_iter().filter(|route| !route.is_old()) {
                        li { a href={ "#" (route.id()) } { span .method { (route.method) } " " (route.path.trim_start_matches("/api/v1")) } }
                    }
                }
            }
            h2 { a href="#forms" { (t("Forms")) } }
            details { summary { (say("{count} forms", &[("count", &schemas.len())])) } ul { @for name in schemas.keys() { li { a href={ "#" (name) } { (name) } } } } }
        }
    }
}

fn group(
    tag: &str,
    heading: &'static str,
    routes: &[Route<'_>],
    schemas: &Map<String, Value>,
    base: &str,
) -> Markup {
    html! {
        h2 { (t(heading)) }
        @for route in of_group(routes, tag) { (section(route, schemas, base)) }
    }
}

fn section(route: &Route<'_>, schemas: &Map<String, Value>, base: &str) -> Markup {
    let about = route.about;
    let parameters = about["parameters"].as_array().map(Vec::as_slice).unwrap_or_default();
    let body = &about["requestBody"]["content"]["application/json"]["schema"];
    let replaced = DEPRECATED.iter().find(|(old, _)| *old == route.path);
    html! {
        section .card id=(route.id()) {
            h3 { span .method { (route.method) } " " code { (route.path) } }
            p { (told(&about["summary"])) " " (told(&about["description"])) }
            @if let Some((_, new)) = replaced { p .loud { (t("Deprecated: use")) " " code { (new) } } }
            @if !parameters.is_empty() {
                table {
                    thead { tr { th scope="col" { (t("Parameter")) } th scope="col" { (t("In")) } th scope="col" { (t("What it is")) } } }
                    tbody {
                        @for parameter in parameters {
                            tr { th scope="row" { code { (text(&parameter["name"])) } @if parameter["required"] == true { " (" (t("needed")) ")" } }
                                 td { (text(&parameter["in"])) } td { (told(&parameter["description"])) } }
                        }
                    }
                }
            }
            @if let Some((name, schema)) = named(body, schemas) {
                p { b { (t("Body")) } ", " code { "application/json" } ", " a href={ "#" (name) } { (name) } ":" }
                (properties(schema))
            }
            ul .answers {
                @for (status, answer) in about["responses"].as_object().into_iter().flatten() {
                    @if !REFUSALS.iter().any(|(_, words)| *words == text(&answer["description"])) {
                        li { code { (status) } " " (told(&answer["description"])) " " (kinds(answer)) }
                    }
                }
            }
            pre tabindex="0" { (example(route, named(body, schemas).map(|(_, schema)| schema), schemas, base)) }
        }
    }
}

/// A form by its reference.
fn named<'a>(schema: &'a Value, schemas: &'a Map<String, Value>) -> Option<(&'a str, &'a Value)> {
    let name = text(&schema["$ref"]).rsplit('/').next()?;
    schemas.get_key_value(name).map(|(name, schema)| (name.as_str(), schema))
}

/// A command that can be pasted into a shell.
fn example(route: &Route<'_>, body: Option<&Value>, schemas: &Map<String, Value>, base: &str) -> String {
    let path = route.path.replace("{id}", "1");
    match body {
        None if route.method == "get" => format!("curl {base}{path}"),
        None => format!("curl -X {} {base}{path}", route.method.to_uppercase()),
        Some(schema) => {
            let given = schema["properties"].as_object().into_iter().flatten();
            let body: Map<String, Value> =
                given.filter_map(|(name, form)| Some((name.clone(), sample(name, form, schemas)?))).collect();
            format!("curl {base}{path} -H 'content-type: application/json' \\\n  -d '{}'", Value::from(body))
        }
    }
}

/// A value that a form allows: of one that lists its words the first, `None` for what has no simple value.
fn sample(name: &str, form: &Value, schemas: &Map<String, Value>) -> Option<Value> {
    // What may be left out is of two types, the other of which is "null".
    let kind = form["type"].get(0).unwrap_or(&form["type"]);
    match (name, text(kind)) {
        ("by", _) => Some("early shift".into()),
        (_, "number" | "integer") => {
            Some(form["maximum"].as_f64().map_or(1.into(), |most| json!(most.min(28_800.0))))
        }
        (_, "string") => Some("pads ordered".into()),
        _ => {
            let either =
                ["oneOf", "allOf", "anyOf"].into_iter().flat_map(|way| form[way].as_array()).flatten();
            let listed = [form].into_iter().chain(either).find_map(|form| named(form, schemas))?.1;
            [listed, &listed["oneOf"][0]].into_iter().find_map(|words| words["enum"].get(0)).cloned()
        }
    }
}

/// Media types of an answer, and where its form is described.
fn kinds(answer: &Value) -> Markup {
    html! {
        @for (kind, content) in answer["content"].as_object().into_iter().flatten() {
            @let reference = text(&content["schema"]["$ref"]).rsplit('/').next().unwrap_or_default().to_owned();
            span.kind { (kind) } " "
            @if !reference.is_empty() { a href={ "#" (reference) } { (reference) } " " }
        }
    }
}

fn form(name: &str, schema: &Value) -> Markup {
    html! {
        section .card id=(name) {
            h3 { (name) }
            p { (told(&schema["description"])) }
            @if let Some(words) = schema["enum"].as_array() {
                p { @for word in words { code { (text(word)) } " " } }
            }
            (properties(schema))
        }
    }
}

fn properties(schema: &Value) -> Markup {
    let needed =
        |name: &str| schema["required"].as_array().is_some_and(|all| all.iter().any(|one| one == name));
    html! {
        @if let Some(properties) = schema["properties"].as_object() {
            table {
                thead { tr { th scope="col" { (t("Name")) } th scope="col" { (t("Type")) } th scope="col" { (t("What it is")) } } }
                tbody {
                    @for (name, property) in properties {
                        tr { th scope="row" { code { (name) } @if !needed(name) { " (" (t("optional")) ")" } }
                             td { (type_of(property)) } td { (told(&property["description"])) } }
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
        return html! { @for (at, choice) in choices.iter().enumerate() { @if at > 0 { " " (t("or")) " " } (type_of(choice)) } };
    }
    let kind = match &property["type"] {
        Value::Array(kinds) => kinds.iter().map(text).collect::<Vec<_>>().join(&format!(" {} ", t("or"))),
        kind => text(kind).to_owned(),
    };
    html! { (kind) @if property["items"].is_object() { " " (t("of")) " " (type_of(&property["items"])) } }
}

/// A sentence of the document in the language of the page. The document breaks lines where its source does.
fn told(value: &Value) -> String {
    reword(&text(value).replace('\n', " "))
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Its style, beside that of all pages.
pub(crate) async fn style() -> impl IntoResponse {
    let kind = [(header::CONTENT_TYPE, HeaderValue::from_static("text/css; charset=utf-8"))];
    (kind, include_str!("docs.css"))
}
