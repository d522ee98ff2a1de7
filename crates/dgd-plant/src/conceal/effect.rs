//! The catalogue's effects, their sizes, and the truth that is written about them.

use crate::cause::{Cause, Foreign, Spans};
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
    /// When it comes again, s from the start.
    pub again_s: Option<(f64, f64)>,
    /// Relations of the model it shows in.
    pub relation: &'static [&'static str],
    /// What the plant simulates.
    pub cause: Cause,
}

/// From this length on, s, recordings are of days.
const DAYS_S: f64 = 12.0 * 3600.0;

/// What is drawn for every effect, used or not, so that a case differs from its neighbours in its effect alone.
struct Lot {
    effect: &'static str,
    severity: Severity,
    /// Share of the moderate size that the severity says.
    factor: f64,
    /// The same, drawn about it.
    size: f64,
    sign: f64,
    onset_s: f64,
    end_s: f64,
    lasts_s: f64,
    choice: f64,
    second: f64,
}

impl Lot {
    fn draw(effect: &'static str, severity: Severity, rig: &Rig, noise: &mut Noise) -> Self {
        let end_s = rig.length_s;
        // In days a cause may set in hours before the end.
        let (early, late) = if end_s > DAYS_S {
            (0.03, 0.97)
        } else {
            (0.33, 0.6)
        };
        // Evaluated in this order: a seed stands for its case.
        Self {
            effect,
            severity,
            factor: severity.factor(),
            size: severity.factor() * noise.between(0.8, 1.2),
            sign: noise.sign(),
            onset_s: (end_s * noise.between(early, late)).round(),
            end_s,
            lasts_s: noise.between(0.6, 1.0) * 3600.0,
            choice: noise.unit(),
            second: noise.unit(),
        }
    }

    /// The effect as this cause, always there, without parameters.
    fn hides(&self, cause: Cause, relation: &'static [&'static str]) -> Hidden {
        Hidden {
            effect: self.effect,
            kind: None,
            severity: self.severity,
            params: Vec::new(),
            extra: Vec::new(),
            interval_s: None,
            again_s: None,
            relation,
            cause,
        }
    }

    /// Measured over true, of a meter.
    fn gain(&self) -> f64 {
        1.0 + self.sign * 0.04 * self.size
    }

    /// From the onset on.
    fn stays(&self) -> Spans {
        Spans::since(self.onset_s)
    }

    /// From the onset to the end.
    fn since(&self) -> (f64, f64) {
        (self.onset_s, self.end_s)
    }

    /// From the onset, and over well before the end.
    fn span_s(&self, lasts_s: f64) -> (f64, f64) {
        let until_s = (self.onset_s + lasts_s).min(self.end_s - 600.0);
        (self.onset_s, until_s)
    }
}

impl Hidden {
    fn scored(mut self, name: &'static str, value: f64) -> Self {
        self.params.push((name, value));
        self
    }

    fn also(mut self, name: &'static str, value: f64) -> Self {
        self.extra.push((name, value));
        self
    }

    fn during(mut self, interval_s: (f64, f64)) -> Self {
        self.interval_s = Some(interval_s);
        self
    }
}

/// Effects that set in and may end again, in the order cases take their turns.
pub const PASSING: [&str; 5] = [
    "outlet_pressure_bias_step",
    "mud_density_change",
    "line_restriction",
    "line_leak",
    "lost_circulation",
];

/// Effects that may come again, in the order cases take their turns.
pub const RECURRING: [&str; 7] = [
    "outlet_pressure_bias_step",
    "mud_density_change",
    "line_restriction",
    "line_leak",
    "lost_circulation",
    "influx",
    "gas_in_pump",
];

impl Hidden {
    /// The same, ended after a tenth to a third of the recording.
    pub(crate) fn ending(self, length_s: f64, noise: &mut Noise) -> Self {
        let lasts_s = (length_s * noise.between(0.1, 0.3)).round();
        let onset_s = self.interval_s.map_or(0.0, |(from, _)| from);
        self.acting(Spans::once((onset_s, onset_s + lasts_s)))
    }

