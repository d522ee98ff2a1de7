//! Beside a fit: `dgd sensitivities --profile`, what a recording tells of one parameter while the others make up for it, and `dgd fit
//! --linear`.

use crate::systems::{benches, free_area};
use serde_json::Value;

fn profile<'a>(told: &'a Value, path: &str) -> &'a Value {
    let all = told["profiles"].as_array().unwrap();
    all.iter().find(|p| p["path"] == path).unwrap()
}

#[test]
fn the_profile_of_a_told_parameter_ends_where_the_fit_says_and_holds_the_truth() {
    let bench = benches();
    let fit = bench.json(
        "fit two_tanks.csv --system two_tanks.toml --out m.toml",
        "dgd.system-fit/1",
    );
    let path = "upper_outlet.discharge_coefficient";
    let told = bench.json(
        &format!("sensitivities two_tanks.csv --system m.toml --profile {path} --out s"),
        "dgd.sensitivities/1",
    );
    let found = profile(&told, path);
    let all = fit["parameters"].as_array().unwrap();
    let fitted = all.iter().find(|p| p["path"] == path).unwrap();
    let ends = |v: &Value| [0, 1].map(|k| v["ci95"][k].as_f64().unwrap());
    let (profiled, curved) = (ends(found), ends(fitted));
    let width = curved[1] - curved[0];
    for (a, b) in profiled.iter().zip(curved) {
        assert!((a - b).abs() < 0.1 * width, "{profiled:?} {curved:?}");
    }
    assert!(profiled[0] < 0.62 && 0.62 < profiled[1], "{profiled:?}");
    let rise = |p: &Value| p["rise"].as_f64().unwrap();
    let points = found["points"].as_array().unwrap();
    assert!(rise(points.first().unwrap()) > 3.84 && rise(points.last().unwrap()) > 3.84);
    let page = bench.text("s/sensitivities.html");
    assert!(page.contains("Profile likelihood"), "no profile is drawn");
}

#[test]
fn a_parameter_that_another_stands_in_for_is_open_as_far_as_either_has_room() {
    let bench = benches();
    free_area(&bench);
    let told = bench.json(
        "sensitivities two_tanks.csv --system both.toml --profile upper_outlet.area --out s",
        "dgd.sensitivities/1",
    );
    let ends = &profile(&told, "upper_outlet.area")["ci95"];
    // The product is 0.62e-4 m2 and the coefficient goes from 0.3 to 1.
    let low = ends[0].as_f64().unwrap();
    assert!((low / 0.62e-4 - 1.0).abs() < 0.02, "{ends}");
    assert!(ends[1].is_null(), "{ends}");
    let said = bench
        .dgd("sensitivities two_tanks.csv --system both.toml --profile upper_outlet.area --out s")
        .done();
    assert!(said.contains("open as far as its upper bound"), "{said}");
}

#[test]
fn a_profile_of_what_is_not_free_is_refused_with_what_is() {
    let bench = benches();
    bench
        .dgd("sensitivities two_tanks.csv --system two_tanks.toml --profile upper.area --out s")
        .refused(&["upper.area", "upper_outlet.discharge_coefficient"]);
}

#[test]
fn the_linear_model_is_fitted_beside_the_equations_and_does_worse_where_tanks_swing() {
    let bench = benches();
    let fit = bench.json(
        "fit two_tanks.csv --system two_tanks.toml --linear --out m.toml",
        "dgd.system-fit/1",
    );
    let rms = |v: &Value| v["outputs"][0]["train"]["rms"].as_f64().unwrap();
    assert!(rms(&fit["linear"]) > 1.5 * rms(&fit), "{}", fit["linear"]);
    let paths = |v: &Value| {
        let all = v["parameters"].as_array().unwrap();
        all.iter()
            .map(|p| p["path"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(paths(&fit), paths(&fit["linear"]));
    assert!(
        bench
            .text("m.html")
            .contains("Estimated on the linear model")
    );
    let plain = bench.json(
        "fit two_tanks.csv --system two_tanks.toml --out plain.toml",
        "dgd.system-fit/1",
    );
    assert!(plain["linear"].is_null());
    assert_eq!(plain["parameters"], fit["parameters"]);
}
