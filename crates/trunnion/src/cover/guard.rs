//! What of a part may not be cut while one face is: every other face, and how near a tool comes to them.

use super::chart::Chart;
use super::clear::Clearing;
use super::clock::Clock;
use super::options::Along;
use super::sheet::{Below, Share, Sheet};
use super::sweep::Sweep;
use crate::cutter::Cutter;
use crate::cutter::solid::{Solid, Tool};
use crate::positioning::PositioningError;
use crate::surface::FaceIndex;
use crate::types::ToolPose;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Size of cells inside a face and at its trims, as shares of the cutter's radius. Those at its trims are halved
/// further where it matters what of them the face has.
pub(super) const SIZES: [f64; 2] = [1.0, 1.0 / 16.0];

/// Halvings of a cell before its bound is taken as it is: from millimetres to nanometres both ways.
const DEPTH: u32 = 40;

/// Cosine of the angle between two faces at which one goes on smoothly from the other, as far as raising a tool tells:
/// eight degrees.
const BELOW: f64 = 0.99;

/// Faces of a part, ready to be kept clear of.
pub(super) struct Guards<'a> {
    /// Of all sheets.
    chart: Chart,
    faces: Vec<(&'a FaceIndex, Sheet)>,
}

/// The place of a face that comes nearest to a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Near {
    /// Signed distance from the solid \[mm\].
    pub(super) distance: f64,
    /// Which face, as an index.
    pub(super) face: usize,
    pub(super) point: Point3<f64>,
}

/// How nearness is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// Places farther off than this do not count \[mm\].
    pub(super) within: f64,
    /// Places nearer by less than this than the nearest known are not looked for \[mm\].
    pub(super) precision: f64,
    /// The first place nearer than this is enough \[mm\].
    pub(super) enough: f64,
}

impl<'a> Guards<'a> {
    pub(super) fn new(faces: impl Iterator<Item = &'a FaceIndex>, cutter: &Cutter) -> Self {
        let faces: Vec<&FaceIndex> = faces.collect();
        let sizes = SIZES.map(|share| share * cutter.radius());
        let chart = Chart::straight(Along::V);
        let ready = |face: &'a FaceIndex| {
            let region = super::face::guarded(face, &chart);
            (face, Sheet::adaptive(face, &chart, &region, sizes))
        };
        let faces = faces.into_par_iter().map(ready).collect();
        Self { chart, faces }
    }

    /// Number of a face.
    pub(super) fn number(&self, face: usize) -> usize {
        self.faces.get(face).map_or(0, |(face, _)| face.face().number)
    }

    /// The place of all faces, without one of them, that comes nearest to a solid.
    pub(super) fn nearest(
        &self,
        (solid, pose): (&Solid, &ToolPose),
        without: Option<usize>,
        look: Look,
    ) -> Option<Near> {
        let mut found: Option<Near> = None;
        for (index, (face, sheet)) in self.faces.iter().enumerate() {
            if Some(index) != without {
                let search = Search { face, sheet, index, solid, pose, look };
                search.run(&mut found);
            }
            if found.is_some_and(|near| near.distance < look.enough) {
                break;
            }
        }
        found
    }
}

/// One face, one solid.
struct Search<'a> {
    face: &'a FaceIndex,
    sheet: &'a Sheet,
    index: usize,
    solid: &'a Solid,
    pose: &'a ToolPose,
    look: Look,
}

