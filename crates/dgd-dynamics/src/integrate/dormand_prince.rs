//! Dormand and Prince's explicit 5(4) pair (Hairer, Nørsett and Wanner 1993, II.5).

use super::driver::Stepper;
use super::vector::Vector;
use super::{Statistics, System};

const C: [f64; 6] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
const A: [[f64; 5]; 6] = [
    [0.0, 0.0, 0.0, 0.0, 0.0],
    [0.2, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
    ],
];
/// Fifth-order weights.
const B: [f64; 6] = [
    35.0 / 384.0,
    0.0,
    500.0 / 1113.0,
    125.0 / 192.0,
    -2187.0 / 6784.0,
    11.0 / 84.0,
];
/// Fifth minus fourth order.
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];
/// Shampine's dense output of order 4, in the form of DOPRI5.
const D: [f64; 7] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];
/// Exponent of the last step's error in the PI controller (Hairer and Wanner 1996, IV.2).
const BETA: f64 = 0.04;

pub(crate) struct DormandPrince<V> {
    k: [V; 7],
    stage: V,
    known: bool,
}

impl<V: Vector> DormandPrince<V> {
    pub(super) fn new(n: usize) -> Self {
        Self {
            k: std::array::from_fn(|_| V::zeros(n)),
            stage: V::zeros(n),
            known: false,
        }
    }
}

impl<V: Vector> Stepper<V> for DormandPrince<V> {
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
            system.rhs(t, x.get(), self.k[0].get_mut());
            count.rhs += 1;
            self.known = true;
        }
        for s in 1..6 {
            for i in 0..n {
                let mut sum = 0.0;
                for (j, k) in self.k[..s].iter().enumerate() {
                    sum += A[s][j] * k.get()[i];
                }
                self.stage.get_mut()[i] = x.get()[i] + h * sum;
            }
            system.rhs(t + C[s] * h, self.stage.get(), self.k[s].get_mut());
        }
        for i in 0..n {
            let sum: f64 = (0..6).map(|s| B[s] * self.k[s].get()[i]).sum();
            next.get_mut()[i] = x.get()[i] + h * sum;
        }
        system.rhs(t + h, next.get(), self.k[6].get_mut());
        count.rhs += 6;
        for i in 0..n {
            let sum: f64 = (0..7).map(|s| E[s] * self.k[s].get()[i]).sum();
            error.get_mut()[i] = h * sum;
        }
        true
    }

    #[inline(always)]
    fn accept(&mut self) {
        // First same as last; a restart at a break makes it unknown again.
        self.k.swap(0, 6);
    }

    fn dense(&self, theta: f64, h: f64, x: &V, next: &V, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let (from, to) = (x.get()[i], next.get()[i]);
            let change = to - from;
            let start = h * self.k[0].get()[i] - change;
            let end = change - h * self.k[6].get()[i] - start;
            let top: f64 = h * (0..7).map(|s| D[s] * self.k[s].get()[i]).sum::<f64>();
            let rest = 1.0 - theta;
            *out = from + theta * (change + rest * (start + theta * (end + rest * top)));
        }
    }

    #[inline(always)]
    fn factor(error: f64, previous: f64) -> f64 {
        let e = error.max(1e-10);
        (0.9 * e.powf(-(0.2 - 0.75 * BETA)) * previous.powf(BETA)).clamp(0.2, 10.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{A, B, C, D, E};

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-14, "{found} for {expected}");
    }

    #[test]
    fn each_stage_stands_where_its_weights_add_up_to() {
        for s in 0..6 {
            close(A[s].iter().sum(), C[s]);
        }
        // From the third on, a rate that grows with time is followed too.
        for s in 2..6 {
            close((0..5).map(|j| A[s][j] * C[j]).sum(), 0.5 * C[s] * C[s]);
        }
    }

    #[test]
    fn the_weights_meet_the_conditions_of_order_five() {
        for (power, divisor) in [(0, 1.0), (1, 2.0), (2, 3.0), (3, 4.0), (4, 5.0)] {
            close((0..6).map(|s| B[s] * C[s].powi(power)).sum(), 1.0 / divisor);
        }
        for j in 0..5 {
            close((0..6).map(|s| B[s] * A[s][j]).sum(), B[j] * (1.0 - C[j]));
        }
        let inner = |s: usize| (0..5).map(|j| A[s][j] * C[j] * C[j]).sum::<f64>();
        close((0..6).map(|s| B[s] * C[s] * inner(s)).sum(), 1.0 / 15.0);
    }

    #[test]
    fn error_and_dense_output_take_nothing_from_what_the_fourth_order_follows() {
        let node = |s: usize| if s < 6 { C[s] } else { 1.0 };
        for power in 0..4 {
            close((0..7).map(|s| E[s] * node(s).powi(power)).sum(), 0.0);
        }
        close(D.iter().sum(), 0.0);
    }
}
