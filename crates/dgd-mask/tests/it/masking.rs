use crate::rig::Rig;
use dgd_identify::{Prepared, Series};
use dgd_mask::{MaskedRecording, MaskingError, choose_references, mask_recording};
use dgd_recording::Recording;

fn masked(rig: &Rig) -> MaskedRecording {
    let (prepared, series) = rig.voyage();
    mask_recording(&prepared, &series, &rig.references()).unwrap()
}

/// Asserts that `pct` is `si` in percent of `reference`, but for noise of this standard deviation.
fn assert_percent(pct: &[f64], si: &[f64], reference: f64, noise: f64) {
    assert_eq!(pct.len(), si.len());
    let off: Vec<f64> = pct
        .iter()
        .zip(si)
        .map(|(p, v)| p / 100.0 * reference - v)
        .collect();
    let largest = off.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    assert!(largest < 6.0 * noise, "{largest} of {noise}");
    let root = (off.iter().map(|v| v * v).sum::<f64>() / off.len() as f64).sqrt();
    // The slow components have few draws in a recording this short.
    assert!(
        (0.7 * noise..1.4 * noise).contains(&root),
        "{root} of {noise}"
    );
}

#[test]
fn what_is_of_another_length_is_refused_by_its_name() {
    let rig = Rig::default();
    let (prepared, series) = rig.voyage();
    let mut short = series.clone();
    short.head_m.pop();
    let error = mask_recording(&prepared, &short, &rig.references()).unwrap_err();
    assert!(error.to_string().contains("`head_m`"), "{error}");
    let mut cut = prepared.clone();
    cut.recording.time_s.pop();
    let error = mask_recording(&cut, &series, &rig.references()).unwrap_err();
    assert!(matches!(error, MaskingError::Prepared(_)), "{error}");
}

#[test]
fn every_channel_is_a_percentage_of_its_reference_but_for_a_little_noise() {
    let rig = Rig::default();
    let (prepared, series) = rig.voyage();
    let masked = masked(&rig);
    let [flow, friction, head, level] = rig.references().disclose();
    let recording = &prepared.recording;
    // Seven components of 0.05 % each.
    let share = 5e-4 * 7f64.sqrt();
    assert_percent(
        &masked.return_flow_pct,
        &recording.return_flow_m3_s,
        flow,
        share * flow,
    );
    assert_percent(
        &masked.inflow_pct,
        &recording.inflow_m3_s(),
        flow,
        share * flow,
    );
    // Of a pressure it is a share of what the level's reference weighs.
    let (noise_m, weight_pa_m) = (share * level, rig.well().weight_pa_m());
    let noise_pa = noise_m * weight_pa_m;
    assert_percent(
        &masked.friction_pct,
        &series.friction_pa,
        friction,
        noise_pa,
    );
    assert_percent(&masked.level_pct, &series.level_m, level, noise_m);
    let both_m = 2f64.sqrt() * noise_m;
    assert_percent(&masked.head_pct, &series.head_m, head, both_m);
    assert_eq!(masked.pump_speed_pct, recording.pump_speed_pct);
}

#[test]
fn time_starts_at_zero_and_says_no_time_of_day() {
    let rig = Rig::default();
    let (mut prepared, series) = rig.voyage();
    prepared
        .recording
        .time_s
        .iter_mut()
        .for_each(|t| *t += 45_296.0);
    let masked = mask_recording(&prepared, &series, &rig.references()).unwrap();
    assert_eq!(masked.time_s[..3], [0.0, 1.0, 2.0]);
}

#[test]
fn the_same_recording_is_masked_the_same_and_another_is_not() {
    let rig = Rig::default();
    assert_eq!(masked(&rig), masked(&rig));
    let (mut prepared, series) = rig.voyage();
    let chosen = choose_references(&prepared, &series).unwrap();
    assert_eq!(choose_references(&prepared, &series).unwrap(), chosen);
    prepared.recording.pump_speed_pct[17] += 0.1;
    assert_ne!(choose_references(&prepared, &series).unwrap(), chosen);
}

