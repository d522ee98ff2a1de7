//! The ground that candidates stand on: what a hypothesis comes to by itself, so that one effect more is run only where it acts.

use crate::layout::BALANCE_BLOCKS;
use crate::record::Record;
use crate::relations::{Applied, Blocks, LevelRate, LineFlow, Metered, Parts, Touched, begun, run};
use dgd_effects::{Changes, Extent, MeterPath};
use std::ops::Range;

/// Values among [`Changes`] that a relation holds.
const FIELDS: usize = 18;

/// A hypothesis run over a recording.
#[derive(Debug)]
pub(crate) struct Incremental {
    line: LineFlow,
    rates: LevelRate,
    parts: Parts,
    blocks: Blocks,
    /// What its effects change, sample by sample: the fields that they touch.
    changes: Vec<(usize, Vec<f64>)>,
}

impl Incremental {
    /// Runs a hypothesis.
    pub(crate) fn under(record: &Record, applied: &[Applied]) -> Self {
        let line = LineFlow::under(record, applied);
        let rates = LevelRate::of(record);
        let mut act = begun(record, applied);
        let samples = record.t_s.len();
        let plain = fields(&Changes::default());
        let mut touched: [Vec<f64>; FIELDS] = Default::default();
        let mut parts = Parts::blank(record);
        run(
            record,
            (&line, &rates),
            0..samples,
            Metered::default(),
            &mut parts,
            |moment, c| {
                act(moment, c);
                for ((column, plain), value) in touched.iter_mut().zip(plain).zip(fields(c)) {
                    if column.is_empty() {
                        if value.to_bits() == plain.to_bits() {
                            continue;
                        }
                        column.resize(samples, plain);
                    }
                    column[moment.index] = value;
                }
                Touched::ALL
            },
        );
        let blocks = Blocks::of(record, parts.clone(), None);
        let changes = touched.into_iter().enumerate();
        Self {
            line,
            rates,
            parts,
            blocks,
            changes: changes.filter(|(_, c)| !c.is_empty()).collect(),
        }
    }

    /// The means of blocks under it.
    pub(crate) fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// Another hypothesis, digit for digit what running it gives: what is not otherwise than under this one is not laid again.
    pub(crate) fn other(&self, record: &Record, applied: &[Applied]) -> Blocks {
        let line = LineFlow::under(record, applied);
        let metered = if line.is(&self.line) {
            Touched::default()
        } else {
            Touched::METERED
        };
        let mut act = begun(record, applied);
        let mut here = Changes::default();
        let mut parts = self.parts.clone();
        run(
            record,
            (&line, &self.rates),
            0..record.t_s.len(),
            Metered::default(),
            &mut parts,
            |moment, c| {
                act(moment, c);
                self.lay(moment.index, &mut here);
                Touched::between(&here, c).or(metered)
            },
        );
        Blocks::of(record, parts, Some((&self.parts, &self.blocks)))
    }

    /// The hypothesis with one effect more, digit for digit what running all of them gives; `None` for an effect
    /// between line and meter, which changes the flow that the others see.
    pub(crate) fn with(&self, record: &Record, one: &Applied) -> Option<Blocks> {
        if one.effect.meter_path(&one.parameters) != MeterPath::default() {
            return None;
        }
        let rows = rows(record, one);
        let per_row = record.per_block * BALANCE_BLOCKS;
        let samples = rows.start * per_row..(rows.end * per_row).min(record.t_s.len());
        let mut action = one.effect.begin(&one.parameters, &record.setting);
        let mut without = Changes::default();
        let mut parts = self.parts.clone();
        let meter = samples.start.checked_sub(1).map(|before| {
            let mut known = Changes::default();
            self.lay(before, &mut known);
            Metered::under(&known)
        });
        let mut all = Touched::default();
        run(
            record,
            (&self.line, &self.rates),
            samples,
            meter.unwrap_or_default(),
            &mut parts,
            |moment, c| {
                self.lay(moment.index, &mut without);
                copy(&without, c);
                action(moment, c);
                let touched = Touched::between(&without, c);
                all = all.or(touched);
                touched
            },
        );
        if all.meter() && !self.changes.is_empty() {
            return None;
        }
        Some(Blocks::of(record, parts, Some((&self.parts, &self.blocks))))
    }

