//! The writers and the words, on a diagnosis made by hand.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{
    DIAGNOSIS, MODEL, REPORT, SIMULATION, Search, at_seams, beyond_two, command, tell, write,
};
use crate::args::{Source, Window};
use crate::commands::carried::effects_here;
use crate::failure::Failure;
use dgd_diagnose::{
    Check, CorrectionCurve, Diagnosis, Finding, HeldOut, Outcome, ParameterEstimate, Signal,
    Simulation, Step, Tested, Verdict, Work,
};
use dgd_documents::{Base, ModelDocument, read_model_document};
use dgd_effects::{
    AppliedEffect, AugmentedModel, Curves, FRICTION_TERMS, HEAD_TERMS, Noise, Relation, Scale,
    Setting, find,
};
use dgd_recording::{Geometry, Moment, Recording};
use std::path::Path;

const GEOMETRY: Geometry = Geometry {
    riser_id_m: 0.495,
    drillpipe_od_m: 0.168,
    casing_od_m: None,
    return_line_id_m: 0.152,
    booster_line_id_m: None,
    pump_inlet_depth_m: 350.0,
    pump_outlet_depth_m: 350.0,
    riser_pressure_sensor_depth_m: None,
};

fn base() -> Base {
    Base::WellOnly {
        density_kg_m3: 1080.0,
        geometry: GEOMETRY,
    }
}

fn kick() -> Finding {
    Finding {
        effect: "influx".into(),
        resembles: None,
        title: "formation fluid enters the well".into(),
        probability: 0.97,
        alternatives: vec![("line_leak".into(), 0.02)],
        relation: Relation::RiserMassBalance,
        shows_in: vec![Relation::RiserMassBalance],
        pair: None,
        intervals_s: vec![(10.0, 22.0)],
        region: "at every flow".into(),
        parameters: vec![ParameterEstimate {
            name: "rate_m3_s".into(),
            meaning: "plateau rate".into(),
            estimate: 0.0021,
            ci95: (0.0019, 0.0023),
        }],
        curve: None,
        held_out: Some(HeldOut {
            signal: "riser_level_m".into(),
            rmse_before: 1.9,
            rmse_after: 0.12,
            improvement_ci95: (0.9, 0.95),
        }),
        equation_before: "A dh/dt = q_in - q".into(),
        equation_after: "A dh/dt = q_in + rate s(t) - q".into(),
        source: "Eq. 3.45".into(),
        evidence: 100.0,
        hurdle: 9.0,
        separating_test: Some("a flow check".into()),
        same_as: None,
    }
}

