//! Blocked cross-validation inside the training part.
//!
//! A block's readings are left out of the fit and compared with the free run that goes through it: the state at its start
//! is what the run makes of inputs and fitted initial states. Racine, J., *J. Econometrics* 99 (2000); one standard error:
//! Breiman, L. et al., *Classification and Regression Trees* (1984).

use crate::baseline::fresh_jacobian;
use crate::context::{Context, Trial};
use crate::stack::{Data, Runner};
use dgd_lsq::lm::{self, Bounds, Effort};
use nalgebra::DMatrix;

/// What each fold fits and scores.
pub(crate) struct Folds {
    folds: Vec<(Vec<bool>, Vec<usize>)>,
    /// Samples in a block of scores.
    length: usize,
    blocks: usize,
}

/// Squared errors on readings that a fit had not seen.
#[derive(Debug, Clone)]
pub(crate) struct LeftOut {
    /// Sum of squares by block of scores.
    pub blocks: Vec<f64>,
    /// Readings.
    pub count: f64,
    /// Sum of squares and readings of each output, in scaled residuals.
    pub by_output: Vec<(f64, f64)>,
    /// Parameters of each fold.
    pub thetas: Vec<Vec<f64>>,
}

const FOLDS: usize = 5;
/// Blocks of all folds together, at most; each at least as long as the residual's memory.
const BLOCKS: usize = 20;
const SCORES: usize = 24;

impl Folds {
    /// Five folds, each of every fifth block, so that each fit sees every stretch of the record; a relation is also asked
    /// to extrapolate, from its first half onwards.
    ///
    /// `memory`: samples over which the base's residual remembers itself.
    pub(crate) fn new(data: &Data, in_time: bool, memory: usize) -> Self {
        let n = data.samples().max(1);
        let position: Vec<usize> = data.rows.iter().map(|r| data.position(r)).collect();
        // Initial states are not to be found without the first readings.
        let warm = |i: usize| {
            let row = &data.rows[i];
            let length = data.windows[row.window].time.len();
            in_time && row.sample < length.div_ceil(33).max(3)
        };
        let count = (n / memory.max(1)).clamp(FOLDS, BLOCKS);
        let mut folds = Vec::new();
        for f in 0..FOLDS {
            let inside = |i: usize| position[i] * count / n % FOLDS == f && !warm(i);
            let keep = (0..position.len()).map(|i| !inside(i)).collect();
            folds.push((keep, (0..position.len()).filter(|&i| inside(i)).collect()));
        }
        if !in_time {
            for f in 3..6 {
                let inside = |i: usize| position[i] * 6 / n == f;
                let keep = (0..position.len())
                    .map(|i| position[i] * 6 / n < f)
                    .collect();
                folds.push((keep, (0..position.len()).filter(|&i| inside(i)).collect()));
            }
        }
        Self {
            folds,
            length: n.div_ceil(SCORES).max(1),
            blocks: SCORES,
        }
    }

    /// Scores a problem from its minimum over all rows.
    pub(crate) fn score(
        &self,
        data: &Data,
        outputs: usize,
        f: &mut dyn FnMut(&[f64]) -> Option<Vec<f64>>,
        theta: &[f64],
        bounds: &Bounds,
        known: (&[f64], &DMatrix<f64>),
    ) -> LeftOut {
        let mut left = LeftOut {
            blocks: vec![0.0; self.blocks],
            count: 0.0,
            by_output: vec![(0.0, 0.0); outputs],
            thetas: Vec::new(),
        };
        // The fold's minimum is near that of all rows: one Jacobian, updated, will do.
        let effort = Effort {
            steps: 6,
            tolerance: 1e-4,
            fresh: 0,
            ..crate::baseline::SPARING
        };
        for (keep, scored) in &self.folds {
            if scored.is_empty() {
                continue;
            }
            let found = lm::minimise(f, theta, bounds, Some(keep), Some(known), effort);
            for &i in scored {
                let e = found.residuals[i].powi(2);
                left.blocks[(data.position(&data.rows[i]) / self.length).min(self.blocks - 1)] += e;
                left.count += 1.0;
                let by = &mut left.by_output[data.rows[i].output];
                *by = (by.0 + e, by.1 + 1.0);
            }
            left.thetas.push(found.theta);
        }
        left
    }

    /// Scores a fitted set.
    pub(crate) fn of_trial(&self, context: &Context<'_>, trial: &Trial) -> Option<LeftOut> {
        let jacobian = fresh_jacobian(context, trial)?;
        let built = context.build(&trial.members)?;
        let mut runner = Runner::new(&built, context.data, &context.simulation).ok()?;
        let m = &trial.minimum;
        Some(self.score(
            context.data,
            context.scale.len(),
            &mut |t: &[f64]| runner.run(t).map(|s| context.residual(s)),
            &m.theta,
            &trial.bounds,
            (&m.residuals, &jacobian),
        ))
    }
}

impl LeftOut {
    /// Mean square.
    pub(crate) fn mean(&self) -> f64 {
        self.blocks.iter().sum::<f64>() / self.count.max(1.0)
    }

    /// Mean square less that of `other`, with its standard error by blocks.
    pub(crate) fn less(&self, other: &Self) -> (f64, f64) {
        let d: Vec<f64> = self
            .blocks
            .iter()
            .zip(&other.blocks)
            .map(|(a, b)| a - b)
            .collect();
        let b = d.len() as f64;
        let mean = d.iter().sum::<f64>() / b;
        let variance = d.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (b - 1.0);
        let count = self.count.max(1.0);
        (mean * b / count, (b * variance).sqrt() / count)
    }
}
