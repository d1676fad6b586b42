//! Instants as people and programs write them, ISO 8601 with a date: `2026-03-01T12:00:00.010Z`, `2026-03-01 13:00:00,01+01:00`.

/// Seconds since 1970 in UTC; a text without an offset is taken as UTC. `None` for anything else.
#[must_use]
pub fn instant_s(text: &str) -> Option<f64> {
    let bytes = text.as_bytes();
    let number = |from: usize, to: usize| -> Option<i64> {
        let digits = bytes.get(from..to)?;
        let all = digits.iter().all(u8::is_ascii_digit);
        all.then(|| digits.iter().fold(0, |sum, digit| sum * 10 + i64::from(digit - b'0')))
    };
    let marks = [(4, b"-"), (7, b"-"), (10, b"T "), (13, b":"), (16, b":")] as [(usize, &[u8]); 5];
    if !marks.iter().all(|(at, allowed)| bytes.get(*at).is_some_and(|byte| allowed.contains(byte))) {
        return None;
    }
    let (year, month, day) = (number(0, 4)?, number(5, 7)?, number(8, 10)?);
    let (hour, minute, second) = (number(11, 13)?, number(14, 16)?, number(17, 19)?);
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) || hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let mut rest = text.get(19..)?;
    let mut fraction_s = 0.0;
    if let Some(digits) = rest.strip_prefix(['.', ',']) {
        let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        fraction_s = format!("0.{}", &digits[..end]).parse().ok()?;
        rest = &digits[end..];
    }
    let offset_s = match rest.trim() {
        "" | "Z" | "z" => 0,
        zone => {
            let sign = match zone.as_bytes()[0] {
                b'+' => 1,
                b'-' => -1,
                _ => return None,
            };
            let plain: String = zone[1..].chars().filter(|c| *c != ':').collect();
            let value: i64 = plain.parse().ok().filter(|_| plain.len() == 4 || plain.len() == 2)?;
            let (hours, minutes) = if plain.len() == 4 { (value / 100, value % 100) } else { (value, 0) };
            sign * (hours * 3600 + minutes * 60)
        }
    };
    let whole_s = days(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second - offset_s;
    Some(whole_s as f64 + fraction_s)
}

/// Days since 1970-01-01 in the Gregorian calendar, counted in eras of 400 years that begin in March.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let shifted = if month <= 2 { year - 1 } else { year };
    let era = shifted.div_euclid(400);
    let year_of_era = shifted - era * 400;
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_read_with_fractions_and_offsets() {
        let noon_s = 1_772_366_400.0;
        for (text, seconds) in [
            ("2026-03-01T12:00:00Z", noon_s),
            ("2026-03-01 12:00:00", noon_s),
            ("2026-03-01T13:00:00+01:00", noon_s),
            ("2026-03-01T12:00:00.250Z", noon_s + 0.25),
            ("2026-03-01 07:30:00,5-0430", noon_s + 0.5),
            ("1970-01-01T00:00:00Z", 0.0),
        ] {
            assert_eq!(instant_s(text), Some(seconds), "{text}");
        }
        for text in [
            "",
            "12.5",
            "2026-03-01",
            "2026-13-01T00:00:00Z",
            "2026-03-01T12:00:00 o'clock",
            "20260301T120000Z",
        ] {
            assert_eq!(instant_s(text), None, "{text}");
        }
    }
}
