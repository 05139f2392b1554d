//! Tree over a face: cells that are halved as finely as a proof needs, and flat balls around them.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::{ChartPoint, TrimmedRegion, clip, meets};
use crate::cover::layout::trims::{GUARDED_SHARE, LOOP_SHARE};
use crate::cover::prove::face_cell::{CellShare, FaceCell};
use crate::cover::prove::face_hull::FaceHull;
use crate::surface::FaceIndex;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// Least and largest number of cells each way in the coarsest subdivision.
const COUNT: [f64; 2] = [8.0, 192.0];

/// Length of a cell along straight lines of the face, over the coarse size.
const LONG: f64 = 8.0;

/// Largest run of an edge across a parameter along which it runs, as a share of the cell's range.
const ALONG: f64 = 1e-6;

/// Ball round part of the face, cut flat: the part lies within `height` of the plane through the
/// centre square to `normal`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TreeNode {
    pub(crate) centre: Point3<f64>,
    pub(crate) radius: f64,
    pub(crate) normal: Vector3<f64>,
    height: f64,
    pub(crate) below: TreeBranch,
}

impl TreeNode {
    fn of(cell: &FaceCell, index: usize) -> Self {
        let centre = cell.centre();
        let normal = cell.normal().unwrap_or_else(Vector3::zeros);
        let high = |p: &Point3<f64>| normal.dot(&(p - centre)).abs();
        let height = cell.corners().iter().map(high).fold(0.0, f64::max);
        let (radius, below) = (cell.radius(), TreeBranch::Leaf(index));
        // Without a normal only the ball is known.
        let flat = height + cell.sag(0) + cell.sag(1);
        let height = if normal.norm_squared() > 0.0 { flat } else { radius };
        Self { centre, radius, normal, height, below }
    }

    /// Returns the ball round two balls.
    fn around([a, b]: [&Self; 2], below: TreeBranch) -> Self {
        let apart = (b.centre - a.centre).norm();
        // Smallest ball around two balls, or the larger one if it holds the other.
        let radius = (0.5 * (apart + a.radius + b.radius)).max(a.radius).max(b.radius);
        let share = if apart > 0.0 { ((radius - a.radius) / apart).clamp(0.0, 1.0) } else { 0.0 };
        let centre = a.centre + (b.centre - a.centre) * share;
        let sum = a.normal + b.normal;
        let normal = sum.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let reach = |node: &Self| (node.centre - centre).norm() + node.radius;
        let high = |node: &Self| normal.dot(&(node.centre - centre)).abs() + node.along(&normal);
        // Once more, for the centre as it was rounded.
        let radius = reach(a).max(reach(b));
        Self { centre, radius, normal, height: high(a).max(high(b)), below }
    }

    /// Bounds the reach of the part from the centre along `direction`, of unit length, either way.
    pub(crate) fn along(&self, direction: &Vector3<f64>) -> f64 {
        // Support of a flat cylinder in that direction: |cos| height + sin radius.
        let lean = self.normal.dot(direction);
        let across = (direction - self.normal * lean).norm();
        (lean.abs() * self.height + across * self.radius).min(self.radius)
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum TreeBranch {
    Halves([usize; 2]),
    Leaf(usize),
}

/// Points of a cell, as shares of it, at which its edges are tested.
const PROBES: [[f64; 2]; 4] = [[0.07, 0.11], [0.91, 0.06], [0.08, 0.93], [0.94, 0.92]];

/// Returns a point of a range by its share. The last is the range's own end, to the bit, so that
/// points on it belong to one of the parts.
pub(crate) fn edge([low, high]: [f64; 2], share: f64) -> f64 {
    if share < 1.0 { low + (high - low) * share } else { high }
}

/// Returns `true` if the segment between two points crosses an odd number of edges.
fn crossed(edges: &[[ChartPoint; 2]], from: ChartPoint, to: ChartPoint) -> bool {
    // A vertex has the same side for both of its edges, so no crossing counts twice.
    let left = |[a, b]: [ChartPoint; 2], p: ChartPoint| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0
    };
    let crosses = |edge: &&[ChartPoint; 2]| {
        let way = [from, to];
        left(way, edge[0]) != left(way, edge[1]) && left(**edge, from) != left(**edge, to)
    };
    edges.iter().filter(crosses).count() % 2 == 1
}

/// Returns `true` if all edges in a cell of a range run along parameter `k`.
fn run_along(edges: &[[ChartPoint; 2]], k: usize, range: [[f64; 2]; 2]) -> bool {
    let [low, high] = range[1 - k];
    edges.iter().all(|[a, b]| (b[1 - k] - a[1 - k]).abs() <= ALONG * (high - low))
}

/// Most points around what a face has of a cell: more edges are left to the halves of the cell.
const MOST_KEPT: usize = 12;

/// Points of the image of a cell, around what the face has of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KeptPoints {
    points: [Point3<f64>; MOST_KEPT],
    count: usize,
    /// Distance of the bilinear image from the plane one that holds the points \[mm\].
    pub(crate) twist: f64,
}

