//! Distance between two triangles, and between the triangles of two meshes.

use super::bvh::{BoundingBox, TreeChildren};
use super::mesh::ClosedMesh;
use nalgebra::{Isometry3, Point3, Vector3, center};

/// Corners of a triangle.
pub(crate) type TriangleCorners = [Point3<f64>; 3];

/// Nearest points of two shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MeshGap {
    /// Distance \[mm\]; 0 where they cross.
    pub(crate) distance: f64,
    /// Nearest point of each.
    pub(crate) ends: [Point3<f64>; 2],
}

impl MeshGap {
    fn between(a: &Point3<f64>, b: &Point3<f64>) -> Self {
        Self { distance: (b - a).norm(), ends: [*a, *b] }
    }

    /// Returns the point in the middle.
    pub(crate) fn middle(&self) -> Point3<f64> {
        center(&self.ends[0], &self.ends[1])
    }

    fn swapped(self) -> Self {
        let [a, b] = self.ends;
        Self { ends: [b, a], ..self }
    }

    fn nearer(self, other: Self) -> Self {
        if other.distance < self.distance { other } else { self }
    }
}

/// Returns the gap between two triangles.
///
/// If they do not cross, the nearest points are a corner and a triangle, or two edges.
pub(crate) fn triangle_gap(a: &TriangleCorners, b: &TriangleCorners) -> MeshGap {
    let edges = |t: &TriangleCorners| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    for (edge, triangle) in edges(a).iter().map(|e| (e, b)).chain(edges(b).iter().map(|e| (e, a))) {
        if let Some(point) = pierced(edge, triangle) {
            return MeshGap { distance: 0.0, ends: [point; 2] };
        }
    }
    let corners = |from: &TriangleCorners, to: &TriangleCorners| {
        let near = from.map(|corner| MeshGap::between(&corner, &on_triangle(&corner, to)));
        near[0].nearer(near[1]).nearer(near[2])
    };
    let mut best = corners(a, b).nearer(corners(b, a).swapped());
    for one in edges(a) {
        for other in edges(b) {
            best = best.nearer(edge_gap(&one, &other));
        }
    }
    best
}

/// Returns the point at which an edge goes through a triangle.
fn pierced([from, to]: &[Point3<f64>; 2], [a, b, c]: &TriangleCorners) -> Option<Point3<f64>> {
    let way = to - from;
    let [ab, ac] = [b - a, c - a];
    let across = way.cross(&ac);
    let volume = ab.dot(&across);
    // An edge parallel to the plane crosses at an edge of the triangle, which the edge tests find.
    if volume == 0.0 {
        return None;
    }
    let off = from - a;
    let u = off.dot(&across) / volume;
    let aside = off.cross(&ab);
    let v = way.dot(&aside) / volume;
    let t = ac.dot(&aside) / volume;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t);
    inside.then(|| from + way * t)
}

/// Returns the point of a triangle nearest to a point, by the region of its plane that the point is over.
pub(crate) fn on_triangle(p: &Point3<f64>, [a, b, c]: &TriangleCorners) -> Point3<f64> {
    let [ab, ac, bc] = [b - a, c - a, c - b];
    let normal = ab.cross(&ac);
    let inside =
        |edge: &Vector3<f64>, start: &Point3<f64>| edge.cross(&(p - start)).dot(&normal) >= 0.0;
    let size = normal.norm_squared();
    if size > 0.0 && inside(&ab, a) && inside(&bc, b) && inside(&-ac, c) {
        return p - normal * (normal.dot(&(p - a)) / size);
    }
    let feet = [on_edge(p, a, &ab), on_edge(p, b, &bc), on_edge(p, a, &ac)];
    let off = |q: &Point3<f64>| (q - p).norm_squared();
    let [first, rest @ ..] = feet;
    rest.into_iter().fold(first, |best, q| if off(&q) < off(&best) { q } else { best })
}

fn on_edge(p: &Point3<f64>, start: &Point3<f64>, way: &Vector3<f64>) -> Point3<f64> {
    let length = way.norm_squared();
    let share = if length > 0.0 { (way.dot(&(p - start)) / length).clamp(0.0, 1.0) } else { 0.0 };
    start + way * share
}

