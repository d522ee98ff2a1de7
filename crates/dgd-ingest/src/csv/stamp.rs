//! Time stamps in cells: ISO 8601 dates and times, clock times, `mm:ss.s`.

use dgd_recording::{days_from_1970, zone_offset_s};

const NS_PER_S: i64 = 1_000_000_000;
const S_PER_DAY: i64 = 86_400;

/// What a cell with a time in it says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamp {
    /// From 1970-01-01 if there is a date, else from midnight or from the full hour.
    pub(super) ns: i64,
    pub(super) kind: StampKind,
}

impl Stamp {
    /// The date of a midnight whose zone is not told.
    pub(super) fn as_date(self) -> Option<Self> {
        let midnight = self.ns % (S_PER_DAY * NS_PER_S) == 0;
        let is_one = midnight && self.kind == StampKind::DateTime { zoned: false };
        is_one.then_some(Self {
            kind: StampKind::Date,
            ..self
        })
    }

    /// `14:11` is hours and minutes as in ISO 8601; a fraction, or more than the `24:00` that ends a day, speaks against it.
    pub(super) fn speaks_for_minutes(self) -> bool {
        match self.kind {
            StampKind::Two { fraction } => fraction || self.ns > 24 * 60 * NS_PER_S,
            _ => false,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StampKind {
    /// `2024-10-22T15:27:49.648`; `zoned` if it says its offset, which is then applied.
    DateTime { zoned: bool },
    /// `2024-10-22`.
    Date,
    /// `15:27:49.648`.
    Clock,
    /// `14:11.6` or `14:11`: which two of hours, minutes, seconds is for the column to decide.
    /// `ns` takes them for minutes and seconds.
    Two { fraction: bool },
}

/// What comes first in dates such as `26/10/2024`, whose year is last: the day here, the month there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum First {
    Day,
    Month,
}

/// What comes first in the dates of a column: whatever is beyond twelve in one of them is the day. `None` if that is not told, or told
/// both ways.
pub(super) fn first<'a>(cells: impl Iterator<Item = &'a [u8]>) -> Option<First> {
    let (mut day, mut month) = (false, false);
    for cell in cells {
        let Some((first, second, _)) = Text(cell).slashed() else {
            continue;
        };
        day |= first > 12;
        month |= second > 12;
    }
    match (day, month) {
        (true, false) => Some(First::Day),
        (false, true) => Some(First::Month),
        _ => None,
    }
}

/// Whether a cell begins with a date whose year is last, in slashes.
pub(super) fn is_slashed(cell: &[u8]) -> bool {
    Text(cell).slashed().is_some()
}

/// Reads a trimmed cell; of dates in slashes that end with the year it must be known what comes `first`.
pub(super) fn parse(cell: &[u8], first: Option<First>) -> Option<Stamp> {
    let mut text = Text(cell);
    if cell.len() > 40 || !cell.first()?.is_ascii_digit() {
        return None;
    }
    if let Some(stamp) = compact(cell) {
        return Some(stamp);
    }
    if let Some(days) = text.date(first) {
        if text.0.is_empty() {
            let ns = days * S_PER_DAY * NS_PER_S;
            return Some(Stamp {
                ns,
                kind: StampKind::Date,
            });
        }
        text.any(b"T t")?;
        let mut hour = text.digits(1, 2).filter(|h| *h <= 24)?;
        text.any(b":")?;
        let minute = text.digits(2, 2).filter(|m| *m < 60)?;
        let mut ns = 0;
        if text.any(b":").is_some() {
            (ns, _) = text.seconds(2)?;
        }
        if let Some(half) = text.half() {
            hour = of_day(hour, half)?;
        }
        let offset_s = text.zone()?;
        let seconds = days * S_PER_DAY + hour * 3600 + minute * 60 - offset_s.unwrap_or(0);
        let kind = StampKind::DateTime {
            zoned: offset_s.is_some(),
        };
        return Some(Stamp {
            ns: seconds * NS_PER_S + ns,
            kind,
        });
    }
    let first = text.digits(1, 4)?;
    text.any(b":")?;
    let (second_ns, fraction) = text.seconds(2)?;
    if text.0.is_empty() {
        let ns = first * 60 * NS_PER_S + second_ns;
        return Some(Stamp {
            ns,
            kind: StampKind::Two { fraction },
        });
    }
    text.any(b":").filter(|_| !fraction)?;
    let (third_ns, _) = text.seconds(2)?;
    let hour = match text.half() {
        Some(half) => of_day(first, half)?,
        None => first,
    };
    let ns = hour * 3600 * NS_PER_S + second_ns * 60 + third_ns;
    (text.0.is_empty() && second_ns < 60 * NS_PER_S).then_some(Stamp {
        ns,
        kind: StampKind::Clock,
    })
}

/// `20241022152749` or `20241022T152749Z`.
pub(super) fn compact(cell: &[u8]) -> Option<Stamp> {
    let digits = cell.iter().take_while(|b| b.is_ascii_digit()).count();
    let mut text = Text(cell);
    let (year, month, day) = (text.digits(4, 4)?, text.digits(2, 2)?, text.digits(2, 2)?);
    if digits == 8 {
        text.any(b"Tt")?;
    } else if digits != 14 {
        return None;
    }
    let days = days_from_1970(year, month, day)?;
    let hour = text.digits(2, 2).filter(|h| *h < 24)?;
    let minute = text.digits(2, 2).filter(|m| *m < 60)?;
    let (ns, _) = text.seconds(2)?;
    let offset_s = text.zone()?;
    let seconds = days * S_PER_DAY + hour * 3600 + minute * 60 - offset_s.unwrap_or(0);
    Some(Stamp {
        ns: seconds * NS_PER_S + ns,
        kind: StampKind::DateTime {
            zoned: offset_s.is_some(),
        },
    })
}

/// What digits alone stand for in a column of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Digits {
    /// `152749` or `52749`, as loggers of WITS write the time of the day; `152749.648`.
    Clock,
    /// `241022` or `20241022`.
    Date,
}

