//! Where the script draws the history of a wagon: the range of time, the wagons beside it, the charts to choose from.

use crate::api::grade::Grade;
use crate::api::wagons::model::WagonView;
use crate::limits::Limits;
use maud::{Markup, html};
use railgrip_indicators::{IndicatorSpec, Limit};
use railgrip_words::t;

/// Ranges that end now, s.
const RANGES: [(u32, &str); 6] = [
    (900, "15 min"),
    (3600, "1 h"),
    (21_600, "6 h"),
    (86_400, "1 day"),
    (604_800, "7 days"),
    (2_592_000, "30 days"),
];

/// The section; `count` is the number of wagons of the train.
pub(super) fn section(wagon: &WagonView, count: usize, limits: &Limits) -> Markup {
    html! {
        section #trends .card aria-labelledby="h-trends" data-wagon=(wagon.id) data-wagons=(count)
            data-wheelsets=(wagon.wheelsets.len()) data-first=(wrong(wagon).join(" ")) data-limits=(ends(wagon, limits)) {
            details #trends-fold open {
                summary { h2 #h-trends { (t("Trends")) } }
                div .ranges.slider role="group" aria-label=(t("Charts")) #picks {}
                div .ranges.slider role="group" aria-label=(t("Range of time")) {
                    @for (seconds, name) in RANGES {
                        button type="button" data-range=(seconds) aria-pressed=(if seconds == 3600 { "true" } else { "false" }) { (t(name)) }
                    }
                    button type="button" .quiet data-move="-0.5" { (t("‹ earlier")) }
                    button type="button" .quiet data-move="0.5" { (t("later ›")) }
                    button type="button" .quiet data-times="0.5" { (t("zoom in")) }
                    button type="button" .quiet data-times="2" { (t("zoom out")) }
                    @if count > 1 {
                        label .beside { (t("beside wagons")) " " input #beside inputmode="numeric" placeholder="2, 5" autocomplete="off" aria-describedby="beside-wrong"; }
                    }
                    button type="button" .quiet data-copy="1" { (t("copy link")) }
                }
                p #beside-wrong .error role="alert" {}
                p .calm { span #trend-state role="status" { (t("Loading the history…")) } " " span #trend-hint .hint {} " " span #copied role="status" {} }
                div #charts .charts {}
            }
        }
    }
}

/// Fields of what is wrong with the wagon or its wheelsets, the worst first: their charts are shown first.
fn wrong(wagon: &WagonView) -> Vec<String> {
    let of_wheelsets = wagon.wheelsets.iter().flat_map(|set| set.indicators.iter());
    let all = wagon.indicators.iter().chain(of_wheelsets);
    let mut wrong: Vec<_> = all.filter(|(_, figure)| figure.grade >= Grade::Watch).collect();
    wrong.sort_by_key(|(_, figure)| std::cmp::Reverse(figure.grade));
    wrong.into_iter().map(|(spec, _)| spec.field()).collect()
}

/// Limits of every indicator that has some, as JSON: four ends by field.
fn ends(wagon: &WagonView, limits: &Limits) -> String {
    let ends = |limit: &Limit| {
        let all = [limit.act_low, limit.watch_low, limit.watch_high, limit.act_high];
        all.map(|end| end.map_or_else(String::new, |end| format!("{end:.6}"))).join(" ")
    };
    let of_wagon = |spec: &'static IndicatorSpec| {
        limits.limit(spec, wagon.id).map(|limit| (spec.field(), ends(&limit).into()))
    };
    let of_wheelsets = wagon.wheelsets.first().into_iter().flat_map(|set| set.indicators.iter());
    let all: serde_json::Map<String, serde_json::Value> =
        wagon.indicators.iter().chain(of_wheelsets).filter_map(|(spec, _)| of_wagon(spec)).collect();
    serde_json::Value::from(all).to_string()
}
