//! Rays of material: three families, in tiles.

use nalgebra::{Point3, Vector3};

/// Rays along the side of a tile.
pub(super) const TILE: usize = 16;

/// Material along a ray: intervals, ascending, that do not touch.
pub(super) type Spans = Vec<[f64; 2]>;

/// One square of rays.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tile {
    /// Number of the first ray by both parameters.
    pub(super) first: [usize; 2],
    /// Rays by both parameters.
    pub(super) size: [usize; 2],
    /// Ray after ray, the second parameter running fastest.
    pub(super) rays: Vec<Spans>,
    /// Lowest and highest material; empty if the first is above the second.
    pub(super) range: [f64; 2],
}

impl Tile {
    /// Finds the range anew.
    pub(super) fn measure(&mut self) {
        let low = self.rays.iter().filter_map(|spans| spans.first()).map(|span| span[0]);
        let high = self.rays.iter().filter_map(|spans| spans.last()).map(|span| span[1]);
        self.range = [low.fold(f64::INFINITY, f64::min), high.fold(f64::NEG_INFINITY, f64::max)];
    }
}

/// Parallel rays through the nodes of a lattice.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Family {
    /// Along which axis.
    pub(super) along: usize,
    /// Tiles, the second parameter running fastest.
    pub(super) tiles: Vec<Tile>,
    columns: usize,
}

/// A lattice of cubes; rays run through the middles of the cubes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lattice {
    /// Middle of the first cube.
    pub(super) origin: Point3<f64>,
    /// Side of a cube \[mm\].
    pub(super) cell: f64,
    /// Cubes by x, y and z.
    pub(super) size: [usize; 3],
}

/// The axes across one, in cyclic order.
pub(super) fn across(along: usize) -> [usize; 2] {
    [(along + 1) % 3, (along + 2) % 3]
}

impl Lattice {
    /// A coordinate of node `index`.
    pub(super) fn at(&self, axis: usize, index: usize) -> f64 {
        self.origin[axis] + self.cell * index as f64
    }

    /// Where the ray `[i, j]` of a family crosses zero of its axis.
    pub(super) fn ray(&self, along: usize, [i, j]: [usize; 2]) -> Point3<f64> {
        let [a, b] = across(along);
        let mut point = Point3::origin();
        (point[a], point[b]) = (self.at(a, i), self.at(b, j));
        point
    }
}

impl Family {
    /// Rays filled by `fill`, which is given the axis and a point of the ray.
    pub(super) fn new(
        lattice: &Lattice,
        along: usize,
        fill: &(dyn Fn(usize, &Point3<f64>) -> Spans + Sync),
    ) -> Self {
        use rayon::prelude::*;
        let [a, b] = across(along).map(|axis| lattice.size[axis]);
        let firsts = |count: usize| (0..count).step_by(TILE);
        let places: Vec<[usize; 2]> =
            firsts(a).flat_map(|i| firsts(b).map(move |j| [i, j])).collect();
        let tile = |&first: &[usize; 2]| {
            let size = [TILE.min(a - first[0]), TILE.min(b - first[1])];
            let places = (0..size[0]).flat_map(|i| (0..size[1]).map(move |j| [i, j]));
            let rays = places
                .map(|[i, j]| fill(along, &lattice.ray(along, [first[0] + i, first[1] + j])))
                .collect();
            let mut tile = Tile { first, size, rays, range: [0.0; 2] };
            tile.measure();
            tile
        };
        Self { along, tiles: places.par_iter().map(tile).collect(), columns: b.div_ceil(TILE) }
    }

    /// Material along the ray `[i, j]`.
    pub(super) fn spans(&self, [i, j]: [usize; 2]) -> &[[f64; 2]] {
        let tile = self.tiles.get(i / TILE * self.columns + j / TILE);
        let spans = tile.and_then(|tile| tile.rays.get(i % TILE * tile.size[1] + j % TILE));
        spans.map_or(&[], Vec::as_slice)
    }

    /// Length of all material \[mm\].
    pub(super) fn length(&self) -> f64 {
        let spans = self.tiles.iter().flat_map(|tile| &tile.rays).flatten();
        spans.map(|[low, high]| high - low).sum()
    }
}

/// Takes `cut` out of the spans.
pub(super) fn subtract(spans: &mut Spans, index: usize, [low, high]: [f64; 2]) {
    let Some(span) = spans.get_mut(index) else { return };
    let [from, to] = *span;
    match (low > from, high < to) {
        (true, true) => {
            span[1] = low;
            spans.insert(index + 1, [high, to]);
        }
        (true, false) => span[1] = low,
        (false, true) => span[0] = high,
        (false, false) => _ = spans.remove(index),
    }
}

/// A direction along an axis.
pub(super) fn unit(along: usize) -> Vector3<f64> {
    let mut unit = Vector3::zeros();
    unit[along] = 1.0;
    unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_shortens_splits_or_removes_a_span() {
        let cut = |cut: [f64; 2]| {
            let mut spans = vec![[0.0, 1.0], [2.0, 5.0]];
            subtract(&mut spans, 1, cut);
            spans
        };
        assert_eq!(cut([4.0, 6.0]), [[0.0, 1.0], [2.0, 4.0]]);
        assert_eq!(cut([1.0, 3.0]), [[0.0, 1.0], [3.0, 5.0]]);
        assert_eq!(cut([3.0, 4.0]), [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]);
        assert_eq!(cut([2.0, 5.0]), [[0.0, 1.0]]);
    }
}
