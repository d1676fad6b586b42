//! In which unit a column may be: as its header says, else as its figures make plausible, with the doubt said.

use crate::columns::Quantity;
use crate::mapping::{quantity_of, unit};

/// Pressing force of a full brake at one wheelset, N: what the largest pressure of a file is taken for where nobody says what area
/// and rigging the cylinder has.
const FULL_BRAKE_N: f64 = 30_000.0;

/// What a column may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Guess {
    /// The column of a run.
    pub to: String,
    /// Unit of the file; nothing where the column has the name of a run, or holds instants.
    pub unit: Option<&'static str>,
    /// Units of the run of one SI unit of the file, where those differ: m² of a cylinder times the rigging.
    pub scale: Option<f64>,
    /// Whether its sign is the other way round.
    pub turned: bool,
    /// Why it may be otherwise: sentences of the table of messages.
    pub doubts: Vec<String>,
}

impl Guess {
    /// A column with the name of a run, whose unit is that of the name.
    pub(super) fn own(to: String, quantity: Quantity, cells: &[f64]) -> Self {
        let doubts = Vec::from_iter(unusual(quantity, quantity.unit(), largest(cells)));
        Self { to, unit: None, scale: None, turned: false, doubts }
    }

    /// Units of the run of one unit of the file.
    #[must_use]
    pub fn factor(&self) -> f64 {
        let si = self.unit.and_then(unit).map_or(1.0, |(factor, _)| factor);
        let sign = if self.turned { -1.0 } else { 1.0 };
        sign * si * self.scale.unwrap_or(1.0)
    }
}

/// What a column of that quantity may be.
pub(super) fn guess(to: String, quantity: Quantity, name: &str, cells: &[f64]) -> Guess {
    let most = largest(cells);
    let (named, why) = match of_header(name, quantity) {
        Some(said) => (Some(said), unusual(quantity, said, most)),
        None => of_figures(quantity, name, cells, most),
    };
    let (scale, of_scale) = named.map_or((None, None), |unit| scale(quantity, unit, most));
    Guess { to, unit: named, scale, turned: false, doubts: why.into_iter().chain(of_scale).collect() }
}

/// The largest magnitude, negative infinity where there is no number.
fn largest(cells: &[f64]) -> f64 {
    let (_, least, most) = figures(cells);
    most.max(-least)
}

/// A number as people read it: four digits are enough to know a unit by.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let place = 10_f64.powf(3.0 - value.abs().log10().floor());
    let rounded = if place.is_normal() { (value * place).round() / place } else { value };
    rounded.to_string()
}

/// Between which magnitudes the largest value of a run usually lies, in SI units.
const fn usual(quantity: Quantity, si: &str) -> Option<[f64; 2]> {
    match quantity {
        Quantity::Speed => Some([0.5, 120.0]),
        Quantity::WheelSpeed => Some([1.0, 300.0]),
        Quantity::PressingForce if matches!(si.as_bytes(), b"Pa") => Some([2e4, 1.5e6]),
        Quantity::PressingForce => Some([500.0, 3e5]),
        Quantity::DriveTorque => Some([50.0, 1e5]),
        Quantity::Grade => Some([0.0, 0.1]),
        _ => None,
    }
}

/// The doubt about a unit that is said in a header, if the values would be unusual in it and usual in another.
fn unusual(quantity: Quantity, said: &'static str, most: f64) -> Option<String> {
    const OTHERS: &[&str] = &[
        "m/s", "km/h", "rad/s", "rpm", "N", "kN", "bar", "mbar", "kPa", "Pa", "N m", "kN m", "rad", "‰", "%",
    ];
    let (factor, si) = unit(said)?;
    let within = |factor: f64, [low, high]: [f64; 2]| (low..=high).contains(&(factor * most));
    if !(most > 0.0 && most.is_finite()) || within(factor, usual(quantity, si)?) {
        return None;
    }
    let fits = |other: &&&str| {
        let known = unit(other).filter(|(_, other_si)| *other_si == si);
        known.is_some_and(|(factor, _)| usual(quantity, si).is_some_and(|range| within(factor, range)))
    };
    let most = short(most);
    Some(match OTHERS.iter().find(fits) {
        Some(other) => {
            format!("named to be in {said}, where at most {most} would be unusual; {other} would be usual")
        }
        None => format!("named to be in {said}, where at most {most} would be unusual"),
    })
}

