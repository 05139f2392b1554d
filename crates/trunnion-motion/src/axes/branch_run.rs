//! A segment between two links, cut into cells at nodes that all branches have in common.

use super::axis_bounds::{AxisBounds, rotary_cost};
use super::candidate::{CandidateRun, CurveRun, rotaries};
use super::options::AxesOptions;
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::types::{AxisNode, AxisPiece, AxisVector};
use std::ops::Range;

/// Cells of a block: enough that a block costs next to nothing a cell, few enough that the axes do not
/// go far on it.
const CELLS_PER_BLOCK: usize = 64;

/// Candidate motions between two links.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct PathSegment {
    /// Index of the tool-path piece it starts with.
    pub(super) piece: usize,
    /// One for each branch, followed by continuity. All have as many cells, and blocks.
    pub(super) branches: Vec<BranchRun>,
}

/// Point between two cells, where one branch may be left for another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SwitchPoint {
    /// Index of the cell that starts here.
    pub(super) cell: usize,
    /// Index of the tool-path piece that ends here or goes on.
    pub(super) piece: usize,
    /// Its parameter here.
    pub(super) u: f64,
    /// `true` if the tool cuts before and after.
    pub(super) inside: bool,
}

/// Position of a node in the tool path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct NodePosition {
    /// Index of the tool-path piece.
    pub(super) piece: usize,
    /// Index of the node of the piece.
    pub(super) node: usize,
    /// Curve parameter of the node.
    pub(super) u: f64,
}

/// Candidate motion along a segment. Whole turns may be added.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BranchRun {
    /// Nodes and their piece, in order.
    runs: Vec<CurveRun>,
    /// Starts of its cells.
    starts: CellStarts,
    /// Axes at a point.
    point_axes: Option<AxisVector>,
    /// Rotaries at the end \[rad\].
    pub(super) end: [f64; 2],
    /// Cells by the [`CELLS_PER_BLOCK`].
    pub(super) blocks: Vec<CellBlock>,
}

/// Starts of the cells of a branch.
#[derive(Debug, Clone, PartialEq, Default)]
struct CellStarts {
    /// First cell of each run.
    first: Vec<usize>,
    /// Nodes of each run at the starts of cells; `None` where cells are the intervals between nodes.
    nodes: Vec<Option<Vec<usize>>>,
    /// Number of cells.
    count: usize,
}

/// A part of a branch that is run without a break.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RunCell {
    /// Extent of the axes.
    pub(super) bounds: AxisBounds,
    /// Weighted rotary travel \[rad\].
    pub(super) travel: f64,
}

/// Consecutive cells, summed up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CellBlock {
    /// Extent of the axes on all of them.
    pub(super) bounds: AxisBounds,
    /// Highest of the low ends and lowest of the high ends of the cells: no cell is inside where this
    /// is outside.
    pub(super) least: AxisBounds,
    /// Weighted rotary travel \[rad\].
    pub(super) travel: f64,
    /// `true` if the rotaries jump at the start of a cell.
    pub(super) jumps: bool,
    /// `true` if the tool cuts before and after every switch point.
    pub(super) inside: bool,
}

impl CellStarts {
    /// Returns run and node at the start of a cell, or behind the last one.
    fn at(&self, cell: usize) -> [usize; 2] {
        if cell >= self.count {
            return [self.first.len(), 0];
        }
        // Runs are in order: the last one that starts at or before the cell holds it.
        let run = self.first.partition_point(|&first| first <= cell).saturating_sub(1);
        let inside = cell - self.first.get(run).copied().unwrap_or(0);
        let listed = self.nodes.get(run).and_then(Option::as_ref);
        [run, listed.map_or(inside, |nodes| nodes.get(inside).copied().unwrap_or(0))]
    }
}

impl PathSegment {
    /// Returns the number of cells.
    pub(super) fn count(&self) -> usize {
        self.branches.first().map_or(0, |branch| branch.starts.count)
    }

    /// Returns the cells of each block.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let count = self.count();
        (0..count)
            .step_by(CELLS_PER_BLOCK)
            .map(move |from| from..(from + CELLS_PER_BLOCK).min(count))
    }

    /// Returns a range of cells of each branch.
    pub(super) fn cells(&self, range: Range<usize>, options: &AxesOptions) -> Vec<Vec<RunCell>> {
        self.branches.iter().map(|branch| branch.cells(range.clone(), options)).collect()
    }

    /// Returns `true` if the rotaries of a branch jump at the start of a cell.
    pub(super) fn jumps_at(&self, branch: usize, cell: usize) -> bool {
        self.branches.get(branch).is_some_and(|branch| branch.jumps_at(cell))
    }

    /// Returns the switch point at the start of a cell; `None` before the first, and behind the last.
    pub(super) fn switch(&self, cell: usize) -> Option<SwitchPoint> {
        // The starts are common to all branches, so that the first one knows them.
        let first = self.branches.first().filter(|first| 0 < cell && cell < first.starts.count)?;
        let NodePosition { piece, u, .. } = first.position(cell)?;
        Some(SwitchPoint { cell, piece, u, inside: first.is_inside(cell) })
    }
}

