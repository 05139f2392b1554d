//! How deep a moving tool goes into a face, bounded over all its places and all the time.

use super::options::Along;
use super::region::Local;
use super::sheet::{Below, Cell, Sheet};
use super::solid::{Solid, Tool};
use super::sweep::{Instant, Sweep};
use crate::surface::FaceIndex;
use nalgebra::{Point3, Vector3};

/// Halvings of a cell or a stretch of time, together, before its bound is taken as it is: from millimetres
/// to nanometres in all three.
const DEPTH: u32 = 60;

/// A face and a tool.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clearing<'a> {
    pub(super) face: &'a FaceIndex,
    pub(super) chart: Along,
    pub(super) sheet: &'a Sheet,
    pub(super) tool: &'a Tool,
    /// What the tool has to keep from the face \[mm\].
    pub(super) target: f64,
    /// To what a breach of the target is found \[mm\].
    pub(super) precision: f64,
}

/// A stretch of one span's time.
#[derive(Debug, Clone, Copy)]
struct Slab {
    span: usize,
    from: f64,
    to: f64,
    middle: Instant,
}

/// The least distance known so far.
struct Search<'a> {
    clearing: &'a Clearing<'a>,
    sweep: &'a Sweep,
    solid: &'a Solid,
    /// Least distance found anywhere \[mm\].
    found: f64,
    /// What no distance is below \[mm\]; at most the target.
    bound: f64,
}

impl Clearing<'_> {
    /// What the tool keeps from the face at least during a span, looked at in `slabs`; the target, less
    /// the precision, or more if it keeps that.
    pub(super) fn least(&self, sweep: &Sweep, span: usize, slabs: u32) -> f64 {
        let [start, end] = [sweep.curve.knots[span], sweep.curve.knots[span + 1]];
        let mut least = self.target;
        for solid in self.tool.solids() {
            let mut search =
                Search { clearing: self, sweep, solid, found: f64::INFINITY, bound: least };
            for i in 0..slabs {
                let at = |i: u32| start + (end - start) * f64::from(i) / f64::from(slabs);
                match Slab::new(sweep, span, [at(i), at(i + 1)]) {
                    Some(slab) => search.root(&slab),
                    None => return f64::NEG_INFINITY,
                }
            }
            least = search.bound.min(search.found - self.precision);
        }
        least
    }

    fn at(&self) -> impl Fn(Local) -> Point3<f64> {
        let (face, chart) = (self.face, self.chart);
        move |local| {
            let [u, v] = chart.uv(local);
            face.face().point(u, v)
        }
    }
}

impl Slab {
    fn new(sweep: &Sweep, span: usize, [from, to]: [f64; 2]) -> Option<Self> {
        let middle = sweep.instant(span, 0.5 * (from + to))?;
        Some(Self { span, from, to, middle })
    }

    fn half(&self) -> f64 {
        0.5 * (self.to - self.from)
    }

    fn halves(&self, sweep: &Sweep) -> [Option<Self>; 2] {
        let middle = 0.5 * (self.from + self.to);
        [[self.from, middle], [middle, self.to]].map(|part| Self::new(sweep, self.span, part))
    }

    /// Velocity of a fixed place seen from the tool, in the workpiece's directions.
    fn seen(&self, from_tip: &Vector3<f64>) -> Vector3<f64> {
        -self.middle.velocity - self.middle.turn.cross(from_tip)
    }
}

impl Search<'_> {
    /// Nothing at or above this matters any more. A touch at the target itself is not followed below the
    /// precision.
    fn enough(&self) -> f64 {
        self.bound.min(self.found - self.clearing.precision)
    }

    fn root(&mut self, slab: &Slab) {
        let root = self.clearing.sheet.nodes.len();
        if root > 0 {
            self.node(root - 1, slab, 0);
        }
    }

    fn node(&mut self, index: usize, slab: &Slab, depth: u32) {
        let node = self.clearing.sheet.nodes[index];
        let from_tip = node.centre - slab.middle.pose.tip;
        let half = slab.half();
        let far = from_tip.norm() + node.radius;
        let motion = (slab.seen(&from_tip).norm() + slab.middle.turn.norm() * node.radius) * half
            + 0.5 * self.rest(slab, far);
        let distance = self.solid.distance(&node.centre, &slab.middle.pose);
        if distance - node.radius - motion >= self.enough() {
            return;
        }
        if motion > 2.0 * node.radius && depth < DEPTH {
            self.later(slab, |search, slab| search.node(index, slab, depth + 1));
            return;
        }
        match node.below {
            Below::Halves(halves) => {
                for half in halves {
                    self.node(half, slab, depth);
                }
            }
            Below::Cell(cell) => {
                let cell = self.clearing.sheet.cells[cell];
                self.cell(&cell, slab, depth);
            }
        }
    }

    /// Twice the remainder of the first-order motion over a slab.
    fn rest(&self, slab: &Slab, distance: f64) -> f64 {
        let (bend, half) = (self.sweep.bend(slab.span), slab.half());
        bend.seen(distance, slab.middle.velocity.norm() + bend.tip * half) * half * half
    }

    fn later(&mut self, slab: &Slab, each: impl Fn(&mut Self, &Slab)) {
        for half in slab.halves(self.sweep) {
            match half {
                Some(half) => each(self, &half),
                None => self.bound = f64::NEG_INFINITY,
            }
        }
    }

    /// The distance lies above the tangent plane at the middle; over the cell and the slab that plane
    /// is least at a corner, but for the bows of the cell and of the motion.
    fn cell(&mut self, cell: &Cell, slab: &Slab, depth: u32) {
        let pose = &slab.middle.pose;
        let centre = cell.centre();
        let gap = self.solid.gap(&centre, pose);
        self.found = self.found.min(gap.distance);
        let half = slab.half();
        let mut slopes = f64::INFINITY;
        let (mut moving, mut far) = (0.0_f64, 0.0_f64);
        for corner in cell.corners() {
            let from_tip = corner - pose.tip;
            let move_ = gap.gradient.dot(&slab.seen(&from_tip)).abs() * half;
            slopes = slopes.min(gap.gradient.dot(&(corner - centre)) - move_);
            moving = moving.max(move_);
            far = far.max(from_tip.norm());
        }
        let sags = [cell.sag(0), cell.sag(1)];
        let rest = 0.5 * self.rest(slab, far + sags[0] + sags[1]);
        let bound = gap.distance + slopes - sags[0] - sags[1] - rest;
        if bound >= self.enough() {
            return;
        }
        if depth >= DEPTH {
            self.bound = self.bound.min(bound);
            return;
        }
        // Along the feed what the place gains the motion takes back, so slopes are compared as they are.
        let [a, b] = [0, 1].map(|k| {
            let p = &cell.points;
            let way = if k == 0 { p[2][1] - p[0][1] } else { p[1][2] - p[1][0] };
            sags[k] + 0.5 * gap.gradient.dot(&way).abs()
        });
        let time = moving + rest;
        if time >= a.max(b) {
            self.later(slab, |search, slab| search.cell(cell, slab, depth + 1));
        } else {
            let at = self.clearing.at();
            for half in cell.halves(usize::from(b > a), &at) {
                self.cell(&half, slab, depth + 1);
            }
        }
    }
}
