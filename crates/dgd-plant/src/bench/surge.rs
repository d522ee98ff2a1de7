//! The surge shaft: what is between a reservoir and a control valve swings when the valve moves.
//!
//! States: level of the shaft in m above its floor, flow of tunnel and penstock in m³/s.

use super::friction::{Pipe, drop_pa};
use super::gauge::Gauge;
use super::hidden::Hidden;
use crate::constants::{ATMOSPHERE_PA, GRAVITY_M_S2 as G};

/// Inputs as filed: pressure at the tunnel's inlet (absolute), opening of the valve.
pub(crate) const INPUTS: [Gauge; 2] = [
    Gauge {
        name: "reservoir.pressure",
        tag: "P0",
        unit: "kPa",
        si: 1e3,
        noise: 0.01,
        quantum: 0.01,
    },
    Gauge {
        name: "valve.opening",
        tag: "ZT1",
        unit: "1",
        si: 1.0,
        noise: 0.0,
        quantum: 0.0001,
    },
];

/// Outputs as filed: level, flow of tunnel and penstock, pressure before the valve (absolute).
pub(crate) const OUTPUTS: [Gauge; 4] = [
    Gauge {
        name: "level",
        tag: "LT1",
        unit: "m",
        si: 1.0,
        noise: 0.008,
        quantum: 0.002,
    },
    Gauge {
        name: "tunnel_flow",
        tag: "FT1",
        unit: "l/s",
        si: 1e-3,
        noise: 0.03,
        quantum: 0.01,
    },
    Gauge {
        name: "penstock_flow",
        tag: "FT2",
        unit: "l/s",
        si: 1e-3,
        noise: 0.03,
        quantum: 0.01,
    },
    Gauge {
        name: "valve_pressure",
        tag: "PT1",
        unit: "kPa",
        si: 1e3,
        noise: 0.15,
        quantum: 0.1,
    },
];

const DENSITY: f64 = 998.2;
const VISCOSITY: f64 = 1.002e-3;
const TUNNEL: Pipe = Pipe {
    length_m: 60.0,
    bore_m: 0.1,
    density_kg_m3: DENSITY,
    viscosity_pa_s: VISCOSITY,
};
const TUNNEL_MINOR: f64 = 1.5;
const PENSTOCK: Pipe = Pipe {
    length_m: 8.0,
    bore_m: 0.08,
    density_kg_m3: DENSITY,
    viscosity_pa_s: VISCOSITY,
};
const PENSTOCK_MINOR: f64 = 0.5;
const PENSTOCK_ROUGHNESS_M: f64 = 5e-5;
/// How far the valve lies below the floor of the shaft.
const FALL_M: f64 = 2.0;
const SHAFT_AREA_M2: f64 = 0.05;
/// Below it the penstock would be too stiff for the steps.
const LEAST_OPENING: f64 = 0.05;
/// Of a short crest, Poleni's coefficient.
const CREST: f64 = 0.62;

/// The bench, with what varies from recording to recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Surge {
    /// Roughness of the tunnel's wall.
    pub roughness_m: f64,
    /// Of the valve, fully open, in m³/s/√Pa.
    pub flow_coefficient: f64,
    /// What the textbook form leaves out.
    pub hidden: Option<Hidden>,
}

/// What drives the bench at a moment, SI; the opening is that of the plug.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drive {
    pub(crate) time_s: f64,
    pub(crate) inlet_pa: f64,
    pub(crate) opening: f64,
}

impl Surge {
    pub(crate) const STEP_S: f64 = 0.02;

    /// Free surface of the shaft at a level, m².
    pub fn shaft_area_m2(&self, level_m: f64) -> f64 {
        match self.hidden {
            Some(Hidden::ShaftWidening { from_m, share }) => {
                // Over 0.1 m from one area to the other, in a straight line.
                let part = ((level_m - from_m) / 0.1 + 0.5).clamp(0.0, 1.0);
                SHAFT_AREA_M2 * (1.0 + share * part)
            }
            _ => SHAFT_AREA_M2,
        }
    }

