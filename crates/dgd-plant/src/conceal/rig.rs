//! Rigs that cases are drawn on: a well of one of three families, its mud, its pump, its instruments.

use std::f64::consts::PI;

use crate::config::{Controller, Historian, Physics, Plan};
use crate::constants::{ATMOSPHERE_PA, GRAVITY_M_S2, INCH_M};
use crate::instrument::{FaultRates, Transmitter};
use crate::line::LineParameters;
use crate::mud::Rheology;
use crate::noise::Noise;
use crate::pump::PumpParameters;
use crate::well::Well;

/// How clean the base physics is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Smooth pipe, textbook pump, good instruments, much excitation.
    One,
    /// What the model meets only approximately.
    Two,
}

/// A well with what stands on it.
#[derive(Debug, Clone)]
pub(crate) struct Rig {
    pub(crate) family: &'static str,
    pub(crate) level: Level,
    pub(crate) length_s: f64,
    pub(crate) well: Well,
    pub(crate) physics: Physics,
    pub(crate) controller: Controller,
    pub(crate) transmitters: [Transmitter; 10],
    pub(crate) faults: [FaultRates; 10],
    /// Level the crew keeps, m below the rotary table.
    pub(crate) level_m: f64,
    /// Delay of the flow meter when none is concealed, s.
    pub(crate) base_delay_s: f64,
}

/// A hundred days, s.
const LONGEST_S: usize = 8_640_000;

/// Speed at which the pump is sized for the level and the usual flow, as a fraction of full.
const DESIGN_SPEED: f64 = 0.6;

impl Rig {
    /// A rig whose recording lasts so many hours, or as many as are drawn, and whose mud is so many times as viscous as drawn.
    pub(crate) fn draw(
        level: Level,
        hours: Option<f64>,
        viscosity: f64,
        noise: &mut Noise,
    ) -> Self {
        let usual = [4.0, 5.0, 5.0, 6.0, 6.0, 8.0];
        let mut drawn: f64 = usual[pick(noise, usual.len())];
        if level == Level::One {
            drawn = drawn.min(6.0);
        }
        let length_s = 3600.0 * hours.unwrap_or(drawn);
        let (family, well) = well(noise);
        let level_m = (well.pump_inlet_depth_m * noise.between(0.3, 0.48)).round();
        let base_delay_s = match level {
            Level::One => 0.25,
            Level::Two => (4.0 * noise.between(0.25, 1.0)).round() / 4.0,
        };
        // Instruments and turbulence of a noisier rig are noisier together.
        let louder = match level {
            Level::One => 1.0,
            Level::Two => [1.0, 1.2, 1.6, 2.0][pick(noise, 4)],
        };
        let mut rig = Self {
            family,
            level,
            length_s,
            physics: physics(level, base_delay_s, louder, noise),
            well,
            controller: controller(noise),
            transmitters: transmitters(level, louder, noise),
            faults: faults(),
            level_m,
            base_delay_s,
        };
        rig.physics.rheology.consistency_pa_sn *= viscosity;
        rig.size_pump();
        rig
    }

    /// Tip speed so that at the design speed the pump lifts the usual flow from the level to the surface.
    fn size_pump(&mut self) {
        let wanted = self.lift_m();
        let (mut low, mut high) = (10.0, 120.0);
        for _ in 0..60 {
            self.physics.pump.tip_speed_m_s = 0.5 * (low + high);
            let shaft = self.physics.pump.shaft(100.0 * DESIGN_SPEED);
            if self.physics.pump.head_m(shaft, self.usual_flow_m3_s()) < wanted {
                low = self.physics.pump.tip_speed_m_s;
            } else {
                high = self.physics.pump.tip_speed_m_s;
            }
        }
    }

    /// Two and a half metres a second in the return line.
    pub(crate) fn usual_flow_m3_s(&self) -> f64 {
        2.5 * self.well.return_line_area_m2()
    }

    fn lift_m(&self) -> f64 {
        let line = &self.physics.line;
        let (rho, v) = (self.well.mud_density_kg_m3, 2.5);
        let wall = self.physics.rheology.friction_gradient_pa_m(
            v,
            self.well.return_line_id_m,
            line.roughness_m,
            rho,
        ) * self.well.pump_outlet_depth_m;
        let friction_pa = wall + line.minor_loss * rho * v * v / 2.0;
        self.level_m + friction_pa / (rho * GRAVITY_M_S2)
    }

    /// Pressure at the pump inlet's depth with the riser at its level, Pa.
    pub(crate) fn inlet_pa(&self) -> f64 {
        ATMOSPHERE_PA
            + self.well.mud_density_kg_m3
                * GRAVITY_M_S2
                * (self.well.pump_inlet_depth_m - self.level_m)
    }

