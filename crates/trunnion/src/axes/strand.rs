//! A stretch between two links, cut into cells at places that all ways to run it have in common.

use super::AxesOptions;
use super::march::{Bounds, Marched, turn};
use super::stops::{Candidate, Run};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::types::{AxisPiece, AxisVector, Motion};
use std::ops::Range;

/// All ways to run what lies between two links.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Stretch {
    /// Index of the tool-path piece it starts with.
    pub(super) piece: usize,
    /// Where one way may be left for another: between two cells. One fewer than cells.
    pub(super) joints: Vec<Joint>,
    /// One for each branch, followed by continuity.
    pub(super) strands: Vec<Strand>,
}

/// A place between two cells.
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
    pub(super) runs: Vec<Run>,
    /// Between the places in common.
    pub(super) cells: Vec<Cell>,
    /// Rotaries at the end \[rad\].
    pub(super) end: [f64; 2],
}

/// A part of a strand that is run without a break.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell {
    /// Run and node at its start.
    pub(super) at: [usize; 2],
    /// Rotaries at its start \[rad\].
    pub(super) start: [f64; 2],
    /// How far the axes go.
    pub(super) bounds: Bounds,
    /// Weighted rotary travel \[rad\].
    pub(super) travel: f64,
}

impl Strand {
    /// Its pieces over a range of cells, with `offset` \[rad\] added to the rotaries.
    pub(super) fn pieces(&self, cells: Range<usize>, offset: [f64; 2]) -> Vec<AxisPiece> {
        let first = self.cells.get(cells.start).map_or([0, 0], |cell| cell.at);
        let last = self.cells.get(cells.end).map_or([self.runs.len(), 0], |cell| cell.at);
        let runs = self.runs.iter().enumerate().take(last[0] + 1).skip(first[0]);
        runs.filter_map(|(index, run)| {
            let all = &run.marched.nodes;
            let from = if index == first[0] { first[1] } else { 0 };
            let to = if index == last[0] { last[1] + 1 } else { all.len() };
            let mut nodes = all.get(from..to).filter(|nodes| nodes.len() > 1)?.to_vec();
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
        self.cells.get(cell).map_or(self.end, |cell| cell.start)
    }
}

impl Strand {
    /// All axes at the start of a cell; zero for what does not move.
    pub(super) fn axes_at(&self, cell: usize) -> AxisVector {
        let at = self.cells.get(cell).map(|cell| cell.at);
        let node = at.and_then(|[run, node]| self.runs.get(run)?.marched.nodes.get(node));
        node.map_or_else(AxisVector::zeros, |node| node.q[0])
    }
}

/// Cuts candidates into cells at the nodes that all of them have.
pub(super) fn stretch(candidates: Vec<Candidate>, options: &AxesOptions) -> Stretch {
    let marks = common(&candidates);
    let piece = candidates.first().map_or(0, |candidate| candidate.piece);
    let mut joints = Vec::new();
    if let (Some(first), Some(marks)) = (candidates.first(), marks.first()) {
        joints.reserve(marks.len());
        for &[run, node] in marks.iter().skip(1) {
            let here = first.runs.get(run);
            let u = here.and_then(|run| run.marched.nodes.get(node)).map_or(0.0, |node| node.s);
            let piece = here.map_or(0, |run| run.piece);
            let inside = node > 0 && here.is_some_and(|run| run.motion == Motion::Cut);
            joints.push(Joint { piece, u, inside });
        }
    }
    let both = candidates.into_iter().zip(&marks);
    let strands = both.map(|(candidate, at)| strand(candidate, at, options)).collect();
    Stretch { piece, joints, strands }
}

/// For each candidate, run and node at every place they have in common, the end left out.
fn common(candidates: &[Candidate]) -> Vec<Vec<[usize; 2]>> {
    let runs = candidates.iter().map(|candidate| candidate.runs.len()).min().unwrap_or(0);
    let mut marks = vec![Vec::new(); candidates.len()];
    for run in 0..runs {
        let nodes: Vec<&[_]> = candidates
            .iter()
            .filter_map(|candidate| candidate.runs.get(run))
            .map(|run| run.marched.nodes.as_slice())
            .collect();
        let Some((first, others)) = nodes.split_first() else { continue };
        let mut at = vec![0; others.len()];
        for (index, node) in first.iter().enumerate().take(first.len().saturating_sub(1)) {
            // The last nodes differ by nothing: all end with the curve.
            let found = others.iter().zip(&mut at).all(|(other, at)| {
                *at += other.iter().skip(*at).take_while(|other| other.s < node.s).count();
                other.get(*at).is_some_and(|other| other.s.to_bits() == node.s.to_bits())
            });
            if found {
                let places = std::iter::once(index).chain(at.iter().copied());
                marks.iter_mut().zip(places).for_each(|(marks, node)| marks.push([run, node]));
            }
        }
    }
    for marks in marks.iter_mut().filter(|marks| marks.is_empty()) {
        marks.push([0, 0]);
    }
    marks
}

fn strand(candidate: Candidate, marks: &[[usize; 2]], options: &AxesOptions) -> Strand {
    let Candidate { runs, stand, end, .. } = candidate;
    let last = [runs.len(), 0];
    let mut cells = Vec::with_capacity(marks.len());
    for (index, &at) in marks.iter().enumerate() {
        let to = marks.get(index + 1).copied().unwrap_or(last);
        let mut bounds = Bounds::NONE;
        let mut travel = 0.0;
        for (marched, nodes) in parts(&runs, at, to) {
            for part in marched.bounds.get(nodes.clone()).unwrap_or_default() {
                bounds.merge(part);
            }
            for pair in marched.nodes.get(nodes.start..nodes.end + 1).unwrap_or_default().windows(2)
            {
                travel += turn(&pair[1].q[0], &pair[0].q[0], options);
            }
        }
        let here = runs.get(at[0]).and_then(|run| run.marched.nodes.get(at[1]));
        let q = here.map_or(stand, |node| Some(node.q[0]));
        if let Some(q) = &q {
            bounds.include(q);
        }
        cells.push(Cell { at, start: q.as_ref().map_or(end, rotaries), bounds, travel });
    }
    Strand { runs, cells, end }
}

/// Runs and intervals between two marks.
fn parts(
    runs: &[Run],
    from: [usize; 2],
    to: [usize; 2],
) -> impl Iterator<Item = (&Marched, Range<usize>)> {
    let all = runs.iter().enumerate().take(to[0] + 1).skip(from[0]);
    all.map(move |(index, run)| {
        let start = if index == from[0] { from[1] } else { 0 };
        let end = if index == to[0] { to[1] } else { run.marched.bounds.len() };
        (&run.marched, start..end)
    })
}

pub(super) fn rotaries(q: &AxisVector) -> [f64; 2] {
    [q[FIRST_ROTARY], q[SECOND_ROTARY]]
}
