//! A made recording whose friction, delay and head curve are known.

use dgd_identify::{Identification, IdentifyOptions, ScreenOptions, identify, prepare};
use dgd_recording::{ChannelMap, ChannelSource, Geometry, Recording, TimeSource, Well};
use dgd_units::{Dimension, Unit};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) const B: f64 = 2e4;
pub(crate) const D: f64 = 1.2e8;
pub(crate) const E: f64 = 4e8;
pub(crate) const C0: f64 = 0.0688;
pub(crate) const C1: f64 = 3.0;
pub(crate) const C2: f64 = 2.4e3;
pub(crate) const N0: f64 = 1.95;
pub(crate) const N2: f64 = 1.62;

const ATMOSPHERE_PA: f64 = 101_325.0;

pub(crate) fn friction_pa(q: f64) -> f64 {
    B + D * q * q + E * q * q * q
}

pub(crate) fn head_m(w: f64, q: f64) -> f64 {
    C0 * w.powf(N0) - C1 * w * q - C2 * q.powf(N2)
}

pub(crate) fn well() -> Well {
    let column = |tag: &str, dimension| ChannelSource::column(tag, Unit::si(dimension));
    let flow = |tag| column(tag, Dimension::FlowRate);
    let pressure = |tag| column(tag, Dimension::Pressure);
    Well {
        mud_density_kg_m3: 1080.0,
        geometry: Geometry {
            riser_id_m: 0.4953,
            drillpipe_od_m: 0.168_275,
            casing_od_m: None,
            return_line_id_m: 0.1524,
            booster_line_id_m: None,
            pump_inlet_depth_m: 350.3,
            pump_outlet_depth_m: 348.0,
            riser_pressure_sensor_depth_m: None,
        },
        channels: ChannelMap {
            time: TimeSource::Interval { step_s: 1.0 },
            mud_pump_flow: flow("FT1"),
            booster_flow: flow("FT2"),
            topfill_flow: flow("FT3"),
            return_flow: flow("FT4"),
            pump_inlet_pressure: vec![pressure("PT1"), pressure("PT2")],
            pump_outlet_pressure: vec![pressure("PT3"), pressure("PT4")],
            riser_pressure: None,
            pump_speed: column("SPM", Dimension::Percent),
        },
    }
}

/// What to make.
#[derive(Clone, Copy)]
pub(crate) struct Rig {
    pub(crate) samples: u32,
    pub(crate) step_s: f64,
    pub(crate) delay_s: f64,
    /// How far speed and flow swing about 55 % and 0.045 m³/s, as a share.
    pub(crate) swing: f64,
    /// Noise of the flow meter, m³/s; its values are quantised to 1e-5.
    pub(crate) flow_noise_m3_s: f64,
    pub(crate) seed: u64,
}

impl Default for Rig {
    fn default() -> Self {
        Self {
            samples: 9000,
            step_s: 1.0,
            delay_s: 12.0,
            swing: 1.0,
            flow_noise_m3_s: 2e-5,
            seed: 1,
        }
    }
}

impl Rig {
    pub(crate) fn speed_pct(&self, t: f64) -> f64 {
        55.0 + self.swing * (8.0 * (t / 173.0).sin() + 5.0 * (t / 61.0 + 1.0).sin())
    }

    pub(crate) fn flow_m3_s(&self, t: f64) -> f64 {
        0.045 + self.swing * (0.014 * (t / 97.0).sin() + 0.006 * (t / 29.0 + 2.0).cos())
    }

    /// Exact pressures with 1 kPa of noise on the mean of two transmitters.
    pub(crate) fn recording(&self) -> Recording {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let weight = well().weight_pa_m();
        let column = weight * well().geometry.pump_outlet_depth_m + ATMOSPHERE_PA;
        let mut recording = Recording {
            pump_inlet_pressure_pa: vec![Vec::new(); 2],
            pump_outlet_pressure_pa: vec![Vec::new(); 2],
            ..Recording::default()
        };
        let on = |quantum: f64, value: f64| (value / quantum).round() * quantum;
        for i in 0..self.samples {
            let t = f64::from(i) * self.step_s;
            let (w, q) = (self.speed_pct(t), self.flow_m3_s(t));
            let w = if self.swing > 0.0 { on(0.01, w) } else { w };
            recording.time_s.push(t);
            recording.pump_speed_pct.push(w);
            let meter =
                self.flow_m3_s(t - self.delay_s) + self.flow_noise_m3_s * normal(&mut random);
            recording.return_flow_m3_s.push(on(1e-5, meter));
            let inflow = 0.03 + 2e-5 * normal(&mut random);
            recording.mud_pump_flow_m3_s.push(on(1e-5, inflow));
            recording.booster_flow_m3_s.push(0.01);
            recording.topfill_flow_m3_s.push(0.0);
            let outlet = column + friction_pa(q);
            let inlet = outlet - weight * head_m(w, q);
            for (side, pressure) in [
                (&mut recording.pump_inlet_pressure_pa, inlet),
                (&mut recording.pump_outlet_pressure_pa, outlet),
            ] {
                for transmitter in side {
                    transmitter.push(on(100.0, pressure + 1414.0 * normal(&mut random)));
                }
            }
        }
        recording
    }

    pub(crate) fn identify(&self) -> Identification {
        fit(self.recording(), self.step_s, &IdentifyOptions::default())
    }
}

pub(crate) fn fit(recording: Recording, step_s: f64, options: &IdentifyOptions) -> Identification {
    let prepared = prepare(recording, step_s, &ScreenOptions::default()).unwrap();
    identify(&prepared, &well(), options).unwrap()
}

/// A standard normal number (Box and Muller).
pub(crate) fn normal(random: &mut ChaCha8Rng) -> f64 {
    let uniform = |random: &mut ChaCha8Rng| {
        (f64::from(random.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0)
    };
    let (u, v) = (uniform(random), uniform(random));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}
