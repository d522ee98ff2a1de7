//! The model linearised about a hypothesis, and evidence measured off its tangent.
//!
//! All base parameters (friction and head curves, the offset between redundant transmitters) and the slow wander of
//! instruments within their accuracy span the tangent. Evidence for an effect is what its signature explains beyond it.

use crate::ground::Ground;
use crate::noise::{Layout, Whitening};
use crate::record::{MASS_BLOCKS, Record};
use crate::relations::{Applied, Blocks, Rows};
use crate::scan::joined;
use crate::slack::{Slack, slack};
use crate::step::Step;
use crate::unrest::wander;
pub(crate) use crate::vectors::dot;
use crate::vectors::{
    Orthonormal, Reach, Sparse, back_substitute, dot_within, orthonormal, products, support,
    take_away, without,
};
use dgd_effects::{
    Curves, FRICTION_TERMS, HEAD_POWERS, HEAD_TERMS, Rank, Scale, friction_terms, head_terms,
    quantile,
};
use nalgebra::{DMatrix, DVector};
use std::sync::{Arc, OnceLock};

/// Prior width of the head's lean on inlet pressure.
const LEAN_PRIOR: f64 = 0.1;
/// Prior widths of the friction terms, Pa at the scale's flow: intercept and linear term are physics, not curve.
pub(crate) const FRICTION_PRIOR_PA: [f64; FRICTION_TERMS] =
    [3.0e3, 4.0e3, 1e8, 1e8, 4.0e3, 2e3, 2e3, 2e3, 2e3, 2e3];
/// Prior widths of the head terms, Pa at the scale: an offset within accuracy, the parabola as a share of the lift, terms of
/// another degree than the second, which break the affinity laws, small, then bumps.
const HEAD_OFFSET_PA: f64 = 3.0e3;
const HEAD_ODD_PA: f64 = 5.0e4;
const HEAD_BUMP_PA: f64 = 4.0e4;

/// The linearised model.
#[derive(Clone)]
pub(crate) struct Tangent {
    /// The hypothesis that it is linearised about.
    applied: Vec<Applied>,
    /// What that comes to by itself, once a candidate stands on it.
    ground: OnceLock<Arc<Ground>>,
    pub rows: Rows,
    pub layout: Layout,
    pub whitening: Arc<Whitening>,
    pub curves: Curves,
    /// Other coefficients: offset of the outlets, lean, slack.
    rest: Vec<f64>,
    /// Columns of `rest`, stacked rows.
    nuisance: Vec<Arc<Sparse>>,
    /// Orthonormal columns, over whitened rows followed by prior rows.
    basis: Vec<Vec<f64>>,
    /// Rows in which each of them may differ from 0.
    reaches: Vec<Reach>,
    /// Whitened residual off the tangent, the same shape.
    pub off: Vec<f64>,
    /// Raw residual of the curves alone (wanders not taken out), stacked.
    pub residual: Vec<f64>,
    /// How freely the curves may bend.
    pub lean: Bend,
    /// What the named effects may be wrong by.
    slack: Vec<Slack>,
    /// Logarithm of the prior's volume over the posterior's: the price of all freedom.
    ln_volume: f64,
    /// The curves at this hypothesis.
    evaluated: Evaluated,
}

/// What a tangent leaves to the one that takes its place.
struct Kept {
    rows: Rows,
    curves: Curves,
    whitening: Arc<Whitening>,
    residual: Vec<f64>,
    lean: Bend,
}

/// Median lift of the pump where its head may be judged, Pa.
fn typical_lift(rows: &Rows, blocks: &Blocks) -> f64 {
    let lifts =
        (blocks.lift.iter().zip(&rows.head)).filter_map(|(lift, head)| head.then_some(*lift));
    quantile(lifts, Rank::MEDIAN).unwrap_or(1e6).max(1e5)
}

/// Mean and width of each head term at the scale, Pa.
///
/// Radial pumps of any make: a shut-off head somewhat above the usual lift, which falls with flow (Gülich 2010, on
/// performance characteristics; the numbers are ours). Where speed and flow hardly vary it is this that keeps a curve of
/// any slope from hiding gas or wear.
fn head_priors(lift: f64) -> [(f64, f64); HEAD_TERMS] {
    let mut out = [(0.0, HEAD_BUMP_PA); HEAD_TERMS];
    out[0].1 = HEAD_OFFSET_PA;
    out[1] = (1.3 * lift, 0.25 * lift);
    out[2] = (0.0, 0.2 * lift);
    out[3] = (-0.3 * lift, 0.2 * lift);
    out[4..HEAD_POWERS].fill((0.0, HEAD_ODD_PA));
    out
}

