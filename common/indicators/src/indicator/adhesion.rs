//! Adhesion: what is used of it, and what there would be.

use super::judging::{known, unknown};
use crate::measure::rail_view::RailView;
use crate::observed::{Available, Observed};
use crate::settings::AdhesionSettings;
use crate::spec::{Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach};
use railgrip_messages::{Grade, Indicator};

/// The scale on which adhesion is drawn.
const SCALE: Limit = Limit::free(0.0, 0.4);

/// The largest adhesion utilised recently.
pub static ADHESION_UTILISED: IndicatorSpec = IndicatorSpec {
    id: "adhesion_utilised",
    form: Form::COEFFICIENT,
    judge: Judge {
        wagon: Some(|seen, _| utilised(seen.state.wagon.window.largest(), &seen.settings.adhesion)),
        wheelset: Some(|seen, index| {
            utilised(seen.state.wheelset[index].rail.window.largest(), &seen.settings.adhesion)
        }),
        ..Judge::NONE
    },
    limit: Some(|_, _| SCALE),
    metric: Some(Metric {
        reach: Reach::Both,
        ..Metric::gauge("adhesion_utilised_ratio", "Largest adhesion utilised recently, magnitude")
    }),
    meaning: Meaning {
        name: "Adhesion used",
        block: "manipulation",
        definition: "Tangential over normal force between wheel and rail, the largest value of the last seconds.",
        interval: "95 %, from the filter",
        limits: |settings, _| format!("Not judged; over the latest {:.0} s.", settings.adhesion.window_s),
        cannot_see: "How much adhesion was left unused.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// The most that the rail gives, or a lower bound of it.
pub static ADHESION_AVAILABLE: IndicatorSpec = IndicatorSpec {
    id: "adhesion_available",
    form: Form::COEFFICIENT,
    judge: Judge {
        wagon: Some(|seen, _| judge_available(seen, &seen.state.wagon)),
        wheelset: Some(|seen, index| judge_available(seen, &seen.state.wheelset[index].rail)),
        ..Judge::NONE
    },
    limit: Some(|_, _| SCALE),
    metric: Some(Metric {
        reach: Reach::Both,
        ..Metric::gauge("adhesion_available_ratio", "Adhesion available, or a lower bound of it")
    }),
    meaning: Meaning {
        name: "Adhesion available",
        definition: "The largest adhesion that the rail can provide. It is measured while a wheelset slides; otherwise the adhesion used without sliding is a lower bound, marked ≥.",
        interval: "95 %, from all slides and all rolling so far",
        limits: |settings, _| {
            format!(
                "Not judged itself (see Rail). A value from a slide is kept for {:.0} s.",
                settings.adhesion.slide_hold_s
            )
        },
        cannot_see: "The limit, while the adhesion used stays well below it.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

fn judge_available(seen: &Observed, view: &RailView) -> Indicator {
    available(&seen.available(view))
}

/// The largest adhesion utilised in the window.
fn utilised(largest: Option<(f64, f64)>, settings: &AdhesionSettings) -> Indicator {
    let Some((value, sigma)) = largest else { return unknown("no estimate yet") };
    let half = 1.96 * sigma;
    let reason = format!("{value:.3} ± {half:.3}, the largest of the last {:.0} s", settings.window_s);
    known(value, (value - half).max(0.0), value + half, Grade::Ok, &reason)
}

/// The adhesion available; a lower bound where no slide showed it.
fn available(available: &Available) -> Indicator {
    if let Some((value, age_s)) = available.slid {
        let when = if age_s < 1.0 { "now".to_owned() } else { format!("{age_s:.0} s ago") };
        let reason = format!("{value:.3}, seen in a slide {when}");
        let (low, high) = (available.low.min(value), available.high.max(value));
        return known(value, low, high, Grade::Ok, &reason);
    }
    match available.utilised {
        None => unknown("no estimate yet"),
        Some((value, sigma)) => {
            let low = (value - 1.96 * sigma).max(0.0);
            let reason = format!("at least {low:.3}: this much was used without sliding");
            known(low, low, available.high.max(low), Grade::Ok, &reason)
        }
    }
}
