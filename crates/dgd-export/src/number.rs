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

#[cfg(test)]
mod tests {
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
