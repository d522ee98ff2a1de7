//! Arrays of any stored type, as columns of doubles.

/// A matrix whose shorter side is longer than this is a picture, not channels.
const MAX_MATRIX_COLUMNS: u64 = 1024;

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Number {
    pub(crate) kind: NumberKind,
    pub(crate) big_endian: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberKind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    /// Bytes of one value.
    pub(crate) fn size(self) -> usize {
        match self.kind {
            NumberKind::I8 | NumberKind::U8 => 1,
            NumberKind::I16 | NumberKind::U16 => 2,
            NumberKind::I32 | NumberKind::U32 | NumberKind::F32 => 4,
            NumberKind::I64 | NumberKind::U64 | NumberKind::F64 => 8,
        }
    }

    /// Appends every whole value of `bytes`; 64-bit integers round to the nearest double.
    pub(crate) fn extend(self, bytes: &[u8], out: &mut Vec<f64>) {
        macro_rules! widen {
            ($t:ty) => {{
                let (items, _) = bytes.as_chunks::<{ size_of::<$t>() }>();
                if self.big_endian {
                    out.extend(items.iter().map(|b| <$t>::from_be_bytes(*b) as f64));
                } else {
                    out.extend(items.iter().map(|b| <$t>::from_le_bytes(*b) as f64));
                }
            }};
        }
        match self.kind {
            NumberKind::I8 => widen!(i8),
            NumberKind::U8 => widen!(u8),
            NumberKind::I16 => widen!(i16),
            NumberKind::U16 => widen!(u16),
            NumberKind::I32 => widen!(i32),
            NumberKind::U32 => widen!(u32),
            NumberKind::I64 => widen!(i64),
            NumberKind::U64 => widen!(u64),
            NumberKind::F32 => widen!(f32),
            NumberKind::F64 => widen!(f64),
        }
    }
}

/// How the values of an array fall into columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Neighbours in the file belong to neighbouring columns (a wide matrix).
    pub(crate) interleaved: bool,
}

impl Layout {
    /// For an array of these sides, fastest first; the longer side is time.
    ///
    /// `Err` says why it is no table of channels.
    pub(crate) fn of(dims: &[u64]) -> Result<Self, String> {
        let sides: Vec<u64> = dims.iter().copied().filter(|&d| d != 1).collect();
        if sides.contains(&0) {
            return Err("it is empty".into());
        }
        let (first, second) = match sides[..] {
            [] => (1, 1),
            [n] => (n, 1),
            [n, m] => (n, m),
            _ => {
                return Err(format!(
                    "it has {} sides, only columns and matrices are read",
                    sides.len()
                ));
            }
        };
        let (columns, rows) = (first.min(second), first.max(second));
        if columns > MAX_MATRIX_COLUMNS {
            return Err(format!(
                "it is {first} x {second}, more than {MAX_MATRIX_COLUMNS} channels"
            ));
        }
        match (usize::try_from(columns), usize::try_from(rows)) {
            (Ok(columns), Ok(rows)) if columns.checked_mul(rows).is_some() => Ok(Self {
                columns,
                rows,
                interleaved: first < second && columns > 1,
            }),
            _ => Err(format!("{first} x {second} does not fit this machine")),
        }
    }

    /// Number of values; [`Layout::of`] has seen that it does not overflow.
    pub(crate) fn len(self) -> usize {
        self.columns * self.rows
    }
}

/// Takes the values of one array in the order of the file.
#[derive(Debug)]
pub(crate) struct Sink {
    layout: Layout,
    columns: Vec<Vec<f64>>,
    filled: usize,
    scratch: Vec<f64>,
}

/// Values decoded at a time where they must be spread over columns.
const SPREAD: usize = 4096;

impl Sink {
    /// Reserves at most `allowance` values ahead; the rest grows as values really come.
    pub(crate) fn new(layout: Layout, allowance: usize) -> Self {
        let ahead = layout.rows.min(allowance / layout.columns.max(1));
        Self {
            layout,
            columns: (0..layout.columns)
                .map(|_| Vec::with_capacity(ahead))
                .collect(),
            filled: 0,
            scratch: Vec::new(),
        }
    }

    /// Filled with `value`, for [`Sink::put`]; the caller has checked the size.
    pub(crate) fn filled(layout: Layout, value: f64) -> Self {
        Self {
            layout,
            columns: vec![vec![value; layout.rows]; layout.columns],
            filled: layout.len(),
            scratch: Vec::new(),
        }
    }

