//! Where the residual went: stretches of the record, and ranges of the quantities.

use crate::revision::Region;
use crate::stack::Data;

/// Stretches of the independent variable that hold 60 % of what the squares fell by, at most a fortieth of the record fine.
pub(crate) fn intervals(data: &Data, before: &[f64], after: &[f64]) -> Vec<(f64, f64)> {
    let length = data.samples().div_ceil(40).max(1);
    // One pool over all windows: an event in one of them is no event of the others.
    let mut bins: Vec<Bin> = Vec::new();
    for (w, window) in data.windows.iter().enumerate() {
        let time = &window.time;
        // Samples of a relation come in any order.
        let mut order: Vec<usize> = (0..time.len()).collect();
        order.sort_by(|a, b| time[*a].total_cmp(&time[*b]));
        let mut bin_of = vec![0; time.len()];
        for (k, part) in order.chunks(length).enumerate() {
            part.iter().for_each(|&i| bin_of[i] = bins.len() + k);
        }
        let last = order.len().saturating_sub(1);
        bins.extend((0..order.len()).step_by(length).map(|k| Bin {
            window: w,
            from: time[order[k]],
            to: time[order[(k + length).min(last)]],
            fall: 0.0,
        }));
        for (i, row) in data.rows.iter().enumerate().filter(|(_, r)| r.window == w) {
            bins[bin_of[row.sample]].fall += before[i].powi(2) - after[i].powi(2);
        }
    }
    let total: f64 = bins.iter().map(|b| b.fall.max(0.0)).sum();
    let mut order: Vec<usize> = (0..bins.len()).collect();
    order.sort_by(|a, b| bins[*b].fall.total_cmp(&bins[*a].fall));
    let (mut sum, mut chosen) = (0.0, Vec::new());
    for k in order {
        if sum >= 0.6 * total || !(bins[k].fall > 0.0) {
            break;
        }
        sum += bins[k].fall;
        chosen.push(k);
    }
    chosen.sort_unstable();
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut last: Option<usize> = None;
    for k in chosen {
        let next = |l: usize| l + 1 == k && bins[l].window == bins[k].window;
        match (last, found.last_mut()) {
            (Some(l), Some(open)) if next(l) => open.1 = bins[k].to,
            _ => found.push((bins[k].from, bins[k].to)),
        }
        last = Some(k);
    }
    found
}

/// A stretch of a window.
struct Bin {
    window: usize,
    from: f64,
    to: f64,
    /// What the squares fell by.
    fall: f64,
}