/// How freely the curves may bend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bend {
    /// As pumps and lines do: for estimates.
    Free,
    /// The head may also lean on the inlet pressure: a gate for effects of the pump.
    Lean,
    /// Every smooth shape, and a lean: what is left over then is no curve.
    Loose,
}

/// Both curves at the blocks of one hypothesis: others share most of its blocks, and bumps are dear.
#[derive(Debug, Clone)]
struct Evaluated {
    flow: Vec<f64>,
    friction_pa: Vec<f64>,
    speed: Vec<f64>,
    through: Vec<f64>,
    head_pa: Vec<f64>,
}

impl Evaluated {
    fn of(curves: &Curves, b: &Blocks, known: Option<&Self>) -> Self {
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
    fn residual(&self, layout: Layout, b: &Blocks) -> Vec<f64> {
        let mut out = Vec::with_capacity(layout.len());
        let n = layout.blocks;
        out.extend((0..n).map(|k| b.drop[k] - b.friction_factor[k] * self.friction_pa[k]));
        out.extend((0..n).map(|k| b.lift[k] - b.head_factor[k] * self.head_pa[k]));
        out.extend_from_slice(&b.difference);
        out.extend_from_slice(&b.imbalance);
        out
    }
}

/// A robust straight least-squares fit; returns the coefficients.
fn robust(columns: &[Vec<f64>], y: &[f64], priors: &[f64]) -> Vec<f64> {
    let p = columns.len();
    let mut weight = vec![1.0; y.len()];
    let mut beta = vec![0.0; p];
    for _ in 0..8 {
        let mut normal = nalgebra::DMatrix::<f64>::zeros(p, p);
        let mut right = nalgebra::DVector::<f64>::zeros(p);
        for i in 0..y.len() {
            for a in 0..p {
                let wa = weight[i] * columns[a][i];
                right[a] += wa * y[i];
                for b in 0..=a {
                    normal[(a, b)] += wa * columns[b][i];
                }
            }
        }
        for a in 0..p {
            for b in a + 1..p {
                normal[(a, b)] = normal[(b, a)];
            }
            // A noise of 5 kPa stands against the prior; a whisper keeps collinear terms apart.
            normal[(a, a)] += (5e3 / priors[a]).powi(2) + 1e-10 * normal[(a, a)].max(1e-12);
        }
        let Some(factor) = normal.cholesky() else {
            break;
        };
        let solved = factor.solve(&right);
        beta.copy_from_slice(solved.as_slice());
        let residual: Vec<f64> = (0..y.len())
            .map(|i| y[i] - (0..p).map(|a| columns[a][i] * beta[a]).sum::<f64>())
            .collect();
        let scale = crate::noise::spread(residual.iter().copied()).max(200.0);
        for (w, r) in weight.iter_mut().zip(&residual) {
            let u = r.abs() / scale;
            *w = if u < 2.0 { 1.0 } else { 2.0 / u };
            if u > 8.0 {
                *w *= 8.0 / u;
            }
        }
    }
    beta
}

/// Fits both curves robustly to the valid rows.
fn curves_of(rows: &Rows, b: &Blocks, scale: Scale) -> Curves {
    let fit = |valid: &[bool],
               y: &[f64],
               terms: &dyn Fn(usize) -> Vec<f64>,
               priors: &[f64]|
     -> Vec<f64> {
        let use_: Vec<usize> = (0..valid.len())
            .filter(|&k| valid[k] && y[k].is_finite())
            .collect();
        let table: Vec<Vec<f64>> = use_.iter().map(|&k| terms(k)).collect();
        let columns: Vec<Vec<f64>> = (0..priors.len())
            .map(|a| table.iter().map(|r| r[a]).collect())
            .collect();
        let values: Vec<f64> = use_.iter().map(|&k| y[k]).collect();
        robust(&columns, &values, priors)
    };
    // The curves fitted here only lead to the linearisation: their priors need no means.
    let head_widths = head_priors(typical_lift(rows, b)).map(|(mean, width)| mean.hypot(width));
    let friction = fit(
        &rows.friction,
        &b.drop,
        &|k| {
            friction_terms(b.flow[k], scale)
                .iter()
                .map(|v| v * b.friction_factor[k])
                .collect()
        },
        &FRICTION_PRIOR_PA,
    );
    let head = fit(
        &rows.head,
        &b.lift,
        &|k| {
            head_terms(b.speed[k], b.through[k], scale)
                .iter()
                .map(|v| v * b.head_factor[k])
                .collect()
        },
        &head_widths,
    );
    let mut curves = Curves {
        scale,
        friction: [0.0; FRICTION_TERMS],
        head: [0.0; HEAD_TERMS],
    };
    curves.friction.copy_from_slice(&friction);
    curves.head.copy_from_slice(&head);
    curves
}

impl Tangent {
    /// Linearises about a hypothesis. `excluded` blocks (held out) carry no weight.
    pub(crate) fn at(
        record: &Record,
        applied: &[Applied],
        excluded: &[bool],
        lean: Bend,
    ) -> Option<Self> {
        let blocks = Blocks::under(record, applied);
        let mut rows = Rows::of(record, &blocks);
        for b in 0..record.blocks {
            if excluded.get(b).copied().unwrap_or(false) {
                rows.friction[b] = false;
                rows.head[b] = false;
                if let Some(d) = rows.difference.get_mut(b) {
                    *d = false;
                }
                if let Some(m) = rows.mass.get_mut(b / MASS_BLOCKS) {
                    *m = false;
                }
            }
        }
        let scale = Scale {
            flow_m3_s: upper(&record.flow)?.max(5e-3),
            speed_pct: upper(&record.speed)?.max(10.0),
        };
        let count = rows.friction.iter().filter(|v| **v).count();
        if count < 60 || rows.head.iter().filter(|v| **v).count() < 60 {
            return None;
        }
        let curves = curves_of(&rows, &blocks, scale);
        let layout = Layout {
            blocks: record.blocks,
            difference: blocks.difference.len(),
            mass: blocks.imbalance.len(),
        };
        let residual = Evaluated::of(&curves, &blocks, None).residual(layout, &blocks);
        let unrest = crate::unrest::unrest(record, &curves, &blocks, layout);
        let whitening = Whitening::of(layout, &rows, &residual, &unrest, wander(record, &curves));
        let first = Self::with(
            record,
            applied,
            &blocks,
            rows,
            curves,
            Arc::new(whitening),
            lean,
            Vec::new(),
        );
        // A row that stands out alone is a glitch: no effect of minutes looks like that.
        let lonely = first.lonely(record);
        let Kept {
            mut rows,
            curves,
            residual,
            ..
        } = first.kept();
        for row in lonely {
            let n = layout.blocks;
            if row < n {
                rows.friction[row] = false;
                rows.head[row] = false;
            } else if row < 2 * n {
                rows.head[row - n] = false;
            } else if row < layout.mass_at() {
                rows.difference[row - layout.difference_at()] = false;
            } else {
                rows.mass[row - layout.mass_at()] = false;
            }
        }
        let unrest = crate::unrest::unrest(record, &curves, &blocks, layout);
        let whitening = Whitening::of(layout, &rows, &residual, &unrest, wander(record, &curves));
        Some(Self::with(
            record,
            applied,
            &blocks,
            rows,
            curves,
            Arc::new(whitening),
            lean,
            Vec::new(),
        ))
    }

