//! Broad phase: finds the tiles that a moving body may come near.

use super::collision::CollisionKind;
use super::dexel::{
    DexelGrid, HeightBins, MaterialBins, RayFamily, RaySquare, RayTile, TILE, across,
};
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::quadratic::{MotionPiece, SupportPlanes};
use crate::verify::swept::tool::ConvexBody;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;

/// Piece of a move, with a bound on its departure from straight motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundedPiece {
    pub(crate) piece: MotionPiece,
    /// Largest departure of the tool's points from straight motion in its frame \[mm\].
    pub(crate) bend: f64,
}

impl BoundedPiece {
    /// Bounds a piece; `reach` is the distance of the tool's points from its tip \[mm\].
    pub(crate) fn new(piece: &MotionPiece, reach: f64) -> Self {
        Self { piece: *piece, bend: piece.bend(reach) }
    }

    /// Returns the planes below the distance of a body around a point.
    #[inline]
    pub(crate) fn support_planes(&self, body: ConvexBody, point: &Point3<f64>) -> SupportPlanes {
        let SupportPlanes { sides: [(one, a), (other, b)] } =
            self.piece.support_planes(body, point);
        SupportPlanes { sides: [(one - self.bend, a), (other - self.bend, b)] }
    }
}

/// Body over one piece on which it moves nearly straight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyPiece<'a> {
    pub(crate) part: &'a MovingPart,
    pub(crate) bounded: &'a BoundedPiece,
}

/// Body over a piece of a move.
#[derive(Debug, Clone)]
pub(crate) struct MovingPart {
    pub(crate) whole: BoundedPiece,
    /// The same motion, in pieces that are nearly straight.
    pub(crate) straight: Arc<[BoundedPiece]>,
    pub(crate) body: ConvexBody,
    /// Collision if it meets material; `None` for the cutting part at feed.
    pub(crate) harm: Option<CollisionKind>,
    /// Box around it, including the margin for bodies that must not touch material.
    pub(crate) bounds: BoundingBox,
    /// Number of the first part of the same move, and of this part, in the program.
    pub(crate) number: usize,
    pub(crate) first: usize,
}

impl MovingPart {
    pub(crate) fn new(
        whole: &BoundedPiece,
        straight: Arc<[BoundedPiece]>,
        body: ConvexBody,
        harm: Option<CollisionKind>,
    ) -> Self {
        let [low, high] = whole.piece.axis_box(body.heights());
        let bounds = BoundingBox { low, high }.grown(body.radius());
        Self { whole: *whole, straight, body, harm, bounds, number: 0, first: 0 }
    }

    /// Numbers the part within the program, and grows its box by `margin` \[mm\] if it must not touch material.
    pub(crate) fn number(&mut self, [first, number]: [usize; 2], margin: f64) {
        (self.first, self.number) = (first, number);
        if self.harm.is_some() {
            self.bounds = self.bounds.grown(margin);
        }
    }

    /// Returns its range along an axis.
    pub(crate) fn extent(&self, axis: usize) -> [f64; 2] {
        [self.bounds.low[axis], self.bounds.high[axis]]
    }

    /// Tests if the body keeps off a box by more than `least` \[mm\].
    ///
    /// Each plane is laid at the point of the box to which the gradient of the previous one leads.
    fn clears(&self, [low, high]: &[Point3<f64>; 2], least: f64) -> bool {
        let clamp = |p: Point3<f64>| p.sup(low).inf(high);
        let piece = &self.whole.piece;
        let pose = &piece.middle().pose;
        let middle = nalgebra::center(low, high);
        let [from, to] = self.body.heights();
        let height = pose.axis.dot(&(middle - pose.tip)).clamp(from, to);
        // First plane at the point of the box nearest to the axis of the body, roughly.
        let mut at = clamp(pose.tip + pose.axis * height);
        let far = (high - low).norm();
        for _ in 0..MOST_PLANES {
            let planes = piece.support_planes(self.body, &at);
            let bend = piece.bend((at - pose.tip).norm() + far);
            // Least value of the plane over the box: the sum of the least values along each axis.
            let over = |&(height, gradient): &(f64, Vector3<f64>)| {
                let side = |k: usize| {
                    let ends = [low[k], high[k]].map(|end| gradient[k] * (end - at[k]));
                    ends[0].min(ends[1])
                };
                height - bend + side(0) + side(1) + side(2)
            };
            if planes.sides.iter().all(|side| over(side) > least) {
                return true;
            }
            let &(height, gradient) = planes.lower();
            if height <= least {
                return false;
            }
            // Go down the gradient by the distance: in a convex function that leads to the nearest point.
            at = clamp(at - gradient * height);
        }
        false
    }
}