    /// Writes what the hypothesis changes at a sample.
    fn lay(&self, sample: usize, changes: &mut Changes) {
        let slots = slots(changes);
        for (field, column) in &self.changes {
            *slots[*field] = column[sample];
        }
    }
}

/// Rows of the mass balance in which an effect acts, the last of which may be no whole one.
///
/// [`Extent`] promises that nothing happens, and nothing is kept in mind, before an onset.
fn rows(record: &Record, one: &Applied) -> Range<usize> {
    let per_row = record.per_block * BALANCE_BLOCKS;
    let all = record.t_s.len().div_ceil(per_row);
    let about = one.effect.about();
    if about.extent() == Extent::Always {
        return 0..all;
    }
    let (from, to) = one.effect.acts_s(&one.parameters, record.setting.span_s);
    let first = record.t_s.partition_point(|t| *t < from);
    let end = record.t_s.partition_point(|t| *t <= to);
    // The last samples may lie behind the span, as means of fewer than the others.
    let end = if to >= record.setting.span_s.1 {
        record.t_s.len()
    } else {
        end
    };
    first.min(end) / per_row..end.div_ceil(per_row)
}

/// Every value that a relation holds, in one order; taken apart so that a new member is not passed over.
fn slots(changes: &mut Changes) -> [&mut f64; FIELDS] {
    let Changes {
        inflow_m3_s,
        area_factor,
        entering_kg_m3,
        riser_kg_m3,
        line_kg_m3,
        line_drop_pa,
        friction_factor,
        line_fall_m,
        head_factor,
        head_pa,
        speed_pct,
        recirculation_m3_s,
        leak_m3_s,
        meter_gain,
        outlet_bias_pa: [outlet, other_outlet],
        inlet_bias_pa: [inlet, other_inlet],
        riser_bias_pa: _,
    } = changes;
    [
        inflow_m3_s,
        area_factor,
        entering_kg_m3,
        riser_kg_m3,
        line_kg_m3,
        line_drop_pa,
        friction_factor,
        line_fall_m,
        head_factor,
        head_pa,
        speed_pct,
        recirculation_m3_s,
        leak_m3_s,
        meter_gain,
        outlet,
        other_outlet,
        inlet,
        other_inlet,
    ]
}

fn fields(changes: &Changes) -> [f64; FIELDS] {
    slots(&mut { *changes }).map(|value| *value)
}

