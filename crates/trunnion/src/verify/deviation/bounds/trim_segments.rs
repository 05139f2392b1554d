//! Trims of a face as straight segments: what of them crosses a rectangle, and which points are beside them.

use super::shape::UvRectangle;
use crate::surface::Face;
use crate::verify::error::VerifyError;
use crate::verify::swept::quadratic::PatchPart;
use crate::verify::swept::tool::DepthRule;

/// Trim curves of a face as straight segments.
pub(crate) struct TrimSegments {
    segments: Vec<[[f64; 2]; 2]>,
    /// Box around each [`RUN`] segments, so that few of them are compared with a rectangle.
    boxes: Vec<UvRectangle>,
    /// Largest distance of the curves from the segments, in u and v.
    tolerance: [f64; 2],
}

/// Distance from the border of a face, along u and along v, at which a point is beside it \[mm\].
///
/// A tool that goes down beside the next face and overcuts it by less than this leaves the face by its border: the gouge is
/// that overcut, not how deep the tool goes down.
const EDGE: f64 = 0.1;

/// Share of a piece by which its tangents may change.
const SPREAD: f64 = 0.1;

/// Accuracy of trims as a share of a cell's parameters.
const TRIM_SHARE: f64 = 1e-3;

/// Segments in one box: about as many as there are boxes round a loop of a thousand segments.
const RUN: usize = 32;

/// Returns the box around some segments.
fn box_around(segments: &[[[f64; 2]; 2]]) -> UvRectangle {
    let ends = || segments.iter().flatten();
    [0, 1].map(|k: usize| {
        let low = ends().map(|end| end[k]).fold(f64::INFINITY, f64::min);
        [low, ends().map(|end| end[k]).fold(f64::NEG_INFINITY, f64::max)]
    })
}

/// Relation of a rectangle to the trims.
pub(crate) enum TrimCrossing {
    /// No trim crosses it.
    Clear,
    /// These segments cross it.
    Border(Vec<u32>),
}

impl TrimSegments {
    /// Approximates the trims of a face that is measured at a grid of parameters.
    pub(crate) fn over(face: &Face, grid: [&[f64]; 2]) -> Result<Self, VerifyError> {
        // A small share of the mean width of a grid cell, in units of the parameter.
        let tolerance = grid.map(|values| {
            let width = values.last().unwrap_or(&0.0) - values.first().unwrap_or(&0.0);
            TRIM_SHARE * width / values.len().max(2) as f64
        });
        Self::new(face, tolerance)
    }

    /// Approximates the trims within `tolerance`, on every turn of a periodic surface.
    fn new(face: &Face, tolerance: [f64; 2]) -> Result<Self, VerifyError> {
        let periods = face.surface.periods().map(|period| period.unwrap_or(0.0));
        // Copies one period off on both sides meet rectangles across the seam.
        let turns =
            periods.map(|period| if period > 0.0 { vec![-period, 0.0, period] } else { vec![0.0] });
        let mut segments = Vec::new();
        for trim in &face.loops {
            let points = trim.polyline(tolerance);
            for du in &turns[0] {
                for dv in &turns[1] {
                    let moved =
                        |pair: &[[f64; 2]]| [pair[0], pair[1]].map(|[u, v]| [u + du, v + dv]);
                    segments.extend(points.windows(2).map(moved));
                }
            }
        }
        if u32::try_from(segments.len()).is_err() {
            let points = segments.len() as f64;
            return Err(VerifyError::TooManyPoints {
                face: face.number,
                points,
                most: u32::MAX as usize,
            });
        }
        let boxes = segments.chunks(RUN).map(box_around).collect();
        Ok(Self { segments, boxes, tolerance })
    }

