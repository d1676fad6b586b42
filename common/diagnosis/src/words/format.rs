//! Numbers and names as people read them, in the language that is spoken.

use railgrip_words::{Language, say, spoken, t, word};

/// Decimals as the language writes them, and a real minus sign.
fn marked(text: &str) -> String {
    let text = text.replace('-', "−");
    match spoken() {
        Language::English => text,
        Language::German => text.replace('.', ","),
    }
}

/// A number with three significant digits and a real minus sign.
pub fn number(x: f64) -> String {
    number_to(x, 3)
}

/// A number with `digits` significant digits.
pub fn number_to(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return "–".to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    let magnitude = x.abs().log10().floor() as i32;
    let text = if !(-3..6).contains(&magnitude) {
        let mantissa = x / 10f64.powi(magnitude);
        format!("{} × 10{}", trimmed(mantissa, digits.saturating_sub(1)), superscript(magnitude))
    } else if magnitude >= 4 {
        let scale = 10f64.powi((magnitude + 1 - digits as i32).max(0));
        thousands(((x / scale).round() * scale) as i64)
    } else {
        trimmed(x, (digits as i32 - 1 - magnitude).max(0) as usize)
    };
    marked(&text)
}

fn trimmed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Groups of three with a narrow space.
fn thousands(x: i64) -> String {
    let digits = x.unsigned_abs().to_string();
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push('\u{202f}');
        }
        grouped.push(digit);
    }
    if x < 0 { format!("-{grouped}") } else { grouped }
}

fn superscript(exponent: i32) -> String {
    let sign = if exponent < 0 { "⁻" } else { "" };
    let digits = exponent.unsigned_abs().to_string();
    let high: String = digits
        .chars()
        .filter_map(|digit| digit.to_digit(10))
        .map(|digit| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize])
        .collect();
    format!("{sign}{high}")
}

/// A gap with two decimals, or one from ten up.
pub fn gap(x: f64) -> String {
    match x {
        x if !x.is_finite() => "–".to_owned(),
        x if x >= 1000.0 => number(x),
        x if x >= 100.0 => format!("{x:.0}"),
        x if x >= 10.0 => marked(&format!("{x:.1}")),
        x => marked(&format!("{x:.2}")),
    }
}

/// A share as a whole percentage.
pub fn percent(share: f64) -> String {
    let rounded = (100.0 * share).round() + 0.0;
    if share.is_finite() { marked(&format!("{rounded:.0} %")) } else { "–".to_owned() }
}

/// A share of a whole as a percentage; what exceeds the whole is all of it, and what is worse than nothing is said so.
pub fn part(share: f64) -> String {
    match share {
        x if !x.is_finite() => "–".to_owned(),
        x if x >= 0.995 => t("all").to_owned(),
        x if x < -1.0 => t("worse").to_owned(),
        x => percent(x),
    }
}

/// A p-value in two digits. Where it comes from `replicates` random draws, they cannot tell less than one in so many.
pub fn p_value(p: f64, replicates: Option<usize>) -> String {
    let least = replicates.map_or(1e-3, |n| 1.0 / (n as f64 + 1.0));
    match p {
        p if !p.is_finite() => "–".to_owned(),
        p if p <= least * 1.01 => format!("< {}", number_to(least * 1.5, 1)),
        p if p < 0.1 => number_to(p, 1),
        p => marked(&format!("{p:.1}")),
    }
}

/// An interval.
pub fn interval([low, high]: [f64; 2]) -> String {
    say("{low} to {high}", &[("low", &number(low)), ("high", &number(high))])
}

/// Decimals that an interval allows: one digit of its width. `None` where it has no width. Negative counts are tens, hundreds.
pub fn interval_digits([low, high]: [f64; 2]) -> Option<i32> {
    let width = high - low;
    (width.is_finite() && width > 0.0).then(|| -(width.log10() + 1e-9).floor() as i32)
}

/// A number with so many decimals; with a negative count rounded to tens, hundreds and so on.
pub fn rounded(x: f64, decimals: i32) -> String {
    if !x.is_finite() {
        return "–".to_owned();
    }
    let step = 10f64.powi(-decimals);
    // Adding zero turns −0 into 0.
    let x = (x / step).round() * step + 0.0;
    let text = match usize::try_from(decimals) {
        Ok(decimals) if x != 0.0 => format!("{x:.decimals$}"),
        Ok(_) => "0".to_owned(),
        Err(_) => thousands(x.round() as i64),
    };
    marked(&text)
}

