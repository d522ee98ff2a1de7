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

/// Smooth bumps of unit height, equally far apart.
struct Bumps {
    /// Centre of the first.
    first: f64,
    /// From one centre to the next.
    apart: f64,
    /// Standard deviation of each.
    width: f64,
    /// Height of a bump at its neighbour's centre: exp(-(apart / width)² / 2).
    beside: f64,
}

const FRICTION_BUMP: Bumps = Bumps {
    first: 0.25,
    apart: 0.25,
    width: 0.2,
    beside: 0.45783336177161427,
};
const HEAD_BUMP: Bumps = Bumps {
    first: 0.0,
    apart: 0.17,
    width: 0.16,
    beside: 0.568671053718672,
};

impl Bumps {
    /// The height of each at a place.
    ///
    /// The nearest is worked out, and its neighbours from it: j centres further on, at a distance u from the nearest, a bump
    /// is exp(u apart / width²)^j beside^(j²) times as high. That is two exponentials for all of them.
    fn at<const N: usize>(&self, x: f64) -> [f64; N] {
        /// Widths from the nearest centre at which exp(-u²/2) is 0 in double precision.
        const FAR: f64 = 39.0;
        let beyond = |k: &usize| x > self.first + self.apart * (*k as f64 - 0.5);
        let nearest = (1..N).take_while(beyond).count();
        let u = (x - self.first - self.apart * nearest as f64) / self.width;
        let mut out = [0.0; N];
        if u.abs() > FAR {
            return out;
        }
        out[nearest] = (-0.5 * u * u).exp();
        let onward = (u * self.apart / self.width).exp();
        let square = self.beside * self.beside;
        let mut step = onward * self.beside;
        for k in nearest + 1..N {
            out[k] = out[k - 1] * step;
            step *= square;
        }
        let mut step = self.beside / onward;
        for k in (0..nearest).rev() {
            out[k] = out[k + 1] * step;
            step *= square;
        }
        out
    }
}

/// Friction of the line at a flow q, m³/s: B while the mud moves, and q to the powers 1, 1.75 (Blasius), 2, 3; then bumps in flow.
pub fn friction_terms(q: f64, scale: Scale) -> [f64; FRICTION_TERMS] {
    let z = (q / scale.flow_m3_s).max(0.0);
    let moving = if q > STANDING_M3_S { 1.0 } else { 0.0 };
    let mut out = [0.0; FRICTION_TERMS];
    out[..5].copy_from_slice(&[moving, z, z * z.sqrt() * z.sqrt().sqrt(), z * z, z * z * z]);
    if moving > 0.0 {
        out[5..].copy_from_slice(&FRICTION_BUMP.at::<FRICTION_BUMPS>(z));
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
    let bumps = HEAD_BUMP.at::<HEAD_BUMPS>(s);
    for (term, bump) in out[HEAD_POWERS..].iter_mut().zip(bumps) {
        *term = x2 * bump;
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

#[cfg(test)]
mod tests {
    use super::{Bumps, FRICTION_BUMP, HEAD_BUMP};

    #[test]
    fn bumps_are_those_worked_out_one_by_one() {
        let heights = |bumps: &Bumps, x: f64| -> [f64; 9] {
            std::array::from_fn(|k| {
                let u = (x - bumps.first - bumps.apart * k as f64) / bumps.width;
                (-0.5 * u * u).exp()
            })
        };
        for bumps in [&FRICTION_BUMP, &HEAD_BUMP] {
            for x in (-400..=800).map(|i| 0.01 * f64::from(i)) {
                for (got, want) in bumps.at::<9>(x).iter().zip(heights(bumps, x)) {
                    assert!(
                        (got - want).abs() <= 1e-12 * want + 1e-300,
                        "{got} and {want} at {x}"
                    );
                }
            }
        }
    }

    #[test]
    fn far_from_all_bumps_nothing_is_left() {
        for x in [-1e300, -60.0, 60.0, 1e300, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(HEAD_BUMP.at::<9>(x), [0.0; 9], "at {x}");
        }
        assert!(HEAD_BUMP.at::<9>(f64::NAN).iter().all(|v| v.is_nan()));
    }
}
