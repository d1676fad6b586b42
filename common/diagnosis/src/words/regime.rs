//! The operating range in which the gap stands out, in the words of somebody who runs trains.

use super::format::{plain, rounded};
use crate::answer::schema::Regime;
use crate::answer::supplement::HeatMap;
use railgrip_words::{say, t, word};

/// How a variable of a regime is told.
struct Told {
    /// Name in reports.
    variable: &'static str,
    /// What is above or below a value.
    noun: &'static str,
    /// By how much SI values are multiplied.
    factor: f64,
    /// Unit behind the number.
    unit: &'static str,
}

const TOLD: &[Told] = &[
    Told { variable: "temperature", noun: "disc", factor: 1.0, unit: "°C" },
    Told { variable: "speed", noun: "speed", factor: 1.0, unit: "m/s" },
    Told { variable: "brake_force", noun: "pressing force of all brakes", factor: 1e-3, unit: "kN" },
    Told { variable: "pressing_force", noun: "pressing force", factor: 1e-3, unit: "kN" },
    Told {
        variable: "time_since_brake_onset",
        noun: "time since the brakes came on",
        factor: 1.0,
        unit: "s",
    },
    Told {
        variable: "slip_power",
        noun: "power lost in slip at the front wheelset",
        factor: 1e-3,
        unit: "kW",
    },
    Told { variable: "position", noun: "position", factor: 1.0, unit: "m" },
];

/// The regime in words: `disc above 150 °C`, `speed between 40 and 70 km/h`. Ends that are those of the recordings are left out.
pub fn regime(regime: &Regime, map: &HeatMap) -> String {
    let group = map.groups.iter().find(|group| plain(&group.variable) == plain(&regime.variable));
    let told = TOLD.iter().find(|told| told.variable == regime.variable);
    let (noun, factor, unit) = match told {
        Some(told) => (word(told.noun), told.factor, told.unit),
        None => (plain(&regime.variable), 1.0, group.map_or("", |group| group.unit.as_str())),
    };
    let [low, high] = regime.range;
    let ends = group.and_then(|group| Some([*group.edges.first()?, *group.edges.last()?]));
    let (from, to) = ends.map_or((low, high), |[from, to]| (from, to));
    let near = 1e-3 * (to - from).abs();
    let (first, last) = (ends.is_some() && low <= from + near, ends.is_some() && high >= to - near);
    let value = |x: f64| two_digits(factor * x);
    let unit = if unit.is_empty() { String::new() } else { format!("\u{a0}{unit}") };
    let (low, high) = (value(low), value(high));
    let told = |message| say(message, &[("what", &noun), ("low", &low), ("high", &high), ("unit", &unit)]);
    match (first, last) {
        // No power is lost where nothing slips.
        (false, true) if regime.variable == "slip_power" => t("a wheelset slides").to_owned(),
        (true, false) if regime.variable == "slip_power" => t("no wheelset slides").to_owned(),
        (false, true) => told("{what} above {low}{unit}"),
        (true, false) => told("{what} below {high}{unit}"),
        (true, true) => told("any {what}"),
        (false, false) => told("{what} between {low} and {high}{unit}"),
    }
}

/// A number in two digits, never in more decimals than two.
fn two_digits(x: f64) -> String {
    let magnitude = if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 };
    rounded(x, (1 - magnitude).min(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::supplement::HeatGroup;

    #[test]
    fn ranges_are_told_by_the_end_that_matters() {
        let cases = [
            ("temperature", [150.0, 384.0], [20.0, 384.0], "disc above 150\u{a0}°C"),
            ("speed", [2.0, 11.2], [2.0, 43.0], "speed below 11\u{a0}m/s"),
            ("position", [350.0, 564.8], [-1.0, 1506.0], "position between 350 and 560\u{a0}m"),
            ("slip_power", [8.5e3, 3.2e4], [0.0, 3.2e4], "a wheelset slides"),
            ("brake_force", [129e3, 269e3], [0.0, 269e3], "pressing force of all brakes above 130\u{a0}kN"),
            ("creepage", [0.02, 0.1], [0.0, 0.1], "creepage above 0.02"),
        ];
        for (variable, range, [first, last], words) in cases {
            let group =
                HeatGroup { variable: plain(variable), edges: vec![first, last], ..HeatGroup::default() };
            let map = HeatMap { signals: Vec::new(), groups: vec![group] };
            let place = Regime { variable: variable.to_owned(), range, gap_inside: 2.0, gap_outside: 1.0 };
            assert_eq!(regime(&place, &map), words);
        }
    }
}
