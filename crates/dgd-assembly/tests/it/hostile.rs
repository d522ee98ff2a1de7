//! Descriptions and records that nobody would write, and some that somebody will.

use crate::common::{PUMP_LOOP, RETURN_LINE, TWO_TANKS, clock};
use dgd_assembly::{
    Assembly, AssemblyError, Portion, Record, RunStatus, SimulationOptions, Simulator, Window,
};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_description_is_refused_or_runs(which in 0usize..3, cut in 0usize..2000, length in 0usize..40, put in "[ -~]{0,12}") {
        let text = [TWO_TANKS, PUMP_LOOP, RETURN_LINE][which];
        let start = cut % text.len();
        let end = (start + length).min(text.len());
        let (Some(head), Some(tail)) = (text.get(..start), text.get(end..)) else { return Ok(()) };
        match Assembly::parse(&format!("{head}{put}{tail}")) {
            Ok(assembly) => {
                let n = assembly.inputs().len();
                let window = Window { time: clock(5, 1.0), inputs: vec![vec![1.0; 5]; n], readings: Vec::new(), origin: None };
                let options = SimulationOptions { max_steps: 2000, ..Default::default() };
                let _ = assembly.simulate(&assembly.start(), &window, 0, &options);
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }

    #[test]
    fn valves_between_nodes_chosen_at_random_are_solved_or_refused(
        pairs in proptest::collection::vec((0usize..6, 0usize..6, -9.0f64..-3.0), 1..10),
        pressure in 0.0f64..1e7,
    ) {
        let names = ["high", "atmosphere", "n0", "n1", "n2", "n3"];
        let mut text = String::from("connections = [");
        for (k, (a, b, _)) in pairs.iter().enumerate() {
            text += &format!("\"{} -> v{k} -> {}\",", names[*a], names[*b]);
        }
        text += "]\n[components]\n";
        for node in &names[2..] {
            if pairs.iter().any(|(a, b, _)| names[*a] == *node || names[*b] == *node) {
                text += &format!("{node} = {{ kind = \"junction\" }}\n");
            }
        }
        if pairs.iter().any(|(a, b, _)| *a == 0 || *b == 0) {
            text += &format!("high = {{ kind = \"boundary\", pressure = {pressure:e} }}\n");
        }
        for (k, (_, _, coefficient)) in pairs.iter().enumerate() {
            text += &format!("v{k} = {{ kind = \"valve\", flow_coefficient = {:e} }}\nq{k} = {{ kind = \"instrument\", measures = \"flow\", of = \"v{k}\" }}\n", 10f64.powf(*coefficient));
        }
        match Assembly::parse(&text) {
            Ok(assembly) => {
                let window = Window { time: clock(2, 1.0), ..Window::default() };
                let run = assembly.simulate(&[], &window, 0, &SimulationOptions::default()).unwrap();
                prop_assert_eq!(run.status, RunStatus::Finished, "{}", text);
                // What enters a junction leaves it.
                for (n, name) in names.iter().enumerate().skip(2) {
                    let (mut net, mut size) = (0.0, 0.0_f64);
                    for (k, (a, b, _)) in pairs.iter().enumerate() {
                        let q = run.outputs[assembly.outputs().iter().position(|o| *o == format!("q{k}")).unwrap()][0];
                        net += if *b == n { q } else { 0.0 } - if *a == n { q } else { 0.0 };
                        size = size.max(q.abs());
                    }
                    // Near rest a valve of 1e-3 turns the last digit of a pressure into this flow.
                    let rounding = 1e-12 + 10.0 * f64::EPSILON * pressure.max(1e5) * 1e-2;
                    prop_assert!(net.abs() <= 1e-6 * size + rounding, "{name} {net} {text}");
                }
            }
            Err(error) => prop_assert!(matches!(error, AssemblyError::IllPosed(_)), "{error}\n{text}"),
        }
    }
}

fn tanks() -> Assembly {
    Assembly::parse(TWO_TANKS).unwrap()
}

#[test]
fn a_record_without_the_column_names_those_it_has() {
    let v = [0.0; 4];
    let error = tanks()
        .windows(
            &Record {
                columns: vec![("voltage", &v)],
            },
            Portion::Train,
        )
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "the record has no column `u` for pump.input, expected one of: voltage"
    );
}

#[test]
fn unequal_columns_and_clocks_that_jump_back_are_refused() {
    let (short, long) = ([0.0; 4], [0.0; 5]);
    let error = tanks()
        .windows(
            &Record {
                columns: vec![("u", &long), ("h1", &short)],
            },
            Portion::Train,
        )
        .unwrap_err();
    assert!(
        matches!(
            error,
            AssemblyError::Length {
                expected: 5,
                found: 4,
                ..
            }
        ),
        "{error}"
    );
    let assembly = Assembly::parse(RETURN_LINE).unwrap();
    let back = [0.0, 2.0, 1.0, 3.0];
    let error = assembly
        .windows(
            &Record {
                columns: vec![("t", &back), ("q_in", &short), ("w", &short)],
            },
            Portion::Train,
        )
        .unwrap_err();
    assert!(
        matches!(error, AssemblyError::Times { index: 3, .. }),
        "{error}"
    );
}