fn diagnosis(findings: Vec<Finding>) -> Diagnosis {
    let applied = |finding: &Finding| AppliedEffect {
        id: finding.effect.clone(),
        parameters: (find(&finding.effect).unwrap().about().parameters.iter())
            .map(|p| p.usual)
            .collect(),
    };
    let before = AugmentedModel {
        curves: Curves {
            scale: Scale {
                flow_m3_s: 0.06,
                speed_pct: 55.0,
                laminar: None,
            },
            friction: [1.0; FRICTION_TERMS],
            head: [2.0; HEAD_TERMS],
        },
        speed_range_pct: (20.0, 80.0),
        ratio_range: (0.0, 0.001),
        span_s: None,
        inlet_range_pa: None,
        effects: Vec::new(),
    };
    let after = AugmentedModel {
        effects: findings.iter().map(applied).collect(),
        ..before.clone()
    };
    let held_out: Vec<bool> = (0..30).map(|i| i >= 20).collect();
    let signal = |name| Signal {
        name,
        measured: vec![1.0; 30],
        before: vec![1.5; 30],
        after: (0..30)
            .map(|i| if i < 5 { f64::NAN } else { 1.25 })
            .collect(),
    };
    Diagnosis {
        verdict: if findings.is_empty() {
            Verdict::Consistent
        } else {
            Verdict::Explained
        },
        findings,
        started_from: Vec::new(),
        suspected: Vec::new(),
        tested: vec![
            Tested {
                effect: "heave",
                title: "rig motion",
                outcome: Outcome::NotSeen,
                evidence: -3.0,
                admissible: true,
                hurdle: 12.0,
                strength: "amplitude_pa",
                standard_error: None,
                limit: Some(900.0),
            },
            Tested {
                effect: "gel_strength",
                title: "gel",
                outcome: Outcome::NotTestable("the mud never stood".into()),
                evidence: 0.0,
                admissible: true,
                hurdle: 12.0,
                strength: "tau_gel_pa",
                standard_error: None,
                limit: None,
            },
        ],
        warnings: Vec::new(),
        checks: vec![Check {
            name: "placebo".into(),
            passed: false,
            detail: "gains 4 %".into(),
        }],
        before,
        after,
        setting: Setting {
            density_kg_m3: 1080.0,
            riser_area_m2: 0.17,
            line_area_m2: 0.018,
            line_diameter_m: 0.152,
            line_length_m: 350.0,
            riser_volume_m3: 30.0,
            span_s: (0.0, 30.0),
            inlet_range_pa: (2e6, 3e6),
            outlets: 2,
            connections: Vec::new(),
            noise: Noise::default(),
        },
        simulation: Simulation {
            t_s: (0..30).map(f64::from).collect(),
            held_out,
            valid: vec![true; 30],
            signals: [
                "return_flow_m3_s",
                "riser_level_m",
                "pump_outlet_pressure_pa",
                "pump_head_m",
            ]
            .map(signal)
            .to_vec(),
        },
        traces: Vec::new(),
        held_out_s: vec![(20.0, 29.0)],
        began: None,
        settings: Vec::new(),
        work: Work::default(),
    }
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

#[test]
fn the_four_files_are_written_and_the_model_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new");
    let diagnosis = diagnosis(vec![kick()]);
    let json = write(&diagnosis, base(), "<html/>", &out).unwrap();
    let mut names: Vec<String> = std::fs::read_dir(&out)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, [DIAGNOSIS, MODEL, REPORT, SIMULATION]);
    assert_eq!(text(&out, DIAGNOSIS), json);
    assert_eq!(text(&out, REPORT), "<html/>");
    let (document, warnings) = read_model_document(&text(&out, MODEL)).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(document.augmented, Some(diagnosis.after));
    let csv = text(&out, SIMULATION);
    let mut lines = csv.lines();
    assert_eq!(
        lines.next().unwrap(),
        "t_s,held_out,valid,\
         return_flow_m3_s_measured,return_flow_m3_s_before,return_flow_m3_s_after,\
         riser_level_m_measured,riser_level_m_before,riser_level_m_after,\
         pump_outlet_pressure_pa_measured,pump_outlet_pressure_pa_before,pump_outlet_pressure_pa_after,\
         pump_head_m_measured,pump_head_m_before,pump_head_m_after"
    );
    assert_eq!(lines.next(), Some("0,0,1,1,1.5,,1,1.5,,1,1.5,,1,1.5,"));
    assert_eq!(
        lines.next_back(),
        Some("29,1,1,1,1.5,1.25,1,1.5,1.25,1,1.5,1.25,1,1.5,1.25")
    );
    assert_eq!(csv.lines().count(), 31);
}

#[test]
fn if_one_file_cannot_be_written_the_others_stay_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    std::fs::write(out.join(MODEL), "old").unwrap();
    std::fs::create_dir(out.join(REPORT)).unwrap();
    let failed = write(&diagnosis(vec![kick()]), base(), "", out).unwrap_err();
    assert!(matches!(failed, Failure::Write { .. }), "{failed}");
    assert_eq!(text(out, MODEL), "old");
    // No file under a final or a hidden name has come.
    assert_eq!(std::fs::read_dir(out).unwrap().count(), 2);
}

#[test]
fn a_finding_is_told_first_and_then_with_its_numbers() {
    let told = tell::tell(
        &diagnosis(vec![kick()]),
        &[("two-state model: pump".into(), "head c0 w^1.80".into())],
        "rig.mat",
        Path::new("out"),
    );
    assert!(
        told.contains("\ntwo-state model: pump: head c0 w^1.80\n"),
        "{told}"
    );
    assert!(
        told.starts_with(
            "rig.mat: explained, formation fluid enters the well\n\
             free run over 0.0025 h held out: riser level error 1.9 m without, 0.12 m with it\n\n1. "
        ),
        "{told}"
    );
    for part in [
        "1. formation fluid enters the well (influx), probability 0.97",
        "rate 126 [114, 138] L/min",
        "riser_mass_balance, 10 to 22 s",
        "line_leak 0.020",
        "a flow check",
        "90 to 95 % less",
        "tested 2 effects: 0 found, 1 not seen, 1 not testable on this recording",
        "gel_strength: the mud never stood",
        "failed: placebo: gains 4 %",
        "open out/report.html",
    ] {
        assert!(told.contains(part), "`{part}` is not in:\n{told}");
    }
}

