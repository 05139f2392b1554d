//! What holds between the measured points: a bound of the deepest gouge and of the highest excess over
//! a whole face.
//!
//! `h >= -G` everywhere if no tool ever comes to the face moved inwards by `G`: a tool that is convex,
//! holds a point of the face and gets below `-G` on its normal is at `-G` as well. `h <= E` over a
//! piece of the face if one tool, at one instant, holds the whole piece moved outwards by `E`, or holds one place of it
//! after the other while it moves. Both are
//! asked of pieces that are planes to within a known error, and pieces are quartered as far as they
//! tell.

mod excess;
mod gather;
mod gouge;
mod shape;

use super::chunks::{ChunkMotion, MotionChunks};
use super::map::Measured;
use super::ray::DecidingPose;
use crate::surface::Face;
use crate::verify::VerifyError;
use crate::verify::report::{Bounds, Extreme, FaceMap};
use shape::{FaceShape, TrimCrossing, TrimSegments, UvRectangle};

/// Cells along the side of a tile.
const TILE: usize = 8;
/// Pieces looked at in every tile, for each of both bounds: several times what a tile takes on average where strips of
/// round corners meet.
const FEW_PIECES: usize = 400;
/// Pieces for tiles that take more, together: about half a minute of one core. What a sharp edge leaves where one move
/// meets the next is held only in pieces as small as micrometres, and a face full of that is not worth hours.
const ALL_PIECES: usize = 1_500_000;
/// The same of one tile; more only where the bound cannot come near the truth.
const MOST_PIECES: usize = 60_000;
/// Share of a cell's parameters to which trims are followed.
const TRIM_SHARE: f64 = 1e-3;
/// Least share of the margin that is used where the tolerance leaves less room.
const LEAST_MARGIN: f64 = 0.05;
/// And least part of it by that with which heights are measured: what is deeper than the bound must be seen to be deeper
/// than the worst place known, which takes one such tolerance and a fifth.
const LEAST_TOLERANCES: f64 = 2.0;
/// Share of what a tolerance is exceeded by, as margin of the bound.
const BROKEN_SHARE: f64 = 0.1;

/// How far a bound may be from the worst place known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MarginRule {
    /// At most, while the tolerance is kept \[mm\].
    pub(crate) margin: f64,
    /// What the worst place is to keep \[mm\].
    pub(crate) tolerance: f64,
    /// How exactly heights are measured \[mm\].
    pub(crate) exact: f64,
}

impl MarginRule {
    /// Where the tolerance is kept, so should the bound be; where it is broken, the first digits will do. With it
    /// the bound rises no less than the worst place does.
    fn margin(&self, worst: f64) -> f64 {
        let (Self { margin, .. }, room) = (*self, self.tolerance - worst.max(0.0));
        let least = (LEAST_MARGIN * margin).max(LEAST_TOLERANCES * self.exact).min(margin);
        let share = margin.min(0.5 * room).max(least);
        if room > 0.0 { share } else { margin.max(-BROKEN_SHARE * room) }
    }
}

/// What is promised so far: the worst heights known, and what is certain.
#[derive(Debug, Clone, Copy)]
struct TileBound {
    /// The worst place known \[mm\]: how far out of the way of 0.
    worst: f64,
    /// How far the bound may be from it.
    room: MarginRule,
    /// Bound where that was not enough.
    beyond: f64,
    /// The worst place, if it is new.
    place: Option<Extreme>,
    /// Area of which nothing is certain \[mm²\].
    open: f64,
    /// Whether some of that was not looked at any more.
    ended: bool,
    /// Whether moves that keep farther off than those that were looked at may count.
    short: bool,
}

impl TileBound {
    fn new(worst: f64, room: MarginRule) -> Self {
        Self { worst, room, beyond: 0.0, place: None, open: 0.0, ended: false, short: false }
    }

    /// A piece that is not looked at any more.
    fn end(&mut self, area: f64) {
        self.open += area;
        self.ended = true;
    }

    /// What is added to the worst place for the bound \[mm\].
    fn margin(&self) -> f64 {
        self.room.margin(self.worst)
    }

    /// What is tried next.
    fn aim(&self) -> f64 {
        (self.worst + self.margin()).max(0.0)
    }

    /// What is certain.
    fn bound(&self) -> f64 {
        self.aim().max(self.beyond)
    }

    fn join(mut self, other: &Self) -> Self {
        if other.worst > self.worst {
            (self.worst, self.place) = (other.worst, other.place);
        }
        self.beyond = self.beyond.max(other.beyond);
        self.open += other.open;
        self
    }
}

