//! What a recording may conceal: physics that the two-state model leaves out.
//!
//! Each [`Cause`] is simulated where nature has it, in the riser, the line, the pump or an instrument; the
//! channels only show what follows. Parameters are SI. Times count from the start of the recording.

/// When a cause acts that is not always there: once, or twice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spans {
    /// From, to, s; to infinity where it stays.
    pub first_s: (f64, f64),
    /// When it comes again, from, to, s.
    pub again_s: Option<(f64, f64)>,
}

impl Spans {
    /// From some time on, s.
    pub fn since(onset_s: f64) -> Self {
        Self::once((onset_s, f64::INFINITY))
    }

    /// From, to, s.
    pub fn once(first_s: (f64, f64)) -> Self {
        Self {
            first_s,
            again_s: None,
        }
    }

    fn each(self) -> impl Iterator<Item = (f64, f64)> {
        std::iter::once(self.first_s).chain(self.again_s)
    }

    /// 1 while it acts, 0 otherwise.
    fn acts(self, t_s: f64) -> f64 {
        f64::from(u8::from(
            self.each().any(|(from, to)| t_s >= from && t_s < to),
        ))
    }
}

/// One piece of physics or one instrument error that a plan adds to the clean plant.
///
/// Of a kind given twice in one plan the last counts.
#[derive(Debug, Clone, PartialEq)]
pub enum Cause {
    /// The return flow is measured this much later, s.
    ReturnFlowDelay {
        /// Pure transport delay, s.
        delay_s: f64,
    },
    /// The return flow meter's reading over truth.
    ReturnFlowGain {
        /// Measured over true.
        gain: f64,
    },
    /// The mud pump flow's reading over truth.
    InflowGain {
        /// Measured over true.
        gain: f64,
    },
    /// Both outlet transmitters read too much.
    OutletPressureBias {
        /// Measured less true, Pa.
        bias_pa: f64,
    },
    /// One outlet transmitter shifts.
    OutletPressureBiasStep {
        /// Measured less true, Pa.
        bias_pa: f64,
        /// 1 or 2.
        sensor: u8,
        /// When.
        acts: Spans,
    },
    /// Mud of another weight is pumped.
    MudDensityChange {
        /// New less old, kg/m³.
        delta_rho_kg_m3: f64,
        /// When it reaches the pump inlet.
        acts: Spans,
    },
    /// Cuttings raise the density while the well is drilled.
    CuttingsLoading {
        /// Density added to what comes up, kg/m³.
        delta_rho_kg_m3: f64,
    },
    /// A yield stress resists flowing mud and lets standing mud alone.
    YieldStress {
        /// Yield stress, Pa; the wall feels 4/3 of it.
        tau_pa: f64,
        /// Share of it that turbulence at full flow leaves, 0 to 1.
        turbulent_share: f64,
    },
    /// Gel that builds while the line stands and breaks with the volume pumped.
    GelStrength {
        /// Strength after long standing, Pa.
        tau_gel_pa: f64,
        /// Time constant of building, s.
        build_s: f64,
        /// Volume that breaks it to 1/e, m³.
        break_m3: f64,
    },
    /// Mud runs back from the line into the riser while the pump is off.
    LineDrainage {
        /// Fall of the line's surface, m/s.
        rate_m_s: f64,
    },
    /// Leakage inside the pump grows from nothing, in proportion to time.
    PumpWear {
        /// Growth at 100 m of head, m³/s per second; it goes with the root of the head.
        leak_growth_m3_s2: f64,
    },
    /// Gas takes head for a while.
    GasInPump {
        /// Share of the head lost.
        head_loss_fraction: f64,
        /// When.
        acts: Spans,
    },
    /// The pump follows its set-point with a first-order lag.
    PumpSpeedLag {
        /// Time constant, s.
        tau_s: f64,
    },
    /// Formation fluid of the mud's own weight comes in: it rises over the first fifth, stays, dies away over the last third.
    Influx {
        /// Plateau, m³/s.
        rate_m3_s: f64,
        /// When.
        acts: Spans,
    },
    /// Mud is lost where the pressure at the pump inlet's depth exceeds what the formation holds.
    LostCirculation {
        /// Loss over excess pressure, m³/s/Pa.
        j_m3_s_pa: f64,
        /// Pressure at the pump inlet's depth where losses begin, Pa absolute.
        fracture_pa: f64,
        /// When.
        acts: Spans,
    },
    /// The drill string's outflow follows the mud pump.
    UTube {
        /// Time constant while it fills, s.
        tau_s: f64,
        /// Time constant while it drains, s: shorter where a valve in the string shuts. What is held back fills the
        /// stand that is added.
        drains_s: f64,
    },
    /// The booster line's outflow follows its pump.
    BoosterLineStorage {
        /// Time constant, s.
        tau_s: f64,
    },
    /// The riser annulus is another than the well file says.
    AnnulusArea {
        /// True area, m².
        area_m2: f64,
    },
    /// Pipe that goes in at a connection displaces mud, within a minute.
    PipeDisplacement {
        /// Displaced each time the mud pump stands, m³.
        volume_m3: f64,
        /// Whether it goes in before the mud pump starts again, instead of after it has stopped.
        before_start: bool,
    },
    /// The rig heaves: the return line's upper end moves, and a third of it the riser's surface.
    Heave {
        /// Mean period, s.
        period_s: f64,
        /// Amplitude, m.
        amplitude_m: f64,
    },
    /// The mud's consistency drifts.
    ViscosityDrift {
        /// Relative change at the end.
        relative_mu_change: f64,
        /// Length of the recording, s.
        length_s: f64,
    },
    /// A restriction in the return line.
    LineRestriction {
        /// Loss coefficient on the line's velocity head.
        k: f64,
        /// When.
        acts: Spans,
    },
    /// The line loses mud between the pump and the meter, while it flows.
    LineLeak {
        /// Loss over the root of the gauge pressure at the line's foot, m³/s/√Pa.
        c: f64,
        /// When.
        acts: Spans,
    },
    /// Gas cushions before the meter store mud, one behind the other.
    LineGasStorage {
        /// Time constant of each, s.
        cushions_s: [f64; 2],
    },
    /// Something that is in no catalogue.
    Foreign(Foreign),
}

