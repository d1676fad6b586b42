//! From the messages of a wagon to what the API says of it.

use crate::api::figure::{Freshness, figure, known, rounded};
use crate::api::grade::{Condition, Grade};
use crate::api::processes::process;
use crate::api::wagons::model::{Present, RailView, WagonRow, WagonView, WheelsetPresent, WheelsetView};
use crate::time::rfc3339;
use railgrip_messages::{Health, Heartbeat, Indicator, WheelsetHealth, valid};

/// The indicators of a wagon that are judged, by the name of their cause.
pub(crate) fn judged(health: &Health) -> Vec<(&'static str, Option<u32>, &Indicator)> {
    let mut all = vec![
        ("brake_friction", None, &health.brake_friction),
        ("asymmetry", None, &health.asymmetry),
        ("rail", None, &health.rail),
        ("wsp_share", None, &health.wsp_share),
        ("sensors", None, &health.sensors),
        ("filter", None, &health.filter),
        ("model", None, &health.model),
        ("response", None, &health.response),
        ("dragging", None, &health.dragging),
        ("sanding", None, &health.sanding),
    ];
    for (index, wheelset) in health.wheelset[..health.wheelset_count()].iter().enumerate() {
        let number = Some(index as u32 + 1);
        all.push(("brake_friction", number, &wheelset.brake_friction));
        all.push(("slides", number, &wheelset.slides));
        all.push(("isolated", number, &wheelset.isolated));
    }
    all
}

/// The worst grade of a wagon and where it comes from.
fn verdict(health: Option<&Health>, fresh: Freshness) -> (Grade, String) {
    let Some(health) = health.filter(|_| fresh.is_live()) else { return (Grade::Unknown, fresh.reason()) };
    let grade = health.grade();
    // The first of the worst: the order of `judged` is that of importance.
    let worst = judged(health).into_iter().find(|(_, _, indicator)| indicator.grade() == grade);
    let reason = match worst {
        Some(_) if grade == railgrip_messages::Grade::Ok => "everything known is as it should be".to_owned(),
        Some((cause, wheelset, indicator)) => {
            let place = wheelset.map_or_else(String::new, |number| format!(" of wheelset {number}"));
            format!("{}{place}: {}", cause.replace('_', " "), indicator.reason)
        }
        None => "no indicator is known yet".to_owned(),
    };
    (grade.into(), reason)
}

fn condition(health: &Health) -> Option<Condition> {
    (health.samples > 0)
        .then(|| railgrip_messages::Condition::from_code(health.condition))
        .flatten()
        .map(Into::into)
}

/// One line about a wagon.
pub(crate) fn row(id: u32, name: &str, health: Option<&Health>, fresh: Freshness) -> WagonRow {
    let (grade, reason) = verdict(health, fresh);
    let live = health.filter(|_| fresh.is_live());
    let wheelsets = || live.map(|health| &health.wheelset[..health.wheelset_count()]);
    WagonRow {
        id,
        name: name.to_owned(),
        state: fresh.state,
        age_s: fresh.age_s,
        grade,
        reason,
        v_m_s: live.and_then(|health| known(health.v_m_s)),
        adhesion_utilised: live.and_then(|health| known(health.mu_w.abs())),
        adhesion_available: live.and_then(|health| health.adhesion_available.figure()).map(rounded),
        adhesion_available_is_lower_bound: live.map(|health| health.adhesion_available_is_bound != 0),
        condition: live.and_then(condition),
        brake_friction: health.and_then(|health| health.brake_friction.figure()).map(rounded),
        asymmetry: health.and_then(|health| health.asymmetry.figure()).map(rounded),
        sliding: wheelsets().map(|all| all.iter().any(|wheelset| wheelset.sliding != 0)),
        wsp_active: wheelsets().map(|all| all.iter().any(|wheelset| wheelset.wsp_active != 0)),
    }
}

