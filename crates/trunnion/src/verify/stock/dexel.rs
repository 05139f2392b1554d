//! Dexels: three families of parallel rays with intervals of material, in tiles.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Rays along the side of a tile.
pub(crate) const TILE: usize = 16;

/// Material along a ray: ascending intervals. Nearly every ray has one, which is stored in place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RaySpans {
    /// First interval; empty if it ends where it begins.
    first: [f64; 2],
    more: Vec<[f64; 2]>,
}

impl RaySpans {
    /// Ray without material.
    pub(crate) const NONE: Self = Self { first: [0.0; 2], more: Vec::new() };

    /// Returns the number of intervals.
    pub(crate) fn len(&self) -> usize {
        if self.first[0] < self.first[1] { 1 + self.more.len() } else { 0 }
    }

    /// Returns an interval.
    pub(crate) fn get(&self, index: usize) -> Option<[f64; 2]> {
        match index.checked_sub(1) {
            Some(more) => self.more.get(more).copied(),
            None => (self.first[0] < self.first[1]).then_some(self.first),
        }
    }

    /// Iterates over all intervals.
    pub(crate) fn iter(&self) -> impl Iterator<Item = [f64; 2]> {
        let first = (self.first[0] < self.first[1]).then_some(self.first);
        first.into_iter().chain(self.more.iter().copied())
    }

    /// Returns the lowest and the highest end.
    pub(crate) fn range(&self) -> Option<[f64; 2]> {
        let last = self.more.last().unwrap_or(&self.first);
        (self.first[0] < self.first[1]).then_some([self.first[0], last[1]])
    }

    /// Adds an interval above all others; skips one without length.
    pub(crate) fn push(&mut self, span: [f64; 2]) {
        if span[0] >= span[1] {
            return;
        }
        if self.first[0] < self.first[1] { self.more.push(span) } else { self.first = span }
    }

    /// Removes `low..high` from all intervals.
    pub(crate) fn take(&mut self, [low, high]: [f64; 2]) {
        for index in (0..self.len()).rev() {
            if self.get(index).is_some_and(|span| span[0] < high && low < span[1]) {
                self.cut(index, [low, high]);
            }
        }
    }

    /// Removes `low..high` from one interval. The remainder above has number `index + 1` if something remains below, or
    /// else `index`.
    pub(crate) fn cut(&mut self, index: usize, [low, high]: [f64; 2]) {
        let further = index.checked_sub(1);
        let Some(span) = further.map_or(Some(&mut self.first), |at| self.more.get_mut(at)) else {
            return;
        };
        // Material may remain below the cut, above it, on both sides, or not at all.
        let to = span[1];
        match (low > span[0], high < to) {
            (true, true) => {
                span[1] = low;
                self.more.insert(index, [high, to]);
            }
            (true, false) => span[1] = low,
            (false, true) => span[0] = high,
            (false, false) => match further {
                Some(at) => _ = self.more.remove(at),
                None if self.more.is_empty() => self.first = [0.0; 2],
                None => self.first = self.more.remove(0),
            },
        }
    }
}

/// Square tile of rays.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RayTile {
    /// Numbers of the first ray in both directions.
    pub(crate) first: [usize; 2],
    /// Number of rays in both directions.
    pub(crate) size: [usize; 2],
    /// Rays, the second number running fastest.
    pub(crate) rays: Vec<RaySpans>,
    /// Range of material on them.
    pub(crate) held: MaterialBins,
    /// Length of material \[mm\].
    pub(crate) length: f64,
}

/// Range of material on some rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MaterialBins {
    /// Lowest and highest material; empty if the first is above the second.
    range: [f64; 2],
    /// Bit mask of the bins along the rays that contain material.
    bins: u64,
}

/// Division of the length of a family's rays into bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeightBins {
    low: f64,
    size: f64,
}

/// Bins along a ray.
const BINS: f64 = 64.0;

