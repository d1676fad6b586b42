//! Units of own parameters: people read them beside a fitted value, so that a slip of the pen must not pass for one.

/// Symbols of which a unit may be made. A prefix before one of them is read as such, so `kN` and `mrad` need no entry.
const SYMBOLS: [&str; 28] = [
    "m", "g", "t", "s", "min", "h", "A", "K", "C", "rad", "deg", "rev", "rpm", "Hz", "N", "Nm", "Ns", "J",
    "W", "Wh", "Pa", "bar", "V", "ohm", "Ω", "permil", "percent", "l",
];

/// Prefixes of powers of ten.
const PREFIXES: [&str; 8] = ["n", "u", "µ", "m", "c", "k", "M", "G"];

/// Checks that every word of a unit is a symbol, with a prefix or without: `N/(m/s)^2`, `rad/kN m`, `m²`, `1`, `%`.
///
/// # Errors
/// What is wrong with it, and the symbols that there are.
pub fn check(unit: &str) -> Result<(), String> {
    let known =
        || format!("a unit is 1, %, ‰ or made of {}, with prefixes such as k and m", SYMBOLS.join(", "));
    let between = |c: char| c.is_whitespace() || c.is_ascii_digit() || "()/*^·.+-%‰°²³⁻¹⁴".contains(c);
    if let Some(word) = unit.split(between).find(|word| !word.is_empty() && !is_symbol(word)) {
        return Err(format!("nothing is measured in {word:?}; {}", known()));
    }
    if unit.trim().is_empty() {
        return Err(format!("is empty; {}", known()));
    }
    Ok(())
}

fn is_symbol(word: &str) -> bool {
    let plain = |word: &str| SYMBOLS.contains(&word);
    plain(word) || PREFIXES.iter().any(|prefix| word.strip_prefix(prefix).is_some_and(plain))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::catalogue::CATALOGUE;

    /// What the catalogue itself is measured in, and how else people write units.
    #[test]
    fn units_of_the_catalogue_and_of_people_pass() {
        let catalogue =
            CATALOGUE.iter().flat_map(|(spec, _)| spec.parameters).map(|parameter| parameter.unit);
        let people = [
            "N/(m/s)^2",
            "N m",
            "kN·m",
            "kNm",
            "m s^-2",
            "%",
            "‰",
            "°C",
            "1/min",
            "bar",
            "Wh/km",
            "µm",
            "mm²",
            "km/h",
        ];
        for unit in catalogue.chain(people) {
            assert_eq!(check(unit), Ok(()), "{unit}");
        }
    }

    #[test]
    fn a_slip_is_told_with_what_there_is() {
        for (unit, word) in
            [("furlong", "furlong"), ("N/foot", "foot"), ("mN2/bra", "bra"), ("1/k", "k"), ("Km/h", "Km")]
        {
            let problem = check(unit).expect_err(unit);
            assert!(problem.contains(&format!("in {word:?}; a unit is 1, %")), "{problem}");
            assert!(problem.contains("N, Nm, Ns, J, W"), "{problem}");
        }
        assert!(check(" ").expect_err("empty").starts_with("is empty"));
    }
}
