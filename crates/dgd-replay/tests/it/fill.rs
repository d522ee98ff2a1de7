//! Gaps are filled between their neighbours.

use dgd_replay::fill_gaps;
use proptest::prelude::*;

fn holed() -> impl Strategy<Value = Vec<f64>> {
    let value = prop_oneof![
        3 => -1e9..1e9_f64,
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(f64::NEG_INFINITY),
    ];
    proptest::collection::vec(value, 0..80)
}

proptest! {
    #[test]
    fn every_gap_is_counted_and_every_value_kept(values in holed()) {
        let holes = values.iter().filter(|v| !v.is_finite()).count();
        let mut filled = values.clone();
        let count = fill_gaps(&mut filled);
        if holes == values.len() {
            prop_assert_eq!(count, None);
            return Ok(());
        }
        prop_assert_eq!(count, Some(holes));
        for (new, old) in filled.iter().zip(&values) {
            prop_assert!(new.is_finite());
            prop_assert!(!old.is_finite() || new.to_bits() == old.to_bits());
        }
    }

    #[test]
    fn a_filled_value_lies_between_its_neighbours(values in holed()) {
        let mut filled = values.clone();
        prop_assume!(fill_gaps(&mut filled).is_some());
        for i in (0..values.len()).filter(|&i| !values[i].is_finite()) {
            let before = values[..i].iter().rev().copied().find(|v| v.is_finite());
            let after = values[i..].iter().copied().find(|v| v.is_finite());
            let (a, b) = (before.or(after).unwrap(), after.or(before).unwrap());
            // The interpolation may round off by a unit of the larger end.
            let slack = 2.0 * f64::EPSILON * a.abs().max(b.abs());
            prop_assert!((a.min(b) - slack..=a.max(b) + slack).contains(&filled[i]));
        }
    }

    #[test]
    fn holes_in_a_straight_line_are_filled_with_the_line(
        slope in -10.0..10.0_f64,
        holes in proptest::collection::vec(any::<bool>(), 3..60),
    ) {
        let last = holes.len() - 1;
        let line: Vec<f64> = (0..holes.len()).map(|i| 5.0 + slope * i as f64).collect();
        let mut values = line.clone();
        for i in (1..last).filter(|&i| holes[i]) {
            values[i] = f64::NAN;
        }
        fill_gaps(&mut values);
        for (value, truth) in values.iter().zip(&line) {
            prop_assert!((value - truth).abs() < 1e-10, "{} {}", value, truth);
        }
    }

    #[test]
    fn filling_backwards_gives_the_same(values in holed()) {
        let mut forwards = values.clone();
        let mut backwards: Vec<f64> = values.iter().rev().copied().collect();
        prop_assert_eq!(fill_gaps(&mut forwards), fill_gaps(&mut backwards));
        backwards.reverse();
        for (f, b) in forwards.iter().zip(&backwards) {
            prop_assert!(f.to_bits() == b.to_bits() || (f - b).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_full_stays_as_it_is(values in holed()) {
        let mut once = values;
        prop_assume!(fill_gaps(&mut once).is_some());
        let mut twice = once.clone();
        prop_assert_eq!(fill_gaps(&mut twice), Some(0));
        prop_assert_eq!(twice, once);
    }
}
