//! Bound-and-prune search over the Bezier patches of a NURBS surface.

use super::error::ClosestError;
use super::newton::{self, FacePoint};
use super::nurbs::BezierPatch;
use super::nurbs::NurbsSurface;
use super::parameter_box::ParameterBox;
use super::proximity::{SolidDistance, SolidProximity};
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Vector3;
use nalgebra::Vector4;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Two distances closer than this share of the numbers involved count as equal: halving a patch
/// 40 times leaves relative errors of at most `40 p eps`, about 1e-13, in its control points.
const EQUAL: f64 = 1e-10;

/// Patches examined before the search gives up; an ordinary query examines tens.
const LOOKS: usize = 20_000;

/// Pieces examined in the search for one near a solid: those of a tool that keeps a tenth of a millimetre off all round a
/// tube of a thousand patches.
const MEETINGS: usize = 20_000;

/// Boxes over rectangles of patches, halved down to single patches.
#[derive(Debug, Clone)]
pub(crate) struct PatchTree {
    nodes: Vec<PatchNode>,
    /// Ranges of u and v that count.
    bounds: ParameterBox,
}

#[derive(Debug, Clone)]
struct PatchNode {
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Ranges of patch columns and rows.
    cells: [[usize; 2]; 2],
    /// Indices of the two halves; the first is the node itself at a single patch.
    halves: [usize; 2],
}

/// An entry of the queue: nothing below it is closer than `bound`.
struct QueueEntry {
    bound: f64,
    kind: QueueItem,
}

enum QueueItem {
    Node(usize),
    Piece(Box<PatchPiece>),
}

/// Part of a patch: its own control points and rectangle.
pub(super) struct PatchPiece {
    pub(super) points: Vec<Vector4<f64>>,
    columns: usize,
    bounds: ParameterBox,
}

/// Best point found so far.
struct BestPoint {
    uv: [f64; 2],
    distance: f64,
}

impl PatchTree {
    /// Builds the tree over the part of the domain within `bounds`.
    pub(crate) fn new(surface: &NurbsSurface, bounds: ParameterBox) -> Self {
        let cells = cells_within(surface, bounds);
        let [columns, rows] = cells.map(|[first, end]| end - first);
        let mut tree = Self { nodes: Vec::with_capacity(2 * columns * rows), bounds };
        tree.build(surface, cells);
        tree
    }

    /// Returns the part of a patch that counts.
    fn piece(&self, surface: &NurbsSurface, [i, j]: [usize; 2]) -> Option<PatchPiece> {
        let patch = surface.patch(i, j)?;
        Some(PatchPiece::of(&patch, surface.degree()[1]).within(self.bounds))
    }

