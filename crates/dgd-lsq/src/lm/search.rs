//! The search itself: what is known at each moment, and what one turn makes of it.

use super::step::{Moved, any_waits, broyden, half_square, normal_equations, promise, step};
use super::{Bounds, Effort, Ending, Minimum, Residuals};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;

/// Damping at the start, relative to the curvature.
const DAMPING: f64 = 1e-3;
/// What an accepted step leaves of the damping, and the least of it.
const EASED: (f64, f64) = (0.3, 1e-9);
/// By what a refused step multiplies the damping.
const STIFFENED: f64 = 8.0;
/// A step shorter than this in every parameter, in shares of its bounds, is none.
const NO_STEP: f64 = 1e-12;
/// In wide bounds a step without damping of less than this share of the parameter, or of 1e-12, is none.
const STILL: f64 = 1e-10;
/// Bounds this many times as far apart as the parameter is large, or as 1, are wide: differences within them tell no slope.
const WIDE: f64 = 1e8;
/// A step that gains less than this share of the cost leads not far: an updated Jacobian is renewed after it.
const NOT_FAR: f64 = 0.02;

/// Where a search stands.
pub(super) struct Search<'a, R: ?Sized> {
    problem: &'a mut R,
    bounds: &'a Bounds,
    keep: Option<&'a [bool]>,
    effort: Effort,
    theta: Vec<f64>,
    residuals: Vec<f64>,
    jacobian: DMatrix<f64>,
    /// Steps accepted on this Jacobian.
    age: usize,
    /// Jacobians asked for.
    fresh: usize,
    damping: f64,
    /// Which parameters are moved.
    which: Moved,
    /// Steps tried.
    done: usize,
    /// Gains below the tolerance, in a row.
    small: usize,
    /// Steps refused, in a row.
    refused: usize,
    /// Whether a step was accepted.
    gained: bool,
    /// Share of the cost that the last undamped model promised.
    promised: f64,
}

impl<'a, R: Residuals + ?Sized> Search<'a, R> {
    /// At the start; where there are no residuals or no Jacobian, what there is, as the end.
    pub(super) fn begin(
        problem: &'a mut R,
        start: &[f64],
        bounds: &'a Bounds,
        keep: Option<&'a [bool]>,
        known: Option<(&[f64], &DMatrix<f64>)>,
        effort: Effort,
    ) -> Result<Self, Box<Minimum>> {
        let nowhere = |theta, ending| Minimum {
            theta,
            residuals: Vec::new(),
            cost: f64::INFINITY,
            jacobian: DMatrix::zeros(0, start.len()),
            steps: 0,
            ending,
        };
        let mut theta = start.to_vec();
        if theta.len() != bounds.low.len() || theta.iter().any(|t| t.is_nan()) {
            return Err(Box::new(nowhere(theta, Ending::NoStart)));
        }
        bounds.clamp(&mut theta);
        let residuals = match known {
            Some((r, _)) => Some(r.to_vec()),
            None => problem.at(&theta),
        };
        let Some(residuals) = residuals else {
            return Err(Box::new(nowhere(theta, Ending::NoStart)));
        };
        let jacobian = match known {
            Some((_, j)) => Some(j.clone()),
            None => problem.jacobian(&theta, &residuals, bounds),
        };
        let Some(jacobian) = jacobian else {
            let weights = problem.weights(&residuals);
            return Err(Box::new(Minimum {
                cost: half_square(&residuals, keep, weights.as_deref()),
                residuals,
                ..nowhere(theta, Ending::NoProgress)
            }));
        };
        Ok(Self {
            problem,
            bounds,
            keep,
            effort,
            theta,
            residuals,
            jacobian,
            age: 0,
            fresh: usize::from(known.is_none()),
            damping: DAMPING,
            which: Moved::Plain,
            done: 0,
            small: 0,
            refused: 0,
            gained: false,
            promised: 0.0,
        })
    }

