//! What others call a quantity, and how they measure it, into the columns of a run: one description for recordings and live
//! sources. A value is `sign · scale · (what was read, in SI units) + offset`.
//!
//! With the area of the cylinder times the rigging ratio as the scale, a cylinder pressure becomes the force at the pads.

use crate::columns::{MAX_WHEELSETS, Quantity};

/// How several inputs become one value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Combine {
    /// The first that is there.
    #[default]
    First,
    /// The mean of those that are there.
    Mean,
    /// The sum; missing as soon as one is missing.
    Sum,
}

/// A value counts only while another input has this value.
#[derive(Debug, Clone, PartialEq)]
pub struct Flag {
    /// Name of the input.
    pub from: String,
    /// What it says of a good value.
    pub is: f64,
}

/// Where one column of a run comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Name of the column of a run.
    pub to: String,
    /// Names of the inputs.
    pub from: Vec<String>,
    /// How they become one.
    pub combine: Combine,
    /// SI units of one unit of the inputs, times scale and sign.
    pub factor: f64,
    /// Added at last, in the unit of the column.
    pub offset: f64,
    /// When the value counts.
    pub flag: Option<Flag>,
}

/// Where the columns of a run come from; a column without a rule has its own name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mapping {
    /// One rule a column at most.
    pub rules: Vec<Rule>,
}

impl Mapping {
    /// Whether nothing is mapped.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rules.is_empty()
    }

    /// Names of all inputs.
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        self.rules.iter().flat_map(Rule::inputs)
    }

    /// The value of a column from what `read` gives of the inputs by their names, NaN where there is nothing.
    pub fn value(&self, column: &str, read: &mut dyn FnMut(&str) -> f64) -> f64 {
        match self.rules.iter().find(|rule| rule.to == column) {
            Some(rule) => rule.value(read),
            None => read(column),
        }
    }

    /// Whether a column comes from an input of this name.
    #[must_use]
    pub fn reads(&self, column: &str, input: &str) -> bool {
        match self.rules.iter().find(|rule| rule.to == column) {
            Some(rule) => rule.from.iter().any(|from| from == input),
            None => column == input,
        }
    }

    /// Whether an input says of others whether they count.
    #[must_use]
    pub fn is_flag(&self, input: &str) -> bool {
        self.rules.iter().filter_map(|rule| rule.flag.as_ref()).any(|flag| flag.from == input)
    }
}

impl Rule {
    /// Names of its inputs.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &str> {
        self.from.iter().chain(self.flag.as_ref().map(|flag| &flag.from)).map(String::as_str)
    }

    pub(crate) fn value(&self, read: &mut dyn FnMut(&str) -> f64) -> f64 {
        if let Some(flag) = &self.flag
            && read(&flag.from) != flag.is
        {
            return f64::NAN;
        }
        let values: Vec<f64> = self.from.iter().map(|name| read(name)).collect();
        self.of(&values)
    }

    /// The value of the column from those of its inputs in their order, NaN where there is nothing; the flag is not asked.
    #[must_use]
    pub fn of(&self, values: &[f64]) -> f64 {
        let there = || values.iter().copied().filter(|value| value.is_finite());
        let one = match self.combine {
            Combine::First => there().next().unwrap_or(f64::NAN),
            Combine::Mean => there().sum::<f64>() / there().count() as f64,
            Combine::Sum => values.iter().sum(),
        };
        self.factor * one + self.offset
    }
}

/// A unit by its name: SI units of one of it, and the SI unit.
#[must_use]
pub fn unit(name: &str) -> Option<(f64, &'static str)> {
    use std::f64::consts::{PI, TAU};
    const UNITS: &[(&str, f64, &str)] = &[
        ("s", 1.0, "s"),
        ("ms", 1e-3, "s"),
        ("us", 1e-6, "s"),
        ("µs", 1e-6, "s"),
        ("ns", 1e-9, "s"),
        ("min", 60.0, "s"),
        ("h", 3600.0, "s"),
        ("m/s", 1.0, "m/s"),
        ("km/h", 1.0 / 3.6, "m/s"),
        ("mph", 0.447_04, "m/s"),
        ("rad/s", 1.0, "rad/s"),
        ("rpm", TAU / 60.0, "rad/s"),
        ("1/min", TAU / 60.0, "rad/s"),
        ("1/s", TAU, "rad/s"),
        ("deg/s", PI / 180.0, "rad/s"),
        ("N", 1.0, "N"),
        ("kN", 1e3, "N"),
        ("Pa", 1.0, "Pa"),
        ("kPa", 1e3, "Pa"),
        ("MPa", 1e6, "Pa"),
        ("mbar", 1e2, "Pa"),
        ("bar", 1e5, "Pa"),
        ("psi", 6_894.757_293, "Pa"),
        ("N m", 1.0, "N m"),
        ("Nm", 1.0, "N m"),
        ("kN m", 1e3, "N m"),
        ("kNm", 1e3, "N m"),
        ("rad", 1.0, "rad"),
        ("deg", PI / 180.0, "rad"),
        ("permille", 1e-3, "rad"),
        ("‰", 1e-3, "rad"),
        ("%", 1e-2, "(off to on)"),
        ("m", 1.0, "m"),
        ("km", 1e3, "m"),
        ("kg", 1.0, "kg"),
        ("t", 1e3, "kg"),
    ];
    UNITS.iter().find(|(known, ..)| *known == name).map(|(_, factor, si)| (*factor, *si))
}