/// Most planes between a box and a body; two or three suffice if it is far away.
const MOST_PLANES: u32 = 10;

/// Lists the parts that may come near each tile of a family, in order.
pub(crate) fn by_tile(
    parts: &[MovingPart],
    lattice: &DexelGrid,
    family: &RayFamily,
) -> Vec<Vec<u32>> {
    let [a, b] = across(family.along);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); family.tiles.len()];
    for (number, part) in (0u32..).zip(parts) {
        let tiles = |axis: usize| {
            let [first, count] = lattice.nodes(axis, part.extent(axis));
            // First and last node in units of tiles, the last one included.
            if count == 0 { 0..0 } else { first / TILE..(first + count - 1) / TILE + 1 }
        };
        let [columns, rows] = [tiles(b), tiles(a)];
        for row in rows {
            let first = row * family.grid[1];
            let within = first + columns.start..first + columns.end;
            for list in lists.get_mut(within).unwrap_or_default() {
                list.push(number);
            }
        }
    }
    lists
}

/// Geometry of the rays of one family.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayFrame {
    pub(crate) lattice: DexelGrid,
    pub(crate) along: usize,
    pub(crate) bins: HeightBins,
}

impl RayFrame {
    /// Tests if a body may be deeper than `touch` \[mm\] in the material of a square of rays.
    pub(crate) fn meets(
        &self,
        tile: &RayTile,
        square: RaySquare,
        held: &MaterialBins,
        part: &MovingPart,
        touch: f64,
    ) -> bool {
        let range = held.within(self.bins, part.extent(self.along));
        range.is_some_and(|range| !part.clears(&self.corners(tile, square, range), -touch))
    }

    /// Returns the box around the material of a square of rays between two positions along them.
    pub(crate) fn corners(
        &self,
        tile: &RayTile,
        square: RaySquare,
        [low, high]: [f64; 2],
    ) -> [Point3<f64>; 2] {
        let mut corners = [Point3::origin(); 2];
        for (corner, side) in corners.iter_mut().zip(self.sides(tile, square)) {
            for (axis, coordinate) in across(self.along).into_iter().zip(side) {
                corner[axis] = coordinate;
            }
        }
        (corners[0][self.along], corners[1][self.along]) = (low, high);
        corners
    }

    /// Returns the coordinates across of the first and the last ray of a square.
    pub(crate) fn sides(&self, tile: &RayTile, square: RaySquare) -> [[f64; 2]; 2] {
        let [a, b] = across(self.along);
        let first = [0, 1].map(|k: usize| tile.first[k] + square.from[k]);
        let last = [0, 1].map(|k: usize| (first[k] + square.size[k]).saturating_sub(1));
        [first, last].map(|[i, j]| [self.lattice.at(a, i), self.lattice.at(b, j)])
    }

    /// Returns a point of ray `index` of a tile.
    pub(crate) fn ray(&self, tile: &RayTile, index: usize) -> Point3<f64> {
        let [i, j] = [index / tile.size[1].max(1), index % tile.size[1].max(1)];
        self.lattice.ray(self.along, [tile.first[0] + i, tile.first[1] + j])
    }
}
