//! The search for the highest touch.

use super::end::CuttingEnd;
use super::error::DropError;
use super::touch::{EndTouch, PlacedEnd};
use super::tree::{DropNode, IndexedTriangle, build};
use crate::types::{Interval, Mesh};
use nalgebra::{Point3, Vector2};
use rayon::prelude::*;

/// Places that one thread takes at a time: a place costs about a microsecond.
const AT_A_TIME: usize = 256;

/// Depth of the tree beyond which no index of `u32` triangles reaches.
const DEPTH: usize = 64;

/// Most triangles of an index.
const MOST: usize = u32::MAX as usize / 2;

/// Contact of a lowered cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct DropContact {
    /// Tip of the cutter \[mm\].
    pub tip: Point3<f64>,
    /// Point of the triangle that it touches \[mm\].
    pub point: Point3<f64>,
    /// Index of the triangle in the mesh.
    pub triangle: usize,
}

/// Triangles, prepared for lowering cutters on them along z.
#[derive(Debug, Clone)]
pub struct DropIndex {
    triangles: Vec<IndexedTriangle>,
    nodes: Vec<DropNode>,
}

impl DropIndex {
    /// Prepares a mesh.
    ///
    /// # Errors
    ///
    /// [`DropError`] for corners without a vertex, and vertices that are not finite.
    pub fn new(mesh: &Mesh) -> Result<Self, DropError> {
        let finite = |point: &Point3<f64>| point.iter().all(|value| value.is_finite());
        if let Some(vertex) = mesh.vertices.iter().position(|point| !finite(point)) {
            return Err(DropError::NotFinite { vertex });
        }
        let count = mesh.triangles.len();
        if count > MOST {
            return Err(DropError::TooMany { triangles: count, most: MOST });
        }
        let mut triangles = Vec::with_capacity(count);
        for ((triangle, corners), number) in mesh.triangles.iter().enumerate().zip(0..) {
            let vertices = mesh.vertices.len();
            let mut points = [Point3::origin(); 3];
            for (point, &corner) in points.iter_mut().zip(corners) {
                let known = mesh.vertices.get(corner as usize).copied();
                *point = known.ok_or(DropError::Corner { triangle, corner, vertices })?;
            }
            triangles.push(IndexedTriangle::new(points, number));
        }
        let nodes = build(&mut triangles);
        Ok(Self { triangles, nodes })
    }

    /// Lowers a cutting end at a place `[x, y]` \[mm\] until it touches; `None` where nothing lies below it.
    pub fn lowered(&self, end: &CuttingEnd, place: [f64; 2]) -> Option<DropContact> {
        let placed = PlacedEnd { end, place: Vector2::from(place) };
        let mut best: Option<NumberedTouch> = None;
        let mut stack = [0_usize; DEPTH];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let Some(node) = self.nodes.get(at) else { continue };
            let least = best.map_or(f64::NEG_INFINITY, |best| best.touch.tip);
            if placed.bound(node).is_none_or(|bound| bound <= least) {
                continue;
            }
            if node.count > 0 {
                let (first, count) = (node.first as usize, node.count as usize);
                let triangles = self.triangles.get(first..first + count).unwrap_or_default();
                best = placed.best_of(triangles, best);
                continue;
            }
            let mut children = [at + 1, node.first as usize];
            let bounds =
                children.map(|child| self.nodes.get(child).and_then(|node| placed.bound(node)));
            // The child that promises more is taken first, from the top of the stack.
            if bounds[0] > bounds[1] {
                children.swap(0, 1);
            }
            for child in children {
                if let Some(slot) = stack.get_mut(depth) {
                    *slot = child;
                    depth += 1;
                }
            }
        }
        best.map(|NumberedTouch { touch, number }| DropContact {
            tip: Point3::new(place[0], place[1], touch.tip),
            point: touch.point,
            triangle: number as usize,
        })
    }

    /// Lowers a cutting end at many places, in parallel; the results are in order of the places.
    pub fn lowered_at(&self, end: &CuttingEnd, places: &[[f64; 2]]) -> Vec<Option<DropContact>> {
        let at = |place: &[f64; 2]| self.lowered(end, *place);
        places.par_iter().with_min_len(AT_A_TIME).map(at).collect()
    }

    /// Returns bounds of the height of the tip \[mm\] on the shape that the triangles stand for, from which they
    /// are at most `deviation` \[mm\] away; `None` where nothing is touched for sure.
    ///
    /// A shape within the deviation touches the end no higher than the triangles touch the end grown by it, and no
    /// lower than they touch the end shrunk by it.
    pub fn tip_bounds(
        &self,
        end: &CuttingEnd,
        place: [f64; 2],
        deviation: f64,
    ) -> Option<Interval> {
        let grown = self.lowered(&end.grown(deviation)?, place)?;
        let shrunk = self.lowered(&end.shrunk(deviation)?, place)?;
        Some(Interval::new(shrunk.tip.z - deviation, grown.tip.z + deviation))
    }
}

/// Touch of a triangle, with the number of the triangle in the mesh.
#[derive(Debug, Clone, Copy)]
struct NumberedTouch {
    touch: EndTouch,
    number: u32,
}

impl PlacedEnd<'_> {
    /// Returns an upper bound on the tip over everything in a node; `None` if it lies beside the end.
    fn bound(&self, node: &DropNode) -> Option<f64> {
        let distance = node.bounds.distance(&self.place);
        (distance <= self.end.radius()).then(|| node.bounds.top - self.end.height(distance))
    }

    /// Returns the highest touch of some triangles and the best so far.
    fn best_of(
        &self,
        triangles: &[IndexedTriangle],
        mut best: Option<NumberedTouch>,
    ) -> Option<NumberedTouch> {
        for IndexedTriangle { corners, number, bounds } in triangles {
            let least = best.map_or(f64::NEG_INFINITY, |best| best.touch.tip);
            let distance = bounds.distance(&self.place);
            let beside = distance > self.end.radius();
            if beside || bounds.top - self.end.height(distance) <= least {
                continue;
            }
            let number = *number;
            let touch = self.triangle(corners, least);
            best = touch.map(|touch| NumberedTouch { touch, number }).or(best);
        }
        best
    }
}