/// A recording of exact numbers, and four quantities beside it.
fn exact() -> (Prepared, Series) {
    let row = |n: i32, of: i32| -> Vec<f64> {
        let at = |i: i32| f64::from(i * n % of);
        (0..64).map(at).collect()
    };
    let recording = Recording {
        time_s: (0..64).map(f64::from).collect(),
        mud_pump_flow_m3_s: row(3, 7),
        booster_flow_m3_s: row(5, 11),
        topfill_flow_m3_s: row(2, 3),
        return_flow_m3_s: row(7, 13),
        pump_inlet_pressure_pa: vec![row(11, 17)],
        pump_outlet_pressure_pa: vec![row(13, 19)],
        riser_pressure_pa: None,
        pump_speed_pct: row(17, 23),
    };
    let series = Series {
        level_m: row(19, 29),
        friction_pa: row(23, 31),
        head_m: row(29, 37),
    };
    let prepared = Prepared {
        keep: vec![true; 64],
        step_s: 1.0,
        inlet_pressure_pa: row(11, 17),
        outlet_pressure_pa: row(13, 19),
        tally: Vec::new(),
        stuck: Vec::new(),
        dropouts: Vec::new(),
        recording,
    };
    (prepared, series)
}

/// Pinned: another draw would make a rig's next recording incomparable with those shared before.
#[test]
fn the_draw_of_the_references_is_pinned_to_the_last_bit() {
    let (prepared, series) = exact();
    let chosen = choose_references(&prepared, &series).unwrap().disclose();
    let expected: [f64; 4] = [
        13.856_510_505_430_741,
        33.535_844_513_601_134,
        40.312_031_342_925_28,
        35.478_082_483_722_87,
    ];
    assert_eq!(chosen.map(f64::to_bits), expected.map(f64::to_bits));
}

#[test]
fn references_exceed_the_largest_kept_value_by_5_to_60_percent() {
    let (mut prepared, mut series) = Rig::default().voyage();
    // A rejected spike must not set the scale.
    prepared.keep[100] = false;
    series.level_m[100] = 9e9;
    let chosen = choose_references(&prepared, &series).unwrap().disclose();
    let largest = |values: &[f64]| {
        let kept = values.iter().zip(&prepared.keep).filter(|(_, k)| **k);
        kept.map(|(v, _)| *v).fold(0.0, f64::max)
    };
    let expected = [
        largest(&prepared.recording.return_flow_m3_s),
        largest(&series.friction_pa),
        largest(&series.head_m),
        largest(&series.level_m),
    ];
    for (reference, largest) in chosen.iter().zip(expected) {
        assert!((1.05..1.6).contains(&(reference / largest)));
    }
}

#[test]
fn a_missing_value_stays_missing_and_shifts_nothing_else() {
    let rig = Rig::default();
    let whole = masked(&rig);
    let (prepared, mut series) = rig.voyage();
    series.friction_pa[10] = f64::NAN;
    let holed = mask_recording(&prepared, &series, &rig.references()).unwrap();
    assert!(holed.friction_pct[10].is_nan());
    assert_eq!(holed.friction_pct[11..], whole.friction_pct[11..]);
}

#[test]
fn what_no_usable_sample_shows_is_blanked() {
    // A dead inlet transmitter reads as a riser that is full to the pump; the outlet at full scale as much friction.
    let rig = Rig::default();
    let (mut prepared, mut series) = rig.voyage();
    for (i, level_m, friction_pa) in [(5, 700.0, 1e5), (6, 150.0, 9e6), (7, -60.0, 1e5)] {
        prepared.keep[i] = false;
        series.level_m[i] = level_m;
        series.friction_pa[i] = friction_pa;
    }
    // Full scale of a meter, not twice the reference.
    prepared.recording.return_flow_m3_s[8] = 1.5 * rig.references().disclose()[0];
    prepared.keep[8] = false;
    let masked = mask_recording(&prepared, &series, &rig.references()).unwrap();
    let told = |values: &[f64]| {
        values[5..9]
            .iter()
            .map(|v| v.is_finite())
            .collect::<Vec<_>>()
    };
    assert_eq!(told(&masked.level_pct), [false, true, false, true]);
    assert_eq!(told(&masked.friction_pct), [true, false, true, true]);
    assert_eq!(told(&masked.return_flow_pct), [true, true, true, false]);
}

