//! Claims about the relations under a hypothesis: where it is the truth, what is left is the rig's own curves and a balance of 0.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Applied, Blocks, LevelRate, LineFlow, Metered, Parts, Touched, run};
use crate::layout::BALANCE_BLOCKS;
use crate::record::Record;
use crate::test_rig::{DT_S, FLOW_M3_S, PER_BLOCK, SPEED_PCT, cut, steady};
use dgd_effects::{Changes, Moment, find, shrunk};
use dgd_units::STANDARD_GRAVITY_M_S2;

/// Friction of the rig's line at its flow, Pa.
const FRICTION_PA: f64 = 4e5;
/// Head of its pump at the first sample, Pa, and how it changes, Pa/s.
const HEAD_PA: (f64, f64) = (40e5, 20.0);
const ROWS: usize = 6;

fn head_pa(t_s: f64) -> f64 {
    HEAD_PA.0 + HEAD_PA.1 * t_s
}

/// What the instruments of the rig read where the changes `c` act on it, by Eqs. 3.13, 2.27 and 3.45.
fn read(c: &Changes, transmitters: usize) -> Record {
    let mut record = steady(ROWS * BALANCE_BLOCKS);
    let n = record.t_s.len();
    let g = STANDARD_GRAVITY_M_S2;
    let s = &record.setting;
    let rho = s.density_kg_m3;
    let (line, riser) = (1.0 + c.line_kg_m3 / rho, 1.0 + c.riser_kg_m3 / rho);
    let column = record.column_pa() + c.line_kg_m3 * g * s.line_length_m - rho * g * c.line_fall_m;
    let outlet = column + c.line_drop_pa + c.friction_factor * line * FRICTION_PA;
    let inlet = |t: f64| outlet - c.head_pa - c.head_factor * riser * head_pa(t);
    // The level falls as the head rises, and what is pumped in is what the balance then asks for.
    let rate = -c.head_factor * riser * HEAD_PA.1;
    let stored = c.area_factor * s.riser_area_m2 / (rho * g) * rate;
    let inflow = (stored + FLOW_M3_S * riser - c.inflow_m3_s) / (1.0 + c.entering_kg_m3 / rho);
    let (booster, topfill) = (0.01, 0.002);
    record.topfill = vec![topfill; n];
    record.filled.topfill.clone_from(&record.topfill);
    record.mud_pump = vec![inflow - booster - topfill; n];
    record.flow = vec![(FLOW_M3_S - c.leak_m3_s) * c.meter_gain; n];
    record.speed = vec![SPEED_PCT - c.speed_pct; n];
    record.inlet = (record.t_s.iter())
        .map(|t| inlet(*t) + 0.5 * (c.inlet_bias_pa[0] + c.inlet_bias_pa[1]))
        .collect();
    record.outlets = (0..transmitters)
        .map(|k| vec![outlet + c.outlet_bias_pa[k]; n])
        .collect();
    let bias = c.outlet_bias_pa[..transmitters].iter().sum::<f64>() / transmitters as f64;
    record.outlet = vec![outlet + bias; n];
    record.filled.mud_pump.clone_from(&record.mud_pump);
    record.filled.flow.clone_from(&record.flow);
    record
}

fn under(record: &Record, c: &Changes) -> Parts {
    run_whole(record, |_| *c)
}

/// Runs changes over a whole recording.
fn run_whole(record: &Record, changes: impl Fn(&Moment) -> Changes) -> Parts {
    let (line, rates) = (LineFlow::under(record, &[]), LevelRate::of(record));
    let mut parts = Parts::blank(record);
    run(
        record,
        (&line, &rates),
        0..record.t_s.len(),
        Metered::default(),
        &mut parts,
        |at, c| {
            *c = changes(at);
            Touched::ALL
        },
    );
    parts
}

