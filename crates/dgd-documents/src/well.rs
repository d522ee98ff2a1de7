//! `well.toml`: the mud, the geometry and the channels of a recording.

use crate::mistaken::{Kind, mistaken};
use crate::reader::{Notes, Section, Value, parse};
use crate::{DocumentError, Problem};
use dgd_recording::{Added, ChannelMap, ChannelSource, Geometry, TimeSource, Well};
use dgd_units::{Dimension, Unit, UnitError};
use std::fmt::Write as _;
use toml::de::DeTable;

/// Reads `well.toml` (its schema is in this crate's README).
///
/// Returns the well and warnings about keys that are not read.
///
/// # Errors
/// [`DocumentError`] with every problem found, each at its place in `source`.
///
/// ```
/// let error = dgd_documents::read_well("[mud]\ndensity = \"1.08 psi\"\n").unwrap_err();
/// assert!(error.to_string().starts_with("line 1, column 1: the section [geometry] is missing"));
/// assert_eq!(error.places[2], (2, 11));
/// ```
pub fn read_well(source: &str) -> Result<(Well, Vec<Problem>), DocumentError> {
    let document = parse(source)?;
    mistaken(source, document.get_ref(), Kind::Well)?;
    let notes = Notes::default();
    let root = Section::new("", 0..source.len(), document.get_ref(), &notes);
    let mud = root.need_section("mud");
    let geometry = root.need_section("geometry");
    let channels = root.need_section("channels");
    root.warn_of_unread();
    let mud_density_kg_m3 = mud.and_then(|mud| {
        let density = mud.need_positive("density", Dimension::Density, "1.08 sg");
        mud.warn_of_unread();
        density
    });
    let geometry = geometry.and_then(|section| read_geometry(&section));
    let channels = channels.and_then(|section| read_channels(&section));
    let well = match (mud_density_kg_m3, geometry, channels) {
        (Some(mud_density_kg_m3), Some(geometry), Some(channels)) => Some(Well {
            mud_density_kg_m3,
            geometry,
            channels,
        }),
        _ => None,
    };
    notes.conclude(source, well)
}

/// Line of `well.toml` in which a key of a section stands, counted from 1; of several transmitters
/// the one with this number, counted from 0. `None` where the text has no such.
///
/// ```
/// let text = "[mud]\ndensity = \"1.08 sg\"\n";
/// assert_eq!(dgd_documents::well_line(text, "mud", "density", None), Some(2));
/// assert_eq!(dgd_documents::well_line(text, "mud", "viscosity", None), None);
/// ```
pub fn well_line(
    source: &str,
    section: &str,
    key: &str,
    transmitter: Option<usize>,
) -> Option<usize> {
    let document = parse(source).ok()?;
    let section = entry(document.get_ref(), section)?;
    let value = entry(section.get_ref().as_table()?, key)?;
    let list = value.get_ref().as_array();
    let one = transmitter.and_then(|n| list.and_then(|list| list.get(n)));
    let span = one.unwrap_or(value).span();
    Some(crate::line_and_column(source, span.start).0)
}

fn entry<'a, 'i>(table: &'a DeTable<'i>, key: &str) -> Option<&'a Value<'i>> {
    let mut entries = table.iter();
    entries.find(|(k, _)| k.get_ref() == key).map(|(_, v)| v)
}

