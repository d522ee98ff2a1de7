use crate::wells::{table, well};
use dgd_recording::{
    ClockError, IssueKind, Recording, RecordingError, Uneven, check_even, odd_step, survey_clock,
};
use proptest::prelude::*;

fn recording(time_s: &[f64]) -> Recording {
    Recording::from_table(table(time_s), &well()).unwrap().0
}

fn kinds(issues: &[dgd_recording::Issue]) -> Vec<IssueKind> {
    issues.iter().map(|i| i.kind).collect()
}

#[test]
fn an_even_recording_is_returned_untouched() {
    let stamps: Vec<f64> = (0..100).map(|i| 0.1 * f64::from(i)).collect();
    let recording = recording(&stamps);
    let before = (recording.clone(), recording.return_flow_m3_s.as_ptr());
    let (gridded, step_s, issues) = recording.onto_grid().unwrap();
    assert_eq!(gridded.return_flow_m3_s.as_ptr(), before.1);
    assert_eq!(gridded, before.0);
    assert!((step_s - 0.1).abs() < 1e-12);
    assert_eq!(issues, []);
}

#[test]
fn a_series_of_another_length_is_refused_by_its_name_on_any_clock() {
    for stamps in [[0.0, 1.0, 2.0], [0.0, 1.0, 3.0]] {
        let mut recording = recording(&stamps);
        recording.pump_speed_pct.pop();
        let error = recording.onto_grid().unwrap_err();
        assert_eq!(
            error.to_string(),
            "`pump_speed` has 2 samples, expected 3 to match the time"
        );
    }
}

#[test]
fn stamps_in_whole_seconds_are_surveyed_as_those_between() {
    // Those between the seconds go through every check.
    for (count, step) in [(2_i32, 1), (1000, 1), (1000, 5)] {
        let at =
            |from: f64| -> Vec<f64> { (0..count).map(|i| from + f64::from(i * step)).collect() };
        let whole = survey_clock(&at(1.6e9)).unwrap();
        let mut between = survey_clock(&at(1.6e9 + 0.25)).unwrap();
        between.span_s = (between.span_s.0 - 0.25, between.span_s.1 - 0.25);
        assert_eq!(whole, between);
        assert!(whole.even && whole.step_s == f64::from(step));
    }
    for odd in [
        vec![0.0, 1.0, 3.0],
        vec![3.0, 2.0, 1.0],
        vec![0.0, f64::NAN, 2.0],
    ] {
        assert!(survey_clock(&odd).is_ok_and(|survey| !survey.even));
    }
    assert!(survey_clock(&[1.0, 1.0, 1.0]).is_err());
}

#[test]
fn gaps_are_filled_with_nan_in_every_series() {
    let (gridded, step_s, issues) = recording(&[0.0, 2.0, 4.0, 12.0, 14.0]).onto_grid().unwrap();
    assert_eq!(step_s, 2.0);
    assert_eq!(gridded.time_s, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0]);
    for (channel, values) in gridded.series() {
        let missing: Vec<usize> = (0..8).filter(|i| values[*i].is_nan()).collect();
        assert_eq!(missing, [3, 4, 5], "{channel}");
    }
    assert_eq!(kinds(&issues), [IssueKind::Gap]);
    assert_eq!(
        issues[0].to_string(),
        "time: 1 gap, 3 samples missing; filled with NaN"
    );
}

