//! The catalogue's effects, their sizes, and the truth that is written about them.

use crate::cause::{Cause, Foreign};
use crate::conceal::rig::{Level, Rig};
use crate::noise::Noise;

const FRICTION: &[&str] = &["return_line_friction"];
const HEAD: &[&str] = &["pump_head"];
const BALANCE: &[&str] = &["riser_mass_balance"];
const FRICTION_HEAD: &[&str] = &["return_line_friction", "pump_head"];
const FRICTION_BALANCE: &[&str] = &["return_line_friction", "riser_mass_balance"];
const HEAD_BALANCE: &[&str] = &["pump_head", "riser_mass_balance"];

/// Ids of the catalogue, in the order cases take their turns.
pub const EFFECTS: [&str; 24] = [
    "return_flow_delay",
    "return_flow_gain",
    "inflow_gain",
    "outlet_pressure_bias",
    "outlet_pressure_bias_step",
    "mud_density_change",
    "cuttings_loading",
    "yield_stress",
    "gel_strength",
    "line_drainage",
    "pump_wear",
    "gas_in_pump",
    "pump_speed_lag",
    "influx",
    "lost_circulation",
    "u_tube",
    "booster_line_storage",
    "annulus_area",
    "pipe_displacement",
    "heave",
    "viscosity_drift",
    "line_restriction",
    "line_leak",
    "line_gas_storage",
];

/// Kinds of effects outside the catalogue, in the order cases take their turns.
pub const FOREIGN: [&str; 10] = [
    "head_ripple_level",
    "booster_crosstalk",
    "meter_fouling",
    "inlet_filter_clog",
    "topfill_offset",
    "friction_hysteresis",
    "speed_band",
    "inlet_temperature",
    "choke_stick",
    "friction_swell",
];

/// How large an effect is, as a share of the moderate size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// 0.08: mostly nothing can be seen.
    Trace,
    /// 0.2
    Faint,
    /// 0.5
    Subtle,
    /// 1
    Moderate,
    /// 2
    Strong,
}

impl Severity {
    /// All, in the order cases take their turns.
    pub const ALL: [Self; 5] = [
        Self::Moderate,
        Self::Faint,
        Self::Subtle,
        Self::Strong,
        Self::Trace,
    ];

    /// Share of the moderate size.
    pub fn factor(self) -> f64 {
        match self {
            Self::Trace => 0.08,
            Self::Faint => 0.2,
            Self::Subtle => 0.5,
            Self::Moderate => 1.0,
            Self::Strong => 2.0,
        }
    }

    /// Name in the truth.
    pub fn name(self) -> &'static str {
        match self {
            Self::Trace => "trace",
            Self::Faint => "faint",
            Self::Subtle => "subtle",
            Self::Moderate => "moderate",
            Self::Strong => "strong",
        }
    }

    /// The severity of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }
}

/// One concealed effect: the cause that is simulated, and what the truth says of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// Id of the catalogue, or `unknown`.
    pub effect: &'static str,
    /// Kind of an unknown effect.
    pub kind: Option<&'static str>,
    /// How large.
    pub severity: Severity,
    /// Scored parameters, SI.
    pub params: Vec<(&'static str, f64)>,
    /// More about it, SI; not scored.
    pub extra: Vec<(&'static str, f64)>,
    /// When, s from the start; `None` where it is always there.
    pub interval_s: Option<(f64, f64)>,
    /// Relations of the model it shows in.
    pub relation: &'static [&'static str],
    /// What the plant simulates.
    pub cause: Cause,
}

/// From this length on, s, recordings are of days.
const DAYS_S: f64 = 12.0 * 3600.0;

