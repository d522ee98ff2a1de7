//! A line of the thesis's size, and deterministic noise.

use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::integrate::Method;
use dgd_dynamics::return_line::{Friction, PumpHead, ReturnLine, SimulationOptions};

pub(crate) const METHODS: [Method; 3] = [Method::Rodasp, Method::Rodas3, Method::DormandPrince];

pub(crate) fn line() -> ReturnLine {
    ReturnLine {
        density_kg_m3: 1080.0,
        riser_area_m2: 0.170_44,
        line_area_m2: 0.018_241,
        inlet_depth_m: 350.3,
        outlet_depth_m: 350.3,
        friction: Friction {
            b_pa: 12_650.0,
            c_pa_s_m3: 2e5,
            d_pa_s2_m6: 1.28e8,
            e_pa_s3_m9: -2.3e8,
        },
        pump: PumpHead {
            c0: 0.068_78,
            c1: 0.05,
            c2: 8926.0,
            n0: 1.9546,
            n2: 1.6243,
        },
        non_return_valve: true,
        b_is_offset: false,
    }
}

pub(crate) fn options(method: Method, tolerance: f64) -> SimulationOptions {
    SimulationOptions {
        method,
        relative: tolerance,
        level_tolerance_m: tolerance,
        flow_tolerance_m3_s: tolerance * 1e-2,
        ..SimulationOptions::default()
    }
}

pub(crate) fn linear<'a>(time: &'a [f64], values: &'a [f64]) -> Signal<'a> {
    Signal::new("signal", time, values, Interpolation::Linear).unwrap()
}

/// Uniform in ±0.5, the same on every machine.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 32).unwrap()) / f64::from(u32::MAX) - 0.5
    }
}

/// Time, inflow and speed at 1 Hz with a kink at every sample.
pub(crate) fn kinked_inputs(seconds: u32) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut noise = Noise(7);
    let time: Vec<f64> = (0..=seconds).map(f64::from).collect();
    let inflow = time
        .iter()
        .map(|t| 0.05 + 0.004 * (t * 0.03).sin() + 0.002 * noise.next())
        .collect();
    let speed = time
        .iter()
        .map(|t| 62.0 + 3.0 * (t * 0.02).cos() + noise.next())
        .collect();
    (time, inflow, speed)
}

/// Slope of the straight line through `(x, y)` by least squares.
pub(crate) fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let top: f64 = x.iter().zip(y).map(|(a, b)| (a - mx) * (b - my)).sum();
    top / x.iter().map(|a| (a - mx).powi(2)).sum::<f64>()
}