impl HeightBins {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 63")]
    fn number(self, s: f64) -> u32 {
        ((s - self.low) / self.size).clamp(0.0, BINS - 1.0) as u32
    }

    /// Returns the mask of the bins that an interval meets.
    fn mask(self, [low, high]: [f64; 2]) -> u64 {
        let [first, last] = [self.number(low), self.number(high)];
        // All bins from the first to the last: bits `first..=last`.
        (u64::MAX << first) & (u64::MAX >> (63 - last))
    }
}

impl MaterialBins {
    /// Returns the range of no ray.
    pub(crate) const NONE: Self = Self { range: [f64::INFINITY, f64::NEG_INFINITY], bins: 0 };

    /// Includes a ray.
    pub(crate) fn add(&mut self, spans: &RaySpans, bins: HeightBins) {
        let Some([low, high]) = spans.range() else { return };
        self.range = [self.range[0].min(low), self.range[1].max(high)];
        for span in spans.iter() {
            self.bins |= bins.mask(span);
        }
    }

    /// Returns the lowest and the highest material, ignoring bins outside `low..high`.
    pub(crate) fn within(&self, bins: HeightBins, [low, high]: [f64; 2]) -> Option<[f64; 2]> {
        if high < self.range[0] || low > self.range[1] {
            return None;
        }
        let held = self.bins & bins.mask([low, high]);
        if held == 0 {
            return None;
        }
        let edge = |number: u32| bins.low + bins.size * f64::from(number);
        // Lowest and highest bin with material; the outermost bins have no outer edge, since positions beyond are clamped.
        let [below, above] = [held.trailing_zeros(), held.leading_zeros()];
        let low = if below == 0 { f64::MIN } else { edge(below) };
        let high = if above == 0 { f64::MAX } else { edge(64 - above) };
        Some([self.range[0].max(low), self.range[1].min(high)])
    }
}

impl RayTile {
    /// Updates range and length of the material.
    pub(crate) fn measure(&mut self, bins: HeightBins) {
        (self.held, self.length) = (MaterialBins::NONE, 0.0);
        for spans in &self.rays {
            self.held.add(spans, bins);
            self.length += spans.iter().map(|[low, high]| high - low).sum::<f64>();
        }
    }

    /// Returns row and column of a ray.
    pub(crate) fn row_and_column(&self, ray: usize) -> [usize; 2] {
        let columns = self.size[1].max(1);
        [ray / columns, ray % columns]
    }

    /// Returns probing rays: in the middle, and in the middle of each quarter.
    pub(crate) fn probing_rays(&self) -> [usize; 5] {
        let [rows, columns] = self.size;
        // In quarters of both sides.
        let at = |[i, j]: [usize; 2]| rows * i / 4 * columns + columns * j / 4;
        [[2, 2], [1, 1], [1, 3], [3, 1], [3, 3]].map(at)
    }

    /// Divides the tile into squares of `side` rays.
    pub(crate) fn squares(&self, side: usize) -> impl Iterator<Item = RaySquare> + use<> {
        let [rows, columns] = self.size;
        (0..rows).step_by(side).flat_map(move |i| {
            (0..columns).step_by(side).map(move |j| RaySquare {
                from: [i, j],
                size: [side.min(rows - i), side.min(columns - j)],
                columns,
            })
        })
    }

    /// Returns the square of all rays.
    pub(crate) fn whole(&self) -> RaySquare {
        RaySquare { from: [0, 0], size: self.size, columns: self.size[1] }
    }
}

/// Square of rays in a tile: first ray and count in both directions, and the row length of the tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RaySquare {
    pub(crate) from: [usize; 2],
    pub(crate) size: [usize; 2],
    columns: usize,
}

impl RaySquare {
    /// Iterates over the numbers of the rays in the tile.
    pub(crate) fn rays(self) -> impl Iterator<Item = usize> {
        self.rows().flatten()
    }

