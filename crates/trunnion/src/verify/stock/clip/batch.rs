//! Clips the tiles of one ray family by a batch of moves.

use super::closest_approach::{BodyMotion, RayLine};
use super::ray;
use super::ray::SweptSpans;
use crate::verify::stock::between_rays::boxes::CloseBox;
use crate::verify::stock::broad_phase::{BodyPiece, BoundedPiece, MovingPart, RayFrame};
use crate::verify::stock::collision::{Collision, CollisionKind};
use crate::verify::stock::dexel::{DexelGrid, RayFamily, RaySpans, RayTile, unit};
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::quadratic::SupportPlanes;

/// Most pairs of support planes between the ends of a span before a body is evaluated exactly.
const MOST_PLANE_PAIRS: u32 = 6;

/// Batch of moves against one ray family.
pub(crate) struct ClipBatch<'a> {
    pub(crate) frame: RayFrame,
    parts: &'a [MovingPart],
    pub(crate) tolerance: f64,
    /// Depth below which a body does not cut \[mm\].
    pub(crate) touch: f64,
    /// Distance from a ray at which a body that must not touch material is close to it \[mm\].
    margin: f64,
}

/// Body that may cut a ray, with the time at which it is probably nearest.
#[derive(Clone, Copy)]
pub(crate) struct CutRequest<'a> {
    pub(crate) motion: BodyPiece<'a>,
    /// Initial guess of the nearest time, see [`TimeGuess`](super::closest_approach::TimeGuess).
    pub(crate) guess: f64,
}

/// Findings of a batch on one tile.
#[derive(Debug, Default)]
pub(crate) struct ClipFindings {
    /// Collisions on the rays of the tile.
    pub(crate) hits: Vec<Collision>,
    /// Boxes in which a body comes close to material.
    pub(crate) close: Vec<CloseBox>,
}

/// Distance, in ray spacings, at which a body is close to material.
///
/// Material at least as thick as the spacing, or pointed at no less than some 30 degrees, has a ray this near to each of its
/// points.
const CLOSE: f64 = 2.0;

impl<'a> ClipBatch<'a> {
    pub(crate) fn new(
        lattice: DexelGrid,
        family: &RayFamily,
        parts: &'a [MovingPart],
        tolerance: f64,
    ) -> Self {
        let frame = RayFrame { lattice, along: family.along, bins: family.bins };
        let margin = margin(&lattice);
        Self { frame, parts, tolerance, touch: ray::TOUCH * tolerance, margin }
    }

