//! The cost of a pair of exponents without touching the rows again.
//!
//! Every sum in the normal equations is a smooth function of the exponents, for example
//! `Σ w^n0 q^n2`. One pass over the rows takes these sums at Chebyshev nodes over the allowed
//! exponents; between nodes they are interpolated, to rounding, so that a search costs the same
//! for a minute and for a month of data. Speed and flow are quantised by their instruments, so
//! powers are taken per distinct value, not per row.

use crate::pass::Pass;
use crate::{PumpError, Samples};
use std::ops::RangeInclusive;

/// Nodes per exponent. Interpolating `x^n = exp(-n t)` over `n` from `lo` to `lo + 2h` with K nodes
/// leaves about `exp(-lo t - K²/(2 h t))`: 1e-13 for values down to 1 % of the largest, squared.
pub(crate) const NODES: usize = 28;

/// Samples of which the distinct values are looked up before their sums are taken: few enough that both stay in the cache.
const PART: usize = 1 << 15;

/// Least squared sine between columns that counts as telling them apart.
const PIVOT: f64 = 1e-10;

/// Sums of the normal equations of `[w^n0, -w q, -q^n2 | H]` over a range of exponents.
pub(crate) struct Table {
    n0: Nodes,
    n2: Nodes,
    n: u64,
    sums: Sums,
}

/// `a` stands for the scaled `w^n0`, `b` for `w q`, `d` for `q^n2`, `y` for the head.
struct Sums {
    aa: [f64; NODES],
    ab: [f64; NODES],
    ay: [f64; NODES],
    dd: [f64; NODES],
    bd: [f64; NODES],
    dy: [f64; NODES],
    /// By node of n0, then of n2.
    ad: Vec<[f64; NODES]>,
    rows: u64,
    bb: f64,
    by: f64,
    yy: f64,
}

/// Cosines between columns `w^n0`, `-w q`, `-q^n2` (first with second, first with third, second with
/// third), and between each and the head.
struct Normal {
    inner: [f64; 3],
    y: [f64; 3],
}

/// The least-squares answer for one pair of exponents.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer {
    pub(crate) mse: f64,
    /// The c1 and the c2 term over the head, in root mean square; 0 where held there.
    pub(crate) share1: f64,
    pub(crate) share2: f64,
}

impl Table {
    /// One pass over the kept rows.
    pub(crate) fn new(
        samples: &Samples,
        n0: &RangeInclusive<f64>,
        n2: &RangeInclusive<f64>,
    ) -> Result<Self, PumpError> {
        // Powers are taken of values scaled by the largest, so they lie in 0..1.
        let mut scale = (0.0_f64, 0.0_f64);
        for (w, q, _) in samples.rows() {
            scale = (scale.0.max(w), scale.1.max(q));
        }
        for (name, found) in [("speed_pct", scale.0), ("flow_m3_s", scale.1)] {
            if found == 0.0 {
                return Err(PumpError::Domain {
                    name,
                    found,
                    expected: "kept samples above 0",
                });
            }
        }
        let (n0, n2) = (Nodes::over(n0), Nodes::over(n2));
        let mut sums = Sums::zero();
        let mut pass = Pass::new();
        let mut rest = *samples;
        while !rest.keep.is_empty() {
            let part = rest.to(rest.keep.len().min(PART));
            let taken = pass.take(&part, scale, (&n0, &n2));
            if taken < part.keep.len() {
                sums.fold(&pass);
                pass = Pass::new();
            }
            rest = rest.from(taken);
        }
        sums.fold(&pass);
        let n = sums.rows;
        Ok(Self { n0, n2, n, sums })
    }

    /// Mean of the squared heads: the error of no model at all.
    pub(crate) fn mean_square_head(&self) -> f64 {
        self.sums.yy / count(self.n)
    }

