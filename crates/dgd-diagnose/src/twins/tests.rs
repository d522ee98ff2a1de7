//! Claims about two transmitters of one pressure.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Pair, Twins};
use crate::claims::fixture::steady;
use crate::draws::normals;
use crate::noise::Wander;
use crate::record::Record;
use dgd_effects::KNOTS;
use nalgebra::DMatrix;

const BLOCKS: usize = 1200;
/// Accuracy of a good transmitter, wandering over two hours.
const WANDER: Wander = Wander {
    friction_pa: 0.0,
    head_pa: 0.0,
    difference_pa: 3e3,
    mass_m3_s: 0.0,
    blocks: 800.0,
    hidden_friction_pa: 0.0,
    hidden_head_pa: 0.0,
    hidden_blocks: 30.0,
};
const UNIT: f64 = 1.5e4;

/// Inlets that read too much by `drift` at each share of the recording, 3 m of mud above the riser's transmitter.
fn drifting(drift: impl Fn(f64) -> f64) -> Record {
    let mut record = steady(BLOCKS);
    let n = record.t_s.len();
    let noise = [normals(1, n), normals(2, n)];
    let truth = record.inlet.clone();
    let riser = (0..n).map(|i| truth[i] + 3.5e4 + 800.0 * noise[0][i]);
    record.riser = Some(riser.collect());
    for i in 0..n {
        record.inlet[i] += 800.0 * noise[1][i] + drift(i as f64 / n as f64);
    }
    record
}

/// The inlets beside the riser's transmitter.
fn twins(record: &Record, excluded: &[bool]) -> Option<Twins> {
    Twins::of(record, Pair::InletAndRiser, &[], WANDER, excluded)
}

/// Evidence of a curve of free knots, and the knots, Pa.
fn curve(record: &Record, excluded: &[bool]) -> (f64, Vec<f64>) {
    let witness = twins(record, excluded).unwrap();
    let (gram, right) = witness
        .normal_equations(record.setting.span_s, UNIT)
        .unwrap();
    let factor = (gram + DMatrix::identity(KNOTS, KNOTS)).cholesky().unwrap();
    let solved = factor.solve(&right);
    let price: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
    let knots = solved.iter().map(|v| v * UNIT).collect();
    (0.5 * right.dot(&solved) - price, knots)
}

#[test]
fn the_riser_tells_how_the_inlets_drift_but_for_a_constant() {
    let of = |share: f64| 2.5e4 * (7.0 * share).sin();
    let (evidence, knots) = curve(&drifting(of), &[]);
    assert!(evidence > 100.0, "{evidence}");
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let truth: Vec<f64> = (0..KNOTS)
        .map(|k| of(k as f64 / (KNOTS - 1) as f64))
        .collect();
    let (shift, centre) = (mean(&knots), mean(&truth));
    for (found, truth) in knots.iter().zip(&truth) {
        assert!(((found - shift) - (truth - centre)).abs() < 5e3);
    }
}

#[test]
fn transmitters_that_differ_by_a_constant_and_their_accuracy_tell_nothing() {
    let (evidence, _) = curve(&drifting(|share| 3e3 * (5.0 * share).sin()), &[]);
    assert!(evidence < 0.0, "{evidence}");
}

#[test]
fn what_parts_the_two_is_told_by_block_beside_its_noise() {
    // Two transmitters of 800 Pa, five samples a block.
    let noise = 800.0 * (2.0_f64 / 5.0).sqrt();
    let found = |record: &Record, excluded: &[bool]| {
        let witness = twins(record, excluded).unwrap();
        witness.noise_pa() / noise
    };
    let calm = found(&drifting(|_| 0.0), &[]);
    assert!((calm - 1.0).abs() < 0.1, "{calm}");
    // Blocks that are not looked at tell nothing of it.
    let mut noisy = drifting(|_| 0.0);
    for (i, p) in noisy.inlet.iter_mut().enumerate().skip(BLOCKS) {
        *p += if i % 2 == 0 { 1e5 } else { -1e5 };
    }
    let late: Vec<bool> = (0..BLOCKS).map(|b| 5 * b >= BLOCKS - 5).collect();
    let looked = found(&noisy, &late);
    assert!((looked - 1.0).abs() < 0.1, "{looked}");

    // The column between the two is taken out, a step is not.
    let step = |share: f64| if share >= 0.75 { 4e4 } else { 0.0 };
    let witness = twins(&drifting(step), &[]).unwrap();
    let (residual, t_s) = (witness.residual(), witness.t_s());
    assert_eq!((residual.len(), t_s.len()), (BLOCKS, BLOCKS));
    for (b, (residual, t)) in residual.iter().zip(t_s).enumerate() {
        // Of samples at 0, 2, 4, 6 and 8 s.
        assert!((t - (10.0 * b as f64 + 4.0)).abs() < 1e-9);
        let off = residual - step(b as f64 / BLOCKS as f64);
        assert!(off.abs() < 6.0 * noise, "{b}: {off}");
    }
}

