//! Claims about where the windows are laid that no fit sees, and about the range over which a model was fitted.

use crate::held_out::{held_out, model, trained};
use crate::record::Record;
use crate::relations::{Applied, Blocks, Rows};
use crate::selection::Selection;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, INFLUX_S, drilled, named};
use dgd_effects::{Curves, find};

const START_S: f64 = 300.0;

/// The windows of a recording that starts at some time, in seconds from there.
fn windows(total_s: f64, intervals: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let later: Vec<(f64, f64)> = (intervals.iter())
        .map(|i| (i.0 + START_S, i.1 + START_S))
        .collect();
    let found = held_out((START_S, START_S + total_s), &later);
    (found.iter())
        .map(|w| (w.0 - START_S, w.1 - START_S))
        .collect()
}

fn assert_near(found: &[(f64, f64)], expected: &[(f64, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (f, e) in found.iter().zip(expected) {
        assert!(
            (f.0 - e.0).abs() < 1e-6 && (f.1 - e.1).abs() < 1e-6,
            "{found:?}"
        );
    }
}

/// 0.215 of the recording, a twentieth past the middle of each equal part.
#[test]
fn where_nothing_was_found_every_part_has_its_window_past_its_middle() {
    assert_near(&windows(5400.0, &[]), &[(2340.0, 3600.0)]);
    // Two windows of 1548 s in parts of two hours.
    assert_near(
        &windows(14_400.0, &[]),
        &[(3186.0, 4734.0), (10_386.0, 11_934.0)],
    );
    // What is there from the start to the end has no edges.
    assert_near(&windows(5400.0, &[(0.0, 5400.0)]), &[(2340.0, 3600.0)]);
    assert_near(&windows(5400.0, &[(-50.0, 5500.0)]), &[(2340.0, 3600.0)]);
    // Where a window hardly fits it is cut at the end of the recording, not moved before its start.
    assert_near(&windows(1300.0, &[]), &[(85.0, 1300.0)]);
}

/// Within an hour and a half the window of 21 minutes goes, minute by minute, to the nearest place that is better.
#[test]
fn a_window_keeps_three_minutes_from_every_beginning_and_end() {
    for (intervals, from) in [
        // After the end, as before the beginning is farther; and the other way round.
        (&[(2400.0, 3000.0)][..], 3180.0),
        (&[(2700.0, 3900.0)], 1260.0),
        // From the start on there is no beginning to keep from, to the end no end.
        (&[(0.0, 2400.0)], 960.0),
        (&[(3000.0, 5400.0)], 3180.0),
        // Within three minutes of either as well.
        (&[(0.0, 1500.0)], 60.0),
        (&[(-50.0, 1500.0)], 60.0),
        (&[(3900.0, 5400.0)], 4080.0),
        (&[(3900.0, 5500.0)], 4080.0),
        // A second one bars the way: the last place of the grid, or the first.
        (&[(1000.0, 1001.0), (2500.0, 3960.0)], 4140.0),
        (&[(1440.0, 2900.0), (4400.0, 4401.0)], 0.0),
    ] {
        let found = windows(5400.0, intervals);
        assert_near(&found, &[(from, from + 1260.0)]);
    }
}

#[test]
fn a_window_lies_within_a_finding_where_it_fits() {
    // The nearest place without an edge would be after it, at 2580 s.
    assert_near(&windows(5400.0, &[(600.0, 2400.0)]), &[(960.0, 2220.0)]);
    // Of two findings that overlap, within both.
    let both = windows(7200.0, &[(0.0, 4800.0), (2400.0, 7200.0)]);
    let (from, to) = both[0];
    assert!(from >= 2580.0 && to <= 4620.0, "{both:?}");
    // Where it does not fit with three minutes to spare, outside.
    assert_near(&windows(5400.0, &[(1000.0, 2500.0)]), &[(2700.0, 3960.0)]);
}

#[test]
fn curves_hold_where_all_but_a_hundredth_of_the_blocks_were() {
    let record = drilled(Hidden::default());
    let fit = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    let state = [Applied::new(
        find("influx").unwrap(),
        vec![1e-3, 0.0, 600.0, 0.15],
    )];
    let found = model(&record, &state, &fit, &[]);
    assert_eq!(found.effects.len(), 1);
    assert_eq!(
        (found.effects[0].id.as_str(), &found.effects[0].parameters),
        ("influx", &state[0].parameters)
    );
    let blocks = Blocks::under(&record, &state);
    let mut speeds = Vec::new();
    let mut ratios = Vec::new();
    for b in (0..record.blocks).filter(|b| fit.rows.head[*b]) {
        speeds.push(blocks.speed[b]);
        ratios.push(blocks.through[b] / blocks.speed[b]);
    }
    for (values, range) in [(speeds, found.speed_range_pct), (ratios, found.ratio_range)] {
        let beyond = values.len() / 200;
        let below = values
            .iter()
            .filter(|v| **v < range.0 * (1.0 - 1e-12))
            .count();
        let above = values
            .iter()
            .filter(|v| **v > range.1 * (1.0 + 1e-12))
            .count();
        assert_eq!((below, above), (beyond, beyond), "{range:?}");
        assert!(beyond > 0);
    }
}

#[test]
fn curves_hold_over_true_flows_where_the_meter_has_a_gain() {
    let record = drilled(Hidden::default());
    let fit = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    let most = |gain: f64| {
        let state = [Applied::new(find("return_flow_gain").unwrap(), vec![gain])];
        model(&record, &state, &fit, &[]).ratio_range.1
    };
    assert!((most(-0.2) / most(0.0) - 1.25).abs() < 1e-9);
}

/// What curves leave over of the friction and of the head, where mud flows, of the blocks that are let in.
fn left(record: &Record, curves: &Curves, excluded: &[bool]) -> [f64; 2] {
    let blocks = Blocks::under(record, &[]);
    let rows = Rows::of(record, &blocks);
    let of = |rows: Vec<bool>, residual: &dyn Fn(usize) -> f64| {
        let mut left: Vec<f64> = (0..record.blocks)
            .filter(|b| rows[*b] && !excluded[*b])
            .map(residual)
            .collect();
        left.sort_by(f64::total_cmp);
        left[left.len() / 2]
    };
    let flowing = (rows.friction.iter().zip(&rows.still)).map(|(f, still)| *f && !still);
    [
        of(flowing.collect(), &|b| {
            blocks.drop[b] - curves.friction_pa(blocks.flow[b])
        }),
        of(rows.head.clone(), &|b| {
            blocks.lift[b] - curves.head_pa(blocks.speed[b], blocks.through[b])
        }),
    ]
}

#[test]
fn a_run_keeps_what_the_transmitters_show_of_mud_that_flows() {
    let mut record = drilled(Hidden::default());
    // What is held out tells nothing of it.
    let excluded: Vec<bool> = (0..record.blocks).map(|b| b < record.blocks / 3).collect();
    for p in &mut record.outlet[..5 * (record.blocks / 3)] {
        *p += 2e5;
    }
    let fit = Tangent::at(&record, &[], &excluded, Bend::Stiff).unwrap();
    let found = model(&record, &[], &fit, &excluded);
    let [friction, head] = left(&record, &found.curves, &excluded);
    assert!(
        friction.abs() < 1e-6 && head.abs() < 1e-6,
        "{friction} {head}"
    );
    // The wander had a part of it.
    let [friction, head] = left(&record, &fit.curves, &excluded);
    assert!(
        friction.abs() > 50.0 && head.abs() > 10.0,
        "{friction} {head}"
    );
    // Nothing else of the curves is touched.
    assert_eq!(found.curves.friction[1..], fit.curves.friction[1..]);
    assert_eq!(found.curves.head[1..], fit.curves.head[1..]);
}

/// On the training blocks the search begins anew: an influx that the whole recording had elsewhere is found where it is,
/// and to the minute.
#[test]
fn what_is_named_is_fitted_again_on_the_training_blocks() {
    let record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    // The last twenty minutes are held out.
    let excluded: Vec<bool> = (0..record.blocks).map(|b| b >= 420).collect();
    let (from, lasts, rise) = INFLUX_S;
    for onset in [from - 60.0, from + 1200.0] {
        let selection = Selection {
            held: 0,
            allowances: Vec::new(),
            named: vec![named("influx", &[2e-3, onset, lasts, rise])],
            first: Vec::new(),
            stays: false,
        };
        let found = trained(&record, &[], &selection, &excluded).unwrap();
        let influx = found.iter().find(|a| !a.allowance).unwrap();
        assert_eq!(influx.id(), "influx");
        let p = &influx.parameters;
        assert!((p[0] - 3e-3).abs() < 3e-4, "{p:?}");
        assert!(
            (p[1] - from).abs() < 30.0 && (p[1] + p[2] - from - lasts).abs() < 30.0,
            "{p:?}"
        );
    }
}
