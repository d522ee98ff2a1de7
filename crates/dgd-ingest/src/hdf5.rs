//! MAT v7.3 files, which are HDF5 behind a text header, and plain HDF5 files of columns.
//!
//! A reader of our own for what MATLAB (and h5py in its default and `latest` settings)
//! writes: superblocks 0 to 3, old and new groups, compact, contiguous and chunked data
//! sets with gzip, shuffle and fletcher32. Every address is checked against the file
//! before it is followed, every size against what the file can hold before memory is
//! asked for. Groups come as dotted names, in the order of the file's index, which is that of the names: MATLAB keeps
//! the order of a struct's fields in `MATLAB_fields`, a list of texts of any length, which is not read.

mod chunks;
mod dataset;
mod dense;
mod file;
mod group;
mod object;
mod values;

use std::collections::HashSet;

use dgd_recording::{IssueKind, Table};

use crate::error::IngestError;
use crate::mat::{Collector, Fault, FaultKind, MAX_DEPTH, join};
use chunks::Unfilter;
use file::File;
use object::{Attribute, Object, Value};

const FORMAT: &str = "MAT v7.3";

/// Reads every numeric data set of a MAT v7.3 or HDF5 file.
///
/// # Errors
/// [`IngestError::Empty`], else what kept the file from giving a single column.
pub(crate) fn read(bytes: &[u8]) -> Result<Table, IngestError> {
    if bytes.is_empty() {
        return Err(IngestError::Empty);
    }
    let mut collector = Collector::new(FORMAT, bytes.len());
    let file = File::open(bytes).map_err(|fault| fault.into_error(FORMAT))?;
    let size = bytes.len() as u64;
    if file.end > size {
        collector.issue(
            IssueKind::Truncated,
            format!("byte {size}"),
            format!(
                "the file should have {} bytes; what can be reached was kept",
                file.end
            ),
        );
    }
    let mut reader = Reader {
        file,
        collector,
        seen: HashSet::new(),
        unfilter: Unfilter::new(),
    };
    if let Err(fault) = reader.object("", file.root, 0) {
        reader
            .collector
            .fault(fault, "the rest of the file was left out");
    }
    reader.collector.finish()
}

struct Reader<'a> {
    file: File<'a>,
    collector: Collector,
    /// Object headers read so far: names may lead round in circles.
    seen: HashSet<u64>,
    unfilter: Unfilter,
}

/// What MATLAB says of an object in its attributes.
struct Labels<'t> {
    attributes: &'t [Attribute],
}

impl Labels<'_> {
    fn text(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find_map(|a| match &a.value {
            Value::Text(text) if a.name == name => Some(text.as_str()),
            _ => None,
        })
    }

    fn has(&self, name: &str) -> bool {
        self.attributes.iter().any(|a| a.name == name)
    }

    fn is_set(&self, name: &str) -> bool {
        self.attributes
            .iter()
            .any(|a| a.name == name && a.value != Value::Number(0.0))
    }
}

impl<'a> Reader<'a> {
    fn object(&mut self, tag: &str, address: u64, depth: usize) -> Result<(), Fault> {
        self.collector.count_part(tag)?;
        if !self.seen.insert(address) {
            self.collector
                .skip(tag, "it is a second name of something read before");
            return Ok(());
        }
        let object = Object::read(&self.file, address)?;
        let attributes = object.attributes();
        let labels = Labels {
            attributes: &attributes,
        };
        match group::links(&self.file, &object)? {
            Some((links, other)) => self.group(tag, links, other, &labels, depth),
            None => self.dataset(tag, address, &object, &labels),
        }
    }

    fn group(
        &mut self,
        tag: &str,
        links: Vec<group::Link>,
        other: usize,
        labels: &Labels<'_>,
        depth: usize,
    ) -> Result<(), Fault> {
        if labels.has("MATLAB_sparse") {
            self.collector
                .skip(tag, "it is sparse, save it as `full(x)`");
            return Ok(());
        }
        if other > 0 {
            self.collector.skip(
                if tag.is_empty() { "the file" } else { tag },
                format!("{other} of its names only point elsewhere (soft links)"),
            );
        }
        for (name, address) in links {
            // MATLAB keeps cells and objects in groups of these names.
            if tag.is_empty() && (name == "#refs#" || name == "#subsystem#") {
                continue;
            }
            let Some(child) = join(tag, &name).filter(|_| depth + 1 < MAX_DEPTH) else {
                self.collector
                    .skip(tag, format!("its parts lie deeper than {MAX_DEPTH} levels"));
                continue;
            };
            let mark = self.collector.mark();
            if let Err(mut fault) = self.object(&child, address, depth + 1) {
                if self.collector.is_full() {
                    return Err(fault);
                }
                self.collector.roll_back(mark);
                if !matches!(fault.kind, FaultKind::TooLarge { .. }) {
                    fault.place = format!("{} (`{child}`)", fault.place);
                }
                self.collector
                    .fault(fault, &format!("`{child}` was left out"));
            }
        }
        Ok(())
    }
}
