//! Closed intervals of numbers.

/// A closed interval `[low, high]`, in the unit of the quantity that it bounds.
///
/// `low <= high` for a proper interval. An interval with `low > high` is empty; a NaN end contains nothing.
///
/// # Example
///
/// ```
/// use trunnion_types::types::Interval;
///
/// let travel = Interval::new(-120.0, 30.0);
/// assert_eq!(travel.width(), 150.0);
/// assert_eq!(travel.middle(), -45.0);
/// assert!(travel.contains(30.0) && !travel.contains(30.5));
/// assert_eq!(travel.clamp(99.0), 30.0);
/// assert!(travel.widened(0.5).contains(30.5) && travel.is_bounded());
/// assert_eq!(<[f64; 2]>::from(travel), [-120.0, 30.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end; part of the interval.
    pub low: f64,
    /// Upper end; part of the interval.
    pub high: f64,
}

impl Interval {
    /// All real numbers.
    pub const UNBOUNDED: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Creates the interval from `low` to `high`.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Creates the interval that holds only `value`.
    pub const fn point(value: f64) -> Self {
        Self { low: value, high: value }
    }

    /// Returns `high - low`; negative for an empty interval.
    pub fn width(&self) -> f64 {
        self.high - self.low
    }

    /// Returns the middle of a bounded interval.
    pub fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// Returns the point at `share` of the way from `low` (0) to `high` (1).
    pub fn at(&self, share: f64) -> f64 {
        self.low + share * (self.high - self.low)
    }

    /// Returns `true` if `value` lies in the interval, ends included.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// Returns `true` if all of `part` lies in the interval.
    pub fn encloses(&self, part: Self) -> bool {
        self.low <= part.low && part.high <= self.high
    }

    /// Returns the number of the interval that is nearest to `value`.
    ///
    /// Of an empty interval, returns `high`.
    pub fn clamp(&self, value: f64) -> f64 {
        value.max(self.low).min(self.high)
    }

    /// Returns the numbers that both intervals contain; empty if they are apart.
    #[must_use]
    pub fn intersection(&self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    /// Returns the smallest interval that contains both.
    #[must_use]
    pub fn hull(&self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Returns `true` if no number lies in the interval.
    pub fn is_empty(&self) -> bool {
        self.low > self.high || self.low.is_nan() || self.high.is_nan()
    }

    /// Returns `true` if both ends are finite.
    pub fn is_bounded(&self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// Returns the interval with both ends times `factor`, such as a change of unit; `factor > 0`.
    #[must_use]
    pub const fn scaled(&self, factor: f64) -> Self {
        Self { low: self.low * factor, high: self.high * factor }
    }

    /// Returns the interval with `margin` added at both ends.
    #[must_use]
    pub const fn widened(&self, margin: f64) -> Self {
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Returns both ends, the lower one first.
    pub const fn ends(self) -> [f64; 2] {
        [self.low, self.high]
    }
}

impl From<[f64; 2]> for Interval {
    fn from([low, high]: [f64; 2]) -> Self {
        Self { low, high }
    }
}

impl From<Interval> for [f64; 2] {
    fn from(interval: Interval) -> Self {
        interval.ends()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_are_apart_have_an_empty_intersection() {
        let [left, right] = [Interval::new(0.0, 1.0), Interval::new(2.0, 3.0)];
        assert!(left.intersection(right).is_empty());
        assert_eq!(left.hull(right), Interval::new(0.0, 3.0));
        assert!(Interval::new(f64::NAN, 1.0).is_empty());
        assert!(!Interval::point(1.0).is_empty());
    }
}
