//! Friction in a full round pipe.

use std::f64::consts::PI;

/// Darcy's friction factor: `64/Re` up to a Reynolds number of 2000, Colebrook and White from 4000, a straight line between.
///
/// - `reynolds`: Reynolds number, positive.
/// - `relative_roughness`: roughness over bore.
///
/// # Source
/// C. F. Colebrook (1939), *J. Inst. Civil Eng.* 11:133, solved by Newton's method.
pub fn friction_factor(reynolds: f64, relative_roughness: f64) -> f64 {
    const LAMINAR: f64 = 2000.0;
    const TURBULENT: f64 = 4000.0;
    if reynolds <= LAMINAR {
        return 64.0 / reynolds;
    }
    let turbulent = colebrook(reynolds.max(TURBULENT), relative_roughness);
    let part = ((reynolds - LAMINAR) / (TURBULENT - LAMINAR)).min(1.0);
    (1.0 - part) * 64.0 / LAMINAR + part * turbulent
}

/// `1/√f = -2 log10(ε/3.7 + 2.51/(Re √f))`.
fn colebrook(reynolds: f64, relative_roughness: f64) -> f64 {
    let (a, b) = (relative_roughness / 3.7, 2.51 / reynolds);
    // x = 1/√f; five steps from here reach the last digit.
    let mut x = 7.0_f64;
    for _ in 0..5 {
        let inside = a + b * x;
        let off = x + 2.0 * inside.log10();
        x -= off / (1.0 + 2.0 / std::f64::consts::LN_10 * b / inside);
    }
    1.0 / (x * x)
}

/// A pipe and what flows in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pipe {
    pub(crate) length_m: f64,
    pub(crate) bore_m: f64,
    pub(crate) density_kg_m3: f64,
    pub(crate) viscosity_pa_s: f64,
}

impl Pipe {
    pub(crate) fn area_m2(&self) -> f64 {
        PI / 4.0 * self.bore_m * self.bore_m
    }

    /// Inertia of the column, `ρL/A` in kg/m⁴.
    pub(crate) fn inertance_kg_m4(&self) -> f64 {
        self.density_kg_m3 * self.length_m / self.area_m2()
    }

    pub(crate) fn reynolds(&self, flow_m3_s: f64) -> f64 {
        4.0 * self.density_kg_m3 * flow_m3_s.abs() / (PI * self.bore_m * self.viscosity_pa_s)
    }

    /// Pressure of a velocity head, Pa; not negative.
    pub(crate) fn velocity_head_pa(&self, flow_m3_s: f64) -> f64 {
        let v = flow_m3_s / self.area_m2();
        0.5 * self.density_kg_m3 * v * v
    }

    /// Hagen and Poiseuille: Pa per m³/s.
    pub(crate) fn laminar_pa_s_m3(&self) -> f64 {
        128.0 * self.viscosity_pa_s * self.length_m / (PI * self.bore_m.powi(4))
    }
}

/// Pressure lost to wall friction and local losses (in velocity heads), Pa, of the sign of the flow: Darcy and Weisbach.
pub(crate) fn drop_pa(pipe: &Pipe, roughness_m: f64, minor_loss: f64, flow_m3_s: f64) -> f64 {
    let reynolds = pipe.reynolds(flow_m3_s);
    if reynolds < 1e-6 {
        return 0.0;
    }
    let factor = friction_factor(reynolds, roughness_m / pipe.bore_m);
    let heads = factor * pipe.length_m / pipe.bore_m + minor_loss;
    flow_m3_s.signum() * heads * pipe.velocity_head_pa(flow_m3_s)
}
