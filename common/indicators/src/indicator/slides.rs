//! Slides and the risk of wheel flats.

use super::judging::{known, large, unknown};
use crate::measure::slides::Slides;
use crate::observed::Observed;
use crate::settings::SlideSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Meaning, Metric, Reach, Stored, Unit};
use railgrip_messages::{Grade, Indicator};

/// Slides counted, judged by their energy and by the time locked.
pub static SLIDES: IndicatorSpec = IndicatorSpec {
    id: "slides",
    unit: Unit::Count,
    form: Form::COUNT,
    judge: Judge {
        wagon: Some(|seen, _| match seen.state.samples {
            0 => unknown("no samples yet"),
            _ => judge(&all(seen), &seen.settings.slides),
        }),
        wheelset: Some(|seen, index| judge(&seen.state.wheelset[index].slides, &seen.settings.slides)),
        ..Judge::NONE
    },
    alert: Some(AlertRule {
        of_free_wagon: true,
        inhibited_by: &["sensors"],
        ..AlertRule::of(
            "slides",
            Reach::Wheelsets,
            Advice {
                wagon: "Listen for wheel flats and inspect the treads of this wagon.",
                train: "The train slid hard: inspect the treads of all listed wheelsets for flats.",
            },
        )
    }),
    stored: Stored::Value,
    metric: Some(Metric { name: "slides", help: "Slides", counter: true, reach: Reach::Wheelsets }),
    meaning: Meaning {
        name: "Slides",
        block: "health assessment",
        definition: "Number of slides, the energy they put into tread and rail, and the time with a locked wheelset. They show the risk of wheel flats.",
        unit: "number; J; s",
        interval: "none: they are counted",
        limits: |settings, _| {
            let slides = &settings.slides;
            format!(
                "For one wheelset, recently: watch above {:.0} MJ or {:.0} s locked, act above {:.0} MJ or {:.0} s.",
                1e-6 * slides.energy_watch_j,
                slides.locked_watch_s,
                1e-6 * slides.energy_act_j,
                slides.locked_act_s
            )
        },
        cannot_see: "The shape of the wheel itself, and slides shorter than a tenth of a second.",
    },
    ..IndicatorSpec::PLAIN
};

/// Slides of all wheelsets, with the worst wheelset's risk: flats form on one wheel, not on the sum.
fn all(seen: &Observed) -> Slides {
    let mut sum = Slides::default();
    let wheelsets = &seen.state.wheelset[..seen.last.wheelset_count()];
    for slides in wheelsets.iter().map(|wheelset| &wheelset.slides) {
        sum.count += slides.count;
        sum.energy_j += slides.energy_j;
        sum.seconds += slides.seconds;
        sum.recent_energy_j = sum.recent_energy_j.max(slides.recent_energy_j);
        sum.recent_locked_s = sum.recent_locked_s.max(slides.recent_locked_s);
    }
    sum
}

/// Slides of one wheelset, or summed over a wagon.
fn judge(slides: &Slides, settings: &SlideSettings) -> Indicator {
    let energy = large(slides.recent_energy_j, settings.energy_watch_j, settings.energy_act_j);
    let locked = large(slides.recent_locked_s, settings.locked_watch_s, settings.locked_act_s);
    let count = slides.count;
    let total = format!("{count:.0} with {:.0} kJ in {:.1} s", slides.energy_j * 1e-3, slides.seconds);
    let reason = match energy.max(locked) {
        Grade::Ok if count == 0.0 => "none".to_owned(),
        Grade::Ok => total,
        _ if locked >= energy => {
            format!("risk of wheel flats: locked for {:.1} s recently; {total}", slides.recent_locked_s)
        }
        _ => format!("risk of wheel flats: {:.1} MJ recently; {total}", slides.recent_energy_j * 1e-6),
    };
    known(count, count, count, energy.max(locked), &reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Text;

    #[test]
    fn every_reason_fits_into_its_field() {
        let worst = Slides {
            count: 99_999.0,
            energy_j: 9e12,
            seconds: 1e6,
            recent_energy_j: 9e12,
            recent_locked_s: 99_999.0,
            ..Slides::default()
        };
        let judged = judge(&worst, &SlideSettings::default());
        assert!(judged.reason.as_str().len() < Text::CAPACITY, "{}", judged.reason);
    }
}