/// Copies member by member: as a whole they are too large to be copied without a call, and it is done for every sample.
fn copy(from: &Changes, to: &mut Changes) {
    let Changes {
        inflow_m3_s,
        area_factor,
        entering_kg_m3,
        riser_kg_m3,
        line_kg_m3,
        line_drop_pa,
        friction_factor,
        line_fall_m,
        head_factor,
        head_pa,
        speed_pct,
        recirculation_m3_s,
        leak_m3_s,
        meter_gain,
        outlet_bias_pa,
        inlet_bias_pa,
        riser_bias_pa,
    } = from;
    to.inflow_m3_s = *inflow_m3_s;
    to.area_factor = *area_factor;
    to.entering_kg_m3 = *entering_kg_m3;
    to.riser_kg_m3 = *riser_kg_m3;
    to.line_kg_m3 = *line_kg_m3;
    to.line_drop_pa = *line_drop_pa;
    to.friction_factor = *friction_factor;
    to.line_fall_m = *line_fall_m;
    to.head_factor = *head_factor;
    to.head_pa = *head_pa;
    to.speed_pct = *speed_pct;
    to.recirculation_m3_s = *recirculation_m3_s;
    to.leak_m3_s = *leak_m3_s;
    to.meter_gain = *meter_gain;
    to.outlet_bias_pa = *outlet_bias_pa;
    to.inlet_bias_pa = *inlet_bias_pa;
    to.riser_bias_pa = *riser_bias_pa;
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{FIELDS, Incremental, fields, rows, slots};
    use crate::record::{Filled, Record};
    use crate::relations::{Applied, Blocks};
    use crate::test_rig::{normals, setting};
    use crate::told::Told;
    use dgd_effects::{Changes, Connection, MeterPath, Noise, Role, Setting, catalogue, find};
    use std::sync::Arc;

    const DT_S: f64 = 2.0;
    /// No whole number of rows, nor of blocks.
    const SAMPLES: usize = 2011;

    /// An hour with a connection, noise, and a gap in the flow.
    fn record() -> Record {
        let t_s: Vec<f64> = (0..SAMPLES).map(|i| 0.5 + DT_S * i as f64).collect();
        let noisy = |seed: u64, size: f64, of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let noise = normals(seed, SAMPLES);
            t_s.iter()
                .zip(noise)
                .map(|(t, n)| of(*t) + size * n)
                .collect()
        };
        let stands = |t: f64| (1500.0..1700.0).contains(&t);
        let rest = |t: f64, v: f64| if stands(t) { 0.0 } else { v };
        let mud_pump = noisy(1, 1e-5, &|t| rest(t, 0.03));
        let booster = noisy(2, 1e-5, &|t| if t < 2500.0 { 0.01 } else { 0.014 });
        let filled_flow = noisy(3, 2e-4, &|t| rest(t, 0.042 + 0.004 * (t / 300.0).sin()));
        let speed = noisy(4, 0.05, &|t| rest(t, 70.0 + 4.0 * (t / 300.0).sin()));
        let inlet = noisy(5, 500.0, &|t| 164e5 + 1e5 * (t / 700.0).sin());
        let outlet = noisy(6, 500.0, &|t| 184e5 + 1e5 * (t / 300.0).sin());
        let mut flow = filled_flow.clone();
        flow[900..930].fill(f64::NAN);
        let per_block = 5;
        Record {
            laminar: None,
            setting: Setting {
                outlets: 2,
                connections: vec![Connection {
                    from_s: 1500.0,
                    to_s: 1700.0,
                }],
                noise: Noise {
                    flow_m3_s: 2e-4,
                    ..Noise::default()
                },
                ..setting((0.0, t_s[SAMPLES - 1] + 0.5))
            },
            dt_s: DT_S,
            speed_error_pct: 0.05,
            coarse_m3_s: 0.0,
            outlets: vec![outlet.clone(), outlet.iter().map(|p| p + 2e3).collect()],
            filled: Filled {
                mud_pump: mud_pump.clone(),
                booster: booster.clone(),
                topfill: vec![0.001; SAMPLES],
                flow: filled_flow,
                pumping: t_s.iter().map(|t| !stands(*t)).collect(),
                speed: speed.clone(),
                inlet: inlet.clone(),
                outlet: outlet.clone(),
            },
            without: Vec::new(),
            seldom: Vec::new(),
            tally: Arc::default(),
            suction_heads: None,
            told: Told::default(),
            stops: Vec::new(),
            told_every_s: 2.0,
            per_block,
            blocks: SAMPLES / per_block,
            t_s,
            mud_pump,
            booster,
            topfill: vec![0.001; SAMPLES],
            flow,
            speed,
            inlet,
            riser: None,
            inlets: Vec::new(),
            outlet,
        }
    }

    fn bits(b: &Blocks) -> Vec<Vec<u64>> {
        [
            &b.flow,
            &b.averaged,
            &b.through,
            &b.speed,
            &b.drop,
            &b.friction_factor,
            &b.lift,
            &b.head_factor,
            &b.difference,
            &b.imbalance,
        ]
        .map(|v| v.iter().map(|v| v.to_bits()).collect())
        .to_vec()
    }

    #[test]
    fn one_effect_more_gives_the_digits_of_running_all_wherever_it_begins() {
        let record = record();
        let late = |id: &str, tau: f64| {
            let effect = find(id).unwrap();
            Applied::new(effect, effect.about().of_strength(tau))
        };
        let states = [
            vec![],
            vec![late("pump_speed_lag", 3.0), late("u_tube", 2.0)],
            vec![
                late("return_flow_delay", 1.5),
                late("booster_line_storage", 3.0),
            ],
            // One that follows the flow, beside what changes between it and the meter.
            vec![late("line_leak", 1e-3), late("line_restriction", 0.5)],
            // Changes from the first sample to the last.
            vec![late("return_flow_gain", -0.03), late("inflow_gain", 0.02)],
        ];
        for state in states {
            let incremental = Incremental::under(&record, &state);
            assert_eq!(
                bits(&incremental.blocks),
                bits(&Blocks::under(&record, &state))
            );
            assert_eq!(
                bits(&incremental.other(&record, &[])),
                bits(&Blocks::under(&record, &[]))
            );
            for effect in catalogue().iter().copied() {
                let about = effect.about();
                for onset in [-1e6, 0.0, 1234.5, 3300.0, 4021.5, 9e6] {
                    let parameters = (about.parameters.iter())
                        .map(|p| match p.role {
                            Role::Onset => onset,
                            Role::Duration(_) => 700.0,
                            Role::Grid(v)
                            | Role::Shape(v)
                            | Role::Choice(v)
                            | Role::Sensor(v)
                            | Role::Edge(v) => v.first().copied().unwrap_or(1.0),
                            Role::Amplitude => p.usual,
                        })
                        .collect();
                    let one = Applied::new(effect, parameters);
                    let all: Vec<Applied> = state.iter().cloned().chain([one.clone()]).collect();
                    let expected = Blocks::under(&record, &all);
                    let other = incremental.other(&record, &all);
                    assert!(bits(&other) == bits(&expected), "{} at {onset}", about.id);
                    let found = incremental.with(&record, &one);
                    let direct = effect.meter_path(&one.parameters) == MeterPath::default();
                    // What it does to the flow, the others see.
                    let between = matches!(about.id, "return_flow_gain" | "line_leak");
                    let not_yet = onset > 0.0 && about.onset().is_some();
                    if !(between && not_yet) {
                        let runs = direct && (state.is_empty() || !between);
                        assert_eq!(found.is_some(), runs, "{} at {onset}", about.id);
                    }
                    if let Some(found) = found {
                        assert!(bits(&found) == bits(&expected), "{} at {onset}", about.id);
                    }
                }
            }
        }
    }

    #[test]
    fn a_field_is_the_one_at_its_place() {
        for field in 0..FIELDS {
            let mut c = Changes::default();
            *slots(&mut c)[field] = 7.0;
            let mut expected = fields(&Changes::default());
            expected[field] = 7.0;
            assert_eq!(fields(&c), expected);
        }
    }

    #[test]
    fn an_effect_is_run_over_the_rows_in_which_it_acts() {
        let record = record();
        let of = |id: &str, parameters: &[f64]| {
            rows(
                &record,
                &Applied::new(find(id).unwrap(), parameters.to_vec()),
            )
        };
        // Rows of fifteen samples; the onset falls on the last sample of a row, the end on the sixth of one.
        assert_eq!(of("influx", &[1e-3, 1258.5, 700.0, 0.1]), 41..66);
        assert_eq!(of("influx", &[1e-3, 1258.6, 700.0, 0.1]), 42..66);
        // What began before the recording lasts from then.
        assert_eq!(of("influx", &[1e-3, -1e6, 700.0, 0.1]), 0..0);
        assert_eq!(of("influx", &[1e-3, -300.0, 700.0, 0.1]), 0..14);
        assert_eq!(of("influx", &[1e-3, 3800.0, 700.0, 0.1]), 126..135);
        assert_eq!(of("line_leak", &[1e-3, 3300.0]), 110..135);
        assert_eq!(of("line_leak", &[1e-3, 9e6]), 134..135);
        assert_eq!(of("return_flow_gain", &[0.02]), 0..135);
    }
}