impl Digits {
    /// Reads a trimmed cell.
    pub(super) fn parse(self, cell: &[u8]) -> Option<Stamp> {
        let digits = cell.iter().take_while(|b| b.is_ascii_digit()).count();
        let (whole, fraction) = cell.split_at(digits);
        let number = Text(whole).digits(1, 8)?;
        let (high, middle, low) = (number / 10_000, number / 100 % 100, number % 100);
        match self {
            Self::Clock => {
                let is_one = digits <= 6 && high < 24 && middle < 60 && low < 60;
                let mut text = Text(fraction);
                let part_ns = if fraction.is_empty() {
                    0
                } else {
                    text.fraction()?
                };
                let ns = (high * 3600 + middle * 60 + low) * NS_PER_S + part_ns;
                (is_one && text.0.is_empty()).then_some(Stamp {
                    ns,
                    kind: StampKind::Clock,
                })
            }
            Self::Date => {
                let year = match digits {
                    6 => 2000 + high,
                    8 => high,
                    _ => return None,
                };
                let days = days_from_1970(year, middle, low).filter(|_| fraction.is_empty())?;
                Some(Stamp {
                    ns: days * S_PER_DAY * NS_PER_S,
                    kind: StampKind::Date,
                })
            }
        }
    }
}

/// Whether numbers are times of the day in digits: each can be one, and from some of them to the next it is the time that goes on evenly
/// and not the number, as from `75959` to `80000`.
pub(super) fn is_dial(cells: &[&[u8]]) -> bool {
    let read = |cell: &&[u8]| {
        let ns = Digits::Clock.parse(cell)?.ns;
        let number: f64 = std::str::from_utf8(cell).ok()?.parse().ok()?;
        Some((ns as f64 / 1e9, number))
    };
    let Some(read) = cells.iter().map(read).collect::<Option<Vec<_>>>() else {
        return false;
    };
    let steps = || {
        read.windows(2).map(|w| {
            let time = (w[1].0 - w[0].0).rem_euclid(86_400.0);
            (time, w[1].1 - w[0].1)
        })
    };
    let mut usual: Vec<f64> = steps().map(|(time, _)| time).filter(|s| *s > 0.0).collect();
    usual.sort_by(f64::total_cmp);
    let Some(usual) = usual.get(usual.len() / 2) else {
        return false;
    };
    let limit = 1.5 * usual;
    // From 23:59:59 to midnight the number falls by more than this; one that falls by less runs backwards.
    const MIDNIGHT: f64 = -200_000.0;
    let jumps = |number: f64| number > limit || number < MIDNIGHT;
    steps().any(|(time, number)| time > 0.0 && time <= limit && jumps(number))
}

