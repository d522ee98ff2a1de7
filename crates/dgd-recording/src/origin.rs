//! The wall-clock time of the first sample.

/// Nanoseconds from 1970 of an RFC 3339 time, such as readers put into a table's origin.
pub(crate) fn nanoseconds(text: &str) -> Option<u64> {
    let bytes = text.as_bytes();
    let number = |range: std::ops::Range<usize>| -> Option<i64> {
        let digits = bytes.get(range)?;
        let all = digits.iter().all(u8::is_ascii_digit);
        all.then(|| digits.iter().fold(0, |n, b| n * 10 + i64::from(b - b'0')))
    };
    let signs = [(4, b'-'), (7, b'-'), (13, b':'), (16, b':')];
    let shaped = signs.iter().all(|(at, sign)| bytes.get(*at) == Some(sign));
    if !shaped || !matches!(bytes.get(10), Some(b'T' | b't' | b' ')) {
        return None;
    }
    let (year, month, day) = (number(0..4)?, number(5..7)?, number(8..10)?);
    let (hour, minute, second) = (number(11..13)?, number(14..16)?, number(17..19)?);
    let days = days_from_1970(year, month, day)?;
    if hour >= 24 || minute >= 60 || second > 60 {
        return None;
    }
    let rest = &bytes[19..];
    let decimals = match rest {
        [b'.', digits @ ..] => digits.iter().take_while(|b| b.is_ascii_digit()).count(),
        _ => 0,
    };
    let point = usize::from(decimals > 0);
    let fraction_ns = number(20 - 1 + point..19 + point + decimals.min(9))
        .unwrap_or(0)
        .checked_mul(10_i64.pow(9 - u32::try_from(decimals.min(9)).ok()?))?;
    let offset_s = match &rest[point + decimals..] {
        b"Z" | b"z" => 0,
        [sign @ (b'+' | b'-'), _, _, b':', _, _] => {
            let at = 19 + point + decimals;
            let east_s = zone_offset_s(number(at + 1..at + 3)?, number(at + 4..at + 6)?)?;
            if *sign == b'-' { -east_s } else { east_s }
        }
        _ => return None,
    };
    let seconds = days * 86_400 + hour * 3600 + minute * 60 + second - offset_s;
    u64::try_from(
        seconds
            .checked_mul(1_000_000_000)?
            .checked_add(fraction_ns)?,
    )
    .ok()
}

/// So many seconds after an instant, or before it; `None` before 1970 and after the last instant.
pub(crate) fn later(ns: u64, after_s: f64) -> Option<u64> {
    let after_ns = (1e9 * after_s).round();
    #[expect(
        clippy::cast_possible_truncation,
        reason = "what is beyond the range ends at it, and is refused by the sum"
    )]
    let after_ns = after_s.is_finite().then_some(after_ns as i64)?;
    ns.checked_add_signed(after_ns)
}

