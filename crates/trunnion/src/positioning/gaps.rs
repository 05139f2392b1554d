//! What the error cannot exceed between two points of the circle.

use super::circle::Sample;
use super::probe::Reading;
use crate::surface::FaceIndex;
use nalgebra::UnitVector3;

/// Bounds of the second derivative of the error along the circle.
///
/// `E'' = n . (C - q) + R^2 H(t, t)`: the circle's own part and the surface's, `H` the second
/// derivative of the distance, whose eigenvalues are `-k / (1 - k d)` for the principal curvatures
/// `k` at the foot and 0 along the normal. Axis, radius and tangent are orthogonal, so that `n . (C - q)`
/// and `E' = n . t` are at most `R sin(beta)`, `beta` the angle between tool axis and normal, whose
/// sine grows by at most `R max |H|` per rad.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gaps {
    /// Radius of the circle \[mm\].
    pub(super) radius: f64,
    /// Corner radius \[mm\].
    pub(super) minor: f64,
    /// Tool axis.
    pub(super) axis: UnitVector3<f64>,
    /// No normal curvature of the surface below leaves this range \[1/mm\].
    pub(super) curvatures: [f64; 2],
}

impl Gaps {
    /// What the error does not fall below and does not exceed between two points.
    pub(super) fn range(&self, a: &Sample, b: &Sample) -> [f64; 2] {
        let bends = self.bends([a, b], b.psi - a.psi);
        [-peak([a, b], -1.0, -bends[0]), peak([a, b], 1.0, bends[1])]
    }

    /// Range of `E''` over a gap of `h` \[rad\].
    fn bends(&self, [a, b]: [&Sample; 2], h: f64) -> [f64; 2] {
        let radius = self.radius;
        let way = 0.5 * radius * h;
        let far = self.minor + a.error.max(b.error) + way;
        let near = self.minor + a.error.min(b.error) - way;
        let Some([low, high]) = self.second(near, far) else {
            return [f64::NEG_INFINITY, f64::INFINITY];
        };
        let sine = |s: &Sample| self.axis.cross(&s.reading.normal()).norm();
        let lean = sine(a).max(sine(b)) + way * high.max(-low);
        // Rate of n . (C - q): the normal's turn across, at most half the spread of H, and E'.
        let rate = radius * (0.5 * radius * (high - low) + lean);
        let own = 0.5 * (a.plane_bend + b.plane_bend);
        let spread = (0.5 * h * rate).min(radius * lean + own.abs());
        [(own - spread) + radius * radius * low, (own + spread) + radius * radius * high]
    }

    /// Range of the eigenvalues of `H`, 0 included; `None` where there is no bound.
    fn second(&self, near: f64, far: f64) -> Option<[f64; 2]> {
        let [least, most] = [self.curvatures[0].min(0.0), self.curvatures[1].max(0.0)];
        let (falling, rising) = (1.0 - most * far.max(0.0), 1.0 - least * near);
        let bounded = falling > 0.0 && rising > 0.0 && least.is_finite() && most.is_finite();
        bounded.then(|| [-most / falling, -least / rising])
    }
}

/// What `sign * error` cannot exceed between two points: under both parabolas that start with
/// value and slope of a point and bend upward by `bend` or, where that is negative, not at all.
fn peak([a, b]: [&Sample; 2], sign: f64, bend: f64) -> f64 {
    let h = b.psi - a.psi;
    let bend = bend.max(0.0);
    let [ea, eb] = [sign * a.error, sign * b.error];
    let [sa, sb] = [sign * a.slope, sign * b.slope];
    let ends = ea.max(eb);
    let closing = sa - sb + bend * h;
    if !bend.is_finite() {
        return f64::INFINITY;
    }
    if closing <= 0.0 {
        return ends;
    }
    let s = ((eb - ea - sb * h + 0.5 * bend * h * h) / closing).clamp(0.0, h);
    let left = ea + s * (sa + 0.5 * bend * s);
    let t = h - s;
    let right = eb - t * (sb - 0.5 * bend * t);
    ends.max(left.min(right))
}

/// Range of the curvatures under all points within `way` of those read, whose distances from the
/// surface stay below `far`; infinite where there is no bound.
///
/// A foot moves at most `1 / (1 - k d)` times as fast as its point, `k` bounded over all there is
/// within the reach of such feet: as it starts inside, it never leaves.
pub(super) fn curvatures_under<'a>(
    face: &FaceIndex,
    readings: &(impl Iterator<Item = &'a Reading> + Clone),
    (way, far): (f64, f64),
) -> [f64; 2] {
    /// Each widens the reach to what the last one asked for; more than twice is rare.
    const WIDENINGS: u32 = 8;
    let mut reach = 1.25 * way;
    for _ in 0..WIDENINGS {
        let around = face.curvature_around(readings.clone().map(|reading| &reading.foot), reach);
        // Of the continuation beyond the domain the feet are all there is to go by.
        let [low, high] = readings.clone().fold(around, |[low, high], reading| {
            let [least, most] = reading.curvatures();
            [low.min(least), high.max(most)]
        });
        let left = 1.0 - high * far.max(0.0);
        if left > 0.0 && way <= reach * left {
            return [low, high];
        }
        if left <= 0.0 {
            break;
        }
        reach = 1.25 * way / left;
    }
    [f64::NEG_INFINITY, f64::INFINITY]
}
