//! Fits recover what made the record.

use crate::common::{Noise, TWO_TANKS, clock, steps};
use dgd_assembly::{
    Assembly, AssemblyError, FitOptions, FitStatus, Loss, Portion, Record, SimulationOptions,
    Window, fit,
};

/// The cascade with its truth, and its record with noise of `sigma` on both levels.
fn cascade(sigma: f64) -> (Assembly, Vec<f64>, Window) {
    let assembly = Assembly::parse(TWO_TANKS).unwrap();
    let truth: Vec<f64> = assembly
        .parameters()
        .iter()
        .map(|p| match p.path.as_str() {
            "lower_outlet.discharge_coefficient" => 0.71,
            "upper_outlet.discharge_coefficient" => 0.55,
            "pump.coefficient" => 1.7e-5,
            "lower.level" => 0.21,
            _ => p.start,
        })
        .collect();
    let u = steps(600, 15, 2.0, 6.0);
    let mut window = assembly
        .windows(
            &Record {
                columns: vec![("u", &u)],
            },
            Portion::Train,
        )
        .unwrap()
        .remove(0);
    let options = SimulationOptions {
        relative: 1e-8,
        ..Default::default()
    };
    let run = assembly.simulate(&truth, &window, 0, &options).unwrap();
    let mut noise = Noise(3);
    window.readings = run
        .outputs
        .iter()
        .map(|o| {
            o.iter()
                .map(|v| v + sigma * 12.0_f64.sqrt() * noise.next())
                .collect()
        })
        .collect();
    (assembly, truth, window)
}

#[test]
fn parameters_and_initial_state_are_recovered_from_an_exact_record() {
    let (assembly, truth, window) = cascade(0.0);
    let found = fit(&assembly, &[window], &FitOptions::default()).unwrap();
    assert_eq!(found.status, FitStatus::Converged);
    for ((p, found), truth) in assembly.parameters().iter().zip(&found.theta).zip(&truth) {
        assert!(
            (found / truth - 1.0).abs() < 1e-4,
            "{}: {found} instead of {truth}",
            p.path
        );
    }
}

#[test]
fn standard_errors_hold_the_truth_in_noise() {
    let (assembly, truth, window) = cascade(2e-3);
    let found = fit(&assembly, &[window], &FitOptions::default()).unwrap();
    for i in 0..truth.len() {
        let off = (found.theta[i] - truth[i]) / found.standard_error[i];
        assert!(
            off.abs() < 3.5 && found.standard_error[i] < 0.1 * truth[i],
            "{i}: {off}"
        );
    }
    assert!(found.inflation < 1.2);
}

#[test]
fn a_robust_loss_is_not_pulled_by_spikes() {
    let (assembly, truth, mut window) = cascade(1e-3);
    for k in (0..600).step_by(17) {
        window.readings[0][k] += 0.5;
    }
    let error = |loss| {
        let found = fit(
            &assembly,
            &[window.clone()],
            &FitOptions {
                loss,
                ..Default::default()
            },
        )
        .unwrap();
        (found.theta[0] / truth[0] - 1.0).abs()
    };
    assert!(error(Loss::Huber(1.5)) < 0.2 * error(Loss::Square));
}

#[test]
fn a_robust_loss_has_a_scale_where_most_of_the_record_is_at_rest() {
    let text = r#"
        connections = ["feed -> tank"]
        [components]
        feed = { kind = "boundary" }
        tank = { kind = "tank", area = 1.0 }
        level = { kind = "instrument", measures = "level", of = "tank" }
        [inputs]
        "feed.flow" = { channel = "q", between = "held" }
        [initial]
        "tank.level" = 0.0
        [free]
        "level.gain" = { start = 1.0, low = 0.5, high = 2.0 }
    "#;
    let assembly = Assembly::parse(text).unwrap();
    // Nothing flows, and nothing is read, until three quarters are over.
    let q: Vec<f64> = (0..400).map(|i| if i < 300 { 0.0 } else { 0.01 }).collect();
    let mut noise = Noise(5);
    let read: Vec<f64> = (0..400)
        .map(|i| match i {
            0..=300 => 0.0,
            _ => 1.3 * 0.01 * f64::from(i - 300) + 1e-3 * noise.next(),
        })
        .collect();
    let record = Record {
        columns: vec![("q", &q), ("level", &read)],
    };
    let windows = assembly.windows(&record, Portion::Train).unwrap();
    let options = FitOptions {
        loss: Loss::Huber(1.5),
        ..Default::default()
    };
    let found = fit(&assembly, &windows, &options).unwrap();
    assert!((found.theta[0] - 1.3).abs() < 2e-3, "{:?}", found.theta);
    assert!(found.standard_error[0] > 0.0);
}

