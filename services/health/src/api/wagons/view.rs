//! From the messages of a wagon to what the API says of it.

use crate::api::figure::{Freshness, figure, known, rounded};
use crate::api::figures::Figures;
use crate::api::grade::{Condition, Grade};
use crate::api::processes::process;
use crate::api::wagons::model::{Present, WagonRow, WagonView, WheelsetPresent, WheelsetView};
use crate::time::rfc3339;
use railgrip_indicators::indicator::{ADHESION_AVAILABLE, ASYMMETRY, BRAKE_FRICTION, SLIDES};
use railgrip_indicators::{Judged, Table};
use railgrip_messages::{Health, Heartbeat, valid};

/// Which wagon.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Who<'a> {
    /// Its place in the train, 1 first.
    pub id: u32,
    /// Its name.
    pub name: &'a str,
    /// The number of its vehicle, where it has one.
    pub vehicle: Option<&'a str>,
}

/// The worst grade of a wagon and where it comes from.
fn verdict(table: Table, health: Option<&Health>, fresh: Freshness) -> (Grade, String) {
    let Some(health) = health.filter(|_| fresh.is_live()) else { return (Grade::Unknown, fresh.reason()) };
    let grade = health.grade();
    // The first of the worst: the order of the table is that of importance.
    let own = |judged: &Judged<'_>| !judged.spec.is_of_train() && judged.indicator.grade() == grade;
    let worst = table.judged(health).into_iter().find(own);
    let reason = match worst {
        Some(_) if grade == railgrip_messages::Grade::Ok => "everything known is as it should be".to_owned(),
        Some(judged) => {
            let place = judged.wheelset.map_or_else(String::new, |number| format!(" of wheelset {number}"));
            format!("{}{place}: {}", judged.spec.name(), judged.indicator.reason)
        }
        None => "no indicator is known yet".to_owned(),
    };
    (grade.into(), reason)
}

/// The indicators of a wagon; those that only its neighbours can judge are unknown here.
fn figures(table: Table, health: &Health, fresh: Freshness) -> Figures {
    let shown = table.iter().filter(|spec| spec.judge.wagon.is_some() || spec.judge.among.is_some());
    Figures(shown.map(|spec| (spec, figure(table.wagon(health, spec), fresh))).collect())
}

fn condition(health: &Health) -> Option<Condition> {
    (health.samples > 0)
        .then(|| railgrip_messages::Condition::from_code(health.condition))
        .flatten()
        .map(Into::into)
}

/// One line about a wagon.
pub(crate) fn row(table: Table, who: Who<'_>, health: Option<&Health>, fresh: Freshness) -> WagonRow {
    let (grade, reason) = verdict(table, health, fresh);
    let of = |spec| health.and_then(|health| table.wagon(health, spec).figure()).map(rounded);
    let live = health.filter(|_| fresh.is_live());
    let wheelsets = || live.map(|health| &health.wheelset[..health.wheelset_count()]);
    WagonRow {
        id: who.id,
        name: who.name.to_owned(),
        vehicle_number: who.vehicle.map(str::to_owned),
        state: fresh.state,
        age_s: fresh.age_s,
        grade,
        reason,
        v_m_s: live.and_then(|health| known(health.v_m_s)),
        adhesion: live.and_then(|health| known(health.mu_w)),
        adhesion_available: live.and_then(|_| of(&ADHESION_AVAILABLE)),
        adhesion_available_is_lower_bound: live.map(|health| health.adhesion_available_is_bound != 0),
        condition: live.and_then(condition),
        brake_friction: of(&BRAKE_FRICTION),
        asymmetry: of(&ASYMMETRY),
        sliding: wheelsets().map(|all| all.iter().any(|wheelset| wheelset.sliding != 0)),
        wsp_active: wheelsets().map(|all| all.iter().any(|wheelset| wheelset.wsp_active != 0)),
    }
}

/// Everything about a wagon.
pub(crate) fn wagon(
    table: Table,
    who: Who<'_>,
    health: Option<&Health>,
    estimator: Option<&Heartbeat>,
    fresh: Freshness,
    now_ns: u64,
) -> WagonView {
    let (grade, reason) = verdict(table, health, fresh);
    let acquired_at = health.map(|health| rfc3339(health.acquired.unix_ns));
    let nothing = Health::default();
    let health = health.unwrap_or(&nothing);
    let now = fresh.is_live().then(|| Present {
        v_m_s: known(health.v_m_s),
        position_m: known(health.position_m).filter(|position_m| *position_m != 0.0),
        adhesion: known(health.mu_w),
        adhesion_sigma: known(health.mu_w_sigma),
        brake_friction_now: known(health.mu_b_mean),
        brake_friction_now_sigma: known(health.mu_b_mean_sigma),
        pressing_force_n: known(health.pressing_force_n),
        sand: known(health.sanding_now),
    });
    let condition = condition(health);
    let share = |share: f64| condition.map(|_| rounded(share));
    let [rail_dry, rail_wet, rail_low, rail_very_low] = health.condition_probability.map(share);
    WagonView {
        id: who.id,
        name: who.name.to_owned(),
        vehicle_number: who.vehicle.map(str::to_owned),
        state: fresh.state,
        age_s: fresh.age_s,
        acquired_at,
        grade,
        reason,
        now,
        indicators: figures(table, health, fresh),
        adhesion_available_is_lower_bound: health.adhesion_available_is_bound != 0,
        condition: condition.filter(|_| fresh.is_live()),
        rail_dry,
        rail_wet,
        rail_low,
        rail_very_low,
        acoustic: None,
        faulty_sensors: if fresh.is_live() { faulty_sensors(health) } else { Vec::new() },
        brake_applications: health.brake_applications,
        brake_applied_at: (health.brake_applied.unix_ns > 0).then(|| rfc3339(health.brake_applied.unix_ns)),
        braking_s: rounded(health.braking_s),
        samples: health.samples,
        samples_missed: health.missed,
        outputs_rejected: health.rejected,
        wheelsets: (0..health.wheelset_count()).map(|index| wheelset(table, health, index, fresh)).collect(),
        estimator: estimator.map(|beat| process(beat, who.vehicle, now_ns)),
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

fn wheelset(table: Table, wagon: &Health, index: usize, fresh: Freshness) -> WheelsetView {
    let health = &wagon.wheelset[index];
    let now = fresh.is_live().then(|| WheelsetPresent {
        adhesion: known(health.mu_w),
        adhesion_sigma: known(health.mu_w_sigma),
        brake_friction_now: known(health.mu_b),
        brake_friction_now_sigma: known(health.mu_b_sigma),
        observable: health.observable != 0,
        creepage: known(health.slip),
        sliding: health.sliding != 0,
        wsp_active: health.wsp_active != 0,
    });
    let friction = table.wheelset(wagon, index, &BRAKE_FRICTION).figure();
    let figure = |spec| (spec, figure(table.wheelset(wagon, index, spec), fresh));
    let indicators = Figures(table.of_wheelset().map(figure).collect());
    let shown = [&BRAKE_FRICTION, &SLIDES].into_iter().filter_map(|spec| indicators.get(spec));
    WheelsetView {
        id: index as u32 + 1,
        grade: shown.map(|figure| figure.grade).max().unwrap_or(Grade::Unknown),
        now,
        indicators,
        brake_friction_to_nominal: friction.and_then(|_| known(health.brake_friction_ratio)),
        adhesion_available_is_lower_bound: health.adhesion_available_is_bound != 0,
        slide_energy_j: rounded(health.slide_energy_j),
        slide_s: rounded(health.slide_s),
    }
}
