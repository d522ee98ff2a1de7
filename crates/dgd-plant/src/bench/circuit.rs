//! The loop of glycol: a gear pump feeds an accumulator, from which a laminar hose and a needle valve lead into a header tank that
//! drains back into the sump.
//!
//! States: pressure in the accumulator in Pa above the air's, flow in the hose in m³/s, levels of header and sump in m,
//! volume pumped in m³.

use super::friction::Pipe;
use super::gauge::Gauge;
use super::hidden::Hidden;
use crate::constants::{ATMOSPHERE_PA, GRAVITY_M_S2 as G};

/// Inputs as filed: speed of the pump, opening of the needle.
pub(crate) const INPUTS: [Gauge; 2] = [
    Gauge {
        name: "pump.input",
        tag: "SPM",
        unit: "rpm",
        si: 1.0,
        noise: 0.0,
        quantum: 0.1,
    },
    Gauge {
        name: "needle.opening",
        tag: "ZT1",
        unit: "1",
        si: 1.0,
        noise: 0.0,
        quantum: 0.0001,
    },
];

/// Outputs as filed: pressure in the accumulator (absolute), flow in the hose, levels of header and sump.
pub(crate) const OUTPUTS: [Gauge; 4] = [
    Gauge {
        name: "pressure",
        tag: "PT1",
        unit: "kPa",
        si: 1e3,
        noise: 1.0,
        quantum: 0.5,
    },
    Gauge {
        name: "flow",
        tag: "FT1",
        unit: "l/min",
        si: 1e-3 / 60.0,
        noise: 0.04,
        quantum: 0.01,
    },
    Gauge {
        name: "header_level",
        tag: "LT1",
        unit: "cm",
        si: 0.01,
        noise: 0.1,
        quantum: 0.05,
    },
    Gauge {
        name: "sump_level",
        tag: "LT2",
        unit: "cm",
        si: 0.01,
        noise: 0.05,
        quantum: 0.02,
    },
];

const DENSITY: f64 = 1090.0;
const HOSE: Pipe = Pipe {
    length_m: 12.0,
    bore_m: 0.016,
    density_kg_m3: DENSITY,
    viscosity_pa_s: 0.012,
};
/// From accumulator to the header's top.
const RISE_M: f64 = 1.5;
/// Volume over bulk modulus of the accumulator's bellows, m³/Pa.
const GIVE_M3_PA: f64 = 4e-9;
const HEADER_AREA_M2: f64 = 0.03;
const DRAIN_AREA_M2: f64 = 1.6e-4;
const SUMP_AREA_M2: f64 = 0.12;
/// Below it the hose would be too stiff for the steps.
const LEAST_OPENING: f64 = 0.3;
/// Level of the sump with an empty header.
const FILL_M: f64 = 0.45;

/// The bench, with what varies from recording to recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Circuit {
    /// What the pump delivers, m³/s per revolution a minute.
    pub displacement_m3_s_rpm: f64,
    /// Of the needle, fully open, in m³/s/√Pa.
    pub flow_coefficient: f64,
    /// Of the drain.
    pub discharge_coefficient: f64,
    /// The fluid's at the start, Pa·s.
    pub viscosity_pa_s: f64,
    /// What the textbook form leaves out.
    pub hidden: Option<Hidden>,
}

/// What drives the bench at a moment; the opening is that of the needle itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drive {
    pub(crate) time_s: f64,
    pub(crate) speed_rpm: f64,
    pub(crate) opening: f64,
}

impl Circuit {
    pub(crate) const STEP_S: f64 = 0.01;

    /// What the pump delivers, m³/s.
    fn pumped(&self, speed_rpm: f64, rise_pa: f64, header_m: f64) -> f64 {
        let flow = self.displacement_m3_s_rpm * speed_rpm;
        match self.hidden {
            Some(Hidden::PumpSlip { per_pa }) => flow - per_pa * rise_pa,
            Some(Hidden::FloatSwitch { share, wave_m }) => {
                flow * (1.0 + share * (std::f64::consts::TAU * header_m / wave_m).sin())
            }
            _ => flow,
        }
    }