    /// What leaves the shaft for good: spilled or leaked, m³/s.
    pub fn lost_m3_s(&self, level_m: f64) -> f64 {
        match self.hidden {
            Some(Hidden::CrestOverflow { crest_m, width_m }) => {
                let over = (level_m - crest_m).max(0.0);
                2.0 / 3.0 * CREST * (2.0 * G).sqrt() * width_m * over.powf(1.5)
            }
            Some(Hidden::ShaftLeak { area_m2 }) => area_m2 * (2.0 * G * level_m.max(0.0)).sqrt(),
            _ => 0.0,
        }
    }

    /// Pressure above that of the air at the foot of the shaft, where the pipes meet, Pa.
    fn foot_pa(&self, level_m: f64, into_m3_s: f64) -> f64 {
        let throttle = match self.hidden {
            Some(Hidden::FootThrottle { area_m2 }) => {
                let jet = into_m3_s / area_m2;
                0.5 * DENSITY * jet * jet.abs()
            }
            _ => 0.0,
        };
        DENSITY * G * level_m + throttle
    }

    /// Pressure above that of the air behind the valve, Pa.
    fn tail_pa(&self, flow_m3_s: f64) -> f64 {
        match self.hidden {
            Some(Hidden::TailwaterRise { width_m }) => {
                DENSITY * G * (flow_m3_s.max(0.0) / (1.705 * width_m)).powf(2.0 / 3.0)
            }
            _ => 0.0,
        }
    }

    /// Pressure lost in the valve, Pa.
    fn valve_pa(&self, flow_m3_s: f64, opening: f64, level_m: f64) -> f64 {
        let hum = match self.hidden {
            Some(Hidden::HummingShaft { share, wave_m }) => {
                1.0 + share * (std::f64::consts::TAU * level_m / wave_m).sin()
            }
            _ => 1.0,
        };
        let passes = self.flow_coefficient * opening.max(LEAST_OPENING) * hum;
        flow_m3_s * flow_m3_s.abs() / (passes * passes)
    }

    /// Pressure lost between reservoir and shaft, Pa.
    fn tunnel_pa(&self, flow_m3_s: f64, time_s: f64) -> f64 {
        let rack = match self.hidden {
            Some(Hidden::RackClogging {
                from_s,
                heads_per_hour,
            }) => heads_per_hour * (time_s - from_s).max(0.0) / 3600.0,
            _ => 0.0,
        };
        drop_pa(&TUNNEL, self.roughness_m, TUNNEL_MINOR + rack, flow_m3_s)
    }

    pub(crate) fn rates(&self, drive: &Drive, y: &[f64; 3]) -> [f64; 3] {
        let [level, tunnel, penstock] = *y;
        let lost = self.lost_m3_s(level);
        let into = tunnel - penstock - lost;
        let foot = self.foot_pa(level, into);
        let valve = self.valve_pa(penstock, drive.opening, level);
        let rest = drop_pa(&PENSTOCK, PENSTOCK_ROUGHNESS_M, PENSTOCK_MINOR, penstock);
        [
            into / self.shaft_area_m2(level),
            (drive.inlet_pa - ATMOSPHERE_PA - foot - self.tunnel_pa(tunnel, drive.time_s))
                / TUNNEL.inertance_kg_m4(),
            (foot + DENSITY * G * FALL_M - rest - valve - self.tail_pa(penstock))
                / PENSTOCK.inertance_kg_m4(),
        ]
    }

    /// Level, both flows and the pressure before the valve, SI.
    pub(crate) fn outputs(&self, drive: &Drive, y: &[f64; 3]) -> [f64; 4] {
        let [level, tunnel, penstock] = *y;
        let before =
            ATMOSPHERE_PA + self.tail_pa(penstock) + self.valve_pa(penstock, drive.opening, level);
        [level, tunnel, penstock, before]
    }

    /// A start from which the bench finds its steady state by itself.
    pub(crate) fn start(&self) -> [f64; 3] {
        [3.0, 0.006, 0.006]
    }
}
