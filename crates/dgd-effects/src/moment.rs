//! The rig at one moment, what effects change in it, and what they know beforehand.

use dgd_recording::{Rank, Recording, STANDING_M3_S, Well, quantile, readings};
use dgd_units::{STANDARD_ATMOSPHERE_PA, STANDARD_GRAVITY_M_S2};

/// The rig at one sample, as measured or as simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Sample number on the even clock.
    pub index: usize,
    /// Time of the recording's clock, s.
    pub t_s: f64,
    /// Step of the clock, s.
    pub dt_s: f64,
    /// Mud pump flow by its meter, m³/s.
    pub mud_pump_m3_s: f64,
    /// Booster flow by its meter, m³/s.
    pub booster_m3_s: f64,
    /// Topfill flow by its meter, m³/s.
    pub topfill_m3_s: f64,
    /// Flow through the pump into the return line, m³/s; what its meter shows, where it is measured.
    pub flow_m3_s: f64,
    /// Flow out of the return line's top, m³/s: none while the line fills, and what the meter shows where it is measured.
    pub outflow_m3_s: f64,
    /// Set-point of the pump's speed, %.
    pub speed_pct: f64,
    /// Pump inlet pressure, Pa absolute.
    pub inlet_pa: f64,
    /// Pump outlet pressure, Pa absolute.
    pub outlet_pa: f64,
    /// Whether the subsea pump turns.
    pub pumping: bool,
}

/// What effects change at one moment; the default changes nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Changes {
    /// Flow into the riser that the flow meters do not tell of, m³/s; negative is a loss.
    pub inflow_m3_s: f64,
    /// True riser area over the area of the well file.
    pub area_factor: f64,
    /// Density above the well file's that entering mud adds to the mass which the pump inlet feels, kg/m³: its own, where all that is
    /// stirred stands above the inlet.
    pub entering_kg_m3: f64,
    /// Density of the mud that leaves the riser above the well file's, kg/m³.
    pub riser_kg_m3: f64,
    /// Mean density in the return line above the well file's, kg/m³.
    pub line_kg_m3: f64,
    /// Further pressure drop along the line, Pa.
    pub line_drop_pa: f64,
    /// Factor on the line's friction.
    pub friction_factor: f64,
    /// Height by which the mud surface in the line has fallen, m; nothing leaves the line's top before it is full again.
    pub line_fall_m: f64,
    /// Factor on the pump's head.
    pub head_factor: f64,
    /// Further pressure rise over the pump, Pa.
    pub head_pa: f64,
    /// True speed of the pump less its set-point, %.
    pub speed_pct: f64,
    /// Flow that returns inside the pump from outlet to inlet, m³/s.
    pub recirculation_m3_s: f64,
    /// Flow lost between pump and flow meter, m³/s.
    pub leak_m3_s: f64,
    /// Return flow by the meter over the true one.
    pub meter_gain: f64,
    /// Reading less truth of either outlet transmitter, Pa.
    pub outlet_bias_pa: [f64; 2],
    /// Reading less truth of either inlet transmitter, Pa; one that stands alone is both.
    pub inlet_bias_pa: [f64; 2],
    /// Reading less truth of the riser's transmitter, Pa.
    pub riser_bias_pa: f64,
}

impl Default for Changes {
    fn default() -> Self {
        Self {
            inflow_m3_s: 0.0,
            area_factor: 1.0,
            entering_kg_m3: 0.0,
            riser_kg_m3: 0.0,
            line_kg_m3: 0.0,
            line_drop_pa: 0.0,
            friction_factor: 1.0,
            line_fall_m: 0.0,
            head_factor: 1.0,
            head_pa: 0.0,
            speed_pct: 0.0,
            recirculation_m3_s: 0.0,
            leak_m3_s: 0.0,
            meter_gain: 1.0,
            outlet_bias_pa: [0.0; 2],
            inlet_bias_pa: [0.0; 2],
            riser_bias_pa: 0.0,
        }
    }
}

impl Changes {
    /// What the inlet pressure reads too much, Pa, as the mean of both transmitters; a single one has both.
    pub fn read_inlet_bias_pa(&self) -> f64 {
        let [first, second] = self.inlet_bias_pa;
        0.5 * (first + second)
    }

    /// What the outlet pressure reads too much, Pa, as the mean of so many transmitters; a single one is the first.
    pub fn read_outlet_bias_pa(&self, transmitters: usize) -> f64 {
        let [first, second] = self.outlet_bias_pa;
        if transmitters < 2 {
            first
        } else {
            0.5 * (first + second)
        }
    }
}

/// Rate of a pump rather than of a kick that goes on for minutes, m³/s: a barrel every quarter of a minute. Set by hand.
pub const PUMPED_M3_S: f64 = 0.01;

