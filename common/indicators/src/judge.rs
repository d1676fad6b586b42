//! From figures to grades, with the reason in words.

use crate::mean::Mean;
use crate::settings::{
    AdhesionSettings, AsymmetrySettings, BrakeFrictionSettings, IndicatorSettings, SlideSettings,
};
use crate::slides::Slides;
use railgrip_messages::{Condition, Grade, Indicator, Text};

/// Nothing to judge, and why.
pub(crate) fn unknown(reason: &str) -> Indicator {
    Indicator { reason: Text::new(reason), ..Indicator::default() }
}

/// A judged figure.
pub(crate) fn known(value: f64, low: f64, high: f64, grade: Grade, reason: &str) -> Indicator {
    Indicator { value, low, high, grade: grade.code(), known: 1, reason: Text::new(reason) }
}

/// Grade of a figure that is bad when large.
pub(crate) fn large(value: f64, watch: f64, act: f64) -> Grade {
    if value > act {
        Grade::Act
    } else if value > watch {
        Grade::Watch
    } else {
        Grade::Ok
    }
}

/// Pad friction against its nominal value. A limit counts as passed when the interval's nearer end has passed it, so
/// that an uncertain figure raises no alarm; an interval wider than the ok range gives no verdict.
pub(crate) fn brake_friction(
    mean: Option<Mean>,
    braking_s: f64,
    nominal: f64,
    settings: &BrakeFrictionSettings,
    nothing: &str,
) -> Indicator {
    let Some(mean) = mean.filter(|_| braking_s >= settings.min_braking_s) else { return unknown(nothing) };
    let half = mean.half_width.hypot(1.96 * settings.systematic_share * mean.value);
    let (low, high) = ((mean.value - half).max(0.0), mean.value + half);
    let ratio = mean.value / nominal;
    let (ratio_low, ratio_high) = (low / nominal, high / nominal);
    let figure = format!(
        "{:.3} ± {half:.3} over {braking_s:.0} s of braking, {:.0} % of nominal {nominal:.3}",
        mean.value,
        100.0 * ratio
    );
    let (grade, words) = if ratio_high < settings.ratio_act_low {
        (Grade::Act, "far too low")
    } else if ratio_low > settings.ratio_act_high {
        (Grade::Act, "far too high")
    } else if ratio_high < settings.ratio_watch_low {
        (Grade::Watch, "low")
    } else if ratio_low > settings.ratio_watch_high {
        (Grade::Watch, "high")
    } else if ratio_low < settings.ratio_act_low && ratio_high > settings.ratio_act_high {
        (Grade::Unknown, "too uncertain to judge")
    } else {
        (Grade::Ok, "as it should be")
    };
    known(mean.value, low, high, grade, &format!("{words}: {figure}"))
}

/// Front minus rear over their mean.
pub(crate) fn asymmetry(
    difference: Option<Mean>,
    seconds: f64,
    friction: Option<Mean>,
    settings: &AsymmetrySettings,
    min_braking_s: f64,
) -> Indicator {
    let both =
        difference.zip(friction).filter(|(_, friction)| seconds >= min_braking_s && friction.value > 0.0);
    let Some((difference, friction)) = both else {
        return unknown("needs braking in which each wheelset is observable on its own");
    };
    let (value, half) = (difference.value / friction.value, difference.half_width / friction.value);
    let (low, high) = (value - half, value + half);
    // The end of the interval nearer to zero decides; an interval around zero is no asymmetry.
    let sure = if low > 0.0 {
        low
    } else if high < 0.0 {
        -high
    } else {
        0.0
    };
    let weaker = if value > 0.0 { "rear" } else { "front" };
    let percent = format!("{:+.0} ± {:.0} %", 100.0 * value, 100.0 * half);
    match large(sure, settings.watch, settings.act) {
        Grade::Ok if half > settings.act => known(
            value,
            low,
            high,
            Grade::Unknown,
            &format!("too uncertain to judge: front minus rear {percent}"),
        ),
        Grade::Ok => {
            known(value, low, high, Grade::Ok, &format!("even: front minus rear {percent} of their mean"))
        }
        grade => known(
            value,
            low,
            high,
            grade,
            &format!("{weaker} brakes less: front minus rear {percent} of their mean"),
        ),
    }
}

/// The largest adhesion utilised in the window.
pub(crate) fn utilised(largest: Option<(f64, f64)>, settings: &AdhesionSettings) -> Indicator {
    let Some((value, sigma)) = largest else { return unknown("no estimate yet") };
    let half = 1.96 * sigma;
    let reason = format!("{value:.3} ± {half:.3} at most in the last {:.0} s", settings.window_s);
    known(value, (value - half).max(0.0), value + half, Grade::Ok, &reason)
}

