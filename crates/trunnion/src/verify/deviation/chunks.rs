//! Streams the moves of a program in chunks that are ready to be measured against, so that memory does not grow with the
//! program.

use super::ray::{LowestEntry, MovingBody};
use crate::cutter::Cutter;
use crate::verify::error::VerifyError;
use crate::verify::options::CheckOptions;
use crate::verify::replay::segment::Segment;
use crate::verify::replay::segments::{Run, Segments};
use crate::verify::swept::bvh::{BoundingBox, BoxTree, ContentId, TreeItem};
use crate::verify::swept::quadratic;
use crate::verify::swept::quadratic::MotionPiece;
use crate::verify::swept::rays::RayBundle;
use crate::verify::swept::tool;
use crate::verify::swept::tool::{ConvexBody, NormalRay};
use nalgebra::Point3;
use std::ops::Range;
use std::sync::Arc;

/// Pieces of moves per chunk: some tens of megabytes.
const PIECES: usize = 32_768;
/// Chunks' worth of pieces that may be kept for closer inspection.
const KEPT: usize = 4;
/// Share of the ray tolerance that the approximation of moves by quadratics may use.
const ERROR_SHARE: f64 = 0.1;

/// Cutters in the order of the tool table, with the options of the measurement.
#[derive(Clone, Copy)]
pub(crate) struct MeasuredTools<'a> {
    pub(crate) cutters: &'a [&'a Cutter],
    pub(crate) options: &'a CheckOptions,
}

/// Kind of moves that are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MoveKind {
    /// Moves at feed: what they leave, and what they gouge.
    Cuts,
    /// Rapids with all axes together. They may gouge; nothing they cut counts as finished.
    Rapids,
    /// Rapids with each axis at its own speed; likewise.
    DogLegs,
}

/// Tools, range and accuracy of a measurement.
#[derive(Clone)]
pub(crate) struct MeasureScope {
    /// Bodies of all tools.
    bodies: Arc<[ConvexBody]>,
    /// Range of bodies of each tool in the tool table.
    of_tool: Arc<[Range<u32>]>,
    /// Depth of the search below the faces \[mm\].
    pub(crate) reach: f64,
    pub(crate) moves: MoveKind,
    /// Accuracy of measured heights \[mm\].
    pub(crate) tolerance: f64,
    /// Distance within which a cutting end counts as having cut a point that nothing cuts along the normal \[mm\].
    pub(crate) total: f64,
}

impl MeasureScope {
    fn new(tools: MeasuredTools<'_>, moves: MoveKind) -> Self {
        let (mut bodies, mut of_tool) = (Vec::new(), Vec::new());
        for cutter in tools.cutters {
            let start = narrow(bodies.len());
            bodies.extend(tool::bodies(cutter));
            of_tool.push(start..narrow(bodies.len()));
        }
        let (bodies, of_tool) = (bodies.into(), of_tool.into());
        let CheckOptions { reach, ray_tolerance: tolerance, total, .. } = *tools.options;
        // Rapids finish nothing.
        let total = if moves == MoveKind::Cuts { total } else { 0.0 };
        Self { bodies, of_tool, reach, moves, tolerance, total }
    }

    /// Returns the height of the search above the faces \[mm\].
    pub(crate) fn top(&self) -> f64 {
        if self.moves == MoveKind::DogLegs { 0.0 } else { self.reach }
    }

    /// Returns the numbers of the bodies that move in a piece.
    fn bodies_in(&self, piece: &MotionPiece) -> Range<u32> {
        self.of_tool.get(piece.tool).cloned().unwrap_or(0..0)
    }

    /// Returns a box around the rays of a bundle, from the reach below up to `top` \[mm\].
    pub(crate) fn around(&self, bundle: &RayBundle, top: f64) -> BoundingBox {
        // Every point of every ray, from the centre: across, along, and the error of the pieces.
        let far = bundle.radius + bundle.bulge + self.reach.max(top) + self.error();
        BoundingBox { low: bundle.centre, high: bundle.centre }.grown(far)
    }

