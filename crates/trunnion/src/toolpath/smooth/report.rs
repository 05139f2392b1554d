//! Deviations and counts of smoothing.

use super::options::SmoothLimits;

/// Deviation of a smoothed path from its reference, at equal parameters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct PathDeviation {
    /// Distance of the tip, the largest seen at the ends and in the middle of steps \[mm\].
    pub tip: f64,
    /// Distance of the tip, bounded everywhere \[mm\].
    pub tip_bound: f64,
    /// Angle of the tool axis, the largest seen \[rad\].
    pub axis: f64,
    /// Angle of the tool axis, bounded everywhere \[rad\].
    pub axis_bound: f64,
    /// Distance of the contact point, bounded everywhere \[mm\].
    pub contact_bound: f64,
}

impl PathDeviation {
    /// Returns the larger of both, part by part.
    #[must_use]
    pub fn worst(&self, other: &Self) -> Self {
        Self {
            tip: self.tip.max(other.tip),
            tip_bound: self.tip_bound.max(other.tip_bound),
            axis: self.axis.max(other.axis),
            axis_bound: self.axis_bound.max(other.axis_bound),
            contact_bound: self.contact_bound.max(other.contact_bound),
        }
    }

    pub(super) fn with_slack(mut self, [place, turn]: [f64; 2]) -> Self {
        self.tip_bound += place;
        self.contact_bound += place;
        self.axis_bound += turn;
        self
    }

    pub(super) fn within(&self, limits: &SmoothLimits, share: f64) -> bool {
        self.tip_bound.max(self.contact_bound) <= share * limits.tip
            && self.axis_bound <= share * limits.axis
    }
}

/// Counts and largest deviations of smoothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct SmoothReport {
    /// Stations taken in.
    pub stations: usize,
    /// Stations left out because they are within 1/64 of the tolerances of the one before.
    pub merged: usize,
    /// Polynomials.
    pub spans: usize,
    /// Corners rounded within tolerance.
    pub blended: usize,
    /// Corners at which the tool stops.
    pub stops: usize,
    /// Largest deviations and their bounds.
    pub deviated: PathDeviation,
}

impl SmoothReport {
    /// Adds the counts of another path.
    pub fn add(&mut self, other: &Self) {
        self.stations += other.stations;
        self.merged += other.merged;
        self.spans += other.spans;
        self.blended += other.blended;
        self.stops += other.stops;
        self.deviated = self.deviated.worst(&other.deviated);
    }
}
