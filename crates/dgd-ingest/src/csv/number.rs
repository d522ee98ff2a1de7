//! Decimal numbers in cells, exactly rounded.

/// Powers of ten that `f64` holds exactly.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];
/// Digits whose integer is below 2⁵³ whatever they are.
const EXACT_DIGITS: usize = 15;

/// A plain decimal such as `-597.25` at the start of `bytes`, with its length.
///
/// Integer and power of ten are both exact in `f64`, so their one division rounds
/// correctly (Clinger 1990). `None` for everything else: exponents, long numbers, text.
#[inline]
pub(crate) fn plain(bytes: &[u8]) -> Option<(f64, usize)> {
    let negative = bytes.first() == Some(&b'-');
    let start = usize::from(negative);
    let mut at = start;
    let mut integer: u64 = 0;
    let mut point = None;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'0'..=b'9' => {
                integer = integer
                    .wrapping_mul(10)
                    .wrapping_add(u64::from(byte - b'0'))
            }
            b'.' if point.is_none() => point = Some(at),
            _ => break,
        }
        at += 1;
        if at - start > EXACT_DIGITS + 1 {
            return None;
        }
    }
    let digits = at - start - usize::from(point.is_some());
    if digits == 0 || digits > EXACT_DIGITS {
        return None;
    }
    let decimals = point.map_or(0, |p| at - p - 1);
    let value = integer as f64 / EXACT_POWERS[decimals];
    Some((if negative { -value } else { value }, at))
}

/// The number that a trimmed cell holds, decimal point, exponent and `inf` included; digits too large for `f64` are none.
pub(crate) fn parse(cell: &[u8]) -> Option<f64> {
    match plain(cell) {
        Some((value, length)) if length == cell.len() => Some(value),
        // The standard parser would take any of these as a number too: `nan`, `infinity`.
        _ => {
            let value: f64 = std::str::from_utf8(cell).ok()?.parse().ok()?;
            let overflows = value.is_infinite() && cell.iter().any(u8::is_ascii_digit);
            (!overflows).then_some(value)
        }
    }
}

/// The number in a cell with thousands in groups and a decimal sign that is another one: `2,078.5` or `2.078,5`; says whether
/// a comma was its decimal sign. One sign alone may be either, and is not guessed.
pub(super) fn parse_grouped(cell: &[u8]) -> Option<(f64, bool)> {
    if cell.len() > 64 {
        return None;
    }
    let decimal = *cell.iter().rfind(|b| matches!(b, b'.' | b','))?;
    let group = if decimal == b'.' { b',' } else { b'.' };
    let at = cell.iter().position(|b| *b == decimal)?;
    let (whole, decimals) = (&cell[..at], &cell[at + 1..]);
    let digits = |part: &[u8]| !part.is_empty() && part.iter().all(u8::is_ascii_digit);
    let mut groups = whole
        .strip_prefix(b"-")
        .unwrap_or(whole)
        .split(|b| *b == group);
    let first = groups.next()?;
    let mut rest = 0;
    for part in groups {
        if part.len() != 3 || !digits(part) {
            return None;
        }
        rest += 1;
    }
    if rest == 0 || first.len() > 3 || !digits(first) || !digits(decimals) {
        return None;
    }
    let mut plain: Vec<u8> = whole.iter().copied().filter(|b| *b != group).collect();
    plain.push(b'.');
    plain.extend_from_slice(decimals);
    parse(&plain).map(|value| (value, decimal == b','))
}

/// The number in a cell of a file whose delimiter leaves the comma free; says whether
/// a comma was its decimal sign.
pub(super) fn parse_with_comma(cell: &[u8]) -> Option<(f64, bool)> {
    if let Some(value) = parse(cell) {
        return Some((value, false));
    }
    if let Some(grouped) = parse_grouped(cell) {
        return Some(grouped);
    }
    let mut commas = cell.iter().enumerate().filter(|(_, b)| **b == b',');
    let (Some((at, _)), None) = (commas.next(), commas.next()) else {
        return None;
    };
    // A point beside the comma means thousands are grouped; which is which is a guess.
    if cell.len() > 64 || cell.contains(&b'.') {
        return None;
    }
    let mut copy = [0; 64];
    let copy = &mut copy[..cell.len()];
    copy.copy_from_slice(cell);
    copy[at] = b'.';
    parse(copy).map(|value| (value, true))
}

/// Whether the comma in a cell, read as a decimal sign, may as well separate thousands: `1,002`, but not `0,500` or `1234,567`.
pub(super) fn may_be_thousands(cell: &[u8]) -> bool {
    let plain = cell.strip_prefix(b"-").or(cell.strip_prefix(b"+"));
    let mut parts = plain.unwrap_or(cell).split(|b| *b == b',');
    let (Some(whole), Some(behind), None) = (parts.next(), parts.next(), parts.next()) else {
        return false;
    };
    let digits = |part: &[u8]| part.iter().all(u8::is_ascii_digit);
    let leads = (1..=3).contains(&whole.len()) && whole[0] != b'0';
    leads && behind.len() == 3 && digits(whole) && digits(behind)
}