/// Draws an effect of the catalogue for a rig; `None` for an id that is not in [`EFFECTS`].
#[expect(
    clippy::too_many_lines,
    reason = "one arm an effect, each a line of the catalogue"
)]
pub(crate) fn draw(id: &str, severity: Severity, rig: &Rig, noise: &mut Noise) -> Option<Hidden> {
    let effect = EFFECTS.into_iter().find(|e| *e == id)?;
    let f = severity.factor();
    let end = rig.length_s;
    // Drawn for every effect, so that a case differs from its neighbours in its effect alone.
    let size = f * noise.between(0.8, 1.2);
    let sign = if noise.unit() < 0.5 { -1.0 } else { 1.0 };
    // In days a cause may set in hours before the end.
    let (early, late) = if end > DAYS_S {
        (0.03, 0.97)
    } else {
        (0.33, 0.6)
    };
    let onset_s = (end * noise.between(early, late)).round();
    let lasts_s = noise.between(0.6, 1.0) * 3600.0;
    let choice = noise.unit();
    let second = noise.unit();
    let since = Some((onset_s, end));
    let span_s = (onset_s, (onset_s + lasts_s).min(end - 600.0));
    let area = rig.well.annulus_area_m2();
    let gain = 1.0 + sign * 0.04 * size;
    let mut extra = Vec::new();
    let (cause, params, interval_s, relation): (Cause, Vec<(&'static str, f64)>, _, _) = match id {
        "return_flow_delay" => {
            let delay_s = (8.0 + f * (2.0 + 4.0 * choice)).round();
            let cause = Cause::ReturnFlowDelay {
                delay_s: delay_s - rig.base_delay_s,
            };
            (cause, vec![("delay_s", delay_s)], None, FRICTION_HEAD)
        }
        "return_flow_gain" => (
            Cause::ReturnFlowGain { gain },
            vec![("gain", gain)],
            None,
            BALANCE,
        ),
        "inflow_gain" => (
            Cause::InflowGain { gain },
            vec![("gain", gain)],
            None,
            BALANCE,
        ),
        "outlet_pressure_bias" => {
            let bias_pa = sign * 6e4 * size;
            (
                Cause::OutletPressureBias { bias_pa },
                vec![("bias_pa", bias_pa)],
                None,
                FRICTION_HEAD,
            )
        }
        "outlet_pressure_bias_step" => {
            let bias_pa = sign * 5e4 * size;
            let sensor: u8 = if choice < 0.5 { 1 } else { 2 };
            (
                Cause::OutletPressureBiasStep {
                    bias_pa,
                    sensor,
                    onset_s,
                },
                vec![("bias_pa", bias_pa), ("sensor", f64::from(sensor))],
                since,
                FRICTION,
            )
        }
        "mud_density_change" => {
            let delta_rho_kg_m3 = sign * 40.0 * size;
            (
                Cause::MudDensityChange {
                    delta_rho_kg_m3,
                    onset_s,
                },
                vec![("delta_rho_kg_m3", delta_rho_kg_m3)],
                since,
                FRICTION,
            )
        }
        "cuttings_loading" => {
            let delta_rho_kg_m3 = 22.0 * size;
            (
                Cause::CuttingsLoading { delta_rho_kg_m3 },
                vec![("delta_rho_kg_m3", delta_rho_kg_m3)],
                None,
                FRICTION,
            )
        }
        "yield_stress" => {
            let friction_pa = 5e4 * size;
            let tau_pa = friction_pa * 3.0 * rig.well.return_line_id_m
                / (16.0 * rig.well.pump_outlet_depth_m);
            extra.push(("tau_y_pa", tau_pa));
            (
                Cause::YieldStress {
                    tau_pa,
                    turbulent_share: 0.4 + 0.6 * choice,
                },
                Vec::new(),
                None,
                FRICTION,
            )
        }
        "gel_strength" => {
            let tau_gel_pa = 12.0 * size;
            let line_m3 = rig.well.return_line_area_m2() * rig.well.pump_outlet_depth_m;
            (
                Cause::GelStrength {
                    tau_gel_pa,
                    build_s: 200.0 + 150.0 * choice,
                    break_m3: line_m3 * (0.4 + 0.6 * second),
                },
                vec![("tau_gel_pa", tau_gel_pa)],
                None,
                FRICTION,
            )
        }
        "line_drainage" => {
            let rate_m_s = 0.12 * size;
            (
                Cause::LineDrainage { rate_m_s },
                vec![("rate_m_s", rate_m_s)],
                None,
                FRICTION,
            )
        }
        "pump_wear" => {
            let leak_growth_m3_s2 = 0.025 * size * rig.leak_for_all_head_m3_s() / end;
            extra.push(("leak_growth", leak_growth_m3_s2));
            (
                Cause::PumpWear { leak_growth_m3_s2 },
                Vec::new(),
                None,
                HEAD,
            )
        }
        "gas_in_pump" => {
            let head_loss_fraction = 0.07 * size;
            let span_s = (
                onset_s,
                (onset_s + noise.between(1800.0, 3600.0)).min(end - 600.0),
            );
            (
                Cause::GasInPump {
                    head_loss_fraction,
                    span_s,
                },
                vec![("head_loss_fraction", head_loss_fraction)],
                Some(span_s),
                HEAD,
            )
        }
        "pump_speed_lag" => {
            let tau_s = 18.0 * size;
            (
                Cause::PumpSpeedLag { tau_s },
                vec![("tau_s", tau_s)],
                None,
                HEAD,
            )
        }
        "influx" => {
            let rate_m3_s = 0.0022 * size;
            (
                Cause::Influx { rate_m3_s, span_s },
                vec![("rate_m3_s", rate_m3_s)],
                Some(span_s),
                BALANCE,
            )
        }
        "lost_circulation" => {
            let j_m3_s_pa = 2.5e-8 * size;
            let fracture_pa = rig.inlet_pa() - 1e5 * (0.8 + 1.7 * choice);
            extra.push(("p_frac_pa", fracture_pa));
            (
                Cause::LostCirculation {
                    j_m3_s_pa,
                    fracture_pa,
                    onset_s,
                },
                vec![("J_m3_s_pa", j_m3_s_pa)],
                since,
                BALANCE,
            )
        }
        "u_tube" => {
            // 24 s is faint: the moderate 60 s less what every string has.
            let tau_s = (15.0 + 45.0 * f) * noise.between(0.9, 1.1);
            // At level two a valve in the string holds some of it back in half of the rigs.
            let held = noise.unit().mul_add(2.0, -1.0).max(0.0);
            let drains_s = match rig.level {
                Level::One => tau_s,
                Level::Two => tau_s * (1.0 - 0.8 * held),
            };
            extra.extend([("tau_s", tau_s), ("drains_s", drains_s)]);
            (Cause::UTube { tau_s, drains_s }, Vec::new(), None, BALANCE)
        }
        "booster_line_storage" => {
            let tau_s = 35.0 * size;
            (
                Cause::BoosterLineStorage { tau_s },
                vec![("tau_s", tau_s)],
                None,
                BALANCE,
            )
        }
        "annulus_area" => {
            // Either another pipe or riser than the file says, or, as practice has it, on the way to the casing's annulus.
            let change = if choice < 0.5 {
                sign * 0.12 * size
            } else {
                f * (rig.casing_area_m2() / area - 1.0)
            };
            let area_m2 = area * (1.0 + change).max(0.3);
            (
                Cause::AnnulusArea { area_m2 },
                vec![("area_m2", area_m2)],
                None,
                BALANCE,
            )
        }
        "pipe_displacement" => {
            let volume_m3 = 0.25 * size;
            (
                Cause::PipeDisplacement {
                    volume_m3,
                    before_start: choice < 0.5,
                },
                vec![("volume_m3", volume_m3)],
                None,
                BALANCE,
            )
        }
        "heave" => {
            let (period_s, amplitude_m) = (8.0 + 6.0 * choice, 0.5 * size);
            extra.push(("amplitude_m", amplitude_m));
            (
                Cause::Heave {
                    period_s,
                    amplitude_m,
                },
                vec![("period_s", period_s)],
                None,
                HEAD_BALANCE,
            )
        }
        "viscosity_drift" => {
            let relative_mu_change = (sign * 0.6 * size).max(-0.8);
            (
                Cause::ViscosityDrift {
                    relative_mu_change,
                    length_s: end,
                },
                vec![("relative_mu_change", relative_mu_change)],
                None,
                FRICTION,
            )
        }
        "line_restriction" => {
            let k = 14.0 * size;
            (
                Cause::LineRestriction { k, onset_s },
                vec![("K", k)],
                since,
                FRICTION,
            )
        }
        "line_leak" => {
            let c = 1.96e-6 * size;
            extra.push(("C", c));
            (Cause::LineLeak { c, onset_s }, Vec::new(), since, BALANCE)
        }
        _ => {
            let tau_s = 18.0 * size;
            // At level two gas is spread along the line in half of the rigs: two cushions.
            let spread = rig.level == Level::Two && noise.unit() < 0.5;
            let second = if spread { 0.5 * tau_s } else { 0.0 };
            extra.push(("second_s", second));
            (
                Cause::LineGasStorage {
                    cushions_s: [tau_s - second, second],
                },
                vec![("tau_s", tau_s)],
                None,
                FRICTION_BALANCE,
            )
        }
    };
    Some(Hidden {
        effect,
        kind: None,
        severity,
        params,
        extra,
        interval_s,
        relation,
        cause,
    })
}

/// Draws an effect outside the catalogue; `None` for a kind that is not in [`FOREIGN`].
pub(crate) fn draw_foreign(
    kind: &str,
    severity: Severity,
    rig: &Rig,
    noise: &mut Noise,
) -> Option<Hidden> {
    let size = severity.factor() * noise.between(0.8, 1.2);
    let choice = noise.unit();
    let sign = if noise.unit() < 0.5 { -1.0 } else { 1.0 };
    let end = rig.length_s;
    let (foreign, relation): (_, &'static [&'static str]) = match kind {
        "head_ripple_level" => (
            Foreign::HeadRippleLevel(sign * 0.03 * size, 8.0 + 10.0 * choice),
            HEAD,
        ),
        "booster_crosstalk" => (
            Foreign::BoosterCrosstalk(sign * 5e4 * size / 0.0158),
            &["return_line_friction", "pump_head", "instrument"],
        ),
        "meter_fouling" => (
            Foreign::MeterFouling(sign * 0.05 * size, 0.03 + 0.02 * choice, end),
            &["riser_mass_balance", "instrument"],
        ),
        "inlet_filter_clog" => (
            Foreign::InletFilterClog(1.2e5 * size / 0.05_f64.powi(2), 3600.0 * (0.8 + choice)),
            &["pump_head", "instrument"],
        ),
        "topfill_offset" => (Foreign::TopfillOffset(sign * 1.4e-3 * size), BALANCE),
        "friction_hysteresis" => (Foreign::FrictionHysteresis(6e4 * size), FRICTION),
        "speed_band" => (
            Foreign::SpeedBand(sign * 4.0 * size, 55.0 + 10.0 * choice),
            HEAD,
        ),
        "inlet_temperature" => (
            Foreign::InletTemperature(4e4 * size, 3600.0 * (1.2 + 2.0 * choice)),
            &["pump_head", "riser_mass_balance", "instrument"],
        ),
        "choke_stick" => (Foreign::ChokeStick(0.0, 12.0 * size), FRICTION),
        "friction_swell" => (
            Foreign::FrictionSwell(sign * 0.2 * size, 1200.0 + 2400.0 * choice),
            FRICTION,
        ),
        _ => return None,
    };
    Some(Hidden {
        effect: "unknown",
        kind: Some(foreign.kind()),
        severity,
        params: Vec::new(),
        extra: Vec::new(),
        interval_s: None,
        relation,
        cause: Cause::Foreign(foreign),
    })
}
