//! Claims about the residuals that are shown over time.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{levelled, traces};
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, INFLUX_S, drilled, normals, stand};
use dgd_effects::{Relation, find};
use dgd_recording::{Rank, quantile};

/// What the clock says at the first sample, s.
const START_S: f64 = 1000.0;

/// Drilling with an influx, by a clock that starts late.
fn record() -> Record {
    let mut record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    record.setting.span_s = (START_S, START_S + 5400.0);
    record.t_s.iter_mut().for_each(|t| *t += START_S);
    record.speed_error_pct = 0.05 / 5.0_f64.sqrt();
    // Nothing is known of some minutes.
    record.flow[500..700].fill(f64::NAN);
    record
}

fn influx() -> [Applied; 1] {
    let (from, lasts, rise) = INFLUX_S;
    [Applied::new(
        find("influx").unwrap(),
        vec![3e-3, from + START_S, lasts, rise],
    )]
}

/// Standard deviation of what is there.
fn spread(values: &[f64]) -> f64 {
    let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let mean = finite.iter().sum::<f64>() / finite.len() as f64;
    let squares = finite.iter().map(|v| (v - mean).powi(2));
    (squares.sum::<f64>() / finite.len() as f64).sqrt()
}

#[test]
fn each_relation_is_shown_where_it_is_used_and_comes_to_its_noise_with_the_cause() {
    let record = record();
    let [before, after] =
        [&[][..], &influx()].map(|state| Tangent::at(&record, state, &[], Bend::Stiff).unwrap());
    let found = traces(&record, (&before, &[]), (&after, &influx()));
    let rows = &after.rows;
    let relations = [
        Relation::ReturnLineFriction,
        Relation::PumpHead,
        Relation::RiserMassBalance,
    ];
    assert_eq!(found.len(), 3);
    for (k, (trace, used)) in found
        .iter()
        .zip([&rows.friction, &rows.head, &rows.balance])
        .enumerate()
    {
        assert_eq!((trace.relation, trace.pair), (relations[k], None));
        assert_eq!(trace.unit, if k == 2 { "m3/s" } else { "Pa" });
        let (count, step) = if k == 2 { (180, 30.0) } else { (540, 10.0) };
        assert_eq!(trace.t_s.len(), count);
        for (i, t) in trace.t_s.iter().enumerate() {
            assert!((t - START_S - step * (i as f64 + 0.5)).abs() < 1e-9);
            assert_eq!(trace.after[i].is_finite(), used[i], "{k} {i}");
        }
        assert!(used.contains(&false) && trace.before.len() == count);
        // Noise is all that is left, and the mean that instruments may wander by.
        let left = spread(&trace.after) / trace.noise;
        assert!((2.0 / 3.0..1.5).contains(&left), "{k}: {left}");
    }
    // The balance misses 3 litres a second before, in the influx alone.
    let (balance, (from, lasts, _)) = (&found[2], INFLUX_S);
    for (i, t) in balance.t_s.iter().enumerate() {
        let off = (balance.before[i] - balance.after[i]).abs();
        let within = (t - START_S - from) / lasts;
        if within > 0.2 && within < 0.8 && off.is_finite() {
            assert!((off - 3e-3).abs() < 5e-4, "{t} s: {off}");
        }
    }
}

#[test]
fn flowing_mud_scatters_about_zero_and_what_no_fit_has_seen_is_shown() {
    let mut record = record();
    // A stop whose column stands a bar too low, and no fit sees it, nor the hour's first ten minutes.
    let (stop, per_block) = (300..340, record.per_block);
    let samples = stop.start * per_block..stop.end * per_block;
    stand(&mut record, &samples);
    let standing = record.column_pa() - 1e5;
    record.outlet[samples.clone()].fill(standing);
    let excluded: Vec<bool> = (0..record.blocks)
        .map(|b| b < 60 || stop.contains(&b))
        .collect();
    let before = Tangent::at(&record, &[], &excluded, Bend::Stiff).unwrap();
    let after = Tangent::at(&record, &influx(), &[], Bend::Stiff).unwrap();
    let found = traces(&record, (&before, &[]), (&after, &influx()));
    for fit in [&before, &after] {
        let (friction, head) = fit.flowing_level(&levelled(fit), &[]);
        assert!(
            friction.abs() < 1e-6 && head.abs() < 1e-6,
            "{friction} {head}"
        );
    }
    assert!(!before.rows.friction[310] && after.rows.still[310]);
    assert!((found[0].before[310] + 1e5).abs() < 1e3);
    assert!(found[0].before[30].is_finite() && found[1].before[30].is_finite());
    for (values, noise) in [
        (&found[0].before, found[0].noise),
        (&found[0].after, found[0].noise),
        (&found[1].before, found[1].noise),
    ] {
        let flowing = (values.iter().enumerate())
            .filter(|(b, v)| v.is_finite() && !after.rows.still[*b])
            .map(|(_, v)| *v);
        let level = quantile(flowing, Rank::MEDIAN).unwrap();
        assert!(level.abs() < 0.2 * noise, "{level} of {noise}");
    }
}

