//! Distance between two triangles, and between the triangles of two meshes.

use super::bvh::{BoundingBox, TreeChildren, TreeItem};
use super::mesh::ClosedMesh;
use nalgebra::{Isometry3, Matrix3, Point3, Vector3, center};

/// Corners of a triangle.
pub(crate) type TriangleCorners = [Point3<f64>; 3];

/// Nearest points of two shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MeshGap {
    /// Distance \[mm\]; 0 where they cross.
    pub(crate) distance: f64,
    /// Nearest point of each.
    pub(crate) ends: [Point3<f64>; 2],
    /// Numbers of the triangles in their meshes; 0 for triangles outside a mesh.
    pub(crate) triangles: [u32; 2],
}

impl MeshGap {
    fn between(a: &Point3<f64>, b: &Point3<f64>) -> Self {
        Self { distance: (b - a).norm(), ends: [*a, *b], triangles: [0; 2] }
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
            return MeshGap { distance: 0.0, ends: [point; 2], triangles: [0; 2] };
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
    first: &'a ClosedMesh,
    second: &'a ClosedMesh,
    place: Isometry3<f64>,
    rotation: Matrix3<f64>,
    /// Absolute values of the rotation: how far a turned box reaches.
    reach: Matrix3<f64>,
}

/// Bounds on the motion of every point of the second mesh against the first, from where it is placed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SweptTravel {
    /// Largest travel along each coordinate of the first frame \[mm\].
    pub(crate) along: Vector3<f64>,
    /// Largest travel in any direction \[mm\].
    pub(crate) most: f64,
}

impl SweptTravel {
    /// Nothing moves.
    pub(crate) const NONE: Self = Self { along: Vector3::new(0.0, 0.0, 0.0), most: 0.0 };

    /// Bounds the travel from one end of a gap towards the other: along the straight line between them.
    ///
    /// Both triangles are convex, so planes across that line, as far apart as the gap, keep them on both sides: what moves along
    /// the planes does not come nearer.
    fn across(&self, gap: &MeshGap) -> f64 {
        let way = gap.ends[1] - gap.ends[0];
        if way.norm() <= 0.0 {
            return self.most;
        }
        (way.abs().dot(&self.along) / way.norm()).min(self.most)
    }
}

/// Goal of a search between two meshes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapGoal {
    /// Distance from which nothing is returned \[mm\].
    pub(crate) cap: f64,
    /// Length by which the gap that is returned may be larger than the least \[mm\].
    pub(crate) slack: f64,
    /// Triangles that were nearest at a place near by: a good first bound.
    pub(crate) hint: Option<[u32; 2]>,
    /// Motion over which the gap is bounded from below.
    pub(crate) travel: SweptTravel,
    /// Difference of gap and bound from which the search ends at once: parts of the motion have to be looked at \[mm\].
    pub(crate) sharp: f64,
}

impl GapGoal {
    /// Returns the goal of bodies that stand still.
    pub(crate) fn below(cap: f64, slack: f64) -> Self {
        Self { cap, slack, hint: None, travel: SweptTravel::NONE, sharp: f64::INFINITY }
    }
}

/// Gap in the middle of a motion, and a bound over all of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SweptGap {
    /// Gap in the middle, between the triangles with the least bound.
    pub(crate) gap: MeshGap,
    /// Lower bound of the distance of all triangles over the whole motion \[mm\]; `None` if the search ended early.
    pub(crate) low: Option<f64>,
}

/// Node pair of both trees, with a lower bound on its distance.
struct NodePair {
    low: f64,
    nodes: [usize; 2],
}

/// Most node pairs that are opened for a motion of which parts can be looked at.
const MOST_PAIRS: usize = 2000;

/// Box in the middle of a motion, and over all of it.
struct SweptBox {
    middle: BoundingBox,
    swept: BoundingBox,
}

/// Triangles with the least bound so far.
struct NearestTriangles {
    /// The gap, and its bound.
    best: Option<(MeshGap, f64)>,
    goal: GapGoal,
    /// True if a gap is below the cap, and its bound too blurred to say more.
    blurred: bool,
}

impl NearestTriangles {
    /// Returns the distance from which boxes need not be opened.
    fn most(&self) -> f64 {
        self.best.map_or(self.goal.cap, |(_, low)| low - self.goal.slack)
    }

