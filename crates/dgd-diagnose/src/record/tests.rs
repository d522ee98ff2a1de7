//! Claims about what becomes of a screened recording on the working clock.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Record, Slow, new_every_s, rounding};
use crate::ablation::Step;
use crate::numbers::{bridged, mean, tails, whole};
use crate::test_rig::{recorded, steady};
use dgd_identify::Prepared;
use dgd_recording::{Channel, Well};

/// All that was read, and the means of the pressures.
fn series(prepared: &mut Prepared) -> [&mut Vec<f64>; 9] {
    let r = &mut prepared.recording;
    [
        &mut r.mud_pump_flow_m3_s,
        &mut r.booster_flow_m3_s,
        &mut r.topfill_flow_m3_s,
        &mut r.return_flow_m3_s,
        &mut r.pump_speed_pct,
        &mut r.pump_inlet_pressure_pa[0],
        &mut r.pump_outlet_pressure_pa[0],
        &mut prepared.inlet_pressure_pa,
        &mut prepared.outlet_pressure_pa,
    ]
}

/// A recording of so many samples, a step apart, whose return flow counts them.
fn counted(n: usize, step_s: f64) -> (Well, Prepared) {
    let (well, mut prepared) = recorded(&steady(n / 5 + 1), 0.0);
    let r = &mut prepared.recording;
    r.time_s = (0..n).map(|i| step_s * i as f64).collect();
    r.return_flow_m3_s = (0..n).map(|i| i as f64).collect();
    for values in series(&mut prepared) {
        values.truncate(n);
    }
    prepared.step_s = step_s;
    (well, prepared)
}

#[test]
fn samples_are_averaged_to_two_seconds_and_blocks_last_ten() {
    for (step_s, fold, dt_s, per_block) in [
        (0.5, 4, 2.0, 5),
        (0.7, 2, 1.4, 7),
        (1.0, 2, 2.0, 5),
        (2.0, 1, 2.0, 5),
        (3.0, 1, 3.0, 3),
        (30.0, 1, 30.0, 1),
    ] {
        let (well, prepared) = counted(200, step_s);
        let record = Record::new(&well, &prepared, &[]);
        assert!((record.dt_s - dt_s).abs() < 1e-12, "{step_s}");
        assert_eq!(record.per_block, per_block, "{step_s}");
        assert!((record.block_s() - dt_s * per_block as f64).abs() < 1e-9);
        let samples = 200_usize.div_ceil(fold);
        assert_eq!(record.t_s.len(), samples);
        assert_eq!(record.blocks, samples / per_block);
        for k in 0..200 / fold {
            let middle = (k * fold) as f64 + 0.5 * (fold as f64 - 1.0);
            assert_eq!(record.flow[k], middle);
            assert!((record.t_s[k] - step_s * middle).abs() < 1e-9);
        }
    }
}

#[test]
fn beyond_forty_hours_clock_and_blocks_are_twice_as_long() {
    for (n, per_block) in [(14_400, 1), (14_401, 2)] {
        let (well, prepared) = counted(n, 10.0);
        let record = Record::new(&well, &prepared, &[]);
        assert_eq!((record.dt_s, record.per_block), (10.0, per_block));
    }
    let (well, prepared) = counted(72_001, 2.0);
    let record = Record::new(&well, &prepared, &[]);
    assert_eq!((record.dt_s, record.per_block), (4.0, 5));
}

#[test]
fn hurdles_grow_with_the_hours_beyond_those_they_were_set_on() {
    let (well, prepared) = counted(200, 2.0);
    let mut record = Record::new(&well, &prepared, &[]);
    for (hours, times) in [(0.0, 1.0), (8.0, 1.0), (12.0, 1.5), (80.0, 10.0)] {
        let end = 640.0 + 3600.0 * hours;
        assert_eq!(record.times_usual((640.0, end)), times);
    }
    record.setting.span_s = (640.0, 4240.0);
    assert_eq!((record.lasts_s(), record.told_s()), (3600.0, 3600.0));
}

