//! The README shows what the readers read.

use dgd_documents::{read_model, read_well, write_model, write_well};
use dgd_recording::ChannelSource;

fn example(start: &str) -> &'static str {
    let blocks = include_str!("../../README.md").split("```toml\n").skip(1);
    let mut texts = blocks.filter_map(|rest| rest.split("```").next());
    texts.find(|text| text.starts_with(start)).unwrap()
}

/// Keys and sections of a document, with the dots of their path.
fn keys(table: &toml::Table, path: &str, found: &mut Vec<String>) {
    for (key, value) in table {
        let path = format!("{path}.{key}");
        match value {
            toml::Value::Table(inner) if !inner.contains_key("tag") => keys(inner, &path, found),
            _ => found.push(path.trim_start_matches('.').to_owned()),
        }
    }
}

#[test]
fn the_well_of_the_readme_has_every_key_and_no_other() {
    let (well, warnings) = read_well(example("[mud]")).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let geometry = &well.geometry;
    assert!(geometry.casing_od_m.is_some() && geometry.booster_line_id_m.is_some());
    assert!(geometry.riser_pressure_sensor_depth_m.is_some());
    assert!(well.channels.riser_pressure.is_some());
    assert!(matches!(
        well.channels.topfill_flow,
        ChannelSource::Constant { .. }
    ));
    let mut written = Vec::new();
    keys(&write_well(&well).parse().unwrap(), "", &mut written);
    for key in written {
        let row = format!("\n| `{key}` |");
        assert!(include_str!("../../README.md").contains(&row), "{key}");
    }
}

#[test]
fn the_model_of_the_readme_is_read_and_written_alike() {
    let text = example("schema");
    let (model, warnings) = read_model(text).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let again: toml::Table = write_model(&model).parse().unwrap();
    assert_eq!(again, text.parse().unwrap());
}
