//! The four relations in block form, under a hypothesis.
//!
//! Rows: line friction (Eq. 3.13 with the inertia of Eq. 3.46), pump head (Eq. 2.27), the redundant outlet
//! transmitters, and the riser's mass balance (Eq. 3.45) in integral form over half a minute.

use crate::record::{MASS_BLOCKS, Record, mean, whole};
use dgd_effects::{Action, Changes, Effect, MeterPath, Moment, STANDING_M3_S, shrunk};
use dgd_units::STANDARD_GRAVITY_M_S2;
use std::ops::Range;

/// An effect with its parameters.
#[derive(Clone)]
pub(crate) struct Applied {
    pub effect: &'static dyn Effect,
    pub parameters: Vec<f64>,
    /// Whether it only allows for timing: no finding.
    pub allowance: bool,
}

impl Applied {
    /// An effect that counts as a finding.
    pub(crate) fn new(effect: &'static dyn Effect, parameters: Vec<f64>) -> Self {
        Self {
            effect,
            parameters,
            allowance: false,
        }
    }
}

/// Block means under a hypothesis, before any curve.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    /// Flow through the line, m³/s.
    pub flow: Vec<f64>,
    /// Blocks averaged in each value of the flow.
    pub averaged: Vec<f64>,
    /// Flow through the pump's impeller, m³/s.
    pub through: Vec<f64>,
    /// True speed, %.
    pub speed: Vec<f64>,
    /// Outlet pressure less column, inertia and further drops, Pa.
    pub drop: Vec<f64>,
    /// Factor on the friction curve.
    pub friction_factor: Vec<f64>,
    /// Outlet less inlet pressure, Pa.
    pub lift: Vec<f64>,
    /// Factor on the head curve.
    pub head_factor: Vec<f64>,
    /// First less second outlet transmitter, Pa.
    pub difference: Vec<f64>,
    /// Imbalance of the riser, m³/s, one a [`MASS_BLOCKS`] blocks.
    pub imbalance: Vec<f64>,
}

/// Which rows may be used, and how they were excited; from the bare recording.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    /// Row of the friction relation, by block.
    pub friction: Vec<bool>,
    /// Whether that row is static: no flow.
    pub still: Vec<bool>,
    pub head: Vec<bool>,
    pub difference: Vec<bool>,
    pub mass: Vec<bool>,
}

/// Value at a fractional index, NaN beyond the ends or beside a gap.
fn at(values: &[f64], position: f64) -> f64 {
    let low = whole(position.floor());
    let share = position - low as f64;
    match (values.get(low), values.get(low + 1)) {
        (Some(a), _) if share < 1e-9 => *a,
        (Some(a), Some(b)) => a + share * (b - a),
        _ => f64::NAN,
    }
}

/// The line's flow from its meter: the meter path inverted, a lag through the slope over some seconds.
///
/// What is added is judged on a smoothed meter and cleared of noise: the relation's residual holds the meter's noise too.
fn line_flow(meter: &[f64], path: MeterPath, dt_s: f64, noise: f64) -> Vec<f64> {
    let n = meter.len();
    let shift = path.delay_s / dt_s;
    let half = whole(4.0 / dt_s).max(1);
    let smooth: Vec<f64> = (0..n)
        .map(|i| mean(&meter[i.saturating_sub(half)..(i + half + 1).min(n)]))
        .collect();
    let reach = whole(path.lag_s.min(8.0) / dt_s).max(1);
    let slope = |i: usize| -> f64 {
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(n - 1));
        (smooth[b] - smooth[a]) / ((b - a).max(1) as f64 * dt_s)
    };
    let noise = noise * (2.0 / (2 * half + 1) as f64).sqrt();
    (0..n)
        .map(|i| {
            let mut ahead = at(&smooth, i as f64 + shift) - smooth[i];
            if path.lag_s > 0.0 && meter[i] > STANDING_M3_S {
                // Standing mud has no store to fill: the meter's 0 is a valve's.
                let here = whole(i as f64 + shift).min(n - 1);
                ahead += path.lag_s * slope(here);
            }
            let floor = noise * (1.0 + path.lag_s / (2.0 * reach as f64 * dt_s));
            meter[i] + shrunk(ahead, floor)
        })
        .collect()
}

