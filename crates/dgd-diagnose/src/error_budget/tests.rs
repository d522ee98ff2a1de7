//! Claims about what stands between a sound model and a sound recording besides white noise.

use super::{PRESSURE_WANDER_PA, late, late_flows, moving, unrest, wander};
use crate::layout::{Layout, Section};
use crate::record::Record;
use crate::relations::Blocks;
use crate::test_rig::{
    BLOCK_S, FLOW_M3_S, MUD_PUMP_M3_S, PER_BLOCK, SPEED_PCT, blocks, parabolas, stand, steady,
};
use dgd_effects::{Curves, FRICTION_TERMS, HEAD_TERMS, Scale};

const BLOCKS: usize = 30;
const LAYOUT: Layout = Layout {
    blocks: BLOCKS,
    outlets: 0,
    balance: BLOCKS / 3,
};
/// What half a second is worth.
const TIMING_S: f64 = 0.5;

fn of(record: &Record, curves: &Curves, b: &Blocks) -> Vec<f64> {
    unrest(record, curves, b, LAYOUT)
}

fn flat() -> Curves {
    parabolas(0.0, 0.0, 0.0)
}

fn close(found: f64, expected: f64) {
    let size = 1e-9 * expected.abs().max(1e-9);
    assert!((found - expected).abs() < size, "{found} for {expected}");
}

#[test]
fn steady_running_without_noise_is_not_restless() {
    let rows = of(&steady(BLOCKS), &parabolas(4e5, 30e5, 5e5), &blocks(BLOCKS));
    assert_eq!(rows, vec![0.0; LAYOUT.len()]);
}

#[test]
fn half_a_second_is_worth_what_the_curves_move_in_it() {
    let (f, h, r) = (4e5, 30e5, 5e5);
    let mut b = blocks(BLOCKS);
    for k in 0..BLOCKS {
        let share = 1.0 + 0.002 * k as f64;
        (b.flow[k], b.speed[k]) = (FLOW_M3_S * share, SPEED_PCT * share);
    }
    let rows = of(&steady(BLOCKS), &parabolas(f, h, r), &b);
    // The impeller's flow stands still, and the line's grows evenly: no bend.
    let square = |k: usize| (1.0 + 0.002 * k as f64).powi(2);
    for k in 0..BLOCKS {
        let (a, z) = (k.saturating_sub(1), (k + 1).min(BLOCKS - 1));
        let per_s = (square(z) - square(a)) / ((z - a) as f64 * BLOCK_S);
        // The bend of an even ramp is rounding through an inertia of 9e7.
        assert!(
            (rows[k] - TIMING_S * f * per_s).abs() < 1e-6,
            "friction {k}"
        );
        close(rows[BLOCKS + k], TIMING_S * h * per_s);
    }
    // Downwards it is worth as much.
    for v in [&mut b.flow, &mut b.speed] {
        v.reverse();
    }
    let back = of(&steady(BLOCKS), &parabolas(f, h, r), &b);
    for k in 0..BLOCKS {
        assert!((back[k] - rows[BLOCKS - 1 - k]).abs() < 1e-6);
        close(back[BLOCKS + k], rows[2 * BLOCKS - 1 - k]);
    }
}

#[test]
fn where_the_flow_bends_a_third_of_the_inertia_of_the_change_is_unsure() {
    let record = steady(BLOCKS);
    let mut b = blocks(BLOCKS);
    b.flow[10] += 1e-3;
    let rows = of(&record, &flat(), &b);
    let inertia = 1200.0 * 1500.0 / 0.02;
    for (k, bend) in [(8, 0.0), (9, 1e-3), (10, 2e-3), (11, 1e-3), (12, 0.0)] {
        close(rows[k], 0.3 * inertia * bend / BLOCK_S);
    }
    // An end has no bend, and a gap none that is known.
    b.flow[0] = 0.05;
    b.flow[20] = f64::NAN;
    let rows = of(&record, &flat(), &b);
    for k in [0, 19, 20, 21] {
        assert_eq!(rows[k], 0.0, "{k}");
    }
}

