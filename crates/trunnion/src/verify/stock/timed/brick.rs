//! Division of the lattice into bricks, whose pieces of the surface are drawn each on its own.

use crate::types::Mesh;
use crate::verify::stock::material::Stock;
use crate::verify::stock::mesh::surface_nets::{GridNode, NodeBox};
use nalgebra::Point3;

/// Piece of the surface of stock.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StockBrick {
    /// Number of the brick, the same at all times.
    pub number: usize,
    /// Its surface \[mm\], open towards the bricks beside it; without triangles where there is none.
    pub mesh: Mesh,
}

/// Changes of the surface of stock.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct StockChanges {
    /// Bricks whose surface may have changed.
    pub bricks: Vec<StockBrick>,
    /// Box around all that has changed, low and high corner \[mm\]; `None` if nothing has.
    pub bounds: Option<[Point3<f64>; 2]>,
}

/// Nodes along the side of a brick: few triangles beside those that change, and few enough bricks to draw each in a call of
/// its own.
const SIDE: i64 = 16;

/// Bricks of a lattice.
#[derive(Debug, Clone, Copy)]
pub(super) struct BrickGrid {
    nodes: NodeBox,
    /// Number of bricks along x, y and z.
    count: [i64; 3],
}

impl BrickGrid {
    pub(super) fn of(stock: &Stock) -> Self {
        let nodes = stock.nodes();
        let count =
            [0, 1, 2].map(|axis: usize| (nodes.high[axis] - nodes.low[axis] + SIDE - 1) / SIDE);
        Self { nodes, count }
    }

    /// Iterates over the numbers of the bricks that meet a box of nodes.
    pub(super) fn meeting(self, nodes: &NodeBox) -> impl Iterator<Item = usize> + use<> {
        let first = [0, 1, 2].map(|k: usize| self.brick(k, nodes.low[k]));
        let last = [0, 1, 2].map(|k: usize| self.brick(k, nodes.high[k] - 1));
        let [_, y, z] = self.count;
        (first[0]..=last[0]).flat_map(move |i| {
            let row = move |j: i64| (first[2]..=last[2]).map(move |k| (i * y + j) * z + k);
            (first[1]..=last[1]).flat_map(row).filter_map(|number| usize::try_from(number).ok())
        })
    }

    /// Iterates over the numbers of all bricks.
    pub(super) fn all(self) -> impl Iterator<Item = usize> + use<> {
        self.meeting(&self.nodes)
    }

    /// Returns the brick of a node along an axis; nodes beyond the lattice belong to the outermost.
    fn brick(&self, axis: usize, node: i64) -> i64 {
        ((node - self.nodes.low[axis]).max(0) / SIDE).min(self.count[axis] - 1)
    }

    /// Returns the nodes of a brick.
    pub(super) fn nodes(&self, number: usize) -> NodeBox {
        let number = i64::try_from(number).unwrap_or(i64::MAX);
        let [_, y, z] = self.count;
        let at: GridNode = [number / (y * z), number / z % y, number % z];
        let low = [0, 1, 2].map(|k: usize| self.nodes.low[k] + SIDE * at[k]);
        let high = [0, 1, 2].map(|k: usize| (low[k] + SIDE).min(self.nodes.high[k]));
        NodeBox { low, high }
    }
}
