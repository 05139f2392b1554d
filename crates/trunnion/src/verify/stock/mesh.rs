//! The surface of what is left: one vertex for each cube of the lattice through which it runs, in the
//! mean of the places where rays cross it there (surface nets), a quad for each edge it crosses. Whether
//! a node is inside is told by one family alone, so that the surface is closed whatever the others say.

use super::Stock;
use super::dexel::across;
use crate::types::Mesh;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Node by x, y, z; one outside each end of the lattice counts as well.
type Node = [i64; 3];

impl Stock {
    /// A closed surface around the material.
    pub fn mesh(&self) -> Mesh {
        let inside = Inside::new(self);
        let mut net = Net::default();
        for along in 0..3 {
            self.edges(along, &inside, &mut net);
        }
        let vertices = net.sums.iter().map(|(sum, count)| Point3::from(sum / f64::from(*count)));
        Mesh { vertices: vertices.collect(), triangles: net.triangles }
    }

    /// Edges between neighbouring nodes along an axis that the surface crosses.
    fn edges(&self, along: usize, inside: &Inside, net: &mut Net) {
        let [a, b] = across(along);
        let size = self.lattice.size;
        let Some(family) = self.families.get(along) else { return };
        for i in 0..size[a] {
            for j in 0..size[b] {
                let spans = family.spans([i, j]);
                let mut node: Node = [0; 3];
                (node[a], node[b]) = (signed(i), signed(j));
                let mut before = false;
                for k in 0..=size[along] {
                    node[along] = signed(k);
                    let here = k < size[along] && inside.at(&node);
                    if here != before {
                        let mut from = node;
                        from[along] -= 1;
                        let place = self.crossing(along, &from, spans);
                        net.edge((along, &from), place, before);
                    }
                    before = here;
                }
            }
        }
    }

    /// Where the surface crosses the edge that begins at a node.
    fn crossing(&self, along: usize, from: &Node, spans: &[[f64; 2]]) -> Vector3<f64> {
        let at = |axis: usize| self.lattice.origin[axis] + self.lattice.cell * from[axis] as f64;
        let mut place = Vector3::new(at(0), at(1), at(2));
        let [low, high] = [place[along], place[along] + self.lattice.cell];
        let ends = spans.iter().flatten().copied();
        let middle = 0.5 * (low + high);
        place[along] = ends.into_iter().find(|s| (low..=high).contains(s)).unwrap_or(middle);
        place
    }
}

fn signed(index: usize) -> i64 {
    i64::try_from(index).unwrap_or(i64::MAX)
}

/// Which nodes are inside, by the rays along z.
struct Inside {
    bits: Vec<bool>,
    size: [usize; 3],
}

impl Inside {
    fn new(stock: &Stock) -> Self {
        let size = stock.lattice.size;
        let mut bits = Vec::with_capacity(size.iter().product());
        let [.., family] = &stock.families;
        for i in 0..size[0] {
            for j in 0..size[1] {
                let spans = family.spans([i, j]);
                bits.extend((0..size[2]).map(|k| {
                    let z = stock.lattice.at(2, k);
                    spans.iter().any(|&[low, high]| (low..=high).contains(&z))
                }));
            }
        }
        Self { bits, size }
    }

    fn at(&self, node: &Node) -> bool {
        let [x, y, z] = node.map(|index| usize::try_from(index).unwrap_or(usize::MAX));
        let [_, m, n] = self.size;
        self.bits.get((x * m + y) * n + z).copied().unwrap_or(false)
    }
}

/// Vertices by cube, named after its lowest node.
#[derive(Default)]
struct Net {
    numbers: HashMap<Node, u32>,
    sums: Vec<(Vector3<f64>, u32)>,
    triangles: Vec<[u32; 3]>,
}

impl Net {
    /// An edge that is crossed: the four cubes around it are joined, outside `up` the axis where its
    /// first node is inside.
    fn edge(&mut self, (along, from): (usize, &Node), place: Vector3<f64>, up: bool) {
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
        let [p, q, r, s] = [corner(1, 1), corner(0, 1), corner(0, 0), corner(1, 0)];
        let quad = if up { [[p, q, r], [p, r, s]] } else { [[p, r, q], [p, s, r]] };
        self.triangles.extend(quad);
    }
}
