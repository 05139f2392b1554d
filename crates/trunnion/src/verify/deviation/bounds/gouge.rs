//! No tool comes to the face moved inwards.

use super::shape::{FlatCell, UvRectangle, quarters};
use super::{CellLocation, TILE, TileBound, TileSurvey};
use crate::verify::deviation::chunks::MoveKind;
use crate::verify::report::Extreme;
use crate::verify::swept::quadratic::{DistanceMargin, SurfacePatch};
use crate::verify::swept::tool::NormalRay;

/// Quarterings after which the height in the middle of a piece is measured, where no answer came.
const MEASURED_FROM: u32 = 3;
/// Quarterings after which a larger bound is tried: pieces are some 1e-6 of a cell then.
const DEEPEST: u32 = 20;
/// Halvings of a piece of a move at most.
const SHORTEST: f64 = 1e-6;
/// Doublings of the bound at most.
const DOUBLINGS: i32 = 24;

/// A body over a stretch of a piece of a move: numbers, middle, half width.
type OpenBody = ((u32, u32), f64, f64);

/// A piece of the face and what may come to it.
struct GougeCell {
    rectangle: UvRectangle,
    level: u32,
    items: Vec<OpenBody>,
    /// Trim segments that may touch it.
    border: Option<Vec<u32>>,
}

/// The deepest gouge in a tile, bounded by `most` pieces.
pub(crate) fn tile(survey: &TileSurvey<'_>, at: [usize; 2], most: usize) -> TileBound {
    let mut known = survey.start[0];
    let Some(whole) = survey.rectangle(at, TILE) else { return known };
    let mut open: Vec<GougeCell> = survey
        .shape
        .smooth_parts(whole)
        .into_iter()
        .filter_map(|rectangle| first(survey, rectangle))
        .collect();
    let mut count = 0;
    while let Some(next) = open.pop() {
        count += 1;
        if count > most {
            known.end(area(survey, &next.rectangle));
            continue;
        }
        quarter(survey, next, &mut known, &mut open);
    }
    known
}

fn area(survey: &TileSurvey<'_>, rectangle: &UvRectangle) -> f64 {
    survey.shape.cell(rectangle).map_or(0.0, |cell| cell.area())
}

/// A piece with all that comes near the tile.
fn first(survey: &TileSurvey<'_>, rectangle: UvRectangle) -> Option<GougeCell> {
    let border = match survey.first_place(&rectangle) {
        CellLocation::Outside => return None,
        CellLocation::Inside => None,
        CellLocation::Border(segments) => Some(segments),
    };
    let items = survey.parts.numbers().map(|numbers| (numbers, 0.0, 1.0)).collect();
    Some(GougeCell { rectangle, level: 0, items, border })
}

/// Drops a piece to which nothing comes, or quarters it.
fn quarter(
    survey: &TileSurvey<'_>,
    next: GougeCell,
    known: &mut TileBound,
    open: &mut Vec<GougeCell>,
) {
    let GougeCell { rectangle, level, items, border } = next;
    let place = survey.place(&rectangle, border.as_deref());
    if matches!(place, CellLocation::Outside) {
        return;
    }
    let mut left = items;
    if let Some(cell) = survey.shape.cell(&rectangle) {
        left = coming(survey, &cell, known.aim(), &left);
        if left.is_empty() {
            return;
        }
        if level >= MEASURED_FROM && survey.holds_middle(&rectangle, &place) {
            measure(survey, (&cell, &rectangle), &left, known);
        }
        if level >= DEEPEST {
            beyond(survey, &cell, &left, known);
            return;
        }
    } else if level >= DEEPEST {
        // A point without a normal; the pieces around it are all certain.
        return;
    }
    let border = match place {
        CellLocation::Border(segments) => Some(segments),
        _ => None,
    };
    for rectangle in quarters(rectangle) {
        let (items, border) = (left.clone(), border.clone());
        open.push(GougeCell { rectangle, level: level + 1, items, border });
    }
}

/// Which of the stretches may come to a piece moved inwards by `depth`, cut to where they may.
fn coming(
    survey: &TileSurvey<'_>,
    cell: &FlatCell,
    depth: f64,
    items: &[OpenBody],
) -> Vec<OpenBody> {
    let slack = depth * cell.turn;
    let patch = SurfacePatch {
        centre: cell.centre - cell.normal * depth,
        half: &cell.half,
        bulge: cell.bulge + slack,
        radius: cell.radius() + slack,
        normal: cell.normal,
    };
    let mut left = Vec::new();
    let mut stretches = Vec::new();
    let error = survey.parts.look.error();
    for &(numbers, u, half) in items {
        let Some(part) = survey.parts.part(numbers) else { continue };
        stretches.push((u, half));
        while let Some((u, half)) = stretches.pop() {
            let instant = part.piece.instant(u);
            let near = part.piece.keeps_off(&instant, half, part.body, &patch);
            if near.least() > error {
                continue;
            }
            let flat = part.piece.keeps_above(&instant, half, part.body, &patch);
            if flat.least() > error {
                continue;
            }
            let DistanceMargin { place, time, .. } =
                if flat.least() > near.least() { flat } else { near };
            if place >= time || half < SHORTEST {
                left.push((numbers, u, half));
            } else {
                stretches.extend([(u - 0.5 * half, 0.5 * half), (u + 0.5 * half, 0.5 * half)]);
            }
        }
    }
    left
}

/// Measures the height in the middle of a piece, against what may come to it.
fn measure(
    survey: &TileSurvey<'_>,
    (cell, rectangle): (&FlatCell, &UvRectangle),
    items: &[OpenBody],
    known: &mut TileBound,
) {
    let below = survey.parts.look.reach;
    let ray = NormalRay { origin: cell.centre, normal: cell.normal, below };
    let lowest = survey.parts.lowest(items.iter().map(|item| item.0), &ray);
    if let (Some(line), true) = (lowest.line, -lowest.s > known.worst) {
        known.worst = -lowest.s;
        let uv = rectangle.map(|[low, high]| 0.5 * (low + high));
        let face = survey.map.face;
        known.place = Some(Extreme {
            face,
            uv,
            point: cell.centre,
            height: lowest.s,
            or_deeper: false,
            line,
            dog_leg: survey.parts.look.moves == MoveKind::DogLegs,
        });
    }
}

/// Looks for a larger bound that holds.
fn beyond(survey: &TileSurvey<'_>, cell: &FlatCell, items: &[OpenBody], known: &mut TileBound) {
    for doubling in 1..DOUBLINGS {
        let depth = known.worst.max(0.0) + known.margin() * 2f64.powi(doubling);
        if depth > survey.parts.look.reach {
            break;
        }
        if coming(survey, cell, depth, items).is_empty() {
            known.beyond = known.beyond.max(depth);
            return;
        }
    }
    known.open += cell.area();
}