/// Days from 1970-01-01 to a date of the Gregorian calendar, from 1900 to 2200, where 64-bit nanoseconds hold it; `None` where there is no
/// such date.
///
/// ```
/// assert_eq!(dgd_recording::days_from_1970(2024, 2, 29), Some(19_782));
/// assert_eq!(dgd_recording::days_from_1970(2023, 2, 29), None);
/// ```
#[must_use]
pub fn days_from_1970(year: i64, month: i64, day: i64) -> Option<i64> {
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let most = match month {
        2 => 28 + i64::from(leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    let is_one =
        (1900..2200).contains(&year) && (1..=12).contains(&month) && (1..=most).contains(&day);
    is_one.then(|| days_of_civil(year, month, day))
}

/// What is behind the sign of an offset from UTC, s; `None` where no clock on land or sea is so far from it.
///
/// ```
/// assert_eq!(dgd_recording::zone_offset_s(5, 30), Some(19_800));
/// assert_eq!(dgd_recording::zone_offset_s(14, 1), None);
/// assert_eq!(dgd_recording::zone_offset_s(0, 60), None);
/// ```
#[must_use]
pub fn zone_offset_s(hours: i64, minutes: i64) -> Option<i64> {
    // Kiribati is farthest, 14 h ahead.
    let is_one = hours >= 0 && (0..60).contains(&minutes) && hours * 60 + minutes <= 14 * 60;
    is_one.then_some(hours * 3600 + minutes * 60)
}

/// Howard Hinnant's `days_from_civil`, for years after 0.
fn days_of_civil(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let (era, year_of_era) = (year / 400, year % 400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

/// An instant in nanoseconds from 1970 as RFC 3339 has it; `-00:00` where the zone is not known.
///
/// ```
/// assert_eq!(dgd_recording::rfc3339(1_412_640_000_500_000_000, true), "2014-10-07T00:00:00.5Z");
/// ```
#[must_use]
pub fn rfc3339(ns: i64, zoned: bool) -> String {
    const NS_PER_S: i64 = 1_000_000_000;
    const S_PER_DAY: i64 = 86_400;
    let (seconds, fraction) = (ns.div_euclid(NS_PER_S), ns.rem_euclid(NS_PER_S));
    let (days, of_day) = (seconds.div_euclid(S_PER_DAY), seconds.rem_euclid(S_PER_DAY));
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = (shifted_month + 2) % 12 + 1;
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    let mut text = format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}");
    if fraction != 0 {
        let digits = format!(".{fraction:09}");
        text.push_str(digits.trim_end_matches('0'));
    }
    text.push_str(if zoned { "Z" } else { "-00:00" });
    text
}

#[cfg(test)]
mod tests {
    use super::{nanoseconds, rfc3339};

    #[test]
    fn offsets_and_fractions_name_one_instant() {
        let expected = Some(1_412_640_000_500_000_000);
        for text in [
            "2014-10-07T00:00:00.5Z",
            "2014-10-07T02:00:00.500+02:00",
            "2014-10-07T00:00:00.500000000-00:00",
            "2014-10-07T14:00:00.5+14:00",
            "2014-10-06T10:00:00.5-14:00",
        ] {
            assert_eq!(nanoseconds(text), expected, "{text}");
        }
        assert_eq!(nanoseconds("1970-01-01T00:00:00Z"), Some(0));
    }

    #[test]
    fn every_day_from_1970_to_2200_is_told_as_it_is_read_and_no_other_is_read() {
        let mut midnight_ns = 0;
        for (year, month, day) in (1970..2200)
            .flat_map(|year| (0..=13).map(move |month| (year, month)))
            .flat_map(|(year, month)| (0..=32).map(move |day| (year, month, day)))
        {
            let text = format!("{year}-{month:02}-{day:02}T00:00:00Z");
            let Some(ns) = nanoseconds(&text) else {
                assert_ne!(rfc3339(midnight_ns, true), text);
                continue;
            };
            assert_eq!(i64::try_from(ns), Ok(midnight_ns), "{text}");
            assert_eq!(rfc3339(midnight_ns, true), text);
            midnight_ns += 86_400_000_000_000;
        }
        assert_eq!(rfc3339(midnight_ns, true), "2200-01-01T00:00:00Z");
    }

    #[test]
    fn what_is_no_instant_is_none() {
        for text in [
            "",
            "2014-10-07",
            "2014-10-07T00:00:00",
            "2014-13-07T00:00:00Z",
            "1969-12-31T23:59:59Z",
            "2200-01-01T00:00:00Z",
            "2024-02-31T10:00:00Z",
            "2014-10-07T24:00:00Z",
            "2014-10-07T00:60:00Z",
            "2014-10-07T00:00:61Z",
            "2014-10-07T00:00:00+14:01",
            "2014-10-07T00:00:00-99:00",
            "2014-10-07T00:00:00+01:60",
            "2014-10-07T00:00:00.Z",
            "2014-10-07T00:00:0éZ",
        ] {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }
}
