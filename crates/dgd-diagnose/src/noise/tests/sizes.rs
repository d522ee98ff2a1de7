//! Claims about the sizes, the memory and the coupling that are read from residuals.

use super::{NO_WANDER, full, layout, patchy, remembering, white};
use crate::layout::Section;
use crate::noise::{Layout, Whitening, autoregression, high_pass};
use crate::numbers::spread;
use crate::relations::Rows;
use crate::test_rig::normals;

fn of(l: Layout, rows: &Rows, residual: &[f64], unrest: &[f64]) -> Whitening {
    Whitening::of(l, rows, residual, unrest, NO_WANDER)
}

/// Head rows that hold 0.8 of friction's.
fn kindred(l: Layout, seed: u64) -> Vec<f64> {
    let mut residual = white(l, seed);
    for b in 0..l.blocks {
        residual[l.rows(Section::Head).start + b] += 0.8 * residual[b];
    }
    residual
}

#[test]
fn coupling_is_the_slope_where_both_flow_and_neither_is_beyond_four_deviations_of_calm_rows() {
    let l = layout(900);
    let rows = patchy(l);
    let n = l.blocks;
    let mut residual = kindred(l, 4);
    let mut unrest = vec![0.0; l.len()];
    // Most rows are restless, and much larger.
    for b in (0..n).filter(|b| b % 5 > 1) {
        residual[b] *= 7.0;
        residual[n + b] *= 5.0;
        (unrest[b], unrest[n + b]) = (1500.0, 4e3);
    }
    let flowing: Vec<bool> = (0..n).map(|b| rows.friction[b] && !rows.still[b]).collect();
    let friction = high_pass(&residual[..n], &flowing, 15);
    let head = high_pass(&residual[n..2 * n], &rows.head, 15);
    let core = |values: &[f64], valid: &[bool]| {
        let calm = (0..n).filter(|b| valid[*b] && b % 5 <= 1);
        4.0 * spread(calm.map(|b| values[b]))
    };
    let (most_friction, most_head) = (core(&friction, &flowing), core(&head, &rows.head));
    let pairs: Vec<(f64, f64)> = (0..n)
        .filter(|b| flowing[*b] && rows.head[*b])
        .map(|b| (friction[b], head[b]))
        .filter(|(f, h)| f.abs() < most_friction && h.abs() < most_head)
        .collect();
    assert!(pairs.len() > 300 && pairs.len() < 700, "{}", pairs.len());
    let slope = pairs.iter().map(|(f, h)| f * h).sum::<f64>()
        / pairs.iter().map(|(f, _)| f * f).sum::<f64>();
    let found = of(l, &rows, &residual, &unrest).coupling;
    assert!(slope > 0.1 && (found - slope).abs() < 1e-12, "{found}");
}

#[test]
fn rows_of_zeros_are_not_coupled() {
    let l = layout(100);
    let zero = vec![0.0; l.len()];
    assert_eq!(of(l, &full(l), &zero, &zero).coupling, 0.0);
}

#[test]
fn a_head_row_weighs_what_it_holds_beside_friction() {
    let l = layout(6000);
    let w = of(l, &full(l), &kindred(l, 5), &vec![0.0; l.len()]);
    let size = 1.0 / w.weight[l.rows(Section::Head).start];
    assert!((size / 7e3 - 1.0).abs() < 0.05, "{size}");
}

#[test]
fn a_section_has_the_memory_and_the_size_of_its_calm_rows() {
    let n = 400;
    let l = layout(n);
    let mut w = of(l, &full(l), &white(l, 6), &vec![0.0; l.len()]);
    let scale = 2.0;
    let mut values: Vec<f64> = remembering(0.2, 0.1, n).iter().map(|v| v * scale).collect();
    // Half a deviation and more is restless, less is not.
    let kinds = [0.0, 0.3, 0.45, 0.5, 0.7, 3.0];
    let unrest: Vec<f64> = (0..n).map(|i| kinds[i / 10 % 6] * scale).collect();
    let valid: Vec<bool> = (0..n).map(|i| i % 37 != 5).collect();
    for i in 0..n {
        values[i] *= 1.0 + i as f64 / 100.0 + 3.0 * unrest[i];
        if !valid[i] {
            values[i] = 1e6;
        }
    }
    let calm: Vec<bool> = (0..n).map(|i| valid[i] && unrest[i] < 1.0).collect();
    let [a, b] = autoregression(&values, &calm, scale);
    assert!(a != 0.0 && b != 0.0);
    let triples = calm.windows(3).zip(values.windows(3));
    let left = triples
        .filter(|(calm, _)| calm.iter().all(|c| *c))
        .map(|(_, v)| v[2] - a * v[1] - b * v[0]);
    let size = spread(left);
    for section in [Section::Friction, Section::Head, Section::Outlets] {
        let range = l.rows(section);
        w.weight.fill(0.0);
        w.weigh(section, &values, &valid, (scale, 0.1), &unrest);
        assert_eq!(w.memory[section as usize], [a, b]);
        for i in 0..n {
            let expected = if valid[i] {
                1.0 / size.hypot(unrest[i])
            } else {
                0.0
            };
            let found = w.weight[range.start + i];
            assert!(
                (found - expected).abs() < 1e-12,
                "{section:?}, {i}: {found}"
            );
        }
        let elsewhere = w.weight.iter().filter(|v| **v > 0.0).count();
        assert_eq!(elsewhere, valid.iter().filter(|v| **v).count());
    }
}

#[test]
fn standing_rows_have_a_size_of_their_own_of_at_least_800_pa_and_at_most_that_of_flow() {
    let l = layout(3000);
    let mut rows = full(l);
    (0..l.blocks).for_each(|b| rows.still[b] = b % 150 < 50);
    for (size, expected) in [(2e3, 2e3), (10.0, 800.0), (5e4, 6e3)] {
        let mut residual = white(l, 7);
        for (b, draw) in normals(8, l.blocks).into_iter().enumerate() {
            if rows.still[b] {
                residual[b] = size * draw;
            }
        }
        let w = of(l, &rows, &residual, &vec![0.0; l.len()]);
        let found = 1.0 / w.weight[0];
        assert!((found / expected - 1.0).abs() < 0.1, "{found}");
        let flowing = 1.0 / w.weight[100];
        assert!((flowing / 6e3 - 1.0).abs() < 0.1, "{flowing}");
    }
}

#[test]
fn what_every_row_of_the_balance_has_is_no_timing_of_some() {
    let l = layout(900);
    let rows = full(l);
    let balance = l.rows(Section::Balance);
    let mut residual = white(l, 6);
    residual[balance.clone()]
        .iter_mut()
        .for_each(|v| *v *= 1e-3);
    let noise = |every: f64| {
        let mut unrest = vec![0.0; l.len()];
        unrest[balance.clone()].fill(every);
        of(l, &rows, &residual, &unrest).noise(balance.clone())
    };
    let own = noise(0.0);
    // Beside the noise that the rows show, however much it is.
    assert!((noise(1e-3) / own.hypot(1e-3) - 1.0).abs() < 0.1);
}
