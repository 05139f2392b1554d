//! Numbers with a fixed count of decimals, as `format!` writes them, in a fraction of the time: tables at the servo period
//! have tens of millions of them.

use std::io::{Result, Write};

/// Largest number, in units of its last decimal, whose product with the power of ten is off by less than [`DOUBT`].
///
/// The product of two doubles is off by half a unit in the last place: 2^-10 below 2^43.
const MOST: f64 = (1_u64 << 43) as f64;

/// Distance from the middle between two neighbours at which rounding might go the wrong way.
const DOUBT: f64 = 1.0 / 256.0;

/// Powers of ten that are exact, by decimals.
const POWERS: [f64; 11] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10];

/// Digits of the largest number with its point and sign, and some room.
const LENGTH: usize = 32;

/// Writes a number with `decimals` decimals.
pub(crate) fn write(out: &mut impl Write, value: f64, decimals: usize) -> Result<()> {
    let Some(units) = in_units(value, decimals) else { return write!(out, "{value:.decimals$}") };
    // From the last digit to the first one.
    let (mut text, mut first, mut left) = ([b'0'; LENGTH], LENGTH, units);
    let mut count = 0;
    while left > 0 || count <= decimals {
        if count == decimals && decimals > 0 {
            first -= 1;
            text[first] = b'.';
        }
        first -= 1;
        // A digit is below 10.
        text[first] = b'0' + (left % 10) as u8;
        left /= 10;
        count += 1;
    }
    if value.is_sign_negative() {
        first -= 1;
        text[first] = b'-';
    }
    out.write_all(&text[first..])
}

/// Returns a number in units of its last decimal, without its sign, if it surely rounds as its exact value does.
fn in_units(value: f64, decimals: usize) -> Option<u64> {
    let scaled = value.abs() * POWERS.get(decimals)?;
    if scaled.is_nan() || scaled >= MOST {
        return None;
    }
    let whole = scaled.floor();
    let rest = scaled - whole;
    if (rest - 0.5).abs() <= DOUBT {
        return None;
    }
    // Whole, not negative, and below the largest number.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
    let units = whole as u64;
    Some(units + u64::from(rest > 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn text(value: f64, decimals: usize) -> String {
        let mut out = Vec::new();
        write(&mut out, value, decimals).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn ties_signs_and_numbers_of_any_size_are_written_as_the_formatter_does() {
        let near = [
            0.5,
            0.25,
            0.125,
            1.5,
            2.5,
            0.05,
            0.15,
            1e-7,
            5e-11,
            0.999_999_999_95,
            879.609_302_220_8,
        ];
        let odd =
            [0.0, f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE, f64::EPSILON, 1e15, 1e22];
        for value in near.into_iter().chain(odd) {
            for value in [value, -value, value.next_up(), value.next_down()] {
                for decimals in 0..14 {
                    assert_eq!(text(value, decimals), format!("{value:.decimals$}"));
                }
            }
        }
    }

    proptest! {
        #[test]
        fn any_number_is_written_as_the_formatter_does(
            digits in -9_999_999_999_i64..9_999_999_999,
            divisor in 0_i32..12,
            bits in any::<u64>(),
            decimals in 0_usize..12,
        ) {
            for value in [digits as f64 / 10_f64.powi(divisor), f64::from_bits(bits)] {
                prop_assert_eq!(text(value, decimals), format!("{value:.decimals$}"));
            }
        }
    }
}
