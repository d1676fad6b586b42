//! What to do about a finding: at the vehicle, in the model, and with the next run.

use super::sentences::likelier;
use crate::answer::schema::{Report, Verdict};
use railgrip_words::{reword, say, t, word};

/// What an effect asks for at the vehicle or in its data, by id and else by term.
const AT_THE_VEHICLE: &[(&str, &str)] = &[
    ("dragging_brake", "Look at the brake of this wheelset: it does not let go."),
    (
        "wheel_radius",
        "Measure the wheel diameters and correct the vehicle file or the speed sensor's setting.",
    ),
    (
        "speed_scale",
        "Have the vehicle's speed measurement checked: wheel diameter that is set, radar or receiver.",
    ),
    (
        "speed_latency",
        "Find out where vehicle speed is delayed (receiver, filter, time stamps) before you trust it in a stop.",
    ),
    (
        "clock_skew",
        "Check the clocks of the loggers: wheelset speeds and vehicle speed do not run on one time.",
    ),
    ("wheel_encoder_eccentricity", "Have the wheelset speed sensor's target wheel checked for run-out."),
    (
        "wheel_encoder_window",
        "Look up the averaging of the wheelset speed sensor; a shorter one shows slides earlier.",
    ),
    ("mass_error", "Weigh the wagon, or correct its mass in the vehicle file."),
    (
        "rotating_inertia",
        "Correct the wheelsets' inertia in the vehicle file; motors and gears belong to it.",
    ),
    ("load_transfer", "Check the height of the centre of gravity and the wheelbase in the vehicle file."),
    ("grade", "Check the grade of this stretch in the track map."),
    ("low_adhesion_patch", "Report this stretch of track: it is slippery."),
    ("coupler_force", "Record the wagon uncoupled, or record its neighbour, too: something pulls at it."),
    ("pressing_force_offset", "Check return springs, rigging and the zero of the brake-pressure sensor."),
    ("rigging_hysteresis", "Check the brake rigging for stiff joints."),
    (
        "pressure_dump",
        "Log the dump valves, or measure pressure behind them: the slide protection vents there.",
    ),
    (
        "cast_iron",
        "If the wagon has cast-iron blocks, say so in the vehicle file; if not, have the pads looked at.",
    ),
    ("brake_lag", "If the lag is new, check cylinder and rigging; if it always was, the model lacks it."),
    ("axle_torsion", "Look at the drivetrain or axle for a vibration at this frequency."),
    ("brake_friction", "Nothing needs repair: pads behave so. The model lacks the law."),
    ("adhesion", "Nothing needs repair: rail and wheel behave so. The model lacks the law."),
    ("resistance", "Check running resistance, wind and grade of the day against the vehicle file."),
];

/// What to do, in order.
pub fn advice(report: &Report) -> Vec<String> {
    let mut steps: Vec<String> = Vec::new();
    for effect in &report.effects {
        let by = |key: &str| AT_THE_VEHICLE.iter().find(|(name, _)| *name == key).map(|(_, step)| word(step));
        if let Some(step) = by(&effect.id).or_else(|| by(&effect.term)).filter(|step| !steps.contains(step)) {
            steps.push(step);
        }
    }
    match report.verdict {
        Verdict::None if likelier(report).is_some() => steps.push(
            t("Nothing at the vehicle yet. Record more runs, above all unlike these, and diagnose them together: nothing is settled.").to_owned(),
        ),
        Verdict::None => steps.push(
            t("Nothing at the vehicle. Go on with the calibrated model: --apply writes it as a vehicle file.").to_owned(),
        ),
        Verdict::Effects if report.carries_over == Some(false) => steps.push(
            t("Do not put it into the model yet: the runs that were only predicted are no better for it.").to_owned(),
        ),
        Verdict::Effects | Verdict::EffectsAndUnknown => steps.push(
            t("Put it into the model: --apply FILE writes the vehicle file with the effect in it; simulate, estimate and up load it.")
                .to_owned(),
        ),
        Verdict::Unknown => steps.push(t("Put nothing into the model yet: no known law fits.").to_owned()),
    }
    if let Some(next) = &report.next_run {
        // Ids stand in it as words.
        let next = reword(&next.replace('_', " "));
        steps.push(say("Next run: {text}", &[("text", &next)]));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_of_the_catalogue_has_a_step_at_the_vehicle() {
        for (spec, _) in railgrip_vehicle::effects::all() {
            let named = |key: &str| AT_THE_VEHICLE.iter().any(|(name, _)| *name == key);
            assert!(named(spec.id) || named(spec.term.name()), "{}", spec.id);
        }
    }
}