pub(crate) fn read_geometry(section: &Section<'_, '_>) -> Option<Geometry> {
    let length = |key, example| section.need_positive(key, Dimension::Length, example);
    let optional = |key, example| section.optional_positive(key, Dimension::Length, example);
    // All are read before any is given up, so that every problem is told at once.
    let riser_id_m = length("riser_id", "19.5 in");
    let drillpipe_od_m = length("drillpipe_od", "6.625 in");
    let casing_od_m = optional("casing_od", "13 5/8 in");
    let return_line_id_m = length("return_line_id", "6 in");
    let booster_line_id_m = optional("booster_line_id", "4 in");
    let pump_inlet_depth_m = length("pump_inlet_depth", "350.3 m");
    let pump_outlet_depth_m = length("pump_outlet_depth", "350.3 m");
    let riser_pressure_sensor_depth_m = optional("riser_pressure_sensor_depth", "352.1 m");
    section.warn_of_unread();
    let geometry = Geometry {
        riser_id_m: riser_id_m?,
        drillpipe_od_m: drillpipe_od_m?,
        casing_od_m,
        return_line_id_m: return_line_id_m?,
        booster_line_id_m,
        pump_inlet_depth_m: pump_inlet_depth_m?,
        pump_outlet_depth_m: pump_outlet_depth_m?,
        riser_pressure_sensor_depth_m,
    };
    if geometry.drillpipe_od_m >= geometry.riser_id_m {
        section.notes().problem(
            section.span(),
            format!(
                "the drill pipe ({:.4} m) does not fit into the riser ({:.4} m)",
                geometry.drillpipe_od_m, geometry.riser_id_m
            ),
            Some("check `drillpipe_od` and `riser_id`, and their units".into()),
        );
        return None;
    }
    Some(geometry)
}

fn read_channels(section: &Section<'_, '_>) -> Option<ChannelMap> {
    let one = |key, dimension, example: &str| {
        section
            .need(key, example)
            .and_then(|value| read_source(section, key, value, dimension))
    };
    let flow = |tag| format!("{{ tag = \"{tag}\", unit = \"gpm\" }}");
    let pumped = |key, tag, absent: &str| {
        let value = section.need(key, &format!("{}{absent}", flow(tag)))?;
        read_sum(section, key, value)
    };
    let none = "  # or \"0 gpm\" if the rig has none";
    let several = |key, tag| {
        let example = format!("[{{ tag = \"{tag}\", unit = \"psia\" }}]");
        let value = section.need(key, &example)?;
        let Some(list) = value.get_ref().as_array() else {
            return read_source(section, key, value, Dimension::Pressure)
                .map(|source| vec![source]);
        };
        let sources: Vec<_> = list
            .iter()
            .filter_map(|v| read_source(section, key, v, Dimension::Pressure))
            .collect();
        if list.is_empty() {
            section.problem(
                value,
                format!("`{key}` lists no transmitter"),
                Some(format!("such as {example}")),
            );
        }
        (sources.len() == list.len() && !sources.is_empty()).then_some(sources)
    };
    let time = section
        .need("time", "{ tag = \"t\", unit = \"s\" }")
        .and_then(|value| read_time(section, value));
    let mud_pump_flow = pumped("mud_pump_flow", "FT1", "");
    let booster_flow = pumped("booster_flow", "FT2", none);
    let topfill_flow = pumped("topfill_flow", "FT3", none);
    let return_flow = one("return_flow", Dimension::FlowRate, &flow("FT4"));
    let pump_inlet_pressure = several("pump_inlet_pressure", "PT1");
    let pump_outlet_pressure = several("pump_outlet_pressure", "PT3");
    let riser_pressure = section
        .get("riser_pressure")
        .map(|value| read_source(section, "riser_pressure", value, Dimension::Pressure));
    let pump_speed = one(
        "pump_speed",
        Dimension::Percent,
        "{ tag = \"SPM\", unit = \"%\" }",
    );
    section.warn_of_unread();
    Some(ChannelMap {
        time: time?,
        mud_pump_flow: mud_pump_flow?,
        booster_flow: booster_flow?,
        topfill_flow: topfill_flow?,
        return_flow: return_flow?,
        pump_inlet_pressure: pump_inlet_pressure?,
        pump_outlet_pressure: pump_outlet_pressure?,
        riser_pressure: match riser_pressure {
            Some(source) => Some(source?),
            None => None,
        },
        pump_speed: pump_speed?,
    })
}