#[test]
fn duplicates_keep_the_first_and_backward_time_is_put_in_order() {
    let (gridded, _, issues) = recording(&[0.0, 1.0, 1.0, 4.0, 3.0, 2.0, f64::NAN, 5.0])
        .onto_grid()
        .unwrap();
    assert_eq!(gridded.time_s, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    // Speed counts the samples of the file by hundredths.
    let order: Vec<f64> = gridded
        .pump_speed_pct
        .iter()
        .map(|w| ((w - 50.0) * 100.0).round())
        .collect();
    assert_eq!(order, [0.0, 1.0, 5.0, 4.0, 3.0, 7.0]);
    assert_eq!(
        kinds(&issues),
        [
            IssueKind::MissingTime,
            IssueKind::BackwardTime,
            IssueKind::DuplicateTime
        ]
    );
}

#[test]
fn jitter_moves_each_sample_to_its_own_step_however_long_the_recording() {
    let mut state = 1u64;
    let stamps: Vec<f64> = (0..20_000)
        .map(|i| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let jitter = (state >> 40) as f64 / f64::from(1u32 << 24) - 0.5;
            f64::from(i) + 0.4 * jitter
        })
        .collect();
    let (gridded, step_s, issues) = recording(&stamps).onto_grid().unwrap();
    assert!((step_s - 1.0).abs() < 1e-4, "{step_s}");
    assert_eq!(gridded.len(), 20_000);
    assert!(gridded.pump_speed_pct.iter().all(|w| w.is_finite()));
    assert_eq!(kinds(&issues), [IssueKind::Jitter]);
}

#[test]
fn rounded_stamps_of_an_odd_step_keep_their_samples() {
    // A step of 1.1 s written in whole seconds.
    let stamps: Vec<f64> = (0..5000).map(|i| (1.1 * f64::from(i)).round()).collect();
    let (gridded, step_s, _) = recording(&stamps).onto_grid().unwrap();
    let kept = gridded.pump_speed_pct.iter().filter(|w| w.is_finite());
    // Which even clock fits is open; the samples must survive on it.
    assert!(kept.count() == 5000, "step {step_s}");
}

#[test]
fn samples_that_find_their_step_taken_are_counted() {
    // At a mean of 1 Hz, but most steps near the median of 1.61 s, and no part of that fits both.
    let mut stamps = vec![0.0];
    stamps.extend((0..500).flat_map(|i| [1.61, 2.0].map(|t| f64::from(2 * i) + t)));
    let clock = survey_clock(&stamps).unwrap();
    let (gridded, _, issues) = recording(&stamps).onto_grid().unwrap();
    let kept = gridded.pump_speed_pct.iter().filter(|w| w.is_finite());
    assert_eq!(kept.count() + clock.crowded, 1001);
    assert_eq!((clock.crowded, clock.duplicates), (379, 0));
    assert_eq!(kinds(&issues).last(), Some(&IssueKind::Crowded));
    let told = issues.last().unwrap().to_string();
    assert!(
        told.starts_with("time: 379 samples lie on a step of 1.61 s that an earlier sample has"),
        "{told}"
    );
}

#[test]
fn rows_every_one_to_three_seconds_lie_on_whole_seconds() {
    for (steps, step_s) in [([1.0, 2.0, 3.0, 2.0], 1.0), ([0.5, 1.5, 1.0, 2.5], 0.5)] {
        let mut t = 0.0;
        let stamps: Vec<f64> = (0..4000)
            .map(|i| {
                // In no order that comes again.
                t += steps[(i * i / 7) % 4];
                t
            })
            .collect();
        let clock = survey_clock(&stamps).unwrap();
        assert_eq!(
            (clock.step_s, clock.crowded, clock.jitter_s),
            (step_s, 0, 0.0)
        );
        let (gridded, _, issues) = recording(&stamps).onto_grid().unwrap();
        let kept = gridded.pump_speed_pct.iter().filter(|w| w.is_finite());
        assert_eq!(kept.count(), 4000);
        assert_eq!(kinds(&issues), [IssueKind::Gap]);
    }
}

#[test]
fn a_repeat_whose_sample_is_kept_is_none() {
    // A millionth of a step apart, the one before the middle of it and the other behind.
    let mut stamps: Vec<f64> = (0..5000).map(f64::from).collect();
    stamps.splice(101..101, [100.499_999_5, 100.500_000_5]);
    let clock = survey_clock(&stamps).unwrap();
    assert_eq!(clock.step_s, 1.0);
    let (gridded, _, _) = recording(&stamps).onto_grid().unwrap();
    let kept = gridded.pump_speed_pct.iter().filter(|w| w.is_finite());
    assert_eq!(kept.count() + clock.duplicates + clock.crowded, 5002);
    assert_eq!((clock.duplicates, clock.crowded), (0, 2));
}

