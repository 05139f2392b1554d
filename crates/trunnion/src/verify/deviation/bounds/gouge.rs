//! Upper bound on gouge depth: proves that no tool position reaches the face offset inwards by the bound.

use super::margin::TileBound;
use super::shape::{FlatCell, UvRectangle, quarters};
use super::survey::{CellLocation, TileSurvey, TileTask};
use crate::verify::deviation::chunks::MoveKind;
use crate::verify::report::ExtremeHeight;
use crate::verify::swept::bvh::ContentId;
use crate::verify::swept::quadratic::{DistanceMargin, PatchPart, SurfacePatch};
use crate::verify::swept::tool::{BodySurface, DepthRule, NormalRay};

/// Quarterings after which the height in the middle of an undecided piece is measured.
const MEASURED_FROM: u32 = 3;
/// Quarterings after which a piece that stays open counts as touched; it is then some micrometres wide.
const TOUCHED_FROM: u32 = 10;
/// Quarterings after which a larger bound is tried; a piece is then some 1e-6 of a cell.
const DEEPEST: u32 = 20;
/// Trim segments in a piece up to which its part inside them is bounded: the bodies are compared with each.
const FEW_SEGMENTS: usize = 24;
/// Shortest half interval of time in a search: a millionth of the piece.
const SHORTEST: f64 = 1e-6;
/// Most doublings of the bound.
const DOUBLINGS: i32 = 24;

/// Body over an interval of time that may come to a piece of the face.
#[derive(Clone, Copy)]
struct OpenBody {
    numbers: ContentId,
    /// Middle of the interval.
    u: f64,
    /// Half its length.
    half: f64,
}

/// Piece of the face with the bodies that may come to it.
struct GougeCell {
    rectangle: UvRectangle,
    level: u32,
    items: Vec<OpenBody>,
    /// Trim segments that may touch it.
    border: Option<Vec<u32>>,
    /// Rule for the depth at all its points.
    rule: DepthRule,
}

/// Bounds the deepest gouge in a tile.
pub(crate) fn tile(survey: &TileSurvey<'_>) -> TileBound {
    // Start from the worst gouge known: the aim of the proof is a margin deeper.
    let TileTask { cells, start: [mut known, _], most, .. } = survey.task;
    let Some(whole) = survey.rectangle(cells) else { return known };
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
            if !known.relax(&survey.worst[0]) {
                known.end(area(survey, &next.rectangle));
                continue;
            }
            count = 0;
        }
        quarter(survey, next, &mut known, &mut open);
    }
    known
}

fn area(survey: &TileSurvey<'_>, rectangle: &UvRectangle) -> f64 {
    survey.shape.cell(rectangle).map_or(0.0, |cell| cell.area())
}

/// Returns a piece of the tile with everything that comes near the tile.
fn first(survey: &TileSurvey<'_>, rectangle: UvRectangle) -> Option<GougeCell> {
    let border = match survey.locate_any(&rectangle) {
        CellLocation::Outside => return None,
        CellLocation::Inside => None,
        CellLocation::Border(segments) => Some(segments),
    };
    let items =
        survey.parts.numbers().map(|numbers| OpenBody { numbers, u: 0.0, half: 1.0 }).collect();
    Some(GougeCell { rectangle, level: 0, items, border, rule: DepthRule::AlongNormal })
}