    /// Returns the rule for the depth of a gouge at all points within `half` \[mm\] of a point, along u and along v: inside
    /// the tool if the border is near all of them.
    pub(crate) fn depth_rule(&self, face: &Face, [u, v]: [f64; 2], half: [f64; 2]) -> DepthRule {
        let reach = half.map(|half| EDGE - (1.0 + SPREAD) * half);
        // Larger pieces are no neighbours of a border as a whole.
        if self.segments.is_empty() || reach.iter().any(|reach| *reach <= 0.0) {
            return DepthRule::AlongNormal;
        }
        let jet = face.surface.jet1(u, v);
        let [du, dv] = [reach[0] / jet.su.norm(), reach[1] / jet.sv.norm()];
        match self.side(&[[u - du, u + du], [v - dv, v + dv]], None) {
            TrimCrossing::Clear => DepthRule::AlongNormal,
            TrimCrossing::Border(_) => DepthRule::InsideTool,
        }
    }

    /// Returns the part of a rectangle inside the trims, of which `among` cross it.
    ///
    /// Its corners are corners of the rectangle, ends of segments, and points where segments cross the border.
    pub(crate) fn part(&self, face: &Face, rectangle: &UvRectangle, among: &[u32]) -> PatchPart {
        let [u, v] = *rectangle;
        let half = rectangle.map(|[low, high]| 0.5 * (high - low));
        let grown = self.grown(rectangle);
        let local = |uv: [f64; 2]| [0, 1].map(|k| (uv[k] - rectangle[k][0]) / half[k] - 1.0);
        let segments = among.iter().filter_map(|index| self.segments.get(*index as usize));
        let crossing = segments.filter_map(|segment| clipped(segment, &grown)).flatten();
        let corners = [[u[0], v[0]], [u[0], v[1]], [u[1], v[0]], [u[1], v[1]]];
        let inside = corners.into_iter().filter(|[u, v]| face.contains(*u, *v));
        PatchPart {
            corners: crossing.chain(inside).map(local).collect(),
            slack: [0, 1].map(|k| self.tolerance[k] / half[k]),
        }
    }

    /// Returns a point of the face close to a segment in a rectangle, of which `among` cross it; `None` if none is found
    /// towards the middle, the corners, or the sides.
    pub(crate) fn just_inside(
        &self,
        face: &Face,
        rectangle: &UvRectangle,
        among: &[u32],
    ) -> Option<[f64; 2]> {
        /// Halvings of the way from the border, and tolerances beside it.
        const HALVINGS: i32 = 10;
        const BESIDE: f64 = 4.0;
        let [u, v] = *rectangle;
        let middle = rectangle.map(|[low, high]| 0.5 * (low + high));
        let grown = self.grown(rectangle);
        let mut segments = among.iter().filter_map(|index| self.segments.get(*index as usize));
        let [a, b] = segments.find_map(|segment| clipped(segment, &grown))?;
        let from = [0, 1].map(|k: usize| 0.5 * (a[k] + b[k]));
        // The rectangle may lie beyond the border, within the tolerance of the segments.
        let [du, dv] = self.tolerance.map(|tolerance| BESIDE * tolerance);
        let sides = [[du, 0.0], [-du, 0.0], [0.0, dv], [0.0, -dv]];
        let corners = [middle, [u[0], v[0]], [u[0], v[1]], [u[1], v[0]], [u[1], v[1]]];
        let places = corners.into_iter().chain(sides.map(|[u, v]| [from[0] + u, from[1] + v]));
        let inside = places.into_iter().find(|[u, v]| face.contains(*u, *v))?;
        let at = |halvings: i32| {
            let share = 0.5f64.powi(halvings);
            [0, 1].map(|k: usize| from[k] + (inside[k] - from[k]) * share)
        };
        (0..=HALVINGS).rev().map(at).find(|[u, v]| face.contains(*u, *v))
    }

    /// Returns a rectangle with all points that a trim curve may be off a segment in it.
    fn grown(&self, rectangle: &UvRectangle) -> UvRectangle {
        [0, 1].map(|k: usize| {
            [rectangle[k][0] - self.tolerance[k], rectangle[k][1] + self.tolerance[k]]
        })
    }