/// The hour of the day of one before noon or after it, of which twelve comes first.
fn of_day(hour: i64, half: Half) -> Option<i64> {
    let after = match half {
        Half::BeforeNoon => 0,
        Half::AfterNoon => 12,
    };
    (1..=12).contains(&hour).then_some(hour % 12 + after)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Half {
    BeforeNoon,
    AfterNoon,
}

struct Text<'a>(&'a [u8]);

impl Text<'_> {
    fn any(&mut self, of: &[u8]) -> Option<u8> {
        let (first, rest) = self.0.split_first().filter(|(b, _)| of.contains(b))?;
        self.0 = rest;
        Some(*first)
    }

    fn digits(&mut self, least: usize, most: usize) -> Option<i64> {
        let count = self
            .0
            .iter()
            .take(most)
            .take_while(|b| b.is_ascii_digit())
            .count();
        if count < least {
            return None;
        }
        let (digits, rest) = self.0.split_at(count);
        self.0 = rest;
        Some(digits.iter().fold(0, |n, b| n * 10 + i64::from(b - b'0')))
    }

    /// `10/26/2024`: its three numbers, the year last.
    fn slashed(&mut self) -> Option<(i64, i64, i64)> {
        let first = self.digits(1, 2)?;
        self.any(b"/")?;
        let second = self.digits(1, 2)?;
        self.any(b"/")?;
        Some((first, second, self.digits(4, 4)?))
    }

    /// ` PM`, ` am`.
    fn half(&mut self) -> Option<Half> {
        let said = self.0.trim_ascii_start();
        let half = match said.get(..2)? {
            b"AM" | b"am" => Half::BeforeNoon,
            b"PM" | b"pm" => Half::AfterNoon,
            _ => return None,
        };
        self.0 = &said[2..];
        Some(half)
    }

    /// A month by its English name, or the first three letters of it, or `Sept`.
    fn month(&mut self) -> Option<i64> {
        const NAMES: [&str; 12] = [
            "january",
            "february",
            "march",
            "april",
            "may",
            "june",
            "july",
            "august",
            "september",
            "october",
            "november",
            "december",
        ];
        let letters = (self.0.iter())
            .take_while(|b| b.is_ascii_alphabetic())
            .count();
        let (name, rest) = self.0.split_at(letters);
        let is = |full: &&str| {
            let begins = full.as_bytes().get(..letters);
            begins.is_some_and(|begins| name.eq_ignore_ascii_case(begins))
                && (letters == 3 || letters == full.len() || name.eq_ignore_ascii_case(b"sept"))
        };
        let month = (1..)
            .zip(NAMES.iter())
            .find_map(|(number, full)| is(full).then_some(number))?;
        self.0 = rest;
        Some(month)
    }

    /// `2024-10-22`, `2024/10/22`, `22.10.2024` or `22-Oct-2024` to days from 1970, and `10/22/2024` where it is known what comes first; nothing is eaten
    /// otherwise.
    fn date(&mut self, first: Option<First>) -> Option<i64> {
        let mut text = Text(self.0);
        let (year, month, day) = if let Some((a, b, year)) = Text(self.0).slashed() {
            text.slashed()?;
            match first? {
                First::Day => (year, b, a),
                First::Month => (year, a, b),
            }
        } else {
            let a = text.digits(1, 4)?;
            let sign = text.any(b"-/. ")?;
            let named = text.month();
            let month = match named {
                Some(month) => month,
                None => text.digits(1, 2).filter(|_| sign != b' ')?,
            };
            text.any(&[sign])?;
            let before = text.0.len();
            let last = text.digits(1, 4)?;
            match sign {
                b'-' | b'/' if named.is_none() => (a, month, last),
                // `22-Oct-24`, as databases and spreadsheets write it.
                _ if named.is_some() && before - text.0.len() == 2 => {
                    (last + if last < 70 { 2000 } else { 1900 }, month, a)
                }
                _ => (last, month, a),
            }
        };
        let days = days_from_1970(year, month, day)?;
        self.0 = text.0;
        Some(days)
    }

    /// Seconds with an optional fraction, ns; says whether there was a fraction.
    /// 60 is a leap second.
    fn seconds(&mut self, digits: usize) -> Option<(i64, bool)> {
        let whole = self.digits(digits, digits).filter(|s| *s <= 60)?;
        if !self.0.starts_with(b".") && !self.0.starts_with(b",") {
            return Some((whole * NS_PER_S, false));
        }
        Some((whole * NS_PER_S + self.fraction()?, true))
    }

    /// `.648`, ns.
    fn fraction(&mut self) -> Option<i64> {
        self.any(b".,")?;
        let before = self.0.len();
        let mut ns = self.digits(1, 9)?;
        for _ in before - self.0.len()..9 {
            ns *= 10;
        }
        while self.any(b"0123456789").is_some() {} // finer than a nanosecond
        Some(ns)
    }

    /// The rest of the cell: `Some(None)` without a zone, else its offset in seconds.
    fn zone(&mut self) -> Option<Option<i64>> {
        while self.any(b" ").is_some() {}
        if self.0.is_empty() {
            return Some(None);
        }
        if matches!(self.0, b"Z" | b"z" | b"UTC" | b"GMT") {
            return Some(Some(0));
        }
        let named = [b"UTC", b"GMT"]
            .iter()
            .find_map(|name| self.0.strip_prefix(*name));
        // `GMT+2` is written so, and `+2` is not.
        let fewest = if named.is_some() { 1 } else { 2 };
        self.0 = named.unwrap_or(self.0);
        let sign = if self.any(b"+-")? == b'-' { -1 } else { 1 };
        let hours = self.digits(fewest, 2)?;
        let _ = self.any(b":");
        let minutes = if self.0.is_empty() {
            0
        } else {
            self.digits(2, 2)?
        };
        let offset_s = zone_offset_s(hours, minutes).filter(|_| self.0.is_empty())?;
        Some(Some(sign * offset_s))
    }
}

