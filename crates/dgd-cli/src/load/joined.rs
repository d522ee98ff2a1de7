//! Recordings behind each other on one clock, by the dates that their files tell.

use crate::failure::Failure;
use dgd_recording::{Moment, Recording};
use std::path::{Path, PathBuf};
use tracing::warn;

/// What keeps a clock from being told in dates where a recording has none.
pub(super) const UNDATED: &str = "not all of the recordings have";

/// What was joined so far: where it ends, if a date tells.
#[derive(Debug, Default)]
pub(super) struct Joint {
    /// The last recording that has dates.
    dated: Option<Dated>,
    /// Whether the last recording has.
    ends_dated: bool,
    /// Whether a recording has none.
    undated: bool,
    /// Whether a recording stands 120 s behind the one before it, wherever its dates are.
    by_rule: bool,
    /// The last recording.
    last: Option<Clock>,
    /// How recordings were joined, where who reads the answer must know.
    warnings: Vec<String>,
}

/// Whence a recording is, and what its file tells of its time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken<'a> {
    pub(super) path: &'a Path,
    /// When its earliest row was taken.
    pub(super) began: Option<Moment>,
    /// What its clock reads there, s, whatever it counts from.
    pub(super) first_stamp_s: Option<f64>,
}

/// What the clock of a recording reads, whatever it counts from.
#[derive(Debug)]
struct Clock {
    path: PathBuf,
    from_s: f64,
    to_s: f64,
}

/// A recording that tells when it was taken.
#[derive(Debug)]
struct Dated {
    path: PathBuf,
    /// First and last sample, ns from 1970.
    from_ns: i64,
    to_ns: i64,
    zoned: bool,
    samples: usize,
}

/// How a recording stands behind the one before it.
#[derive(Debug, PartialEq)]
enum Seam {
    /// So many samples are missing between them.
    Missing(usize),
    /// So many of its first samples were taken before the one before it ends.
    Shared(usize),
    /// Nothing tells.
    Untold,
}

impl Joint {
    /// Of a first recording.
    pub(super) fn of(taken: Taken<'_>, recording: &Recording) -> Self {
        let dated = (taken.began).map(|began| Dated::of(taken.path, began, recording));
        Self {
            ends_dated: dated.is_some(),
            undated: dated.is_none(),
            dated,
            by_rule: false,
            last: Clock::of(taken, recording),
            warnings: Vec::new(),
        }
    }