/// Returns the gap between two edges.
fn edge_gap(a: &[Point3<f64>; 2], b: &[Point3<f64>; 2]) -> MeshGap {
    let [u, v, w] = [a[1] - a[0], b[1] - b[0], a[0] - b[0]];
    let [uu, uv, vv, uw, vw] = [u.dot(&u), u.dot(&v), v.dot(&v), u.dot(&w), v.dot(&w)];
    let det = uu * vv - uv * uv;
    // Step 1: nearest points of the lines, the first clamped to its edge; of parallel edges any will do.
    let s = if det > 0.0 { ((uv * vw - vv * uw) / det).clamp(0.0, 1.0) } else { 0.0 };
    // Step 2: the other one for it, clamped, and back again.
    let t = if vv > 0.0 { ((uv * s + vw) / vv).clamp(0.0, 1.0) } else { 0.0 };
    let s = if uu > 0.0 { ((uv * t - uw) / uu).clamp(0.0, 1.0) } else { 0.0 };
    MeshGap::between(&(a[0] + u * s), &(b[0] + v * t))
}

/// Distance between two boxes.
fn box_gap(a: &BoundingBox, b: &BoundingBox) -> f64 {
    let apart = Vector3::from_fn(|k, _| (a.low[k] - b.high[k]).max(b.low[k] - a.high[k]).max(0.0));
    apart.norm()
}

/// Two closed meshes, the second in a place of the frame of the first.
pub(crate) struct MeshPair<'a> {
    pub(crate) first: &'a ClosedMesh,
    pub(crate) second: &'a ClosedMesh,
    pub(crate) place: Isometry3<f64>,
}

/// Node pair of both trees, with a lower bound on its distance.
struct NodePair {
    low: f64,
    nodes: [usize; 2],
}

