//! Numbers with a fixed count of decimals, rounded once.

use std::fmt;

/// Written form of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberForm {
    /// Always with a point: `3.`, which some controls need.
    Point,
    /// `3`.
    Plain,
    /// `+3`.
    Signed,
}

/// A value in units of its last digit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FixedNumber {
    /// Count of last digits.
    digits: i64,
    decimals: u8,
}

/// Largest count of last digits: integers up to here are exact in `f64`.
const LARGEST: f64 = 9e15;

impl FixedNumber {
    /// Rounds to nearest; `None` if the value is not finite or has too many digits.
    pub(super) fn nearest(value: f64, decimals: u8) -> Option<Self> {
        Self::new((value * scale(decimals)).round(), decimals)
    }

    /// Rounds towards minus infinity.
    pub(super) fn down(value: f64, decimals: u8) -> Option<Self> {
        Self::new((value * scale(decimals)).floor(), decimals)
    }

    /// Returns the smallest number above 0.
    pub(super) fn last_digit(decimals: u8) -> Self {
        Self { digits: 1, decimals }
    }

    fn new(digits: f64, decimals: u8) -> Option<Self> {
        #[expect(clippy::cast_possible_truncation, reason = "integral and in range")]
        // Larger values would lose digits on the way to an integer; NaN fails the comparison, too.
        (digits.abs() <= LARGEST).then_some(Self { digits: digits as i64, decimals })
    }

    /// Returns the value that is written.
    pub(super) fn value(self) -> f64 {
        self.digits as f64 / scale(self.decimals)
    }

    /// Appends it, without trailing zeros. (Programs are long: four times as fast as formatting.)
    pub(super) fn push(self, out: &mut String, form: NumberForm) {
        let mut text = [0_u8; 32];
        let mut at = text.len();
        let mut put = |byte: u8| {
            at -= 1;
            if let Some(slot) = text.get_mut(at) {
                *slot = byte;
            }
        };
        // The text is filled from its end: decimals, point, whole part, sign.
        let mut rest = self.digits.unsigned_abs();
        let mut left = self.decimals;
        // Trailing zeros carry no value.
        while left > 0 && rest.is_multiple_of(10) {
            rest /= 10;
            left -= 1;
        }
        let digit = |rest: u64| b'0' + u8::try_from(rest % 10).unwrap_or(0);
        let point = left > 0 || form == NumberForm::Point;
        while left > 0 {
            put(digit(rest));
            rest /= 10;
            left -= 1;
        }
        if point {
            put(b'.');
        }
        loop {
            put(digit(rest));
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        if self.digits < 0 {
            put(b'-');
        } else if form == NumberForm::Signed {
            put(b'+');
        }
        out.push_str(std::str::from_utf8(text.get(at..).unwrap_or_default()).unwrap_or_default());
    }

    /// Returns the number itself if it `holds`, or else one last digit less.
    pub(super) fn lowered_to(self, holds: impl Fn(f64) -> bool) -> Self {
        // Counts of last digits are integers, so one less is exact.
        let lower = i64::from(!holds(self.value()));
        Self { digits: self.digits - lower, ..self }
    }

    /// Returns the whole number above where a last digit is all that is missing; for values above
    /// 0.
    pub(super) fn up_to_whole(self) -> Self {
        let unit = 10_i64.pow(u32::from(self.decimals));
        // 2999.999 is 3000 that was rounded down from a sum just below it.
        let missing = i64::from(self.digits % unit == unit - 1);
        Self { digits: self.digits + missing, ..self }
    }

    /// Takes whole revolutions off, so that the value lies in `[low, low + 360)` degrees.
    pub(super) fn within_turn(self, low: i64) -> Self {
        let unit = 10_i64.pow(u32::from(self.decimals));
        // In whole last digits a turn is exact, and 359.9999 cannot become 360.
        let [turn, low] = [360 * unit, low * unit];
        Self { digits: (self.digits - low).rem_euclid(turn) + low, ..self }
    }

    /// Returns true if all digits are 0.
    pub(super) fn is_zero(self) -> bool {
        self.digits == 0
    }
}

fn scale(decimals: u8) -> f64 {
    10f64.powi(i32::from(decimals))
}

impl fmt::Display for FixedNumber {
    /// Writes the number without trailing zeros but always with a point, which some controls need:
    /// `-12.5`, `3.`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.digits < 0 { "-" } else { "" };
        let mut unit = 1;
        for _ in 0..self.decimals {
            unit *= 10;
        }
        let digits = self.digits.unsigned_abs();
        let [whole, mut fraction] = [digits / unit, digits % unit];
        let mut width = usize::from(self.decimals);
        if fraction == 0 {
            return write!(f, "{sign}{whole}.");
        }
        while fraction % 10 == 0 {
            fraction /= 10;
            width -= 1;
        }
        write!(f, "{sign}{whole}.{fraction:0width$}")
    }
}