#[test]
fn hurdles_grow_with_a_step_beyond_ten_seconds() {
    for (step_s, times) in [(1.0, 1.0), (10.0, 1.0), (40.0, 8.0)] {
        let (well, prepared) = counted(200, step_s);
        let record = Record::new(&well, &prepared, &[]);
        assert!((record.times_usual((0.0, 1000.0)) - times).abs() < 1e-12);
        let hours = (0.0, 16.0 * 3600.0);
        assert!((record.times_usual(hours) - 2.0 * times).abs() < 1e-12);
    }
}

#[test]
fn hours_without_a_reading_are_not_counted() {
    let (well, mut prepared) = counted(14_401, 10.0);
    for values in series(&mut prepared) {
        values[1000..9640].fill(f64::NAN);
    }
    let record = Record::new(&well, &prepared, &[]);
    assert_eq!(record.lasts_s() - record.told_s(), 86_400.0);
    let span_s = record.setting.span_s;
    assert_eq!(record.times_usual(span_s), record.told_s() / 28_800.0);
    assert_eq!(record.times_usual((0.0, 100_000.0)), 1.0);
}

#[test]
fn steps_are_taken_unless_they_are_left_out() {
    let (well, prepared) = counted(100, 2.0);
    let record = Record::new(&well, &prepared, &[Step::Form]);
    assert!(record.takes(Step::Edges) && !record.takes(Step::Form));
    assert_eq!(record.without, [Step::Form]);
}

/// Mud of 1200 kg/m³ in a line of 1500 m and 0.02 m².
#[test]
fn the_column_has_its_weight_and_the_line_its_inertia() {
    let record = steady(10);
    assert!((record.column_pa() - (101_325.0 + 1200.0 * 9.80665 * 1500.0)).abs() < 1e-6);
    assert!((record.inertia() - 1200.0 * 1500.0 / 0.02).abs() < 1e-3);
}

/// The mean goes over the samples within half a minute on either side, and at the ends over those that there are.
#[test]
fn effects_see_pressures_as_means_over_a_minute() {
    let mut record = steady(40);
    record.inlet.fill(1e7);
    record.inlet[100] += 31e3;
    record.outlet = (0..200).map(|i| 2e7 + 10.0 * f64::from(i)).collect();
    let (well, prepared) = recorded(&record, 0.0);
    let filled = Record::new(&well, &prepared, &[]).filled;
    for (i, inlet) in filled.inlet.iter().enumerate() {
        let near = i.abs_diff(100) <= 15;
        assert!(
            (inlet - 1e7 - if near { 1e3 } else { 0.0 }).abs() < 1e-4,
            "{i}"
        );
        // A ramp stays a ramp; at its ends it is the ramp in the middle of what there is.
        let (from, to) = (i.max(15) - 15, (i + 15).min(199));
        let ramp = 2e7 + 5.0 * (from + to) as f64;
        assert!((filled.outlet[i] - ramp).abs() < 1e-4, "{i}");
    }
    // With a clock slower than that, their own neighbours.
    let (well, mut prepared) = counted(20, 100.0);
    prepared.inlet_pressure_pa[10] += 3e3;
    let filled = Record::new(&well, &prepared, &[]).filled;
    assert!((filled.inlet[9] - filled.inlet[5] - 1e3).abs() < 1e-4);
}

