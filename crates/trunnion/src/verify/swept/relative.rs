//! A body over a piece of a move: when it is nearest to a place, and how far it reaches.

use super::distance;
use super::quadratic::MotionPiece;
use super::tool::ConvexBody;
use nalgebra::{Point3, Vector3};

/// A body over a piece of a move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RelativeMotion<'a> {
    pub(crate) body: ConvexBody,
    pub(crate) piece: &'a MotionPiece,
    /// Of its points, over the whole piece \[mm\].
    pub(crate) sag: f64,
}

/// Halvings towards the nearest time; what they leave, parting does.
const TIMES: u32 = 8;

impl RelativeMotion<'_> {
    /// How far the body reaches along a unit vector at most, over a stretch of time, from the origin \[mm\]: at one of
    /// its ends, but for the [sag](Piece::sag) of the body's points.
    pub(crate) fn reach(&self, way: &Vector3<f64>, time: [f64; 2]) -> f64 {
        let half = 0.5 * (time[1] - time[0]);
        let ends = time.map(|u| {
            let at = self.piece.instant(u).stand;
            at.tip.coords.dot(way) + self.body.extent(&at.axis, way)
        });
        ends[0].max(ends[1]) + self.sag * half * half
    }

    /// About when within a stretch of time the body is nearest to a point.
    pub(crate) fn nearest_time(&self, point: &Point3<f64>, [mut low, mut high]: [f64; 2]) -> f64 {
        let comes_nearer = |u: f64| {
            let now = self.piece.instant(u);
            let (_, gradient) = distance::distance(self.body, &now.stand, point);
            gradient.dot(&now.velocity(&(point - now.stand.tip))) > 0.0
        };
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