#[test]
fn where_a_moving_flow_bends_both_count() {
    let (record, mut b) = (steady(BLOCKS), blocks(BLOCKS));
    for (k, q) in b.flow.iter_mut().enumerate().skip(15) {
        *q += 1e-4 * (k - 15) as f64;
    }
    let (bent, moved) = (of(&record, &flat(), &b), parabolas(4e5, 0.0, 0.0));
    let rows = of(&record, &moved, &b);
    // At the corner: half a step over two blocks, and the bend of one.
    let rate = (moved.friction_pa(b.flow[16]) - moved.friction_pa(b.flow[14])) / (2.0 * BLOCK_S);
    assert!(bent[15] > 100.0 && TIMING_S * rate > 10.0);
    close(rows[15], TIMING_S * rate + bent[15]);
}

#[test]
fn after_a_start_the_model_lacks_what_fades_in_half_a_minute() {
    let stop = |at: &dyn Fn(&mut Record)| {
        let mut record = steady(BLOCKS);
        at(&mut record);
        of(&record, &flat(), &blocks(BLOCKS))
    };
    // A block in which the pump or the flow stands for one sample is no running one.
    let sample = 12 * PER_BLOCK + 3;
    let pump = stop(&|r| r.filled.pumping[sample] = false);
    let flow = stop(&|r| r.filled.flow[sample] = 1e-3);
    assert_eq!(pump, flow);
    for (k, row) in pump[..BLOCKS].iter().enumerate() {
        let expected = match k.checked_sub(12) {
            Some(since) => 2.5e4 * (-(since as f64) * BLOCK_S / 25.0).exp(),
            None => 0.0,
        };
        close(*row, expected);
        assert_eq!(pump[BLOCKS + k], *row);
    }
    assert!(pump[2 * BLOCKS..].iter().all(|v| *v == 0.0));
}

#[test]
fn the_noise_of_flow_and_speed_comes_through_the_slopes_of_the_curves() {
    let (f, h, r) = (4e5, 30e5, 5e5);
    let mut record = steady(BLOCKS);
    record.setting.noise.flow_m3_s = 2e-4;
    record.speed_error_pct = 0.05;
    let mut b = blocks(BLOCKS);
    b.averaged[7] = 9.0;
    let rows = of(&record, &parabolas(f, h, r), &b);
    for k in [6, 7] {
        // Five samples a block, nine blocks in the calm one.
        let noise = 2e-4 / 5.0_f64.sqrt() / b.averaged[k].sqrt();
        close(rows[k], noise * 2.0 * f / FLOW_M3_S);
        let by_flow = noise * 2.0 * r / FLOW_M3_S;
        close(rows[BLOCKS + k], by_flow.hypot(0.05 * 2.0 * h / SPEED_PCT));
    }
    // What is not known moves nothing.
    b.flow[3] = f64::NAN;
    let rows = of(&record, &parabolas(f, h, r), &b);
    assert_eq!((rows[3], rows[BLOCKS + 3]), (0.0, 0.0));
}

#[test]
fn all_kinds_of_unrest_of_a_row_add_up_as_squares() {
    let f = 4e5;
    let mut record = steady(BLOCKS);
    record.filled.pumping[12 * PER_BLOCK] = false;
    let started = of(&record, &flat(), &blocks(BLOCKS));
    record.setting.noise.flow_m3_s = 2e-3;
    let noisy = of(&record, &parabolas(f, 0.0, f), &blocks(BLOCKS));
    let calm = noisy[5];
    assert!(calm > 1e3);
    for k in [12, 13, 15] {
        close(noisy[k], calm.hypot(started[k]));
        close(noisy[BLOCKS + k], calm.hypot(started[k]));
    }
}

