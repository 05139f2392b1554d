//! Convex outline of a plane face: one plane shows that a tool beside or above it is clear.
//!
//! Where a tool rests on one face, it touches the edge that this face shares with its neighbour. A proof by cells
//! of the neighbour would have to halve them along the whole edge until they stick out over it by less than the
//! gap. A plane between the tool and the outline of the neighbour proves the same at once.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::math;
use crate::surface::{FaceIndex, Surface};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Corners that an outline has at most; a curved one is replaced by a polygon around it.
const CORNERS: usize = 48;

/// Corners of a convex polygon that holds a plane face.
#[derive(Debug, Clone)]
pub(crate) struct FaceHull {
    pub(crate) points: Vec<Point3<f64>>,
    /// Unit normal of the plane, of either sign.
    normal: Vector3<f64>,
    /// Distance in the plane by which the face may leave the polygon: that of the trims from their polylines \[mm\].
    slack: f64,
}

impl FaceHull {
    /// Finds the outline of a face whose trim loops are within `share` of its extent; `None` for faces that are no
    /// planes.
    pub(crate) fn of<Inside: Fn(ChartPoint) -> bool>(
        face: &FaceIndex,
        chart: &Chart,
        region: &TrimmedRegion<Inside>,
        share: f64,
    ) -> Option<Self> {
        let Surface::Plane(plane) = &face.face().surface else { return None };
        let outline: Vec<[f64; 2]> = region.outline().map(|local| chart.uv(local)).collect();
        let hull = convex_hull(outline);
        let corners = if hull.len() <= CORNERS { hull } else { polygon_around(&hull) };
        if corners.len() < 3 {
            return None;
        }
        let size = |k: usize| {
            let along = || corners.iter().map(|corner| corner[k]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let slack = share * (size(0) + size(1));
        let points = corners.iter().map(|[u, v]| face.face().point(*u, *v)).collect();
        Some(Self { points, normal: plane.frame.z().into_inner(), slack })
    }

    /// Returns by how much the face may reach beyond the polygon along a unit vector \[mm\].
    pub(crate) fn beyond(&self, direction: &Vector3<f64>) -> f64 {
        self.slack * direction.cross(&self.normal).norm()
    }

    /// Returns the normals, away from the tool, of planes that may separate it from the face.
    pub(crate) fn normals(&self, axis: &UnitVector3<f64>) -> [Vector3<f64>; 3] {
        [-axis.into_inner(), self.normal, -self.normal]
    }
}

/// Returns the corners of the convex hull, counterclockwise (Andrew's monotone chain).
fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let left = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..] {
                if left(a, b, point) {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        // The last point begins the other half.
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

/// Returns a polygon around a convex one, of [`CORNERS`] tangents in even directions.
fn polygon_around(hull: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let directions = || (0..CORNERS).map(|k| TAU * k as f64 / CORNERS as f64);
    // Each tangent is the line d . p = reach, with the support of the hull.
    let tangent = |angle: f64| {
        let (sin, cos) = math::sin_cos(angle);
        let reach = hull.iter().map(|p| cos * p[0] + sin * p[1]).fold(f64::NEG_INFINITY, f64::max);
        [cos, sin, reach]
    };
    let tangents: Vec<[f64; 3]> = directions().map(tangent).collect();
    let next = tangents.iter().cycle().skip(1);
    let corner = |([a, b, r], [c, d, s]): (&[f64; 3], &[f64; 3])| {
        // Cramer's rule; neighbouring directions are TAU / CORNERS apart.
        let determinant = a * d - b * c;
        [(r * d - b * s) / determinant, (a * s - r * c) / determinant]
    };
    tangents.iter().zip(next).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_square_with_points_inside_is_the_square() {
        let points = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0]];
        assert_eq!(convex_hull(points), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    }

    #[test]
    fn a_polygon_around_holds_every_point() {
        let circle: Vec<[f64; 2]> = (0..1000)
            .map(|k| (TAU * f64::from(k) / 1000.0).sin_cos())
            .map(|(sin, cos)| [7.0 + 3.0 * cos, 2.0 * sin])
            .collect();
        let hull = convex_hull(circle.clone());
        assert_eq!(hull.len(), 1000);
        let around = polygon_around(&hull);
        assert_eq!(around.len(), CORNERS);
        for p in circle {
            for (a, b) in around.iter().zip(around.iter().cycle().skip(1)) {
                let side = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                assert!(side >= -1e-12, "{p:?} {a:?} {b:?}");
            }
        }
        // No corner is farther out than 1 / cos(pi / CORNERS) of the radius.
        let far = around.iter().map(|p| (p[0] - 7.0).hypot(p[1])).fold(0.0, f64::max);
        assert!(far < 3.02, "{far}");
    }
}