/// Time over which the mean of what is measured is the state that a free run starts from, s: less noisy than one sample. Set by hand.
pub const START_S: f64 = 5.0;

/// What a [leak](Changes::leak_m3_s) takes while so much leaves the line at its end, m³/s: nothing of mud that stands.
pub fn leaking_m3_s(leak_m3_s: f64, outflow_m3_s: f64) -> f64 {
    if outflow_m3_s > STANDING_M3_S {
        leak_m3_s
    } else {
        0.0
    }
}

/// A stretch in which the mud pump stands: a connection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Connection {
    /// When the mud pump has stopped, s.
    pub from_s: f64,
    /// When it starts again, s.
    pub to_s: f64,
}

/// What effects know of well and recording before they start.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Mud density of the well file, kg/m³.
    pub density_kg_m3: f64,
    /// Cross-section of the riser annulus, m².
    pub riser_area_m2: f64,
    /// Cross-section of the return line, m².
    pub line_area_m2: f64,
    /// Inner diameter of the return line, m.
    pub line_diameter_m: f64,
    /// Length of the return line, m.
    pub line_length_m: f64,
    /// Mud in the riser, typically, m³.
    pub riser_volume_m3: f64,
    /// Start and end of the recording, s.
    pub span_s: (f64, f64),
    /// 2nd and 98th percentile of the inlet pressure, Pa.
    pub inlet_range_pa: (f64, f64),
    /// Stretches without mud pump flow, in order.
    pub connections: Vec<Connection>,
    /// Outlet transmitters, whose mean is the outlet pressure.
    pub outlets: usize,
    /// Noise of the channels that effects delay.
    pub noise: Noise,
}

/// Standard deviations of the noise from reading to reading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Noise {
    /// Mud pump flow, m³/s.
    pub mud_pump_m3_s: f64,
    /// Booster flow, m³/s.
    pub booster_m3_s: f64,
    /// Return flow, m³/s.
    pub flow_m3_s: f64,
    /// Pump speed, %.
    pub speed_pct: f64,
    /// Inlet pressure, Pa.
    pub inlet_pa: f64,
}

/// A change with what noise makes of it taken away.
///
/// `x³ / (x² + 9 s²)` for a change x and noise s: small changes vanish, large ones stay. The difference of a channel
/// from its delayed self holds the channel's noise, which its relation's residual
/// holds too; left in, noise would pass for a delay (errors in variables).
pub fn shrunk(change: f64, noise: f64) -> f64 {
    let gate = 3.0 * noise;
    let square = change * change;
    if square > 0.0 {
        change * square / (square + gate * gate)
    } else {
        0.0
    }
}

/// Noise of a series: the median absolute second difference of its readings, as a standard deviation.
fn noise(values: &[f64], step_s: f64) -> f64 {
    let read: Vec<f64> = readings(values, step_s).map(|i| values[i]).collect();
    let second = read.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs());
    // 0.6745 turns a median absolute value into a deviation, 6 is 1 + 4 + 1.
    quantile(second, Rank::Nearest(0.5)).unwrap_or(0.0) / 0.6745 / 6.0_f64.sqrt()
}

/// Value at a fraction of the sorted finite values, 0 if there are none.
fn fraction(values: &[f64], fraction: f64) -> f64 {
    quantile(values.iter().copied(), Rank::Nearest(fraction)).unwrap_or(0.0)
}

impl Setting {
    /// Reads the setting off a well and its recording on an even clock.
    ///
    /// `inlet_pa`: pump inlet pressure, Pa absolute, shape `(n,)`, as the mean of its transmitters. Values that are not
    /// finite are passed over. The riser's volume follows from the median inlet pressure; a connection is a minute or
    /// more with less than a tenth of the mud pump's 80th percentile, of that while it runs where it stands for most of the time.
    pub fn of(well: &Well, recording: &Recording, inlet_pa: &[f64]) -> Self {
        let geometry = &well.geometry;
        let weight = well.mud_density_kg_m3 * STANDARD_GRAVITY_M_S2;
        let level = ((fraction(inlet_pa, 0.5) - STANDARD_ATMOSPHERE_PA) / weight).max(1.0);
        let time = &recording.time_s;
        let step_s = match time.as_slice() {
            [first, .., last] => (last - first) / (time.len() - 1) as f64,
            _ => 0.0,
        };
        Self {
            density_kg_m3: well.mud_density_kg_m3,
            riser_area_m2: geometry.riser_area_m2(),
            line_area_m2: geometry.line_area_m2(),
            line_diameter_m: geometry.return_line_id_m,
            line_length_m: geometry.pump_outlet_depth_m,
            riser_volume_m3: level * geometry.riser_area_m2(),
            span_s: (
                time.first().copied().unwrap_or(0.0),
                time.last().copied().unwrap_or(0.0),
            ),
            inlet_range_pa: (fraction(inlet_pa, 0.02), fraction(inlet_pa, 0.98)),
            connections: connections(time, &recording.mud_pump_flow_m3_s),
            outlets: recording.pump_outlet_pressure_pa.len(),
            noise: Noise {
                mud_pump_m3_s: noise(&recording.mud_pump_flow_m3_s, step_s),
                booster_m3_s: noise(&recording.booster_flow_m3_s, step_s),
                flow_m3_s: noise(&recording.return_flow_m3_s, step_s),
                speed_pct: noise(&recording.pump_speed_pct, step_s),
                inlet_pa: noise(inlet_pa, step_s),
            },
        }
    }

