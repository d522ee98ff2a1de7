use crate::rig::Rig;
use dgd_mask::{MaskedRecording, MaskingError, choose_references, mask_recording};

fn masked(rig: &Rig) -> MaskedRecording {
    let (prepared, series) = rig.voyage();
    mask_recording(&prepared, &series, &rig.references())
}

/// Asserts that `pct` is `si` in percent of `reference`, to within `half_step` of the same unit.
fn assert_percent(pct: &[f64], si: &[f64], reference: f64, half_step: f64) {
    assert_eq!(pct.len(), si.len());
    let mut sum = 0.0;
    for (p, v) in pct.iter().zip(si) {
        let off = p / 100.0 * reference - v;
        assert!(
            off.abs() <= half_step * (1.0 + 1e-9),
            "{off} of {half_step}"
        );
        sum += off;
    }
    // Uniform noise of n draws has the standard error 2h/sqrt(12 n); five of them.
    let error = 2.0 * half_step / (12.0 * si.len() as f64).sqrt();
    assert!((sum / si.len() as f64).abs() < 5.0 * error);
}

#[test]
fn every_channel_is_a_percentage_of_its_reference_to_half_a_step() {
    let rig = Rig::default();
    let (prepared, series) = rig.voyage();
    let masked = masked(&rig);
    let [flow, friction, head, level] = rig.references().disclose();
    let recording = &prepared.recording;
    let half_flow = rig.flow_step_m3_s / 2.0;
    assert_percent(
        &masked.return_flow_pct,
        &recording.return_flow_m3_s,
        flow,
        half_flow,
    );
    // Three meters, three half steps.
    assert_percent(
        &masked.inflow_pct,
        &recording.inflow_m3_s(),
        flow,
        3.0 * half_flow,
    );
    let half_m = 345.0 / rig.well().weight_pa_m();
    assert_percent(&masked.friction_pct, &series.friction_pa, friction, 345.0);
    assert_percent(&masked.level_pct, &series.level_m, level, half_m);
    assert_percent(&masked.head_pct, &series.head_m, head, 2.0 * half_m);
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
    let masked = mask_recording(&prepared, &series, &rig.references());
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
    let holed = mask_recording(&prepared, &series, &rig.references());
    assert!(holed.friction_pct[10].is_nan());
    assert_eq!(holed.friction_pct[11..], whole.friction_pct[11..]);
}

#[test]
fn a_meter_at_its_full_scale_is_blanked() {
    let rig = Rig::default();
    let (mut prepared, series) = rig.voyage();
    prepared.recording.mud_pump_flow_m3_s[5] = 2.1 * rig.references().disclose()[0];
    let masked = mask_recording(&prepared, &series, &rig.references());
    assert!(masked.inflow_pct[5].is_nan());
    assert!(masked.inflow_pct[6].is_finite());
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
