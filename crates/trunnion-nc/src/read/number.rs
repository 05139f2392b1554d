//! Decimal numbers as programs write them, rounded correctly without a look at a library.

/// Powers of ten that are exact in `f64`.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Up to this integers are exact in `f64`.
const EXACT: u64 = 1 << 53;

/// Characters that may stand before the decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DecimalMark {
    /// `1.25`.
    Point,
    /// `1.25` or `1,25`, as Heidenhain writes.
    PointOrComma,
}

/// A number without sign and exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ScannedNumber {
    pub(super) value: f64,
    /// Digits after the point.
    pub(super) decimals: u8,
    /// It has a point.
    pub(super) point: bool,
    /// Bytes.
    pub(super) length: usize,
}

/// Reads the number that `text` begins with: `12`, `12.`, `.5`, `1.25`.
///
/// An integer below 2^53 over an exact power of ten is one correctly rounded division; anything longer is
/// left to the standard library.
#[inline]
pub(super) fn number(text: &str, mark: DecimalMark) -> Option<ScannedNumber> {
    let bytes = text.as_bytes();
    let (mut mantissa, mut digits, mut length) = (0_u64, 0_usize, 0_usize);
    let (mut point, mut fraction) = (false, 0_usize);
    for &byte in bytes {
        match byte {
            b'0'..=b'9' => {
                // Overflow needs 20 digits, which the check below leaves to the library.
                mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                digits += 1;
                fraction += usize::from(point);
            }
            // A second point ends the number; letters do, too, as programs know no exponents.
            b'.' if !point => point = true,
            b',' if !point && mark == DecimalMark::PointOrComma => point = true,
            _ => break,
        }
        length += 1;
    }
    if digits == 0 {
        return None;
    }
    let decimals = u8::try_from(fraction).unwrap_or(u8::MAX);
    // Nineteen digits fit in 64 bits.
    // Both operands are exact in f64, so the quotient is correctly rounded (Clinger's fast path).
    let value = match POWERS.get(fraction) {
        Some(power) if digits <= 19 && mantissa <= EXACT => mantissa as f64 / power,
        _ => text.get(..length)?.replace(',', ".").parse().ok()?,
    };
    Some(ScannedNumber { value, decimals, point, length })
}

/// Reads a number that may have a sign.
#[inline]
pub(super) fn signed(text: &str, mark: DecimalMark) -> Option<ScannedNumber> {
    // The sign is exact in floating point, so it may be applied after rounding.
    let (rest, sign) = match text.as_bytes().first() {
        Some(b'-') => (text.get(1..)?, -1.0),
        Some(b'+') => (text.get(1..)?, 1.0),
        _ => return number(text, mark),
    };
    let found = number(rest, mark)?;
    Some(ScannedNumber { value: sign * found.value, length: found.length + 1, ..found })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_number_ends_where_it_ends() {
        let found = number("12.50X3", DecimalMark::Point).unwrap();
        assert_eq!((found.decimals, found.length, found.point), (2, 5, true));
        assert!((found.value - 12.5).abs() < 1e-15);
        assert_eq!(number(".", DecimalMark::Point), None);
        assert_eq!(number("X", DecimalMark::Point), None);
        assert_eq!(number("1.2.3", DecimalMark::Point).unwrap().length, 3);
        assert!((signed("-,5", DecimalMark::PointOrComma).unwrap().value + 0.5).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn every_number_is_rounded_as_the_library_rounds_it(text in "[0-9]{0,22}\\.?[0-9]{1,24}") {
            let found = number(&text, DecimalMark::Point).unwrap();
            prop_assert_eq!(found.length, text.len());
            prop_assert_eq!(found.value.to_bits(), text.parse::<f64>().unwrap().to_bits());
        }
    }
}