#[test]
fn missing_readings_are_left_out() {
    let (assembly, truth, mut window) = cascade(0.0);
    window.readings[0][100..400].fill(f64::NAN);
    window.readings[1].clear();
    let found = fit(&assembly, &[window], &FitOptions::default()).unwrap();
    assert!(
        (found.theta[0] / truth[0] - 1.0).abs() < 1e-3,
        "{:?}",
        found.theta
    );
}

#[test]
fn what_no_reading_tells_is_untold_even_where_it_was_left_on_a_bound() {
    let (_, _, window) = cascade(1e-3);
    let free = "[free]\n\"lower_level.offset\" = { start = 0.0, low = 0.0, high = 0.1 }";
    let assembly = Assembly::parse(&TWO_TANKS.replace("[free]", free)).unwrap();
    let of = |path: &str| {
        let parameters = assembly.parameters();
        parameters.iter().position(|p| p.path == path).unwrap()
    };
    let (offset, upper) = (
        of("lower_level.offset"),
        of("upper_outlet.discharge_coefficient"),
    );
    // No reading of the upper tank turns with what the lower one's transmitter adds.
    let options = FitOptions {
        outputs: vec!["upper_level".into()],
        ..Default::default()
    };
    let found = fit(&assembly, &[window], &options).unwrap();
    assert!(!found.at_bound[offset]);
    assert_eq!(found.standard_error[offset], f64::INFINITY);
    assert!(found.standard_error[upper] < 0.1);
}

