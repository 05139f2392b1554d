//! Surface of the remaining material by surface nets.
//!
//! Each lattice cube that the surface crosses has one vertex, at the mean of the points where rays cross the cube's edges.
//! Each crossed edge has one quad. The rays along z alone decide if a node is inside, so the surface is closed even if the
//! other rays disagree.

use super::merge::{self, NetQuad, signed};
use crate::types::Mesh;
use crate::verify::stock::dexel::{RaySpans, across};
use crate::verify::stock::material::Stock;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Node by x, y and z; nodes one step outside the lattice count as well.
pub(crate) type GridNode = [i64; 3];

/// Box of nodes: first, and one past the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NodeBox {
    pub(crate) low: GridNode,
    pub(crate) high: GridNode,
}

impl NodeBox {
    pub(crate) fn contains(&self, node: &GridNode) -> bool {
        (0..3).all(|axis| (self.low[axis]..self.high[axis]).contains(&node[axis]))
    }

    /// Returns the box with one more node on every side.
    fn grown(&self) -> Self {
        Self { low: self.low.map(|node| node - 1), high: self.high.map(|node| node + 1) }
    }
}

impl Stock {
    /// Returns a closed surface around the material, which was cut with a `tolerance` \[mm\].
    ///
    /// There are two triangles per cell. Where the surface is a plane across an axis, or constant along one, to a twentieth
    /// of the tolerance, cells are merged.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trunnion::verify::{Solid, Stock};
    ///
    /// let [low, high] = [Point3::origin(), Point3::new(2.0, 2.0, 2.0)];
    /// let stock = Stock::new(&Solid::Box { low, high }, 0.5, 1000)?;
    /// let mesh = stock.mesh(0.01);
    /// let highest = mesh.vertices.iter().map(|p| p.z).fold(0.0, f64::max);
    /// assert!((highest - 2.0).abs() < 0.5);
    /// # Ok::<(), trunnion::verify::VerifyError>(())
    /// ```
    pub fn mesh(&self, tolerance: f64) -> Mesh {
        let (quads, points) = self.net();
        merge::mesh(quads, points, self.lattice.cell, tolerance)
    }

    /// Returns the quads of the surface and its vertices.
    pub(crate) fn net(&self) -> (Vec<NetQuad>, Vec<Point3<f64>>) {
        self.net_around(self.nodes())
    }

    /// Returns all nodes at which an edge begins that the surface may cross.
    pub(crate) fn nodes(&self) -> NodeBox {
        NodeBox { low: [-1; 3], high: self.lattice.size.map(signed) }
    }

    /// Returns the piece of the surface around the edges that begin in a box of nodes, as [`Stock::mesh`] has it. Pieces of
    /// neighbouring boxes meet: each leaves out other vertices of their border, on lines that are straight.
    pub(crate) fn mesh_around(&self, nodes: NodeBox, tolerance: f64) -> Mesh {
        let (quads, points) = self.net_around(nodes);
        merge::mesh(quads, points, self.lattice.cell, tolerance)
    }

    /// Returns the quads around the edges that begin in a box of nodes, and their vertices among others.
    pub(crate) fn net_around(&self, nodes: NodeBox) -> (Vec<NetQuad>, Vec<Point3<f64>>) {
        // A vertex at the border is the mean of crossings beyond it as well.
        let mut net = SurfaceNet::of(nodes.grown());
        let NodeBox { low, high } = net.nodes;
        for i in low[0].max(0)..=high[0] {
            for j in low[1].max(0)..=high[1] {
                let here = self.inside(i, j);
                self.ends([i, j], &here, &mut net);
                self.sides(0, [i, j], [&self.inside(i - 1, j), &here], &mut net);
                self.sides(1, [i, j], [&self.inside(i, j - 1), &here], &mut net);
            }
        }
        let SurfaceNet { sums, mut quads, .. } = net;
        quads.retain(|quad| nodes.contains(&quad.node()));
        let points = sums.iter().map(|(sum, count)| Point3::from(sum / f64::from(*count)));
        (quads, points.collect())
    }

    /// Returns the ranges of nodes, first and last, that are inside on the ray `[i, j]` along z; none beside the lattice.
    fn inside(&self, i: i64, j: i64) -> Vec<[i64; 2]> {
        let [Ok(i), Ok(j)] = [i, j].map(usize::try_from) else { return Vec::new() };
        if i >= self.lattice.size[0] || j >= self.lattice.size[1] {
            return Vec::new();
        }
        let [.., family] = &self.families;
        let last = signed(self.lattice.size[2]) - 1;
        let number = |z: f64| (z - self.lattice.origin.z) / self.lattice.cell[2];
        #[expect(clippy::cast_possible_truncation, reason = "saturates")]
        // Nodes inside an interval: from the first at or above its lower end to the last at or below its upper end.
        let range = |[low, high]: [f64; 2]| {
            [(number(low).ceil() as i64).max(0), (number(high).floor() as i64).min(last)]
        };
        let spans = family.spans([i, j]).into_iter().flat_map(RaySpans::iter);
        spans.map(range).filter(|[first, last]| first <= last).collect()
    }

