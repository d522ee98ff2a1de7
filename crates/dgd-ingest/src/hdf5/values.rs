//! The values of one data set: what it is, how they are stored, and the way into columns.

use super::chunks::{self, Chunk, Filters};
use super::dataset::{self, Chunked, Datatype, Index, Storage};
use super::object::{self, Object, to_usize};
use super::{Labels, Reader};
use crate::mat::{Fault, FaultKind, Layout, MAX_TEXT, Number, NumberKind, Sink};
use dgd_recording::IssueKind;

/// HDF5's own limit is 4 GiB; MATLAB's chunks are far below a megabyte.
const MAX_CHUNK_BYTES: u64 = 64 << 20;
/// Deflate cannot expand more than 1032 times.
const MAX_EXPANSION: u64 = 1040;
/// A data set of this size is read whatever was stored of it.
const SMALL_BYTES: u64 = 64 << 10;

/// Why a data set gives no column.
enum Stop {
    /// It is sound, and nothing for a table.
    Skipped(String),
    /// It is damaged, or too large.
    Faulty(Fault),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Self::Faulty(fault)
    }
}

fn skipped<T>(reason: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::Skipped(reason.into()))
}

/// Numbers and how they are stored.
struct Stored<'a> {
    number: Number,
    /// Sides as in the file: the last runs fastest.
    dims: Vec<u64>,
    storage: Storage<'a>,
    filters: Filters,
    /// Value of what was never written.
    fill: f64,
}

impl<'a> Reader<'a> {
    /// Reads a data set into a column, some columns or a text, or notes why not.
    pub(super) fn dataset(
        &mut self,
        tag: &str,
        address: u64,
        object: &Object<'a>,
        labels: &Labels<'_>,
    ) -> Result<(), Fault> {
        match self.values(tag, address, object, labels) {
            Err(Stop::Skipped(reason)) => {
                self.collector.skip(tag, reason);
                Ok(())
            }
            Err(Stop::Faulty(fault)) => Err(fault),
            Ok(()) => Ok(()),
        }
    }

    fn values(
        &mut self,
        tag: &str,
        address: u64,
        object: &Object<'a>,
        labels: &Labels<'_>,
    ) -> Result<(), Stop> {
        let message = |kind: u16, what: &str| {
            object.message(kind).ok_or_else(|| {
                Fault::damaged(self.file.place(address), format!("it has no {what}"))
            })
        };
        let kind = message(object::DATATYPE, "data type")?;
        let space = message(object::DATASPACE, "dataspace")?;
        let layout = message(object::LAYOUT, "storage layout")?;
        if kind.shared || space.shared || layout.shared {
            return skipped("its type is shared with other data sets");
        }
        if labels.is_set("MATLAB_empty") {
            return skipped("it is empty");
        }
        let class = labels.text("MATLAB_class").unwrap_or("");
        if labels.has("MATLAB_object_decode") || matches!(class, "cell" | "function_handle") {
            return skipped(format!(
                "it is a {class}, which only MATLAB can open: save its columns as doubles"
            ));
        }
        let datatype = Datatype::read(&mut kind.body.clone())?;
        let dims = dataset::dims(&mut space.body.clone())?;
        let number = match datatype {
            Datatype::Number(number) => number,
            Datatype::Text { size } => return self.text(tag, &dims, layout, size),
            Datatype::LongText => return skipped("it is text"),
            Datatype::Other(what) => return skipped(format!("it is {what}")),
        };
        let stored = self.stored(object, layout, number, dims)?;
        if class == "char" {
            return self.characters(tag, &stored);
        }
        let sides: Vec<u64> = stored.dims.iter().rev().copied().collect();
        let layout = Layout::of(&sides).or_else(skipped)?;
        if !self.collector.has_room(tag, layout) {
            return Ok(());
        }
        for word in ["units", "unit"] {
            if let Some(unit) = labels.text(word).map(str::trim).filter(|u| !u.is_empty()) {
                self.collector.unit(tag, unit.to_owned());
                break;
            }
        }
        match self.sink(tag, &stored, layout)? {
            Some(sink) => self.collector.array(tag, sink),
            None => return skipped("no value was ever written to it"),
        }
        Ok(())
    }