/// Drops a piece that nothing reaches, or quarters it.
fn quarter(
    survey: &TileSurvey<'_>,
    next: GougeCell,
    known: &mut TileBound,
    open: &mut Vec<GougeCell>,
) {
    let GougeCell { rectangle, level, items, border, mut rule } = next;
    let location = survey.locate(&rectangle, border.as_deref());
    if matches!(location, CellLocation::Outside) {
        return;
    }
    let mut left = items;
    if let Some(cell) = survey.shape.cell(&rectangle) {
        // What holds for all points of a piece holds for its quarters.
        if rule == DepthRule::AlongNormal {
            rule = survey.depth_rule(middle_of(&rectangle), cell.half.map(|half| half.norm()));
        }
        // Nothing comes to the piece offset inwards by the aim: no gouge in it is deeper.
        let part = match &location {
            CellLocation::Border(segments) if segments.len() <= FEW_SEGMENTS => {
                Some(survey.trims.part(survey.shape.face, &rectangle, segments))
            }
            _ => None,
        };
        let face = FacePiece { cell: &cell, part: part.as_ref(), rule };
        left = coming(survey, &face, known.aim(), &left);
        if left.is_empty() {
            return;
        }
        // A piece that stays open may hold a deeper gouge than known: measuring it raises the aim. A tool beside the next
        // face goes deepest into this one at the border.
        if level >= MEASURED_FROM {
            let middle = survey.holds_middle(&rectangle, &location).then(|| middle_of(&rectangle));
            let rim = match (&location, rule) {
                (CellLocation::Border(segments), DepthRule::InsideTool) => {
                    survey.trims.just_inside(survey.shape.face, &rectangle, segments)
                }
                _ => None,
            };
            for uv in [middle, rim].into_iter().flatten() {
                measure(survey, uv, &left, known);
            }
        }
        // A tool that goes in as deep as the search reaches, or almost, may go deeper: no smaller piece shows how deep.
        if level >= MEASURED_FROM && known.aim() > survey.parts.scope.reach {
            known.open += cell.area();
            return;
        }
        if level >= TOUCHED_FROM {
            known.allow_touch();
        }
        if level >= DEEPEST {
            beyond(survey, &face, &left, known);
            return;
        }
    } else if level >= DEEPEST {
        // A singular point without a normal; the pieces around it are all proven.
        return;
    }
    let border = match location {
        CellLocation::Border(segments) => Some(segments),
        _ => None,
    };
    for rectangle in quarters(rectangle) {
        let (items, border) = (left.clone(), border.clone());
        open.push(GougeCell { rectangle, level: level + 1, items, border, rule });
    }
}

/// Flat piece of the face, and the part of it inside the trims where they cross it.
#[derive(Clone, Copy)]
struct FacePiece<'a> {
    cell: &'a FlatCell,
    part: Option<&'a PatchPart>,
    rule: DepthRule,
}

/// Returns the middle of a rectangle.
fn middle_of(rectangle: &UvRectangle) -> [f64; 2] {
    rectangle.map(|[low, high]| 0.5 * (low + high))
}

