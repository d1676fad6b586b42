//! What the service says is found in the table of messages.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use axum::body::Body;
use axum::http::Request;
use http_body_util::BodyExt;
use railgrip_causes::Cause;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_indicators::train::capability::FullBraking;
use railgrip_indicators::{INDICATORS, IndicatorSettings};
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use railgrip_words::{Language, german, in_language, reword, say, speak, t};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tower::ServiceExt;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What the tables of indicators and settings say of themselves.
#[test]
fn every_text_of_the_tables_is_known() {
    let mut all: Vec<String> = Vec::new();
    for spec in INDICATORS.iter() {
        let meaning = &spec.meaning;
        let own = [
            meaning.name,
            meaning.block,
            meaning.definition,
            meaning.unit,
            meaning.interval,
            meaning.cannot_see,
        ];
        all.extend(own.into_iter().filter(|text| !text.is_empty()).map(str::to_owned));
        all.push((meaning.limits)(&IndicatorSettings::default(), &FullBraking::default()));
        all.extend(
            spec.alert.iter().flat_map(|alert| [alert.advice.wagon, alert.advice.train]).map(str::to_owned),
        );
    }
    all.extend(Cause::ALL.iter().flat_map(|cause| [cause.title(), cause.advice()]).map(str::to_owned));
    all.extend(IndicatorSettings::default().entries().into_iter().map(|entry| entry.words.to_owned()));
    let unknown: Vec<&String> = all.iter().filter(|text| german(text).is_none()).collect();
    assert_eq!(unknown, Vec::<&String>::new(), "without German");
}

/// What the description of the interface says of its routes, their parameters and their answers, and of the fields of forms.
#[tokio::test]
async fn every_route_and_field_is_described_in_both_languages() {
    let file = root().join("config/railgrip.toml");
    let settings = TrainSettings::load(Some(&file), &Overrides::default()).unwrap();
    let now = || Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 1 };
    let router = router(Shared::new(Store::new(&settings).snapshot(now()), now));
    let ask = async |path: &str, language: &str| {
        let request =
            Request::builder().uri(path).header("host", "localhost").header("accept-language", language);
        let answer = router.clone().oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
        String::from_utf8(answer.into_body().collect().await.unwrap().to_bytes().to_vec()).unwrap()
    };
    let api: Value = serde_json::from_str(&ask("/openapi.json", "en").await).unwrap();
    let routes = api["paths"].as_object().unwrap().values();
    let mut all: Vec<&Value> = vec![&api["info"]["description"]];
    for route in routes.flat_map(|methods| methods.as_object().unwrap().values()) {
        all.extend([&route["summary"], &route["description"]]);
        all.extend(route["parameters"].as_array().into_iter().flatten().map(|one| &one["description"]));
        let answers = route["responses"].as_object().unwrap().values();
        all.extend(answers.map(|one| &one["description"]));
    }
    let forms = api["components"]["schemas"].as_object().unwrap().values();
    for form in forms {
        all.push(&form["description"]);
        let fields = form["properties"].as_object();
        all.extend(fields.into_iter().flat_map(|fields| fields.values()).map(|one| &one["description"]));
    }
    assert!(all.len() > 400, "{} descriptions", all.len());
    let texts = all.into_iter().filter_map(Value::as_str).map(|text| text.replace('\n', " "));
    // Refusals that every route has are told nowhere on the page.
    let common = [
        "token is needed",
        "role does not",
        "header `Accept` does",
        "not known by that",
        "Too many",
        "no answer in",
    ];
    let own = texts.filter(|text| !text.is_empty() && !common.iter().any(|words| text.contains(words)));
    let unknown: BTreeSet<String> = own.filter(|text| german(text).is_none()).collect();
    assert_eq!(unknown, BTreeSet::new(), "without German");
    let page = ask("/docs", "de").await;
    for needed in [
        "lang=\"de\"",
        "Die Schnittstelle",
        "Der Zug auf einen Blick.",
        "Was es ist",
        "Alter des letzten Abtastwerts",
    ] {
        assert!(page.contains(needed), "{needed}");
    }
}