/// `{ tag = "FT1", unit = "gpm" }`, or a written value for a channel without a transmitter.
fn read_source<'a, 'i>(
    section: &Section<'a, 'i>,
    key: &'static str,
    value: &'a Value<'i>,
    dimension: Dimension,
) -> Option<ChannelSource> {
    if value.get_ref().is_str() {
        let si = section.quantity(
            key,
            value,
            dimension,
            &format!("30 {}", dimension.example()),
        )?;
        return Some(ChannelSource::Constant { si });
    }
    let (tag, unit, late_s) = read_column(section, key, value, dimension)?;
    Some(ChannelSource::Column {
        tag,
        unit,
        late_s,
        added: Vec::new(),
    })
}

/// A source, or a list of columns that are added up.
fn read_sum<'a, 'i>(
    section: &Section<'a, 'i>,
    key: &'static str,
    value: &'a Value<'i>,
) -> Option<ChannelSource> {
    let Some(list) = value.get_ref().as_array() else {
        return read_source(section, key, value, Dimension::FlowRate);
    };
    let columns: Vec<_> = list
        .iter()
        .filter_map(|value| read_column(section, key, value, Dimension::FlowRate))
        .collect();
    if columns.len() < list.len() {
        return None;
    }
    let mut columns = columns.into_iter();
    let Some((tag, unit, late_s)) = columns.next() else {
        section.problem(
            value,
            format!("`{key}` lists no pump"),
            Some(
                "list the columns that are added, or write `\"0 gpm\"` if the rig has none".into(),
            ),
        );
        return None;
    };
    if columns.clone().any(|(.., other_s)| other_s != late_s) {
        section.problem(
            value,
            format!("the columns of `{key}` that are added are late by different times"),
            Some("give all of them the same `late`".into()),
        );
        return None;
    }
    let added = columns.map(|(tag, unit, _)| Added { tag, unit });
    Some(ChannelSource::Column {
        tag,
        unit,
        late_s,
        added: added.collect(),
    })
}

fn read_time<'a, 'i>(section: &Section<'a, 'i>, value: &'a Value<'i>) -> Option<TimeSource> {
    if let Some(table) = value.get_ref().as_table() {
        let inner = Section::new("channels.time", value.span(), table, section.notes());
        if let Some(interval) = inner.get("interval") {
            let step_s = inner.quantity("interval", interval, Dimension::Time, "1 s")?;
            inner.warn_of_unread();
            if step_s > 0.0 {
                return Some(TimeSource::Interval { step_s });
            }
            section.problem(interval, "`interval` must be more than 0".into(), None);
            return None;
        }
    }
    let (tag, unit, _) = read_column(section, "time", value, Dimension::Time)?;
    Some(TimeSource::Column { tag, unit })
}

/// Tag, unit, and the seconds by which the column's stamps are late, which those of the clock cannot be.
fn read_column<'a, 'i>(
    section: &Section<'a, 'i>,
    key: &'static str,
    value: &'a Value<'i>,
    dimension: Dimension,
) -> Option<(String, Unit, f64)> {
    let Some(table) = value.get_ref().as_table() else {
        section.wrong_type(
            key,
            value,
            &format!("{{ tag = \"...\", unit = \"{}\" }}", dimension.example()),
        );
        return None;
    };
    let inner = Section::new(
        &format!("channels.{key}"),
        value.span(),
        table,
        section.notes(),
    );
    let tag = inner
        .need("tag", "\"FT1\"")
        .and_then(|v| inner.text("tag", v).map(|text| (v, text)));
    let unit = inner.need("unit", &format!("\"{}\"", dimension.example()));
    let unit = unit.and_then(|v| {
        let written = inner.text("unit", v)?;
        match Unit::parse_as(written, dimension) {
            Ok(unit) => Some(unit),
            Err(UnitError::WrongDimension {
                is: Dimension::RotationalSpeed,
                ..
            }) if dimension == Dimension::Percent => of_full_speed(&inner, key, v, written),
            Err(UnitError::WrongDimension {
                is: Dimension::RotationalSpeed,
                ..
            }) if dimension == Dimension::FlowRate => of_strokes(&inner, key, v, written),
            Err(error) => {
                let of_percent = matches!(
                    error,
                    UnitError::WrongDimension { is: Dimension::Percent, expected: Dimension::FlowRate, .. }
                );
                let help = of_percent.then(|| {
                    "a paddle or a meter in percent must be calibrated first: add a column with its flow, such as from the strokes of the mud \
                     pump while the level stands"
                        .to_owned()
                });
                section.problem(v, format!("`unit` of `{key}`: {error}"), help);
                None
            }
        }
    });
    let late = (dimension != Dimension::Time).then(|| inner.get("late"));
    let late_s = match late.flatten() {
        Some(late) => inner.quantity("late", late, Dimension::Time, "20 s")?,
        None => 0.0,
    };
    inner.warn_of_unread();
    let (place, tag) = tag?;
    if tag.is_empty() {
        section.problem(place, format!("`tag` of `{key}` is empty"), None);
        return None;
    }
    Some((tag.to_owned(), unit?, late_s))
}

