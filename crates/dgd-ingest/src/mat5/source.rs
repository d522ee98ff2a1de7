//! The bytes of one top-level element, plain or inflated as they are asked for.

use std::thread::Scope;

use crate::mat::{Fault, Number, Sink};

use super::inflate::{BUFFER, Inflate, Stop};

/// A stream of bytes that knows where it is.
pub(super) struct Source<'a> {
    feed: Feed<'a>,
    /// Bytes given out so far.
    position: u64,
    /// Offset in the file of the first byte of the element's data.
    base: usize,
    /// Bytes that the element takes in the file.
    element_bytes: usize,
}

enum Feed<'a> {
    Plain(&'a [u8]),
    Deflate {
        inflate: Inflate<'a>,
        /// The element claims more bytes than the file has.
        cut_short: bool,
    },
}

impl<'a> Source<'a> {
    pub(super) fn plain(bytes: &'a [u8], base: usize) -> Self {
        Self {
            feed: Feed::Plain(bytes),
            position: 0,
            base,
            element_bytes: bytes.len(),
        }
    }

    pub(super) fn deflated<'scope>(
        bytes: &'a [u8],
        base: usize,
        cut_short: bool,
        scope: &'scope Scope<'scope, '_>,
    ) -> Self
    where
        'a: 'scope,
    {
        Self {
            feed: Feed::Deflate {
                inflate: Inflate::new(bytes, scope),
                cut_short,
            },
            position: 0,
            base,
            element_bytes: bytes.len(),
        }
    }

    pub(super) fn position(&self) -> u64 {
        self.position
    }

    /// For messages: a byte of the file, or of what it inflates to.
    pub(super) fn place(&self) -> String {
        match self.feed {
            Feed::Plain(_) => format!("byte {}", self.base as u64 + self.position),
            Feed::Deflate { .. } => format!(
                "inflated byte {} of the element at byte {}",
                self.position, self.base
            ),
        }
    }

    /// Bytes that the element takes in the file.
    pub(super) fn element_bytes(&self) -> usize {
        self.element_bytes
    }

    /// How many bytes could still come, at most.
    pub(super) fn remaining_at_most(&self) -> u64 {
        match &self.feed {
            Feed::Plain(bytes) => bytes.len() as u64,
            Feed::Deflate { .. } => {
                (self.element_bytes as u64).saturating_mul(1040) + BUFFER as u64
            }
        }
    }

    /// The next bytes, at least one.
    fn available(&mut self) -> Result<&[u8], Fault> {
        let place = self.place();
        match &mut self.feed {
            Feed::Plain([]) => Err(Fault::truncated(place, "the bytes end here")),
            Feed::Plain(bytes) => Ok(bytes),
            Feed::Deflate { inflate, cut_short } => {
                if inflate.ready().is_empty() {
                    let more = inflate
                        .refill()
                        .map_err(|s| fault(s, place.clone(), *cut_short))?;
                    if !more {
                        return Err(Fault::damaged(
                            place,
                            "the compressed element ends before its contents do",
                        ));
                    }
                }
                Ok(inflate.ready())
            }
        }
    }

    fn consume(&mut self, count: usize) {
        match &mut self.feed {
            Feed::Plain(bytes) => *bytes = bytes.get(count..).unwrap_or(&[]),
            Feed::Deflate { inflate, .. } => inflate.consume(count),
        }
        self.position += count as u64;
    }

    pub(super) fn read_exact(&mut self, out: &mut [u8]) -> Result<(), Fault> {
        let mut done = 0;
        while done < out.len() {
            let available = self.available()?;
            let count = available.len().min(out.len() - done);
            out[done..done + count].copy_from_slice(&available[..count]);
            done += count;
            self.consume(count);
        }
        Ok(())
    }

    /// Reads `count` bytes; the memory grows with what really comes.
    pub(super) fn read_vec(&mut self, count: u64) -> Result<Vec<u8>, Fault> {
        let mut out = Vec::new();
        let mut left = count;
        while left > 0 {
            let available = self.available()?;
            let now = available
                .len()
                .min(usize::try_from(left).unwrap_or(usize::MAX));
            out.extend_from_slice(&available[..now]);
            left -= now as u64;
            self.consume(now);
        }
        Ok(out)
    }

    pub(super) fn skip(&mut self, count: u64) -> Result<(), Fault> {
        let mut left = count;
        while left > 0 {
            let now = self
                .available()?
                .len()
                .min(usize::try_from(left).unwrap_or(usize::MAX));
            left -= now as u64;
            self.consume(now);
        }
        Ok(())
    }

    /// Moves `count` values into `sink`.
    pub(super) fn numbers(
        &mut self,
        count: usize,
        number: Number,
        sink: &mut Sink,
    ) -> Result<(), Fault> {
        let size = number.size();
        let mut left = count;
        while left > 0 {
            let available = self.available()?;
            let whole = (available.len() / size).min(left);
            if whole == 0 {
                // One value lies across two fillings of the buffer.
                let mut one = [0; 8];
                self.read_exact(&mut one[..size])?;
                sink.append(&one[..size], number);
                left -= 1;
            } else {
                sink.append(&available[..whole * size], number);
                left -= whole;
                self.consume(whole * size);
            }
        }
        Ok(())
    }

    /// Runs to the end of a compressed element, so that its checksum is verified.
    pub(super) fn verify(&mut self) -> Result<(), Fault> {
        let place = self.place();
        if let Feed::Deflate { inflate, cut_short } = &mut self.feed {
            while inflate
                .refill()
                .map_err(|stop| fault(stop, place.clone(), *cut_short))?
            {}
        }
        Ok(())
    }
}

fn fault(stop: Stop, place: String, cut_short: bool) -> Fault {
    match stop {
        Stop::Broken(error) => Fault::damaged(place, format!("it does not inflate: {error}")),
        Stop::Ended => {
            let reason = "the compressed bytes end in the middle of the element";
            if cut_short {
                Fault::truncated(place, reason)
            } else {
                Fault::damaged(place, reason)
            }
        }
    }
}
