//! Fitted values with their units, in no more digits than the interval allows.

use super::format::{interval_digits, number, plain, rounded};
use crate::answer::schema::{Interval, ParameterEstimate};
use railgrip_words::{say, t};

/// How the values of a parameter are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// By how much a value is multiplied.
    pub factor: f64,
    /// Unit behind the number; empty where there is none.
    pub unit: &'static str,
}

/// Ends of names that carry a unit, the longer ones first; `factor` leads from SI to what is shown.
const BY_ENDING: &[(&str, Shown)] = &[
    ("_n_s2_per_m2", Shown { factor: 1.0, unit: "N s²/m²" }),
    ("_n_s_per_m", Shown { factor: 1.0, unit: "N s/m" }),
    ("_s_per_m", Shown { factor: 1.0, unit: "s/m" }),
    ("_rad_per_knm", Shown { factor: 1.0, unit: "rad/(kN m)" }),
    ("_kg_m2", Shown { factor: 1.0, unit: "kg m²" }),
    ("_per_k", Shown { factor: 1e4, unit: "% per 100 K" }),
    ("_per_n", Shown { factor: 1e5, unit: "% per kN" }),
    ("_permil", Shown { factor: 1.0, unit: "‰" }),
    ("_m_s", Shown { factor: 1.0, unit: "m/s" }),
    ("_nm", Shown { factor: 1.0, unit: "N m" }),
    ("_hz", Shown { factor: 1.0, unit: "Hz" }),
    ("_kg", Shown { factor: 1e-3, unit: "t" }),
    ("_k", Shown { factor: 1.0, unit: "K" }),
    ("_c", Shown { factor: 1.0, unit: "°C" }),
    ("_j", Shown { factor: 1e-3, unit: "kJ" }),
    ("_n", Shown { factor: 1e-3, unit: "kN" }),
    ("_s", Shown { factor: 1.0, unit: "s" }),
    ("_m", Shown { factor: 1.0, unit: "m" }),
];

/// Dimensionless parameters that are no shares.
const BARE: &[&str] = &[
    "exponent",
    "damping_ratio",
    "wheelset",
    "encoder_at_wheels",
    "on_dry_rail_too",
    "k_a",
    "k_s",
    "spread",
];

/// Unit and scale of the parameter `name` of `owner` (an effect, or `nuisance`).
pub fn shown(owner: &str, name: &str) -> Shown {
    let bare = BARE.iter().any(|bare| name.ends_with(bare));
    let by_ending = || BY_ENDING.iter().find(|(end, _)| name.ends_with(end)).map(|(_, shown)| *shown);
    match name {
        // Coefficients of a bench are fitted themselves, those of a wagon by their relative error.
        "mu0" | "friction_coefficient" => Shown { factor: 1.0, unit: "" },
        _ if owner == "nuisance" && name != "stiffness_n" => Shown { factor: 100.0, unit: "%" },
        "constant_n" => Shown { factor: 1.0, unit: "N" },
        _ if bare => Shown { factor: 1.0, unit: "" },
        _ => by_ending().unwrap_or(Shown { factor: 100.0, unit: "%" }),
    }
}

/// Names that say little without the equation.
const BY_NAME: &[(&str, &str)] = &[
    ("drag", "air resistance"),
    ("pad_friction_f", "pad friction, front"),
    ("pad_friction_r", "pad friction, rear"),
    ("adhesion_dry", "adhesion on dry rail"),
    ("adhesion_wet", "adhesion on wet rail"),
    ("adhesion_low", "adhesion on low rail"),
    ("adhesion_undeclared", "adhesion on undeclared rail"),
    ("half_slip_velocity_m_s", "slip velocity of half the effect"),
    ("slip_velocity_scale_m_s", "scale of slip velocity"),
    ("half_creepage", "creepage of half the effect"),
    ("creepage_scale", "scale of creepage"),
    ("speed_scale_m_s", "scale of speed"),
    ("alpha_per_k", "loss of friction"),
    ("onset_k", "onset above ambient"),
    ("rise", "rise towards standstill"),
    ("relative_half_width", "half width, share of the force"),
    ("constant_n", "constant part"),
    ("linear_n_s_per_m", "part that grows with speed"),
];

