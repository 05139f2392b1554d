//! Merges the quads of a surface net where the surface does not change from cube to cube.
//!
//! A block is a flat rectangle of quads, or a strip one quad wide with a constant section, as along an edge. On its border
//! only those vertices are kept that are a corner of some block. The others are on straight lines between two kept ones,
//! for all blocks they belong to. Two blocks therefore always share the same edges, and a closed net stays closed.

use crate::types::Mesh;
use crate::verify::stock::clip::ray::CLOSE;
use crate::verify::stock::dexel::across;
use nalgebra::{Point3, Vector3};

/// Rounding error of a vertex \[mm per mm of the largest coordinate\]. A vertex is the mean of up to twelve ends of rays,
/// each after some hundred operations with an error of 2⁻⁵³.
const ROUNDING: f64 = 1e-13;

/// Four vertices around a crossed lattice edge. The order is plane by plane, row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct NetQuad {
    /// Axis of the edge.
    pub(crate) along: usize,
    /// The outside is up that axis.
    pub(crate) up: bool,
    /// Number of the edge's first node on the axis.
    pub(crate) level: i64,
    /// Numbers on the two axes across it, in cyclic order.
    pub(crate) at: [i64; 2],
    /// Vertices counter-clockwise as seen from up the axis, starting at the lowest numbers; the second one is a step
    /// further on the first axis across.
    pub(crate) corners: [u32; 4],
}

impl NetQuad {
    /// Returns the node at which its edge begins.
    pub(crate) fn node(&self) -> [i64; 3] {
        let [a, b] = across(self.along);
        let mut node = [self.level; 3];
        (node[a], node[b]) = (self.at[0], self.at[1]);
        node
    }
}

/// Triangulates the surface of the quads with few triangles.
///
/// `cell` holds the sides of a cube, `tolerance` is that of the ray ends \[mm\].
pub(crate) fn mesh(
    mut quads: Vec<NetQuad>,
    points: Vec<Point3<f64>>,
    cell: [f64; 3],
    tolerance: f64,
) -> Mesh {
    quads.sort_unstable();
    let largest = points.iter().fold(0.0, |most, point| point.coords.amax().max(most));
    // Two rays that meet the same plane may end this far apart, both off it to the same side.
    let flat = CLOSE * tolerance + ROUNDING * largest;
    let net = QuadNet { quads, points, cell: Vector3::from(cell), flat };
    let blocks = net.blocks();
    let mut kept = vec![false; net.points.len()];
    let corners = blocks.iter().flat_map(|block| (0..4).filter_map(|side| net.corner(block, side)));
    corners.for_each(|vertex| mark(&mut kept, vertex));
    let mut triangles = Vec::new();
    for block in &blocks {
        net.fill(block, &kept, &mut triangles);
    }
    only_used(&net.points, triangles)
}

/// Block of quads: `0..size` on both axes across, from the first quad.
struct QuadBlock {
    first: NetQuad,
    size: [i64; 2],
}

impl QuadBlock {
    /// Returns the quads along a side, counter-clockwise: side `k` begins at corner `k`.
    fn side(&self, side: usize) -> impl Iterator<Item = [i64; 2]> {
        let [[a, b], [m, n]] = [self.first.at, self.size];
        let count = if side.is_multiple_of(2) { m } else { n };
        (0..count).map(move |k| match side {
            0 => [a + k, b],
            1 => [a + m - 1, b + k],
            2 => [a + m - 1 - k, b + n - 1],
            _ => [a, b + n - 1 - k],
        })
    }
}

/// Net of quads with the allowance for flatness.
struct QuadNet {
    /// Quads in order.
    quads: Vec<NetQuad>,
    points: Vec<Point3<f64>>,
    cell: Vector3<f64>,
    /// Largest distance of vertices from flat \[mm\].
    flat: f64,
}

impl QuadNet {
    /// Partitions the quads into blocks.
    fn blocks(&self) -> Vec<QuadBlock> {
        let mut free = vec![true; self.quads.len()];
        let mut blocks = Vec::new();
        for (number, quad) in self.quads.iter().enumerate() {
            if free.get(number) == Some(&true) {
                let size = self.grown(number, &free);
                let rows = (0..size[0]).filter_map(|k| self.number(quad, [k, 0]));
                for row in rows {
                    let row = free.iter_mut().skip(row).take(index(size[1]));
                    row.for_each(|free| *free = false);
                }
                blocks.push(QuadBlock { first: *quad, size });
            }
        }
        blocks
    }