/// The quantity in a range of which the fall of the squares is most crowded; `None` where nothing fell.
pub(crate) fn region(
    data: &Data,
    before: &[f64],
    after: &[f64],
    quantities: &[(String, Vec<Vec<f64>>)],
) -> Option<Region> {
    const BINS: usize = 10;
    let total: f64 = before.iter().zip(after).map(|(b, a)| b * b - a * a).sum();
    if !(total > 0.0) {
        return None;
    }
    let mut best: Option<(f64, Region)> = None;
    for (name, quantity) in quantities {
        let mut of: Vec<(f64, f64)> = data
            .rows
            .iter()
            .zip(before.iter().zip(after))
            .map(|(row, (b, a))| (quantity[row.window][row.sample], b * b - a * a))
            .collect();
        of.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = of.len();
        // What stands still tells no place.
        if !(of[n - 1].0 - of[0].0 > 1e-6 * of[n - 1].0.abs()) {
            continue;
        }
        // Tenths of the samples; a value that the quantity keeps lies wholly on one side of an edge, or between two of its own.
        let mut edges = vec![0, n];
        for at in (1..BINS).map(|k| of[k * n / BINS].0) {
            let below = of.partition_point(|p| p.0 < at);
            let upto = of.partition_point(|p| p.0 <= at);
            edges.push(below);
            if upto - below > 1 {
                edges.push(upto);
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let fall = |from: usize, to: usize| of[from..to].iter().map(|p| p.1).sum::<f64>();
        // Where squares rise instead, they make no share of the others larger.
        let total: f64 = edges.windows(2).map(|e| fall(e[0], e[1]).max(0.0)).sum();
        // Ranges of up to half of the samples, or of one value: how much more than their share of samples lies there.
        for width in 1..edges.len() {
            for first in 0..edges.len() - width {
                let part = &of[edges[first]..edges[first + width]];
                let (Some(low), Some(high)) = (part.first(), part.last()) else {
                    continue;
                };
                if part.len() > n / 2 + 1 && low.0 < high.0 {
                    continue;
                }
                let share = fall(edges[first], edges[first + width]) / total;
                let of_samples = part.len() as f64 / n as f64;
                let crowded = share - of_samples;
                if best.as_ref().is_none_or(|b| crowded > b.0 + 1e-9) {
                    let region = Region {
                        along: name.clone(),
                        range: (low.0, high.0),
                        share,
                        of_samples,
                    };
                    best = Some((crowded, region));
                }
            }
        }
    }
    best.map(|b| b.1)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{intervals, region};
    use crate::stack::Data;
    use dgd_assembly::Window;

    /// The region along a quantity of such values, where the squares fall by 1 at samples 70 to 99 alone.
    fn told(quantity: impl Fn(usize) -> f64) -> ((f64, f64), f64, f64) {
        let window = Window {
            time: (0..100).map(f64::from).collect(),
            readings: vec![vec![0.0; 100]],
            ..Window::default()
        };
        let data = Data::training(vec![window]);
        let before: Vec<f64> = (0..100).map(|i| f64::from(u8::from(i >= 70))).collect();
        let quantities = [("u".to_owned(), vec![(0..100).map(quantity).collect()])];
        let found = region(&data, &before, &[0.0; 100], &quantities).unwrap();
        (found.range, found.share, found.of_samples)
    }

    /// Intervals where the squares fall by `share` at each sample, by window and independent variable.
    fn stretches(windows: &[Vec<f64>], share: impl Fn(usize, f64) -> f64) -> Vec<(f64, f64)> {
        let window = |time: &Vec<f64>| Window {
            time: time.clone(),
            readings: vec![(0..time.len()).map(|i| i as f64).collect()],
            ..Window::default()
        };
        let data = Data::training(windows.iter().map(window).collect());
        let before: Vec<f64> = data
            .rows
            .iter()
            .map(|row| share(row.window, data.time(row)).sqrt())
            .collect();
        intervals(&data, &before, &vec![0.0; before.len()])
    }

    #[test]
    fn stretches_are_those_of_the_record_not_of_each_of_its_windows() {
        let windows = [0.0, 200.0].map(|from| (0..100).map(|i| from + f64::from(i)).collect());
        let event = |w: usize, t: f64| {
            if w == 1 && (230.0..240.0).contains(&t) {
                1.0
            } else {
                1e-6
            }
        };
        let found = stretches(&windows, event);
        assert!(
            !found.is_empty() && found.iter().all(|s| s.0 >= 230.0 && s.1 <= 240.0),
            "{found:?}"
        );
    }

    #[test]
    fn stretches_of_a_relation_ascend_whatever_the_order_of_its_samples() {
        let event = |_: usize, t: f64| f64::from(u8::from((20.0..40.0).contains(&t)));
        let ascending: Vec<f64> = (0..100).map(f64::from).collect();
        let mut descending = ascending.clone();
        descending.reverse();
        let mixed: Vec<f64> = (0..100).map(|i| f64::from(37 * i % 100)).collect();
        let found = stretches(&[ascending], event);
        assert_eq!(found, stretches(&[descending], event));
        assert_eq!(found, stretches(&[mixed], event));
        assert!(found.iter().all(|s| s.0 < s.1), "{found:?}");
    }

    #[test]
    fn a_region_is_where_more_of_the_squares_lie_than_of_the_samples() {
        assert_eq!(told(|i| i as f64), ((70.0, 99.0), 1.0, 0.3));
    }

    #[test]
    fn no_region_holds_more_than_all_of_the_squares_where_others_rise() {
        let window = Window {
            time: (0..100).map(f64::from).collect(),
            readings: vec![vec![0.0; 100]],
            ..Window::default()
        };
        let data = Data::training(vec![window]);
        let fell = |i: u32| f64::from(u8::from(i >= 70));
        let before: Vec<f64> = (0..100).map(fell).collect();
        let after: Vec<f64> = (0..100).map(|i| 0.3 * (1.0 - fell(i))).collect();
        let quantities = [("u".to_owned(), vec![(0..100).map(f64::from).collect()])];
        let found = region(&data, &before, &after, &quantities).unwrap();
        assert_eq!((found.range, found.share), ((70.0, 99.0), 1.0));
    }

    #[test]
    fn a_value_that_is_kept_is_wholly_within_a_region_or_without() {
        let stepped = |i: usize| if i < 64 { 1.0 } else { 2.0 };
        assert_eq!(told(stepped), ((2.0, 2.0), 1.0, 0.36));
        // Mostly at its lowest or its highest value, as an opening.
        assert_eq!(told(|i| f64::from(u8::from(i >= 95))).0, (1.0, 1.0));
        assert_eq!(told(|i| f64::from(u8::from(i < 95))).0, (0.0, 0.0));
        // The region would end within the samples of 2.
        let thrice = |i: usize| [1.0, 2.0, 3.0][usize::from(i >= 55) + usize::from(i >= 85)];
        let (range, share, of_samples) = told(thrice);
        assert_eq!((range, of_samples), ((2.0, 3.0), 0.45));
        assert!((share - 1.0).abs() < 1e-12);
    }
}
