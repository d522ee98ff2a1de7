//! Everything about a recording that can be chosen, and the two presets.

use crate::cause::Cause;
use crate::instrument::{FaultRates, Transmitter};
use crate::line::LineParameters;
use crate::mud::Rheology;
use crate::pump::PumpParameters;
use crate::schedule::{self, Segment};
use crate::well::Well;

/// Names of the measured channels, in the order of [`crate::Recording::channels`] and of the thesis's Table 2.1.
pub const CHANNELS: [&str; 10] = [
    "FT1", "FT2", "FT3", "FT4", "PT1", "PT2", "PT3", "PT4", "PT5", "SPM",
];

/// Units of the channels, in the order of [`CHANNELS`]. Pressures are absolute.
pub const UNITS: [&str; 10] = [
    "gpm", "gpm", "gpm", "gpm", "psi", "psi", "psi", "psi", "psi", "%",
];

/// The physical plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Physics {
    /// How the mud flows.
    pub rheology: Rheology,
    /// The return line.
    pub line: LineParameters,
    /// The subsea pump.
    pub pump: PumpParameters,
    /// Lag of the bit's flow behind the mud pump (compressed drill string), s.
    pub string_lag_s: f64,
    /// Lag of the booster line's outflow, s.
    pub booster_lag_s: f64,
    /// Time constant of each of the two tanks the flow line at surface amounts to, s.
    pub flow_line_lag_s: f64,
    /// Time the mud then takes to the flow meter, with the meter's own processing, s.
    pub flow_meter_delay_s: f64,
    /// Spread of the active pit's density, kg/m³.
    pub pit_density_sd_kg_m3: f64,
    /// What cuttings add to the density of the flow from the bit while drilling, kg/m³.
    pub cuttings_kg_m3: f64,
    /// Loss coefficient of the suction line on the return line's velocity head.
    pub suction_loss: f64,
    /// How fast the mud pump is brought up and down, US gallons a minute per second.
    pub mud_pump_ramp_gpm_s: (f64, f64),
    /// How the outlet pressure trembles at the usual flow, Pa, in both outlet transmitters alike.
    pub tremble_pa: f64,
    /// Volume of mud that turns over when its weight changes, m³; used with the causes that change it.
    pub turnover_m3: f64,
}

/// The level controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    /// Proportional gain, % of speed per metre.
    pub gain_pct_m: f64,
    /// Integral time, s.
    pub integral_s: f64,
    /// Filter on the measured level, s.
    pub filter_s: f64,
    /// Lowest and highest speed, %.
    pub limits_pct: (f64, f64),
    /// Fastest change of the order, %/s.
    pub rate_pct_s: f64,
    /// Fastest move of the level set-point, m/s.
    pub setpoint_rate_m_s: f64,
}

/// The historian.
#[derive(Debug, Clone, PartialEq)]
pub struct Historian {
    /// How often a channel filed by exception is looked at, s.
    pub poll_s: [f64; 10],
    /// Deadband of every channel in stretches filed by exception, in the channel's unit; 0 files all.
    pub deadband: [f64; 10],
    /// Longest silence of a channel filed by exception, s.
    pub silence_s: f64,
    /// Places where the clock skips: seconds since the start, seconds lost.
    pub gaps_s: Vec<(f64, f64)>,
}

/// A recording to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Name of the preset, for the provenance.
    pub name: &'static str,
    /// Seed of all noise and of the crew's timing.
    pub seed: u64,
    /// Samples of each of the consecutive series, 1 Hz.
    pub series: Vec<usize>,
    /// The well.
    pub well: Well,
    /// The plant.
    pub physics: Physics,
    /// The level controller.
    pub controller: Controller,
    /// The ten transmitters, in the order of [`CHANNELS`].
    pub transmitters: [Transmitter; 10],
    /// What goes wrong in each channel, in the order of [`CHANNELS`].
    pub faults: [FaultRates; 10],
    /// What is filed.
    pub historian: Historian,
    /// What the crew does; the last segment lasts until the recording ends.
    pub schedule: Vec<Segment>,
    /// What the plant conceals: physics beyond the clean plant. Empty in the presets.
    pub causes: Vec<Cause>,
}