/// Every part, by its name.
fn listed(parts: &Parts) -> [(&'static str, &[f64]); 9] {
    [
        ("flow", &parts.flow),
        ("through", &parts.through),
        ("speed", &parts.speed),
        ("drop", &parts.drop),
        ("friction factor", &parts.friction_factor),
        ("lift", &parts.lift),
        ("head factor", &parts.head_factor),
        ("difference", &parts.difference),
        ("imbalance", &parts.imbalance),
    ]
}

fn close(found: f64, expected: f64, size: f64) {
    assert!((found - expected).abs() < 1e-9 * size, "{found} {expected}");
}

/// Each change by itself, and all of them.
fn changes() -> Vec<Changes> {
    let all = Changes {
        inflow_m3_s: 4e-3,
        area_factor: 1.3,
        entering_kg_m3: 60.0,
        riser_kg_m3: 40.0,
        line_kg_m3: 25.0,
        line_drop_pa: 7e4,
        friction_factor: 1.2,
        line_fall_m: 15.0,
        head_factor: 0.9,
        head_pa: -3e5,
        speed_pct: 1.5,
        recirculation_m3_s: 3e-3,
        leak_m3_s: 5e-3,
        meter_gain: 1.04,
        outlet_bias_pa: [5e4, -2e4],
        inlet_bias_pa: [6e4, 2e4],
        // No relation holds it.
        riser_bias_pa: 3e4,
    };
    let none = Changes::default;
    let with = |set: fn(&mut Changes, &Changes)| {
        let mut one = none();
        set(&mut one, &all);
        one
    };
    vec![
        none(),
        with(|one, all| one.inflow_m3_s = all.inflow_m3_s),
        with(|one, all| one.area_factor = all.area_factor),
        with(|one, all| one.entering_kg_m3 = all.entering_kg_m3),
        with(|one, all| one.riser_kg_m3 = all.riser_kg_m3),
        with(|one, all| one.line_kg_m3 = all.line_kg_m3),
        with(|one, all| one.line_drop_pa = all.line_drop_pa),
        with(|one, all| one.friction_factor = all.friction_factor),
        with(|one, all| one.line_fall_m = all.line_fall_m),
        with(|one, all| one.head_factor = all.head_factor),
        with(|one, all| one.head_pa = all.head_pa),
        with(|one, all| one.speed_pct = all.speed_pct),
        with(|one, all| one.recirculation_m3_s = all.recirculation_m3_s),
        with(|one, all| one.leak_m3_s = all.leak_m3_s),
        with(|one, all| one.meter_gain = all.meter_gain),
        with(|one, all| one.outlet_bias_pa = all.outlet_bias_pa),
        with(|one, all| one.inlet_bias_pa = all.inlet_bias_pa),
        all,
    ]
}

#[test]
fn what_acts_on_the_rig_is_undone_where_it_is_told() {
    for c in changes() {
        for transmitters in [1, 2] {
            let record = read(&c, transmitters);
            let parts = under(&record, &c);
            assert_eq!(parts.flow.len(), record.blocks);
            for b in 0..record.blocks {
                close(parts.flow[b], FLOW_M3_S, FLOW_M3_S);
                close(
                    parts.through[b],
                    FLOW_M3_S + c.recirculation_m3_s,
                    FLOW_M3_S,
                );
                close(parts.speed[b], SPEED_PCT, SPEED_PCT);
                close(parts.drop[b] / parts.friction_factor[b], FRICTION_PA, 184e5);
                // The middle of a block is that of its samples.
                let middle = DT_S * (PER_BLOCK * b + PER_BLOCK / 2) as f64;
                close(parts.lift[b] / parts.head_factor[b], head_pa(middle), 184e5);
            }
            // The ends have no sample beyond them to tell the level from.
            assert_eq!(parts.imbalance.len(), ROWS);
            for imbalance in &parts.imbalance[1..ROWS - 1] {
                close(*imbalance, 0.0, FLOW_M3_S);
            }
            let apart = if transmitters == 2 { record.blocks } else { 0 };
            assert_eq!(parts.difference.len(), apart);
            for difference in parts.difference {
                close(difference, 0.0, 184e5);
            }
        }
    }
}

#[test]
fn what_is_told_and_does_not_act_is_left_over() {
    let sound = read(&Changes::default(), 2);
    let plain = under(&sound, &Changes::default());
    for c in &changes()[1..] {
        let parts = under(&sound, c);
        let moved =
            |a: &[f64], b: &[f64]| (a.iter().zip(b)).any(|(a, b)| (a / b - 1.0).abs() > 1e-3);
        let off = |a: &[f64]| a.iter().any(|v| v.abs() > 1e-5);
        let ratio = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a / b).collect::<Vec<_>>();
        assert!(
            moved(&parts.flow, &plain.flow)
                || moved(&parts.through, &plain.through)
                || moved(&parts.speed, &plain.speed)
                || moved(&ratio(&parts.drop, &parts.friction_factor), &plain.drop)
                || moved(&ratio(&parts.lift, &parts.head_factor), &plain.lift)
                || off(&parts.difference)
                || off(&parts.imbalance[1..ROWS - 1])
        );
    }
}

