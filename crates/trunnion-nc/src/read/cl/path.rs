//! Arcs and drilling cycles of a CL file.

use crate::math;
use nalgebra::{Point3, UnitVector3, Vector3};

/// Path of the tool to a location.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClPath {
    /// The tip moves straight, the tool axis on a great circle.
    Straight,
    /// The tip moves on an arc or a helix.
    Arc(ClArc),
    /// The location is a hole: the tool comes, drills and goes.
    Hole(ClHole),
}

/// An arc, or one turn at most of a helix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClArc {
    /// Tip at the start \[mm\].
    pub start: Point3<f64>,
    /// A point of the axis of the arc \[mm\].
    pub center: Point3<f64>,
    /// Axis about which the tip turns, by the right-hand rule.
    pub normal: UnitVector3<f64>,
    /// Angle of the turn, in (0, 2π] \[rad\].
    pub sweep: f64,
}

/// One hole of a drilling cycle; distances along the tool axis from its location \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClHole {
    /// Down to where the tool comes with rapid speed, above the location.
    pub clear: f64,
    /// Bottom, below the location.
    pub depth: f64,
    /// Up to where the tool goes afterwards, above the location.
    pub retract: f64,
    /// First and further steps after which it goes up to `clear`; one step if there is none.
    pub steps: Option<[f64; 2]>,
    /// Time at the bottom \[s\].
    pub dwell: f64,
    /// The tool comes out with the feed (taps, reamers, boring bars), not with rapid speed.
    pub feed_out: bool,
}

/// Most straight moves for an arc, most steps of a hole: a tolerance or a step that asks for more is a slip.
pub(super) const MOST: f64 = 65_535.0;

impl ClArc {
    /// Returns the distances from the axis at start and end, and the travel along the axis \[mm\].
    pub(super) fn shape(&self, end: &Point3<f64>) -> ([f64; 2], f64) {
        let [from, to] = [self.start, *end].map(|point| point - self.center);
        // Height along the axis of the arc, and distance from it.
        let [low, high] = [from, to].map(|way| way.dot(&self.normal));
        let across = |way: Vector3<f64>, height: f64| (way - self.normal.scale(height)).norm();
        ([across(from, low), across(to, high)], high - low)
    }

    /// Returns the length up to `end` \[mm\].
    pub fn length(&self, end: &Point3<f64>) -> f64 {
        let ([start, stop], rise) = self.shape(end);
        // Mean radius times sweep, and the rise of the helix.
        math::hypot(0.5 * (start + stop) * self.sweep, rise)
    }

    /// Returns the tip at a share of the path to `end`; distances from the axis that differ change
    /// evenly.
    pub fn at(&self, end: &Point3<f64>, share: f64) -> Point3<f64> {
        let ([start, stop], rise) = self.shape(end);
        let from = self.start - self.center;
        let low = from.dot(&self.normal);
        let across = from - self.normal.scale(low);
        // The radius changes evenly from start to end, which may differ by the rounding of the
        // file.
        let stretch = if start > 0.0 { 1.0 + share * (stop - start) / start } else { 1.0 };
        // Cylindrical coordinates: angle, radius and height all change linearly with the share.
        let turned = math::rotation_about(&self.normal, share * self.sweep) * across;
        self.center + turned * stretch + self.normal.scale(low + share * rise)
    }

    /// Returns the number of straight moves that stay within `tolerance` of the arc: an eighth of
    /// the largest second
    /// derivative by the share, `r θ² + 2 r' θ`.
    pub(super) fn parts(&self, end: &Point3<f64>, tolerance: f64) -> u32 {
        let ([start, stop], _) = self.shape(end);
        // A chord over a share h is off by h^2 / 8 times the second derivative at most.
        let bend = start.max(stop) * self.sweep.powi(2) + 2.0 * (stop - start).abs() * self.sweep;
        let parts = (0.125 * bend / tolerance).sqrt().ceil();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let parts = parts.clamp(1.0, MOST) as u32;
        parts
    }
}

impl ClHole {
    /// Returns the depths of the steps, one after the other \[mm\].
    pub(super) fn depths(&self) -> Vec<f64> {
        let Some([first, further]) = self.steps else { return vec![self.depth] };
        let mut depths = Vec::new();
        let mut depth = first;
        // A step that ends at the bottom is the last; the bound keeps a tiny step from filling the
        // memory.
        while depth < self.depth && further > 0.0 && (depths.len() as f64) < MOST {
            depths.push(depth);
            depth += further;
        }
        depths.push(self.depth);
        depths
    }
}
