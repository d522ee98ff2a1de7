//! Sampled inputs: interpolation, kinks, and a cursor that looks pieces up in constant time.

/// How a signal behaves between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Straight lines between samples (`interp1(..., 'linear')` of the thesis).
    #[default]
    Linear,
    /// Each value holds until the next sample (set-points).
    Hold,
}

/// Why a signal was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// Times and values differ in length.
    #[error("`{name}` has {found} values, expected {expected} (one per time)")]
    Length {
        /// Signal.
        name: String,
        /// Number of times.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// No sample at all.
    #[error("`{name}` has no samples, expected at least one")]
    Empty {
        /// Signal.
        name: String,
    },
    /// A value or time is NaN or infinite.
    #[error("`{name}` is not finite at sample {index}, expected finite times and values")]
    NonFinite {
        /// Signal.
        name: String,
        /// First bad sample.
        index: usize,
    },
    /// Times do not ascend strictly.
    #[error("`{name}` has time {found} s at sample {index}, expected more than {before} s")]
    Time {
        /// Signal.
        name: String,
        /// Offending sample.
        index: usize,
        /// Time before it.
        before: f64,
        /// Its time.
        found: f64,
    },
}

/// A signal sampled on an ascending time grid, borrowed.
///
/// Before the first and after the last sample it keeps the end value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signal<'a> {
    name: &'a str,
    time_s: &'a [f64],
    values: &'a [f64],
    interpolation: Interpolation,
}

/// A straight piece of a signal: `value + slope·(t − from_s)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Piece {
    /// Time at which it starts, s.
    pub from_s: f64,
    /// Value there, the limit from inside.
    pub value: f64,
    /// Change a second.
    pub slope: f64,
}

impl Piece {
    /// Value at `t`.
    #[must_use]
    #[inline(always)]
    pub fn at(&self, t: f64) -> f64 {
        self.value + self.slope * (t - self.from_s)
    }
}

/// Position in a [`Signal`]; moving it forward costs constant time a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cursor {
    /// Number of samples at or before the time last asked for.
    passed: usize,
}

impl<'a> Signal<'a> {
    /// Checks the samples and wraps them.
    ///
    /// - `name`: used in errors.
    /// - `time_s`: sample times, s, shape `(n,)`, strictly ascending, finite.
    /// - `values`: shape `(n,)`, finite.
    ///
    /// # Errors
    /// See [`InputError`]; the first offending sample is named.
    pub fn new(
        name: &'a str,
        time_s: &'a [f64],
        values: &'a [f64],
        interpolation: Interpolation,
    ) -> Result<Self, InputError> {
        let owned = || name.to_owned();
        if time_s.len() != values.len() {
            return Err(InputError::Length {
                name: owned(),
                expected: time_s.len(),
                found: values.len(),
            });
        }
        if time_s.is_empty() {
            return Err(InputError::Empty { name: owned() });
        }
        // Without an early exit the compiler takes several at once; who is to blame is asked after.
        let finite = |all: &[f64]| all.iter().fold(true, |fine, v| fine & v.is_finite());
        let steps = time_s.iter().zip(time_s.get(1..).unwrap_or_default());
        let rising = steps.fold(true, |fine, (a, b)| fine & (a < b));
        if !(finite(time_s) & finite(values) & rising) {
            Self::refuse(name, time_s, values)?;
        }
        Ok(Self {
            name,
            time_s,
            values,
            interpolation,
        })
    }

    /// Names the first sample that is not finite or not later than the one before.
    #[cold]
    fn refuse(name: &str, time_s: &[f64], values: &[f64]) -> Result<(), InputError> {
        let owned = || name.to_owned();
        let mut before = f64::NEG_INFINITY;
        for (index, (&t, &v)) in time_s.iter().zip(values).enumerate() {
            if !(t.is_finite() && v.is_finite()) {
                return Err(InputError::NonFinite {
                    name: owned(),
                    index,
                });
            }
            if t <= before {
                return Err(InputError::Time {
                    name: owned(),
                    index,
                    before,
                    found: t,
                });
            }
            before = t;
        }
        Ok(())
    }

