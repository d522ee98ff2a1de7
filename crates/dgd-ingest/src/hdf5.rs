//! MAT v7.3 files, which are HDF5 behind a text header, and plain HDF5 files of columns.
//!
//! A reader of our own for what MATLAB (and h5py in its default and `latest` settings)
//! writes: superblocks 0 to 3, old and new groups, compact, contiguous and chunked data
//! sets with gzip, shuffle and fletcher32. Every address is checked against the file
//! before it is followed, every size against what the file can hold before memory is
//! asked for. Groups come as dotted names, in the order of the file's index.

mod chunks;
mod dataset;
mod dense;
mod file;
mod group;
mod object;

use std::collections::HashSet;

use dgd_recording::{IssueKind, Table};

use crate::error::IngestError;
use crate::mat::{
    Collector, Fault, FaultKind, Layout, MAX_DEPTH, MAX_TEXT, Number, NumberKind, Sink, join,
};
use chunks::{Chunk, Filters, Unfilter};
use dataset::{Chunked, Datatype, Index, Storage};
use file::File;
use object::{Attribute, Object, Value, to_usize};

const FORMAT: &str = "MAT v7.3";
/// HDF5's own limit is 4 GiB; MATLAB's chunks are far below a megabyte.
const MAX_CHUNK_BYTES: u64 = 64 << 20;
/// Deflate cannot expand more than 1032 times.
const MAX_EXPANSION: u64 = 1040;
/// A data set of this size is read whatever was stored of it.
const SMALL_BYTES: u64 = 64 << 10;

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

    fn dataset(
        &mut self,
        tag: &str,
        address: u64,
        object: &Object<'a>,
        labels: &Labels<'_>,
    ) -> Result<(), Fault> {
        let missing =
            |what: &str| Fault::damaged(self.file.place(address), format!("it has no {what}"));
        let kind = object
            .message(object::DATATYPE)
            .ok_or_else(|| missing("data type"))?;
        let space = object
            .message(object::DATASPACE)
            .ok_or_else(|| missing("dataspace"))?;
        let layout = object
            .message(object::LAYOUT)
            .ok_or_else(|| missing("storage layout"))?;
        if kind.shared || space.shared || layout.shared {
            self.collector
                .skip(tag, "its type is shared with other data sets");
            return Ok(());
        }
        if labels.is_set("MATLAB_empty") {
            self.collector.skip(tag, "it is empty");
            return Ok(());
        }
        let class = labels.text("MATLAB_class").unwrap_or("");
        if labels.has("MATLAB_object_decode") || matches!(class, "cell" | "function_handle") {
            self.collector.skip(
                tag,
                format!("it is a {class}, which only MATLAB can open: save its columns as doubles"),
            );
            return Ok(());
        }
        let datatype = Datatype::read(&mut kind.body.clone())?;
        let mut dims = dataset::dims(&mut space.body.clone())?;
        let number = match datatype {
            Datatype::Number(number) => number,
            Datatype::Text { size } => return self.text(tag, &dims, layout, size),
            Datatype::LongText => {
                self.collector.skip(tag, "it is text");
                return Ok(());
            }
            Datatype::Other(what) => {
                self.collector.skip(tag, format!("it is {what}"));
                return Ok(());
            }
        };
        let storage = match Storage::read(
            &self.file,
            &mut layout.body.clone(),
            dims.len(),
            number.size(),
        )? {
            Ok(storage) => storage,
            Err(reason) => {
                self.collector.skip(tag, reason);
                return Ok(());
            }
        };
        let filters = match object.message(object::FILTERS) {
            Some(message) if message.shared => {
                self.collector
                    .skip(tag, "its filters are shared with other data sets");
                return Ok(());
            }
            Some(message) => match Filters::read(message.body.clone())? {
                Ok(filters) => filters,
                Err(reason) => {
                    self.collector.skip(tag, reason);
                    return Ok(());
                }
            },
            None => Filters::default(),
        };
        let fill = object
            .message(object::FILL_VALUE)
            .filter(|m| !m.shared)
            .map_or(0.0, |m| dataset::fill_value(m.body.clone(), number));
        if class == "char" {
            return self.characters(tag, &dims, number, &storage, &filters);
        }
        let whole = dims.clone();
        dims.reverse();
        let layout = match Layout::of(&dims) {
            Ok(layout) if self.collector.has_room(tag, layout) => layout,
            Ok(_) => return Ok(()),
            Err(reason) => {
                self.collector.skip(tag, reason);
                return Ok(());
            }
        };
        for word in ["units", "unit"] {
            if let Some(unit) = labels.text(word).map(str::trim).filter(|u| !u.is_empty()) {
                self.collector.unit(tag, unit.to_owned());
                break;
            }
        }
        let sink = match storage {
            Storage::Compact(bytes) => self.in_one_piece(tag, bytes, number, layout)?,
            Storage::Contiguous(Some((at, size))) => {
                let bytes = self.file.bytes(at, size)?;
                self.in_one_piece(tag, bytes, number, layout)?
            }
            Storage::Contiguous(None) => {
                self.collector.skip(tag, "no value was ever written to it");
                return Ok(());
            }
            Storage::Chunked(chunked) => {
                self.chunked(tag, &chunked, &whole, number, layout, &filters, fill)?
            }
        };
        self.collector.array(tag, sink);
        Ok(())
    }

    fn in_one_piece(
        &mut self,
        tag: &str,
        bytes: &[u8],
        number: Number,
        layout: Layout,
    ) -> Result<Sink, Fault> {
        let claimed = layout.len() as u64;
        if claimed.checked_mul(number.size() as u64) != Some(bytes.len() as u64) {
            return Err(Fault::damaged(
                format!("`{tag}`"),
                format!(
                    "{claimed} values by its sides, but {} bytes of values",
                    bytes.len()
                ),
            ));
        }
        self.collector.charge(tag, claimed)?;
        let mut sink = Sink::new(layout, layout.len());
        sink.append(bytes, number);
        Ok(sink)
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "one data set has this many sides to it"
    )]
    fn chunked(
        &mut self,
        tag: &str,
        chunked: &Chunked,
        dims: &[u64],
        number: Number,
        layout: Layout,
        filters: &Filters,
        fill: f64,
    ) -> Result<Sink, Fault> {
        let element = number.size();
        let chunk_values = chunked
            .sides
            .iter()
            .fold(1_u64, |n, &s| n.saturating_mul(s));
        let chunk_bytes = chunk_values.saturating_mul(element as u64);
        if chunk_bytes > MAX_CHUNK_BYTES {
            return Err(Fault::too_large(
                format!("a chunk of `{tag}`"),
                chunk_bytes,
                MAX_CHUNK_BYTES,
            ));
        }
        if chunked.index == Index::Implicit {
            // Nothing is stored of such a chunk but its values; its place in the list costs more.
            let grid = dims.iter().zip(&chunked.sides).map(|(d, s)| d.div_ceil(*s));
            let cells = grid.fold(1_u64, |n, g| n.saturating_mul(g));
            let each = 10 + dims.len() as u64;
            self.collector.charge(tag, cells.saturating_mul(each))?;
        }
        let list = chunks::list(&self.file, chunked, dims, chunk_bytes, !filters.is_empty())?;
        let stored = list.iter().fold(0_u64, |n, c| n.saturating_add(c.size));
        if stored > self.file.data.len() as u64 {
            return Err(Fault::damaged(
                format!("`{tag}`"),
                format!(
                    "its chunks claim {stored} bytes, the file has {}",
                    self.file.data.len()
                ),
            ));
        }
        // What the stored bytes can inflate to bounds the columns and the work.
        let expansion = if filters.deflates() { MAX_EXPANSION } else { 1 };
        let most = stored.saturating_mul(expansion).saturating_add(SMALL_BYTES);
        let values = layout.len() as u64;
        let claimed = values.saturating_mul(element as u64);
        let work = (list.len() as u64).saturating_mul(chunk_bytes);
        if claimed > most || work > most {
            return Err(Fault::too_large(
                format!("`{tag}` (bytes)"),
                claimed.max(work),
                most,
            ));
        }
        self.collector
            .charge(tag, values.max(work / element as u64))?;
        let mut sink = Sink::filled(layout, fill);
        let mut decoded = Vec::new();
        for chunk in &list {
            let result = match self.file.bytes(chunk.address, chunk.size) {
                Err(fault) => Err((fault.kind, fault.reason)),
                Ok(stored) => self
                    .unfilter
                    .undo(
                        stored,
                        filters,
                        chunk.skipped,
                        element,
                        to_usize(chunk_bytes),
                    )
                    .map_err(|reason| (FaultKind::Damaged, reason)),
            };
            decoded.clear();
            let trouble = match result {
                Ok(bytes) => {
                    number.extend(bytes, &mut decoded);
                    None
                }
                Err(trouble) => {
                    decoded.resize(to_usize(chunk_values), f64::NAN);
                    Some(trouble)
                }
            };
            let placed = place(&mut sink, &decoded, chunk, &chunked.sides, dims);
            if let Some((kind, reason)) = trouble {
                let kind = if kind == FaultKind::Truncated {
                    IssueKind::Truncated
                } else {
                    IssueKind::Damaged
                };
                self.collector.issue(
                    kind,
                    format!("{} (`{tag}`)", self.file.place(chunk.address)),
                    format!("a chunk is lost: {reason}; its {placed} values are NaN"),
                );
            }
        }
        Ok(sink)
    }

    /// Fixed-size text of a file that MATLAB did not write.
    fn text(
        &mut self,
        tag: &str,
        dims: &[u64],
        layout: &object::Message<'a>,
        size: u32,
    ) -> Result<(), Fault> {
        let element = to_usize(size.into());
        let one = dims.iter().all(|&d| d == 1) && u64::from(size) <= MAX_TEXT;
        let storage = Storage::read(&self.file, &mut layout.body.clone(), dims.len(), element)?;
        let bytes = match storage {
            Ok(Storage::Compact(bytes)) if one => bytes,
            Ok(Storage::Contiguous(Some((at, length)))) if one => {
                self.file.bytes(at, length.min(MAX_TEXT))?
            }
            _ => {
                self.collector.skip(tag, "it is text");
                return Ok(());
            }
        };
        self.collector.text(tag, object::text(bytes));
        Ok(())
    }

    /// MATLAB's text: 16-bit characters.
    fn characters(
        &mut self,
        tag: &str,
        dims: &[u64],
        number: Number,
        storage: &Storage<'a>,
        filters: &Filters,
    ) -> Result<(), Fault> {
        let count = dims.iter().fold(1_u64, |n, &d| n.saturating_mul(d));
        let line = dims.iter().filter(|&&d| d > 1).count() <= 1;
        if number.kind != NumberKind::U16 || count > MAX_TEXT || !line {
            self.collector.skip(tag, "it is a block of text");
            return Ok(());
        }
        let layout = Layout {
            columns: 1,
            rows: to_usize(count),
            interleaved: false,
        };
        let sink = match storage {
            Storage::Compact(bytes) => self.in_one_piece(tag, bytes, number, layout)?,
            Storage::Contiguous(Some((at, size))) => {
                let bytes = self.file.bytes(*at, *size)?;
                self.in_one_piece(tag, bytes, number, layout)?
            }
            Storage::Contiguous(None) => return Ok(()),
            Storage::Chunked(chunked) => {
                self.chunked(tag, chunked, dims, number, layout, filters, 0.0)?
            }
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "they were 16-bit characters a line above"
        )]
        let units = sink.into_columns().into_iter().flatten().map(|v| v as u16);
        let text = char::decode_utf16(units)
            .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect();
        self.collector.text(tag, text);
        Ok(())
    }
}

