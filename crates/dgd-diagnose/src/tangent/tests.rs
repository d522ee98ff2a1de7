//! Claims about the tangent: what is off it, what its freedom costs, and when it is that of another hypothesis.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Bend, Tangent, Worked, alike};
use crate::ablation::Step;
use crate::bayes::evidence;
use crate::layout::Section;
use crate::record::Record;
use crate::relations::{Applied, Blocks};
use crate::scan::weigh;
use crate::slack::{Slack, slack};
use crate::test_rig::{BLOCK_S, Hidden, INFLUX_S, drilled, normals, one, stops_told_late};
use crate::vectors::Sparse;
use dgd_lsq::dot;
use std::sync::Arc;

fn influx(rate: f64) -> Applied {
    let (from, lasts, rise) = INFLUX_S;
    one("influx", &[rate, from, lasts, rise])
}

fn record() -> Record {
    drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    })
}

fn about(record: &Record, bend: Bend) -> Tangent {
    Tangent::at(record, &[], &[], bend).unwrap()
}

fn close(found: f64, expected: f64, size: f64) {
    assert!((found - expected).abs() < 1e-8 * size, "{found} {expected}");
}

/// Misfit and the price of all freedom.
fn cost(t: &Tangent) -> f64 {
    0.5 * dot(&t.off, &t.off) + t.ln_volume
}

#[test]
fn one_freedom_more_is_worth_its_evidence() {
    let record = record();
    // Loose curves also have columns of what answers late, which are taken at the curves found last.
    for bend in [Bend::Stiff, Bend::Lean] {
        let bare = about(&record, bend);
        let sections = bare.layout.sections();
        for (seed, width) in [(1, 200.0), (2, 3e4)] {
            let mut column = normals(seed, bare.layout.len());
            // In the units of the balance, which are m³/s.
            column[bare.layout.rows(Section::Balance).start..]
                .iter_mut()
                .for_each(|v| *v *= 1e-8);
            let off = bare.beyond(&record, &column);
            let (energy, score) = (dot(&off, &off), dot(&off, &bare.off));
            let free = Slack {
                column: Arc::new(Sparse::of(&column, &sections)),
                width,
            };
            let with = bare.clone().slackened(&record, vec![free]);
            let worth = evidence(energy, score, width, false);
            assert!(worth.abs() > 1e-3);
            close(cost(&bare) - cost(&with), worth, cost(&bare));
        }
    }
}

#[test]
fn an_effect_within_its_form_is_worth_what_it_saves_and_each_freedom_by_itself() {
    let record = record();
    let bare = about(&record, Bend::Lean);
    for one in [influx(3e-3), one("return_flow_gain", &[0.02])] {
        let state = std::slice::from_ref(&one);
        let plain = bare.refitted(&record, state);
        let mut expected = cost(&bare) - cost(&plain);
        let mut held: Vec<Slack> = Vec::new();
        for free in slack(&record, &plain, state, 0) {
            let so_far = plain.clone().slackened(&record, held.clone());
            let off = so_far.beyond(&record, &free.column.whole());
            let (energy, score) = (dot(&off, &off), dot(&off, &so_far.off));
            expected += evidence(energy, score, free.width, false);
            held.push(free);
        }
        assert!(held.len() > 1);
        close(bare.formed(&record, &[], &one), expected, cost(&bare));
        // The freedoms are told by themselves, wherever the tangent without the effect lay.
        let gain = expected - (cost(&bare) - cost(&plain));
        close(bare.form_gain(&record, &[], &one), gain, cost(&bare));
    }
}

#[test]
fn normal_equations_are_products_of_what_is_off_the_tangent() {
    let mut record = record();
    for projects in [true, false] {
        record.without = vec![Step::LateFlows];
        if !projects {
            record.without.push(Step::Projection);
        }
        let tangent = about(&record, Bend::Lean);
        let changes: Vec<Vec<f64>> = [influx(1e-3), one("line_restriction", &[5.0, 2000.0])]
            .map(|one| tangent.change(&record, &[one]))
            .to_vec();
        let off: Vec<Vec<f64>> = changes
            .iter()
            .map(|change| tangent.beyond(&record, change))
            .collect();
        let (gram, right) = tangent.normal_equations(&record, &changes);
        let size = gram[(0, 0)].max(gram[(1, 1)]);
        for a in 0..2 {
            let left = (right[a], dot(&off[a], &tangent.off));
            close(left.0, left.1, right.amax());
            for b in 0..2 {
                close(gram[(a, b)], dot(&off[a], &off[b]), size);
            }
        }
        // The curves may do what the restriction does in part, unless it is not taken off them; the balance has none.
        let left = [0, 1].map(|a| {
            let whole = tangent.whitening.apply(&changes[a]);
            dot(&off[a], &off[a]) / dot(&whole, &whole)
        });
        close(left[0], 1.0, 1.0);
        assert_eq!(left[1] < 0.9, projects, "{left:?}");
    }
}

