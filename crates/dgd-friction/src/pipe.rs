//! The textbook laws of thesis section 2.3.

use crate::FrictionError;
use std::f64::consts::PI;

/// Reynolds number at and above which flow counts as turbulent (thesis section 2.3).
pub const RE_CRIT: f64 = 2300.0;

/// Standard gravity, m/s².
const G_M_S2: f64 = 9.806_65;

/// A pipe of one diameter, and what flows in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pipe {
    /// Length, m.
    pub length_m: f64,
    /// Inner diameter, m.
    pub diameter_m: f64,
    /// Wall roughness ε, m; 0 is smooth.
    pub roughness_m: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Dynamic viscosity, Pa·s.
    pub viscosity_pa_s: f64,
}

impl Pipe {
    /// Checks the numbers, so that the laws below may take them as they are.
    ///
    /// # Errors
    /// [`FrictionError::Domain`] if length, diameter, density or viscosity is no positive number, or the roughness is negative.
    pub fn check(&self) -> Result<(), FrictionError> {
        let positive = [
            ("length_m", self.length_m),
            ("diameter_m", self.diameter_m),
            ("density_kg_m3", self.density_kg_m3),
            ("viscosity_pa_s", self.viscosity_pa_s),
        ];
        let odd = (positive.into_iter()).find(|(_, v)| !(v.is_finite() && *v > 0.0));
        let (name, found, expected) = match odd {
            Some((name, found)) => (name, found, "a finite number above 0"),
            None if self.roughness_m.is_finite() && self.roughness_m >= 0.0 => return Ok(()),
            None => (
                "roughness_m",
                self.roughness_m,
                "a finite number of at least 0",
            ),
        };
        Err(FrictionError::Domain {
            name,
            found,
            expected,
        })
    }
}

/// Reynolds number of a flow in a circular pipe, thesis Eq. 2.21: `4ρ|q| / (π d μ)`.
///
/// Units: kg/m³, m, Pa·s, m³/s. Direction does not matter: never negative of a pipe that can be
/// ([`Pipe::check`]), and of another what IEEE arithmetic gives.
pub fn reynolds(density_kg_m3: f64, diameter_m: f64, viscosity_pa_s: f64, flow_m3_s: f64) -> f64 {
    4.0 * density_kg_m3 * flow_m3_s.abs() / (PI * diameter_m * viscosity_pa_s)
}

/// Darcy friction factor: laminar `64/Re` (thesis Eq. 2.23) below [`RE_CRIT`], else Haaland's
/// `(-1.8 log10[6.9/Re + (ε/3.7d)^1.11])^-2` (Eq. 2.24).
///
/// - `relative_roughness`: ε/d, dimensionless.
///
/// It jumps at [`RE_CRIT`] (from 0.028 to 0.048 for a smooth pipe): the transition is not modelled.
/// Infinite at `Re = 0`; use [`darcy_weisbach`] for a drop that is 0 there.
///
/// ```
/// use dgd_friction::friction_factor;
/// assert_eq!(friction_factor(1000.0, 0.0), 0.064);
/// // Moody chart, Re = 1e5 and ε/d = 0.001: 0.0222. Haaland's formula is good to 2 %.
/// assert!((friction_factor(1e5, 1e-3) / 0.0222 - 1.0).abs() < 0.02);
/// ```
pub fn friction_factor(reynolds: f64, relative_roughness: f64) -> f64 {
    if reynolds < RE_CRIT {
        64.0 / reynolds
    } else {
        let inner = 6.9 / reynolds + (relative_roughness / 3.7).powf(1.11);
        (-1.8 * inner.log10()).powi(-2)
    }
}

/// Frictional pressure drop over a pipe in Pa, thesis Eq. 2.22 with constant diameter:
/// `f · 8ρL / (π² d⁵) · q|q|`.
///
/// - `flow_m3_s`: q, m³/s; the drop has its sign, and is 0 at no flow.
///
/// The numbers of the pipe are not looked at: see [`Pipe::check`].
pub fn darcy_weisbach(pipe: &Pipe, flow_m3_s: f64) -> f64 {
    if flow_m3_s == 0.0 {
        return 0.0;
    }
    let Pipe {
        length_m: l,
        diameter_m: d,
        density_kg_m3: rho,
        viscosity_pa_s: mu,
        roughness_m: eps,
    } = *pipe;
    let re = reynolds(rho, d, mu, flow_m3_s);
    if re < RE_CRIT {
        // f·q² written out: 64/Re times q² has no singularity at rest.
        return 128.0 * mu * l / (PI * d.powi(4)) * flow_m3_s;
    }
    friction_factor(re, eps / d) * 8.0 * rho * l / (PI * PI * d.powi(5))
        * flow_m3_s
        * flow_m3_s.abs()
}

/// Pressure loss over a bit's nozzles in Pa, thesis Eq. 2.25: `ρ q|q| / (2 Cv² TFA²)`.
///
/// - `density_kg_m3`: ρ at the bit, kg/m³.
/// - `discharge`: Cv, dimensionless.
/// - `area_m2`: total flow area TFA, m².
/// - `flow_m3_s`: q, m³/s; the loss has its sign.
pub fn bit_loss(density_kg_m3: f64, discharge: f64, area_m2: f64, flow_m3_s: f64) -> f64 {
    density_kg_m3 * flow_m3_s * flow_m3_s.abs() / (2.0 * (discharge * area_m2).powi(2))
}

/// Friction in a return line from the pressure at its foot, in Pa, thesis Eq. 3.13:
/// `P_out - ρ g h - p0`.
///
/// - `outlet_pa`: pressure at the pump outlet, Pa absolute, shape `(n,)`; NaN gives NaN.
/// - `density_kg_m3`: ρ, kg/m³; `height_m`: static height from the outlet to the rig, m.
/// - `ambient_pa`: pressure at the rig end, Pa (101325).
///
/// Holds at steady flow: the inertia of the line is not taken off.
pub fn observed_friction(
    outlet_pa: &[f64],
    density_kg_m3: f64,
    height_m: f64,
    ambient_pa: f64,
) -> Vec<f64> {
    let still = density_kg_m3 * G_M_S2 * height_m + ambient_pa;
    outlet_pa.iter().map(|p| p - still).collect()
}