#[test]
fn the_mass_balance_is_restless_by_every_step_of_pumps_and_return_flow() {
    let mut record = steady(BLOCKS);
    let mut b = blocks(BLOCKS);
    // Row 4 holds blocks 12 to 14, samples 60 to 74. The mud pump steps and goes back, which is twice the change.
    record.filled.mud_pump[65..68].fill(MUD_PUMP_M3_S + 4e-3);
    record.filled.booster[70..].fill(0.012);
    // A step between two blocks, and one within the pumps' noise in row 6.
    b.flow[14..].fill(FLOW_M3_S - 3e-3);
    record.filled.mud_pump[95] += 1e-4;
    let rows = of(&record, &flat(), &b);
    let mass = &rows[2 * BLOCKS..];
    let moved = (8e-3 - 3e-4) + (2e-3 - 3e-4) + 3e-3;
    for (k, row) in mass.iter().enumerate() {
        let expected = if k == 4 { TIMING_S * moved / 30.0 } else { 0.0 };
        assert!((row - expected).abs() < 1e-15, "row {k}: {row}");
    }
    // Gaps move nothing, and behind the last block there is nothing.
    record.filled.mud_pump[62] = f64::NAN;
    b.flow[12] = f64::NAN;
    let gaps = of(&record, &flat(), &b);
    assert!((gaps[2 * BLOCKS + 4] - mass[4]).abs() < 1e-15);
    record.filled.booster[BLOCKS * PER_BLOCK - 1] = 0.02;
    let last = of(&record, &flat(), &b)[2 * BLOCKS + BLOCKS / 3 - 1];
    assert!(
        (last - TIMING_S * (8e-3 - 3e-4) / 30.0).abs() < 1e-15,
        "{last}"
    );
}

#[test]
fn instruments_wander_within_their_accuracy_and_through_the_curves() {
    let (f, h, r) = (4e5, 30e5, 5e5);
    let mut record = steady(BLOCKS);
    record.setting.noise.flow_m3_s = 2e-4;
    let w = wander(&record, &parabolas(f, h, r));
    // A quarter of a percent of the flow, twice that of what goes with its square.
    close(w.friction_pa, 2.5e3_f64.hypot(0.0025 * 2.0 * f));
    let speed = 2.0 * 0.0005 * (h - r);
    close(w.head_pa, 2.5e3_f64.hypot((0.0025 * 2.0 * r).hypot(speed)));
    close(w.outlets_pa, 3750.0);
    close(w.balance_m3_s, 0.0025 * FLOW_M3_S.hypot(MUD_PUMP_M3_S));
    close(w.blocks, 800.0);
    // Movements of a little more than half of the meter's noise in a block.
    let hidden = 0.57 * 2e-4 / 5.0_f64.sqrt() / FLOW_M3_S;
    close(w.hidden_friction_pa, hidden * 2.0 * f);
    close(w.hidden_head_pa, hidden * 2.0 * r);
    close(w.hidden_blocks, 30.0);
}

#[test]
fn a_head_on_its_way_moves_with_its_neighbours_and_one_at_rest_or_unknown_does_not() {
    let mut head: Vec<f64> = vec![2e6; 40];
    for (k, h) in head.iter_mut().enumerate().skip(20) {
        *h = if k < 24 {
            2e6 - 2e5 * (k as f64 - 19.0)
        } else {
            1.2e6
        };
    }
    head[5] = f64::NAN;
    let moves = moving(&head, 10.0);
    let from = moves.iter().position(|m| *m);
    let to = moves.iter().rposition(|m| *m);
    // The ramp runs from 19 to 23; the noise remembers two blocks.
    assert_eq!((from, to), (Some(17), Some(25)));
    // Ten times slower it is worth less than the transmitters' accuracy.
    assert!(!moving(&head, 100.0).contains(&true));
}

#[test]
fn a_head_moves_from_where_half_a_second_of_its_rate_exceeds_the_transmitters_accuracy() {
    for seconds in [10.0, 20.0] {
        for (share, moves) in [(0.99, false), (1.01, true)] {
            let step = 2.0 * PRESSURE_WANDER_PA * seconds * share;
            let head: Vec<f64> = (0..30).map(|k| 3e6 - step * f64::from(k)).collect();
            // At its ends a ramp is known from one side.
            assert_eq!(moving(&head, seconds), vec![moves; 30], "{seconds} {share}");
        }
    }
}