    /// The least-squares answer at exponents inside the ranges; `None` if it cannot be solved.
    pub(crate) fn solve(&self, n0: f64, n2: f64) -> Option<Answer> {
        let normal = self.normal(n0, n2);
        let [ab, ad, bd] = normal.inner;
        let y = normal.y;
        // Cholesky of a matrix with unit diagonal.
        let p2 = 1.0 - ab * ab;
        let r22 = p2.sqrt();
        let r23 = (bd - ab * ad) / r22;
        let p3 = 1.0 - ad * ad - r23 * r23;
        let r33 = p3.sqrt();
        let z1 = y[0];
        let z2 = (y[1] - ab * z1) / r22;
        let z3 = (y[2] - ad * z1 - r23 * z2) / r33;
        let share2 = z3 / r33;
        let share1 = (z2 - r23 * share2) / r22;
        // Pivots near rounding mean that the columns cannot be told apart.
        let sound = p2 > PIVOT && p3 > PIVOT;
        self.answer(1.0 - z1 * z1 - z2 * z2 - z3 * z3, share1, share2)
            .filter(|_| sound)
    }

    /// The answer under `c1, c2 >= 0`: the best of the subsets of terms whose estimates comply.
    pub(crate) fn solve_bounded(&self, n0: f64, n2: f64) -> Option<Answer> {
        let free = self.solve(n0, n2);
        if free.is_some_and(|free| free.share1 > 0.0 && free.share2 > 0.0) {
            return free;
        }
        let normal = self.normal(n0, n2);
        let y = normal.y;
        let with = |inner: f64, other: f64| {
            let pivot = 1.0 - inner * inner;
            let z = (other - inner * y[0]) / pivot.sqrt();
            (1.0 - y[0] * y[0] - z * z, z / pivot.sqrt(), pivot > PIVOT)
        };
        let (rest1, share1, sound1) = with(normal.inner[0], y[1]);
        let (rest2, share2, sound2) = with(normal.inner[1], y[2]);
        let mut best = self.answer(1.0 - y[0] * y[0], 0.0, 0.0)?;
        let candidates = [
            (sound1 && share1 > 0.0, rest1, share1, 0.0),
            (sound2 && share2 > 0.0, rest2, 0.0, share2),
        ];
        for (legal, rest, share1, share2) in candidates {
            if let Some(answer) = self.answer(rest, share1, share2)
                && legal
                && answer.mse < best.mse
            {
                best = answer;
            }
        }
        Some(best)
    }

    fn answer(&self, rest: f64, share1: f64, share2: f64) -> Option<Answer> {
        (rest.is_finite() && self.n > 3).then(|| Answer {
            mse: rest.max(0.0) * self.sums.yy / count(self.n - 3),
            share1,
            share2,
        })
    }

    /// Normal equations with columns and head scaled to unit length.
    fn normal(&self, n0: f64, n2: f64) -> Normal {
        let (l0, l2) = (self.n0.weights(n0), self.n2.weights(n2));
        let s = &self.sums;
        let ad: f64 = l0.iter().zip(&s.ad).map(|(l, row)| l * dot(row, &l2)).sum();
        let size = [dot(&s.aa, &l0), s.bb, dot(&s.dd, &l2), s.yy].map(f64::sqrt);
        // Signs of the model: the second and third column are negative.
        let inner = [
            -dot(&s.ab, &l0) / (size[0] * size[1]),
            -ad / (size[0] * size[2]),
            dot(&s.bd, &l2) / (size[1] * size[2]),
        ];
        let y = [dot(&s.ay, &l0), -s.by, -dot(&s.dy, &l2)];
        Normal {
            inner,
            y: [0, 1, 2].map(|j| y[j] / (size[j] * size[3])),
        }
    }

    /// Kept rows.
    pub(crate) fn rows(&self) -> u64 {
        self.n
    }
}

#[expect(clippy::cast_precision_loss, reason = "row counts stay far below 2^53")]
fn count(n: u64) -> f64 {
    n as f64
}

impl Sums {
    fn zero() -> Self {
        let none = [0.0; NODES];
        Self {
            aa: none,
            ab: none,
            ay: none,
            dd: none,
            bd: none,
            dy: none,
            ad: vec![none; NODES],
            rows: 0,
            bb: 0.0,
            by: 0.0,
            yy: 0.0,
        }
    }