    /// Leakage at 100 m of head that would take all the head at the design point, were the curve straight.
    pub(crate) fn leak_for_all_head_m3_s(&self) -> f64 {
        let pump = &self.physics.pump;
        let (shaft, q) = (pump.shaft(100.0 * DESIGN_SPEED), self.usual_flow_m3_s());
        let slope = (pump.head_m(shaft, q) - pump.head_m(shaft, q + 2e-3)) / 2e-3;
        let leak = pump.head_m(shaft, q) / slope.max(100.0);
        leak / (pump.head_m(shaft, 0.0).max(1.0) / 100.0).sqrt()
    }

    /// Cross-section between riser and casing, m².
    pub(crate) fn casing_area_m2(&self) -> f64 {
        PI / 4.0 * (self.well.riser_id_m.powi(2) - self.well.casing_od_m.powi(2))
    }

    pub(crate) fn plan(&self, seed: u64) -> Plan {
        Plan {
            name: self.family,
            seed,
            series: vec![crate::constants::index(self.length_s, LONGEST_S)],
            well: self.well.clone(),
            physics: self.physics.clone(),
            controller: self.controller.clone(),
            transmitters: self.transmitters.clone(),
            faults: self.faults.clone(),
            historian: Historian {
                poll_s: [1.0; 10],
                deadband: [0.0; 10],
                silence_s: 1800.0,
                gaps_s: Vec::new(),
            },
            schedule: Vec::new(),
            causes: Vec::new(),
        }
    }
}

pub(crate) fn pick(noise: &mut Noise, n: usize) -> usize {
    crate::constants::index(noise.unit() * n as f64, n.saturating_sub(1))
}

fn well(noise: &mut Noise) -> (&'static str, Well) {
    let families = [
        ("gom", (310.0, 400.0), (46.0, 50.0), (1.03, 1.25)),
        ("deep", (450.0, 600.0), (50.0, 54.0), (1.10, 1.60)),
        ("shallow", (220.0, 300.0), (42.0, 46.0), (1.03, 1.35)),
    ];
    let (family, depth, eighths, weight) = families[pick(noise, 3)];
    let depth_m = (10.0 * noise.between(depth.0, depth.1)).round() / 10.0;
    let pipes = [5.0, 5.5, 5.875, 6.625];
    let risers = [19.0, 19.5, 19.5, 19.75, 20.0];
    let inches = noise.between(eighths.0, eighths.1).round() / 8.0;
    let well = Well {
        mud_density_kg_m3: 10.0 * (100.0 * noise.between(weight.0, weight.1)).round(),
        riser_id_m: risers[pick(noise, risers.len())] * INCH_M,
        drillpipe_od_m: pipes[pick(noise, pipes.len())] * INCH_M,
        casing_od_m: 13.625 * INCH_M,
        return_line_id_m: inches * INCH_M,
        pump_inlet_depth_m: depth_m,
        pump_outlet_depth_m: depth_m,
        riser_sensor_depth_m: depth_m + (10.0 * noise.between(1.0, 3.0)).round() / 10.0,
        wellhead_depth_m: depth_m + 1100.0,
    };
    (family, well)
}