#[test]
fn what_an_effect_may_be_wrong_by_joins_the_tangent_unless_that_step_is_left_out() {
    let mut record = record();
    let state = [influx(3e-3)];
    let freedoms = |record: &Record, state: &[Applied]| {
        let beside = Tangent::beside(record, state, &[], Bend::Lean).unwrap();
        let bare = Tangent::at(record, state, &[], Bend::Lean).unwrap();
        beside.basis.len() - bare.basis.len()
    };
    assert_eq!(freedoms(&record, &[]), 0);
    // Strength, onset, duration, shape; time twice and load.
    assert_eq!(freedoms(&record, &state), 7);
    record.without = vec![Step::Slack];
    assert_eq!(freedoms(&record, &state), 0);
}

#[test]
fn hypotheses_are_alike_digit_for_digit_only() {
    let leak = |rate: f64| one("line_leak", &[rate, 2000.0]);
    let restriction = one("line_restriction", &[1e-3, 2000.0]);
    let same = |a: &[Applied], b: &[Applied]| {
        assert_eq!(alike(a, b), alike(b, a));
        alike(a, b)
    };
    assert!(same(&[], &[]));
    assert!(same(
        &[leak(1e-3), influx(1e-3)],
        &[leak(1e-3), influx(1e-3)]
    ));
    assert!(!same(&[leak(1e-3)], &[]));
    assert!(!same(&[leak(1e-3)], &[leak(1e-3), influx(1e-3)]));
    assert!(!same(&[leak(1e-3)], &[leak(1e-3_f64.next_up())]));
    assert!(!same(&[leak(1e-3)], &[restriction]));
    assert!(!same(
        &[leak(1e-3), influx(1e-3)],
        &[influx(1e-3), leak(1e-3)]
    ));
}

#[test]
fn the_pump_is_on_its_way_where_the_flow_goes_to_another_level() {
    let record = drilled(Hidden::default());
    let moving = about(&record, Bend::Stiff).moving(&record);
    assert_eq!(moving.len(), record.blocks);
    for (b, moving) in moving.iter().enumerate() {
        // A new level every four minutes, reached within half a minute: at 720 s by more than a fifth, at 960 s by a quarter.
        let t = (b as f64 + 0.5) * BLOCK_S;
        let apart = ((t + 120.0) % 240.0 - 120.0).abs();
        if (t - 720.0).abs() < 10.0 || (t - 960.0).abs() < 10.0 {
            assert!(moving, "{t}");
        }
        if apart > 100.0 || t < 100.0 {
            assert!(!moving, "{t}");
        }
    }
}

#[test]
fn without_flow_or_without_speed_there_is_nothing_to_fit() {
    let sound = drilled(Hidden::default());
    assert!(Tangent::at(&sound, &[], &[], Bend::Stiff).is_some());
    let mut still = sound.clone();
    still.speed[50..].fill(f64::NAN);
    assert!(Tangent::at(&still, &[], &[], Bend::Stiff).is_none());
    let mut unknown = sound;
    unknown.outlet.fill(f64::NAN);
    assert!(Tangent::at(&unknown, &[], &[], Bend::Stiff).is_none());
}

