//! Public behaviour of `dgd-pump`, as claims.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod constrained;
mod curve;
mod fit;
mod refusals;
mod search;
mod shape;

use dgd_pump::{HeadCurve, Samples};

/// Deterministic noise of mean 0 in -1..1.
pub(crate) fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / 2f64.powi(31) - 1.0
}

pub(crate) struct Recording {
    pub(crate) speed: Vec<f64>,
    pub(crate) flow: Vec<f64>,
    pub(crate) head: Vec<f64>,
    pub(crate) keep: Vec<bool>,
}

impl Recording {
    /// Speed of 49-100 % in steps of 0.1, flow up to 0.07 m³/s in steps of 0.5 gpm.
    pub(crate) fn new(n: usize, curve: &HeadCurve, sigma: f64) -> Self {
        let speed: Vec<f64> = (0..n)
            .map(|i| ((74.5 + 25.5 * noise(i + 1_000_000)) * 10.0).round() / 10.0)
            .collect();
        let flow: Vec<f64> = (0..n)
            .map(|i| {
                let gpm = 555.0 * (1.0 + noise(i + 2_000_000));
                (gpm * 2.0).round() / 2.0 * 6.3090e-5
            })
            .collect();
        let head = (0..n)
            .map(|i| curve.head_m(speed[i], flow[i]) + sigma * noise(i))
            .collect();
        Self {
            speed,
            flow,
            head,
            keep: vec![true; n],
        }
    }

    /// The flow follows the speed almost, and any shape of the head: columns that are nearly alike.
    pub(crate) fn alike(seed: u32) -> Self {
        const N: usize = 200;
        let at = |k: usize| 0.5 * (1.0 + noise(usize::try_from(seed).unwrap() * 5000 + k));
        let (lowest, spread) = (
            30.0 + 40.0 * at(0),
            if seed.is_multiple_of(2) { 10.0 } else { 30.0 },
        );
        let tie = if seed.is_multiple_of(3) { 0.99 } else { 0.9 };
        let (c1, c2) = (10.0 * (at(1) - 0.5), 4e4 * (at(2) - 0.5));
        let speed: Vec<f64> = (0..N).map(|i| lowest + spread * at(100 + i)).collect();
        let flow: Vec<f64> = (0..N)
            .map(|i| 0.0008 * (tie * speed[i] + (1.0 - tie) * 80.0 * at(1000 + i)))
            .collect();
        let head = (0..N)
            .map(|i| {
                let (w, q) = (speed[i], flow[i]);
                0.05 * w * w - c1 * w * q - c2 * q * q + (at(2000 + i) - 0.5)
            })
            .collect();
        Self {
            speed,
            flow,
            head,
            keep: vec![true; N],
        }
    }

    pub(crate) fn samples(&self) -> Samples<'_> {
        Samples {
            speed_pct: &self.speed,
            flow_m3_s: &self.flow,
            head_m: &self.head,
            keep: &self.keep,
        }
    }
}

/// A pump like the one of the thesis.
pub(crate) const PUMP: HeadCurve = HeadCurve {
    c0: 0.056,
    c1: 5.7,
    c2: 1.8e4,
    n0: 2.0,
    n2: 2.0,
};

/// One whose least-squares curve is convex at the exponents of Eq. 3.31: the thesis' Figure 3.9.
pub(crate) const CONVEX: HeadCurve = HeadCurve {
    c2: -6e3,
    c1: 9.0,
    ..PUMP
};