#[test]
fn a_meter_at_its_full_scale_is_blanked() {
    let rig = Rig::default();
    let (mut prepared, series) = rig.voyage();
    prepared.recording.mud_pump_flow_m3_s[5] = 2.1 * rig.references().disclose()[0];
    let masked = mask_recording(&prepared, &series, &rig.references()).unwrap();
    assert!(masked.inflow_pct[5].is_nan());
    assert!(masked.inflow_pct[6].is_finite());
}

#[test]
fn a_full_scale_just_above_the_usable_range_is_blanked() {
    let rig = Rig::default();
    let (mut prepared, series) = rig.voyage();
    let kept = |prepared: &dgd_identify::Prepared| {
        let flows = prepared.recording.return_flow_m3_s.iter();
        let kept = flows.zip(&prepared.keep).filter(|(_, keep)| **keep);
        kept.fold(0.0f64, |most, (flow, _)| most.max(*flow))
    };
    for i in 20..30 {
        prepared.keep[i] = false;
    }
    let most = kept(&prepared);
    prepared.recording.return_flow_m3_s[20..30].fill(most * 1000.0 / 960.0);
    prepared.recording.return_flow_m3_s[29] = most;
    let masked = mask_recording(&prepared, &series, &rig.references()).unwrap();
    let plateau = &masked.return_flow_pct[20..29];
    assert!(plateau.iter().all(|v| v.is_nan()), "{plateau:?}");
    assert!(masked.return_flow_pct[29].is_finite());
}

#[test]
fn a_quantity_that_is_nowhere_positive_is_refused_by_name() {
    let (prepared, series) = Rig::default().voyage();
    let refused = |f: &dyn Fn(&mut dgd_identify::Prepared, &mut dgd_identify::Series)| {
        let (mut prepared, mut series) = (prepared.clone(), series.clone());
        f(&mut prepared, &mut series);
        match choose_references(&prepared, &series) {
            Err(MaskingError::NothingPositive { quantity }) => quantity,
            other => panic!("{other:?}"),
        }
    };
    let zero = |values: &mut Vec<f64>| values.iter_mut().for_each(|v| *v = -1.0);
    assert_eq!(
        refused(&|p, _| zero(&mut p.recording.return_flow_m3_s)),
        "return flow"
    );
    assert_eq!(refused(&|_, s| zero(&mut s.friction_pa)), "friction");
    assert_eq!(refused(&|_, s| zero(&mut s.head_m)), "pump head");
    assert_eq!(refused(&|_, s| zero(&mut s.level_m)), "riser level");
    assert_eq!(refused(&|p, _| p.keep.fill(false)), "return flow");
}

#[test]
fn a_reference_that_is_not_finite_is_refused_without_its_value() {
    let (prepared, mut series) = Rig::default().voyage();
    series.head_m[3] = f64::INFINITY;
    let error = choose_references(&prepared, &series).unwrap_err();
    assert!(matches!(error, MaskingError::Reference(_)));
    assert_eq!(
        error.to_string(),
        "the head reference must be a positive finite number"
    );
}

#[test]
fn references_are_in_no_debug_output() {
    let (prepared, series) = Rig::default().voyage();
    let chosen = choose_references(&prepared, &series).unwrap();
    for shown in [
        format!("{chosen:?}"),
        format!("{chosen:#?}"),
        format!("{:?}", Some(&chosen)),
    ] {
        assert!(!shown.contains(|c: char| c.is_ascii_digit()), "{shown}");
    }
}
