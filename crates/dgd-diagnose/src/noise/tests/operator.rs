//! Claims about what a whitening does to rows, in full: the covariance that it is made for comes out as one.

use super::{NO_WANDER, full, layout, patchy, white};
use crate::layout::Section;
use crate::noise::apply::FADED;
use crate::noise::{Layout, Wander, Whitening};
use crate::relations::Rows;

type Matrix = Vec<Vec<f64>>;

const MEMORY: [[f64; 2]; 4] = [[0.3, 0.1], [-0.4, -0.3], [0.25, 0.15], [0.2, -0.2]];
const COUPLING: f64 = 0.8;
/// So short that rows forget within the made record.
const WANDER: Wander = Wander {
    friction_pa: 0.7,
    head_pa: 1.5,
    outlets_pa: 0.4,
    balance_m3_s: 1.1,
    blocks: 20.0,
    hidden_friction_pa: 0.5,
    hidden_head_pa: 0.9,
    hidden_blocks: 4.0,
};

/// A whitening whose rows have sizes near 1.
fn whitening(l: Layout, rows: &Rows, memory: [[f64; 2]; 4], wander: Wander) -> Whitening {
    let mut w = Whitening::of(l, rows, &white(l, 1), &vec![0.0; l.len()], NO_WANDER);
    for (row, weight) in w.weight.iter_mut().enumerate() {
        if *weight > 0.0 {
            *weight = 1.0 / size(row);
        }
    }
    (w.memory, w.coupling) = (memory, COUPLING);
    w.starts();
    w.filter(wander);
    w
}

fn size(row: usize) -> f64 {
    1.0 + 0.1 * (row % 7) as f64
}

/// What comes out of noise of a covariance, the head's rows holding their share of friction: `A·cov·Aᵀ`.
fn comes_out(w: &Whitening, cov: &dyn Fn(usize, usize) -> f64) -> Matrix {
    let n = w.layout.len();
    let columns: Matrix = (0..n)
        .map(|j| {
            let mut impulse = vec![0.0; n];
            impulse[j] = 1.0;
            if j < w.layout.blocks && w.valid[j] && !w.still[j] {
                impulse[w.layout.rows(Section::Head).start + j] = COUPLING;
            }
            w.apply(&impulse)
        })
        .collect();
    let half: Matrix = (0..n)
        .map(|row| {
            let sum = |j: usize| (0..n).map(|k| columns[k][row] * cov(k, j)).sum();
            (0..n).map(sum).collect()
        })
        .collect();
    (0..n)
        .map(|row| {
            let sum = |other: usize| (0..n).map(|k| half[row][k] * columns[k][other]).sum();
            (0..n).map(sum).collect()
        })
        .collect()
}

fn assert_white(w: &Whitening, out: &Matrix) {
    for (row, values) in out.iter().enumerate() {
        for (other, found) in values.iter().enumerate() {
            let one = f64::from(u8::from(row == other && w.valid[row]));
            assert!((found - one).abs() < 1e-12, "{row}, {other}: {found}");
        }
    }
}

/// Runs of one, two, three and more rows, at other places in each section; the line stands for a while.
fn runs(l: Layout) -> Rows {
    let mut rows = full(l);
    let gaps = |valid: &mut [bool], at: [usize; 4]| at.into_iter().for_each(|k| valid[k] = false);
    gaps(&mut rows.friction, [1, 4, 8, 12]);
    gaps(&mut rows.head, [2, 4, 7, 11]);
    gaps(&mut rows.outlets, [3, 5, 8, 12]);
    gaps(&mut rows.balance, [0, 2, 5, 9]);
    rows.still[15..19].fill(true);
    rows
}

/// Rows of an autoregression at rest, with innovations of one size: their covariance.
fn at_rest(w: &Whitening, rows: &Rows) -> impl Fn(usize, usize) -> f64 {
    let l = w.layout;
    // Each row's section and run; standing rows have no memory, and each is a run of its own.
    let mut run = vec![(4, 0); l.len()];
    for (k, range) in l.sections().into_iter().enumerate() {
        let mut number = 0;
        for row in range {
            let stands = k == 0 && rows.still[row];
            number += usize::from(!w.valid[row] || stands);
            run[row] = (k, number);
            number += usize::from(stands);
        }
    }
    let (valid, still) = (w.valid.clone(), rows.still.clone());
    move |i, j| {
        if i == j && (!valid[i] || i < l.blocks && still[i]) {
            // Whatever stands in a row that may not be used.
            return 1.0;
        }
        if run[i] != run[j] || !valid[i] || !valid[j] {
            return 0.0;
        }
        let [a, b] = MEMORY[run[i].0];
        let r = a / (1.0 - b);
        let mut now = 1.0 / ((1.0 - b * b) * (1.0 - r * r));
        let mut next = r * now;
        for _ in 0..i.abs_diff(j) {
            (now, next) = (next, a * next + b * now);
        }
        now
    }
}

