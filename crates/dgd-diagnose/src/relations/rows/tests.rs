//! Claims about which rows a recording supports.

use super::Rows;
use crate::layout::BALANCE_BLOCKS;
use crate::numbers::whole;
use crate::record::Record;
use crate::relations::Blocks;
use crate::test_rig::{DT_S, FLOW_M3_S, PER_BLOCK, normals, stand, steady};
use std::ops::Range;

const BLOCKS: usize = 60;
/// Blocks in which the pump stands.
const STOP: Range<usize> = 20..40;

/// Samples of some blocks.
fn samples(blocks: Range<usize>) -> Range<usize> {
    blocks.start * PER_BLOCK..blocks.end * PER_BLOCK
}

/// Ten minutes with two noisy outlet transmitters and a stop in the middle.
fn stopped() -> Record {
    let mut record = steady(BLOCKS);
    stand(&mut record, &samples(STOP));
    record.outlets = [1, 2]
        .map(|seed| normals(seed, record.t_s.len()))
        .map(|noise| noise.iter().map(|v| 184e5 + 500.0 * v).collect())
        .to_vec();
    record
}

fn rows(record: &Record) -> Rows {
    Rows::of(record, &Blocks::under(record, &[]))
}

/// The rows that are used.
fn used(rows: &[bool]) -> Vec<usize> {
    (0..rows.len()).filter(|b| rows[*b]).collect()
}

fn all(ranges: &[Range<usize>]) -> Vec<usize> {
    ranges.iter().cloned().flatten().collect()
}

/// The rows of sound drilling that are not used.
fn lost(sound: &[bool], rows: &[bool]) -> Vec<usize> {
    assert_eq!(sound.len(), rows.len());
    (0..sound.len()).filter(|b| sound[*b] != rows[*b]).collect()
}

#[test]
fn no_row_lies_at_a_start_or_stop() {
    let found = rows(&stopped());
    // A start is over after a block, a stop after two; the block before either is not used. The recording begins with a start.
    assert_eq!(used(&found.head), all(&[1..19, 41..60]));
    assert_eq!(used(&found.still), (22..39).collect::<Vec<usize>>());
    assert_eq!(used(&found.friction), all(&[1..19, 22..39, 41..60]));
    assert_eq!(used(&found.outlets).len(), BLOCKS);
    // The balance needs no flow, but its own is not known where the line fills.
    assert_eq!(used(&found.balance), all(&[1..13, 14..20]));
}

#[test]
fn a_block_that_turns_or_flows_in_part_is_a_start_or_stop() {
    let sound = rows(&stopped());
    for in_stop in [false, true] {
        let block = if in_stop { 30 } else { 10 };
        let near = |first: usize, last: usize| (first..=last).collect::<Vec<_>>();
        let sample = block * PER_BLOCK + 2;
        for (flow, pumping) in [
            (if in_stop { FLOW_M3_S } else { 0.0 }, !in_stop),
            (if in_stop { 0.0 } else { FLOW_M3_S }, in_stop),
        ] {
            let mut record = stopped();
            record.filled.flow[sample] = flow;
            record.filled.pumping[sample] = pumping;
            let found = rows(&record);
            // The row before it, its own, and those until it is settled or rested again.
            let after = if in_stop { block + 2 } else { block + 1 };
            assert_eq!(
                lost(&sound.friction, &found.friction),
                near(block - 1, after)
            );
            assert_eq!(
                lost(&sound.balance, &found.balance),
                [block / BALANCE_BLOCKS]
            );
        }
    }
}

