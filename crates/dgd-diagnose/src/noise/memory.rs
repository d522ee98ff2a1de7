//! What of a residual is noise, and how long its memory is.

/// Residuals less their mean over so many rows to either side, minutes to half an hour: what is slower is drift or an effect, not noise.
pub(super) fn high_pass(values: &[f64], valid: &[bool], half: usize) -> Vec<f64> {
    let n = values.len();
    let mut sums = vec![(0.0_f64, 0.0_f64); n + 1];
    for i in 0..n {
        let (s, c) = sums[i];
        sums[i + 1] = if valid[i] {
            (s + values[i], c + 1.0)
        } else {
            (s, c)
        };
    }
    (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(half), (i + half + 1).min(n));
            let count: f64 = sums[b].1 - sums[a].1;
            values[i] - (sums[b].0 - sums[a].0) / count.max(1.0)
        })
        .collect()
}

/// Autoregression of order 2 over clipped residuals; stationary by construction.
pub(super) fn autoregression(values: &[f64], valid: &[bool], scale: f64) -> [f64; 2] {
    /// Standard deviations at which a residual is clipped. Set by hand.
    const CLIP: f64 = 3.0;
    /// Pairs of rows below which nothing tells a memory. Set by hand.
    const LEAST_PAIRS: f64 = 30.0;
    /// Partial correlations with the row before and the one before that. Set by hand: a longer memory is not noise, it is a drift or an effect.
    const FIRST: (f64, f64) = (-0.6, 0.35);
    const SECOND: (f64, f64) = (-0.4, 0.15);
    let clip = |v: f64| v.clamp(-CLIP * scale, CLIP * scale);
    let mut r = [0.0_f64; 3];
    let mut counts = [0.0_f64; 3];
    for lag in 0..3 {
        for i in lag..values.len() {
            if valid[i] && valid[i - lag] {
                r[lag] += clip(values[i]) * clip(values[i - lag]);
                counts[lag] += 1.0;
            }
        }
        r[lag] /= f64::max(counts[lag], 1.0);
    }
    if counts[2] < LEAST_PAIRS || r[0] <= 0.0 {
        return [0.0; 2];
    }
    let (p1, p2) = (r[1] / r[0], r[2] / r[0]);
    let k1 = p1.clamp(FIRST.0, FIRST.1);
    let k2 = ((p2 - k1 * k1) / (1.0 - k1 * k1)).clamp(SECOND.0, SECOND.1);
    [k1 * (1.0 - k2), k2]
}
