//! Claims about the search for a period: which frequencies it asks, what a swing of each explains, and how finely it is told.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Course, LEAST_TIMES, MOST, SHORTEST_S, STEPS, Search, drawn, in_place, peaks};
use crate::empirical::instead_of;
use crate::empirical::tests::{LENGTH_S, loose, made, off_by, size_in};
use crate::empirical::timed::COMES_AGAIN;
use crate::layout::Section;
use crate::record::Record;
use crate::relations::Applied;
use crate::relations::FINE_KNOTS;
use crate::test_rig::{Hidden, drilled, normals};
use dgd_effects::{Curve, KNOTS, Place, Quantity};
use dgd_lsq::dot;
use std::f64::consts::TAU;

/// By a clock that starts at another time than 0.
const START_S: f64 = 1000.0;

fn late(mut record: Record) -> Record {
    record.setting.span_s = (START_S, START_S + LENGTH_S);
    record.t_s.iter_mut().for_each(|t| *t += START_S);
    record
}

fn swinging(place: Place, frequency: f64) -> Record {
    late(off_by(place, size_in(place), |record, i| {
        (TAU * frequency * record.t_s[i] + 1.0).sin()
    }))
}

/// A wave along a period, as a correction of unit knots.
fn wave(place: Place, frequency: f64, phase: f64) -> Applied {
    let turn = |k: usize| TAU * k as f64 / (FINE_KNOTS - 1) as f64;
    let knots = (0..FINE_KNOTS).map(|k| place.width() * (turn(k) + phase).cos());
    Applied::from(&Curve::new(
        place,
        Quantity::Period,
        (START_S, START_S + 1.0 / frequency),
        knots.collect(),
    ))
}

#[test]
fn frequencies_are_thirds_of_what_can_be_parted_from_two_times_and_a_half_to_ten_minutes() {
    let mut record = late(drilled(Hidden::default()));
    let tangent = loose(&record);
    let search = Search::of(&record, &tangent, &[]);
    let frequencies = &search.frequencies;
    assert_eq!(frequencies[0], LEAST_TIMES / LENGTH_S);
    for pair in frequencies.windows(2) {
        assert!(((pair[1] - pair[0]) * STEPS * LENGTH_S - 1.0).abs() < 1e-9);
    }
    assert_eq!(search.step, 1.0 / (STEPS * LENGTH_S));
    let last = frequencies[frequencies.len() - 1];
    assert!(last <= 1.0 / SHORTEST_S && last + search.step > 1.0 / SHORTEST_S);
    // In weeks of drilling the shortest period is longer, and in twenty-four minutes there is none.
    record.setting.span_s.1 = START_S + 3e6;
    assert_eq!(Search::of(&record, &tangent, &[]).frequencies.len(), MOST);
    record.setting.span_s.1 = START_S + 0.99 * LEAST_TIMES * SHORTEST_S;
    let none = Search::of(&record, &tangent, &[]);
    assert!(none.frequencies.is_empty() && none.coarse(Place::Friction).is_none());
}

#[test]
fn rows_are_timed_by_their_middle() {
    let record = drilled(Hidden::default());
    let layout = loose(&record).layout;
    let times = layout.times_s(10.0);
    assert_eq!(times.len(), layout.len());
    for (section, step) in layout.sections().into_iter().zip([10.0, 10.0, 10.0, 30.0]) {
        for (i, t) in times[section].iter().enumerate() {
            assert!((t - (i as f64 + 0.5) * step).abs() < 1e-9);
        }
    }
}

#[test]
fn peaks_are_higher_than_what_is_beside_them_and_two_at_the_most() {
    let of = |power: &[f64]| {
        let frequencies: Vec<f64> = (0..power.len()).map(|k| k as f64).collect();
        peaks(&frequencies, power)
    };
    assert_eq!(of(&[1.0, 3.0, 2.0, 5.0, 4.0, 4.5, 1.0]), [3.0, 5.0]);
    // At either end, and once where two are as high.
    assert_eq!(of(&[4.0, 1.0, 2.0]), [0.0, 2.0]);
    assert_eq!(of(&[1.0, 2.0, 2.0, 1.0]), [2.0]);
    assert!(of(&[0.0; 4]).is_empty() && of(&[]).is_empty());
}

