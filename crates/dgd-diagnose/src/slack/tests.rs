//! Claims about what a named effect may be wrong by: its parameters, its form, from stand to stand, and with the load.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Slack, slack};
use crate::layout::{BALANCE_BLOCKS, Section};
use crate::record::Record;
use crate::relations::Blocks;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{BLOCK_S, Hidden, INFLUX_S, drilled, one};
use dgd_effects::{Connection, Curve, KNOTS, Place, Quantity};
use dgd_lsq::dot;

fn free(record: &Record, id: &str, parameters: &[f64]) -> (Vec<Slack>, Tangent) {
    let state = [one(id, parameters)];
    let tangent = Tangent::at(record, &state, &[], Bend::Stiff).unwrap();
    (slack(record, &tangent, &state, 0), tangent)
}

/// Start of a stacked row, s.
fn time(tangent: &Tangent, row: usize) -> f64 {
    let layout = tangent.layout;
    let block = match row.checked_sub(layout.rows(Section::Balance).start) {
        Some(k) => k * BALANCE_BLOCKS,
        None => row % layout.blocks,
    };
    block as f64 * BLOCK_S
}

#[test]
fn an_effect_may_grow_with_the_flow_from_nothing_to_twice() {
    let record = drilled(Hidden::default());
    let (from, lasts, rise) = INFLUX_S;
    let parameters = [3e-3, from, lasts, rise];
    let (free, tangent) = free(&record, "influx", &parameters);
    let flow = Blocks::under(&record, &[]).flow;
    let mean = flow.iter().sum::<f64>() / flow.len() as f64;
    let mass = tangent.layout.rows(Section::Balance).start;
    let (by_strength, by_load) = (free[0].column.whole(), free[6].column.whole());
    let mut seen = 0;
    for k in 0..tangent.layout.balance {
        let trace = 3e-3 * by_strength[mass + k];
        let load = flow[k * BALANCE_BLOCKS] / mean - 1.0;
        let found = by_load[mass + k];
        assert!((found - trace * load).abs() < 1e-12, "{k}: {found}");
        seen += usize::from((trace * load).abs() > 1e-5);
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn each_stand_has_its_own_strength_and_slope() {
    let mut record = drilled(Hidden::default());
    record.setting.connections = [1800.0, 3600.0]
        .map(|from_s| Connection {
            from_s,
            to_s: from_s + 100.0,
        })
        .to_vec();
    let (free, tangent) = free(
        &record,
        "cuttings_loading",
        &[15.0, 0.82, 0.3, 0.05, 1.0, 0.0],
    );
    // Six parameters, time twice and load, and two of each of three stands.
    assert_eq!(free.len(), 6 + 3 + 2 * 3);
    let stands = &free[9..];
    assert!(stands.iter().all(|s| s.width == 0.3));
    let stands: Vec<Vec<f64>> = stands.iter().map(|s| s.column.whole()).collect();
    let edges = [0.0, 1900.0, 3700.0, record.setting.span_s.1];
    for row in 0..tangent.layout.len() {
        let t = time(&tangent, row);
        let trace: f64 = stands.iter().step_by(2).map(|column| column[row]).sum();
        for (k, stand) in stands.chunks(2).enumerate() {
            let (from, to) = (edges[k], edges[k + 1]);
            let inside = (from..to).contains(&t);
            assert_eq!(stand[0][row], if inside { trace } else { 0.0 });
            let slope = if inside {
                (2.0 * t - from - to) / (to - from)
            } else {
                0.0
            };
            assert!((stand[1][row] - trace * slope).abs() <= 1e-12 * trace.abs());
        }
    }
    for stand in stands {
        assert!(dot(&stand, &stand) > 0.0);
    }
}

#[test]
fn a_stand_ends_where_the_pump_starts_after_a_minute_or_more() {
    let mut record = drilled(Hidden::default());
    // A minute, and two seconds less.
    record.filled.pumping[600..630].fill(false);
    record.filled.pumping[1500..1529].fill(false);
    let (free, tangent) = free(&record, "line_drainage", &[0.1, 0.5, 0.0]);
    // Three parameters, time twice and load, and the strength of two stands.
    assert_eq!(free.len(), 3 + 3 + 2);
    let start = record.t_s[630];
    let (before, after) = (free[6].column.whole(), free[7].column.whole());
    assert!(dot(&before, &before) > 0.0);
    for row in 0..tangent.layout.len() {
        let other = if time(&tangent, row) < start {
            &after
        } else {
            &before
        };
        assert_eq!(other[row], 0.0, "{row}");
    }
}

#[test]
fn what_two_transmitters_part_by_may_also_sit_elsewhere() {
    let record = drilled(Hidden::default());
    let curve: Vec<f64> = (0..180).map(|k| 1e4 * (f64::from(k) / 9.0).sin()).collect();
    let of = |place: Place, knots: &[f64]| {
        let ends = (0.0, record.setting.span_s.1);
        let curve = Curve::new(place, Quantity::Time, ends, knots.to_vec());
        free(&record, "unknown", &curve.parameters())
    };
    for (place, others) in [
        (Place::Suction, 2),
        (Place::InletReading, 2),
        (Place::SecondInlet, 2),
        (Place::FirstOutlet, 1),
        (Place::RiserReading, 0),
    ] {
        let (free, tangent) = of(place, &curve);
        assert_eq!(free.len(), others, "{place:?}");
        let layout = tangent.layout;
        let (head, mass) = (
            layout.rows(Section::Head),
            layout.rows(Section::Balance).start,
        );
        for (k, slack) in free.iter().enumerate() {
            let column = slack.column.whole();
            let acts = |rows: std::ops::Range<usize>| column[rows].iter().any(|v| v.abs() > 1e-6);
            let outlet = place == Place::FirstOutlet;
            assert_eq!(acts(layout.rows(Section::Friction)), outlet);
            assert_eq!(acts(head.clone()), outlet || k == 0);
            assert_eq!(acts(mass..layout.len()), k == 1);
        }
    }
    // Knots of a model are drawn where they are.
    assert!(of(Place::Suction, &curve[..KNOTS]).0.is_empty());
}

#[test]
fn an_influx_may_be_wrong_by_its_parameters_and_by_a_seventh_of_its_form() {
    let record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    let (from, lasts, rise) = INFLUX_S;
    let state = vec![one("influx", &[3e-3, from, lasts, rise])];
    let tangent = Tangent::at(&record, &state, &[], Bend::Stiff).unwrap();
    let free = slack(&record, &tangent, &state, 0);
    // Strength, onset, duration, shape; then time twice and load, each with half of its form's error.
    let widths: Vec<f64> = free.iter().map(|s| s.width).collect();
    assert_eq!(widths, [3e-3, 120.0, 120.0, 1.0, 0.075, 0.075, 0.075]);

    // Along its strength lies all that it does.
    let columns: Vec<Vec<f64>> = free.iter().map(|s| s.column.whole()).collect();
    let trace: Vec<f64> = columns[0].iter().map(|v| 3e-3 * v).collect();
    let without = tangent.change(&record, &[]);
    let size = dot(&trace, &trace).sqrt();
    assert!(size > 1e-3);
    for (trace, without) in trace.iter().zip(&without) {
        assert!((trace + without).abs() < 1e-9 * size);
    }
    // Later by a second, it is what the trace loses in one: onset and duration together move it whole.
    let later = one("influx", &[3e-3, from + 30.0, lasts, rise]);
    let moved = tangent.change(&record, &[later]);
    for (column, moved) in columns[1].iter().zip(&moved) {
        assert!((30.0 * column - moved).abs() < 1e-9 * size);
    }
    // It may swell and fade from first to last, and be weak amidst; at the ends both are whole.
    let mass = tangent.layout.rows(Section::Balance).start;
    for row in 0..tangent.layout.balance {
        let t = (row * BALANCE_BLOCKS) as f64 * BLOCK_S;
        let through = 2.0 * ((t - from) / lasts).clamp(0.0, 1.0) - 1.0;
        let here = trace[mass + row];
        let close = |k: usize, by: f64| {
            let found = columns[k][mass + row];
            assert!((found - here * by).abs() < 1e-9 * size, "{k} {row}");
        };
        close(4, through);
        close(5, 2.0 * through * through - 1.0);
    }
    // An allowance is no finding, and not wrong by anything.
    let mut allowed = state.clone();
    allowed[0].allowance = true;
    assert!(slack(&record, &tangent, &allowed, 0).is_empty());
}