#[test]
fn a_gap_takes_the_rows_that_it_is_in() {
    let sound = rows(&stopped());
    let (block, sample) = (10, 10 * PER_BLOCK + 3);
    let without = |change: fn(&mut Record, usize)| {
        let mut record = stopped();
        change(&mut record, sample);
        let found = rows(&record);
        [
            lost(&sound.friction, &found.friction),
            lost(&sound.head, &found.head),
            lost(&sound.outlets, &found.outlets),
            lost(&sound.balance, &found.balance),
        ]
    };
    let (here, row, none) = (vec![block], vec![block / BALANCE_BLOCKS], Vec::new());
    let gap = f64::NAN;
    assert_eq!(
        without(|r, i| r.flow[i] = f64::NAN),
        [here.clone(), here.clone(), none.clone(), none.clone()]
    );
    assert_eq!(
        without(|r, i| r.speed[i] = f64::NAN),
        [none.clone(), here.clone(), none.clone(), none.clone()]
    );
    for change in [
        |r: &mut Record, i: usize| r.mud_pump[i] = f64::NAN,
        |r: &mut Record, i: usize| r.booster[i] = f64::NAN,
    ] {
        assert_eq!(
            without(change),
            [none.clone(), none.clone(), none.clone(), row.clone()]
        );
    }
    // The top-fill goes on as it is for a minute to either side.
    let topped = |missing: Range<usize>| {
        let mut record = stopped();
        record.topfill[samples(missing)].fill(gap);
        lost(&sound.balance, &rows(&record).balance)
    };
    assert_eq!(topped(block - 5..block + 7), none);
    assert_eq!(topped(block - 6..block + 7), row);
    // A mean of some samples will do for a pressure: a whole block must be missing.
    let whole = |values: &mut [f64]| values[samples(10..11)].fill(f64::NAN);
    for one in [gap, 184e5] {
        let mut record = stopped();
        record.outlet[sample] = one;
        assert_eq!(used(&rows(&record).head), used(&sound.head));
    }
    let mut record = stopped();
    whole(&mut record.outlet);
    let found = rows(&record);
    assert_eq!(lost(&sound.friction, &found.friction), here);
    assert_eq!(lost(&sound.head, &found.head), here);
    let mut record = stopped();
    whole(&mut record.inlet);
    let found = rows(&record);
    assert_eq!(lost(&sound.friction, &found.friction), none);
    assert_eq!(lost(&sound.head, &found.head), here);
    let mut record = stopped();
    whole(&mut record.outlets[1]);
    assert_eq!(lost(&sound.outlets, &rows(&record).outlets), here);
    // A standing line needs its pressure and nothing else.
    let mut record = stopped();
    record.outlet[samples(30..31)].fill(f64::NAN);
    record.flow[samples(33..34)].fill(f64::NAN);
    let found = rows(&record);
    assert_eq!(lost(&sound.still, &found.still), [30]);
    assert_eq!(lost(&sound.friction, &found.friction), [30]);
}

#[test]
fn a_start_that_flow_and_speed_tell_late_ends_the_stop() {
    let sound = rows(&stopped());
    // The outlet stands lower until block 33, in which the pump starts; neither tells before block 40.
    let late = |rise_pa: f64| {
        let mut record = stopped();
        for values in [&mut record.outlet, &mut record.filled.outlet] {
            for v in &mut values[samples(20..33)] {
                *v -= rise_pa;
            }
        }
        lost(&sound.still, &rows(&record).still)
    };
    // A block too many before the start is left out, as before any.
    let hidden: Vec<usize> = (32..39).collect();
    for rise_pa in [2e5, 0.9e5, 0.3e5] {
        assert_eq!(late(rise_pa), hidden, "{rise_pa}");
    }
    assert!(late(0.1e5).is_empty(), "transmitters wander");
    // Whoever lets the line fill while the pump stands has not started it: the level that it starts from is the last.
    let mut record = stopped();
    for values in [&mut record.outlet, &mut record.filled.outlet] {
        for v in &mut values[samples(24..28)] {
            *v -= 0.9e5;
        }
        for v in &mut values[samples(39..40)] {
            *v -= 0.9e5;
        }
    }
    assert!(lost(&sound.still, &rows(&record).still).is_empty());
}

#[test]
fn a_pump_that_turns_and_lifts_nothing_leaves_the_balance() {
    let usual = Blocks::under(&stopped(), &[]).drop[10];
    // The outlet stands at a share of the drop that flowing mud has.
    let turning = |share: f64, flow_m3_s: f64| {
        let mut record = stopped();
        let turns = samples(24..STOP.end);
        record.filled.pumping[turns.clone()].fill(true);
        for values in [&mut record.flow, &mut record.filled.flow] {
            values[turns.clone()].fill(flow_m3_s);
        }
        for values in [&mut record.outlet, &mut record.filled.outlet] {
            values[turns.clone()]
                .iter_mut()
                .for_each(|v| *v -= usual * (1.0 - share));
        }
        rows(&record)
    };
    // The start takes its own row and what follows until two blocks lie behind it; the check valve opens in block 40.
    let dead_headed = all(&[1..8, 9..13, 14..20]);
    for (share, flow_m3_s) in [(0.0, 0.0), (0.2, 1.5e-3), (-0.2, 0.0)] {
        let found = turning(share, flow_m3_s);
        assert_eq!(used(&found.balance), dead_headed, "{share}");
        // Curves are asked at neither: the valve may flutter.
        assert_eq!(used(&found.still), [22]);
        assert_eq!(used(&found.head), all(&[1..19, 41..60]));
    }
    // A meter that reads nothing where the outlet tells of a flow, and a line that fills, do not.
    for share in [0.3, 1.0, -0.3] {
        assert_eq!(
            used(&turning(share, 0.0).balance),
            all(&[1..8, 14..20]),
            "{share}"
        );
    }
}