/// Turns the stamps of one column into seconds from the first, as they come.
#[derive(Debug, Default)]
pub(super) struct Clock {
    first_ns: Option<i64>,
    /// Added since the clock passed midnight, or the full hour; less than 0 where it passed them backwards.
    carried_ns: i64,
    last_ns: i64,
    /// Rows that are later than the one before them, less those that are earlier, and how many are either: rows may run from the newest to the oldest.
    ahead: i64,
    moves: i64,
    /// Two fields are hours and minutes, not minutes and seconds.
    two_are_hours: bool,
    /// How many of them cannot be hours.
    minutes: u64,
    /// Another column has the date, so midnight needs no guess.
    pub(super) dated: bool,
    first: Option<Stamp>,
}

impl Clock {
    pub(super) fn new(two_are_hours: bool, dated: bool) -> Self {
        Self {
            two_are_hours,
            dated,
            ..Self::default()
        }
    }

    /// Seconds from the first stamp of the column.
    pub(super) fn seconds(&mut self, stamp: Stamp) -> f64 {
        let hours = matches!(stamp.kind, StampKind::Two { .. }) && self.two_are_hours;
        self.minutes += u64::from(stamp.speaks_for_minutes());
        let mut ns = if hours { stamp.ns * 60 } else { stamp.ns };
        let period_s = match stamp.kind {
            StampKind::Clock => S_PER_DAY,
            StampKind::Two { .. } if hours => S_PER_DAY,
            StampKind::Two { .. } => 3600,
            StampKind::DateTime { .. } | StampKind::Date => 0,
        };
        let period_ns = period_s * NS_PER_S;
        let first_ns = *self.first_ns.get_or_insert(ns);
        if self.first.is_none() {
            self.first = Some(stamp);
            self.last_ns = ns;
        }
        if period_ns > 0 && !self.dated {
            ns = ns.saturating_add(self.carried_ns);
            // Back by more than half the dial is a new day; less is a clock put back. Of rows that run back, on by more than that is the day before.
            // A dial that counts past its period (`75:02.5`) never comes here.
            let reversed = 2 * self.ahead < -self.moves;
            let turned = if reversed && ns > self.last_ns.saturating_add(period_ns / 2) {
                -period_ns
            } else if !reversed && ns < self.last_ns.saturating_sub(period_ns / 2) {
                period_ns
            } else {
                0
            };
            self.carried_ns = self.carried_ns.saturating_add(turned);
            ns = ns.saturating_add(turned);
            let ahead = ns.cmp(&self.last_ns) as i64;
            self.ahead += ahead;
            self.moves += ahead.abs();
            self.last_ns = ns;
        }
        ns.saturating_sub(first_ns) as f64 / 1e9
    }

