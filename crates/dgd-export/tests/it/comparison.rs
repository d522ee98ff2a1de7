//! Measured beside two simulations.

use crate::Full;
use dgd_export::{ComparedSignal, Comparison, ExportError, write_comparison_csv};

fn signal<'a>(name: &'a str, values: &'a [f64]) -> ComparedSignal<'a> {
    ComparedSignal {
        name,
        measured: values,
        before: values,
        after: values,
    }
}

fn comparison<'a>(time_s: &'a [f64], signals: &'a [ComparedSignal<'a>]) -> Comparison<'a> {
    static YES: [bool; 70_000] = [true; 70_000];
    static NO: [bool; 70_000] = [false; 70_000];
    Comparison {
        time_s,
        held_out: &NO[..time_s.len()],
        valid: &YES[..time_s.len()],
        signals,
    }
}

fn written(comparison: &Comparison<'_>) -> String {
    let mut bytes = Vec::new();
    write_comparison_csv(comparison, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn each_unit_keeps_the_digits_an_instrument_could_mean() {
    let values = [1.0 / 3.0];
    let signals = [
        signal("return_flow_m3_s", &values),
        signal("riser_level_m", &values),
        signal("pump_outlet_pressure_pa", &values),
    ];
    let text = written(&comparison(&[0.5], &signals));
    let row = text.lines().nth(1).unwrap();
    assert_eq!(
        row,
        "0.5,0,1,0.333333333,0.333333333,0.333333333,0.333333,0.333333,0.333333,0.33,0.33,0.33"
    );
}

#[test]
fn what_is_not_finite_is_an_empty_cell() {
    let signals = [ComparedSignal {
        name: "pump_head_m",
        measured: &[f64::NAN],
        before: &[f64::INFINITY],
        after: &[f64::NEG_INFINITY],
    }];
    let text = written(&comparison(&[3.0], &signals));
    assert_eq!(
        text,
        "t_s,held_out,valid,pump_head_m_measured,pump_head_m_before,pump_head_m_after\n3,0,1,,,\n"
    );
}

#[test]
fn names_with_commas_quotes_and_line_ends_stay_one_cell() {
    let values = [1.0];
    let signals = [
        signal("flow, \"out\"_m3_s", &values),
        signal("two\nlines_m", &values),
    ];
    let text = written(&comparison(&[0.0], &signals));
    assert!(
        text.starts_with(
            "t_s,held_out,valid,\"flow, \"\"out\"\"_m3_s_measured\",\"flow, \"\"out\"\"_m3_s_before\","
        ),
        "{text}"
    );
    assert!(text.contains(",\"two\nlines_m_after\"\n0,"), "{text}");
}

#[test]
fn long_comparisons_are_written_whole_and_read_back_to_their_rounding() {
    let time: Vec<f64> = (0..70_000).map(f64::from).collect();
    let level: Vec<f64> = time
        .iter()
        .map(|t| 150.0 + 20.0 * (t / 97.0).sin())
        .collect();
    let signals = [signal("riser_level_m", &level)];
    let text = written(&comparison(&time, &signals));
    let mut rows = 0;
    for (line, (t, level)) in text.lines().skip(1).zip(time.iter().zip(&level)) {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        assert_eq!(cells[0], *t);
        assert!((cells[3] - level).abs() <= 0.5e-6, "{line}");
        rows += 1;
    }
    assert_eq!(rows, 70_000);
}

#[test]
fn each_refusal_has_its_error() {
    let write = |c: &Comparison<'_>| write_comparison_csv(c, &mut Vec::new());
    let short = [signal("riser_level_m", &[1.0])];
    assert!(matches!(
        write(&comparison(&[0.0, 1.0], &short)),
        Err(ExportError::Length { expected: 2, found: 1, name }) if name == "riser_level_m"
    ));
    let one = [signal("a_m", &[1.0])];
    let mut flags = comparison(&[0.0], &one);
    flags.valid = &[];
    assert!(matches!(
        write(&flags),
        Err(ExportError::Length { expected: 1, found: 0, name }) if name == "valid"
    ));
    let twice = [signal("a_m", &[1.0]), signal("a_m", &[1.0])];
    assert!(matches!(
        write(&comparison(&[0.0], &twice)),
        Err(ExportError::NameTaken { tag }) if tag == "a_m"
    ));
    let full = write_comparison_csv(&comparison(&[0.0], &one), Full);
    assert!(matches!(full, Err(ExportError::Io(_))));
}