#[test]
fn near_shut_off_the_head_has_no_rows() {
    let sound = rows(&stopped());
    // More than a twelfth of the greatest flow is enough, less is not; friction is asked at either.
    for (share, used) in [(0.075, false), (0.085, true)] {
        let mut record = stopped();
        for values in [&mut record.flow, &mut record.filled.flow] {
            values[samples(8..14)].fill(share * FLOW_M3_S);
        }
        let found = rows(&record);
        let expected = if used { Vec::new() } else { (8..14).collect() };
        assert_eq!(lost(&sound.head, &found.head), expected, "{share}");
        assert!(lost(&sound.friction, &found.friction).is_empty());
    }
}

#[test]
fn a_transmitter_that_repeats_itself_is_stuck() {
    let sound = rows(&stopped());
    // 24 s of one value where mud flows, a minute where it stands.
    for (first, seconds) in [(8 * PER_BLOCK + 2, 24.0), (25 * PER_BLOCK + 2, 60.0)] {
        let repeats = whole(seconds / DT_S);
        for k in [0, 1] {
            let stuck = |repeats: usize| {
                let mut record = stopped();
                record.outlets[k][first..=first + repeats].fill(185e5);
                rows(&record)
            };
            let found = stuck(repeats);
            // From its first sample on, and two blocks beyond its last.
            let last = (first + repeats) / PER_BLOCK;
            let blocks: Vec<usize> = (first / PER_BLOCK..=last + 2).collect();
            assert_eq!(lost(&sound.outlets, &found.outlets), blocks);
            assert_eq!(lost(&sound.friction, &found.friction), blocks);
            let head = if first < STOP.start * PER_BLOCK {
                blocks
            } else {
                Vec::new()
            };
            assert_eq!(lost(&sound.head, &found.head), head);
            assert!(lost(&sound.balance, &found.balance).is_empty());
            let found = stuck(repeats - 1);
            assert!(lost(&sound.friction, &found.friction).is_empty());
        }
    }
    // Up to the end of the recording.
    let mut record = stopped();
    record.outlets[0][samples(57..60)].fill(185e5);
    assert_eq!(lost(&sound.head, &rows(&record).head), [57, 58, 59]);
}

#[test]
fn an_outlet_that_rises_at_rest_tells_a_start_that_the_set_point_does_not() {
    let with = |rise_pa: f64| {
        let mut record = stopped();
        record.outlet[samples(30..STOP.end)]
            .iter_mut()
            .for_each(|v| *v += rise_pa);
        rows(&record)
    };
    // From the block before the rise on nothing stands.
    let found = with(2e5);
    assert_eq!(used(&found.still), (22..29).collect::<Vec<usize>>());
    assert_eq!(used(&found.friction), all(&[1..19, 22..29, 41..60]));
    assert_eq!(used(&found.head), all(&[1..19, 41..60]));
    let row = 30 / BALANCE_BLOCKS;
    assert!(found.balance[row - 1] && !found.balance[row]);
    // A line that drains falls, and what transmitters wander by is no start.
    for rise_pa in [-20e5, 0.5e5] {
        assert_eq!(with(rise_pa).still, rows(&stopped()).still);
    }
    // A reading that is missing, or drops out once, is neither a rise nor a low.
    for odd in [f64::NAN, 150e5] {
        let mut record = stopped();
        record.outlet[samples(27..28)].fill(odd);
        let lost = lost(&rows(&stopped()).still, &rows(&record).still);
        assert!(lost.iter().all(|b| *b == 27), "{lost:?}");
    }
    // It is the lowest of a stop that counts: one that falls first shows its start as well.
    let mut record = stopped();
    let outlet = &mut record.outlet;
    outlet[samples(24..36)].iter_mut().for_each(|v| *v -= 5e5);
    assert_eq!(used(&rows(&record).still), (22..35).collect::<Vec<usize>>());
}
