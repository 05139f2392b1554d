//! Times of a motion for which a distance is bounded, and planes below it during them.

use crate::cover::prove::sweep::{PassSweep, SweepInstant};
use crate::cutter::SignedDistance;
use nalgebra::{Point3, Vector3};

/// Times of a span for which a clearance is bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SpanTimes {
    /// All of them, divided into slabs of equal length at first.
    Slabs(u32),
    /// The middle alone.
    Middle,
}

/// Length of the slabs in which a span is checked first, as a share of the cutter's radius.
const SLAB: f64 = 1.0 / 8.0;

impl SpanTimes {
    /// Returns all times of a span, for a cutter of some radius \[mm\].
    pub(crate) fn all(sweep: &PassSweep, span: usize, radius: f64) -> Self {
        let length = sweep.curve.knots[span + 1] - sweep.curve.knots[span];
        // Small and positive.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
        // Short slabs: the remainder of the motion is of second order in their length.
        let slabs = (length / (SLAB * radius)).ceil().max(1.0) as u32;
        Self::Slabs(slabs)
    }
}

/// Part of the time of one span.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeSlab {
    pub(super) span: usize,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) middle: SweepInstant,
    /// Indices of the halves, once they are needed.
    pub(super) halves: Option<[usize; 2]>,
}

impl TimeSlab {
    pub(super) fn new(sweep: &PassSweep, span: usize, [from, to]: [f64; 2]) -> Option<Self> {
        let middle = sweep.instant(span, 0.5 * (from + to))?;
        Some(Self { span, from, to, middle, halves: None })
    }

    pub(super) fn half(&self) -> f64 {
        0.5 * (self.to - self.from)
    }

    /// Returns the velocity of a fixed point seen from the tool, in the workpiece's directions.
    pub(super) fn seen(&self, from_tip: &Vector3<f64>) -> Vector3<f64> {
        -self.middle.velocity - self.middle.turn.cross(from_tip)
    }
}

/// Plane below the distance, over the corners of a cell and the first-order motion of a slab.
pub(super) struct PlaneBound {
    /// Least value \[mm\].
    pub(super) least: f64,
    /// Largest change by the motion \[mm\].
    pub(super) moving: f64,
}

pub(super) fn over(
    slab: &TimeSlab,
    centre: &Point3<f64>,
    corners: &[Point3<f64>],
    plane: SignedDistance,
) -> PlaneBound {
    let SignedDistance { distance, gradient } = plane;
    let (mut least, mut moving) = (f64::INFINITY, 0.0_f64);
    for corner in corners {
        // The plane is linear in space and, to first order, in time: least at a corner and at an
        // end.
        let seen = slab.seen(&(corner - slab.middle.pose.tip));
        let moved = gradient.dot(&seen).abs() * slab.half();
        least = least.min(distance + gradient.dot(&(corner - centre)) - moved);
        moving = moving.max(moved);
    }
    PlaneBound { least, moving }
}
