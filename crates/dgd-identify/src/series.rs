//! The measured quantities that the relations are fitted to.

use dgd_recording::Well;

/// Level, friction and head at each sample of a recording; NaN where a transmitter is silent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Riser level h_r, m (Eq. 4.1).
    pub level_m: Vec<f64>,
    /// Friction of the return line, Pa (Eq. 3.13).
    pub friction_pa: Vec<f64>,
    /// Pump head ΔH, m (Eq. 2.27).
    pub head_m: Vec<f64>,
}

impl Series {
    /// Works the three out from the pressures at the pump's sides, Pa absolute, shape `(n,)` each.
    pub fn of(well: &Well, inlet_pressure_pa: &[f64], outlet_pressure_pa: &[f64]) -> Self {
        let sides = inlet_pressure_pa.iter().zip(outlet_pressure_pa);
        let level = || inlet_pressure_pa.iter().map(|p| well.level_m(*p)).collect();
        let friction = || {
            let outlet = outlet_pressure_pa.iter();
            outlet.map(|p| well.line_friction_pa(*p)).collect()
        };
        let head = || {
            sides
                .map(|(inlet, outlet)| well.head_m(*inlet, *outlet))
                .collect()
        };
        let (level_m, (friction_pa, head_m)) = rayon::join(level, || rayon::join(friction, head));
        Self {
            level_m,
            friction_pa,
            head_m,
        }
    }
}

/// `values` read `steps` samples ahead, NaN beyond the end (Eq. 3.30).
pub fn read_ahead(values: &[f64], steps: i64) -> Vec<f64> {
    let shift = usize::try_from(steps.unsigned_abs())
        .unwrap_or(usize::MAX)
        .min(values.len());
    let blank = std::iter::repeat_n(f64::NAN, shift);
    if steps >= 0 {
        values[shift..].iter().copied().chain(blank).collect()
    } else {
        blank
            .chain(values[..values.len() - shift].iter().copied())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reading_ahead_and_back_meets_the_end_with_nan() {
        assert_eq!(read_ahead(&[1.0, 2.0, 3.0], 1)[..2], [2.0, 3.0]);
        assert!(read_ahead(&[1.0, 2.0, 3.0], 1)[2].is_nan());
        assert_eq!(read_ahead(&[1.0, 2.0, 3.0], -2)[2], 1.0);
        assert!(read_ahead(&[1.0, 2.0, 3.0], 99).iter().all(|v| v.is_nan()));
    }
}