    /// Name given at construction.
    #[must_use]
    pub fn name(&self) -> &'a str {
        self.name
    }

    /// Sample times, s.
    #[must_use]
    pub fn time_s(&self) -> &'a [f64] {
        self.time_s
    }

    /// Sample values.
    #[must_use]
    pub fn values(&self) -> &'a [f64] {
        self.values
    }

    /// Value at `t`, found by bisection; at a jump the value after it. NaN at no time.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        if t.is_nan() {
            return f64::NAN;
        }
        self.after(self.time_s.partition_point(|&s| s <= t), t)
    }

    /// Value at `t`, given that `passed` samples lie at or before it.
    #[inline(always)]
    fn after(&self, passed: usize, t: f64) -> f64 {
        let Some(left) = passed.checked_sub(1) else {
            return self.values[0];
        };
        if passed == self.values.len() || self.interpolation == Interpolation::Hold {
            return self.values[left];
        }
        let (t0, t1) = (self.time_s[left], self.time_s[passed]);
        let (v0, v1) = (self.values[left], self.values[passed]);
        if t == t0 {
            v0
        } else {
            v0 + (v1 - v0) * ((t - t0) / (t1 - t0))
        }
    }

    /// The straight piece over `start..=end`, which must hold no kink inside (see
    /// [`kinks`](Self::kinks)). Forward moves of `cursor` cost constant time a sample.
    #[inline(always)]
    pub fn piece(&self, cursor: &mut Cursor, start: f64, end: f64) -> Piece {
        // From one sample to the next, as at every kink of a recording: nothing to search.
        let next = self.passed_next(cursor, start);
        if self.interpolation == Interpolation::Linear
            && let Some(&[t0, t1]) = self.time_s.get(next..).and_then(|t| t.first_chunk())
            && let Some(&[v0, v1]) = self.values.get(next..).and_then(|v| v.first_chunk())
            && t0 == start
            && t1 == end
        {
            cursor.passed = next + 2;
            return Piece {
                from_s: start,
                value: v0,
                slope: (v1 - v0) / (end - start),
            };
        }
        self.piece_between(cursor, start, end)
    }

    #[inline(never)]
    fn piece_between(&self, cursor: &mut Cursor, start: f64, end: f64) -> Piece {
        let value = self.after(self.seek(cursor, start), start);
        if self.interpolation == Interpolation::Hold {
            return Piece {
                from_s: start,
                value,
                slope: 0.0,
            };
        }
        let last = self.after(self.seek(cursor, end), end);
        let slope = if end > start {
            (last - value) / (end - start)
        } else {
            0.0
        };
        Piece {
            from_s: start,
            value,
            slope,
        }
    }

    /// Where `start` would be the sample after, or at, the one last passed.
    #[inline(always)]
    fn passed_next(&self, cursor: &Cursor, start: f64) -> usize {
        let last = cursor.passed.saturating_sub(1);
        match self.time_s.get(last) {
            Some(t) if *t == start => last,
            _ => cursor.passed,
        }
    }

    #[inline(always)]
    fn seek(&self, cursor: &mut Cursor, t: f64) -> usize {
        let time = self.time_s;
        let mut passed = cursor.passed.min(time.len());
        if passed > 0 && time[passed - 1] > t {
            passed = time[..passed].partition_point(|&s| s <= t);
        } else {
            while passed < time.len() && time[passed] <= t {
                passed += 1;
            }
        }
        cursor.passed = passed;
        passed
    }

    /// Times at which the slope (or, with [`Interpolation::Hold`], the value) changes, ascending.
    ///
    /// Samples on the straight line that started at the last kink are skipped if the line meets
    /// them to a few units of round-off, so neither a constant nor a ramp makes an integrator
    /// stop.
    #[must_use]
    pub fn kinks(&self) -> Vec<f64> {
        let (t, v) = (self.time_s, self.values);
        let n = v.len();
        if self.interpolation == Interpolation::Hold {
            return (1..n).filter(|&k| v[k] != v[k - 1]).map(|k| t[k]).collect();
        }
        let mut kinks = Vec::new();
        let mut straight = Straight::from(t[0], v[0]);
        // Past the last sample it is flat again.
        let ends = (t[n - 1] + 1.0, v[n - 1]);
        let next = t[1..].iter().zip(&v[1..]).map(|(t, v)| (*t, *v));
        for ((&t, &v), ahead) in t.iter().zip(v).zip(next.chain([ends])) {
            if straight.bends_at((t, v), ahead) {
                kinks.push(t);
            }
        }
        kinks
    }

    /// A signal of nothing, in the place of one that is not at hand.
    pub(crate) const fn rest() -> Signal<'static> {
        Signal {
            name: "",
            time_s: &[0.0],
            values: &[0.0],
            interpolation: Interpolation::Linear,
        }
    }
}

