//! Boxes round small pieces of a NURBS surface: proof that the surface keeps away from a point.

use super::nurbs::NurbsSurface;
use super::parameter_box::ParameterBox;
use super::patches::{PatchPiece, cells_within, hull_box};
use super::proximity::{SolidDistance, SolidProximity};
use nalgebra::Point3;
use nalgebra::Vector3;

/// Diagonal of the boxes to which patches are halved, as a share of that of all: a piece of a single patch is then
/// about a 32nd of it in both directions.
const SHARE: f64 = 1.0 / 32.0;

/// Halvings of a patch at most.
const DEPTH: u32 = 11;

/// Boxes of the control points of pieces, and of pairs of pieces, up to the whole surface.
#[derive(Debug, Clone)]
pub(super) struct HullTree {
    nodes: Vec<HullNode>,
}

#[derive(Debug, Clone, Copy)]
struct HullNode {
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// The two halves; 0, which is nobody's half, at a single piece.
    halves: [usize; 2],
    /// A corner of the surface inside.
    corner: Point3<f64>,
}

/// Part of the domain that counts, and the size to which patches are halved.
#[derive(Debug, Clone, Copy)]
struct PatchDivision {
    bounds: ParameterBox,
    /// Diagonal of a box \[mm\].
    size: f64,
}

/// Size of a box, and halvings that are left.
#[derive(Debug, Clone, Copy)]
struct PieceLimit {
    /// Diagonal \[mm\].
    size: f64,
    depth: u32,
}

impl HullTree {
    /// Builds the boxes of the part of the domain within `bounds`.
    pub(super) fn new(surface: &NurbsSurface, bounds: ParameterBox) -> Self {
        let cells = cells_within(surface, bounds);
        let mut tree = Self { nodes: Vec::new() };
        let [[i0, i1], [j0, j1]] = cells;
        let patches = (i0..i1).flat_map(|i| (j0..j1).filter_map(move |j| surface.patch(i, j)));
        let piece = |patch| PatchPiece::of(&patch, surface.degree()[1]).within(bounds);
        let nothing = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
        let [low, high] = patches.map(piece).fold(nothing, |[low, high], piece| {
            let (a, b) = hull_box(&piece.points);
            [low.inf(&a), high.sup(&b)]
        });
        let size = SHARE * (high - low).norm();
        tree.patches(surface, cells, PatchDivision { bounds, size });
        tree
    }

    /// Builds the tree of a rectangle of patches; returns its root.
    fn patches(
        &mut self,
        surface: &NurbsSurface,
        cells: [[usize; 2]; 2],
        division: PatchDivision,
    ) -> Option<usize> {
        let PatchDivision { bounds, size } = division;
        let [[i0, i1], [j0, j1]] = cells;
        if i1 - i0 <= 1 && j1 - j0 <= 1 {
            let patch = surface.patch(i0, j0)?;
            let piece = PatchPiece::of(&patch, surface.degree()[1]).within(bounds);
            return Some(self.piece(&piece, PieceLimit { size, depth: DEPTH }));
        }
        let index = self.reserve();
        let k = usize::from(j1 - j0 > i1 - i0);
        let (mut first, mut second) = (cells, cells);
        let middle = usize::midpoint(cells[k][0], cells[k][1]);
        (first[k][1], second[k][0]) = (middle, middle);
        let halves =
            [self.patches(surface, first, division)?, self.patches(surface, second, division)?];
        Some(self.join(index, halves))
    }

    fn piece(&mut self, piece: &PatchPiece, limit: PieceLimit) -> usize {
        let index = self.reserve();
        let (low, high) = hull_box(&piece.points);
        if limit.depth == 0 || (high - low).norm() <= limit.size {
            // A Bezier piece passes through the corners of its net.
            let corner = piece.points.first().map(|point| point.xyz() / point.w);
            let corner = Point3::from(corner.unwrap_or(low));
            self.nodes[index] = HullNode { low, high, halves: [0; 2], corner };
            return index;
        }
        let limit = PieceLimit { depth: limit.depth - 1, ..limit };
        let halves = piece.halves().map(|half| self.piece(&half, limit));
        self.join(index, halves)
    }

    fn reserve(&mut self) -> usize {
        let nothing = Vector3::zeros();
        let corner = Point3::origin();
        self.nodes.push(HullNode { low: nothing, high: nothing, halves: [0; 2], corner });
        self.nodes.len() - 1
    }

    fn join(&mut self, index: usize, halves: [usize; 2]) -> usize {
        let [a, b] = halves.map(|half| self.nodes[half]);
        let (low, high) = (a.low.inf(&b.low), a.high.sup(&b.high));
        self.nodes[index] = HullNode { low, high, halves, corner: a.corner };
        index
    }

    /// Decides if the surface comes nearer than `limit` to a solid.
    pub(super) fn meets(&self, gap: SolidDistance<'_>, limit: f64) -> SolidProximity {
        if self.nodes.is_empty() {
            SolidProximity::Undecided
        } else {
            self.node_meets(0, gap, limit)
        }
    }