/// A face with what was measured on it.
struct MeasuredFace<'a> {
    shape: FaceShape<'a>,
    trims: TrimSegments,
    map: &'a FaceMap,
    deciding: &'a [Option<DecidingPose>],
    /// The worst gouge and excess known at the start.
    start: [TileBound; 2],
    excess: bool,
}

/// A tile of a face, with the moves that come to it.
struct TileSurvey<'a> {
    ground: &'a MeasuredFace<'a>,
    parts: ChunkMotion,
    /// Moves that get no lower than this over the face may be missing \[mm\].
    top: f64,
}

impl<'a> std::ops::Deref for TileSurvey<'a> {
    type Target = MeasuredFace<'a>;

    fn deref(&self) -> &MeasuredFace<'a> {
        self.ground
    }
}

/// Where a piece of a face lies.
enum CellLocation {
    Inside,
    Outside,
    /// These trim segments run through it.
    Border(Vec<u32>),
}

impl MeasuredFace<'_> {
    /// Where a rectangle lies; `among` are the trim segments that may touch it, `None` if none does.
    fn place(&self, rectangle: &UvRectangle, among: Option<&[u32]>) -> CellLocation {
        let Some(among) = among else { return CellLocation::Inside };
        let [u, v] = rectangle.map(|[low, high]| 0.5 * (low + high));
        match self.trims.side(rectangle, Some(among)) {
            TrimCrossing::Border(segments) => CellLocation::Border(segments),
            TrimCrossing::Clear if self.shape.face.contains(u, v) => CellLocation::Inside,
            TrimCrossing::Clear => CellLocation::Outside,
        }
    }

    /// The same of a rectangle of which nothing is known yet.
    fn first_place(&self, rectangle: &UvRectangle) -> CellLocation {
        if self.shape.face.loops.is_empty() {
            return CellLocation::Inside;
        }
        match self.trims.side(rectangle, None) {
            TrimCrossing::Border(segments) => CellLocation::Border(segments),
            TrimCrossing::Clear => self.place(rectangle, Some(&[])),
        }
    }

    /// Whether the middle of a rectangle is on the face.
    fn holds_middle(&self, rectangle: &UvRectangle, place: &CellLocation) -> bool {
        let [u, v] = rectangle.map(|[low, high]| 0.5 * (low + high));
        match place {
            CellLocation::Inside => true,
            CellLocation::Outside => false,
            CellLocation::Border(_) => self.shape.face.contains(u, v),
        }
    }

    fn tiles(&self) -> Vec<[usize; 2]> {
        let [rows, columns] = [self.map.u.len(), self.map.v.len()].map(|n| n.saturating_sub(1));
        let along = |i: usize| (0..columns).step_by(TILE).map(move |j| [i, j]);
        (0..rows).step_by(TILE).flat_map(along).collect()
    }

    /// Parameters of a range of cells.
    fn rectangle(&self, [i, j]: [usize; 2], count: usize) -> Option<UvRectangle> {
        let range = |values: &[f64], first: usize| {
            let last = (first + count).min(values.len().saturating_sub(1));
            Some([*values.get(first)?, *values.get(last)?])
        };
        Some([range(&self.map.u, i)?, range(&self.map.v, j)?])
    }
}

/// Bounds the deviation over faces of which the maps are given; the worst places that turn up on the
/// way are told as well.
pub(crate) fn of(
    chunks: &MotionChunks<'_>,
    faces: &[Face],
    measured: &[Measured],
    (rooms, excess): ([MarginRule; 2], bool),
    extremes: [Option<f64>; 2],
) -> Result<(Bounds, [Option<Extreme>; 2]), VerifyError> {
    let ([low, high], [deep, tall], bounded) = (extremes, rooms, excess);
    let start = [
        TileBound::new(low.map_or(0.0, |height| -height), deep),
        TileBound::new(high.unwrap_or(0.0), tall),
    ];
    let mut known = start;
    let mut grounds = Vec::new();
    for (face, (map, deciding)) in faces.iter().zip(measured) {
        let shape = FaceShape::new(face);
        let tolerance = [&map.u, &map.v].map(|values| {
            let width = values.last().unwrap_or(&0.0) - values.first().unwrap_or(&0.0);
            TRIM_SHARE * width / values.len().max(2) as f64
        });
        let trims = TrimSegments::new(face, tolerance)?;
        grounds.push(MeasuredFace { shape, trims, map, deciding, start, excess: bounded });
    }
    for [gouge, excess] in &all(chunks, &grounds)? {
        known = [known[0].join(gouge), known[1].join(excess)];
    }
    let [gouge, excess] = known;
    let bounds = Bounds {
        gouge: gouge.bound(),
        excess: bounded.then(|| excess.bound()),
        open: if bounded { gouge.open.max(excess.open) } else { gouge.open },
    };
    Ok((bounds, [gouge.place, excess.place]))
}