    /// The same, early in the recording and as long once more.
    pub(crate) fn recurring(self, length_s: f64, noise: &mut Noise) -> Self {
        let [onset_s, lasts_s, apart_s] = [(0.12, 0.25), (0.1, 0.2), (0.1, 0.25)]
            .map(|(least, most)| (length_s * noise.between(least, most)).round());
        let end_s = onset_s + lasts_s;
        let again_s = end_s + apart_s;
        self.acting(Spans {
            first_s: (onset_s, end_s),
            again_s: Some((again_s, again_s + lasts_s)),
        })
    }

    fn acting(mut self, when: Spans) -> Self {
        if let Cause::OutletPressureBiasStep { acts, .. }
        | Cause::MudDensityChange { acts, .. }
        | Cause::GasInPump { acts, .. }
        | Cause::Influx { acts, .. }
        | Cause::LostCirculation { acts, .. }
        | Cause::LineRestriction { acts, .. }
        | Cause::LineLeak { acts, .. } = &mut self.cause
        {
            *acts = when;
        }
        self.interval_s = Some(when.first_s);
        self.again_s = when.again_s;
        self
    }
}

/// Draws an effect of the catalogue for a rig; `None` for an id that is not in [`EFFECTS`].
pub(crate) fn draw(id: &str, severity: Severity, rig: &Rig, noise: &mut Noise) -> Option<Hidden> {
    let effect = EFFECTS.into_iter().find(|e| *e == id)?;
    let lot = Lot::draw(effect, severity, rig, noise);
    of_instrument(&lot, rig)
        .or_else(|| of_line(&lot, rig, noise))
        .or_else(|| of_pump(&lot, rig, noise))
        .or_else(|| of_inflow(&lot, rig, noise))
        .or_else(|| of_riser(&lot, rig))
}

fn of_instrument(lot: &Lot, rig: &Rig) -> Option<Hidden> {
    let Lot { size, sign, .. } = *lot;
    Some(match lot.effect {
        "return_flow_delay" => {
            let delay_s = (8.0 + lot.factor * (2.0 + 4.0 * lot.choice)).round();
            let cause = Cause::ReturnFlowDelay {
                delay_s: delay_s - rig.base_delay_s,
            };
            lot.hides(cause, FRICTION_HEAD).scored("delay_s", delay_s)
        }
        "return_flow_gain" => {
            let gain = lot.gain();
            lot.hides(Cause::ReturnFlowGain { gain }, BALANCE)
                .scored("gain", gain)
        }
        "inflow_gain" => {
            let gain = lot.gain();
            lot.hides(Cause::InflowGain { gain }, BALANCE)
                .scored("gain", gain)
        }
        "outlet_pressure_bias" => {
            let bias_pa = sign * 6e4 * size;
            let cause = Cause::OutletPressureBias { bias_pa };
            lot.hides(cause, FRICTION_HEAD).scored("bias_pa", bias_pa)
        }
        "outlet_pressure_bias_step" => {
            let bias_pa = sign * 5e4 * size;
            let sensor: u8 = if lot.choice < 0.5 { 1 } else { 2 };
            let cause = Cause::OutletPressureBiasStep {
                bias_pa,
                sensor,
                acts: lot.stays(),
            };
            lot.hides(cause, FRICTION)
                .during(lot.since())
                .scored("bias_pa", bias_pa)
                .scored("sensor", f64::from(sensor))
        }
        _ => return None,
    })
}

