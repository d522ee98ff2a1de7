//! The return line of the thesis: riser level and pump flow, Eq. 3.45-3.46.

mod linear;
mod model;
mod parts;
mod power;
mod simulate;
mod steady;

pub use linear::{LinearLine, linearise};
pub use parts::LineParts;
pub use simulate::{
    LateParts, LineOutputs, LineState, OutputParts, RiserBounds, Simulation, SimulationOptions,
    derive_outputs, measured_flow, simulate_coupled, simulate_flow_alone, simulate_riser_alone,
};
pub use steady::{
    FLOW_LIMIT_M3_S, SteadyFlow, SteadyParts, SteadyStatus, steady_flow, steady_state,
};

use crate::DynamicsError;

/// Standard gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.80665;
/// Standard atmosphere, Pa.
pub const ATMOSPHERE_PA: f64 = 101_325.0;

/// Frictional pressure loss of the discharge line, `F(q) = B + C·q + D·q|q| + E·q³`.
///
/// Odd in `q` but for `B`. In the thesis `B` is the offset of the outlet transmitter, and
/// nevertheless enters the momentum balance 3.46: the head curve was fitted to the same
/// transmitter, so the two offsets cancel there. See [`ReturnLine::b_is_offset`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Friction {
    /// `B`, Pa.
    pub b_pa: f64,
    /// `C`, Pa·s/m³.
    pub c_pa_s_m3: f64,
    /// `D`, Pa·s²/m⁶.
    pub d_pa_s2_m6: f64,
    /// `E`, Pa·s³/m⁹.
    pub e_pa_s3_m9: f64,
}

impl Friction {
    /// `F(q)` in Pa, with `B`.
    #[must_use]
    #[inline(always)]
    pub fn loss_pa(&self, flow_m3_s: f64) -> f64 {
        let size = flow_m3_s.abs();
        self.b_pa + flow_m3_s * (self.c_pa_s_m3 + size * (self.d_pa_s2_m6 + size * self.e_pa_s3_m9))
    }

    /// `dF/dq` in Pa·s/m³.
    #[must_use]
    #[inline(always)]
    pub fn slope_pa_s_m3(&self, flow_m3_s: f64) -> f64 {
        let size = flow_m3_s.abs();
        self.c_pa_s_m3 + size * (2.0 * self.d_pa_s2_m6 + size * 3.0 * self.e_pa_s3_m9)
    }
}

/// Head of the subsea pump (Eq. 3.39), `H = c0·w^n0 − c1·w·q − c2·q|q|^(n2−1)`, m of mud, with the
/// speed `w` in percent and the flow `q` in m³/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PumpHead {
    /// `c0`, m/%^n0.
    pub c0: f64,
    /// `c1`, m·s/(%·m³).
    pub c1: f64,
    /// `c2`, m/(m³/s)^n2.
    pub c2: f64,
    /// Exponent of the speed, at least 1.
    pub n0: f64,
    /// Exponent of the flow, at least 1.
    pub n2: f64,
}

impl PumpHead {
    /// Head in m of mud, continued as `dgd_pump::HeadCurve` is: oddly to flows below 0, and a speed below 0 counts as 0, while a NaN stays
    /// one. Simulations refuse such speeds.
    #[must_use]
    pub fn head_m(&self, speed_pct: f64, flow_m3_s: f64) -> f64 {
        // Not `max`, which would hide a NaN.
        let w = if speed_pct < 0.0 { 0.0 } else { speed_pct };
        let powers = (w.powf(self.n0), flow_m3_s.abs().powf(self.n2));
        self.head_of(powers, w, flow_m3_s)
    }

    /// The same with `w^n0` and `|q|^n2` known, which are dear, and the speed at least 0.
    fn head_of(&self, (spun, swept): (f64, f64), speed_pct: f64, flow_m3_s: f64) -> f64 {
        self.c0 * spun - self.c1 * speed_pct * flow_m3_s - self.c2 * swept.copysign(flow_m3_s)
    }
}

/// Parameters of riser, pump and discharge line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnLine {
    /// Mud density ρ, kg/m³.
    pub density_kg_m3: f64,
    /// Free cross-section of the riser `A_a`, m².
    pub riser_area_m2: f64,
    /// Cross-section of the discharge line `A_MRL`, m².
    pub line_area_m2: f64,
    /// Depth of the pump inlet `h_in`, m below the riser's top.
    pub inlet_depth_m: f64,
    /// Depth of the pump outlet `h_out`, m below the line's outlet.
    pub outlet_depth_m: f64,
    /// Friction of the discharge line.
    pub friction: Friction,
    /// Head of the pump.
    pub pump: PumpHead,
    /// True: a valve keeps the line from running back through the pump, `q ≥ 0`.
    pub non_return_valve: bool,
    /// False, as in Eq. 3.46: `B` acts on the flow. True: `B` only shifts the outlet transmitter
    /// (for a head curve that is free of that offset).
    pub b_is_offset: bool,
}

