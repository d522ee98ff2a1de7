//! Numbers as text.

use std::io::Write;

/// Appends the shortest decimal that reads back to the same `f64`; exponents only where
/// they are shorter by far.
///
/// The text is that of `{value}` and `{value:e}`, but that of two shortest decimals that are equally near the even one is
/// taken. Their way to the digits takes most of the time in which a long table is written, so that the digits
/// come from `zmij`.
pub(crate) fn push(text: &mut Vec<u8>, value: f64) {
    let size = value.abs();
    if !value.is_finite() || value == 0.0 {
        let written = write!(text, "{value}");
        debug_assert!(written.is_ok(), "a vector takes every byte");
        return;
    }
    if value < 0.0 {
        text.push(b'-');
    }
    let mut buffer = zmij::Buffer::new();
    let (digits, point) = Digits::of(buffer.format_finite(size).as_bytes());
    let digits = digits.get();
    if (1e-5..1e16).contains(&size) {
        match usize::try_from(point) {
            Ok(whole) if whole >= digits.len() => {
                text.extend_from_slice(digits);
                text.resize(text.len() + whole - digits.len(), b'0');
            }
            Ok(whole) if whole > 0 => {
                text.extend_from_slice(&digits[..whole]);
                text.push(b'.');
                text.extend_from_slice(&digits[whole..]);
            }
            _ => {
                text.extend_from_slice(b"0.");
                let zeros = usize::try_from(-point).unwrap_or(0);
                text.resize(text.len() + zeros, b'0');
                text.extend_from_slice(digits);
            }
        }
    } else {
        text.extend_from_slice(&digits[..1]);
        if digits.len() > 1 {
            text.push(b'.');
            text.extend_from_slice(&digits[1..]);
        }
        let written = write!(text, "e{}", point - 1);
        debug_assert!(written.is_ok(), "a vector takes every byte");
    }
}

/// The digits of a decimal, without zeros at either end.
struct Digits {
    all: [u8; Self::MOST],
    from: usize,
    to: usize,
}

impl Digits {
    /// A shortest decimal has at most 17 digits, beside zeros in front or behind.
    const MOST: usize = 40;

    /// Reads a decimal above 0; with where its point stands, counted from the first digit.
    fn of(written: &[u8]) -> (Self, i32) {
        let mut digits = Self {
            all: [b'0'; Self::MOST],
            from: 0,
            to: 0,
        };
        let mut point = None;
        let mut exponent = 0;
        for (k, byte) in written.iter().enumerate() {
            match byte {
                b'0'..=b'9' => {
                    if let Some(place) = digits.all.get_mut(digits.to) {
                        *place = *byte;
                        digits.to += 1;
                    }
                }
                b'.' => point = Some(digits.to),
                _ => {
                    let rest = std::str::from_utf8(&written[k + 1..]).unwrap_or_default();
                    exponent = rest.parse().unwrap_or(0);
                    break;
                }
            }
        }
        let point = point.unwrap_or(digits.to);
        while digits.from < digits.to && digits.all[digits.from] == b'0' {
            digits.from += 1;
        }
        while digits.to > digits.from + 1 && digits.all[digits.to - 1] == b'0' {
            digits.to -= 1;
        }
        let place = |k: usize| i32::try_from(k).unwrap_or(0);
        let point = place(point) - place(digits.from) + exponent;
        (digits, point)
    }

    fn get(&self) -> &[u8] {
        &self.all[self.from..self.to]
    }
}

/// Appends a number rounded to so many decimals (at most 9), without closing zeros; nothing if it is not finite.
///
/// Whole numbers are quicker to write than shortest digits, and a table of a simulation has millions.
pub(crate) fn push_fixed(text: &mut Vec<u8>, value: f64, decimals: u32) {
    if !value.is_finite() {
        return;
    }
    let scale = 10_u64.pow(decimals.min(9));
    let scaled = (value.abs() * scale as f64).round();
    // Beyond 2^53 a float holds no decimals of its own.
    if scaled >= 9e15 {
        push(text, value);
        return;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole, from 0 to 9e15"
    )]
    let whole = scaled as u64;
    if value < 0.0 && whole > 0 {
        text.push(b'-');
    }
    push_whole(text, whole / scale, 1);
    let mut fraction = whole % scale;
    if fraction > 0 {
        let mut digits = decimals.min(9);
        while fraction.is_multiple_of(10) {
            fraction /= 10;
            digits -= 1;
        }
        text.push(b'.');
        push_whole(text, fraction, digits);
    }
}

