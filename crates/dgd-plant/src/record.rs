//! Runs a plan and files what the instruments say.

use crate::cause::Active;
use crate::config::{CHANNELS, Historian, Plan};
use crate::constants::{ATMOSPHERE_PA, GPM_M3_S, GRAVITY_M_S2, PSI_PA};
use crate::control::PumpDesk;
use crate::instrument::{Exception, Fault, FaultKind, Working, spoil};
use crate::noise::Noise;
use crate::plant::{Plant, TrueState};
use crate::schedule::{Control, Segment};

/// Why a plan was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// The recording would be empty, or too long for memory.
    #[error("the plan asks for {found} samples, expected 1 to 8640000")]
    Samples {
        /// Samples asked for.
        found: usize,
    },
    /// Nothing is scheduled.
    #[error("the schedule has no segment, expected at least one")]
    NoSchedule,
    /// A number of the plan is not finite or not positive.
    #[error("`{name}` is {found}, expected a positive number")]
    NotPositive {
        /// The field.
        name: &'static str,
        /// Its value.
        found: f64,
    },
}

/// A recording with the truth behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Seconds since the start of the first series, shape `(n,)`; rises by 1 but where the clock skips.
    pub time_s: Vec<f64>,
    /// The ten channels of [`CHANNELS`] in field units, each of shape `(n,)`; NaN where a value is missing.
    pub channels: [Vec<f64>; 10],
    /// First sample of each series.
    pub starts: Vec<usize>,
    /// What was true at each sample, shape `(n,)`.
    pub truth: Vec<TrueState>,
    /// What was done to the readings.
    pub faults: Vec<Fault>,
}

fn check(plan: &Plan) -> Result<(), PlantError> {
    let found = plan.samples();
    if found == 0 || found > 8_640_000 {
        return Err(PlantError::Samples { found });
    }
    if plan.schedule.is_empty() {
        return Err(PlantError::NoSchedule);
    }
    let w = &plan.well;
    for (name, found) in [
        ("well.mud_density_kg_m3", w.mud_density_kg_m3),
        ("well.return_line_id_m", w.return_line_id_m),
        ("well.annulus_area_m2", w.annulus_area_m2()),
        ("well.pump_inlet_depth_m", w.pump_inlet_depth_m),
        ("well.pump_outlet_depth_m", w.pump_outlet_depth_m),
        ("well.riser_sensor_depth_m", w.riser_sensor_depth_m),
        (
            "physics.line.wave_speed_m_s",
            plan.physics.line.wave_speed_m_s,
        ),
        ("physics.line.valve_leak", plan.physics.line.valve_leak),
        (
            "physics.line.valve_close_s",
            plan.physics.line.valve_close_s,
        ),
        ("physics.pump.slew_pct_s", plan.physics.pump.slew_pct_s),
        ("controller.rate_pct_s", plan.controller.rate_pct_s),
        (
            "controller.setpoint_rate_m_s",
            plan.controller.setpoint_rate_m_s,
        ),
        ("controller.limits_pct.0", plan.controller.limits_pct.0),
        (
            "the span of controller.limits_pct",
            plan.controller.limits_pct.1 - plan.controller.limits_pct.0,
        ),
        ("controller.integral_s", plan.controller.integral_s),
        ("controller.filter_s", plan.controller.filter_s),
    ] {
        if !(found.is_finite() && found > 0.0) {
            return Err(PlantError::NotPositive { name, found });
        }
    }
    Ok(())
}

/// Makes the recording a plan describes. The same plan gives the same recording.
///
/// # Errors
/// [`PlantError::Samples`] on an empty or overlong recording, [`PlantError::NoSchedule`] on an empty
/// schedule, [`PlantError::NotPositive`] on a length, density or time constant that cannot be.
pub fn record(plan: &Plan) -> Result<Recording, PlantError> {
    check(plan)?;
    let begin_m = begin_m(plan);
    let causes = Active::new(&plan.causes);
    let mut plant = Plant::new(&plan.well, &plan.physics, &causes, plan.seed, begin_m);
    let mut desk = PumpDesk::new(&plan.controller, begin_m);
    let mut readers: Vec<Working> = plan
        .transmitters
        .iter()
        .zip(100..)
        .map(|(kind, stream)| Working::new(kind, plan.seed, stream))
        .collect();
    let mut shift = Shift::new(&plan.schedule);
    let mut files = Files::new(plan);
    let mut level_seen_m = begin_m;
    // The plant runs in for twenty minutes before the recording begins.
    let mut clock_s: f64 = -1200.0;
    while !files.full() {
        if clock_s >= 0.0 {
            shift.tick();
        }
        let orders = shift.orders();
        let order_pct = desk.order(orders.control, level_seen_m);
        let state = plant.second(orders, order_pct, clock_s, shift.restart_s());
        let reading = read_all(&mut readers, &plant, &state, order_pct);
        level_seen_m = plan.well.riser_sensor_depth_m
            - (reading[8] * PSI_PA - ATMOSPHERE_PA) / (plan.well.mud_density_kg_m3 * GRAVITY_M_S2);
        if clock_s >= 0.0 {
            files.add(clock_s, &reading, state, orders.every_second);
        }
        clock_s += 1.0;
    }
    let mut rec = files.close();
    for (c, values) in rec.channels.iter_mut().enumerate() {
        let mut noise = Noise::new(plan.seed, 200 + c as u64);
        rec.faults
            .extend(spoil(values, c, &plan.faults[c], &mut noise));
    }
    Ok(rec)
}