#[test]
fn train_and_test_are_taken_from_their_own_columns_or_windows() {
    let text = TWO_TANKS.replace(
        "step = 4.0",
        "step = 4.0\n[record.train]\nchannels = { u = \"uEst\", h1 = \"yEst\" }\nwindows = [[0.0, 20.0], [40.0, 60.0]]\n[record.test]\nchannels = { u = \"uVal\", h1 = \"yVal\" }",
    );
    let assembly = Assembly::parse(&text).unwrap();
    let est: Vec<f64> = clock(20, 1.0);
    let val: Vec<f64> = clock(20, -1.0);
    let record = Record {
        columns: vec![
            ("uEst", &est),
            ("yEst", &est),
            ("uVal", &val),
            ("yVal", &val),
        ],
    };
    let train = assembly.windows(&record, Portion::Train).unwrap();
    assert_eq!(train.len(), 2);
    assert_eq!(
        (train[0].time.len(), train[1].time[0], train[1].inputs[0][0]),
        (6, 40.0, 10.0)
    );
    // Its own initial state for each training window.
    assert!(
        assembly
            .parameters()
            .iter()
            .any(|p| p.path == "lower.level@2")
    );
    let test = assembly.windows(&record, Portion::Test).unwrap();
    assert_eq!(
        (test.len(), test[0].time.len(), test[0].inputs[0][3]),
        (1, 20, -3.0)
    );
    let upper = assembly
        .outputs()
        .iter()
        .position(|o| o == "upper_level")
        .unwrap();
    assert_eq!(test[0].readings[upper][3], -3.0);
    let lower = assembly
        .outputs()
        .iter()
        .position(|o| o == "lower_level")
        .unwrap();
    assert!(test[0].readings[lower].is_empty());
}

#[test]
fn a_measured_start_is_read_off_its_instrument_and_missed_where_there_is_none() {
    let text = TWO_TANKS
        .replace(
            "\"upper.level\" = 0.1",
            "\"upper.level\" = { measured = \"upper_level\" }",
        )
        .replace(
            "of = \"upper\"",
            "of = \"upper\", gain = 10.0, offset = 1.0",
        );
    let assembly = Assembly::parse(&text).unwrap();
    let (u, h) = ([1.0; 5], [f64::NAN, 4.0, 4.0, 4.0, 4.0]);
    let window = assembly
        .windows(
            &Record {
                columns: vec![("u", &u), ("h1", &h)],
            },
            Portion::Train,
        )
        .unwrap()
        .remove(0);
    let run = assembly
        .simulate(&assembly.start(), &window, 0, &SimulationOptions::default())
        .unwrap();
    assert!((run.states[1][0] - 0.3).abs() < 1e-12);
    let blind = assembly
        .windows(
            &Record {
                columns: vec![("u", &u)],
            },
            Portion::Train,
        )
        .unwrap()
        .remove(0);
    let error = assembly
        .simulate(&assembly.start(), &blind, 0, &SimulationOptions::default())
        .unwrap_err();
    assert!(
        error.to_string().starts_with("`upper.level` is NaN"),
        "{error}"
    );
}

#[test]
fn a_gap_in_an_input_is_bridged_by_the_last_value() {
    let u = [f64::NAN, 2.0, f64::NAN, 3.0];
    let window = tanks()
        .windows(
            &Record {
                columns: vec![("u", &u)],
            },
            Portion::Train,
        )
        .unwrap()
        .remove(0);
    assert_eq!(window.inputs[0], [2.0, 2.0, 3.0]);
    assert_eq!(window.time, [4.0, 8.0, 12.0]);
}

#[test]
fn the_same_run_gives_the_same_bytes_whatever_ran_before() {
    let assembly = tanks();
    let u: Vec<f64> = clock(50, 0.3);
    let window = assembly
        .windows(
            &Record {
                columns: vec![("u", &u)],
            },
            Portion::Train,
        )
        .unwrap()
        .remove(0);
    let theta = assembly.start();
    let fresh = assembly
        .simulate(&theta, &window, 0, &SimulationOptions::default())
        .unwrap();
    let mut simulator =
        Simulator::new(&assembly, &window, 0, &SimulationOptions::default()).unwrap();
    let other: Vec<f64> = assembly.parameters().iter().map(|p| p.high).collect();
    simulator.run(&other).unwrap();
    let again = simulator.run(&theta).unwrap();
    for (a, b) in fresh
        .outputs
        .iter()
        .flatten()
        .zip(again.outputs.iter().flatten())
    {
        assert_eq!(a.to_bits(), b.to_bits());
    }
}

#[test]
fn an_empty_window_and_an_input_that_is_no_number_are_refused() {
    let text = TWO_TANKS.replace(
        "step = 4.0",
        "step = 4.0\ntrain = { windows = [[1e6, 2e6]] }",
    );
    let u = [1.0; 5];
    let record = Record {
        columns: vec![("u", &u)],
    };
    let error = Assembly::parse(&text)
        .unwrap()
        .windows(&record, Portion::Train)
        .unwrap_err();
    assert!(
        matches!(error, AssemblyError::Window { expected: 2, .. }),
        "{error}"
    );
    let bad = Window {
        time: clock(3, 1.0),
        inputs: vec![vec![1.0, f64::NAN, 1.0]],
        readings: Vec::new(),
        origin: None,
    };
    let error = tanks()
        .simulate(&tanks().start(), &bad, 0, &SimulationOptions::default())
        .unwrap_err();
    assert!(matches!(error, AssemblyError::Input(_)), "{error}");
    let still = SimulationOptions {
        relative: f64::NAN,
        ..Default::default()
    };
    let error = tanks()
        .simulate(
            &tanks().start(),
            &Window {
                inputs: vec![vec![1.0; 3]],
                ..bad
            },
            0,
            &still,
        )
        .unwrap_err();
    assert!(matches!(error, AssemblyError::Integrate(_)), "{error}");
}
