//! MAT v5 files laid by hand, sound or not.

use flate2::{Compression, write::ZlibEncoder};
use std::io::Write;

pub(crate) fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend(u32::try_from(data.len()).unwrap().to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

pub(crate) fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

/// An array of this class, sides and name; `body` is what follows.
pub(crate) fn matrix(class: u32, sides: [u32; 2], name: &str, body: &[Vec<u8>]) -> Vec<u8> {
    let mut inner = element(6, &words(&[class, 0]));
    inner.extend(element(5, &words(&sides)));
    inner.extend(element(1, name.as_bytes()));
    inner.extend(body.concat());
    element(14, &inner)
}

/// A compressed element, as MATLAB lays it: without padding.
pub(crate) fn compress(variable: &[u8], level: Compression) -> Vec<u8> {
    let mut zlib = ZlibEncoder::new(Vec::new(), level);
    zlib.write_all(variable).unwrap();
    let squashed = zlib.finish().unwrap();
    let mut element = words(&[15, u32::try_from(squashed.len()).unwrap()]);
    element.extend(squashed);
    element
}
