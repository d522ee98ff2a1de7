//! The model linearised about a hypothesis, and evidence measured off its tangent.
//!
//! All base parameters (friction and head curves, the offset between redundant transmitters) and the slow wander of
//! instruments within their accuracy span the tangent. Evidence for an effect is what its signature explains beyond it.

mod columns;
mod curves;
mod flow_errors;
mod frame;

use crate::ablation::Step;
use crate::incremental::Incremental;
use crate::layout::{Layout, Section};
use crate::noise::Whitening;
use crate::record::Record;
use crate::relations::{Applied, Blocks, Rows, joined, meter_path};
use crate::slack::{Slack, slack};
use crate::stops::left_over;
use crate::vectors::{
    Column, Reach, Sparse, back_substitute, orthonormal, product_within, products, support, without,
};
use columns::Columns;
pub(crate) use columns::FRICTION_PRIOR_PA;
use curves::Evaluated;
use dgd_effects::{Curves, FRICTION_TERMS, HEAD_TERMS, Laminar, Scale, friction_terms};
use dgd_lsq::dot;
use dgd_recording::{Rank, quantile};
pub(crate) use frame::LEAST_ROWS;
use frame::{Frame, isolated};
use nalgebra::{DMatrix, DVector};
use std::sync::{Arc, OnceLock};

/// How freely the curves may bend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bend {
    /// As pumps and lines do: for estimates.
    Stiff,
    /// The head may also lean on the inlet pressure: a gate for effects of the pump, and for corrections that have a form of their own.
    Lean,
    /// Every smooth shape, and a lean: what is left over then is no curve.
    Loose,
}

/// The linearised model.
#[derive(Clone)]
pub(crate) struct Tangent {
    /// The hypothesis that it is linearised about.
    applied: Vec<Applied>,
    /// What that comes to by itself; of a re-fit, once a candidate stands on it.
    ground: OnceLock<Arc<Incremental>>,
    pub rows: Rows,
    pub layout: Layout,
    pub whitening: Arc<Whitening>,
    pub curves: Curves,
    /// Other coefficients: offset of the outlets, lean, slack.
    rest: Vec<f64>,
    /// Columns of `rest`, stacked rows.
    nuisance: Vec<Arc<Sparse>>,
    /// Orthonormal columns, over whitened rows followed by those of the stops, which they do not touch, and prior rows.
    basis: Vec<Column>,
    /// Whitened residual off the tangent, the same shape: between rows and priors stands what is left over of the stops.
    pub off: Vec<f64>,
    /// Raw residual of the curves alone (wanders not taken out), stacked.
    pub residual: Vec<f64>,
    /// How freely the curves may bend.
    bend: Bend,
    /// What the named effects may be wrong by.
    slack: Vec<Slack>,
    /// Logarithm of the prior's volume over the posterior's: the price of all freedom.
    ln_volume: f64,
    /// The curves at this hypothesis.
    evaluated: Evaluated,
}

impl Tangent {
    /// Linearises about a hypothesis. `excluded` blocks (held out) carry no weight.
    pub(crate) fn at(
        record: &Record,
        applied: &[Applied],
        excluded: &[bool],
        bend: Bend,
    ) -> Option<Self> {
        let ground = Arc::new(Incremental::under(record, applied));
        let blocks = ground.blocks();
        let rough = Frame::of(record, blocks, excluded, bend)?;
        let first = Self::with(record, applied, blocks, rough.clone());
        let isolated = isolated(record, first.layout, &first.off);
        let frame = rough.again(
            record,
            blocks,
            first.curves.clone(),
            &first.residual,
            isolated,
        );
        // Its place is taken: two at a time would be held for nothing.
        drop(first);
        Some(Self::on(record, ground, applied, frame))
    }

    /// The model re-fitted under another hypothesis, its noise and rows as here.
    pub(crate) fn refitted(&self, record: &Record, applied: &[Applied]) -> Self {
        let blocks = self.ground(record).other(record, applied);
        Self::with(record, applied, &blocks, self.frame())
    }

    /// What the model re-fitted so leaves over, whitened: the `off` of [`Self::refitted`], without all else.
    pub(crate) fn left_over(&self, record: &Record, applied: &[Applied]) -> Vec<f64> {
        let blocks = self.ground(record).other(record, applied);
        Solved::of(record, applied, &blocks, &self.frame()).off
    }