    /// Returns the distance from a ray at which a moving body may still count for it \[mm\].
    pub(super) fn aside(&self) -> f64 {
        self.total.max(0.0) + self.error()
    }

    /// Returns the largest distance of the tool from its approximation by pieces \[mm\].
    pub(crate) fn error(&self) -> f64 {
        ERROR_SHARE * self.tolerance
    }
}

/// Moves of a program, handed out chunk by chunk.
pub(crate) struct MotionChunks<'a> {
    run: &'a Run<'a>,
    pub(crate) scope: MeasureScope,
    /// Largest distance from the tip of any point that matters \[mm\].
    far: f64,
    /// Pieces per chunk.
    size: usize,
    /// All moves, if they fit into one chunk.
    whole: Option<MotionChunk>,
}

impl<'a> MotionChunks<'a> {
    /// Takes the cutting moves, in chunks of the usual size.
    pub(crate) fn new(run: &'a Run<'a>, tools: MeasuredTools<'_>) -> Result<Self, VerifyError> {
        Self::of(run, tools, PIECES)
    }

    /// Takes the cutting moves, in chunks of about `size` pieces.
    pub(crate) fn of(
        run: &'a Run<'a>,
        tools: MeasuredTools<'_>,
        size: usize,
    ) -> Result<Self, VerifyError> {
        Self::some(run, tools, MoveKind::Cuts, size)?.ok_or(VerifyError::NoMotion)
    }

    /// Takes the rapids, run one way or the other; `None` if none run this way.
    pub(crate) fn rapids(
        run: &'a Run<'a>,
        tools: MeasuredTools<'_>,
        moves: MoveKind,
    ) -> Result<Option<Self>, VerifyError> {
        let chunks = Self::some(run, tools, moves, PIECES)?;
        let any = |chunk: &MotionChunk| !chunk.parts.pieces.is_empty();
        Ok(chunks.filter(|chunks| chunks.whole.as_ref().is_none_or(any)))
    }

    /// Reads the first chunk; `None` if the program has no move.
    fn some(
        run: &'a Run<'a>,
        tools: MeasuredTools<'_>,
        moves: MoveKind,
        size: usize,
    ) -> Result<Option<Self>, VerifyError> {
        let MeasuredTools { cutters, options } = tools;
        let far = cutters.iter().map(|cutter| tool::size(cutter)).fold(0.0, f64::max);
        let scope = MeasureScope::new(tools, moves);
        // Points that matter are in the tool, or on a ray as far from it as the search range.
        let far = far + options.reach;
        let mut chunks = Self { run, scope, far, size, whole: None };
        let mut segments = run.segments();
        // A program of one chunk is kept whole, and is then split into pieces only once.
        let Some(first) = chunks.next(&mut segments)? else { return Ok(None) };
        if chunks.next(&mut segments)?.is_none() {
            chunks.whole =
                Some(MotionChunk::new(first.0, &chunks.scope, &BoundingBox::everywhere()));
        }
        Ok(Some(chunks))
    }

    /// Hands out chunk by chunk in program order, with the share done before and after each \[0..=1\].
    ///
    /// The tree of a chunk may omit what does not come `within` a region.
    pub(crate) fn each(
        &self,
        within: &BoundingBox,
        mut work: impl FnMut(&MotionChunk, [f64; 2]) -> Result<(), VerifyError>,
    ) -> Result<(), VerifyError> {
        if let Some(whole) = &self.whole {
            return work(whole, [0.0, 1.0]);
        }
        let (mut segments, mut before) = (self.run.segments(), 0);
        while let Some((pieces, moves)) = self.next(&mut segments)? {
            let ends = [before, before + moves].map(|done| done as f64 / self.run.steps() as f64);
            work(&MotionChunk::new(pieces, &self.scope, within), ends.map(|share| share.min(1.0)))?;
            before += moves;
        }
        Ok(())
    }