#[test]
fn a_run_comes_out_white_and_of_one_size_from_its_first_row_on() {
    let l = layout(42);
    let rows = runs(l);
    let mut w = whitening(l, &rows, MEMORY, NO_WANDER);
    w.weight.iter_mut().for_each(|v| *v = v.min(1.0).ceil());
    w.filter(NO_WANDER);
    assert_white(&w, &comes_out(&w, &at_rest(&w, &rows)));
}

#[test]
fn what_never_changes_comes_out_white_through_memory_gaps_and_standing_mud() {
    let l = layout(42);
    let rows = runs(l);
    let forever = Wander {
        blocks: 1e300,
        hidden_blocks: 1e300,
        ..WANDER
    };
    let mut w = whitening(l, &rows, MEMORY, forever);
    w.weight.iter_mut().for_each(|v| *v = v.min(1.0).ceil());
    w.filter(forever);
    let section = |row: usize| l.sections().iter().position(|s| s.contains(&row)).unwrap();
    let white = at_rest(&w, &rows);
    let cov = |i: usize, j: usize| -> f64 {
        let k = section(i);
        if k != section(j) || !w.valid[i] || !w.valid[j] {
            return white(i, j);
        }
        let sd = forever.of(Section::ALL[k]);
        white(i, j) + sd[0].powi(2) + sd[1].powi(2)
    };
    assert_white(&w, &comes_out(&w, &cov));
}

#[test]
fn white_rows_that_wander_come_out_white_across_gaps() {
    let l = layout(42);
    let w = whitening(l, &runs(l), [[0.0; 2]; 4], WANDER);
    let sizes = [
        (WANDER.friction_pa, WANDER.hidden_friction_pa, 1.0),
        (WANDER.head_pa, WANDER.hidden_head_pa, 1.0),
        (WANDER.outlets_pa, 0.0, 1.0),
        (WANDER.balance_m3_s, 0.0, 3.0),
    ];
    let section = |row: usize| l.sections().iter().position(|s| s.contains(&row)).unwrap();
    let cov = |i: usize, j: usize| -> f64 {
        let own = if i == j { size(i) * size(i) } else { 0.0 };
        if section(i) != section(j) || !w.valid[i] || !w.valid[j] {
            return own;
        }
        let (slow, hidden, blocks) = sizes[section(i)];
        let apart = blocks * i.abs_diff(j) as f64;
        let slow = slow * slow * (-apart / WANDER.blocks).exp();
        let hidden = hidden * hidden * (-apart / WANDER.hidden_blocks).exp();
        own + slow + hidden
    };
    assert_white(&w, &comes_out(&w, &cov));
}

#[test]
fn a_wander_that_has_faded_is_none_unless_it_is_followed_to_the_end() {
    let l = layout(2400);
    let short = Wander {
        blocks: 5.0,
        hidden_blocks: 2.0,
        ..WANDER
    };
    let w = whitening(l, &patchy(l), MEMORY, short);
    let mut early = vec![0.0; l.len()];
    for range in l.sections() {
        early[range.start..range.start + 20].fill(1.0);
    }
    let (cut, whole) = (w.apply(&early), w.apply_whole(&early));
    for (k, range) in l.sections().into_iter().enumerate() {
        let mut faded = 0;
        for (cut, whole) in cut[range.clone()].iter().zip(&whole[range]) {
            if cut != whole {
                assert!(*cut == 0.0 && whole.abs() < 3.0 * FADED, "{k}: {whole}");
                faded += 1;
            }
        }
        assert!(faded > 100, "{k}: {faded}");
    }
}

#[test]
fn a_column_that_begins_late_or_ends_early_has_the_digits_of_a_sum_of_its_parts() {
    let l = layout(60);
    let w = whitening(l, &patchy(l), MEMORY, WANDER);
    let x = white(l, 3);
    for cut in [1, 2, 3, 17, 59, 60, 61, 119, 121, 180, 183] {
        let (mut first, mut second) = (x.clone(), x.clone());
        first[cut..].fill(0.0);
        second[..cut].fill(0.0);
        let (first, second) = (w.apply(&first), w.apply(&second));
        for ((a, b), c) in first.iter().zip(&second).zip(w.apply(&x)) {
            assert!((a + b - c).abs() < 1e-9 * c.abs().max(1.0), "{cut}");
        }
    }
}