/// The line through the last kink; flat before the first sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Straight {
    from_t: f64,
    from_v: f64,
    slope: f64,
}

impl Straight {
    pub(crate) fn from(t: f64, v: f64) -> Self {
        Self {
            from_t: t,
            from_v: v,
            slope: 0.0,
        }
    }

    /// Whether the line ends at a sample, given the next one; then it goes on from there.
    #[inline(always)]
    pub(crate) fn bends_at(&mut self, (t, v): (f64, f64), (due, ahead): (f64, f64)) -> bool {
        let off = (ahead - (self.from_v + self.slope * (due - self.from_t))).abs();
        let size = if ahead.abs() > self.from_v.abs() {
            ahead.abs()
        } else {
            self.from_v.abs()
        };
        let bends = off > 4.0 * f64::EPSILON * size || (self.slope == 0.0 && ahead != v);
        if bends {
            (self.from_t, self.from_v) = (t, v);
            self.slope = (ahead - v) / (due - t);
        }
        bends
    }
}

/// The kinks of all `signals` strictly within `start..end`, ascending, each once.
#[must_use]
pub fn merged_kinks(signals: &[&Signal<'_>], start: f64, end: f64) -> Vec<f64> {
    let mut all = Vec::new();
    for signal in signals {
        let kinks = signal.kinks();
        let inside = kinks.partition_point(|&t| t <= start)..kinks.partition_point(|&t| t < end);
        let inside = kinks.get(inside).unwrap_or_default();
        all = if all.is_empty() {
            inside.to_vec()
        } else {
            merged(&all, inside)
        };
    }
    all
}

/// Two ascending series as one, each value once.
fn merged(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut all = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while let (Some(&x), Some(&y)) = (a.get(i), b.get(j)) {
        all.push(if y < x { y } else { x });
        i += usize::from(x <= y);
        j += usize::from(y <= x);
    }
    all.extend_from_slice(&a[i..]);
    all.extend_from_slice(&b[j..]);
    all
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "test")]
    use super::*;

    fn line<'a>(t: &'a [f64], v: &'a [f64]) -> Signal<'a> {
        Signal::new("u", t, v, Interpolation::Linear).unwrap()
    }

    #[test]
    fn a_constant_has_no_kink_and_a_ramp_only_its_ends() {
        let t: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(line(&t, &[0.3; 100]).kinks().is_empty());
        assert!(line(&t, &[0.0; 100]).kinks().is_empty());
        let ramp: Vec<f64> = t.iter().map(|t| 0.25 * t).collect();
        assert_eq!(line(&t, &ramp).kinks(), [0.0, 99.0]);
    }

    #[test]
    fn a_trapezoid_has_four_kinks() {
        let t = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let v = [1.0, 1.0, 2.0, 3.0, 3.0, 2.0, 2.0];
        assert_eq!(line(&t, &v).kinks(), [1.0, 3.0, 4.0, 5.0]);
    }

    #[test]
    fn a_held_signal_kinks_where_it_jumps() {
        let (t, v) = ([0.0, 1.0, 2.0, 3.0], [1.0, 1.0, 2.0, 2.0]);
        let s = Signal::new("w", &t, &v, Interpolation::Hold).unwrap();
        assert_eq!(s.kinks(), [2.0]);
        assert_eq!(s.at(1.999), 1.0);
        assert_eq!(s.at(2.0), 2.0);
    }

    #[test]
    fn the_cursor_agrees_with_bisection_forwards_and_backwards() {
        let t: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.7 + 1.0).collect();
        let v: Vec<f64> = t.iter().map(|t| (t * 1.3).sin()).collect();
        let s = line(&t, &v);
        let mut cursor = Cursor::default();
        for &at in &[0.0, 1.0, 1.2, 3.0, 20.0, 5.0, 2.4, 35.3, 40.0] {
            let piece = s.piece(&mut cursor, at, at);
            assert_eq!(piece.value, s.at(at), "at {at}");
        }
    }

    #[test]
    fn kinks_of_two_signals_are_merged_within_the_span() {
        let t = [0.0, 1.0, 2.0, 3.0, 4.0];
        let a = line(&t, &[0.0, 1.0, 0.0, 0.0, 1.0]);
        let b = line(&t, &[0.0, 0.0, 0.0, 2.0, 2.0]);
        assert_eq!(merged_kinks(&[&a, &b], 0.0, 4.0), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn between_uneven_samples_stands_the_straight_line() {
        let (t, v) = ([0.0, 4.0, 4.5, 10.0], [1.0, 3.0, 2.0, 2.0]);
        let s = line(&t, &v);
        for (at, value) in [(1.0, 1.5), (3.0, 2.5), (4.25, 2.5), (7.0, 2.0), (-1.0, 1.0)] {
            assert_eq!(s.at(at), value, "at {at}");
            let piece = s.piece(&mut Cursor::default(), at, at + 0.25);
            assert_eq!((piece.from_s, piece.value), (at, value));
            assert!((piece.at(at + 0.25) - s.at(at + 0.25)).abs() < 1e-15);
        }
    }

    #[test]
    fn a_piece_of_no_length_is_its_value() {
        let (t, v) = ([0.0, 1.0, 2.0], [0.0, 3.0, 1.0]);
        for kind in [Interpolation::Linear, Interpolation::Hold] {
            let s = Signal::new("w", &t, &v, kind).unwrap();
            for at in [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0] {
                let piece = s.piece(&mut Cursor::default(), at, at);
                assert_eq!((piece.slope, piece.at(at)), (0.0, s.at(at)));
            }
        }
    }

    #[test]
    fn a_ramp_that_only_rounds_has_no_kink_inside_and_one_that_bends_a_little_has() {
        let t: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.1).collect();
        let mut ramp: Vec<f64> = t.iter().map(|t| 0.3 + 0.7 * t).collect();
        assert_eq!(line(&t, &ramp).kinks(), [t[0], t[99]]);
        ramp[50] += 1e-14;
        assert!(line(&t, &ramp).kinks().contains(&t[49]));
    }

    #[test]
    fn a_step_of_one_bit_from_rest_is_a_kink() {
        let t = [0.0, 1.0, 2.0, 3.0];
        let up = 1.0 + f64::EPSILON;
        assert_eq!(line(&t, &[1.0, 1.0, up, up]).kinks()[0], 1.0);
        assert_eq!(line(&t, &[1.0; 4]).kinks(), []);
    }

    #[test]
    fn one_sample_is_a_constant() {
        let s = line(&[5.0], &[0.3]);
        assert_eq!((s.at(0.0), s.at(5.0), s.at(9.0)), (0.3, 0.3, 0.3));
        assert!(s.kinks().is_empty());
        assert_eq!(
            (s.name(), s.time_s(), s.values()),
            ("u", &[5.0][..], &[0.3][..])
        );
    }
}
