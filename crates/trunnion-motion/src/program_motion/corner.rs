//! A corner of the path, and what its kernel adds.

use super::kernel::{bending, rounding};
use super::leg::{LetterVector, triples};
use super::pace::least;
use crate::feed::Limits;
use crate::math;
use crate::types::{AXES, AxisVector};

/// Largest half width of a kernel \[mm\]: a path must be known three times as far ahead.
pub(super) const WIDEST: f64 = 2.0;

/// Largest second and third derivative of the kernel of a corner.
const LARGEST_TURN_BEND: f64 = 1.125;
const LARGEST_TURN_CHANGE: f64 = 2.25;

/// Share of a tolerance that roundings use; the rest is for the quintics between nodes.
pub(super) const USED: f64 = 0.95;

/// Largest value of the kernel of a bend: at 1/4.
const LARGEST_BEND: f64 = 27.0 / 3072.0;

/// Largest deviations at a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CornerTolerance {
    /// Of X Y Z, and of U V W \[mm\].
    pub(super) tip: f64,
    /// Of A B C \[rad\].
    pub(super) axis: f64,
}

impl CornerTolerance {
    /// Returns a deviation as a share of the tolerance.
    pub(super) fn share(&self, deviation: &LetterVector) -> f64 {
        let [xyz, abc, uvw] = triples(deviation).map(|triple| triple.norm());
        (xyz / self.tip).max(abc / self.axis).max(uvw / self.tip)
    }

    /// Returns the smaller tolerance of both.
    pub(super) fn min(self, other: Self) -> Self {
        Self { tip: self.tip.min(other.tip), axis: self.axis.min(other.axis) }
    }
}

/// A corner.
#[derive(Debug, Clone)]
pub(super) struct Corner {
    pub(super) at: f64,
    /// Change of direction, and of curvature.
    pub(super) turn: LetterVector,
    pub(super) bend: LetterVector,
    pub(super) tolerance: CornerTolerance,
    /// Half width of its kernel, once it was chosen.
    pub(super) width: f64,
}

impl Corner {
    /// Returns the step that a kernel of half width `w` adds to the path at `s`, with derivatives.
    pub(super) fn at(&self, s: f64, w: f64) -> [LetterVector; 4] {
        // At a corner the leg behind it counts, and so do the jumps behind it.
        let u =
            ((s - self.at) / w).abs().max(f64::MIN_POSITIVE) * if s < self.at { -1.0 } else { 1.0 };
        let [turn, bend] = [rounding(u), bending(u)];
        let mut scale = w;
        std::array::from_fn(|order| {
            let part = self.turn * (turn[order] * scale) + self.bend * (bend[order] * scale * w);
            scale /= w;
            part
        })
    }

    /// Returns that step without derivatives.
    pub(super) fn deviation(&self, s: f64, w: f64) -> LetterVector {
        let u = (s - self.at) / w;
        self.turn * (rounding(u)[0] * w) + self.bend * (bending(u)[0] * w * w)
    }

    /// Bound on what it adds at `s`, as a share of a tolerance.
    pub(super) fn share(&self, s: f64, w: f64, tolerance: &CornerTolerance) -> f64 {
        let u = (s - self.at) / w;
        if u.abs() >= 1.0 {
            return 0.0;
        }
        tolerance.share(&(self.turn * (rounding(u)[0] * w)))
            + tolerance.share(&(self.bend * (LARGEST_BEND * w * w)))
    }
}

/// Returns the largest speed at a corner, by the turn of the letters there and that of the axes.
pub(super) fn largest_speed(
    letters: &LetterVector,
    axes: &AxisVector,
    tolerance: &CornerTolerance,
    limits: &Limits<AXES>,
) -> f64 {
    let width = (USED / (tolerance.share(letters) * rounding(0.0)[0])).min(WIDEST);
    let square = width * least(&limits.acceleration, axes) / LARGEST_TURN_BEND;
    let cube = limits
        .jerk
        .as_ref()
        .map_or(f64::INFINITY, |jerk| width * width * least(jerk, axes) / LARGEST_TURN_CHANGE);
    square.sqrt().min(math::cbrt(cube))
}
