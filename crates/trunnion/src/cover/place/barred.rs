//! Cells of a face over which the corner of the cutter would go into another face, wherever it touches.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::cover::layout::trims::region;
use crate::cover::options::CoverOptions;
use crate::cover::pattern::FeedDirection;
use crate::cover::place::context::PartSetup;
use crate::cover::place::tool_fit::ContactPoint;
use crate::cover::prove::face_cell::FaceCell;
use crate::cover::prove::face_tree::edge;
use crate::cover::prove::part_faces::NearestQuery;
use crate::cutter::ConvexSolid;
use crate::surface::FaceIndex;
use crate::types::{Interval, ToolPose};
use rayon::prelude::*;
use std::ops::Range;

/// Cells each way of a block; blocks are searched at the same time.
const BLOCK: usize = 8;

/// Precision of a depth, as a share of the corner's radius.
const PRECISION: f64 = 0.02;

/// Factor of the depth at the edges of the face, round which the corner may roll.
const AT_EDGES: f64 = 2.0;

/// Returns for every cell of an even grid over the box of a face, by u then by v, `true` if the corner of the cutter
/// finishes nothing in it, as it would go into another face.
///
/// A corner of radius `r` that finishes a point within `t`, and keeps off the face, lies near the one that touches at that
/// point: their centres are about `sqrt(2 r t (1 + r k))` apart at most, where the face bends away from the cutter by `k`.
/// (On a plane, points at `s` beside it are outside the corner, whose centre leans by `r t / s + s / 2` at most then, which
/// is least at `s^2 = 2 r t`.) Where the corner that touches goes deeper than that into another face, none finishes the
/// point. As the point moves along the face, the centre moves `1 + r k` times as fast at most: a depth in the middle of a
/// cell bounds that over all of it.
pub(super) fn barred_cells(
    face: &FaceIndex,
    setup: &PartSetup<'_>,
    options: &CoverOptions,
    counts: [usize; 2],
) -> Vec<bool> {
    let mut barred = vec![false; counts[0] * counts[1]];
    // A sharp edge has no corner, and the side of a barrel is no ball.
    if setup.cutter.minor() <= 0.0 || setup.cutter.is_barrel() {
        return barred;
    }
    let region = region(face, &Chart::straight(FeedDirection::V));
    let least = options.band.lower;
    let excess = options.band.upper + options.path_share - least;
    let search = BarredSearch { face, setup, least, excess, counts, region: &region };
    let [wide, high] = counts.map(|count| count.div_ceil(BLOCK));
    let found: Vec<[Range<usize>; 2]> = (0..wide * high)
        .into_par_iter()
        .flat_map_iter(|i| {
            let block = [[0, i / high], [1, i % high]].map(|[k, at]| {
                let first = at * BLOCK;
                first..(first + BLOCK).min(counts[k])
            });
            search.barred(block)
        })
        .collect();
    for [us, vs] in found {
        for i in us {
            barred[i * counts[1] + vs.start..i * counts[1] + vs.end].fill(true);
        }
    }
    barred
}

struct BarredSearch<'a, Inside> {
    face: &'a FaceIndex,
    setup: &'a PartSetup<'a>,
    /// Distance that the tool keeps from every face \[mm\].
    least: f64,
    /// Largest excess of a finished point over that \[mm\].
    excess: f64,
    counts: [usize; 2],
    region: &'a TrimmedRegion<Inside>,
}

