//! Upper bound on excess: proves that a tool holds each piece of the face offset outwards, or sweeps over it.

use super::margin::TileBound;
use super::shape::{FlatCell, UvRectangle, halves, quarters};
use super::survey::{CellLocation, TileCells, TileSurvey, TileTask};
use crate::verify::deviation::ray::DecidingPose;
use crate::verify::report::{ExtremeHeight, HeightSample};
use crate::verify::swept::bvh::ContentId;
use crate::verify::swept::tool::{DepthRule, NormalRay};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Quarterings after which a larger bound is tried.
const DEEPEST: u32 = 14;
/// Most doublings of the bound.
const DOUBLINGS: i32 = 24;
/// Most poses tried on one piece: those that decided nearest to it.
const MOST_POSES: usize = 6;

/// Piece of the face with poses that may hold it.
struct ExcessCell {
    rectangle: UvRectangle,
    level: u32,
    poses: Vec<DecidingPose>,
    /// Last pose found among the bodies that may come to the piece.
    found: Option<DecidingPose>,
    /// Grid cell that it is part of.
    cell: TileCells,
    /// Bodies that may come to the piece, once they have been sought.
    items: Option<Rc<[ContentId]>>,
    /// Trim segments that may touch it.
    border: Option<Vec<u32>>,
}

/// Bodies that may come to the blocks of a tile: those of a block are sought among those of the block around it, once a cell
/// in it needs them.
struct BlockBodies<'a> {
    survey: &'a TileSurvey<'a>,
    all: Rc<[ContentId]>,
    /// By size and first cell of the block.
    blocks: BTreeMap<(usize, [usize; 2]), Rc<[ContentId]>>,
}

impl BlockBodies<'_> {
    /// Returns the bodies that may come to the smallest block around a cell.
    fn around(&mut self, cell: TileCells) -> Rc<[ContentId]> {
        self.of(cell.within(self.survey.task.cells, 2))
    }

    fn of(&mut self, block: TileCells) -> Rc<[ContentId]> {
        let TileTask { cells: whole, top, .. } = self.survey.task;
        if block.size >= whole.size {
            return Rc::clone(&self.all);
        }
        let key = (block.size, block.at);
        if let Some(known) = self.blocks.get(&key) {
            return Rc::clone(known);
        }
        let before = self.of(block.within(whole, 2 * block.size));
        let bundles = self.survey.bundles(block);
        let comes = |numbers: &ContentId| {
            let mut comes =
                bundles.iter().map(|bundle| self.survey.parts.comes(*numbers, bundle, top));
            comes.any(|distance| distance.is_some())
        };
        let found: Rc<[ContentId]> = before.iter().filter(|body| comes(body)).copied().collect();
        self.blocks.insert(key, Rc::clone(&found));
        found
    }
}

/// Bounds the highest excess in a tile.
pub(crate) fn tile(survey: &TileSurvey<'_>) -> TileBound {
    let TileTask { cells, start: [_, mut known], most, .. } = survey.task;
    let mut open = Vec::new();
    for one in cells.each() {
        cell(survey, one, &mut open);
    }
    let mut bodies =
        BlockBodies { survey, all: survey.parts.numbers().collect(), blocks: BTreeMap::new() };
    let mut count = 0;
    while let Some(mut next) = open.pop() {
        count += 1;
        let Some(piece) = survey.shape.cell(&next.rectangle) else {
            halve(next, None, None, &mut open);
            continue;
        };
        // Step 1: drop the piece if a pose that decided nearby holds it up to the bound, or passes over it.
        let aim = known.aim();
        if next.poses.iter().any(|pose| clears(survey, &piece, aim, pose))
            || next.found.is_some_and(|pose| passes(survey, &piece, aim, &pose))
        {
            continue;
        }
        // The same for its quarters, before all bodies are sought that may come to it.
        if quarters_clear(survey, &next, aim) {
            continue;
        }
        // Step 2: abandon the piece at the limit, as area without a proof.
        if count > most {
            if !known.relax(&survey.worst[1]) {
                known.end(piece.area());
                continue;
            }
            count = 0;
        }
        let items = next.items.take().unwrap_or_else(|| bodies.around(next.cell));
        next.items = Some(coming(survey, &piece, &items));
        search(survey, next, &piece, &mut known, &mut open);
    }
    known
}