    /// Adds the sums per distinct value to the sums per node.
    fn fold(&mut self, pass: &Pass) {
        let groups = &pass.groups;
        let speeds = pass.speeds.values.iter().zip(&pass.speeds.powers);
        for ((w, a), at) in speeds.zip(&groups.at_speed) {
            for (k, a) in a.iter().enumerate() {
                self.aa[k] += at.rows * a * a;
                self.ab[k] += a * w * at.other;
                self.ay[k] += a * at.head;
            }
        }
        let flows = pass.flows.values.iter().zip(&pass.flows.powers);
        for (((q, d), at), v) in flows.zip(&groups.at_flow).zip(&pass.v) {
            for (k, d) in d.iter().enumerate() {
                self.dd[k] += at.rows * d * d;
                self.bd[k] += d * q * at.other;
                self.dy[k] += d * at.head;
            }
            for (ad, v) in self.ad.iter_mut().zip(v) {
                for (ad, d) in ad.iter_mut().zip(d) {
                    *ad += v * d;
                }
            }
        }
        self.rows += groups.rows;
        self.bb += groups.bb;
        self.by += groups.by;
        self.yy += groups.yy;
    }
}

/// Chebyshev nodes of an exponent, and interpolation between them.
pub(crate) struct Nodes {
    at: [f64; NODES],
    /// Barycentric weights.
    bary: [f64; NODES],
}

impl Nodes {
    pub(crate) fn over(range: &RangeInclusive<f64>) -> Self {
        let (middle, half) = (
            0.5 * (range.start() + range.end()),
            0.5 * (range.end() - range.start()),
        );
        let mut nodes = Self {
            at: [0.0; NODES],
            bary: [0.0; NODES],
        };
        #[expect(clippy::cast_precision_loss, reason = "28 nodes")]
        for k in 0..NODES {
            let angle = std::f64::consts::PI * (2 * k + 1) as f64 / (2 * NODES) as f64;
            nodes.at[k] = middle + half * angle.cos();
            nodes.bary[k] = if k % 2 == 0 {
                angle.sin()
            } else {
                -angle.sin()
            };
        }
        nodes
    }

    /// `x^n` at every node, for x in 0..1.
    pub(crate) fn powers(&self, x: f64) -> [f64; NODES] {
        if x == 0.0 {
            return [0.0; NODES];
        }
        let log = x.ln();
        self.at.map(|n| (n * log).exp())
    }

    /// Weights of the nodes in the interpolant at n (Berrut and Trefethen 2004, Eq. 4.2).
    fn weights(&self, n: f64) -> [f64; NODES] {
        let mut weights = [0.0; NODES];
        let mut sum = 0.0;
        for k in 0..NODES {
            let distance = n - self.at[k];
            if distance == 0.0 {
                weights = [0.0; NODES];
                weights[k] = 1.0;
                return weights;
            }
            weights[k] = self.bary[k] / distance;
            sum += weights[k];
        }
        weights.map(|w| w / sum)
    }
}