impl KeptPoints {
    fn of(cell: &FaceCell) -> Self {
        let [a, b, c, d] = cell.corners();
        let twist = ((a - b) + (d - c)).norm();
        Self { points: [a; MOST_KEPT], count: 0, twist }
    }

    pub(crate) fn points(&self) -> &[Point3<f64>] {
        self.points.get(..self.count).unwrap_or(&self.points)
    }

    /// Adds the image of a local point; `None` if there are too many.
    fn add(&mut self, cell: &FaceCell, local: ChartPoint) -> Option<()> {
        let [a, b, c, _] = cell.corners();
        let share = |k: usize| {
            let [low, high] = cell.range[k];
            (local[k] - low) / (high - low)
        };
        *self.points.get_mut(self.count)? = a + (c - a) * share(0) + (b - a) * share(1);
        self.count += 1;
        Some(())
    }
}

/// Known side of the middle of a cell: on the face or off it. Any thread may find it first, with
/// the same result.
#[derive(Debug, Clone, Default)]
struct InsideMark(Arc<AtomicU8>);

impl InsideMark {
    /// Returns the side, if it was found before and the edges separate the face.
    fn known(&self) -> Option<bool> {
        let known = self.0.load(Ordering::Relaxed);
        (known > 1).then_some(known == 3)
    }

    /// Returns the known side, or finds it now; `None` where the edges do not separate the face.
    fn get_or(&self, find: impl FnOnce() -> Option<bool>) -> Option<bool> {
        match self.0.load(Ordering::Relaxed) {
            0 => {
                let found = find();
                self.0.store(found.map_or(1, |inside| 2 + u8::from(inside)), Ordering::Relaxed);
                found
            }
            1 => None,
            known => Some(known == 3),
        }
    }
}

/// Cell with its place among the others, for the order of the tree.
#[derive(Debug, Clone, Copy)]
struct CellIndex {
    cell: usize,
    /// Point across and along, in steps of the bounds.
    place: [usize; 2],
}

/// Tree of balls over the cells that hold some of the face.
#[derive(Debug, Clone)]
pub(crate) struct FaceTree {
    pub(crate) cells: Vec<FaceCell>,
    /// Edges of the face's trims that cross a cell; no entry where cells count whole.
    edges: Vec<Vec<[ChartPoint; 2]>>,
    /// Sides of the middles of these cells, found when they are first needed.
    marks: Vec<InsideMark>,
    /// Nodes of the tree; the last one is the root.
    pub(crate) nodes: Vec<TreeNode>,
    /// Outline of a plane face.
    pub(crate) hull: Option<FaceHull>,
}

