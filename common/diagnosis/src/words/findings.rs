//! What was found, as a sentence with its number: one line of a table for each effect of the catalogue.

use super::format::{capital, number, number_to, plain, rounded};
use super::parameters::{estimate, shown, with_word};
use crate::answer::schema::{FoundEffect, ParameterEstimate};
use railgrip_words::{say, t};
use std::fmt::Display;

/// Ambient from which disc temperatures are counted, °C.
pub const AMBIENT_C: f64 = 20.0;
/// Speed at which an added resistance is told, m/s.
const TOLD_SPEED_M_S: f64 = 20.0;
/// Pressing forces between which the fall of friction is told, N.
const TOLD_FORCES_N: [f64; 2] = [25e3, 50e3];

/// An effect as a clause that a sentence can begin with, such as `vehicle speed reads 1.4 % low (1.4–1.5)`. Effects or
/// forms that the table does not know are named.
pub fn finding(effect: &FoundEffect) -> String {
    of_catalogue(effect).unwrap_or_else(|| say("the model lacks {one}", &[("one", &plain(&effect.id))]))
}

/// The finding as the beginning of a sentence.
pub fn sentence(effect: &FoundEffect) -> String {
    capital(&finding(effect))
}

fn of_catalogue(effect: &FoundEffect) -> Option<String> {
    let id = effect.id.as_str();
    let get = |name: &str| effect.parameters.get(name);
    let value = |name: &str| get(name).map(|p| p.value);
    // With its unit and interval, as it stands.
    let told = |name: &str| get(name).map(|p| estimate(id, name, p));
    // Without its sign, which a word tells.
    let signed = |name: &str, plus: &str, minus: &str| {
        let (p, shown) = (get(name)?, shown(id, name));
        let ParameterEstimate { value, ci95, .. } = unsigned(p);
        let word = if p.value < 0.0 { minus } else { plus };
        Some(with_word(shown.factor * value, ci95.map(|x| shown.factor * x), shown.unit, word))
    };
    let wheelset = || value("wheelset").map_or(t("one"), wheelset_name);
    let of_all = value("wheelset") == Some(0.0);
    Some(match id {
        "speed_scale" => {
            let told = signed("relative_error", "", "")?;
            let (value, interval) = told.split_at(told.find(" (").unwrap_or(told.len()));
            let message = match get("relative_error")?.value < 0.0 {
                true => "vehicle speed reads {value} low{interval}",
                false => "vehicle speed reads {value} high{interval}",
            };
            say(message, &[("value", &value), ("interval", &interval)])
        }
        "speed_latency" => say("vehicle speed reads {time} late", &[("time", &told("latency_s")?)]),
        "wheel_radius" => {
            let how = signed("relative_error", t("larger"), t("smaller"))?;
            match of_all {
                true => {
                    say("the radius of all wheelsets is {how} than the vehicle file says", &[("how", &how)])
                }
                false => say(
                    "the {which} wheelset's radius is {how} than the vehicle file says",
                    &[("which", &wheelset()), ("how", &how)],
                ),
            }
        }
        "wheel_encoder_eccentricity" => {
            let swing = 100.0 * value("sine")?.hypot(value("cosine").unwrap_or(0.0));
            match of_all {
                true => say(
                    "the speed reading of all wheelsets swings by ±{share} % once a turn",
                    &[("share", &number(swing))],
                ),
                false => say(
                    "the speed reading of the {which} wheelset swings by ±{share} % once a turn",
                    &[("which", &wheelset()), ("share", &number(swing))],
                ),
            }
        }
        "wheel_encoder_window" => {
            say("wheelset speeds are means over the last {time}", &[("time", &told("window_s")?)])
        }
        "clock_skew" => say(
            "wheelset speeds come later and later, by {share} of the time since the start, on top of {time}",
            &[("share", &told("drift")?), ("time", &told("offset_s")?)],
        ),
        "mass_error" => say(
            "the wagon is {how} than the vehicle file says",
            &[("how", &signed("relative_error", t("heavier"), t("lighter"))?)],
        ),
        "rotating_inertia" => say(
            "the wheelsets' inertia is {how} than the vehicle file says",
            &[("how", &signed("relative_error", t("larger"), t("smaller"))?)],
        ),
        "load_transfer" => say(
            "braking shifts load between the wheelsets {how} than the model says",
            &[("how", &signed("relative_error", t("more"), t("less"))?)],
        ),
        "brake_fade" => {
            let loss = with_word(
                1e4 * value("alpha_per_k")?,
                get("alpha_per_k")?.ci95.map(|x| 1e4 * x),
                "%",
                t("of their friction per 100 K"),
            );
            let onset = rounded(AMBIENT_C + value("onset_k").unwrap_or(0.0), -1);
            say(
                "pads lose {loss} once the disc is above about {onset} °C",
                &[("loss", &loss), ("onset", &onset)],
            )
        }
        "brake_friction_speed" => say(
            "pads grip {how} near standstill than at speed",
            &[("how", &signed("rise", t("more"), t("less"))?)],
        ),
        "brake_friction_pressure" => pressure(effect)?,
        "cast_iron" => say(
            "pads grip like cast iron, less with speed and with pressure ({share} of Karwatzki's law)",
            &[("share", &told("share")?)],
        ),
        "pressure_dump" => say(
            "in a slide {share} of the force that pressure tells is vented within {time}",
            &[("share", &told("depth")?), ("time", &told("venting_time_s")?)],
        ),
        "brake_wet_delay" => say(
            "wet pads grip {loss} less until about {energy} kJ have gone into each disc",
            &[("loss", &told("loss")?), ("energy", &number(1e-3 * value("drying_energy_j")?))],
        ),
        "brake_lag" => say(
            "pad force follows brake pressure with a dead time of {dead} and a lag of {lag}",
            &[("dead", &told("dead_time_s")?), ("lag", &told("time_constant_s")?)],
        ),
        "rigging_hysteresis" => say(
            "the brake rigging holds pad force back by ±{share} and ±{force} N",
            &[("share", &told("relative_half_width")?), ("force", &number(value("half_width_n")?))],
        ),
        "pressing_force_offset" => say(
            "pads take hold only above {force} of the force that pressure tells",
            &[("force", &told("threshold_n")?)],
        ),
        "dragging_brake" => say(
            "the brake of the {which} wheelset drags with {torque} at all times",
            &[("which", &wheelset()), ("torque", &told("torque_nm")?)],
        ),
        "falling_friction" => {
            say("adhesion falls in a slide to {share} of its peak", &[("share", &told("friction_ratio")?)])
        }
        "self_cleaning" => say(
            "the rail gives following wheelsets {gain} more adhesion, and {slip} more behind a sliding one",
            &[("gain", &told("gain")?), ("slip", &told("gain_in_slip")?)],
        ),
        "low_adhesion_patch" => say(
            "adhesion is {loss} lower from {stretch}",
            &[("loss", &told("loss")?), ("stretch", &stretch(effect)?)],
        ),
        "adhesion_speed" => {
            let [slow, fast] = [15.0, 30.0].map(|v| {
                let floor = value("asymptote_share").unwrap_or(0.0);
                Some(floor + (1.0 - floor) / (1.0 + v * value("decay_s_per_m")?))
            });
            let share = rounded(100.0 * fast? / slow?, 0);
            say("adhesion at 30 m/s is about {share} % of what it is at 15 m/s", &[("share", &share)])
        }
        "sanding" => say("sand raises adhesion by {gain}", &[("gain", &told("gain")?)]),
        "axle_torsion" => {
            let compliance = 1e-3 * value("compliance_rad_per_knm")?;
            let frequency =
                (compliance * value("disc_inertia_kg_m2")?).sqrt().recip() / std::f64::consts::TAU;
            say(
                "the axle or drivetrain swings at about {frequency} Hz and shows in the wheelset speeds",
                &[("frequency", &number_to(frequency, 2))],
            )
        }
        "grade" => say(
            "the track is {how} than the map says from {stretch}",
            &[
                ("how", &signed("error_permil", t("steeper"), t("less steep"))?),
                ("stretch", &stretch(effect)?),
            ],
        ),
        "running_resistance" => {
            let added = value("constant_n")? + TOLD_SPEED_M_S * value("linear_n_s_per_m").unwrap_or(0.0);
            let how = if added < 0.0 { t("lower") } else { t("higher") };
            say(
                "running resistance is {force} N {how} at {speed} m/s than the vehicle file says",
                &[("force", &number(added.abs())), ("how", &how), ("speed", &number(TOLD_SPEED_M_S))],
            )
        }
        "headwind" => say(
            "the wind blows with {how}",
            &[("how", &signed("headwind_m_s", t("from ahead"), t("from behind"))?)],
        ),
        "coupler_force" => say(
            "a neighbour of about {mass} t pushes and pulls through the coupler",
            &[("mass", &number(1e-3 * value("mass_kg")?))],
        ),
        _ => return None,
    })
}