/// What is known of the adhesion available.
pub(crate) struct Available {
    /// What the last slide showed: the adhesion utilised in it, and its age in s.
    pub slid: Option<(f64, f64)>,
    /// Largest adhesion utilised while rolling, with its 1 σ.
    pub utilised: Option<(f64, f64)>,
    /// 95 % range of the belief.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// The adhesion available, and whether it is only a lower bound.
pub(crate) fn available(available: &Available) -> (Indicator, bool) {
    if let Some((value, age_s)) = available.slid {
        let when = if age_s < 1.0 { "now".to_owned() } else { format!("{age_s:.0} s ago") };
        let reason = format!("{value:.3}, seen in a slide {when}");
        let (low, high) = (available.low.min(value), available.high.max(value));
        return (known(value, low, high, Grade::Ok, &reason), false);
    }
    match available.utilised {
        None => (unknown("no estimate yet"), true),
        Some((value, sigma)) => {
            let low = (value - 1.96 * sigma).max(0.0);
            let reason = format!("at least {low:.3}: so much was utilised without sliding");
            (known(low, low, available.high.max(low), Grade::Ok, &reason), true)
        }
    }
}

/// The rail's condition from the probabilities of dry, wet, low and very low.
pub(crate) fn rail(classes: [f64; 4], settings: &AdhesionSettings) -> (Indicator, Condition) {
    let best = (0..4).max_by(|a, b| classes[*a].total_cmp(&classes[*b])).unwrap_or(0);
    let condition = Condition::ALL[best];
    let poor = classes[2] + classes[3];
    let (grade, words) = if classes[3] >= settings.very_low_probability_act {
        (Grade::Act, "adhesion is very low")
    } else if poor >= settings.low_probability_watch {
        (Grade::Watch, "adhesion is low")
    } else if poor <= settings.low_probability_ok {
        (Grade::Ok, "adhesion is not low")
    } else {
        (Grade::Unknown, "nothing tells yet: no slide, little adhesion utilised")
    };
    let mut order = [0, 1, 2, 3];
    order.sort_by(|a, b| classes[*b].total_cmp(&classes[*a]));
    let said = order.into_iter().filter(|class| classes[*class] >= 0.005);
    let said: Vec<String> =
        said.map(|class| format!("{} {:.0} %", Condition::ALL[class], 100.0 * classes[class])).collect();
    let reason = format!("{words}: {}", said.join(", "));
    (known(classes[best], classes[best], classes[best], grade, &reason), condition)
}

/// Slides of one wheelset, or summed over a wagon.
pub(crate) fn slides(slides: &Slides, settings: &SlideSettings) -> Indicator {
    let energy = large(slides.recent_energy_j, settings.energy_watch_j, settings.energy_act_j);
    let locked = large(slides.recent_locked_s, settings.locked_watch_s, settings.locked_act_s);
    let count = slides.count;
    let total = format!("{count:.0} with {:.0} kJ in {:.1} s", slides.energy_j * 1e-3, slides.seconds);
    let reason = match energy.max(locked) {
        Grade::Ok if count == 0.0 => "none".to_owned(),
        Grade::Ok => total,
        _ if locked >= energy => {
            format!("risk of wheel flats: locked for {:.1} s lately; {total}", slides.recent_locked_s)
        }
        _ => format!("risk of wheel flats: {:.1} MJ lately; {total}", slides.recent_energy_j * 1e-6),
    };
    known(count, count, count, energy.max(locked), &reason)
}

/// Share of the braking time with slide protection. On low rail it does its work; only what it does elsewhere is judged.
pub(crate) fn wsp(share: Option<f64>, elsewhere: Option<f64>, settings: &IndicatorSettings) -> Indicator {
    let Some(share) = share else { return unknown("no braking yet") };
    let percent = 100.0 * share;
    let Some(elsewhere) = elsewhere else {
        let reason = format!("active in {percent:.0} % of the latest braking, all of it on low rail");
        return known(share, share, share, Grade::Ok, &reason);
    };
    let grade = large(elsewhere, settings.wsp.share_watch, settings.wsp.share_act);
    let reason = format!(
        "active in {percent:.0} % of the latest braking, in {:.0} % of the braking on good rail",
        100.0 * elsewhere
    );
    known(share, share, share, grade, &reason)
}

/// Share of sensor values missing, refused or dead, with the faulty ones by name (true: dead ones among them).
pub(crate) fn sensors(
    missing: Option<f64>,
    refused: Option<f64>,
    dead: Option<f64>,
    faulty: Option<(bool, String)>,
    settings: &IndicatorSettings,
) -> Indicator {
    let Some((missing, refused)) = missing.zip(refused) else { return unknown("no samples yet") };
    let dead = dead.unwrap_or_default();
    let share = (missing + refused + dead).min(1.0);
    let mut grade = large(share, settings.sensors.faulty_share_watch, settings.sensors.faulty_share_act);
    if faulty.as_ref().is_some_and(|(any_dead, _)| *any_dead) {
        grade = Grade::Act;
    }
    let named = faulty.map_or_else(String::new, |(_, words)| format!("{words}: "));
    let reason = format!(
        "{named}{:.1} % of the values missing, {:.1} % refused, {:.1} % dead",
        100.0 * missing,
        100.0 * refused,
        100.0 * dead
    );
    known(share, share, share, grade, &reason)
}

/// Mean normalised innovation squared over its degrees of freedom.
pub(crate) fn filter(ratio: Option<f64>, settings: &IndicatorSettings) -> Indicator {
    let Some(ratio) = ratio else { return unknown("no innovations yet") };
    let limits = &settings.filter;
    let (grade, words) = if ratio > limits.nis_act_high {
        (Grade::Act, "model and data disagree")
    } else if ratio > limits.nis_watch_high {
        (Grade::Watch, "model and data differ more than the sensors explain")
    } else if ratio < limits.nis_watch_low {
        (Grade::Watch, "data are calmer than the declared sensors")
    } else {
        (Grade::Ok, "model and data agree")
    };
    known(ratio, ratio, ratio, grade, &format!("{words}: innovation ratio {ratio:.2}, ideal 1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(value: f64, half_width: f64) -> Option<Mean> {
        Some(Mean { value, sigma: half_width / 1.96, half_width })
    }

    fn friction(value: f64, half_width: f64) -> Indicator {
        brake_friction(
            mean(value, half_width),
            42.0,
            0.35,
            &BrakeFrictionSettings::default(),
            "no braking yet",
        )
    }

    #[test]
    fn brake_friction_is_judged_by_the_sure_end_of_its_interval() {
        let cases = [
            (0.350, 0.005, Grade::Ok, "as it should be"),
            (0.280, 0.005, Grade::Watch, "low"),
            (0.290, 0.030, Grade::Ok, "as it should be"),
            (0.200, 0.005, Grade::Act, "far too low"),
            (0.450, 0.005, Grade::Watch, "high"),
            (0.600, 0.010, Grade::Act, "far too high"),
            (0.350, 0.300, Grade::Unknown, "too uncertain"),
        ];
        for (value, half_width, grade, words) in cases {
            let indicator = friction(value, half_width);
            println!("{}", indicator.reason);
            assert_eq!(indicator.grade(), grade, "{value} ± {half_width}");
            assert!(indicator.reason.as_str().starts_with(words), "{}", indicator.reason);
        }
        let reason = friction(0.280, 0.005).reason;
        assert_eq!(reason.as_str(), "low: 0.280 ± 0.007 over 42 s of braking, 80 % of nominal 0.350");
        let settings = BrakeFrictionSettings::default();
        let early = brake_friction(mean(0.2, 0.01), 1.0, 0.35, &settings, "no braking yet");
        assert_eq!(
            (early.grade(), early.figure(), early.reason.as_str()),
            (Grade::Unknown, None, "no braking yet")
        );
    }

    #[test]
    fn asymmetry_names_the_weaker_end() {
        let judge = |difference, half| {
            asymmetry(mean(difference, half), 10.0, mean(0.35, 0.01), &AsymmetrySettings::default(), 3.0)
        };
        assert_eq!(judge(0.01, 0.02).grade(), Grade::Ok);
        let front = judge(-0.08, 0.01);
        assert_eq!(front.grade(), Grade::Watch);
        assert!(front.reason.as_str().starts_with("front brakes less"), "{}", front.reason);
        assert_eq!(judge(0.20, 0.02).grade(), Grade::Act);
        assert_eq!(judge(0.05, 0.2).grade(), Grade::Unknown);
    }

    #[test]
    fn every_reason_fits_into_its_field() {
        let settings = IndicatorSettings::default();
        let worst = Slides {
            count: 99_999.0,
            energy_j: 9e12,
            seconds: 1e6,
            recent_energy_j: 9e12,
            recent_locked_s: 99_999.0,
            ..Slides::default()
        };
        let all = [
            friction(0.2, 0.001),
            rail([0.05, 0.05, 0.45, 0.45], &settings.adhesion).0,
            rail([0.25; 4], &AdhesionSettings { low_probability_watch: 0.9, ..settings.adhesion }).0,
            slides(&worst, &settings.slides),
            filter(Some(1e9), &settings),
            filter(Some(0.1), &settings),
            sensors(Some(0.5), Some(0.5), None, Some((true, "pressing force 2 dead".to_owned())), &settings),
        ];
        for indicator in all {
            println!("{} {}", indicator.reason.as_str().len(), indicator.reason);
            assert!(indicator.reason.as_str().len() < Text::CAPACITY, "{}", indicator.reason);
        }
    }
}
