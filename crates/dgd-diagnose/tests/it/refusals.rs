//! What cannot be diagnosed is refused with a reason.

use super::rig::{case, recorded, screened, tried};
use dgd_diagnose::{DiagnoseError, Options, diagnose};
use dgd_effects::AppliedEffect;
use dgd_identify::Prepared;
use dgd_recording::{Recording, Well};

fn clean() -> (Well, Recording, f64) {
    recorded(&case(303, None))
}

fn channels(recording: &mut Recording) -> Vec<&mut Vec<f64>> {
    let mut out = vec![
        &mut recording.mud_pump_flow_m3_s,
        &mut recording.booster_flow_m3_s,
        &mut recording.topfill_flow_m3_s,
        &mut recording.return_flow_m3_s,
        &mut recording.pump_speed_pct,
    ];
    out.extend(&mut recording.pump_inlet_pressure_pa);
    out.extend(&mut recording.pump_outlet_pressure_pa);
    out.extend(&mut recording.riser_pressure_pa);
    out
}

#[test]
fn a_recording_of_any_length_below_half_an_hour_is_refused() {
    let (well, recording, step_s) = clean();
    for samples in [1, 2, 9, 10, 11, 59, 119, 300, 601, 1199, 1800] {
        let error = tried(&well, recording.slice(3000..3000 + samples), step_s).unwrap_err();
        let DiagnoseError::TooShort {
            blocks,
            needed,
            block_s,
        } = error
        else {
            panic!("{samples} samples: {error}");
        };
        assert_eq!((needed, block_s), (190, 10.0));
        assert!(
            blocks <= samples.div_ceil(10),
            "{blocks} blocks in {samples} samples"
        );
    }
}

#[test]
fn the_message_tells_how_much_can_be_used() {
    let (well, recording, step_s) = clean();
    let mut standing = recording.slice(0..5400);
    standing.pump_speed_pct.fill(0.0);
    standing.return_flow_m3_s.fill(0.0);
    let error = tried(&well, standing, step_s).unwrap_err();
    assert_eq!(
        error.to_string(),
        "flow and pressures can be used in 0 of 540 blocks of 10 s, a diagnosis needs 60 besides its held-out windows: check what the screening rejects, or record for longer"
    );
}

#[test]
fn a_storm_of_gaps_is_refused_or_names_nothing_that_is_not_there() {
    let (well, recording, step_s) = clean();
    let recording = recording.slice(0..5400);
    let storm = |values: &mut Vec<f64>, salt: usize, lost: usize| {
        for (i, v) in values.iter_mut().enumerate() {
            if (i + salt).wrapping_mul(2_654_435_761) % 65_536 < lost {
                *v = f64::NAN;
            }
        }
    };
    let everywhere = |lost: usize| {
        let mut all = recording.clone();
        for (salt, values) in channels(&mut all).into_iter().enumerate() {
            storm(values, 7919 * salt, lost);
        }
        tried(&well, all, step_s)
    };
    // A value in twelve: as where a historian writes what changes. A value in sixty-five is too few.
    let found = everywhere(60_000).unwrap();
    assert!(found.findings.is_empty(), "{:?}", found.findings);
    let refused = everywhere(64_500);
    assert!(matches!(refused, Err(DiagnoseError::TooFew { .. })));
    // In one channel alone the rest may carry the diagnosis, or not: it does not panic, and never names anything
    // in a clean recording.
    for k in 0..channels(&mut recording.clone()).len() {
        let mut one = recording.clone();
        storm(channels(&mut one)[k], 0, 60_000);
        if let Ok(found) = tried(&well, one, step_s) {
            assert!(
                found.findings.is_empty(),
                "channel {k}: {:?}",
                found.findings
            );
        }
    }
}

#[test]
fn a_clock_in_another_unit_is_refused_before_any_work() {
    let (well, recording, _) = clean();
    for step_s in [61.0, 86_400.0, 1e6, 1e9, 1e12] {
        let mut slow = recording.slice(0..3000);
        slow.time_s = (0..3000).map(|i| f64::from(i) * step_s).collect();
        let error = tried(&well, slow, step_s).unwrap_err();
        assert_eq!(error, DiagnoseError::Step { step_s });
        assert!(error.to_string().contains("unit of the time"), "{error}");
    }
    let prepared = screened(recording, 1.0);
    for step_s in [0.0, -1.0, f64::NAN] {
        let other = Prepared {
            step_s,
            ..prepared.clone()
        };
        let refused = diagnose(&well, &other, &Options::default(), &mut |_| {});
        assert!(matches!(refused, Err(DiagnoseError::Prepared(_))));
    }
}