    fn build(&mut self, surface: &NurbsSurface, cells: [[usize; 2]; 2]) -> usize {
        let index = self.nodes.len();
        let [[i0, i1], [j0, j1]] = cells;
        let (low, high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        self.nodes.push(PatchNode { low, high, cells, halves: [index; 2] });
        if i1 - i0 <= 1 && j1 - j0 <= 1 {
            if let Some(piece) = self.piece(surface, [i0, j0]) {
                let (low, high) = hull_box(&piece.points);
                (self.nodes[index].low, self.nodes[index].high) = (low, high);
            }
            return index;
        }
        let (mut first, mut second) = (cells, cells);
        // Across the direction of more patches, so that boxes stay compact.
        let k = usize::from(j1 - j0 > i1 - i0);
        let middle = usize::midpoint(cells[k][0], cells[k][1]);
        (first[k][1], second[k][0]) = (middle, middle);
        let halves = [self.build(surface, first), self.build(surface, second)];
        for half in halves {
            let (low, high) = (self.nodes[half].low, self.nodes[half].high);
            let node = &mut self.nodes[index];
            (node.low, node.high) = (node.low.inf(&low), node.high.sup(&high));
        }
        self.nodes[index].halves = halves;
        index
    }

    /// Finds the parameters of the closest point over the domain.
    pub(crate) fn closest(
        &self,
        surface: &NurbsSurface,
        p: &Point3<f64>,
    ) -> Result<[f64; 2], ClosestError> {
        let best = BestPoint { uv: [f64::NAN; 2], distance: f64::INFINITY };
        self.search(surface, p, best, 0.0).map(|best| best.uv)
    }

    /// Returns the distance of some point of the domain that is nearer than `enough`; `None` proves
    /// that there is none.
    pub(crate) fn nearer(
        &self,
        surface: &NurbsSurface,
        p: &Point3<f64>,
        enough: f64,
    ) -> Result<Option<f64>, ClosestError> {
        // So that what the search leaves out is no nearer than `enough`.
        let none = BestPoint { uv: [f64::NAN; 2], distance: enough + self.slack(p) };
        let best = self.search(surface, p, none, enough)?;
        Ok(Some(best.distance).filter(|distance| *distance < enough))
    }

    /// Returns the difference below which distances count as equal \[mm\].
    fn slack(&self, p: &Point3<f64>) -> f64 {
        let size = |root: &PatchNode| (root.high - root.low).norm() + root.high.norm();
        EQUAL * (self.nodes.first().map_or(0.0, size) + p.coords.norm())
    }

    /// Finds the closest point over the domain if it is nearer than `best`, or the first one nearer
    /// than `enough`.
    fn search(
        &self,
        surface: &NurbsSurface,
        p: &Point3<f64>,
        mut best: BestPoint,
        enough: f64,
    ) -> Result<BestPoint, ClosestError> {
        let Some(root) = self.nodes.first() else { return Err(ClosestError::NotFinite) };
        let slack = self.slack(p);
        let mut queue = BinaryHeap::new();
        queue.push(QueueEntry { bound: box_distance(p, root), kind: QueueItem::Node(0) });
        for _ in 0..LOOKS {
            let Some(look) = queue.pop() else { return Ok(best) };
            // The queue gives the smallest bound first: if this one is no closer, nothing is.
            if look.bound >= best.distance - slack || best.distance < enough {
                return Ok(best);
            }
            match look.kind {
                QueueItem::Node(index) => self.open(surface, p, index, &best, &mut queue),
                QueueItem::Piece(piece) => self.split(surface, p, &piece, &mut best, &mut queue),
            }
        }
        let bound = queue.peek().map_or(best.distance, |look| look.bound);
        Err(ClosestError::Undecided { uv: best.uv.into(), distance: best.distance, bound })
    }

    /// Decides if the surface comes nearer than `limit` to a convex solid.
    ///
    /// The distance from it is convex: over the hull of a piece's control points it lies above its
    /// tangent plane at their middle.
    pub(crate) fn meets(
        &self,
        surface: &NurbsSurface,
        gap: SolidDistance<'_>,
        limit: f64,
    ) -> SolidProximity {
        let mut queue = BinaryHeap::new();
        queue.extend(self.nodes.first().map(|root| node_gap(root, 0, gap)));
        for _ in 0..MEETINGS {
            // The queue gives the smallest bound first: where it is large enough, all are.
            let Some(QueueEntry { bound, kind }) = queue.pop() else {
                return SolidProximity::Clear;
            };
            if bound >= limit {
                return SolidProximity::Clear;
            }
            let pieces = match kind {
                QueueItem::Node(index) => {
                    let PatchNode { halves, cells: [[i, _], [j, _]], .. } = self.nodes[index];
                    if halves[0] != index {
                        queue.extend(halves.map(|half| node_gap(&self.nodes[half], half, gap)));
                        continue;
                    }
                    self.piece(surface, [i, j]).map_or_else(Vec::new, |piece| vec![piece])
                }
                QueueItem::Piece(piece) => piece.halves().into(),
            };
            for piece in pieces {
                // Corners of the net lie on the surface: one within the limit is an answer.
                let near = |corner: &Point3<f64>| gap(corner).0 < limit;
                if let Some(corner) = piece.corners().into_iter().find(near) {
                    return SolidProximity::Nearer(corner);
                }
                let bound = piece.least_gap(gap);
                if bound < limit {
                    queue.push(QueueEntry { bound, kind: QueueItem::Piece(Box::new(piece)) });
                }
            }
        }
        SolidProximity::Undecided
    }

    /// Replaces a node by its halves, or by the control points of its patch.
    fn open(
        &self,
        surface: &NurbsSurface,
        p: &Point3<f64>,
        index: usize,
        best: &BestPoint,
        queue: &mut BinaryHeap<QueueEntry>,
    ) {
        let node = &self.nodes[index];
        if node.halves[0] == index {
            let [[i, _], [j, _]] = node.cells;
            let Some(piece) = self.piece(surface, [i, j]) else { return };
            offer(p, piece, best, queue);
        } else {
            for half in node.halves {
                let bound = box_distance(p, &self.nodes[half]);
                if bound < best.distance {
                    queue.push(QueueEntry { bound, kind: QueueItem::Node(half) });
                }
            }
        }
    }

    /// Improves the best point from the middle of `piece`, then queues its two halves.
    fn split(
        &self,
        surface: &NurbsSurface,
        p: &Point3<f64>,
        piece: &PatchPiece,
        best: &mut BestPoint,
        queue: &mut BinaryHeap<QueueEntry>,
    ) {
        let middle = piece.bounds.map(|range| range.middle());
        let at = |uv: [f64; 2]| surface.jet2(uv[0], uv[1]);
        let start = at(middle);
        // Newton's method costs as much as many halvings: only from where it is sure to improve.
        if (start.s - p).norm() < best.distance {
            let middle = FacePoint { uv: middle, jet: start };
            let found = newton::minimise(at, p, middle.uv, self.bounds).unwrap_or(middle);
            let distance = (found.jet.s - p).norm();
            if distance < best.distance {
                *best = BestPoint { uv: found.uv, distance };
            }
        }
        for half in piece.halves() {
            offer(p, half, best, queue);
        }
    }
}

/// Queues a piece unless it is proved to be no closer than the best point.
fn offer(p: &Point3<f64>, piece: PatchPiece, best: &BestPoint, queue: &mut BinaryHeap<QueueEntry>) {
    let bound = lower_bound(p, &piece);
    if bound < best.distance {
        queue.push(QueueEntry { bound, kind: QueueItem::Piece(Box::new(piece)) });
    }
}

impl PatchPiece {
    /// Returns a lower bound on the distance of the piece from a convex solid.
    fn least_gap(&self, gap: SolidDistance<'_>) -> f64 {
        let points = || self.points.iter().map(|point| point.xyz() / point.w);
        let middle = points().sum::<Vector3<f64>>() / self.points.len() as f64;
        let (distance, gradient) = gap(&Point3::from(middle));
        // Convexity: gap(p) >= gap(m) + gradient . (p - m); over the hull this is least at a point of the net.
        let rise = points().map(|p| gradient.dot(&(p - middle)));
        distance + rise.fold(f64::INFINITY, f64::min)
    }