#[test]
fn a_clock_jump_is_refused_before_memory_is_taken() {
    let mut stamps: Vec<f64> = (0..1000).map(f64::from).collect();
    stamps.extend((0..1000).map(|i| 1.7e9 + f64::from(i)));
    let error = recording(&stamps).onto_grid().unwrap_err();
    let RecordingError::Clock(ClockError::Jump {
        jump_s, samples, ..
    }) = &error
    else {
        panic!("{error}");
    };
    assert_eq!((*jump_s, *samples), (999.0, 2000));
    assert!(
        error
            .to_string()
            .contains("split the file there, or correct its clock")
    );
}

#[test]
fn the_even_clock_is_never_longer_than_its_bound() {
    // The widest gap that is still let through.
    let stamps = [0.0, 1.0, 2.0, 100_000.0];
    assert_eq!(survey_clock(&stamps).unwrap().steps(), 100_001);
    assert!(survey_clock(&[0.0, 1.0, 2.0, 100_002.0]).is_err());
    assert!(survey_clock(&[f64::MIN, 0.0, f64::MAX]).is_err());
}

#[test]
fn too_few_stamps_are_no_clock() {
    for (stamps, found) in [
        (&[][..], 0),
        (&[f64::NAN, f64::INFINITY], 0),
        (&[3.0, 3.0, 3.0], 1),
    ] {
        let expected = ClockError::TooFew {
            found,
            samples: stamps.len(),
        };
        assert_eq!(survey_clock(stamps), Err(expected));
    }
}

#[test]
fn a_clock_that_was_set_once_keeps_its_step() {
    let stamps: Vec<f64> = (0..4000)
        .map(|i| 30.0 * f64::from(i) + if i < 1500 { 0.0 } else { 11.0 })
        .collect();
    let (gridded, step_s, issues) = recording(&stamps).onto_grid().unwrap();
    assert_eq!(step_s, 30.0);
    assert_eq!(gridded.len(), 4000);
    assert_eq!(kinds(&issues), [IssueKind::Jitter]);
}

#[test]
fn a_clock_that_was_set_back_is_refused_with_the_place() {
    let stamps: Vec<f64> = (0..300)
        .map(|i| f64::from(i) - if i < 200 { 0.0 } else { 50.0 })
        .collect();
    let error = recording(&stamps).onto_grid().unwrap_err();
    let expected = ClockError::SetBack {
        jump_s: 199.0,
        back_s: 49.0,
        samples: 50,
    };
    assert_eq!(error, RecordingError::Clock(expected));
}

#[test]
fn a_stretch_that_is_there_twice_alike_counts_once() {
    let once = recording(&(0..250).map(f64::from).collect::<Vec<f64>>());
    let again = |values: &[f64]| [&values[..200], &values[150..]].concat();
    let twice = once.map_channels(again(&once.time_s), again);
    let (gridded, _, issues) = twice.onto_grid().unwrap();
    assert_eq!(gridded.len(), 250);
    assert_eq!(
        kinds(&issues),
        [IssueKind::BackwardTime, IssueKind::DuplicateTime]
    );
}

#[test]
fn a_stamp_that_hardly_differs_from_the_one_before_repeats_it() {
    let mut stamps: Vec<f64> = (0..100).map(f64::from).collect();
    stamps.insert(51, 50.0 + 1e-7);
    let (gridded, step_s, issues) = recording(&stamps).onto_grid().unwrap();
    assert_eq!(gridded.len(), 100);
    assert_eq!(gridded.check_even(step_s), Ok(()));
    assert!(kinds(&issues).contains(&IssueKind::DuplicateTime));
}