/// Joins numbers with commas.
pub(super) fn list<'a>(values: impl Iterator<Item = &'a FixedNumber>) -> String {
    let mut text = String::new();
    for value in values {
        if !text.is_empty() {
            text.push(',');
        }
        value.push(&mut text, NumberForm::Point);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_forms_say_the_same_number() {
        let text = |value, decimals, form| {
            let mut out = String::new();
            FixedNumber::nearest(value, decimals).unwrap().push(&mut out, form);
            out
        };
        for value in [0.0, -0.000_01, 3.0, -12.5, 0.07, -0.07, 1e9, 123.456_789, 900.0, -370.0] {
            let fixed = FixedNumber::nearest(value, 4).unwrap();
            assert_eq!(text(value, 4, NumberForm::Point), fixed.to_string());
            assert!(text(value, 4, NumberForm::Signed).starts_with(['+', '-']));
            let back: f64 = text(value, 4, NumberForm::Plain).parse().unwrap();
            assert!((back - fixed.value()).abs() < 1e-12, "{value}");
        }
        assert_eq!(text(3.0, 4, NumberForm::Plain), "3");
        assert_eq!(text(3.0, 0, NumberForm::Signed), "+3");
    }

    #[test]
    fn a_last_digit_short_of_a_whole_number_is_that_number() {
        let text = |value| FixedNumber::down(value, 3).unwrap().up_to_whole().to_string();
        assert_eq!(text(2_999.999_2), "3000.");
        assert_eq!(text(2_999.998_9), "2999.998");
        assert_eq!(text(0.999), "1.");
        assert_eq!(text(12_345.678_9), "12345.678");
    }

    #[test]
    fn turns_are_taken_off_after_rounding() {
        let turned =
            |value, low| FixedNumber::nearest(value, 3).unwrap().within_turn(low).to_string();
        assert_eq!(turned(359.999_9, 0), "0.");
        assert_eq!(turned(370.5, 0), "10.5");
        assert_eq!(turned(-10.0, 0), "350.");
        assert_eq!(turned(180.0, -180), "-180.");
        assert_eq!(turned(-190.0, -180), "170.");
    }

    #[test]
    fn numbers_are_rounded_once_and_trimmed() {
        let text = |value, decimals| FixedNumber::nearest(value, decimals).unwrap().to_string();
        assert_eq!(text(-12.500_04, 4), "-12.5");
        assert_eq!(text(2.000_05, 4), "2.0001");
        assert_eq!(text(-0.000_01, 4), "0.");
        assert_eq!(text(0.07, 3), "0.07");
        assert_eq!(FixedNumber::down(599.999_99, 3).unwrap().to_string(), "599.999");
        assert_eq!(FixedNumber::nearest(f64::NAN, 3), None);
        assert_eq!(FixedNumber::nearest(1e12, 9), None);
        assert!((FixedNumber::nearest(1.25, 1).unwrap().value() - 1.3).abs() < 1e-15);
    }
}
