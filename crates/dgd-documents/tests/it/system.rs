//! Systems with their fit.

use dgd_documents::{
    FITTED_SCHEMA, FittedParameter, FittedSystem, read_model, read_system, read_system_types,
    return_line_system, write_fitted_system,
};

const SYSTEM: &str = r#"
connections = ["tank -> valve -> atmosphere"]

[components]
tank = { kind = "tank", area = 1.0 }
valve = { kind = "valve" }
gauge = { kind = "instrument", measures = "level", of = "tank", channel = "h" }

[initial]
"tank.level" = { start = 1.0, low = 0.0, high = 2.0 }

[free]
"valve.flow_coefficient" = { start = 3e-5, low = 1e-6, high = 1e-3 }

[record]
train = { windows = [[0.0, 10.0], [20.0, 30.0]] }
"#;

fn fitted() -> FittedSystem {
    let entry = |path: &str, value: f64, standard_error: f64| FittedParameter {
        path: path.into(),
        value,
        standard_error,
        at_bound: false,
    };
    FittedSystem {
        recording: "tank \"one\".csv".into(),
        status: "converged".into(),
        samples: 22,
        parameters: vec![
            entry("valve.flow_coefficient", 4.5e-5, 1e-7),
            entry("tank.level", 1.25, f64::INFINITY),
            entry("tank.level@2", 0.75, 0.0),
        ],
    }
}

#[test]
fn a_fit_reads_back_as_it_was_written_every_window_s_start_included() {
    let document = read_system(SYSTEM).unwrap();
    assert!(document.fitted.is_none());
    assert_eq!(document.theta(), [3e-5, 1.0, 1.0]);
    let text = write_fitted_system(&document.assembly, &fitted()).unwrap();
    let again = read_system(&text).unwrap();
    assert_eq!(again.fitted.as_ref(), Some(&fitted()));
    assert_eq!(again.theta(), [4.5e-5, 1.25, 0.75]);
    assert_eq!(
        write_fitted_system(&again.assembly, &fitted()).unwrap(),
        text
    );
    // Without the fit it is the system that was described, and a search starts where the first one did.
    let plain = text.split("\n[fitted]").next().unwrap();
    assert_eq!(read_system(plain).unwrap().theta(), document.theta());
    assert_eq!(again.assembly.start(), document.assembly.start());
}

#[test]
fn a_fit_that_does_not_belong_to_the_system_is_refused_at_its_line() {
    let document = read_system(SYSTEM).unwrap();
    let text = write_fitted_system(&document.assembly, &fitted()).unwrap();
    let line = text.lines().position(|l| l == "[fitted]").unwrap() + 1;
    for (from, to, part) in [
        ("tank.level@2", "tank.level@3", "is not free in the system"),
        ("4.5e-5", "4.5", "0.001"),
        ("value = 1.25", "value = \"x\"", "absent"),
        (FITTED_SCHEMA, "dgd.fitted-system/9", FITTED_SCHEMA),
    ] {
        let found = text.rfind(from).or_else(|| text.rfind("0.000045")).unwrap();
        let length = if text[found..].starts_with(from) {
            from.len()
        } else {
            8
        };
        let wrong = format!("{}{to}{}", &text[..found], &text[found + length..]);
        let error = read_system(&wrong).unwrap_err();
        assert_eq!(error.places[0].0, line, "{error}");
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn problems_are_told_at_their_lines_whether_or_not_a_fit_stands_before_them() {
    let bad = SYSTEM.replace("area = 1.0", "area = -1.0");
    let line = bad.lines().position(|l| l.starts_with("tank =")).unwrap() + 1;
    let error = read_system(&bad).unwrap_err();
    assert_eq!(error.places[0].0, line);
    assert!(error.problems[0].message.contains("tank.area"));
    let behind = format!(
        "[fitted]\nschema = \"x\"\n{}",
        bad.replace("connections", "[x]\nconnections")
    );
    assert!(read_system(&behind).is_err());
    let error = read_system("connections = [").unwrap_err();
    assert_eq!(error.places[0].0, 1);
}

#[test]
fn a_system_that_is_not_well_posed_still_has_its_types_read() {
    let loose = SYSTEM.replace(" -> atmosphere", "");
    assert!(read_system(&loose).is_err());
    assert_eq!(read_system_types(&loose).unwrap().components.len(), 3);
    assert!(read_system_types("components = 3").is_err());
}

#[test]
fn no_text_makes_the_reader_panic() {
    for text in [
        "",
        "[fitted]",
        "[fitted",
        "[[fitted]]\n",
        "\u{feff}[fitted]\nä = 1",
        "[fitted.parameters]\n\"a\" = 1",
    ] {
        assert!(read_system(text).is_err(), "{text}");
    }
    for end in 0..SYSTEM.len() {
        let _ = read_system(&SYSTEM[..end]);
    }
}

#[test]
fn the_built_in_return_line_is_a_well_posed_system() {
    let (model, _) = read_model(crate::model::MODEL).unwrap();
    let document = read_system(&return_line_system(&model)).unwrap();
    assert_eq!(document.assembly.states(), ["riser.level", "line.flow"]);
    assert_eq!(document.assembly.inputs(), ["inflow.flow", "pump.speed"]);
    assert!(document.assembly.warnings().is_empty());
}