/// The name without its unit, as words.
pub fn name(name: &str) -> String {
    if let Some((_, words)) = BY_NAME.iter().find(|(known, _)| *known == name) {
        return railgrip_words::word(words);
    }
    if let Some(number) = name.strip_prefix("pad_friction_") {
        return say("pad friction {number}", &[("number", &number)]);
    }
    let end = BY_ENDING.iter().find(|(end, _)| name.ends_with(end)).map_or("", |(end, _)| end);
    plain(name.strip_suffix(end).unwrap_or(name))
}

/// A value with its interval: `1.4 % (1.4–1.5)`.
pub fn estimate(owner: &str, name: &str, estimate: &ParameterEstimate) -> String {
    let shown = shown(owner, name);
    with_interval(shown.factor * estimate.value, estimate.ci95.map(|end| shown.factor * end), shown.unit)
}

/// A unit in the language that is spoken.
pub fn unit(unit: &str) -> String {
    railgrip_words::word(unit)
}

/// A value with unit and interval; an interval without width is left out, as the value was chosen and not estimated.
pub fn with_interval(value: f64, ci95: Interval, unit: &str) -> String {
    with_word(value, ci95, unit, "")
}

/// The same with a word between value and interval: `1.4 % low (1.4–1.5)`.
pub fn with_word(value: f64, [low, high]: Interval, unit: &str, word: &str) -> String {
    let word = if word.is_empty() { String::new() } else { format!(" {word}") };
    let unit = self::unit(unit);
    let space = if unit.is_empty() { "" } else { "\u{a0}" };
    let digits = interval_digits([low, high]);
    match digits {
        Some(digits) => {
            let [value, low, high] = [value, low, high].map(|x| rounded(x, digits));
            let dash = if low.starts_with('−') || high.starts_with('−') { t(" to ") } else { "–" };
            format!("{value}{space}{unit}{word} ({low}{dash}{high})")
        }
        None => format!("{}{space}{unit}{word}", number(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_units_and_the_digits_of_their_interval() {
        let cases: &[(&str, &str, f64, Interval, &str)] = &[
            ("speed_scale", "relative_error", -0.0142, [-0.0145, -0.0139], "−1.42\u{a0}% (−1.45 to −1.39)"),
            ("brake_fade", "alpha_per_k", 3.26e-4, [2.09e-4, 4.62e-4], "3\u{a0}% per 100 K (2–5)"),
            ("brake_fade", "onset_k", 37.3, [20.9, 55.7], "40\u{a0}K (20–60)"),
            ("brake_lag", "time_constant_s", 0.2134, [0.2098, 0.2171], "0.213\u{a0}s (0.210–0.217)"),
            ("pressing_force_offset", "threshold_n", 4321.0, [4100.0, 4500.0], "4.3\u{a0}kN (4.1–4.5)"),
            ("running_resistance", "constant_n", 512.3, [402.0, 690.0], "500\u{a0}N (400–700)"),
            ("grade", "error_permil", 2.44, [2.31, 2.52], "2.4\u{a0}‰ (2.3–2.5)"),
            ("wheel_radius", "wheelset", 2.0, [2.0, 2.0], "2"),
            ("axle_torsion", "disc_inertia_kg_m2", 32.1, [25.2, 41.3], "30\u{a0}kg m² (30–40)"),
            ("nuisance", "mass", 0.0123, [-0.001, 0.021], "1\u{a0}% (0–2)"),
        ];
        for (owner, name, value, ci95, words) in cases {
            let said = estimate(owner, name, &ParameterEstimate::new(*value, *ci95));
            assert_eq!(said, *words, "{owner} {name}");
        }
    }

    #[test]
    fn names_lose_their_units() {
        assert_eq!(name("time_constant_s"), "time constant");
        assert_eq!(name("alpha_per_k"), "loss of friction");
        assert_eq!(name("relative_error"), "relative error");
    }
}
