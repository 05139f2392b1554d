//! Uncut material: connected regions that the passes leave, with height, reason and the largest
//! ball that fits.

use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::cover::place::context::FaceContext;
use crate::cover::place::placed::PlacedPasses;
use crate::cover::place::tool_fit::{self, ContactPoint};
use crate::cover::prove::connected::{ParameterBox, hull, parts};
use crate::cover::prove::coverage::CoverageProof;
use crate::cover::prove::face_cell::FaceCell;
use crate::cover::prove::face_tree::edge;
use crate::cover::prove::sweep::PassSweep;
use crate::types::{Interval, UncutReason, UncutRegion};
use nalgebra::Point3;
use rayon::prelude::*;

/// Size of the cells at the edges of the uncut area, as a share of a narrow strip.
const CELL: f64 = 1.0 / 16.0;

/// Size of the cells of a closer search, where a cell is finished at its middle, as a share of the
/// least spacing.
const FINEST: f64 = 0.125;

/// Approximate number of points of one region at which height and fit are evaluated.
const LOOKS: usize = 48;

/// Points per side of a cell at the edge of the face, which measure its area; parts per side of a
/// range on a bent chart.
const PARTS: u32 = 4;

/// Halvings of a cell in the proof that the tool comes near to all of it.
const WITHIN_DEPTH: u32 = 16;

/// Distance from a region up to which poses are searched first for its height, as a share of the cutter's radius.
const MARGIN: f64 = 0.125;

/// Precision with which a ball keeps off the faces, as a share of the path share.
const PRECISION: f64 = 0.05;

/// Kind of the map between local parameters and those of the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MapKind {
    /// The same parameters, in some order.
    Exchange,
    Bent,
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> FaceContext<'_, Inside> {
    /// Returns the material that is unfinished in the end, of the ranges that were missed, the
    /// largest region first. Later passes may have swept over some of them.
    pub(crate) fn rest(&self, state: &PlacedPasses) -> Vec<UncutRegion> {
        let boxes: Vec<ParameterBox> =
            state.missed.iter().map(|uv| self.local_range(*uv)).collect();
        if boxes.is_empty() {
            return Vec::new();
        }
        let sweeps: Vec<&PassSweep> = state.sweeps().collect();
        let region = self.whole.complete();
        let swept = self.coverage(&region, &sweeps);
        // Coarse cells at the rim of the uncut area, fine ones where a cell is finished at its
        // middle.
        let sizes = [CELL * self.narrow(), FINEST * self.options.spacing.low];
        // Step 1: find the cells of the missed ranges that no pass finishes.
        let open = swept.open(&boxes, sizes);
        // Step 2: join them to connected regions and measure each.
        let mut rest: Vec<UncutRegion> = parts(&open)
            .into_par_iter()
            .filter_map(|cells| {
                let part = self.part(&region, &swept, &cells)?;
                // Step 3: drop what is no higher than the excess allowed.
                // In the corner between two faces the tool keeps off the other face by some micrometres. There it is
                // not above the face along the normal, but near it all the same.
                let height = swept.limit.max(self.options.excess);
                let is_left =
                    part.depth > height || !swept.comes_near(&cells, height, WITHIN_DEPTH);
                is_left.then_some(part)
            })
            .collect();
        rest.sort_by(|a, b| b.area.total_cmp(&a.area));
        rest
    }

    /// Measures the material that passes over all of the face leave.
    pub(crate) fn measure_whole(&self, placed: &mut PlacedPasses) {
        placed.missed = vec![self.face.face().bounds().map(Interval::ends)];
        placed.report.rest = self.rest(placed);
        placed.resolved = self.resolved(&placed.report.rest);
        placed.report.area = self.area();
    }

    /// Returns the resolution of the uncut area \[mm²\]. Cells on its rim count in full, and the
    /// rim of each region is about as long as that of its box.
    pub(crate) fn resolved(&self, rest: &[UncutRegion]) -> f64 {
        let rim = |[low, high]: &[Point3<f64>; 2]| 2.0 * (high - low).sum();
        CELL * self.narrow() * rest.iter().map(|part| rim(&part.bounds)).sum::<f64>()
    }

    /// Returns the ranges of u and v that hold a range across and along.
    pub(crate) fn uv_range(&self, range: ParameterBox) -> ParameterBox {
        image(range, self.map_kind(), &|local| self.chart.uv(local))
    }

    /// Returns the ranges across and along that hold a range of u and v.
    pub(crate) fn local_range(&self, range: ParameterBox) -> ParameterBox {
        image(range, self.map_kind(), &|uv| self.chart.local(uv))
    }

    fn map_kind(&self) -> MapKind {
        if self.chart.is_straight() { MapKind::Exchange } else { MapKind::Bent }
    }

    /// Measures one connected region.
    fn part(
        &self,
        region: &TrimmedRegion<&Inside>,
        swept: &CoverageProof<'_, &Inside>,
        cells: &[ParameterBox],
    ) -> Option<UncutRegion> {
        let chart = &self.chart;
        let at = |local: ChartPoint| {
            let [u, v] = chart.uv(local);
            self.face.face().point(u, v)
        };
        let mut area = 0.0;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        // The area counts the share of a cell inside the region; the bounds hold all of its corners.
        for &range in cells {
            let cell = FaceCell::new(range, &at);
            area += cell.area() * inside(region, range);
            for corner in cell.corners() {
                low = [0, 1, 2].map(|k: usize| low[k].min(corner[k]));
                high = [0, 1, 2].map(|k: usize| high[k].max(corner[k]));
            }
        }
        let looks = self.looks(region, swept, cells);
        let ball = |look: &LookedAt| look.ball;
        let deepest = looks.iter().max_by(|a, b| a.depth.total_cmp(&b.depth))?;
        let balls = looks.iter().map(ball);
        let uv: Vec<ParameterBox> = cells.iter().map(|range| self.uv_range(*range)).collect();
        Some(UncutRegion {
            face: self.face.face().number,
            area,
            uv: hull(&uv).map(Interval::from),
            cells: uv.into_iter().map(|range| range.map(Interval::from)).collect(),
            bounds: [Point3::from(low), Point3::from(high)],
            depth: deepest.depth,
            deepest: chart.uv(deepest.place).into(),
            point: at(deepest.place),
            ball: deepest.ball,
            balls: Interval {
                low: balls.clone().fold(f64::INFINITY, f64::min),
                high: balls.fold(0.0, f64::max),
            },
            reason: self.reason(deepest.place),
        })
    }

    /// Evaluates points of some cells, spread over them.
    fn looks(
        &self,
        region: &TrimmedRegion<&Inside>,
        swept: &CoverageProof<'_, &Inside>,
        cells: &[ParameterBox],
    ) -> Vec<LookedAt> {
        let middle = |range: &ParameterBox| range.map(|[low, high]| 0.5 * (low + high));
        let held = |range: &&ParameterBox| region.holds(middle(range));
        let inside: Vec<&ParameterBox> = cells.iter().filter(held).collect();
        // Where no middle of a cell is inside, the first serves.
        let places = if inside.is_empty() {
            vec![middle(cells.first().unwrap_or(&[[0.0; 2]; 2]))]
        } else {
            spread(&inside).into_iter().map(middle).collect()
        };
        let precision = PRECISION * self.options.path_share;
        let margin = MARGIN * self.setup.cutter.radius();
        let near = swept.poses_near(hull(cells), margin);
        let look = |&place: &ChartPoint| {
            let contact = ContactPoint::new(self.face, self.chart.uv(place))?;
            let ball = tool_fit::largest_ball(
                self.setup.part_faces,
                &contact,
                self.setup.cutter,
                precision,
            );
            Some(LookedAt { place, depth: swept.height(&contact.point, &near, margin), ball })
        };
        places.par_iter().filter_map(look).collect()
    }

    fn reason(&self, place: ChartPoint) -> UncutReason {
        let contact = ContactPoint::new(self.face, self.chart.uv(place));
        let reason =
            |contact: ContactPoint| tool_fit::reason(&self.keep_off(), &contact, self.setup.cutter);
        contact.map_or(UncutReason::Passes, reason)
    }
}

