//! Numbers as text.

use std::io::Write;

/// Appends the shortest decimal that reads back to the same `f64`; exponents only where
/// they are shorter by far.
pub(crate) fn push(text: &mut Vec<u8>, value: f64) {
    let size = value.abs();
    let plain = value == 0.0 || (1e-5..1e16).contains(&size) || !value.is_finite();
    let written = if plain {
        write!(text, "{value}")
    } else {
        write!(text, "{value:e}")
    };
    debug_assert!(written.is_ok(), "a vector takes every byte");
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