/// Whether a cell is a number from 100 to 999, such as stand below `1,000` where commas separate thousands.
pub(super) fn is_hundreds(cell: &[u8]) -> bool {
    cell.len() == 3 && cell[0] != b'0' && cell.iter().all(u8::is_ascii_digit)
}

/// The number in a cell with a comma in it though commas separate cells, so that it stands in quotes: `"2,078.5"`, `"329,25"`. Three
/// digits behind a comma alone may be thousands, and are not guessed.
pub(super) fn parse_quoted(cell: &[u8]) -> Option<f64> {
    let (value, comma) = parse_with_comma(cell)?;
    let behind = cell.iter().rev().position(|b| *b == b',')?;
    (!comma || cell.contains(&b'.') || behind != 3).then_some(value)
}

/// Words that instruments and spreadsheets write where there is no value.
pub(super) fn is_missing(cell: &[u8]) -> bool {
    const WORDS: [&str; 14] = [
        "nan", "null", "na", "n/a", "#n/a", "#na", "none", "nil", "-", "--", "#value!", "#div/0!",
        "#null!", "#nv",
    ];
    cell.len() <= 8
        && WORDS
            .iter()
            .any(|word| cell.eq_ignore_ascii_case(word.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_decimals_equal_the_standard_parser_to_the_bit() {
        let mut state = 1_u64;
        for _ in 0..200_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let decimals = (state >> 40) % 9;
            let whole = (state >> 20) % 1_000_000;
            let text = format!(
                "-{whole}.{:0width$}",
                state % 10_u64.pow(decimals as u32 + 1),
                width = decimals as usize
            );
            let expected: f64 = text.parse().expect("a decimal");
            assert_eq!(
                parse(text.as_bytes()).map(f64::to_bits),
                Some(expected.to_bits()),
                "{text}"
            );
        }
    }

    #[test]
    fn edges_of_numbers() {
        assert_eq!(parse(b".5"), Some(0.5));
        assert_eq!(parse(b"5."), Some(5.0));
        assert_eq!(parse(b"+1e-3"), Some(1e-3));
        assert_eq!(
            parse(b"12345678901234567890.5"),
            Some(12_345_678_901_234_567_890.5)
        );
        assert_eq!(
            parse(b"0.1234567890123456789"),
            Some(0.123_456_789_012_345_68)
        );
        assert_eq!(parse(b"-inf"), Some(f64::NEG_INFINITY));
        assert_eq!(parse(b"-0").map(f64::to_bits), Some((-0.0_f64).to_bits()));
        for text in ["", "-", ".", "1.2.3", "12a", "0x10", "1 2", "1_0", "1e999"] {
            assert_eq!(parse(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn a_comma_is_a_decimal_sign_only_when_nothing_speaks_against_it() {
        assert_eq!(parse_with_comma(b"1,5"), Some((1.5, true)));
        assert_eq!(parse_with_comma(b"1.5"), Some((1.5, false)));
        assert_eq!(parse_with_comma(b"1,234,5"), None);
    }

    #[test]
    fn a_comma_before_three_digits_may_separate_thousands() {
        for (cell, may) in [
            ("1,002", true),
            ("-12,345", true),
            ("+999,000", true),
            ("0,500", false),
            ("1234,567", false),
            ("1,5", false),
            (",500", false),
            ("1,2e3", false),
            ("1.234,567", false),
            ("12", false),
        ] {
            assert_eq!(may_be_thousands(cell.as_bytes()), may, "{cell}");
        }
        assert!(is_hundreds(b"998") && !is_hundreds(b"099") && !is_hundreds(b"9.8"));
    }

    #[test]
    fn thousands_are_grouped_where_two_signs_tell_which_is_which() {
        for (text, read) in [
            ("2,078.5", Some((2078.5, false))),
            ("-2.078,25", Some((-2078.25, true))),
            ("12,345,678.0", Some((12_345_678.0, false))),
            ("1.5", None),
            ("1,500", None),
            ("1,50.5", None),
            ("1234,567.8", None),
            ("1,234.", None),
            (",234.5", None),
            ("1,234.5,6", None),
            ("1.234.5", None),
            ("1,2a4.5", None),
        ] {
            assert_eq!(parse_grouped(text.as_bytes()), read, "{text}");
        }
        assert_eq!(parse_with_comma(b"1.234,5"), Some((1234.5, true)));
        for (text, read) in [
            ("2,078.5", Some(2078.5)),
            ("2.078,5", Some(2078.5)),
            ("329,25", Some(329.25)),
            ("1,234", None),
            ("12", None),
        ] {
            assert_eq!(parse_quoted(text.as_bytes()), read, "{text}");
        }
    }
}