#[test]
fn a_correction_is_told_by_what_its_curve_spans() {
    let correction = Finding {
        parameters: Vec::new(),
        curve: Some(CorrectionCurve {
            along: "pump_speed_pct",
            adds: "correction_fraction",
            knots: vec![(40.0, -0.02), (55.0, 0.01), (70.0, 0.005)],
            level: None,
        }),
        ..kick()
    };
    let told = tell::tell(
        &diagnosis(vec![correction]),
        &[],
        "rig.mat",
        Path::new("out"),
    );
    let size = "   size     correction -2 to 1 % along pump speed, 40 to 70 %\n";
    assert!(told.contains(size), "{told}");
}

#[test]
fn an_episode_is_told_by_its_one_value() {
    let added = [0.0, 0.0, -6e-3, -6e-3, 0.0, 0.0];
    let times = [0.0, 7000.0, 7000.0, 7800.0, 7800.0, 14_400.0];
    let episode = Finding {
        parameters: Vec::new(),
        curve: Some(CorrectionCurve {
            along: "time_s",
            adds: "correction_m3_s",
            knots: times.into_iter().zip(added).collect(),
            level: Some(-6e-3),
        }),
        ..kick()
    };
    let told = tell::tell(&diagnosis(vec![episode]), &[], "rig.mat", Path::new("out"));
    let size = "   size     correction -360 L/min while it acts, else nothing\n";
    assert!(told.contains(size), "{told}");
}

#[test]
fn a_finding_has_dates_where_the_recording_does() {
    let told = |began: Option<&str>| {
        let finding = Finding {
            intervals_s: vec![(4.0, 14.0), (3600.0, 9000.0)],
            ..kick()
        };
        let mut one = diagnosis(vec![finding]);
        one.began = began.and_then(Moment::parse);
        tell::tell(&one, &[], "rig.mat", Path::new("out"))
    };
    let plain = "riser_mass_balance, 4 to 14 s, 3600 to 9000 s\n";
    assert!(told(None).contains(plain), "{}", told(None));
    let dated = told(Some("2024-10-26 22:00"));
    let with_dates = "4 to 14 s (2024-10-26 22:00:04 to 22:00:14), 3600 to 9000 s (2024-10-26 23:00 to 2024-10-27 00:30)\n";
    assert!(dated.contains(with_dates), "{dated}");
}

#[test]
fn a_consistent_recording_is_told_with_what_would_have_been_seen() {
    let told = tell::tell(&diagnosis(Vec::new()), &[], "rig.mat", Path::new("out"));
    let mut lines = told.lines();
    let (first, second) = (lines.next().unwrap(), lines.next().unwrap());
    assert!(
        first.starts_with("rig.mat: consistent, the model leaves out nothing"),
        "{first}"
    );
    assert!(second.contains("riser level 0.5 m"), "{second}");
    assert!(told.contains("heave"), "{told}");
    assert!(told.contains("0.009  bar  amplitude"), "{told}");
    let mut open = diagnosis(Vec::new());
    open.verdict = Verdict::Unexplained;
    let told = tell::tell(&open, &[], "rig.mat", Path::new("out"));
    let first = told.lines().next().unwrap();
    assert!(
        first.starts_with("rig.mat: unexplained") && first.contains("no cause could be identified"),
        "{first}"
    );
    let mut started = diagnosis(Vec::new());
    started.started_from = vec!["influx", "heave"];
    let told = tell::tell(&started, &[], "rig.mat", Path::new("out"));
    let first = told.lines().next().unwrap();
    assert!(
        first.ends_with("starting model (influx, heave); but a check failed, see below"),
        "{first}"
    );
    started
        .checks
        .iter_mut()
        .for_each(|check| check.passed = true);
    let told = tell::tell(&started, &[], "rig.mat", Path::new("out"));
    let first = told.lines().next().unwrap();
    assert!(
        first.ends_with("beyond the effects of the starting model (influx, heave)"),
        "{first}"
    );
    // What makes an output worse is not all there is.
    let mut worse = diagnosis(vec![kick()]);
    worse.verdict = Verdict::PartlyExplained;
    let failing = |name: &str| Check {
        name: name.to_owned(),
        passed: false,
        detail: String::new(),
    };
    let noise = failing("what is left is noise");
    let output = failing("no output is made worse on held-out windows");
    for (checks, says) in [
        (
            vec![output.clone()],
            "partly explained (an output runs worse with it on the held-out windows), ",
        ),
        (
            vec![noise.clone()],
            "partly explained (residual above noise), ",
        ),
        (
            vec![output, noise],
            "partly explained (residual above noise, and an output runs worse with it on the held-out windows), ",
        ),
    ] {
        worse.checks = checks;
        let told = tell::tell(&worse, &[], "rig.mat", Path::new("out"));
        assert!(told.starts_with(&format!("rig.mat: {says}")), "{told}");
    }
}

