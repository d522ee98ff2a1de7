//! The curves that lead to the linearisation, and what they leave over.

use super::columns::{friction_priors, head_priors};
use crate::cores::both;
use crate::layout::Layout;
use crate::numbers::spread;
use crate::relations::{Blocks, Rows};
use dgd_effects::{Curves, Scale, friction_terms, head_terms};
use nalgebra::{SMatrix, SVector};

/// Fits both curves robustly to the valid rows.
pub(super) fn robust_curves(rows: &Rows, b: &Blocks, scale: Scale) -> Curves {
    // These only lead to the linearisation: their priors need no means.
    let head_widths = head_priors(rows, b).map(|(mean, width)| mean.hypot(width));
    let friction = || {
        robust_over(
            &rows.friction,
            &b.drop,
            |k| friction_terms(b.flow[k], scale).map(|v| v * b.friction_factor[k]),
            &friction_priors(scale),
        )
    };
    let head = || {
        robust_over(
            &rows.head,
            &b.lift,
            |k| head_terms(b.speed[k], b.through[k], scale).map(|v| v * b.head_factor[k]),
            &head_widths,
        )
    };
    let (friction, head) = both(friction, head);
    Curves {
        scale,
        friction,
        head,
    }
}

/// The robust fit of `terms` to the rows of `y` that are valid.
fn robust_over<const P: usize>(
    valid: &[bool],
    y: &[f64],
    terms: impl Fn(usize) -> [f64; P],
    widths: &[f64; P],
) -> [f64; P] {
    let kept = (0..valid.len()).filter(|&k| valid[k] && y[k].is_finite());
    let (rows, values): (Vec<_>, Vec<_>) = kept.map(|k| (terms(k), y[k])).unzip();
    robust(&rows, &values, widths)
}

/// A robust straight least-squares fit; returns the coefficients.
fn robust<const P: usize>(rows: &[[f64; P]], y: &[f64], widths: &[f64; P]) -> [f64; P] {
    /// Rounds of reweighting, after which the weights hardly move. Set by hand.
    const ROUNDS: usize = 8;
    /// Least spread, Pa: below it rows are as good as exact. Set by hand.
    const LEAST_PA: f64 = 200.0;
    /// Spreads from which on a row counts less (Huber), and from which on it counts hardly at all. Set by hand.
    const HUBER: f64 = 2.0;
    const FAR: f64 = 8.0;
    let mut weight = vec![1.0; y.len()];
    let mut beta = [0.0; P];
    for _ in 0..ROUNDS {
        let mut normal = SMatrix::<f64, P, P>::zeros();
        let mut right = SVector::<f64, P>::zeros();
        for ((row, y), weight) in rows.iter().zip(y).zip(&weight) {
            for a in 0..P {
                let wa = weight * row[a];
                right[a] += wa * y;
                for b in 0..=a {
                    normal[(a, b)] += wa * row[b];
                }
            }
        }
        for a in 0..P {
            for b in a + 1..P {
                normal[(a, b)] = normal[(b, a)];
            }
            // A noise of 5 kPa stands against the prior; a relative 1e-10 keeps the matrix positive definite.
            normal[(a, a)] += (5e3 / widths[a]).powi(2) + 1e-10 * normal[(a, a)].max(1e-12);
        }
        let Some(factor) = normal.cholesky() else {
            break;
        };
        let solved = factor.solve(&right);
        beta.copy_from_slice(solved.as_slice());
        let off = |(row, y): (&[f64; P], &f64)| {
            y - row.iter().zip(&beta).map(|(v, b)| v * b).sum::<f64>()
        };
        let residual: Vec<f64> = rows.iter().zip(y).map(off).collect();
        let scale = spread(residual.iter().copied()).max(LEAST_PA);
        for (w, r) in weight.iter_mut().zip(&residual) {
            let u = r.abs() / scale;
            *w = if u < HUBER { 1.0 } else { HUBER / u };
            if u > FAR {
                *w *= FAR / u;
            }
        }
    }
    beta
}

/// Both curves at the blocks of one hypothesis: others share most of its blocks, and bumps are dear.
#[derive(Debug, Clone)]
pub(super) struct Evaluated {
    flow: Vec<f64>,
    friction_pa: Vec<f64>,
    speed: Vec<f64>,
    through: Vec<f64>,
    pub(super) head_pa: Vec<f64>,
}