/// A tachometer's unit, `full` of which is 100 %.
fn of_full_speed<'a, 'i>(
    inner: &Section<'a, 'i>,
    key: &str,
    place: &Value<'i>,
    written: &str,
) -> Option<Unit> {
    let Some(full) = inner.get("full") else {
        inner.problem(
            place,
            format!("`unit` of `{key}`: `{written}` can be converted to percent only with the full speed"),
            Some("add the 100 % value, such as `full = \"1800 rpm\"`".into()),
        );
        return None;
    };
    let full = inner.positive("full", full, Dimension::RotationalSpeed, "1800 rpm")?;
    let unit = Unit::parse(written).and_then(|unit| unit.in_percent_of(unit.from_si(full)));
    unit.map_err(|error| inner.problem(place, format!("`full` of `{key}`: {error}"), None))
        .ok()
}

/// The unit of a flow that is told in strokes, each of which displaces a `stroke`.
fn of_strokes<'a, 'i>(
    inner: &Section<'a, 'i>,
    key: &str,
    place: &Value<'i>,
    written: &str,
) -> Option<Unit> {
    let Some(stroke) = inner.get("stroke") else {
        inner.problem(
            place,
            format!("`unit` of `{key}`: `{written}` can be converted to a flow only with the volume of a stroke"),
            Some("add what a stroke displaces, efficiency included, such as `stroke = \"15.9 L\"`".into()),
        );
        return None;
    };
    let stroke_m3 = inner.positive("stroke", stroke, Dimension::Volume, "15.9 L")?;
    let unit = Unit::parse(written).and_then(|unit| unit.in_flow_of(stroke_m3));
    unit.map_err(|error| inner.problem(place, format!("`stroke` of `{key}`: {error}"), None))
        .ok()
}

/// The keys of a column's source: tag, unit, for a tachometer the reading at 100 %, for strokes their volume, and what its stamps are late by.
fn column_keys(tag: &str, unit: &Unit, late_s: f64) -> String {
    let mut keys = format!("tag = {}, unit = \"{unit}\"", quoted(tag));
    if late_s != 0.0 {
        keys += &format!(", late = \"{late_s} s\"");
    }
    if unit.dimension == Dimension::Percent && unit.factor != 1.0 {
        let full = shortest(100.0 / unit.factor, |full| 100.0 / full == unit.factor);
        keys += &format!(", full = \"{full} {unit}\"");
    }
    if unit.dimension == Dimension::FlowRate && unit.counts_turns() {
        let turns = Unit::parse_as(unit.symbol, Dimension::RotationalSpeed);
        let read_as = |m3: f64| turns.as_ref().ok()?.in_flow_of(m3).ok();
        let one = read_as(1.0).map_or(1.0, |unit| unit.factor);
        let m3 = shortest(unit.factor / one, |m3| read_as(m3) == Some(*unit));
        keys += &format!(", stroke = \"{m3} m3\"");
    }
    format!("{{ {keys} }}")
}

