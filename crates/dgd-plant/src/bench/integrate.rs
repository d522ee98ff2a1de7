//! The classical Runge-Kutta method with fixed steps.

/// One step of the classical Runge-Kutta method of fourth order.
///
/// `rates` gives the time derivative of `y` at a time in s; `y` is the state at `at_s`, the result that at `at_s + step_s`.
///
/// # Source
/// W. Kutta (1901), *Z. Math. Phys.* 46:435.
pub fn rk4<const N: usize>(
    y: &[f64; N],
    at_s: f64,
    step_s: f64,
    mut rates: impl FnMut(f64, &[f64; N]) -> [f64; N],
) -> [f64; N] {
    let ahead = |k: &[f64; N], part: f64| std::array::from_fn(|i| y[i] + part * step_s * k[i]);
    let k1 = rates(at_s, y);
    let k2 = rates(at_s + 0.5 * step_s, &ahead(&k1, 0.5));
    let k3 = rates(at_s + 0.5 * step_s, &ahead(&k2, 0.5));
    let k4 = rates(at_s + step_s, &ahead(&k3, 1.0));
    std::array::from_fn(|i| y[i] + step_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}
