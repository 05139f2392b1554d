//! Where the material of a square of rays ends, and planes below the distance of bodies from there.
//!
//! Neighbouring rays end on nearly a plane, whichever way it leans; how far off it they are is measured. What holds
//! a body off the corners of that plane, less that, holds it off all of the rays.

use super::nearest::Line;
use super::rays::{Spans, Square, Tile, across};
use super::work::Work;
use nalgebra::{Point3, Vector3};

/// A plane below the distance of a body, by its number. Places are given across the rays, first, and along them.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub(super) part: usize,
    at: [f64; 3],
    pub(super) height: f64,
    gradient: [f64; 3],
    shear: f64,
}

/// Where one end of a span lies on the rays of a square.
struct Sheet {
    middle: [f64; 3],
    /// Largest distance from the middle across.
    half: [f64; 2],
    /// How much farther along it is, across.
    slopes: [f64; 2],
    /// Lowest and highest ray beside it.
    off: [f64; 2],
}

/// A span of all the rays of a square: lower and upper end.
pub(super) struct Layer([Sheet; 2]);

impl Plane {
    /// Of a body's number, from a place to the height of its distance there, its gradient and how much less steep it
    /// may be.
    pub(super) fn new(
        (part, along): (usize, usize),
        at: &Point3<f64>,
        (height, gradient): (f64, Vector3<f64>),
        shear: f64,
    ) -> Self {
        let [a, b] = across(along);
        let (at, gradient) = ([at[a], at[b], at[along]], [a, b, along].map(|axis| gradient[axis]));
        Self { part, at, height, gradient, shear }
    }

    /// The place along a ray from which it was laid, and its slope along the ray.
    pub(super) fn seen(&self) -> (f64, f64) {
        (self.at[2], self.gradient[2])
    }

    /// Least height over a span of a ray through a place across.
    #[inline]
    pub(super) fn along(&self, [a, b]: [f64; 2], [low, high]: [f64; 2]) -> f64 {
        let Self { at, gradient, shear, .. } = self;
        let [a, b] = [a - at[0], b - at[1]];
        let beside = self.height + gradient[0] * a + gradient[1] * b - shear * (a.abs() + b.abs());
        let end = |s: f64| gradient[2] * (s - at[2]) - shear * (s - at[2]).abs();
        beside + end(low).min(end(high))
    }

    /// Least height over a layer.
    pub(super) fn over(&self, Layer(ends): &Layer) -> f64 {
        let [low, high] = ends.each_ref().map(|sheet| self.over_sheet(sheet));
        low.min(high)
    }

    fn over_sheet(&self, sheet: &Sheet) -> f64 {
        let Sheet { middle, half, slopes, off } = sheet;
        let Self { at, gradient, shear, .. } = self;
        let by = [0, 1, 2].map(|k: usize| middle[k] - at[k]);
        let mut height = self.height + gradient[2] * by[2];
        let [deep, high] = off.map(|off| gradient[2] * off);
        let mut far = by[2].abs() + off[1].max(-off[0]);
        for k in [0, 1] {
            height += gradient[k] * by[k];
            height -= (gradient[k] + gradient[2] * slopes[k]).abs() * half[k];
            far += by[k].abs() + half[k] * (1.0 + slopes[k].abs());
        }
        height + deep.min(high) - shear * far
    }
}

impl Work<'_> {
    /// The layers of a square: first spans of all rays, second ones, and so on.
    pub(super) fn layers(&self, tile: &Tile, square: Square) -> Vec<Layer> {
        let most = square.rays().filter_map(|ray| tile.rays.get(ray)).map(Spans::len);
        let layer = |number| Layer([0, 1].map(|end| self.sheet(tile, square, (number, end))));
        (0..most.max().unwrap_or(0)).map(layer).collect()
    }

    /// Through an end of a span of the corners of a square, if they have it.
    fn sheet(&self, tile: &Tile, square: Square, (number, end): (usize, usize)) -> Sheet {
        let place = |ray: usize| Some(tile.rays.get(ray)?.get(number)?[end]);
        let [low, high] = self.frame.sides(tile, square);
        let half = [0, 1].map(|k: usize| 0.5 * (high[k] - low[k]));
        let mut slopes = [0.0; 2];
        let mut middle = None;
        if let [Some(a), Some(b), Some(c), Some(d)] = square.corners().map(place) {
            let slope = |rise: f64, half: f64| if half > 0.0 { 0.25 * rise / half } else { 0.0 };
            slopes = [slope(c + d - a - b, half[0]), slope(b + d - a - c, half[1])];
            middle = Some(0.25 * (a + b + c + d));
        }
        let middle = middle.or_else(|| square.rays().find_map(place)).unwrap_or(0.0);
        let centre = [0, 1].map(|k: usize| low[k] + half[k]);
        let steps = across(self.frame.along).map(|axis| self.frame.lattice.cell[axis]);
        let steps = [0, 1].map(|k: usize| slopes[k] * steps[k]);
        let corner = middle - slopes[0] * half[0] - slopes[1] * half[1];
        let mut off = [0.0_f64; 2];
        for (row, rays) in square.rows().enumerate() {
            let mut expected = corner + steps[0] * row as f64;
            for spans in tile.rays.get(rays).unwrap_or_default() {
                if let Some(span) = spans.get(number) {
                    let by = span[end] - expected;
                    off = [off[0].min(by), off[1].max(by)];
                }
                expected += steps[1];
            }
        }
        Sheet { middle: [centre[0], centre[1], middle], half, slopes, off }
    }

    /// Where a line of this family runs, across.
    pub(super) fn beside(&self, line: &Line) -> [f64; 2] {
        across(self.frame.along).map(|axis| line.from[axis])
    }
}