    /// What the model re-fitted to another reading of the recording leaves over, on the rows and by the noise of this one.
    pub(crate) fn left_over_of(&self, other: &Record, applied: &[Applied]) -> Vec<f64> {
        let blocks = Blocks::under(other, applied);
        Solved::of(other, applied, &blocks, &self.frame()).off
    }

    /// Misfit of another hypothesis about a line of another regime, re-fitted on the rows and by the noise of this one.
    pub(crate) fn misfit_of(&self, other: &Record, applied: &[Applied]) -> f64 {
        let mut frame = self.frame();
        frame.curves.scale.laminar = other.laminar;
        let blocks = Blocks::under(other, applied);
        let solved = Solved::of(other, applied, &blocks, &frame);
        0.5 * dot(&solved.off, &solved.off) + solved.ln_volume
    }

    /// Evidence for laminar flow: for its law, and that of the share that is turbulent, beside the curves here.
    pub(crate) fn laminar_evidence(&self, record: &Record, laminar: Laminar) -> Option<f64> {
        /// Prior width of each law at the scale's flow, Pa: as large as friction is. Set by hand.
        const WIDTH_PA: f64 = 3e5;
        let ground = self.ground(record);
        let b = ground.blocks();
        let scale = Scale {
            laminar: Some(laminar),
            ..self.curves.scale
        };
        let mut laws = vec![vec![0.0; self.layout.len()]; 3];
        for k in self.layout.rows(Section::Friction) {
            let terms = friction_terms(b.flow[k], scale);
            for (law, term) in laws.iter_mut().zip(&terms[1..]) {
                law[k] = WIDTH_PA * b.friction_factor[k] * term;
            }
        }
        let (gram, right) = self.normal_equations(record, &laws);
        let factor = (gram + DMatrix::identity(3, 3)).cholesky()?;
        let saved = 0.5 * right.dot(&factor.solve(&right));
        Some(saved - 0.5 * factor.ln_determinant())
    }

    /// What its hypothesis comes to by itself.
    fn ground(&self, record: &Record) -> Arc<Incremental> {
        let run = || Arc::new(Incremental::under(record, &self.applied));
        Arc::clone(self.ground.get_or_init(run))
    }

    /// The same model on the same rows with the same noise, its curves bending otherwise.
    pub(crate) fn bending(&self, record: &Record, bend: Bend) -> Self {
        let frame = Frame {
            bend,
            ..self.frame()
        };
        Self::on(record, self.ground(record), &self.applied, frame)
    }

    /// What each raw row adds to the product of a whitened vector with the residual.
    pub(crate) fn pull(&self) -> Vec<f64> {
        (self.whitening).transpose(&self.off[..self.layout.len()])
    }

    /// Lets go of the columns, which are what memory goes into: for who only asks what is left when it is
    /// [re-fitted](Self::left_over).
    pub(crate) fn release_columns(&mut self) {
        self.basis = Vec::new();
        self.nuisance = Vec::new();
    }

    /// What it stands on, but for the hypothesis; all the rest, the columns above all, is released.
    fn into_frame(self) -> Frame {
        Frame {
            rows: self.rows,
            curves: self.curves,
            whitening: self.whitening,
            bend: self.bend,
            slack: self.slack,
        }
    }

    /// The same, beside it.
    fn frame(&self) -> Frame {
        Frame {
            rows: self.rows.clone(),
            curves: self.curves.clone(),
            whitening: Arc::clone(&self.whitening),
            bend: self.bend,
            slack: self.slack.clone(),
        }
    }

    /// Linearises about a hypothesis whose own effects may be wrong by their slack: what a further effect must stand out from.
    pub(crate) fn beside(
        record: &Record,
        applied: &[Applied],
        excluded: &[bool],
        bend: Bend,
    ) -> Option<Self> {
        let bare = Self::at(record, applied, excluded, bend)?;
        if !record.takes(Step::Slack) {
            return Some(bare);
        }
        let slack: Vec<Slack> = (0..applied.len())
            .flat_map(|k| slack(record, &bare, applied, k))
            .collect();
        Some(if slack.is_empty() {
            bare
        } else {
            bare.slackened(record, slack)
        })
    }

    /// Evidence (ln of the Bayes factor) of an effect whose parameters are free and whose form is within its error.
    pub(crate) fn formed(&self, record: &Record, state: &[Applied], one: &Applied) -> f64 {
        self.misfit() - self.with_form(record, state, one).1
    }