/// Effects outside the catalogue that resemble some inside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Foreign {
    /// Head rises and falls with the riser level: share of the head, wave length in m.
    HeadRippleLevel(f64, f64),
    /// Booster flow leaks into both outlet transmitters: Pa per m³/s.
    BoosterCrosstalk(f64),
    /// The return meter fouls: share at the end, flow in m³/s of the worst error, length of the recording in s.
    MeterFouling(f64, f64, f64),
    /// The inlet filter clogs and clears: loss in Pa per (m³/s)² before it clears, period in s.
    InletFilterClog(f64, f64),
    /// The topfill meter reads too little by this much, m³/s.
    TopfillOffset(f64),
    /// Friction is higher after the flow has risen than after it has fallen: Pa.
    FrictionHysteresis(f64),
    /// Between two speeds the pump turns at another speed than ordered: percent at full level depth, centre in percent.
    SpeedBand(f64, f64),
    /// The inlet transmitters follow the temperature: Pa, period in s.
    InletTemperature(f64, f64),
    /// A choke at the line's end sticks until the flow has moved: loss coefficients it jumps between.
    ChokeStick(f64, f64),
    /// Friction swells after a restart: share, time constant in s.
    FrictionSwell(f64, f64),
}

impl Foreign {
    /// Name in the truth.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::HeadRippleLevel(..) => "head_ripple_level",
            Self::BoosterCrosstalk(..) => "booster_crosstalk",
            Self::MeterFouling(..) => "meter_fouling",
            Self::InletFilterClog(..) => "inlet_filter_clog",
            Self::TopfillOffset(..) => "topfill_offset",
            Self::FrictionHysteresis(..) => "friction_hysteresis",
            Self::SpeedBand(..) => "speed_band",
            Self::InletTemperature(..) => "inlet_temperature",
            Self::ChokeStick(..) => "choke_stick",
            Self::FrictionSwell(..) => "friction_swell",
        }
    }
}

