//! A tool holds each piece of the face moved outwards.

use super::super::body::Ray;
use super::super::deviation::Around;
use super::super::index::Bounds;
use super::super::ray::Deciding;
use super::super::report::{Extreme, Sample};
use super::shape::{Cell, Rectangle, quarters};
use super::{Known, Place, Survey, TILE};
use nalgebra::Point3;

/// Quarterings after which a larger bound is tried.
const DEEPEST: u32 = 14;
/// Doublings of the bound at most.
const DOUBLINGS: i32 = 24;
/// Poses tried on one piece: those that decided nearest to it.
const MOST_POSES: usize = 6;

/// A piece of the face and poses that may hold it.
struct Open {
    rectangle: Rectangle,
    level: u32,
    poses: Vec<Deciding>,
    /// Trim segments that may touch it.
    border: Option<Vec<u32>>,
}

/// The highest excess in a tile, bounded by `most` pieces.
pub(super) fn tile(survey: &Survey<'_>, at: [usize; 2], most: usize) -> Known {
    let mut known = survey.start[1];
    let mut open = Vec::new();
    let [rows, columns] = [survey.map.u.len(), survey.map.v.len()];
    for i in at[0]..(at[0] + TILE).min(rows.saturating_sub(1)) {
        for j in at[1]..(at[1] + TILE).min(columns.saturating_sub(1)) {
            cell(survey, [i, j], &mut open);
        }
    }
    let mut around = None;
    let mut count = 0;
    while let Some(next) = open.pop() {
        count += 1;
        let Some(piece) = survey.shape.cell(&next.rectangle) else {
            halve(next, None, &mut open);
            continue;
        };
        if next.poses.iter().any(|pose| holds(survey, &piece, known.aim(), pose)) {
            continue;
        }
        if count > most {
            known.end(piece.area());
            continue;
        }
        let around = around.get_or_insert_with(|| nearby(survey, at));
        search(survey, (next, &piece), around, (&mut known, &mut open));
    }
    known
}

/// The pieces of a grid cell, with the poses that decided at its corners. Cells with a corner that is
/// uncut, and those that meet the rest, are told as such and left out.
fn cell(survey: &Survey<'_>, [i, j]: [usize; 2], open: &mut Vec<Open>) {
    let columns = survey.map.v.len();
    if survey.map.unfinished.get(i * columns.saturating_sub(1) + j).is_some_and(|meets| *meets) {
        return;
    }
    let mut poses: Vec<Deciding> = Vec::new();
    for place in
        [i * columns + j, i * columns + j + 1, (i + 1) * columns + j, (i + 1) * columns + j + 1]
    {
        let sample: Option<&Sample> = survey.map.samples.get(place).and_then(Option::as_ref);
        if sample.is_some_and(|sample| sample.rest || sample.height.is_none()) {
            return;
        }
        let pose = survey.deciding.get(place).copied().flatten();
        poses.extend(pose.filter(|pose| !poses.contains(pose)));
    }
    let Some(whole) = survey.rectangle([i, j], 1) else { return };
    for rectangle in survey.shape.smooth_parts(whole) {
        let border = match survey.first_place(&rectangle) {
            Place::Outside => continue,
            Place::Inside => None,
            Place::Border(segments) => Some(segments),
        };
        open.push(Open { rectangle, level: 0, poses: poses.clone(), border });
    }
}

/// Whether a pose holds all of a piece moved outwards by `height`: a convex body does if it holds the
/// corners of the plane piece with room for what the piece may differ from it.
fn holds(survey: &Survey<'_>, cell: &Cell, height: f64, pose: &Deciding) -> bool {
    let Some(part) = survey.sweep.part((pose.piece, pose.body)) else { return false };
    let stand = part.piece.instant(pose.u).stand;
    let room = cell.bulge + height * cell.turn + survey.sweep.error();
    let [a, b] = cell.half;
    let middle = cell.centre + cell.normal * height - stand.tip;
    [a + b, a - b, b - a, -a - b]
        .iter()
        .all(|corner| part.body.probe(&(middle + corner), &stand.axis).distance <= -room)
}

fn halve(next: Open, border: Option<Vec<u32>>, open: &mut Vec<Open>) {
    if next.level >= DEEPEST {
        return;
    }
    let border = border.or(next.border);
    for rectangle in quarters(next.rectangle) {
        let (poses, border) = (next.poses.clone(), border.clone());
        open.push(Open { rectangle, level: next.level + 1, poses, border });
    }
}

/// Looks for the pose that comes lowest in the middle of a piece, and quarters the piece if that does
/// not hold it.
fn search(
    survey: &Survey<'_>,
    (mut next, piece): (Open, &Cell),
    around: &Around<'_>,
    (known, open): (&mut Known, &mut Vec<Open>),
) {
    let place = survey.place(&next.rectangle, next.border.as_deref());
    if matches!(place, Place::Outside) {
        return;
    }
    let ray = Ray { origin: piece.centre, normal: piece.normal, below: survey.sweep.reach() };
    let lowest = survey.sweep.lowest(around, &ray);
    let inside = survey.holds_middle(&next.rectangle, &place);
    match (lowest.by, lowest.line) {
        (Some(pose), Some(line)) => {
            next.poses.insert(0, pose);
            next.poses.truncate(MOST_POSES);
            if inside && lowest.s > known.worst {
                known.worst = lowest.s;
                let uv = next.rectangle.map(|[low, high]| 0.5 * (low + high));
                let (face, point) = (survey.map.face, piece.centre);
                known.place =
                    Some(Extreme { face, uv, point, height: lowest.s, or_deeper: false, line });
            }
            if holds(survey, piece, known.aim(), &pose) {
                return;
            }
        }
        // A hole between the measured points.
        _ if inside => {
            known.open += piece.area();
            return;
        }
        _ => {}
    }
    if next.level >= DEEPEST {
        beyond(survey, piece, &next.poses, known);
        return;
    }
    let border = match place {
        Place::Border(segments) => Some(segments),
        _ => None,
    };
    if border.is_none() {
        next.border = None;
    }
    halve(next, border, open);
}

/// Looks for a larger bound that holds.
fn beyond(survey: &Survey<'_>, piece: &Cell, poses: &[Deciding], known: &mut Known) {
    for doubling in 1..DOUBLINGS {
        let height = known.worst.max(0.0) + known.margin * 2f64.powi(doubling);
        if height > survey.sweep.reach() {
            break;
        }
        if poses.iter().any(|pose| holds(survey, piece, height, pose)) {
            known.beyond = known.beyond.max(height);
            return;
        }
    }
    known.open += piece.area();
}

/// All that can come near a tile.
fn nearby<'a>(survey: &Survey<'a>, at: [usize; 2]) -> Around<'a> {
    let mut region = Bounds::empty();
    let mut middle = Point3::origin();
    let reach = survey.sweep.reach();
    if let Some(whole) = survey.rectangle(at, TILE) {
        for part in survey.shape.smooth_parts(whole) {
            if let Some(cell) = survey.shape.cell(&part) {
                let here = Bounds { low: cell.centre, high: cell.centre };
                region = region.join(&here.grown(cell.radius() + reach));
                middle = cell.centre;
            }
        }
    }
    survey.sweep.around(&region, middle)
}