    /// Adds the edges along z that are crossed on a ray.
    fn ends(&self, [i, j]: [i64; 2], inside: &[[i64; 2]], net: &mut SurfaceNet) {
        for &[first, last] in inside {
            for (from, outside) in
                [([i, j, first - 1], Outside::Below), ([i, j, last], Outside::Above)]
            {
                if net.nodes.contains(&from) {
                    net.edge(2, &from, self.crossing(2, &from), outside);
                }
            }
        }
    }

    /// Adds the edges along x or y between two rays along z that are inside on one of them only.
    fn sides(
        &self,
        along: usize,
        [i, j]: [i64; 2],
        [before, here]: [&[[i64; 2]]; 2],
        net: &mut SurfaceNet,
    ) {
        // Nothing changes between two neighbouring ends of either ray.
        let mut ends: Vec<i64> =
            before.iter().chain(here).flat_map(|&[first, last]| [first, last + 1]).collect();
        ends.sort_unstable();
        ends.dedup();
        let holds = |ranges: &[[i64; 2]], k: i64| ranges.iter().any(|r| (r[0]..=r[1]).contains(&k));
        for pair in ends.windows(2) {
            let &[from, to] = pair else { continue };
            let (was, is) = (holds(before, from), holds(here, from));
            if was == is {
                continue;
            }
            for k in from.max(net.nodes.low[2])..to.min(net.nodes.high[2]) {
                let outside = if was { Outside::Above } else { Outside::Below };
                let mut node = [i, j, k];
                node[along] -= 1;
                if net.nodes.contains(&node) {
                    net.edge(along, &node, self.crossing(along, &node), outside);
                }
            }
        }
    }

    /// Returns the point where the surface crosses the edge that begins at a node: where the ray along the edge ends, or else
    /// the middle of the edge.
    fn crossing(&self, along: usize, from: &GridNode) -> Vector3<f64> {
        // Coordinates of the node; the edge runs one cell on along its axis.
        let at =
            |axis: usize| self.lattice.origin[axis] + self.lattice.cell[axis] * from[axis] as f64;
        let mut point = Vector3::new(at(0), at(1), at(2));
        let [low, high] = [point[along], point[along] + self.lattice.cell[along]];
        point[along] = 0.5 * (low + high);
        let [a, b] = across(along).map(|axis| usize::try_from(from[axis]));
        if let (Ok(a), Ok(b), Some(family)) = (a, b, self.families.get(along)) {
            let mut ends = family.spans([a, b]).into_iter().flat_map(RaySpans::iter).flatten();
            point[along] = ends.find(|s| (low..=high).contains(s)).unwrap_or(point[along]);
        }
        point
    }
}

/// Side of a crossed edge on which the outside is, along its axis.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outside {
    Above,
    Below,
}

/// Vertices by cube, each cube named after its lowest node.
struct SurfaceNet {
    /// Nodes at which its edges begin.
    nodes: NodeBox,
    numbers: HashMap<GridNode, u32>,
    sums: Vec<(Vector3<f64>, u32)>,
    quads: Vec<NetQuad>,
}

impl SurfaceNet {
    fn of(nodes: NodeBox) -> Self {
        Self { nodes, numbers: HashMap::new(), sums: Vec::new(), quads: Vec::new() }
    }

    /// Joins the four cubes around a crossed edge by a quad.
    fn edge(&mut self, along: usize, from: &GridNode, point: Vector3<f64>, outside: Outside) {
        let [a, b] = across(along);
        let mut corner = |da: i64, db: i64| {
            let mut cube = *from;
            cube[a] -= da;
            cube[b] -= db;
            let next = u32::try_from(self.sums.len()).unwrap_or(u32::MAX);
            let number = *self.numbers.entry(cube).or_insert(next);
            if number == next {
                self.sums.push((Vector3::zeros(), 0));
            }
            if let Some((sum, count)) = self.sums.get_mut(number as usize) {
                *sum += point;
                *count += 1;
            }
            number
        };
        let corners = [corner(1, 1), corner(0, 1), corner(0, 0), corner(1, 0)];
        let up = outside == Outside::Above;
        self.quads.push(NetQuad { along, up, level: from[along], at: [from[a], from[b]], corners });
    }
}