/// Puts a chunk where it belongs, less what hangs over the sides; returns how many
/// values that were.
fn place(sink: &mut Sink, values: &[f64], chunk: &Chunk, sides: &[u64], dims: &[u64]) -> u64 {
    let Some(last) = dims.len().checked_sub(1) else {
        sink.put(0, values);
        return values.len() as u64;
    };
    // How much of the chunk lies inside, side by side.
    let inside: Vec<u64> = (0..dims.len())
        .map(|d| dims[d].saturating_sub(chunk.start[d]).min(sides[d]))
        .collect();
    if inside.contains(&0) {
        return 0;
    }
    let run = inside[last];
    let runs: u64 = inside[..last].iter().product();
    for index in 0..runs {
        // Where this run begins in the chunk and in the data set.
        let (mut rest, mut from, mut to) = (index, 0, chunk.start[last]);
        let (mut from_step, mut to_step) = (sides[last], dims[last]);
        for d in (0..last).rev() {
            let at = rest % inside[d];
            rest /= inside[d];
            from += at * from_step;
            to += (chunk.start[d] + at) * to_step;
            from_step *= sides[d];
            to_step *= dims[d];
        }
        let from = to_usize(from);
        if let Some(values) = values.get(from..from + to_usize(run)) {
            sink.put(to_usize(to), values);
        }
    }
    runs * run
}
