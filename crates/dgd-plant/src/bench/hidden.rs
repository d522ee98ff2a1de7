//! What a bench can conceal.

/// Something that the textbook form of a bench leaves out, with its size. SI units unless the name says otherwise.
///
/// The source with each is where the hydraulics or instrumentation literature describes it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Hidden {
    /// The shaft spills over a crest in its wall below the brim: `Q = 2/3 Cd √(2g) b (z - z_c)^1.5`. Poleni's formula; M. G. Bos,
    /// *Discharge Measurement Structures*, ILRI 20 (1989).
    CrestOverflow {
        /// Height of the crest above the shaft's floor.
        crest_m: f64,
        /// Its length.
        width_m: f64,
    },
    /// The shaft widens into an upper chamber. M. H. Chaudhry, *Applied Hydraulic Transients*, 3rd ed. (2014), on surge tanks.
    ShaftWidening {
        /// Where it widens, within 0.1 m.
        from_m: f64,
        /// By what share of its area.
        share: f64,
    },
    /// A hole at the foot of the shaft: `Q = CA √(2 g z)`, Torricelli's law, which real leaks often exceed: J. E. van Zyl and C. R. I.
    /// Clayton (2007), *Proc. ICE Water Management* 160:109.
    ShaftLeak {
        /// Discharge coefficient times area.
        area_m2: f64,
    },
    /// The trash rack before the tunnel clogs, evenly in time from a moment on: a loss in velocity heads of the tunnel. I. E. Idelchik,
    /// *Handbook of Hydraulic Resistance* (1986), on grids; H. Meusburger, *Energieverluste an Einlaufrechen von Flusskraftwerken*, ETH Zürich (2002).
    RackClogging {
        /// When it begins.
        from_s: f64,
        /// Velocity heads gained an hour.
        heads_per_hour: f64,
    },
    /// Play between stem and plug. M. A. A. S. Choudhury, N. F. Thornhill and S. L. Shah (2005), *Control Eng. Practice* 13:641.
    ValveBacklash {
        /// Half of the play, as a share of the full opening.
        half_band: f64,
    },
    /// The water below the valve stands higher the more flows out over a broad crest: `h = (q / (1.705 b))^(2/3)`. V. T. Chow,
    /// *Open-Channel Hydraulics* (1959).
    TailwaterRise {
        /// Length of the crest, b.
        width_m: f64,
    },
    /// A throttle between tunnel and shaft: a loss with the square of what enters or leaves the shaft. C. Jaeger, *Fluid Transients in
    /// Hydro-Electric Engineering Practice* (1977).
    FootThrottle {
        /// Discharge coefficient times area.
        area_m2: f64,
    },
    /// The level gauge's zero drifts evenly. IEC 61298-2:2008, long-term drift.
    LevelDrift {
        /// Drift over an hour.
        per_hour_m: f64,
    },
    /// Leakage through the pump's clearances, in proportion to the pressure rise. W. E. Wilson (1946), *Trans. ASME* 68:371; H. E. Merritt,
    /// *Hydraulic Control Systems* (1967).
    PumpSlip {
        /// m³/s per Pa.
        per_pa: f64,
    },
    /// The relief valve weeps into the sump above its cracking pressure, in proportion to what is above. Merritt (1967).
    ReliefCracking {
        /// Gauge pressure at which it cracks.
        crack_pa: f64,
        /// m³/s per Pa above.
        per_pa: f64,
    },
    /// The fluid warms up and thins: `μ = μ0 exp(-s (1 - exp(-t/τ)))`. O. Reynolds (1886), *Phil. Trans. R. Soc.* 177:157.
    WarmingFluid {
        /// s.
        log_share: f64,
        /// τ.
        time_constant_s: f64,
    },
    /// Flow turns turbulent (Blasius) at a low Reynolds number, as it does behind rough fittings. O. Reynolds (1883), *Phil. Trans. R. Soc.*
    /// 174:935; H. Blasius (1913), *VDI Forschungsheft* 131.
    EarlyTransition {
        /// Reynolds number at which half of the flow is turbulent.
        reynolds: f64,
    },
    /// The warm sump steams: its level falls at an even rate. H. L. Penman (1948),
    /// *Proc. R. Soc. A* 193:120.
    SumpEvaporation {
        /// Fall of the level in an hour.
        per_hour_m: f64,
    },
    /// The needle sticks until its command is a band away, then slips most of the way. Choudhury, Thornhill and Shah (2005).
    NeedleStiction {
        /// Share of the full opening at which it lets go; 60 % of it is slipped.
        band: f64,
    },
    /// A pocket of gas beside the accumulator, compressed as gas is: its give falls with the square of the pressure. Merritt (1967);
    /// E. B. Wylie and V. L. Streeter, *Fluid Transients in Systems* (1993).
    TrappedGas {
        /// Its volume at the pressure of the air outside.
        volume_m3: f64,
    },
    /// The flow meter is damped: first order. E. O. Doebelin, *Measurement Systems* (2004).
    MeterLag {
        /// Time constant.
        time_constant_s: f64,
    },
    /// Foreign: the valve passes more or less as the shaft hums, with the sine of the level.
    HummingShaft {
        /// Share of the flow.
        share: f64,
        /// Level from crest to crest.
        wave_m: f64,
    },
    /// Foreign: the level gauge hears the square of the valve's opening, half a minute late.
    EchoOfTheValve {
        /// At an opening 0.3 from the middle.
        level_m: f64,
        /// How late.
        delay_s: f64,
    },
    /// Foreign: a rag goes round with the fluid and half-blocks the needle each time it comes by.
    TravellingRag {
        /// Share of the needle's conductance that it takes.
        share: f64,
        /// Volume pumped from one visit to the next.
        round_m3: f64,
    },
    /// Foreign: a float switch in the header tank meddles with the pump's drive, with the sine of the level.
    FloatSwitch {
        /// Share of the pump's flow.
        share: f64,
        /// Level from crest to crest.
        wave_m: f64,
    },
}