impl<Inside: Fn(ChartPoint) -> bool> BarredSearch<'_, Inside> {
    /// Returns the barred parts of a block of cells.
    fn barred(&self, block: [Range<usize>; 2]) -> Vec<[Range<usize>; 2]> {
        let (mut barred, mut waiting) = (Vec::new(), vec![block]);
        while let Some(block) = waiting.pop() {
            match self.verdict(&block) {
                BlockVerdict::Free => {}
                BlockVerdict::Barred => barred.push(block),
                BlockVerdict::Open => waiting.extend(halves(block)),
            }
        }
        barred
    }

    fn verdict(&self, block: &[Range<usize>; 2]) -> BlockVerdict {
        let range = [0, 1].map(|k| self.range(k, block[k].start..block[k].end));
        let cell = FaceCell::new(range, &|[u, v]| self.face.face().point(u, v));
        let middle = cell.middle();
        let Some(contact) = ContactPoint::new(self.face, middle) else { return BlockVerdict::Free };
        // The cells around count for the curvature: the corner touches beside the points that it finishes.
        let around = [0, 1].map(|k| {
            let Range { start, end } = block[k];
            Interval::from(self.range(k, start.saturating_sub(1)..(end + 1).min(self.counts[k])))
        });
        let radius = self.setup.cutter.minor();
        let bend = self.face.curvature_range(around);
        let [away, towards] = [1.0 - radius * bend.low, radius * bend.high - 1.0];
        let moved = away.max(towards) * cell.radius();
        let apart = (2.0 * radius * self.excess * away).sqrt() + 2.0 * self.excess;
        let at_edge = !self.region.edges(around.map(Interval::ends)).is_empty();
        let margin = if at_edge { AT_EDGES * apart } else { apart };
        if self.is_deeper(&contact, margin + moved) {
            BlockVerdict::Barred
        } else if block.iter().all(|range| range.len() == 1)
            || !self.is_deeper(&contact, apart - moved)
        {
            BlockVerdict::Free
        } else {
            BlockVerdict::Open
        }
    }

    /// Returns `true` if the corner that touches at a point goes into another face by more than a depth \[mm\].
    fn is_deeper(&self, contact: &ContactPoint, depth: f64) -> bool {
        let PartSetup { cutter, part_faces, own, .. } = *self.setup;
        let radius = cutter.minor();
        // No ball goes deeper into anything than its diameter; without a bound of the curvature nothing is known.
        if depth.is_nan() || depth >= 2.0 * radius {
            return false;
        }
        let tip = contact.point + contact.normal.scale(radius + self.least);
        let pose = ToolPose { tip, axis: contact.normal };
        let query = NearestQuery::any(self.least - depth, PRECISION * radius);
        part_faces.nearest(&ConvexSolid::ball(radius), &pose, Some(own), query).is_some()
    }

    /// Returns the range of parameter `k` over some cells.
    fn range(&self, k: usize, cells: Range<usize>) -> [f64; 2] {
        let whole = self.face.face().bounds()[k].ends();
        [cells.start, cells.end].map(|line| edge(whole, line as f64 / self.counts[k] as f64))
    }
}

/// Finding about a block of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BlockVerdict {
    /// No cell of it is barred.
    Free,
    /// All of it is barred.
    Barred,
    /// Its halves have to be asked.
    Open,
}

