//! Runs a plan and files what the instruments say.

use crate::cause::Active;
use crate::config::{CHANNELS, Plan};
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
    let n = plan.samples();
    let mut starts = Vec::with_capacity(plan.series.len());
    let mut first = 0;
    for &count in &plan.series {
        starts.push(first);
        first += count;
    }

    let begin_m = plan
        .schedule
        .iter()
        .find_map(|s| {
            if let Control::Level(m) = s.control {
                Some(m)
            } else {
                None
            }
        })
        .unwrap_or(0.4 * plan.well.pump_inlet_depth_m);
    let causes = Active::new(&plan.causes);
    let mut plant = Plant::new(&plan.well, &plan.physics, &causes, plan.seed, begin_m);
    let mut desk = PumpDesk::new(&plan.controller, begin_m);
    let mut readers: Vec<Working> = plan
        .transmitters
        .iter()
        .zip(100..)
        .map(|(kind, stream)| Working::new(kind, plan.seed, stream))
        .collect();
    let mut filing: Vec<Exception> = vec![Exception::default(); CHANNELS.len()];
    let mut rec = Recording {
        time_s: Vec::with_capacity(n),
        channels: std::array::from_fn(|_| Vec::with_capacity(n)),
        starts,
        truth: Vec::with_capacity(n),
        faults: Vec::new(),
    };

    let mut segments = plan.schedule.iter().peekable();
    let mut left_s = segments.peek().map_or(0.0, |s| s.duration_s);
    let mut orders = &plan.schedule[0];
    let mut level_seen_m = begin_m;
    let mut skip_s: f64 = 0.0;
    // The plant runs in for twenty minutes before the recording begins.
    let mut clock_s: f64 = -1200.0;
    let mut silent_since: Option<usize> = None;
    while rec.time_s.len() < n {
        if clock_s >= 0.0 {
            while left_s <= 0.0 && segments.len() > 1 {
                segments.next();
                if let Some(next) = segments.peek() {
                    orders = next;
                    left_s = next.duration_s;
                }
            }
            left_s -= 1.0;
        }
        let order_pct = desk.order(orders.control, level_seen_m);
        let restart_s = restart_s(segments.clone(), left_s);
        let state = plant.second(orders, order_pct, clock_s, restart_s);
        let reading = read_all(&mut readers, &plant, &state, order_pct);
        level_seen_m = plan.well.riser_sensor_depth_m
            - (reading[8] * PSI_PA - ATMOSPHERE_PA) / (plan.well.mud_density_kg_m3 * GRAVITY_M_S2);
        if clock_s >= 0.0 {
            if let Some(&(_, lost)) = plan
                .historian
                .gaps_s
                .iter()
                .find(|&&(at, _)| at.to_bits() == clock_s.to_bits())
            {
                skip_s = lost;
                let (first, count) = (rec.time_s.len(), crate::constants::index(lost, n));
                rec.faults.push(Fault {
                    channel: None,
                    kind: FaultKind::Gap,
                    first,
                    count,
                });
            }
            let live = orders.every_second;
            let i = rec.time_s.len();
            if live {
                filing.iter_mut().for_each(Exception::forget);
            }
            let filed: [f64; 10] = std::array::from_fn(|c| {
                if live {
                    reading[c]
                } else {
                    filing[c].file(
                        reading[c],
                        plan.historian.poll_s[c],
                        plan.historian.deadband[c],
                        plan.historian.silence_s,
                    )
                }
            });
            if skip_s > 0.0 {
                skip_s -= 1.0;
            } else {
                rec.time_s.push(clock_s);
                for (channel, value) in rec.channels.iter_mut().zip(filed) {
                    channel.push(value);
                }
                rec.truth.push(state);
                match (live, silent_since) {
                    (false, None) => silent_since = Some(i),
                    (true, Some(first)) => {
                        rec.faults.push(exception(first, i));
                        silent_since = None;
                    }
                    _ => {}
                }
            }
        }
        clock_s += 1.0;
    }
    if let Some(first) = silent_since {
        rec.faults.push(exception(first, n));
    }
    for (c, values) in rec.channels.iter_mut().enumerate() {
        let mut noise = Noise::new(plan.seed, 200 + c as u64);
        rec.faults
            .extend(spoil(values, c, &plan.faults[c], &mut noise));
    }
    Ok(rec)
}

/// Until the crew wants the mud pump again, s: 0 while it does, without end if it never does.
fn restart_s<'a>(mut segments: impl Iterator<Item = &'a Segment>, left_s: f64) -> f64 {
    let stands = |s: &Segment| s.mud_pump_gpm <= 0.0;
    if segments.next().is_none_or(|now| !stands(now)) {
        return 0.0;
    }
    let mut waits_s = left_s;
    for next in segments {
        if !stands(next) {
            return waits_s;
        }
        waits_s += next.duration_s;
    }
    f64::INFINITY
}

fn exception(first: usize, end: usize) -> Fault {
    Fault {
        channel: None,
        kind: FaultKind::Exception,
        first,
        count: end - first,
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
