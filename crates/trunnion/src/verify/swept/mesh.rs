//! Closed triangle meshes in a bounding volume hierarchy.

use super::bvh::{BoundingBox, BoxTree, ContentId, TreeItem};
use super::crossing::crossing;
use crate::types::Mesh;
use nalgebra::{Point3, Vector3};

/// Closed mesh with the tree of its triangles.
#[derive(Debug)]
pub(crate) struct ClosedMesh {
    mesh: Mesh,
    pub(crate) tree: BoxTree,
}

/// Upper bound on the part of a solid inside a box.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum BoxContent {
    Nothing,
    /// At most the half spaces behind all of these planes: `direction x <= most`.
    Behind(Vec<(Vector3<f64>, f64)>),
}

/// Axis of the rays that separate inside from outside.
const ALONG: usize = 2;
/// Most triangles in a box for which supporting planes are sought.
const FACES: usize = 48;
/// Distance in front of a plane within which a point counts as on it \[mm\].
const ON: f64 = 1e-9;
/// Distance to either side of a triangle at which inside and outside are tested \[mm\].
const ASIDE: f64 = 1e-7;

type TriangleCorners = [Point3<f64>; 3];

impl ClosedMesh {
    /// Builds the tree; `None` without a triangle.
    pub(crate) fn new(mesh: Mesh) -> Option<Self> {
        let around =
            |all: BoundingBox, p: &Point3<f64>| all.join(&BoundingBox { low: *p, high: *p });
        let items = (0u32..).zip(&mesh.triangles).filter_map(|(number, triangle)| {
            let bounds = corners(&mesh, triangle)?.iter().fold(BoundingBox::empty(), around);
            Some(TreeItem { bounds, content: ContentId::item(number) })
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

    /// Tests if a point is inside.
    ///
    /// A ray upwards from it leaves the solid once more than it enters, or crosses an odd number of triangles if they are
    /// not oriented alike.
    pub(crate) fn holds(&self, point: &Point3<f64>) -> bool {
        let Some(bounds) = self.tree.root().and_then(|root| self.tree.bounds(root)) else {
            return false;
        };
        if !bounds.meets(&BoundingBox { low: *point, high: *point }) {
            return false;
        }
        // Only triangles between the point and the top of the mesh can be met.
        let mut high = *point;
        high[ALONG] = bounds.high[ALONG];
        let mut near = Vec::new();
        self.tree.near(&BoundingBox { low: *point, high }, &mut near);
        let above = near.iter().filter_map(|id| {
            let [a, b, c] = self.triangle(id.item)?;
            crossing([&a, &b, &c], [0, 1, ALONG], point)
                .filter(|crossing| crossing.s > point[ALONG])
        });
        let (wound, count) =
            above.fold((0, 0), |(wound, n), crossing| (wound + crossing.winding, n + 1));
        // Winding counts if the triangles are oriented alike, the parity of the crossings if they are not.
        wound != 0 || count % 2 == 1
    }

    /// Returns an upper bound on the part of the solid inside a box.
    ///
    /// If all triangles in the box are behind the plane of one of them, so is the solid. Proof: take a point of the solid in
    /// front of that plane. The straight line from it to the triangle, whose front is outside, would have to leave the solid
    /// through another triangle in front of the plane.
    pub(crate) fn within(&self, bounds: &BoundingBox) -> BoxContent {
        let mut near = Vec::new();
        self.tree.near(bounds, &mut near);
        let triangles = near.iter().filter_map(|id| self.triangle(id.item));
        let triangles: Vec<TriangleCorners> = triangles.filter(|one| is_in(one, bounds)).collect();
        if triangles.is_empty() && !self.holds(&nalgebra::center(&bounds.low, &bounds.high)) {
            return BoxContent::Nothing;
        }
        // Each plane is tested against all triangles: quadratic in their number, so only for few.
        let planes = triangles.iter().filter(|_| triangles.len() <= FACES);
        BoxContent::Behind(planes.filter_map(|one| self.front(one, &triangles)).collect())
    }

    /// Returns the outward plane of a triangle if all other triangles are behind it.
    fn front(&self, one: &TriangleCorners, all: &[TriangleCorners]) -> Option<(Vector3<f64>, f64)> {
        let [a, b, c] = one;
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        [normal, -normal].into_iter().find_map(|direction| {
            let most = direction.dot(&a.coords) + ON;
            let behind = |p: &Point3<f64>| direction.dot(&p.coords) <= most;
            // Cheap test first: all triangles behind the plane. Then the side that faces outwards is found by two points.
            let bulges = all.iter().flatten().all(behind);
            let bounds = bulges
                && self.holds(&(middle - direction * ASIDE))
                && !self.holds(&(middle + direction * ASIDE));
            bounds.then_some((direction, most))
        })
    }
}

fn corners(mesh: &Mesh, triangle: &[u32; 3]) -> Option<TriangleCorners> {
    let [a, b, c] = triangle.map(|corner| mesh.vertices.get(corner as usize).copied());
    Some([a?, b?, c?])
}

/// Tests if any part of a triangle is in a box, by clipping it at all six sides.
fn is_in(triangle: &TriangleCorners, bounds: &BoundingBox) -> bool {
    let mut left = triangle.to_vec();
    for axis in 0..3 {
        for (sign, end) in [(1.0, bounds.high[axis]), (-1.0, -bounds.low[axis])] {
            left = kept(&left, |p| sign * p[axis] - end);
        }
    }
    !left.is_empty()
}

/// Clips a polygon to the part where a linear function is at most 0.
pub(crate) fn kept(
    polygon: &[Point3<f64>],
    over: impl Fn(&Point3<f64>) -> f64,
) -> Vec<Point3<f64>> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let Some(q) = polygon.get((k + 1) % polygon.len()) else { continue };
        let [here, there] = [over(p), over(q)];
        // Sutherland and Hodgman: keep the corners behind the plane, and the points where edges cross it.
        if here <= 0.0 {
            left.push(*p);
        }
        if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
            left.push(p + (q - p) * (here / (here - there)));
        }
    }
    left
}
