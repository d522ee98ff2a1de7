//! Claims over the whole catalogue, and of a few effects one by one.

use crate::common::{Noise, PUMP_LOOP, RETURN_LINE, TWO_TANKS, apart, clock, steps, window};
use dgd_assembly::effects::{all, find};
use dgd_assembly::{
    Assembly, FitOptions, Kind, Record, RunStatus, SimulationOptions, Window, effects_for, fit,
};

/// A pressure vessel between a pump and a valve: what the other rigs do not have.
const VESSEL: &str = r#"
    connections = ["pit -> pump -> vessel -> valve -> sea", "vessel -> line -> sea"]
    [components]
    pit = { kind = "boundary", pressure = 101325.0 }
    sea = { kind = "boundary", pressure = "2 bar" }
    pump = { kind = "displacement_pump", coefficient = 1e-4 }
    vessel = { kind = "volume", volume = 0.1, bulk_modulus = 1e8 }
    valve = { kind = "valve", flow_coefficient = 2e-6 }
    line = { kind = "line", length = 100.0, bore = 0.03, elevation = -3.0 }
    p = { kind = "instrument", measures = "pressure", of = "vessel" }
    q = { kind = "instrument", measures = "flow", of = "line.outlet" }
    [inputs]
    "pump.input" = { channel = "u" }
    "valve.opening" = { channel = "z", between = "held" }
    [initial]
    "vessel.pressure" = 3e5
    [scale]
    pressure = 2e5
    flow = 1e-3
    time = 2.0
"#;

/// A relation along depth, without states.
const STANDPIPE: &str = r#"
    independent = "depth"
    connections = ["pump -> string -> bit -> annulus -> atmosphere"]
    [fluid]
    viscosity = 0.02
    [components]
    pump = { kind = "boundary" }
    string = { kind = "line", bore = 0.1 }
    bit = { kind = "orifice", discharge_coefficient = 0.95, area = 6e-4 }
    annulus = { kind = "line", bore = 0.22, inner_diameter = 0.127 }
    standpipe = { kind = "instrument", measures = "pressure", of = "string.inlet", channel = "p" }
    [inputs]
    "pump.flow" = { channel = "q_in" }
    "string.length" = { channel = "t" }
    "annulus.length" = { channel = "t" }
    [record]
    time = "t"
"#;

/// Every rig with an exciting window.
fn rigs() -> Vec<(&'static str, Assembly, Window)> {
    let t = clock(200, 1.0);
    let speed: Vec<f64> = steps(200, 13, 40.0, 80.0);
    let opening = steps(200, 17, 0.3, 1.0);
    let inflow: Vec<f64> = t.iter().map(|t| 0.05 + 0.01 * (t * 0.05).sin()).collect();
    // Runs the upper tank over.
    let u: Vec<f64> = steps(200, 11, 1.0, 16.0);
    let strokes = steps(200, 7, 5.0, 20.0);
    let columns: Vec<(&str, &[f64])> = vec![
        ("t", &t),
        ("u", &u),
        ("w", &speed),
        ("z", &opening),
        ("q_in", &inflow),
    ];
    let pressed: Vec<(&str, &[f64])> = vec![("t", &t), ("u", &strokes), ("z", &opening)];
    [
        ("tanks", TWO_TANKS, &columns),
        ("loop", PUMP_LOOP, &columns),
        ("return line", RETURN_LINE, &columns),
        ("vessel", VESSEL, &pressed),
        ("standpipe", STANDPIPE, &columns),
    ]
    .into_iter()
    .map(|(name, text, columns)| {
        let assembly = Assembly::parse(text).unwrap();
        let window = window(&assembly, columns);
        (name, assembly, window)
    })
    .collect()
}

fn names(parameters: &[dgd_assembly::EffectParameter]) -> Vec<&'static str> {
    parameters.iter().map(|p| p.name).collect()
}