/// What is in the return line, and the mud that it carries.
fn of_line(lot: &Lot, rig: &Rig, noise: &mut Noise) -> Option<Hidden> {
    let size = lot.size;
    let well = &rig.well;
    Some(match lot.effect {
        "mud_density_change" => {
            let delta_rho_kg_m3 = lot.sign * 40.0 * size;
            let cause = Cause::MudDensityChange {
                delta_rho_kg_m3,
                acts: lot.stays(),
            };
            lot.hides(cause, FRICTION)
                .during(lot.since())
                .scored("delta_rho_kg_m3", delta_rho_kg_m3)
        }
        "cuttings_loading" => {
            let delta_rho_kg_m3 = 22.0 * size;
            lot.hides(Cause::CuttingsLoading { delta_rho_kg_m3 }, FRICTION)
                .scored("delta_rho_kg_m3", delta_rho_kg_m3)
        }
        "yield_stress" => {
            let friction_pa = 5e4 * size;
            let tau_pa =
                friction_pa * 3.0 * well.return_line_id_m / (16.0 * well.pump_outlet_depth_m);
            let cause = Cause::YieldStress {
                tau_pa,
                turbulent_share: 0.4 + 0.6 * lot.choice,
            };
            lot.hides(cause, FRICTION).also("tau_y_pa", tau_pa)
        }
        "gel_strength" => {
            let tau_gel_pa = 12.0 * size;
            let line_m3 = well.return_line_area_m2() * well.pump_outlet_depth_m;
            let cause = Cause::GelStrength {
                tau_gel_pa,
                build_s: 200.0 + 150.0 * lot.choice,
                break_m3: line_m3 * (0.4 + 0.6 * lot.second),
            };
            lot.hides(cause, FRICTION).scored("tau_gel_pa", tau_gel_pa)
        }
        "line_drainage" => {
            let rate_m_s = 0.12 * size;
            lot.hides(Cause::LineDrainage { rate_m_s }, FRICTION)
                .scored("rate_m_s", rate_m_s)
        }
        "viscosity_drift" => {
            let relative_mu_change = (lot.sign * 0.6 * size).max(-0.8);
            let cause = Cause::ViscosityDrift {
                relative_mu_change,
                length_s: lot.end_s,
            };
            lot.hides(cause, FRICTION)
                .scored("relative_mu_change", relative_mu_change)
        }
        "line_restriction" => {
            let k = 14.0 * size;
            lot.hides(
                Cause::LineRestriction {
                    k,
                    acts: lot.stays(),
                },
                FRICTION,
            )
            .during(lot.since())
            .scored("K", k)
        }
        "line_leak" => {
            let c = 1.96e-6 * size;
            lot.hides(
                Cause::LineLeak {
                    c,
                    acts: lot.stays(),
                },
                BALANCE,
            )
            .during(lot.since())
            .also("C", c)
        }
        "line_gas_storage" => {
            let tau_s = 18.0 * size;
            // At level two gas is spread along the line in half of the rigs: two cushions.
            let spread = rig.level == Level::Two && noise.unit() < 0.5;
            let second = if spread { 0.5 * tau_s } else { 0.0 };
            let cause = Cause::LineGasStorage {
                cushions_s: [tau_s - second, second],
            };
            lot.hides(cause, FRICTION_BALANCE)
                .scored("tau_s", tau_s)
                .also("second_s", second)
        }
        _ => return None,
    })
}

fn of_pump(lot: &Lot, rig: &Rig, noise: &mut Noise) -> Option<Hidden> {
    let size = lot.size;
    Some(match lot.effect {
        "pump_wear" => {
            let leak_growth_m3_s2 = 0.025 * size * rig.leak_for_all_head_m3_s() / lot.end_s;
            lot.hides(Cause::PumpWear { leak_growth_m3_s2 }, HEAD)
                .also("leak_growth", leak_growth_m3_s2)
        }
        "gas_in_pump" => {
            let head_loss_fraction = 0.07 * size;
            let span_s = lot.span_s(noise.between(1800.0, 3600.0));
            let cause = Cause::GasInPump {
                head_loss_fraction,
                acts: Spans::once(span_s),
            };
            lot.hides(cause, HEAD)
                .during(span_s)
                .scored("head_loss_fraction", head_loss_fraction)
        }
        "pump_speed_lag" => {
            let tau_s = 18.0 * size;
            lot.hides(Cause::PumpSpeedLag { tau_s }, HEAD)
                .scored("tau_s", tau_s)
        }
        _ => return None,
    })
}

