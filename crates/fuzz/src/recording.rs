//! What must hold of every recording, sound or hostile.
//!
//! `dgd-ingest` includes this file in its tests, so that the stable toolchain holds it too.

use dgd_ingest::{
    BlockError, BlockOptions, BlockReader, Format, IngestError, Opened, ReadOptions, detect, read,
};
use dgd_recording::{
    ChannelMap, ChannelSource, Geometry, Recording, Table, TimeSource, Well, propose_channels,
    survey, survey_clock,
};
use dgd_units::{Dimension, Unit};
use std::io::Cursor;

/// Reads the whole file as a user's call does; `None` if it is of another format.
///
/// # Panics
/// If a table has no column or more cells than `bytes` may hold, or an error says nothing.
pub fn table(bytes: &[u8], format: Format) -> Option<Result<Table, IngestError>> {
    if detect(bytes) != Ok(format) {
        return None;
    }
    let result = read(bytes, &ReadOptions::default()).map(|(_, table)| table);
    match &result {
        Ok(table) => {
            let cells: usize = table.columns.iter().map(|c| c.values.len()).sum();
            let most = most_cells(format, bytes.len());
            assert!(!table.columns.is_empty(), "a table without a column");
            assert!(
                cells <= most,
                "{cells} cells of {} bytes, at most {most}",
                bytes.len()
            );
            assert!(table.issues.iter().all(|i| !i.message.is_empty()));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    Some(result)
}

/// Cells that a file of this size may hold, as the README of `dgd-ingest` states it.
pub fn most_cells(format: Format, bytes: usize) -> usize {
    match format {
        Format::Mat5 | Format::Mat73 => (1040 * bytes + (1 << 16))
            .min((1 << 23) + 25 * bytes)
            .min(1 << 28),
        // Those of tags that have a reading a line each.
        Format::Csv => 4 * bytes + (1 << 20),
        // Every other byte of what the chunks may unpack to, and the clock beside.
        _ => (64 << 20) + 1000 * bytes + (1 << 20),
    }
}

/// Bytes that reading may take at the same time, beside the file and the window of a zstd frame.
pub fn most_memory(format: Format, bytes: usize) -> usize {
    const MIB: usize = 1 << 20;
    match format {
        // The columns, the column that is growing, a chunk, and buffers.
        Format::Mat5 | Format::Mat73 => 3 * 8 * most_cells(format, bytes) + 2 * MIB,
        Format::Csv => 20 * MIB + 64 * bytes,
        _ => 40 * MIB + 3000 * bytes,
    }
}

/// Reads the file again block by block, with little memory; says how many blocks there were, if it can be read so.
///
/// # Panics
/// If the blocks are not what was read of the whole file.
pub fn in_blocks(bytes: &[u8], whole: &Result<Table, IngestError>) -> Option<usize> {
    let (length, last) = (bytes.len(), bytes.last().copied().unwrap_or(0));
    let limits = BlockOptions {
        bytes: 256 << (length % 4),
        cells: 1 << (last % 12),
    };
    let options = ReadOptions::default();
    let mut reader = match BlockReader::open(Cursor::new(bytes), &options, limits) {
        Ok(Opened::Blocks(reader)) => reader,
        Ok(Opened::Whole(_)) => return None,
        Err(BlockError::Content(error)) => {
            assert_eq!(whole.as_ref().err(), Some(&error), "of the whole file");
            return None;
        }
        Err(error) => panic!("bytes in memory: {error}"),
    };
    let Ok(whole) = whole else {
        // Cells are counted over blocks, so that a member that comes late is counted late.
        assert!(matches!(whole, Err(IngestError::TooLarge { .. })));
        return None;
    };
    let mut blocks = 0;
    for _pass in 0..2 {
        blocks = 0;
        let mut found = reader.head().clone();
        while let Some(block) = reader.next_block().expect("it was read before") {
            blocks += 1;
            for (column, more) in found.columns.iter_mut().zip(&block.columns) {
                column.values.extend_from_slice(&more.values);
            }
        }
        assert_eq!(reader.rows(), found.rows());
        assert_same(&found, whole);
        reader.rewind();
    }
    Some(blocks)
}

/// The same to the bit, NaN the same as NaN.
fn assert_same(found: &Table, expected: &Table) {
    assert_eq!(found.issues, expected.issues);
    assert_eq!(found.origin, expected.origin);
    assert_eq!(found.columns.len(), expected.columns.len());
    for (found, expected) in found.columns.iter().zip(&expected.columns) {
        let tag = &expected.tag;
        assert_eq!((&found.tag, &found.unit), (tag, &expected.unit));
        assert_eq!(found.values.len(), expected.values.len(), "`{tag}`");
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
        let mut pairs = found.values.iter().zip(&expected.values);
        let other = pairs.position(|(a, b)| !same(*a, *b));
        assert_eq!(other, None, "`{tag}`: a sample that differs");
    }
}

/// Goes on as the program does: what is in it, which column is which, one even clock.
///
/// # Panics
/// If the channels are not as long as their clock, or the clock is out of proportion.
pub fn structure(table: Table) {
    let survey = survey(&table);
    let proposal = propose_channels(&survey);
    for channel in &proposal.channels {
        assert!(
            table.column(&channel.tag).is_some()
                || table.columns.iter().any(|c| c.tag == channel.tag)
        );
        assert!(
            Unit::parse(&channel.unit).is_ok(),
            "unit `{}`",
            channel.unit
        );
    }
    let rows = table.rows();
    let Some(well) = well(&table, survey.time_column) else {
        return;
    };
    let Ok((recording, _)) = Recording::from_table(table, &well) else {
        return;
    };
    let samples = recording.len();
    assert!(samples <= rows);
    if let Ok(clock) = survey_clock(&recording.time_s) {
        let steps = clock.steps();
        assert!(
            steps <= 100_001.max(20 * samples + 1),
            "{steps} steps of {samples} samples"
        );
        // Longer ones are no other, and take a thousand times as long.
        if steps > 10_000 {
            return;
        }
    }
    if let Ok((recording, step_s, _)) = recording.onto_grid() {
        assert!(step_s > 0.0);
        assert!(
            recording
                .series()
                .iter()
                .all(|(_, values)| values.len() == recording.len())
        );
    }
}

/// The table's clock and its first other column as return flow; no other transmitter.
fn well(table: &Table, time: Option<usize>) -> Option<Well> {
    let seconds = Unit::parse("s").ok()?;
    let gpm = Unit::parse("gpm").ok()?;
    assert_eq!(gpm.dimension, Dimension::FlowRate);
    let tag = |index: usize| table.columns[index].tag.clone();
    let flow = (0..table.columns.len()).find(|i| Some(*i) != time)?;
    let constant = || ChannelSource::Constant { si: 1.0 };
    Some(Well {
        mud_density_kg_m3: 1080.0,
        geometry: Geometry {
            riser_id_m: 0.495,
            drillpipe_od_m: 0.168,
            casing_od_m: None,
            return_line_id_m: 0.152,
            booster_line_id_m: None,
            pump_inlet_depth_m: 350.0,
            pump_outlet_depth_m: 350.0,
            riser_pressure_sensor_depth_m: None,
        },
        channels: ChannelMap {
            time: match time {
                Some(index) => TimeSource::Column {
                    tag: tag(index),
                    unit: seconds,
                },
                None => TimeSource::Interval { step_s: 1.0 },
            },
            mud_pump_flow: constant(),
            booster_flow: constant(),
            topfill_flow: constant(),
            return_flow: ChannelSource::column(tag(flow), gpm),
            pump_inlet_pressure: vec![constant()],
            pump_outlet_pressure: vec![constant()],
            riser_pressure: None,
            pump_speed: constant(),
        },
    })
}
