//! The cutting end: a disc with a rounded rim, and perhaps a side beside it.

use crate::cutter::{Cutter, TangentProfile};

/// Cutting end of a cutter; above it the cutter is a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CuttingEnd {
    /// Radius `R` of the centre circle \[mm\]; 0 for a ball.
    pub(super) major: f64,
    /// Radius `r` of the rounding \[mm\]; 0 for a flat cutter.
    pub(super) minor: f64,
    /// Whole profile of a tapered, barrel or lens cutter.
    pub(super) side: Option<TangentProfile>,
}

impl CuttingEnd {
    /// Takes the cutting end of a cutter. Its shank is left out: the cutter goes on upwards as a cylinder.
    pub fn of(cutter: &Cutter) -> Self {
        let side = cutter.tangent_profile().copied();
        Self { side, ..Self::round(cutter.major(), cutter.minor()) }
    }

    /// Takes a flat, ball or bull-nose end with the centre circle `R` = `major` and the rounding `r` = `minor`
    /// \[mm\].
    pub fn round(major: f64, minor: f64) -> Self {
        Self { major, minor, side: None }
    }

    /// Returns the outer radius \[mm\].
    pub fn radius(&self) -> f64 {
        self.side.as_ref().map_or(self.major + self.minor, TangentProfile::radius)
    }

    /// Returns the height of the end over its tip at a distance from the axis, at most [`CuttingEnd::radius`]
    /// \[mm\].
    pub(super) fn height(&self, distance: f64) -> f64 {
        if let Some(side) = &self.side {
            return side.height(distance);
        }
        let out = (distance - self.major).clamp(0.0, self.minor);
        // r - sqrt(r² - out²), without the cancellation of small distances.
        let square = out * out;
        let root = (self.minor * self.minor - square).max(0.0).sqrt();
        if square > 0.0 { square / (self.minor + root) } else { 0.0 }
    }

    /// Returns the end with everything within `by` \[mm\] around it; its tip lies `by` below the tip of this one. `None`
    /// if `by` is no number to grow by.
    #[must_use]
    pub fn grown(&self, by: f64) -> Option<Self> {
        let side = match &self.side {
            Some(side) => Some(side.parallel(by)?),
            None => None,
        };
        Some(Self { minor: self.minor + by, side, ..*self })
    }

    /// Returns an end that lies inside this one with everything within `by` \[mm\] around it; its tip lies `by` above the
    /// tip of this one. `None` if nothing is left.
    #[must_use]
    pub fn shrunk(&self, by: f64) -> Option<Self> {
        if let Some(side) = &self.side {
            let side = side.parallel(-by)?;
            return Some(Self { minor: self.minor - by, side: Some(side), ..*self });
        }
        let minor = (self.minor - by).max(0.0);
        let major = self.major - (by - self.minor).max(0.0);
        (major >= 0.0 && major + minor > 0.0).then_some(Self::round(major, minor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_height_is_that_of_a_torus() {
        let end = CuttingEnd::round(10.0, 6.0);
        assert!(end.height(9.0).abs() < 1e-15);
        assert!((end.height(16.0) - 6.0).abs() < 1e-15);
        let out = 3.0_f64;
        assert!((end.height(13.0) - (6.0 - (36.0 - out * out).sqrt())).abs() < 1e-14);
        assert!(CuttingEnd::round(4.0, 0.0).height(4.0).abs() < 1e-15);
    }

    #[test]
    fn a_flat_end_shrinks_in_radius() {
        let flat = CuttingEnd::round(4.0, 0.0);
        assert_eq!(flat.shrunk(0.5), Some(CuttingEnd::round(3.5, 0.0)));
        assert_eq!(flat.shrunk(5.0), None);
    }
}
