//! Passes along sharp corners of a face, row after row from the corner into the face.
//!
//! A cutter with a round end leaves a strip beside every sharp corner. The edge of a flat end mill gets into it, if the tool
//! leans square to the other face, and a round end gets as near as it touches both faces. Lines of constant parameters through
//! the strip have the tool turn and lift, rows along the corner do not.

use crate::cover::layout::border_line::border_lines;
use crate::cover::layout::region::ChartPoint;
use crate::cover::place::chain_planner::{ChainPlanner, SpotPass, SpotStation, split};
use crate::cover::place::context::FaceContext;
use crate::cover::place::sharp_corner::SharpCorner;
use crate::cover::place::spots::{SPACING, small_cells};
use crate::cover::place::tool_fit::{
    ContactGap, ContactPoint, PoseOrder, has_flank, keeps_off_others,
};
use crate::cutter::{ConvexSolid, Cutter};
use crate::math;
use crate::positioning::ToleranceBand;
use crate::surface::FaceSample;
use crate::types::{Interval, Station, ToolPose, UncutRegion};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Fewest and most points of a border: farther apart than usual on a very long one.
const FEW: f64 = 8.0;
const POINTS: f64 = 2000.0;

/// Distance from the border within which the other face of a corner is, as a share of a narrow strip.
const NEAR: f64 = 0.05;

/// Distance of the stations of a row, in widths of a narrow strip: half that of spots, as rows end up to one before the corner does.
const CLOSE: f64 = 0.5 * SPACING;

/// Distance of the first row from the other face, above the lower end of the band, as a share of the band.
const FIRST: f64 = 0.25;

/// Rows beside a corner, at most.
const ROWS: usize = 60;

/// Steps in which the strip of a station is measured, and the least distance of the next row, as shares of a narrow strip.
const STEP: f64 = 0.1;

/// Share of the strip of a row after which the next one follows.
const OVERLAP: f64 = 0.9;

/// Precision of the first row of a round end, as a share of a narrow strip.
const TANGENT: f64 = 0.01;

/// Point of a border in a sharp corner.
#[derive(Debug, Clone, Copy)]
struct CornerPoint {
    uv: [f64; 2],
    point: Point3<f64>,
    normal: UnitVector3<f64>,
    /// Direction into the face, of unit length.
    inward: Vector3<f64>,
    /// Sine of the angle by which the face rises from the other one.
    rise: f64,
    /// Distance to which material is left \[mm\].
    depth: f64,
}

impl CornerPoint {
    /// Returns a pose that leans by an angle \[rad\], square to the corner and away from it.
    fn leaning(&self, angle: f64) -> ToolPose {
        let (sin, cos) = math::sin_cos(angle);
        let axis = self.normal.scale(cos) + self.inward.scale(sin);
        ToolPose { tip: self.point, axis: Unit::new_normalize(axis) }
    }
}

/// Plans passes along the corners of a face beside which some regions are left.
pub(crate) fn corner_rows<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    rest: &[&UncutRegion],
) -> Vec<SpotPass> {
    let left = LeftBesideCorners { parts: rest, most: corner_reach(context.setup.cutter) };
    corners(context, left)
        .par_iter()
        .flat_map_iter(|corner| CornerRows { context, corner }.passes())
        .collect()
}

/// Returns the distance from a corner up to which rows along it finish material \[mm\]: a round end touches both faces of a
/// right angle at its radius from the corner, of a sharper one farther away.
pub(crate) fn corner_reach(cutter: &Cutter) -> f64 {
    cutter.radius() + cutter.minor()
}

/// Regions that are left, as far as rows along corners are to finish them.
#[derive(Clone, Copy)]
struct LeftBesideCorners<'a> {
    parts: &'a [&'a UncutRegion],
    /// Greatest distance from a corner \[mm\].
    most: f64,
}

/// Returns the corners beside which some regions lie, each in the order of the border.
fn corners<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    left: LeftBesideCorners<'_>,
) -> Vec<Vec<CornerPoint>> {
    if left.parts.is_empty() {
        return Vec::new();
    }
    let step = CLOSE * context.narrow();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let lines = border_lines(context.face, |length| (length / step).clamp(FEW, POINTS) as usize);
    let mut corners = Vec::new();
    for line in lines {
        let mut points: Vec<Option<CornerPoint>> =
            line.par_iter().map(|sample| corner_point(context, sample)).collect();
        mark_depths(context, &mut points, left);
        corners.extend(runs(&points));
    }
    corners
}