/// Tests if the poses that decided near a piece leave no more than `height` on each of its quarters.
///
/// Where no single pose does that on the whole piece, each quarter may still have one that does. A ball whose curvature is
/// nearly that of the face comes near a piece with thousands of moves, and to seek among them takes longer.
fn quarters_clear(survey: &TileSurvey<'_>, next: &ExcessCell, height: f64) -> bool {
    let clear = |quarter: UvRectangle| {
        let cell = survey.shape.cell(&quarter);
        cell.is_some_and(|cell| next.poses.iter().any(|pose| clears(survey, &cell, height, pose)))
    };
    next.level < DEEPEST
        && !next.poses.is_empty()
        && quarters(next.rectangle).into_iter().all(clear)
}

/// Adds the pieces of a grid cell, with the poses that decide at its corners.
///
/// Cells with an uncut corner, and those that touch declared rest material, are reported as such and left out.
fn cell(survey: &TileSurvey<'_>, cell: TileCells, open: &mut Vec<ExcessCell>) {
    let [i, j] = cell.at;
    let Some(whole) = survey.rectangle(cell) else { return };
    let columns = survey.map.v.len();
    if survey.map.unfinished.get(i * columns.saturating_sub(1) + j).is_some_and(|meets| *meets) {
        return;
    }
    let mut poses: Vec<DecidingPose> = Vec::new();
    for index in
        [i * columns + j, i * columns + j + 1, (i + 1) * columns + j, (i + 1) * columns + j + 1]
    {
        let sample: Option<&HeightSample> = survey.map.samples.get(index).and_then(Option::as_ref);
        if sample.is_some_and(|sample| sample.rest || sample.height.is_none()) {
            return;
        }
        // The tool that leaves the least at a corner probably holds the cell around it.
        let pose = survey.deciding.get(index).copied().flatten();
        poses.extend(pose.filter(|pose| !poses.contains(pose)));
    }
    for rectangle in survey.shape.smooth_parts(whole) {
        let border = match survey.locate_any(&rectangle) {
            CellLocation::Outside => continue,
            CellLocation::Inside => None,
            CellLocation::Border(segments) => Some(segments),
        };
        let poses = poses.clone();
        open.push(ExcessCell {
            rectangle,
            level: 0,
            poses,
            found: None,
            cell,
            items: None,
            border,
        });
    }
}

/// Tests if a pose holds all of a piece offset outwards by `height`.
///
/// A convex body does if it holds the corners of the flat piece, less the largest departure of the piece from it.
fn holds(survey: &TileSurvey<'_>, cell: &FlatCell, height: f64, by: &DecidingPose) -> bool {
    let Some(body) = survey.parts.body(by.body) else { return false };
    let pose = by.pose;
    // Departure of the offset piece from the flat one: its bulge, and the turn of its normals times the
    // offset.
    let room = cell.bulge + height * cell.turn + survey.parts.scope.error();
    let [a, b] = cell.half;
    let middle = cell.centre + cell.normal * height - pose.tip;
    [a + b, a - b, b - a, -a - b]
        .iter()
        .all(|corner| body.probe(&(middle + corner), &pose.axis).distance <= -room)
}

/// Tests if a pose leaves no more than `height` on a piece: it holds the offset piece, or all of the piece is near it.
fn clears(survey: &TileSurvey<'_>, cell: &FlatCell, height: f64, by: &DecidingPose) -> bool {
    holds(survey, cell, height, by) || comes_near(survey, cell, height, by)
}