    /// Compares two triangles, the second in the frame of the first.
    fn compare(&mut self, first: &TriangleCorners, second: &TriangleCorners, items: [u32; 2]) {
        let gap = triangle_gap(first, second);
        let travel = self.goal.travel.across(&gap);
        let low = gap.distance - travel;
        if low < self.best.map_or(self.goal.cap, |(_, low)| low) {
            self.best = Some((MeshGap { triangles: items, ..gap }, low));
            self.blurred |= travel + self.goal.slack > self.goal.sharp;
        }
    }
}

impl<'a> MeshPair<'a> {
    /// Places the second mesh in the frame of the first.
    pub(crate) fn new(
        first: &'a ClosedMesh,
        second: &'a ClosedMesh,
        place: Isometry3<f64>,
    ) -> Self {
        let rotation = *place.rotation.to_rotation_matrix().matrix();
        Self { first, second, place, rotation, reach: rotation.abs() }
    }

    /// Returns the boxes in the first frame around a box of the second: in the middle, and wherever it travels.
    fn swept_box(&self, bounds: &BoundingBox, travel: &SweptTravel) -> SweptBox {
        let at = self.point(&center(&bounds.low, &bounds.high));
        let half = self.reach * ((bounds.high - bounds.low) * 0.5);
        let middle = BoundingBox { low: at - half, high: at + half };
        let swept =
            BoundingBox { low: middle.low - travel.along, high: middle.high + travel.along };
        SweptBox { middle, swept }
    }

    fn point(&self, p: &Point3<f64>) -> Point3<f64> {
        self.rotation * p + self.place.translation.vector
    }

    /// Returns the gap between the surfaces, if it is below the cap, or one that is larger by at most the slack: of
    /// parallel planes all triangles are equally near, and not each pair has to be compared.
    pub(crate) fn gap(&self, cap: f64, slack: f64, hint: Option<[u32; 2]>) -> Option<MeshGap> {
        let goal = GapGoal { hint, ..GapGoal::below(cap, slack) };
        self.swept(goal).map(|swept| swept.gap)
    }

    /// Bounds the gap between the surfaces over a motion; `None` if it is nowhere below the cap.
    pub(crate) fn swept(&self, goal: GapGoal) -> Option<SweptGap> {
        let mut nearest = NearestTriangles { best: None, goal, blurred: false };
        if let Some([a, b]) = goal.hint
            && let (Some(first), Some(second)) = (self.first.triangle(a), self.second.triangle(b))
        {
            nearest.compare(&first, &second.map(|p| self.point(&p)), [a, b]);
        }
        let roots = [self.first.tree.root()?, self.second.tree.root()?];
        let mut open = vec![NodePair { low: f64::NEG_INFINITY, nodes: roots }];
        // Where the travel is about as long as the gap, nearly all triangles have to be compared: parts of the motion are
        // quicker.
        let mut left = if goal.travel.most > goal.sharp { MOST_PAIRS } else { usize::MAX };
        while let Some(NodePair { low, nodes: [a, b] }) = open.pop() {
            left -= 1;
            nearest.blurred |= left == 0 && nearest.best.is_some();
            if nearest.blurred {
                break;
            }
            left = left.max(1);
            if low >= nearest.most() {
                continue;
            }
            match [self.first.tree.below(a), self.second.tree.below(b)] {
                [TreeChildren::Items(a), TreeChildren::Items(b)] => {
                    self.compare_all([a, b], &mut nearest);
                }
                [TreeChildren::Nodes(a), TreeChildren::Items(_)] => {
                    self.open_pairs(&a, &[b], &nearest, &mut open);
                }
                [TreeChildren::Items(_), TreeChildren::Nodes(b)] => {
                    self.open_pairs(&[a], &b, &nearest, &mut open);
                }
                [TreeChildren::Nodes(a), TreeChildren::Nodes(b)] => {
                    self.open_pairs(&a, &b, &nearest, &mut open);
                }
            }
        }
        let low = |low: f64| (!nearest.blurred).then_some(low - goal.slack);
        nearest.best.map(|(gap, bound)| SweptGap { gap, low: low(bound) })
    }

    /// Returns a lower bound of the bounds of all triangles in two boxes, the second swept: the larger of the distance by
    /// coordinates and that of the boxes in the middle less the largest travel.
    fn box_bound(first: &BoundingBox, second: &SweptBox, travel: &SweptTravel) -> f64 {
        let least = box_gap(first, &second.middle) - travel.most;
        let swept = box_gap(first, &second.swept);
        // Boxes that overlap say nothing: their triangles may go deep into each other.
        if swept > 0.0 { swept.max(least) } else { least }
    }