/// The quantity that a column of a run measures, whatever the number of its wheelsets.
#[must_use]
pub fn quantity_of(column: &str) -> Option<Quantity> {
    let named = |quantity: &Quantity| {
        (1..=MAX_WHEELSETS).any(|wheelsets| {
            let count = if quantity.per_wheelset() { wheelsets } else { 1 };
            (0..count).any(|wheelset| quantity.column(wheelset, wheelsets) == column)
        })
    };
    Quantity::ALL.into_iter().find(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(to: &str, from: &[&str], unit_name: &str, scale: f64, offset: f64) -> Rule {
        let (factor, _) = unit(unit_name).expect("known");
        let from = from.iter().map(|name| (*name).to_owned()).collect();
        Rule { to: to.into(), from, combine: Combine::First, factor: factor * scale, offset, flag: None }
    }

    #[test]
    fn units_scales_and_offsets_make_si() {
        let mapping = Mapping {
            rules: vec![
                rule("v_m_s", &["speed"], "km/h", 1.0, 0.0),
                rule("omega_f_rad_s", &["n"], "rpm", -1.0, 0.0),
                // 3.8 bar on 400 cm² with a ratio of 4, less 1.2 kN of the spring.
                rule("f_perp_f_n", &["p"], "bar", 0.04 * 4.0, -1200.0),
            ],
        };
        let mut read = |name: &str| match name {
            "speed" => 72.0,
            "n" => -100.0,
            "p" => 3.8,
            "grade_rad" => 0.01,
            _ => f64::NAN,
        };
        assert!((mapping.value("v_m_s", &mut read) - 20.0).abs() < 1e-12);
        assert!((mapping.value("omega_f_rad_s", &mut read) - 10.471_975_5).abs() < 1e-6);
        assert!((mapping.value("f_perp_f_n", &mut read) - 59_600.0).abs() < 1e-6);
        assert_eq!(mapping.value("grade_rad", &mut read), 0.01);
        assert!(mapping.value("position_m", &mut read).is_nan());
    }

    #[test]
    fn several_inputs_become_one_and_a_flag_decides() {
        let mut mapping = Mapping { rules: vec![rule("v_m_s", &["a", "b"], "m/s", 1.0, 0.0)] };
        let read = |a: f64, b: f64, good: f64| {
            move |name: &str| match name {
                "a" => a,
                "b" => b,
                _ => good,
            }
        };
        let value = |mapping: &Mapping, a, b, good| mapping.value("v_m_s", &mut read(a, b, good));
        assert_eq!(value(&mapping, f64::NAN, 3.0, 1.0), 3.0);
        mapping.rules[0].combine = Combine::Mean;
        assert_eq!((value(&mapping, 1.0, 3.0, 1.0), value(&mapping, f64::NAN, 3.0, 1.0)), (2.0, 3.0));
        mapping.rules[0].combine = Combine::Sum;
        assert!(value(&mapping, 1.0, 3.0, 1.0) == 4.0 && value(&mapping, f64::NAN, 3.0, 1.0).is_nan());
        mapping.rules[0].flag = Some(Flag { from: "good".into(), is: 1.0 });
        assert!(value(&mapping, 1.0, 3.0, 0.0).is_nan() && value(&mapping, 1.0, 3.0, 1.0) == 4.0);
    }

    #[test]
    fn columns_and_units_have_their_quantity() {
        assert_eq!(quantity_of("omega_r_rad_s"), Some(Quantity::WheelSpeed));
        assert_eq!(quantity_of("f_perp_3_n"), Some(Quantity::PressingForce));
        assert_eq!(quantity_of("speed"), None);
        assert_eq!(unit("furlong"), None);
        for quantity in Quantity::ALL {
            assert!(quantity.unit() == "(off to on)" || unit(quantity.unit()).is_some(), "{quantity:?}");
        }
    }
}