/// Tests if a pose comes within `distance` of all of a piece.
///
/// In the corner between two faces the tool keeps off one by some micrometres, and leaves as much of the other: along the
/// normal nothing cuts there, but all of it is near the tool. The distance of a convex body is convex, so that the corners
/// of the flat piece bound it. The probe of a cutting end is the distance itself; that of a shank may be less.
fn comes_near(survey: &TileSurvey<'_>, cell: &FlatCell, distance: f64, by: &DecidingPose) -> bool {
    let Some(body) = survey.parts.body(by.body).filter(|body| body.end_top().is_some()) else {
        return false;
    };
    let room = distance - cell.bulge - survey.parts.scope.error();
    let [a, b] = cell.half;
    let middle = cell.centre - by.pose.tip;
    [a + b, a - b, b - a, -a - b]
        .iter()
        .all(|corner| body.probe(&(middle + corner), &by.pose.axis).distance <= room)
}

/// Tests if a moving tool sweeps over all of a piece offset outwards by `height`, point after point. A sharp edge does
/// that although it holds no two points at once.
///
/// Proof: give every point `p` a time `u(p)` that is linear in `p`. Seen from the tool, `p` at that time depends linearly
/// on `p`, except for the bend of the motion. A convex body that holds the corners then holds everything between them.
/// Any such `u` is valid; it is fitted to the times at which the middles of the sides are deepest.
fn passes(survey: &TileSurvey<'_>, cell: &FlatCell, height: f64, by: &DecidingPose) -> bool {
    let Some(part) = survey.parts.part(ContentId { item: by.piece, body: by.body }) else {
        return false;
    };
    let [a, b] = cell.half;
    let point = |s: f64, t: f64| cell.centre + cell.normal * height + a * s + b * t;
    // Step 1: fit a linear time to the deepest times at the middles of the four sides.
    let deepest = |s: f64, t: f64| part.piece.deepest(part.body, &point(s, t));
    let sides = [deepest(-1.0, 0.0), deepest(1.0, 0.0), deepest(0.0, -1.0), deepest(0.0, 1.0)];
    let rates = [0.5 * (sides[1] - sides[0]), 0.5 * (sides[3] - sides[2])];
    // Step 2: keep the times within the piece of the move; a little early or late costs some micrometres only.
    let width = rates[0].abs() + rates[1].abs();
    let [p, q] = rates.map(|rate| rate / width.max(1.0));
    let width = width.min(1.0);
    let middle = (0.25 * sides.iter().sum::<f64>()).clamp(width - 1.0, 1.0 - width);
    let far = (cell.centre - part.piece.middle().pose.tip).norm() + cell.radius() + height;
    // Step 3: both a point and the corners may depart from the linear motion.
    let bend =
        2.0 * (part.piece.bend(far) * width * width + part.piece.shear(width) * cell.radius());
    let room = cell.bulge + height * cell.turn + survey.parts.scope.error() + bend;
    [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].iter().all(|[s, t]| {
        part.piece.distance(part.body, middle + p * s + q * t, &point(*s, *t)).0 <= -room
    })
}

/// Returns the parameter by which the corners of a piece differ in what a pose does: those on one side it holds, those
/// on the other it does not. `None` if both matter, or none.
fn dividing(
    survey: &TileSurvey<'_>,
    cell: &FlatCell,
    height: f64,
    by: &DecidingPose,
) -> Option<usize> {
    let body = survey.parts.body(by.body)?;
    let [a, b] = cell.half;
    let middle = cell.centre + cell.normal * height - by.pose.tip;
    let holds =
        |corner: Vector3<f64>| body.probe(&(middle + corner), &by.pose.axis).distance <= 0.0;
    let corners = [[holds(-a - b), holds(b - a)], [holds(a - b), holds(a + b)]];
    match corners {
        [[low, up], [other, top]] if low == up && other == top && low != other => Some(0),
        [[low, up], [other, top]] if low == other && up == top && low != up => Some(1),
        _ => None,
    }
}

fn halve(
    next: ExcessCell,
    border: Option<Vec<u32>>,
    by: Option<usize>,
    open: &mut Vec<ExcessCell>,
) {
    if next.level >= DEEPEST {
        return;
    }
    let border = border.or(next.border);
    let parts = by
        .map_or_else(|| quarters(next.rectangle).to_vec(), |k| halves(next.rectangle, k).to_vec());
    for rectangle in parts {
        let (poses, items) = (next.poses.clone(), next.items.clone());
        let (level, border) = (next.level + 1, border.clone());
        let (cell, found) = (next.cell, next.found);
        open.push(ExcessCell { rectangle, level, poses, found, cell, items, border });
    }
}