    /// Volume of the return line, m³.
    pub fn line_volume_m3(&self) -> f64 {
        self.line_area_m2 * self.line_length_m
    }
}

/// Stretches of a minute or more with less than a tenth of the usual mud pump flow.
fn connections(time_s: &[f64], flow_m3_s: &[f64]) -> Vec<Connection> {
    let all = fraction(flow_m3_s, 0.8);
    // A pump that stands for most of a recording has its usual flow when it runs.
    let running = flow_m3_s.iter().copied().filter(|q| *q > STANDING_M3_S);
    let usual = if all > STANDING_M3_S {
        all
    } else {
        quantile(running, Rank::Nearest(0.8)).unwrap_or(0.0)
    };
    let threshold = 0.1 * usual;
    let mut found: Vec<Connection> = Vec::new();
    let mut from: Option<f64> = None;
    for (&t, &q) in time_s.iter().zip(flow_m3_s) {
        if q < threshold {
            from.get_or_insert(t);
        } else if q >= threshold
            && let Some(start) = from.take()
        {
            found.push(Connection {
                from_s: start,
                to_s: t,
            });
        }
    }
    if let (Some(start), Some(&end)) = (from, time_s.last()) {
        found.push(Connection {
            from_s: start,
            to_s: end,
        });
    }
    found.retain(|c| c.to_s - c.from_s >= 60.0);
    found
}

/// A first-order lag, exact for an input that runs straight from sample to sample.
///
/// Held over the step it would come half a step too soon, and a lag that is fitted would be as much too long.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lag {
    /// What it shows, and what it was given last.
    value: Option<(f64, f64)>,
    tau_s: f64,
    /// The last step, s, its share of the way, and that of what the input goes on by: the clock is even, and exponentials are dear.
    step_s: f64,
    share: f64,
    ramp: f64,
}

impl Lag {
    pub(crate) fn new(tau_s: f64) -> Self {
        Self {
            value: None,
            tau_s,
            step_s: 0.0,
            share: 0.0,
            ramp: 0.0,
        }
    }

    /// One that has shown a value for long.
    pub(crate) fn at(value: f64, tau_s: f64) -> Self {
        Self {
            value: Some((value, value)),
            ..Self::new(tau_s)
        }
    }

    /// How long a lag remembers: e⁻⁶⁰ is far below a digit.
    pub(crate) fn memory_s(tau_s: f64) -> f64 {
        60.0 * tau_s.max(0.0)
    }

    pub(crate) fn step(&mut self, input: f64, dt_s: f64) -> f64 {
        if self.step_s != dt_s {
            self.step_s = dt_s;
            (self.share, self.ramp) = lagging(self.tau_s, dt_s);
        }
        let value = match self.value {
            Some((value, before)) if input.is_finite() => {
                value + self.share * (before - value) + self.ramp * (input - before)
            }
            Some((value, _)) => return value,
            None if input.is_finite() => input,
            None => return 0.0,
        };
        self.value = Some((value, input));
        value
    }
}

/// What a lag goes in a step: its share of the way to the input before, and of what the input goes on by.
pub(crate) fn lagging(tau_s: f64, dt_s: f64) -> (f64, f64) {
    let tau_s = tau_s.max(0.0);
    let share = -(-dt_s / tau_s).exp_m1();
    (share, 1.0 - share * tau_s / dt_s)
}

/// Least mixed volume, over mud in the riser: below it mixing is at once.
pub(crate) const MIXING_LEAST: f64 = 1e-3;

/// A stirred volume through which mud flows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stirred {
    pub(crate) value: f64,
    volume_m3: f64,
}

impl Stirred {
    pub(crate) fn new(volume_m3: f64) -> Self {
        Self {
            value: 0.0,
            volume_m3,
        }
    }

    pub(crate) fn step(&mut self, entering: f64, flow_m3_s: f64, dt_s: f64) -> f64 {
        let turned = (flow_m3_s.max(0.0) * dt_s / self.volume_m3.max(1e-6)).min(50.0);
        self.value += (1.0 - (-turned).exp()) * (entering - self.value);
        self.value
    }
}
