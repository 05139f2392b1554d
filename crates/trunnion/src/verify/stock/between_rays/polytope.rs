//! Convex polytope: a box clipped by planes.

use crate::math;
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::mesh::kept;
use nalgebra::{Point3, Vector3};

/// Convex polytope by its faces, each an ordered polygon.
#[derive(Debug, Clone)]
pub(crate) struct Polytope {
    faces: Vec<Vec<Point3<f64>>>,
}

/// Corners of a box, one bit per axis, face by face.
const FACES: [[u8; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// Distance up to which corners of different faces are the same \[mm\].
const SAME: f64 = 1e-9;

impl Polytope {
    /// Returns the polytope of a box.
    pub(crate) fn cuboid(BoundingBox { low, high }: &BoundingBox) -> Self {
        let corner = |k: u8| {
            let end = |axis: usize| if k >> axis & 1 == 0 { low[axis] } else { high[axis] };
            Point3::new(end(0), end(1), end(2))
        };
        Self { faces: FACES.iter().map(|face| face.map(corner).to_vec()).collect() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Clips to the half space `direction x <= most`; a cut less deep than rounding removes nothing.
    pub(crate) fn keep(&mut self, direction: &Vector3<f64>, most: f64) {
        let over = |p: &Point3<f64>| direction.dot(&p.coords) - most;
        if self.faces.iter().flatten().all(|p| over(p) <= SAME) {
            return;
        }
        for face in &mut self.faces {
            // Step 1: clip every face to the half space.
            *face = kept(face, over);
        }
        // Step 2: close the polytope with the polygon of all corners on the plane.
        let rim = different(self.faces.iter().flatten().filter(|p| over(p) > -SAME));
        self.faces.retain(|face| !face.is_empty());
        if rim.len() > 2 && !self.faces.is_empty() {
            self.faces.push(in_order(rim, direction));
        }
    }

    /// Returns its corners.
    pub(crate) fn corners(&self) -> Vec<Point3<f64>> {
        different(self.faces.iter().flatten())
    }
}

/// Returns each point once.
fn different<'a>(points: impl Iterator<Item = &'a Point3<f64>>) -> Vec<Point3<f64>> {
    let mut all: Vec<Point3<f64>> = Vec::new();
    for p in points {
        if all.iter().all(|q| (p - q).amax() > SAME) {
            all.push(*p);
        }
    }
    all
}

/// Sorts points of a plane across `direction` around their middle.
fn in_order(mut rim: Vec<Point3<f64>>, direction: &Vector3<f64>) -> Vec<Point3<f64>> {
    let middle = mean(&rim);
    let mut unit = Vector3::zeros();
    // The coordinate axis farthest from `direction` gives two directions across it, of equal length.
    unit[direction.iamin()] = 1.0;
    let [a, b] = [direction.cross(&unit), direction.cross(&direction.cross(&unit))];
    // The corners of a convex polygon are in order by their angle around an inner point.
    let angle = |p: &Point3<f64>| math::atan2((p - middle).dot(&a), (p - middle).dot(&b));
    rim.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
    rim
}

/// Returns the mean of some points.
pub(crate) fn mean(points: &[Point3<f64>]) -> Point3<f64> {
    let sum = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
    Point3::from(sum / points.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn planes_that_are_one_but_for_rounding_cut_once() {
        let bounds = BoundingBox { low: Point3::origin(), high: Point3::new(1.0, 1.0, 1.0) };
        let mut polytope = Polytope::cuboid(&bounds);
        for k in 0..60 {
            let direction = Vector3::new(1.0, 1e-11 * f64::from(k), 1.0).normalize();
            polytope.keep(&direction, 0.9 - 1e-10 * f64::from(k));
        }
        // An edge of the cube is off.
        assert_eq!(polytope.corners().len(), 10);
    }

    proptest! {
        /// The kept part of the box lies in the hull of the corners: the farthest corner in any direction is as
        /// far as the farthest of many points, and never beyond a plane.
        #[test]
        fn corners_are_the_extremes_of_what_is_kept(
            planes in prop::collection::vec(([-1.0..1.0, -1.0..1.0, -1.0..1.0], -0.5..0.9), 0..5),
            toward in [-1.0..1.0, -1.0..1.0, -1.0..1.0],
        ) {
            let bounds = BoundingBox { low: Point3::new(-1.0, -1.0, -1.0), high: Point3::new(1.0, 1.0, 1.0) };
            let mut polytope = Polytope::cuboid(&bounds);
            let planes: Vec<(Vector3<f64>, f64)> = planes.into_iter().map(|(direction, most)| (Vector3::from(direction), most)).collect();
            for (direction, most) in &planes {
                polytope.keep(direction, *most);
            }
            let corners = polytope.corners();
            let inside = |p: &Point3<f64>, by: f64| planes.iter().all(|(direction, most)| direction.dot(&p.coords) <= most + by);
            for p in &corners {
                prop_assert!(inside(p, 1e-8) && p.coords.amax() <= 1.0 + 1e-12, "{p}");
            }
            let toward = Vector3::from(toward);
            let reach = |p: &Point3<f64>| toward.dot(&p.coords);
            let farthest = corners.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
            let grid = |k: u32| Point3::new(f64::from(k % 15), f64::from(k / 15 % 15), f64::from(k / 225)) / 7.0 - Vector3::repeat(1.0);
            let sampled = (0..3375).map(grid).filter(|p| inside(p, 0.0)).map(|p| reach(&p)).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(farthest >= sampled - 1e-8, "{farthest} {sampled}");
        }
    }
}