/// Flow of the line, as the meter's path under a hypothesis has it.
#[derive(Debug, Clone)]
pub(crate) struct LineFlow {
    /// With gaps, and without; `None` where nothing stands between line and meter.
    inverted: Option<(Vec<f64>, Vec<f64>)>,
}

impl LineFlow {
    /// The flow under a hypothesis.
    pub(crate) fn under(record: &Record, applied: &[Applied]) -> Self {
        let mut path = MeterPath::default();
        for one in applied {
            let p = one.effect.meter_path(&one.parameters);
            path.delay_s += p.delay_s;
            path.lag_s += p.lag_s;
        }
        let inverted = (path != MeterPath::default()).then(|| {
            let noise = record.setting.noise.flow_m3_s;
            let flow = line_flow(&record.flow, path, record.dt_s, noise);
            let filled = crate::record::bridged(&flow);
            (flow, filled)
        });
        Self { inverted }
    }
}

/// Runs effects over samples of a recording; `changes` tells what they change at each, which is called in order.
pub(crate) fn run(
    record: &Record,
    line: &LineFlow,
    samples: Range<usize>,
    mut changes: impl FnMut(&Moment) -> Changes,
) -> Parts {
    let setting = &record.setting;
    let (flow, filled_flow) = match &line.inverted {
        Some((flow, filled)) => (flow, filled),
        None => (&record.flow, &record.filled.flow),
    };
    let rho = setting.density_kg_m3;
    let g = STANDARD_GRAVITY_M_S2;
    let column = record.column_pa();
    let single = record.outlets.len() < 2;
    // Row by row of the mass balance: samples need not be held once their means are taken.
    let per_row = record.per_block * MASS_BLOCKS;
    let mut parts = Parts::room_for(samples.len() / record.per_block);
    let mut native = Native::with(per_row);
    let mut first = samples.start;
    for i in samples {
        let moment = Moment {
            index: i,
            t_s: record.t_s[i],
            dt_s: record.dt_s,
            mud_pump_m3_s: record.filled.mud_pump[i],
            booster_m3_s: record.filled.booster[i],
            topfill_m3_s: record.filled.topfill[i],
            flow_m3_s: filled_flow[i],
            speed_pct: record.filled.speed[i],
            inlet_pa: record.filled.inlet[i],
            outlet_pa: record.filled.outlet[i],
            pumping: record.filled.pumping[i],
        };
        let c = changes(&moment);
        let bias = if single {
            c.outlet_bias_pa[0]
        } else {
            0.5 * (c.outlet_bias_pa[0] + c.outlet_bias_pa[1])
        };
        let q = flow[i] / c.meter_gain;
        let through = q + c.leak_m3_s;
        native.flow.push(through);
        native.through.push(through + c.recirculation_m3_s);
        native.speed.push(record.speed[i] + c.speed_pct);
        let outlet = record.outlet[i] - bias;
        native.drop.push(
            outlet - column - c.line_kg_m3 * g * setting.line_length_m + rho * g * c.line_fall_m
                - c.line_drop_pa,
        );
        native
            .friction_factor
            .push(c.friction_factor * (1.0 + c.line_kg_m3 / rho));
        native
            .lift
            .push(outlet - record.inlet[i] + c.inlet_bias_pa - c.head_pa);
        native.inlet_bias.push(c.inlet_bias_pa);
        native
            .head_factor
            .push(c.head_factor * (1.0 + c.riser_kg_m3 / rho));
        let inflow =
            record.filled.mud_pump[i] + record.filled.booster[i] + record.filled.topfill[i];
        native.net.push(
            inflow * (1.0 + c.entering_kg_m3 / rho) + c.inflow_m3_s
                - through * (1.0 + c.riser_kg_m3 / rho),
        );
        native
            .area
            .push(c.area_factor * setting.riser_area_m2 / (rho * g));
        native.bias.push(c.outlet_bias_pa[0] - c.outlet_bias_pa[1]);
        if i + 1 - first == per_row {
            native.move_into(&mut parts, record, first);
            first = i + 1;
        }
    }
    native.move_into(&mut parts, record, first);
    parts
}

