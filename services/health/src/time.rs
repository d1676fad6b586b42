//! Instants and spans as people and JSON write them.

use std::time::{SystemTime, UNIX_EPOCH};

/// Instants beyond are refused: the year 9999.
const LAST_UNIX_S: i64 = 253_402_300_799;
const DAY_S: i64 = 86_400;

/// What [`instant_s`] takes, in words.
pub const INSTANT_ALLOWED: &str = "an RFC 3339 instant from 1970 on such as 2026-03-01T12:00:00Z, Unix seconds, now, or \
    an age as a whole number with s, m, h or d, such as 7d or -7d";
/// What [`span_s`] takes, in words.
pub const SPAN_ALLOWED: &str =
    "a whole number of seconds, or one with s, m, h or d, at most 9999999s, 999999m, 99999h or 9999d";
/// What [`instant_s`] takes, as a pattern. Leap days: of years that 4 divides, and of centuries that 400 divides.
pub(crate) const INSTANT: &str = "^([0-9]{1,11}(\\.[0-9]{1,9})?|now|\
    -?([1-9][0-9]{0,6}s|[1-9][0-9]{0,5}m|[1-9][0-9]{0,4}h|[1-9][0-9]{0,3}d)|\
    ((19[7-9][0-9]|[2-9][0-9]{3})-((0[13578]|1[02])-(0[1-9]|[12][0-9]|3[01])|(0[469]|11)-(0[1-9]|[12][0-9]|30)|\
    02-(0[1-9]|1[0-9]|2[0-8]))|(19(7[26]|8[048]|9[26])|[2-9][0-9](0[48]|[2468][048]|[13579][26])|\
    ([2468][048]|[3579][26])00)-02-29)\
    [Tt]([01][0-9]|2[0-3]):[0-5][0-9]:([0-5][0-9]|60)(\\.[0-9]{1,9})?([Zz]|[+-]([01][0-9]|2[0-3]):[0-5][0-9]))$";
/// What [`span_s`] takes, as a pattern.
pub(crate) const SPAN: &str = "^([1-9][0-9]{0,6}s?|[1-9][0-9]{0,5}m|[1-9][0-9]{0,4}h|[1-9][0-9]{0,3}d)$";

/// Seconds since 1970.
pub(crate) fn unix_s() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_secs()).unwrap_or(i64::MAX)
}

/// Unix seconds of an instant as people write it: RFC 3339, Unix seconds, `now`, or an age such as `7d`, with or without a minus.
#[must_use]
pub fn instant_s(text: &str, now_unix_s: i64) -> Option<i64> {
    if text == "now" {
        return Some(now_unix_s.clamp(0, LAST_UNIX_S));
    }
    let ago = text.strip_prefix('-').unwrap_or(text);
    if ago.ends_with(['s', 'm', 'h', 'd']) {
        return span_s(ago).map(|ago_s| (now_unix_s - ago_s).clamp(0, LAST_UNIX_S));
    }
    let digits = |text: &str, most: usize| {
        (1..=most).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit())
    };
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    if digits(whole, 11) && digits(fraction, 9) {
        return whole.parse().ok();
    }
    // Zones move the first and the last day a little beyond these years.
    let named = parse_rfc3339(text).filter(|_| text >= "1970")?;
    Some((named.floor() as i64).clamp(0, LAST_UNIX_S))
}

/// A span: seconds, or a whole number with `s`, `m`, `h` or `d`.
#[must_use]
pub fn span_s(text: &str) -> Option<i64> {
    let (number, unit_s, most_digits) = match text.char_indices().last()? {
        (at, 's') => (&text[..at], 1, 7),
        (at, 'm') => (&text[..at], 60, 6),
        (at, 'h') => (&text[..at], 3600, 5),
        (at, 'd') => (&text[..at], DAY_S, 4),
        _ => (text, 1, 7),
    };
    let plain = number.bytes().all(|byte| byte.is_ascii_digit()) && !number.starts_with('0');
    let number: i64 = number.parse().ok().filter(|_| plain && number.len() <= most_digits)?;
    Some(number * unit_s)
}

/// RFC 3339 in UTC with milliseconds, for example `2026-03-01T12:00:00.250Z`.
#[must_use]
pub fn rfc3339(unix_ns: i64) -> String {
    written(unix_ns.div_euclid(1_000_000_000), unix_ns.rem_euclid(1_000_000_000) / 1_000_000)
}

/// The same of whole seconds, also of years that nanoseconds do not reach.
#[must_use]
pub fn rfc3339_s(unix_s: i64) -> String {
    written(unix_s, 0)
}

fn written(seconds: i64, millis: i64) -> String {
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
            let digits = text.strip_prefix('.').filter(|digits| (1..=9).contains(&digits.len()))?;
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
        assert_eq!(rfc3339_s(253_402_300_799), "9999-12-31T23:59:59.000Z", "nanoseconds end in 2262");
    }

    #[test]
    fn people_write_instants_in_several_ways() {
        const NOW: i64 = 1_772_366_400;
        for (text, unix_s) in [
            ("2026-03-01T12:00:00Z", NOW),
            ("2026-03-01t12:00:00.9z", NOW),
            ("1772366400", NOW),
            ("1772366400.75", NOW),
            ("now", NOW),
            ("90s", NOW - 90),
            ("-7d", NOW - 7 * 86_400),
            ("7d", NOW - 7 * 86_400),
            ("9999d", NOW - 9999 * 86_400),
            ("1970-01-01T00:00:00+05:00", 0),
            ("2000-02-29T00:00:00Z", 951_782_400),
        ] {
            assert_eq!(instant_s(text, NOW), Some(unix_s), "{text}");
        }
        for wrong in [
            "",
            "-",
            "d",
            "-d",
            "0d",
            "+7d",
            "--7d",
            "99999d",
            "-90",
            "yesterday",
            "1969-12-31T23:00:00Z",
            "1900-02-29T00:00:00Z",
            "123456789012",
            "1.",
            "9é",
        ] {
            assert_eq!(instant_s(wrong, NOW), None, "{wrong}");
        }
        assert_eq!(
            [span_s("90"), span_s("90s"), span_s("2m"), span_s("12h")],
            [Some(90), Some(90), Some(120), Some(43_200)]
        );
        for wrong in ["", "s", "0", "01", "-1", "1y", "1.5h", "12345678", "10000d"] {
            assert_eq!(span_s(wrong), None, "{wrong}");
        }
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