#[test]
fn sentences_are_understood_with_what_was_filled_in() {
    let in_german = |sentence: &str| speak(Language::German, || reword(sentence));
    for (english, wanted) in [
        (
            "Pad friction of wheelset 2: far too low: 0.178 ± 0.013 over 17 s of braking, 51 % of nominal 0.350",
            "Belagreibwert an Radsatz 2: viel zu niedrig: 0,178 ± 0,013 über 17 s Bremsen, 51 % vom Sollwert 0,350",
        ),
        (
            "2 wagons (1-2), worst wagon 1: no data since 2026-11-22T10:53:40.680Z",
            "2 Wagen (1-2), am schlimmsten Wagen 1: keine Daten seit 2026-11-22T10:53:40.680Z",
        ),
        (
            "wagon 4: adhesion is low: low 92 %, dry 5 %, wet 2 %",
            "Wagen 4: der Kraftschluss ist niedrig: niedrig 92 %, trocken 5 %, nass 2 %",
        ),
        (
            "wheel speed 1 bad, pressing force 2 dead: 20.0 % of the values missing, 0.1 % of the values dead",
            "Raddrehzahl 1 gestört, Anpresskraft 2 tot: 20,0 % der Werte fehlen, 0,1 % der Werte tot",
        ),
        (
            "well since 2026-11-22T10:53:40.680Z; before: needs longer than nominal: about 141 % of the nominal distance",
            "gut seit 2026-11-22T10:53:40.680Z; davor: braucht länger als Soll: etwa 141 % des Soll-Bremswegs",
        ),
        (
            "model and data disagree (ratio 3.5, ideal 1), most for the speed while the brake is applied or released: suspect brake actuation",
            "Modell und Daten widersprechen sich (Verhältnis 3,5, ideal 1), am meisten bei der Geschwindigkeit, während die Bremse angelegt oder gelöst wird: Verdacht auf Bremsbetätigung",
        ),
        (
            "stale: no new data for 12 s; before: even: front minus rear +1 ± 3 % of their mean",
            "veraltet: keine neuen Daten seit 12 s; davor: gleichmäßig: vorn minus hinten +1 ± 3 % ihres Mittels",
        ),
        (
            "Slides act: risk of wheel flats: locked for 3.2 s recently; 4 with 120 kJ in 5.0 s",
            "Gleitvorgänge handeln: Gefahr von Flachstellen: zuletzt 3,2 s blockiert; 4 mit 120 kJ in 5,0 s",
        ),
        (
            "a brake drags, or another force holds the wagon back: +25.1 ± 0.4 kN while released, 30 s",
            "eine Bremse schleift, oder eine andere Kraft hält den Wagen zurück: +25,1 ± 0,4 kN im gelösten Zustand, 30 s",
        ),
        ("0.056, seen in a slide now", "0,056, jetzt in einem Gleiten gesehen"),
        ("kim wrote this", "kim wrote this"),
    ] {
        assert_eq!(in_german(english), wanted);
        assert_eq!(reword(english), english);
    }
}

#[test]
fn messages_speak_the_language_that_was_chosen() {
    let both = || (t("What to do"), say("{share} % of its force", &[("share", &"87.5")]));
    assert_eq!(both(), ("What to do", "87.5 % of its force".to_owned()));
    assert_eq!(speak(Language::German, both), ("Was zu tun ist", "87,5 % seiner Kraft".to_owned()));
    assert_eq!(both().0, "What to do", "the language belongs to one rendering");
    let script = in_language(r#"const W = { live: "connecting", size: "10" };"#, Language::German);
    assert_eq!(script, r#"const W = { live: "verbindet", size: "10" };"#);
}
