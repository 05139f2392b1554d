//! Coverage: proves which cells of a face the passes finish, over all of the face and not only at
//! points.
//!
//! A point is finished if the point above it, as high as the excess allowed, was inside the cutter; a
//! cell, if [`CellPassage`] proves it. Nothing here uses strips or closest points, so a mistake there cannot hide.

use crate::cover::layout::advance::PassPart;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::{ChartPoint, TrimmedRegion, meets};
use crate::cover::prove::cell_passage::CellPassage;
use crate::cover::prove::connected::hull;
use crate::cover::prove::deepest::deepest;
use crate::cover::prove::face_cell::FaceCell;
use crate::cover::prove::face_tree::edge;
use crate::cover::prove::sweep::{PassSweep, SweepInstant};
use crate::cutter::ConvexSolid;
use crate::surface::FaceIndex;
use nalgebra::Point3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Width of the columns that are searched independently, in usual cells.
const COLUMN: f64 = 20.0;

/// Width of a strip, in cells, below which it is measured with smaller cells: what a cell that straddles its edge
/// takes from it is at most this part.
const FINE: f64 = 16.0;

/// Ratio of the cells of two measurements.
const FINER: f64 = 4.0;

/// Largest number of columns.
const COLUMNS: f64 = 400.0;

/// Ratio of the sides of a cell before it is as narrow as asked, over that of the smallest cells.
const SLENDER: f64 = 16.0;

/// Width that a pass may finish, in widths of the cutter.
const WINDOW: f64 = 1.0;

/// Tiles each way that are searched independently.
const TILES: u32 = 8;

/// Size of open cells that no tool comes near, over that of cells at the edges of the open area.
/// Their area is exact all the same.
const LARGEST: f64 = 16.0;

/// Number of poses below which a cell is not compared with each of them again.
const FEW: usize = 8;

/// Smallest part of a box, by parameter, into which it is divided: some thousand times what rounding leaves of a
/// parameter.
const RESOLVED: f64 = 1e-12;

/// Number of passes of the cutter over a point that are tried, the closest ones.
const PASSINGS: usize = 3;

/// Column of the face, and how far across it is finished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PassColumn {
    /// Range along.
    pub(crate) along: [f64; 2],
    /// Parameter across to which it is finished.
    pub(crate) finished: f64,
    /// Length along and width finished \[mm\].
    pub(crate) part: PassPart,
}

/// Time of a closest approach, and the distance of the point from the cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ClosestPass {
    u: f64,
    distance: f64,
}

/// Column to search for its first open cell.
#[derive(Debug, Clone, Copy)]
struct ProofColumn {
    /// Range along.
    along: [f64; 2],
    /// Cells are not halved below this \[mm\].
    smallest: f64,
}

/// Size and shape of the smallest cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellGrain {
    /// Cells are not halved below this where strips are as wide as usual \[mm\].
    pub(crate) usual: f64,
    /// Length of a cell along over its width across.
    pub(crate) long: f64,
}

/// Face with the sweeps of the passes over it.
pub(crate) struct CoverageProof<'a, Inside> {
    pub(crate) face: &'a FaceIndex,
    pub(crate) chart: &'a Chart,
    pub(crate) region: &'a TrimmedRegion<Inside>,
    pub(crate) end: ConvexSolid,
    /// Excess allowed \[mm\].
    pub(crate) limit: f64,
    /// Cells are not halved below this where strips are narrow \[mm\].
    pub(crate) smallest: f64,
    pub(crate) grain: CellGrain,
    pub(crate) sweeps: &'a [&'a PassSweep],
}

/// Proof that the cutter comes near to all points.
#[derive(Debug, Clone, Copy)]
struct NearSearch {
    /// Largest distance from the cutter \[mm\].
    height: f64,
    /// Number of times that a cell is halved.
    depth: u32,
}

/// Poses, as indices of sweep and pose.
type PoseIndices = Arc<[[usize; 2]]>;

