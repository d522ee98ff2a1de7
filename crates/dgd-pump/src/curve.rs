//! The head curve and its slopes.

/// A pump curve `H = c0 w^n0 - c1 w q - c2 q^n2`, thesis Eq. 3.39 (2.28 with both exponents 2).
///
/// Head H in m of the pumped fluid, speed w in percent of full (0 to 100), flow q in m³/s. The
/// units of the coefficients follow. A fit of the same data with flow in percent of some
/// `q_100` has `c1·q_100/100` and `c2·(q_100/100)^n2` instead.
///
/// The pump of a simulation has the same letters in the same units; n0 and n2 must be at least 1 there:
///
/// ```
/// use dgd_dynamics::return_line::PumpHead;
/// use dgd_pump::HeadCurve;
/// let HeadCurve { c0, c1, c2, n0, n2 } = HeadCurve { c0: 0.0688, c1: 3.0, c2: 2.4e3, n0: 1.95, n2: 1.62 };
/// let pump = PumpHead { c0, c1, c2, n0, n2 };
/// let curve = HeadCurve { c0, c1, c2, n0, n2 };
/// for (w, q) in [(60.0, 0.05), (0.0, 0.0), (72.0, -0.01)] {
///     assert!((pump.head_m(w, q) - curve.head_m(w, q)).abs() < 1e-12);
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadCurve {
    /// c0, m/%^n0: head at no flow.
    pub c0: f64,
    /// c1, m/(%·m³/s): loss with speed and flow.
    pub c1: f64,
    /// c2, m/(m³/s)^n2: loss with flow alone.
    pub c2: f64,
    /// n0, exponent of the speed.
    pub n0: f64,
    /// n2, exponent of the flow.
    pub n2: f64,
}

/// A speed below 0 counts as 0; one that is missing stays missing, which `max` would hide.
fn not_below_rest(speed_pct: f64) -> f64 {
    if speed_pct < 0.0 { 0.0 } else { speed_pct }
}

impl HeadCurve {
    /// Head in m.
    ///
    /// Backflow is continued oddly, `sign(q) |q|^n2`: the loss opposes the flow, and the curve keeps
    /// falling through q = 0. Speed below 0 counts as 0.
    ///
    /// ```
    /// use dgd_pump::HeadCurve;
    /// let curve = HeadCurve { c0: 0.05, c1: 5.0, c2: 2e4, n0: 2.0, n2: 2.0 };
    /// assert!((curve.head_m(60.0, 0.05) - (180.0 - 15.0 - 50.0)).abs() < 1e-12);
    /// ```
    pub fn head_m(&self, speed_pct: f64, flow_m3_s: f64) -> f64 {
        let w = not_below_rest(speed_pct);
        let q = flow_m3_s;
        self.c0 * power(w, self.n0)
            - self.c1 * w * q
            - self.c2 * power(q.abs(), self.n2).copysign(q)
    }

    /// ∂H/∂q in m/(m³/s): `-c1 w - n2 c2 |q|^(n2-1)` (thesis Eq. 3.41).
    pub fn slope_flow(&self, speed_pct: f64, flow_m3_s: f64) -> f64 {
        let w = not_below_rest(speed_pct);
        -self.c1 * w - times(self.n2 * self.c2, power(flow_m3_s.abs(), self.n2 - 1.0))
    }

    /// ∂H/∂w in m/%: `n0 c0 w^(n0-1) - c1 q`; 0 at speeds below 0, which count as 0.
    pub fn slope_speed(&self, speed_pct: f64, flow_m3_s: f64) -> f64 {
        if speed_pct < 0.0 {
            return 0.0;
        }
        times(self.n0 * self.c0, power(speed_pct, self.n0 - 1.0)) - self.c1 * flow_m3_s
    }

    /// ∂²H/∂q² in m/(m³/s)²: `-(n2-1) n2 c2 q^(n2-2)` (thesis Eq. 3.43), odd in q.
    ///
    /// Infinite at rest for n2 between 1 and 2.
    pub fn bend_flow(&self, flow_m3_s: f64) -> f64 {
        let factor = (self.n2 - 1.0) * self.n2 * self.c2;
        let sign = if flow_m3_s < 0.0 { -1.0 } else { 1.0 };
        -sign * times(factor, power(flow_m3_s.abs(), self.n2 - 2.0))
    }
}

/// 0 · ∞ is 0 here: a term that is not in the curve has no slope.
fn times(factor: f64, power: f64) -> f64 {
    if factor == 0.0 { 0.0 } else { factor * power }
}

/// `x^n` for x >= 0, without `powf` for the thesis' exponents.
pub(crate) fn power(x: f64, n: f64) -> f64 {
    if n == 2.0 {
        x * x
    } else if n == 1.0 {
        x
    } else {
        x.powf(n)
    }
}
