//! A stretch between two links, cut into cells at places that all ways to run it have in common.

use super::AxesOptions;
use super::march::{Bounds, turn};
use super::stops::{Candidate, Run};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::types::{AxisNode, AxisPiece, AxisVector, Motion};
use std::ops::Range;

/// Cells of a block: enough that a block costs next to nothing a cell, few enough that the axes do not
/// go far on it.
const BLOCK: usize = 64;

/// All ways to run what lies between two links.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Stretch {
    /// Index of the tool-path piece it starts with.
    pub(super) piece: usize,
    /// One for each branch, followed by continuity. All have as many cells, and blocks.
    pub(super) strands: Vec<Strand>,
}

/// A place between two cells, where one way may be left for another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Joint {
    /// Index of the tool-path piece that ends here or goes on.
    pub(super) piece: usize,
    /// Its parameter here.
    pub(super) u: f64,
    /// Whether the tool cuts before and after.
    pub(super) inside: bool,
}

/// One way to run a stretch. Whole turns may be added.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strand {
    /// Nodes and their piece, in order.
    runs: Vec<Run>,
    /// Where its cells start.
    places: Places,
    /// Axes at a point.
    stand: Option<AxisVector>,
    /// Rotaries at the end \[rad\].
    pub(super) end: [f64; 2],
    /// Cells by the [`BLOCK`].
    pub(super) blocks: Vec<Block>,
}

/// Where the cells of a strand start.
#[derive(Debug, Clone, PartialEq, Default)]
struct Places {
    /// First cell of each run.
    first: Vec<usize>,
    /// Nodes of each run at the starts of cells; none where cells are the intervals between nodes.
    nodes: Vec<Option<Vec<usize>>>,
    /// Number of cells.
    count: usize,
}

/// A part of a strand that is run without a break.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell {
    /// How far the axes go.
    pub(super) bounds: Bounds,
    /// Weighted rotary travel \[rad\].
    pub(super) travel: f64,
}

/// Some cells after each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    /// How far the axes go on all of them.
    pub(super) bounds: Bounds,
    /// Highest of the low ends and lowest of the high ends of the cells: no cell is inside where this
    /// is outside.
    pub(super) least: Bounds,
    /// Weighted rotary travel \[rad\].
    pub(super) travel: f64,
    /// Whether the rotaries jump at the start of a cell.
    pub(super) torn: bool,
    /// Whether the tool cuts before and after every joint of it.
    pub(super) inside: bool,
}

impl Places {
    /// Run and node at the start of a cell, or behind the last one.
    fn at(&self, cell: usize) -> [usize; 2] {
        if cell >= self.count {
            return [self.first.len(), 0];
        }
        let run = self.first.partition_point(|&first| first <= cell).saturating_sub(1);
        let inside = cell - self.first.get(run).copied().unwrap_or(0);
        let listed = self.nodes.get(run).and_then(Option::as_ref);
        [run, listed.map_or(inside, |nodes| nodes.get(inside).copied().unwrap_or(0))]
    }
}

impl Stretch {
    /// How many cells it has.
    pub(super) fn count(&self) -> usize {
        self.strands.first().map_or(0, |strand| strand.places.count)
    }

    /// The cells of each block.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let count = self.count();
        (0..count).step_by(BLOCK).map(move |from| from..(from + BLOCK).min(count))
    }

    /// Some cells of each strand.
    pub(super) fn cells(&self, range: Range<usize>, options: &AxesOptions) -> Vec<Vec<Cell>> {
        self.strands.iter().map(|strand| strand.cells(range.clone(), options)).collect()
    }

    /// Whether the rotaries of a strand jump at the start of a cell.
    pub(super) fn is_torn(&self, strand: usize, cell: usize) -> bool {
        self.strands.get(strand).is_some_and(|strand| strand.is_torn(cell))
    }

    /// The place before a cell; `None` before the first, and behind the last.
    pub(super) fn joint(&self, cell: usize) -> Option<Joint> {
        let first = self.strands.first().filter(|first| 0 < cell && cell < first.places.count)?;
        let (piece, _, u) = first.place(cell)?;
        Some(Joint { piece, u, inside: first.is_inside(cell) })
    }
}

