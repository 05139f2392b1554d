//! Places at which two states of a stock differ.

use super::brick::BrickGrid;
use crate::verify::stock::dexel::{DexelGrid, RaySpans, RayTile, across};
use crate::verify::stock::material::Stock;
use crate::verify::stock::mesh::surface_nets::NodeBox;
use crate::verify::swept::bvh::BoundingBox;
use nalgebra::Point3;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Nodes beside a changed end of a ray at which quads may begin whose corners move: the end is on an edge that begins up to
/// one node before, has vertices in the cubes one node before that, and these are corners of quads up to one node further.
const REACH: i64 = 2;

/// Places at which two states of a stock differ.
#[derive(Default)]
pub(super) struct Difference {
    /// Numbers of the bricks whose surface may differ.
    pub(super) bricks: BTreeSet<usize>,
    /// Box around all of it.
    pub(super) bounds: Option<BoundingBox>,
}

impl Difference {
    pub(super) fn of(before: &Stock, after: &Stock) -> Self {
        let grid = BrickGrid::of(after);
        let lattice = &after.lattice;
        let mut found = Self::default();
        for (old, new) in before.families.iter().zip(&after.families) {
            let tiles = old.tiles.par_iter().zip(&new.tiles);
            let boxes = tiles.filter_map(|(was, is)| changed_box(lattice, new.along, [was, is]));
            for bounds in boxes.collect::<Vec<_>>() {
                let nodes = nodes(lattice, &bounds);
                found.bricks.extend(grid.meeting(&nodes));
                found.add(place(lattice, &nodes));
            }
        }
        found
    }

    /// Returns all bricks of a stock.
    pub(super) fn all(stock: &Stock) -> Self {
        let bounds = place(&stock.lattice, &stock.nodes());
        Self { bricks: BrickGrid::of(stock).all().collect(), bounds: Some(bounds) }
    }

    fn add(&mut self, more: BoundingBox) {
        self.bounds = Some(self.bounds.map_or(more, |bounds| bounds.join(&more)));
    }
}

/// Returns the box that vertices of the cubes at some nodes are in.
fn place(lattice: &DexelGrid, nodes: &NodeBox) -> BoundingBox {
    let at = |node: i64, axis: usize| lattice.origin[axis] + lattice.cell[axis] * node as f64;
    let corner = |node: [i64; 3]| Point3::new(at(node[0], 0), at(node[1], 1), at(node[2], 2));
    BoundingBox { low: corner(nodes.low), high: corner(nodes.high) }
}

/// Returns the box around all that differs between two states of a tile; `None` if nothing does.
fn changed_box(
    lattice: &DexelGrid,
    along: usize,
    [old, new]: [&RayTile; 2],
) -> Option<BoundingBox> {
    let [a, b] = across(along);
    let mut bounds = None;
    for (ray, (was, is)) in old.rays.iter().zip(&new.rays).enumerate() {
        let Some(ends) = changed_stretch(was, is) else { continue };
        let [row, column] = new.row_and_column(ray);
        let point = |s: f64| {
            let mut point = Point3::origin();
            point[a] = lattice.at(a, new.first[0] + row);
            point[b] = lattice.at(b, new.first[1] + column);
            point[along] = s;
            point
        };
        let [low, high] = ends.map(point);
        let stretch = BoundingBox { low, high };
        bounds = Some(bounds.map_or(stretch, |bounds: BoundingBox| bounds.join(&stretch)));
    }
    bounds
}

/// Returns the lowest and the highest position at which two states of a ray differ.
fn changed_stretch(was: &RaySpans, is: &RaySpans) -> Option<[f64; 2]> {
    if was == is {
        return None;
    }
    let [was, is] = [was, is].map(|spans| spans.iter().flatten().collect::<Vec<f64>>());
    // Equal ends are equal bit by bit: the same ray, not cut in between.
    let same = |(a, b): &(&f64, &f64)| a.total_cmp(b).is_eq();
    let below = was.iter().zip(&is).take_while(same).count();
    let above = was.iter().rev().zip(is.iter().rev()).take_while(same).count();
    let next = |ends: &[f64]| ends.get(below).copied();
    let last =
        |ends: &[f64]| ends.len().checked_sub(above + 1).and_then(|at| ends.get(at)).copied();
    let low = [&was, &is].into_iter().filter_map(|ends| next(ends)).fold(f64::INFINITY, f64::min);
    let high =
        [&was, &is].into_iter().filter_map(|ends| last(ends)).fold(f64::NEG_INFINITY, f64::max);
    Some([low.min(high), high.max(low)])
}

/// Returns the nodes at which quads begin that depend on rays within a box.
fn nodes(lattice: &DexelGrid, bounds: &BoundingBox) -> NodeBox {
    let node = |axis: usize, x: f64| {
        #[expect(clippy::cast_possible_truncation, reason = "within the lattice, and saturates")]
        let node = ((x - lattice.origin[axis]) / lattice.cell[axis]).floor() as i64;
        node
    };
    let low = [0, 1, 2].map(|axis| node(axis, bounds.low[axis]) - REACH);
    let high = [0, 1, 2].map(|axis| node(axis, bounds.high[axis]) + REACH + 1);
    NodeBox { low, high }
}
