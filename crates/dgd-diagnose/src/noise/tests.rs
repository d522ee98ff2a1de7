//! Claims about the whitening.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod operator;
mod sizes;

use super::{Layout, Wander, Whitening, autoregression, high_pass};
use crate::layout::Section;
use crate::relations::Rows;
use crate::test_rig::normals;

const NO_WANDER: Wander = Wander {
    friction_pa: 0.0,
    head_pa: 0.0,
    outlets_pa: 0.0,
    balance_m3_s: 0.0,
    blocks: 300.0,
    hidden_friction_pa: 0.0,
    hidden_head_pa: 0.0,
    hidden_blocks: 30.0,
};
const WANDER: Wander = Wander {
    friction_pa: 2.5e3,
    head_pa: 4e3,
    outlets_pa: 3e3,
    balance_m3_s: 2e-4,
    hidden_friction_pa: 1e3,
    hidden_head_pa: 2e3,
    ..NO_WANDER
};
/// Size of the made noise by section.
const SIZES: [f64; 4] = [6e3, 7e3, 5e3, 8e-4];

fn layout(blocks: usize) -> Layout {
    Layout {
        blocks,
        outlets: blocks,
        balance: blocks / 3,
    }
}

fn sections(l: Layout) -> [std::ops::Range<usize>; 4] {
    [
        0..l.rows(Section::Head).start,
        l.rows(Section::Head),
        l.rows(Section::Outlets),
        l.rows(Section::Balance),
    ]
}

/// Everything valid and flowing.
fn full(l: Layout) -> Rows {
    Rows {
        friction: vec![true; l.blocks],
        still: vec![false; l.blocks],
        head: vec![true; l.blocks],
        outlets: vec![true; l.outlets],
        balance: vec![true; l.balance],
        stops: Vec::new(),
    }
}

/// Gaps, stands and their edges, not the same in any two sections.
fn patchy(l: Layout) -> Rows {
    let mut rows = full(l);
    for b in 0..l.blocks {
        rows.still[b] = b % 97 < 12;
        rows.friction[b] = b % 31 > 1;
        rows.head[b] = !rows.still[b] && b % 23 != 4;
        rows.outlets[b] = b % 41 > 2;
    }
    (0..l.balance).for_each(|k| rows.balance[k] = k % 19 != 3);
    rows
}

fn white(l: Layout, seed: u64) -> Vec<f64> {
    let mut out = normals(seed, l.len());
    for (range, size) in sections(l).into_iter().zip(SIZES) {
        out[range].iter_mut().for_each(|v| *v *= size);
    }
    out
}

/// An Ornstein-Uhlenbeck process of unit size.
fn wandering(seed: u64, n: usize, blocks: f64) -> Vec<f64> {
    let decay = (-1.0 / blocks).exp();
    let mut now = 0.0;
    normals(seed, n)
        .into_iter()
        .enumerate()
        .map(|(i, v)| {
            now = if i == 0 {
                v
            } else {
                decay * now + (1.0 - decay * decay).sqrt() * v
            };
            now
        })
        .collect()
}

fn moments(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let power = values.iter().map(|v| v * v).sum::<f64>() / n;
    let next: f64 = values.windows(2).map(|w| w[0] * w[1]).sum();
    (power, next / n / power)
}

#[test]
fn the_transpose_is_the_transpose_of_apply() {
    let l = layout(600);
    let mut residual = white(l, 1);
    // A memory and a coupling to be whitened, and values that are not there.
    for range in sections(l) {
        for i in range.start + 1..range.end {
            residual[i] += 0.3 * residual[i - 1];
        }
    }
    for b in 0..l.blocks {
        residual[l.rows(Section::Head).start + b] += 0.8 * residual[b];
    }
    residual[77] = f64::NAN;
    let unrest: Vec<f64> = normals(2, l.len()).iter().map(|v| 1e-5 * v.abs()).collect();
    let w = Whitening::of(l, &patchy(l), &residual, &unrest, WANDER);
    assert!(w.coupling > 0.1 && w.memory.iter().all(|m| m[0] != 0.0));
    for seed in 3..13 {
        // Every section has its say.
        let (x, y) = (white(l, seed), normals(seed + 100, l.len()));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(p, q)| p * q).sum::<f64>();
        let (white, back) = (w.apply(&x), w.transpose(&y));
        let size = (dot(&white, &white) * dot(&y, &y)).sqrt();
        let off = dot(&white, &y) - dot(&x, &back);
        assert!(off.abs() < 1e-9 * size, "seed {seed}: {off} of {size}");
    }
}

#[test]
fn white_noise_comes_out_with_unit_variance_in_every_section() {
    let l = layout(6000);
    let noise = white(l, 5);
    let w = Whitening::of(l, &full(l), &noise, &vec![0.0; l.len()], NO_WANDER);
    let out = w.apply(&noise);
    for (k, range) in sections(l).into_iter().enumerate() {
        let (power, next) = moments(&out[range]);
        assert!((power - 1.0).abs() < 0.1, "section {k}: power {power}");
        assert!(next.abs() < 0.05, "section {k}: lag-one correlation {next}");
    }
}

