//! A pump speed that rests: an operator's set-point, or a reading that froze?

use crate::record::STANDING_PCT;
use std::ops::Range;

/// Shortest and longest rest that is looked at, s: below the first a reading repeats by chance, beyond the second
/// somebody holds it.
const REST_S: Range<f64> = 20.0..600.0;
/// Samples on either side of a rest that tell how often the reading repeats there.
const AROUND: usize = 300;
/// Chance of an honest rest, at a given sample, below which nothing is taken from it.
const CHANCE: f64 = 1e-6;

/// A speed without the rests that are too long for its jitter and too short for an operator's.
///
/// Under a share p of samples that repeat their predecessor, m equal ones begin at a given sample with chance p^(m-1). A
/// set-point under automatic control jitters with the level's noise, and one that has frozen while the pump
/// overshoots looks like gas or wear. A set-point that hardly ever moves repeats so often that it keeps all its rests.
pub(crate) fn without_seldom_rest(speed_pct: &[f64], step_s: f64) -> Vec<f64> {
    let n = speed_pct.len();
    let rests: Vec<Range<usize>> = runs(speed_pct)
        .filter(|r| r.len() as f64 * step_s >= REST_S.start)
        .collect();
    // Running counts of samples outside long rests, and of those that repeat their predecessor.
    let mut counted = vec![true; n];
    for rest in &rests {
        counted[rest.clone()].fill(false);
    }
    let (mut samples, mut repeats) = (vec![0.0; n + 1], vec![0.0; n + 1]);
    for i in 0..n {
        let counts = counted[i] && speed_pct[i] > STANDING_PCT;
        let repeat = counts && i > 0 && speed_pct[i - 1] == speed_pct[i];
        samples[i + 1] = samples[i] + f64::from(counts);
        repeats[i + 1] = repeats[i] + f64::from(repeat);
    }
    let mut out = speed_pct.to_vec();
    for rest in rests {
        let held = rest.len() as f64 * step_s > REST_S.end;
        if held || speed_pct[rest.start] <= STANDING_PCT {
            continue;
        }
        let (from, to) = (
            rest.start.saturating_sub(AROUND),
            (rest.end + AROUND).min(n),
        );
        let share = (repeats[to] - repeats[from] + 1.0) / (samples[to] - samples[from] + 1.0);
        if (rest.len() - 1) as f64 * share.ln() < CHANCE.ln() {
            out[rest].fill(f64::NAN);
        }
    }
    out
}

/// Runs of equal values.
fn runs(values: &[f64]) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    values.chunk_by(|a, b| a == b).map(move |run| {
        let range = start..start + run.len();
        start = range.end;
        range
    })
}

/// Quantisation step of a channel: the least by which its readings move, but for the rarest; 0 if they never do.
pub(crate) fn quantum(values: &[f64], step_s: f64) -> f64 {
    let read: Vec<f64> = dgd_recording::readings(values, step_s)
        .map(|i| values[i])
        .collect();
    let steps = read.windows(2).map(|w| (w[1] - w[0]).abs());
    dgd_recording::quantile(steps.filter(|s| *s > 1e-6), dgd_recording::Rank::Lower(10))
        .unwrap_or(0.0)
}

#[cfg(test)]
mod lengths;
#[cfg(test)]
mod tests {
    use super::{quantum, without_seldom_rest};

    /// A set-point that moves by a tenth now and then: at sample i if `moves(i)`.
    fn speed(moves: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut level = 600_i32;
        (0..4000_usize)
            .map(|i| {
                if moves(i) {
                    level += if level > 600 { -1 } else { 1 };
                }
                f64::from(level) / 10.0
            })
            .collect()
    }

    /// A number from 0 to 9 for each sample, as good as drawn.
    fn digit(i: usize) -> usize {
        (i.wrapping_mul(2_654_435_761) >> 16) % 10
    }

    fn blanked(values: &[f64]) -> usize {
        values.iter().filter(|v| v.is_nan()).count()
    }

    #[test]
    fn digits_are_told_of_a_speed_that_is_logged_now_and_then() {
        let values = speed(|i| digit(i) < 5);
        let seldom: Vec<f64> = (values.iter().enumerate())
            .map(|(i, v)| if i % 5 == 0 { *v } else { f64::NAN })
            .collect();
        for values in [values, seldom] {
            assert!((quantum(&values, 1.0) - 0.1).abs() < 1e-9);
        }
    }

    #[test]
    fn a_jittering_set_point_that_rests_for_minutes_is_blanked_there_alone() {
        let mut values = speed(|i| digit(i) < 5);
        let held = values[2000];
        values[2000..2200].fill(held);
        let kept = without_seldom_rest(&values, 1.0);
        assert!((2000..2200).all(|i| kept[i].is_nan()));
        assert!((200..206).contains(&blanked(&kept)), "{}", blanked(&kept));
    }

    #[test]
    fn a_set_point_that_hardly_moves_and_one_that_is_held_keep_their_rests() {
        // Once in three minutes.
        assert_eq!(
            blanked(&without_seldom_rest(&speed(|i| i % 180 == 0), 1.0)),
            0
        );
        // A quarter of an hour by hand.
        let mut values = speed(|i| digit(i) < 5);
        values[1000..1900].fill(58.0);
        assert_eq!(blanked(&without_seldom_rest(&values, 1.0)), 0);
    }

    #[test]
    fn a_standing_pump_rests_honestly() {
        let mut values = speed(|i| digit(i) < 5);
        values[1000..1300].fill(0.0);
        assert_eq!(blanked(&without_seldom_rest(&values, 1.0)), 0);
    }

    #[test]
    fn the_quantum_is_the_least_usual_step() {
        assert!((quantum(&speed(|i| digit(i) < 5), 1.0) - 0.1).abs() < 1e-9);
        assert_eq!(quantum(&[60.0; 50], 1.0), 0.0);
        assert_eq!(quantum(&[], 1.0), 0.0);
    }
}
