//! Bounds of curvature over any rectangle, from a tree of pieces bounded once.

use super::bounds::PatchCell;
use super::creases::{CreaseIndex, meets};
use super::nurbs::NurbsSurface;
use super::parameter_box::ParameterBox;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Vector3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A bound this share above a curvature attained is close enough: above the largest of the whole
/// surface to begin with, then above the largest in the middle of the same piece.
const CLOSE: f64 = 0.1;

/// Share of the surface's largest curvature below which a piece counts as flat. [`CLOSE`] then
/// counts from this share: nobody needs sharp bounds of next to nothing.
const FLAT: f64 = 0.1;

/// Pieces made for the whole surface, and for its parts, before bounds are left as they are.
const PIECES: [usize; 2] = [16_000, 4000];

/// Halvings of a piece that has no bound yet: at a pole no number of them gives one.
const DEPTH: u32 = 14;

/// Pieces of a NURBS surface, each with a range that no normal curvature on it leaves.
#[derive(Debug, Clone)]
pub(super) struct CurvatureTree {
    nodes: Vec<CurvatureNode>,
    /// Breaks by u and v; the node of patch `(i, j)` is number `i rows + j`.
    breaks: [Vec<f64>; 2],
    /// Box of each column of patches.
    columns: Vec<[Vector3<f64>; 2]>,
    /// Creases, across which curvature may jump.
    creases: CreaseIndex,
}

#[derive(Debug, Clone)]
struct CurvatureNode {
    bounds: ParameterBox,
    /// At most 0, at least 0 \[1/mm\].
    range: Interval,
    /// Largest rate of curvature \[1/mm^2\].
    rate: f64,
    /// Low and high corner of a box that holds the piece.
    hull: [Vector3<f64>; 2],
    /// First of the two halves.
    halves: Option<usize>,
}

/// A piece that may be halved.
struct CurvaturePiece {
    cell: PatchCell,
    node: usize,
    depth: u32,
    /// Largest curvature, either sign, by the bound \[1/mm\].
    bound: f64,
    /// Curvatures in its middle.
    attained: Interval,
}

impl CurvatureTree {
    pub(super) fn new(surface: &NurbsSurface) -> Self {
        let [columns, rows] = surface.patch_count();
        let breaks = [0, 1].map(|k| surface.knots()[k].breaks().to_vec());
        let mut tree = Self {
            nodes: Vec::with_capacity(columns * rows),
            breaks,
            columns: Vec::new(),
            creases: CreaseIndex::new(surface),
        };
        let mut queue = BinaryHeap::new();
        let patches = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
        for patch in patches.filter_map(|(i, j)| surface.patch(i, j)) {
            queue.push(tree.leaf(surface, PatchCell::of_patch(&patch, surface.degree()[1]), 0));
        }
        tree.columns = tree.nodes.chunks(rows).map(hull_of_all).collect();
        let mut attained =
            queue.iter().map(|piece| piece.attained).fold(Interval::point(0.0), |a, b| a.hull(b));
        // First, bounds that are sharp against the largest curvature of the whole surface.
        let whole = |_: &CurvaturePiece, range: Interval, attained: Interval| {
            attained.widened(CLOSE * size(attained)).encloses(range)
        };
        // Then bounds sharp against the curvature of the same piece, unless this is next to
        // nothing.
        let part = |piece: &CurvaturePiece, range: Interval, attained: Interval| {
            let slack = CLOSE * size(piece.attained).max(FLAT * size(attained));
            piece.attained.widened(slack).encloses(range)
        };
        let rest = tree.refine(surface, queue, &mut attained, PIECES[0], whole);
        tree.refine(surface, rest, &mut attained, PIECES[1], part);
        tree.tighten();
        tree
    }

    /// Halves the piece with the largest bound until every bound is close or the budget is spent;
    /// returns the pieces left.
    fn refine(
        &mut self,
        surface: &NurbsSurface,
        mut queue: BinaryHeap<CurvaturePiece>,
        attained: &mut Interval,
        budget: usize,
        close: impl Fn(&CurvaturePiece, Interval, Interval) -> bool,
    ) -> BinaryHeap<CurvaturePiece> {
        let most = self.nodes.len() + budget;
        let mut done = BinaryHeap::new();
        while self.nodes.len() < most
            && let Some(piece) = queue.pop()
        {
            let hopeless = piece.depth >= DEPTH && !piece.bound.is_finite();
            if hopeless || close(&piece, self.nodes[piece.node].range, *attained) {
                done.push(piece);
                continue;
            }
            // Both halves are stored next, one behind the other.
            self.nodes[piece.node].halves = Some(self.nodes.len());
            for half in piece.cell.halves() {
                let half = self.leaf(surface, half, piece.depth + 1);
                *attained = attained.hull(half.attained);
                queue.push(half);
            }
        }
        done.append(&mut queue);
        done
    }

    fn leaf(&mut self, surface: &NurbsSurface, cell: PatchCell, depth: u32) -> CurvaturePiece {
        let (range, attained) = (cell.bound(), cell.attained(surface));
        let node = self.nodes.len();
        let hull = cell.hull();
        self.nodes.push(CurvatureNode {
            bounds: cell.bounds,
            range,
            rate: cell.rate(),
            hull,
            halves: None,
        });
        CurvaturePiece { cell, node, depth, bound: size(range), attained }
    }