impl Evaluated {
    pub(super) fn of(curves: &Curves, b: &Blocks, known: Option<&Self>) -> Self {
        let n = b.flow.len();
        let friction_pa = (0..n)
            .map(|k| match known {
                Some(v) if v.flow[k] == b.flow[k] => v.friction_pa[k],
                _ => curves.friction_pa(b.flow[k]),
            })
            .collect();
        let head_pa = (0..n)
            .map(|k| match known {
                Some(v) if v.speed[k] == b.speed[k] && v.through[k] == b.through[k] => v.head_pa[k],
                _ => curves.head_pa(b.speed[k], b.through[k]),
            })
            .collect();
        Self {
            flow: b.flow.clone(),
            friction_pa,
            speed: b.speed.clone(),
            through: b.through.clone(),
            head_pa,
        }
    }

    /// Stacked residuals of the curves under the same hypothesis.
    pub(super) fn residual(&self, layout: Layout, b: &Blocks) -> Vec<f64> {
        let mut out = Vec::with_capacity(layout.len());
        let n = layout.blocks;
        out.extend((0..n).map(|k| b.drop[k] - b.friction_factor[k] * self.friction_pa[k]));
        out.extend((0..n).map(|k| b.lift[k] - b.head_factor[k] * self.head_pa[k]));
        out.extend_from_slice(&b.difference);
        out.extend_from_slice(&b.imbalance);
        out
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Evaluated, robust, robust_curves};
    use crate::layout::Layout;
    use crate::relations::Rows;
    use crate::test_rig::{blocks, normals, parabolas};

    const ROWS: usize = 600;
    const TRUTH: [f64; 3] = [2e4, -3e5, 5e5];

    /// A parabola of a quantity from 0 to 1, with noise of so many Pa.
    fn parabola(noise_pa: f64) -> (Vec<[f64; 3]>, Vec<f64>) {
        let x = (0..ROWS).map(|k| k as f64 / ROWS as f64);
        let rows: Vec<[f64; 3]> = x.map(|x| [1.0, x, x * x]).collect();
        let noise = normals(5, ROWS);
        let y = (rows.iter().zip(&noise))
            .map(|(row, noise)| {
                row.iter().zip(TRUTH).map(|(v, c)| v * c).sum::<f64>() + noise_pa * noise
            })
            .collect();
        (rows, y)
    }