#[test]
fn wanders_of_what_is_seen_and_hidden_add_as_squares() {
    let record = record();
    let fit = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    let may = crate::error_budget::wander(&record, &fit.curves);
    let found = traces(&record, (&fit, &[]), (&fit, &[]));
    let square = |k: usize| found[k].wander * found[k].wander;
    let friction = may.friction_pa.powi(2) + may.hidden_friction_pa.powi(2);
    let head = may.head_pa.powi(2) + may.hidden_head_pa.powi(2);
    assert!((square(0) / friction - 1.0).abs() < 1e-9);
    assert!((square(1) / head - 1.0).abs() < 1e-9);
    assert_eq!(found[2].wander, may.balance_m3_s);
}

#[test]
fn transmitters_are_held_against_their_neighbours_where_they_have_any_that_say_something() {
    let mut record = record();
    let noise = normals(21, record.t_s.len());
    let second: Vec<f64> = record
        .outlet
        .iter()
        .zip(&noise)
        .map(|(p, n)| p - 4e4 + 2e3 * n)
        .collect();
    let riser = record
        .inlet
        .iter()
        .zip(&noise)
        .map(|(p, n)| p - 3e4 + 800.0 * n);
    record.riser = Some(riser.collect());
    record.outlets.push(second);
    let apart = record
        .inlet
        .iter()
        .zip(&noise)
        .map(|(p, n)| p - 1e4 + 500.0 * n);
    record.inlets = vec![record.inlet.clone(), apart.collect()];
    let fit = |record: &Record| Tangent::at(record, &[], &[], Bend::Stiff).unwrap();
    let tangent = fit(&record);
    let found = traces(&record, (&tangent, &[]), (&tangent, &[]));
    let pairs: Vec<_> = found.iter().filter_map(|t| t.pair).collect();
    assert_eq!(
        pairs,
        [
            "outlet transmitters, first less second",
            "inlet transmitters, first less second",
            "pump inlet less riser pressure"
        ]
    );
    for trace in &found[3..] {
        assert_eq!((trace.relation, trace.unit), (Relation::Instrument, "Pa"));
        assert!((trace.t_s.iter()).all(|t| *t > START_S && *t < START_S + 5400.0));
        assert!((trace.t_s[1] - trace.t_s[0] - 10.0).abs() < 1e-9);
        assert!(trace.noise > 0.0 && trace.wander > 0.0);
        // What stands between them is no residual.
        let left = spread(&trace.after) / trace.noise;
        assert!((2.0 / 3.0..1.5).contains(&left), "{:?}: {left}", trace.pair);
        assert_eq!(trace.before.len(), trace.t_s.len());
    }
    record.riser = None;
    record.outlets[1].fill(f64::NAN);
    record.inlets[0].fill(f64::NAN);
    let tangent = fit(&record);
    assert_eq!(traces(&record, (&tangent, &[]), (&tangent, &[])).len(), 3);
}

#[test]
fn noise_is_that_of_the_blocks_that_are_used_however_few() {
    let mut record = record();
    let noise = |record: &Record| {
        let fit = Tangent::at(record, &influx(), &[], Bend::Stiff).unwrap();
        let found = traces(record, (&fit, &influx()), (&fit, &influx()));
        found.iter().map(|t| t.noise).collect::<Vec<_>>()
    };
    let whole = noise(&record);
    // Two thirds of the recording say nothing of the flow.
    record.flow[900..].fill(f64::NAN);
    for (part, whole) in noise(&record).iter().zip(whole) {
        assert!(
            (2.0 / 3.0..1.5).contains(&(part / whole)),
            "{part} for {whole}"
        );
    }
}