/// Where something concealed sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Components of the system description that it can be said to sit on; the first is where it was simulated.
    pub components: &'static [&'static str],
    /// `tank`, `line`, `valve`, `pump`, `boundary`, `volume`, `instrument` or `foreign`.
    pub kind: &'static str,
}

impl Hidden {
    /// Its name in [`super::Bench::things`] or [`super::Bench::foreign`].
    pub fn name(&self) -> &'static str {
        self.facts().0
    }

    /// Where it sits.
    pub fn place(&self) -> Place {
        let (_, kind, components) = self.facts();
        Place { components, kind }
    }

    /// Whether it is in no literature.
    pub fn is_foreign(&self) -> bool {
        self.facts().1 == "foreign"
    }

    fn facts(&self) -> (&'static str, &'static str, &'static [&'static str]) {
        match self {
            Hidden::CrestOverflow { .. } => ("crest_overflow", "tank", &["shaft"]),
            Hidden::ShaftWidening { .. } => ("shaft_widening", "tank", &["shaft"]),
            // Between the two flow meters there is nothing to tell a hole in the shaft from one in the pipes at its foot.
            Hidden::ShaftLeak { .. } => ("shaft_leak", "tank", &["shaft", "tunnel", "penstock"]),
            // In series with the tunnel, before it.
            Hidden::RackClogging { .. } => ("rack_clogging", "line", &["tunnel", "reservoir"]),
            Hidden::ValveBacklash { .. } => ("valve_backlash", "valve", &["valve"]),
            Hidden::TailwaterRise { .. } => ("tailwater_rise", "boundary", &["tailrace"]),
            Hidden::FootThrottle { .. } => ("foot_throttle", "tank", &["shaft"]),
            Hidden::LevelDrift { .. } => ("level_drift", "instrument", &["level"]),
            Hidden::PumpSlip { .. } => ("pump_slip", "pump", &["pump"]),
            // It hangs on the accumulator, and returns to where the pump draws from.
            Hidden::ReliefCracking { .. } => {
                ("relief_cracking", "valve", &["accumulator", "pump", "hose"])
            }
            Hidden::WarmingFluid { .. } => ("warming_fluid", "line", &["hose"]),
            Hidden::EarlyTransition { .. } => ("early_transition", "line", &["hose"]),
            Hidden::SumpEvaporation { .. } => ("sump_evaporation", "tank", &["sump"]),
            Hidden::NeedleStiction { .. } => ("needle_stiction", "valve", &["needle"]),
            Hidden::TrappedGas { .. } => ("trapped_gas", "volume", &["accumulator"]),
            Hidden::MeterLag { .. } => ("meter_lag", "instrument", &["flow"]),
            Hidden::HummingShaft { .. } => ("humming_shaft", "foreign", &["valve"]),
            Hidden::EchoOfTheValve { .. } => ("echo_of_the_valve", "foreign", &["level"]),
            Hidden::TravellingRag { .. } => ("travelling_rag", "foreign", &["needle"]),
            Hidden::FloatSwitch { .. } => ("float_switch", "foreign", &["pump"]),
        }
    }

    /// Names and values of its size, for the truth.
    pub fn size(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Hidden::CrestOverflow { crest_m, width_m } => {
                vec![("crest_m", crest_m), ("width_m", width_m)]
            }
            Hidden::ShaftWidening { from_m, share } => vec![("from_m", from_m), ("share", share)],
            Hidden::ShaftLeak { area_m2 } | Hidden::FootThrottle { area_m2 } => {
                vec![("area_m2", area_m2)]
            }
            Hidden::RackClogging {
                from_s,
                heads_per_hour,
            } => vec![("from_s", from_s), ("heads_per_hour", heads_per_hour)],
            Hidden::ValveBacklash { half_band } => vec![("half_band", half_band)],
            Hidden::TailwaterRise { width_m } => vec![("width_m", width_m)],
            Hidden::LevelDrift { per_hour_m } | Hidden::SumpEvaporation { per_hour_m } => {
                vec![("per_hour_m", per_hour_m)]
            }
            Hidden::PumpSlip { per_pa } => vec![("per_pa_m3_s", per_pa)],
            Hidden::ReliefCracking { crack_pa, per_pa } => {
                vec![("crack_pa", crack_pa), ("per_pa_m3_s", per_pa)]
            }
            Hidden::WarmingFluid {
                log_share,
                time_constant_s,
            } => vec![
                ("log_share", log_share),
                ("time_constant_s", time_constant_s),
            ],
            Hidden::EarlyTransition { reynolds } => vec![("reynolds", reynolds)],
            Hidden::NeedleStiction { band } => vec![("band", band)],
            Hidden::TrappedGas { volume_m3 } => vec![("volume_m3", volume_m3)],
            Hidden::MeterLag { time_constant_s } => vec![("time_constant_s", time_constant_s)],
            Hidden::HummingShaft { share, wave_m } | Hidden::FloatSwitch { share, wave_m } => {
                vec![("share", share), ("wave_m", wave_m)]
            }
            Hidden::EchoOfTheValve { level_m, delay_s } => {
                vec![("level_m", level_m), ("delay_s", delay_s)]
            }
            Hidden::TravellingRag { share, round_m3 } => {
                vec![("share", share), ("round_m3", round_m3)]
            }
        }
    }
}
