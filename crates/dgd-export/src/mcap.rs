//! MCAP logs.

use crate::ExportError;
use crate::number::push;
use ::mcap::records::MessageHeader;
use ::mcap::{Compression, WriteOptions};
use dgd_recording::{Column, Table, survey};
use dgd_units::{Dimension, Unit};
use serde_json::json;
use std::collections::BTreeMap;
use std::fmt;
use std::io::{Seek, Write};

/// How to write an MCAP log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct McapOptions {
    /// Column that is the clock. Default: [`Table::clock`], else the column that is named `t` and nothing else, else the one that
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

/// What readers of this workspace call the clock of a log that does not name it.
const UNNAMED_CLOCK: &str = "t";

/// Metadata of the channel that name the clock.
const CLOCK_TAG: &str = "time_tag";

/// Metadata of the channel, and their value, of log times that are of an unknown zone.
const ZONE: &str = "time_zone";
const UNKNOWN_ZONE: &str = "unknown";

/// No recording is longer than this, s; a larger time is an epoch, not a time from the start.
const LONGEST_S: f64 = 5e8;

/// Writes a table as an MCAP log: one topic, one JSON message a sample, with a JSON
/// Schema that says each member's unit (in `unit` and in `description`), so that
/// Foxglove plots it as it is.
///
/// The time column becomes the log time, in whole nanoseconds after the table's origin
/// (after zero, if it has none), and is no member; the channel's metadata name it in `time_tag`, and say
/// `time_zone: unknown` if the origin ends in `-00:00`. Other values have the fewest digits
/// that read back to the same `f64`; NaN is `null`, and so is what a shorter column
/// lacks. JSON has no infinity: it becomes `null` too. Chunks are zstd, with checksums.
///
/// # Errors
/// [`ExportError`]: no such time column, no other column beside it, a time that is missing or negative, equal
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
    let mut options = options.clone();
    if options.time_tag.is_none() && told_clock(table).is_none() {
        let found = survey(table).time_column;
        options.time_tag = found.map(|index| table.columns[index].tag.clone());
    }
    let mut log = McapWriter::new(table, &options, writer)?;
    log.write(table)?;
    log.finish()
}

/// An MCAP log that is written block by block, as [`write_mcap`] writes it at once.
///
/// Without [`Self::finish`] it has neither end nor index, and a failure to write the last chunk is lost.
#[must_use = "call `finish`"]
pub struct McapWriter<W: Write + Seek> {
    log: ::mcap::Writer<W>,
    channel_id: u16,
    columns: usize,
    /// Column that is the clock, and seconds in one of its units.
    time: usize,
    factor: f64,
    start_ns: u64,
    /// `"FT4": ` and what stands before it, for every column but the clock.
    heads: Vec<(usize, Vec<u8>)>,
    rows: usize,
    message: Vec<u8>,
}

