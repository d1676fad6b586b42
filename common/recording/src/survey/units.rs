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
    /// Why it may be otherwise.
    pub doubt: Option<String>,
}

impl Guess {
    /// A column with the name of a run.
    pub(super) const fn own(to: String) -> Self {
        Self { to, unit: None, scale: None, doubt: None }
    }

    /// Units of the run of one unit of the file.
    #[must_use]
    pub fn factor(&self) -> f64 {
        let si = self.unit.and_then(unit).map_or(1.0, |(factor, _)| factor);
        si * self.scale.unwrap_or(1.0)
    }
}

/// What a column of that quantity may be.
pub(super) fn guess(to: String, quantity: Quantity, name: &str, cells: &[f64]) -> Guess {
    let (_, least, most) = figures(cells);
    let most = most.max(-least);
    if let Some(said) = of_header(name, quantity) {
        let (scale, doubt) = scale(quantity, said, most);
        return Guess { to, unit: Some(said), scale, doubt };
    }
    let (named, why) = of_figures(quantity, name, cells, most);
    let (scale, of_scale) = named.map_or((None, None), |unit| scale(quantity, unit, most));
    let doubt = match (why, of_scale) {
        (Some(why), Some(more)) => Some(format!("{why}; {more}")),
        (why, more) => why.or(more),
    };
    Guess { to, unit: named, scale, doubt }
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
            let doubt =
                format!("no unit in the header; taken for {unit}, since one row follows the other by {step}");
            (Some(unit), Some(doubt))
        }
        None => (Some("s"), Some(format!("no unit in the header; taken for s: one row every {step} s"))),
    }
}

/// Unit of the run that a guess leads to.
pub(super) fn unit_of_run(guess: &Guess) -> &'static str {
    quantity_of(&guess.to).map_or("", Quantity::unit)
}
