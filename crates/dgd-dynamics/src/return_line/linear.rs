//! The linear model around an operating point.

use super::model::Momentum;
use super::{GRAVITY_M_S2, LineState, ReturnLine};
use crate::DynamicsError;

/// Continuous linear model `dx/dt = A·x + B·u`, `y = C·x` of deviations from an operating point.
///
/// - `x`: level m, flow m³/s;
/// - `u`: inflow m³/s, pump speed %;
/// - `y`: inlet pressure Pa, outlet pressure Pa (steady, Eq. 3.13), flow m³/s.
///
/// There is no feed-through: `D = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearLine {
    /// `A`, row-major.
    pub a: [[f64; 2]; 2],
    /// `B`, row-major.
    pub b: [[f64; 2]; 2],
    /// `C`, row-major.
    pub c: [[f64; 2]; 3],
}

impl LinearLine {
    /// Time constant of the flow alone, s: how fast it follows the pump at a given level.
    #[must_use]
    pub fn flow_time_constant_s(&self) -> f64 {
        -1.0 / self.a[1][1]
    }
}

/// Linearises Eq. 3.45-3.46 at `state` and `speed_pct`, with the non-return valve open and the
/// riser neither full nor empty.
///
/// # Errors
/// [`DynamicsError::Parameter`] on parameters out of range or an operating point that is not
/// finite.
pub fn linearise(
    line: &ReturnLine,
    state: LineState,
    speed_pct: f64,
) -> Result<LinearLine, DynamicsError> {
    line.check()?;
    for (name, found) in [("level_m", state.level_m), ("flow_m3_s", state.flow_m3_s)] {
        if !found.is_finite() {
            return Err(DynamicsError::Parameter {
                name,
                found,
                expected: "a finite number",
            });
        }
    }
    if !(speed_pct >= 0.0 && speed_pct.is_finite()) {
        let expected = "a finite speed of at least 0 %";
        return Err(DynamicsError::Parameter {
            name: "speed_pct",
            found: speed_pct,
            expected,
        });
    }
    let area = 1.0 / line.riser_area_m2;
    let at = Momentum::new(line).linearise(state.level_m, speed_pct, state.flow_m3_s);
    let rho_g = line.density_kg_m3 * GRAVITY_M_S2;
    Ok(LinearLine {
        a: [[0.0, area], [at.by_level, at.by_flow]],
        b: [[-area, 0.0], [0.0, at.by_speed]],
        c: [
            [-rho_g, 0.0],
            [0.0, line.friction.slope_pa_s_m3(state.flow_m3_s)],
            [0.0, 1.0],
        ],
    })
}