    /// Rows more than 4.5 deviations off between calm neighbours, away from starts of the pump.
    fn lonely(&self, record: &Record) -> Vec<usize> {
        let l = self.layout;
        let n = l.blocks;
        let m = record.per_block;
        let starting = |b: usize| {
            let r = (b.saturating_sub(9) * m)..((b + 2) * m).min(record.filled.pumping.len());
            record.filled.pumping[r].iter().any(|p| !*p)
        };
        let mut out = Vec::new();
        for (k, from, to) in [
            (0, 0, n),
            (1, n, 2 * n),
            (2, l.difference_at(), l.mass_at()),
            (3, l.mass_at(), l.len()),
        ] {
            for row in from..to {
                let block = if k == 3 {
                    (row - from) * MASS_BLOCKS
                } else {
                    row - from
                };
                if self.off[row].abs() < 4.5 || (k < 2 && starting(block)) {
                    continue;
                }
                // The memory of the filter lets a glitch ring for two rows; before it all is calm.
                let calm = |i: usize| i < from || i >= to || self.off[i].abs() < 3.0;
                let before = row == from || (calm(row - 1) && (row < from + 2 || calm(row - 2)));
                let after = calm(row + 2) && calm(row + 3) && calm(row + 4);
                if before && after {
                    out.push(row);
                }
            }
        }
        out
    }