#[test]
fn the_spectrum_is_what_a_wave_of_each_frequency_takes_out_of_the_residuals() {
    for place in [Place::Friction, Place::Balance, Place::InletReading] {
        let record = swinging(place, 6.3 / LENGTH_S);
        let mut tangent = loose(&record);
        let drawn = tangent.off.clone();
        // And a pulse, which has waves of all frequencies, a little later in the balance.
        let times = tangent.layout.times_s(record.block_s());
        let pulse: Vec<f64> = (times.iter().enumerate())
            .map(|(row, t)| {
                let (size, at) = if row < tangent.layout.rows(Section::Balance).start {
                    (1e4, 2600.0)
                } else {
                    (1e-3, 2750.0)
                };
                size * (-0.5 * ((t - at) / 100.0_f64).powi(2)).exp()
            })
            .collect();
        let mut struck = tangent.whitening.apply(&pulse);
        struck.resize(drawn.len(), 0.0);
        for (off, share, rest) in [(drawn, 0.05, 0.02), (struck, 0.01, 0.0)] {
            tangent.off = off;
            let search = Search::of(&record, &tangent, &[]);
            let power = search.spectrum(place).unwrap();
            assert_eq!(power.len(), search.frequencies.len());
            let most = power.iter().copied().fold(0.0, f64::max);
            for (frequency, power) in search.frequencies.iter().zip(&power) {
                let (mut pull, mut energy) = (0.0, 0.0);
                for phase in [0.0, -0.25 * TAU] {
                    let change = tangent.change(&record, &[wave(place, *frequency, phase)]);
                    let white = tangent.whitening.apply(&change);
                    pull += dot(&white, &tangent.off[..white.len()]).powi(2);
                    energy += dot(&white, &white);
                }
                // Within 50 s rows are not told apart.
                let x = 0.5 * TAU * frequency * 50.0;
                let expected = pull / energy * (x.sin() / x).powi(2);
                assert!(
                    (power - expected).abs() < share * expected + rest * most,
                    "{place:?} {frequency}: {power} {expected}"
                );
            }
        }
        // By a clock on which the last rows come early in their 50 s.
        let mut record = record;
        record.dt_s *= 0.995;
        let search = Search::of(&record, &tangent, &[]);
        assert!(search.spectrum(place).unwrap().iter().all(|p| *p > 0.0));
    }
}

#[test]
fn a_period_is_told_to_a_twentieth_of_a_step_within_the_range_of_periods() {
    let step = 1.0 / (STEPS * LENGTH_S);
    let told = |truth: f64, from: f64| {
        let record = swinging(Place::Friction, truth);
        let tangent = loose(&record);
        let search = Search::of(&record, &tangent, &[]);
        let start = search.best(Place::Friction, &[from]).unwrap();
        let finer = search.finer(start);
        assert_eq!(finer.curve.from, START_S);
        1.0 / (finer.curve.to - START_S)
    };
    let middle = 6.0 / LENGTH_S;
    for apart in [-0.82, -0.3, -0.15, 0.23, 0.45, 0.82] {
        let truth = middle + apart * step;
        let found = told(truth, middle);
        let off = (found - truth) / step;
        assert!(off.abs() < 0.05, "{apart}: {off}");
    }
    // Not beyond either end.
    let (least, most) = (LEAST_TIMES / LENGTH_S, 1.0 / SHORTEST_S);
    assert!(told(least - 0.5 * step, least) > 0.999 * least);
    assert!(told(most + 0.5 * step, most) < 1.001 * most);
}

#[test]
fn the_choice_among_what_can_be_parted_is_paid_for() {
    let frequency = 6.0 / LENGTH_S;
    let record = swinging(Place::Friction, frequency);
    let tangent = loose(&record);
    let search = Search::of(&record, &tangent, &[]);
    let best = search
        .best(
            Place::Friction,
            &[0.8 * frequency, frequency, 1.2 * frequency],
        )
        .unwrap();
    assert_eq!(best.frequency, frequency);
    let course = Course {
        place: Place::Friction,
        quantity: Quantity::Period,
        timed_s: Some((START_S, START_S + 1.0 / frequency)),
    };
    let plain = drawn(&record, &tangent, &[], None, course).unwrap();
    let choice = (20.0_f64 / 3.0).ln();
    assert!((plain.evidence - best.correction.evidence - choice).abs() < 1e-9);
    assert!((plain.borne - best.correction.borne - choice).abs() < 1e-9);
    // Where nothing swings, no choice is worth its price.
    let sound = late(drilled(Hidden::default()));
    let tangent = loose(&sound);
    for place in [Place::Friction, Place::Head, Place::Balance] {
        assert!(
            in_place(&sound, &tangent, &[], place).is_none_or(|c| c.evidence <= 0.0),
            "{place:?}"
        );
    }
}

#[test]
fn what_a_period_a_little_off_shows_less_of_is_asked_more_finely() {
    // Between two of the frequencies that are asked first.
    let record = swinging(Place::Friction, (6.5 + 1.0 / 6.0) / LENGTH_S);
    let tangent = loose(&record);
    let search = Search::of(&record, &tangent, &[]);
    let coarse = search.coarse(Place::Friction).unwrap();
    let rough = coarse.evidence();
    let fine = search.finer(coarse).evidence;
    let evidence = 0.5 * (rough + fine - COMES_AGAIN);
    assert!(evidence > rough + 1.0);
    assert!(
        instead_of(
            &record,
            &[],
            &made(Place::Friction, Quantity::Time, &[0.0; KNOTS], evidence)
        )
        .is_some()
    );
}

#[test]
fn where_the_riser_has_a_transmitter_the_inlets_reading_is_left_to_it() {
    for place in [Place::Friction, Place::InletReading] {
        let mut record = swinging(place, 7.5 / LENGTH_S);
        let asked = made(place, Quantity::Time, &[0.0; KNOTS], 20.0);
        let told = |record: &Record| instead_of(record, &[], &asked).map(|c| c.curve.place);
        assert_eq!(told(&record), Some(place));
        let noise = normals(7, record.inlet.len());
        let riser = (record.inlet.iter().zip(noise)).map(|(p, noise)| p - 3e5 + 500.0 * noise);
        record.riser = Some(riser.collect());
        if place == Place::InletReading {
            assert_ne!(told(&record), Some(Place::InletReading));
        } else {
            assert_eq!(told(&record), Some(place));
        }
    }
}