impl MeshPair<'_> {
    /// Returns the box in the first frame around a box of the second.
    fn placed(&self, bounds: &BoundingBox) -> BoundingBox {
        let middle = self.place * center(&bounds.low, &bounds.high);
        let half = (bounds.high - bounds.low) * 0.5;
        let half = self.place.rotation.to_rotation_matrix().matrix().abs() * half;
        BoundingBox { low: middle - half, high: middle + half }
    }

    fn pair(&self, nodes: [usize; 2]) -> Option<NodePair> {
        let [a, b] = [self.first.tree.bounds(nodes[0])?, self.second.tree.bounds(nodes[1])?];
        Some(NodePair { low: box_gap(a, &self.placed(b)), nodes })
    }

    /// Returns the gap between the surfaces, if it is below `cap` \[mm\], or one that is larger by at most `slack`: of
    /// parallel planes all triangles are equally near, and not each pair has to be compared.
    pub(crate) fn gap(&self, cap: f64, slack: f64) -> Option<MeshGap> {
        let mut best: Option<MeshGap> = None;
        let mut most = cap;
        let roots = [self.first.tree.root()?, self.second.tree.root()?];
        let mut open = vec![self.pair(roots)?];
        while let Some(NodePair { low, nodes }) = open.pop() {
            if low >= most {
                continue;
            }
            if best.is_some() && low >= most - slack {
                continue;
            }
            let below = [self.first.tree.below(nodes[0]), self.second.tree.below(nodes[1])];
            let mut next: Vec<NodePair> = match &below {
                [TreeChildren::Items(a), TreeChildren::Items(b)] => {
                    for one in *a {
                        let Some(first) = self.first.triangle(one.content.item) else { continue };
                        for other in *b {
                            let nearest = most - if best.is_some() { slack } else { 0.0 };
                            if box_gap(&one.bounds, &self.placed(&other.bounds)) >= nearest {
                                continue;
                            }
                            let Some(second) = self.second.triangle(other.content.item) else {
                                continue;
                            };
                            let gap = triangle_gap(&first, &second.map(|p| self.place * p));
                            if gap.distance < most {
                                (most, best) = (gap.distance, Some(gap));
                            }
                        }
                    }
                    continue;
                }
                [TreeChildren::Nodes(a), TreeChildren::Items(_)] => {
                    a.iter().filter_map(|a| self.pair([*a, nodes[1]])).collect()
                }
                [TreeChildren::Items(_), TreeChildren::Nodes(b)] => {
                    b.iter().filter_map(|b| self.pair([nodes[0], *b])).collect()
                }
                [TreeChildren::Nodes(a), TreeChildren::Nodes(b)] => {
                    let all = a.iter().flat_map(|a| b.iter().map(move |b| [*a, *b]));
                    all.filter_map(|nodes| self.pair(nodes)).collect()
                }
            };
            if most <= 0.0 {
                break;
            }
            // The nearest pair is opened first: it lies on top of the stack.
            next.sort_by(|a, b| b.low.total_cmp(&a.low));
            open.extend(next);
        }
        best
    }

    /// Returns true if one mesh lies inside the other, their surfaces apart.
    pub(crate) fn is_inside(&self) -> bool {
        let corner = |mesh: &ClosedMesh| mesh.mesh().vertices.first().copied();
        let held = |mesh: &ClosedMesh, point: Option<Point3<f64>>| {
            point.is_some_and(|point| mesh.holds(&point))
        };
        held(self.first, corner(self.second).map(|p| self.place * p))
            || held(self.second, corner(self.first).map(|p| self.place.inverse() * p))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::Mesh;

    fn noise(seed: u32) -> f64 {
        let x = (f64::from(seed) * 12.9898).sin() * 43_758.545_3;
        2.0 * (x - x.floor()) - 1.0
    }

    fn triangle(seed: u32, far: f64) -> TriangleCorners {
        [0, 3, 6].map(|k| {
            let at = |i| noise(9 * seed + k + i);
            Point3::new(2.0 * at(0) + far, 2.0 * at(1), 2.0 * at(2))
        })
    }

    /// Against points of both triangles, 40 a side, which are at most this much nearer or farther.
    #[test]
    fn the_gap_of_triangles_is_that_of_their_points() {
        let points = |t: &TriangleCorners| -> Vec<Point3<f64>> {
            let at = |i: u32, j: u32| {
                let [u, v] = [i, j].map(|k| f64::from(k) / 40.0);
                t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v
            };
            (0..=40).flat_map(|i| (0..=40 - i).map(move |j| at(i, j))).collect()
        };
        for seed in 0..60 {
            let (a, b) = (triangle(seed, 0.0), triangle(seed + 1000, f64::from(seed % 4)));
            let (first, second) = (points(&a), points(&b));
            let least = first
                .iter()
                .flat_map(|p| second.iter().map(move |q| (p - q).norm()))
                .fold(f64::INFINITY, f64::min);
            let gap = triangle_gap(&a, &b).distance;
            assert!(gap <= least + 1e-12 && gap >= least - 0.3, "{seed}: {gap} {least}");
            assert!(gap > 0.0 || least < 0.3);
            // Rounded points that are nearest are as far from each other.
            let other = triangle_gap(&b, &a).distance;
            assert!((gap - other).abs() < 1e-12);
        }
    }

    #[test]
    fn the_gap_of_meshes_is_that_of_all_triangles() {
        let mesh = |offset: u32| {
            let triangles: Vec<TriangleCorners> =
                (0..60).map(|i| triangle(offset + i, noise(offset + 7 * i) * 8.0)).collect();
            let vertices: Vec<Point3<f64>> = triangles.iter().flatten().copied().collect();
            let triangles = (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            ClosedMesh::new(Mesh { vertices, triangles }).unwrap()
        };
        let (first, second) = (mesh(0), mesh(5000));
        for i in 0..20 {
            let turn = Vector3::new(noise(i), noise(i + 50), noise(i + 90)) * 2.0;
            let place =
                Isometry3::new(Vector3::new(3.0 * noise(i + 7), 8.0, 0.5 * f64::from(i)), turn);
            let pair = MeshPair { first: &first, second: &second, place };
            let all = (0..60).flat_map(|a| (0..60).map(move |b| (a, b)));
            let least = all
                .map(|(a, b)| {
                    let b = second.triangle(b).unwrap().map(|p| place * p);
                    triangle_gap(&first.triangle(a).unwrap(), &b).distance
                })
                .fold(f64::INFINITY, f64::min);
            let found = pair.gap(f64::INFINITY, 0.0).unwrap();
            assert!((found.distance - least).abs() < 1e-12, "{i}");
            assert_eq!(pair.gap(least, 0.0), None);
            assert!(pair.gap(f64::INFINITY, 0.5).unwrap().distance <= least + 0.5);
        }
    }
}