#[test]
fn a_block_of_the_speed_may_be_off_by_half_a_quantum_and_its_noise() {
    let error = |speed: Vec<f64>| {
        let mut record = steady(speed.len() / 5);
        record.speed = speed;
        let (well, prepared) = recorded(&record, 0.0);
        Record::new(&well, &prepared, &[]).speed_error_pct
    };
    assert_eq!(error(vec![70.0; 500]), 0.0);
    // It moves by 0.2 every minute or so, and has no noise.
    let steps = (0..500).map(|i| {
        if (i / 31 + i / 47) % 2 == 0 {
            70.0
        } else {
            70.2
        }
    });
    assert!((error(steps.collect()) - 0.1).abs() < 1e-9);
    // White noise of 0.05 that is hardly rounded: five samples make a block. The tenth part of its differences is below
    // 0.126 of their deviation.
    let white: Vec<f64> = crate::test_rig::normals(5, 2700);
    let white = white.iter().map(|v| 70.0 + 0.05 * v).collect();
    let expected = (0.05 / 5.0_f64.sqrt()).hypot(0.5 * 0.126 * 0.05 * 2.0_f64.sqrt());
    assert!((error(white) / expected - 1.0).abs() < 0.1);
}

#[test]
fn a_balance_is_off_by_what_rounding_leaves_of_the_inlet_pressure() {
    let coarse = |inlet: Vec<f64>| {
        let mut record = steady(inlet.len() / 5);
        record.inlet = inlet;
        let (well, prepared) = recorded(&record, 0.0);
        let record = Record::new(&well, &prepared, &[]);
        // Of a row, in pascals at its two edges.
        record.coarse_m3_s * record.row_s() / record.riser_m3_per_pa() / 2.0_f64.sqrt()
    };
    let wave = |i: usize| 1e7 + 3e4 * (i as f64 / 90.0).sin();
    let rounded = |to: f64, of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..2700).map(|i| (of(i) / to).round() * to).collect()
    };
    // In steps of a psi, without noise.
    assert!((coarse(rounded(6895.0, &wave)) - 6895.0 / 12.0_f64.sqrt()).abs() < 1.0);
    // Noise that crosses them leaves nothing; a pressure that never moves has no steps.
    let noise = crate::test_rig::normals(3, 2700);
    let noisy = |i: usize| wave(i) + 6895.0 * noise[i];
    assert!(coarse(rounded(6895.0, &noisy)) < 10.0);
    assert_eq!(coarse(vec![1e7; 2700]), 0.0);
    assert!((rounding(1.0, 0.25) - 0.0841).abs() < 1e-4);
}

#[test]
fn gaps_are_bridged_for_states_and_left_in_what_is_evidence() {
    let mut record = steady(40);
    record.flow[50..60].fill(f64::NAN);
    record.flow[60..].fill(0.051);
    record.speed[..90].fill(4.9);
    record.speed[100] = f64::NAN;
    let (well, mut prepared) = recorded(&record, 0.0);
    let r = &mut prepared.recording;
    r.riser_pressure_pa = Some(vec![1e7; 200]);
    let outlets = [1.0, 2.0, 3.0].map(|v| vec![v; 200]);
    r.pump_outlet_pressure_pa = outlets.to_vec();
    let found = Record::new(&well, &prepared, &[]);
    assert!(found.flow[50..60].iter().all(|v| v.is_nan()));
    for i in 50..60 {
        let line = 0.04 + 0.011 * (i - 49) as f64 / 11.0;
        assert!((found.filled.flow[i] - line).abs() < 1e-12);
    }
    assert!(found.speed[100].is_nan() && found.filled.speed[100] == 70.0);
    let pumping = (0..200).map(|i| i >= 90);
    assert!(pumping.eq(found.filled.pumping.iter().copied()));
    assert_eq!(found.riser, Some(vec![1e7; 200]));
    assert_eq!(found.outlets, outlets[..2]);
    assert_eq!(found.filled.booster, record.booster);
    assert_eq!(bridged(&[f64::NAN; 3]), [0.0; 3]);
}

#[test]
fn means_and_tails_are_of_what_is_finite() {
    assert_eq!(mean(&[1.0, f64::NAN, 4.0, f64::INFINITY]), 2.5);
    assert!(mean(&[f64::NAN]).is_nan() && mean(&[]).is_nan());
    let values: Vec<f64> = (0..100).map(f64::from).chain([f64::NAN]).collect();
    assert_eq!(tails(&values, 20), Some((5.0, 94.0)));
    assert_eq!(tails(&[f64::NAN], 20), None);
    assert_eq!([2.5, 2.4, -3.0, f64::NAN].map(whole), [3, 2, 0, 0]);
}

