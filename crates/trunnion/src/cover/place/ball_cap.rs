//! Part of a ball that finishes a face while it runs along it.

use crate::positioning::ToleranceBand;

/// Share of the band that stays above the rim.
const SPARE: f64 = 0.02;

/// Cap of a ball below the upper end of the tolerance band.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BallCap {
    /// Height of the lowest point above the lower end of the band \[mm\].
    pub(crate) above: f64,
    /// Height of the rim above the lowest point \[mm\].
    pub(crate) rim: f64,
}

impl BallCap {
    /// Places the cap in the band, its lowest point above the lower end by a share of the band.
    pub(crate) fn new(band: ToleranceBand, above: f64) -> Self {
        let width = band.upper - band.lower;
        Self { above: above * width, rim: (1.0 - above - SPARE) * width }
    }

    /// Returns the radius of the rim of a ball \[mm\].
    pub(crate) fn radius(&self, ball: f64) -> f64 {
        // rho^2 = r^2 - (r - h)^2 at height h above the lowest point.
        (self.rim * (2.0 * ball - self.rim)).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rim_is_as_high_as_the_band_allows() {
        let band = ToleranceBand { lower: 0.002, upper: 0.012 };
        let cap = BallCap::new(band, 0.1);
        // On a plane the ball of radius 5 rises by r - sqrt(r^2 - rho^2) over its rim.
        let rho = cap.radius(5.0);
        let top = band.lower + cap.above + 5.0 - (25.0 - rho * rho).sqrt();
        assert!((top - (band.upper - SPARE * 0.01)).abs() < 1e-12, "{top}");
    }
}