    fn assert_near(found: &[f64], expected: &[f64], within: f64) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < within, "{found} {expected}");
        }
    }

    #[test]
    fn a_curve_of_wide_priors_is_the_one_that_was_drawn() {
        let (rows, y) = parabola(0.0);
        assert_near(&robust(&rows, &y, &[1e9; 3]), &TRUTH, 1.0);
    }

    #[test]
    fn a_row_pulls_in_full_within_twice_the_spread_no_more_beyond_and_less_again_far_off() {
        let (rows, clean) = parabola(0.0);
        for by in [
            -350.0, 100.0, 300.0, 800.0, 1400.0, -1400.0, 2e3, 5e3, -5e4, 5e5,
        ] {
            let mut y = clean.clone();
            // A tenth of the rows, all at one side; the spread is held to be 200 Pa at the least.
            y.iter_mut().skip(3).step_by(10).for_each(|v| *v += by);
            let found = robust(&rows, &y, &[1e9; 3]);
            let size = f64::abs(by);
            let pull = size.min(400.0).min(400.0 * 1600.0 / size).copysign(by);
            // What all others hold against it.
            let expected = pull / if size < 400.0 { 10.0 } else { 9.0 };
            for x in [0.2, 0.5, 0.8] {
                let moved: f64 = (0..3)
                    .map(|a| (found[a] - TRUTH[a]) * f64::powi(x, i32::try_from(a).unwrap()))
                    .sum();
                let off = (moved - expected).abs();
                assert!(
                    off < 0.05 * expected.abs() + 1.0,
                    "{by}: {moved}, {expected}"
                );
            }
        }
    }

    #[test]
    fn a_prior_counts_as_a_row_of_5_kpa_and_what_nothing_tells_is_nought() {
        // One column of ones, of prior width w: n rows of noise 5 kPa against one of the prior.
        let y = vec![1e4; 16];
        for width in [5e3, 2.5e3, 1e3] {
            let found = robust(&[[1.0]; 16], &y, &[width]);
            let share = 16.0 / (16.0 + (5e3_f64 / width).powi(2));
            assert!((found[0] / 1e4 - share).abs() < 1e-6, "{width}: {found:?}");
        }
        let found = robust(&[[1.0, 0.0]; 16], &y, &[1e9, 1e9]);
        assert!(
            (found[0] - 1e4).abs() < 1e-3 && found[1] == 0.0,
            "{found:?}"
        );
    }

    #[test]
    fn columns_that_nothing_tells_apart_share_what_they_explain() {
        let y = vec![1e4; 16];
        for size in [1.0, 1e3] {
            let found = robust(&[[size, size]; 16], &y, &[1e9, 1e9]);
            let sum = size * (found[0] + found[1]);
            assert!((sum - 1e4).abs() < 1.0, "{size}: {found:?}");
        }
    }

    #[test]
    fn a_factor_that_is_known_changes_no_curve() {
        let truth = parabolas(4e5, 45e5, 5e5);
        let mut b = blocks(300);
        let rows = Rows {
            friction: vec![true; 300],
            still: vec![false; 300],
            head: vec![true; 300],
            outlets: Vec::new(),
            balance: Vec::new(),
            stops: Vec::new(),
        };
        for k in 0..300 {
            let share = k as f64 / 300.0;
            b.flow[k] = 0.02 + 0.02 * share;
            b.through[k] = 0.04 - 0.02 * share;
            b.speed[k] = 50.0 + 20.0 * (7.0 * share).sin().abs();
            b.friction_factor[k] = 1.0 + 0.5 * share;
            b.head_factor[k] = 1.0 - 0.3 * share;
            b.drop[k] = b.friction_factor[k] * truth.friction_pa(b.flow[k]);
            b.lift[k] = b.head_factor[k] * truth.head_pa(b.speed[k], b.through[k]);
        }
        let found = robust_curves(&rows, &b, truth.scale);
        for k in (0..300).step_by(7) {
            let (q, w, r) = (b.flow[k], b.speed[k], b.through[k]);
            let friction = truth.friction_pa(q);
            assert!((found.friction_pa(q) / friction - 1.0).abs() < 0.01);
            assert!((found.head_pa(w, r) / truth.head_pa(w, r) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn residuals_are_what_the_curves_leave_of_drop_and_lift_each_times_its_factor() {
        let curves = parabolas(4e5, 45e5, 5e5);
        let mut b = blocks(9);
        for k in 0..9 {
            b.flow[k] = 0.03 + 0.002 * k as f64;
            b.through[k] = 0.05 - 0.002 * k as f64;
            b.speed[k] = 60.0 + 3.0 * k as f64;
            b.friction_factor[k] = 1.0 + 0.1 * k as f64;
            b.head_factor[k] = 1.0 - 0.05 * k as f64;
            // Off by 1 kPa and so on, and by 2 kPa.
            b.drop[k] = b.friction_factor[k] * curves.friction_pa(b.flow[k]) + 1e3 * k as f64;
            b.lift[k] = b.head_factor[k] * curves.head_pa(b.speed[k], b.through[k]) - 2e3;
        }
        b.imbalance = vec![1e-3, -2e-3, 3e-3];
        let layout = Layout {
            blocks: 9,
            outlets: 0,
            balance: 3,
        };
        let found = Evaluated::of(&curves, &b, None).residual(layout, &b);
        let friction = (0..9).map(|k| 1e3 * f64::from(k));
        let head = (0..9).map(|_| -2e3);
        let expected: Vec<f64> = friction.chain(head).chain(b.imbalance.clone()).collect();
        assert_eq!(found.len(), expected.len());
        assert_near(&found, &expected, 1e-6);
    }

    #[test]
    fn curves_known_at_other_blocks_have_the_digits_of_new_ones() {
        let curves = parabolas(4e5, 45e5, 5e5);
        let known = Evaluated::of(&curves, &blocks(8), None);
        let mut b = blocks(8);
        (b.flow[1], b.through[2], b.speed[3]) = (0.05, 0.03, 80.0);
        (b.flow[4], b.through[4], b.speed[4]) = (0.02, 0.06, 40.0);
        let [new, found] = [None, Some(&known)].map(|v| Evaluated::of(&curves, &b, v));
        let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found.friction_pa), bits(&new.friction_pa));
        assert_eq!(bits(&found.head_pa), bits(&new.head_pa));
        assert!(new.friction_pa[1] != new.friction_pa[0] && new.head_pa[2] != new.head_pa[3]);
    }
}