    /// What keeps the joint clock from being told in dates, if anything does.
    pub(super) fn keeps_dates(&self) -> Option<&'static str> {
        if self.undated {
            Some(UNDATED)
        } else if self.by_rule {
            Some("not all of the recordings lie where theirs say")
        } else {
            None
        }
    }

    /// What was warned of.
    pub(super) fn into_warnings(self) -> Vec<String> {
        self.warnings
    }

    fn warn(&mut self, warning: String) {
        warn!("{warning}");
        self.warnings.push(warning);
    }

    /// Appends a recording to what was joined, as far behind as it was taken unless most would be missing then; 120 s behind where
    /// that is not known. What both hold counts once; a value that only one of them has stays.
    ///
    /// Returns how many of its samples are left out; refuses one that was taken before the one before it.
    pub(super) fn append(
        &mut self,
        all: &mut Recording,
        later: Recording,
        step_s: f64,
        taken: Taken<'_>,
    ) -> Result<usize, Failure> {
        let path = taken.path;
        let dated = (taken.began).map(|began| Dated::of(path, began, &later));
        self.undated |= dated.is_none();
        let clock = Clock::of(taken, &later);
        let seam = match (&self.dated, &dated) {
            (Some(before), Some(dated)) => {
                let (seam, doubt) = dated.behind(before, step_s)?;
                doubt.into_iter().for_each(|doubt| self.warn(doubt));
                if self.ends_dated { seam } else { Seam::Untold }
            }
            (None, None) => self.by_clocks(all, &later, clock.as_ref(), step_s),
            _ => Seam::Untold,
        };
        let before = self.dated.as_ref();
        let path_before = (before.map(|b| &b.path)).or(self.last.as_ref().map(|last| &last.path));
        let told_before = path_before.map_or(String::new(), |path| path.display().to_string());
        let told = path.display();
        let close = before.map_or(0, |b| b.samples) + later.len();
        let mut left_out = 0;
        let appended = match seam {
            Seam::Missing(seam) if seam <= close => all.append_after(later, step_s, seam),
            Seam::Missing(seam) => {
                self.by_rule = true;
                self.warn(format!(
                    "{told} begins {:.1} h after {told_before} ends; on the joint clock 120 s lie between them",
                    seam as f64 * step_s / 3600.0
                ));
                all.append(later, step_s)
            }
            Seam::Shared(shared) if !same(all, &later, shared) => {
                let shared = shared.min(later.len());
                self.by_rule = true;
                self.warn(format!(
                    "{told}: its first {shared} samples share times with {told_before} but have other values (was a clock set back?); all are \
                     kept, with 120 s between the two recordings on the joint clock"
                ));
                all.append(later, step_s)
            }
            Seam::Shared(shared) => {
                let start = all.len() - shared;
                let known = shared.min(later.len());
                let appended = all.append_after(later.slice(known..later.len()), step_s, 0);
                let filled = fill(all, &later, start);
                let within = known == later.len();
                if within && filled == 0 {
                    return Err(Failure::input(
                        path,
                        format!(
                            "contains nothing that {told_before} does not contain: give each stretch of time once"
                        ),
                    ));
                }
                let but = match filled {
                    0 => String::new(),
                    n => format!(", but for {n} values that {told_before} lacks"),
                };
                self.warn(format!(
                    "{told}: its first {known} samples are the last of {told_before}; they are left out{but}"
                ));
                left_out = known;
                if within {
                    // What was joined still ends with the recording before.
                    return appended
                        .map(|_| left_out)
                        .map_err(|e| Failure::input(path, e));
                }
                appended
            }
            Seam::Untold => {
                self.by_rule = true;
                let reversed = clock.as_ref().zip(self.last.as_ref());
                if let Some(doubt) = reversed.and_then(|(clock, last)| clock.before(last)) {
                    self.warn(doubt);
                }
                all.append(later, step_s)
            }
        };
        appended.map_err(|e| Failure::input(path, e))?;
        self.ends_dated = dated.is_some();
        self.dated = dated.or(self.dated.take());
        self.last = clock;
        Ok(left_out)
    }

    /// Where a recording begins in the one before it by clocks that tell no date, if they have the same samples there: clocks that begin
    /// anew read the same at other times, but of no noisy transmitter twice the same.
    fn by_clocks(
        &self,
        all: &Recording,
        later: &Recording,
        clock: Option<&Clock>,
        step_s: f64,
    ) -> Seam {
        /// Fewer samples may be alike by chance, where a rig stands still.
        const FEWEST: usize = 30;
        let shared = self.last.as_ref().zip(clock).and_then(|(last, clock)| {
            let within = (last.from_s..=last.to_s).contains(&clock.from_s);
            within.then(|| whole((last.to_s - clock.from_s) / step_s) + 1)
        });
        match shared {
            Some(shared) if alike(all, later, shared).is_some_and(|of| of.are_same(FEWEST)) => {
                Seam::Shared(shared)
            }
            _ => Seam::Untold,
        }
    }
}

/// A number of steps, to the nearest whole one; 0 below it.
fn whole(steps: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative; what is too large saturates"
    )]
    let whole = steps.round().max(0.0) as usize;
    whole
}

impl Clock {
    /// `None` of a recording without a clock of its own.
    fn of(taken: Taken<'_>, recording: &Recording) -> Option<Self> {
        let first_s = taken.first_stamp_s?;
        // The even clock counts from the earliest row.
        Some(Self {
            path: taken.path.to_owned(),
            from_s: first_s + recording.time_s.first()?,
            to_s: first_s + recording.time_s.last()?,
        })
    }

    /// A doubt of the order, where its clock ends before that of the recording given before it begins. No more than a doubt: seconds of
    /// the day begin again at midnight, and a recorder at its start.
    fn before(&self, other: &Self) -> Option<String> {
        (self.to_s < other.from_s).then(|| {
            format!(
                "{}: its clock reads {:.0} to {:.0} s, that of {}, given before it, {:.0} to {:.0} s: if both count from the same moment, give the \
                 recordings in time order; taken as given, with 120 s between them on the joint clock",
                self.path.display(),
                self.from_s,
                self.to_s,
                other.path.display(),
                other.from_s,
                other.to_s
            )
        })
    }
}

