//! Steinebach's RODASP: a stiffly accurate Rosenbrock method of order 4(3), L-stable.
//!
//! Coefficients: Steinebach, G. (1995), "Order-reduction of ROW-methods for DAEs and method of
//! lines applications", Preprint 1741, TH Darmstadt; in the form of Hairer and Wanner (1996),
//! IV.7, where `U` replaces the stages so that no product with the Jacobian is needed:
//! `(I/(hγ) − J)·U_i = f(t + α_i·h, x + Σ a_ij·U_j) + Σ (c_ij/h)·U_j + h·d_i·∂f/∂t`.

use super::driver::Stepper;
use super::vector::{Vector, lu_factor, lu_solve};
use super::{Linearised, Statistics, System};

const GAMMA: f64 = 0.25;
const ALPHA: [f64; 6] = [0.0, 0.75, 0.21, 0.63, 1.0, 1.0];
const DRIFT: [f64; 6] = [0.25, -0.5, -0.023_504, -0.0362, 0.0, 0.0];
const A: [[f64; 4]; 5] = [
    [0.0, 0.0, 0.0, 0.0],
    [3.0, 0.0, 0.0, 0.0],
    [1.831_036_793_486_759, 0.495_518_396_743_379_5, 0.0, 0.0],
    [
        2.304_376_582_692_669,
        -0.052_492_752_457_430_01,
        -1.176_798_761_832_782,
        0.0,
    ],
    [
        -7.170_454_962_423_024,
        -4.741_636_671_481_785,
        -16.310_026_313_309_71,
        -1.062_004_044_111_401,
    ],
];
const C: [[f64; 5]; 6] = [
    [0.0, 0.0, 0.0, 0.0, 0.0],
    [-12.0, 0.0, 0.0, 0.0, 0.0],
    [
        -8.791_795_173_947_035,
        -2.207_865_586_973_518,
        0.0,
        0.0,
        0.0,
    ],
    [
        10.817_930_568_571_53,
        6.780_270_611_428_266,
        19.534_859_446_424_1,
        0.0,
        0.0,
    ],
    [
        34.190_950_067_496_76,
        15.496_711_537_259_63,
        54.747_608_759_641_3,
        14.160_053_921_485_34,
        0.0,
    ],
    [
        34.626_058_309_305_32,
        15.300_849_761_144_73,
        56.999_555_786_626_67,
        18.408_070_097_930_95,
        -5.714_285_714_285_717,
    ],
];
/// Dense output of order 3.
const H: [[f64; 5]; 2] = [
    [
        25.098_767_037_085_89,
        11.620_131_043_618_67,
        28.491_483_077_146_26,
        -5.664_021_568_594_133,
        0.0,
    ],
    [
        1.638_054_557_396_973,
        -0.737_361_980_667_874_8,
        8.477_918_219_238_99,
        15.992_531_487_795_2,
        -1.882_352_941_176_471,
    ],
];

pub(crate) struct Rodas<V: Vector> {
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
}

impl<V: Vector> Rodas<V> {
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

impl<V: Vector> Rodas<V> {
    /// Solves for one stage. `K` is a constant so that the sums unroll.
    #[inline(always)]
    fn stage<const K: usize, S: System + ?Sized>(&mut self, p: &Point<'_, S, V>) {
        let n = p.x.get().len();
        let (before, from) = self.u.split_at_mut(K);
        let u = &mut from[0];
        if K == 0 {
            u.get_mut().copy_from_slice(self.rate.get());
        } else {
            for i in 0..n {
                // Stage 6 builds on stage 5: a_6j = a_5j and a_65 = 1. What is small is added up first: what a
                // step adds to the state, which is large, rounds once.
                let moved = if K < 5 {
                    let first = A[K][0] * before[0].get()[i];
                    (1..K).fold(first, |sum, j| sum + A[K][j] * before[j].get()[i])
                } else {
                    self.moved.get()[i] + before[4].get()[i]
                };
                self.moved.get_mut()[i] = moved;
                self.stage.get_mut()[i] = p.x.get()[i] + moved;
            }
            p.system
                .rhs(p.t + ALPHA[K] * p.h, self.stage.get(), u.get_mut());
        }
        for i in 0..n {
            let sum = (0..K).fold(0.0, |sum, j| sum + C[K][j] * before[j].get()[i]);
            u.get_mut()[i] += sum * p.inverse + p.h * DRIFT[K] * self.drift.get()[i];
        }
        let (factors, rows) = (V::flat(&self.factors), V::index(&self.rows));
        lu_solve(factors, rows, u.get_mut(), n);
    }
}

impl<V: Vector> Stepper<V> for Rodas<V> {
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
        for i in 0..n {
            factors[i * n + i] += inverse / GAMMA;
        }
        count.factorisations += 1;
        if !lu_factor(factors, V::index_mut(&mut self.rows), n) {
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
        self.stage::<4, S>(&point);
        self.stage::<5, S>(&point);
        count.rhs += 5;
        for i in 0..n {
            let last = self.u[5].get()[i];
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
        let rest = 1.0 - theta;
        for (i, out) in out.iter_mut().enumerate() {
            let [second, third] =
                H.map(|row| (0..5).map(|s| row[s] * self.u[s].get()[i]).sum::<f64>());
            // In this form a state at rest stays at rest to the last bit.
            let from = x.get()[i];
            *out = from + theta * (next.get()[i] - from + rest * (second + theta * third));
        }
    }

    #[inline(always)]
    fn factor(error: f64, _previous: f64) -> f64 {
        // The fourth root: the estimate is of third order.
        (0.9 / error.max(1e-10).sqrt().sqrt()).clamp(0.2, 6.0)
    }
}