/// The shortest number near `exact` that is read as the same.
fn shortest(exact: f64, same: impl Fn(f64) -> bool) -> f64 {
    let shorter = (0..17).map(|digits| format!("{exact:.digits$e}").parse().unwrap_or(exact));
    shorter
        .into_iter()
        .find(|number| same(*number))
        .unwrap_or(exact)
}

/// Writes a well as `well.toml`; [`read_well`] gives the same well back.
pub fn write_well(well: &Well) -> String {
    let geometry = &well.geometry;
    let mut text = String::from("# Well and channel description of a recording.\n[mud]\n");
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "density = \"{} kg/m3\"\n\n[geometry]",
        well.mud_density_kg_m3
    );
    for (key, length_m) in lengths_of(geometry) {
        let _ = writeln!(text, "{key} = \"{length_m} m\"");
    }
    let map = &well.channels;
    let _ = match &map.time {
        TimeSource::Column { tag, unit } => {
            writeln!(text, "\n[channels]\ntime = {}", column_keys(tag, unit, 0.0))
        }
        TimeSource::Interval { step_s } => {
            writeln!(text, "\n[channels]\ntime = {{ interval = \"{step_s} s\" }}")
        }
    };
    let one = |source: &ChannelSource, dimension: Dimension| match source {
        ChannelSource::Column {
            tag,
            unit,
            late_s,
            added,
        } => {
            let mut columns = vec![column_keys(tag, unit, *late_s)];
            columns.extend(added.iter().map(|a| column_keys(&a.tag, &a.unit, *late_s)));
            match columns.as_slice() {
                [only] => only.clone(),
                several => format!("[{}]", several.join(", ")),
            }
        }
        ChannelSource::Constant { si } => format!("\"{si} {}\"", dimension.si_symbol()),
    };
    let several = |sources: &[ChannelSource]| {
        let list: Vec<String> = sources
            .iter()
            .map(|s| one(s, Dimension::Pressure))
            .collect();
        format!("[{}]", list.join(", "))
    };
    let lines = [
        (
            "mud_pump_flow",
            Some(one(&map.mud_pump_flow, Dimension::FlowRate)),
        ),
        (
            "booster_flow",
            Some(one(&map.booster_flow, Dimension::FlowRate)),
        ),
        (
            "topfill_flow",
            Some(one(&map.topfill_flow, Dimension::FlowRate)),
        ),
        (
            "return_flow",
            Some(one(&map.return_flow, Dimension::FlowRate)),
        ),
        (
            "pump_inlet_pressure",
            Some(several(&map.pump_inlet_pressure)),
        ),
        (
            "pump_outlet_pressure",
            Some(several(&map.pump_outlet_pressure)),
        ),
        (
            "riser_pressure",
            map.riser_pressure
                .as_ref()
                .map(|s| one(s, Dimension::Pressure)),
        ),
        ("pump_speed", Some(one(&map.pump_speed, Dimension::Percent))),
    ];
    for (key, line) in lines {
        if let Some(line) = line {
            let _ = writeln!(text, "{key} = {line}");
        }
    }
    text
}

/// Keys and values of the lengths that are known.
pub(crate) fn lengths_of(geometry: &Geometry) -> impl Iterator<Item = (&'static str, f64)> {
    [
        ("riser_id", Some(geometry.riser_id_m)),
        ("drillpipe_od", Some(geometry.drillpipe_od_m)),
        ("casing_od", geometry.casing_od_m),
        ("return_line_id", Some(geometry.return_line_id_m)),
        ("booster_line_id", geometry.booster_line_id_m),
        ("pump_inlet_depth", Some(geometry.pump_inlet_depth_m)),
        ("pump_outlet_depth", Some(geometry.pump_outlet_depth_m)),
        (
            "riser_pressure_sensor_depth",
            geometry.riser_pressure_sensor_depth_m,
        ),
    ]
    .into_iter()
    .filter_map(|(key, length_m)| length_m.map(|length_m| (key, length_m)))
}

/// A TOML basic string on one line, fit for a key too (keys may not be multi-line strings).
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => {
                quoted.push('\\');
                quoted.push(c);
            }
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