/// What comes into the riser, or leaves it, otherwise than through the pump.
fn of_inflow(lot: &Lot, rig: &Rig, noise: &mut Noise) -> Option<Hidden> {
    let size = lot.size;
    Some(match lot.effect {
        "influx" => {
            let rate_m3_s = 0.0022 * size;
            let span_s = lot.span_s(lot.lasts_s);
            let acts = Spans::once(span_s);
            lot.hides(Cause::Influx { rate_m3_s, acts }, BALANCE)
                .during(span_s)
                .scored("rate_m3_s", rate_m3_s)
        }
        "lost_circulation" => {
            let j_m3_s_pa = 2.5e-8 * size;
            let fracture_pa = rig.inlet_pa() - 1e5 * (0.8 + 1.7 * lot.choice);
            let cause = Cause::LostCirculation {
                j_m3_s_pa,
                fracture_pa,
                acts: lot.stays(),
            };
            lot.hides(cause, BALANCE)
                .during(lot.since())
                .scored("J_m3_s_pa", j_m3_s_pa)
                .also("p_frac_pa", fracture_pa)
        }
        "u_tube" => {
            // 24 s is faint: the moderate 60 s less what every string has.
            let tau_s = (15.0 + 45.0 * lot.factor) * noise.between(0.9, 1.1);
            // At level two a valve in the string holds some of it back in half of the rigs.
            let held = noise.unit().mul_add(2.0, -1.0).max(0.0);
            let drains_s = match rig.level {
                Level::One => tau_s,
                Level::Two => tau_s * (1.0 - 0.8 * held),
            };
            lot.hides(Cause::UTube { tau_s, drains_s }, BALANCE)
                .also("tau_s", tau_s)
                .also("drains_s", drains_s)
        }
        "booster_line_storage" => {
            let tau_s = 35.0 * size;
            lot.hides(Cause::BoosterLineStorage { tau_s }, BALANCE)
                .scored("tau_s", tau_s)
        }
        _ => return None,
    })
}

fn of_riser(lot: &Lot, rig: &Rig) -> Option<Hidden> {
    let Lot { size, choice, .. } = *lot;
    Some(match lot.effect {
        "annulus_area" => {
            let area = rig.well.annulus_area_m2();
            // Either another pipe or riser than the file says, or, as practice has it, on the way to the casing's annulus.
            let change = if choice < 0.5 {
                lot.sign * 0.12 * size
            } else {
                lot.factor * (rig.casing_area_m2() / area - 1.0)
            };
            let area_m2 = area * (1.0 + change).max(0.3);
            lot.hides(Cause::AnnulusArea { area_m2 }, BALANCE)
                .scored("area_m2", area_m2)
        }
        "pipe_displacement" => {
            let volume_m3 = 0.25 * size;
            let cause = Cause::PipeDisplacement {
                volume_m3,
                before_start: choice < 0.5,
            };
            lot.hides(cause, BALANCE).scored("volume_m3", volume_m3)
        }
        "heave" => {
            let (period_s, amplitude_m) = (8.0 + 6.0 * choice, 0.5 * size);
            let cause = Cause::Heave {
                period_s,
                amplitude_m,
            };
            lot.hides(cause, HEAD_BALANCE)
                .scored("period_s", period_s)
                .also("amplitude_m", amplitude_m)
        }
        _ => return None,
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
    let sign = noise.sign();
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
        again_s: None,
        relation,
        cause: Cause::Foreign(foreign),
    })
}
