//! A moment of the calendar: when a clock was at 0, and when something of a recording was.

use crate::origin::{later, nanoseconds, rfc3339};
use std::fmt;

/// A moment of the calendar, such as when the clock of a recording was at 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// Nanoseconds from 1970, of the zone's clock where the zone is not known.
    pub unix_ns: u64,
    /// Whether the zone is known.
    pub zoned: bool,
}

/// Stretches shorter than this are told to the second, s.
const SHORT_S: f64 = 600.0;

impl Moment {
    /// A date with a time, as people write it: `2024-10-26 03:00`, `2024-10-26T03:00:05.5`, with `Z` or `+02:00` where it tells
    /// its zone; from 1970 to 2200. `None` where it is no such text, or no date of the calendar.
    ///
    /// ```
    /// use dgd_recording::Moment;
    /// assert_eq!(Moment::parse("2024-10-26 03:00").map(|m| m.zoned), Some(false));
    /// assert_eq!(Moment::parse("2024-10-26T03:00+02:00"), Moment::parse("2024-10-26T01:00:00Z"));
    /// assert_eq!(Moment::parse("3h"), None);
    /// assert_eq!(Moment::parse("2024-02-31 10:00"), None);
    /// ```
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        const MINUTES: usize = "2024-10-26T03:00".len();
        let (to_minutes, rest) = text.trim().split_at_checked(MINUTES)?;
        let seconds = if rest.starts_with(':') { "" } else { ":00" };
        let zone = if rest.ends_with(['Z', 'z']) || rest.contains(['+', '-']) {
            ""
        } else {
            "-00:00"
        };
        Self::of_rfc3339(&format!("{to_minutes}{seconds}{rest}{zone}"))
    }

    /// An RFC 3339 time; `-00:00` leaves the zone unknown.
    pub(crate) fn of_rfc3339(text: &str) -> Option<Self> {
        Some(Self {
            unix_ns: nanoseconds(text)?,
            zoned: !text.trim_end().ends_with("-00:00"),
        })
    }

    /// So many seconds later, or earlier; `None` before 1970 and after 2262.
    #[must_use]
    pub fn after(self, seconds: f64) -> Option<Self> {
        let unix_ns = later(self.unix_ns, seconds)?;
        i64::try_from(unix_ns).ok()?;
        Some(Self { unix_ns, ..self })
    }

    /// Seconds from this moment to another one; negative if that was before. Zones are not looked at.
    #[must_use]
    pub fn until(self, other: Self) -> f64 {
        let forward = other.unix_ns >= self.unix_ns;
        let seconds = other.unix_ns.abs_diff(self.unix_ns) as f64 * 1e-9;
        if forward { seconds } else { -seconds }
    }

    /// As RFC 3339 has it; `-00:00` where the zone is not known.
    #[must_use]
    pub fn rfc3339(self) -> String {
        rfc3339(i64::try_from(self.unix_ns).unwrap_or(i64::MAX), self.zoned)
    }

    /// As RFC 3339 has it, without a zone where it is not known: as people write it.
    ///
    /// ```
    /// # use dgd_recording::Moment;
    /// let told = |text: &str| Moment::parse(text).expect("a date").local();
    /// assert_eq!(told("2024-10-26 03:20:40"), "2024-10-26T03:20:40");
    /// assert_eq!(told("2024-10-26T03:20:40+02:00"), "2024-10-26T01:20:40Z");
    /// ```
    pub fn local(self) -> String {
        let told = self.rfc3339();
        told.trim_end_matches("-00:00").to_owned()
    }

    /// `2024-10-26 03:21`, to the nearest minute.
    ///
    /// ```
    /// # let at = dgd_recording::Moment::parse("2024-10-26 03:20:40").expect("a date");
    /// assert_eq!(at.to_minute(), "2024-10-26 03:21");
    /// ```
    #[must_use]
    pub fn to_minute(self) -> String {
        self.shown(60, 16)
    }

    /// A stretch of a clock that was at 0 at this moment: `2024-10-26 03:21 to 04:30`; short ones to the second.
    ///
    /// ```
    /// # let at = dgd_recording::Moment::parse("2024-10-26 00:00").expect("a date");
    /// assert_eq!(at.stretch((3600.0, 9000.0)).as_deref(), Some("2024-10-26 01:00 to 02:30"));
    /// assert_eq!(at.stretch((0.0, 90_000.0)).as_deref(), Some("2024-10-26 00:00 to 2024-10-27 01:00"));
    /// assert_eq!(at.stretch((60.0, 65.0)).as_deref(), Some("2024-10-26 00:01:00 to 00:01:05"));
    /// ```
    #[must_use]
    pub fn stretch(self, (from_s, to_s): (f64, f64)) -> Option<String> {
        let (from, to) = (self.after(from_s)?, self.after(to_s)?);
        let short = to_s - from_s < SHORT_S;
        let [from, to] = [from, to].map(|at| {
            if short {
                at.shown(1, 19)
            } else {
                at.to_minute()
            }
        });
        let same_day = from.get(..10) == to.get(..10);
        let until = if same_day { to.get(11..)? } else { &to };
        Some(format!("{from} to {until}"))
    }

    /// Rounded to so many seconds, cut after so many letters.
    fn shown(self, to_s: u64, letters: usize) -> String {
        let step = to_s * 1_000_000_000;
        let rounded = self.unix_ns.saturating_add(step / 2) / step * step;
        let rounded = Self {
            unix_ns: rounded,
            ..self
        };
        let mut text = rounded.rfc3339().replace('T', " ");
        text.truncate(letters);
        text
    }
}