    /// Returns the size of the block that begins at a quad: the longest row and as many rows as fit, or else a column.
    fn grown(&self, number: usize, free: &[bool]) -> [i64; 2] {
        let Some(quad) = self.quads.get(number) else { return [1, 1] };
        let [p, q, _, s] = self.offsets(quad);
        let fits = |number: usize, like: &[Vector3<f64>; 4]| {
            let offsets = self.quads.get(number).map(|quad| self.offsets(quad));
            // Equal offsets from cube to cube mean that the surface does not change.
            let near = |(a, b): (&Vector3<f64>, &Vector3<f64>)| (a - b).amax() <= self.flat;
            free.get(number) == Some(&true)
                && offsets.is_some_and(|offsets| offsets.iter().zip(like).all(near))
        };
        let holds = |to: [i64; 2], like: &[_; 4]| {
            self.number(quad, to).is_some_and(|number| fits(number, like))
        };
        // A row along the second axis repeats its section, p and q. More rows fit only if all four offsets are equal: a flat
        // rectangle.
        let most = signed(self.quads.len());
        let row = (0..most).take_while(|&k| holds([0, k], &[p, q, q, p])).count();
        if row > 1 {
            let full = |&k: &i64| (0..signed(row)).all(|to| holds([k, to], &[p; 4]));
            return [signed((0..most).take_while(full).count().max(1)), signed(row)];
        }
        let column = (0..most).take_while(|&k| holds([k, 0], &[p, p, s, s])).count();
        [signed(column.max(1)), 1]
    }

    /// Returns the number of the quad at an offset in the same plane.
    fn number(&self, quad: &NetQuad, [a, b]: [i64; 2]) -> Option<usize> {
        let key = |quad: &NetQuad| (quad.along, quad.up, quad.level, quad.at);
        let at = [quad.at[0] + a, quad.at[1] + b];
        self.quads.binary_search_by_key(&key(&NetQuad { at, ..*quad }), key).ok()
    }

    /// Returns the positions of a quad's vertices inside their cubes.
    fn offsets(&self, quad: &NetQuad) -> [Vector3<f64>; 4] {
        let [a, b] = across(quad.along);
        let mut cube = Vector3::zeros();
        cube[quad.along] = quad.level as f64;
        [(0, [1, 1]), (1, [0, 1]), (2, [0, 0]), (3, [1, 0])].map(|(corner, back): (usize, _)| {
            cube[a] = (quad.at[0] - back[0]) as f64;
            cube[b] = (quad.at[1] - back[1]) as f64;
            let vertex = quad.corners.get(corner).copied().unwrap_or_default();
            let point = self.points.get(vertex as usize).copied().unwrap_or_default();
            point.coords - cube.component_mul(&self.cell)
        })
    }

    fn vertex(&self, block: &QuadBlock, at: [i64; 2], corner: usize) -> Option<u32> {
        let to = [at[0] - block.first.at[0], at[1] - block.first.at[1]];
        let quad = self.number(&block.first, to).and_then(|number| self.quads.get(number));
        quad.and_then(|quad| quad.corners.get(corner)).copied()
    }

    /// Returns the corner at which a side begins.
    fn corner(&self, block: &QuadBlock, side: usize) -> Option<u32> {
        block.side(side).next().and_then(|at| self.vertex(block, at, side))
    }

    /// Returns the vertices kept on a block's border, counter-clockwise from its first corner.
    fn border(&self, block: &QuadBlock, kept: &[bool]) -> Vec<BorderVertex> {
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let sides = corners.iter().enumerate().flat_map(|(side, [da, db])| {
            block.side(side).filter_map(move |[a, b]| {
                let vertex = self.vertex(block, [a, b], side)?;
                Some(BorderVertex { vertex, at: [a + da, b + db] })
            })
        });
        sides.filter(|border| kept.get(border.vertex as usize) == Some(&true)).collect()
    }

    /// Triangulates a block: a fan around a vertex in its middle, or a strip between its two long sides.
    fn fill(&self, block: &QuadBlock, kept: &[bool], triangles: &mut Vec<[u32; 3]>) {
        let border = self.border(block, kept);
        let [m, n] = block.size;
        let middle = [block.first.at[0] + m / 2, block.first.at[1] + n / 2];
        let filled = match self.vertex(block, middle, 0) {
            Some(centre) if m > 1 && n > 1 => fan(centre, &border),
            _ => strip(border, usize::from(n > 1)),
        };
        // Blocks are counter-clockwise as seen from up the axis: turn them over if the outside is below.
        let turned = |[a, b, c]: [u32; 3]| if block.first.up { [a, b, c] } else { [a, c, b] };
        triangles.extend(filled.into_iter().map(turned));
    }
}