impl Blocks {
    /// Runs a hypothesis over the recording.
    pub(crate) fn under(record: &Record, applied: &[Applied]) -> Self {
        let line = LineFlow::under(record, applied);
        let mut actions: Vec<Action> = (applied.iter())
            .map(|one| one.effect.begin(&one.parameters, &record.setting))
            .collect();
        let parts = run(record, &line, 0..record.t_s.len(), |moment| {
            let mut c = Changes::default();
            for action in &mut actions {
                action(moment, &mut c);
            }
            c
        });
        Self::of(record, parts, None)
    }

    /// Calms what is averaged, and takes the line's inertia out of its drop. What `known` parts have alike, digit for
    /// digit, is not calmed again.
    pub(crate) fn of(record: &Record, parts: Parts, known: Option<(&Parts, &Self)>) -> Self {
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
        let (flow, averaged) = match known {
            Some((before, blocks)) if same(&before.flow, &parts.flow) => {
                (blocks.flow.clone(), blocks.averaged.clone())
            }
            _ => calmed(&parts.flow),
        };
        let through = match known {
            Some((before, blocks)) if same(&before.through, &parts.through) => {
                blocks.through.clone()
            }
            _ => calmed(&parts.through).0,
        };
        let speed = match known {
            Some((before, blocks)) if same(&before.speed, &parts.speed) => blocks.speed.clone(),
            _ => calmed(&parts.speed).0,
        };
        let inertia = record.inertia();
        let seconds = record.dt_s * record.per_block as f64;
        let mut drop = parts.drop;
        for b in 0..drop.len() {
            // Rate across the block from its neighbours; one-sided where one is missing.
            let before = b.checked_sub(1).map_or(f64::NAN, |k| flow[k]);
            let after = flow.get(b + 1).copied().unwrap_or(f64::NAN);
            let rate = match (before.is_finite(), after.is_finite()) {
                (true, true) => (after - before) / (2.0 * seconds),
                (true, false) => (flow[b] - before) / seconds,
                (false, true) => (after - flow[b]) / seconds,
                _ => 0.0,
            };
            if rate.is_finite() {
                drop[b] -= inertia * rate;
            }
        }
        Self {
            flow,
            averaged,
            through,
            speed,
            drop,
            friction_factor: parts.friction_factor,
            lift: parts.lift,
            head_factor: parts.head_factor,
            difference: parts.difference,
            imbalance: parts.imbalance,
        }
    }
}

/// Block means before flows and speed are calmed and the line's inertia is taken out of its drop.
#[derive(Debug, Clone)]
pub(crate) struct Parts {
    flow: Vec<f64>,
    through: Vec<f64>,
    speed: Vec<f64>,
    drop: Vec<f64>,
    friction_factor: Vec<f64>,
    lift: Vec<f64>,
    head_factor: Vec<f64>,
    difference: Vec<f64>,
    /// One a [`MASS_BLOCKS`] blocks.
    imbalance: Vec<f64>,
}

impl Parts {
    /// None yet, of so many blocks.
    fn room_for(blocks: usize) -> Self {
        let empty = || Vec::with_capacity(blocks);
        Self {
            flow: empty(),
            through: empty(),
            speed: empty(),
            drop: empty(),
            friction_factor: empty(),
            lift: empty(),
            head_factor: empty(),
            difference: empty(),
            imbalance: Vec::with_capacity(blocks / MASS_BLOCKS),
        }
    }

