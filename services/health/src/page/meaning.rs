//! What every figure means: definition, unit, interval, limits and what it cannot see. The limits are those of the running
//! train, so that this page and the grades cannot contradict each other.

use crate::limits::Limits;
use maud::{Markup, html};
use railgrip_indicators::IndicatorSpec;
use railgrip_words::{reword, t};

/// One figure, by the block of ISO 13374 that it belongs to.
struct Entry {
    id: String,
    name: &'static str,
    /// Block of ISO 13374.
    block: &'static str,
    is: &'static str,
    unit: &'static str,
    interval: &'static str,
    limits: String,
    blind: &'static str,
}

impl Entry {
    /// What the table says of an indicator.
    fn of(spec: &IndicatorSpec, limits: &Limits) -> Self {
        let meaning = &spec.meaning;
        Self {
            id: spec.anchor(),
            name: spec.name(),
            block: meaning.block,
            is: meaning.definition,
            unit: meaning.unit,
            interval: meaning.interval,
            limits: (meaning.limits)(&limits.settings, &limits.full_braking()),
            blind: meaning.cannot_see,
        }
    }
}

pub(super) fn body(limits: &Limits) -> Markup {
    let of_table = limits.table.iter().map(|spec| Entry::of(spec, limits));
    let all: Vec<Entry> = of_table.chain(others(limits)).collect();
    html! {
        h1 .page { (t("What the figures mean")) }
        section .card aria-labelledby="h-grades" {
            h2 #h-grades { (t("Grades, intervals and ages")) }
            p {
                (t("Ok: as it should be. Watch: worth a look at the next occasion. Act: needs action. Unknown: not enough fresh data to judge.")) " "
                (t("A limit counts as passed only when the whole 95 % interval lies beyond it, so an uncertain figure raises no alarm; the reason then says that the figure is too uncertain.")) " "
                (t("Old data are marked as stale with their age, and are not judged."))
            }
            p { (t("The words at the right are the processing blocks of ISO 13374: acquisition, manipulation, state detection, health assessment, prognosis, advisory.")) }
            nav .contents aria-label=(t("Figures")) { @for one in &all { a href={ "#" (one.id) } { (t(one.name)) } " " } }
        }
        @for one in &all { (entry(one)) }
    }
}

fn entry(one: &Entry) -> Markup {
    html! {
        section .card.meaning id=(one.id) aria-labelledby={ "m-" (one.id) } {
            div .heading { h2 id={ "m-" (one.id) } { (t(one.name)) } span .legend { (t(one.block)) } }
            p { (t(one.is)) }
            dl .meanings {
                div { dt { (t("Unit")) } dd { (t(one.unit)) } }
                div { dt { (t("Interval")) } dd { (t(one.interval)) } }
                div { dt { (t("Limits")) } dd { (reword(&one.limits)) } }
                div { dt { (t("Cannot see")) } dd { (t(one.blind)) } }
            }
        }
    }
}

/// What the pages show beside the indicators.
fn others(limits: &Limits) -> Vec<Entry> {
    let (cell_m, memory_s) =
        limits.capability.as_ref().map_or((0.0, 0.0), |set| (set.cell_m, set.map_memory_s));
    vec![
        Entry {
            id: "age".to_owned(),
            name: "Age of the data",
            block: "acquisition",
            is: "Time since the sample behind a figure was taken, by a clock that cannot be set.",
            unit: "s",
            interval: "none",
            limits: "Beyond the limit in the config a wagon is stale, and none of its figures is shown as current."
                .to_owned(),
            blind: "A source that sends old samples with new time stamps.",
        },
        Entry {
            id: "map".to_owned(),
            name: "Adhesion along the track",
            block: "state detection",
            is: "The probabilities of Rail for each stretch of the track, from every wagon that passed it. Each wagon makes them more certain.",
            unit: "none, by kilometre",
            interval: "95 %",
            limits: format!(
                "A stretch counts as low from 50 % probability. Cells of {cell_m:.0} m; what is known of them fades in about {:.0} min.",
                memory_s / 60.0
            ),
            blind: "Stretches on which no wagon braked or pulled.",
        },
        Entry {
            id: "trend".to_owned(),
            name: "Trend and time left",
            block: "prognosis",
            is: "Median slope between all pairs of stored points (Theil and Sen) over 30 days, or over what there is. The time left is the time until that line meets the act limit.",
            unit: "per day; days",
            interval: "95 %, from Kendall's statistic, widened because neighbouring points are alike",
            limits: "There is a trend only if the interval of the slope excludes zero. \"No trend\" is a result, too.".to_owned(),
            blind: "Changes to come, such as new pads or a new season. Fewer than eight points, or less than an hour, show no trend.",
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_indicators::INDICATORS;

    /// Every link from an indicator to its meaning must lead somewhere.
    #[test]
    fn every_figure_has_a_meaning() {
        let text = body(&Limits::default()).into_string();
        let others = ["map", "trend", "age"].map(str::to_owned);
        for id in INDICATORS.iter().map(IndicatorSpec::anchor).chain(others) {
            assert!(text.contains(&format!("id=\"{id}\"")), "{id}");
        }
    }
}
