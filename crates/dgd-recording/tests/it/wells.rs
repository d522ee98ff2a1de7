//! A well, a table that fits it, and ways to break them.

use dgd_recording::{ChannelMap, ChannelSource, Column, Geometry, Table, TimeSource, Well};
use dgd_units::Unit;

pub(crate) fn unit(text: &str) -> Unit {
    Unit::parse(text).unwrap()
}

pub(crate) fn source(tag: &str, unit_text: &str) -> ChannelSource {
    ChannelSource::column(tag, unit(unit_text))
}

pub(crate) fn column(tag: &str, unit: &str, values: &[f64]) -> Column {
    Column {
        tag: tag.into(),
        unit: Some(unit.into()),
        values: values.to_vec(),
    }
}

/// Table 2.1 and Table 2.2 of the thesis.
pub(crate) fn well() -> Well {
    Well {
        mud_density_kg_m3: 1080.0,
        geometry: Geometry {
            riser_id_m: 0.4953,
            drillpipe_od_m: 0.168_275,
            casing_od_m: None,
            return_line_id_m: 0.1524,
            booster_line_id_m: None,
            pump_inlet_depth_m: 350.3,
            pump_outlet_depth_m: 350.3,
            riser_pressure_sensor_depth_m: Some(352.1),
        },
        channels: ChannelMap {
            time: TimeSource::Column {
                tag: "t".into(),
                unit: unit("s"),
            },
            mud_pump_flow: source("FT1", "gpm"),
            booster_flow: source("FT2", "gpm"),
            topfill_flow: source("FT3", "gpm"),
            return_flow: source("FT4", "gpm"),
            pump_inlet_pressure: vec![source("PT1", "psia"), source("PT2", "psia")],
            pump_outlet_pressure: vec![source("PT3", "psia"), source("PT4", "psia")],
            riser_pressure: Some(source("PT5", "psia")),
            pump_speed: source("SPM", "%"),
        },
    }
}

/// A table that fits, at these stamps; each channel counts from its own level.
pub(crate) fn table(time_s: &[f64]) -> Table {
    let channels = [
        ("FT1", "gpm", 500.0),
        ("FT2", "gpm", 200.0),
        ("FT3", "gpm", 30.0),
        ("FT4", "gpm", 730.0),
        ("PT1", "psia", 350.0),
        ("PT2", "psia", 352.0),
        ("PT3", "psia", 590.0),
        ("PT4", "psia", 592.0),
        ("PT5", "psia", 353.0),
        ("SPM", "%", 50.0),
    ];
    let mut columns = vec![column("gom.t", "s", time_s)];
    columns.extend(channels.map(|(tag, unit, level)| {
        let values: Vec<f64> = (0..time_s.len()).map(|i| level + 0.01 * i as f64).collect();
        column(&format!("gom.{tag}"), unit, &values)
    }));
    Table {
        columns,
        ..Table::default()
    }
}