    /// Returns the number of pieces that may be kept for closer inspection.
    pub(crate) fn kept(&self) -> usize {
        KEPT * self.size
    }

    /// Returns the next pieces and the number of moves they stand for; `None` at the end.
    fn next(
        &self,
        segments: &mut Segments<'_>,
    ) -> Result<Option<(Vec<MotionPiece>, usize)>, VerifyError> {
        let (mut pieces, mut moves) = (Vec::new(), 0);
        while pieces.len() < self.size {
            let Some(segment) = segments.next() else { break };
            let segment: Segment = segment?;
            match self.scope.moves {
                MoveKind::DogLegs => {
                    let legs = self.run.mover.dog_leg(&segment);
                    legs.iter().try_for_each(|leg| self.take(leg, &mut pieces))?;
                }
                moves if segment.rapid == (moves == MoveKind::Rapids) => {
                    self.take(&segment, &mut pieces)?;
                }
                _ => {}
            }
            moves += 1;
        }
        Ok((moves > 0).then_some((pieces, moves)))
    }

    fn take(&self, segment: &Segment, pieces: &mut Vec<MotionPiece>) -> Result<(), VerifyError> {
        quadratic::pieces(&self.run.mover, segment, self.far, self.scope.error(), pieces)
    }
}

/// Pieces of some moves, with the bodies that follow them.
pub(crate) struct ChunkMotion {
    pub(crate) pieces: Vec<MotionPiece>,
    pub(crate) scope: MeasureScope,
}

impl ChunkMotion {
    /// Returns a moving body by its numbers.
    pub(crate) fn part(&self, numbers: ContentId) -> Option<MovingBody<'_>> {
        let piece = self.pieces.get(numbers.item as usize)?;
        let body = self.body(numbers.body)?;
        Some(MovingBody { piece, body, numbers })
    }

    /// Returns all bodies of the tool that moves in a piece.
    pub(crate) fn tool_of(&self, piece: &MotionPiece) -> impl Iterator<Item = ConvexBody> {
        self.scope.bodies_in(piece).filter_map(|number| self.body(number))
    }

    /// Returns a body by its number.
    pub(crate) fn body(&self, number: u32) -> Option<ConvexBody> {
        self.scope.bodies.get(number as usize).copied()
    }

    /// Returns the numbers of all bodies in all pieces.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = ContentId> {
        let pieces = (0..).zip(&self.pieces);
        pieces.flat_map(|(index, piece)| {
            self.scope.bodies_in(piece).map(move |body| ContentId { item: index, body })
        })
    }

    /// Returns the lowest entry of a ray into the given moving bodies.
    pub(crate) fn lowest(
        &self,
        numbers: impl Iterator<Item = ContentId>,
        ray: &NormalRay,
    ) -> LowestEntry {
        self.lowest_below(self.scope.top(), numbers, ray)
    }

    /// Returns the lowest entry of a ray into the given moving bodies below `top` \[mm\]: those that come no lower are not
    /// searched.
    pub(crate) fn lowest_below(
        &self,
        top: f64,
        numbers: impl Iterator<Item = ContentId>,
        ray: &NormalRay,
    ) -> LowestEntry {
        let mut lowest = LowestEntry::none(top);
        for part in numbers.filter_map(|numbers| self.part(numbers)) {
            lowest.search(&part, ray, self.scope.tolerance);
        }
        lowest
    }

    /// Returns the lowest entry of a ray into the given moving bodies, or the distance of the cutting end that comes nearest
    /// to its origin, if that is within the tolerance and what cuts along the ray is not.
    ///
    /// It is the rule by which the map measures its points: at an edge the tool that cuts the next face cuts this one too.
    pub(crate) fn lowest_or_nearest(&self, numbers: &[ContentId], ray: &NormalRay) -> LowestEntry {
        let lowest = self.lowest(numbers.iter().copied(), ray);
        if lowest.line.is_some() && lowest.s <= self.scope.total {
            return lowest;
        }
        let mut nearest = LowestEntry::none(self.scope.total);
        for part in numbers.iter().filter_map(|&numbers| self.part(numbers)) {
            nearest.approach(&part, &ray.origin);
        }
        lowest.or_nearer(nearest)
    }

    /// Tests if a moving body may come to a bundle of rays, from the reach below up to `top` \[mm\], or near enough to count
    /// as having cut it; returns its approximate distance if so.
    pub(crate) fn comes(&self, numbers: ContentId, bundle: &RayBundle, top: f64) -> Option<f64> {
        let MovingBody { piece, body, .. } = self.part(numbers)?;
        piece.comes(body, bundle, [self.scope.reach, top], self.scope.aside())
    }
}

