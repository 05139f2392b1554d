//! The triangles that enclose a solid, in a tree of boxes.

use super::bvh::{BoundingBox, BoxTree, TreeItem};
use super::crossing::crossing;
use crate::types::Mesh;
use nalgebra::{Point3, Vector3};

/// A closed mesh.
#[derive(Debug)]
pub(crate) struct ClosedMesh {
    mesh: Mesh,
    pub(crate) tree: BoxTree,
}

/// What of a solid is in a box.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum BoxContent {
    Nothing,
    /// No more than what is behind all of these planes: `way x <= most`.
    Behind(Vec<(Vector3<f64>, f64)>),
}

/// Axis of the rays that tell inside from outside.
const ALONG: usize = 2;
/// Triangles in a box of which it is asked whether they bulge.
const FACES: usize = 48;
/// What lies so little in front of a plane is on it \[mm\], and it is looked so far to either side of a triangle for
/// what is inside.
const ON: f64 = 1e-9;
const ASIDE: f64 = 1e-7;

type TriangleCorners = [Point3<f64>; 3];

impl ClosedMesh {
    /// `None` without a triangle.
    pub(crate) fn new(mesh: Mesh) -> Option<Self> {
        let around =
            |all: BoundingBox, p: &Point3<f64>| all.join(&BoundingBox { low: *p, high: *p });
        let items = (0u32..).zip(&mesh.triangles).filter_map(|(number, triangle)| {
            let bounds = corners(&mesh, triangle)?.iter().fold(BoundingBox::empty(), around);
            Some(TreeItem { bounds, content: (number, 0) })
        });
        let tree = BoxTree::new(items.collect());
        tree.root()?;
        Some(Self { mesh, tree })
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    pub(crate) fn triangle(&self, number: u32) -> Option<TriangleCorners> {
        corners(&self.mesh, self.mesh.triangles.get(number as usize)?)
    }

    /// Whether a point is inside: a ray up from it comes out once more than it goes in, or crosses an odd number of
    /// triangles, should they turn this way and that.
    pub(crate) fn holds(&self, point: &Point3<f64>) -> bool {
        let Some(bounds) = self.tree.root().and_then(|root| self.tree.bounds(root)) else {
            return false;
        };
        if !bounds.meets(&BoundingBox { low: *point, high: *point }) {
            return false;
        }
        let mut high = *point;
        high[ALONG] = bounds.high[ALONG];
        let mut near = Vec::new();
        self.tree.near(&BoundingBox { low: *point, high }, &mut near);
        let above = near.iter().filter_map(|&(number, _)| {
            let [a, b, c] = self.triangle(number)?;
            crossing([&a, &b, &c], [0, 1, ALONG], point).filter(|(s, _)| *s > point[ALONG])
        });
        let (wound, count) = above.fold((0, 0), |(wound, n), (_, way)| (wound + way, n + 1));
        wound != 0 || count % 2 == 1
    }

    /// What of the solid is in a box at most.
    ///
    /// If all triangles in the box are behind the plane of one of them, then so is the solid: from a place of it in
    /// front, the straight way to that triangle, whose front is outside, would have to leave it through another one.
    pub(crate) fn within(&self, bounds: &BoundingBox) -> BoxContent {
        let mut near = Vec::new();
        self.tree.near(bounds, &mut near);
        let triangles = near.iter().filter_map(|&(number, _)| self.triangle(number));
        let triangles: Vec<TriangleCorners> = triangles.filter(|one| is_in(one, bounds)).collect();
        if triangles.is_empty() && !self.holds(&nalgebra::center(&bounds.low, &bounds.high)) {
            return BoxContent::Nothing;
        }
        let planes = triangles.iter().filter(|_| triangles.len() <= FACES);
        BoxContent::Behind(planes.filter_map(|one| self.front(one, &triangles)).collect())
    }

    /// The plane of a triangle, seen from outside, if all others are behind it.
    fn front(&self, one: &TriangleCorners, all: &[TriangleCorners]) -> Option<(Vector3<f64>, f64)> {
        let [a, b, c] = one;
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        [normal, -normal].into_iter().find_map(|way| {
            let most = way.dot(&a.coords) + ON;
            let behind = |p: &Point3<f64>| way.dot(&p.coords) <= most;
            let bulges = all.iter().flatten().all(behind);
            let bounds = bulges
                && self.holds(&(middle - way * ASIDE))
                && !self.holds(&(middle + way * ASIDE));
            bounds.then_some((way, most))
        })
    }
}

fn corners(mesh: &Mesh, triangle: &[u32; 3]) -> Option<TriangleCorners> {
    let [a, b, c] = triangle.map(|corner| mesh.vertices.get(corner as usize).copied());
    Some([a?, b?, c?])
}

/// Whether any of a triangle is in a box: what its sides cut off leaves something.
fn is_in(triangle: &TriangleCorners, bounds: &BoundingBox) -> bool {
    let mut left = triangle.to_vec();
    for axis in 0..3 {
        for (sign, end) in [(1.0, bounds.high[axis]), (-1.0, -bounds.low[axis])] {
            left = kept(&left, |p| sign * p[axis] - end);
        }
    }
    !left.is_empty()
}

/// A polygon's part where a linear function is at most 0.
pub(crate) fn kept(
    polygon: &[Point3<f64>],
    over: impl Fn(&Point3<f64>) -> f64,
) -> Vec<Point3<f64>> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let Some(q) = polygon.get((k + 1) % polygon.len()) else { continue };
        let [here, there] = [over(p), over(q)];
        if here <= 0.0 {
            left.push(*p);
        }
        if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
            left.push(p + (q - p) * (here / (here - there)));
        }
    }
    left
}
