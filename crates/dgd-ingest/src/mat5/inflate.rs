//! Inflates one element buffer by buffer, for long ones in a thread that runs ahead.
//!
//! Half of the time goes into first touching the memory of the columns, the other half
//! into inflating; side by side they take the time of one. What comes out is the same.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{Builder, Scope};

use flate2::{Decompress, FlushDecompress, Status};

/// Inflated bytes held at a time. Larger buffers leave the cache, smaller ones
/// make zlib-rs copy its 32 KiB window more often.
pub(super) const BUFFER: usize = 256 * 1024;
/// Buffers under way between the two threads.
const BUFFERS: usize = 3;
/// Shorter elements are done before a thread has started.
const WORTH_A_THREAD: usize = 64 * 1024;

/// What stopped the inflating.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Stop {
    /// The bytes ended before the stream did.
    Ended,
    /// Not a deflate stream from here on, or its checksum is wrong.
    Broken(String),
}

/// Inflates into buffers that it is given.
struct Inflater<'a> {
    inflater: Decompress,
    input: &'a [u8],
    finished: bool,
}

impl<'a> Inflater<'a> {
    fn new(input: &'a [u8]) -> Self {
        Self {
            inflater: Decompress::new(true),
            input,
            finished: false,
        }
    }

    /// Fills the buffer as far as bytes come; 0 at the verified end of the stream.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<usize, Stop> {
        let mut end = 0;
        while !self.finished && end < buffer.len() {
            let (read, written) = (self.inflater.total_in(), self.inflater.total_out());
            let status = self
                .inflater
                .decompress(self.input, &mut buffer[end..], FlushDecompress::None)
                .map_err(|error| Stop::Broken(error.to_string()))?;
            let read = usize::try_from(self.inflater.total_in() - read).unwrap_or(usize::MAX);
            let written =
                usize::try_from(self.inflater.total_out() - written).unwrap_or(usize::MAX);
            self.input = self.input.get(read..).unwrap_or(&[]);
            end = end.saturating_add(written).min(buffer.len());
            if status == Status::StreamEnd {
                self.finished = true;
            } else if read == 0 && written == 0 {
                if end > 0 {
                    break;
                }
                return Err(Stop::Ended);
            }
        }
        Ok(end)
    }
}

/// A supply of inflated buffers.
pub(super) struct Inflate<'a> {
    supply: Supply<'a>,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
}

enum Supply<'a> {
    Here(Box<Inflater<'a>>),
    Ahead {
        full: Receiver<Result<(Vec<u8>, usize), Stop>>,
        empty: Sender<Vec<u8>>,
    },
}

impl<'a> Inflate<'a> {
    /// Over `input`, in a thread of `scope` if it is long.
    pub(super) fn new<'scope>(input: &'a [u8], scope: &'scope Scope<'scope, '_>) -> Self
    where
        'a: 'scope,
    {
        let ahead = if input.len() >= WORTH_A_THREAD {
            run_ahead(input, scope)
        } else {
            None
        };
        match ahead {
            Some(supply) => Self {
                supply,
                buffer: Vec::new(),
                start: 0,
                end: 0,
            },
            None => Self {
                supply: Supply::Here(Box::new(Inflater::new(input))),
                // A small stream must not cost a large buffer.
                buffer: vec![0; input.len().saturating_mul(1040).clamp(1024, BUFFER)],
                start: 0,
                end: 0,
            },
        }
    }

    /// Bytes that are there but not consumed.
    pub(super) fn ready(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    pub(super) fn consume(&mut self, count: usize) {
        self.start = (self.start + count).min(self.end);
    }

    /// Replaces the buffer by the next one; `false` at the verified end of the stream.
    pub(super) fn refill(&mut self) -> Result<bool, Stop> {
        self.start = 0;
        self.end = 0;
        match &mut self.supply {
            Supply::Here(inflater) => self.end = inflater.fill(&mut self.buffer)?,
            Supply::Ahead { full, empty } => {
                let used = std::mem::take(&mut self.buffer);
                if !used.is_empty() {
                    // The thread may have ended: then nobody needs the buffer.
                    let _ = empty.send(used);
                }
                // It ends after the last buffer or after its trouble.
                if let Ok(next) = full.recv() {
                    (self.buffer, self.end) = next?;
                }
            }
        }
        Ok(self.end > 0)
    }
}

/// Starts the thread; `None` if the system gives none.
fn run_ahead<'a, 'scope>(input: &'a [u8], scope: &'scope Scope<'scope, '_>) -> Option<Supply<'a>>
where
    'a: 'scope,
{
    let (give, full) = channel();
    let (empty, take) = channel::<Vec<u8>>();
    for _ in 0..BUFFERS {
        empty.send(vec![0; BUFFER]).ok()?;
    }
    Builder::new()
        .name("inflate".into())
        .spawn_scoped(scope, move || {
            let mut inflater = Inflater::new(input);
            while let Ok(mut buffer) = take.recv() {
                let filled = inflater.fill(&mut buffer);
                let last = !matches!(filled, Ok(1..));
                if give.send(filled.map(|end| (buffer, end))).is_err() || last {
                    break;
                }
            }
        })
        .ok()?;
    Some(Supply::Ahead { full, empty })
}
