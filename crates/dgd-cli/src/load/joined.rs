//! Recordings behind each other on one clock, by the dates that their files tell.

use crate::failure::Failure;
use dgd_recording::Recording;
use std::path::{Path, PathBuf};
use tracing::warn;

/// A recording that tells when it began.
pub(super) struct Dated {
    path: PathBuf,
    /// First sample, ns from 1970.
    from_ns: u64,
    /// Last sample.
    to_ns: u64,
}

/// How far a recording stands behind the one before it.
#[derive(Debug, PartialEq)]
pub(super) enum Apart {
    /// So many samples are missing between them.
    Missing(usize),
    /// So many of its first samples were taken before the one before it ends.
    Shared(usize),
}

impl Dated {
    /// On its even clock, from the time of its first sample.
    pub(super) fn of(path: &Path, from_ns: u64, recording: &Recording) -> Self {
        let times = &recording.time_s;
        let ends = times.first().zip(times.last());
        let lasts_s = ends.map_or(0.0, |(first, last)| (last - first).max(0.0));
        Self {
            path: path.to_owned(),
            from_ns,
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative; the last instant at the most"
            )]
            to_ns: from_ns.saturating_add((1e9 * lasts_s).round() as u64),
        }
    }

    /// How far this one stands behind another; refused if it does not end after it.
    pub(super) fn behind(&self, before: &Self, step_s: f64) -> Result<Apart, Failure> {
        if self.from_ns < before.from_ns || self.to_ns <= before.to_ns {
            let early = 1e-9 * (before.from_ns.saturating_sub(self.from_ns)) as f64;
            let before = before.path.display();
            let reason = if early > 0.0 {
                format!("begins {early} s before {before}: name the recordings in order of time")
            } else {
                format!(
                    "ends no later than {before}, which covers its time: name each stretch of time once"
                )
            };
            return Err(Failure::input(&self.path, reason));
        }
        let ahead_ns = i128::from(self.from_ns) - i128::from(before.to_ns);
        let steps = (1e-9 * ahead_ns as f64 / step_s).round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive; what is too large saturates"
        )]
        Ok(if steps >= 1.0 {
            Apart::Missing(steps as usize - 1)
        } else {
            Apart::Shared((1.0 - steps) as usize)
        })
    }
}

/// Appends a recording, as far behind as it was taken unless most would be missing then; 120 s behind if that is not known.
/// Returns how many of its samples are left out.
pub(super) fn append(
    all: &mut Recording,
    later: Recording,
    step_s: f64,
    (path, apart): (&Path, Option<Apart>),
) -> Result<usize, Failure> {
    let mut left_out = 0;
    let longest = all.len() + later.len();
    let appended = match apart {
        Some(Apart::Missing(seam)) if seam <= longest => all.append_after(later, step_s, seam),
        Some(Apart::Missing(seam)) => {
            warn!(
                "{} begins {:.1} h after the recording before it ends; on the joint clock 120 s lie between them",
                path.display(),
                seam as f64 * step_s / 3600.0
            );
            all.append(later, step_s)
        }
        Some(Apart::Shared(shared)) => {
            warn!(
                "{}: its first {shared} samples were taken before the recording before it ends; they are left out",
                path.display()
            );
            left_out = shared.min(later.len());
            let rest = later.slice(left_out..later.len());
            all.append_after(rest, step_s, 0)
        }
        None => all.append(later, step_s),
    };
    appended.map_err(|e| Failure::input(path, e))?;
    Ok(left_out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Apart, Dated, append};
    use dgd_recording::Recording;
    use std::path::Path;

    const STEP_S: f64 = 2.0;
    const DAY_NS: u64 = 86_400_000_000_000;

    fn recording(samples: u32) -> Recording {
        let time_s: Vec<f64> = (0..samples).map(|i| STEP_S * f64::from(i)).collect();
        Recording {
            mud_pump_flow_m3_s: time_s.clone(),
            booster_flow_m3_s: time_s.clone(),
            topfill_flow_m3_s: time_s.clone(),
            return_flow_m3_s: time_s.clone(),
            pump_speed_pct: time_s.clone(),
            time_s,
            ..Recording::default()
        }
    }

    /// So many samples from so many seconds after a midnight on.
    fn dated(from_s: f64, samples: u32) -> Dated {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, less than a year"
        )]
        let from_ns = 16_000 * DAY_NS + (1e9 * from_s) as u64;
        Dated::of(Path::new("rig.csv"), from_ns, &recording(samples))
    }

    /// Ten samples and five more from so many seconds later on.
    fn joined(from_s: f64) -> (usize, Recording) {
        let apart = dated(from_s, 5).behind(&dated(0.0, 10), STEP_S).unwrap();
        let mut all = recording(10);
        let path = Path::new("rig.csv");
        let left_out = append(&mut all, recording(5), STEP_S, (path, Some(apart))).unwrap();
        (left_out, all)
    }

    #[test]
    fn recordings_stand_as_far_apart_as_they_were_taken() {
        for (from_s, left_out, samples) in [
            (20.0, 0, 15),
            // Half a step off is the same step.
            (20.9, 0, 15),
            (24.0, 0, 17),
            // Mostly nothing: 120 s.
            (50.0, 0, 30),
            (52.0, 0, 75),
            (1e7, 0, 75),
            (18.0, 1, 14),
            (12.0, 4, 11),
        ] {
            let (out, all) = joined(from_s);
            assert_eq!((out, all.len()), (left_out, samples), "{from_s}");
            let last = all.time_s.last().unwrap();
            assert_eq!(*last, STEP_S * (samples - 1) as f64);
            assert_eq!(all.pump_speed_pct.last(), Some(&8.0));
        }
    }

    #[test]
    fn what_is_not_later_is_refused() {
        for (from_s, samples, part) in [
            (
                -20.0,
                10,
                "begins 20 s before rig.csv: name the recordings in order of time",
            ),
            (0.0, 10, "covers its time"),
            (4.0, 8, "covers its time"),
        ] {
            let one = dated(100.0 + from_s, samples);
            let refused = one
                .behind(&dated(100.0, 10), STEP_S)
                .unwrap_err()
                .to_string();
            assert!(refused.contains(part), "{refused}");
        }
        let same = dated(100.0, 11).behind(&dated(100.0, 10), STEP_S).unwrap();
        assert_eq!(same, Apart::Shared(10));
    }
}