/// Everything about a wagon.
pub(crate) fn wagon(
    id: u32,
    name: &str,
    health: Option<&Health>,
    estimator: Option<&Heartbeat>,
    fresh: Freshness,
    now_ns: u64,
) -> WagonView {
    let (grade, reason) = verdict(health, fresh);
    let acquired_at = health.map(|health| rfc3339(health.acquired.unix_ns));
    let nothing = Health::default();
    let health = health.unwrap_or(&nothing);
    let now = fresh.is_live().then(|| Present {
        v_m_s: known(health.v_m_s),
        position_m: known(health.position_m).filter(|position_m| *position_m != 0.0),
        adhesion: known(health.mu_w),
        adhesion_sigma: known(health.mu_w_sigma),
        brake_friction: known(health.mu_b_mean),
        brake_friction_sigma: known(health.mu_b_mean_sigma),
    });
    let wheelsets = health.wheelset[..health.wheelset_count()].iter().enumerate();
    WagonView {
        id,
        name: name.to_owned(),
        state: fresh.state,
        age_s: fresh.age_s,
        acquired_at,
        grade,
        reason,
        now,
        brake_friction: figure(&health.brake_friction, fresh),
        asymmetry: figure(&health.asymmetry, fresh),
        adhesion_utilised: figure(&health.adhesion_utilised, fresh),
        adhesion_available: figure(&health.adhesion_available, fresh),
        adhesion_available_is_lower_bound: health.adhesion_available_is_bound != 0,
        rail: rail(health, fresh),
        acoustic: None,
        slides: figure(&health.slides, fresh),
        wsp_share: figure(&health.wsp_share, fresh),
        sensors: figure(&health.sensors, fresh),
        filter: figure(&health.filter, fresh),
        brake_friction_standard: figure(&health.brake_friction_standard, fresh),
        response: figure(&health.response, fresh),
        brake_delay: figure(&Indicator::default(), fresh),
        dragging: figure(&health.dragging, fresh),
        isolated: figure(&health.isolated, fresh),
        sanding: figure(&health.sanding, fresh),
        model: figure(&health.model, fresh),
        faulty_sensors: if fresh.is_live() { faulty_sensors(health) } else { Vec::new() },
        brake_applications: health.brake_applications,
        brake_applied_at: (health.brake_applied.unix_ns > 0).then(|| rfc3339(health.brake_applied.unix_ns)),
        braking_s: rounded(health.braking_s),
        samples: health.samples,
        samples_missed: health.missed,
        outputs_rejected: health.rejected,
        wheelsets: wheelsets.map(|(index, health)| wheelset(index as u32 + 1, health, fresh)).collect(),
        estimator: estimator.map(|beat| process(beat, now_ns)),
    }
}

/// Names of the sensors that are missing, refused or dead.
fn faulty_sensors(health: &Health) -> Vec<String> {
    let bad = |bit: u32| health.faulty_sensors & bit != 0;
    let mut names = Vec::new();
    if bad(valid::SPEED) {
        names.push("train speed".to_owned());
    }
    for index in 0..health.wheelset_count() {
        if bad(valid::wheel_speed(index)) {
            names.push(format!("wheel speed {}", index + 1));
        }
        if bad(valid::pressing_force(index)) {
            names.push(format!("pressing force {}", index + 1));
        }
    }
    names
}

fn rail(health: &Health, fresh: Freshness) -> RailView {
    let judged = figure(&health.rail, fresh);
    let condition = condition(health);
    let share = |share: f64| condition.map(|_| rounded(share));
    let [dry, wet, low, very_low] = health.condition_probability.map(share);
    let condition = condition.filter(|_| fresh.is_live());
    RailView { condition, dry, wet, low, very_low, grade: judged.grade, reason: judged.reason }
}

fn wheelset(id: u32, health: &WheelsetHealth, fresh: Freshness) -> WheelsetView {
    let now = fresh.is_live().then(|| WheelsetPresent {
        adhesion: known(health.mu_w),
        adhesion_sigma: known(health.mu_w_sigma),
        brake_friction: known(health.mu_b),
        brake_friction_sigma: known(health.mu_b_sigma),
        observable: health.observable != 0,
        creepage: known(health.slip),
        sliding: health.sliding != 0,
        wsp_active: health.wsp_active != 0,
    });
    WheelsetView {
        id,
        now,
        brake_friction: figure(&health.brake_friction, fresh),
        brake_friction_to_nominal: health
            .brake_friction
            .figure()
            .and_then(|_| known(health.brake_friction_ratio)),
        brake_friction_standard: figure(&health.brake_friction_standard, fresh),
        isolated: figure(&health.isolated, fresh),
        adhesion_utilised: figure(&health.adhesion_utilised, fresh),
        adhesion_available: figure(&health.adhesion_available, fresh),
        adhesion_available_is_lower_bound: health.adhesion_available_is_bound != 0,
        slides: figure(&health.slides, fresh),
        slide_energy_j: rounded(health.slide_energy_j),
        slide_s: rounded(health.slide_s),
        wsp_share: figure(&health.wsp_share, fresh),
    }
}
