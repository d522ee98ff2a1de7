//! Claims about block means: what calm leaves of noise, and what inertia leaves of a drop.
use super::{Blocks, calmed};
use crate::relations::Parts;
use crate::test_rig::{BLOCK_S, normals, steady};

const NOISE: f64 = 1e-4;

fn stepping() -> Vec<f64> {
    normals(4, 400)
        .iter()
        .enumerate()
        .map(|(i, v)| if i < 200 { 0.03 } else { 0.04 } + NOISE * v)
        .collect()
}

#[test]
fn calm_stretches_are_averaged_and_steps_are_kept() {
    let (out, count) = calmed(&stepping(), 0.0);
    for (i, v) in out.iter().enumerate() {
        let truth = if i < 200 { 0.03 } else { 0.04 };
        assert!((v - truth).abs() < 4.5 * NOISE, "block {i}: {v}");
    }
    // The last block before the step has a neighbour that is not alike: it stands alone.
    assert_eq!((count[199], count[200]), (1.0, 1.0));
    let left: f64 = (20..180).map(|i| (out[i] - 0.03).powi(2)).sum::<f64>() / 160.0;
    assert!(left.sqrt() < 0.6 * NOISE, "{}", left.sqrt());
}

#[test]
fn a_gap_is_not_averaged_into_its_neighbours() {
    let mut values = stepping();
    values[100] = f64::NAN;
    let (out, count) = calmed(&values, 0.0);
    assert!(out[100].is_nan());
    assert!(
        out.iter()
            .enumerate()
            .all(|(i, v)| i == 100 || v.is_finite())
    );
    assert_eq!((count[99], count[101]), (1.0, 1.0));
}

/// Blocks of flow, speed and drops.
fn parts(flow: Vec<f64>, drop_pa: f64) -> Parts {
    let all = |value: f64| vec![value; flow.len()];
    Parts {
        through: flow.iter().map(|q| q + 1e-3).collect(),
        speed: flow.iter().map(|q| 1000.0 * q).collect(),
        drop: all(drop_pa),
        friction_factor: all(1.0),
        lift: all(20e5),
        head_factor: all(1.0),
        difference: Vec::new(),
        imbalance: Vec::new(),
        flow,
    }
}

#[test]
fn as_many_are_averaged_as_are_alike_on_both_sides_six_each_at_most() {
    let values = [0.04; 30];
    let (out, count) = calmed(&values, 0.0);
    for (b, n) in count.iter().enumerate() {
        let side = b.min(29 - b).min(6);
        assert_eq!(*n, (2 * side + 1) as f64, "{b}");
    }
    assert!(out.iter().all(|v| (v - 0.04).abs() < 1e-15));
    // Of one value, and of nothing finite, there is nothing to average.
    for values in [vec![0.03], vec![f64::NAN; 3], vec![0.03, f64::NAN, 0.05]] {
        let (out, count) = calmed(&values, 0.0);
        assert_eq!(count, vec![1.0; values.len()]);
        for (a, b) in out.iter().zip(&values) {
            assert_eq!(a.to_bits(), b.to_bits());
        }
    }
}

#[test]
fn a_drop_is_cleared_of_what_accelerates_the_mud() {
    let record = steady(20);
    // The flow rises evenly; one block alone between two gaps does not tell how fast, and nor does the first of a wide gap.
    let mut flow: Vec<f64> = (0..20).map(|b| 0.03 + 1e-4 * f64::from(b)).collect();
    for gap in [5, 7, 12, 13] {
        flow[gap] = f64::NAN;
    }
    let drop_pa = 4e5;
    let found = Blocks::of(&record, parts(flow, drop_pa), None).drop;
    let rising = drop_pa - record.inertia() * 1e-4 / BLOCK_S;
    for (b, drop) in found.iter().enumerate() {
        let expected = if [6, 12, 13].contains(&b) {
            drop_pa
        } else {
            rising
        };
        assert!((drop - expected).abs() < 1e-6, "{b}: {drop}");
    }
}

#[test]
fn what_is_known_is_taken_from_there_only_where_it_is_the_same() {
    let record = steady(40);
    let noisy =
        |seed: u64| -> Vec<f64> { normals(seed, 40).iter().map(|v| 0.04 + NOISE * v).collect() };
    let before = parts(noisy(1), 4e5);
    let known = Blocks::of(&record, before.clone(), None);
    let mut one = before.clone();
    one.flow[20] += 1e-5;
    let mut through = before.clone();
    through.through[20] += 1e-5;
    let mut speed = before.clone();
    speed.speed[20] += 0.1;
    for other in [before.clone(), parts(noisy(2), 4e5), one, through, speed] {
        let anew = Blocks::of(&record, other.clone(), None);
        let found = Blocks::of(&record, other, Some((&before, &known)));
        assert_eq!(found.flow, anew.flow);
        assert_eq!(found.averaged, anew.averaged);
        assert_eq!(found.through, anew.through);
        assert_eq!(found.speed, anew.speed);
        assert_eq!(found.drop, anew.drop);
    }
}