#[test]
fn wander_within_accuracy_is_filtered_to_white() {
    let l = layout(6000);
    let mut noise = white(l, 6);
    let sizes = [
        (WANDER.friction_pa, WANDER.hidden_friction_pa, 1.0),
        (WANDER.head_pa, WANDER.hidden_head_pa, 1.0),
        (WANDER.outlets_pa, 0.0, 1.0),
        (WANDER.balance_m3_s, 0.0, 3.0),
    ];
    let w = Whitening::of(l, &full(l), &noise, &vec![0.0; l.len()], WANDER);
    for (k, (range, (slow, hidden, blocks))) in sections(l).into_iter().zip(sizes).enumerate() {
        let n = range.len();
        let a = wandering(20 + k as u64, n, WANDER.blocks / blocks);
        let b = wandering(30 + k as u64, n, WANDER.hidden_blocks / blocks);
        for (i, row) in range.enumerate() {
            noise[row] += slow * a[i] + hidden * b[i];
        }
    }
    let out = w.apply(&noise);
    for (k, range) in sections(l).into_iter().enumerate() {
        let (power, next) = moments(&out[range]);
        assert!((power - 1.0).abs() < 0.1, "section {k}: power {power}");
        assert!(next.abs() < 0.05, "section {k}: lag-one correlation {next}");
    }
}

#[test]
fn rows_that_may_not_be_used_weigh_nothing() {
    let l = layout(300);
    let noise = white(l, 7);
    let mut rows = full(l);
    rows.friction[100..120].fill(false);
    let w = Whitening::of(l, &rows, &noise, &vec![0.0; l.len()], WANDER);
    let mut spoilt = noise.clone();
    spoilt[100..120].fill(1e9);
    assert_eq!(w.apply(&noise), w.apply(&spoilt));
    assert!(w.apply(&noise)[100..120].iter().all(|v| *v == 0.0));
}

#[test]
fn what_is_slower_than_the_window_is_taken_out_and_rows_that_are_not_there_say_nothing() {
    let n = 60;
    let mut values = normals(8, n);
    let mut valid = vec![true; n];
    valid[20..27].fill(false);
    values[20..27].fill(1e9);
    for half in [2, 5] {
        let out = high_pass(&values, &valid, half);
        for i in 0..n {
            let near = (0..n).filter(|j| valid[*j] && i.abs_diff(*j) <= half);
            let (sum, count) = near.fold((0.0, 0), |(s, c), j| (s + values[j], c + 1));
            let mean = if count > 0 {
                sum / f64::from(count)
            } else {
                0.0
            };
            let off = out[i] - (values[i] - mean);
            assert!(off.abs() < 1e-12 * values[i].abs().max(1.0), "{i}: {off}");
        }
    }
}

/// A series whose next value holds `a` of the last and `b` of the one before.
fn remembering(a: f64, b: f64, n: usize) -> Vec<f64> {
    let mut out = normals(9, n);
    for i in 2..n {
        out[i] += a * out[i - 1] + b * out[i - 2];
    }
    out
}

#[test]
fn a_short_memory_is_found_and_a_longer_one_is_cut() {
    let n = 20_000;
    let valid = vec![true; n];
    for (a, b) in [(0.27, 0.1), (-0.2, -0.3), (0.1, 0.0)] {
        let [p, q] = autoregression(&remembering(a, b, n), &valid, 100.0);
        assert!((p - a).abs() < 0.03 && (q - b).abs() < 0.03, "{p} {q}");
    }
    // Correlations of at most 0.35 and at least -0.6, and a second coefficient of -0.4 to 0.15.
    for (a, b, cut) in [
        (0.9, 0.0, [0.35 * 0.85, 0.15]),
        (-0.9, 0.0, [-0.6 * 0.85, 0.15]),
        (0.0, -0.8, [0.0, -0.4]),
    ] {
        let [p, q] = autoregression(&remembering(a, b, n), &valid, 100.0);
        assert!((p - cut[0]).abs() < 0.03 && q == cut[1], "{p} {q}");
    }
}

#[test]
fn a_memory_is_that_of_values_cut_at_three_deviations_beside_rows_that_are_there() {
    let n = 200;
    let mut values = remembering(0.2, 0.05, n);
    let mut valid = vec![true; n];
    let cut: Vec<f64> = values.iter().map(|v| v.clamp(-1.5, 1.5)).collect();
    assert_eq!(
        autoregression(&values, &valid, 0.5),
        autoregression(&cut, &valid, 1e3)
    );
    // The moments by hand, over the pairs of which both are there.
    valid[50..90].fill(false);
    valid[120] = false;
    values[50..90].fill(1e9);
    let moment = |lag: usize| {
        let pairs: Vec<f64> = (lag..n)
            .filter(|i| valid[*i] && valid[i - lag])
            .map(|i| values[i] * values[i - lag])
            .collect();
        pairs.iter().sum::<f64>() / pairs.len() as f64
    };
    let (p1, p2) = (moment(1) / moment(0), moment(2) / moment(0));
    assert!(p1 > 0.02 && p1 < 0.35, "{p1}");
    let k2 = (p2 - p1 * p1) / (1.0 - p1 * p1);
    let [a, b] = autoregression(&values, &valid, 1e3);
    assert!((a - p1 * (1.0 - k2)).abs() < 1e-12 && (b - k2).abs() < 1e-12);
}

#[test]
fn thirty_pairs_two_apart_tell_of_a_memory_and_fewer_or_silence_do_not() {
    let values = remembering(0.3, 0.1, 32);
    assert_ne!(autoregression(&values, &[true; 32], 1e3), [0.0; 2]);
    assert_eq!(autoregression(&values[..31], &[true; 31], 1e3), [0.0; 2]);
    assert_eq!(autoregression(&[0.0; 50], &[true; 50], 1e3), [0.0; 2]);
}
