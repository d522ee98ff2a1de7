//! The base curves: friction of the line and head of the pump, smooth and of whatever shape.
//!
//! Their shape is identification, not a finding. Polynomials carry the trend, bumps of bounded height what is left.

use dgd_recording::STANDING_M3_S;

/// Bumps by which a smooth curve may differ from its polynomial: in flow, and in flow over speed.
const FRICTION_BUMPS: usize = 5;
const HEAD_BUMPS: usize = 9;
/// Terms of [`friction_terms`].
pub const FRICTION_TERMS: usize = 5 + FRICTION_BUMPS;
/// Terms of [`head_terms`] that are powers; bumps follow.
pub const HEAD_POWERS: usize = 8;
/// Terms of [`head_terms`].
pub const HEAD_TERMS: usize = HEAD_POWERS + HEAD_BUMPS;

/// Flow and speed that the curves are scaled by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Flow, m³/s.
    pub flow_m3_s: f64,
    /// Speed, %.
    pub speed_pct: f64,
}

/// A smooth bump of unit height.
fn bump(x: f64, centre: f64, width: f64) -> f64 {
    let u = (x - centre) / width;
    (-0.5 * u * u).exp()
}

/// Friction of the line at a flow q, m³/s: B while the mud moves, and q to the powers 1, 1.75 (Blasius), 2, 3; then bumps in flow.
pub fn friction_terms(q: f64, scale: Scale) -> [f64; FRICTION_TERMS] {
    let z = (q / scale.flow_m3_s).max(0.0);
    let moving = if q > STANDING_M3_S { 1.0 } else { 0.0 };
    let mut out = [0.0; FRICTION_TERMS];
    out[..5].copy_from_slice(&[moving, z, z * z.sqrt() * z.sqrt().sqrt(), z * z, z * z * z]);
    for k in 0..FRICTION_BUMPS {
        out[5 + k] = moving * bump(z, 0.25 * (k + 1) as f64, 0.2);
    }
    out
}

/// Head of the pump at a speed w, % and a flow q, m³/s: an offset, powers of speed and flow to the third, and bumps in flow over speed.
pub fn head_terms(w: f64, q: f64, scale: Scale) -> [f64; HEAD_TERMS] {
    let x = (w / scale.speed_pct).max(0.05);
    let z = q / scale.flow_m3_s;
    let s = z / x;
    let x2 = x * x;
    let mut out = [0.0; HEAD_TERMS];
    let z2 = z * z;
    out[..HEAD_POWERS].copy_from_slice(&[1.0, x2, x * z, z2, x2 * x, x2 * z, x * z2, z2 * z]);
    for k in 0..HEAD_BUMPS {
        out[HEAD_POWERS + k] = x2 * bump(s, 0.17 * k as f64, 0.16);
    }
    out
}

/// The base curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// What flow and speed are scaled by.
    pub scale: Scale,
    /// Coefficients of [`friction_terms`], Pa.
    pub friction: [f64; FRICTION_TERMS],
    /// Coefficients of [`head_terms`], Pa.
    pub head: [f64; HEAD_TERMS],
}

impl Curves {
    /// Friction of the line, Pa, at a flow, m³/s.
    pub fn friction_pa(&self, q: f64) -> f64 {
        dot(&self.friction, &friction_terms(q, self.scale))
    }

    /// Pressure rise over the pump, Pa, at a speed, %, and a flow, m³/s.
    pub fn head_pa(&self, w: f64, q: f64) -> f64 {
        dot(&self.head, &head_terms(w, q, self.scale))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