    fn node_meets(&self, index: usize, gap: SolidDistance<'_>, limit: f64) -> SolidProximity {
        let node = &self.nodes[index];
        // 1-Lipschitz: over a box at least the distance of the centre less half the diagonal.
        let least = |node: &HullNode| {
            let centre = Point3::from(0.5 * (node.low + node.high));
            gap(&centre).0 - 0.5 * (node.high - node.low).norm()
        };
        if least(node) >= limit {
            return SolidProximity::Clear;
        }
        if node.halves[0] == 0 {
            // The box is too near; only a point of the surface can settle it.
            let nearer = gap(&node.corner).0 < limit;
            return if nearer {
                SolidProximity::Nearer(node.corner)
            } else {
                SolidProximity::Undecided
            };
        }
        let [a, b] = node.halves;
        // Nearer points are mostly in the nearer half.
        let order = if least(&self.nodes[a]) <= least(&self.nodes[b]) { [a, b] } else { [b, a] };
        let mut found = SolidProximity::Clear;
        for half in order {
            match self.node_meets(half, gap, limit) {
                SolidProximity::Clear => {}
                SolidProximity::Undecided => found = SolidProximity::Undecided,
                nearer @ SolidProximity::Nearer(_) => return nearer,
            }
        }
        found
    }

    /// Returns `true` if all boxes are at least `radius` away from `p`: proof that the surface is.
    pub(super) fn clear_of(&self, p: &Point3<f64>, radius: f64) -> bool {
        !self.nodes.is_empty() && radius.is_finite() && self.node_clear(0, p, radius)
    }

    fn node_clear(&self, index: usize, p: &Point3<f64>, radius: f64) -> bool {
        let node = &self.nodes[index];
        let gap = (node.low - p.coords).sup(&(p.coords - node.high)).sup(&Vector3::zeros());
        // Written so that a point that is not a number is never clear.
        gap.norm_squared() >= radius * radius.max(0.0)
            || (node.halves[0] != 0
                && node.halves.iter().all(|&half| self.node_clear(half, p, radius)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Face;
    use crate::surface::FaceIndex;
    use crate::surface::Surface;

    /// A patch of 3 x 2 pieces that rolls like a sea.
    fn sea() -> NurbsSurface {
        let knots =
            [vec![0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0], vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]];
        let height = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 8.0 } else { -5.0 };
        let point =
            |i: usize, j: usize| Point3::new(20.0 * i as f64, 15.0 * j as f64, height(i, j));
        let points = (0..5).map(|i| (0..4).map(|j| point(i, j)).collect()).collect();
        NurbsSurface::new([2, 2], knots, points, None).unwrap()
    }

    #[test]
    fn clear_is_never_closer_and_hardly_ever_missed() {
        let surface = sea();
        let tree = HullTree::new(&surface, surface.domain());
        let face = Face::new(1, Surface::Nurbs(surface), vec![]).unwrap();
        let face = FaceIndex::new(face).unwrap();
        for k in 0..40 {
            let t = f64::from(k);
            let p = Point3::new(2.0 * t - 5.0, 40.0 * (0.7 * t).sin().abs(), 3.0 + 0.5 * t);
            let foot = face.closest(&p).unwrap();
            let distance = (p - foot.point).norm();
            assert!(!tree.clear_of(&p, distance * (1.0 + 1e-9)), "{p} {distance}");
            // Pieces of up to 2.5 mm, sloping by 30 degrees and more.
            assert!(tree.clear_of(&p, distance - 2.0), "{p} {distance}");
        }
        assert!(!tree.clear_of(&Point3::new(f64::NAN, 0.0, 0.0), 1.0));
    }

    #[test]
    fn a_ball_is_met_where_the_closest_point_is_nearer() {
        let surface = sea();
        let tree = HullTree::new(&surface, surface.domain());
        let face = Face::new(1, Surface::Nurbs(surface), vec![]).unwrap();
        let face = FaceIndex::new(face).unwrap();
        for k in 0..40 {
            let t = f64::from(k);
            let p = Point3::new(2.0 * t - 5.0, 40.0 * (0.7 * t).sin().abs(), 3.0 + 0.5 * t);
            let exact = (p - face.closest(&p).unwrap().point).norm();
            let ball =
                |radius: f64| move |q: &Point3<f64>| ((q - p).norm() - radius, (q - p).normalize());
            let SolidProximity::Nearer(q) = tree.meets(&ball(exact + 2.0), 0.0) else {
                panic!("a ball that goes in by 2 mm, {p}")
            };
            assert!((q - p).norm() < exact + 2.0 && (q - p).norm() > exact - 1e-9, "{p}");
            assert_eq!(tree.meets(&ball(exact - 4.0), 0.0), SolidProximity::Clear, "{p}");
            assert_ne!(tree.meets(&ball(exact + 1e-9), 0.0), SolidProximity::Clear, "{p}");
            let fine = face.meets(&ball(exact + 1e-6), 0.0);
            assert!(
                matches!(fine, SolidProximity::Nearer(q) if (q - p).norm() < exact + 1e-6),
                "{p}"
            );
            assert_eq!(face.meets(&ball(exact - 1e-6), 0.0), SolidProximity::Clear, "{p}");
            assert_eq!(face.nearer(&p, exact * (1.0 - 1e-9)).unwrap(), None, "{p}");
            let nearer = face.nearer(&p, exact * (1.0 + 1e-9)).unwrap().unwrap();
            assert!((nearer - exact).abs() <= 1e-9 * exact, "{p}");
            let other = face.nearer(&p, exact + 2.0).unwrap().unwrap();
            assert!(other >= exact * (1.0 - 1e-9) && other < exact + 2.0, "{p}");
        }
    }
}