fn physics(level: Level, base_delay_s: f64, louder: f64, noise: &mut Noise) -> Physics {
    let two = level == Level::Two;
    let viscosity = noise.between(0.012, 0.03);
    let index = if two { noise.between(0.85, 1.0) } else { 1.0 };
    let line = LineParameters {
        cells: 8,
        wave_speed_m_s: 1000.0,
        roughness_m: if two {
            noise.between(5e-5, 4e-4)
        } else {
            noise.between(3e-5, 6e-5)
        },
        minor_loss: if two {
            noise.between(10.0, 35.0)
        } else {
            noise.between(4.0, 12.0)
        },
        valve_close_s: 0.5,
        valve_leak: 1e-6,
    };
    let textbook = PumpParameters {
        tip_speed_m_s: 38.0,
        stages: 5.0,
        slip_factor: 0.8,
        outlet_area_m2: noise.between(0.027, 0.034),
        blade_cotangent: noise.between(1.6, 2.2),
        design_flow_m3_s: noise.between(0.07, 0.08),
        incidence_s2_m5: noise.between(1200.0, 2500.0),
        channel_loss_m: noise.between(8.0, 14.0),
        channel_exponent: 2.0,
        leakage_m3_s_m05: 0.0,
        lowest_speed: 0.0,
        motor_slip: 0.0,
        slew_pct_s: 80.0,
    };
    let pump = if two {
        // Steep incidence below a far design point bends the curve up to a hump.
        PumpParameters {
            design_flow_m3_s: noise.between(0.08, 0.105),
            incidence_s2_m5: noise.between(3000.0, 7500.0),
            channel_exponent: noise.between(1.7, 2.0),
            leakage_m3_s_m05: noise.between(2e-5, 1e-4),
            lowest_speed: noise.between(0.0, 0.035),
            motor_slip: noise.between(0.0, 0.03),
            ..textbook
        }
    } else {
        textbook
    };
    let ramp = noise.between(8.0, 20.0);
    Physics {
        rheology: Rheology {
            yield_pa: 0.0,
            // The same viscosity at the wall's usual 150 1/s.
            consistency_pa_sn: viscosity * 150_f64.powf(1.0 - index),
            index,
        },
        line,
        pump,
        string_lag_s: if two { noise.between(0.5, 3.0) } else { 0.5 },
        booster_lag_s: if two { noise.between(0.3, 1.5) } else { 0.3 },
        flow_line_lag_s: if two { noise.between(0.05, 0.6) } else { 0.05 },
        flow_meter_delay_s: base_delay_s,
        pit_density_sd_kg_m3: if two { noise.between(0.0, 0.6) } else { 0.0 },
        cuttings_kg_m3: 0.0,
        suction_loss: noise.between(0.3, 1.5),
        mud_pump_ramp_gpm_s: (ramp, 1.2 * ramp),
        tremble_pa: 6800.0 * louder,
        turnover_m3: noise.between(14.0, 26.0),
    }
}

fn controller(noise: &mut Noise) -> Controller {
    Controller {
        gain_pct_m: noise.between(0.7, 1.3),
        integral_s: noise.between(220.0, 420.0),
        filter_s: 8.0,
        limits_pct: (25.0, 100.0),
        rate_pct_s: 2.0,
        setpoint_rate_m_s: noise.between(0.03, 0.06),
    }
}

fn transmitters(level: Level, louder: f64, noise: &mut Noise) -> [Transmitter; 10] {
    let two = level == Level::Two;
    let drift_time_s = noise.between(5000.0, 12_000.0);
    let mut make = |noise_sd: f64, drift: f64, bias: f64, quantum: f64, counts: bool| {
        let accuracy = if two { 0.0005 * noise.normal() } else { 0.0 };
        let wander = if two { noise.between(0.5, 1.0) } else { 0.0 };
        Transmitter {
            gain: if counts { 1.0 + accuracy } else { 1.0 },
            droop: 0.0,
            bias,
            lag_s: 0.15,
            noise: noise_sd * louder,
            drift: drift * wander,
            drift_time_s,
            quantum,
            low_cut: 0.0,
            counts,
        }
    };
    let mud = make(1.8, 0.9, 0.0, 1.0, true);
    let booster = make(1.0, 0.5, 0.0, 1.0, true);
    let topfill = make(0.5, 0.1, 0.0, 0.5, true);
    let back = make(3.6, 1.2, 0.0, 0.5, true);
    let inlet = make(0.23, 0.35, -0.1, 0.2, false);
    let inlet2 = make(0.23, 0.35, 0.1, 0.2, false);
    let outlet = make(0.43, 0.45, 0.1, 0.2, false);
    let outlet2 = make(0.43, 0.45, -0.1, 0.2, false);
    let riser = make(0.23, 0.35, 0.0, 0.2, false);
    let speed = Transmitter {
        gain: 1.0,
        lag_s: 0.0,
        noise: 0.0,
        drift: 0.0,
        quantum: 0.1,
        ..riser.clone()
    };
    [
        mud, booster, topfill, back, inlet, inlet2, outlet, outlet2, riser, speed,
    ]
}

fn faults() -> [FaultRates; 10] {
    let quiet = FaultRates {
        stuck_per_day: 0.0,
        stuck_s: (40.0, 320.0),
        spikes_per_day: 1.5,
        spike_fraction: (0.4, 0.9),
        missing_per_day: 0.8,
        missing_s: (4.0, 60.0),
        zeros_per_day: 0.8,
        zeros_s: (1.0, 2.0),
    };
    std::array::from_fn(|c| {
        let mut rates = quiet.clone();
        match c {
            3 => rates.stuck_per_day = 15.0,
            6 => rates.stuck_per_day = 4.0,
            9 => {
                rates.stuck_per_day = 9.0;
                rates.spikes_per_day = 0.0;
                rates.zeros_per_day = 0.0;
            }
            _ => {}
        }
        rates
    })
}
