//! The subsea pump: a multistage centrifugal machine on a frequency converter.
//!
//! Head is built from the velocity triangles and the losses, not from a polynomial in speed and
//! flow: Euler head with slip, less incidence and channel losses, with leakage past the wear rings.
//! The converter maps 0-100 % onto a lowest and a highest speed, and the motor slips under load, so that the
//! affinity laws hold for the shaft and not for the set-point an operator sees.

use crate::constants::GRAVITY_M_S2;

/// What the pump and its drive are built of.
#[derive(Debug, Clone, PartialEq)]
pub struct PumpParameters {
    /// Tip speed of the impellers at full shaft speed, m/s.
    pub tip_speed_m_s: f64,
    /// Number of stages in series.
    pub stages: f64,
    /// Wiesner's slip factor.
    pub slip_factor: f64,
    /// Outlet area of one impeller, m².
    pub outlet_area_m2: f64,
    /// Cotangent of the blade angle at the outlet.
    pub blade_cotangent: f64,
    /// Flow without incidence at full shaft speed, m³/s.
    pub design_flow_m3_s: f64,
    /// Incidence loss over all stages, m per (m³/s)².
    pub incidence_s2_m5: f64,
    /// Channel friction over all stages at 0.05 m³/s, m.
    pub channel_loss_m: f64,
    /// Exponent of the channel friction: 1 laminar, 2 rough.
    pub channel_exponent: f64,
    /// Leakage past the wear rings, m³/s per square root of a metre of head.
    pub leakage_m3_s_m05: f64,
    /// Shaft speed at a set-point of 0 %, as a fraction of full speed.
    pub lowest_speed: f64,
    /// Fraction of speed the motor slips at full load.
    pub motor_slip: f64,
    /// Fastest change of speed the converter allows, % per second.
    pub slew_pct_s: f64,
}

impl PumpParameters {
    /// Shaft speed as a fraction of full speed, at a set-point of `speed_pct`.
    pub fn shaft(&self, speed_pct: f64) -> f64 {
        if speed_pct <= 0.0 {
            return 0.0;
        }
        let s = speed_pct / 100.0;
        (self.lowest_speed + (1.0 - self.lowest_speed) * s) * (1.0 - self.motor_slip * s * s)
    }

    /// Head in metres of the fluid pumped, at a shaft speed (fraction of full) and a flow.
    ///
    /// A flow backwards through the pump meets the resistance of its passages.
    pub fn head_m(&self, shaft: f64, flow_m3_s: f64) -> f64 {
        let tip = self.tip_speed_m_s * shaft;
        let euler0 = self.stages * self.slip_factor * tip * tip / GRAVITY_M_S2;
        let leak = self.leakage_m3_s_m05 * euler0.sqrt();
        let through = flow_m3_s.max(0.0) + leak;
        let meridional = through / self.outlet_area_m2;
        let euler = euler0 - self.stages * tip * meridional * self.blade_cotangent / GRAVITY_M_S2;
        let off_design = through - self.design_flow_m3_s * shaft;
        let incidence = self.incidence_s2_m5 * off_design * off_design;
        let channel = self.channel_loss_m * (through / 0.05).powf(self.channel_exponent);
        let forward = euler - incidence - channel;
        if flow_m3_s < 0.0 {
            forward + 2.0 * self.incidence_s2_m5 * flow_m3_s * flow_m3_s
        } else {
            forward
        }
    }
}

/// The drive's state: where the speed is on its way to the set-point.
#[derive(Debug, Clone, Default)]
pub(crate) struct Drive {
    pub(crate) speed_pct: f64,
}

impl Drive {
    pub(crate) fn step(&mut self, dt_s: f64, setpoint_pct: f64, slew_pct_s: f64) {
        let most = slew_pct_s * dt_s;
        self.speed_pct += (setpoint_pct - self.speed_pct).clamp(-most, most);
    }

    /// Follows the set-point with a first-order lag instead; stands once it hardly turns.
    pub(crate) fn follow(&mut self, dt_s: f64, setpoint_pct: f64, tau_s: f64) {
        self.speed_pct += (setpoint_pct - self.speed_pct) * (1.0 - (-dt_s / tau_s).exp());
        if setpoint_pct <= 0.0 && self.speed_pct < 0.1 {
            self.speed_pct = 0.0;
        }
    }
}

/// The non-return valve behind the pump.
#[derive(Debug, Clone)]
pub(crate) struct NonReturnValve {
    opening: f64,
    leak: f64,
    close_s: f64,
    loss_pa_s2_m6: f64,
}

impl NonReturnValve {
    pub(crate) fn new(leak: f64, close_s: f64, loss_pa_s2_m6: f64) -> Self {
        Self {
            opening: leak,
            leak,
            close_s,
            loss_pa_s2_m6,
        }
    }

    /// Opens within a second under forward pressure, closes within `close_s` without it.
    pub(crate) fn step(&mut self, dt_s: f64, forward: bool) {
        let change = if forward { dt_s } else { -dt_s / self.close_s };
        self.opening = (self.opening + change).clamp(self.leak, 1.0);
    }

    pub(crate) fn loss_pa(&self, flow_m3_s: f64) -> f64 {
        self.loss_pa_s2_m6 * flow_m3_s * flow_m3_s.abs() / (self.opening * self.opening)
    }
}
