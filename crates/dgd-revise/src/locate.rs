//! Where the residual went: stretches of the record, and ranges of the quantities.

use crate::revision::Region;
use crate::stack::Data;

/// Stretches of the independent variable that hold 60 % of what the squares fell by, at most a fortieth of the record fine.
pub(crate) fn intervals(data: &Data, before: &[f64], after: &[f64]) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    for (w, window) in data.windows.iter().enumerate() {
        let n = window.time.len();
        let length = n.div_ceil(40).max(1);
        let mut fall = vec![0.0; n.div_ceil(length)];
        for (i, row) in data.rows.iter().enumerate().filter(|(_, r)| r.window == w) {
            fall[row.sample / length] += before[i].powi(2) - after[i].powi(2);
        }
        let total: f64 = fall.iter().filter(|f| **f > 0.0).sum();
        let mut order: Vec<usize> = (0..fall.len()).collect();
        order.sort_by(|a, b| fall[*b].total_cmp(&fall[*a]));
        let (mut sum, mut chosen) = (0.0, Vec::new());
        for k in order {
            if sum >= 0.6 * total || !(fall[k] > 0.0) {
                break;
            }
            sum += fall[k];
            chosen.push(k);
        }
        chosen.sort_unstable();
        let time = |i: usize| window.time[i.min(n - 1)];
        let mut last: Option<usize> = None;
        for k in chosen {
            let (from, to) = (time(k * length), time((k + 1) * length));
            match (last, found.last_mut()) {
                (Some(l), Some(open)) if l + 1 == k => open.1 = to,
                _ => found.push((from, to)),
            }
            last = Some(k);
        }
    }
    found
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

    use super::region;
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