/// Point of the uncut material, its height there, and the largest ball that fits.
struct LookedAt {
    place: ChartPoint,
    depth: f64,
    ball: f64,
}

/// Chooses about [`LOOKS`] cells, from each part of the list in proportion to its area by
/// parameters.
fn spread<'a>(cells: &[&'a ParameterBox]) -> Vec<&'a ParameterBox> {
    let area = |range: &ParameterBox| range.iter().map(|[low, high]| high - low).product::<f64>();
    let step = cells.iter().map(|range| area(range)).sum::<f64>() / LOOKS as f64;
    // A cell is chosen when the area summed up passes the next threshold; a large cell is chosen once.
    let (mut sum, mut next) = (0.0, 0.0);
    let mut chosen = Vec::new();
    for range in cells {
        sum += area(range);
        if sum > next {
            chosen.push(*range);
            next = (next + step).max(sum);
        }
    }
    chosen
}

/// Returns the share of a cell that lies inside the region.
fn inside<Inside: Fn(ChartPoint) -> bool>(
    region: &TrimmedRegion<Inside>,
    range: ParameterBox,
) -> f64 {
    if region.edges(range).is_empty() {
        return 1.0;
    }
    let at = |k: usize, i: u32| {
        let [low, high] = range[k];
        low + (high - low) * (f64::from(i) + 0.5) / f64::from(PARTS)
    };
    let all = PARTS * PARTS;
    let held = (0..all).filter(|i| region.holds([at(0, i / PARTS), at(1, i % PARTS)])).count();
    held as f64 / f64::from(all)
}

/// Returns the box around the image of a range: by its corners where the map exchanges parameters
/// at most, otherwise by parts of it, each with its bow.
fn image(range: ParameterBox, kind: MapKind, map: &dyn Fn([f64; 2]) -> [f64; 2]) -> ParameterBox {
    if kind == MapKind::Exchange {
        let [[a, b], [c, d]] = range;
        let [low, high] = [map([a, c]), map([b, d])];
        return [0, 1].map(|k| [low[k], high[k]]);
    }
    let at = |local: ChartPoint| {
        let [a, b] = map(local);
        Point3::new(a, b, 0.0)
    };
    let part =
        |k: usize, i: u32| [i, i + 1].map(|i| edge(range[k], f64::from(i) / f64::from(PARTS)));
    let of = |i: u32| {
        let cell = FaceCell::new([part(0, i / PARTS), part(1, i % PARTS)], &at);
        let corners = cell.corners().map(|p| [[p.x, p.x], [p.y, p.y]]);
        // The image leaves the hull of its corners by no more than the bows of both parameters.
        let bow = cell.sag(0) + cell.sag(1);
        hull(&corners).map(|[low, high]| [low - bow, high + bow])
    };
    hull(&(0..PARTS * PARTS).map(of).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_a_cell_inside_by_pencil() {
        let half = vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0]];
        let region = TrimmedRegion::new([[0.0, 1.0]; 2], &[half], |[x, _]: ChartPoint| x < 0.5);
        assert!((inside(&region, [[0.0, 1.0]; 2]) - 0.5).abs() < 1e-12);
        assert!((inside(&region, [[0.1, 0.2], [0.1, 0.2]]) - 1.0).abs() < 1e-12);
    }
}
