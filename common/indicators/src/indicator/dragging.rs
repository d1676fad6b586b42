//! Brakes that do not release.

use super::judging::{known, large, unknown};
use crate::settings::DraggingSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Unit};
use railgrip_messages::{Grade, Indicator};

/// Force that holds the wagon back while its brakes are released.
pub static DRAGGING: IndicatorSpec = IndicatorSpec {
    id: "dragging",
    unit: Unit::Newtons,
    form: Form::KILONEWTONS,
    judge: Judge {
        wagon: Some(|seen, _| {
            judge(seen.state.dragging.drag(), seen.nominal.weight_n(), &seen.settings.dragging)
        }),
        ..Judge::NONE
    },
    limit: Some(|settings, nominal| {
        let dragging = &settings.dragging;
        let share = Limit {
            scale: (-0.4 * dragging.act, 1.6 * dragging.act),
            ..Limit::above(1.0, dragging.watch, dragging.act)
        };
        share.times(nominal.weight_n())
    }),
    alert: Some(AlertRule {
        of_free_wagon: true,
        inhibited_by: &["sensors"],
        ..AlertRule::of(
            "dragging",
            Reach::Wagon,
            Advice {
                wagon: "Look for a brake that does not release: hot discs, handbrake, release valve.",
                train: "Most wagons are held back: check for an applied brake, a wrong gradient or headwind before single wagons.",
            },
        )
    }),
    trend: Reach::Wagon,
    metric: Some(Metric::gauge(
        "brake_dragging_newtons",
        "Retarding force while the brakes are released, beyond running resistance",
    )),
    meaning: Meaning {
        name: "Drag when released",
        definition: "Force that holds the wagon back while its brakes are released, beyond running resistance and gradient.",
        unit: "kN",
        interval: "95 %, allowing for wind, load and gradient",
        limits: |settings, _| {
            let dragging = &settings.dragging;
            format!(
                "Watch above {:.1} %, act above {:.1} % of the weight, at the lower end of the interval; needs {:.0} s of running with released brakes.",
                100.0 * dragging.watch,
                100.0 * dragging.act,
                dragging.min_released_s
            )
        },
        cannot_see: "In a coupled train the couplers spread the drag of one wagon, so every wagon shows a part of it.",
        ..Meaning::PLAIN
    },
    formerly: &["dragging"],
    ..IndicatorSpec::PLAIN
};

/// Retarding force while the brakes are released; `weight_n` turns shares into forces.
fn judge(drag: Option<(f64, f64, f64)>, weight_n: f64, settings: &DraggingSettings) -> Indicator {
    let limits = settings;
    let Some((share, half, seconds)) = drag.filter(|(_, _, seconds)| *seconds >= limits.min_released_s)
    else {
        return unknown("needs running with released brakes");
    };
    let grade = large(share - half, limits.watch, limits.act);
    let figure = format!("{:+.1} ± {:.1} kN while released", 1e-3 * share * weight_n, 1e-3 * half * weight_n);
    let (grade, words) = match grade {
        Grade::Ok if half > limits.act => (Grade::Unknown, "too uncertain to judge"),
        Grade::Ok => (Grade::Ok, "runs freely"),
        grade => (grade, "a brake drags, or another force holds the wagon back"),
    };
    let (value, half) = (share * weight_n, half * weight_n);
    known(value, value - half, value + half, grade, &format!("{words}: {figure}, {seconds:.0} s"))
}