/// A tile to be looked at: of which face, where, how many pieces of it at most, and up to which height moves count.
#[derive(Clone, Copy)]
struct TileTask<'a> {
    ground: &'a MeasuredFace<'a>,
    at: [usize; 2],
    most: usize,
    top: f64,
}

/// All tiles of all faces: those of a face that take many pieces share what there is for them.
fn all(
    chunks: &MotionChunks<'_>,
    grounds: &[MeasuredFace<'_>],
) -> Result<Vec<[TileBound; 2]>, VerifyError> {
    let mut tasks = Vec::new();
    for ground in grounds {
        let top = ground.top(chunks.look.reach);
        tasks.extend(ground.tiles().into_iter().map(|at| TileTask {
            ground,
            at,
            most: FEW_PIECES,
            top,
        }));
    }
    let mut tiles = look(chunks, &mut tasks)?;
    let ended = |tile: &[TileBound; 2]| tile.iter().any(|known| known.ended);
    let mut again = Vec::new();
    for ground in grounds {
        let of = |(task, tile): &(&TileTask<'_>, &[TileBound; 2])| {
            std::ptr::eq(task.ground, ground) && ended(tile)
        };
        let count = tasks.iter().zip(&tiles).filter(of).count();
        let most = MOST_PIECES.min(ALL_PIECES / count.max(1));
        if most > FEW_PIECES {
            let places = tasks.iter().zip(&tiles).enumerate().filter(|(_, pair)| of(pair));
            again.extend(places.map(|(index, (task, _))| (index, TileTask { most, ..*task })));
        }
    }
    let (places, mut more): (Vec<usize>, Vec<TileTask<'_>>) = again.into_iter().unzip();
    for (index, known) in places.into_iter().zip(look(chunks, &mut more)?) {
        if let Some(tile) = tiles.get_mut(index) {
            *tile = known;
        }
    }
    Ok(tiles)
}

/// Looks at tiles; where higher moves may count, with all that come within reach.
fn look(
    chunks: &MotionChunks<'_>,
    tasks: &mut [TileTask<'_>],
) -> Result<Vec<[TileBound; 2]>, VerifyError> {
    let mut tiles = gather::each(chunks, tasks)?;
    let short = |tile: &[TileBound; 2]| tile.iter().any(|known| known.short);
    let mut higher = Vec::new();
    for (index, (task, tile)) in tasks.iter_mut().zip(&tiles).enumerate() {
        if short(tile) {
            task.top = chunks.look.reach;
            higher.push((index, *task));
        }
    }
    let (places, higher): (Vec<usize>, Vec<TileTask<'_>>) = higher.into_iter().unzip();
    let found = gather::each(chunks, &higher)?;
    for (index, known) in places.into_iter().zip(found) {
        if let Some(tile) = tiles.get_mut(index) {
            *tile = known;
        }
    }
    Ok(tiles)
}

impl MeasuredFace<'_> {
    /// Moves that get no lower are not looked at before it turns out that they count \[mm\].
    fn top(&self, reach: f64) -> f64 {
        let start = &self.start[1];
        if self.excess { reach.min(2.0 * start.aim() + start.margin()) } else { 0.0 }
    }

    /// What is known of a tile to which more moves come than can be looked at.
    fn crowded(&self, at: [usize; 2]) -> [TileBound; 2] {
        let area = |rectangle: &UvRectangle| self.shape.cell(rectangle).map_or(0.0, |c| c.area());
        let parts = self.rectangle(at, TILE).map(|whole| self.shape.smooth_parts(whole));
        let area = parts.iter().flatten().map(area).sum();
        self.start.map(|mut known| {
            known.end(area);
            known
        })
    }
}

impl TileSurvey<'_> {
    fn tile(&self, task: &TileTask<'_>) -> [TileBound; 2] {
        let gouge = gouge::tile(self, task.at, task.most);
        let excess =
            if self.excess { excess::tile(self, task.at, task.most) } else { self.start[1] };
        [gouge, excess]
    }
}
