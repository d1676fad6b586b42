//! What sand does, now or in the last test of the sanders.

use super::judging::{known, unknown};
use crate::measure::sanding::Gain;
use crate::settings::SandingSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach};
use railgrip_messages::{Grade, Indicator};

/// Adhesion in slides with sand over adhesion in slides without.
pub static SANDING: IndicatorSpec = IndicatorSpec {
    id: "sanding",
    form: Form::FACTOR,
    judge: Judge {
        wagon: Some(|seen, _| judge(seen.state.sanding.gain(), &seen.settings.sanding)),
        ..Judge::NONE
    },
    limit: Some(|settings, _| {
        let watch = settings.sanding.factor_watch;
        Limit { watch_low: Some(watch), ..Limit::free(0.0, 3.0 * watch) }
    }),
    alert: Some(AlertRule {
        of_free_wagon: true,
        ..AlertRule::of(
            "sanding",
            Reach::Wagon,
            Advice::same("Check sand level, nozzles and heating: sand does not raise adhesion."),
        )
    }),
    metric: Some(Metric::gauge(
        "sanding_gain_ratio",
        "Adhesion in slides with sand over adhesion in slides without",
    )),
    meaning: Meaning {
        name: "Sand: gain of grip",
        definition: "Adhesion in slides with sand over adhesion in slides without, within a short time. Sanding for at least two seconds while wheelsets slide is a test of the sanders; its result stays, with its date, until the next one.",
        unit: "a factor",
        interval: "95 %, from the scatter of both",
        limits: |settings, _| {
            format!("Watch when the upper end of the interval is below {:.1}.", settings.sanding.factor_watch)
        },
        cannot_see: "Sand that falls where no wheelset slides, or a rail that changes between the slides compared.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// What sand does.
fn judge(gain: Option<Gain>, settings: &SandingSettings) -> Indicator {
    let Some(Gain { value, low, high, tested_unix_ns }) = gain else {
        return unknown("needs slides with and without sand within a short time");
    };
    let (grade, words) = if high < settings.factor_watch {
        (Grade::Watch, "sand has no effect")
    } else if low > 1.0 {
        (Grade::Ok, "sand helps")
    } else {
        (Grade::Unknown, "too uncertain to judge")
    };
    let found = format!("{words}: with sand {value:.2} times the adhesion without, {low:.2} to {high:.2}");
    let reason = tested_unix_ns.map_or(found.clone(), |at| format!("{found}; tested on {}", day(at)));
    known(value, low, high, grade, &reason)
}

/// The day of an instant in UTC, `2026-03-01`. After Hinnant, "chrono-compatible low-level date algorithms": years begin in
/// March, so that the leap day is their last, and 400 of them have 146 097 days.
fn day(unix_ns: i64) -> String {
    let days = unix_ns.div_euclid(86_400_000_000_000) + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = 400 * era + year_of_era + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Text;

    #[test]
    fn a_test_is_told_with_its_interval_and_its_day() {
        let gain = |high: f64, tested_unix_ns| Some(Gain { value: 1.05, low: 1.01, high, tested_unix_ns });
        let tested = judge(gain(1.09, Some(1_772_366_400_000_000_000)), &SandingSettings::default());
        let said = "sand has no effect: with sand 1.05 times the adhesion without, 1.01 to 1.09; tested on 2026-03-01";
        assert_eq!((tested.reason.as_str(), tested.grade()), (said, Grade::Watch));
        assert!(said.len() < Text::CAPACITY);
        let running = judge(gain(1.2, None), &SandingSettings::default());
        assert!(running.reason.as_str().ends_with("1.01 to 1.20") && running.grade() == Grade::Ok);
        for (unix_s, text) in [
            (0, "1970-01-01"),
            (951_782_400, "2000-02-29"),
            (951_868_800, "2000-03-01"),
            (4_107_542_399, "2100-02-28"),
            (4_107_542_400, "2100-03-01"),
        ] {
            assert_eq!(day(unix_s * 1_000_000_000), text);
        }
    }
}
