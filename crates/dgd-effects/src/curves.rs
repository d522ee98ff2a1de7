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

/// Flow and speed that the curves are scaled by, and the regime of the line's flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Flow, m³/s.
    pub flow_m3_s: f64,
    /// Speed, %.
    pub speed_pct: f64,
    /// How the line's flow is laminar where it is slow; `None` where all of it is turbulent.
    pub laminar: Option<Laminar>,
}

/// Laminar flow of viscous mud in the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Laminar {
    /// Flow about which it turns turbulent, m³/s.
    pub below_m3_s: f64,
    /// Power of the flow that friction goes with: the flow index of the mud, 1 of a Newtonian one and less of one that thins under shear (Metzner and
    /// Reed, AIChE J. 1, 1955).
    pub index: f64,
}

impl Laminar {
    /// Share of the line's flow that is turbulent at a flow, m³/s: a tenth at Reynolds numbers of 2300, nine tenths at 4000.
    fn turbulent(&self, q: f64) -> f64 {
        // By powers of the flow, as Churchill (Chem. Eng. 84, 1977) joins the regimes.
        let ratio = (q.max(0.0) / self.below_m3_s).powi(8);
        if ratio.is_finite() {
            ratio / (1.0 + ratio)
        } else {
            1.0
        }
    }
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

/// Friction of the line at a flow q, m³/s: B while the mud moves, and q to the powers 1, 1.75 (Blasius), 2, 3; then bumps in flow. Where
/// flow may be laminar, its law stands in the place of the first power (Hagen and Poiseuille), and the next two are those of the share that is turbulent.
pub fn friction_terms(q: f64, scale: Scale) -> [f64; FRICTION_TERMS] {
    let z = (q / scale.flow_m3_s).max(0.0);
    let moving = if q > STANDING_M3_S { 1.0 } else { 0.0 };
    let mut out = [0.0; FRICTION_TERMS];
    let [blasius, rough] = [z * z.sqrt() * z.sqrt().sqrt(), z * z];
    out[..5].copy_from_slice(&[moving, z, blasius, rough, z * z * z]);
    if let Some(laminar) = scale.laminar {
        let turbulent = laminar.turbulent(q);
        out[1..4].copy_from_slice(&[
            (1.0 - turbulent) * z.powf(laminar.index),
            turbulent * blasius,
            turbulent * rough,
        ]);
    }
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
    use super::{Bumps, FRICTION_BUMP, HEAD_BUMP, Laminar, Scale, friction_terms};

    #[test]
    fn laminar_flow_follows_its_own_law_up_to_where_it_turns_turbulent() {
        let turbulent = Scale {
            flow_m3_s: 0.04,
            speed_pct: 60.0,
            laminar: None,
        };
        let of = |index: f64| Scale {
            laminar: Some(Laminar {
                below_m3_s: 0.02,
                index,
            }),
            ..turbulent
        };
        let [slow, at, fast] = [0.008, 0.02, 0.06].map(|q| friction_terms(q, of(0.8)));
        assert!((slow[1] - 0.2_f64.powf(0.8)).abs() < 1e-3 && slow[2] < 1e-3 && slow[3] < 1e-3);
        assert!(fast[1] < 1e-3 && (fast[3] - 2.25).abs() < 1e-3);
        // Half and half at the transition.
        assert!((at[1] - 0.5 * 0.5_f64.powf(0.8)).abs() < 1e-12 && (at[3] - 0.125).abs() < 1e-12);
        // All else is as it is in turbulent flow.
        for q in [0.0, 0.008, 0.02, 0.06] {
            let (laminar, other) = (friction_terms(q, of(1.0)), friction_terms(q, turbulent));
            assert_eq!((laminar[0], &laminar[4..]), (other[0], &other[4..]));
            assert!((0.0..=1.0).contains(&(laminar[1] / other[1].max(1e-300))));
        }
        // However far from it.
        assert!(friction_terms(1e300, of(1.0))[1].is_finite());
        assert_eq!(friction_terms(-0.01, of(1.0))[1], 0.0);
    }

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