    /// How numbers are stored, by the messages of their object.
    fn stored(
        &self,
        object: &Object<'a>,
        layout: &object::Message<'a>,
        number: Number,
        dims: Vec<u64>,
    ) -> Result<Stored<'a>, Stop> {
        let mut place = layout.body.clone();
        let storage = Storage::read(&self.file, &mut place, dims.len(), number.size())?;
        let storage = storage.or_else(skipped)?;
        let filters = match object.message(object::FILTERS) {
            Some(message) if message.shared => {
                return skipped("its filters are shared with other data sets");
            }
            Some(message) => Filters::read(message.body.clone())?.or_else(skipped)?,
            None => Filters::default(),
        };
        let fill = object
            .message(object::FILL_VALUE)
            .filter(|m| !m.shared)
            .map_or(0.0, |m| dataset::fill_value(m.body.clone(), number));
        Ok(Stored {
            number,
            dims,
            storage,
            filters,
            fill,
        })
    }

    /// The values; `None` where none was ever written.
    fn sink(
        &mut self,
        tag: &str,
        stored: &Stored<'a>,
        layout: Layout,
    ) -> Result<Option<Sink>, Fault> {
        let bytes = match &stored.storage {
            Storage::Compact(bytes) => bytes,
            Storage::Contiguous(Some((at, size))) => self.file.bytes(*at, *size)?,
            Storage::Contiguous(None) => return Ok(None),
            Storage::Chunked(chunked) => {
                return self.chunked(tag, chunked, stored, layout).map(Some);
            }
        };
        let claimed = layout.len() as u64;
        if claimed.checked_mul(stored.number.size() as u64) != Some(bytes.len() as u64) {
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
        sink.append(bytes, stored.number);
        Ok(Some(sink))
    }

    fn chunked(
        &mut self,
        tag: &str,
        chunked: &Chunked,
        stored: &Stored<'a>,
        layout: Layout,
    ) -> Result<Sink, Fault> {
        let Stored { number, dims, .. } = stored;
        let element = number.size();
        let chunk_values = (chunked.sides.iter()).fold(1_u64, |n, &s| n.saturating_mul(s));
        let chunk_bytes = chunk_values.saturating_mul(element as u64);
        let list = self.chunks(tag, chunked, stored, layout, chunk_bytes)?;
        let mut sink = Sink::filled(layout, stored.fill);
        let mut decoded = Vec::new();
        for chunk in &list {
            let bytes = match self.file.bytes(chunk.address, chunk.size) {
                Err(fault) => Err((fault.kind, fault.reason)),
                Ok(bytes) => {
                    let (filters, size) = (&stored.filters, to_usize(chunk_bytes));
                    (self
                        .unfilter
                        .undo(bytes, filters, chunk.skipped, element, size))
                    .map_err(|reason| (FaultKind::Damaged, reason))
                }
            };
            decoded.clear();
            let trouble = match bytes {
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

    /// The chunks of a data set, once memory and work are bounded by what the file can hold.
    fn chunks(
        &mut self,
        tag: &str,
        chunked: &Chunked,
        stored: &Stored<'a>,
        layout: Layout,
        chunk_bytes: u64,
    ) -> Result<Vec<Chunk>, Fault> {
        let Stored { dims, filters, .. } = stored;
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
        let bytes = list.iter().fold(0_u64, |n, c| n.saturating_add(c.size));
        if bytes > self.file.data.len() as u64 {
            return Err(Fault::damaged(
                format!("`{tag}`"),
                format!(
                    "its chunks claim {bytes} bytes, the file has {}",
                    self.file.data.len()
                ),
            ));
        }
        // What the stored bytes can inflate to bounds the columns and the work.
        let expansion = if filters.deflates() { MAX_EXPANSION } else { 1 };
        let most = bytes.saturating_mul(expansion).saturating_add(SMALL_BYTES);
        let element = stored.number.size() as u64;
        let values = layout.len() as u64;
        let claimed = values.saturating_mul(element);
        let work = (list.len() as u64).saturating_mul(chunk_bytes);
        if claimed > most || work > most {
            return Err(Fault::too_large(
                format!("`{tag}` (bytes)"),
                claimed.max(work),
                most,
            ));
        }
        self.collector.charge(tag, values.max(work / element))?;
        Ok(list)
    }

    /// Fixed-size text of a file that MATLAB did not write.
    fn text(
        &mut self,
        tag: &str,
        dims: &[u64],
        layout: &object::Message<'a>,
        size: u32,
    ) -> Result<(), Stop> {
        let element = to_usize(size.into());
        let one = dims.iter().all(|&d| d == 1) && u64::from(size) <= MAX_TEXT;
        let storage = Storage::read(&self.file, &mut layout.body.clone(), dims.len(), element)?;
        let bytes = match storage {
            Ok(Storage::Compact(bytes)) if one => bytes,
            Ok(Storage::Contiguous(Some((at, length)))) if one => {
                self.file.bytes(at, length.min(MAX_TEXT))?
            }
            _ => return skipped("it is text"),
        };
        self.collector.text(tag, object::text(bytes));
        Ok(())
    }

    /// MATLAB's text: 16-bit characters.
    fn characters(&mut self, tag: &str, stored: &Stored<'a>) -> Result<(), Stop> {
        let dims = &stored.dims;
        let count = dims.iter().fold(1_u64, |n, &d| n.saturating_mul(d));
        let line = dims.iter().filter(|&&d| d > 1).count() <= 1;
        if stored.number.kind != NumberKind::U16 || count > MAX_TEXT || !line {
            return skipped("it is a block of text");
        }
        let layout = Layout {
            columns: 1,
            rows: to_usize(count),
            interleaved: false,
        };
        let Some(sink) = self.sink(tag, stored, layout)? else {
            return Ok(());
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