    /// Returns the four corners, in which the piece meets its control points.
    fn corners(&self) -> [Point3<f64>; 4] {
        let last = self.points.len() - 1;
        let side = self.columns - 1;
        [0, side, last - side, last].map(|i| Point3::from(self.points[i].xyz() / self.points[i].w))
    }

    /// Makes a piece of a whole patch of a surface of `degree` by v.
    pub(super) fn of(patch: &BezierPatch<'_>, degree: usize) -> Self {
        Self { points: patch.points.to_vec(), columns: degree + 1, bounds: patch.bounds }
    }

    /// Returns the part of the piece within a box of parameters that it meets.
    pub(super) fn within(mut self, bounds: ParameterBox) -> Self {
        for (k, Interval { low, high }) in bounds.into_iter().enumerate() {
            let Interval { low: start, high: end } = self.bounds[k];
            if high < end && high > start {
                [self, _] = self.cut(k, (high - start) / (end - start));
                self.bounds[k].high = high;
            }
            let Interval { low: start, high: end } = self.bounds[k];
            if low > start && low < end {
                [_, self] = self.cut(k, (low - start) / (end - start));
                self.bounds[k].low = low;
            }
        }
        self
    }

    /// Returns the halves across the longer direction of the control net.
    pub(super) fn halves(&self) -> [Self; 2] {
        let rows = self.points.len() / self.columns;
        let c = |i: usize, j: usize| {
            let point = &self.points[i * self.columns + j];
            point.xyz() / point.w
        };
        // Lengths of the four sides of the net, point by point: a piece all round ends where it begins.
        let sides = [0, self.columns - 1]
            .map(|j| (1..rows).map(|i| (c(i, j) - c(i - 1, j)).norm()).sum::<f64>());
        let along_u = sides[0] + sides[1];
        let sides = [0, rows - 1]
            .map(|i| (1..self.columns).map(|j| (c(i, j) - c(i, j - 1)).norm()).sum::<f64>());
        let along_v = sides[0] + sides[1];
        let k = usize::from(along_v > along_u);
        self.cut(k, 0.5)
    }

