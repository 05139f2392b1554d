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

/// Digits of a number without sign.
struct Digits {
    /// All of them as an integer; meaningless beyond 19.
    number: u64,
    /// Digits before and behind the point.
    whole: usize,
    fraction: usize,
    point: bool,
}

impl DecimalMark {
    fn is(self, byte: u8) -> bool {
        byte == b'.' || byte == b',' && self == Self::PointOrComma
    }
}

/// Reads the digits that `bytes` begin with.
fn any_digits(bytes: &[u8], mark: DecimalMark) -> Digits {
    let (number, whole) = append_digits(bytes, 0);
    // A second point ends the number; letters do, too, as programs know no exponents.
    match bytes.get(whole..) {
        Some([point, rest @ ..]) if mark.is(*point) => {
            let (number, fraction) = append_digits(rest, number);
            Digits { number, whole, fraction, point: true }
        }
        _ => Digits { number, whole, fraction: 0, point: false },
    }
}

/// Appends the digits that `bytes` begin with to a number, and counts them.
fn append_digits(bytes: &[u8], number: u64) -> (u64, usize) {
    let (mut number, mut count) = (number, 0);
    for byte in bytes.iter().take_while(|byte| byte.is_ascii_digit()) {
        // Overflow needs 20 digits, which the caller leaves to the library.
        number = number.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
        count += 1;
    }
    (number, count)
}

/// Reads a number that is no longer than a machine word, all bytes at once; `None`: it is longer, it has no
/// digits, or the text ends within the word.
#[inline]
fn short_number(bytes: &[u8], mark: DecimalMark) -> Option<ScannedNumber> {
    /// A byte, eight times.
    const fn each(byte: u8) -> u64 {
        u64::from_le_bytes([byte; 8])
    }
    // The first character is the lowest byte. Digits become their values, 0 to 9.
    let values = u64::from_le_bytes(*bytes.first_chunk()?) ^ each(b'0');
    // Adding 0x76 carries 10 and more into the high bit; without that bit no byte carries into the next.
    let others = (((values & each(0x7F)) + each(0x76)) | values) & each(0x80);
    let whole = others.trailing_zeros() / 8;
    let point = bytes.get(usize::try_from(whole).ok()?).is_some_and(|byte| mark.is(*byte));
    if whole == 8 {
        return None;
    }
    let (values, count) = if point {
        // Without the point the digits behind it move one place down. The place that this frees holds none.
        let before = (1 << (8 * whole)) - 1;
        let without = |word: u64| (word & before) | ((word >> 8) & !before);
        (without(values), (without(others) | 1 << 63).trailing_zeros() / 8)
    } else {
        (values, whole)
    };
    // A number that fills the word may go on behind it.
    if count == 0 || count == 7 && bytes.get(8).is_some_and(u8::is_ascii_digit) {
        return None;
    }
    // Leading zeros fill up to eight digits; then neighbours are joined: 10 a + b, 100 a + b, 10 000 a + b.
    let digits = values << (64 - 8 * count);
    let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8) & each_other(0xFF, 16);
    let fours = pairs.wrapping_mul(100).wrapping_add(pairs >> 16) & each_other(0xFFFF, 32);
    let digits = u32::try_from(fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xFFFF_FFFF);
    let decimals = u8::try_from(count - whole).ok()?;
    // Both operands are exact in f64, so the quotient is correctly rounded (Clinger's fast path).
    let value = f64::from(digits.ok()?) / POWERS.get(usize::from(decimals))?;
    let length = usize::try_from(count).ok()? + usize::from(point);
    Some(ScannedNumber { value, decimals, point, length })
}

/// A mask at every `bits` bits of a word, from the lowest on.
const fn each_other(mask: u64, bits: u32) -> u64 {
    if bits == 32 { mask | mask << 32 } else { mask | mask << 16 | mask << 32 | mask << 48 }
}

/// Reads the number that `bytes` begin with: `12`, `12.`, `.5`, `1.25`.
///
/// An integer below 2^53 over an exact power of ten is one correctly rounded division; anything longer is
/// left to the standard library.
#[inline]
pub(super) fn number(bytes: &[u8], mark: DecimalMark) -> Option<ScannedNumber> {
    short_number(bytes, mark).or_else(|| any_number(bytes, mark))
}

/// Reads the number that `bytes` begin with, whatever its length.
fn any_number(bytes: &[u8], mark: DecimalMark) -> Option<ScannedNumber> {
    let Digits { number: mantissa, whole, fraction, point } = any_digits(bytes, mark);
    let digits = whole + fraction;
    let length = digits + usize::from(point);
    if digits == 0 {
        return None;
    }
    let decimals = u8::try_from(fraction).unwrap_or(u8::MAX);
    // Nineteen digits fit in 64 bits.
    let value = match POWERS.get(fraction) {
        Some(power) if digits <= 19 && mantissa <= EXACT => mantissa as f64 / power,
        _ => std::str::from_utf8(bytes.get(..length)?).ok()?.replace(',', ".").parse().ok()?,
    };
    Some(ScannedNumber { value, decimals, point, length })
}

/// Reads a number that may have a sign.
#[inline]
pub(super) fn signed(text: &[u8], mark: DecimalMark) -> Option<ScannedNumber> {
    // The sign is exact in floating point, so it may be applied after rounding.
    let (rest, sign) = match text {
        [b'-', rest @ ..] => (rest, -1.0),
        [b'+', rest @ ..] => (rest, 1.0),
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
        let found = number(b"12.50X3", DecimalMark::Point).unwrap();
        assert_eq!((found.decimals, found.length, found.point), (2, 5, true));
        assert!((found.value - 12.5).abs() < 1e-15);
        assert_eq!(number(b".", DecimalMark::Point), None);
        assert_eq!(number(b"X", DecimalMark::Point), None);
        assert_eq!(number(b"1.2.3", DecimalMark::Point).unwrap().length, 3);
        assert!((signed(b"-,5", DecimalMark::PointOrComma).unwrap().value + 0.5).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn every_number_is_rounded_as_the_library_rounds_it(text in "[0-9]{0,22}\\.?[0-9]{1,24}") {
            let found = number(text.as_bytes(), DecimalMark::Point).unwrap();
            prop_assert_eq!(found.length, text.len());
            prop_assert_eq!(found.value.to_bits(), text.parse::<f64>().unwrap().to_bits());
        }

        #[test]
        fn numbers_read_at_once_are_those_read_digit_by_digit(
            text in "[0-9]{0,9}[.,]?[0-9]{0,9}[-.,X é]?[0-9X é]{0,8}"
        ) {
            for mark in [DecimalMark::Point, DecimalMark::PointOrComma] {
                if let Some(found) = short_number(text.as_bytes(), mark) {
                    prop_assert_eq!(Some(found), any_number(text.as_bytes(), mark));
                }
            }
        }
    }
}