    /// Whether stamps were minutes and seconds for certain; one alone may be a slip.
    pub(super) fn met_minutes(&self) -> bool {
        self.minutes > 1
    }

    /// Nanoseconds and whether the zone is known, if the first stamp has a date and a time of day.
    pub(super) fn origin(&self) -> Option<(i64, bool)> {
        let first = self.first?;
        match first.kind {
            StampKind::DateTime { zoned } => Some((first.ns, zoned)),
            _ => None,
        }
    }

    pub(super) fn first(&self) -> Option<Stamp> {
        self.first
    }
}

/// Puts times of the day onto the dates of another column, as they come.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// Time of the day and date of the row before.
    last: Option<(f64, f64)>,
    /// Days since a date that stays while the clock passes midnight, such as that of the spud.
    carried_s: f64,
    /// As those of [`Clock`].
    ahead: i64,
    moves: i64,
    /// Whether rows come in no order, and each has its own date.
    unordered: bool,
}

impl Joined {
    /// Takes each date as it stands: rows come in no order.
    pub(super) fn take_as_they_are(&mut self) {
        self.unordered = true;
    }

    /// Seconds from the first row, of seconds from its time of the day and from its date.
    pub(super) fn seconds(&mut self, of_day_s: f64, date_s: f64) -> f64 {
        if !(of_day_s + date_s).is_finite() {
            return f64::NAN;
        }
        if let Some((before_s, last_date_s)) = self.last.filter(|_| !self.unordered) {
            let fell = of_day_s < before_s - S_PER_DAY as f64 / 2.0;
            let reversed = 2 * self.ahead < -self.moves;
            if date_s != last_date_s {
                self.carried_s = 0.0;
            } else if fell && !reversed {
                self.carried_s += S_PER_DAY as f64;
            }
            let ahead = (of_day_s + date_s).total_cmp(&(before_s + last_date_s)) as i64;
            self.ahead += ahead;
            self.moves += ahead.abs();
        }
        self.last = Some((of_day_s, date_s));
        of_day_s + date_s + self.carried_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ns(text: &str) -> Option<i64> {
        parse(text.as_bytes(), None).map(|s| s.ns)
    }

    #[test]
    fn dates_and_zones_name_the_same_instant() {
        let expected = Some(1_729_610_869_648_000_000);
        for text in [
            "2024-10-22T15:27:49.648Z",
            "2024/10/22 15:27:49.648",
            "22.10.2024 15:27:49,648",
            "22-Oct-2024 15:27:49.648",
            "22 October 2024 15:27:49.648",
            "22/OCT/2024 03:27:49.648 PM",
            "22-Oct-24 15:27:49.648",
            "20241022152749.648",
            "20241022T152749.648Z",
            "2024-10-22T17:27:49.648+02:00",
            "2024-10-22 10:57:49.648-0430",
            "2024-10-22 15:27:49.648 UTC",
            "2024-10-22 17:27:49.648 GMT+02:00",
            "2024-10-22 17:27:49.648 UTC+2",
        ] {
            assert_eq!(ns(text), expected, "{text}");
        }
    }

    #[test]
    fn instants_print_as_they_were_read() {
        for text in [
            "1999-12-31T23:59:59Z",
            "2024-02-29T00:00:00.000000001Z",
            "1969-12-31T23:59:59.5Z",
        ] {
            assert_eq!(
                dgd_recording::rfc3339(ns(text).expect("a stamp"), true),
                text
            );
        }
    }

    #[test]
    fn months_have_names_and_their_years_two_digits_or_four() {
        for (text, same) in [
            ("1-Sept-2014", "2014-09-01"),
            ("01 sep 69", "2069-09-01"),
            ("1-SEPTEMBER-70", "1970-09-01"),
            ("31/May/1999", "1999-05-31"),
        ] {
            assert!(ns(same).is_some());
            assert_eq!(ns(text), ns(same), "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_none() {
        for text in [
            "58-32",
            "22-Okt-2024",
            "2024102215274",
            "20241322152749",
            "20241022T1527",
            "20241022T2527490",
            "22-O-2024",
            "22 10 2024",
            "22-Octo-2024",
            "22.10.24",
            "22-Oct-124",
            "31-Jun-2024",
            "2024-Oct-22",
            "2024-13-01",
            "2023-02-29",
            "14",
            "14:",
            "14:61",
            "1:2:3:4",
            "10/22/2024",
            "14:11.6:12",
            "14:11 x",
            "2024-10-22T",
            "2024-10-22T15:00+",
            "2024-10-22T15:00+14:30",
            "2024-10-22T15:00-23",
            "2024-10-22T15:00+02:75",
            "",
            ":1",
        ] {
            assert_eq!(ns(text), None, "{text}");
        }
    }

    #[test]
    fn a_clock_runs_on_past_midnight_and_past_the_hour() {
        let run = |texts: &[&str]| {
            let mut clock = Clock::default();
            let stamps = texts.iter().filter_map(|t| parse(t.as_bytes(), None));
            stamps.map(|s| clock.seconds(s)).collect::<Vec<_>>()
        };
        assert_eq!(
            run(&["23:59:59.5", "00:00:00", "00:00:00.5"]),
            [0.0, 0.5, 1.0]
        );
        assert_eq!(run(&["59:59.9", "00:00.1", "00:00.2"]), [0.0, 0.2, 0.3]);
        assert_eq!(run(&["10:00:00", "09:59:00"]), [0.0, -60.0]);
        // A gap of more than half a day.
        assert_eq!(
            run(&["06:00:00", "06:00:01", "20:00:00"]),
            [0.0, 1.0, 50_400.0]
        );
        assert_eq!(run(&["59:59.9", "60:00.0", "60:00.1"]), [0.0, 0.1, 0.2]);
        // Neighbours that are swapped run on.
        let swapped = [
            "23:59:57", "23:59:56", "23:59:59", "23:59:58", "00:00:01", "00:00:00",
        ];
        assert_eq!(run(&swapped), [0.0, -1.0, 2.0, 1.0, 4.0, 3.0]);
        // From the newest to the oldest.
        let newest_first = ["00:00:00.5", "00:00:00", "23:59:59.5", "23:59:00"];
        assert_eq!(run(&newest_first), [0.0, -0.5, -1.0, -60.5]);
    }
}
