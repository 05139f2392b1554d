//! Selects the bodies that decide a ray.
//!
//! Of all that come near, the deepest cuts first, then the deepest in what remains. Support planes bound the depth. A plane
//! that keeps a body off a span keeps it off every remainder of that span, so most bodies are evaluated once.

use super::batch::{ClipBatch, CutRequest};
use super::chain::PieceChain;
use super::closest_approach::RayLine;
use super::front::BodyPlane;
use crate::verify::stock::broad_phase::MovingPart;
use crate::verify::stock::dexel::RaySpans;

/// Most planes tried for one body and span.
const PLANES: u32 = 12;
/// Share of the distance that a plane must bound to be accepted.
const ENOUGH: f64 = 0.9;

/// Bodies near a ray, with the planes that keep them off its spans.
struct RayCandidates<'a> {
    work: &'a ClipBatch<'a>,
    chain: &'a PieceChain<'a>,
    line: RayLine,
    /// Coordinates of the ray across it.
    beside: [f64; 2],
    all: Vec<RayCandidate>,
    /// Planes, each with the number of the previous plane of the same body.
    planes: Vec<(BodyPlane, Option<usize>)>,
}

struct RayCandidate {
    part: usize,
    /// Number of its last plane.
    last: Option<usize>,
    /// Lowest height found, and if it may still cut.
    height: f64,
    open: bool,
}

/// Cut of a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayCut {
    /// Number of the piece that made it.
    pub(crate) number: usize,
    /// Interval of the ray.
    pub(crate) span: [f64; 2],
}

impl ClipBatch<'_> {
    /// Clips a ray by bodies, deepest first.
    ///
    /// Returns the cuts, and planes that keep all bodies off the remainder, body by body; for a ray that is gone, the planes
    /// before the last cut.
    pub(crate) fn decide(
        &self,
        line: &RayLine,
        spans: &mut RaySpans,
        chain: &PieceChain<'_>,
        parts: &[usize],
    ) -> (Vec<BodyPlane>, Vec<RayCut>) {
        let candidate =
            |&part: &usize| RayCandidate { part, last: None, height: f64::INFINITY, open: true };
        let all = parts.iter().map(candidate).collect();
        let planes = Vec::with_capacity(2 * parts.len());
        let beside = self.beside(line);
        let mut candidates = RayCandidates { work: self, chain, line: *line, beside, all, planes };
        let mut cuts = Vec::new();
        // Each round evaluates the bodies still open and cuts with the deepest one; a body cuts only once.
        while spans.len() > 0 {
            candidates.evaluate(spans);
            // The deepest body probably removes most, and spares the evaluation of others.
            let Some(part) = candidates.deepest() else { break };
            for number in chain.of(part) {
                let Some(&motion) = chain.pieces.get(number) else { continue };
                let request = CutRequest { motion, guess: 0.0 };
                self.cut_spans(&request, line, spans, &mut |span| {
                    cuts.push(RayCut { number, span });
                });
            }
        }
        (candidates.below(spans), cuts)
    }

    /// Returns the best plane below a body's distance from a span: the one at the point nearest to the body.
    fn plane(
        &self,
        number: usize,
        part: &MovingPart,
        line: &RayLine,
        [low, high]: [f64; 2],
    ) -> BodyPlane {
        let along = self.frame.along;
        let plane = |s: f64| BodyPlane::new(number, part, along, &line.at(s));
        // Only the part of the span within the range of the body can meet it.
        let [least, most] = part.extent(along);
        let [low, high] = [low.clamp(least, most), high.clamp(least, most)];
        let mut upper = plane(high);
        // The distance only grows farther down.
        if upper.falls() || upper.height <= -self.touch {
            return upper;
        }
        let mut lower = plane(low);
        if lower.rises() || lower.height <= -self.touch {
            return lower;
        }
        // Cutting planes: the next point is that at which the two planes intersect; its plane replaces the
        // one on its side.
        for _ in 0..PLANES {
            let Some(meet) = lower.meet(&upper) else { break };
            // The level mean bounds the whole span. It is taken if it loses little against both points.
            if meet.height >= ENOUGH * lower.height.min(upper.height) {
                return meet;
            }
            let next = plane(meet.position());
            if next.height <= -self.touch {
                return next;
            }
            *(if next.slope() > 0.0 { &mut upper } else { &mut lower }) = next;
        }
        lower.meet(&upper).unwrap_or(if lower.height < upper.height { lower } else { upper })
    }
}

impl RayCandidates<'_> {
    /// Returns the first plane of a body that keeps it off a span.
    fn holding(&self, last: Option<usize>, span: [f64; 2]) -> Option<&BodyPlane> {
        // The planes of one body form a list, latest first: the latest is the one laid for the smallest remainder.
        let before = |&at: &usize| self.planes.get(at).and_then(|(_, before)| *before);
        let mut planes = std::iter::successors(last, before).filter_map(|at| self.planes.get(at));
        let (beside, least) = (self.beside, -self.work.touch);
        let holding = planes.find(|(plane, _)| plane.along(beside, span) > least);
        holding.map(|(plane, _)| plane)
    }

    /// Adds a plane for a body and a span.
    fn lay(&mut self, index: usize, span: [f64; 2]) -> Option<f64> {
        let candidate = self.all.get_mut(index)?;
        let body = self.chain.parts.get(candidate.part)?;
        let plane = self.work.plane(candidate.part, body, &self.line, span);
        let before = candidate.last.replace(self.planes.len());
        self.planes.push((plane, before));
        Some(plane.height)
    }

    /// Evaluates all bodies that may still cut the remainder.
    fn evaluate(&mut self, spans: &RaySpans) {
        let least = -self.work.touch;
        for index in 0..self.all.len() {
            let Some(&RayCandidate { last, open: true, .. }) = self.all.get(index) else {
                continue;
            };
            let mut height = f64::INFINITY;
            for span in spans.iter() {
                // A plane of a longer span holds for its remainder as well.
                if self.holding(last, span).is_none() {
                    height = height.min(self.lay(index, span).unwrap_or(height));
                }
            }
            if let Some(candidate) = self.all.get_mut(index) {
                // A body that all spans exclude stays closed, since spans only shrink.
                (candidate.height, candidate.open) = (height, height <= least);
            }
        }
    }

    /// Returns the deepest body, which may not cut again.
    fn deepest(&mut self) -> Option<usize> {
        let open = self.all.iter_mut().filter(|candidate| candidate.open);
        let deepest = open.min_by(|a, b| a.height.total_cmp(&b.height))?;
        deepest.open = false;
        Some(deepest.part)
    }

    /// Returns one plane for every body and span.
    fn below(mut self, spans: &RaySpans) -> Vec<BodyPlane> {
        let mut below = Vec::with_capacity(self.all.len());
        for index in 0..self.all.len() {
            let Some(&RayCandidate { last, .. }) = self.all.get(index) else { continue };
            // For a ray that is gone, the last plane of each body remains a hint for the rays around it.
            if spans.len() == 0 {
                below.extend(last.and_then(|at| self.planes.get(at)).map(|(plane, _)| *plane));
            }
            for span in spans.iter() {
                if let Some(plane) = self.holding(last, span) {
                    below.push(*plane);
                } else {
                    self.lay(index, span);
                    below.extend(self.planes.last().map(|(plane, _)| *plane));
                }
            }
        }
        below
    }
}
