//! Front of material on a square of rays, and planes that keep bodies off it.
//!
//! Neighbouring rays end nearly on a plane, however it is inclined; their distances from it are measured. A body kept off the
//! corners of that plane by at least these distances is kept off all of the rays.

use super::batch::ClipBatch;
use super::closest_approach::RayLine;
use crate::verify::stock::broad_phase::MovingPart;
use crate::verify::stock::dexel::{RaySpans, RaySquare, RayTile, across};
use nalgebra::{Point3, Vector3};

/// Pair of support planes of one body around a point; the lower one counts. Coordinates are across the rays first, then along
/// them.
#[derive(Clone, Copy)]
pub(crate) struct BodyPlane {
    pub(crate) part: usize,
    at: [f64; 3],
    pub(crate) height: f64,
    /// Height at the point, and slopes.
    sides: [(f64, [f64; 3]); 2],
    /// Slope of the lower plane along the rays.
    slope: f64,
    /// Range of the body along the rays.
    extent: [f64; 2],
}

/// Plane through one end of a span on the rays of a square.
struct FrontSheet {
    middle: [f64; 3],
    /// Half the extent across.
    half: [f64; 2],
    /// Slopes across.
    slopes: [f64; 2],
    /// Lowest and highest deviation of a ray from the plane.
    off: [f64; 2],
}

/// Span of all rays of a square: lower and upper end.
pub(crate) struct FrontLayer([FrontSheet; 2]);

impl BodyPlane {
    /// Returns the planes of a body at a point.
    pub(crate) fn new(number: usize, part: &MovingPart, along: usize, at: &Point3<f64>) -> Self {
        let [a, b] = across(along);
        let planes = part.whole.support_planes(part.body, at);
        let side = |&(height, g): &(f64, Vector3<f64>)| (height, [g[a], g[b], g[along]]);
        let sides = [side(&planes.sides[0]), side(&planes.sides[1])];
        // The lower plane of both is the bound at the point itself.
        let &(height, gradient) = planes.lower();
        let (slope, extent) = (gradient[along], part.extent(along));
        Self { part: number, at: [at[a], at[b], at[along]], height, sides, slope, extent }
    }

    /// Returns the mean of two planes of a body, laid at their intersection, that is level along the ray.
    ///
    /// One must fall and the other rise along it. The distance is at no time below any mean of both.
    pub(crate) fn meet(&self, other: &Self) -> Option<Self> {
        if !(self.slope < 0.0 && other.slope > 0.0) {
            return None;
        }
        // Step 1: choose the weight for which the slopes along the ray cancel.
        let share = other.slope / (other.slope - self.slope);
        let mean = |a: f64, b: f64| share * a + (1.0 - share) * b;
        // Step 2: find the point on the ray at which both lower planes have the same height.
        let [from, to] = [self.at[2], other.at[2]];
        let rise = other.height - self.height + other.slope * (from - to);
        let s = (from + rise / (self.slope - other.slope)).clamp(from.min(to), from.max(to));
        // Step 3: move both pairs to that point and average them, each side with its own.
        let side = |k: usize| {
            let [(one, a), (two, b)] = [self.sides[k], other.sides[k]];
            let height = mean(one + a[2] * (s - from), two + b[2] * (s - to));
            (height, [mean(a[0], b[0]), mean(a[1], b[1]), mean(a[2], b[2])])
        };
        let sides = [side(0), side(1)];
        let lower = if sides[0].0 < sides[1].0 { &sides[0] } else { &sides[1] };
        let [a, b, _] = self.at;
        Some(Self { at: [a, b, s], height: lower.0, slope: lower.1[2], sides, ..*self })
    }

    /// Returns the position along the ray at which it was laid.
    pub(crate) fn position(&self) -> f64 {
        self.at[2]
    }

    /// Returns its slope along the ray.
    pub(crate) fn slope(&self) -> f64 {
        self.slope
    }

    /// Tests if nothing farther back along a ray is nearer than its point.
    pub(crate) fn falls(&self) -> bool {
        self.sides.iter().all(|side| side.1[2] <= 0.0)
    }

    /// Tests if nothing farther on along a ray is nearer than its point.
    pub(crate) fn rises(&self) -> bool {
        self.sides.iter().all(|side| side.1[2] >= 0.0)
    }

    /// Returns the least height over a span of a ray, within the range of the body.
    #[inline]
    pub(crate) fn along(&self, [a, b]: [f64; 2], [low, high]: [f64; 2]) -> f64 {
        let Self { at, sides, extent, .. } = self;
        // Outside its range along the rays the body cannot meet the span.
        let [low, high] = [low.max(extent[0]), high.min(extent[1])];
        if low >= high {
            return f64::INFINITY;
        }
        let [a, b, low, high] = [a - at[0], b - at[1], low - at[2], high - at[2]];
        // A plane is linear along the ray, so its least height is at one end of the span.
        let over = |&(height, slopes): &(f64, [f64; 3])| {
            height + slopes[0] * a + slopes[1] * b + (slopes[2] * low).min(slopes[2] * high)
        };
        over(&sides[0]).min(over(&sides[1]))
    }

