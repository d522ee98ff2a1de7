//! Rosenbrock methods: linearly implicit, one factorisation a step.
//!
//! In the form of Hairer and Wanner (1996), IV.7, where `U` replaces the stages so that no product with the Jacobian is
//! needed: `(I/(hγ) − J)·U_i = f(t + α_i·h, x + Σ a_ij·U_j) + Σ (c_ij/h)·U_j + h·d_i·∂f/∂t`.

use super::driver::{Step, Stepper};
use super::vector::{Vector, lu_factor, lu_solve};
use super::{Linearised, Statistics, System};
use std::marker::PhantomData;

/// A method of up to six stages, of which the last builds on the one before it (`a_sj = a_(s−1)j`, `a_s(s−1) = 1`), is the
/// estimate of the error, and ends the step.
pub(crate) trait Tableau {
    const STAGES: usize;
    const GAMMA: f64;
    const ALPHA: [f64; 6];
    /// `d_i`.
    const DRIFT: [f64; 6];
    /// `a_ij` of all stages but the last.
    const A: [[f64; 4]; 5];
    const C: [[f64; 5]; 6];
    /// Dense output: `x(θ) = x + θ·(x₁ − x + (1 − θ)·Σ (h_1j + θ·h_2j)·U_j)`.
    const H: [[f64; 5]; 2];

    /// By which factor a step is too long whose scaled error is `error`.
    fn root(error: f64) -> f64;
}

pub(crate) struct Rosenbrock<V: Vector, T> {
    u: [V; 6],
    rate: V,
    drift: V,
    /// How far the stage lies off the step's start.
    moved: V,
    stage: V,
    jacobian: V::Square,
    factors: V::Square,
    rows: V::Rows,
    known: bool,
    tableau: PhantomData<T>,
}

impl<V: Vector, T: Tableau> Rosenbrock<V, T> {
    pub(super) fn new(n: usize) -> Self {
        Self {
            u: std::array::from_fn(|_| V::zeros(n)),
            rate: V::zeros(n),
            drift: V::zeros(n),
            moved: V::zeros(n),
            stage: V::zeros(n),
            jacobian: V::square(n),
            factors: V::square(n),
            rows: V::rows(n),
            known: false,
            tableau: PhantomData,
        }
    }
}

/// Where a step starts.
struct Point<'a, S: ?Sized, V> {
    system: &'a S,
    t: f64,
    x: &'a V,
    h: f64,
    inverse: f64,
}

impl<V: Vector, T: Tableau> Rosenbrock<V, T> {
    /// Whether a stage evaluates where the step starts, which is known already.
    #[inline(always)]
    const fn is_at_start(k: usize) -> bool {
        T::ALPHA[k] == 0.0 && T::A[k][0] == 0.0
    }

    /// Solves for one stage. `K` is a constant so that the sums unroll.
    #[inline(always)]
    fn stage<const K: usize, S: System + ?Sized>(&mut self, p: &Point<'_, S, V>) {
        let n = p.x.get().len();
        let (before, from) = self.u.split_at_mut(K);
        let u = &mut from[0];
        let last = K + 1 == T::STAGES;
        if !last && Self::is_at_start(K) {
            u.get_mut().copy_from_slice(self.rate.get());
        } else {
            for i in 0..n {
                // What is small is added up first: what a step adds to the state, which is large, rounds once.
                let moved = if last {
                    self.moved.get()[i] + before[K - 1].get()[i]
                } else {
                    weighted::<K, V>(&T::A[K], before, i)
                };
                self.moved.get_mut()[i] = moved;
                self.stage.get_mut()[i] = p.x.get()[i] + moved;
            }
            p.system
                .rhs(p.t + T::ALPHA[K] * p.h, self.stage.get(), u.get_mut());
        }
        for i in 0..n {
            let sum = weighted::<K, V>(&T::C[K], before, i);
            u.get_mut()[i] += sum * p.inverse + p.h * T::DRIFT[K] * self.drift.get()[i];
        }
        let (factors, rows) = (V::flat(&self.factors), V::index(&self.rows));
        lu_solve(factors, rows, u.get_mut(), n);
    }
}

/// `Σ weights[j]·stages[j]` of a state over the first `K`; what is weighed by naught costs nothing.
#[inline(always)]
fn weighted<const K: usize, V: Vector>(weights: &[f64], stages: &[V], state: usize) -> f64 {
    let mut sum = 0.0;
    for j in 0..K {
        if weights[j] != 0.0 {
            sum += weights[j] * stages[j].get()[state];
        }
    }
    sum
}