    /// What the relief valve lets back into the sump, m³/s.
    fn relieved(&self, pressure_pa: f64) -> f64 {
        match self.hidden {
            Some(Hidden::ReliefCracking { crack_pa, per_pa }) => {
                per_pa * (pressure_pa - crack_pa).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// How much the volume at the pump's outlet gives, m³/Pa.
    fn give(&self, pressure_pa: f64) -> f64 {
        match self.hidden {
            Some(Hidden::TrappedGas { volume_m3 }) => {
                let absolute = (ATMOSPHERE_PA + pressure_pa).max(1e4);
                // Isothermal: V = V0 p0/p.
                GIVE_M3_PA + volume_m3 * ATMOSPHERE_PA / (absolute * absolute)
            }
            _ => GIVE_M3_PA,
        }
    }

    fn viscosity(&self, time_s: f64) -> f64 {
        match self.hidden {
            Some(Hidden::WarmingFluid {
                log_share,
                time_constant_s,
            }) => {
                let warmed = 1.0 - (-time_s.max(0.0) / time_constant_s).exp();
                self.viscosity_pa_s * (-log_share * warmed).exp()
            }
            _ => self.viscosity_pa_s,
        }
    }

    /// Pressure lost in the hose, Pa.
    pub fn hose_pa(&self, flow_m3_s: f64, time_s: f64) -> f64 {
        let hose = Pipe {
            viscosity_pa_s: self.viscosity(time_s),
            ..HOSE
        };
        let laminar = hose.laminar_pa_s_m3() * flow_m3_s;
        let Some(Hidden::EarlyTransition { reynolds }) = self.hidden else {
            return laminar;
        };
        let here = hose.reynolds(flow_m3_s).max(1.0);
        let blasius = 0.3164 / here.powf(0.25) * hose.length_m / hose.bore_m
            * hose.velocity_head_pa(flow_m3_s)
            * flow_m3_s.signum();
        // The share of time that the flow is turbulent rises over a tenth of the Reynolds number, up and down.
        let turbulent = 1.0 / (1.0 + (-(here - reynolds) / (0.05 * reynolds)).exp());
        laminar + turbulent * (blasius - laminar).max(0.0)
    }

    /// Pressure lost in the needle, Pa.
    fn needle_pa(&self, flow_m3_s: f64, opening: f64, pumped_m3: f64) -> f64 {
        let rag = match self.hidden {
            Some(Hidden::TravellingRag { share, round_m3 }) => {
                // It takes a tenth of a round to pass.
                let along = (pumped_m3 / round_m3).rem_euclid(1.0);
                1.0 - share * (-((along - 0.5) / 0.05).powi(2)).exp()
            }
            _ => 1.0,
        };
        let passes = self.flow_coefficient * opening.max(LEAST_OPENING) * rag;
        flow_m3_s * flow_m3_s.abs() / (passes * passes)
    }

    /// What drains from the header, m³/s.
    fn drained(&self, header_m: f64) -> f64 {
        self.discharge_coefficient * DRAIN_AREA_M2 * (2.0 * G * header_m.max(0.0)).sqrt()
    }

    /// What evaporates from the sump, m³/s.
    fn steamed(&self, time_s: f64) -> f64 {
        match self.hidden {
            Some(Hidden::SumpEvaporation { per_hour_m }) if time_s >= 0.0 => {
                per_hour_m / 3600.0 * SUMP_AREA_M2
            }
            _ => 0.0,
        }
    }

    pub(crate) fn rates(&self, drive: &Drive, y: &[f64; 5]) -> [f64; 5] {
        let [pressure, flow, header, sump, gone_round] = *y;
        let pumped = self.pumped(drive.speed_rpm, pressure - DENSITY * G * sump, header);
        let relieved = self.relieved(pressure);
        let resists = self.hose_pa(flow, drive.time_s)
            + self.needle_pa(flow, drive.opening, gone_round)
            + DENSITY * G * RISE_M;
        let drained = self.drained(header);
        [
            (pumped - relieved - flow) / self.give(pressure),
            (pressure - resists) / HOSE.inertance_kg_m4(),
            (flow - drained) / HEADER_AREA_M2,
            (drained + relieved - pumped - self.steamed(drive.time_s)) / SUMP_AREA_M2,
            pumped,
        ]
    }

    /// Pressure in the accumulator (absolute), flow in the hose, levels of header and sump, SI.
    pub(crate) fn outputs(y: &[f64; 5]) -> [f64; 4] {
        [ATMOSPHERE_PA + y[0], y[1], y[2], y[3]]
    }

    /// A start from which the bench finds its steady state by itself, with the fluid it is always filled with.
    pub(crate) fn start(&self) -> [f64; 5] {
        let header = 0.25;
        [
            2e5,
            2e-4,
            header,
            FILL_M - header * HEADER_AREA_M2 / SUMP_AREA_M2,
            0.0,
        ]
    }
}