impl Search<'_> {
    /// Places at or beyond this do not matter.
    fn limit(&self, found: Option<&Near>) -> f64 {
        found.map_or(self.look.within, |near| near.distance - self.look.precision)
    }

    /// The distance is convex: over a ball it lies above the tangent plane at its centre.
    fn run(&self, found: &mut Option<Near>) {
        let mut waiting: Vec<usize> = self.sheet.nodes.len().checked_sub(1).into_iter().collect();
        while let Some(index) = waiting.pop() {
            let node = self.sheet.nodes[index];
            let gap = self.solid.gap(&node.centre, self.pose);
            if gap.distance - node.along(&gap.gradient) >= self.limit(found.as_ref()) {
                continue;
            }
            match node.below {
                Below::Halves(halves) => {
                    let near = |i: &usize| {
                        let node = &self.sheet.nodes[*i];
                        self.solid.distance(&node.centre, self.pose) - node.radius
                    };
                    let [a, b] = halves;
                    // The nearer half is looked at first.
                    waiting.extend(if near(&a) < near(&b) { [b, a] } else { [a, b] });
                }
                Below::Cell(cell) => self.cell(cell, found),
            }
            if found.is_some_and(|near| near.distance < self.look.enough) {
                return;
            }
        }
    }

    /// Over a cell the distance lies above its tangent plane at the middle, which is least at a corner, but for
    /// the bows of the cell.
    fn cell(&self, index: usize, found: &mut Option<Near>) {
        let at = |[u, v]: [f64; 2]| self.face.face().point(u, v);
        let holds = |[u, v]: [f64; 2]| self.face.face().contains(u, v);
        let mut waiting = vec![(self.sheet.cells[index], Share::Cut(false), 0)];
        while let Some((cell, before, depth)) = waiting.pop() {
            let share = match before {
                Share::Cut(_) => self.sheet.share((index, &cell), holds),
                known => known,
            };
            if share == Share::None {
                continue;
            }
            let point = cell.centre();
            let gap = self.solid.gap(&point, self.pose);
            let known = found.map_or(self.look.within, |near| near.distance);
            let some = cell.some_within(share).map(|away| gap.distance + away);
            if let Some(distance) = some.filter(|distance| *distance < known) {
                *found = Some(Near { distance, face: self.index, point });
            }
            let sags = [cell.sag(0), cell.sag(1)];
            let lowest = |plane: &crate::cutter::solid::Gap| {
                let over = |corner: &Point3<f64>| plane.gradient.dot(&(corner - point));
                plane.distance + cell.corners().iter().map(over).fold(f64::INFINITY, f64::min)
            };
            let sides = cell.normal().into_iter().flat_map(|n| [n, -n]);
            let planes = sides.map(|n| self.solid.plane(&point, self.pose, n));
            let least = planes.fold(lowest(&gap), |least, plane| least.max(lowest(&plane)));
            let enough = found.is_some_and(|near| near.distance < self.look.enough);
            if enough || least - sags[0] - sags[1] >= self.limit(found.as_ref()) || depth == DEPTH {
                continue;
            }
            let ways = [0, 1].map(|k| 0.5 * gap.gradient.dot(&cell.way(k)).abs() + sags[k]);
            let halves = cell.halves(usize::from(ways[1] > ways[0]), &at);
            waiting.extend(halves.map(|half| (half, share, depth + 1)));
        }
    }
}

/// All faces but the one that is cut, the tool that has to keep off them, and the machine that has to get there.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) clock: &'a dyn Clock,
    pub(super) guards: &'a Guards<'a>,
    /// The face that is cut.
    pub(super) own: usize,
    pub(super) tool: &'a Tool,
    /// What the tool keeps from every place \[mm\], to this precision \[mm\].
    pub(super) least: f64,
    pub(super) precision: f64,
}

impl Around<'_> {
    /// Whether the machine gets to a pose, and it keeps off all other faces.
    pub(super) fn clear(&self, pose: &ToolPose, uv: [f64; 2]) -> Result<(), PositioningError> {
        if !self.clock.reaches(pose) {
            return Err(PositioningError::OutOfReach { uv });
        }
        let within = self.least - self.precision;
        let look = Look { within, precision: self.precision, enough: within };
        for solid in self.tool.solids() {
            if let Some(near) = self.guards.nearest((solid, pose), Some(self.own), look) {
                let (face, depth) = (self.guards.number(near.face), self.least - near.distance);
                return Err(PositioningError::Neighbour { uv, face, depth });
            }
        }
        Ok(())
    }

    /// Whether the place of another face that a pose goes into lies right below the tool, seen along `normal`.
    pub(super) fn below(&self, pose: &ToolPose, normal: &Vector3<f64>) -> bool {
        let within = self.least - self.precision;
        let look = Look { within, precision: self.precision, enough: within };
        let below = |solid: &Solid| {
            let near = self.guards.nearest((solid, pose), Some(self.own), look)?;
            Some(solid.gap(&near.point, pose).gradient.dot(normal) <= -BELOW)
        };
        self.tool.solids().find_map(below).unwrap_or(false)
    }

    /// Whether a pose goes into any face, that which is cut among them.
    pub(super) fn hits(&self, pose: &ToolPose) -> bool {
        let within = self.least - self.precision;
        let look = Look { within, precision: self.precision, enough: within };
        self.tool.solids().any(|solid| self.guards.nearest((solid, pose), None, look).is_some())
    }

    /// As [`Clearing::least`], for every other face: what the tool keeps from them at least during a span.
    pub(super) fn kept(&self, sweep: &Sweep, (span, slabs): (usize, u32), target: f64) -> f64 {
        let mut least = target;
        for (index, (face, sheet)) in self.guards.faces.iter().enumerate() {
            if index != self.own {
                let (tool, precision, chart) = (self.tool, self.precision, &self.guards.chart);
                let clearing = Clearing { face, chart, sheet, tool, target, precision };
                least = least.min(clearing.least(sweep, span, slabs));
            }
        }
        least
    }
}