#[test]
fn a_gain_that_is_none_is_told_as_none() {
    let told = |low, high| {
        let mut finding = kick();
        finding.held_out.as_mut().unwrap().improvement_ci95 = (low, high);
        let told = tell::tell(&diagnosis(vec![finding]), &[], "rig.mat", Path::new("out"));
        let line = told
            .lines()
            .find(|l| l.starts_with("held out: riser"))
            .unwrap();
        line.split_once(" with it: ").unwrap().1.to_owned()
    };
    assert_eq!(told(0.1, 0.25), "10 to 25 % less (95 %)");
    assert_eq!(
        told(-0.002, -0.0),
        "not significant: 0.2 % more to 0 % less (95 %)"
    );
    assert_eq!(
        told(-0.1, 0.02),
        "not significant: 10 % more to 2 % less (95 %)"
    );
    assert_eq!(told(-0.3, -0.04), "4 to 30 % more (95 %)");
}

#[test]
fn what_was_not_suspected_and_stands_out_is_told_where_no_suspect_is_likely() {
    let stands = |effect: &'static str, evidence: f64| Tested {
        effect,
        title: "an effect",
        outcome: Outcome::NotSeen,
        evidence,
        admissible: true,
        hurdle: 12.0,
        strength: "gain",
        standard_error: None,
        limit: None,
    };
    let mut suspected = diagnosis(Vec::new());
    suspected.verdict = Verdict::Unexplained;
    suspected.suspected = vec!["influx".into()];
    let weak = Tested {
        admissible: false,
        ..stands("gel_strength", 90.0)
    };
    suspected.tested = vec![
        stands("line_leak", 40.0),
        stands("inflow_gain", 11.9),
        weak,
        stands("annulus_area", 328.0),
        stands("influx", 50.0),
    ];
    let told = |d: &Diagnosis| tell::tell(d, &[], "rig.mat", Path::new("out"));
    let said = "rig.mat: unexplained, no sign of what was suspected (influx); also standing out: annulus_area (ln BF 328), line_leak (ln BF 40)\n";
    assert!(told(&suspected).starts_with(said), "{}", told(&suspected));
    suspected.findings = vec![Finding {
        probability: 0.08,
        ..kick()
    }];
    let said = "; also standing out: annulus_area (ln BF 328), line_leak (ln BF 40)";
    assert!(told(&suspected).contains(said));
    // Beside a suspect that is likely the others may only look like it.
    suspected.findings = vec![kick()];
    assert!(!told(&suspected).contains("standing out"));
    suspected.findings.clear();
    suspected.suspected.clear();
    assert!(!told(&suspected).contains("standing out"));
}

#[test]
fn a_suspect_that_is_unlikely_is_told_as_one() {
    let unlikely = || Finding {
        probability: 0.08,
        ..kick()
    };
    let mut suspected = diagnosis(vec![unlikely()]);
    suspected.verdict = Verdict::Consistent;
    suspected.suspected = vec!["influx".into()];
    let told = tell::tell(&suspected, &[], "rig.mat", Path::new("out"));
    let said = "rig.mat: consistent, what was suspected is less likely than not: formation fluid";
    assert!(told.starts_with(said), "{told}");
    let said = "looked for influx: 0 found, 1 less likely than not;";
    assert!(told.contains(said) && !told.contains("tested"), "{told}");
    // Swell is told beside, and is none of them.
    suspected.findings.push(Finding {
        effect: "heave".into(),
        ..kick()
    });
    let told = tell::tell(&suspected, &[], "rig.mat", Path::new("out"));
    assert!(told.contains(said), "{told}");
    let one_of_two = diagnosis(vec![kick(), unlikely()]);
    let told = tell::tell(&one_of_two, &[], "rig.mat", Path::new("out"));
    let said = "rig.mat: explained, formation fluid enters the well; what was suspected is less \
                likely than not: formation fluid enters the well\n";
    assert!(told.starts_with(said), "{told}");
}