impl<W: Write + Seek> fmt::Debug for McapWriter<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("McapWriter");
        shown.field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl<W: Write + Seek> McapWriter<W> {
    /// Begins with the names, the units and the origin of `head`, whose values are left out.
    ///
    /// The clock is the column of [`McapOptions::time_tag`], else that of [`Table::clock`], else `t`.
    ///
    /// # Errors
    /// Those of [`write_mcap`] that no value can cause.
    pub fn new(head: &Table, options: &McapOptions, writer: W) -> Result<Self, ExportError> {
        crate::check_names(head)?;
        let (time, factor) = clock(head, options.time_tag.as_deref())?;
        if head.columns.len() == 1 {
            return Err(ExportError::OnlyTime {
                tag: head.columns[time].tag.clone(),
            });
        }
        let start_ns = head.origin.as_deref().map_or(Ok(0), |text| {
            head.origin_ns().ok_or_else(|| ExportError::Origin {
                found: text.to_owned(),
            })
        })?;
        let members = || (head.columns.iter().enumerate()).filter(|(index, _)| *index != time);
        // One thread: the number of threads must not show in the bytes.
        let mut log = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .compression_threads(0)
            .profile("")
            .library(concat!("dgd-export ", env!("CARGO_PKG_VERSION")))
            .create(writer)
            .map_err(failed)?;
        let schema = schema(members().map(|(_, column)| column));
        let schema_id = log
            .add_schema("dgd.Sample", "jsonschema", &schema)
            .map_err(failed)?;
        let clock_tag = &head.columns[time].tag;
        let mut metadata = BTreeMap::new();
        if clock_tag != UNNAMED_CLOCK {
            metadata.insert(CLOCK_TAG.to_owned(), clock_tag.clone());
        }
        if (head.origin.as_deref()).is_some_and(|origin| origin.trim_end().ends_with("-00:00")) {
            metadata.insert(ZONE.to_owned(), UNKNOWN_ZONE.to_owned());
        }
        let channel_id = log
            .add_channel(schema_id, &options.topic, "json", &metadata)
            .map_err(failed)?;
        let heads = members().enumerate();
        Ok(Self {
            log,
            channel_id,
            columns: head.columns.len(),
            time,
            factor,
            start_ns,
            heads: heads
                .map(|(nth, (index, column))| (index, member(nth, &column.tag)))
                .collect(),
            rows: 0,
            message: Vec::new(),
        })
    }

    /// Appends a message a row, in columns as those of the head.
    ///
    /// # Errors
    /// [`ExportError::Width`], [`ExportError::TimeValue`] or [`ExportError::Mcap`].
    pub fn write(&mut self, block: &Table) -> Result<(), ExportError> {
        crate::check_width(block, self.columns)?;
        let message = &mut self.message;
        for row in 0..block.rows() {
            let time = block.columns[self.time].values.get(row);
            let seconds = time.map_or(f64::NAN, |t| t * self.factor);
            if !(0.0..=LONGEST_S).contains(&seconds) {
                return Err(ExportError::TimeValue {
                    index: self.rows,
                    found: seconds,
                });
            }
            message.clear();
            message.push(b'{');
            for (index, head) in &self.heads {
                message.extend_from_slice(head);
                match block.columns[*index].values.get(row) {
                    Some(value) if value.is_finite() => push(message, *value),
                    _ => message.extend_from_slice(b"null"),
                }
            }
            message.push(b'}');
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "within 0 to 5e17"
            )]
            let log_time = self.start_ns + (seconds * 1e9).round() as u64;
            let header = MessageHeader {
                channel_id: self.channel_id,
                sequence: u32::try_from(self.rows).unwrap_or(u32::MAX),
                log_time,
                publish_time: log_time,
            };
            self.log
                .write_to_known_channel(&header, message)
                .map_err(failed)?;
            self.rows += 1;
        }
        Ok(())
    }

    /// Closes the log.
    ///
    /// # Errors
    /// [`ExportError::Mcap`].
    pub fn finish(mut self) -> Result<(), ExportError> {
        self.log.finish().map_err(failed)?;
        Ok(())
    }
}

fn failed(error: ::mcap::McapError) -> ExportError {
    ExportError::Mcap(Box::new(error))
}

/// The column that the table says is its clock, or that is named as one by convention.
fn told_clock(head: &Table) -> Option<usize> {
    let told = head.clock.filter(|index| *index < head.columns.len());
    told.or_else(|| head.columns.iter().position(|c| c.tag == UNNAMED_CLOCK))
}

/// Index of the time column, which may be given by its tag, and the seconds in one of its units.
fn clock(head: &Table, tag: Option<&str>) -> Result<(usize, f64), ExportError> {
    let found = tag.map_or_else(|| told_clock(head), |tag| head.find(tag));
    let index = found.ok_or_else(|| ExportError::NoTime {
        tag: tag.unwrap_or(UNNAMED_CLOCK).to_owned(),
        present: head
            .columns
            .iter()
            .take(24)
            .map(|c| c.tag.as_str())
            .collect::<Vec<_>>()
            .join(", "),
    })?;
    let time = &head.columns[index];
    let Some(written) = &time.unit else {
        return Ok((index, 1.0));
    };
    match Unit::parse(written) {
        Ok(unit) if unit.dimension == Dimension::Time => Ok((index, unit.factor)),
        _ => Err(ExportError::TimeUnit {
            tag: time.tag.clone(),
            found: written.clone(),
        }),
    }
}

/// Put together as text, so that members stand in the order of the columns.
fn schema<'a>(members: impl Iterator<Item = &'a Column>) -> Vec<u8> {
    let properties: Vec<String> = members
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

/// What stands before a member's value in a message.
fn member(index: usize, tag: &str) -> Vec<u8> {
    let comma = if index > 0 { "," } else { "" };
    format!("{comma}{}:", json!(tag)).into_bytes()
}