/// The causes of a plan, sorted for the plant: neutral where a cause is absent.
#[derive(Debug, Clone, Default)]
pub(crate) struct Active {
    pub(crate) delay_s: f64,
    pub(crate) outlet_bias_pa: f64,
    pub(crate) outlet_step: Option<(f64, u8, Spans)>,
    pub(crate) return_gain: Option<f64>,
    pub(crate) inflow_gain: Option<f64>,
    pub(crate) density: Option<(f64, Spans)>,
    pub(crate) cuttings_kg_m3: f64,
    pub(crate) yield_stress: Option<(f64, f64)>,
    pub(crate) gel: Option<(f64, f64, f64)>,
    pub(crate) drain_m_s: f64,
    pub(crate) leak_growth_m3_s2: f64,
    pub(crate) gas: Option<(f64, Spans)>,
    pub(crate) speed_lag_s: f64,
    pub(crate) influx: Option<(f64, Spans)>,
    pub(crate) loss: Option<(f64, f64, Spans)>,
    /// While the string fills, and while it drains.
    pub(crate) string_lag_s: Option<[f64; 2]>,
    pub(crate) booster_lag_s: Option<f64>,
    pub(crate) area_m2: Option<f64>,
    pub(crate) pipe_m3: f64,
    pub(crate) pipe_before_start: bool,
    pub(crate) heave: Option<(f64, f64)>,
    pub(crate) viscosity: Option<(f64, f64)>,
    pub(crate) restriction: Option<(f64, Spans)>,
    pub(crate) leak: Option<(f64, Spans)>,
    pub(crate) cushions_s: [f64; 2],
    pub(crate) foreign: Option<Foreign>,
}

impl Active {
    pub(crate) fn new(causes: &[Cause]) -> Self {
        let mut a = Self::default();
        for cause in causes {
            match *cause {
                Cause::ReturnFlowDelay { delay_s } => a.delay_s = delay_s,
                Cause::ReturnFlowGain { gain } => a.return_gain = Some(gain),
                Cause::InflowGain { gain } => a.inflow_gain = Some(gain),
                Cause::OutletPressureBias { bias_pa } => a.outlet_bias_pa = bias_pa,
                Cause::OutletPressureBiasStep {
                    bias_pa,
                    sensor,
                    acts,
                } => a.outlet_step = Some((bias_pa, sensor, acts)),
                Cause::MudDensityChange {
                    delta_rho_kg_m3,
                    acts,
                } => a.density = Some((delta_rho_kg_m3, acts)),
                Cause::CuttingsLoading { delta_rho_kg_m3 } => a.cuttings_kg_m3 = delta_rho_kg_m3,
                Cause::YieldStress {
                    tau_pa,
                    turbulent_share,
                } => a.yield_stress = Some((tau_pa, turbulent_share)),
                Cause::GelStrength {
                    tau_gel_pa,
                    build_s,
                    break_m3,
                } => a.gel = Some((tau_gel_pa, build_s, break_m3)),
                Cause::LineDrainage { rate_m_s } => a.drain_m_s = rate_m_s,
                Cause::PumpWear { leak_growth_m3_s2 } => a.leak_growth_m3_s2 = leak_growth_m3_s2,
                Cause::GasInPump {
                    head_loss_fraction,
                    acts,
                } => a.gas = Some((head_loss_fraction, acts)),
                Cause::PumpSpeedLag { tau_s } => a.speed_lag_s = tau_s,
                Cause::Influx { rate_m3_s, acts } => a.influx = Some((rate_m3_s, acts)),
                Cause::LostCirculation {
                    j_m3_s_pa,
                    fracture_pa,
                    acts,
                } => a.loss = Some((j_m3_s_pa, fracture_pa, acts)),
                Cause::UTube { tau_s, drains_s } => a.string_lag_s = Some([tau_s, drains_s]),
                Cause::BoosterLineStorage { tau_s } => a.booster_lag_s = Some(tau_s),
                Cause::AnnulusArea { area_m2 } => a.area_m2 = Some(area_m2),
                Cause::PipeDisplacement {
                    volume_m3,
                    before_start,
                } => (a.pipe_m3, a.pipe_before_start) = (volume_m3, before_start),
                Cause::Heave {
                    period_s,
                    amplitude_m,
                } => a.heave = Some((period_s, amplitude_m)),
                Cause::ViscosityDrift {
                    relative_mu_change,
                    length_s,
                } => a.viscosity = Some((relative_mu_change, length_s)),
                Cause::LineRestriction { k, acts } => a.restriction = Some((k, acts)),
                Cause::LineLeak { c, acts } => a.leak = Some((c, acts)),
                Cause::LineGasStorage { cushions_s } => a.cushions_s = cushions_s,
                Cause::Foreign(f) => a.foreign = Some(f),
            }
        }
        a
    }