fn flow(gain: f64, bias: f64, lag_s: f64, noise: f64, quantum: f64, low_cut: f64) -> Transmitter {
    Transmitter {
        gain,
        droop: 0.0,
        bias,
        lag_s,
        noise,
        drift: 1.0,
        drift_time_s: 7200.0,
        quantum,
        low_cut,
        counts: false,
    }
}

fn strokes(gain: f64, noise: f64) -> Transmitter {
    Transmitter {
        drift: 0.3,
        counts: true,
        ..flow(gain, 0.0, 1.0, noise, 1.0, 0.0)
    }
}

fn pressure(gain: f64, bias: f64) -> Transmitter {
    Transmitter {
        gain,
        droop: 0.0,
        bias,
        lag_s: 0.5,
        noise: 0.18,
        drift: 0.2,
        drift_time_s: 20_000.0,
        quantum: 0.2,
        low_cut: 0.0,
        counts: false,
    }
}

/// Behind the pump the pressure trembles with the blades and the turbulence.
fn discharge(gain: f64, bias: f64) -> Transmitter {
    Transmitter {
        noise: 0.5,
        ..pressure(gain, bias)
    }
}

fn physics() -> Physics {
    Physics {
        rheology: Rheology {
            yield_pa: 0.1,
            consistency_pa_sn: 0.02,
            index: 0.88,
        },
        line: LineParameters {
            cells: 16,
            wave_speed_m_s: 1000.0,
            roughness_m: 3.5e-4,
            minor_loss: 35.0,
            valve_close_s: 5.0,
            valve_leak: 1.2e-3,
        },
        pump: PumpParameters {
            tip_speed_m_s: 38.0,
            stages: 5.0,
            slip_factor: 0.8,
            outlet_area_m2: 0.03,
            blade_cotangent: 1.9,
            design_flow_m3_s: 0.075,
            incidence_s2_m5: 1500.0,
            channel_loss_m: 10.0,
            channel_exponent: 1.8,
            leakage_m3_s_m05: 7e-5,
            lowest_speed: 0.038,
            motor_slip: 0.03,
            slew_pct_s: 12.0,
        },
        string_lag_s: 2.0,
        booster_lag_s: 1.0,
        flow_line_lag_s: 2.5,
        flow_meter_delay_s: 5.75,
        pit_density_sd_kg_m3: 5.5,
        cuttings_kg_m3: 7.0,
        suction_loss: 1.5,
        mud_pump_ramp_gpm_s: (4.0, 6.0),
        tremble_pa: 0.0,
        turnover_m3: 20.0,
    }
}

fn transmitters() -> [Transmitter; 10] {
    [
        // Strokes times a displacement that the worn liners no longer reach.
        strokes(1.004, 1.2),
        strokes(1.006, 0.8),
        flow(1.01, 0.4, 1.0, 0.6, 1.0, 2.0),
        // A meter in a line that carries some air reads ever lower as it fills.
        Transmitter {
            droop: 8e-5,
            ..flow(1.048, 0.0, 2.15, 3.0, 0.5, 12.0)
        },
        pressure(1.0005, -0.3),
        pressure(0.9995, 0.4),
        discharge(0.999, -3.8),
        discharge(0.9988, -3.0),
        pressure(1.0003, 0.2),
        Transmitter {
            gain: 1.0,
            droop: 0.0,
            bias: 0.0,
            lag_s: 0.0,
            noise: 0.0,
            drift: 0.0,
            drift_time_s: 1.0,
            quantum: 0.1,
            low_cut: 0.0,
            counts: false,
        },
    ]
}