impl ReturnLine {
    /// Checks that every parameter is finite, the geometry positive and the exponents at least 1.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] with the first that is not.
    pub fn check(&self) -> Result<(), DynamicsError> {
        let refuse = |name, found, expected| {
            Err(DynamicsError::Parameter {
                name,
                found,
                expected,
            })
        };
        for (name, found) in [
            ("density_kg_m3", self.density_kg_m3),
            ("riser_area_m2", self.riser_area_m2),
            ("line_area_m2", self.line_area_m2),
            ("inlet_depth_m", self.inlet_depth_m),
            ("outlet_depth_m", self.outlet_depth_m),
        ] {
            if !(found > 0.0 && found.is_finite()) {
                return refuse(name, found, "a positive finite number");
            }
        }
        let (f, p) = (&self.friction, &self.pump);
        for (name, found) in [
            ("b_pa", f.b_pa),
            ("c_pa_s_m3", f.c_pa_s_m3),
            ("d_pa_s2_m6", f.d_pa_s2_m6),
            ("e_pa_s3_m9", f.e_pa_s3_m9),
            ("c0", p.c0),
            ("c1", p.c1),
            ("c2", p.c2),
        ] {
            if !found.is_finite() {
                return refuse(name, found, "a finite number");
            }
        }
        for (name, found) in [("n0", p.n0), ("n2", p.n2)] {
            // Below 1 the slope at standstill is infinite and no start is well posed.
            if !(found >= 1.0 && found.is_finite()) {
                return refuse(name, found, "a finite exponent of at least 1");
            }
        }
        Ok(())
    }

    /// Inertia `M` of the moving mud, kg/m⁴ (Eq. 2.46): `ρ·(h_in − h_r)/A_a + ρ·h_out/A_MRL`.
    #[must_use]
    pub fn inertia_kg_m4(&self, level_m: f64) -> f64 {
        self.density_kg_m3
            * ((self.inlet_depth_m - level_m).max(0.0) / self.riser_area_m2
                + self.outlet_depth_m / self.line_area_m2)
    }

    /// Pressure at the pump inlet, Pa (Eq. 2.49): `p0 + ρ·g·(h_in − h_r)`.
    #[must_use]
    pub fn inlet_pressure_pa(&self, level_m: f64) -> f64 {
        ATMOSPHERE_PA + self.density_kg_m3 * GRAVITY_M_S2 * (self.inlet_depth_m - level_m)
    }

    /// Riser level, m below the top, from the inlet pressure (Eq. 4.1):
    /// `h_in − (P_in − p0)/(ρ·g)`.
    #[must_use]
    pub fn level_from_inlet_pressure(&self, inlet_pa: f64) -> f64 {
        self.inlet_depth_m - (inlet_pa - ATMOSPHERE_PA) / (self.density_kg_m3 * GRAVITY_M_S2)
    }

    /// Pressure at the pump outlet in steady flow, Pa (Eq. 3.13): `p0 + ρ·g·h_out + F(q)`.
    #[must_use]
    pub fn outlet_pressure_pa(&self, flow_m3_s: f64) -> f64 {
        ATMOSPHERE_PA
            + self.density_kg_m3 * GRAVITY_M_S2 * self.outlet_depth_m
            + self.friction.loss_pa(flow_m3_s)
    }

    /// Net pressure that accelerates the flow, Pa: the bracket of Eq. 3.46, generalised to
    /// `h_in ≠ h_out`. A speed below 0 counts as 0 ([`PumpHead::head_m`]).
    #[must_use]
    pub fn drive_pa(&self, level_m: f64, speed_pct: f64, flow_m3_s: f64) -> f64 {
        self.drive_under(level_m, flow_m3_s, self.pump.head_m(speed_pct, flow_m3_s))
    }

    /// The same with the head known, m of mud: its powers are dear.
    fn drive_under(&self, level_m: f64, flow_m3_s: f64, head_m: f64) -> f64 {
        let rho_g = self.density_kg_m3 * GRAVITY_M_S2;
        let lift = level_m + self.outlet_depth_m - self.inlet_depth_m;
        let offset = if self.b_is_offset {
            self.friction.b_pa
        } else {
            0.0
        };
        rho_g * (head_m - lift) - (self.friction.loss_pa(flow_m3_s) - offset)
    }
}
