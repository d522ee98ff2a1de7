//! The identified model, with its doubt.

use dgd_dynamics::return_line::{Friction, PumpHead, ReturnLine};
use dgd_recording::{Geometry, Well};

/// An estimated parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Its value.
    pub value: f64,
    /// Its standard error; `None` if the parameter was held (at a bound, or given).
    ///
    /// The exponents of the pump's curve are as uncertain as its coefficients, and residuals that hang together count as the fewer samples
    /// that they are worth, up to 256 to one. The delay is taken as known.
    pub standard_error: Option<f64>,
}

/// Friction of the return line (Eq. 3.26 or another sum of powers).
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionModel {
    /// Terms, by rising power; powers are 0 (B), 1 (C), 2 (D) and 3 (E).
    pub terms: Vec<FrictionTerm>,
    /// Mean squared error, Pa², over n - p.
    pub mse_pa2: f64,
    /// Share of the variance explained.
    pub r2: f64,
    /// Samples used.
    pub samples: u64,
    /// Condition number of the scaled regressors: 1 is richly excited.
    pub condition: f64,
}

/// One term `coefficient · q^power`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionTerm {
    /// 0, 1, 2 or 3.
    pub power: u8,
    /// Pa/(m³/s)^power.
    pub coefficient: Estimate,
}

/// Head curve of the subsea pump (Eq. 3.39).
#[derive(Debug, Clone, PartialEq)]
pub struct PumpModel {
    /// c0, m/%^n0.
    pub c0: Estimate,
    /// c1, m/(%·m³/s).
    pub c1: Estimate,
    /// c2, m/(m³/s)^n2.
    pub c2: Estimate,
    /// Exponent of the speed.
    pub n0: f64,
    /// Exponent of the flow.
    pub n2: f64,
    /// Mean squared error, m².
    pub mse_m2: f64,
    /// Share of the variance explained.
    pub r2: f64,
    /// Samples used.
    pub samples: u64,
    /// Condition number of the scaled regressors.
    pub condition: f64,
    /// Constraints of Eq. 3.44 that hold the fit, such as `c2 > 0`; empty if none does.
    pub active_constraints: Vec<String>,
}

/// What the model was identified from.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DataUsed {
    /// Recordings, as the user names them.
    pub recordings: Vec<String>,
    /// Samples recorded; `identify` counts those on the even clock, gaps included, until told better.
    pub samples: usize,
    /// Samples that passed the screening.
    pub kept: usize,
    /// Step of the clock, s.
    pub step_s: f64,
    /// Samples rejected for each reason; a sample may have several.
    pub rejected: Vec<(String, usize)>,
}

/// An identified return line: the parameters of Eqs. 3.45-3.46.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Mud density, kg/m³.
    pub density_kg_m3: f64,
    /// Diameters and depths.
    pub geometry: Geometry,
    /// Friction law.
    pub friction: FrictionModel,
    /// Head curve.
    pub pump: PumpModel,
    /// How late the return flow meter is, s (Eq. 3.21).
    pub delay_s: f64,
    /// What it was identified from.
    pub data: DataUsed,
}

impl FrictionModel {
    /// Coefficient of a power, 0 if the law does not have it.
    pub fn coefficient(&self, power: u8) -> f64 {
        self.terms
            .iter()
            .find(|t| t.power == power)
            .map_or(0.0, |t| t.coefficient.value)
    }
}

impl Model {
    /// The model as the simulations take it.
    pub fn return_line(&self) -> ReturnLine {
        let geometry = &self.geometry;
        ReturnLine {
            density_kg_m3: self.density_kg_m3,
            riser_area_m2: geometry.riser_area_m2(),
            line_area_m2: geometry.line_area_m2(),
            inlet_depth_m: geometry.pump_inlet_depth_m,
            outlet_depth_m: geometry.pump_outlet_depth_m,
            friction: Friction {
                b_pa: self.friction.coefficient(0),
                c_pa_s_m3: self.friction.coefficient(1),
                d_pa_s2_m6: self.friction.coefficient(2),
                e_pa_s3_m9: self.friction.coefficient(3),
            },
            pump: PumpHead {
                c0: self.pump.c0.value,
                c1: self.pump.c1.value,
                c2: self.pump.c2.value,
                n0: self.pump.n0,
                n2: self.pump.n2,
            },
            non_return_valve: true,
            // The head curve is fitted with the same transmitters, so B belongs into the balance (3.46).
            b_is_offset: false,
        }
    }

    /// Whether the model was identified on a well of this mud and geometry.
    pub fn fits_well(&self, well: &Well) -> bool {
        self.density_kg_m3 == well.mud_density_kg_m3 && self.geometry == well.geometry
    }
}

#[cfg(test)]
mod tests {
    use crate::IdentifyOptions;
    use dgd_dynamics::return_line::{Friction, GRAVITY_M_S2, PumpHead, ReturnLine};
    use dgd_pump::HeadCurve;

    const PUMP: PumpHead = PumpHead {
        c0: 0.0688,
        c1: 3.0,
        c2: 2.4e3,
        n0: 1.95,
        n2: 1.62,
    };

    fn line(pump: PumpHead) -> ReturnLine {
        ReturnLine {
            density_kg_m3: 1000.0,
            riser_area_m2: 0.1704,
            line_area_m2: 0.01824,
            inlet_depth_m: 350.0,
            outlet_depth_m: 350.0,
            friction: Friction::default(),
            pump,
            non_return_valve: true,
            b_is_offset: false,
        }
    }

    #[test]
    fn exponents_are_sought_where_they_can_be_simulated() {
        let range = IdentifyOptions::default().search.n0;
        let at = |n0| line(PumpHead { n0, ..PUMP }).check();
        assert!(at(*range.start()).is_ok() && at(*range.end()).is_ok());
        assert!(at(range.start() - 1e-9).is_err(), "nor is any left out");
        assert_eq!(range, dgd_pump::SearchOptions::default().n0);
    }

    /// What is fitted by the one is simulated by the other.
    #[test]
    fn the_head_simulated_is_the_head_fitted_at_any_speed_and_flow() {
        for (n0, n2) in [(2.0, 2.0), (1.95, 1.62), (1.0, 1.0), (3.0, 1.5)] {
            let PumpHead { c0, c1, c2, .. } = PUMP;
            let fitted = HeadCurve { c0, c1, c2, n0, n2 };
            let simulated = PumpHead { n0, n2, ..PUMP };
            let line = line(simulated);
            for w in [-40.0, -1e-9, -0.0, 0.0, 1e-9, 30.0, 100.0] {
                for q in [-0.05, -0.0, 0.0, 1e-6, 0.05] {
                    let (a, b) = (simulated.head_m(w, q), fitted.head_m(w, q));
                    assert!((a - b).abs() <= 1e-14 * (1.0 + b.abs()), "{w} {q}: {a} {b}");
                    let drive_m = line.drive_pa(0.0, w, q) / (1000.0 * GRAVITY_M_S2);
                    assert!((drive_m - b).abs() <= 1e-13 * (1.0 + b.abs()), "{w} {q}");
                }
            }
            assert!(simulated.head_m(f64::NAN, 0.05).is_nan());
            assert!(fitted.head_m(f64::NAN, 0.05).is_nan());
        }
    }
}
