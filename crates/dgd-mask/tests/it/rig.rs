//! A small recording whose transmitters have known steps.

use dgd_identify::{Prepared, Series};
use dgd_recording::{ChannelMap, ChannelSource, Geometry, Recording, TimeSource, Well};
use dgd_units::{FullScale, MaskReferences, Unit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) const SAMPLES: usize = 6000;
const P0_PA: f64 = 101_325.0;

/// How large a rig is, and how finely it is read.
#[derive(Clone)]
pub(crate) struct Rig {
    /// Lengths and heads, against the first rig's.
    pub(crate) length: f64,
    /// Flows, against the first rig's.
    pub(crate) flow: f64,
    pub(crate) density_kg_m3: f64,
    pub(crate) flow_step_m3_s: f64,
    /// Step of each inlet transmitter.
    pub(crate) inlet_steps_pa: Vec<f64>,
    pub(crate) outlet_steps_pa: Vec<f64>,
}

impl Default for Rig {
    fn default() -> Self {
        Self {
            length: 1.0,
            flow: 1.0,
            density_kg_m3: 1113.0,
            flow_step_m3_s: 0.5 * 6.309e-5,
            inlet_steps_pa: vec![690.0],
            outlet_steps_pa: vec![690.0],
        }
    }
}

impl Rig {
    pub(crate) fn well(&self) -> Well {
        let source = |tag: &str, unit: &str| ChannelSource::column(tag, Unit::parse(unit).unwrap());
        // A_a scales as flow/length: the mass balance in percent is then the same.
        let across = (self.flow / self.length).sqrt();
        Well {
            mud_density_kg_m3: self.density_kg_m3,
            geometry: Geometry {
                riser_id_m: 0.4953 * across,
                drillpipe_od_m: 0.1683 * across,
                casing_od_m: None,
                return_line_id_m: 0.1524,
                booster_line_id_m: None,
                pump_inlet_depth_m: 350.3 * self.length,
                pump_outlet_depth_m: 350.3 * self.length,
                riser_pressure_sensor_depth_m: None,
            },
            channels: ChannelMap {
                time: TimeSource::Interval { step_s: 1.0 },
                mud_pump_flow: source("FT1", "m3/s"),
                booster_flow: source("FT2", "m3/s"),
                topfill_flow: source("FT3", "m3/s"),
                return_flow: source("FT4", "m3/s"),
                pump_inlet_pressure: vec![source("PT1", "Pa")],
                pump_outlet_pressure: vec![source("PT3", "Pa")],
                riser_pressure: None,
                pump_speed: source("SPM", "%"),
            },
        }
    }

    /// The same voyage on every rig, in its own size, read by its own transmitters.
    pub(crate) fn voyage(&self) -> (Prepared, Series) {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let well = self.well();
        let weight_pa_m = well.weight_pa_m();
        let depth_m = well.geometry.pump_inlet_depth_m;
        let mut recording = Recording {
            pump_inlet_pressure_pa: vec![Vec::new(); self.inlet_steps_pa.len()],
            pump_outlet_pressure_pa: vec![Vec::new(); self.outlet_steps_pa.len()],
            ..Recording::default()
        };
        for i in 0..SAMPLES {
            let t = i as f64;
            // As wide as some steps, so that neighbours differ by several.
            let mut noise = |size: f64| size * (random.random::<f64>() - 0.5);
            let return_flow = 0.05 + 0.02 * (t / 311.0).sin() + noise(8e-4);
            let level_m = self.length * (140.0 + 40.0 * (t / 977.0).sin() + noise(0.8));
            let friction_m = 2.0e4 * return_flow.powi(2) + noise(0.8);
            let inflow = [0.035, 0.01, 0.002].map(|q| q * (1.2 + (t / 401.0).cos()) + noise(8e-4));
            let flow = |q: f64| step_of(q * self.flow, self.flow_step_m3_s);
            recording.time_s.push(t);
            recording.mud_pump_flow_m3_s.push(flow(inflow[0]));
            recording.booster_flow_m3_s.push(flow(inflow[1]));
            recording.topfill_flow_m3_s.push(flow(inflow[2]));
            recording.return_flow_m3_s.push(flow(return_flow));
            let inlet_pa = P0_PA + weight_pa_m * (depth_m - level_m);
            let outlet_pa = P0_PA + weight_pa_m * (depth_m + self.length * friction_m);
            let sides = [
                (
                    inlet_pa,
                    &self.inlet_steps_pa,
                    &mut recording.pump_inlet_pressure_pa,
                ),
                (
                    outlet_pa,
                    &self.outlet_steps_pa,
                    &mut recording.pump_outlet_pressure_pa,
                ),
            ];
            for (pressure_pa, steps, series) in sides {
                for (step, values) in steps.iter().zip(series) {
                    values.push(step_of(pressure_pa, *step));
                }
            }
            recording
                .pump_speed_pct
                .push(60.0 + 20.0 * (t / 311.0).sin());
        }
        let (inlet, outlet) = (
            recording.mean_inlet_pressure_pa(),
            recording.mean_outlet_pressure_pa(),
        );
        let series = Series::of(&well, &inlet, &outlet);
        let prepared = Prepared {
            keep: vec![true; SAMPLES],
            step_s: 1.0,
            inlet_pressure_pa: inlet,
            outlet_pressure_pa: outlet,
            tally: Vec::new(),
            stuck: Vec::new(),
            dropouts: Vec::new(),
            recording,
        };
        (prepared, series)
    }

    /// References proportional to the rig's size.
    pub(crate) fn references(&self) -> MaskReferences {
        let weight = self.density_kg_m3 / Self::default().density_kg_m3;
        MaskReferences::new(FullScale {
            flow_m3_s: 0.0731 * self.flow,
            friction_pa: 1.317e6 * self.length * weight,
            head_m: 331.7 * self.length,
            level_m: 207.3 * self.length,
        })
        .unwrap()
    }
}

fn step_of(value: f64, step: f64) -> f64 {
    (value / step).round() * step
}