    /// Turns until one ends it.
    pub(super) fn run(&mut self) -> Ending {
        while self.done < self.effort.steps {
            if let ControlFlow::Break(ending) = self.turn()
                && !(ending == Ending::Converged && self.release())
            {
                return ending;
            }
        }
        Ending::StepLimit
    }

    /// Moves the parameters too that waited for the others, if that promises anything; says whether it does.
    fn release(&mut self) -> bool {
        let weights = self.problem.weights(&self.residuals);
        let weights = weights.as_deref();
        let cost = half_square(&self.residuals, self.keep, weights);
        if self.which == Moved::All || cost <= 0.0 {
            return false;
        }
        let (normal, gradient) =
            normal_equations(&self.jacobian, &self.residuals, self.keep, weights);
        if !any_waits(&normal) {
            return false;
        }
        self.which = Moved::All;
        let free = self.step(&normal, &gradient, EASED.1);
        let promised = free.map_or(0.0, |free| promise(&normal, &gradient, &free) / cost);
        (self.damping, self.small, self.refused) = (DAMPING, 0, 0);
        promised >= self.effort.tolerance
    }

    /// The damped step in shares of the bounds.
    fn step(
        &self,
        normal: &DMatrix<f64>,
        gradient: &DVector<f64>,
        damping: f64,
    ) -> Option<Vec<f64>> {
        step(
            normal,
            gradient,
            &self.theta,
            self.bounds,
            damping,
            self.which,
        )
    }

    /// What was found.
    pub(super) fn minimum(self, ending: Ending) -> Minimum {
        let weights = self.problem.weights(&self.residuals);
        Minimum {
            cost: half_square(&self.residuals, self.keep, weights.as_deref()),
            theta: self.theta,
            residuals: self.residuals,
            jacobian: self.jacobian,
            steps: self.done,
            ending,
        }
    }

    /// One step tried, accepted or refused.
    fn turn(&mut self) -> ControlFlow<Ending> {
        // A robust loss weighs anew at each step; within it costs are compared by the same weights.
        let weights = self.problem.weights(&self.residuals);
        let weights = weights.as_deref();
        let cost = half_square(&self.residuals, self.keep, weights);
        if !cost.is_finite() {
            return ControlFlow::Break(Ending::NoStart);
        }
        if self.theta.is_empty() || cost <= 0.0 {
            return ControlFlow::Break(Ending::Converged);
        }
        self.done += 1;
        let (normal, gradient) =
            normal_equations(&self.jacobian, &self.residuals, self.keep, weights);
        // A Jacobian with a NaN leads nowhere.
        let Some(trial) = self.trial(&normal, &gradient) else {
            return ControlFlow::Break(Ending::NoProgress);
        };
        let moved: Vec<f64> = (0..trial.len())
            .map(|i| (trial[i] - self.theta[i]) / self.bounds.span(i))
            .collect();
        if self.refused == 0 {
            self.promised = self.promise(&normal, &gradient, &moved) / cost;
        }
        if self.is_none(&moved) {
            // Damping makes any step small.
            return ControlFlow::Break(if self.refused == 0 {
                Ending::Converged
            } else {
                self.given_up()
            });
        }
        let there = self.problem.at(&trial);
        let lower = there
            .filter(|there| there.len() == self.residuals.len())
            .map(|there| (half_square(&there, self.keep, weights), there))
            .filter(|(new, _)| *new < cost);
        match lower {
            Some((new, there)) => self.accept(trial, there, &moved, (cost - new) / cost),
            // The fault may be the old Jacobian's.
            None if self.age > 0 && self.fresh < self.effort.fresh => self.renew(),
            None => self.refuse(),
        }
    }

    /// Whether a step, in shares of the bounds, is too short to try; in wide bounds any step may be short, and is none if it is worth nothing.
    fn is_none(&self, moved: &[f64]) -> bool {
        moved.iter().all(|d| d.abs() < NO_STEP) && !self.is_doubtful()
    }