/// Returns the bodies that may come to a piece offset inwards by `depth`, their times cut to where they may.
fn coming(
    survey: &TileSurvey<'_>,
    face: &FacePiece<'_>,
    depth: f64,
    items: &[OpenBody],
) -> Vec<OpenBody> {
    let FacePiece { cell, part, rule } = *face;
    // Offset inwards, a point is off the flat piece by the turn of its normal times the depth as well.
    let slack = depth * cell.turn;
    let patch = SurfacePatch {
        centre: cell.centre - cell.normal * depth,
        half: &cell.half,
        bulge: cell.bulge + slack,
        radius: cell.radius() + slack,
        normal: cell.normal,
        part,
    };
    let surface =
        SurfacePatch { centre: cell.centre, bulge: cell.bulge, radius: cell.radius(), ..patch };
    let mut left = Vec::new();
    let mut intervals = Vec::new();
    let error = survey.parts.scope.error();
    for &OpenBody { numbers, u, half } in items {
        let Some(part) = survey.parts.part(numbers) else { continue };
        intervals.push((u, half));
        while let Some((u, half)) = intervals.pop() {
            let instant = part.piece.instant(u);
            // Two lower bounds of the distance: the gradient at the nearest point, and the support plane across the
            // patch. Either one above the error drops the interval.
            let body = BodySurface::Whole(part.body);
            let near = part.piece.keeps_off(&instant, half, body, &patch);
            if near.least() > error {
                continue;
            }
            let flat = part.piece.keeps_above(&instant, half, part.body, &patch);
            if flat.least() > error {
                continue;
            }
            let off = |body| part.piece.keeps_off(&instant, half, body, &surface);
            let inside = match rule {
                // At an edge it is enough that no point of the piece lies deeper in the tool.
                DepthRule::InsideTool => {
                    let skin = off(BodySurface::Skin(part.body));
                    Some(DistanceMargin { distance: skin.distance + depth, ..skin })
                }
                // Elsewhere it is enough that the tool holds no point of the piece: if it is in the material below all the
                // same, it came there through another face, and gouges that one.
                DepthRule::AlongNormal => {
                    let bodies = survey.parts.tool_of(part.piece);
                    let offs = bodies.map(|body| off(BodySurface::Whole(body)));
                    offs.min_by(|a, b| a.least().total_cmp(&b.least()))
                }
            };
            if inside.as_ref().is_some_and(|inside| inside.least() > error) {
                continue;
            }
            // Bisect time where that alone will do, or gains more than quartering the face would. The second bound does
            // not grow with either beyond its distance.
            let proves = |margin: &DistanceMargin| margin.distance - margin.extent > error;
            // Where the tool holds the middle of the piece all the time, no part of the time proves more: under a flat end,
            // distances change neither with time nor over a plane face.
            let gains = near.time > near.spread.max(error) && near.distance + near.time > error;
            let by_time =
                proves(&near) || proves(&flat) || inside.as_ref().is_some_and(proves) || gains;
            if !by_time || half < SHORTEST {
                left.push(OpenBody { numbers, u, half });
            } else {
                intervals.extend([(u - 0.5 * half, 0.5 * half), (u + 0.5 * half, 0.5 * half)]);
            }
        }
    }
    left
}

/// Measures the height at a point against the bodies that may come to it, where it is deeper than the worst known.
///
/// A tool that gouges many points of a tile is searched once for each; only what gouges deeper matters.
fn measure(survey: &TileSurvey<'_>, uv: [f64; 2], items: &[OpenBody], known: &mut TileBound) {
    let (below, face) = (survey.parts.scope.reach, survey.shape.face);
    let Some(normal) = face.normal(uv[0], uv[1]) else { return };
    let (origin, normal) = (face.point(uv[0], uv[1]), normal.into_inner());
    let ray = NormalRay { origin, normal, below, rule: survey.depth_rule(uv, [0.0; 2]) };
    // A body has as many intervals as times at which it may come: it is searched once.
    let bodies = items.chunk_by(|a, b| a.numbers == b.numbers).filter_map(|one| one.first());
    let numbers = bodies.map(|item| item.numbers);
    let lowest = survey.parts.lowest_below(-known.worst, numbers, &ray);
    if let (Some(line), true) = (lowest.line, -lowest.s > known.worst) {
        known.worst = -lowest.s;
        known.extreme = Some(ExtremeHeight {
            face: survey.map.face,
            uv: uv.into(),
            point: ray.origin,
            height: lowest.s,
            or_deeper: false,
            line,
            dog_leg: survey.parts.scope.moves == MoveKind::DogLegs,
        });
    }
}

/// Tries larger bounds until one holds.
fn beyond(
    survey: &TileSurvey<'_>,
    face: &FacePiece<'_>,
    items: &[OpenBody],
    known: &mut TileBound,
) {
    for doubling in 1..DOUBLINGS {
        let depth = known.worst.max(0.0) + known.margin() * 2f64.powi(doubling);
        // Beyond the search range moves were not gathered: no proof is possible there.
        if depth > survey.parts.scope.reach {
            break;
        }
        if coming(survey, face, depth, items).is_empty() {
            known.accept(depth);
            return;
        }
    }
    known.open += face.cell.area();
}
