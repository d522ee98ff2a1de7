//! MCAP logs.

use crate::ExportError;
use crate::number::push;
use crate::origin;
use ::mcap::records::MessageHeader;
use ::mcap::{Compression, WriteOptions};
use dgd_recording::{Column, Table, survey};
use dgd_units::{Dimension, Unit};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

/// How to write an MCAP log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct McapOptions {
    /// Column that is the clock. Default: `t`, or else the column that
    /// [`dgd_recording::survey`] takes for one.
    pub time_tag: Option<String>,
    /// Topic of the samples. Default: `/rig`.
    pub topic: String,
}

impl Default for McapOptions {
    fn default() -> Self {
        Self {
            time_tag: None,
            topic: "/rig".into(),
        }
    }
}

/// No recording is longer than this, s; a larger time is an epoch, not a time from the start.
const LONGEST_S: f64 = 5e8;

/// Writes a table as an MCAP log: one topic, one JSON message a sample, with a JSON
/// Schema that says each member's unit (in `unit` and in `description`), so that
/// Foxglove plots it as it is.
///
/// The time column becomes the log time, in whole nanoseconds after the table's origin
/// (after zero, if it has none), and is no member. Other values have the fewest digits
/// that read back to the same `f64`; NaN is `null`, and so is what a shorter column
/// lacks. JSON has no infinity: it becomes `null` too. Chunks are zstd, with checksums.
///
/// # Errors
/// [`ExportError`]: no such time column, a time that is missing or negative, equal
/// names, an origin that is no time, or a writer that fails.
///
/// ```
/// use dgd_export::{McapOptions, write_mcap};
/// use dgd_recording::{Column, Table};
/// let column = |tag: &str, unit: &str| Column {
///     tag: tag.into(), unit: Some(unit.into()), values: vec![0.0, 1.0],
/// };
/// let table = Table { columns: vec![column("t", "s"), column("FT4", "gpm")], ..Table::default() };
/// let mut log = std::io::Cursor::new(Vec::new());
/// write_mcap(&table, &McapOptions::default(), &mut log)?;
/// assert!(log.get_ref().starts_with(b"\x89MCAP0\r\n"));
/// # Ok::<(), dgd_export::ExportError>(())
/// ```
pub fn write_mcap(
    table: &Table,
    options: &McapOptions,
    writer: impl Write + Seek,
) -> Result<(), ExportError> {
    crate::check_names(table)?;
    let (time, factor) = clock(table, options.time_tag.as_deref())?;
    let start_ns = table.origin.as_deref().map_or(Ok(0), |text| {
        origin::nanoseconds(text).ok_or_else(|| ExportError::Origin {
            found: text.to_owned(),
        })
    })?;
    let members: Vec<&Column> = table
        .columns
        .iter()
        .filter(|c| !std::ptr::eq(*c, time))
        .collect();
    // One thread: the number of threads must not show in the bytes.
    let mut log = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .profile("")
        .library(concat!("dgd-export ", env!("CARGO_PKG_VERSION")))
        .create(writer)?;
    let schema = schema(&members);
    let schema_id = log.add_schema("dgd.Sample", "jsonschema", &schema)?;
    let channel_id = log.add_channel(schema_id, &options.topic, "json", &BTreeMap::new())?;
    // `"FT4": ` and what stands before it, once and not for every sample.
    let heads: Vec<Vec<u8>> = members
        .iter()
        .enumerate()
        .map(|(i, c)| head(i, &c.tag))
        .collect();
    let mut message = Vec::new();
    for row in 0..table.rows() {
        let seconds = time.values.get(row).map_or(f64::NAN, |t| t * factor);
        if !(0.0..=LONGEST_S).contains(&seconds) {
            return Err(ExportError::TimeValue {
                index: row,
                found: seconds,
            });
        }
        message.clear();
        message.push(b'{');
        for (column, head) in members.iter().zip(&heads) {
            message.extend_from_slice(head);
            match column.values.get(row) {
                Some(value) if value.is_finite() => push(&mut message, *value),
                _ => message.extend_from_slice(b"null"),
            }
        }
        message.push(b'}');
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within 0 to 5e17"
        )]
        let log_time = start_ns + (seconds * 1e9).round() as u64;
        let header = MessageHeader {
            channel_id,
            sequence: u32::try_from(row).unwrap_or(u32::MAX),
            log_time,
            publish_time: log_time,
        };
        log.write_to_known_channel(&header, &message)?;
    }
    log.finish()?;
    Ok(())
}

/// The time column and the seconds in one of its units.
fn clock<'a>(table: &'a Table, tag: Option<&str>) -> Result<(&'a Column, f64), ExportError> {
    let surveyed = || survey(table).time_column.map(|index| &table.columns[index]);
    let time = match tag {
        Some(tag) => table.column(tag),
        None => table.column("t").or_else(surveyed),
    };
    let time = time.ok_or_else(|| ExportError::NoTime {
        tag: tag.unwrap_or("t").to_owned(),
        present: table
            .columns
            .iter()
            .take(24)
            .map(|c| c.tag.as_str())
            .collect::<Vec<_>>()
            .join(", "),
    })?;
    let Some(written) = &time.unit else {
        return Ok((time, 1.0));
    };
    match Unit::parse(written) {
        Ok(unit) if unit.dimension == Dimension::Time => Ok((time, unit.factor)),
        _ => Err(ExportError::TimeUnit {
            tag: time.tag.clone(),
            found: written.clone(),
        }),
    }
}

/// Put together as text, so that members stand in the order of the columns.
fn schema(members: &[&Column]) -> Vec<u8> {
    let properties: Vec<String> = members
        .iter()
        .map(|column| {
            let unit = column.unit.as_ref().map_or_else(String::new, |unit| {
                format!(
                    r#","unit":{},"description":{}"#,
                    json!(unit),
                    json!(format!("unit: {unit}"))
                )
            });
            format!(r#"{}:{{"type":"number"{unit}}}"#, json!(column.tag))
        })
        .collect();
    let properties = properties.join(",");
    format!(r#"{{"title":"dgd.Sample","type":"object","properties":{{{properties}}}}}"#)
        .into_bytes()
}

fn head(index: usize, tag: &str) -> Vec<u8> {
    let comma = if index > 0 { "," } else { "" };
    format!("{comma}{}:", json!(tag)).into_bytes()
}