    /// What the form of an effect gains within its error, everything else fitted about the effect; that its parameters are free as
    /// well is paid for.
    pub(crate) fn form_gain(&self, record: &Record, state: &[Applied], one: &Applied) -> f64 {
        let (plain, with) = self.with_form(record, state, one);
        plain - with
    }

    /// Misfit about an effect, and with its form free within its error.
    fn with_form(&self, record: &Record, state: &[Applied], one: &Applied) -> (f64, f64) {
        let applied = joined(state, one);
        let plain = self.refitted(record, &applied);
        let mut free = self.slack.clone();
        free.extend(slack(record, &plain, &applied, applied.len() - 1));
        let before = plain.misfit();
        (before, plain.slackened(record, free).misfit())
    }

    /// Half of the squares that are left over, and the logarithm of the volume of what is free.
    fn misfit(&self) -> f64 {
        0.5 * dot(&self.off, &self.off) + self.ln_volume
    }

    /// The same tangent with other slack.
    fn slackened(self, record: &Record, slack: Vec<Slack>) -> Self {
        let (ground, applied) = (self.ground(record), self.applied.clone());
        let frame = Frame {
            slack,
            ..self.into_frame()
        };
        Self::on(record, ground, &applied, frame)
    }

    /// The tangent in a known frame, about a hypothesis that has been run.
    fn on(record: &Record, ground: Arc<Incremental>, applied: &[Applied], frame: Frame) -> Self {
        Self {
            ground: OnceLock::from(Arc::clone(&ground)),
            ..Self::with(record, applied, ground.blocks(), frame)
        }
    }

    /// The tangent in a known frame; `blocks` are those under `applied`.
    fn with(record: &Record, applied: &[Applied], blocks: &Blocks, frame: Frame) -> Self {
        let Solved {
            basis,
            off,
            mut beta,
            ln_volume,
            beyond_curves,
        } = Solved::of(record, applied, blocks, &frame);
        let Frame {
            rows,
            mut curves,
            whitening,
            bend,
            slack,
        } = frame;
        let layout = whitening.layout;
        let rest = beta.split_off(FRICTION_TERMS + HEAD_TERMS);
        let (friction, head) = beta.split_at(FRICTION_TERMS);
        curves.friction.copy_from_slice(friction);
        curves.head.copy_from_slice(head);
        let evaluated = Evaluated::of(&curves, blocks, None);
        let residual = evaluated.residual(layout, blocks);
        Self {
            applied: applied.to_vec(),
            ground: OnceLock::new(),
            rows,
            layout,
            whitening,
            curves,
            rest,
            nuisance: beyond_curves,
            basis,
            off,
            residual,
            bend,
            slack,
            ln_volume,
            evaluated,
        }
    }

    /// Blocks in which the pump is on its way to another head.
    pub(crate) fn moving(&self, record: &Record) -> Vec<bool> {
        crate::error_budget::moving(&self.evaluated.head_pa, record.block_s())
    }

    /// The whitened part of a stacked vector off the tangent.
    pub(crate) fn project(&self, stacked: &[f64]) -> Vec<f64> {
        self.off_columns(self.whitened(stacked))
    }

    /// A stacked vector whitened, and how much of it lies along each column.
    fn whitened(&self, stacked: &[f64]) -> Whitened {
        assert!(!self.basis.is_empty(), "its columns were released");
        let values = self.whitening.apply(stacked);
        // Most effects touch one relation: only the columns and rows that meet it cost anything.
        let touched = support(&values);
        let within = &values[touched.clone()];
        let energy = dot(within, within);
        // Columns are orthonormal: the products need not wait for one another.
        let mut shares = products(&self.basis, &values, &touched);
        for share in &mut shares {
            // Written as `!(a > b)`, so that a NaN is set to 0 too.
            if !(share.abs() > 1e-9 * energy.sqrt()) {
                *share = 0.0;
            }
        }
        Whitened {
            values,
            touched,
            energy,
            shares,
        }
    }

    /// What of it lies off the tangent, over the rows of the priors as well.
    fn off_columns(&self, of: Whitened) -> Vec<f64> {
        let mut out = of.values;
        out.resize(self.off.len(), 0.0);
        without(&mut out, &self.basis, &of.shares);
        out
    }

