//! A window of the recordings' clock, in seconds or by dates.

use super::values::parse_range;
use dgd_recording::Moment;
use std::fmt;

/// What `--window` asks for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Window {
    /// Seconds of the recordings' clock.
    Clock(f64, f64),
    /// Dates.
    Dates(Moment, Moment),
}

impl Window {
    /// `14000:20000`, `3h:5h`, `2024-10-26T03:00/2024-10-26T05:00` or `2024-10-26T03:00/05:00`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let Some((from, to)) = text.split_once('/') else {
            let of_dates = text.matches('-').count() > 2;
            let (from, to) = parse_range(text).map_err(|e| match of_dates {
                true => "write two dates with a slash, such as 2024-10-26T03:00/05:00".to_owned(),
                false => e,
            })?;
            return Ok(Self::Clock(from, to));
        };
        let (from, to) = (from.trim(), to.trim());
        let date = |said: &str, whole: &str| {
            Moment::parse(whole).ok_or_else(|| {
                format!("`{said}` is not a date such as 2024-10-26T03:00 or 2024-10-26T03:00:00Z")
            })
        };
        let first = date(from, from)?;
        // An end may leave out the day of the beginning (ISO 8601).
        let day = from.get(..DAY).filter(|_| Moment::parse(to).is_none());
        let last = match day {
            Some(day) => date(to, &format!("{day}{to}"))?,
            None => date(to, to)?,
        };
        if first.zoned != last.zoned {
            return Err("one of the dates has a time zone, the other does not".into());
        }
        if first.until(last) < 0.0 {
            return Err(format!("{from} is after {to}"));
        }
        Ok(Self::Dates(first, last))
    }

    /// Seconds of a clock that was at 0 at a moment, or what keeps it from being told in dates.
    pub(crate) fn seconds(&self, began: Result<Moment, &str>) -> Result<(f64, f64), String> {
        match self {
            Self::Clock(from, to) => Ok((*from, *to)),
            Self::Dates(from, to) => {
                let began = began.map_err(|keeps| {
                    format!("--window {self} has dates, but {keeps}: give seconds, as in 3h:5h")
                })?;
                if from.zoned && !began.zoned {
                    return Err(format!(
                        "--window {self} has a time zone, but the recordings have none: give their own times, without a zone"
                    ));
                }
                Ok((began.until(*from), began.until(*to)))
            }
        }
    }

    /// Whether dates with a zone tell it.
    pub(crate) fn is_zoned(&self) -> bool {
        matches!(self, Self::Dates(from, _) if from.zoned)
    }

    /// Whether dates tell it.
    pub(crate) fn is_dated(&self) -> bool {
        matches!(self, Self::Dates(..))
    }
}

/// `2024-10-26T`.
const DAY: usize = 11;

impl fmt::Display for Window {
    /// As it may be asked for.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clock(from, to) => write!(f, "{from}:{to}"),
            Self::Dates(from, to) => {
                write!(f, "{}/{}", from.local(), to.local())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::Window;
    use dgd_recording::Moment;

    #[test]
    fn a_window_of_dates_lies_where_the_clock_says() {
        let began = Moment::parse("2024-10-25 22:00");
        for text in [
            "2024-10-26 03:00/2024-10-26 05:30",
            "2024-10-26T03:00/05:30",
            "2024-10-26T03:00:00/05:30:00",
        ] {
            let window = Window::parse(text).unwrap();
            assert_eq!(
                window.seconds(began.ok_or("")),
                Ok((18_000.0, 27_000.0)),
                "{text}"
            );
            assert!(window.seconds(Err("")).unwrap_err().contains("3h:5h"));
        }
        let utc = Moment::parse("2024-10-25T22:00Z");
        let zoned = Window::parse("2024-10-26T05:00+02:00/2024-10-26T05:30+02:00").unwrap();
        assert_eq!(zoned.seconds(utc.ok_or("")), Ok((18_000.0, 19_800.0)));
        assert!(zoned.seconds(began.ok_or("")).unwrap_err().contains("zone"));
        // Times are told in UTC where the zone is known, and so a date without one is of UTC.
        let window = Window::parse("2024-10-26T03:00/05:00").unwrap();
        assert_eq!(window.seconds(utc.ok_or("")), Ok((18_000.0, 25_200.0)));
    }

    #[test]
    fn a_window_is_told_as_it_may_be_asked_for_again() {
        for (text, told) in [
            (
                "2024-10-26 03:00 / 05:30",
                "2024-10-26T03:00:00/2024-10-26T05:30:00",
            ),
            (
                "2024-10-26T03:00:00.5-00:00/2024-10-27T00:00",
                "2024-10-26T03:00:00.5/2024-10-27T00:00:00",
            ),
            (
                "2024-10-26T05:00+02:00/05:30+02:00",
                "2024-10-26T03:00:00Z/2024-10-26T03:30:00Z",
            ),
            ("3h:5h", "10800:18000"),
        ] {
            let window = Window::parse(text).unwrap();
            assert_eq!(window.to_string(), told);
            assert_eq!(Window::parse(told), Ok(window));
        }
    }

    #[test]
    fn a_window_of_the_clock_knows_no_dates() {
        let window = Window::parse("3h:5h").unwrap();
        assert_eq!(window, Window::Clock(10_800.0, 18_000.0));
        assert_eq!(window.seconds(Err("")), Ok((10_800.0, 18_000.0)));
    }

    #[test]
    fn what_is_no_window_is_refused_with_what_to_write() {
        for (text, told) in [
            ("2024-10-26T03:00/x", "`x` is not a date"),
            ("yesterday/today", "`yesterday` is not a date"),
            (
                "2024-02-28T03:00/2024-02-31T05:00",
                "`2024-02-31T05:00` is not a date",
            ),
            ("2023-02-29T03:00/05:00", "`2023-02-29T03:00` is not a date"),
            (
                "2024-10-26T03:00+99:00/05:00+99:00",
                "`2024-10-26T03:00+99:00` is not a date",
            ),
            ("2024-10-26T03:00/02:00", "is after"),
            ("2024-10-26T03:00Z/2024-10-26T05:00", "the other does not"),
            ("2024-10-26T03:00:2024-10-26T05:00", "with a slash"),
            ("3h", "with a colon"),
        ] {
            let error = Window::parse(text).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