#[test]
fn a_channel_that_is_logged_now_and_then_has_straight_lines_between_and_none_over_gaps() {
    let every = |step: usize, n: usize| -> Vec<f64> {
        let value = |i: usize| {
            if i.is_multiple_of(step) {
                i as f64
            } else {
                f64::NAN
            }
        };
        (0..n).map(value).collect()
    };
    let mut values = every(5, 400);
    values[101..200].fill(f64::NAN);
    let slow = |step_s: f64| Slow {
        step_s,
        held_at: Vec::new(),
    };
    assert_eq!(slow(1.0).every_s(&values), Some(5.0));
    let lines = slow(1.0).between(&values).unwrap();
    for (i, value) in lines.iter().enumerate() {
        let missing = (101..200).contains(&i) || i > 395;
        assert_eq!(value.is_finite(), !missing, "{i}");
        assert!(missing || (value - i as f64).abs() < 1e-9, "{i} {value}");
    }
    // At fewer than 19 samples of 20, and at least every half a minute.
    for (values, step_s) in [
        (every(1, 300), 1.0),
        (every(40, 4000), 1.0),
        (every(5, 300), 10.0),
        (vec![f64::NAN; 300], 1.0),
        (every(500, 500), 1.0),
    ] {
        assert_eq!(slow(step_s).between(&values), None);
        assert_eq!(slow(step_s).every_s(&values), None);
    }
    // One, two and five seconds apart, eight seconds in eight: joined but over what is longer than six.
    let mut at = 0;
    let mut rows = vec![f64::NAN; 400];
    for apart in [1, 1, 2, 5].into_iter().cycle() {
        if at >= rows.len() {
            break;
        }
        rows[at] = at as f64;
        at += apart;
    }
    rows[200..208].fill(f64::NAN);
    let every_s = slow(1.0).every_s(&rows).unwrap();
    assert!((every_s - 2.25).abs() < 0.1, "{every_s}");
    let lines = slow(1.0).between(&rows).unwrap();
    let missing: Vec<usize> = (0..390).filter(|i| !lines[*i].is_finite()).collect();
    assert!(
        missing.len() > 6 && missing.iter().all(|i| (195..212).contains(i)),
        "{missing:?}"
    );
    // What is missing for another reason is not logged seldom: the first half here.
    for hole in [0..600, 200..800] {
        let mut half = every(1, 1000);
        half[hole].fill(f64::NAN);
        assert_eq!(slow(1.0).every_s(&half), None);
    }
}

/// However the working clock lies to it: what is every 3 s in seconds is two samples of three on a clock of 2 s.
#[test]
fn a_slow_channel_is_whole_on_the_working_clock_whether_it_is_missing_or_held_in_between() {
    let noise = crate::test_rig::normals(7, 1201);
    for every in 2..=10 {
        for held in [false, true] {
            let (well, mut prepared) = counted(1201, 1.0);
            let reading = |i: usize| 50.0 + 0.2 * noise[i - i % every];
            let flow = &mut prepared.recording.return_flow_m3_s;
            for (i, q) in flow.iter_mut().enumerate() {
                let read = held || i % every == 0;
                *q = if read { reading(i) } else { f64::NAN };
            }
            let record = Record::new(&well, &prepared, &[]);
            assert_eq!(record.seldom, [(Channel::ReturnFlow, every as f64)]);
            let last = 1200 - 1200 % every;
            assert!(
                record.flow[..last / 2].iter().all(|q| q.is_finite()),
                "{every}"
            );
            // Half way between two readings lies their mean.
            let middle = 0.5 * (reading(0) + reading(every));
            assert!((record.flow[0] - reading(0)).abs() <= (middle - reading(0)).abs() + 1e-9);
            // The same noise as that of all samples, for the fewer readings that it is had from.
            let found = record.setting.noise.flow_m3_s / 0.2;
            let times = (every as f64 / 2.0).max(1.0).sqrt();
            assert!((found / times - 1.0).abs() < 0.25, "{every} {found}");
        }
    }
}

