//! Grades and reasons of how the brakes behave.

use crate::dead::Faulty;
use crate::judge::{known, large, unknown};
use crate::settings::IndicatorSettings;
use railgrip_messages::{Grade, Indicator};

/// Time from the first pressing force to 90 % of its level.
pub(crate) fn response(time_s: Option<(f64, f64, f64)>, settings: &IndicatorSettings) -> Indicator {
    let Some((median_s, low_s, high_s)) = time_s else {
        return unknown("needs three brake applications that come to rest");
    };
    let grade = large(low_s, settings.response.watch_s, settings.response.act_s);
    let words = if grade > Grade::Ok { "slow" } else { "as it should be" };
    let reason =
        format!("{words}: {median_s:.1} s to 90 % of the force, {low_s:.1} to {high_s:.1} s of late");
    known(median_s, low_s, high_s, grade, &reason)
}

/// Retarding force while the brakes are released; `weight_n` turns shares into forces.
pub(crate) fn dragging(
    drag: Option<(f64, f64, f64)>,
    weight_n: f64,
    settings: &IndicatorSettings,
) -> Indicator {
    let limits = &settings.dragging;
    let Some((share, half, seconds)) = drag.filter(|(_, _, seconds)| *seconds >= limits.min_released_s)
    else {
        return unknown("needs running with released brakes");
    };
    let grade = large(share - half, limits.watch, limits.act);
    let figure = format!("{:+.1} ± {:.1} kN while released", 1e-3 * share * weight_n, 1e-3 * half * weight_n);
    let (grade, words) = match grade {
        Grade::Ok if half > limits.act => (Grade::Unknown, "too uncertain to judge"),
        Grade::Ok => (Grade::Ok, "runs freely"),
        grade => (grade, "a brake drags, or something else holds the wagon"),
    };
    let (value, half) = (share * weight_n, half * weight_n);
    known(value, value - half, value + half, grade, &format!("{words}: {figure}, {seconds:.0} s"))
}

/// One wheelset that does not brake: no pressing force, or none that has an effect (friction and its upper end, over
/// nominal).
pub(crate) fn isolated(
    share: Option<f64>,
    friction_ratio: Option<(f64, f64)>,
    settings: &IndicatorSettings,
) -> Indicator {
    let limits = &settings.isolated;
    if let Some((ratio, high)) = friction_ratio.filter(|(_, high)| *high < limits.effect_ratio) {
        let said = format!(
            "pressed without effect: pads at {:.0} % of nominal, {:.0} % at most",
            100.0 * ratio,
            100.0 * high
        );
        return known(1.0, 1.0, 1.0, Grade::Act, &said);
    }
    let Some(share) = share else { return unknown("no braking yet") };
    let grade = large(share, limits.watch, limits.act);
    let words = if grade > Grade::Ok {
        "no pressing force here while others press"
    } else {
        "pressed like the others"
    };
    known(
        share,
        share,
        share,
        grade,
        &format!("{words}: without in {:.0} % of the latest braking", 100.0 * share),
    )
}

/// What sand does.
pub(crate) fn sanding(ratio: Option<(f64, f64, f64)>, settings: &IndicatorSettings) -> Indicator {
    let Some((ratio, low, high)) = ratio else {
        return unknown("needs slides with and without sand within a short time");
    };
    let (grade, words) = if high < settings.sanding.factor_watch {
        (Grade::Watch, "sand has no effect")
    } else if low > 1.0 {
        (Grade::Ok, "sand helps")
    } else {
        (Grade::Unknown, "too uncertain to judge")
    };
    known(
        ratio,
        low,
        high,
        grade,
        &format!("{words}: adhesion {ratio:.2} times that without, {low:.2} to {high:.2}"),
    )
}

/// The faulty sensors in words, for example `wheel speed 2 dead`; `None` if there are none.
pub(crate) fn faulty(faulty: impl Iterator<Item = Faulty>) -> Option<(bool, String)> {
    let (mut words, mut any_dead): (Vec<String>, bool) = (Vec::new(), false);
    for sensor in faulty {
        let place = sensor.wheelset.map_or_else(String::new, |wheelset| format!(" {}", wheelset + 1));
        words.push(format!("{}{place} {}", sensor.what, if sensor.dead { "dead" } else { "bad" }));
        any_dead |= sensor.dead;
    }
    (!words.is_empty()).then(|| (any_dead, words.join(", ")))
}