#[test]
fn what_answers_late_changes_the_head_by_its_rate_and_nothing_else() {
    let mut head = [0.0; HEAD_TERMS];
    head[1] = 2e6;
    head[3] = -5e5;
    let curves = Curves {
        scale: Scale {
            flow_m3_s: 0.06,
            speed_pct: 60.0,
            laminar: None,
        },
        friction: [1e5; FRICTION_TERMS],
        head,
    };
    let n = 20;
    let flow: Vec<f64> = (0..n).map(|k| 0.02 + 0.001 * k as f64).collect();
    let speed: Vec<f64> = (0..n).map(|k| 50.0 + 0.2 * k as f64).collect();
    let by_flow = (curves.head_pa(52.0, 0.0301) - curves.head_pa(52.0, 0.0299)) / 2e-4;
    let by_speed = (curves.head_pa(52.01, 0.03) - curves.head_pa(51.99, 0.03)) / 0.02;
    let b = Blocks {
        through: flow.clone(),
        averaged: vec![1.0; n],
        drop: vec![0.0; n],
        friction_factor: vec![1.0; n],
        lift: vec![0.0; n],
        head_factor: vec![1.0; n],
        difference: Vec::new(),
        imbalance: vec![0.0; 4],
        flow,
        speed,
    };
    let layout = Layout {
        blocks: n,
        outlets: 0,
        balance: 4,
    };
    let [meter, drive] = late(10.0, &curves, &b, layout);
    // 0.0001 m3/s and 0.02 % a second at the tenth block.
    assert!((meter[n + 10] / (1e-4 * by_flow) - 1.0).abs() < 1e-6);
    assert!((drive[n + 10] / (0.02 * by_speed) - 1.0).abs() < 1e-6);
    for column in [meter, drive] {
        assert!(
            column[..n]
                .iter()
                .chain(&column[2 * n..])
                .all(|v| *v == 0.0)
        );
    }
}

#[test]
fn flows_that_are_late_change_what_the_balance_holds_by_their_steps_and_nothing_else() {
    let mut record = steady(BLOCKS);
    let more_m3_s = 3e-3;
    // Up in the third row, down at the edge of the sixth and the seventh.
    let (up, down) = (2 * 15 + 7, 6 * 15);
    let shifted = |by: usize| {
        let mut flow = vec![FLOW_M3_S; record.t_s.len()];
        flow[up + by..down + by].fill(FLOW_M3_S + more_m3_s);
        flow
    };
    let (told, later) = (shifted(0), shifted(1));
    record.filled.flow.clone_from(&told);
    record.flow.clone_from(&told);
    let [mud_pump, meter] = late_flows(&record, LAYOUT);
    assert!(mud_pump.iter().all(|v| *v == 0.0));
    let balance = LAYOUT.rows(Section::Balance);
    assert!(meter[..balance.start].iter().all(|v| *v == 0.0));
    let step = more_m3_s / 30.0;
    // At the edge of two rows both have half of it.
    let expected = [
        0.0,
        0.0,
        step,
        0.0,
        0.0,
        -0.5 * step,
        -0.5 * step,
        0.0,
        0.0,
        0.0,
    ];
    for (found, expected) in meter[balance.clone()].iter().zip(expected) {
        close(*found, expected);
    }
    // That is what the balance changes by, a second of it.
    let before = Blocks::under(&record, &[]).imbalance;
    record.flow.clone_from(&later);
    let after = Blocks::under(&record, &[]).imbalance;
    for (k, (before, after)) in before.iter().zip(&after).enumerate().take(5) {
        close((after - before) / 2.0, meter[balance.start + k]);
    }
    let by_hand = |k: usize| (after[k] - before[k]) / 2.0;
    close(by_hand(5) + by_hand(6), -step);
}

#[test]
fn a_pump_that_stands_for_most_of_a_recording_wanders_by_what_it_does_when_it_turns() {
    let curves = parabolas(4e5, 30e5, 5e5);
    let turning = wander(&steady(BLOCKS), &curves);
    let mut record = steady(BLOCKS);
    let stands = 0..2 * BLOCKS / 3 * PER_BLOCK;
    stand(&mut record, &stands);
    record.mud_pump[stands].fill(0.0);
    let mostly_standing = wander(&record, &curves);
    close(mostly_standing.balance_m3_s, turning.balance_m3_s);
    close(mostly_standing.friction_pa, turning.friction_pa);
    close(mostly_standing.head_pa, turning.head_pa);
}
