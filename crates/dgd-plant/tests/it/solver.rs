//! The thesis's estimators in thirty lines, so that the plant is judged without the product's crates.

use dgd_plant::Recording;

pub(crate) const GPM: f64 = 6.3090e-5;
const PSI: f64 = 6_894.757_29;

/// Coefficients and mean squared error over n - p, by normal equations on scaled columns.
pub(crate) fn fit(rows: &[Vec<f64>], y: &[f64]) -> (Vec<f64>, f64) {
    let p = rows[0].len();
    let scale: Vec<f64> = (0..p)
        .map(|j| rows.iter().map(|r| r[j] * r[j]).sum::<f64>().sqrt())
        .collect();
    let mut a = vec![vec![0.0; p + 1]; p];
    for (row, &y) in rows.iter().zip(y) {
        for i in 0..p {
            for j in 0..p {
                a[i][j] += row[i] * row[j] / scale[i] / scale[j];
            }
            a[i][p] += row[i] * y / scale[i];
        }
    }
    for i in 0..p {
        let pivot = (i..p)
            .max_by(|&x, &y| a[x][i].abs().total_cmp(&a[y][i].abs()))
            .unwrap();
        a.swap(i, pivot);
        for r in 0..p {
            if r != i {
                let f = a[r][i] / a[i][i];
                for k in i..=p {
                    a[r][k] -= f * a[i][k];
                }
            }
        }
    }
    let c: Vec<f64> = (0..p).map(|i| a[i][p] / a[i][i] / scale[i]).collect();
    let sum: f64 = rows
        .iter()
        .zip(y)
        .map(|(r, y)| (y - r.iter().zip(&c).map(|(r, c)| r * c).sum::<f64>()).powi(2))
        .sum();
    (c, sum / (rows.len() - p) as f64)
}

/// One screened sample: flow in percent of 0.06 m³/s at every shift, friction, head, speed.
pub(crate) struct Screened {
    pub(crate) flow_pct: Vec<f64>,
    pub(crate) friction_pa: Vec<f64>,
    pub(crate) head_m: Vec<f64>,
    pub(crate) speed_pct: Vec<f64>,
    pub(crate) keep: Vec<bool>,
}

/// The rules of section 3.3: pump on, positive rise, positive flow, no run of more than five equal flows
/// or sixty equal speeds.
pub(crate) fn screen(r: &Recording) -> Screened {
    let [_, _, _, ft4, pt1, pt2, pt3, pt4, _, spm] = &r.channels;
    let (stuck_flow, stuck_speed) = (in_run(ft4, 5), in_run(spm, 60));
    let n = ft4.len();
    let mut s = Screened {
        flow_pct: Vec::with_capacity(n),
        friction_pa: Vec::with_capacity(n),
        head_m: Vec::with_capacity(n),
        speed_pct: spm.clone(),
        keep: Vec::with_capacity(n),
    };
    for i in 0..n {
        let inlet = 0.5 * (pt1[i] + pt2[i]) * PSI;
        let outlet = 0.5 * (pt3[i] + pt4[i]) * PSI;
        s.flow_pct.push(ft4[i] * GPM / 0.06 * 100.0);
        s.friction_pa
            .push(outlet - 1080.0 * 9.80665 * 350.3 - 101_325.0);
        s.head_m.push((outlet - inlet) / 1080.0 / 9.80665);
        let measured = (ft4[i] + inlet + outlet + spm[i]).is_finite();
        s.keep.push(
            measured
                && spm[i] > 0.0
                && outlet > inlet
                && ft4[i] > 0.0
                && !stuck_flow[i]
                && !stuck_speed[i],
        );
    }
    s
}

fn in_run(x: &[f64], longest: usize) -> Vec<bool> {
    let mut out = vec![false; x.len()];
    let mut first = 0;
    for i in 1..=x.len() {
        if i == x.len() || x[i].to_bits() != x[first].to_bits() {
            if i - first > longest {
                out[first..i].fill(true);
            }
            first = i;
        }
    }
    out
}

impl Screened {
    /// Indices that can be used at a shift of `delay` samples, and the shifted flow.
    pub(crate) fn shifted(&self, delay: usize) -> Vec<(usize, f64)> {
        (0..self.keep.len() - delay)
            .filter(|&i| self.keep[i] && self.flow_pct[i + delay].is_finite())
            .map(|i| (i, self.flow_pct[i + delay]))
            .collect()
    }

    /// Fit of F = C q + D q² (3.14, 3.23).
    pub(crate) fn quadratic(&self, delay: usize) -> (Vec<f64>, f64) {
        let used = self.shifted(delay);
        let rows: Vec<Vec<f64>> = used.iter().map(|&(_, q)| vec![q, q * q]).collect();
        let y: Vec<f64> = used.iter().map(|&(i, _)| self.friction_pa[i]).collect();
        fit(&rows, &y)
    }

    /// Fit of F = B + D q² + E q³ (3.26).
    pub(crate) fn cubic(&self, delay: usize) -> (Vec<f64>, f64) {
        let used = self.shifted(delay);
        let rows: Vec<Vec<f64>> = used
            .iter()
            .map(|&(_, q)| vec![1.0, q * q, q.powi(3)])
            .collect();
        let y: Vec<f64> = used.iter().map(|&(i, _)| self.friction_pa[i]).collect();
        fit(&rows, &y)
    }

    /// Fit of the head c0 ω^n0 - c1 ω q - c2 q^n2 (3.31, 3.39).
    pub(crate) fn head(&self, delay: usize, n0: f64, n2: f64) -> (Vec<f64>, f64) {
        let used = self.shifted(delay);
        let rows: Vec<Vec<f64>> = used
            .iter()
            .map(|&(i, q)| {
                let w = self.speed_pct[i];
                vec![w.powf(n0), -w * q, -q.max(0.0).powf(n2)]
            })
            .collect();
        let y: Vec<f64> = used.iter().map(|&(i, _)| self.head_m[i]).collect();
        fit(&rows, &y)
    }

    /// The shift between 0 and 30 samples with the least error of (3.23).
    pub(crate) fn best_delay(&self) -> usize {
        (0..=30)
            .min_by(|&a, &b| self.quadratic(a).1.total_cmp(&self.quadratic(b).1))
            .unwrap()
    }

    /// Best exponents with c1, c2 > 0 and n2 > 1 (3.44), by compass search: n0, n2 and the error.
    pub(crate) fn exponents(&self, delay: usize) -> (f64, f64, f64) {
        let cost = |n0: f64, n2: f64| {
            let (c, mse) = self.head(delay, n0, n2);
            if n2 > 1.0 && c[1] > 0.0 && c[2] > 0.0 {
                mse
            } else {
                f64::INFINITY
            }
        };
        let (mut n0, mut n2, mut step) = (1.82, 1.9, 0.08);
        let mut best = cost(n0, n2);
        while step > 2e-3 {
            let tries = [
                (step, 0.0),
                (-step, 0.0),
                (0.0, 2.0 * step),
                (0.0, -2.0 * step),
                (-step, 2.0 * step),
                (step, -2.0 * step),
            ];
            let next = tries
                .iter()
                .map(|&(a, b)| (n0 + a, n2 + b, cost(n0 + a, n2 + b)))
                .min_by(|a, b| a.2.total_cmp(&b.2))
                .unwrap();
            if next.2 < best {
                (n0, n2, best) = next;
            } else {
                step *= 0.5;
            }
        }
        (n0, n2, best)
    }
}
