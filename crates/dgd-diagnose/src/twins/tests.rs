//! Claims about two transmitters of one pressure.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Pair, Twins};
use crate::noise::Wander;
use crate::numbers::whole;
use crate::record::Record;
use crate::relations::Applied;
use crate::test_rig::{normals, steady};
use dgd_effects::{Curve, KNOTS, Place, Quantity};
use dgd_lsq::dot;
use nalgebra::{DMatrix, DVector};

pub(super) const BLOCKS: usize = 1200;
/// Accuracy of a good transmitter, wandering over two hours.
pub(super) const WANDER: Wander = Wander {
    friction_pa: 0.0,
    head_pa: 0.0,
    outlets_pa: 3e3,
    balance_m3_s: 0.0,
    blocks: 800.0,
    hidden_friction_pa: 0.0,
    hidden_head_pa: 0.0,
    hidden_blocks: 30.0,
};
const UNIT: f64 = 1.5e4;

/// Inlets that read too much by `drift` at each share of the recording, 3 m of mud above the riser's transmitter.
pub(super) fn drifting(drift: impl Fn(f64) -> f64) -> Record {
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

/// The same with two transmitters at either side of the pump.
fn doubled() -> Record {
    let mut record = drifting(|_| 0.0);
    record.inlets = vec![record.inlet.clone(); 2];
    record.outlets = vec![record.outlet.clone(); 2];
    record
}

/// The inlets beside the riser's transmitter.
pub(super) fn twins(record: &Record, excluded: &[bool]) -> Option<Twins> {
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
fn what_a_reading_is_held_to_be_off_by_is_taken_off() {
    let record = doubled();
    let curve: Vec<f64> = (0..BLOCKS).map(|b| 3e4 * (b as f64 / 90.0).sin()).collect();
    for (pair, place, share) in [
        (Pair::Inlets, Place::FirstInlet, 1.0),
        (Pair::Inlets, Place::SecondInlet, -1.0),
        (Pair::Outlets, Place::FirstOutlet, 1.0),
        (Pair::Outlets, Place::SecondOutlet, -1.0),
        (Pair::InletAndRiser, Place::InletReading, 1.0),
        (Pair::InletAndRiser, Place::SecondInlet, 0.5),
        (Pair::InletAndRiser, Place::RiserReading, -1.0),
        // What moves both of two parts them by nothing.
        (Pair::Inlets, Place::InletReading, 0.0),
    ] {
        // From the middle of the first block to that of the last.
        let to_s = 10.0 * (BLOCKS - 1) as f64 + 4.0;
        let held = Curve::new(place, Quantity::Time, (4.0, to_s), curve.clone());
        let state = [Applied::from(&held)];
        let residual = |state: &[Applied]| {
            let twins = Twins::of(&record, pair, state, WANDER, &[]).unwrap();
            twins.residual().to_vec()
        };
        let (sound, off) = (residual(&[]), residual(&state));
        let taken = |b: usize| sound[b] - off[b];
        for (b, by) in curve.iter().enumerate() {
            // But for the median of what is left.
            let found = taken(b) - taken(0);
            assert!((found - share * by).abs() < 1e-3, "{place:?} {b}: {found}");
        }
    }
}

#[test]
fn a_transmitter_that_is_stuck_or_missing_does_not_part_from_the_other() {
    for missing in [false, true] {
        let mut record = drifting(|_| 0.0);
        let riser = record.riser.as_mut().unwrap();
        for (i, (inlet, riser)) in record.inlet.iter_mut().zip(riser.iter_mut()).enumerate() {
            let mud = 1e5 * (i as f64 / 300.0).sin();
            *inlet += mud;
            *riser += mud;
        }
        let held = if missing { f64::NAN } else { riser[2000] };
        riser[2000..2600].fill(held);
        assert!(twins(&record, &[]).unwrap().parting(0).is_none());
    }
}

#[test]
fn what_the_suction_is_known_to_lose_parts_no_transmitters() {
    let mut record = drifting(|_| 0.0);
    let half = record.filled.flow.len() / 2;
    record.filled.flow[half..]
        .iter_mut()
        .for_each(|q| *q *= 0.5);
    let lossless = twins(&record, &[]).unwrap();
    let off = |record: &Record| {
        let found = twins(record, &[]).unwrap();
        let apart = found.residual.iter().zip(&lossless.residual);
        for (a, b) in apart.clone() {
            assert_eq!(a.is_finite(), b.is_finite());
        }
        assert!(apart.clone().any(|(a, _)| a.is_finite()));
        (apart.map(|(a, b)| (a - b).abs()))
            .filter(|v| v.is_finite())
            .fold(0.0, f64::max)
    };
    record.suction_heads = Some(0.8);
    for i in 0..record.inlet.len() {
        record.inlet[i] -= record.suction_pa(record.filled.flow[i]);
    }
    assert!(off(&record) < 1e-6, "{}", off(&record));
    // Where it is not known it parts them.
    record.suction_heads = None;
    assert!(off(&record) > 100.0, "{}", off(&record));
}

#[test]
fn two_may_differ_by_what_span_answer_and_suction_make_of_the_readings() {
    let mut record = doubled();
    let (low, high) = record.setting.inlet_range_pa;
    for (i, t) in record.t_s.iter().enumerate() {
        record.filled.inlet[i] = 163e5 + 2.5e-3 * t * t;
        record.filled.outlet[i] = 184e5 - 5.0 * t;
        record.filled.flow[i] = match i / 5 {
            ..700 => 0.04,
            700..1100 => 0.02,
            _ => 0.0,
        };
    }
    let may = |pair: Pair| Twins::of(&record, pair, &[], WANDER, &[]).unwrap().may;
    let (riser, inlets, outlets) = (
        may(Pair::InletAndRiser),
        may(Pair::Inlets),
        may(Pair::Outlets),
    );
    assert_eq!((riser.len(), inlets.len(), outlets.len()), (4, 3, 3));
    let near = |found: f64, truth: f64| (found - truth).abs() < 1e-6 * (1.0 + truth.abs());
    let last = BLOCKS - 1;
    for b in 0..BLOCKS {
        let middle = 10.0 * b as f64 + 4.0;
        // The mean of a square over five samples, 2 s apart.
        let inlet = 163e5 + 2.5e-3 * (middle * middle + 8.0);
        let span = 3e3 * (inlet - low) / (high - low);
        // The pressure's rate, from the block before to the next, times 10 s.
        let beside = match b {
            0 => middle + 5.0,
            b if b == last => middle - 5.0,
            _ => middle,
        };
        let late = 10.0 * 5e-3 * beside;
        for two in [&riser, &inlets] {
            assert!(near(two[0][b], 1e5) && near(two[1][b], span) && near(two[2][b], late));
        }
        let lost = match b {
            ..700 => 1e4,
            700..1100 => 0.25e4,
            _ => 0.0,
        };
        assert!(near(riser[3][b], lost), "{b}: {}", riser[3][b]);
        // Outlets go by their own pressure: a line, of which a fiftieth lies beyond either end of the range.
        assert!(near(outlets[2][b], -50.0));
        let share = (last - b) as f64 / last as f64;
        let spanned = 3e3 * ((share - 0.02) / 0.96);
        assert!((outlets[1][b] - spanned).abs() < 5.0, "{b}");
    }
}

#[test]
fn knots_and_what_the_two_may_differ_by_are_weighed_together() {
    let mut record = drifting(|share| 2.5e4 * (7.0 * share).sin());
    let (low, high) = record.setting.inlet_range_pa;
    let n = record.t_s.len() as f64;
    for (i, p) in record.filled.inlet.iter_mut().enumerate() {
        *p = 0.5 * (low + high + (high - low) * (5.0 * i as f64 / n).sin());
    }
    let witness = twins(&record, &[]).unwrap();
    let (from, to) = record.setting.span_s;
    let apart_s = (to - from) / (KNOTS - 1) as f64;
    let mut columns = witness.free.clone();
    for k in 0..KNOTS {
        let hat = |t: &f64| UNIT * (1.0 - ((t - from) / apart_s - k as f64).abs()).max(0.0);
        let column: Vec<f64> = witness.t_s.iter().map(hat).collect();
        columns.push(witness.whitening.apply_whole(&column));
    }
    let m = columns.len();
    let gram = DMatrix::from_fn(m, m, |a, b| dot(&columns[a], &columns[b]));
    let pull = DVector::from_fn(m, |a, _| dot(&columns[a], &witness.apart));
    let joint = (gram + DMatrix::identity(m, m)).cholesky().unwrap();
    let (joint, (_, knots)) = (joint.solve(&pull), curve(&record, &[]));
    for (k, knot) in knots.iter().enumerate() {
        let truth = UNIT * joint[m - KNOTS + k];
        assert!((knot - truth).abs() < 1e-3, "{k}: {knot} {truth}");
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
    let mut record = drifting(|share| apart(whole(share * n as f64)));
    // What moves both alike has no edges.
    let riser = record.riser.as_mut().unwrap();
    for (i, (inlet, riser)) in record.inlet.iter_mut().zip(riser).enumerate() {
        let mud = 1e5 * (i as f64 / 4.0).sin();
        *inlet += mud;
        *riser += mud;
    }
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

#[test]
fn an_edge_is_read_where_it_stands_out_of_the_noise_of_its_own_samples() {
    // A drift, and jumps up and down a sample before every twentieth row ends.
    let sharp = |jump: f64| -> Vec<f64> {
        let apart = |i: usize| {
            let up = (i + 1) / (20 * 15) % 2 == 1;
            3e4 * (i as f64 / 900.0).sin() + if up { jump } else { 0.0 }
        };
        let n = (5 * BLOCKS) as f64;
        let record = drifting(|share| apart(whole(share * n)));
        let witness = twins(&record, &[]).unwrap();
        let parting = witness.parting(60).unwrap();
        let edges = witness.at_edges(&record, Pair::InletAndRiser, &parting);
        // By how much each differs from the curve there.
        let curve = &parting.curve;
        let smooth = |b: usize| 0.5 * (curve[b.saturating_sub(1)] + curve[b.min(BLOCKS - 1)]);
        let differ = |(row, edge): (usize, &f64)| edge - smooth(3 * row);
        edges.iter().enumerate().map(differ).collect()
    };
    // Noise alone is nowhere read: an edge has two samples, whose mean differs by 800 Pa.
    assert!(sharp(0.0).iter().all(|differs| *differs == 0.0));
    // The curve takes half of a jump, seven times that noise, and leans towards it a little: four times are asked.
    let found = sharp(1.2e4);
    let read = (1..20).filter(|k| found[20 * k].abs() > 0.0).count();
    assert!(read > 15, "{read}");
}