/// A value and its interval without their sign. An interval that reaches over zero begins there.
fn unsigned(p: &ParameterEstimate) -> ParameterEstimate {
    let [low, high] = p.ci95;
    let ci95 = match (low < 0.0, high < 0.0) {
        (true, true) => [-high, -low],
        (true, false) => [0.0, if p.value < 0.0 { -low } else { high }],
        _ => [low, high],
    };
    ParameterEstimate::new(p.value.abs(), ci95)
}

/// By how much friction falls when the pressing force doubles.
fn pressure(effect: &FoundEffect) -> Option<String> {
    let exponent = effect.parameters.get("exponent")?;
    let levelling = effect.parameters.get("levelling_force_n").map_or(0.0, |p| p.value);
    let [low, high] = TOLD_FORCES_N;
    let fall = |n: f64| 100.0 * (1.0 - ((low + levelling) / (high + levelling)).powf(n));
    let told = ParameterEstimate::new(fall(exponent.value), exponent.ci95.map(fall));
    let word = if told.value < 0.0 { t("more") } else { t("less") };
    let told = unsigned(&told);
    let how = with_word(told.value, told.ci95, "%", word);
    let (high, low) = (number(1e-3 * high), number(1e-3 * low));
    let ends: [(&str, &dyn Display); 3] = [("how", &how), ("high", &high), ("low", &low)];
    Some(say("pads grip {how} at {high} kN than at {low} kN", &ends))
}

