//! The cutting end: a disc with a rounded rim.

use crate::cutter::Cutter;

/// Cutting end of a flat, ball or bull-nose cutter; above it the cutter is a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CuttingEnd {
    /// Radius `R` of the centre circle \[mm\]; 0 for a ball.
    pub major: f64,
    /// Radius `r` of the rounding \[mm\]; 0 for a flat cutter.
    pub minor: f64,
}

impl CuttingEnd {
    /// Takes the cutting end of a flat, ball or bull-nose cutter. Its shank is left out: the cutter goes on upwards as a
    /// cylinder. Of a cutter with a side beside its tip arc it takes the ball of that arc alone.
    pub fn of(cutter: &Cutter) -> Self {
        Self { major: cutter.major(), minor: cutter.minor() }
    }

    /// Returns the outer radius \[mm\].
    pub fn radius(&self) -> f64 {
        self.major + self.minor
    }

    /// Returns the height of the end over its tip at a distance from the axis, at most [`CuttingEnd::radius`]
    /// \[mm\].
    pub(super) fn height(&self, distance: f64) -> f64 {
        let out = (distance - self.major).clamp(0.0, self.minor);
        // r - sqrt(r² - out²), without the cancellation of small distances.
        let square = out * out;
        let root = (self.minor * self.minor - square).max(0.0).sqrt();
        if square > 0.0 { square / (self.minor + root) } else { 0.0 }
    }

    /// Returns the end with everything within `by` \[mm\] around it; its tip lies `by` below the tip of this one.
    #[must_use]
    pub fn grown(&self, by: f64) -> Self {
        Self { minor: self.minor + by, ..*self }
    }

    /// Returns an end that lies inside this one with everything within `by` \[mm\] around it; its tip lies `by` above the
    /// tip of this one. `None` if nothing is left.
    #[must_use]
    pub fn shrunk(&self, by: f64) -> Option<Self> {
        let minor = (self.minor - by).max(0.0);
        let major = self.major - (by - self.minor).max(0.0);
        (major >= 0.0 && major + minor > 0.0).then_some(Self { major, minor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_height_is_that_of_a_torus() {
        let end = CuttingEnd { major: 10.0, minor: 6.0 };
        assert!(end.height(9.0).abs() < 1e-15);
        assert!((end.height(16.0) - 6.0).abs() < 1e-15);
        let out = 3.0_f64;
        assert!((end.height(13.0) - (6.0 - (36.0 - out * out).sqrt())).abs() < 1e-14);
        assert!(CuttingEnd { major: 4.0, minor: 0.0 }.height(4.0).abs() < 1e-15);
    }

    #[test]
    fn a_flat_end_shrinks_in_radius() {
        let flat = CuttingEnd { major: 4.0, minor: 0.0 };
        assert_eq!(flat.shrunk(0.5), Some(CuttingEnd { major: 3.5, minor: 0.0 }));
        assert_eq!(flat.shrunk(5.0), None);
    }
}