    /// Cuts the piece across parameter `k`, at a share of its range.
    fn cut(&self, k: usize, share: f64) -> [Self; 2] {
        let rows = self.points.len() / self.columns;
        let mut low = self.points.clone();
        let mut high = self.points.clone();
        let (lines, count, step, stride) = if k == 0 {
            (self.columns, rows, 1, self.columns)
        } else {
            (rows, self.columns, self.columns, 1)
        };
        // De Casteljau: the first point of every level belongs to the low part, and the points that remain are the
        // high part.
        for line in 0..lines {
            let at = |i: usize| line * step + i * stride;
            for level in 0..count {
                low[at(level)] = high[at(0)];
                for i in 0..count - 1 - level {
                    high[at(i)] = high[at(i)] * (1.0 - share) + high[at(i + 1)] * share;
                }
            }
        }
        let (mut first, mut second) = (self.bounds, self.bounds);
        let Interval { low: start, high: end } = self.bounds[k];
        let middle = start + share * (end - start);
        (first[k].high, second[k].low) = (middle, middle);
        let columns = self.columns;
        [
            Self { points: low, columns, bounds: first },
            Self { points: high, columns, bounds: second },
        ]
    }
}

/// Returns the ranges of patch columns and rows that meet a box of parameters; at least one of either.
pub(super) fn cells_within(surface: &NurbsSurface, bounds: ParameterBox) -> [[usize; 2]; 2] {
    [0, 1].map(|k| {
        let breaks = surface.knots()[k].breaks();
        let last = breaks.len() - 2;
        let first = breaks.partition_point(|x| *x <= bounds[k].low).saturating_sub(1).min(last);
        let end = breaks.partition_point(|x| *x < bounds[k].high).clamp(first + 1, last + 1);
        [first, end]
    })
}

/// Returns a lower bound on the distance of the piece: the distance to the box of its control
/// points, or to their plane of support across the direction to the net's middle, whichever is
/// larger. The second is quadratically sharp where the surface faces `p`.
fn lower_bound(p: &Point3<f64>, piece: &PatchPiece) -> f64 {
    let points = || piece.points.iter().map(|point| point.xyz() / point.w - p.coords);
    let count = piece.points.len() as f64;
    let middle = points().sum::<Vector3<f64>>() / count;
    let (low, high) = points().fold(
        (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)),
        |(low, high), x| (low.inf(&x), high.sup(&x)),
    );
    // Seen from p at the origin: the offset of the box in each coordinate, 0 where it spans it.
    let gap = low.sup(&-high).sup(&Vector3::zeros()).norm();
    // The hull lies behind the plane square to d through its nearest point, at this distance.
    let support = middle
        .try_normalize(0.0)
        .map_or(0.0, |d| points().map(|x| x.dot(&d)).fold(f64::INFINITY, f64::min));
    gap.max(support)
}

/// Queues a node with a lower bound on its distance from a solid.
fn node_gap(node: &PatchNode, index: usize, gap: SolidDistance<'_>) -> QueueEntry {
    let centre = Point3::from(0.5 * (node.low + node.high));
    // A distance is 1-Lipschitz: over a box it is at least that of the centre less half the diagonal.
    let bound = gap(&centre).0 - 0.5 * (node.high - node.low).norm();
    QueueEntry { bound, kind: QueueItem::Node(index) }
}

/// Returns the distance from `p` to the box of a node.
fn box_distance(p: &Point3<f64>, node: &PatchNode) -> f64 {
    (node.low - p.coords).sup(&(p.coords - node.high)).sup(&Vector3::zeros()).norm()
}

/// Returns the box of Cartesian control points.
pub(super) fn hull_box(points: &[Vector4<f64>]) -> (Vector3<f64>, Vector3<f64>) {
    points.iter().map(|point| point.xyz() / point.w).fold(
        (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)),
        |(low, high), x| (low.inf(&x), high.sup(&x)),
    )
}

impl PartialEq for QueueEntry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for QueueEntry {}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for QueueEntry {
    /// The smallest bound is the greatest: a heap pops it first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}