/// Returns a fan of triangles around a centre.
fn fan(centre: u32, border: &[BorderVertex]) -> Vec<[u32; 3]> {
    let next = border.iter().cycle().skip(1);
    border.iter().zip(next).map(|(from, to)| [centre, from.vertex, to.vertex]).collect()
}

/// Vertex kept on the border of a block, with its numbers on the axes across.
#[derive(Clone, Copy)]
struct BorderVertex {
    vertex: u32,
    at: [i64; 2],
}

/// Triangulates a strip along one of the axes across, always towards the nearer of the next two vertices.
fn strip(mut border: Vec<BorderVertex>, axis: usize) -> Vec<[u32; 3]> {
    // The first and the last vertex are then those of the end with the lowest numbers.
    border.rotate_left(axis);
    let mut triangles = Vec::new();
    let mut rest = border.as_slice();
    while let [low, next, .., high] = *rest
        && let [.., before, _] = *rest
    {
        // Advance on the side that is behind, so that triangles stay short.
        let lower = next.at.get(axis) < before.at.get(axis);
        let third = if lower { next } else { before };
        triangles.push([low.vertex, third.vertex, high.vertex]);
        let last = rest.len() - 1;
        rest = if lower { rest.get(1..) } else { rest.get(..last) }.unwrap_or_default();
    }
    triangles
}

/// Returns a mesh of the vertices that triangles use, in their order.
fn only_used(points: &[Point3<f64>], mut triangles: Vec<[u32; 3]>) -> Mesh {
    let mut used = vec![false; points.len()];
    triangles.iter().flatten().for_each(|&vertex| mark(&mut used, vertex));
    let mut count = 0;
    let mut numbers = Vec::with_capacity(used.len());
    for &used in &used {
        numbers.push(count);
        count += u32::from(used);
    }
    for vertex in triangles.iter_mut().flatten() {
        *vertex = numbers.get(*vertex as usize).copied().unwrap_or_default();
    }
    let vertices = points.iter().zip(&used).filter(|(_, used)| **used).map(|(point, _)| *point);
    Mesh { vertices: vertices.collect(), triangles }
}

fn mark(marks: &mut [bool], vertex: u32) {
    if let Some(mark) = marks.get_mut(vertex as usize) {
        *mark = true;
    }
}