    /// Finds the segments that touch a rectangle, among all or among the given ones.
    pub(crate) fn side(&self, rectangle: &UvRectangle, among: Option<&[u32]>) -> TrimCrossing {
        // A trim curve may be off its segment by the tolerance, so the rectangle grows by that.
        let grown = self.grown(rectangle);
        let touches = |index: &u32| {
            let segment = self.segments.get(*index as usize);
            segment.is_some_and(|segment| meets(segment, &grown))
        };
        let near =
            |of: &UvRectangle| (0..2).all(|k| of[k][0] <= grown[k][1] && of[k][1] >= grown[k][0]);
        let count = u32::try_from(self.segments.len()).unwrap_or(u32::MAX);
        let runs = (0..count).step_by(RUN).zip(&self.boxes).filter(|(_, of)| near(of));
        let found: Vec<u32> = match among {
            Some(some) => some.iter().copied().filter(touches).collect(),
            None => runs.flat_map(|(first, _)| (first..count).take(RUN)).filter(touches).collect(),
        };
        if found.is_empty() { TrimCrossing::Clear } else { TrimCrossing::Border(found) }
    }
}

/// Tests if a segment meets a rectangle.
fn meets(segment: &[[f64; 2]; 2], rectangle: &UvRectangle) -> bool {
    clipped(segment, rectangle).is_some()
}

/// Returns the part of a segment in a rectangle, by Liang and Barsky's clipping.
fn clipped([from, to]: &[[f64; 2]; 2], rectangle: &UvRectangle) -> Option<[[f64; 2]; 2]> {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for k in 0..2 {
        let ([low, high], start, delta) = (rectangle[k], from[k], to[k] - from[k]);
        // The segment is in the slab between two parameters; a parallel one is inside all along, or nowhere.
        if delta.abs() > 0.0 {
            let [a, b] = [(low - start) / delta, (high - start) / delta];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        } else if start < low || start > high {
            return None;
        }
    }
    let at = |share: f64| [0, 1].map(|k: usize| from[k] + share * (to[k] - from[k]));
    (enter <= leave).then(|| [at(enter), at(leave)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{CylinderSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};
    use nalgebra::{Point3, Vector3};
    use std::f64::consts::TAU;

    #[test]
    fn a_segment_meets_a_rectangle_or_passes_its_corner() {
        let square = [[0.0, 1.0], [0.0, 1.0]];
        assert!(meets(&[[-1.0, 0.5], [2.0, 0.6]], &square));
        assert!(meets(&[[0.4, 0.5], [0.6, 0.5]], &square));
        assert!(!meets(&[[-1.0, 1.5], [0.9, 3.0]], &square));
        assert!(!meets(&[[1.2, -1.0], [1.2, 2.0]], &square));
    }

    /// Rectangles of all sizes on a turn of a cylinder with a round hole: the boxes hide no segment.
    #[test]
    fn all_segments_that_touch_a_rectangle_are_found() {
        let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
        let surface = Surface::Cylinder(CylinderSurface::new(frame, 5.0).unwrap());
        let round = |i: u32| {
            let angle = f64::from(i) * TAU / 300.0;
            [1.0 + 0.8 * angle.cos(), 4.0 + 3.0 * angle.sin()]
        };
        let points: Vec<[f64; 2]> = (0..=300).map(|i| round(i % 300)).collect();
        let border = TrimCurve::polyline(&points).unwrap();
        let trim = TrimLoop::new(vec![border], [Some(TAU), None], 1e-9).unwrap();
        let face = Face::new(1, surface, vec![trim]).unwrap();
        let trims = TrimSegments::new(&face, [1e-6; 2]).unwrap();
        assert!(trims.segments.len() >= 900 && trims.boxes.len() >= 28);
        let mut found = 0;
        for k in 0..400 {
            let (i, j, size) = (f64::from(k % 20), f64::from(k / 20), f64::from(k % 7 + 1) * 0.1);
            let rectangle = [[0.5 * i - 4.0, 0.5 * i - 4.0 + size], [0.4 * j, 0.4 * j + size]];
            let all: Vec<u32> = (0..900).collect();
            let some = |of: TrimCrossing| match of {
                TrimCrossing::Clear => Vec::new(),
                TrimCrossing::Border(segments) => segments,
            };
            let by_boxes = some(trims.side(&rectangle, None));
            assert_eq!(by_boxes, some(trims.side(&rectangle, Some(&all))));
            found += by_boxes.len();
        }
        assert!(found > 200, "{found}");
    }
}