impl FaceTree {
    /// Divides a region into cells of about `size` \[mm\].
    pub(crate) fn new<Inside: Fn(ChartPoint) -> bool + Sync>(
        face: &FaceIndex,
        chart: &Chart,
        region: &TrimmedRegion<Inside>,
        size: f64,
    ) -> Self {
        let at = |local: ChartPoint| {
            let [u, v] = chart.uv(local);
            face.face().point(u, v)
        };
        let whole = FaceCell::new(region.bounds, &at);
        let counts = [0, 1].map(|k| {
            // Clamped: small and positive.
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "see above"
            )]
            let count = (whole.extent(k) / size).ceil().clamp(COUNT[0], COUNT[1]) as usize;
            count
        });
        let part = |k: usize, i: usize| {
            [i, i + 1].map(|i| edge(region.bounds[k], i as f64 / counts[k] as f64))
        };
        let all: Vec<[usize; 2]> =
            (0..counts[0]).flat_map(|i| (0..counts[1]).map(move |j| [i, j])).collect();
        let kept: Vec<([usize; 2], FaceCell)> = all
            .into_par_iter()
            .filter_map(|[i, j]| {
                let range = [part(0, i), part(1, j)];
                region.touches(range[0], range[1]).then(|| ([i, j], FaceCell::new(range, &at)))
            })
            .collect();
        let cells = kept.iter().map(|(_, cell)| *cell).collect();
        let mut indices: Vec<CellIndex> = kept
            .iter()
            .enumerate()
            .map(|(cell, (place, _))| CellIndex { cell, place: *place })
            .collect();
        let (edges, marks, nodes) = (Vec::new(), Vec::new(), Vec::new());
        let hull = FaceHull::of(face, chart, region, LOOP_SHARE);
        let mut tree = Self { cells, edges, marks, nodes, hull };
        if !indices.is_empty() {
            tree.build(&mut indices);
        }
        tree
    }

    /// Divides a region into cells of about the coarse size inside it, and of the fine size \[mm\]
    /// where its edges cross them. Along a parameter whose lines are straight, and along edges, cells are longer: they
    /// bound no worse there.
    pub(crate) fn adaptive<Inside: Fn(ChartPoint) -> bool + Sync>(
        face: &FaceIndex,
        chart: &Chart,
        region: &TrimmedRegion<Inside>,
        [coarse, fine]: [f64; 2],
    ) -> Self {
        let at = |local: ChartPoint| {
            let [u, v] = chart.uv(local);
            face.face().point(u, v)
        };
        let mut waiting = vec![(FaceCell::new(region.bounds, &at), region.edges(region.bounds))];
        let (edges, marks, nodes) = (Vec::new(), Vec::new(), Vec::new());
        let hull = FaceHull::of(face, chart, region, GUARDED_SHARE);
        let mut tree = Self { cells: Vec::new(), edges, marks, nodes, hull };
        while let Some((cell, edges)) = waiting.pop() {
            let [a, b] = [0, 1].map(|k| {
                let is_fine = !edges.is_empty() && !run_along(&edges, k, cell.range);
                let long = if cell.is_straight(k) { LONG * coarse } else { coarse };
                cell.extent(k) / if is_fine { fine } else { long }
            });
            if a.max(b) > 1.0 {
                for half in cell.halves(usize::from(b > a), &at) {
                    let near = edges.iter().filter(|edge| meets(**edge, half.range));
                    let near = near.copied().collect();
                    waiting.push((half, near));
                }
            } else if !edges.is_empty() || region.holds(cell.middle()) {
                tree.cells.push(cell);
                tree.edges.push(edges);
                tree.marks.push(InsideMark::default());
            }
        }
        let mut indices: Vec<CellIndex> = tree
            .cells
            .iter()
            .enumerate()
            .map(|(index, cell)| CellIndex {
                cell: index,
                place: place(cell.middle(), region.bounds),
            })
            .collect();
        if !indices.is_empty() {
            tree.build(&mut indices);
        }
        tree
    }

    /// Returns the share of part of a cell that the face has.
    pub(crate) fn share(
        &self,
        index: usize,
        part: &FaceCell,
        holds: impl Fn(ChartPoint) -> bool,
    ) -> CellShare {
        let edges = self.edges.get(index).map_or(&[][..], Vec::as_slice);
        if edges.is_empty() {
            return CellShare::Whole;
        }
        let place = part.middle();
        let holds = match self.mark(index, edges, &holds) {
            Some((from, inside)) => inside != crossed(edges, from, place),
            None => holds(place),
        };
        if edges.iter().any(|edge| meets(*edge, part.range)) {
            return CellShare::Cut(holds);
        }
        if holds { CellShare::Whole } else { CellShare::None }
    }

    /// Returns points of the bilinear image of part of a cell whose hull holds what the face has of it; `None` where
    /// that is not known, or takes too many points.
    ///
    /// The hull of all corners sticks out over the edge that the face shares with its neighbour, which the tool
    /// touches while it cuts the neighbour.
    pub(crate) fn kept(&self, index: usize, part: &FaceCell) -> Option<KeptPoints> {
        let edges = self.edges.get(index).filter(|edges| !edges.is_empty())?;
        let (from, inside) = self.known_mark(index)?;
        let mut kept = KeptPoints::of(part);
        let [a, b] = part.range;
        // What is kept has its extreme points at corners of the cell and on edges of the trims.
        for corner in [[a[0], b[0]], [a[0], b[1]], [a[1], b[0]], [a[1], b[1]]] {
            if inside != crossed(edges, from, corner) {
                kept.add(part, corner)?;
            }
        }
        for edge in edges {
            for end in clip(*edge, part.range).into_iter().flatten() {
                kept.add(part, end)?;
            }
        }
        (kept.count > 0).then_some(kept)
    }

    /// Returns the middle of a cell, and `true` if it is on the face, as found before.
    fn known_mark(&self, index: usize) -> Option<(ChartPoint, bool)> {
        let (cell, mark) = (self.cells.get(index)?, self.marks.get(index)?);
        mark.known().map(|inside| (cell.middle(), inside))
    }

    /// Returns the middle of a cell, and `true` if it is on the face. Any other point is as many
    /// crossings of edges away.
    ///
    /// This is trusted where points near all corners of the cell agree; loops that run round a
    /// closed face do not separate it.
    fn mark(
        &self,
        index: usize,
        edges: &[[ChartPoint; 2]],
        holds: &impl Fn(ChartPoint) -> bool,
    ) -> Option<(ChartPoint, bool)> {
        let (cell, mark) = (self.cells.get(index)?, self.marks.get(index)?);
        let from = cell.middle();
        let found = mark.get_or(|| {
            let inside = holds(from);
            let at = |k: usize, share: f64| {
                let [low, high] = cell.range[k];
                low + share * (high - low)
            };
            let near = PROBES.map(|[a, b]| [at(0, a), at(1, b)]);
            let agrees =
                |place: &ChartPoint| holds(*place) == (inside != crossed(edges, from, *place));
            near.iter().all(agrees).then_some(inside)
        });
        found.map(|inside| (from, inside))
    }

    /// Returns the area of the cells \[mm²\].
    pub(crate) fn area(&self) -> f64 {
        self.cells.iter().map(FaceCell::area).sum()
    }

    /// Adds the tree over some cells, and returns its root.
    fn build(&mut self, indices: &mut [CellIndex]) -> usize {
        let node = if let [CellIndex { cell, .. }] = *indices {
            TreeNode::of(&self.cells[cell], cell)
        } else {
            let span = |k: usize| {
                let places = || indices.iter().map(|one| one.place[k]);
                places().max().unwrap_or(0) - places().min().unwrap_or(0)
            };
            // Split at the median of the longer side.
            let k = usize::from(span(1) > span(0));
            let half = indices.len() / 2;
            indices.select_nth_unstable_by_key(half, |one| (one.place[k], one.cell));
            let (first, second) = indices.split_at_mut(half);
            let halves = [self.build(first), self.build(second)];
            TreeNode::around(halves.map(|i| &self.nodes[i]), TreeBranch::Halves(halves))
        };
        self.nodes.push(node);
        self.nodes.len() - 1
    }
}