/// Appends a whole number with at least so many digits.
fn push_whole(text: &mut Vec<u8>, mut value: u64, digits: u32) {
    let mut buffer = [b'0'; 20];
    let mut at = buffer.len();
    let mut written = 0;
    while value > 0 || written < digits {
        at -= 1;
        buffer[at] = b"0123456789"[usize::try_from(value % 10).unwrap_or(0)];
        value /= 10;
        written += 1;
    }
    text.extend_from_slice(&buffer[at..]);
}

#[cfg(test)]
mod tests {
    #[test]
    fn fixed_numbers_are_the_nearest_of_their_decimals() {
        let fixed = |value, decimals| {
            let mut text = Vec::new();
            super::push_fixed(&mut text, value, decimals);
            String::from_utf8(text).expect("text")
        };
        assert_eq!(fixed(0.050_123_456_7, 9), "0.050123457");
        assert_eq!(fixed(-1.5, 6), "-1.5");
        assert_eq!(fixed(-1e-9, 6), "0");
        assert_eq!(fixed(101_325.004_9, 2), "101325");
        assert_eq!(fixed(7.05, 2), "7.05");
        assert_eq!(fixed(0.999_999_999_9, 9), "1");
        assert_eq!(fixed(1e20, 9), "1e20");
        assert_eq!(fixed(f64::NAN, 9), "");
        assert_eq!(fixed(f64::INFINITY, 2), "");
    }

    #[test]
    fn the_text_is_that_of_the_standard_library_but_for_ties() {
        let check = |value: f64| {
            let mut text = Vec::new();
            super::push(&mut text, value);
            let size = value.abs();
            let plain = value == 0.0 || (1e-5..1e16).contains(&size) || !value.is_finite();
            let expected = if plain {
                format!("{value}")
            } else {
                format!("{value:e}")
            };
            let text = String::from_utf8(text).expect("text");
            // Of two decimals as short and as near, the one whose last digit is even.
            let differ: Vec<(u8, u8)> = (text.bytes().zip(expected.bytes()))
                .filter(|(a, b)| a != b)
                .collect();
            let even = matches!(differ[..], [(a, b)] if a % 2 == 0 && a.abs_diff(b) == 1);
            let tied = even && text.len() == expected.len() && text.parse() == Ok(value);
            assert!(text == expected || tied, "{text} for {expected}");
        };
        let mut bits = 88_172_645_463_325_252_u64;
        for _ in 0..100_000 {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            // Of every size, then of the sizes that recordings have, then with few digits.
            check(f64::from_bits(bits));
            let share = (bits >> 11) as f64 / 2_f64.powi(53);
            for scale in [1e-6, 0.1, 300.0, 4e7, 1e16] {
                check((share - 0.3) * scale);
            }
            check((share * 1e6).round() / 100.0);
        }
        let mut ends = vec![0.0, -0.0, 1.0, 10.0, 1e15, 1e16, 1e-5, 1e-6, 1e300, 5e-324];
        ends.extend([f64::MAX, f64::MIN_POSITIVE, f64::NAN, f64::NEG_INFINITY]);
        ends.extend((-320..309).map(|k| 10_f64.powi(k)));
        ends.extend((0..1024).map(|k| 2_f64.powi(k)));
        for value in ends {
            check(value);
            check(-value);
            if value.is_finite() {
                check(value.next_up());
                check(value.next_down());
            }
        }
    }

    #[test]
    fn numbers_read_back_to_the_bit() {
        let values = [
            0.0,
            -0.0,
            0.1,
            1.0 / 3.0,
            5e-324,
            f64::MIN_POSITIVE,
            f64::MAX,
            -1e16,
            1e-5,
            9.999e-6,
            123_456_789.123_456_79,
            f64::INFINITY,
            2_f64.powi(53) + 2.0,
        ];
        for value in values {
            let mut text = Vec::new();
            super::push(&mut text, value);
            let read: f64 = std::str::from_utf8(&text)
                .expect("text")
                .parse()
                .expect("number");
            assert_eq!(read.to_bits(), value.to_bits());
        }
    }
}