#[test]
fn a_set_point_is_read_with_the_others_where_it_moves_with_them_alone() {
    let noise = crate::test_rig::normals(7, 1201);
    for (late, expected) in [(0, true), (1, false)] {
        let (well, mut prepared) = counted(1201, 1.0);
        let r = &mut prepared.recording;
        r.return_flow_m3_s = (0..1201).map(|i| noise[i - i % 5]).collect();
        // It goes up every minute or so, when the others are read or a second later.
        r.pump_speed_pct = (0..1201)
            .map(|i: usize| 60.0 + (i.saturating_sub(late) / 65) as f64)
            .collect();
        let record = Record::new(&well, &prepared, &[]);
        let read = record.seldom.contains(&(Channel::PumpSpeed, 5.0));
        assert_eq!(read, expected);
        // Between two readings lies a line.
        let between = record.filled.speed[31] - 60.0;
        assert_eq!((0.2..0.9).contains(&between), expected, "{between}");
    }
}

#[test]
fn a_reading_tells_something_new_when_its_value_changes_whether_it_is_held_or_missing_until_then() {
    let swings = |i: usize| (0.7 * i as f64).sin();
    let every = |k: usize, held: bool| -> Vec<f64> {
        let value = |i: usize| match i % k {
            0 => swings(i),
            _ if held => swings(i - i % k),
            _ => f64::NAN,
        };
        (0..400).map(value).collect()
    };
    for (k, step_s) in [(1, 1.0), (1, 5.0), (3, 0.5), (10, 1.0)] {
        for held in [true, false] {
            assert_eq!(new_every_s(&every(k, held), step_s), k as f64 * step_s);
        }
    }
    for nothing in [vec![], vec![f64::NAN; 9], vec![2.0; 9]] {
        assert_eq!(new_every_s(&nothing, 1.0), 0.0);
    }
    // The slower of flow and outlet pressure counts.
    let (well, mut prepared) = counted(1200, 1.0);
    let told = |prepared: &Prepared| Record::new(&well, prepared, &[]).told_every_s;
    prepared.outlet_pressure_pa = (0..1200).map(|i| 5e6 + 1e5 * swings(i)).collect();
    assert_eq!(told(&prepared), 2.0);
    prepared.outlet_pressure_pa = (0..1200).map(|i| 5e6 + 1e5 * swings(i - i % 8)).collect();
    assert_eq!(told(&prepared), 8.0);
}

/// One reading in four to ten missing, two in a row now and then, and sixty; with samples one and five seconds apart.
#[test]
fn what_is_missing_here_and_there_lies_on_lines_and_what_is_missing_for_long_stays() {
    for (step_s, every) in [(1.0, 4), (1.0, 7), (1.0, 10), (5.0, 4), (5.0, 10)] {
        let (well, mut prepared) = counted(1201, step_s);
        let flow = &mut prepared.recording.return_flow_m3_s;
        for (i, q) in flow.iter_mut().enumerate() {
            let lost = i % every == 3 || i % 100 == 80 || (302..362).contains(&i);
            *q = if lost { f64::NAN } else { 50.0 + i as f64 };
        }
        let record = Record::new(&well, &prepared, &[]);
        let fold = crate::numbers::whole(record.dt_s / step_s);
        let lasts = 302 / fold..362 / fold;
        for (k, q) in record.flow.iter().enumerate().take(1190 / fold) {
            if lasts.contains(&k) {
                assert!(q.is_nan(), "{step_s} s: {k}");
            } else {
                let middle = 50.0 + (fold * k) as f64 + 0.5 * (fold as f64 - 1.0);
                assert!((q - middle).abs() < 1e-9, "{step_s} s: {k} {q} {middle}");
            }
        }
    }
}
