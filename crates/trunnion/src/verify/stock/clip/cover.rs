//! Removes the middle of a ray by a few instants of the motion.
//!
//! Where a tool moves along a ray, its moves from first to last together leave nothing between them. A few instants suffice
//! to prove that. Those that did so on one ray are tried on the rays around it, each from where it meets the previous one to
//! where it meets the next. A convex body that holds both ends of an interval holds all of it.

use super::batch::ClipBatch;
use super::candidates::RayCut;
use super::chain::PieceChain;
use super::closest_approach::RayLine;
use crate::verify::stock::broad_phase::BodyPiece;
use crate::verify::stock::dexel::RaySpans;

/// Instant of a motion with the interval of a ray that its body holds.
pub(crate) struct CoverLink<'a> {
    motion: BodyPiece<'a>,
    /// Whole interval of the ray that the body holds.
    holds: [f64; 2],
}

/// Share of that interval that the body probably holds on the next ray.
const SHARE: f64 = 0.9;

impl ClipBatch<'_> {
    /// Returns the middle instants of the pieces that cut a ray, in the order of the ray.
    pub(crate) fn links<'a>(
        &self,
        line: &RayLine,
        cuts: &[RayCut],
        chain: &PieceChain<'a>,
    ) -> Vec<CoverLink<'a>> {
        let link = |&RayCut { number, span: [low, high] }: &RayCut| {
            let &motion = chain.pieces.get(number)?;
            let moving = self.moving(motion);
            let [from, to] = motion.part.extent(self.frame.along);
            let middle = 0.5 * (low + high);
            // Newton steps from both ends of the range of the motion approach the body from outside.
            let holds = [
                moving.through(line, [from, middle], 0.0)?.0,
                moving.through(line, [to, middle], 0.0)?.0,
            ];
            Some(CoverLink { motion, holds })
        };
        let mut links: Vec<CoverLink<'a>> = cuts.iter().filter_map(link).collect();
        links.sort_by(|a, b| a.holds[0].total_cmp(&b.holds[0]));
        // An interval within that of the instant before it adds nothing.
        links.dedup_by(|next, link| next.holds[1] <= link.holds[1]);
        links
    }
}

/// Removes from a ray what instants remove between the points where each meets the next.
pub(crate) fn cover(links: &[CoverLink<'_>], line: &RayLine, spans: &mut RaySpans) {
    for at in (0..spans.len()).rev() {
        let Some([low, high]) = spans.get(at) else { continue };
        let mut taken: Option<[f64; 2]> = None;
        for (index, link) in links.iter().enumerate() {
            let before = index.checked_sub(1).and_then(|before| links.get(before));
            let [from, to] = link.between(before, links.get(index + 1));
            let [from, to] = [from.max(low), to.min(high)];
            if from >= to || !link.takes(line, [from, to]) {
                continue;
            }
            // Only one connected interval is removed; a gap ends it.
            match &mut taken {
                Some(taken) if taken[1] >= from => taken[1] = to,
                Some(_) => break,
                None => taken = Some([from, to]),
            }
        }
        if let Some(taken) = taken {
            spans.cut(at, taken);
        }
    }
}

impl CoverLink<'_> {
    /// Returns the interval between the middles of the overlaps with the previous and with the next instant.
    fn between(&self, before: Option<&Self>, next: Option<&Self>) -> [f64; 2] {
        let [from, to] = self.holds;
        let [middle, half] = [0.5 * (from + to), 0.5 * SHARE * (to - from)];
        // The next ray may meet the bodies a little elsewhere: cutting at the middle of the overlap leaves room on both sides.
        let share = |other: &Self, end: f64| 0.5 * (other.holds[usize::from(end < middle)] + end);
        [
            before.map_or(middle - half, |before| share(before, from)),
            next.map_or(middle + half, |next| share(next, to)),
        ]
    }

    /// Tests if the body holds an interval at its instant.
    fn takes(&self, line: &RayLine, ends: [f64; 2]) -> bool {
        let BodyPiece { part, bounded } = self.motion;
        let middle = bounded.piece.middle();
        // A convex body that holds both ends holds the interval.
        ends.iter().all(|&s| part.body.holds(&middle.pose, &line.at(s)))
    }
}