#[test]
fn a_drift_of_the_inlets_is_no_level() {
    // By 2 Pa/s over the whole recording, and by ever more: each row then has a drift of its own, and so has what a wider riser stores.
    let steadily: fn(f64) -> f64 = |t| 2.0 * t;
    let ever_more: fn(f64) -> f64 = |t| 2.0 * t + 0.1 * t * t;
    for (drift, area_factor) in [(steadily, 1.0), (ever_more, 1.0), (ever_more, 1.3)] {
        let wider = Changes {
            area_factor,
            ..Changes::default()
        };
        let mut record = read(&wider, 1);
        for (p, t) in record.inlet.iter_mut().zip(&record.t_s) {
            *p += drift(*t);
        }
        let parts = run_whole(&record, |at| Changes {
            inlet_bias_pa: [drift(at.t_s); 2],
            ..wider
        });
        for imbalance in &parts.imbalance[1..ROWS - 1] {
            close(*imbalance, 0.0, FLOW_M3_S);
        }
    }
}

#[test]
fn what_the_suction_loses_is_put_back_to_the_level() {
    let mut record = steady(30);
    // The flow grows ever faster, and at first comes down.
    let flow = |i: usize| 0.04 * (i as f64 / 60.0 - 0.3).powi(2);
    record.filled.flow = (0..record.t_s.len()).map(flow).collect();
    let plain = under(&record, &Changes::default()).imbalance;
    let (rho, area) = (record.setting.density_kg_m3, record.setting.line_area_m2);
    let heads = 0.8;
    for (p, q) in record.inlet.iter_mut().zip(&record.filled.flow) {
        *p -= heads * 0.5 * rho * (q / area).powi(2);
    }
    let off = |record: &Record| {
        let found = under(record, &Changes::default()).imbalance;
        let apart = found.iter().zip(&plain);
        assert!(apart.clone().all(|(a, b)| a.is_finite() == b.is_finite()));
        apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let unknown = off(&record);
    assert!(unknown > 1e-4, "{unknown}");
    record.suction_heads = Some(heads);
    // The loss at the mean flow about an edge is not quite the mean loss there.
    assert!(off(&record) < 0.01 * unknown);
}

#[test]
fn of_a_level_that_moves_by_no_more_than_its_noise_another_area_tells_little() {
    let wider = Changes {
        area_factor: 1.3,
        ..Changes::default()
    };
    let mut record = read(&wider, 1);
    // In half a minute it falls by 600 Pa, three times the noise, and a little more or less from row to row.
    let fall = 30.0 * HEAD_PA.1;
    record.setting.noise.inlet_pa = fall / 3.0;
    let per_row = PER_BLOCK * BALANCE_BLOCKS;
    for (i, p) in record.inlet.iter_mut().enumerate() {
        let odd = ((i + per_row / 2) / per_row) % 2 == 1;
        *p += if odd { 8.0 } else { -8.0 };
    }
    let s = &record.setting;
    let plain = s.riser_area_m2 / (s.density_kg_m3 * STANDARD_GRAVITY_M_S2);
    // What of the wider part of the riser is told, over all that it stores of the steady fall.
    let excess = |record: &Record, row: usize| {
        let [without, with] = [Changes::default(), wider].map(|c| under(record, &c).imbalance[row]);
        (with - without) / (0.3 * plain * HEAD_PA.1)
    };
    // Of a steady fall the rows about one tell as well, as many on either side: a rate over five rows has a fifth of the noise.
    let told = |rows: f64| shrunk(3.0 * rows, 1.0) / (3.0 * rows);
    for (row, rows) in [(1, 3.0), (2, 5.0), (3, 5.0), (4, 3.0)] {
        let found = excess(&record, row);
        assert!(
            (found - told(rows)).abs() < 0.03,
            "{row}: {found} for {}",
            told(rows)
        );
    }
    // Of a fall that lasts a row nothing else tells: more of it is taken for noise.
    for (i, p) in record.inlet.iter_mut().enumerate() {
        *p -= 600.0 * ((i as f64 / per_row as f64) - 3.0).clamp(0.0, 1.0);
    }
    let (fell, told) = (excess(&record, 3), shrunk(6.0, 1.0) / 3.0);
    assert!((fell / told - 1.0).abs() < 0.1, "{fell} for {told}");
}

#[test]
fn a_row_of_the_balance_stands_a_tenth_of_gaps() {
    let mut record = read(&Changes::default(), 1);
    let per_row = PER_BLOCK * BALANCE_BLOCKS;
    // One of fifteen samples, and two.
    record.flow[2 * per_row + 7] = f64::NAN;
    record.flow[3 * per_row + 4] = f64::NAN;
    record.flow[3 * per_row + 9] = f64::NAN;
    let parts = under(&record, &Changes::default());
    for (k, imbalance) in parts.imbalance.iter().enumerate() {
        assert_eq!(imbalance.is_nan(), k == 3, "{k}");
    }
    close(parts.imbalance[2], 0.0, FLOW_M3_S);
    // A tenth is enough.
    let mut record = read(&Changes::default(), 1);
    record.per_block = 10;
    record.blocks = record.t_s.len() / 10;
    record.flow[32..35].fill(f64::NAN);
    assert!(under(&record, &Changes::default()).imbalance[1].is_finite());
    record.flow[35] = f64::NAN;
    assert!(under(&record, &Changes::default()).imbalance[1].is_nan());
}

#[test]
fn the_level_at_an_edge_is_that_of_two_seconds_to_either_side() {
    for (dt_s, side) in [(1.0, 2_usize), (2.0, 1), (4.0, 1)] {
        let mut record = read(&Changes::default(), 1);
        record.dt_s = dt_s;
        let plain = under(&record, &Changes::default()).imbalance;
        // Where the third row ends and the fourth begins.
        let edge = 3 * PER_BLOCK * BALANCE_BLOCKS;
        for at in edge - 5..edge + 5 {
            let mut record = record.clone();
            record.inlet[at] += 1e4;
            let found = under(&record, &Changes::default()).imbalance;
            let seen = (edge - side..edge + side).contains(&at);
            for (k, (a, b)) in found.iter().zip(&plain).enumerate() {
                assert_eq!(a != b, seen && (k == 2 || k == 3), "{dt_s} {at} {k}");
            }
        }
    }
}

#[test]
fn rows_that_are_run_by_themselves_take_their_place_among_the_others() {
    let (plain, all) = (Changes::default(), changes().pop().unwrap());
    let mut record = read(&plain, 2);
    for (i, p) in record.inlet.iter_mut().enumerate() {
        *p += 300.0 * (0.7 * i as f64).sin();
    }
    // Four samples that make no block and a block that makes no row.
    let n = record.t_s.len() - 2 * PER_BLOCK;
    let mut record = cut(record, n + 4);
    record.blocks = n / PER_BLOCK;
    let per_row = PER_BLOCK * BALANCE_BLOCKS;
    let (line, rates) = (LineFlow::under(&record, &[]), LevelRate::of(&record));
    let whole = |from: usize, to: usize| {
        run_whole(&record, |at| {
            if (from..to).contains(&at.index) {
                all
            } else {
                plain
            }
        })
    };
    let base = whole(0, 0);
    for (from, to) in [(0, 2), (2, 4), (3, 6)] {
        let end = (to * per_row).min(record.t_s.len());
        let samples = from * per_row..end;
        let mut laid = base.clone();
        let meter = Metered::default();
        run(
            &record,
            (&line, &rates),
            samples,
            meter,
            &mut laid,
            |_, c| {
                *c = all;
                Touched::ALL
            },
        );
        let expected = whole(from * per_row, end);
        assert_eq!(listed(&laid), listed(&expected), "{from}..{to}");
    }
}

#[test]
fn what_a_change_touches_is_all_that_it_changes_and_nothing_else() {
    let mut record = read(&Changes::default(), 2);
    for (i, p) in record.inlet.iter_mut().enumerate() {
        *p += 300.0 * (0.7 * i as f64).sin();
    }
    let (line, rates) = (LineFlow::under(&record, &[]), LevelRate::of(&record));
    let plain = Changes::default();
    let base = under(&record, &plain);
    // A marker stands where nothing is laid.
    let marked = |values: &[f64]| vec![-1.0; values.len()];
    let per_row = PER_BLOCK * BALANCE_BLOCKS;
    for one in changes() {
        // From the middle of each row on: a bias that stays is none of the balance.
        let at_sample = |at: &Moment| {
            if at.index % per_row > per_row / 2 {
                one
            } else {
                plain
            }
        };
        let mut laid = Parts {
            flow: marked(&base.flow),
            through: marked(&base.through),
            speed: marked(&base.speed),
            drop: marked(&base.drop),
            friction_factor: marked(&base.friction_factor),
            lift: marked(&base.lift),
            head_factor: marked(&base.head_factor),
            difference: marked(&base.difference),
            imbalance: marked(&base.imbalance),
        };
        run(
            &record,
            (&line, &rates),
            0..record.t_s.len(),
            Metered::default(),
            &mut laid,
            |at, c| {
                *c = at_sample(at);
                Touched::between(&plain, c)
            },
        );
        let expected = run_whole(&record, at_sample);
        let parts = listed(&laid).into_iter().zip(listed(&base));
        for (((name, laid), (_, base)), (_, expected)) in parts.zip(listed(&expected)) {
            let marked = marked(base);
            let wanted = if base == expected { &marked } else { expected };
            assert_eq!(laid, wanted, "{name} under {one:?}");
        }
    }
}

#[test]
fn effects_see_the_flow_of_the_line_and_not_what_its_meter_makes_of_it() {
    let between = Changes {
        leak_m3_s: 5e-3,
        meter_gain: 0.9,
        ..Changes::default()
    };
    let mut record = read(&between, 1);
    let stops = record.t_s.len() / 2;
    record.filled.flow[stops..].fill(0.0);
    let (line, rates) = (LineFlow::under(&record, &[]), LevelRate::of(&record));
    let samples = 0..record.t_s.len();
    let mut parts = Parts::blank(&record);
    let meter = Metered::under(&between);
    run(
        &record,
        (&line, &rates),
        samples,
        meter,
        &mut parts,
        |at, c| {
            let (flow, outflow) = if at.index < stops {
                (FLOW_M3_S, FLOW_M3_S - 5e-3)
            } else {
                (0.0, 0.0)
            };
            close(at.flow_m3_s, flow, FLOW_M3_S);
            close(at.outflow_m3_s, outflow, FLOW_M3_S);
            *c = between;
            Touched::ALL
        },
    );
}

#[test]
fn a_hypothesis_of_several_effects_is_all_of_them_and_their_meter_paths_add_up() {
    let mut record = steady(30);
    for (i, q) in record.flow.iter_mut().enumerate() {
        *q += 1e-5 * i as f64;
    }
    record.filled.flow.clone_from(&record.flow);
    let one = |id: &str, parameters: &[f64]| Applied::new(find(id).unwrap(), parameters.to_vec());
    let flow = |applied: &[Applied]| Blocks::under(&record, applied).flow;
    let late = [3.0, 5.0, 8.0].map(|s| one("return_flow_delay", &[s]));
    let both = flow(&late[..2]);
    let (bare, whole) = (flow(&[]), flow(&late[2..]));
    for b in 5..22 {
        // A flow that rises by 5e-6 m³/s a second was there so many seconds before.
        close(whole[b] - bare[b], 8.0 * 5e-6, FLOW_M3_S);
        close(both[b], whole[b], FLOW_M3_S);
    }
    let lag = flow(&[4.0, 2.0].map(|s| one("line_gas_storage", &[s, 0.0])));
    close(lag[10] - bare[10], 6.0 * 5e-6, FLOW_M3_S);
    // A gain and an offset of the outlets.
    let gain = one("return_flow_gain", &[0.02]);
    let bias = one("outlet_pressure_bias", &[3e4]);
    let (sound, found) = (
        Blocks::under(&record, &[]),
        Blocks::under(&record, &[gain, bias]),
    );
    close(found.flow[10] * 1.02, sound.flow[10], FLOW_M3_S);
    close(found.lift[10] + 3e4, sound.lift[10], 20e5);
}