/// How a pressure presses cannot be read off it.
fn scale(quantity: Quantity, named: &'static str, most: f64) -> (Option<f64>, Option<String>) {
    let Some((factor, "Pa")) = unit(named).filter(|_| quantity == Quantity::PressingForce) else {
        return (None, None);
    };
    if !(most.is_finite() && most > 0.0) {
        let doubt = "no pressure is seen: the scale is m² of the cylinder × rigging ratio, and 0.1 stands for nothing";
        return (Some(0.1), Some(doubt.to_owned()));
    }
    let scale = FULL_BRAKE_N / (factor * most);
    let digits = 10_f64.powf(2.0 - scale.log10().floor());
    let most = short(most);
    let doubt = format!(
        "the scale is guessed, so that the {most} {named} that are seen at most press with {FULL_BRAKE_N} N, as full brakes do; put \
         m² of the cylinder × rigging ratio"
    );
    (Some((scale * digits).round() / digits), Some(doubt))
}

/// The unit that a header names, as the mapping writes it.
fn of_header(name: &str, quantity: Quantity) -> Option<&'static str> {
    const SPELT: &[(&str, &str)] = &[
        ("km/h", "km/h"),
        ("kmh", "km/h"),
        ("kph", "km/h"),
        ("km_h", "km/h"),
        ("m/s", "m/s"),
        ("m_s", "m/s"),
        ("mph", "mph"),
        ("rad/s", "rad/s"),
        ("rad_s", "rad/s"),
        ("deg/s", "deg/s"),
        ("1/min", "1/min"),
        ("u/min", "1/min"),
        ("min-1", "1/min"),
        ("rpm", "rpm"),
        ("1/s", "1/s"),
        ("knm", "kNm"),
        ("kn m", "kN m"),
        ("nm", "Nm"),
        ("n m", "N m"),
        ("kn", "kN"),
        ("n", "N"),
        ("mbar", "mbar"),
        ("bar", "bar"),
        ("mpa", "MPa"),
        ("kpa", "kPa"),
        ("pa", "Pa"),
        ("psi", "psi"),
        ("permille", "permille"),
        ("‰", "‰"),
        ("deg", "deg"),
        ("rad", "rad"),
        ("%", "%"),
        ("ms", "ms"),
        ("us", "us"),
        ("µs", "µs"),
        ("ns", "ns"),
        ("s", "s"),
        ("km", "km"),
        ("m", "m"),
        ("kg", "kg"),
        ("t", "t"),
    ];
    let lower = name.to_lowercase();
    // At the end of the name, in brackets or after a blank or an underscore; a name of nothing but a unit is none.
    let trimmed = lower.trim_end_matches([']', ')', ' ', '.']);
    let ends = |spelt: &str| {
        let before = trimmed.strip_suffix(spelt)?;
        before.ends_with(['[', '(', ' ', '_', '.', '-', ',']).then_some(())
    };
    let fits = |si: &str| si == quantity.unit() || (quantity == Quantity::PressingForce && si == "Pa");
    let found = SPELT.iter().filter(|(_, named)| unit(named).is_some_and(|(_, si)| fits(si)));
    // A revolution counter that is only called n says nothing of its unit.
    let found = found.filter(|(spelt, _)| ends(spelt).is_some());
    found.max_by_key(|(spelt, _)| spelt.len()).map(|(_, named)| *named)
}

/// How many cells hold a number, and the least and the largest of them.
pub(super) fn figures(cells: &[f64]) -> (usize, f64, f64) {
    let known = || cells.iter().copied().filter(|cell| cell.is_finite());
    (known().count(), known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max))
}