/// A number on an axis that spans `span`: three digits of the span, so that rounding errors beside it read as zero.
pub fn on_axis(x: f64, span: f64) -> String {
    if !(x.is_finite() && span > 0.0 && span.is_finite()) {
        return number(x);
    }
    let step = 10f64.powi(span.log10().floor() as i32 - 2);
    number((x / step).round() * step + 0.0)
}

/// A number with so many decimals.
pub fn decimals(x: f64, decimals: usize) -> String {
    marked(&format!("{x:.decimals$}"))
}

/// An id or name with underscores as words; in the language where it is one that the table of messages knows.
pub fn plain(name: &str) -> String {
    word(&name.replace('_', " "))
}

/// A term of the equations in words.
pub fn term(name: &str) -> String {
    let words = match name {
        "brake_friction" => t("the friction between pad and disc"),
        "brake_actuation" => t("the way from brake pressure to pad force"),
        "adhesion" => t("the adhesion between wheel and rail"),
        "load_distribution" => t("the loads of the wheelsets"),
        "inertia" => t("mass or rotating inertia"),
        "kinematics" => t("the wheel radii"),
        "resistance" => t("running resistance or grade"),
        "longitudinal_force" => t("forces along the track"),
        "sensor_wheel_speed" => t("the measurement of wheel speed"),
        "sensor_speed" => t("the measurement of vehicle speed"),
        "drivetrain" => t("the elasticity of axle or drivetrain"),
        other => return plain(other),
    };
    words.to_owned()
}

/// An output in words.
pub fn signal(name: &str) -> String {
    let words = match name {
        "v_m_s" => t("vehicle speed"),
        "omega_f_rad_s" => t("front wheelset speed"),
        "omega_r_rad_s" => t("rear wheelset speed"),
        "force_n" => t("creep force"),
        "mu" => t("pad friction"),
        other => return plain(other),
    };
    words.to_owned()
}

/// The text with a capital letter at its beginning.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// `a`, `a and b`, `a, b and c`.
pub fn list(items: &[String]) -> String {
    joined(items, t("and"))
}

/// `a`, `a or b`, `a, b or c`.
pub fn or_list(items: &[String]) -> String {
    joined(items, t("or"))
}

fn joined(items: &[String], word: &str) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} {word} {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        assert_eq!(number(0.000_82), "8.2 × 10⁻⁴");
        assert_eq!(number(-0.0345), "−0.0345");
        assert_eq!(number(12.345), "12.3");
        assert_eq!(number(2.0), "2");
        assert_eq!(number(12_345.0), "12\u{202f}300");
        assert_eq!(number(6.04e6), "6.04 × 10⁶");
        assert_eq!(number(f64::NAN), "–");
        assert_eq!(list(&["a".into(), "b".into(), "c".into()]), "a, b and c");
    }

    #[test]
    fn shares_and_chances_say_no_more_than_they_can() {
        let parts = [(1.22, "all"), (0.88, "88 %"), (-0.02, "−2 %"), (-7.0, "worse"), (f64::NAN, "–")];
        for (share, words) in parts {
            assert_eq!(part(share), words);
        }
        let chances = [
            (1.0 / 401.0, Some(400), "< 0.004"),
            (2.0 / 401.0, Some(400), "0.005"),
            (0.0, None, "< 0.002"),
            (0.0312, Some(400), "0.03"),
            (0.58, Some(400), "0.6"),
            (1.0, None, "1.0"),
        ];
        for (p, replicates, words) in chances {
            assert_eq!(p_value(p, replicates), words);
        }
    }

    #[test]
    fn digits_follow_the_interval_or_the_axis() {
        for ([low, high], digits) in
            [([1.39, 1.46], Some(2)), ([1.4, 1.52], Some(1)), ([20.0, 56.0], Some(-1))]
        {
            assert_eq!(interval_digits([low, high]), digits);
        }
        assert_eq!(interval_digits([2.0, 2.0]), None);
        let numbers = [(0.2104, 3, "0.210"), (-0.004, 2, "0"), (1234.0, -2, "1200"), (-55.7, -1, "−60")];
        for (x, decimals, words) in numbers {
            assert_eq!(rounded(x, decimals).replace('\u{202f}', ""), words);
        }
        assert_eq!(on_axis(-2.1e-11, 0.4), "0");
        assert_eq!(on_axis(-2.29, 1500.0), "0");
        assert_eq!(on_axis(-0.123_45, 0.4), "−0.123");
    }
}