/// `150 to 210 m`.
fn stretch(effect: &FoundEffect) -> Option<String> {
    let start = effect.parameters.get("start_m")?.value;
    let end = start + effect.parameters.get("length_m")?.value;
    Some(say("{low} to {high} m", &[("low", &rounded(start, 0)), ("high", &rounded(end, 0))]))
}

/// A wheelset by its number from the front.
fn wheelset_name(number: f64) -> &'static str {
    match number.round() as i64 {
        1 => t("first"),
        2 => t("second"),
        3 => t("third"),
        4 => t("fourth"),
        _ => t("one"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Parameters by name, with value and interval.
    type Values<'a> = &'a [(&'a str, f64, [f64; 2])];

    fn found(id: &str, parameters: Values<'_>) -> FoundEffect {
        let parameters = parameters
            .iter()
            .map(|(name, value, ci95)| ((*name).to_owned(), ParameterEstimate::new(*value, *ci95)));
        FoundEffect {
            id: id.to_owned(),
            term: String::new(),
            confidence: 0.9,
            p: None,
            score: None,
            gap_grows_without: None,
            rivals: Vec::new(),
            equivalent: Vec::new(),
            parameters: parameters.collect::<BTreeMap<_, _>>(),
        }
    }

    #[test]
    fn findings_say_what_and_how_much() {
        let cases: &[(&str, Values<'_>, &str)] = &[
            (
                "speed_scale",
                &[("relative_error", -0.0143, [-0.0151, -0.0138])],
                "vehicle speed reads 1.4\u{a0}% low (1.4–1.5)",
            ),
            (
                "wheel_radius",
                &[("relative_error", 0.0062, [0.0057, 0.0066]), ("wheelset", 2.0, [2.0, 2.0])],
                "the second wheelset's radius is 0.62\u{a0}% larger (0.57–0.66) than the vehicle file says",
            ),
            (
                "brake_fade",
                &[("alpha_per_k", 3.26e-4, [2.1e-4, 4.6e-4]), ("onset_k", 37.3, [20.9, 55.7])],
                "pads lose 3\u{a0}% of their friction per 100 K (2–5) once the disc is above about 60 °C",
            ),
            (
                "brake_friction_pressure",
                &[("exponent", 0.152, [0.139, 0.162]), ("levelling_force_n", 0.0, [0.0, 1e3])],
                "pads grip 10\u{a0}% less (9–11) at 50 kN than at 25 kN",
            ),
            (
                "low_adhesion_patch",
                &[
                    ("loss", 0.523, [0.49, 0.57]),
                    ("start_m", 151.2, [148.0, 153.0]),
                    ("length_m", 60.4, [55.0, 66.0]),
                ],
                "adhesion is 52\u{a0}% (49–57) lower from 151 to 212 m",
            ),
            (
                "mass_error",
                &[("relative_error", -0.001, [-0.02, 0.018])],
                "the wagon is 0\u{a0}% lighter (0–2) than the vehicle file says",
            ),
            (
                "clock_skew",
                &[("drift", 0.011, [0.0102, 0.0113]), ("offset_s", 0.0, [-0.02, 0.02])],
                "wheelset speeds come later and later, by 1.1\u{a0}% (1.0–1.1) of the time since the start, on top of 0\u{a0}s (−0.02 to 0.02)",
            ),
            (
                "axle_torsion",
                &[("compliance_rad_per_knm", 0.02, [0.01, 0.03]), ("disc_inertia_kg_m2", 50.0, [40.0, 60.0])],
                "the axle or drivetrain swings at about 5 Hz and shows in the wheelset speeds",
            ),
            ("own_effect", &[], "the model lacks own effect"),
            ("grade", &[], "the model lacks grade"),
        ];
        for (id, parameters, words) in cases {
            assert_eq!(finding(&found(id, parameters)), *words);
        }
    }

    #[test]
    fn every_effect_of_the_catalogue_has_its_sentence() {
        for (spec, _) in railgrip_vehicle::effects::all() {
            let parameters: Vec<(&str, f64, [f64; 2])> = spec
                .parameters
                .iter()
                .map(|p| (p.name, p.default, if p.discrete { [p.default; 2] } else { [p.lower, p.upper] }))
                .collect();
            let words = finding(&found(spec.id, &parameters));
            assert!(!words.starts_with("the model lacks"), "{}: {words}", spec.id);
        }
    }
}