/// Halves a block by its longer side.
fn halves(block: [Range<usize>; 2]) -> [[Range<usize>; 2]; 2] {
    let [us, vs] = block;
    if us.len() >= vs.len() {
        let middle = us.start + us.len() / 2;
        [[us.start..middle, vs.clone()], [middle..us.end, vs]]
    } else {
        let middle = vs.start + vs.len() / 2;
        [[us.clone(), vs.start..middle], [us, middle..vs.end]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::FinishTolerance;
    use crate::cover::cost::LengthCost;
    use crate::cover::prove::part_faces::PartFaces;
    use crate::cutter::{Cutter, CutterSpec};
    use crate::surface::{Face, NurbsSurface, Surface};
    use nalgebra::{Point3, Vector3};
    use std::f64::consts::TAU;

    const RADIUS: f64 = 3.0;
    const COUNT: usize = 32;

    fn bilinear(number: usize, corners: [[f64; 3]; 4]) -> FaceIndex {
        let [a, b, c, d] = corners.map(Point3::from);
        let knots = [vec![0.0, 0.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::new([1, 1], knots, vec![vec![a, b], vec![c, d]], None).unwrap();
        FaceIndex::new(Face::new(number, Surface::Nurbs(surface), Vec::new()).unwrap()).unwrap()
    }

    /// A floor of 20 mm, and a wall that hangs over it from its end at x = 20 to x = 10, 10 mm above.
    fn floor_and_wall() -> [FaceIndex; 2] {
        let floor = [[0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [20.0, 0.0, 0.0], [20.0, 20.0, 0.0]];
        let wall = [[20.0, 0.0, 0.0], [20.0, 20.0, 0.0], [10.0, 0.0, 10.0], [10.0, 20.0, 10.0]];
        [bilinear(1, floor), bilinear(2, wall)]
    }

    fn barred(faces: &[FaceIndex; 2], tolerance: f64) -> Vec<bool> {
        let cutter = Cutter::new(CutterSpec::ball(2.0 * RADIUS)).unwrap();
        let tolerance = FinishTolerance { excess: tolerance, gouge: 0.0 };
        let options = CoverOptions::finishing(&cutter, tolerance);
        let part_faces = PartFaces::new(faces.iter(), &cutter);
        let cost = LengthCost { link: 10.0 };
        let setup = PartSetup { cutter: &cutter, part_faces: &part_faces, own: 0, cost: &cost };
        barred_cells(&faces[0], &setup, &options, [COUNT; 2])
    }

    /// Distance of a point from the wall: that of the plane x + z = 20, over the middle of the floor.
    fn off_the_wall(p: &Point3<f64>) -> f64 {
        (20.0 - p.x - p.z) / 2.0_f64.sqrt()
    }

    #[test]
    fn no_corner_that_keeps_off_finishes_a_barred_point() {
        let (faces, tolerance) = (floor_and_wall(), 0.02);
        let out = barred(&faces, tolerance);
        assert!(out.iter().filter(|out| **out).count() > COUNT, "{out:?}");
        for cell in (0..COUNT * COUNT).filter(|cell| out[*cell]) {
            let side = 20.0 / COUNT as f64;
            let [x, y] = [cell / COUNT, cell % COUNT].map(|i| side * i as f64);
            for (dx, dy) in [(0.0, 0.0), (side, 0.0), (0.0, side), (side, side)] {
                let p = Point3::new(x + dx, y + dy, 0.0);
                // Centres round the point from which a corner comes within the tolerance, on and above the floor.
                for i in 0..=40 {
                    for k in 0..24 {
                        let lean = 0.01 * f64::from(i);
                        let (sin, cos) = (TAU * f64::from(k) / 24.0).sin_cos();
                        let way = Vector3::new(lean.sin() * cos, lean.sin() * sin, lean.cos());
                        let centre = p + way * (RADIUS + tolerance);
                        let fits = centre.z >= RADIUS && off_the_wall(&centre) >= RADIUS;
                        assert!(!fits, "cell {cell}, lean {lean}: {centre}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_the_corner_reaches_is_not_barred_and_a_free_floor_has_no_barred_cell() {
        let [floor, wall] = floor_and_wall();
        let out = barred(&[floor.clone(), wall], 0.02);
        // A ball on the floor keeps off the wall up to x = 20 - 3 - 3 sqrt(2); cells beyond that by a millimetre are barred.
        let free = 20.0 - RADIUS * (1.0 + 2.0_f64.sqrt());
        for (cell, out) in out.iter().enumerate() {
            let x = 20.0 / COUNT as f64 * (cell / COUNT) as f64;
            assert!(!out || x > free, "{cell}");
            let inside = (2..COUNT - 2).contains(&(cell % COUNT));
            assert!(*out || !inside || x < free + 2.0 || x > 19.0, "{cell} at {x}");
        }
        let away = bilinear(
            2,
            [[40.0, 0.0, 0.0], [40.0, 20.0, 0.0], [30.0, 0.0, 10.0], [30.0, 20.0, 10.0]],
        );
        assert!(barred(&[floor, away], 0.02).iter().all(|out| !out));
    }
}