#[test]
fn a_clock_that_jumps_stands_or_runs_at_another_step_is_named_with_the_place() {
    let even: Vec<f64> = (0..200).map(f64::from).collect();
    assert_eq!(check_even(&even, 1.0), Ok(()));
    let broken = |at: usize, t: f64| {
        let mut stamps = even.clone();
        stamps[at] = t;
        check_even(&stamps, 1.0).unwrap_err()
    };
    let odd = |sample, found_s| Uneven::Step {
        sample,
        found_s,
        step_s: 1.0,
    };
    assert_eq!(broken(100, 99.0), odd(100, 0.0));
    assert_eq!(broken(199, 1e6), odd(199, 1e6 - 198.0));
    assert_eq!(
        broken(100, 100.6).to_string(),
        odd(100, 100.6 - 99.0).to_string()
    );
    for (at, hole) in [(0, 1), (100, 100), (199, 199)] {
        for t in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let Uneven::Step { sample, .. } = broken(at, t) else {
                panic!("{}", broken(at, t));
            };
            assert_eq!(sample, hole, "{t}");
        }
    }
    // Each step is within half of one, all of them together are not.
    for step_s in [0.9, 0.98, 1.02, 1.4] {
        let expected = Uneven::Mean {
            found_s: 1.0,
            step_s,
        };
        assert_eq!(check_even(&even, step_s), Err(expected));
    }
    for step_s in [0.1, 2.1, 0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = check_even(&even, step_s);
        assert!(matches!(refused, Err(Uneven::Step { .. })), "{step_s}");
    }
    assert_eq!(check_even(&[], 1.0), Ok(()));
    assert_eq!(check_even(&[f64::NAN], 1.0), Ok(()));
    assert_eq!(odd_step(&[7.0], 1.0), None);
}

#[test]
fn jitter_within_half_a_step_is_even() {
    let stamps: Vec<f64> = (0..500)
        .map(|i| f64::from(i) + 0.2 * (1.7 * f64::from(i)).sin())
        .collect();
    assert_eq!(check_even(&stamps, 1.0), Ok(()));
    assert_eq!(check_even(&stamps, 1.009), Ok(()));
}

fn stamp() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => 0.0..200.0_f64,
        6 => (0..200_i32).prop_map(f64::from),
        1 => any::<f64>(),
        1 => Just(f64::NAN),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn what_lies_on_a_grid_is_even_by_its_own_step(
        mut stamps in prop::collection::vec(stamp(), 2..80),
        sorted: bool,
        // A step of some units in the last place of an epoch, whole or not.
        epoch in prop_oneof![4 => Just(0.0), 1 => -2e9..2e9_f64, 1 => Just(1e16), 1 => Just(-1e300)],
        digits in 0.5..4.0_f64,
    ) {
        if epoch != 0.0 {
            let unit = digits * (epoch.abs().next_up() - epoch.abs());
            stamps.iter_mut().for_each(|t| *t = epoch + unit * (*t % 300.0));
        }
        if sorted {
            stamps.sort_by(f64::total_cmp);
        }
        let n = stamps.len();
        let series = || vec![0.0; n];
        let recording = Recording {
            time_s: stamps,
            mud_pump_flow_m3_s: series(),
            booster_flow_m3_s: series(),
            topfill_flow_m3_s: series(),
            return_flow_m3_s: series(),
            pump_speed_pct: series(),
            ..Recording::default()
        };
        if let Ok((mut gridded, step_s, _)) = recording.onto_grid() {
            prop_assert_eq!(gridded.check_even(step_s), Ok(()));
            // Nor is what is joined of such, or cut out of them.
            let later = gridded.clone();
            if epoch == 0.0 && gridded.append(later, step_s).is_ok() {
                prop_assert_eq!(gridded.check_even(step_s), Ok(()));
            }
            let cut = gridded.len() / 3..gridded.len() / 2;
            prop_assert_eq!(gridded.slice(cut).check_even(step_s), Ok(()));
        }
    }
}
