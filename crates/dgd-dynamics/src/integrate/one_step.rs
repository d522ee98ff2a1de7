//! One step of each method by itself: what its tableau promises.

use super::dormand_prince::DormandPrince;
use super::driver::Stepper;
use super::rosenbrock::{Rosenbrock, Tableau};
use super::tableaus::{Rodas3, Rodasp};
use super::{Statistics, System};

/// `dx/dt = p·t^(p−1)`: the solution is `t^p`.
struct Power(i32);

impl Power {
    fn at(&self, t: f64) -> f64 {
        t.powi(self.0)
    }
}

impl System for Power {
    fn dimension(&self) -> usize {
        1
    }
    fn rhs(&self, t: f64, _: &[f64], rate: &mut [f64]) {
        rate[0] = f64::from(self.0) * t.powi(self.0 - 1);
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], jacobian: &mut [f64]) -> usize {
        jacobian[0] = 0.0;
        0
    }
    fn time_derivative(&self, t: f64, _: &[f64], _: &[f64], _: f64, drift: &mut [f64]) -> usize {
        drift[0] = f64::from(self.0 * (self.0 - 1)) * t.powi(self.0 - 2);
        0
    }
}

/// `dx/dt = x`.
struct Growth;

impl System for Growth {
    fn dimension(&self) -> usize {
        1
    }
    fn rhs(&self, _: f64, x: &[f64], rate: &mut [f64]) {
        rate[0] = x[0];
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &[f64], jacobian: &mut [f64]) -> usize {
        jacobian[0] = 1.0;
        0
    }
    fn time_derivative(&self, _: f64, _: &[f64], _: &[f64], _: f64, drift: &mut [f64]) -> usize {
        drift[0] = 0.0;
        0
    }
}

/// End, error estimate and the state at a third and two thirds of one step.
fn step<M: Stepper<[f64; 1]>>(mut method: M, s: &impl System, t: f64, x: f64, h: f64) -> [f64; 4] {
    let (mut next, mut error) = ([0.0], [0.0]);
    let mut count = Statistics::default();
    assert!(method.attempt(s, t, &[x], h, &mut next, &mut error, &mut count));
    let dense = [1.0 / 3.0, 2.0 / 3.0].map(|theta| {
        let mut out = [0.0];
        method.dense(theta, h, &[x], &next, &mut out);
        out[0]
    });
    [next[0], error[0], dense[0], dense[1]]
}

fn explicit<S: System>(s: &S, t: f64, x: f64, h: f64) -> [f64; 4] {
    step(DormandPrince::<[f64; 1]>::new(1), s, t, x, h)
}

fn rosenbrock<T: Tableau>(s: &impl System, t: f64, x: f64, h: f64) -> [f64; 4] {
    step(Rosenbrock::<[f64; 1], T>::new(1), s, t, x, h)
}

/// How far end, error estimate and dense output of `t^p` are off over 0.3 to 1 s.
fn off(of: impl Fn(&Power, f64, f64, f64) -> [f64; 4], p: i32) -> [f64; 3] {
    let (power, t, h) = (Power(p), 0.3, 0.7);
    let [next, error, low, high] = of(&power, t, power.at(t), h);
    let between = [(low, t + h / 3.0), (high, t + h / 1.5)].map(|(x, t)| (x - power.at(t)).abs());
    let end = (next - power.at(t + h)).abs();
    [end, error.abs(), between[0].max(between[1])]
}

#[test]
fn polynomials_up_to_the_order_are_followed_to_round_off_and_the_next_is_not() {
    // Of the step, of the method that estimates its error, and of the dense output.
    let orders = [5, 4, 4];
    for p in 1..=6 {
        for (off, order) in off(explicit, p).into_iter().zip(orders) {
            assert_eq!(off < 1e-14, p <= order, "Dormand-Prince, t^{p}: {off:e}");
        }
    }
    let orders = [4, 3, 3];
    for p in 1..=5 {
        for (off, order) in off(rosenbrock::<Rodasp>, p).into_iter().zip(orders) {
            assert_eq!(off < 1e-13, p <= order, "RODASP, t^{p}: {off:e}");
        }
    }
    // Its dense output follows the cube too, which depends on time alone.
    let orders = [3, 2, 3];
    for p in 1..=4 {
        for (off, order) in off(rosenbrock::<Rodas3>, p).into_iter().zip(orders) {
            assert_eq!(off < 1e-13, p <= order, "RODAS3, t^{p}: {off:e}");
        }
    }
}

#[test]
fn growth_is_the_series_of_the_exponential_up_to_the_order() {
    for z in [-0.8_f64, 0.3, 1.0] {
        let series: f64 = 1.0
            + z * (1.0
                + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0 * (1.0 + z / 5.0 * (1.0 + z / 5.0)))));
        // Its sixth term is z⁶/600 (Hairer, Nørsett and Wanner 1993, II.5).
        assert!((explicit(&Growth, 0.0, 1.0, z)[0] - series).abs() < 1e-14);
    }
    // A step of order p is off by h^(p+1), and so is what dense output of order p − 1 adds to it.
    let falls = |off: &dyn Fn(f64) -> f64, by: f64| {
        let order = (off(0.1) / off(0.05)).log2();
        assert!((order - by).abs() < 0.2, "{order}, not {by}");
    };
    let third = |z: f64| (z / 3.0).exp();
    let rodasp = |z| rosenbrock::<Rodasp>(&Growth, 0.0, 1.0, z);
    falls(&|z| (rodasp(z)[0] - z.exp()).abs(), 5.0);
    falls(&|z| (rodasp(z)[2] - third(z)).abs(), 4.0);
    let rodas3 = |z| rosenbrock::<Rodas3>(&Growth, 0.0, 1.0, z);
    falls(&|z| (rodas3(z)[0] - z.exp()).abs(), 4.0);
    falls(&|z| (rodas3(z)[2] - third(z)).abs(), 3.0);
}
