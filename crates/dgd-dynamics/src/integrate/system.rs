//! What the integrators ask of a model.

/// A model `dx/dt = f(t, x)`, piecewise smooth in `t`.
///
/// Only [`dimension`](Self::dimension) and [`rhs`](Self::rhs) are required. The integrator never
/// calls [`rhs`](Self::rhs) outside the segment last announced by
/// [`begin_segment`](Self::begin_segment), so a model may look its inputs up once there and treat
/// them as smooth: values at a jump are the limits from inside the segment.
pub trait System {
    /// Number of states.
    fn dimension(&self) -> usize;

    /// Writes `f(t, x)` to `rate`. Both slices have [`dimension`](Self::dimension) entries.
    fn rhs(&self, t: f64, x: &[f64], rate: &mut [f64]);

    /// Writes `∂f_i/∂x_j` to `jacobian[i·n + j]` and returns how often it called
    /// [`rhs`](Self::rhs). `rate` is `f(t, x)`. By default: forward differences.
    fn jacobian(&self, t: f64, x: &[f64], rate: &[f64], jacobian: &mut [f64]) -> usize {
        let n = x.len();
        let mut moved = x.to_vec();
        let mut changed = vec![0.0; n];
        for j in 0..n {
            // Balances truncation against round-off, as RODAS and RADAU5 do.
            moved[j] = x[j] + (f64::EPSILON * x[j].abs().max(1e-5)).sqrt();
            let step = moved[j] - x[j];
            self.rhs(t, &moved, &mut changed);
            for i in 0..n {
                jacobian[i * n + j] = (changed[i] - rate[i]) / step;
            }
            moved[j] = x[j];
        }
        n
    }

    /// Writes `∂f/∂t` to `drift` and returns how often it called [`rhs`](Self::rhs). `t + step`
    /// still lies in the segment. By default: a forward difference.
    fn time_derivative(
        &self,
        t: f64,
        x: &[f64],
        rate: &[f64],
        step: f64,
        drift: &mut [f64],
    ) -> usize {
        let later = t + (f64::EPSILON.sqrt() * t.abs().max(step)).min(step);
        let delta = later - t;
        self.rhs(later, x, drift);
        for (d, r) in drift.iter_mut().zip(rate) {
            *d = if delta > 0.0 { (*d - r) / delta } else { 0.0 };
        }
        1
    }

    /// Rate, Jacobian and time derivative at once; returns how often the right-hand side was
    /// evaluated. Override it when they share work.
    #[inline]
    fn linearise(&self, t: f64, x: &[f64], step: f64, out: Linearised<'_>) -> usize {
        self.rhs(t, x, out.rate);
        1 + self.jacobian(t, x, out.rate, out.jacobian)
            + self.time_derivative(t, x, out.rate, step, out.drift)
    }

    /// Announces that the next calls lie in `start..=end`, in which the inputs are smooth. `x` is
    /// the state at `start`.
    #[inline]
    fn begin_segment(&mut self, start: f64, end: f64, x: &[f64]) {
        let _ = (start, end, x);
    }

    /// Number of guards. A guard says where the model changes its equations.
    #[inline]
    fn guards(&self) -> usize {
        0
    }

    /// Value of guard `index`; as soon as it falls below zero the integrator locates the crossing
    /// and calls [`cross`](Self::cross). Looked at once a step: a pair of crossings within one
    /// step is missed.
    #[inline]
    fn guard(&self, index: usize, t: f64, x: &[f64]) -> f64 {
        let _ = (index, t, x);
        0.0
    }

    /// Changes the equations (and, if need be, the state) after guard `index` was crossed. The
    /// guard of the new equations should not be negative at once.
    #[inline]
    fn cross(&mut self, index: usize, t: f64, x: &mut [f64]) {
        let _ = (index, t, x);
    }
}

/// Where [`System::linearise`] writes.
#[derive(Debug)]
pub struct Linearised<'a> {
    /// `f(t, x)`, shape `(n,)`.
    pub rate: &'a mut [f64],
    /// `∂f_i/∂x_j` at `i·n + j`, shape `(n, n)` row-major.
    pub jacobian: &'a mut [f64],
    /// `∂f/∂t`, shape `(n,)`.
    pub drift: &'a mut [f64],
}