    /// Iterates over the rays a row at a time.
    pub(crate) fn rows(self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let Self { from, size, columns } = self;
        (from[0]..from[0] + size[0])
            .map(move |i| i * columns + from[1]..i * columns + from[1] + size[1])
    }

    /// Iterates in zigzag: row by row, every other row backwards.
    pub(crate) fn to_and_fro(self) -> impl Iterator<Item = usize> {
        let Self { from, size, columns } = self;
        (0..size[0]).flat_map(move |i| {
            let column = move |k| if i % 2 == 0 { k } else { size[1] - 1 - k };
            (0..size[1]).map(move |k| (from[0] + i) * columns + from[1] + column(k))
        })
    }

    /// Returns the corner rays: both low, second high, first high, both high.
    pub(crate) fn corners(self) -> [usize; 4] {
        let Self { from, size, columns } = self;
        // Inclusive numbers of the last row and column.
        let last = [0, 1].map(|k: usize| (from[k] + size[k]).saturating_sub(1));
        let at = |i: usize, j: usize| i * columns + j;
        [at(from[0], from[1]), at(from[0], last[1]), at(last[0], from[1]), at(last[0], last[1])]
    }

    /// Returns the ray in the middle.
    pub(crate) fn middle(self) -> usize {
        let [i, j] = [0, 1].map(|k| self.from[k] + self.size[k] / 2);
        i * self.columns + j
    }
}

/// Family of parallel rays through the middles of the lattice cubes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RayFamily {
    /// Axis of the rays.
    pub(crate) along: usize,
    /// Tiles, the second number running fastest.
    pub(crate) tiles: Vec<RayTile>,
    pub(crate) bins: HeightBins,
    /// Number of tiles in both directions.
    pub(crate) grid: [usize; 2],
}

/// Lattice of nearly cubic cells; rays run through their middles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DexelGrid {
    /// Middle of the first cell.
    pub(crate) origin: Point3<f64>,
    /// Sides of a cell \[mm\].
    pub(crate) cell: [f64; 3],
    /// Number of cells along x, y and z.
    pub(crate) size: [usize; 3],
}

/// Returns the two axes across one, in cyclic order.
pub(crate) fn across(along: usize) -> [usize; 2] {
    [(along + 1) % 3, (along + 2) % 3]
}

impl DexelGrid {
    /// Returns the coordinate of node `index`.
    pub(crate) fn at(&self, axis: usize, index: usize) -> f64 {
        self.origin[axis] + self.cell[axis] * index as f64
    }

    /// Returns the point of ray `[i, j]` of a family at zero of its axis.
    pub(crate) fn ray(&self, along: usize, [i, j]: [usize; 2]) -> Point3<f64> {
        let [a, b] = across(along);
        let mut point = Point3::origin();
        (point[a], point[b]) = (self.at(a, i), self.at(b, j));
        point
    }

    /// Returns the first node of an axis within `low..=high`, and the number of nodes.
    pub(crate) fn nodes(&self, axis: usize, [low, high]: [f64; 2]) -> [usize; 2] {
        let number = |x: f64| (x - self.origin[axis]) / self.cell[axis];
        let count = self.size[axis] as f64;
        // One more on either side allows for rounding.
        let first = (number(low).ceil() - 1.0).clamp(0.0, count);
        let end = (number(high).floor() + 2.0).clamp(first, count);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        [first as usize, (end - first) as usize]
    }
}