    /// Returns the bodies that come near the material of a tile, in program order.
    fn near(&self, tile: &RayTile, near: &[u32]) -> Vec<&'a MovingPart> {
        let parts = near.iter().filter_map(|&number| self.parts.get(number as usize));
        parts.filter(|part| self.meets(tile, part) || self.comes_close(tile, part)).collect()
    }

    fn comes_close(&self, tile: &RayTile, part: &MovingPart) -> bool {
        part.harm.is_some() && self.frame.meets(tile, tile.whole(), &tile.held, part, -self.margin)
    }

    fn meets(&self, tile: &RayTile, part: &MovingPart) -> bool {
        self.frame.meets(tile, tile.whole(), &tile.held, part, self.touch)
    }

    /// Clips a tile.
    pub(crate) fn cut(&self, tile: &mut RayTile, near: &[u32]) -> ClipFindings {
        let near = self.near(tile, near);
        let mut findings = ClipFindings::default();
        if near.iter().any(|part| part.harm.is_some()) {
            self.in_order(tile, &near, &mut findings);
        } else if !near.is_empty() {
            // Nothing harmful is near: the result does not depend on the order, so follow surfaces from ray to ray.
            self.settle(tile, &near);
            tile.measure(self.frame.bins);
        }
        findings
    }

    /// Clips a tile by one body after the other.
    fn in_order(&self, tile: &mut RayTile, near: &[&MovingPart], findings: &mut ClipFindings) {
        for part in near {
            findings.close.extend(self.close(tile, part));
            if !self.meets(tile, part) {
                continue;
            }
            let mut changed = false;
            // Order matters here: material that one body has removed is no collision of the next.
            for index in 0..tile.rays.len() {
                changed |= self.ray(tile, index, part, &mut findings.hits);
            }
            if changed {
                tile.measure(self.frame.bins);
            }
        }
    }

    /// Returns a box around the material of a tile that a body comes close to but must not touch.
    fn close(&self, tile: &RayTile, part: &MovingPart) -> Option<CloseBox> {
        let kind = part.harm.filter(|_| self.comes_close(tile, part))?;
        let mut bounds = BoundingBox::empty();
        for (index, spans) in tile.rays.iter().enumerate() {
            let line = self.line(tile, index);
            // Only the stretches of material that support planes do not exclude enter the box.
            for [low, high] in spans.iter().filter_map(|span| self.comes_to(part, &line, span)) {
                bounds = bounds.join(&BoundingBox { low: line.at(low), high: line.at(high) });
            }
        }
        let some = bounds.low.x <= bounds.high.x;
        let (bounds, line) = (bounds.grown(self.margin), part.whole.piece.line);
        let most = part.body.radius();
        some.then_some(CloseBox {
            part: part.number,
            first: part.first,
            bounds,
            line,
            kind,
            most,
            known: 0.0,
        })
    }

    /// Returns the part of a span that support planes do not prove to be farther from a body than the margin.
    fn comes_to(
        &self,
        part: &MovingPart,
        line: &RayLine,
        [from, to]: [f64; 2],
    ) -> Option<[f64; 2]> {
        let [low, high] = part.extent(self.frame.along);
        let mut span = [from.max(low), to.min(high)];
        let held =
            |s: f64| self.held(&part.whole.support_planes(part.body, &line.at(s)), s, -self.margin);
        for _ in 0..MOST_PLANE_PAIRS {
            if span[0] >= span[1] {
                return None;
            }
            // A plane laid at an end excludes the span up to its zero: move the end there and lay the next.
            let before = span[1] - span[0];
            if let Some([_, above]) = held(span[0]) {
                span[0] = above;
            }
            if let Some([below, _]) = held(span[1]) {
                span[1] = below;
            }
            if before - (span[1] - span[0]) < self.margin {
                break;
            }
        }
        (span[0] < span[1]).then_some(span)
    }

    /// Clips a ray by one body over one piece; returns if anything was cut.
    fn ray(
        &self,
        tile: &mut RayTile,
        index: usize,
        part: &MovingPart,
        hits: &mut Vec<Collision>,
    ) -> bool {
        let line = self.line(tile, index);
        let Some(spans) = tile.rays.get_mut(index) else { return false };
        let mut changed = false;
        for bounded in part.straight.iter() {
            let motion = BodyPiece { part, bounded };
            let request = CutRequest { motion, guess: 0.0 };
            changed |= self.cut_spans(&request, &line, spans, &mut |cut| {
                if let Some(kind) = part.harm {
                    self.hit(motion, kind, &line, cut, hits);
                }
            });
        }
        changed
    }

    /// Clips all spans of a ray by a body over a piece, passing each cut to `note`; returns if anything was cut.
    pub(crate) fn cut_spans(
        &self,
        request: &CutRequest<'_>,
        line: &RayLine,
        spans: &mut RaySpans,
        note: &mut dyn FnMut([f64; 2]),
    ) -> bool {
        let mut changed = false;
        // From the last span back, since a cut renumbers only those after it.
        for at in (0..spans.len()).rev() {
            changed |= self.cut_span(request, line, spans, at, note);
        }
        changed
    }

    /// Clips one span of a ray; see [`ClipBatch::cut_spans`].
    pub(crate) fn cut_span(
        &self,
        request: &CutRequest<'_>,
        line: &RayLine,
        spans: &mut RaySpans,
        at: usize,
        note: &mut dyn FnMut([f64; 2]),
    ) -> bool {
        let CutRequest { motion, guess } = *request;
        // Most bodies are refused by planes, before any search over time.
        let met = |span| self.meeting(motion.part, motion.bounded, line, span);
        let Some(span) = spans.get(at).and_then(met) else { return false };
        let SweptSpans { first, more } = self.moving(motion).swept(line, span, guess);
        let mut changed = false;
        for cut in first.into_iter().chain(more) {
            note(cut);
            spans.take(cut);
            changed = true;
        }
        changed
    }

    pub(crate) fn line(&self, tile: &RayTile, index: usize) -> RayLine {
        RayLine { from: self.frame.ray(tile, index), direction: unit(self.frame.along) }
    }

    /// Returns the part of a span in the extent of a body, if the body may meet it there.
    ///
    /// Most bodies do not, which support planes at both ends, and at points between their zeros, prove.
    #[inline]
    pub(crate) fn meeting(
        &self,
        part: &MovingPart,
        bounded: &BoundedPiece,
        line: &RayLine,
        [from, to]: [f64; 2],
    ) -> Option<[f64; 2]> {
        let [low, high] = part.extent(self.frame.along);
        let span = [from.max(low), to.min(high)];
        if span[0] >= span[1] {
            return None;
        }
        let held =
            |s: f64| self.held(&bounded.support_planes(part.body, &line.at(s)), s, self.touch);
        // At an end that planes do not keep off, the body has to be evaluated.
        let Some([high, _]) = held(span[1]) else { return Some(span) };
        if high <= span[0] {
            return None;
        }
        let Some([_, low]) = held(span[0]) else { return Some(span) };
        // Both ends are kept off; the rest between the zeros of their planes is tried from its middle.
        let [mut low, mut high] = [low, high];
        for _ in 0..MOST_PLANE_PAIRS {
            if low >= high {
                return None;
            }
            match held(0.5 * (low + high)) {
                Some([from, to]) if from <= low => low = to,
                Some([from, to]) if to >= high => high = from,
                _ => break,
            }
        }
        Some(span)
    }

    /// Returns the interval of a ray on which support planes at `s` keep a body off, up to a depth of `touch` \[mm\]; `None` if
    /// they do not even at `s`.
    #[inline]
    fn held(&self, planes: &SupportPlanes, s: f64, touch: f64) -> Option<[f64; 2]> {
        let [mut low, mut high] = [f64::NEG_INFINITY, f64::INFINITY];
        for (height, gradient) in &planes.sides {
            let (height, slope) = (height + touch, gradient[self.frame.along]);
            if height <= 0.0 {
                return None;
            }
            // Zero of the plane; behind it, as seen from s, the plane no longer proves anything.
            let end = s - height / slope;
            if slope > 0.0 {
                low = low.max(end);
            } else if slope < 0.0 {
                high = high.min(end);
            }
        }
        Some([low, high])
    }

    pub(crate) fn moving<'b>(&self, motion: BodyPiece<'b>) -> BodyMotion<'b> {
        BodyMotion::new(motion.bounded, motion.part.body, self.tolerance)
    }

    /// Records the collision of a cut if it is the deepest of its kind on its line.
    fn hit(
        &self,
        motion: BodyPiece<'_>,
        kind: CollisionKind,
        line: &RayLine,
        cut: [f64; 2],
        hits: &mut Vec<Collision>,
    ) {
        let number = motion.bounded.piece.line;
        let same = hits.last_mut().filter(|hit| (hit.kind, hit.line) == (kind, number));
        // A cut that is shallower than the known one needs no search for its depth.
        let known = same.as_ref().map_or(self.tolerance, |hit| hit.depth);
        let Some(depth) = self.moving(motion).depth(line, cut, known) else { return };
        let point = line.at(0.5 * (cut[0] + cut[1]));
        let found = Collision { kind, line: number, depth, point };
        match same {
            Some(hit) => *hit = found,
            None => hits.push(found),
        }
    }
}

/// Returns the distance from a ray at which a body is close to material \[mm\].
pub(crate) fn margin(lattice: &DexelGrid) -> f64 {
    CLOSE * lattice.cell.into_iter().fold(0.0, f64::max)
}
