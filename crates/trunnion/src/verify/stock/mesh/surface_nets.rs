//! The surface of what is left: one vertex for each cube of the lattice through which it runs, in the
//! mean of the places where rays cross the cube's edges (surface nets), a quad for each edge that is crossed.
//! Whether a node is inside is told by the rays along z alone, so that the surface is closed whatever the
//! others say.

use super::merge::{self, NetQuad, signed};
use crate::types::Mesh;
use crate::verify::stock::dexel::{RaySpans, across};
use crate::verify::stock::material::Stock;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Node by x, y, z; those one outside the lattice count as well.
type GridNode = [i64; 3];

impl Stock {
    /// A closed surface around the material, which was cut with a `tolerance` \[mm\]. Two triangles for each cell,
    /// but few where it is a plane across an axis, or the same along one, to a twentieth of the tolerance.
    pub fn mesh(&self, tolerance: f64) -> Mesh {
        let (quads, places) = self.net();
        merge::mesh(quads, places, self.lattice.cell, tolerance)
    }

    /// The quads of the surface, and its vertices.
    pub(crate) fn net(&self) -> (Vec<NetQuad>, Vec<Point3<f64>>) {
        let [nx, ny, _] = self.lattice.size.map(signed);
        let mut net = SurfaceNet::default();
        for i in 0..=nx {
            for j in 0..=ny {
                let here = self.inside(i, j);
                self.ends([i, j], &here, &mut net);
                self.sides(0, [i, j], (&self.inside(i - 1, j), &here), &mut net);
                self.sides(1, [i, j], (&self.inside(i, j - 1), &here), &mut net);
            }
        }
        let SurfaceNet { sums, quads, .. } = net;
        let places = sums.iter().map(|(sum, count)| Point3::from(sum / f64::from(*count)));
        (quads, places.collect())
    }

    /// Ranges of nodes along z that are inside, first and last, on the ray `[i, j]`; none beside the lattice.
    fn inside(&self, i: i64, j: i64) -> Vec<[i64; 2]> {
        let [Ok(i), Ok(j)] = [i, j].map(usize::try_from) else { return Vec::new() };
        if i >= self.lattice.size[0] || j >= self.lattice.size[1] {
            return Vec::new();
        }
        let [.., family] = &self.families;
        let last = signed(self.lattice.size[2]) - 1;
        let number = |z: f64| (z - self.lattice.origin.z) / self.lattice.cell[2];
        #[expect(clippy::cast_possible_truncation, reason = "saturates")]
        let range = |[low, high]: [f64; 2]| {
            [(number(low).ceil() as i64).max(0), (number(high).floor() as i64).min(last)]
        };
        let spans = family.spans([i, j]).into_iter().flat_map(RaySpans::iter);
        spans.map(range).filter(|[first, last]| first <= last).collect()
    }

    /// Edges along z that are crossed on a ray.
    fn ends(&self, [i, j]: [i64; 2], inside: &[[i64; 2]], net: &mut SurfaceNet) {
        for &[first, last] in inside {
            for (from, up) in [([i, j, first - 1], false), ([i, j, last], true)] {
                net.edge((2, &from), self.crossing(2, &from), up);
            }
        }
    }

    /// Edges along x or y between two rays along z, inside on one of them only.
    fn sides(
        &self,
        along: usize,
        [i, j]: [i64; 2],
        (before, here): (&[[i64; 2]], &[[i64; 2]]),
        net: &mut SurfaceNet,
    ) {
        // Where either of them begins or ends; between two such places nothing changes.
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
            for k in from..to {
                let mut node = [i, j, k];
                node[along] -= 1;
                net.edge((along, &node), self.crossing(along, &node), was);
            }
        }
    }

    /// Where the surface crosses the edge that begins at a node: where the ray along it does, or in its middle.
    fn crossing(&self, along: usize, from: &GridNode) -> Vector3<f64> {
        let at =
            |axis: usize| self.lattice.origin[axis] + self.lattice.cell[axis] * from[axis] as f64;
        let mut place = Vector3::new(at(0), at(1), at(2));
        let [low, high] = [place[along], place[along] + self.lattice.cell[along]];
        place[along] = 0.5 * (low + high);
        let [a, b] = across(along).map(|axis| usize::try_from(from[axis]));
        if let (Ok(a), Ok(b), Some(family)) = (a, b, self.families.get(along)) {
            let mut ends = family.spans([a, b]).into_iter().flat_map(RaySpans::iter).flatten();
            place[along] = ends.find(|s| (low..=high).contains(s)).unwrap_or(place[along]);
        }
        place
    }
}

/// Vertices by cube, named after its lowest node.
#[derive(Default)]
struct SurfaceNet {
    numbers: HashMap<GridNode, u32>,
    sums: Vec<(Vector3<f64>, u32)>,
    quads: Vec<NetQuad>,
}

impl SurfaceNet {
    /// An edge that is crossed: the four cubes around it are joined, their outside up the axis if the edge's
    /// first node is inside.
    fn edge(&mut self, (along, from): (usize, &GridNode), place: Vector3<f64>, up: bool) {
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
                *sum += place;
                *count += 1;
            }
            number
        };
        let corners = [corner(1, 1), corner(0, 1), corner(0, 0), corner(1, 0)];
        self.quads.push(NetQuad { along, up, level: from[along], at: [from[a], from[b]], corners });
    }
}
