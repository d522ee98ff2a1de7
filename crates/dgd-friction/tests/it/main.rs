//! Public behaviour of `dgd-friction`, as claims.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod fit;
mod pipe;
mod polynomial;
mod refusals;
mod sweep;

use dgd_friction::Samples;

/// Deterministic noise of mean 0 in -1..1.
pub(crate) fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / 2f64.powi(31) - 1.0
}

/// A recording: flow that wanders, friction that follows it `delay` samples before the meter.
pub(crate) struct Recording {
    pub(crate) flow: Vec<f64>,
    pub(crate) friction: Vec<f64>,
    pub(crate) keep: Vec<bool>,
}

impl Recording {
    pub(crate) fn new(n: usize, delay: i64, law: impl Fn(f64) -> f64, sigma: f64) -> Self {
        let true_flow = |t: i64| {
            let t = f64::from(i32::try_from(t).unwrap());
            0.045 + 0.012 * (t / 37.0).sin() + 0.01 * (t / 11.3).cos() + 0.004 * (t / 3.1).sin()
        };
        let t = |i: usize| i64::try_from(i).unwrap();
        let flow = (0..n).map(|i| true_flow(t(i) - delay)).collect();
        let friction = (0..n)
            .map(|i| law(true_flow(t(i))) + sigma * noise(i))
            .collect();
        Self {
            flow,
            friction,
            keep: vec![true; n],
        }
    }

    /// Gaps in the flow and rejected, unreadable friction, at odd places.
    pub(crate) fn damaged(mut self) -> Self {
        for i in 0..self.flow.len() {
            if noise(i / 7 + 5000) > 0.8 {
                self.keep[i] = false;
                self.friction[i] = f64::NAN;
            }
            if noise(i / 3 + 9000) > 0.95 {
                self.flow[i] = f64::NAN;
            }
        }
        self
    }

    pub(crate) fn samples(&self) -> Samples<'_> {
        Samples {
            flow_m3_s: &self.flow,
            friction_pa: &self.friction,
            keep: &self.keep,
            keep_delayed: false,
        }
    }
}