    /// The model re-fitted under another hypothesis, its noise and rows as here.
    pub(crate) fn refitted(&self, record: &Record, applied: &[Applied]) -> Self {
        let blocks = Blocks::under(record, applied);
        Self::with(
            record,
            applied,
            &blocks,
            self.rows.clone(),
            self.curves.clone(),
            self.whitening.clone(),
            self.lean,
            self.slack.clone(),
        )
    }

    /// Linearises about a hypothesis whose own effects may be wrong by their slack: what a further effect must stand out from.
    pub(crate) fn beside(
        record: &Record,
        applied: &[Applied],
        excluded: &[bool],
        lean: Bend,
    ) -> Option<Self> {
        let bare = Self::at(record, applied, excluded, lean)?;
        if !record.takes(Step::Slack) {
            return Some(bare);
        }
        let slack: Vec<Slack> = (0..applied.len())
            .flat_map(|k| slack(record, &bare, applied, k))
            .collect();
        Some(if slack.is_empty() {
            bare
        } else {
            bare.slackened(record, applied, slack)
        })
    }

    /// Evidence (ln of the Bayes factor) of an effect whose parameters are free and whose form is within its error.
    pub(crate) fn formed(&self, record: &Record, state: &[Applied], one: &Applied) -> f64 {
        let applied = joined(state, one);
        let plain = self.refitted(record, &applied);
        let mut free = self.slack.clone();
        free.extend(slack(record, &plain, &applied, applied.len() - 1));
        let with = plain.slackened(record, &applied, free);
        let misfit = |t: &Self| 0.5 * dot(&t.off, &t.off) + t.ln_volume;
        misfit(self) - misfit(&with)
    }

    /// The same tangent with other slack.
    fn slackened(self, record: &Record, applied: &[Applied], slack: Vec<Slack>) -> Self {
        let kept = self.kept();
        Self::with(
            record,
            applied,
            &Blocks::under(record, applied),
            kept.rows,
            kept.curves,
            kept.whitening,
            kept.lean,
            slack,
        )
    }

    /// What a tangent that takes this one's place is made of; all the rest, the columns above all, is released.
    fn kept(self) -> Kept {
        Kept {
            rows: self.rows,
            curves: self.curves,
            whitening: self.whitening,
            residual: self.residual,
            lean: self.lean,
        }
    }