impl Strand {
    /// Its pieces over a range of cells, with `offset` \[rad\] added to the rotaries.
    pub(super) fn pieces(&mut self, cells: Range<usize>, offset: [f64; 2]) -> Vec<AxisPiece> {
        let [first, last] = [cells.start, cells.end].map(|cell| self.places.at(cell));
        let runs = self.runs.iter_mut().enumerate().take(last[0] + 1).skip(first[0]);
        runs.filter_map(|(index, run)| {
            let all = &mut run.marched.nodes;
            let from = if index == first[0] { first[1] } else { 0 };
            let to = if index == last[0] { last[1] + 1 } else { all.len() };
            let part = all.get(from..to).filter(|nodes| nodes.len() > 1)?;
            // Each node is run once, but for those at breaks: what is run whole need not be copied.
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

    /// Rotaries at the start \[rad\].
    pub(super) fn start(&self) -> [f64; 2] {
        self.start_of(0)
    }

    /// Rotaries at the start of a cell, or at the end \[rad\].
    pub(super) fn start_of(&self, cell: usize) -> [f64; 2] {
        self.node(cell).map_or(self.end, |node| rotaries(&node.q[0]))
    }

    /// Rotaries before a cell \[rad\]: where they jump, otherwise than at its start.
    pub(super) fn end_before(&self, cell: usize) -> [f64; 2] {
        if !self.is_torn(cell) {
            return self.start_of(cell);
        }
        let [run, _] = self.places.at(cell);
        let before = run.checked_sub(1).and_then(|before| self.runs.get(before));
        let last = before.and_then(|run| run.marched.nodes.last());
        last.map_or_else(|| self.start_of(cell), |node| rotaries(&node.q[0]))
    }

    /// Whether the rotaries jump at the start of a cell.
    pub(super) fn is_torn(&self, cell: usize) -> bool {
        let [run, node] = self.places.at(cell);
        node == 0 && self.runs.get(run).is_some_and(|run| run.torn)
    }

    /// Whether the tool cuts before and after the start of a cell.
    fn is_inside(&self, cell: usize) -> bool {
        let [run, node] = self.places.at(cell);
        node > 0 && self.runs.get(run).is_some_and(|run| run.motion == Motion::Cut)
    }

    /// All axes at the start of a cell; zero for what does not move.
    pub(super) fn axes_at(&self, cell: usize) -> AxisVector {
        self.node(cell).map_or_else(AxisVector::zeros, |node| node.q[0])
    }

    /// Node at the start of a cell.
    fn node(&self, cell: usize) -> Option<&AxisNode> {
        let [run, node] = self.places.at(cell);
        self.runs.get(run)?.marched.nodes.get(node)
    }

    /// Piece, node and parameter at the start of a cell.
    pub(super) fn place(&self, cell: usize) -> Option<(usize, usize, f64)> {
        let [run, node] = self.places.at(cell);
        let run = self.runs.get(run)?;
        Some((run.piece, node, run.marched.nodes.get(node)?.s))
    }

    /// The deviation of all of it.
    pub(super) fn runs(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter()
    }

    /// All cells.
    pub(super) fn all_cells(&self, options: &AxesOptions) -> Vec<Cell> {
        self.cells(0..self.places.count, options)
    }

    /// Some cells after each other.
    pub(super) fn cells(&self, range: Range<usize>, options: &AxesOptions) -> Vec<Cell> {
        let mut at = self.places.at(range.start);
        let mut cells = Vec::with_capacity(range.len());
        for cell in range {
            let to = self.places.at(cell + 1);
            let mut bounds = Bounds::NONE;
            let mut travel = 0.0;
            for pair in parts(&self.runs, at, to).flat_map(|nodes| nodes.windows(2)) {
                bounds.merge(&Bounds::between(&pair[0], &pair[1]));
                travel += turn(&pair[1].q[0], &pair[0].q[0], options);
            }
            if let Some(q) = &self.stand {
                bounds.include(q);
            }
            cells.push(Cell { bounds, travel });
            at = to;
        }
        cells
    }
}

impl Block {
    fn of(strand: &Strand, range: Range<usize>, options: &AxesOptions) -> Self {
        let joints = range.clone().filter(|cell| *cell > 0);
        let mut block = Self {
            bounds: Bounds::NONE,
            least: Bounds::ALL,
            travel: 0.0,
            torn: joints.clone().any(|cell| strand.is_torn(cell)),
            inside: joints.clone().all(|cell| strand.is_inside(cell)),
        };
        for cell in &strand.cells(range, options) {
            block.bounds.merge(&cell.bounds);
            block.least.meet(&cell.bounds);
            block.travel += cell.travel;
        }
        block
    }
}

/// Cuts candidates into cells at the nodes that all of them have.
pub(super) fn stretch(candidates: Vec<Candidate>, options: &AxesOptions) -> Stretch {
    let places = common(&candidates);
    let piece = candidates.first().map_or(0, |candidate| candidate.piece);
    let both = candidates.into_iter().zip(places);
    let strands = both.map(|(candidate, places)| strand(candidate, places, options)).collect();
    Stretch { piece, strands }
}

/// For each candidate the places they have in common, the end left out.
fn common(candidates: &[Candidate]) -> Vec<Places> {
    let runs = candidates.iter().map(|candidate| candidate.runs.len()).min().unwrap_or(0);
    let mut all = vec![Places::default(); candidates.len()];
    let mut count = 0;
    for run in 0..runs {
        let nodes: Vec<&[AxisNode]> = candidates
            .iter()
            .filter_map(|candidate| candidate.runs.get(run))
            .map(|run| run.marched.nodes.as_slice())
            .collect();
        let marks = if same_places(&nodes) { None } else { Some(common_nodes(&nodes)) };
        let shortest = nodes.first().map_or(0, |nodes| nodes.len().saturating_sub(1));
        for (index, places) in all.iter_mut().enumerate() {
            places.first.push(count);
            places.nodes.push(marks.as_ref().and_then(|marks| marks.get(index).cloned()));
        }
        count += marks.map_or(shortest, |marks| marks.first().map_or(0, Vec::len));
    }
    for places in &mut all {
        places.count = count.max(1);
    }
    all
}

/// Whether all have the same nodes.
fn same_places(nodes: &[&[AxisNode]]) -> bool {
    let Some((first, others)) = nodes.split_first() else { return true };
    others.iter().all(|other| {
        other.len() == first.len()
            && other.iter().zip(*first).all(|(a, b)| a.s.to_bits() == b.s.to_bits())
    })
}

/// Nodes of each that all have, the last one left out: all end with the curve.
fn common_nodes(nodes: &[&[AxisNode]]) -> Vec<Vec<usize>> {
    let mut marks = vec![Vec::new(); nodes.len()];
    let Some((first, others)) = nodes.split_first() else { return marks };
    let mut at = vec![0; others.len()];
    for (index, node) in first.iter().enumerate().take(first.len().saturating_sub(1)) {
        let found = others.iter().zip(&mut at).all(|(other, at)| {
            *at += other.iter().skip(*at).take_while(|other| other.s < node.s).count();
            other.get(*at).is_some_and(|other| other.s.to_bits() == node.s.to_bits())
        });
        if found {
            let places = std::iter::once(index).chain(at.iter().copied());
            marks.iter_mut().zip(places).for_each(|(marks, node)| marks.push(node));
        }
    }
    marks
}

fn strand(candidate: Candidate, places: Places, options: &AxesOptions) -> Strand {
    let Candidate { runs, stand, end, .. } = candidate;
    let mut strand = Strand { runs, places, stand, end, blocks: Vec::new() };
    let count = strand.places.count;
    let ranges = (0..count).step_by(BLOCK).map(|from| from..(from + BLOCK).min(count));
    let blocks = ranges.map(|range| Block::of(&strand, range, options));
    strand.blocks = blocks.collect();
    strand
}

/// Nodes of the runs between two places, both ends with them.
fn parts(runs: &[Run], from: [usize; 2], to: [usize; 2]) -> impl Iterator<Item = &[AxisNode]> {
    let all = runs.iter().enumerate().take(to[0] + 1).skip(from[0]);
    all.map(move |(index, run)| {
        let nodes = &run.marched.nodes;
        let start = if index == from[0] { from[1] } else { 0 };
        let end = if index == to[0] { to[1] + 1 } else { nodes.len() };
        nodes.get(start..end).unwrap_or_default()
    })
}

pub(super) fn rotaries(q: &AxisVector) -> [f64; 2] {
    [q[FIRST_ROTARY], q[SECOND_ROTARY]]
}