    /// Whether a step, in shares of the bounds, is short beside the parameters.
    fn is_still(&self, moved: &[f64]) -> bool {
        let mut steps = moved.iter().zip(&self.theta).enumerate();
        steps.all(|(i, (d, t))| (d * self.bounds.span(i)).abs() <= NO_STEP.max(STILL * t.abs()))
    }

    /// Whether the bounds are so wide that slopes may be wrong.
    fn is_wide(&self) -> bool {
        let mut spans = self.theta.iter().enumerate();
        spans.any(|(i, t)| self.bounds.span(i) > WIDE * t.abs().max(1.0))
    }

    /// What the cost would fall by along the step; in wide bounds along that without damping, which makes any promise small there.
    fn promise(&self, normal: &DMatrix<f64>, gradient: &DVector<f64>, moved: &[f64]) -> f64 {
        if !self.is_wide() {
            return promise(normal, gradient, moved);
        }
        match self.step(normal, gradient, EASED.1) {
            Some(free) if self.is_still(&free) => 0.0,
            Some(free) => promise(normal, gradient, &free),
            None => promise(normal, gradient, moved),
        }
    }

    /// Where the damped step leads, within the bounds; `None` if its equations have no solution.
    fn trial(&self, normal: &DMatrix<f64>, gradient: &DVector<f64>) -> Option<Vec<f64>> {
        let moved = self.step(normal, gradient, self.damping)?;
        let mut trial = self.theta.clone();
        for (i, moved) in moved.iter().enumerate() {
            trial[i] += moved * self.bounds.span(i);
        }
        self.bounds.clamp(&mut trial);
        (!trial.iter().any(|t| t.is_nan())).then_some(trial)
    }

    fn accept(
        &mut self,
        trial: Vec<f64>,
        there: Vec<f64>,
        moved: &[f64],
        gain: f64,
    ) -> ControlFlow<Ending> {
        broyden(&mut self.jacobian, moved, &self.residuals, &there);
        (self.theta, self.residuals) = (trial, there);
        (self.age, self.refused, self.gained) = (self.age + 1, 0, true);
        self.damping = (self.damping * EASED.0).max(EASED.1);
        if gain < self.effort.tolerance {
            self.small += 1;
        } else {
            self.small = 0;
        }
        if self.small >= 2 && !self.is_doubtful() {
            return ControlFlow::Break(Ending::Converged);
        }
        // Several steps on one; more only while they lead far.
        let due = self.age > self.effort.stale || gain < NOT_FAR;
        if due && self.fresh < self.effort.fresh && self.done < self.effort.steps {
            return self.renew();
        }
        ControlFlow::Continue(())
    }

    fn refuse(&mut self) -> ControlFlow<Ending> {
        self.refused += 1;
        self.damping *= STIFFENED;
        if self.refused > self.effort.patience {
            return ControlFlow::Break(self.given_up());
        }
        ControlFlow::Continue(())
    }

    /// A fresh Jacobian.
    fn renew(&mut self) -> ControlFlow<Ending> {
        let there = (&self.theta, &self.residuals);
        let Some(jacobian) = self.problem.jacobian(there.0, there.1, self.bounds) else {
            return ControlFlow::Break(Ending::NoProgress);
        };
        (self.jacobian, self.age, self.fresh) = (jacobian, 0, self.fresh + 1);
        ControlFlow::Continue(())
    }

    /// Whether more is promised than was gained, in bounds so wide that slopes may be wrong.
    fn is_doubtful(&self) -> bool {
        self.promised >= self.effort.tolerance && self.is_wide()
    }

    /// Where no step is accepted it is flat as far as the residuals can tell, if one was before or none was worth taking.
    fn given_up(&self) -> Ending {
        if self.gained && !self.is_doubtful() || self.promised < self.effort.tolerance {
            Ending::Converged
        } else {
            Ending::NoProgress
        }
    }
}