    /// The tangent for a known noise.
    #[expect(
        clippy::too_many_arguments,
        reason = "what a tangent is made of, passed on by three callers"
    )]
    fn with(
        record: &Record,
        applied: &[Applied],
        blocks: &Blocks,
        rows: Rows,
        curves: Curves,
        whitening: Arc<Whitening>,
        lean: Bend,
        slack: Vec<Slack>,
    ) -> Self {
        let layout = whitening.layout;
        let scale = curves.scale;
        let n = layout.blocks;
        let total = layout.len();
        let wide = if lean == Bend::Loose { 6.0 } else { 1.0 };
        let mut priors: Vec<f64> = Vec::new();
        for (a, prior) in FRICTION_PRIOR_PA.into_iter().enumerate() {
            priors.push(prior * if a == 0 { 1.0 } else { wide });
        }
        let mut means = vec![0.0; FRICTION_TERMS];
        let head_priors = head_priors(typical_lift(&rows, blocks));
        for (a, (mean, width)) in head_priors.into_iter().enumerate() {
            means.push(mean);
            priors.push(width * if a == 0 { 1.0 } else { wide });
        }
        let sections = layout.sections();
        let mut nuisance: Vec<Arc<Sparse>> = Vec::new();
        if layout.difference > 0 {
            let mut column = vec![0.0; total];
            column[layout.difference_at()..layout.mass_at()].fill(1.0);
            nuisance.push(Arc::new(Sparse::of(&column, &sections)));
            priors.push(2e4);
        }
        if lean != Bend::Free {
            // Within the meter's noise, what the level tells of the flow is better than the meter: head leans towards
            // the line (lift = line pressure - inlet pressure), as any regression in a noisy flow must.
            let typical = crate::record::mean(&record.filled.inlet);
            let mut column = vec![0.0; total];
            for b in 0..n {
                let samples = b * record.per_block..(b + 1) * record.per_block;
                column[n + b] = crate::record::mean(&record.filled.inlet[samples]) - typical;
            }
            nuisance.push(Arc::new(Sparse::of(&column, &sections)));
            priors.push(LEAN_PRIOR);
        }
        for free in &slack {
            nuisance.push(Arc::clone(&free.column));
            priors.push(free.width);
        }
        let p = priors.len();
        // Each column is whitened as soon as it is made, and held only so: columns are what a tangent's memory goes into.
        let mut whitened: Vec<Vec<f64>> = Vec::with_capacity(p);
        let mut take = |column: Vec<f64>| {
            let mut w = whitening.apply_whole(&column);
            drop(column);
            w.reserve_exact(p);
            whitened.push(w);
        };
        by_column(total, 0, n, |b| {
            friction_terms(blocks.flow[b], scale).map(|v| v * blocks.friction_factor[b])
        })
        .into_iter()
        .for_each(&mut take);
        by_column(total, n, n, |b| {
            head_terms(blocks.speed[b], blocks.through[b], scale).map(|v| v * blocks.head_factor[b])
        })
        .into_iter()
        .for_each(&mut take);
        (nuisance.iter().map(|column| column.whole())).for_each(&mut take);
        // Columns that touch little first: they stay short among themselves.
        let mut order: Vec<usize> = (0..p).collect();
        order.sort_by_key(|&a| support(&whitened[a]).len());
        let mut basis: Vec<Vec<f64>> = order
            .iter()
            .map(|&a| {
                let mut w = std::mem::take(&mut whitened[a]);
                w.resize(total + p, 0.0);
                w[total + a] = 1.0 / priors[a];
                w
            })
            .collect();
        let mut y = vec![0.0; total];
        y[..n].copy_from_slice(&blocks.drop);
        y[n..2 * n].copy_from_slice(&blocks.lift);
        y[layout.difference_at()..layout.mass_at()].copy_from_slice(&blocks.difference);
        y[layout.mass_at()..].copy_from_slice(&blocks.imbalance);
        let mut off = whitening.apply_whole(&y);
        off.resize(total + p, 0.0);
        for (a, mean) in means.iter().enumerate() {
            off[total + a] = mean / priors[a];
        }
        let Orthonormal { triangle, reaches } = orthonormal(&mut basis, total);
        let mut right = vec![0.0; p];
        for ((q, rows), r) in basis.iter().zip(&reaches).zip(&mut right) {
            *r = dot_within(q, &off, rows, p);
            take_away(&mut off, *r, q, rows, p);
        }
        let ln_volume = (triangle.iter().zip(&order).enumerate())
            .map(|(k, (row, &a))| (row[k].abs() * priors[a]).ln())
            .sum();
        let mut beta = vec![0.0; p];
        for (value, &a) in back_substitute(&triangle, right).into_iter().zip(&order) {
            beta[a] = value;
        }
        let mut fitted = curves;
        fitted.friction.copy_from_slice(&beta[..FRICTION_TERMS]);
        fitted
            .head
            .copy_from_slice(&beta[FRICTION_TERMS..FRICTION_TERMS + HEAD_TERMS]);
        let evaluated = Evaluated::of(&fitted, blocks, None);
        let residual = evaluated.residual(layout, blocks);
        Self {
            applied: applied.to_vec(),
            ground: OnceLock::new(),
            rows,
            layout,
            whitening,
            curves: fitted,
            rest: beta[FRICTION_TERMS + HEAD_TERMS..].to_vec(),
            nuisance,
            basis,
            reaches,
            off,
            residual,
            lean,
            slack,
            ln_volume,
            evaluated,
        }
    }

    /// The whitened part of a stacked vector off the tangent.
    pub(crate) fn project(&self, stacked: &[f64]) -> Vec<f64> {
        let mut w = self.whitening.apply(stacked);
        // Most effects touch one relation: only the columns and rows that meet it cost anything.
        let touched = support(&w);
        w.resize(self.off.len(), 0.0);
        if touched.is_empty() {
            return w;
        }
        let scale = dot(&w[touched.clone()], &w[touched.clone()]).sqrt();
        // Columns are orthonormal: the products need not wait for one another.
        let mut shares = products(&self.basis, &self.reaches, &w, &touched);
        for share in &mut shares {
            // Not turned round: a NaN is passed over too.
            if !(share.abs() > 1e-9 * scale) {
                *share = 0.0;
            }
        }
        without(
            &mut w,
            &self.basis,
            &self.reaches,
            &shares,
            self.basis.len(),
        );
        w
    }

    /// Inner products of changes of the stacked residuals, whitened and off the tangent, and those with the residual itself.
    pub(crate) fn normal_equations(
        &self,
        record: &Record,
        changes: &[Vec<f64>],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let whitened: Vec<Vec<f64>> = changes.iter().map(|c| self.whitening.apply(c)).collect();
        let rows = self.layout.len();
        let within: Vec<Vec<f64>> = whitened
            .iter()
            .map(|w| {
                if !record.takes(Step::Projection) {
                    return vec![0.0; self.basis.len()];
                }
                products(&self.basis, &self.reaches, w, &support(w))
            })
            .collect();
        let n = changes.len();
        let gram = DMatrix::from_fn(n, n, |a, b| {
            dot(&whitened[a], &whitened[b]) - dot(&within[a], &within[b])
        });
        let right = DVector::from_fn(n, |a, _| dot(&whitened[a], &self.off[..rows]));
        (gram, right)
    }

    /// What a hypothesis takes out of the residuals of these curves: whitened, off the tangent.
    pub(crate) fn signature(&self, record: &Record, applied: &[Applied]) -> Vec<f64> {
        self.beyond(record, &self.change(record, applied))
    }

    /// What a change of the stacked residuals amounts to: whitened, off the tangent.
    pub(crate) fn beyond(&self, record: &Record, change: &[f64]) -> Vec<f64> {
        if !record.takes(Step::Projection) {
            let mut whole = self.whitening.apply(change);
            whole.resize(self.off.len(), 0.0);
            return whole;
        }
        self.project(change)
    }

    /// The same before whitening.
    pub(crate) fn change(&self, record: &Record, applied: &[Applied]) -> Vec<f64> {
        let blocks = match applied.split_last() {
            Some((one, state)) if alike(state, &self.applied) => {
                let ground = self
                    .ground
                    .get_or_init(|| Arc::new(Ground::under(record, state)));
                ground.with(record, one)
            }
            _ => None,
        };
        let blocks = blocks.unwrap_or_else(|| Blocks::under(record, applied));
        let with = Evaluated::of(&self.curves, &blocks, Some(&self.evaluated))
            .residual(self.layout, &blocks);
        self.residual
            .iter()
            .zip(&with)
            .map(|(a, b)| a - b)
            .collect()
    }

    /// Stacked residual with offsets and slack taken out, in physical units; the wander of instruments is still in it.
    pub(crate) fn clean_residual(&self) -> Vec<f64> {
        let mut out = self.residual.clone();
        for (column, beta) in self.nuisance.iter().zip(&self.rest) {
            column.take_from(&mut out, *beta);
        }
        out
    }
}

/// Whether two hypotheses are the same, digit for digit.
fn alike(a: &[Applied], b: &[Applied]) -> bool {
    let bits = |one: &Applied| {
        one.parameters
            .iter()
            .map(|p| p.to_bits())
            .collect::<Vec<_>>()
    };
    let same = |(a, b): (&Applied, &Applied)| {
        a.effect.about().id == b.effect.about().id && bits(a) == bits(b)
    };
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// Columns of `total` rows from the terms of each of `count` rows after `first`.
fn by_column<const K: usize>(
    total: usize,
    first: usize,
    count: usize,
    terms: impl Fn(usize) -> [f64; K],
) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; total]; K];
    for b in 0..count {
        for (column, v) in columns.iter_mut().zip(terms(b)) {
            column[first + b] = v;
        }
    }
    columns
}

/// 95th percentile of the finite values.
fn upper(values: &[f64]) -> Option<f64> {
    quantile(values.iter().copied(), Rank::Before(0.95))
}
