//! Relative motion of one body and the workpiece over a piece of a move.

use super::distance;
use super::quadratic::MotionPiece;
use super::tool::ConvexBody;
use nalgebra::{Point3, Vector3};

/// Motion of one body over a piece of a move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RelativeMotion<'a> {
    pub(crate) body: ConvexBody,
    pub(crate) piece: &'a MotionPiece,
    /// Sag of the body's points over the whole piece \[mm\], see [`MotionPiece::sag`].
    pub(crate) sag: f64,
}

/// Bisections for the time of closest approach; the search that subdivides time removes the rest of the error.
const TIMES: u32 = 8;

impl RelativeMotion<'_> {
    /// Bounds the reach of the body along a unit vector over an interval of time, from the origin \[mm\].
    ///
    /// That is the larger of the reaches at both ends, plus the [sag](MotionPiece::sag) of the body's points.
    pub(crate) fn reach(&self, direction: &Vector3<f64>, time: [f64; 2]) -> f64 {
        let half = 0.5 * (time[1] - time[0]);
        let ends = time.map(|u| {
            // Support function of the body at the time u, from the origin: E(u) = n tip + extent.
            let at = self.piece.instant(u).pose;
            at.tip.coords.dot(direction) + self.body.extent(&at.axis, direction)
        });
        // Between the ends a point of the body is beyond its chord by the sag, which falls with the square of the duration.
        ends[0].max(ends[1]) + self.sag * half * half
    }

    /// Returns the approximate time within an interval at which the body is nearest to a point.
    pub(crate) fn nearest_time(&self, point: &Point3<f64>, [mut low, mut high]: [f64; 2]) -> f64 {
        let comes_nearer = |u: f64| {
            let now = self.piece.instant(u);
            let (_, gradient) = distance::distance(self.body, &now.pose, point);
            // The tool point that is there now moves along the gradient, towards the point: the distance falls.
            gradient.dot(&now.velocity(&(point - now.pose.tip))) > 0.0
        };
        // The distance is nearly convex in time: it rises all the time, falls all the time, or has one minimum.
        if !comes_nearer(low) {
            return low;
        }
        if comes_nearer(high) {
            return high;
        }
        for _ in 0..TIMES {
            let middle = 0.5 * (low + high);
            if comes_nearer(middle) { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}