    /// Narrows the bounds of every piece to those of its halves, which stand after it.
    fn tighten(&mut self) {
        for k in (0..self.nodes.len()).rev() {
            if let Some(first) = self.nodes[k].halves {
                let both = self.nodes[first].range.hull(self.nodes[first + 1].range);
                let own = self.nodes[k].range;
                self.nodes[k].range = own.intersection(both);
                let both = self.nodes[first].rate.max(self.nodes[first + 1].rate);
                self.nodes[k].rate = self.nodes[k].rate.min(both);
            }
        }
    }

    /// Returns a range that no normal curvature over `cell`, clipped to the domain, leaves.
    pub(super) fn range(&self, cell: ParameterBox) -> Interval {
        // Beyond the domain there is the continuation, of which no bound is kept.
        let cell = [0, 1].map(|k| {
            let (low, high) = (self.breaks[k][0], self.breaks[k][self.breaks[k].len() - 1]);
            let [low, high] = cell[k].ends().map(|x| x.clamp(low, high));
            Interval::new(low, high)
        });
        let rows = self.breaks[1].len() - 1;
        let [(i0, i1), (j0, j1)] = [0, 1].map(|k| touched(&self.breaks[k], cell[k]));
        let mut range = Interval::point(0.0);
        for i in i0..i1 {
            for j in j0..j1 {
                range = self.widened(range, i * rows + j, &cell);
            }
        }
        range
    }

    /// Returns a range that no normal curvature of the surface within `radius` of `p` leaves.
    pub(super) fn near(&self, p: &Point3<f64>, radius: f64) -> Interval {
        let rows = self.breaks[1].len() - 1;
        let columns = self.columns.iter().enumerate();
        // Whole columns are rejected first: most of a long surface by a few boxes.
        let met = columns.filter(|(_, hull)| meets(hull, p, radius)).map(|(i, _)| i * rows);
        met.flat_map(|first| first..first + rows)
            .fold(Interval::point(0.0), |range, node| self.widened_near(range, node, p, radius))
    }

    /// Returns `true` if curvature may jump, or the surface end, within `radius` of `p`.
    pub(super) fn jumps_near(&self, p: &Point3<f64>, radius: f64) -> bool {
        self.creases.any_near(p, radius)
    }

    /// Returns an upper bound on the rate of normal curvature \[1/mm^2\] on the surface within
    /// `radius` of `p`, except where it jumps.
    pub(super) fn rate_near(&self, p: &Point3<f64>, radius: f64) -> f64 {
        let rows = self.breaks[1].len() - 1;
        let columns = self.columns.iter().enumerate();
        let met = columns.filter(|(_, hull)| meets(hull, p, radius)).map(|(i, _)| i * rows);
        met.flat_map(|first| first..first + rows)
            .fold(0.0, |rate, node| self.raised_near(rate, node, p, radius))
    }

    fn raised_near(&self, rate: f64, node: usize, p: &Point3<f64>, radius: f64) -> f64 {
        let node = &self.nodes[node];
        // A bound holds for all below it: a node that cannot raise the result ends the descent.
        if node.rate <= rate || !meets(&node.hull, p, radius) {
            return rate;
        }
        match node.halves {
            Some(first) => {
                let rate = self.raised_near(rate, first, p, radius);
                self.raised_near(rate, first + 1, p, radius)
            }
            None => node.rate,
        }
    }

    fn widened_near(&self, range: Interval, node: usize, p: &Point3<f64>, radius: f64) -> Interval {
        let node = &self.nodes[node];
        // A node whose range is in the result already adds nothing, nor do its halves.
        let inside = range.encloses(node.range);
        if inside || !meets(&node.hull, p, radius) {
            return range;
        }
        match node.halves {
            Some(first) => {
                let range = self.widened_near(range, first, p, radius);
                self.widened_near(range, first + 1, p, radius)
            }
            None => range.hull(node.range),
        }
    }

    /// Returns `range` widened by the part of a piece that meets `cell`.
    fn widened(&self, range: Interval, node: usize, cell: &ParameterBox) -> Interval {
        let node = &self.nodes[node];
        let inside = range.encloses(node.range);
        let apart =
            (0..2).any(|k| node.bounds[k].low > cell[k].high || node.bounds[k].high < cell[k].low);
        if inside || apart {
            return range;
        }
        // Of a piece wholly in the cell the own range is used: tightening made it as narrow as
        // those of its halves.
        let whole = (0..2).all(|k| cell[k].encloses(node.bounds[k]));
        match node.halves {
            Some(first) if !whole => {
                let range = self.widened(range, first, cell);
                self.widened(range, first + 1, cell)
            }
            _ => range.hull(node.range),
        }
    }
}

/// Returns the pieces between `breaks` that meet the closed range: first, and one after the last.
fn touched(breaks: &[f64], Interval { low, high }: Interval) -> (usize, usize) {
    // Both ends count: a range that ends on a break meets the pieces on both sides of it.
    let inner = &breaks[1..breaks.len() - 1];
    (inner.partition_point(|&b| b < low), inner.partition_point(|&b| b <= high) + 1)
}

fn hull_of_all(nodes: &[CurvatureNode]) -> [Vector3<f64>; 2] {
    let nothing = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
    nodes
        .iter()
        .fold(nothing, |[low, high], node| [low.inf(&node.hull[0]), high.sup(&node.hull[1])])
}

/// Returns the largest curvature of a range, either sign; the range holds 0.
fn size(range: Interval) -> f64 {
    range.high.max(-range.low)
}

impl PartialEq for CurvaturePiece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for CurvaturePiece {}

impl PartialOrd for CurvaturePiece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for CurvaturePiece {
    /// Orders the largest bound first: the pieces go where the surface bends most. Of two without
    /// bound the larger piece.
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then(other.depth.cmp(&self.depth))
    }
}