/// Returns `true` if a cell is too small a part of a box, by parameter `k`, to be halved. Its points may still lie apart
/// where normals jump, as at a pole.
fn is_resolved(cell: &FaceCell, whole: [[f64; 2]; 2], k: usize) -> bool {
    let [of_cell, of_whole] = [cell.range[k], whole[k]].map(|[low, high]| high - low);
    of_cell <= RESOLVED * of_whole
}

/// Ranges of local parameters.
type RangeList = Arc<[[[f64; 2]; 2]]>;

/// Returns `true` if a range holds another.
fn holds(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> bool {
    (0..2).all(|k| a[k][0] <= b[k][0] && a[k][1] >= b[k][1])
}

/// Returns ranges that stand for some over a cell and its parts: none where none overlaps it, one that holds the cell if
/// there is such a one. The list shrinks with the cells, but is not copied for little.
fn overlapping(ranges: &RangeList, cell: &[[f64; 2]; 2]) -> RangeList {
    if let Some(whole) = ranges.iter().find(|range| holds(range, cell)) {
        return if ranges.len() == 1 { Arc::clone(ranges) } else { [*whole].into() };
    }
    let overlaps = |range: &&[[f64; 2]; 2]| {
        (0..2).all(|k| range[k][0] < cell[k][1] && range[k][1] > cell[k][0])
    };
    match ranges.iter().filter(overlaps).count() {
        0 => [].into(),
        count if 2 * count > ranges.len() => Arc::clone(ranges),
        _ => ranges.iter().filter(overlaps).copied().collect(),
    }
}

/// Returns `true` for poses of one sweep.
fn same_sweep(a: &[usize; 2], b: &[usize; 2]) -> bool {
    a[0] == b[0]
}

/// Cell that waits to be proven; the queue returns the one that begins first.
struct WaitingCell {
    cell: Box<FaceCell>,
    /// `true` if no edge of the region crosses it.
    whole: bool,
    /// Poses that come near.
    near: PoseIndices,
}

/// Cell that waits to be proven near; the queue returns the one that may be farthest.
struct FarCell {
    /// Largest distance that one of its points may have from the cutter \[mm\].
    farthest: f64,
    cell: Box<FaceCell>,
    /// Poses that come near.
    near: PoseIndices,
    /// Number of times that it may be halved.
    depth: u32,
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> CoverageProof<'_, Inside> {
    /// Returns columns across, from `from` to `end`, in order along.
    ///
    /// Widths are measured as if a step across were `rate` \[mm\] long everywhere: on a fan the
    /// same step finishes little at the tip and much at the rim.
    pub(crate) fn columns(&self, [from, end]: [f64; 2], rate: f64) -> Vec<PassColumn> {
        let range = self.region.bounds[1];
        let at = self.at();
        let whole = FaceCell::new([[from, end], range], &at);
        let count = (whole.extent(1) / (COLUMN * self.grain.usual)).ceil().clamp(1.0, COLUMNS);
        let edges: Vec<[f64; 2]> = std::iter::successors(Some(0.0), |i| Some(i + 1.0))
            .take_while(|i| *i < count)
            .map(|i| [i, i + 1.0].map(|i| edge(range, i / count)))
            .collect();
        // No pass cuts farther across than it is wide, so this window is searched first.
        // Passes that come near are distributed once for the window, not again for every column.
        let window = [from, end.min(from + WINDOW * self.end.width() / rate)];
        let mut near = Vec::with_capacity(edges.len());
        self.share(window, &edges, &self.poses(), &mut near);
        let column = |(along, near): ([f64; 2], PoseIndices)| {
            let mut smallest = self.grain.usual;
            let (finished, width) = loop {
                let column = ProofColumn { along, smallest };
                let open = self.first_open(window, column, near.clone()).or_else(|| {
                    let rest = [window[1], end];
                    (rest[0] < end).then(|| self.first_open(rest, column, self.poses()))?
                });
                let finished = open.map_or(end, |place| place[0]);
                let width = (finished - from) * rate;
                if width >= FINE * smallest || smallest <= self.smallest {
                    break (finished, width);
                }
                smallest = (smallest / FINER).max(self.smallest);
            };
            let length = (at([from, along[1]]) - at([from, along[0]])).norm();
            PassColumn { along, finished, part: PassPart { length, width } }
        };
        edges.into_par_iter().zip(near).map(column).collect()
    }

    /// Returns the cells of some boxes that are not finished: of the first size \[mm\], larger
    /// where no tool comes near. A cell whose middle is finished is divided down to the second
    /// size.
    pub(crate) fn open(&self, boxes: &[[[f64; 2]; 2]], sizes: [f64; 2]) -> Vec<[[f64; 2]; 2]> {
        let counts = [0, 1].map(|k| {
            let low = boxes.iter().map(|range| range[k][0]).fold(f64::INFINITY, f64::min);
            let high = boxes.iter().map(|range| range[k][1]).fold(f64::NEG_INFINITY, f64::max);
            [low, high]
        });
        let part =
            |k: usize, i: u32| [i, i + 1].map(|i| edge(counts[k], f64::from(i) / f64::from(TILES)));
        let all = self.poses();
        let tiles: Vec<[u32; 2]> =
            (0..TILES).flat_map(|i| (0..TILES).map(move |j| [i, j])).collect();
        let open = |[i, j]: [u32; 2]| {
            let range = [part(0, i), part(1, j)];
            self.open_in(range, boxes, &all, sizes)
        };
        tiles.into_par_iter().flat_map_iter(open).collect()
    }

    fn open_in(
        &self,
        range: [[f64; 2]; 2],
        boxes: &[[[f64; 2]; 2]],
        near: &PoseIndices,
        [size, finest]: [f64; 2],
    ) -> Vec<[[f64; 2]; 2]> {
        let at = self.at();
        let edges = self.region.edges(range);
        let (mut open, mut waiting) = (Vec::new(), Vec::new());
        let boxes = overlapping(&boxes.into(), &range);
        waiting.push((FaceCell::new(range, &at), false, near.clone(), boxes));
        while let Some((cell, whole, near, boxes)) = waiting.pop() {
            let boxes = overlapping(&boxes, &cell.range);
            if boxes.is_empty() {
                continue;
            }
            let whole = whole || !edges.iter().any(|edge| meets(*edge, cell.range));
            if whole && !self.region.holds(cell.middle()) {
                continue;
            }
            // Parts of a cell inherit its poses, so the list shrinks with the cells.
            let near = self.near(&cell, &near);
            let [a, b] = [0, 1].map(|k| cell.extent(k));
            let fits = a <= self.end.width();
            let (near, lowest) =
                if fits { self.touching(&cell, near) } else { (near, f64::INFINITY) };
            if fits && !near.is_empty() && self.finished(&cell, &near) {
                continue;
            }
            let least = a.max(b);
            // Where no tool comes near, smaller cells bring nothing.
            let inside = || boxes.iter().any(|other| holds(other, &cell.range));
            if whole && near.is_empty() && least <= LARGEST * size && inside() {
                open.push(cell.range);
                continue;
            }
            // A centre inside the cutter: part of the cell is finished.
            let small = least <= size && !(least > finest && lowest <= 0.0);
            if small && (whole || self.region.holds(cell.middle()) || least <= 0.5 * size) {
                open.push(cell.range);
                continue;
            }
            let longer = usize::from(b > a);
            if is_resolved(&cell, range, longer) {
                open.push(cell.range);
                continue;
            }
            for cell in cell.halves(longer, &at) {
                waiting.push((cell, whole, near.clone(), Arc::clone(&boxes)));
            }
        }
        open
    }

    /// Returns the least distance of a point from the cutter, near some poses \[mm\].
    pub(crate) fn nearest(&self, place: &Point3<f64>, near: &[[usize; 2]]) -> f64 {
        near.chunk_by(same_sweep)
            .map(|poses| self.nearest_of_sweep(place, poses))
            .fold(f64::INFINITY, f64::min)
    }

    /// Returns the least distance of a point from the cutter, near some poses of one sweep \[mm\].
    fn nearest_of_sweep(&self, place: &Point3<f64>, poses: &[[usize; 2]]) -> f64 {
        let sweep = self.sweeps[poses.first().map_or(0, |place| place[0])];
        let starts = self.passings(place, sweep, poses).into_iter().flatten();
        let times = starts.filter_map(|start| deepest(sweep, &self.end, place, start));
        let distance = |(_, here): (f64, SweepInstant)| self.end.distance(place, &here.pose);
        times.map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Returns the poses of those sweeps in which the cutter comes to a cell, and the least distance of its centre.
    ///
    /// A sweep whose cutter stays farther from the centre than the cell reaches cuts none of it. The poses alone are not
    /// enough: between them the cutter moves farther than a small cell is wide.
    fn touching(&self, cell: &FaceCell, near: PoseIndices) -> (PoseIndices, f64) {
        let (centre, radius) = (cell.centre(), cell.radius());
        let mut least = f64::INFINITY;
        let mut kept: Vec<[usize; 2]> = Vec::with_capacity(near.len());
        for poses in near.chunk_by(same_sweep) {
            let distance = self.nearest_of_sweep(&centre, poses);
            least = least.min(distance);
            if distance <= radius {
                kept.extend(poses);
            }
        }
        let near = if kept.len() == near.len() { near } else { kept.into() };
        (near, least)
    }

    /// Returns the least distance of a point from the cutter during all sweeps \[mm\], by the poses `near` in which
    /// the cutter comes within `margin` \[mm\] of it; farther away than that, by all.
    pub(crate) fn height(&self, place: &Point3<f64>, near: &[[usize; 2]], margin: f64) -> f64 {
        let least = self.nearest(place, near);
        if least <= margin { least } else { self.nearest(place, &self.poses()) }
    }

    /// Returns `true` if all points of some cells of the face come within `height` \[mm\] of the cutter: the points
    /// themselves, not those raised by the excess.
    ///
    /// The distance from the cutter is 1-Lipschitz: that of a cell's middle and the radius of the cell bound it. The cell
    /// that may be farthest comes first, so that one point too far away ends the search early.
    pub(crate) fn comes_near(&self, cells: &[[[f64; 2]; 2]], height: f64, depth: u32) -> bool {
        let search = NearSearch { height, depth };
        let mut waiting = BinaryHeap::new();
        if self.first_cells(cells, &self.poses(), search, &mut waiting).is_break() {
            return false;
        }
        let at = self.at_face();
        while let Some(FarCell { cell, near, depth, .. }) = waiting.pop() {
            if depth == 0 {
                return false;
            }
            let longer = usize::from(cell.extent(1) > cell.extent(0));
            for half in cell.halves(longer, &at) {
                let search = NearSearch { depth: depth - 1, ..search };
                if self.look(half, &near, search, &mut waiting).is_break() {
                    return false;
                }
            }
        }
        true
    }

    /// Looks at each of a list of cells, with the poses that come near, so that none is compared with all of them.
    fn first_cells(
        &self,
        cells: &[[[f64; 2]; 2]],
        near: &PoseIndices,
        search: NearSearch,
        waiting: &mut BinaryHeap<FarCell>,
    ) -> ControlFlow<()> {
        let at = self.at_face();
        match cells {
            [] => ControlFlow::Continue(()),
            [range] => self.look(FaceCell::new(*range, &at), near, search, waiting),
            _ => {
                let near = self.near_within(&FaceCell::new(hull(cells), &at), near, search.height);
                let (first, last) = cells.split_at(cells.len() / 2);
                self.first_cells(first, &near, search, waiting)?;
                self.first_cells(last, &near, search, waiting)
            }
        }
    }

    /// Looks at the middle of a cell, which waits for a closer look unless all of it is near or outside the region; breaks
    /// where the middle is too far away.
    fn look(
        &self,
        cell: FaceCell,
        near: &[[usize; 2]],
        search: NearSearch,
        waiting: &mut BinaryHeap<FarCell>,
    ) -> ControlFlow<()> {
        let NearSearch { height: limit, depth } = search;
        let near = self.near_within(&cell, near, limit);
        // No pose within the limit counts as farther away than the limit.
        let height = self.nearest(&cell.centre(), &near);
        let farthest = height + cell.radius();
        if farthest <= limit {
            return ControlFlow::Continue(());
        }
        let held = self.region.holds(cell.middle());
        if height > limit && held {
            return ControlFlow::Break(());
        }
        if held || !self.region.edges(cell.range).is_empty() {
            waiting.push(FarCell { farthest, cell: Box::new(cell), near, depth });
        }
        ControlFlow::Continue(())
    }

    /// Returns the poses in which the cutter may come within `margin` \[mm\] of a cell of the face.
    pub(crate) fn poses_near(&self, range: [[f64; 2]; 2], margin: f64) -> PoseIndices {
        self.near_within(&FaceCell::new(range, &self.at_face()), &self.poses(), margin)
    }

    /// Returns the poses in which the cutter may come within `radius` \[mm\] of a point.
    pub(crate) fn poses_about(&self, centre: &Point3<f64>, radius: f64) -> PoseIndices {
        self.within(centre, radius, &self.poses())
    }

    /// Returns all poses of all sweeps.
    fn poses(&self) -> PoseIndices {
        let poses = |(i, sweep): (usize, &&PassSweep)| (0..sweep.poses.len()).map(move |j| [i, j]);
        self.sweeps.iter().enumerate().flat_map(poses).collect()
    }

    /// Distributes poses to neighbouring columns that they come near.
    fn share(
        &self,
        across: [f64; 2],
        columns: &[[f64; 2]],
        near: &PoseIndices,
        to: &mut Vec<PoseIndices>,
    ) {
        let (Some(first), Some(last)) = (columns.first(), columns.last()) else { return };
        let near = self.near(&FaceCell::new([across, [first[0], last[1]]], &self.at()), near);
        if columns.len() == 1 {
            to.push(near);
            return;
        }
        let (low, high) = columns.split_at(columns.len() / 2);
        self.share(across, low, &near, to);
        self.share(across, high, &near, to);
    }

    /// Returns the least `across` of a cell in a column that some poses are not proven to finish.
    fn first_open(
        &self,
        across: [f64; 2],
        column: ProofColumn,
        near: PoseIndices,
    ) -> Option<ChartPoint> {
        let at = self.at();
        let ProofColumn { along, smallest } = column;
        let edges = self.region.edges([across, along]);
        let mut queue = BinaryHeap::new();
        let cell = Box::new(FaceCell::new([across, along], &at));
        queue.push(WaitingCell { cell, whole: false, near });
        while let Some(WaitingCell { cell, whole, near }) = queue.pop() {
            let whole = whole || !edges.iter().any(|edge| meets(*edge, cell.range));
            if whole && !self.region.holds(cell.middle()) {
                continue;
            }
            let near = if near.len() > FEW { self.near(&cell, &near) } else { near };
            let [a, b] = [0, 1].map(|k| cell.extent(k));
            let fits = a <= self.end.width();
            let near = if fits && near.len() > FEW { self.touching(&cell, near).0 } else { near };
            if fits && !near.is_empty() && self.finished(&cell, &near) {
                continue;
            }
            // Where no pose comes near, all of a cell is open.
            let b = b / self.grain.long;
            // What is finished ends almost straight across a column: first long cells that narrow towards its end.
            let longest = if a > smallest { SLENDER * a } else { a };
            let longer = usize::from(b > longest);
            let resolved = is_resolved(&cell, [across, along], longer);
            if a.max(b) <= smallest || resolved || (whole && near.is_empty()) {
                return Some([cell.range[0][0], cell.middle()[1]]);
            }
            for cell in cell.halves(longer, &at) {
                queue.push(WaitingCell { cell: Box::new(cell), whole, near: near.clone() });
            }
        }
        None
    }

    /// Returns those poses between which and the next a point of the cell may be inside the cutter.
    fn near(&self, cell: &FaceCell, poses: &[[usize; 2]]) -> PoseIndices {
        self.near_within(cell, poses, 0.0)
    }

    /// Returns those poses between which and the next a point of the cell may be within `margin` \[mm\] of the cutter.
    fn near_within(&self, cell: &FaceCell, poses: &[[usize; 2]], margin: f64) -> PoseIndices {
        self.within(&cell.centre(), cell.radius() + margin, poses)
    }

    fn within(&self, centre: &Point3<f64>, radius: f64, poses: &[[usize; 2]]) -> PoseIndices {
        let close = |place: &&[usize; 2]| {
            let sweep = self.sweeps[place[0]];
            let (_, pose) = &sweep.poses[place[1]];
            self.end.distance(centre, pose) <= radius + sweep.stride((centre - pose.tip).norm())
        };
        poses.iter().filter(close).copied().collect()
    }

    /// Returns the face, raised by the excess allowed.
    fn at(&self) -> impl Fn(ChartPoint) -> Point3<f64> {
        let (face, chart, limit) = (self.face.face(), self.chart, self.limit);
        move |local| {
            let [u, v] = chart.uv(local);
            let jet = face.surface.jet1(u, v);
            let normal = match jet.normal() {
                Some(normal) => Some(if face.flip { -normal } else { normal }),
                None => face.normal(u, v),
            };
            normal.map_or(jet.s, |normal| jet.s + normal.scale(limit))
        }
    }

    /// Returns the face itself.
    fn at_face(&self) -> impl Fn(ChartPoint) -> Point3<f64> {
        let (face, chart) = (self.face.face(), self.chart);
        move |local| {
            let [u, v] = chart.uv(local);
            face.point(u, v)
        }
    }

    fn finished(&self, cell: &FaceCell, near: &[[usize; 2]]) -> bool {
        near.chunk_by(same_sweep).rev().any(|poses| self.inside(cell, poses).unwrap_or(false))
    }

    /// Returns `true` if the cell was inside the cutter near some poses of one sweep; `None` where
    /// there is no pose.
    fn inside(&self, cell: &FaceCell, poses: &[[usize; 2]]) -> Option<bool> {
        let sweep = self.sweeps[poses.first()?[0]];
        for start in self.passings(&cell.centre(), sweep, poses).into_iter().flatten() {
            if (CellPassage { end: &self.end, cell, sweep }).is_inside(start)? {
                return Some(true);
            }
        }
        Some(false)
    }

    /// Returns the times, among those of some poses, at which a point comes closest. The cutter
    /// passes over it with the front of its ring and with the rear, and either may be the one that
    /// cuts.
    fn passings(
        &self,
        place: &Point3<f64>,
        sweep: &PassSweep,
        poses: &[[usize; 2]],
    ) -> [Option<f64>; PASSINGS] {
        let mut found: [Option<ClosestPass>; PASSINGS] = [None; PASSINGS];
        let mut keep = |passing: ClosestPass| {
            let mut passing = Some(passing);
            for known in &mut found {
                if passing.is_some_and(|p| known.is_none_or(|k| p.distance < k.distance)) {
                    std::mem::swap(known, &mut passing);
                }
            }
        };
        let mut before: Option<(usize, ClosestPass, bool)> = None;
        for &[_, index] in poses {
            let (u, pose) = &sweep.poses[index];
            let passing = ClosestPass { u: *u, distance: self.end.distance(place, pose) };
            let joined = before.filter(|(i, ..)| i + 1 == index);
            // A local minimum: the distance fell up to the last pose and rises from there, or the
            // run of poses ends.
            let falls = joined.is_none_or(|(_, last, _)| passing.distance < last.distance);
            if let Some((_, last, true)) = before.filter(|_| joined.is_none() || !falls) {
                keep(last);
            }
            before = Some((index, passing, falls));
        }
        if let Some((_, last, true)) = before {
            keep(last);
        }
        found.map(|known| known.map(|passing| passing.u))
    }
}

impl PartialEq for WaitingCell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for WaitingCell {}

impl PartialOrd for WaitingCell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for WaitingCell {
    /// Orders the heap: the cell that begins first is greatest, and of those the first along.
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |w: &Self| [w.cell.range[0][0], w.cell.range[1][0]];
        let ([a0, a1], [b0, b1]) = (key(self), key(other));
        b0.total_cmp(&a0).then(b1.total_cmp(&a1))
    }
}

impl PartialEq for FarCell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for FarCell {}

impl PartialOrd for FarCell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for FarCell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.farthest.total_cmp(&other.farthest)
    }
}