/// The first level that the crew asks for; the riser stands there at the start.
fn begin_m(plan: &Plan) -> f64 {
    let asked = plan.schedule.iter().find_map(|s| match s.control {
        Control::Level(m) => Some(m),
        _ => None,
    });
    asked.unwrap_or(0.4 * plan.well.pump_inlet_depth_m)
}

/// The crew goes through its schedule, and stays in the last segment.
struct Shift<'a> {
    /// The present segment and those after it.
    segments: &'a [Segment],
    left_s: f64,
}

impl<'a> Shift<'a> {
    fn new(segments: &'a [Segment]) -> Self {
        let left_s = segments[0].duration_s;
        Self { segments, left_s }
    }

    fn orders(&self) -> &'a Segment {
        &self.segments[0]
    }

    /// A second goes by.
    fn tick(&mut self) {
        while self.left_s <= 0.0 && self.segments.len() > 1 {
            self.segments = &self.segments[1..];
            self.left_s = self.orders().duration_s;
        }
        self.left_s -= 1.0;
    }

    /// Until the crew wants the mud pump again, s: 0 while it does, without end if it never does.
    fn restart_s(&self) -> f64 {
        let stands = |s: &Segment| s.mud_pump_gpm <= 0.0;
        if !stands(self.orders()) {
            return 0.0;
        }
        let mut waits_s = self.left_s;
        for next in &self.segments[1..] {
            if !stands(next) {
                return waits_s;
            }
            waits_s += next.duration_s;
        }
        f64::INFINITY
    }
}

/// The recording as the historian files it.
struct Files<'a> {
    historian: &'a Historian,
    samples: usize,
    rec: Recording,
    channels: Vec<Exception>,
    /// What of a gap is still to come, s.
    skip_s: f64,
    /// Since when values are filed by exception.
    silent_since: Option<usize>,
}

impl<'a> Files<'a> {
    fn new(plan: &'a Plan) -> Self {
        let n = plan.samples();
        let first_of = |first: &mut usize, count: &usize| {
            let start = *first;
            *first += count;
            Some(start)
        };
        Self {
            historian: &plan.historian,
            samples: n,
            rec: Recording {
                time_s: Vec::with_capacity(n),
                channels: std::array::from_fn(|_| Vec::with_capacity(n)),
                starts: plan.series.iter().scan(0, first_of).collect(),
                truth: Vec::with_capacity(n),
                faults: Vec::new(),
            },
            channels: vec![Exception::default(); CHANNELS.len()],
            skip_s: 0.0,
            silent_since: None,
        }
    }

    fn full(&self) -> bool {
        self.rec.time_s.len() >= self.samples
    }

    /// Files the readings of a second, unless the clock skips it; `live` ones as they are.
    fn add(&mut self, clock_s: f64, reading: &[f64; 10], state: TrueState, live: bool) {
        let i = self.rec.time_s.len();
        let mut gaps = self.historian.gaps_s.iter();
        if let Some(&(_, lost_s)) = gaps.find(|(at_s, _)| at_s.to_bits() == clock_s.to_bits()) {
            self.skip_s = lost_s;
            self.rec.faults.push(Fault {
                channel: None,
                kind: FaultKind::Gap,
                first: i,
                count: crate::constants::index(lost_s, self.samples),
            });
        }
        let filed = self.filed(reading, live);
        if self.skip_s > 0.0 {
            self.skip_s -= 1.0;
            return;
        }
        self.rec.time_s.push(clock_s);
        for (channel, value) in self.rec.channels.iter_mut().zip(filed) {
            channel.push(value);
        }
        self.rec.truth.push(state);
        if live {
            self.end_silence(i);
        } else {
            self.silent_since.get_or_insert(i);
        }
    }

    fn filed(&mut self, reading: &[f64; 10], live: bool) -> [f64; 10] {
        if live {
            self.channels.iter_mut().for_each(Exception::forget);
            return *reading;
        }
        let h = self.historian;
        std::array::from_fn(|c| {
            self.channels[c].file(reading[c], h.poll_s[c], h.deadband[c], h.silence_s)
        })
    }

    fn end_silence(&mut self, end: usize) {
        if let Some(first) = self.silent_since.take() {
            self.rec.faults.push(Fault {
                channel: None,
                kind: FaultKind::Exception,
                first,
                count: end - first,
            });
        }
    }

    fn close(mut self) -> Recording {
        self.end_silence(self.rec.time_s.len());
        self.rec
    }
}

fn read_all(
    readers: &mut [Working],
    plant: &Plant,
    state: &TrueState,
    order_pct: f64,
) -> [f64; 10] {
    let [mud, booster, topfill] = plant.rig_pumps_m3_s();
    let truth = [
        mud / GPM_M3_S,
        booster / GPM_M3_S,
        topfill / GPM_M3_S,
        state.metered_flow_m3_s / GPM_M3_S,
        state.pump_inlet_pa / PSI_PA,
        state.pump_inlet_pa / PSI_PA,
        state.pump_outlet_pa / PSI_PA,
        state.pump_outlet_pa / PSI_PA,
        state.riser_sensor_pa / PSI_PA,
        order_pct,
    ];
    let errors = plant.instrument_errors();
    let unit = |c: usize| if c < 4 { GPM_M3_S } else { PSI_PA };
    let mut out = [0.0; 10];
    for (c, (o, r)) in out.iter_mut().zip(readers).enumerate() {
        *o = r.read(truth[c] + errors[c] / unit(c));
    }
    out
}