    /// What a hypothesis takes out of the residuals, its energy and its product with what is left over known before it is worked out.
    pub(crate) fn sketch(&self, record: &Record, applied: &[Applied]) -> Sketch<'_> {
        self.sketched(record, &self.change(record, applied))
    }

    /// The same of a change of the stacked residuals.
    fn sketched(&self, record: &Record, change: &[f64]) -> Sketch<'_> {
        let worked_out = |signature: Vec<f64>| Sketch {
            energy: dot(&signature, &signature),
            score: dot(&signature, &self.off),
            tangent: self,
            of: Worked::Out(signature),
        };
        if !record.takes(Step::Projection) {
            return worked_out(self.beyond(record, change));
        }
        let of = self.whitened(change);
        // Off the columns by Pythagoras.
        let energy = of.energy - dot(&of.shares, &of.shares);
        if !(energy > LEFT * of.energy) {
            return worked_out(self.off_columns(of));
        }
        // What is left over is at right angles to the columns.
        let rows = of.touched.clone();
        Sketch {
            energy,
            score: dot(&of.values[rows.clone()], &self.off[rows]),
            tangent: self,
            of: Worked::Later(of),
        }
    }

    /// Inner products of changes of the stacked residuals, whitened and off the tangent, and those with the residual itself.
    pub(crate) fn normal_equations(
        &self,
        record: &Record,
        changes: &[Vec<f64>],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let (gram, mut right) = self.inner_products(record, changes, &[&self.off]);
        (gram, right.swap_remove(0))
    }

    /// The same, with those with each of some vectors that are whitened and off the tangent already.
    pub(crate) fn inner_products(
        &self,
        record: &Record,
        changes: &[Vec<f64>],
        of: &[&[f64]],
    ) -> (DMatrix<f64>, Vec<DVector<f64>>) {
        let whitened: Vec<(Vec<f64>, Reach)> = changes
            .iter()
            .map(|change| {
                let values = self.whitening.apply(change);
                let touched = support(&values);
                (values, touched)
            })
            .collect();
        let within: Vec<Vec<f64>> = whitened
            .iter()
            .map(|(values, touched)| {
                if !record.takes(Step::Projection) {
                    return vec![0.0; self.basis.len()];
                }
                products(&self.basis, values, touched)
            })
            .collect();
        // Off the columns by Pythagoras. Most changes touch one relation, many of them for a while.
        let product = |a: usize, b: (&[f64], &Reach)| {
            let (values, touched) = &whitened[a];
            product_within((values, touched), b)
        };
        let n = changes.len();
        let mut gram = DMatrix::zeros(n, n);
        for (a, (values, touched)) in whitened.iter().enumerate() {
            for b in 0..=a {
                let product = product(b, (values, touched)) - dot(&within[a], &within[b]);
                (gram[(a, b)], gram[(b, a)]) = (product, product);
            }
        }
        let rows = 0..self.layout.len();
        let right = |of: &&[f64]| {
            let of = &of[rows.clone()];
            DVector::from_fn(n, |a, _| product(a, (of, &rows)))
        };
        (gram, of.iter().map(right).collect())
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
        let ground = self.ground(record);
        let blocks = match applied.split_last() {
            Some((one, state)) if alike(state, &self.applied) => ground.with(record, one),
            _ => None,
        };
        self.change_to(&blocks.unwrap_or_else(|| ground.other(record, applied)))
    }

    /// What it takes out of the residuals of these curves that blocks are as they are under another hypothesis.
    pub(crate) fn change_to(&self, blocks: &Blocks) -> Vec<f64> {
        let with = Evaluated::of(&self.curves, blocks, Some(&self.evaluated))
            .residual(self.layout, blocks);
        self.residual
            .iter()
            .zip(&with)
            .map(|(a, b)| a - b)
            .collect()
    }

    /// What a stacked residual leaves of friction and head where mud flows, Pa, by the median over rows that are not excluded.
    ///
    /// A tangent parts what the transmitters show into curve and wander, and mud at rest decides which is which. Where there is no
    /// wander, as in a run, this is the curves'.
    pub(crate) fn flowing_level(&self, residual: &[f64], excluded: &[bool]) -> (f64, f64) {
        let (n, rows) = (self.layout.blocks, &self.rows);
        let level = |from: usize, judged: &dyn Fn(usize) -> bool| {
            let rows = (residual[from..from + n].iter().enumerate())
                .filter(|(b, _)| judged(*b) && !excluded.get(*b).copied().unwrap_or(false))
                .map(|(_, v)| *v);
            quantile(rows, Rank::Nearest(0.5)).unwrap_or(0.0)
        };
        (
            level(0, &|b| rows.friction[b] && !rows.still[b]),
            level(self.layout.rows(Section::Head).start, &|b| rows.head[b]),
        )
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

/// What is free in a frame, solved for.
struct Solved {
    basis: Vec<Column>,
    off: Vec<f64>,
    /// Coefficient of each column, curves first.
    beta: Vec<f64>,
    ln_volume: f64,
    /// Columns of what is no curve.
    beyond_curves: Vec<Arc<Sparse>>,
}

impl Solved {
    /// `blocks` are those under `applied`.
    fn of(record: &Record, applied: &[Applied], blocks: &Blocks, frame: &Frame) -> Self {
        record.tally.fitted();
        let Columns {
            mut whitened,
            beyond_curves,
            means,
            widths,
        } = Columns::of(record, applied, blocks, frame);
        let layout = frame.whitening.layout;
        let (n, total, p) = (layout.blocks, layout.len(), whitened.len());
        // What the path of the meter leaves over of the stops, no curve can take.
        let stops = left_over(&record.stops, &frame.rows.stops, meter_path(applied));
        // Columns that touch little first: they stay short among themselves.
        let mut order: Vec<usize> = (0..p).collect();
        order.sort_by_key(|&a| whitened[a].reach().len());
        let mut basis: Vec<Column> = order
            .iter()
            .map(|&a| {
                let mut priors = vec![0.0; p];
                priors[a] = 1.0 / widths[a];
                (std::mem::take(&mut whitened[a]))
                    .with_rows_behind(stops.len())
                    .with_priors(priors)
            })
            .collect();
        let mut y = vec![0.0; total];
        y[..n].copy_from_slice(&blocks.drop);
        y[n..2 * n].copy_from_slice(&blocks.lift);
        y[layout.rows(Section::Outlets)].copy_from_slice(&blocks.difference);
        y[layout.rows(Section::Balance)].copy_from_slice(&blocks.imbalance);
        let mut off = frame.whitening.apply_whole(&y);
        off.extend(stops);
        off.extend((means.iter().zip(&widths)).map(|(mean, width)| mean / width));
        let triangle = orthonormal(&mut basis);
        let mut right = vec![0.0; p];
        for (q, r) in basis.iter().zip(&mut right) {
            *r = q.dot(&off);
            q.take_from(&mut off, *r);
        }
        let ln_volume = (triangle.iter().zip(&order).enumerate())
            .map(|(k, (row, &a))| (row[k].abs() * widths[a]).ln())
            .sum();
        let mut beta = vec![0.0; p];
        for (value, &a) in back_substitute(&triangle, right).into_iter().zip(&order) {
            beta[a] = value;
        }
        Self {
            basis,
            off,
            beta,
            ln_volume,
            beyond_curves,
        }
    }
}

/// Share of a change's energy off the columns below which too few digits of it are left by subtraction.
const LEFT: f64 = 1e-6;

/// A whitened vector and its products with a tangent's columns.
struct Whitened {
    values: Vec<f64>,
    /// Rows from the first to the last that is not 0.
    touched: Reach,
    energy: f64,
    shares: Vec<f64>,
}

/// A signature of which only the size is known yet: most candidates are weighed and dropped.
pub(crate) struct Sketch<'a> {
    /// Its energy.
    pub energy: f64,
    /// Its product with what is left over.
    pub score: f64,
    tangent: &'a Tangent,
    of: Worked,
}

enum Worked {
    Out(Vec<f64>),
    Later(Whitened),
}

impl Sketch<'_> {
    /// The whole of it.
    pub(crate) fn signature(self) -> Vec<f64> {
        match self.of {
            Worked::Out(signature) => signature,
            Worked::Later(of) => self.tangent.off_columns(of),
        }
    }
}

/// Whether two hypotheses are the same, digit for digit.
pub(crate) fn alike(a: &[Applied], b: &[Applied]) -> bool {
    let bits = |one: &Applied| {
        one.parameters
            .iter()
            .map(|p| p.to_bits())
            .collect::<Vec<_>>()
    };
    let same = |(a, b): (&Applied, &Applied)| a.id() == b.id() && bits(a) == bits(b);
    a.len() == b.len() && a.iter().zip(b).all(same)
}

#[cfg(test)]
mod tests;