fn controller() -> Controller {
    Controller {
        gain_pct_m: 1.3,
        integral_s: 240.0,
        filter_s: 1.0,
        limits_pct: (12.0, 100.0),
        rate_pct_s: 1.5,
        setpoint_rate_m_s: 0.03,
    }
}

fn faults() -> [FaultRates; 10] {
    let flow = FaultRates {
        stuck_per_day: 4.0,
        stuck_s: (40.0, 400.0),
        spikes_per_day: 6.0,
        spike_fraction: (0.1, 0.6),
        missing_per_day: 5.0,
        missing_s: (1.0, 12.0),
        zeros_per_day: 0.7,
        zeros_s: (1.0, 4.0),
    };
    // Pressure transmitters fail more gently than flow meters.
    let pressure = FaultRates {
        stuck_per_day: 1.0,
        stuck_s: (20.0, 150.0),
        spikes_per_day: 4.0,
        spike_fraction: (0.01, 0.05),
        zeros_per_day: 0.0,
        ..flow.clone()
    };
    // The set-point is a number in a computer: it can be late or absent, not wild.
    let speed = FaultRates {
        spikes_per_day: 0.0,
        zeros_per_day: 0.0,
        stuck_per_day: 3.0,
        ..flow.clone()
    };
    std::array::from_fn(|c| match c {
        0..=3 => flow.clone(),
        4..=8 => pressure.clone(),
        _ => speed.clone(),
    })
}

impl Plan {
    /// Seed of the stand-in for the thesis's recording: of the first eight, its ladder lies nearest.
    pub const GOM_SEED: u64 = 5;
    /// Seed of the demonstration.
    pub const SHORT_SEED: u64 = 3;

    /// The thesis-sized stand-in: 305,820 samples in four consecutive series over 85 hours.
    pub fn gom(seed: u64) -> Self {
        Self {
            name: "gom",
            seed,
            series: vec![80_000, 76_000, 75_000, 74_820],
            well: Well::gom(),
            physics: physics(),
            controller: controller(),
            transmitters: transmitters(),
            faults: faults(),
            historian: Historian {
                poll_s: [15.0, 15.0, 15.0, 600.0, 1.0, 1.0, 1.0, 1.0, 1.0, 5.0],
                deadband: [4.0, 4.0, 3.0, 8.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3],
                silence_s: 1800.0,
                gaps_s: vec![
                    (80_000.0, 95.0),
                    (118_340.0, 14.0),
                    (156_100.0, 240.0),
                    (201_777.0, 3.0),
                    (231_400.0, 61.0),
                    (290_050.0, 27.0),
                ],
            },
            schedule: schedule::gom(seed),
            causes: Vec::new(),
        }
    }

    /// A compact demonstration: two hours, 7,200 samples, one stand, one connection, one pump stop.
    pub fn short(seed: u64) -> Self {
        let mut plan = Self::gom(seed);
        plan.name = "short";
        plan.series = vec![7200];
        plan.schedule = schedule::short(seed);
        plan.historian.gaps_s = Vec::new();
        // In two hours a few faults must show, and must not swamp what there is.
        for rates in &mut plan.faults {
            rates.missing_per_day = 20.0;
            rates.stuck_per_day *= 1.5;
            rates.stuck_s = (20.0, 120.0);
        }
        plan
    }

    /// The same plan for a recording of another length; series keep their shares, to the sample.
    ///
    /// At most 100 days. The places of clock skips and the schedule stay where they are.
    pub fn with_hours(mut self, hours: f64) -> Self {
        const LONGEST: usize = 8_640_000;
        let scale = (hours * 3600.0).round() / self.samples().max(1) as f64;
        let (mut old_end, mut new_end) = (0.0, 0);
        for n in &mut self.series {
            old_end += *n as f64;
            let end = crate::constants::index((old_end * scale).round(), LONGEST);
            *n = end - new_end;
            new_end = end;
        }
        self
    }

    /// Samples of all series together.
    pub fn samples(&self) -> usize {
        self.series.iter().fold(0, |sum, &n| sum.saturating_add(n))
    }
}