impl RayFamily {
    /// Builds a family from rows of rays, one row per node in the first direction.
    pub(crate) fn new(lattice: &DexelGrid, along: usize, rows: Vec<Vec<RaySpans>>) -> Self {
        let [a, b] = across(along).map(|axis| lattice.size[axis]);
        let bins = HeightBins {
            // From a cell below the first node to a cell above the last.
            low: lattice.at(along, 0) - lattice.cell[along],
            size: lattice.cell[along] * (lattice.size[along] as f64 + 1.0) / BINS,
        };
        let mut rows = rows.into_iter();
        let mut tiles = Vec::new();
        for i in (0..a).step_by(TILE) {
            let first = tiles.len();
            tiles.extend((0..b).step_by(TILE).map(|j| {
                let size = [TILE.min(a - i), TILE.min(b - j)];
                let rays = Vec::with_capacity(size[0] * size[1]);
                RayTile { first: [i, j], size, rays, held: MaterialBins::NONE, length: 0.0 }
            }));
            for row in rows.by_ref().take(TILE) {
                let mut spans = row.into_iter();
                for tile in tiles.iter_mut().skip(first) {
                    let size = tile.size[1];
                    tile.rays.extend(spans.by_ref().take(size));
                }
            }
        }
        tiles.par_iter_mut().for_each(|tile| tile.measure(bins));
        Self { along, tiles, bins, grid: [a.div_ceil(TILE), b.div_ceil(TILE)] }
    }

    /// Returns the material along ray `[i, j]`.
    pub(crate) fn spans(&self, [i, j]: [usize; 2]) -> Option<&RaySpans> {
        let tile = self.tiles.get(i / TILE * self.grid[1] + j / TILE);
        tile.and_then(|tile| tile.rays.get(i % TILE * tile.size[1] + j % TILE))
    }

    /// Returns the length of all material \[mm\].
    pub(crate) fn length(&self) -> f64 {
        self.tiles.iter().map(|tile| tile.length).sum()
    }
}

/// Returns the unit vector along an axis.
pub(crate) fn unit(along: usize) -> Vector3<f64> {
    let mut unit = Vector3::zeros();
    unit[along] = 1.0;
    unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_shortens_splits_or_removes_a_span() {
        let spans = |all: &[[f64; 2]]| {
            let mut spans = RaySpans::NONE;
            for &span in all {
                spans.push(span);
            }
            spans
        };
        let two = [[0.0, 1.0], [2.0, 5.0]];
        let cut = |index: usize, cut: [f64; 2]| {
            let mut spans = spans(&two);
            spans.cut(index, cut);
            spans
        };
        assert_eq!(cut(1, [4.0, 6.0]), spans(&[[0.0, 1.0], [2.0, 4.0]]));
        assert_eq!(cut(1, [1.0, 3.0]), spans(&[[0.0, 1.0], [3.0, 5.0]]));
        assert_eq!(cut(1, [3.0, 4.0]), spans(&[[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]));
        assert_eq!(cut(0, [0.25, 0.5]), spans(&[[0.0, 0.25], [0.5, 1.0], [2.0, 5.0]]));
        assert_eq!(cut(1, [2.0, 5.0]), spans(&[[0.0, 1.0]]));
        assert_eq!(cut(0, [0.0, 5.0]), spans(&[[2.0, 5.0]]));
        let mut both = spans(&two);
        both.take([0.5, 3.0]);
        assert_eq!(both, spans(&[[0.0, 0.5], [3.0, 5.0]]));
        both.take([-1.0, 9.0]);
        assert_eq!(both, RaySpans::NONE);
        let mut one = spans(&[[0.0, 1.0]]);
        one.cut(0, [-1.0, 2.0]);
        assert_eq!((one.len(), one.range(), one), (0, None, RaySpans::NONE));
    }

    #[test]
    fn rays_know_their_gaps() {
        let bins = HeightBins { low: 0.0, size: 1.0 };
        let mut spans = RaySpans::NONE;
        spans.push([2.5, 10.25]);
        spans.push([50.75, 63.5]);
        let mut held = MaterialBins::NONE;
        held.add(&spans, bins);
        assert_eq!(held.within(bins, [0.0, 64.0]), Some([2.5, 63.5]));
        assert_eq!(held.within(bins, [11.5, 49.5]), None);
        assert_eq!(held.within(bins, [5.0, 20.0]), Some([5.0, 11.0]));
        assert_eq!(held.within(bins, [40.0, 52.0]), Some([50.0, 53.0]));
        assert_eq!(held.within(bins, [70.0, 80.0]), None);
    }
}
