//! Extent of every axis on a part of a path.

use super::options::AxesOptions;
use crate::machine::{FIRST_ROTARY, RotaryPair, SECOND_ROTARY};
use crate::math::quintic::Quintic;
use crate::types::{AXES, AxisNode, AxisVector, TRAVEL_ROUNDING};

/// Parts an interval is cut into to bound its extent.
const PARTS: u32 = 8;

/// Control points this far outside both ends of an interval \[mm or rad\] are taken as its bounds: a
/// tenth of the rounding allowed at ends of travel.
const FLAT: f64 = 0.1 * TRAVEL_ROUNDING;

/// Lowest and highest value of every axis on some part of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisBounds(pub(super) [[f64; 2]; AXES]);

impl AxisBounds {
    pub(super) const NONE: Self = Self([[f64::INFINITY, f64::NEG_INFINITY]; AXES]);
    pub(super) const ALL: Self = Self([[f64::NEG_INFINITY, f64::INFINITY]; AXES]);

    /// Extends the bounds to a position.
    pub(super) fn include(&mut self, q: &AxisVector) {
        for ([low, high], &value) in self.0.iter_mut().zip(q.iter()) {
            *low = low.min(value);
            *high = high.max(value);
        }
    }

    /// Extends the bounds to others.
    pub(super) fn merge(&mut self, other: &Self) {
        for ([low, high], [l, h]) in self.0.iter_mut().zip(other.0) {
            *low = low.min(l);
            *high = high.max(h);
        }
    }

    /// Takes the intersection of both; the ends are in the wrong order where they do not overlap.
    pub(super) fn meet(&mut self, other: &Self) {
        for ([low, high], [l, h]) in self.0.iter_mut().zip(other.0) {
            *low = low.max(l);
            *high = high.min(h);
        }
    }

    /// Bounds the quintic between two nodes by its control points; where an axis turns back in between, by
    /// the control points of its parts.
    pub(super) fn between(from: &AxisNode, to: &AxisNode) -> Self {
        // Convex hull property: the Bezier control points q, q + q' l/5, q + 2 q' l/5 + q'' l²/20, from both
        // ends.
        let mut ends = Self::NONE;
        ends.include(&from.q[0]);
        ends.include(&to.q[0]);
        let mut hull = ends;
        hull.include_controls(&from.q, to.s - from.s);
        hull.include_controls(&to.q, from.s - to.s);
        if hull.exceeds(&ends) <= FLAT {
            return hull;
        }
        // An axis that turns back leaves its ends: control points of eighths are 64 times nearer to the curve.
        let quintic = quintic_between(from, to);
        let part = (to.s - from.s) / f64::from(PARTS);
        for index in 0..PARTS {
            let x = part * f64::from(index);
            for (x, side) in [(x, part), (x + part, -part)] {
                let q = quintic.at(x);
                ends.include(&q[0]);
                ends.include_controls(&q, side);
            }
        }
        ends
    }

    /// Includes the second and third control point of a quintic that goes on for `length` from here.
    fn include_controls(&mut self, [q, q1, q2, _]: &[AxisVector; 4], length: f64) {
        self.include(&(q + q1 * (length / 5.0)));
        self.include(&(q + q1 * (length * 0.4) + q2 * (length * length / 20.0)));
    }

    /// Returns the excess over other bounds \[mm or rad\].
    fn exceeds(&self, other: &Self) -> f64 {
        let pairs = self.0.iter().zip(&other.0);
        pairs.map(|(own, other)| (other[0] - own[0]).max(own[1] - other[1])).fold(0.0, f64::max)
    }
}

/// Returns the weighted rotary travel between two positions \[rad\].
pub(super) fn rotary_cost(to: &AxisVector, from: &AxisVector, options: &AxesOptions) -> f64 {
    let RotaryPair { first, second } = options.rotary_weights;
    first * (to[FIRST_ROTARY] - from[FIRST_ROTARY]).abs()
        + second * (to[SECOND_ROTARY] - from[SECOND_ROTARY]).abs()
}

/// Returns the axis path between two nodes.
pub(super) fn quintic_between(from: &AxisNode, to: &AxisNode) -> Quintic<AXES> {
    let jet = |q: &[AxisVector; 4]| [q[0], q[1], q[2]];
    Quintic::new(to.s - from.s, jet(&from.q), jet(&to.q))
}