/// Returns the point of a border, if it is in a sharp corner.
fn corner_point<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    FaceSample { uv, point, normal }: &FaceSample,
) -> Option<CornerPoint> {
    let contact = ContactPoint { point: *point, normal: *normal };
    let near = NEAR * context.narrow();
    let SharpCorner { inward, other } = SharpCorner::find(&context.keep_off(), &contact, near)?;
    let rise = inward.dot(&other);
    Some(CornerPoint { uv: [uv.u, uv.v], point: *point, normal: *normal, inward, rise, depth: 0.0 })
}

/// Sets the depth of each corner point to that of the cells of some regions which are nearer to it than to the others.
fn mark_depths<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    points: &mut [Option<CornerPoint>],
    left: LeftBesideCorners<'_>,
) {
    let face = context.face.face();
    let step = SPACING * context.narrow();
    // Cells inside a region may be as large as the face.
    let cells = left.parts.iter().flat_map(|part| &part.cells);
    let cells: Vec<[Interval; 2]> = cells.flat_map(|cell| small_cells(face, *cell, step)).collect();
    let nearest = |cell: &[Interval; 2]| {
        let [u, v] = *cell;
        let corners = [[u.low, v.low], [u.low, v.high], [u.high, v.low], [u.high, v.high]];
        let corners = corners.map(|[u, v]| face.point(u, v));
        let middle = face.point(u.middle(), v.middle());
        let apart = |point: &CornerPoint| (point.point - middle).norm_squared();
        let in_corner =
            points.iter().enumerate().filter_map(|(at, point)| Some((at, point.as_ref()?)));
        let found = in_corner.min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)));
        found.map(|(at, point)| {
            let depths = corners.map(|corner| (corner - point.point).norm());
            (at, depths.into_iter().fold(0.0, f64::max))
        })
    };
    let found: Vec<(usize, f64)> = cells.par_iter().filter_map(nearest).collect();
    for (at, depth) in found.into_iter().filter(|(_, depth)| *depth <= left.most) {
        // The point to either side as well: cells may be larger than the points are apart.
        let last = points.len() - 1;
        let beside = at.saturating_sub(1)..=(at + 1).min(last);
        for point in points[beside].iter_mut().flatten() {
            point.depth = point.depth.max(depth);
        }
    }
}

/// Returns the runs of consecutive points beside which something is left. One that goes all round ends where it begins.
fn runs(points: &[Option<CornerPoint>]) -> Vec<Vec<CornerPoint>> {
    let open = |point: &Option<CornerPoint>| point.filter(|point| point.depth > 0.0);
    let mut all: Vec<Option<CornerPoint>> = points.iter().map(open).collect();
    if all.iter().all(Option::is_some) {
        all.extend(all.first().copied());
    } else if let Some(gap) = all.iter().position(Option::is_none) {
        // A run over the end of the line is one.
        all.rotate_left(gap);
    }
    all.split(Option::is_none)
        .map(|run| run.iter().copied().flatten().collect::<Vec<_>>())
        .filter(|run| run.len() > 1)
        .collect()
}