impl fmt::Display for Moment {
    /// `2014-10-07 00:00:00 UTC`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = self.rfc3339().replace('T', " ");
        match told.strip_suffix('Z') {
            Some(utc) => write!(f, "{utc} UTC"),
            None => write!(f, "{} (time zone unknown)", told.trim_end_matches("-00:00")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Moment;

    #[test]
    fn a_moment_may_have_minutes_seconds_fractions_and_a_zone() {
        for (text, shown) in [
            (
                "2024-10-26 03:00",
                "2024-10-26 03:00:00 (time zone unknown)",
            ),
            (
                " 2024-10-26T03:00:05.5 ",
                "2024-10-26 03:00:05.5 (time zone unknown)",
            ),
            ("2024-10-26T03:00Z", "2024-10-26 03:00:00 UTC"),
            ("2024-10-26 03:00:00-05:30", "2024-10-26 08:30:00 UTC"),
            ("2024-10-26 03:00-05:30", "2024-10-26 08:30:00 UTC"),
        ] {
            let told = Moment::parse(text).map(|m| m.to_string());
            assert_eq!(told.as_deref(), Some(shown), "{text}");
        }
        // As it is written for machines.
        for (text, written) in [
            ("2024-10-26 03:00", "2024-10-26T03:00:00-00:00"),
            ("2024-02-29 03:00", "2024-02-29T03:00:00-00:00"),
            ("2000-02-29 03:00Z", "2000-02-29T03:00:00Z"),
        ] {
            let at = Moment::parse(text).expect("a date");
            assert_eq!(at.rfc3339(), written);
            assert_eq!(Moment::parse(&at.rfc3339()), Some(at));
        }
        for text in [
            "",
            "2024-10-26",
            "26.10.2024 03:00",
            "2024-13-26 03:00",
            "2024-10-26 24:00",
            "2024-02-31 10:00",
            "2023-02-29 10:00",
            "2100-02-29 10:00",
            "2024-04-31 10:00",
            "2024-10-00 10:00",
            "2024-10-26 03:00+14:30",
            "2024-10-26 03:00+02:75",
            "2024-10-26 03:00x",
            "2024-10-26 3:00 äöü",
        ] {
            assert_eq!(Moment::parse(text), None, "{text}");
        }
    }

    #[test]
    fn seconds_lead_from_one_moment_to_another_and_back() {
        let at = |text| Moment::parse(text).expect("a date");
        let (early, late) = (at("2024-10-26 23:59:59.5"), at("2024-10-28 00:00"));
        assert_eq!(early.until(late), 86_400.5);
        assert_eq!(late.until(early), -86_400.5);
        assert_eq!(early.after(86_400.5), Some(late));
        assert_eq!(at("1970-01-01 00:00").after(-1.0), None);
        assert_eq!(early.after(f64::NAN), None);
        assert_eq!(early.after(1e30), None);
    }

    #[test]
    fn rounding_takes_the_next_day_along() {
        let at = Moment::parse("2024-12-31 23:59:40").expect("a date");
        assert_eq!(at.to_minute(), "2025-01-01 00:00");
        let told = at.stretch((0.0, 600.0));
        assert_eq!(told.as_deref(), Some("2025-01-01 00:00 to 00:10"));
        assert_eq!(at.stretch((f64::NAN, 600.0)), None);
    }
}