impl<V: Vector, T: Tableau> Rosenbrock<V, T> {
    /// What bends the continuous extension of a state: the sums of [`Tableau::H`].
    #[inline(always)]
    fn bends(&self, state: usize) -> [f64; 2] {
        T::H.map(|row| weighted::<5, V>(&row, &self.u, state))
    }
}

/// A state at the fraction `theta` of a step, in a form in which one at rest stays at rest to the last bit.
#[inline(always)]
fn between(theta: f64, from: f64, to: f64, [second, third]: [f64; 2]) -> f64 {
    from + theta * (to - from + (1.0 - theta) * (second + theta * third))
}

impl<V: Vector, T: Tableau> Stepper<V> for Rosenbrock<V, T> {
    #[inline(always)]
    fn restart(&mut self) {
        self.known = false;
    }

    #[inline(always)]
    fn attempt<S: System + ?Sized>(
        &mut self,
        system: &S,
        t: f64,
        x: &V,
        h: f64,
        next: &mut V,
        error: &mut V,
        count: &mut Statistics,
    ) -> bool {
        let n = x.get().len();
        if !self.known {
            count.rhs += system.linearise(
                t,
                x.get(),
                h,
                Linearised {
                    rate: self.rate.get_mut(),
                    jacobian: V::flat_mut(&mut self.jacobian),
                    drift: self.drift.get_mut(),
                },
            );
            count.jacobians += 1;
            self.known = true;
        }
        let inverse = 1.0 / h;
        let factors = V::flat_mut(&mut self.factors);
        for (f, j) in factors.iter_mut().zip(V::flat(&self.jacobian)) {
            *f = -j;
        }
        let mut trace = 0.0;
        for i in 0..n {
            factors[i * n + i] += inverse / T::GAMMA;
            trace += factors[i * n + i];
        }
        count.factorisations += 1;
        // Below 0 the step outruns what grows by itself: it would pass beyond an infinity as if there were none. Where two things grow, the
        // determinant is above 0 again, but not the trace.
        if trace <= 0.0 || lu_factor(factors, V::index_mut(&mut self.rows), n) <= 0.0 {
            return false;
        }
        let point = Point {
            system,
            t,
            x,
            h,
            inverse,
        };
        self.stage::<0, S>(&point);
        self.stage::<1, S>(&point);
        self.stage::<2, S>(&point);
        self.stage::<3, S>(&point);
        if T::STAGES == 6 {
            self.stage::<4, S>(&point);
            self.stage::<5, S>(&point);
        }
        count.rhs += (0..T::STAGES - 1)
            .filter(|&k| !Self::is_at_start(k))
            .count()
            + 1;
        for i in 0..n {
            let last = self.u[T::STAGES - 1].get()[i];
            next.get_mut()[i] = x.get()[i] + (self.moved.get()[i] + last);
            error.get_mut()[i] = last;
        }
        true
    }

    #[inline(always)]
    fn accept(&mut self) {
        self.known = false;
    }

    fn dense(&self, theta: f64, _h: f64, x: &V, next: &V, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = between(theta, x.get()[i], next.get()[i], self.bends(i));
        }
    }

    /// By what the rate there differs from the slope of the extension, solved for as a stage is: of a mode much faster than the step that is how far
    /// the extension is off, and of a slow one what that adds over the step.
    fn strays<S: System + ?Sized>(
        &mut self,
        system: &S,
        theta: f64,
        step: &Step<'_, V>,
        error: &mut V,
        count: &mut Statistics,
    ) -> bool {
        let (from, to) = (step.x.get(), step.next.get());
        for i in 0..from.len() {
            self.stage.get_mut()[i] = between(theta, from[i], to[i], self.bends(i));
        }
        let error = error.get_mut();
        system.rhs(step.t + theta * step.h, self.stage.get(), error);
        count.rhs += 1;
        for (i, error) in error.iter_mut().enumerate() {
            let [second, third] = self.bends(i);
            let moved = to[i] - from[i]
                + (1.0 - 2.0 * theta) * second
                + theta * (2.0 - 3.0 * theta) * third;
            *error -= moved / step.h;
        }
        let (factors, rows) = (V::flat(&self.factors), V::index(&self.rows));
        lu_solve(factors, rows, error, from.len());
        true
    }

    #[inline(always)]
    fn factor(error: f64, _previous: f64) -> f64 {
        (0.9 / T::root(error.max(1e-10))).clamp(0.2, 6.0)
    }
}
