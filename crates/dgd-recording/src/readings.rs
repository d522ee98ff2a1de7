//! Which samples of a channel are readings of their own.

/// Longest time from reading to reading of a source that is logged slowly, s: beyond it a value that is held is an operator's.
pub const SLOWEST_S: f64 = 30.0;

/// The samples at which a channel was read: the finite ones, and of a slow source that is held in between those alone at which it
/// was read anew. `step_s` is the step of its even clock, s.
///
/// ```
/// use dgd_recording::readings;
///
/// let held = [4.0, 4.0, 4.0, 7.0, 7.0, 7.0, 5.0, 5.0, 5.0];
/// assert_eq!(readings(&held, 1.0).collect::<Vec<_>>(), [0, 3, 6]);
/// ```
pub fn readings(values: &[f64], step_s: f64) -> impl Iterator<Item = usize> {
    let held = held_for(values);
    let every = if held as f64 * step_s > SLOWEST_S {
        1
    } else {
        held
    };
    let mut last: Option<usize> = None;
    (0..values.len()).filter(move |&i| {
        let anew = |at: usize| i - at >= every || values[i] != values[at];
        let read = values[i].is_finite() && last.is_none_or(anew);
        if read {
            last = Some(i);
        }
        read
    })
}

/// For how many samples each reading of a slow source is held; 1 where it is not, as a set-point that now and then is another one.
///
/// ```
/// use dgd_recording::held_for;
///
/// assert_eq!(held_for(&[4.0, 4.0, 7.0, 7.0, 5.0, 5.0]), 2);
/// assert_eq!(held_for(&[4.0, 4.0, 4.0, 5.0, 5.0, 5.0, 5.0, 6.0]), 1);
/// ```
pub fn held_for(values: &[f64]) -> usize {
    let mut last: Option<(usize, f64)> = None;
    let mut apart = Vec::new();
    let mut finite = 0;
    for (i, v) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        finite += 1;
        if last.is_none_or(|(_, before)| before != *v) {
            apart.extend(last.map(|(at, _)| i - at));
            last = Some((i, *v));
        }
    }
    let middle = apart.len() / 2;
    if apart.is_empty() || *apart.select_nth_unstable(middle).1 < 2 {
        return 1;
    }
    let every = apart[middle];
    // Whatever its source tells is new as a rule, and new only when it tells.
    let times = apart.iter().filter(|k| k.is_multiple_of(every)).count();
    let regular = 5 * times >= 4 * apart.len();
    let told = 2 * apart.len() * every >= finite;
    if regular && told { every } else { 1 }
}

/// Fills what lies between two readings, `from` just before it and `to` just after it, with a straight line.
///
/// ```
/// let mut between = [f64::NAN; 3];
/// dgd_recording::draw_line(&mut between, 1.0, 5.0);
/// assert_eq!(between, [2.0, 3.0, 4.0]);
/// ```
pub fn draw_line(between: &mut [f64], from: f64, to: f64) {
    let span = (between.len() + 1) as f64;
    for (step, value) in between.iter_mut().enumerate() {
        *value = from + (to - from) * (step + 1) as f64 / span;
    }
}

#[cfg(test)]
mod tests {
    use super::{held_for, readings};

    fn swings(i: usize) -> f64 {
        (0.7 * i as f64).sin()
    }

    fn held(k: usize) -> Vec<f64> {
        (0..400).map(|i| swings(i - i % k)).collect()
    }

    #[test]
    fn a_slow_source_that_is_held_is_read_where_it_tells_something_new() {
        for k in [1, 2, 3, 10] {
            assert_eq!(held_for(&held(k)), k);
            let at: Vec<usize> = readings(&held(k), 1.0).collect();
            assert_eq!(at, (0..400).step_by(k).collect::<Vec<_>>());
        }
        // Beyond half a minute it is no slow source.
        for (step_s, apart) in [(3.0, 10), (3.1, 1), (0.1, 10)] {
            let at: Vec<usize> = readings(&held(10), step_s).collect();
            assert_eq!(at[1] - at[0], apart, "{step_s}");
        }
        // While it stands it is read as often, and one that is late begins anew.
        let mut stands = held(5);
        stands[200..300].fill(0.0);
        stands.remove(37);
        let at: Vec<usize> = readings(&stands, 1.0).collect();
        assert!(at.windows(2).all(|w| w[1] - w[0] <= 5), "{at:?}");
        assert_eq!(&at[7..10], [35, 39, 44]);
    }

    #[test]
    fn what_is_missing_is_not_read_and_what_repeats_for_another_reason_is() {
        let missing: Vec<f64> = (0..400)
            .map(|i| if i % 3 == 0 { swings(i) } else { f64::NAN })
            .collect();
        let at: Vec<usize> = readings(&missing, 1.0).collect();
        assert_eq!(at, (0..400).step_by(3).collect::<Vec<_>>());
        // A set-point, and digits coarser than the noise.
        let set: Vec<f64> = (0..400).map(|i| 60.0 + (i / 50) as f64).collect();
        let coarse: Vec<f64> = (0..400)
            .map(|i| (3.0 * (0.07 * i as f64).sin()).round())
            .collect();
        // Moved twice, as long after one another, and left there.
        let moved: Vec<f64> = (0..400)
            .map(|i| {
                if i < 20 {
                    1.0
                } else if i < 40 {
                    2.0
                } else {
                    3.0
                }
            })
            .collect();
        for values in [set, coarse, moved, vec![2.0; 400]] {
            assert_eq!(readings(&values, 1.0).count(), 400);
        }
        assert_eq!(readings(&[f64::NAN; 4], 1.0).count(), 0);
    }
}