#[test]
fn a_sketch_tells_the_size_of_the_signature_that_it_comes_to() {
    let mut record = record();
    for without in [vec![], vec![Step::Projection]] {
        record.without = without;
        let tangent = about(&record, Bend::Loose);
        let of = |one: Applied| tangent.change(&record, &[one]);
        // What is a term of the friction, whose prior is wide, but for a thousandth of it: nothing is left to subtract from.
        let leak = of(one("line_leak", &[1e-3, 0.0]));
        let mut within = leak.iter().map(|v| 1e-3 * v).collect::<Vec<_>>();
        for (row, q) in within.iter_mut().zip(&Blocks::under(&record, &[]).flow) {
            *row += 1e5 * (q / tangent.curves.scale.flow_m3_s).powi(2);
        }
        let restriction = of(one("line_restriction", &[5.0, 2000.0]));
        let changes = [of(influx(1e-3)), restriction, leak, within];
        for (k, change) in changes.iter().enumerate() {
            let sketch = tangent.sketched(&record, change);
            let later = matches!(sketch.of, Worked::Later(_));
            assert_eq!(later, k < 3 && record.takes(Step::Projection), "{k}");
            let (energy, score) = (sketch.energy, sketch.score);
            let signature = sketch.signature();
            assert_eq!(signature, tangent.beyond(&record, change), "{k}");
            let exact = dot(&signature, &signature);
            assert!(
                (energy - exact).abs() <= 1e-8 * exact,
                "{k}: {energy} {exact}"
            );
            let size = (exact * dot(&tangent.off, &tangent.off)).sqrt();
            close(score, dot(&signature, &tangent.off), size);
        }
    }
}

#[test]
fn flows_may_be_late_until_a_lateness_is_named() {
    let record = record();
    let free = |state: &[Applied]| {
        let tangent = Tangent::at(&record, state, &[], Bend::Stiff).unwrap();
        tangent.rest.len()
    };
    let none = free(&[]);
    let u_tube = one("u_tube", &[40.0, 1.0, 0.0]);
    let allowed = Applied::allowed(u_tube.effect, 2.0);
    assert_eq!(free(&[influx(3e-3)]), none);
    assert_eq!(free(&[allowed]), none);
    // What it leaves over for want of form is no clock.
    for named in [u_tube, one("return_flow_delay", &[12.0])] {
        assert_eq!(free(&[named]), none - 2);
    }
}

#[test]
fn a_meter_late_by_less_than_is_allowed_for_speaks_for_no_gain() {
    // By how much a gain of the inflow, which it is, leads one of the meter: with flows that may be late, and with exact ones.
    let leads = |late_s: f64, gain: f64| {
        let mut record = drilled(Hidden {
            late_s,
            ..Hidden::default()
        });
        for pumped in [&mut record.mud_pump, &mut record.filled.mud_pump] {
            pumped.iter_mut().for_each(|q| *q *= gain);
        }
        [vec![], vec![Step::LateFlows]].map(|without| {
            record.without = without;
            let tangent = about(&record, Bend::Lean);
            let [inflow, meter] = ["inflow_gain", "return_flow_gain"]
                .map(|id| weigh(&record, &tangent, &[], one(id, &[0.01])).evidence);
            inflow - meter
        })
    };
    let all = [(0.4, 0.985), (0.4, 1.015), (-0.4, 0.985), (-0.4, 1.015)]
        .map(|(late_s, gain)| leads(late_s, gain));
    assert!(all.iter().all(|[free, _]| *free > 0.0), "{all:?}");
    assert!(all.iter().any(|[_, exact]| *exact < -0.5), "{all:?}");
}

#[test]
fn stops_count_for_the_path_of_the_meter_and_for_nothing_else() {
    let bare = drilled(Hidden {
        late_s: 9.0,
        ..Hidden::default()
    });
    let mut told = bare.clone();
    told.stops = stops_told_late(9);
    let [without, with] = [&bare, &told].map(|record| about(record, Bend::Stiff));
    let weighed = |one: Applied| {
        let of = |record, tangent| weigh(record, tangent, &[], one.clone()).evidence;
        of(&told, &with) - of(&bare, &without)
    };
    let rows = with.off.len() - without.off.len();
    assert_eq!(rows, 3 * 90 + 1);
    let at = without.layout.len();
    let of_stops = &with.off[at..at + rows];
    let most = 0.5 * dot(of_stops, of_stops);
    assert!(most > 40.0, "{most}");
    // A delay owes them all that they hold, a store some of it.
    let delay = weighed(one("return_flow_delay", &[9.0]));
    assert!(delay > most - 1.0 && delay <= most, "{delay} of {most}");
    let store = weighed(one("line_gas_storage", &[9.0, 0.0]));
    assert!(store < 0.5 * most, "{store} of {most}");
    // What makes no meter late is worth the same, but for the order of sums.
    let other = weighed(influx(2e-3));
    assert!(other.abs() < 1e-6, "{other}");
    let terms = |t: &Tangent| [&t.curves.friction[..], &t.curves.head[..]].concat();
    for (a, b) in terms(&with).into_iter().zip(terms(&without)) {
        close(a, b, b.abs());
    }
}
