//! Readings that a log repeats until the instrument gives the next.

/// Fewest values from which it can be told.
const FEWEST: usize = 12;
/// Part by which changes of the same size may differ.
const ALIKE: f64 = 0.05;

/// Samples over which a reading usually stays the same, if a log repeats it between updates; 1 if every sample is a reading of
/// its own, be it one of few values.
///
/// - `windows`: the reading by window and sample, NaN where there is none.
pub(crate) fn usual(windows: &[&[f64]]) -> usize {
    let (mut lengths, mut values, mut changes) = (Vec::new(), Vec::new(), Vec::new());
    for reading in windows {
        let runs = repeats(reading);
        lengths.extend(runs.iter().map(Vec::len));
        values.extend(runs.iter().map(|run| reading[run[0]]));
        let change = |pair: &[Vec<usize>]| (reading[pair[1][0]] - reading[pair[0][0]]).abs();
        changes.extend(runs.windows(2).map(change));
    }
    if lengths.len() < FEWEST {
        return 1;
    }
    lengths.sort_unstable();
    // Half of the values or more are repeated: a reading that stands at nought for a while is not held.
    let usual = lengths[(lengths.len() - 1) / 2];
    // A coarse reading repeats itself too, and changes by its step.
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mut gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let step = gaps.get(gaps.len() / 10).copied().unwrap_or(0.0);
    let stepped = |c: &&f64| (**c - step).abs() <= ALIKE * step;
    let coarse = 2 * changes.iter().filter(stepped).count() > changes.len();
    if coarse { 1 } else { usual }
}

/// Samples at which a reading is new: where it changes, and where it has stayed the same for as long as it usually does.
pub(crate) fn new(reading: &[f64], usual: usize) -> Vec<usize> {
    let of = |run: Vec<usize>| {
        let times = (run.len() / usual).max(1);
        (0..times).map(move |k| run[k * usual])
    };
    repeats(reading).into_iter().flat_map(of).collect()
}

/// Samples with a value, those that repeat the one before together.
fn repeats(reading: &[f64]) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = Vec::new();
    for (sample, value) in reading.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        match all.last_mut() {
            Some(run) if reading[run[0]].total_cmp(value).is_eq() => run.push(sample),
            _ => all.push(vec![sample]),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::Draws;

    fn jitter(draws: &mut Draws) -> f64 {
        draws.below(20_001) as f64 / 10_000.0 - 1.0
    }

    #[test]
    fn a_reading_that_a_log_repeats_is_new_where_it_changes() {
        let mut draws = Draws::new(1, 0);
        let mut last = 0.0;
        let held: Vec<f64> = (0..100)
            .map(|i| {
                if i % 5 == 2 {
                    last = jitter(&mut draws);
                }
                last
            })
            .collect();
        assert_eq!(usual(&[&held]), 5);
        let mut expected: Vec<usize> = (0..20).map(|k| 5 * k + 2).collect();
        expected.insert(0, 0);
        assert_eq!(new(&held, 5), expected);
        // What is kept for three updates was read thrice.
        assert_eq!(new(&[7.0; 16], 5), [0, 5, 10]);
    }

    #[test]
    fn a_coarse_reading_and_one_that_stands_at_nought_are_new_in_every_sample() {
        let mut draws = Draws::new(2, 0);
        let coarse: Vec<f64> = (0..400)
            .map(|i| (0.02 * f64::from(i) + 0.1 * jitter(&mut draws)).round())
            .collect();
        assert_eq!(usual(&[&coarse]), 1);
        let nought: Vec<f64> = (0..400)
            .map(|i| if i < 300 { 0.0 } else { jitter(&mut draws) })
            .collect();
        assert_eq!(usual(&[&nought]), 1);
        assert_eq!(new(&nought, 1).len(), 400);
    }
}
