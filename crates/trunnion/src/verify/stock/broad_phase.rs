//! Bodies in motion by the tiles that they may come near.

use super::collision::CollisionKind;
use super::dexel::{
    DexelGrid, HeightBins, MaterialBins, RayFamily, RaySquare, RayTile, TILE, across,
};
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::quadratic::{MotionPiece, SupportPlanes};
use crate::verify::swept::tool::ConvexBody;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;

/// A piece of a move, and what bounds how it moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundedPiece {
    pub(crate) piece: MotionPiece,
    /// How far the points a tool can hold are from moving straight in its frame \[mm\].
    pub(crate) bend: f64,
}

impl BoundedPiece {
    /// `reach` \[mm\]: how far points of the tool are from its tip.
    pub(crate) fn new(piece: &MotionPiece, reach: f64) -> Self {
        Self { piece: *piece, bend: piece.bend(reach) }
    }

    /// What holds the distance of a body up from a point.
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
    /// The same, in parts over which it moves straight.
    pub(crate) straight: Arc<[BoundedPiece]>,
    pub(crate) body: ConvexBody,
    /// What it is if it meets material; `None` for what is there to cut, at feed.
    pub(crate) harm: Option<CollisionKind>,
    /// A box around it, and around all that comes too close to what must not touch material.
    pub(crate) bounds: BoundingBox,
    /// Its number in the program, and that of the first part of its move.
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

    /// Gives it its number in the program, `first` being that of its move; what is within `margin` \[mm\] of what must not touch material is close.
    pub(crate) fn number(&mut self, [first, number]: [usize; 2], margin: f64) {
        (self.first, self.number) = (first, number);
        if self.harm.is_some() {
            self.bounds = self.bounds.grown(margin);
        }
    }

    /// Lowest and highest place along an axis.
    pub(crate) fn extent(&self, axis: usize) -> [f64; 2] {
        [self.bounds.low[axis], self.bounds.high[axis]]
    }

    /// Whether the body keeps off a box by more than `least` \[mm\]. Every look is from the place of the
    /// box to which the one before points.
    fn clears(&self, [low, high]: &[Point3<f64>; 2], least: f64) -> bool {
        let clamp = |p: Point3<f64>| p.sup(low).inf(high);
        let piece = &self.whole.piece;
        let stand = &piece.middle().stand;
        let middle = nalgebra::center(low, high);
        let [from, to] = self.body.heights();
        let height = stand.axis.dot(&(middle - stand.tip)).clamp(from, to);
        let mut at = clamp(stand.tip + stand.axis * height);
        let far = (high - low).norm();
        for _ in 0..LOOKS {
            let tent = piece.support_planes(self.body, &at);
            let bend = piece.bend((at - stand.tip).norm() + far);
            let over = |&(height, gradient): &(f64, Vector3<f64>)| {
                let side = |k: usize| {
                    let ends = [low[k], high[k]].map(|end| gradient[k] * (end - at[k]));
                    ends[0].min(ends[1])
                };
                height - bend + side(0) + side(1) + side(2)
            };
            if tent.sides.iter().all(|side| over(side) > least) {
                return true;
            }
            let &(height, gradient) = tent.lower();
            if height <= least {
                return false;
            }
            at = clamp(at - gradient * height);
        }
        false
    }
}

/// Looks from a box at a body: two or three tell if it is far off.
const LOOKS: u32 = 10;

/// Which of `parts` may come near each tile of a family, in their order.
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

/// Rays along one axis, for all tiles of a family.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayFrame {
    pub(crate) lattice: DexelGrid,
    pub(crate) along: usize,
    pub(crate) bins: HeightBins,
}

impl RayFrame {
    /// Whether a body may be deeper than `touch` \[mm\] in the material of a square of rays.
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

    /// The box around the material of a square of rays between two places along them.
    pub(crate) fn corners(
        &self,
        tile: &RayTile,
        square: RaySquare,
        [low, high]: [f64; 2],
    ) -> [Point3<f64>; 2] {
        let mut corners = [Point3::origin(); 2];
        for (corner, side) in corners.iter_mut().zip(self.sides(tile, square)) {
            for (axis, place) in across(self.along).into_iter().zip(side) {
                corner[axis] = place;
            }
        }
        (corners[0][self.along], corners[1][self.along]) = (low, high);
        corners
    }

    /// The first and the last rays of a square, across.
    pub(crate) fn sides(&self, tile: &RayTile, square: RaySquare) -> [[f64; 2]; 2] {
        let [a, b] = across(self.along);
        let first = [0, 1].map(|k: usize| tile.first[k] + square.from[k]);
        let last = [0, 1].map(|k: usize| (first[k] + square.size[k]).saturating_sub(1));
        [first, last].map(|[i, j]| [self.lattice.at(a, i), self.lattice.at(b, j)])
    }

    /// Where ray `index` of a tile runs.
    pub(crate) fn ray(&self, tile: &RayTile, index: usize) -> Point3<f64> {
        let [i, j] = [index / tile.size[1].max(1), index % tile.size[1].max(1)];
        self.lattice.ray(self.along, [tile.first[0] + i, tile.first[1] + j])
    }
}