#[test]
fn every_kind_has_at_least_six_effects_and_every_description_is_whole() {
    for kind in [
        Kind::Tank,
        Kind::Line,
        Kind::Valve,
        Kind::Orifice,
        Kind::CentrifugalPump,
        Kind::DisplacementPump,
        Kind::Boundary,
        Kind::Instrument,
    ] {
        let count = all()
            .iter()
            .filter(|e| e.about().kinds.contains(&kind))
            .count();
        assert!(count >= 6, "{kind:?} has {count}");
    }
    for (i, effect) in all().iter().enumerate() {
        let about = effect.about();
        assert!(
            !all()[..i].iter().any(|e| e.about().id == about.id),
            "{} twice",
            about.id
        );
        for text in [about.title, about.equation, about.source, about.excited_by] {
            assert!(!text.is_empty(), "{}", about.id);
        }
        for (other, test) in about.confusable {
            assert!(
                find(other).is_some() && !test.is_empty(),
                "{}: {other}",
                about.id
            );
        }
        for p in about.parameters {
            assert!(
                p.low < p.high && p.low.is_finite() && p.high.is_finite(),
                "{}.{}",
                about.id,
                p.name
            );
            assert!(
                p.usual >= p.low && p.usual <= p.high,
                "{}.{}",
                about.id,
                p.name
            );
        }
    }
}

#[test]
fn the_readme_lists_the_catalogue() {
    let readme = include_str!("../../README.md");
    for effect in all() {
        assert!(
            readme.contains(&format!("| `{}` |", effect.about().id)),
            "{}",
            effect.about().id
        );
    }
    let rows = readme
        .lines()
        .filter(|l| l.starts_with("| `") && l.matches('|').count() == 5)
        .count();
    assert_eq!(rows, all().len());
}

#[test]
fn the_readme_shows_a_system_that_is_well_posed() {
    let readme = include_str!("../../README.md");
    let text = readme
        .split("```toml\n")
        .nth(1)
        .and_then(|t| t.split("```").next())
        .unwrap();
    // The lower level starts where it is measured.
    assert_eq!(Assembly::parse(text).unwrap().parameters().len(), 2);
}

#[test]
fn every_effect_finds_a_place_on_some_rig() {
    let rigs = rigs();
    let placed: Vec<&str> = rigs
        .iter()
        .flat_map(|(_, a, _)| effects_for(a))
        .map(|h| h.effect)
        .collect();
    for effect in all() {
        // It wants a junction of its own.
        assert!(placed.contains(&effect.about().id), "{}", effect.about().id);
    }
}

#[test]
fn every_effect_changes_nothing_at_its_neutral_value() {
    for (name, assembly, window) in rigs() {
        let options = SimulationOptions {
            relative: 1e-7,
            ..Default::default()
        };
        let base = assembly
            .simulate(&assembly.start(), &window, 0, &options)
            .unwrap();
        assert_eq!(base.status, RunStatus::Finished, "{name}");
        for h in effects_for(&assembly) {
            let with = assembly
                .with_effect(&h.component, h.effect, &[])
                .unwrap_or_else(|e| panic!("{name} {h:?}: {e}"));
            let run = with.simulate(&with.start(), &window, 0, &options).unwrap();
            assert_eq!(run.status, RunStatus::Finished, "{name} {h:?}");
            for (a, b) in run.outputs.iter().zip(&base.outputs) {
                let size = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                assert!(
                    apart(a, b) <= 1e-5 * size,
                    "{name} {h:?}: {} of {size}",
                    apart(a, b)
                );
            }
        }
    }
}

#[test]
fn every_effect_of_usual_strength_runs_and_is_seen_somewhere() {
    // Drifts are slow: a ten-thousandth must be seen, ten times what the integration may be off.
    let options = SimulationOptions {
        relative: 1e-7,
        ..Default::default()
    };
    let mut seen: Vec<&str> = Vec::new();
    for (name, assembly, window) in rigs() {
        let base = assembly
            .simulate(&assembly.start(), &window, 0, &options)
            .unwrap();
        for h in effects_for(&assembly) {
            let with = assembly
                .with_effect(&h.component, h.effect, &names(&h.parameters))
                .unwrap();
            let run = with.simulate(&with.start(), &window, 0, &options).unwrap();
            assert_eq!(run.status, RunStatus::Finished, "{name} {h:?}");
            for (a, b) in run.outputs.iter().zip(&base.outputs) {
                let size = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                if apart(a, b) > 1e-4 * size {
                    seen.push(h.effect);
                }
            }
        }
    }
    for effect in all() {
        let id = effect.about().id;
        // Nothing runs backwards and no reading is small on these rigs.
        let quiet = ["backflow_stop", "low_flow_cutoff"].contains(&id);
        assert!(quiet || seen.contains(&id), "{id} is not seen");
    }
}