    /// Share of the head that gas takes at `t_s`: it comes and goes within a tenth of the time.
    pub(crate) fn gas_share(&self, t_s: f64) -> f64 {
        self.gas.map_or(0.0, |(fraction, acts)| {
            fraction * rises_and_falls(t_s, acts, 0.1, 0.1)
        })
    }

    pub(crate) fn influx_m3_s(&self, t_s: f64) -> f64 {
        self.influx.map_or(0.0, |(rate, acts)| {
            rate * rises_and_falls(t_s, acts, 0.2, 0.33)
        })
    }

    pub(crate) fn loss_m3_s(&self, t_s: f64, pressure_pa: f64) -> f64 {
        self.loss.map_or(0.0, |(j, fracture, acts)| {
            j * acts.acts(t_s) * (pressure_pa - fracture).max(0.0)
        })
    }

    /// Loss coefficient added to the line at `t_s`.
    pub(crate) fn restriction_k(&self, t_s: f64) -> f64 {
        self.restriction.map_or(0.0, |(k, acts)| k * acts.acts(t_s))
    }

    /// What the foot of the line loses at `t_s`, m³/s, for a gauge pressure.
    pub(crate) fn leak_m3_s(&self, t_s: f64, gauge_pa: f64) -> f64 {
        self.leak.map_or(0.0, |(c, acts)| {
            c * acts.acts(t_s) * gauge_pa.max(0.0).sqrt()
        })
    }

    /// The consistency over its first value at `t_s`: smooth, and full at the end.
    pub(crate) fn viscosity_factor(&self, t_s: f64) -> f64 {
        self.viscosity.map_or(1.0, |(change, length)| {
            let s = (t_s / length).clamp(0.0, 1.0);
            1.0 + change * s * s * (3.0 - 2.0 * s)
        })
    }

    /// Density the new mud adds to what is pumped at `t_s`, kg/m³.
    pub(crate) fn new_mud_kg_m3(&self, t_s: f64) -> f64 {
        self.density
            .map_or(0.0, |(delta, acts)| delta * acts.acts(t_s))
    }

    /// What the outlet transmitters `(1, 2)` read too much, Pa.
    pub(crate) fn outlet_error_pa(&self, t_s: f64) -> [f64; 2] {
        let step = |which: u8| match self.outlet_step {
            Some((bias, sensor, acts)) if sensor == which => bias * acts.acts(t_s),
            _ => 0.0,
        };
        [self.outlet_bias_pa + step(1), self.outlet_bias_pa + step(2)]
    }

    /// Whether riser and line are to be turned over by volume at the pump inlet.
    pub(crate) fn turns_over(&self) -> bool {
        self.density.is_some() || self.cuttings_kg_m3 != 0.0
    }
}

/// What [`trapezium`] comes to each time that it acts.
fn rises_and_falls(t_s: f64, acts: Spans, rise: f64, fall: f64) -> f64 {
    acts.each()
        .map(|span| trapezium(t_s, span, rise, fall))
        .sum()
}

/// Rises over a share of the span, stays at one, falls over another.
fn trapezium(t_s: f64, (from, to): (f64, f64), rise: f64, fall: f64) -> f64 {
    let x = (t_s - from) / (to - from);
    (x / rise).min((1.0 - x) / fall).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::{Active, Cause, Spans};

    #[test]
    fn a_cause_acts_within_its_spans_alone() {
        let once = Spans::once((1000.0, 2000.0));
        let twice = Spans {
            again_s: Some((3000.0, 4000.0)),
            ..once
        };
        for (t_s, expected) in [
            (999.0, [0.0, 0.0, 0.0]),
            (1000.0, [1.0, 1.0, 1.0]),
            (2000.0, [1.0, 0.0, 0.0]),
            (3500.0, [1.0, 0.0, 1.0]),
            (4000.0, [1.0, 0.0, 0.0]),
        ] {
            let acts = [Spans::since(1000.0), once, twice].map(|spans| spans.acts(t_s));
            assert_eq!(acts, expected, "{t_s}");
        }
        // A kick rises and falls each time.
        let kicks = Active::new(&[Cause::Influx {
            rate_m3_s: 2.0,
            acts: twice,
        }]);
        for t_s in [1500.0, 3500.0] {
            assert_eq!(kicks.influx_m3_s(t_s), 2.0);
            assert_eq!(kicks.influx_m3_s(t_s - 400.0), 1.0);
        }
        assert_eq!(kicks.influx_m3_s(2500.0), 0.0);
    }
}