impl BranchRun {
    /// Returns its pieces over a range of cells, with `offset` \[rad\] added to the rotaries.
    pub(super) fn pieces(&mut self, cells: Range<usize>, offset: [f64; 2]) -> Vec<AxisPiece> {
        let [first, last] = [cells.start, cells.end].map(|cell| self.starts.at(cell));
        let runs = self.runs.iter_mut().enumerate().take(last[0] + 1).skip(first[0]);
        runs.filter_map(|(index, run)| {
            let all = &mut run.track.nodes;
            let from = if index == first[0] { first[1] } else { 0 };
            let to = if index == last[0] { last[1] + 1 } else { all.len() };
            let part = all.get(from..to).filter(|nodes| nodes.len() > 1)?;
            // Only nodes at switch points belong to two pieces: a run that is used whole is moved out.
            let whole = part.len() == all.len();
            let mut nodes = if whole { std::mem::take(all) } else { part.to_vec() };
            for node in &mut nodes {
                node.q[0][FIRST_ROTARY] += offset[0];
                node.q[0][SECOND_ROTARY] += offset[1];
            }
            Some(AxisPiece { motion: run.motion, source: run.piece, nodes })
        })
        .collect()
    }

    /// Returns the rotaries at the start \[rad\].
    pub(super) fn start(&self) -> [f64; 2] {
        self.start_of(0)
    }

    /// Returns the rotaries at the start of a cell, or at the end \[rad\].
    pub(super) fn start_of(&self, cell: usize) -> [f64; 2] {
        self.node(cell).map_or(self.end, |node| rotaries(&node.q[0]))
    }

    /// Returns the rotaries just before a cell \[rad\]; they differ from its start where they jump.
    pub(super) fn end_before(&self, cell: usize) -> [f64; 2] {
        if !self.jumps_at(cell) {
            return self.start_of(cell);
        }
        // The rotaries jump from the last node of the run before.
        let [run, _] = self.starts.at(cell);
        let before = run.checked_sub(1).and_then(|before| self.runs.get(before));
        let last = before.and_then(|run| run.track.nodes.last());
        last.map_or_else(|| self.start_of(cell), |node| rotaries(&node.q[0]))
    }

    /// Returns `true` if the rotaries jump at the start of a cell.
    pub(super) fn jumps_at(&self, cell: usize) -> bool {
        let [run, node] = self.starts.at(cell);
        node == 0 && self.runs.get(run).is_some_and(|run| run.jumps)
    }

    /// Returns `true` if the tool cuts before and after the start of a cell.
    fn is_inside(&self, cell: usize) -> bool {
        let [run, node] = self.starts.at(cell);
        node > 0 && self.runs.get(run).is_some_and(|run| run.motion.is_cut())
    }

    /// Returns the axes at the start of a cell; zeros for a run without nodes.
    pub(super) fn axes_at(&self, cell: usize) -> AxisVector {
        self.node(cell).map_or_else(AxisVector::zeros, |node| node.q[0])
    }

    /// Returns the node at the start of a cell.
    fn node(&self, cell: usize) -> Option<&AxisNode> {
        let [run, node] = self.starts.at(cell);
        self.runs.get(run)?.track.nodes.get(node)
    }

    /// Returns the position in the tool path of the node at the start of a cell.
    pub(super) fn position(&self, cell: usize) -> Option<NodePosition> {
        let [run, node] = self.starts.at(cell);
        let run = self.runs.get(run)?;
        Some(NodePosition { piece: run.piece, node, u: run.track.nodes.get(node)?.s })
    }

    /// Returns its curves.
    pub(super) fn runs(&self) -> impl Iterator<Item = &CurveRun> {
        self.runs.iter()
    }

    /// Returns all cells.
    pub(super) fn all_cells(&self, options: &AxesOptions) -> Vec<RunCell> {
        self.cells(0..self.starts.count, options)
    }

    /// Returns consecutive cells.
    pub(super) fn cells(&self, range: Range<usize>, options: &AxesOptions) -> Vec<RunCell> {
        let mut at = self.starts.at(range.start);
        let mut cells = Vec::with_capacity(range.len());
        for cell in range {
            // The next cell may start with the first node of the next run. Where the rotaries jump to it the
            // travel is that of a retract, and not counted here.
            let to = self.starts.at(cell + 1);
            let mut bounds = AxisBounds::NONE;
            let mut travel = 0.0;
            for pair in parts(&self.runs, at, to).flat_map(|nodes| nodes.windows(2)) {
                bounds.merge(&AxisBounds::between(&pair[0], &pair[1]));
                travel += rotary_cost(&pair[1].q[0], &pair[0].q[0], options);
            }
            if let Some(q) = &self.point_axes {
                bounds.include(q);
            }
            cells.push(RunCell { bounds, travel });
            at = to;
        }
        cells
    }
}

