use dgd_documents::{read_references, write_masked_model, write_references};
use dgd_mask::mask_model;
use dgd_units::{FullScale, MaskReferences};

#[test]
fn references_are_read_back_to_the_last_bit() {
    let references = MaskReferences::new(FullScale {
        flow_m3_s: 0.1 + 0.2,
        friction_pa: 1e5 / 3.0,
        head_m: 299.999_999,
        level_m: 7e-11,
    })
    .unwrap();
    let (again, warnings) = read_references(&write_references(&references)).unwrap();
    assert_eq!(again, references);
    assert!(warnings.is_empty());
}

#[test]
fn no_message_about_references_shows_a_value() {
    let source = "flow = \"987 psi\"\nfriction = 987\nhead = \"-987 m\"\nlevel = \"987\"\n";
    let error = read_references(source).unwrap_err();
    let lines: Vec<usize> = error.places.iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [1, 2, 3, 4]);
    assert!(!error.to_string().contains("987"), "{error}");
}

#[test]
fn all_missing_references_are_told() {
    let error = read_references("flow = \"0.1 m3/s\"\nhead = \"300 m\"\n").unwrap_err();
    let told: Vec<&str> = error.problems.iter().map(|p| p.message.as_str()).collect();
    assert_eq!(told, ["the document has no `friction` and `level`"]);
}

#[test]
fn a_masked_model_is_toml_whatever_its_numbers() {
    let (mut model, _) = dgd_documents::read_model(super::model::MODEL).unwrap();
    model.friction.mse_pa2 = f64::NAN;
    model.friction.terms[1].coefficient.standard_error = Some(f64::INFINITY);
    let references = MaskReferences::new(FullScale {
        flow_m3_s: 0.06,
        friction_pa: 5e5,
        head_m: 300.0,
        level_m: 200.0,
    })
    .unwrap();
    let text = write_masked_model(&mask_model(&model, &references));
    let table: toml::Table = text.parse().unwrap();
    assert!(table["friction"]["rmse_pct"].as_float().unwrap().is_nan());
    assert_eq!(table["friction"]["term"][1]["power"].as_integer(), Some(2));
    // 1.2e8 Pa/(m3/s)^2 in % of 5e5 Pa by (% of 0.06 m3/s)^2.
    let d = table["friction"]["term"][1]["value"].as_float().unwrap();
    assert!((d - 1.2e8 * 6e-4 * 6e-4 / 5e3).abs() < 1e-12, "{d}");
    assert!(!text.contains("350.3") && !text.contains("1080"), "{text}");
    let balance = &table["balance"];
    assert_eq!(balance["depth_in_head_pct"].as_float(), Some(0.0));
    // An outlet 6 m deeper, in % of 300 m of head.
    model.geometry.pump_outlet_depth_m = model.geometry.pump_inlet_depth_m + 6.0;
    let text = write_masked_model(&mask_model(&model, &references));
    let table: toml::Table = text.parse().unwrap();
    let deeper = table["balance"]["depth_in_head_pct"].as_float().unwrap();
    assert!((deeper - 2.0).abs() < 1e-9, "{deeper}");
}
