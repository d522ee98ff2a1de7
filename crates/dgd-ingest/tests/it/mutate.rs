//! Damage for the robustness tests: the sort that disks, networks and writers do.

use proptest::prelude::*;

/// One act of damage; places are fractions of the file, so that they fit any length.
#[derive(Debug, Clone)]
pub(crate) enum Damage {
    Flip(u16, u8),
    Set(u16, u8),
    Word(u16, u32),
    Long(u16, u64),
    Cut(u16),
    Copy(u16, u16, u8),
    Insert(u16, u8, u8),
    Remove(u16, u8),
}

pub(crate) fn damage() -> impl Strategy<Value = Vec<Damage>> {
    let word = prop_oneof![
        Just(0),
        Just(1),
        Just(0x7FFF_FFFF),
        Just(0x8000_0000),
        Just(u32::MAX),
        0_u32..100_000,
        any::<u32>(),
    ];
    let long = prop_oneof![
        Just(0),
        Just(u64::MAX),
        Just(1 << 40),
        Just(1 << 62),
        0_u64..1_000_000,
        any::<u64>(),
    ];
    let one = prop_oneof![
        6 => (any::<u16>(), 0_u8..8).prop_map(|(at, bit)| Damage::Flip(at, bit)),
        4 => (any::<u16>(), any::<u8>()).prop_map(|(at, byte)| Damage::Set(at, byte)),
        6 => (any::<u16>(), word).prop_map(|(at, value)| Damage::Word(at, value)),
        6 => (any::<u16>(), long).prop_map(|(at, value)| Damage::Long(at, value)),
        2 => any::<u16>().prop_map(Damage::Cut),
        3 => (any::<u16>(), any::<u16>(), any::<u8>()).prop_map(|(to, from, n)| Damage::Copy(to, from, n)),
        1 => (any::<u16>(), any::<u8>(), any::<u8>()).prop_map(|(at, n, b)| Damage::Insert(at, n, b)),
        1 => (any::<u16>(), any::<u8>()).prop_map(|(at, n)| Damage::Remove(at, n)),
    ];
    proptest::collection::vec(one, 1..5)
}

/// The file with all of the damage done to what lies behind `spared` bytes.
pub(crate) fn apply(file: &[u8], damage: &[Damage], spared: usize) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for act in damage {
        let length = bytes.len().saturating_sub(spared);
        if length == 0 {
            break;
        }
        let place = |at: u16| spared + usize::from(at) * length / 65_536;
        match *act {
            Damage::Flip(at, bit) => bytes[place(at)] ^= 1 << bit,
            Damage::Set(at, byte) => bytes[place(at)] = byte,
            Damage::Word(at, value) => overwrite(&mut bytes, place(at) & !3, &value.to_le_bytes()),
            Damage::Long(at, value) => overwrite(&mut bytes, place(at) & !7, &value.to_le_bytes()),
            Damage::Cut(at) => bytes.truncate(place(at)),
            Damage::Copy(to, from, n) => {
                let from = place(from);
                let part = bytes[from..bytes.len().min(from + usize::from(n))].to_vec();
                overwrite(&mut bytes, place(to), &part);
            }
            Damage::Insert(at, n, byte) => {
                let at = place(at);
                bytes.splice(at..at, std::iter::repeat_n(byte, usize::from(n)));
            }
            Damage::Remove(at, n) => {
                let at = place(at);
                bytes.drain(at..bytes.len().min(at + usize::from(n)));
            }
        }
    }
    bytes
}

fn overwrite(bytes: &mut [u8], at: usize, part: &[u8]) {
    for (to, from) in bytes.iter_mut().skip(at).zip(part) {
        *to = *from;
    }
}