#[test]
fn what_was_screened_and_does_not_belong_together_is_refused_by_name() {
    let (well, recording, step_s) = clean();
    let prepared = screened(recording, step_s);
    let refused = |name: &str, cut: &dyn Fn(&mut Prepared)| {
        let mut short = prepared.clone();
        cut(&mut short);
        let error = diagnose(&well, &short, &Options::default(), &mut |_| {}).unwrap_err();
        assert!(error.to_string().contains(name), "{name}: {error}");
        let fitted = dgd_identify::identify(&short, &well, &Default::default()).unwrap_err();
        assert_eq!(fitted.to_string(), error.to_string());
    };
    refused("`keep`", &|p| p.keep.truncate(50));
    refused("`inlet_pressure_pa`", &|p| p.inlet_pressure_pa.truncate(50));
    refused("`outlet_pressure_pa`", &|p| p.outlet_pressure_pa.push(1e5));
    for k in 0..channels(&mut prepared.recording.clone()).len() {
        refused("samples, expected", &|p| {
            channels(&mut p.recording)[k].truncate(50);
        });
    }
    refused("samples, expected", &|p| p.recording.time_s.truncate(50));
}

#[test]
fn a_well_that_cannot_be_is_refused_by_the_number() {
    let (well, recording, step_s) = clean();
    let prepared = screened(recording, step_s);
    let refused = |name: &str, spoil: &dyn Fn(&mut Well)| {
        let mut other = well.clone();
        spoil(&mut other);
        let error = diagnose(&other, &prepared, &Options::default(), &mut |_| {}).unwrap_err();
        assert!(matches!(error, DiagnoseError::Well(_)), "{error}");
        assert!(error.to_string().contains(name), "{error}");
        assert!(dgd_identify::identify(&prepared, &other, &Default::default()).is_err());
    };
    refused("`mud_density_kg_m3`", &|w| w.mud_density_kg_m3 = f64::NAN);
    refused("`pump_inlet_depth_m`", &|w| {
        w.geometry.pump_inlet_depth_m = 0.0
    });
    refused("`booster_line_id_m`", &|w| {
        w.geometry.booster_line_id_m = Some(-0.1)
    });
    refused("`drillpipe_od_m`", &|w| {
        w.geometry.drillpipe_od_m = w.geometry.riser_id_m;
    });
    let options = Options {
        most_effects: 0,
        ..Options::default()
    };
    let error = diagnose(&well, &prepared, &options, &mut |_| {}).unwrap_err();
    assert_eq!(error, DiagnoseError::NoEffects);
}

#[test]
fn nothing_but_gaps_or_constants_is_refused() {
    let (well, recording, step_s) = clean();
    for value in [f64::NAN, 0.0, 1.0] {
        let mut flat = recording.slice(0..5400);
        channels(&mut flat).into_iter().for_each(|v| v.fill(value));
        let refused = tried(&well, flat, step_s);
        assert!(
            matches!(refused, Err(DiagnoseError::TooFew { .. })),
            "{value}"
        );
    }
}

#[test]
fn a_start_from_an_effect_that_is_not_known_is_refused_by_name() {
    let (well, recording, step_s) = clean();
    let prepared = screened(recording.slice(0..3600), step_s);
    for (id, parameters) in [("poltergeist", vec![1.0]), ("influx", vec![1e-3])] {
        let options = Options {
            start: vec![AppliedEffect {
                id: id.to_owned(),
                parameters,
            }],
            ..Options::default()
        };
        let error = diagnose(&well, &prepared, &options, &mut |_| {}).unwrap_err();
        assert!(matches!(error, DiagnoseError::UnknownEffect(_)));
        assert!(error.to_string().contains(id), "{error}");
    }
}

#[test]
fn a_suspect_that_the_catalogue_does_not_hold_is_refused_with_what_it_holds() {
    let (well, recording, step_s) = clean();
    let prepared = screened(recording, step_s);
    let options = Options {
        suspects: vec!["gremlins".to_owned()],
        ..Options::default()
    };
    let error = diagnose(&well, &prepared, &options, &mut |_| {}).unwrap_err();
    let said = error.to_string();
    assert!(matches!(error, DiagnoseError::NotInCatalogue { .. }));
    assert!(
        said.contains("`gremlins`") && said.contains("gas_in_pump"),
        "{said}"
    );
}