/// Rows along one corner.
struct CornerRows<'a, 'b, Inside> {
    context: &'a FaceContext<'b, Inside>,
    corner: &'a [CornerPoint],
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> CornerRows<'_, '_, Inside> {
    /// Returns the passes of all rows, from the corner on.
    fn passes(&self) -> Vec<SpotPass> {
        let cutter = self.context.setup.cutter;
        // All inclinations of a round end cut about the same.
        let (order, lean) = if has_flank(cutter) {
            (PoseOrder::Widest, FRAC_PI_2)
        } else {
            (PoseOrder::AsBefore, self.context.options.lean.angle)
        };
        // The strip of a ball is as wide on both sides of its contact.
        let sides = if cutter.has_ball_tip() { 2.0 } else { 1.0 };
        let planner = ChainPlanner { context: self.context, order };
        let least = STEP * self.context.narrow();
        let mut passes = Vec::new();
        let mut row: Vec<Option<CornerPoint>> =
            self.corner.iter().map(|point| self.first(point)).collect();
        for _ in 0..ROWS {
            if row.iter().all(Option::is_none) {
                break;
            }
            let mut strip = f64::INFINITY;
            for chain in row.split(Option::is_none).filter(|chain| !chain.is_empty()) {
                let points: Vec<CornerPoint> = chain.iter().copied().flatten().collect();
                // Each by itself: what fits at one point decides nothing at the next.
                let station =
                    |point: &CornerPoint| planner.station(point.uv, Some(point.leaning(lean)));
                let stations: Vec<Option<SpotStation>> = points.par_iter().map(station).collect();
                let strips = points.iter().zip(&stations);
                let strips = strips
                    .filter_map(|(point, station)| self.strip(point, &station.as_ref()?.station));
                strip = strips.fold(strip, f64::min);
                passes.extend(
                    split(&stations).into_iter().flat_map(|run| planner.proven_passes(run)),
                );
            }
            let step = if strip.is_finite() { sides * OVERLAP * strip } else { least };
            let next = |point: &Option<CornerPoint>| self.next((*point)?, step.max(least));
            row = row.iter().map(next).collect();
        }
        passes
    }

    /// Returns the point of the first row: the tool keeps its distance from the other face as well.
    fn first(&self, point: &CornerPoint) -> Option<CornerPoint> {
        if self.context.setup.cutter.minor() > 0.0 {
            return self.first_of_round_end(point);
        }
        let ToleranceBand { lower, upper } = self.context.options.band;
        let step = (lower + FIRST * (upper - lower)) / point.rise;
        self.moved(*point, step.min(STEP * self.context.narrow()))
    }

    /// Returns the point nearest to the corner where a round end touches both faces; `None` if nothing is left there.
    fn first_of_round_end(&self, point: &CornerPoint) -> Option<CornerPoint> {
        let narrow = self.context.narrow();
        let (keep_off, cutter) = (self.context.keep_off(), self.context.setup.cutter);
        let gap = ContactGap { least: keep_off.least, raised: 0.0 };
        let fits = |point: &CornerPoint| {
            let contact = ContactPoint { point: point.point, normal: point.normal };
            keeps_off_others(&keep_off, &contact, gap, cutter.minor())
        };
        // Half of its strip lies before the contact.
        let is_done = |step: f64| step - (0.5 - STEP) * narrow > point.depth;
        // Step 1: doubling steps to a point where it fits.
        let (mut bad, mut good) = (0.0, STEP * narrow);
        let mut first = loop {
            let moved = self.moved(*point, good)?;
            if fits(&moved) {
                break moved;
            }
            if is_done(good) {
                return None;
            }
            (bad, good) = (good, 2.0 * good);
        };
        // Step 2: bisection towards the corner.
        while good - bad > TANGENT * narrow {
            let middle = 0.5 * (bad + good);
            match self.moved(*point, middle).filter(fits) {
                Some(moved) => (good, first) = (middle, moved),
                None => bad = middle,
            }
        }
        (!is_done(good)).then_some(first)
    }

    /// Returns the point a step \[mm\] farther from the corner; `None` where nothing is left beyond the strip before.
    fn next(&self, point: CornerPoint, step: f64) -> Option<CornerPoint> {
        if step < point.depth { self.moved(point, step) } else { None }
    }

    /// Moves a point into the face along its surface; `None` where the face ends.
    fn moved(&self, point: CornerPoint, step: f64) -> Option<CornerPoint> {
        let face = self.context.face;
        let [u, v] =
            self.context.foot_near(&(point.point + point.inward * step), point.uv, step)?;
        let normal = face.face().contains(u, v).then(|| face.face().normal(u, v)).flatten()?;
        let inward = point.inward - normal.scale(normal.dot(&point.inward));
        Some(CornerPoint {
            uv: [u, v],
            point: face.face().point(u, v),
            normal,
            inward: inward.try_normalize(f64::MIN_POSITIVE)?,
            depth: point.depth - step,
            ..point
        })
    }

    /// Returns the width away from the corner that the tool at a station finishes \[mm\]; `None` if that is all that is left.
    fn strip(&self, point: &CornerPoint, station: &Station) -> Option<f64> {
        let context = self.context;
        let step = STEP * context.narrow();
        let is_finished = |point: &CornerPoint| {
            let apart = |solid: &ConvexSolid| solid.distance(&point.point, &station.pose);
            context.tool.solids().any(|solid| apart(solid) <= context.options.band.upper)
        };
        let mut end = *point;
        while let Some(next) = self.next(end, step) {
            if !is_finished(&next) {
                return Some(point.depth - end.depth);
            }
            end = next;
        }
        None
    }
}