    /// The parts with those of some rows of the mass balance, from row `from` on, in their place.
    pub(crate) fn with(mut self, other: &Self, from: usize) -> Self {
        let lay = |into: &mut Vec<f64>, part: &[f64], from: usize| {
            if let Some(place) = into.get_mut(from..from + part.len()) {
                place.copy_from_slice(part);
            }
        };
        let block = from * MASS_BLOCKS;
        for (into, part) in [
            (&mut self.flow, &other.flow),
            (&mut self.through, &other.through),
            (&mut self.speed, &other.speed),
            (&mut self.drop, &other.drop),
            (&mut self.friction_factor, &other.friction_factor),
            (&mut self.lift, &other.lift),
            (&mut self.head_factor, &other.head_factor),
            (&mut self.difference, &other.difference),
        ] {
            lay(into, part, block);
        }
        lay(&mut self.imbalance, &other.imbalance, from);
        self
    }
}

/// Mean of a block without its greatest and least value, so that a spike costs nothing.
fn trimmed(values: &[f64]) -> f64 {
    let (mut sum, mut count, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for v in values.iter().filter(|v| v.is_finite()) {
        sum += v;
        count += 1.0;
        low = low.min(*v);
        high = high.max(*v);
    }
    if count >= 4.0 {
        (sum - low - high) / (count - 2.0)
    } else {
        sum / count
    }
}

/// A series averaged over its calm surroundings, up to a minute on either side, and left alone where it moves.
///
/// A curve fitted to noisy flow leans towards the mean (errors in variables); in steady operation, where flow varies by
/// noise alone, it would lose its slope altogether.
///
/// Returns the averages and the number of blocks in each.
fn calmed(values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    const REACH: usize = 6;
    let noise = crate::noise::spread(values.windows(2).map(|w| w[1] - w[0]));
    if !noise.is_finite() {
        return (values.to_vec(), vec![1.0; values.len()]);
    }
    // The median step is calm: its spread is that of a difference of two.
    let gate = 2.2 * noise.max(1e-9);
    (0..values.len())
        .map(|b| {
            let (mut sum, mut count) = (values[b], 1.0);
            for k in 1..=REACH {
                let (Some(a), Some(z)) = (b.checked_sub(k).map(|i| values[i]), values.get(b + k))
                else {
                    break;
                };
                if !((a - values[b]).abs() < gate && (z - values[b]).abs() < gate) {
                    break;
                }
                sum += a + z;
                count += 2.0;
            }
            (sum / count, count)
        })
        .unzip()
}

/// The same by sample, of a row of the mass balance.
struct Native {
    flow: Vec<f64>,
    through: Vec<f64>,
    speed: Vec<f64>,
    drop: Vec<f64>,
    friction_factor: Vec<f64>,
    lift: Vec<f64>,
    head_factor: Vec<f64>,
    net: Vec<f64>,
    area: Vec<f64>,
    bias: Vec<f64>,
    inlet_bias: Vec<f64>,
}

impl Native {
    fn with(n: usize) -> Self {
        let empty = || Vec::with_capacity(n);
        Self {
            flow: empty(),
            through: empty(),
            speed: empty(),
            drop: empty(),
            friction_factor: empty(),
            lift: empty(),
            head_factor: empty(),
            net: empty(),
            area: empty(),
            bias: empty(),
            inlet_bias: empty(),
        }
    }

    /// Appends the means of whole blocks, and is empty again; the first sample is number `first`, where a row of the
    /// mass balance begins.
    fn move_into(&mut self, parts: &mut Parts, record: &Record, first: usize) {
        let m = record.per_block;
        let blocks = (record.blocks - first / m).min(self.flow.len() / m);
        let by = |values: &mut Vec<f64>, out: &mut Vec<f64>| {
            out.extend(values.chunks_exact(m).take(blocks).map(trimmed));
            values.clear();
        };
        if let [one, two] = record.outlets.as_slice() {
            let here = |b: usize| b * m..(b + 1) * m;
            let there = |b: usize| first + b * m..first + (b + 1) * m;
            parts.difference.extend(
                (0..blocks).map(|b| {
                    mean(&one[there(b)]) - mean(&two[there(b)]) - mean(&self.bias[here(b)])
                }),
            );
        }
        let per_mass = m * MASS_BLOCKS;
        let mass_seconds = record.dt_s * per_mass as f64;
        let edge = |i: usize| -> f64 {
            // The level is smooth: a few samples about the edge tell it.
            let half = whole(2.0 / record.dt_s).max(1);
            mean(&record.inlet[i.saturating_sub(half)..(i + half).min(record.inlet.len())])
        };
        let plain_area =
            record.setting.riser_area_m2 / (record.setting.density_kg_m3 * STANDARD_GRAVITY_M_S2);
        parts.imbalance.extend((0..blocks / MASS_BLOCKS).map(|k| {
            let r = k * per_mass..(k + 1) * per_mass;
            let net = &self.net[r.clone()];
            let bad = net.iter().filter(|v| !v.is_finite()).count();
            if bad * 10 > net.len() {
                return f64::NAN;
            }
            let read = (edge(first + r.end) - edge(first + r.start)) / mass_seconds;
            let drift = (self.inlet_bias[r.end - 1] - self.inlet_bias[r.start])
                / (mass_seconds - record.dt_s);
            let rate = read - drift;
            let noise = record.setting.noise.inlet_pa / mass_seconds;
            let area = mean(&self.area[r.clone()]);
            mean(net) - plain_area * rate - (area - plain_area) * shrunk(rate, noise)
        }));
        by(&mut self.flow, &mut parts.flow);
        by(&mut self.through, &mut parts.through);
        by(&mut self.speed, &mut parts.speed);
        by(&mut self.drop, &mut parts.drop);
        by(&mut self.friction_factor, &mut parts.friction_factor);
        by(&mut self.lift, &mut parts.lift);
        by(&mut self.head_factor, &mut parts.head_factor);
        for values in [
            &mut self.net,
            &mut self.area,
            &mut self.bias,
            &mut self.inlet_bias,
        ] {
            values.clear();
        }
    }
}

impl Rows {
    /// Which rows the recording supports.
    pub(crate) fn of(record: &Record, base: &Blocks) -> Self {
        let m = record.per_block;
        let full =
            |values: &[f64], b: usize| values[b * m..(b + 1) * m].iter().all(|v| v.is_finite());
        let pumping = &record.filled.pumping;
        let n = record.blocks;
        // In the first half minute after a start, and across a stop, the check valve decides.
        let mut settled = vec![0.0_f64; n];
        let mut rested = vec![0.0_f64; n];
        let (mut on, mut off) = (0.0, 0.0);
        for b in 0..n {
            let r = b * m..(b + 1) * m;
            let turning = pumping[r.clone()].iter().all(|p| *p)
                && record.filled.flow[r.clone()]
                    .iter()
                    .all(|q| *q > 2.0 * STANDING_M3_S);
            let standing = pumping[r.clone()].iter().all(|p| !*p)
                && record.filled.flow[r].iter().all(|q| *q < STANDING_M3_S);
            on = if turning { on + 1.0 } else { 0.0 };
            off = if standing { off + 1.0 } else { 0.0 };
            settled[b] = on;
            rested[b] = off;
        }
        // Near shut-off the curve folds and the check valve flutters: no evidence there.
        let least_flow = 0.08 * base.flow.iter().copied().fold(0.0, f64::max);
        let head: Vec<bool> = (0..n)
            .map(|b| {
                settled[b] > 1.0
                    && base.flow[b] > least_flow
                    && settled.get(b + 1).is_none_or(|s| *s > 0.0)
                    && full(&record.flow, b)
                    && full(&record.speed, b)
                    && base.lift[b].is_finite()
                    && base.drop[b].is_finite()
            })
            .collect();
        let still: Vec<bool> = (0..n)
            .map(|b| {
                rested[b] > 2.0
                    && rested.get(b + 1).is_none_or(|s| *s > 0.0)
                    && base.drop[b].is_finite()
            })
            .collect();
        let friction: Vec<bool> = (0..n)
            .map(|b| {
                still[b]
                    || (settled[b] > 1.0
                        && settled.get(b + 1).is_none_or(|s| *s > 0.0)
                        && full(&record.flow, b)
                        && base.drop[b].is_finite())
            })
            .collect();
        // A transmitter that repeats one value through its noise is stuck, whatever the screening made of it.
        let mut frozen = vec![false; n];
        for outlet in &record.outlets {
            let mut run = 0_usize;
            for i in 1..outlet.len() {
                run = if outlet[i] == outlet[i - 1] {
                    run + 1
                } else {
                    0
                };
                let flowing = settled.get(i / m).is_some_and(|s| *s > 0.0);
                if run as f64 * record.dt_s >= if flowing { 24.0 } else { 60.0 } {
                    for b in (i - run) / m..=(i / m + 2).min(n - 1) {
                        frozen[b] = true;
                    }
                }
            }
        }
        let friction: Vec<bool> = friction
            .iter()
            .zip(&frozen)
            .map(|(v, f)| *v && !f)
            .collect();
        let head: Vec<bool> = head.iter().zip(&frozen).map(|(v, f)| *v && !f).collect();
        let difference = base
            .difference
            .iter()
            .zip(&frozen)
            .map(|(d, f)| d.is_finite() && !f)
            .collect();
        let mass = (0..n / MASS_BLOCKS)
            .map(|k| {
                let inputs = (k * MASS_BLOCKS..(k + 1) * MASS_BLOCKS).all(|b| {
                    full(&record.mud_pump, b)
                        && full(&record.booster, b)
                        && (settled[b] > 1.0 || rested[b] > 0.0)
                });
                inputs && base.imbalance[k].is_finite()
            })
            .collect();
        Self {
            friction,
            still,
            head,
            difference,
            mass,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{calmed, trimmed};
    use crate::draws::normals;

    const NOISE: f64 = 1e-4;

    fn stepping() -> Vec<f64> {
        normals(4, 400)
            .iter()
            .enumerate()
            .map(|(i, v)| if i < 200 { 0.03 } else { 0.04 } + NOISE * v)
            .collect()
    }

    #[test]
    fn calm_stretches_are_averaged_and_steps_are_kept() {
        let (out, count) = calmed(&stepping());
        for (i, v) in out.iter().enumerate() {
            let truth = if i < 200 { 0.03 } else { 0.04 };
            assert!((v - truth).abs() < 4.5 * NOISE, "block {i}: {v}");
        }
        // The last block before the step has a neighbour that is not alike: it stands alone.
        assert_eq!((count[199], count[200]), (1.0, 1.0));
        let left: f64 = (20..180).map(|i| (out[i] - 0.03).powi(2)).sum::<f64>() / 160.0;
        assert!(left.sqrt() < 0.6 * NOISE, "{}", left.sqrt());
    }

    #[test]
    fn a_gap_is_not_averaged_into_its_neighbours() {
        let mut values = stepping();
        values[100] = f64::NAN;
        let (out, count) = calmed(&values);
        assert!(out[100].is_nan());
        assert!(
            out.iter()
                .enumerate()
                .all(|(i, v)| i == 100 || v.is_finite())
        );
        assert_eq!((count[99], count[101]), (1.0, 1.0));
    }

    #[test]
    fn a_spike_in_a_block_costs_nothing() {
        assert_eq!(trimmed(&[1.0, 1.0, 1e9, 1.0, 1.0]), 1.0);
        assert_eq!(trimmed(&[1.0, f64::NAN, 3.0]), 2.0);
        assert!(trimmed(&[f64::NAN]).is_nan());
    }
}