#[test]
fn a_drift_is_the_same_by_a_clock_that_starts_later() {
    let early = drifting(|share| 2.5e4 * (7.0 * share).sin());
    let mut late = early.clone();
    late.t_s.iter_mut().for_each(|t| *t += 7e4);
    late.setting.span_s = (early.setting.span_s.0 + 7e4, early.setting.span_s.1 + 7e4);
    let (early, late) = (curve(&early, &[]), curve(&late, &[]));
    assert!((early.0 - late.0).abs() < 1e-3);
    for (early, late) in early.1.iter().zip(&late.1) {
        assert!((early - late).abs() < 0.1);
    }
}

#[test]
fn what_the_suction_loses_and_a_difference_of_spans_are_no_drift() {
    let slow = |share: f64| (7.0 * share).sin();
    let flow = |share: f64| 0.04 * (1.0 + 0.3 * slow(share));
    let squared = |share: f64| -2e4 * (flow(share) / 0.04).powi(2);
    let spanned = |share: f64| 1.2e4 * slow(share);
    let told = |apart: &dyn Fn(f64) -> f64, flows: bool, spans: bool| {
        let mut record = drifting(apart);
        let n = record.t_s.len();
        let (low, high) = record.setting.inlet_range_pa;
        for i in 0..n {
            let share = i as f64 / n as f64;
            if flows {
                record.filled.flow[i] = flow(share);
            }
            if spans {
                record.filled.inlet[i] = 0.5 * (low + high + (high - low) * slow(share));
            }
        }
        curve(&record, &[]).0
    };
    // What follows neither flow nor pressure drifts.
    for (apart, flows) in [(&squared as &dyn Fn(f64) -> f64, true), (&spanned, false)] {
        let (alone, known) = (told(apart, false, false), told(apart, flows, !flows));
        assert!(alone > 5.0 && known < 0.0, "{alone} {known}");
    }
}

#[test]
fn what_the_mud_does_moves_both_alike_and_a_constant_is_not_told() {
    let mut record = drifting(|_| 0.0);
    let n = record.t_s.len();
    for i in 0..n {
        let mud = 1e5 * (7.0 * i as f64 / n as f64).sin();
        record.inlet[i] += mud;
        record.riser.as_mut().unwrap()[i] += mud;
    }
    assert!(curve(&record, &[]).0 < 0.0);
    // Knots that are all alike are a constant, of which the two tell next to nothing.
    let witness = twins(&record, &[]).unwrap();
    let span = record.setting.span_s;
    let (gram, right) = witness.normal_equations(span, UNIT).unwrap();
    assert!(
        gram.sum().abs() < 0.05 * gram.trace(),
        "{} {}",
        gram.sum(),
        gram.trace()
    );
    assert!(right.sum().abs() < 0.1 * gram.trace());
}

#[test]
fn excluded_blocks_and_a_riser_without_transmitter_are_no_witness() {
    // A reading that jumps in the stretch that is not looked at.
    let jump = |share: f64| if share > 0.8 { 1e5 } else { 0.0 };
    let late: Vec<bool> = (0..BLOCKS).map(|b| b > 950).collect();
    assert!(curve(&drifting(jump), &[]).0 > 100.0);
    assert!(curve(&drifting(jump), &late).0 < 0.0);
    assert!(twins(&steady(100), &[]).is_none());
}

#[test]
fn where_rows_of_the_balance_meet_an_edge_is_as_sharp_as_it_is_read() {
    // A row is 15 samples; the reading jumps a sample before the third hundred of them ends, and drifts all the time.
    let n = 5 * BLOCKS;
    let edge = 300 * 15;
    let apart = |i: usize| 3e4 * (i as f64 / 900.0).sin() + if i < edge - 1 { 0.0 } else { 6e4 };
    let record = drifting(|share| apart((share * n as f64).round() as usize));
    let witness = twins(&record, &[]).unwrap();
    let parting = witness.parting(60).unwrap();
    let edges = witness.at_edges(&record, Pair::InletAndRiser, &parting);
    assert_eq!(edges.len(), BLOCKS / 3 + 1);
    let noise = 800.0 * 2.0_f64.sqrt();
    let constant = edges[100] - apart(1500);
    for (row, found) in edges.iter().enumerate() {
        let read: Vec<f64> = [15 * row, (15 * row).wrapping_sub(1)]
            .into_iter()
            .filter(|i| *i < n)
            .map(apart)
            .collect();
        let truth = read.iter().sum::<f64>() / read.len() as f64 + constant;
        assert!(
            (found - truth).abs() < 4.0 * noise,
            "{row}: {found} {truth}"
        );
    }
    // In its calm it has less noise than the readings.
    let square: f64 = (100..250)
        .map(|row| (edges[row] - apart(15 * row) - constant).powi(2))
        .sum();
    assert!((square / 150.0).sqrt() < 0.5 * noise);
}