#[test]
fn a_record_in_twice_the_unit_gives_the_same_parameters() {
    let (assembly, _, window) = cascade(1e-3);
    let first = fit(
        &assembly,
        std::slice::from_ref(&window),
        &FitOptions::default(),
    )
    .unwrap();
    let text = TWO_TANKS
        .replace("of = \"upper\"", "of = \"upper\", gain = 2.0")
        .replace("of = \"lower\"", "of = \"lower\", gain = 2.0");
    let doubled = Assembly::parse(&text).unwrap();
    let mut twice = window;
    twice.readings.iter_mut().flatten().for_each(|r| *r *= 2.0);
    let second = fit(&doubled, &[twice], &FitOptions::default()).unwrap();
    for (a, b) in first.theta.iter().zip(&second.theta) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn more_starts_find_the_minimum_from_a_bad_first_guess() {
    let (assembly, truth, window) = cascade(0.0);
    let bad: Vec<f64> = assembly.parameters().iter().map(|p| p.high).collect();
    let options = FitOptions {
        start: Some(bad),
        more_starts: 4,
        ..Default::default()
    };
    let found = fit(&assembly, &[window], &options).unwrap();
    assert!((found.theta[0] / truth[0] - 1.0).abs() < 1e-3, "{found:?}");
}

#[test]
fn wrong_calls_are_refused() {
    let (assembly, _, window) = cascade(0.0);
    let refused =
        |windows: &[Window], options: FitOptions| fit(&assembly, windows, &options).unwrap_err();
    assert!(matches!(
        refused(&[], FitOptions::default()),
        AssemblyError::Length { .. }
    ));
    let short = FitOptions {
        start: Some(vec![1.0]),
        ..Default::default()
    };
    assert!(matches!(
        refused(std::slice::from_ref(&window), short),
        AssemblyError::Length { .. }
    ));
    let unknown = FitOptions {
        outputs: vec!["colour".into()],
        ..Default::default()
    };
    assert!(matches!(
        refused(std::slice::from_ref(&window), unknown),
        AssemblyError::Column { .. }
    ));
    let held = FitOptions {
        held: vec!["colour".into()],
        ..Default::default()
    };
    assert!(matches!(
        refused(std::slice::from_ref(&window), held),
        AssemblyError::Column { .. }
    ));
    for loss in [0.0, -1.0, f64::NAN].map(Loss::Huber) {
        let options = FitOptions {
            loss,
            ..Default::default()
        };
        let said = refused(std::slice::from_ref(&window), options).to_string();
        assert!(
            said.contains("k of Huber") && said.contains("above 0"),
            "{said}"
        );
    }
    for tolerance in [-1e-9, f64::NAN] {
        let options = FitOptions {
            tolerance,
            ..Default::default()
        };
        let said = refused(std::slice::from_ref(&window), options).to_string();
        assert!(said.contains("`tolerance`"), "{said}");
    }
    let mut short = window.clone();
    short.readings[1].truncate(5);
    let said = refused(&[short], FitOptions::default()).to_string();
    assert!(said.contains("has 5 entries, expected"), "{said}");
    let blind = Window {
        readings: vec![Vec::new(); 2],
        ..window
    };
    assert!(matches!(
        refused(&[blind], FitOptions::default()),
        AssemblyError::NoReadings { .. }
    ));
}

#[test]
fn the_static_relation_between_flow_and_standpipe_pressure_is_fitted_sample_by_sample() {
    let text = r#"
        independent = "depth"
        connections = ["pump -> string -> bit -> annulus -> atmosphere"]
        [fluid]
        viscosity = 0.02
        [components]
        pump = { kind = "boundary" }
        string = { kind = "line", bore = 0.1 }
        bit = { kind = "orifice", discharge_coefficient = 0.95 }
        annulus = { kind = "line", bore = 0.22, inner_diameter = 0.127 }
        standpipe = { kind = "instrument", measures = "pressure", of = "string.inlet", channel = "p" }
        [inputs]
        "pump.flow" = { channel = "q" }
        "string.length" = { channel = "depth" }
        "annulus.length" = { channel = "depth" }
        [free]
        "string.roughness" = { start = 1e-5, low = 0.0, high = 1e-3 }
        "bit.area" = { start = 5e-4, low = 1e-4, high = 2e-3 }
        [record]
        time = "depth"
    "#;
    let assembly = Assembly::parse(text).unwrap();
    assert!(assembly.states().is_empty());
    let depth = clock(200, 10.0);
    let q: Vec<f64> = steps(200, 3, 0.02, 0.05);
    let record = Record {
        columns: vec![("depth", &depth), ("q", &q)],
    };
    let mut window = assembly.windows(&record, Portion::Train).unwrap().remove(0);
    let truth = [6e-4, 1e-4];
    let run = assembly
        .simulate(&truth, &window, 0, &SimulationOptions::default())
        .unwrap();
    assert!(run.outputs[0][199] > run.outputs[0][2]);
    window.readings = run.outputs;
    let found = fit(&assembly, &[window], &FitOptions::default()).unwrap();
    for (a, b) in found.theta.iter().zip(truth) {
        assert!((a / b - 1.0).abs() < 1e-5, "{:?}", found.theta);
    }
}

#[test]
fn the_linear_model_gives_the_same_values_where_inputs_move_little_and_others_where_they_move_much()
{
    let free = r#""upper.level" = { start = 0.1, low = 0.0, high = 0.4 }"#;
    let text = TWO_TANKS.replace(r#""upper.level" = 0.1"#, free);
    let assembly = Assembly::parse(&text).unwrap();
    assert_eq!(
        assembly.parameters().iter().filter(|p| p.initial).count(),
        2
    );
    let truth = assembly.start();
    let linear = SimulationOptions {
        linear: true,
        ..Default::default()
    };
    // Error of the linear run over the size of the movement, and the fitted discharge coefficient of the lower outlet over the true one.
    let told = |swing: f64| {
        let u = steps(400, 20, 4.0 - swing, 4.0 + swing);
        let mut window = assembly
            .windows(
                &Record {
                    columns: vec![("u", &u)],
                },
                Portion::Train,
            )
            .unwrap()
            .remove(0);
        // From the steady state at the mean of the inputs.
        let middle = u.iter().sum::<f64>() / 400.0;
        let guess = vec![0.2; assembly.states().len()];
        let steady = dgd_assembly::steady_state(&assembly, &truth, &[middle], &guess).unwrap();
        let starts: Vec<f64> = assembly
            .parameters()
            .iter()
            .zip(&truth)
            .map(|(p, v)| {
                let state = assembly.states().iter().position(|s| *s == p.path);
                state.map_or(*v, |s| steady.state[s])
            })
            .collect();
        let run = assembly
            .simulate(&starts, &window, 0, &SimulationOptions::default())
            .unwrap();
        window.readings = run.outputs;
        let off = assembly.rms(&starts, &window, 0, &linear).unwrap();
        let options = FitOptions {
            start: Some(starts.clone()),
            simulation: linear,
            ..FitOptions::default()
        };
        let found = fit(&assembly, &[window], &options).unwrap();
        let index = assembly
            .parameters()
            .iter()
            .position(|p| p.path == "lower_outlet.discharge_coefficient")
            .unwrap();
        (off[0] / swing, found.theta[index] / starts[index])
    };
    let (little, much) = (told(0.05), told(1.5));
    assert!(little.0 < 0.1 * much.0, "{little:?} {much:?}");
    assert!((little.1 - 1.0).abs() < 0.01, "{little:?}");
    assert!(
        (much.1 - 1.0).abs() > 2.0 * (little.1 - 1.0).abs(),
        "{little:?} {much:?}"
    );
}