/// Returns a point of a rectangle in steps of a millionth of it.
fn place(local: ChartPoint, bounds: [[f64; 2]; 2]) -> [usize; 2] {
    const STEPS: f64 = 1e6;
    [0, 1].map(|k| {
        let [low, high] = bounds[k];
        let share = (local[k] - low) / (high - low).max(f64::MIN_POSITIVE);
        // Clamped: small and positive.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
        let step = (STEPS * share).clamp(0.0, STEPS) as usize;
        step
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::layout::trims::guarded;
    use crate::cover::pattern::FeedDirection;
    use crate::surface::{Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};

    #[test]
    fn parts_of_a_range_end_where_it_ends() {
        for k in 1..2000_u32 {
            let low = 0.047_625_5 * f64::from(k) - 3.0;
            let high = low + 1.0 / f64::from(k % 17 + 1);
            for count in [1, 3, 7, 64] {
                let edges: Vec<f64> = (0..=count)
                    .map(|i| edge([low, high], f64::from(i) / f64::from(count)))
                    .collect();
                let [first, .., last] = edges[..] else { panic!("two ends") };
                assert_eq!([first, last].map(f64::to_bits), [low, high].map(f64::to_bits));
                assert!(edges.windows(2).all(|pair| pair[0] < pair[1]), "{edges:?}");
            }
        }
    }

    /// A plane in the shape of an L whose corners lie on no line of the cells.
    fn angle_plate() -> FaceIndex {
        let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
        let corners = [[0.0, 0.1], [9.7, 0.3], [9.4, 4.1], [4.2, 3.9], [4.6, 8.8], [0.2, 9.1]];
        let closed: Vec<[f64; 2]> = corners.iter().chain(corners.first()).copied().collect();
        let curve = TrimCurve::polyline(&closed).unwrap();
        let trim = TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap();
        let plane = Surface::Plane(PlaneSurface { frame });
        FaceIndex::new(Face::new(1, plane, vec![trim]).unwrap()).unwrap()
    }

    #[test]
    fn the_kept_points_of_a_cell_hold_what_the_face_has_of_it() {
        const N: u32 = 24;
        let face = angle_plate();
        let chart = Chart::straight(FeedDirection::V);
        let tree = FaceTree::adaptive(&face, &chart, &guarded(&face, &chart), [4.0, 1.0]);
        let holds = |local: ChartPoint| {
            let [u, v] = chart.uv(local);
            face.face().contains(u, v)
        };
        let at = |local: ChartPoint| {
            let [u, v] = chart.uv(local);
            face.face().point(u, v)
        };
        let (mut cut, mut sharper) = (0, 0);
        for (index, cell) in tree.cells.iter().enumerate() {
            if !matches!(tree.share(index, cell, holds), CellShare::Cut(_)) {
                continue;
            }
            let Some(kept) = tree.kept(index, cell) else { continue };
            cut += 1;
            let part = |k: usize, i: u32| edge(cell.range[k], f64::from(i) / f64::from(N));
            let places = (0..=N * (N + 2)).map(|i| [part(0, i / (N + 1)), part(1, i % (N + 1))]);
            let inside: Vec<_> = places.filter(|place| holds(*place)).map(at).collect();
            for k in 0..32 {
                let (y, x) = (0.2 * f64::from(k)).sin_cos();
                let along = |p: &Point3<f64>| x * p.x + y * p.y;
                let least =
                    |points: &[Point3<f64>]| points.iter().map(along).fold(f64::INFINITY, f64::min);
                assert!(least(kept.points()) <= least(&inside) + 1e-9, "cell {index}, way {k}");
                sharper += u32::from(least(kept.points()) > least(&cell.corners()) + 0.05);
            }
        }
        assert!(cut > 20 && sharper > 10 * cut, "{cut} {sharper}");
    }

    #[test]
    fn a_way_is_in_or_out_by_its_crossings() {
        let square = [[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]];
        let edges: Vec<[ChartPoint; 2]> =
            (0..4).map(|i| [square[i], square[(i + 1) % 4]]).collect();
        assert!(crossed(&edges, [0.5, 0.5], [0.5, 0.9]));
        assert!(crossed(&edges, [0.5, 0.5], [0.9, 0.9]), "through a corner");
        assert!(!crossed(&edges, [0.0, 0.5], [1.0, 0.5]));
        assert!(!crossed(&edges, [0.3, 0.3], [0.7, 0.6]));
        assert!(!crossed(&edges, [0.3, 0.3], [0.3, 0.3]));
    }
}