/// Finds the pose that comes lowest in the middle of a piece among the bodies that may come to it, and quarters the piece if that pose does not hold it.
fn search(
    survey: &TileSurvey<'_>,
    mut next: ExcessCell,
    piece: &FlatCell,
    known: &mut TileBound,
    open: &mut Vec<ExcessCell>,
) {
    let location = survey.locate(&next.rectangle, next.border.as_deref());
    if matches!(location, CellLocation::Outside) {
        return;
    }
    let ray = NormalRay {
        origin: piece.centre,
        normal: piece.normal,
        below: survey.parts.scope.reach,
        rule: DepthRule::AlongNormal,
    };
    // Step 1: measure the middle of the piece against the bodies that may come to it.
    let items = next.items.as_deref().unwrap_or_default();
    let lowest = survey.parts.lowest_or_nearest(items, &ray);
    let inside = survey.holds_middle(&next.rectangle, &location);
    // Moves above `top` were not gathered, but may count here: the tile is inspected again with more of them.
    if inside && lowest.s > survey.task.top {
        known.short = true;
        open.clear();
        return;
    }
    match (lowest.by, lowest.line) {
        (Some(pose), Some(line)) => {
            // Step 2: the pose just found is the most probable one for the parts of the piece as well.
            next.poses.insert(0, pose);
            next.poses.truncate(MOST_POSES);
            if inside && lowest.s > known.worst {
                known.worst = lowest.s;
                let uv = next.rectangle.map(|[low, high]| 0.5 * (low + high));
                let (face, point) = (survey.map.face, piece.centre);
                known.extreme = Some(ExtremeHeight {
                    face,
                    uv: uv.into(),
                    point,
                    height: lowest.s,
                    or_deeper: false,
                    line,
                    dog_leg: false,
                });
            }
            next.found = Some(pose);
            let aim = known.aim();
            if clears(survey, piece, aim, &pose) || passes(survey, piece, aim, &pose) {
                return;
            }
        }
        // A hole between the measured points: nothing cuts here, or nothing that could be measured along the normal.
        _ if inside && next.level >= DEEPEST => {
            known.open += piece.area();
            return;
        }
        _ => {}
    }
    if next.level >= DEEPEST {
        beyond(survey, piece, &next, known);
        return;
    }
    // Step 3: quarter the piece, with the trim segments that still cross it.
    let border = match location {
        CellLocation::Border(segments) => Some(segments),
        _ => None,
    };
    if border.is_none() {
        next.border = None;
    }
    let by = next.poses.first().and_then(|pose| dividing(survey, piece, known.aim(), pose));
    halve(next, border, by, open);
}

/// Tries larger bounds until one holds.
fn beyond(survey: &TileSurvey<'_>, piece: &FlatCell, next: &ExcessCell, known: &mut TileBound) {
    for doubling in 1..DOUBLINGS {
        // Doubling the margin finds a provable bound within a factor of two.
        let height = known.worst.max(0.0) + known.margin() * 2f64.powi(doubling);
        if height > survey.parts.scope.reach {
            break;
        }
        if next.poses.iter().any(|pose| clears(survey, piece, height, pose))
            || next.found.is_some_and(|pose| passes(survey, piece, height, &pose))
        {
            known.accept(height);
            return;
        }
    }
    known.open += piece.area();
}

/// Returns the bodies that may come to a piece, lowest first.
fn coming(survey: &TileSurvey<'_>, piece: &FlatCell, items: &[ContentId]) -> Rc<[ContentId]> {
    let bundle = piece.bundle();
    let keeps = |&numbers: &ContentId| {
        Some((survey.parts.comes(numbers, &bundle, survey.task.top)?, numbers))
    };
    let mut coming: Vec<(f64, ContentId)> = items.iter().filter_map(keeps).collect();
    coming.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    coming.into_iter().map(|(_, numbers)| numbers).collect()
}