#[test]
fn windows_in_which_nothing_that_was_found_acts_say_nothing_of_it() {
    let mut early = kick();
    early.intervals_s = vec![(2.0, 20.0)];
    let told = tell::tell(&diagnosis(vec![early]), &[], "rig.mat", Path::new("out"));
    assert!(
        told.contains("\nheld out: no held-out window lies where what was found acts"),
        "{told}"
    );
    assert!(!told.contains("free run over"), "{told}");
}

#[test]
fn what_several_findings_gain_is_told_once_and_of_all_together() {
    let told = tell::tell(
        &diagnosis(vec![kick(), kick(), kick()]),
        &[],
        "rig.mat",
        Path::new("out"),
    );
    assert!(told.contains("enters the well, and 2 more"), "{told}");
    assert_eq!(told.matches("\nheld out: ").count(), 1, "{told}");
    assert_eq!(told.matches("with them").count(), 2, "{told}");
}

#[test]
fn an_effect_that_is_always_there_has_the_whole_recording() {
    let mut always = kick();
    always.intervals_s = vec![(0.0, 30.0)];
    let told = tell::tell(&diagnosis(vec![always]), &[], "rig.mat", Path::new("out"));
    assert!(told.contains("the whole recording"), "{told}");
}

#[test]
fn the_command_in_the_report_names_files_without_their_folders() {
    let source = Source {
        recordings: vec!["/home/me/a.csv".into(), "b.csv".into()],
        well: "wells/w.toml".into(),
        thesis_screening: true,
        window: Some(Window::Clock(600.0, 7200.5)),
    };
    let suspects = ["influx".to_owned(), "line_leak".to_owned()];
    let search = Search {
        model: Some(Path::new("old/model.toml")),
        suspects: &suspects,
        without: &[Step::Edges],
    };
    assert_eq!(
        command(&source, search),
        "dgd diagnose a.csv b.csv --well w.toml --model model.toml --suspect influx,line_leak --without edges \
         --thesis-screening --window 600:7200.5 --out diagnosis"
    );
}

#[test]
fn what_grows_starts_from_what_its_rate_makes_of_it_over_this_recording() {
    let wear = AppliedEffect {
        id: "pump_wear".into(),
        parameters: vec![1e-3],
    };
    let document = ModelDocument {
        base: base(),
        augmented: Some(AugmentedModel {
            span_s: Some((0.0, 1000.0)),
            effects: vec![wear],
            ..diagnosis(Vec::new()).after
        }),
    };
    let start = effects_here(document, &[500.0, 501.0, 3500.0]);
    assert!((start[0].parameters[0] - 3e-3).abs() < 1e-15, "{start:?}");
}

#[test]
fn of_three_transmitters_of_a_side_the_first_two_are_used_and_the_third_is_named() {
    let side = |n: usize| (0..n).map(|k| vec![k as f64]).collect::<Vec<_>>();
    let mut recording = Recording {
        pump_inlet_pressure_pa: side(3),
        pump_outlet_pressure_pa: side(1),
        ..Recording::default()
    };
    let told = beyond_two(&mut recording);
    assert_eq!(told.len(), 1);
    assert!(
        told[0].starts_with("`pump_inlet_pressure 3` is not used"),
        "{told:?}"
    );
    assert_eq!(recording.pump_inlet_pressure_pa, side(2));
    assert_eq!(recording.pump_outlet_pressure_pa, side(1));
    assert_eq!(beyond_two(&mut recording), [""; 0]);
}

#[test]
fn what_sets_in_where_another_recording_begins_may_be_another_well() {
    let begins = [("b.csv".into(), 9000.0), ("c.csv".into(), 10_000.0)];
    let told = |from: f64, probability: f64| {
        let finding = Finding {
            intervals_s: vec![(from, 12_000.0)],
            probability,
            ..kick()
        };
        at_seams(&[finding], &begins)
    };
    for from in [9880.0, 10_001.0, 10_040.0] {
        let told = told(from, 0.9);
        assert!(told.len() == 1 && told[0].contains("c.csv"), "{told:?}");
    }
    for from in [0.0, 8800.0, 9400.0, 10_100.0] {
        assert!(told(from, 0.9).is_empty(), "{from}");
    }
    assert!(told(10_001.0, 0.4).is_empty());
}