impl Dated {
    /// On its even clock, which counts from the first row of the file.
    fn of(path: &Path, began: Moment, recording: &Recording) -> Self {
        let at = |time_s: Option<&f64>| {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "what is beyond the range ends at it"
            )]
            let after_ns = (1e9 * time_s.copied().unwrap_or(0.0)).round() as i64;
            began.unix_ns.cast_signed().saturating_add(after_ns)
        };
        Self {
            path: path.to_owned(),
            from_ns: at(recording.time_s.first()),
            to_ns: at(recording.time_s.last()),
            zoned: began.zoned,
            samples: recording.len(),
        }
    }

    /// How it stands behind another, with what is to be doubted; refused if it begins before it.
    fn behind(&self, before: &Self, step_s: f64) -> Result<(Seam, Option<String>), Failure> {
        let told_before = before.path.display();
        if self.zoned != before.zoned {
            let doubt = format!(
                "{}: only one of it and {told_before} has a time zone; on the joint clock 120 s lie between them",
                self.path.display()
            );
            return Ok((Seam::Untold, Some(doubt)));
        }
        if self.from_ns < before.from_ns {
            let early_s = 1e-9 * before.from_ns.abs_diff(self.from_ns) as f64;
            return Err(Failure::Input {
                path: self.path.clone(),
                reason: format!(
                    "begins {early_s:.0} s before {told_before}: give the recordings in time order"
                ),
                help: (!self.zoned).then(|| {
                    "if a clock was set back between them, write the times with their time zones".into()
                }),
            });
        }
        let ahead_ns = i128::from(self.from_ns) - i128::from(before.to_ns);
        let steps = 1e-9 * ahead_ns as f64 / step_s;
        let seam = if ahead_ns > 0 {
            // What begins within half a step is the next sample.
            Seam::Missing(whole(steps).max(1) - 1)
        } else {
            Seam::Shared(whole(-steps) + 1)
        };
        Ok((seam, None))
    }
}

/// Puts what a recording has where another, from `start` on, has no value; says how many values those were.
fn fill(all: &mut Recording, later: &Recording, start: usize) -> usize {
    let mut filled = 0;
    for (channel, theirs) in later.series() {
        let Some(mine) = all.channel_mut(channel) else {
            continue;
        };
        for (mine, theirs) in mine[start..].iter_mut().zip(theirs) {
            if !mine.is_finite() && theirs.is_finite() {
                *mine = *theirs;
                filled += 1;
            }
        }
    }
    filled
}

/// Samples of two recordings that both have a value.
struct Compared {
    all: usize,
    equal: usize,
}

impl Compared {
    /// Whether they are the same but for one in ten, of as many at least.
    fn are_same(&self, fewest: usize) -> bool {
        self.all >= fewest && 10 * self.equal >= 9 * self.all
    }
}

/// Whether the first samples of a recording are those that another ends with, so many of them, but for one in ten.
fn same(all: &Recording, later: &Recording, shared: usize) -> bool {
    alike(all, later, shared).is_some_and(|compared| compared.are_same(0))
}