    /// Puts all pairs of nodes on the stack that may be nearer; the nearest pair lies on top.
    fn open_pairs(
        &self,
        first: &[usize],
        second: &[usize],
        nearest: &NearestTriangles,
        open: &mut Vec<NodePair>,
    ) {
        let (from, most) = (open.len(), nearest.most());
        for b in second {
            let Some(bounds) = self.second.tree.bounds(*b) else { continue };
            let placed = self.swept_box(bounds, &nearest.goal.travel);
            for a in first {
                let bounds = self.first.tree.bounds(*a);
                let low = bounds
                    .map_or(f64::INFINITY, |a| Self::box_bound(a, &placed, &nearest.goal.travel));
                if low < most {
                    open.push(NodePair { low, nodes: [*a, *b] });
                }
            }
        }
        if let Some(opened) = open.get_mut(from..) {
            opened.sort_by(|a, b| b.low.total_cmp(&a.low));
        }
    }

    /// Compares the triangles of two leaves.
    fn compare_all(&self, [a, b]: [&[TreeItem]; 2], nearest: &mut NearestTriangles) {
        for other in b {
            let bounds = self.swept_box(&other.bounds, &nearest.goal.travel);
            let mut placed: Option<TriangleCorners> = None;
            for one in a {
                let low = Self::box_bound(&one.bounds, &bounds, &nearest.goal.travel);
                if low >= nearest.most() || nearest.blurred {
                    continue;
                }
                let [one, other] = [one.content.item, other.content.item];
                if placed.is_none() {
                    placed =
                        self.second.triangle(other).map(|corners| corners.map(|p| self.point(&p)));
                }
                if let (Some(first), Some(second)) = (self.first.triangle(one), &placed) {
                    nearest.compare(&first, second, [one, other]);
                }
            }
        }
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
    use nalgebra::Translation3;

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
            let pair = MeshPair::new(&first, &second, place);
            let all = (0..60).flat_map(|a| (0..60).map(move |b| (a, b)));
            let least = all
                .map(|(a, b)| {
                    let b = second.triangle(b).unwrap().map(|p| place * p);
                    triangle_gap(&first.triangle(a).unwrap(), &b).distance
                })
                .fold(f64::INFINITY, f64::min);
            let found = pair.gap(f64::INFINITY, 0.0, None).unwrap();
            assert!((found.distance - least).abs() < 1e-12, "{i}");
            assert!(pair.gap(least - 1e-9, 0.0, None).is_none() || least <= 0.0, "{i}");
            assert!(pair.gap(f64::INFINITY, 0.5, None).unwrap().distance <= least + 0.5);
            // A hint, good or bad, changes nothing.
            for hint in [found.triangles, [i % 60, 7 * i % 60]] {
                let again = pair.gap(f64::INFINITY, 0.0, Some(hint)).unwrap();
                assert!((again.distance - least).abs() < 1e-12, "{i}");
            }
            // Where they cross, a motion is looked at even if only what touches counts.
            if least <= 0.0 {
                let most = SweptTravel { along: Vector3::repeat(0.1), most: 0.2 };
                let touching = GapGoal { travel: most, sharp: 0.1, ..GapGoal::below(0.0, 0.0) };
                assert!(pair.swept(touching).is_some(), "{i}");
            }
            // The bound holds wherever the second mesh is moved, and is sharp where it is not.
            let along = Vector3::new(0.1, 0.4, 0.0);
            let travel = SweptTravel { along, most: along.norm() };
            let goal = GapGoal { travel, ..GapGoal::below(f64::INFINITY, 0.0) };
            let low = pair.swept(goal).unwrap().low.unwrap();
            assert!(low <= least && low >= least - travel.most, "{i}");
            for k in 0..30 {
                let by = along.component_mul(&Vector3::from([0, 1, 2].map(|j| noise(97 * k + j))));
                let there = MeshPair::new(&first, &second, Translation3::from(by) * place);
                let distance = there.gap(f64::INFINITY, 0.0, None).unwrap().distance;
                assert!(distance >= low - 1e-12, "{i}: {distance} {low}");
            }
            let blurred = GapGoal { sharp: 0.0, ..goal };
            assert!(pair.swept(blurred).unwrap().low.is_none() || low <= -travel.most);
        }
    }
}
