//! A tool holds each piece of the face moved outwards.

use super::super::body::Ray;
use super::super::ray::Deciding;
use super::super::report::{Extreme, Sample};
use super::shape::{Cell, Rectangle, quarters};
use super::{Known, Place, Survey, TILE};
use std::rc::Rc;

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
    /// What may come to it.
    items: Rc<[(u32, u32)]>,
    /// Trim segments that may touch it.
    border: Option<Vec<u32>>,
}

/// The highest excess in a tile, bounded by `most` pieces.
pub(super) fn tile(survey: &Survey<'_>, at: [usize; 2], most: usize) -> Known {
    let mut known = survey.start[1];
    let mut open = Vec::new();
    let items: Rc<[(u32, u32)]> = survey.parts.numbers().collect();
    let [rows, columns] = [survey.map.u.len(), survey.map.v.len()];
    for i in at[0]..(at[0] + TILE).min(rows.saturating_sub(1)) {
        for j in at[1]..(at[1] + TILE).min(columns.saturating_sub(1)) {
            cell(survey, [i, j], &items, &mut open);
        }
    }
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
        search(survey, (next, &piece), (&mut known, &mut open));
    }
    known
}

/// The pieces of a grid cell, with the poses that decided at its corners. Cells with a corner that is
/// uncut, and those that meet the rest, are told as such and left out.
fn cell(survey: &Survey<'_>, [i, j]: [usize; 2], items: &Rc<[(u32, u32)]>, open: &mut Vec<Open>) {
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
        let (poses, items) = (poses.clone(), Rc::clone(items));
        open.push(Open { rectangle, level: 0, poses, items, border });
    }
}

/// Whether a pose holds all of a piece moved outwards by `height`: a convex body does if it holds the
/// corners of the plane piece with room for what the piece may differ from it.
fn holds(survey: &Survey<'_>, cell: &Cell, height: f64, pose: &Deciding) -> bool {
    let Some(body) = survey.parts.body(pose.body) else { return false };
    let stand = pose.stand;
    let room = cell.bulge + height * cell.turn + survey.parts.look.error();
    let [a, b] = cell.half;
    let middle = cell.centre + cell.normal * height - stand.tip;
    [a + b, a - b, b - a, -a - b]
        .iter()
        .all(|corner| body.probe(&(middle + corner), &stand.axis).distance <= -room)
}

fn halve(next: Open, border: Option<Vec<u32>>, open: &mut Vec<Open>) {
    if next.level >= DEEPEST {
        return;
    }
    let border = border.or(next.border);
    for rectangle in quarters(next.rectangle) {
        let (poses, items) = (next.poses.clone(), Rc::clone(&next.items));
        let (level, border) = (next.level + 1, border.clone());
        open.push(Open { rectangle, level, poses, items, border });
    }
}

/// Looks for the pose that comes lowest in the middle of a piece, and quarters the piece if that does
/// not hold it.
fn search(
    survey: &Survey<'_>,
    (mut next, piece): (Open, &Cell),
    (known, open): (&mut Known, &mut Vec<Open>),
) {
    let place = survey.place(&next.rectangle, next.border.as_deref());
    if matches!(place, Place::Outside) {
        return;
    }
    let ray = Ray { origin: piece.centre, normal: piece.normal, below: survey.parts.look.reach };
    next.items = coming(survey, piece, &next.items);
    let lowest = survey.parts.lowest(next.items.iter().copied(), &ray);
    let inside = survey.holds_middle(&next.rectangle, &place);
    if inside && lowest.s > survey.top {
        known.short = true;
        open.clear();
        return;
    }
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
        if height > survey.parts.look.reach {
            break;
        }
        if poses.iter().any(|pose| holds(survey, piece, height, pose)) {
            known.beyond = known.beyond.max(height);
            return;
        }
    }
    known.open += piece.area();
}

/// What of some may come to a piece, lowest first.
fn coming(survey: &Survey<'_>, piece: &Cell, items: &[(u32, u32)]) -> Rc<[(u32, u32)]> {
    let disc = piece.disc();
    let keeps =
        |&numbers: &(u32, u32)| Some((survey.parts.comes(numbers, &disc, survey.top)?, numbers));
    let mut coming: Vec<(f64, (u32, u32))> = items.iter().filter_map(keeps).collect();
    coming.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    coming.into_iter().map(|(_, numbers)| numbers).collect()
}
