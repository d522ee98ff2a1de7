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
        let edge = |k: usize| k * n / BINS;
        // Ranges of a tenth to a half of the samples: how much more than their share of samples lies there.
        for width in 1..=BINS / 2 {
            for first in 0..=BINS - width {
                let part = &of[edge(first)..edge(first + width)];
                let (Some(low), Some(high)) = (part.first(), part.last()) else {
                    continue;
                };
                let share = part.iter().map(|p| p.1).sum::<f64>() / total;
                let crowded = share - width as f64 / BINS as f64;
                if best.as_ref().is_none_or(|b| crowded > b.0 + 1e-9) {
                    let region = Region {
                        along: name.clone(),
                        range: (low.0, high.0),
                        share,
                        of_samples: width as f64 / BINS as f64,
                    };
                    best = Some((crowded, region));
                }
            }
        }
    }
    best.map(|b| b.1)
}
