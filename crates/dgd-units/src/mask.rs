//! Percentages of undisclosed reference values (Eqs. 3.9-3.12).

/// The values that stand for 100 %. Whoever knows them can read the masked
/// numbers, so they never enter a masked artefact.
///
/// ```
/// use dgd_units::{FullScale, MaskReferences};
/// let full = FullScale { flow_m3_s: 0.06, friction_pa: 5e5, head_m: 300.0, level_m: 200.0 };
/// let references = MaskReferences::new(full)?;
/// assert_eq!(references.mask_flow(0.03), 50.0);
/// // 2e8 Pa/(m³/s)² at 50 % flow is 180 kPa, 36 % friction, either way round.
/// let masked = references.mask_friction_coefficient(2e8, 2.0);
/// assert!((masked * 50.0f64.powi(2) - references.mask_friction(2e8 * 0.03f64.powi(2))).abs() < 1e-9);
/// # Ok::<(), dgd_units::MaskError>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct MaskReferences {
    flow_m3_s: f64,
    friction_pa: f64,
    head_m: f64,
    level_m: f64,
}

/// What stands for 100 %, by name: head and level are both in m.
///
/// As confidential as [`MaskReferences`], and so without `Debug`.
#[derive(Clone, Copy, PartialEq)]
pub struct FullScale {
    /// Flow, m³/s.
    pub flow_m3_s: f64,
    /// Friction, Pa.
    pub friction_pa: f64,
    /// Pump head, m.
    pub head_m: f64,
    /// Riser level, m.
    pub level_m: f64,
}

/// Hides the values, so that no log line or panic message can disclose them.
impl std::fmt::Debug for MaskReferences {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("MaskReferences(undisclosed)")
    }
}

/// A reference that cannot stand for 100 %.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the {name} reference must be a positive finite number")]
pub struct MaskError {
    /// Which reference; its value is confidential and stays out of the message.
    pub name: &'static str,
}

impl MaskReferences {
    /// From the values that stand for 100 %.
    ///
    /// # Errors
    /// [`MaskError`] naming the first reference that is not positive and finite.
    pub fn new(full: FullScale) -> Result<Self, MaskError> {
        let FullScale {
            flow_m3_s,
            friction_pa,
            head_m,
            level_m,
        } = full;
        let named = [
            ("flow", flow_m3_s),
            ("friction", friction_pa),
            ("head", head_m),
            ("level", level_m),
        ];
        match named
            .into_iter()
            .find(|(_, value)| !(value.is_normal() && *value > 0.0))
        {
            Some((name, _)) => Err(MaskError { name }),
            None => Ok(Self {
                flow_m3_s,
                friction_pa,
                head_m,
                level_m,
            }),
        }
    }

    /// The four 100 % values, for whoever keeps them: flow m³/s, friction Pa, head m, level m.
    pub fn disclose(&self) -> [f64; 4] {
        [self.flow_m3_s, self.friction_pa, self.head_m, self.level_m]
    }

    /// Friction in Pa as a percentage (Eq. 3.9).
    pub fn mask_friction(&self, friction_pa: f64) -> f64 {
        friction_pa / self.friction_pa * 100.0
    }

    /// Percentage of friction back to Pa.
    pub fn unmask_friction(&self, percent: f64) -> f64 {
        percent / 100.0 * self.friction_pa
    }

    /// Flow in m³/s as a percentage (Eq. 3.10).
    pub fn mask_flow(&self, flow_m3_s: f64) -> f64 {
        flow_m3_s / self.flow_m3_s * 100.0
    }

    /// Percentage of flow back to m³/s.
    pub fn unmask_flow(&self, percent: f64) -> f64 {
        percent / 100.0 * self.flow_m3_s
    }

    /// Pump head in m as a percentage (Eq. 3.11).
    pub fn mask_head(&self, head_m: f64) -> f64 {
        head_m / self.head_m * 100.0
    }

    /// Percentage of head back to m.
    pub fn unmask_head(&self, percent: f64) -> f64 {
        percent / 100.0 * self.head_m
    }

    /// Riser level in m as a percentage (Eq. 3.12).
    pub fn mask_level(&self, level_m: f64) -> f64 {
        level_m / self.level_m * 100.0
    }

    /// Percentage of riser level back to m.
    pub fn unmask_level(&self, percent: f64) -> f64 {
        percent / 100.0 * self.level_m
    }

    /// Coefficient of q^`power` in a friction law, from Pa/(m³/s)^power to %/%^power.
    pub fn mask_friction_coefficient(&self, coefficient: f64, power: f64) -> f64 {
        self.mask_friction(coefficient * (self.flow_m3_s / 100.0).powf(power))
    }

    /// Inverse of [`Self::mask_friction_coefficient`].
    pub fn unmask_friction_coefficient(&self, masked: f64, power: f64) -> f64 {
        self.unmask_friction(masked) / (self.flow_m3_s / 100.0).powf(power)
    }

    /// Coefficient of q^`power` in a head curve, from m/(m³/s)^power to %/%^power.
    ///
    /// Pump speed is a percentage already, so its exponent does not matter.
    pub fn mask_head_coefficient(&self, coefficient: f64, power: f64) -> f64 {
        self.mask_head(coefficient * (self.flow_m3_s / 100.0).powf(power))
    }

    /// Inverse of [`Self::mask_head_coefficient`].
    pub fn unmask_head_coefficient(&self, masked: f64, power: f64) -> f64 {
        self.unmask_head(masked) / (self.flow_m3_s / 100.0).powf(power)
    }
}