/// The first samples of a recording beside those that another ends with, so many of them; `None` if it has fewer.
fn alike(all: &Recording, later: &Recording, shared: usize) -> Option<Compared> {
    let start = all.len().checked_sub(shared)?;
    let (ended, begun) = (all.series(), later.series());
    let pairs: Vec<(&[f64], &[f64])> = (ended.iter())
        .filter_map(|(channel, ended)| {
            let (_, begun) = begun.iter().find(|(c, _)| c == channel)?;
            Some((&ended[start..], *begun))
        })
        .collect();
    let (mut compared, mut equal) = (0_usize, 0_usize);
    for row in 0..shared.min(later.len()) {
        let values = pairs.iter().map(|(a, b)| (a[row], b[row]));
        let mut both = values.filter(|(a, b)| a.is_finite() && b.is_finite());
        if let Some((a, b)) = both.next() {
            compared += 1;
            equal += usize::from(a == b && both.all(|(a, b)| a == b));
        }
    }
    Some(Compared {
        all: compared,
        equal,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Clock, Joint, Taken, same};
    use crate::failure::Failure;
    use dgd_recording::{Moment, Recording};
    use std::path::Path;

    const STEP_S: f64 = 2.0;
    /// A midnight.
    const MIDNIGHT_NS: i64 = 16_000 * 86_400_000_000_000;

    /// Samples from one on, each of them like no other.
    fn samples(from: u32, count: u32) -> Recording {
        let values: Vec<f64> = (from..from + count).map(f64::from).collect();
        Recording {
            time_s: (0..count).map(|i| STEP_S * f64::from(i)).collect(),
            mud_pump_flow_m3_s: values.clone(),
            booster_flow_m3_s: values.clone(),
            topfill_flow_m3_s: vec![0.0; values.len()],
            return_flow_m3_s: values.clone(),
            pump_speed_pct: values,
            ..Recording::default()
        }
    }

    fn began(at_s: i64, zoned: bool) -> Option<Moment> {
        let unix_ns = (MIDNIGHT_NS + 1_000_000_000 * at_s).cast_unsigned();
        Some(Moment { unix_ns, zoned })
    }

    /// One after another, each with its beginning; the samples left out and what came of it.
    fn joined(all: &[(Option<Moment>, Recording)]) -> Result<(usize, Recording), Failure> {
        let taken = |path, began| Taken {
            path: Path::new(path),
            began,
            first_stamp_s: None,
        };
        let (first, mut whole) = all[0].clone();
        let mut joint = Joint::of(taken("a.csv", first), &whole);
        let mut left_out = 0;
        for (began, next) in &all[1..] {
            let at = taken("b.csv", *began);
            left_out += joint.append(&mut whole, next.clone(), STEP_S, at)?;
        }
        Ok((left_out, whole))
    }

    #[test]
    fn recordings_stand_as_far_apart_as_they_were_taken() {
        let first = || (began(0, true), samples(0, 10));
        for (at_s, taken, left_out, length) in [
            (20, 10, 0, 15),
            // Within half a step of the last sample.
            (19, 10, 0, 15),
            (24, 12, 0, 17),
            // Mostly nothing: 120 s.
            (50, 25, 0, 30),
            (52, 26, 0, 75),
            (10_000_000, 0, 0, 75),
            (18, 9, 1, 14),
            (12, 6, 4, 11),
            // Other values at the same times.
            (12, 7, 0, 75),
        ] {
            let next = (began(at_s, true), samples(taken, 5));
            let (out, all) = joined(&[first(), next]).unwrap();
            assert_eq!((out, all.len()), (left_out, length), "{at_s}");
            assert_eq!(*all.time_s.last().unwrap(), STEP_S * (length - 1) as f64);
            assert_eq!(all.pump_speed_pct.last(), Some(&f64::from(taken + 4)));
        }
    }

    #[test]
    fn what_only_the_later_recording_has_of_the_stretch_of_both_is_kept() {
        // The first ends in rows without values, the later has a transmitter that it lacks.
        let mut first = samples(0, 10);
        for channel in first.series().iter().map(|(c, _)| *c).collect::<Vec<_>>() {
            first.channel_mut(channel).unwrap()[6..].fill(f64::NAN);
        }
        let mut later = samples(6, 5);
        later.riser_pressure_pa = Some(vec![2e5; 5]);
        let all = [(began(0, true), first), (began(12, true), later)];
        let (left_out, whole) = joined(&all).unwrap();
        assert_eq!((left_out, whole.len()), (4, 11));
        assert_eq!(whole.pump_speed_pct, samples(0, 11).pump_speed_pct);
        assert_eq!(whole.riser_pressure_pa.unwrap()[6..], [2e5; 5]);

        // One that lies within the other may have what that lacks, and the next stands behind the longer one.
        let mut first = samples(0, 10);
        first.return_flow_m3_s[3] = f64::NAN;
        let all = [
            (began(0, true), first),
            (began(4, true), samples(2, 5)),
            (began(20, true), samples(10, 5)),
        ];
        let (left_out, whole) = joined(&all).unwrap();
        assert_eq!((left_out, whole.len()), (5, 15));
        assert_eq!(whole.return_flow_m3_s, samples(0, 15).return_flow_m3_s);
    }

    /// Filler never outgrows what was recorded by much, however many recordings there are.
    #[test]
    fn what_was_joined_before_excuses_no_longer_gap() {
        let days = |n: u32| (began(i64::from(n) * 100, true), samples(50 * n, 10));
        let (_, all) = joined(&(0..40).map(days).collect::<Vec<_>>()).unwrap();
        assert_eq!(all.len(), 40 * 10 + 39 * 60);
    }

    #[test]
    fn rows_in_another_order_begin_with_their_earliest() {
        // The file's clock counts from its first row, which is the last.
        let mut newest_first = samples(10, 5);
        newest_first.time_s.iter_mut().for_each(|t| *t -= 8.0);
        let all = [
            (began(0, true), samples(0, 10)),
            (began(28, true), newest_first),
        ];
        assert_eq!(joined(&all).unwrap().1.len(), 15);
    }

    #[test]
    fn without_a_date_or_with_zones_half_known_120_s_lie_between() {
        let apart = |first, next| {
            let all = [(first, samples(0, 10)), (next, samples(10, 5))];
            joined(&all).unwrap().1.len()
        };
        assert_eq!(apart(began(0, true), began(20, true)), 15);
        assert_eq!(apart(began(0, false), began(20, false)), 15);
        assert_eq!(apart(began(0, true), began(20, false)), 75);
        assert_eq!(apart(None, began(20, true)), 75);
        assert_eq!(apart(began(0, true), None), 75);
    }

    #[test]
    fn what_is_not_later_is_refused() {
        let first = || (began(100, false), samples(0, 10));
        let refused = |all: &[(Option<Moment>, Recording)]| joined(all).unwrap_err();
        let before = (began(80, false), samples(20, 30));
        for all in [
            vec![first(), before.clone()],
            // Nor is the order forgotten over one without a date.
            vec![first(), (None, samples(10, 5)), before],
        ] {
            let Failure::Input { reason, help, .. } = refused(&all) else {
                panic!("not of the input");
            };
            let order = "begins 20 s before a.csv: give the recordings in time order";
            assert_eq!(reason, order);
            assert!(help.unwrap().contains("zones"));
        }
        for (at_s, taken, count) in [(100, 0, 10), (104, 2, 8)] {
            let said = refused(&[first(), (began(at_s, false), samples(taken, count))]);
            assert!(
                said.to_string()
                    .contains("contains nothing that a.csv does not contain")
            );
        }
    }

    #[test]
    fn clocks_without_dates_that_run_back_are_doubted_and_those_that_begin_again_are_not() {
        let taken = |name, first_stamp_s| Taken {
            path: Path::new(name),
            began: None,
            first_stamp_s,
        };
        let of = |name, from_s| Clock::of(taken(name, Some(from_s)), &samples(0, 10)).unwrap();
        let doubt = |first, next| of("b.csv", next).before(&of("a.csv", first));
        let said = doubt(200.0, 0.0).unwrap();
        let told = "b.csv: its clock reads 0 to 18 s, that of a.csv, given before it, 200 to 218 s";
        assert!(
            said.starts_with(told) && said.contains("time order"),
            "{said}"
        );
        // In order, and each from its own start.
        assert_eq!(doubt(0.0, 200.0), None);
        assert_eq!(doubt(0.0, 0.0), None);
        assert!(Clock::of(taken("none.csv", None), &samples(0, 10)).is_none());
    }

    #[test]
    fn by_clocks_without_dates_what_two_recordings_share_counts_once_if_there_is_enough_of_it() {
        let joined = |from_s: f64, first: u32| {
            let taken = |name, first_stamp_s| Taken {
                path: Path::new(name),
                began: None,
                first_stamp_s: Some(first_stamp_s),
            };
            let mut whole = samples(0, 100);
            let mut joint = Joint::of(taken("a.csv", 50.0), &whole);
            let next = samples(first, 60);
            let left_out = joint.append(&mut whole, next, STEP_S, taken("b.csv", from_s));
            (left_out.unwrap(), whole.len(), joint.into_warnings())
        };
        // The first clock reads 50 to 248 s.
        let (left_out, length, warnings) = joined(50.0 + 120.0, 60);
        assert_eq!((left_out, length), (40, 120));
        let told = "b.csv: its first 40 samples are the last of a.csv; they are left out";
        assert_eq!(warnings, [told]);
        // Other samples at these times, from a clock that began anew; and fewer than tell.
        for (from_s, first) in [(50.0 + 120.0, 200), (50.0, 100), (50.0 + 160.0, 80)] {
            let (left_out, length, warnings) = joined(from_s, first);
            assert_eq!((left_out, length, warnings.len()), (0, 220, 0), "{from_s}");
        }
    }

    #[test]
    fn what_keeps_dates_from_a_joint_clock_is_told() {
        let keeps = |next: Option<Moment>| {
            let taken = |began| Taken {
                path: Path::new("a.csv"),
                began,
                first_stamp_s: None,
            };
            let mut whole = samples(0, 10);
            let mut joint = Joint::of(taken(began(0, true)), &whole);
            (joint.append(&mut whole, samples(10, 5), STEP_S, taken(next))).unwrap();
            (joint.keeps_dates(), joint.into_warnings().len())
        };
        assert_eq!(keeps(began(20, true)), (None, 0));
        let moved = Some("not all of the recordings lie where theirs say");
        assert_eq!(keeps(began(90_000, true)), (moved, 1));
        assert_eq!(keeps(None), (Some("not all of the recordings have"), 0));
    }

    #[test]
    fn samples_are_the_same_with_one_of_ten_off() {
        let (all, mut later) = (samples(0, 30), samples(20, 20));
        assert!(same(&all, &later, 10));
        assert!(!same(&all, &later, 11));
        assert!(!same(&all, &later, 31), "longer than all there is");
        later.pump_speed_pct[3] = 0.0;
        assert!(same(&all, &later, 10));
        // What has no value is not compared.
        later.return_flow_m3_s[4] = f64::NAN;
        assert!(same(&all, &later, 10));
        later.booster_flow_m3_s[5] = 0.0;
        assert!(!same(&all, &later, 10));
    }
}