/// The unit that the figures make plausible, and why it may be another.
fn of_figures(
    quantity: Quantity,
    name: &str,
    cells: &[f64],
    most: f64,
) -> (Option<&'static str>, Option<String>) {
    let doubt = |unit: &str, other: &str| {
        let most = short(most);
        Some(format!("no unit in the header; taken for {unit}, since at most {most} are seen: {other}"))
    };
    let lower = name.to_lowercase();
    let force = ["f_perp", "force", "kraft", "pressing"].iter().any(|word| lower.contains(word));
    let picked = |unit: &'static str, other: &str| (Some(unit), doubt(unit, other));
    match quantity {
        Quantity::Time => of_steps(cells),
        _ if !most.is_finite() => {
            (None, Some("no value is seen, and no unit stands in the header".to_owned()))
        }
        Quantity::Speed if most > 70.0 => picked("km/h", "as m/s no train is so fast; mph would do, too"),
        Quantity::Speed => picked("m/s", "a slow run in km/h looks alike"),
        Quantity::WheelSpeed if most > 250.0 => picked("rpm", "as rad/s no wheel turns so fast"),
        Quantity::WheelSpeed => picked("rad/s", "a slow run in rpm or km/h looks alike"),
        Quantity::PressingForce if force && most < 200.0 => picked("kN", "as N no pad would press"),
        Quantity::PressingForce if force => picked("N", "the pads of one wheelset, all together"),
        Quantity::PressingForce if most < 20.0 => picked("bar", "kN would do, too"),
        Quantity::PressingForce if most < 2000.0 => picked("kPa", "kN would do, too"),
        Quantity::PressingForce if most < 20_000.0 => {
            picked("mbar", "N would do, too, and Pa press next to nothing")
        }
        Quantity::PressingForce => picked("Pa", "N would do, too"),
        Quantity::DriveTorque if most < 50.0 => picked("kN m", "a small torque in N m looks alike"),
        Quantity::DriveTorque => picked("N m", "at the wheelset, and not at the motor"),
        Quantity::Grade if most > 0.2 => {
            picked("‰", "as rad no track climbs so; % would be ten times as much")
        }
        Quantity::Grade => picked("rad", "a flat line in ‰ or % looks alike"),
        Quantity::Position => picked("m", "km would do, too"),
        Quantity::Load => picked(if most < 500.0 { "t" } else { "kg" }, "all of the wagon"),
        Quantity::Sanding | Quantity::WspActive | Quantity::BrakeDemand if most > 1.0 => {
            picked("%", "expected is 0 to 1")
        }
        Quantity::Sanding | Quantity::WspActive | Quantity::BrakeDemand => (None, None),
    }
}

/// The unit of a clock by its steps; seconds since 1970 and text of instants are seconds without doubt.
fn of_steps(cells: &[f64]) -> (Option<&'static str>, Option<String>) {
    let mut steps: Vec<f64> =
        cells.windows(2).map(|pair| pair[1] - pair[0]).filter(|s| s.is_finite()).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let coarse = [(1e6, "ns"), (1e3, "us"), (0.9, "ms")].into_iter().find(|(least, _)| step >= *least);
    let since_1970 = cells.first().is_some_and(|first| (5e8..5e9).contains(first));
    match coarse {
        _ if since_1970 && step < 0.9 => (None, None),
        Some((_, unit)) => {
            let step = short(step);
            let doubt =
                format!("no unit in the header; taken for {unit}, since one row follows the other by {step}");
            (Some(unit), Some(doubt))
        }
        None => {
            let step = short(step);
            (Some("s"), Some(format!("no unit in the header; taken for s: one row every {step} s")))
        }
    }
}

/// Unit of the run that a guess leads to.
pub(super) fn unit_of_run(guess: &Guess) -> &'static str {
    quantity_of(&guess.to).map_or("", Quantity::unit)
}