fn dot(a: &[f64; NODES], b: &[f64; NODES]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit_unconstrained;

    #[test]
    fn the_table_agrees_with_qr_between_its_nodes() {
        // Speed down to 1 % and flow to 0.1 % of the largest: harder than a rig.
        let rows = 4000_u32;
        let speed: Vec<f64> = (0..rows).map(|i| 1.0 + f64::from(i * 37 % 100)).collect();
        let flow: Vec<f64> = (0..rows).map(|i| 1e-4 * f64::from(i * 71 % 997)).collect();
        let head: Vec<f64> = (0..rows as usize)
            .map(|i| 0.05 * speed[i].powf(1.9) - 3.0 * speed[i] * flow[i] + (i % 13) as f64)
            .collect();
        let samples = Samples {
            speed_pct: &speed,
            flow_m3_s: &flow,
            head_m: &head,
            keep: &vec![true; rows as usize],
        };
        let table = Table::new(&samples, &(0.5..=4.0), &(1.0..=4.0)).expect("rows flow");
        for (n0, n2) in [(0.5, 1.1), (1.9, 1.6), (2.0, 2.0), (3.3, 3.9), (4.0, 4.0)] {
            let exact = fit_unconstrained(&samples, n0, n2).expect("rich data");
            let found = table.solve(n0, n2).expect("rich data");
            assert!(
                (found.mse / exact.mse_m2 - 1.0).abs() < 1e-9,
                "{n0}, {n2}: {} against {}",
                found.mse,
                exact.mse_m2
            );
            assert_eq!(found.share1 > 0.0, exact.curve.c1 > 0.0);
            assert_eq!(found.share2 > 0.0, exact.curve.c2 > 0.0);
        }
    }

    #[test]
    fn folding_often_changes_nothing_but_rounding() {
        // More distinct flows than one pass holds.
        let rows = 40_000_u32;
        let speed: Vec<f64> = (0..rows).map(|i| 30.0 + f64::from(i % 50)).collect();
        let flow: Vec<f64> = (0..rows)
            .map(|i| 1e-6 * f64::from(i * 7919 % 50_021))
            .collect();
        let head: Vec<f64> = (0..rows as usize)
            .map(|i| 0.05 * speed[i].powi(2) - 2e4 * flow[i].powi(2) + (i % 7) as f64)
            .collect();
        let samples = Samples {
            speed_pct: &speed,
            flow_m3_s: &flow,
            head_m: &head,
            keep: &vec![true; rows as usize],
        };
        let table = Table::new(&samples, &(0.5..=4.0), &(1.0..=4.0)).expect("rows flow");
        let exact = fit_unconstrained(&samples, 1.7, 2.2).expect("rich data");
        let found = table.solve(1.7, 2.2).expect("rich data");
        assert!((found.mse / exact.mse_m2 - 1.0).abs() < 1e-9);
        assert_eq!(table.rows(), 40_000);
    }

    struct Rows {
        speed: Vec<f64>,
        flow: Vec<f64>,
        head: Vec<f64>,
        keep: Vec<bool>,
    }

    impl Rows {
        /// `rows` samples of a speed, a flow of it and chance, and a head of both.
        fn new(flow: impl Fn(f64, f64) -> f64, head: impl Fn(f64, f64) -> f64) -> Self {
            let rows = 600_u32;
            let chance = |i: u32, k: u32| f64::from((i * k) % 601) / 601.0;
            let speed: Vec<f64> = (0..rows).map(|i| 20.0 + 70.0 * chance(i, 37)).collect();
            let at = |i: usize| flow(speed[i], chance(u32::try_from(i).unwrap_or(0), 229));
            let flow: Vec<f64> = (0..speed.len()).map(at).collect();
            let pairs = speed.iter().zip(&flow).enumerate();
            let head = pairs
                .map(|(i, (w, q))| head(*w, *q) + (i % 7) as f64)
                .collect();
            let keep = vec![true; rows as usize];
            Self {
                speed,
                flow,
                head,
                keep,
            }
        }

        fn samples(&self) -> Samples<'_> {
            Samples {
                speed_pct: &self.speed,
                flow_m3_s: &self.flow,
                head_m: &self.head,
                keep: &self.keep,
            }
        }
    }

    /// Mean squared error over n - 3 by QR, and c1 and c2, of the best of the four subsets that complies.
    fn by_subsets(rows: &Rows, n0: f64, n2: f64) -> Option<(f64, [f64; 2])> {
        let reduced = crate::fit::reduce(&rows.samples(), n0, n2).ok()?;
        let mut best: Option<(f64, [f64; 2])> = None;
        for free in [[true, true], [true, false], [false, true], [false, false]] {
            let held: Vec<(usize, f64)> =
                (1..3).filter(|&j| !free[j - 1]).map(|j| (j, 0.0)).collect();
            let fit = if held.is_empty() {
                reduced.solve(f64::INFINITY)
            } else {
                reduced.hold(&held).and_then(|r| r.solve(f64::INFINITY))
            };
            let fit = fit.ok()?;
            let complies = fit.coefficients[1..].iter().all(|c| *c > 0.0);
            let mse = fit.rss / (rows.head.len() - 3) as f64;
            if complies && best.is_none_or(|(least, _)| mse < least) {
                let mut values = fit.coefficients[1..].iter();
                let mut next = |free| if free { values.next().copied() } else { None };
                let c = free.map(|free| next(free).unwrap_or(0.0));
                best = Some((mse, c));
            }
        }
        best
    }

    #[test]
    fn the_bounded_answer_is_the_best_subset_that_complies() {
        let mut seen = Vec::new();
        for (c1, c2) in [(3.0, 9e3), (-3.0, 9e3), (20.0, -1e4), (-3.0, -9e3)] {
            let rows = Rows::new(
                |_, x| 0.07 * x,
                |w, q| 0.05 * w * w - c1 * w * q - c2 * q * q,
            );
            let table = Table::new(&rows.samples(), &(0.5..=4.0), &(1.0..=4.0)).expect("flows");
            for (n0, n2) in [(1.2, 1.3), (2.0, 2.0), (1.9, 3.0), (3.0, 1.5)] {
                let (mse, c) = by_subsets(&rows, n0, n2).expect("rich data");
                let free = c.map(|c| c > 0.0);
                let found = table.solve_bounded(n0, n2).expect("rich data");
                assert!((found.mse / mse - 1.0).abs() < 1e-8, "{c1} {c2} {n0} {n2}");
                assert_eq!([found.share1 > 0.0, found.share2 > 0.0], free);
                let samples = rows.samples();
                let squares = samples.rows().fold([0.0; 3], |[a, b, y], (w, q, h)| {
                    [a + (w * q).powi(2), b + q.powf(2.0 * n2), y + h * h]
                });
                for (share, k) in [(found.share1, 0), (found.share2, 1)] {
                    let expected = c[k] * (squares[k] / squares[2]).sqrt();
                    assert!(
                        (share - expected).abs() <= 1e-7 * expected,
                        "{share} {expected}"
                    );
                }
                seen.push(free);
            }
        }
        for free in [[true, true], [true, false], [false, true], [false, false]] {
            assert!(seen.contains(&free), "{free:?} is never the best");
        }
    }

    #[test]
    fn shares_are_those_of_the_terms_in_the_head() {
        let rows = Rows::new(
            |_, x| 0.07 * x,
            |w, q| 0.05 * w * w - 3.0 * w * q - 9e3 * q * q,
        );
        let table = Table::new(&rows.samples(), &(0.5..=4.0), &(1.0..=4.0)).expect("flows");
        let curve = fit_unconstrained(&rows.samples(), 2.0, 2.0)
            .expect("rich data")
            .curve;
        let rms = |of: &dyn Fn(f64, f64, f64) -> f64| {
            let samples = rows.samples();
            let squares = samples.rows().map(|(w, q, h)| of(w, q, h).powi(2));
            (squares.sum::<f64>() / 600.0).sqrt()
        };
        let head = rms(&|_, _, h| h);
        let found = table.solve(2.0, 2.0).expect("rich data");
        let share1 = rms(&|w, q, _| curve.c1 * w * q) / head;
        let share2 = rms(&|_, q, _| curve.c2 * q * q) / head;
        assert!((found.share1 / share1 - 1.0).abs() < 1e-8);
        assert!((found.share2 / share2 - 1.0).abs() < 1e-8);
        assert!((table.mean_square_head() / head.powi(2) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn columns_that_go_together_have_no_answer() {
        // With q = w/1000, w q is w^2 and q^n2 is w^n2.
        let tied = Rows::new(|w, _| 1e-3 * w, |w, _| 0.05 * w * w);
        let table = Table::new(&tied.samples(), &(0.5..=4.0), &(1.0..=4.0)).expect("flows");
        for (n0, n2) in [(2.0, 1.5), (1.5, 2.0), (1.5, 1.5)] {
            assert!(table.solve(n0, n2).is_none(), "{n0} {n2}");
        }
        assert!(table.solve(1.3, 2.7).is_some());
        // Held at 0, a column that goes with another one is not missed.
        assert!(table.solve_bounded(2.0, 1.5).is_some());
    }

    #[test]
    fn three_rows_leave_nothing_to_judge_a_curve_by_and_four_do() {
        for (kept, some) in [(3, false), (4, true)] {
            let mut rows = Rows::new(
                |_, x| 0.07 * x,
                |w, q| 0.05 * w * w - 3.0 * w * q - 9e3 * q * q,
            );
            rows.keep[kept..].fill(false);
            let table = Table::new(&rows.samples(), &(0.5..=4.0), &(1.0..=4.0)).expect("flows");
            assert_eq!(table.solve(1.9, 2.1).is_some(), some);
            assert_eq!(table.solve_bounded(1.9, 2.1).is_some(), some);
        }
    }

    #[test]
    fn at_a_node_its_own_weight_is_all() {
        let nodes = Nodes::over(&(0.5..=4.0));
        for k in 0..NODES {
            let weights = nodes.weights(nodes.at[k]);
            for (j, weight) in weights.iter().enumerate() {
                assert_eq!(*weight, if j == k { 1.0 } else { 0.0 });
            }
        }
    }
}
