#![no_main]

use dgd_ingest::Format;
use flate2::{Compression, Decompress, FlushDecompress, write::ZlibEncoder};
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use std::io::Write;

fuzz_target!(|bytes: &[u8]| -> libfuzzer_sys::Corpus {
    dgd_fuzz::run_recording(bytes, Format::Mat5)
});

// A changed byte in a deflated variable only breaks its checksum: every other time what it inflates to is changed.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    if seed % 2 == 0
        && let Some(changed) = inside(&data[..size], seed)
        && changed.len() <= max_size
    {
        data[..changed.len()].copy_from_slice(&changed);
        return changed.len();
    }
    fuzzer_mutate(data, size, max_size)
});

const HEADER: usize = 128;
const COMPRESSED: u32 = 15;

/// The file with one of its compressed variables changed inside, its checksum right.
fn inside(file: &[u8], seed: u32) -> Option<Vec<u8>> {
    let big_endian = file.get(126..HEADER)? == b"MI";
    let word = |at: usize| -> Option<u32> {
        let four = file.get(at..at + 4)?.try_into().ok()?;
        Some(if big_endian {
            u32::from_be_bytes(four)
        } else {
            u32::from_le_bytes(four)
        })
    };
    let mut found = Vec::new();
    let mut at = HEADER;
    while let (Some(kind), Some(length)) = (word(at), word(at + 4)) {
        let end = (at + 8).checked_add(usize::try_from(length).ok()?)?;
        if end > file.len() {
            break;
        }
        if kind == COMPRESSED {
            found.push((at, end));
        }
        at = end;
    }
    let (start, end) = *found.get((seed / 2) as usize % found.len().max(1))?;
    let mut plain = vec![0; 64 << 10];
    let mut inflater = Decompress::new(true);
    inflater
        .decompress(&file[start + 8..end], &mut plain, FlushDecompress::Finish)
        .ok()?;
    let length = usize::try_from(inflater.total_out()).ok()?;
    let room = plain.len();
    let length = fuzzer_mutate(&mut plain, length, room);
    let mut deflater = ZlibEncoder::new(Vec::new(), Compression::fast());
    deflater.write_all(&plain[..length]).ok()?;
    let packed = deflater.finish().ok()?;
    let claimed = u32::try_from(packed.len()).ok()?;
    let claimed = if big_endian {
        claimed.to_be_bytes()
    } else {
        claimed.to_le_bytes()
    };
    Some([&file[..start + 4], &claimed, &packed, &file[end..]].concat())
}