/// Some moves, sorted by position.
pub(crate) struct MotionChunk {
    pub(crate) parts: ChunkMotion,
    pub(crate) tree: BoxTree,
}

impl MotionChunk {
    fn new(pieces: Vec<MotionPiece>, scope: &MeasureScope, within: &BoundingBox) -> Self {
        let mut items = Vec::new();
        for (index, piece) in pieces.iter().enumerate() {
            for part in scope.bodies_in(piece) {
                let Some(body) = scope.bodies.get(part as usize) else { continue };
                let content = ContentId { item: narrow(index), body: part };
                // The pieces are off the moves by the error, which the boxes must cover.
                let grown = boxes(piece, *body).map(|bounds| bounds.grown(scope.error()));
                let near = grown.filter(|bounds| bounds.meets(within));
                items.extend(near.map(|bounds| TreeItem { bounds, content }));
            }
        }
        Self { parts: ChunkMotion { pieces, scope: scope.clone() }, tree: BoxTree::new(items) }
    }

    /// Returns the bodies that can come near a region, sorted by their clearance from a centre \[mm\].
    ///
    /// The deepest cuts come first, so that most of the others are refused after one test.
    pub(crate) fn around(
        &self,
        region: &BoundingBox,
        centre: Point3<f64>,
    ) -> Vec<(f64, MovingBody<'_>)> {
        let mut near = Vec::new();
        self.tree.near(region, &mut near);
        let mut parts = Vec::with_capacity(near.len());
        for &numbers in &near {
            if let Some(part) = self.parts.part(numbers) {
                parts.push((part.piece.clearance(part.body, &centre), part));
            }
        }
        // The sort is stable: equal distances keep the program order.
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        parts
    }

    /// Returns the numbers of the pieces that may come to one of some bundles, from the reach below up to `top` \[mm\], in
    /// ascending order.
    pub(crate) fn coming(&self, bundles: &[RayBundle], top: f64) -> Vec<u32> {
        let scope = &self.parts.scope;
        let mut found = Vec::new();
        let mut near = Vec::new();
        for bundle in bundles {
            self.tree.near(&scope.around(bundle, top), &mut near);
            let comes = |numbers: &&ContentId| self.parts.comes(**numbers, bundle, top).is_some();
            found.extend(near.iter().filter(comes).map(|numbers| numbers.item));
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn narrow(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// Returns boxes around a body over a piece, each about as high as the body is wide: one box around a slender tilted tool
/// would claim all the space beside it.
fn boxes(piece: &MotionPiece, body: ConvexBody) -> impl Iterator<Item = BoundingBox> {
    let [low, high] = body.heights();
    let radius = body.radius();
    // Boxes as high as the body is wide, but not more than are worth their place in the tree.
    let count = ((high - low) / (2.0 * radius)).ceil().clamp(1.0, 64.0);
    let mut index = 0.0;
    std::iter::from_fn(move || {
        if index >= count {
            return None;
        }
        let [from, to] = [index, index + 1.0].map(|i| low + (high - low) * i / count);
        index += 1.0;
        let [low, high] = piece.axis_box([from, to]);
        Some(BoundingBox { low, high }.grown(radius))
    })
}
