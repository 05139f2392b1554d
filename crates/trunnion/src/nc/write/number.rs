//! Numbers with a fixed count of decimals, rounded once.

use std::fmt;

/// A value in units of its last digit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fixed {
    /// Count of last digits.
    digits: i64,
    decimals: u8,
}

/// Largest count of last digits: integers up to here are exact in `f64`.
const LARGEST: f64 = 9e15;

impl Fixed {
    /// Rounds to nearest; `None` if the value is not finite or has too many digits.
    pub(super) fn nearest(value: f64, decimals: u8) -> Option<Self> {
        Self::new((value * scale(decimals)).round(), decimals)
    }

    /// Rounds towards minus infinity.
    pub(super) fn down(value: f64, decimals: u8) -> Option<Self> {
        Self::new((value * scale(decimals)).floor(), decimals)
    }

    fn new(digits: f64, decimals: u8) -> Option<Self> {
        #[expect(clippy::cast_possible_truncation, reason = "integral and in range")]
        (digits.abs() <= LARGEST).then_some(Self { digits: digits as i64, decimals })
    }

    /// The value that is written.
    #[cfg(test)]
    pub(super) fn value(self) -> f64 {
        self.digits as f64 / scale(self.decimals)
    }

    /// Whether all digits are 0.
    pub(super) fn is_zero(self) -> bool {
        self.digits == 0
    }
}

fn scale(decimals: u8) -> f64 {
    10f64.powi(i32::from(decimals))
}

impl fmt::Display for Fixed {
    /// Without trailing zeros but always with a point, which some controls need: `-12.5`, `3.`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_once_and_trimmed() {
        let text = |value, decimals| Fixed::nearest(value, decimals).unwrap().to_string();
        assert_eq!(text(-12.500_04, 4), "-12.5");
        assert_eq!(text(2.000_05, 4), "2.0001");
        assert_eq!(text(-0.000_01, 4), "0.");
        assert_eq!(text(0.07, 3), "0.07");
        assert_eq!(Fixed::down(599.999_99, 3).unwrap().to_string(), "599.999");
        assert_eq!(Fixed::nearest(f64::NAN, 3), None);
        assert_eq!(Fixed::nearest(1e12, 9), None);
        assert!((Fixed::nearest(1.25, 1).unwrap().value() - 1.3).abs() < 1e-15);
    }
}
