//! Instants as people and JSON read them.

/// RFC 3339 in UTC with milliseconds, for example `2026-03-01T12:00:00.250Z`.
#[must_use]
pub fn rfc3339(unix_ns: i64) -> String {
    let (seconds, millis) =
        (unix_ns.div_euclid(1_000_000_000), unix_ns.rem_euclid(1_000_000_000) / 1_000_000);
    let (days, second) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    let (year, month, day) = civil(days);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{millis:03}Z")
}

/// Unix seconds of an RFC 3339 instant such as `2026-03-01T12:00:00.250Z` or `2026-03-01T13:00:00+01:00`.
#[must_use]
pub fn parse_rfc3339(text: &str) -> Option<f64> {
    let (date, rest) = text.split_at_checked(10)?;
    let rest = rest.strip_prefix(['T', 't'])?;
    let number = |text: &str, width: usize, allowed: std::ops::RangeInclusive<i64>| {
        let plain = text.len() == width && text.bytes().all(|byte| byte.is_ascii_digit());
        plain.then(|| text.parse().ok()).flatten().filter(|number| allowed.contains(number))
    };
    let separated = |text: &str, at: usize, mark: &str| text.get(at..=at) == Some(mark);
    let part = |text: &str, from: usize, to: usize| text.get(from..to).unwrap_or_default().to_owned();
    if !separated(date, 4, "-") || !separated(date, 7, "-") {
        return None;
    }
    let (year, month) = (number(&part(date, 0, 4), 4, 0..=9999)?, number(&part(date, 5, 7), 2, 1..=12)?);
    let day = number(&part(date, 8, 10), 2, 1..=31)?;
    let zone_at = rest.find(['Z', 'z', '+', '-'])?;
    let (clock, zone) = rest.split_at(zone_at);
    let offset_s = match zone {
        "Z" | "z" => 0,
        _ if zone.len() == 6 && separated(zone, 3, ":") => {
            let (hour, minute) =
                (number(&part(zone, 1, 3), 2, 0..=23)?, number(&part(zone, 4, 6), 2, 0..=59)?);
            (hour * 3600 + minute * 60) * if zone.starts_with('-') { -1 } else { 1 }
        }
        _ => return None,
    };
    if !separated(clock, 2, ":") || !separated(clock, 5, ":") {
        return None;
    }
    let (hour, minute) = (number(&part(clock, 0, 2), 2, 0..=23)?, number(&part(clock, 3, 5), 2, 0..=59)?);
    // A leap second counts as the second after it.
    let second = number(&part(clock, 6, 8), 2, 0..=60)?;
    let fraction = match clock.get(8..)? {
        "" => 0.0,
        text => {
            let digits = text.strip_prefix('.').filter(|digits| !digits.is_empty())?;
            let plain = digits.bytes().all(|byte| byte.is_ascii_digit());
            plain.then(|| format!("0.{digits}").parse::<f64>().ok()).flatten()?
        }
    };
    let days = days(year, month, day);
    (civil(days) == (year, month, day))
        .then(|| (days * 86_400 + hour * 3600 + minute * 60 + second - offset_s) as f64 + fraction)
}

/// The inverse of [`civil`].
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = year - i64::from(month <= 2);
    let era = year.div_euclid(400);
    let year_of_era = year.rem_euclid(400);
    let month_from_march = (month + 9) % 12;
    let day_of_year = (153 * month_from_march + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

/// Year, month and day of a day counted from 1970-01-01, in the Gregorian calendar. Years are counted from March, so that
/// the leap day is the last of its year.
fn civil(days: i64) -> (i64, i64, i64) {
    const DAYS_IN_400_YEARS: i64 = 146_097;
    let since_march_0000 = days + 719_468;
    let (era, day_of_era) =
        (since_march_0000.div_euclid(DAYS_IN_400_YEARS), since_march_0000.rem_euclid(DAYS_IN_400_YEARS));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + 400 * era + i64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_instants() {
        let cases = [
            (0, "1970-01-01T00:00:00.000Z"),
            (951_782_400, "2000-02-29T00:00:00.000Z"),
            (1_772_366_400, "2026-03-01T12:00:00.000Z"),
            (4_107_542_399, "2100-02-28T23:59:59.000Z"),
            (-1, "1969-12-31T23:59:59.000Z"),
        ];
        for (seconds, text) in cases {
            assert_eq!(rfc3339(seconds * 1_000_000_000), text);
        }
        assert_eq!(rfc3339(250_000_000), "1970-01-01T00:00:00.250Z");
    }

    #[test]
    fn instants_are_read_back() {
        for unix_ns in [0, 951_782_400_000_000_000, 4_107_542_399_500_000_000, 1_772_366_400_250_000_000] {
            let read = parse_rfc3339(&rfc3339(unix_ns)).unwrap();
            assert!((read - unix_ns as f64 * 1e-9).abs() < 1e-5, "{unix_ns}: {read}");
        }
        assert_eq!(parse_rfc3339("2026-03-01T13:00:00+01:00"), Some(1_772_366_400.0));
        assert_eq!(parse_rfc3339("2026-03-01t06:30:00.5-05:30"), Some(1_772_366_400.5));
        for wrong in [
            "",
            "2026-03-01",
            "2026-02-30T12:00:00Z",
            "2026-03-01T24:00:00Z",
            "2026-03-01T12:00:00",
            "2026-03-01T12:00:00.Z",
            "2026-13-01T12:00:00Z",
            "2026-03-01T12:00:00+1:00",
            "20é6-03-01T12:00:00Z",
        ] {
            assert_eq!(parse_rfc3339(wrong), None, "{wrong}");
        }
    }
}
