//! Public behaviour of `dgd-export`; the round trips through readers are in `dgd-ingest`.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod blocks;
mod comparison;
mod csv;
mod mat;
mod mcap;

use dgd_recording::{Column, Table};

fn column(tag: &str, unit: Option<&str>, values: &[f64]) -> Column {
    Column {
        tag: tag.into(),
        unit: unit.map(Into::into),
        values: values.to_vec(),
    }
}

fn table(columns: Vec<Column>) -> Table {
    Table {
        columns,
        ..Table::default()
    }
}

/// A writer that is full at once.
struct Full;

impl std::io::Write for Full {
    fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
        Err(std::io::ErrorKind::StorageFull.into())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl std::io::Seek for Full {
    fn seek(&mut self, _: std::io::SeekFrom) -> std::io::Result<u64> {
        Ok(0)
    }
}