    /// Appends whole values; any beyond the layout are dropped.
    pub(crate) fn append(&mut self, bytes: &[u8], number: Number) {
        let size = number.size();
        let mut bytes = bytes;
        while bytes.len() >= size && self.filled < self.layout.len() {
            let (column, row) = self.cell(self.filled);
            let run = if self.layout.interleaved {
                SPREAD
            } else {
                self.layout.rows - row
            };
            let count = run
                .min(bytes.len() / size)
                .min(self.layout.len() - self.filled);
            let (now, rest) = bytes.split_at(count * size);
            if self.layout.interleaved {
                self.scratch.clear();
                number.extend(now, &mut self.scratch);
                for (i, &value) in self.scratch.iter().enumerate() {
                    self.columns[(self.filled + i) % self.layout.columns].push(value);
                }
            } else {
                let values = &mut self.columns[column];
                if values.capacity() < values.len() + count {
                    // Doubling, but never beyond the end of the column.
                    values.reserve_exact(count.max(values.len()).min(self.layout.rows - row));
                }
                number.extend(now, values);
            }
            self.filled += count;
            bytes = rest;
        }
    }

    /// Overwrites from the `start`-th value on; any beyond the layout are dropped.
    pub(crate) fn put(&mut self, start: usize, values: &[f64]) {
        let room = self.layout.len().saturating_sub(start);
        let values = &values[..values.len().min(room)];
        if self.layout.interleaved {
            for (i, &value) in values.iter().enumerate() {
                let (column, row) = self.cell(start + i);
                self.columns[column][row] = value;
            }
            return;
        }
        let mut done = 0;
        while done < values.len() {
            let (column, row) = self.cell(start + done);
            let count = (self.layout.rows - row).min(values.len() - done);
            self.columns[column][row..row + count].copy_from_slice(&values[done..done + count]);
            done += count;
        }
    }

    pub(crate) fn layout(&self) -> Layout {
        self.layout
    }

    pub(crate) fn into_columns(self) -> Vec<Vec<f64>> {
        self.columns
    }

    fn cell(&self, index: usize) -> (usize, usize) {
        if self.layout.interleaved {
            (index % self.layout.columns, index / self.layout.columns)
        } else {
            (index / self.layout.rows, index % self.layout.rows)
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    const F64: Number = Number {
        kind: NumberKind::F64,
        big_endian: false,
    };

    fn bytes(values: &[f64]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    #[test]
    fn the_longer_side_of_a_matrix_is_time() {
        let tall = Layout::of(&[5, 2]).unwrap();
        assert_eq!((tall.columns, tall.rows, tall.interleaved), (2, 5, false));
        let wide = Layout::of(&[2, 5]).unwrap();
        assert_eq!((wide.columns, wide.rows, wide.interleaved), (2, 5, true));
        let row = Layout::of(&[1, 5]).unwrap();
        assert_eq!((row.columns, row.rows, row.interleaved), (1, 5, false));
    }

    #[test]
    fn empty_deep_and_picture_sized_arrays_are_no_channels() {
        assert!(Layout::of(&[0, 3]).is_err());
        assert!(Layout::of(&[2, 3, 4]).is_err());
        assert!(Layout::of(&[1025, 1025]).is_err());
        assert!(Layout::of(&[u64::MAX, 2]).is_err());
    }

    #[test]
    fn appending_in_pieces_and_putting_at_once_agree() {
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        for dims in [[6, 2], [2, 6], [12, 1], [1, 12]] {
            let layout = Layout::of(&dims).unwrap();
            let mut pieces = Sink::new(layout, 0);
            for piece in bytes(&values).chunks(40) {
                pieces.append(piece, F64);
            }
            let mut whole = Sink::filled(layout, f64::NAN);
            whole.put(0, &values[..7]);
            whole.put(7, &values[7..]);
            assert_eq!(pieces.columns, whole.columns, "{dims:?}");
        }
    }

    #[test]
    fn values_beyond_the_layout_are_dropped() {
        let layout = Layout::of(&[2, 1]).unwrap();
        let mut sink = Sink::new(layout, 8);
        sink.append(&bytes(&[1.0, 2.0, 3.0]), F64);
        assert_eq!(sink.columns, [[1.0, 2.0]]);
        sink.put(1, &[5.0, 6.0]);
        assert_eq!(sink.columns, [[1.0, 5.0]]);
        sink.put(7, &[5.0]);
    }

    #[test]
    fn every_stored_type_widens_in_both_byte_orders() {
        for (kind, le) in [
            (NumberKind::I8, vec![0xFE]),
            (NumberKind::I16, vec![0xFE, 0xFF]),
            (NumberKind::I32, vec![0xFE, 0xFF, 0xFF, 0xFF]),
            (NumberKind::I64, (-2i64).to_le_bytes().to_vec()),
            (NumberKind::F32, (-2f32).to_le_bytes().to_vec()),
            (NumberKind::F64, (-2f64).to_le_bytes().to_vec()),
        ] {
            for big_endian in [false, true] {
                let mut b = le.clone();
                if big_endian {
                    b.reverse();
                }
                let number = Number { kind, big_endian };
                let mut out = Vec::new();
                number.extend(&b, &mut out);
                assert_eq!(out, [-2.0], "{number:?}");
                assert_eq!(number.size(), b.len());
            }
        }
    }
}