pub(crate) fn signed(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

fn index(count: i64) -> usize {
    usize::try_from(count).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{Cutter, CutterConstruction, CutterKind, CutterSpec};
    use crate::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
    use crate::types::{Silent, ToolPose};
    use crate::verify::{CheckInput, Solid, Stock, StockOptions, simulate};
    use proptest::prelude::*;
    use std::collections::HashMap;

    const TOLERANCE: f64 = 1e-4;

    fn block(cell: f64) -> Stock {
        let [low, high] = [Point3::new(-10.0, -7.5, -6.0), Point3::new(10.0, 7.5, 0.0)];
        Stock::new(&Solid::Box { low, high }, cell, 10_000_000).unwrap()
    }

    /// Cuts with a bull-nosed or flat cutter from tip to tip, and returns the remaining stock.
    fn cut(mut stock: Stock, minor: f64, axis: [f64; 3], tips: &[[f64; 3]]) -> Stock {
        let (kind, construction) = (
            if minor > 0.0 { CutterKind::Bull } else { CutterKind::Flat },
            CutterConstruction::Solid,
        );
        let spec =
            CutterSpec { kind, length: 30.0, construction, ..CutterSpec::of_radii(2.0, minor) };
        let cutter = Cutter::new(spec).unwrap();
        let record = |(line, tip): (u32, &[f64; 3])| {
            let pose = ToolPose::new(*tip, axis).unwrap();
            ClRecord { line, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
        };
        let records = (1..).zip(tips).map(record).collect();
        let file = ClFile { records, ..ClFile::default() };
        let input = CheckInput::locations(&file, &cutter);
        let cutting = StockOptions { worst: 1, ..StockOptions::within(TOLERANCE) };
        simulate(&input, &mut stock, &cutting, &Silent).unwrap();
        stock
    }

    /// Two triangles for every quad.
    fn whole(stock: &Stock) -> Mesh {
        let (quads, vertices) = stock.net();
        let two = |quad: &NetQuad| {
            let [p, q, r, s] = quad.corners;
            if quad.up { [[p, q, r], [p, r, s]] } else { [[p, r, q], [p, s, r]] }
        };
        Mesh { vertices, triangles: quads.iter().flat_map(two).collect() }
    }

    fn volume(mesh: &Mesh) -> f64 {
        let of = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize].coords);
            a.dot(&b.cross(&c)) / 6.0
        };
        mesh.triangles.iter().map(of).sum()
    }

    /// Counts edges that triangles use more than once in the same direction, as where two cubes of material touch
    /// along an edge; `None` if one is not used as often in the other direction.
    fn edges(mesh: &Mesh) -> Option<usize> {
        let mut edges = HashMap::new();
        for [a, b, c] in &mesh.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        let closed = edges.iter().all(|((a, b), count)| edges.get(&(*b, *a)) == Some(count));
        closed.then(|| edges.values().filter(|count| **count > 1).count())
    }

    /// Returns the ratio of triangles before and after merging, of a closed surface of the same volume.
    fn fewer(stock: &Stock) -> f64 {
        let (merged, whole) = (stock.mesh(TOLERANCE), whole(stock));
        let [of_merged, of_whole] = [&merged, &whole].map(edges);
        assert!(of_merged.is_some() && of_merged <= of_whole, "{of_merged:?} {of_whole:?}");
        let [has, had] = [&merged, &whole].map(volume);
        // As far as ends of rays may be off, over about the area of its three views from both sides.
        let [x, y, z] = [20.0, 15.0, 6.0];
        let most = 2.0 * CLOSE * TOLERANCE * 2.0 * (x * y + y * z + z * x);
        assert!((has - had).abs() < most, "{has} {had}");
        let rounded = volume(&stock.mesh(0.0));
        assert!((rounded - had).abs() < 1e-12 * x * y * z, "{rounded} {had}");
        whole.triangles.len() as f64 / merged.triangles.len() as f64
    }

    #[test]
    fn an_uncut_block_has_as_many_triangles_however_fine() {
        for cell in [1.0, 0.3, 0.1] {
            let stock = block(cell);
            assert!(fewer(&stock) > 1.0);
            // Each face: a fan of 4, strips along 4 edges with 2 each, 2 in each of 4 corners.
            assert_eq!(stock.mesh(TOLERANCE).triangles.len(), 6 * (4 + 8 + 8), "{cell}");
            assert_eq!(edges(&stock.mesh(TOLERANCE)), Some(0));
        }
    }

    #[test]
    fn a_slot_has_as_many_triangles_however_fine() {
        let slot = |cell| {
            let tips = [[-20.0, 0.3, -2.1], [20.0, 0.3, -2.1]];
            let stock = cut(block(cell), 0.0, [0.0, 0.0, 1.0], &tips);
            assert!(fewer(&stock) > 10.0);
            assert_eq!(edges(&stock.mesh(TOLERANCE)), Some(0));
            stock.mesh(TOLERANCE).triangles.len()
        };
        let [coarse, fine] = [0.3, 0.1].map(slot);
        assert!(coarse < 300 && fine < 300, "{coarse} {fine}");
    }

    #[test]
    fn the_floor_of_a_pocket_is_merged() {
        let tips = [[-5.3, -3.1, -2.1], [4.7, -3.1, -2.1], [4.7, 2.2, -2.1], [-5.3, 2.2, -2.1]];
        let stock = cut(block(0.1), 1.0, [0.0, 0.0, 1.0], &tips);
        assert!(fewer(&stock) > 3.0, "{}", fewer(&stock));
    }

    proptest! {
        #[test]
        fn random_cuts_leave_it_closed(
            tips in prop::collection::vec((-11.0..11.0, -9.0..9.0, -7.0..1.0), 2..7),
            (lean, flat, level) in ((-0.5..0.5, -0.5..0.5), any::<bool>(), any::<bool>()),
            cell in 0.3..0.9,
        ) {
            let axis = if level { [0.0, 0.0, 1.0] } else { [lean.0, lean.1, 1.0] };
            let tips: Vec<_> = tips.into_iter().map(|(x, y, z)| [x, y, z]).collect();
            let stock = cut(block(cell), if flat { 0.0 } else { 0.8 }, axis, &tips);
            prop_assert!(fewer(&stock) >= 1.0);
        }
    }
}