impl CellBlock {
    fn of(branch: &BranchRun, range: Range<usize>, options: &AxesOptions) -> Self {
        // The start of the segment is no switch point.
        let switches = range.clone().filter(|cell| *cell > 0);
        let mut block = Self {
            bounds: AxisBounds::NONE,
            least: AxisBounds::ALL,
            travel: 0.0,
            jumps: switches.clone().any(|cell| branch.jumps_at(cell)),
            inside: switches.clone().all(|cell| branch.is_inside(cell)),
        };
        for cell in &branch.cells(range, options) {
            block.bounds.merge(&cell.bounds);
            block.least.meet(&cell.bounds);
            block.travel += cell.travel;
        }
        block
    }
}

/// Cuts candidates into cells at the nodes that all of them have.
pub(super) fn segment(candidates: Vec<CandidateRun>, options: &AxesOptions) -> PathSegment {
    let starts = common(&candidates);
    let piece = candidates.first().map_or(0, |candidate| candidate.piece);
    let both = candidates.into_iter().zip(starts);
    let branches = both.map(|(candidate, starts)| branch(candidate, starts, options)).collect();
    PathSegment { piece, branches }
}

/// Returns for each candidate the cell starts that all have in common, the end left out.
fn common(candidates: &[CandidateRun]) -> Vec<CellStarts> {
    let runs = candidates.iter().map(|candidate| candidate.runs.len()).min().unwrap_or(0);
    // Branches take steps of their own, so that nodes differ; only common ones let one take over from another.
    let mut all = vec![CellStarts::default(); candidates.len()];
    let mut count = 0;
    for run in 0..runs {
        let nodes: Vec<&[AxisNode]> = candidates
            .iter()
            .filter_map(|candidate| candidate.runs.get(run))
            .map(|run| run.track.nodes.as_slice())
            .collect();
        // Branches through the same evaluations mostly have the same nodes; then no list is needed.
        let marks = if same_places(&nodes) { None } else { Some(common_nodes(&nodes)) };
        let shortest = nodes.first().map_or(0, |nodes| nodes.len().saturating_sub(1));
        for (index, starts) in all.iter_mut().enumerate() {
            starts.first.push(count);
            starts.nodes.push(marks.as_ref().and_then(|marks| marks.get(index).cloned()));
        }
        count += marks.map_or(shortest, |marks| marks.first().map_or(0, Vec::len));
    }
    for starts in &mut all {
        starts.count = count.max(1);
    }
    all
}

/// Returns `true` if all have nodes at the same parameters.
fn same_places(nodes: &[&[AxisNode]]) -> bool {
    let Some((first, others)) = nodes.split_first() else { return true };
    others.iter().all(|other| {
        other.len() == first.len()
            && other.iter().zip(*first).all(|(a, b)| a.s.to_bits() == b.s.to_bits())
    })
}

/// Returns the indices of the nodes whose parameters all have, the last node left out: all end with the
/// curve.
fn common_nodes(nodes: &[&[AxisNode]]) -> Vec<Vec<usize>> {
    let mut marks = vec![Vec::new(); nodes.len()];
    let Some((first, others)) = nodes.split_first() else { return marks };
    // A merge of sorted lists: each list keeps the index it has come to.
    let mut at = vec![0; others.len()];
    for (index, node) in first.iter().enumerate().take(first.len().saturating_sub(1)) {
        let found = others.iter().zip(&mut at).all(|(other, at)| {
            *at += other.iter().skip(*at).take_while(|other| other.s < node.s).count();
            other.get(*at).is_some_and(|other| other.s.to_bits() == node.s.to_bits())
        });
        if found {
            let starts = std::iter::once(index).chain(at.iter().copied());
            marks.iter_mut().zip(starts).for_each(|(marks, node)| marks.push(node));
        }
    }
    marks
}

/// Sums up the cells of a candidate in blocks.
fn branch(candidate: CandidateRun, starts: CellStarts, options: &AxesOptions) -> BranchRun {
    let CandidateRun { runs, point_axes, end, .. } = candidate;
    let mut branch = BranchRun { runs, starts, point_axes, end, blocks: Vec::new() };
    let count = branch.starts.count;
    let ranges =
        (0..count).step_by(CELLS_PER_BLOCK).map(|from| from..(from + CELLS_PER_BLOCK).min(count));
    let blocks = ranges.map(|range| CellBlock::of(&branch, range, options));
    branch.blocks = blocks.collect();
    branch
}

/// Returns the nodes of each run between two starts, both ends included.
fn parts(runs: &[CurveRun], from: [usize; 2], to: [usize; 2]) -> impl Iterator<Item = &[AxisNode]> {
    let all = runs.iter().enumerate().take(to[0] + 1).skip(from[0]);
    all.map(move |(index, run)| {
        let nodes = &run.track.nodes;
        let start = if index == from[0] { from[1] } else { 0 };
        let end = if index == to[0] { to[1] + 1 } else { nodes.len() };
        nodes.get(start..end).unwrap_or_default()
    })
}