#[test]
fn effects_of_any_strength_within_their_bounds_end_in_a_status_and_never_in_a_panic() {
    let mut noise = Noise(5);
    for (name, assembly, window) in rigs() {
        let short = Window {
            time: window.time[..40].to_vec(),
            inputs: window.inputs.iter().map(|i| i[..40].to_vec()).collect(),
            readings: window.readings.clone(),
            origin: None,
        };
        for h in effects_for(&assembly) {
            let with = assembly
                .with_effect(&h.component, h.effect, &names(&h.parameters))
                .unwrap();
            for _ in 0..4 {
                let theta: Vec<f64> = with
                    .parameters()
                    .iter()
                    .map(|p| match noise.next() {
                        n if n < -0.3 => p.low,
                        n if n > 0.3 => p.high,
                        n => p.low + (n / 0.6 + 0.5) * (p.high - p.low),
                    })
                    .collect();
                let options = SimulationOptions {
                    max_steps: 100_000,
                    ..Default::default()
                };
                let run = with.simulate(&theta, &short, 0, &options).unwrap();
                if run.status == RunStatus::Finished {
                    assert!(
                        run.outputs.iter().flatten().all(|v| v.is_finite()),
                        "{name} {h:?} {theta:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn what_spills_is_caught_in_the_share_that_was_set_and_found_again_by_a_fit() {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let u = steps(400, 25, 1.0, 14.0);
    let mut window = window(&assembly, &[("u", &u)]);
    let truth = assembly
        .with_effect("upper", "overflow_caught", &["share"])
        .unwrap();
    let refused = assembly.with_effect("upper", "overflow_caught", &["shaer"]);
    let said = refused.unwrap_err().to_string();
    assert!(said.contains("`shaer`") && said.contains("share"), "{said}");
    let at = truth
        .parameters()
        .iter()
        .position(|p| p.path == "upper.overflow_caught.share")
        .unwrap();
    let mut theta = truth.start();
    theta[at] = 0.37;
    let tight = SimulationOptions {
        relative: 1e-7,
        ..Default::default()
    };
    let run = truth.simulate(&theta, &window, 0, &tight).unwrap();
    assert!(
        run.held
            .iter()
            .any(|(path, _, full)| *full && path == "upper.level")
    );
    window.readings = run.outputs;
    let found = fit(
        &truth,
        std::slice::from_ref(&window),
        &FitOptions::default(),
    )
    .unwrap();
    assert!((found.theta[at] - 0.37).abs() < 5e-3, "{found:?}");
    let without = fit(&assembly, &[window], &FitOptions::default()).unwrap();
    assert!(
        without.cost > 100.0 * found.cost,
        "{} {}",
        without.cost,
        found.cost
    );
}

#[test]
fn a_delayed_reading_is_the_same_reading_later() {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let u = steps(300, 9, 2.0, 5.0);
    let window = window(&assembly, &[("u", &u)]);
    let base = assembly
        .simulate(&assembly.start(), &window, 0, &SimulationOptions::default())
        .unwrap();
    let late = assembly
        .with_effect("upper_level", "reading_delay", &["delay"])
        .unwrap();
    let mut theta = late.start();
    let at = late
        .parameters()
        .iter()
        .position(|p| p.path.ends_with("delay"))
        .unwrap();
    theta[at] = 8.0; // two samples
    let run = late
        .simulate(&theta, &window, 0, &SimulationOptions::default())
        .unwrap();
    let meter = assembly
        .outputs()
        .iter()
        .position(|o| o == "upper_level")
        .unwrap();
    assert!(apart(&run.outputs[meter][2..], &base.outputs[meter][..298]) < 1e-9);
    assert_eq!(run.outputs[meter][0], base.outputs[meter][0]);
}

#[test]
fn an_assembly_with_effects_is_written_and_read_as_any_other() {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let with = assembly
        .with_effect("upper", "tank_leak", &["leak"])
        .unwrap()
        .with_effect("pump", "pump_lag", &["tau"])
        .unwrap();
    let again = Assembly::parse(&with.to_toml()).unwrap();
    assert_eq!(again.system(), with.system());
    assert_eq!(again.parameters(), with.parameters());
    assert!(again.states().iter().any(|s| s == "pump.pump_lag.x0"));
    let refused = assembly.with_effect("upper", "pump_lag", &[]).unwrap_err();
    assert!(refused.to_string().contains("tank_leak"), "{refused}");
    let u = [1.0; 5];
    let record = Record {
        columns: vec![("u", &u)],
    };
    assert_eq!(
        with.windows(&record, dgd_assembly::Portion::Test)
            .unwrap()
            .len(),
        0
    );
}