    /// Returns the least height over a layer.
    pub(crate) fn over(&self, FrontLayer(ends): &FrontLayer) -> f64 {
        let [low, high] = ends;
        let [from, to] = self.extent;
        if low.range()[0] >= to || high.range()[1] <= from {
            return f64::INFINITY;
        }
        // Outside the range of the body nothing counts: clip both ends to it.
        let flat = |sheet: &FrontSheet, s: f64| FrontSheet {
            middle: [sheet.middle[0], sheet.middle[1], s],
            slopes: [0.0; 2],
            off: [0.0; 2],
            ..*sheet
        };
        let low = if low.range()[1] <= from { &flat(low, from) } else { low };
        let high = if high.range()[0] >= to { &flat(high, to) } else { high };
        self.over_sheet(low).min(self.over_sheet(high))
    }

    fn over_sheet(&self, sheet: &FrontSheet) -> f64 {
        let FrontSheet { middle, half, slopes: lean, off } = sheet;
        // Across the rays by x, the sheet rises by `lean x`. The plane therefore has the slope `slopes[k] +
        // slopes[2] lean[k]` over the sheet, and is least at a corner; the deviations of the rays add their
        // worst.
        let by = [0, 1, 2].map(|k: usize| middle[k] - self.at[k]);
        let over = |&(mut height, slopes): &(f64, [f64; 3])| {
            height += slopes[2] * by[2] + (slopes[2] * off[0]).min(slopes[2] * off[1]);
            for k in [0, 1] {
                height += slopes[k] * by[k];
                height -= (slopes[k] + slopes[2] * lean[k]).abs() * half[k];
            }
            height
        };
        over(&self.sides[0]).min(over(&self.sides[1]))
    }
}

impl FrontSheet {
    /// Returns the lowest and the highest point on the rays.
    fn range(&self) -> [f64; 2] {
        let Self { middle, half, slopes, off } = self;
        // A plane over a rectangle is extreme at its corners.
        let by = slopes[0].abs() * half[0] + slopes[1].abs() * half[1];
        [middle[2] - by + off[0], middle[2] + by + off[1]]
    }
}

impl ClipBatch<'_> {
    /// Returns the layers of a square: the first spans of all rays, the second ones, and so on.
    pub(crate) fn layers(&self, tile: &RayTile, square: RaySquare) -> Vec<FrontLayer> {
        let most = square.rays().filter_map(|ray| tile.rays.get(ray)).map(RaySpans::len);
        let layer = |number| FrontLayer([0, 1].map(|end| self.sheet(tile, square, number, end)));
        (0..most.max().unwrap_or(0)).map(layer).collect()
    }

    /// Fits a plane to one end of a span at the corners of a square, if they have it.
    fn sheet(&self, tile: &RayTile, square: RaySquare, number: usize, end: usize) -> FrontSheet {
        let end_of = |ray: usize| Some(tile.rays.get(ray)?.get(number)?[end]);
        let [low, high] = self.frame.sides(tile, square);
        let half = [0, 1].map(|k: usize| 0.5 * (high[k] - low[k]));
        let mut slopes = [0.0; 2];
        let mut middle = None;
        // Step 1: fit the slopes to the four corners by least squares; without all four, the sheet is level.
        if let [Some(a), Some(b), Some(c), Some(d)] = square.corners().map(end_of) {
            let slope = |rise: f64, half: f64| if half > 0.0 { 0.25 * rise / half } else { 0.0 };
            slopes = [slope(c + d - a - b, half[0]), slope(b + d - a - c, half[1])];
            middle = Some(0.25 * (a + b + c + d));
        }
        let middle = middle.or_else(|| square.rays().find_map(end_of)).unwrap_or(0.0);
        let centre = [0, 1].map(|k: usize| low[k] + half[k]);
        // Step 2: record the extreme deviations of all rays. The plane rises by a constant step from ray to
        // ray.
        let steps = across(self.frame.along).map(|axis| self.frame.lattice.cell[axis]);
        let steps = [0, 1].map(|k: usize| slopes[k] * steps[k]);
        // Height of the plane over the first ray of the square.
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
        FrontSheet { middle: [centre[0], centre[1], middle], half, slopes, off }
    }

    /// Returns the coordinates of a line of this family across it.
    pub(crate) fn beside(&self, line: &RayLine) -> [f64; 2] {
        across(self.frame.along).map(|axis| line.from[axis])
    }
}
