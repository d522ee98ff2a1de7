//! Mutations of the seed corpus for the stable toolchain: no coverage guides them, but every test run does the same ones.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// Every file of these folders beside the crate under test, by name, so that the order is the same everywhere.
pub(crate) fn seeds(folders: &[&str]) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    for folder in folders {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        paths.extend(entries.map(|entry| entry.unwrap().path()));
    }
    paths.sort();
    assert!(!paths.is_empty());
    paths
        .iter()
        .map(|path| std::fs::read(path).unwrap())
        .collect()
}

/// Calls `holds` with each seed, then with `count` mutations of them; `tokens` are words of the format.
pub(crate) fn mutations(
    seeds: &[Vec<u8>],
    tokens: &[&[u8]],
    count: usize,
    mut holds: impl FnMut(&[u8]),
) {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for seed in seeds {
        holds(seed);
    }
    for round in 0..count {
        let other = &seeds[random.random_range(0..seeds.len())];
        let mut bytes = seeds[round % seeds.len()].clone();
        // Half get one act: what is read strictly hardly survives more.
        for _ in 0..1 + random.random_range(0..2) * random.random_range(0..4) {
            mutate(&mut bytes, other, tokens, &mut random);
        }
        holds(&bytes);
    }
}

/// One act: what disks, networks, writers and hands do to a file.
fn mutate(bytes: &mut Vec<u8>, other: &[u8], tokens: &[&[u8]], random: &mut impl Rng) {
    if bytes.is_empty() {
        return;
    }
    let at = random.random_range(0..bytes.len());
    let piece = |bytes: &[u8], random: &mut dyn Rng| {
        let start = random.random_range(0..bytes.len());
        let length = random.random_range(0..64).min(bytes.len() - start);
        bytes[start..start + length].to_vec()
    };
    match random.random_range(0..10) {
        0 | 1 => bytes[at] ^= 1 << random.random_range(0..8),
        2 => bytes[at] = random.random(),
        3 => bytes.truncate(at),
        4 => {
            let end = (at + random.random_range(0..32)).min(bytes.len());
            bytes.drain(at..end);
        }
        5 => {
            let piece = piece(bytes, random);
            bytes.splice(at..at, piece);
        }
        6 => {
            let piece = piece(other, random);
            bytes.splice(at..at, piece);
        }
        7 | 8 if !tokens.is_empty() => {
            let token = tokens[random.random_range(0..tokens.len())];
            let end = (at + random.random_range(0..2) * token.len()).min(bytes.len());
            bytes.splice(at..end, token.iter().copied());
        }
        _ => {
            const SIZES: [u64; 7] = [
                0,
                1,
                0x7FFF_FFFF,
                0x8000_0000,
                0xFFFF_FFFF,
                1 << 40,
                u64::MAX,
            ];
            let size = SIZES[random.random_range(0..SIZES.len())];
            let width = [2, 4, 8][random.random_range(0..3)];
            for (to, from) in bytes[at..].iter_mut().zip(size.to_le_bytes()).take(width) {
                *to = from;
            }
        }
    }
}
