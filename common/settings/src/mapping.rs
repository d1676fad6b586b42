//! The table `[mapping]`: what a source calls a quantity, and how it measures it.

use crate::SettingsError;
use crate::place::ConfigText;
use railgrip_recording::{Combine, Flag, Mapping, Rule, quantity_of, unit};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where one column comes from.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RuleTable {
    /// Name of the input that becomes the column NAME of a run, or a list of them; required.
    from: Inputs,
    /// Unit of the input, for example km/h, rpm, kN, bar; without it that of the column.
    unit: Option<String>,
    /// Units of the column of one SI unit of the input, for example m² of a cylinder × rigging ratio; without it 1.
    scale: Option<f64>,
    /// 1 or -1; without it 1.
    sign: Option<f64>,
    /// Added at last, in the unit of the column.
    #[serde(default)]
    offset: f64,
    /// How several inputs become one: the first that is there, their mean, or their sum.
    #[serde(default)]
    combine: CombineWord,
    /// Name of an input that says whether the value counts.
    flag: Option<String>,
    /// What the flag says of a value that counts; without it 1.
    flag_is: Option<f64>,
}

#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(untagged)]
enum Inputs {
    One(String),
    Several(Vec<String>),
}

#[derive(Debug, Clone, Copy, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum CombineWord {
    #[default]
    First,
    Mean,
    Sum,
}

/// Settles the mapping; what is wrong with a rule is noted.
pub(crate) fn mapping(at: &ConfigText<'_>, table: &BTreeMap<String, RuleTable>) -> Mapping {
    let settled =
        |(to, given): (&String, &RuleTable)| rule(at, to, given).map_err(|error| at.note(error)).ok();
    Mapping { rules: table.iter().filter_map(settled).collect() }
}

fn rule(at: &ConfigText<'_>, to: &str, given: &RuleTable) -> Result<Rule, SettingsError> {
    let key = |name: &str| format!("mapping.{to}.{name}");
    let Some(quantity) = quantity_of(to) else {
        let allowed = "a column of a run, for example v_m_s, omega_f_rad_s, f_perp_f_n, t_s";
        return Err(at.refuse(&format!("mapping.{to}"), to, allowed));
    };
    let from = match &given.from {
        Inputs::One(name) => vec![name.clone()],
        Inputs::Several(names) => names.clone(),
    };
    if from.is_empty() || from.iter().any(String::is_empty) {
        at.note(at.refuse(&key("from"), "empty", "the name of an input, or a list of them"));
    }
    let (unit_factor, si) = match &given.unit {
        None => (1.0, quantity.unit()),
        Some(name) => unit(name).unwrap_or_else(|| {
            at.note(at.refuse(&key("unit"), format!("{name:?}"), "a unit such as km/h, rpm, kN, bar, ms"));
            (1.0, quantity.unit())
        }),
    };
    if si != quantity.unit() && given.scale.is_none() {
        let (name, own) = (given.unit.as_deref().unwrap_or_default(), quantity.unit());
        let allowed = format!("a unit of {own}, or a scale that says how many {own} one {si} is");
        at.note(at.refuse(&key("unit"), format!("{name:?}"), allowed));
    }
    let scale = given.scale.unwrap_or(1.0);
    if !scale.is_finite() || scale == 0.0 {
        at.note(at.refuse(&key("scale"), scale, "a number other than 0"));
    }
    let sign = given.sign.unwrap_or(1.0);
    if sign.abs() != 1.0 {
        at.note(at.refuse(&key("sign"), sign, "1 or -1"));
    }
    if !given.offset.is_finite() {
        at.note(at.refuse(&key("offset"), given.offset, "a number"));
    }
    let flag = given.flag.clone().map(|from| Flag { from, is: given.flag_is.unwrap_or(1.0) });
    if flag.is_none() && given.flag_is.is_some() {
        at.note(at.refuse(&key("flag_is"), "given", "nothing without `flag`"));
    }
    let combine = match given.combine {
        CombineWord::First => Combine::First,
        CombineWord::Mean => Combine::Mean,
        CombineWord::Sum => Combine::Sum,
    };
    Ok(Rule {
        to: to.to_owned(),
        from,
        combine,
        factor: unit_factor * scale * sign,
        offset: given.offset,
        flag,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[derive(Deserialize)]
    struct Form {
        mapping: BTreeMap<String, RuleTable>,
    }

    fn parsed(text: &str) -> Result<Mapping, String> {
        let at = ConfigText::new(Path::new("x.toml"), text);
        let form: Form = at.parse().map_err(|error| error.to_string())?;
        let settled = mapping(&at, &form.mapping);
        at.into_found().first().map_or(Ok(settled), |error| Err(error.to_string()))
    }

    #[test]
    fn a_cylinder_pressure_in_bar_becomes_a_force() {
        let text = "[mapping]\nv_m_s = { from = [\"a\", \"b\"], unit = \"km/h\", combine = \"mean\", flag = \"ok\" }\n\
                    f_perp_f_n = { from = \"p\", unit = \"bar\", scale = 0.16, offset = -1200.0 }\n";
        let mapping = parsed(text).expect("good");
        let mut read = |name: &str| match name {
            "p" => 3.8,
            "a" => 70.0,
            "b" => 74.0,
            _ => 1.0,
        };
        assert!((mapping.value("f_perp_f_n", &mut read) - 59_600.0).abs() < 1e-6);
        assert!((mapping.value("v_m_s", &mut read) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_named_with_what_is_allowed() {
        for (text, words) in [
            ("speed = { from = \"v\" }", "`mapping.speed` is speed, allowed is a column of a run"),
            ("v_m_s = { from = \"v\", unit = \"furlong\" }", "a unit such as km/h"),
            ("f_perp_f_n = { from = \"p\", unit = \"bar\" }", "a scale that says how many N one Pa is"),
            ("v_m_s = { from = [] }", "the name of an input"),
            ("v_m_s = { from = \"v\", sign = 2.0 }", "1 or -1"),
            ("v_m_s = { from = \"v\", scale = 0.0 }", "other than 0"),
            ("v_m_s = { from = \"v\", flag_is = 1.0 }", "nothing without `flag`"),
            ("v_m_s = { from = \"v\", units = \"m/s\" }", "units"),
        ] {
            let said = parsed(&format!("[mapping]\n{text}\n")).expect_err(text);
            assert!(said.contains(words) && said.contains("x.toml:"), "{text}: {said}");
        }
    }
}
