//! Clips a tile that nothing harmful comes near, by finding which body decides which ray.
//!
//! On one ray everything is tried. The body that decides it is then followed over the tile: its surface on the next ray is
//! expected on its tangent plane, and the next piece takes over where one piece of the motion ends. Where the tool moves
//! along the rays, a few of its instants remove everything between both ends (see [`cover`]). All else is kept off by
//! planes below its distance, for squares of rays and for single rays; what they do not keep off is tried as on any ray.

use super::batch::{ClipBatch, CutRequest};
use super::candidates::RayCut;
use super::chain::PieceChain;
use super::closest_approach::{NearestInstant, RayLine, TimeGuess};
use super::cover::cover;
use super::front::{BodyPlane, FrontLayer};
use super::trace::{ExpectedSurface, FollowedCut, SurfaceTrace};
use crate::verify::stock::broad_phase::{BodyPiece, BoundedPiece, MovingPart};
use crate::verify::stock::dexel::{RaySpans, RaySquare, RayTile};
use nalgebra::Point3;

/// Rays along the side of a square.
const SIDE: usize = 8;

/// End of a ray, with the piece that made it and the time of the chain: piece k covers 2 k - 1 to 2 k + 1.
#[derive(Clone, Copy)]
struct RayEnd {
    number: usize,
    time: f64,
    s: f64,
}

impl RayEnd {
    /// Returns its time relative to a piece, clamped to the piece.
    fn seen_from(&self, number: usize) -> f64 {
        (self.time - 2.0 * number as f64).clamp(-1.0, 1.0)
    }
}

/// Ray with the ends that were followed on it.
struct FollowedRay<'a> {
    line: &'a RayLine,
    ends: FollowedEnds,
}

/// Piece during which the tool is nearest to the expected surface.
struct FoundPiece {
    number: usize,
    expected: ExpectedSurface,
    near: NearestInstant,
}

/// Ends to which a ray was followed, by the number of the follower.
type FollowedEnds = [Option<RayEnd>; 2];

/// Point in a body, with its depth and the time.
#[derive(Clone, Copy)]
struct HeldPoint {
    at: Point3<f64>,
    depth: f64,
    number: usize,
    u: f64,
    /// Speed bound, seen from the tool, of points nearer to it than its depth.
    point_speed: f64,
}

impl HeldPoint {
    fn new(at: Point3<f64>, depth: f64, number: usize, bounded: &BoundedPiece, u: f64) -> Self {
        // A point nearer to `at` than its depth is at most so far from the tip, which bounds its speed.
        let far = (at - bounded.piece.middle().pose.tip).norm();
        let point_speed = bounded.piece.point_speed(far + depth.max(0.0));
        Self { at, depth: depth - bounded.bend, number, u, point_speed }
    }

    /// Tests if another point, at a slightly different time, is certainly in the body as well.
    fn holds(&self, at: &Point3<f64>, number: usize, u: f64) -> bool {
        // Depth is 1-Lipschitz in the point, and changes in time by at most the speed of the point.
        let left = self.depth - self.point_speed * (u - self.u).abs();
        number == self.number && left > 0.0 && (at - self.at).norm_squared() < left * left
    }
}

/// State of following one surface from ray to ray.
struct SurfaceFollower {
    /// Index of the ends that it records.
    which: usize,
    trace: SurfaceTrace,
    /// Ray of the trace, and the time that decides it.
    ray: [usize; 2],
    time: f64,
    /// For both directions across: distance of the surface from the tangent plane, and delay, one ray on.
    off: [f64; 2],
    later: [f64; 2],
    /// Growth of the delay, and the direction in which it was learned; 0 if unknown.
    more: [f64; 2],
    sign: [f64; 2],
    held: Option<HeldPoint>,
}

impl ClipBatch<'_> {
    /// Clips a tile by bodies in any order.
    pub(crate) fn settle(&self, tile: &mut RayTile, parts: &[&MovingPart]) {
        let chain = PieceChain::new(parts);
        let all: Vec<usize> = (0..parts.len()).collect();
        let mut ends: Vec<FollowedEnds> = vec![[None; 2]; tile.rays.len()];
        let mut planes = Vec::new();
        // Step 1: decide rays one by one until bodies made the ends of one; follow these over the whole tile.
        for ray in tile.probing_rays() {
            let (below, followers, _) = self.decided(tile, ray, &chain, &all);
            if !below.is_empty() {
                planes = below;
            }
            if !followers.is_empty() {
                let whole = tile.whole();
                for follower in followers {
                    self.walk(tile, whole, &chain, follower, &mut ends);
                }
                break;
            }
        }
        // Step 2: settle what the followers left, square by square.
        for square in tile.squares(SIDE) {
            self.square(tile, square, &chain, &planes, &mut ends);
        }
    }

    /// Clips a square by the bodies that the planes of the tile do not keep off.
    fn square(
        &self,
        tile: &mut RayTile,
        square: RaySquare,
        chain: &PieceChain<'_>,
        planes: &[BodyPlane],
        ends: &mut [FollowedEnds],
    ) {
        // A plane above `-touch` all over a layer keeps its body off: a shallower contact does not cut.
        let off = |planes: &[BodyPlane], layer: &FrontLayer| {
            planes.iter().any(|plane| plane.over(layer) > -self.touch)
        };
        let layers = self.layers(tile, square);
        // Step 1: keep the bodies that some layer does not exclude.
        let by_part = || planes.chunk_by(|a, b| a.part == b.part);
        let close = by_part().filter(|planes| !layers.iter().all(|layer| off(planes, layer)));
        let close: Vec<usize> = close.filter_map(|planes| Some(planes.first()?.part)).collect();
        // Step 2: decide one ray that still has material, preferably the middle one.
        let holds = |ray: &usize| tile.rays.get(*ray).is_some_and(|spans| spans.len() > 0);
        let middle = Some(square.middle()).filter(holds).or_else(|| square.rays().find(holds));
        let Some(middle) = middle.filter(|_| !close.is_empty()) else { return };
        let (mut near, followers, cuts) = self.decided(tile, middle, chain, &close);
        // Step 3: the surfaces and the instants found there remove material from the other rays cheaply.
        let links = self.links(&self.line(tile, middle), &cuts, chain);
        if near.is_empty() {
            near = planes.iter().filter(|plane| close.contains(&plane.part)).copied().collect();
        }
        for follower in followers {
            self.walk(tile, square, chain, follower, ends);
        }
        for index in square.rays().filter(|_| !links.is_empty()) {
            let line = self.line(tile, index);
            if let Some(spans) = tile.rays.get_mut(index) {
                cover(&links, &line, spans);
            }
        }
        // Step 4: the front has receded, so the planes now exclude more bodies; test the others ray by ray.
        let layers = self.layers(tile, square);
        let near = near.chunk_by(|a, b| a.part == b.part);
        let near = near.filter(|planes| !layers.iter().all(|layer| off(planes, layer)));
        let near = halving(near.collect());
        for index in square.rays() {
            let line = self.line(tile, index);
            let Some(spans) = tile.rays.get_mut(index) else { continue };
            let ends = ends.get(index).copied().unwrap_or_default();
            for planes in &near {
                let ray = FollowedRay { line: &line, ends };
                self.try_on(chain, planes, &ray, spans);
            }
        }
    }

    /// Clips a ray by bodies, deepest first. Returns planes that keep all bodies off the remainder, followers of its ends, and
    /// the cuts.
    fn decided(
        &self,
        tile: &mut RayTile,
        ray: usize,
        chain: &PieceChain<'_>,
        parts: &[usize],
    ) -> (Vec<BodyPlane>, Vec<SurfaceFollower>, Vec<RayCut>) {
        let (line, position) = (self.line(tile, ray), tile.row_and_column(ray));
        let Some(spans) = tile.rays.get_mut(ray) else { return Default::default() };
        let (planes, cuts) = self.decide(&line, spans, chain, parts);
        // An end that is bit by bit an end of a cut was made by that cut; the latest such cut counts.
        let last = |end: f64| {
            let made = |cut: &&RayCut| cut.span.iter().any(|s| s.total_cmp(&end).is_eq());
            cuts.iter().rev().find(made).map(|cut| (cut.number, end))
        };
        let ends: Vec<(usize, f64)> = spans.iter().flatten().filter_map(last).collect();
        let follower = |(number, s): (usize, f64)| {
            let &motion = chain.pieces.get(number)?;
            let near = self.moving(motion).nearest(&line, s, TimeGuess::at(0.0));
            let (trace, time) =
                (SurfaceTrace::new(&line, s, &near), 2.0 * number as f64 + near.least);
            Some(SurfaceFollower {
                which: 0,
                trace,
                ray: position,
                time,
                off: [0.0; 2],
                later: [0.0; 2],
                more: [0.0; 2],
                sign: [0.0; 2],
                held: None,
            })
        };
        let mut followers: Vec<SurfaceFollower> = ends.into_iter().filter_map(follower).collect();
        for (which, follower) in followers.iter_mut().enumerate() {
            follower.which = which;
        }
        (planes, followers, cuts)
    }

    /// Clips rays in zigzag order by what decides them, as far as it can be followed.
    fn walk(
        &self,
        tile: &mut RayTile,
        square: RaySquare,
        chain: &PieceChain<'_>,
        mut follower: SurfaceFollower,
        ends: &mut [FollowedEnds],
    ) {
        for index in square.to_and_fro() {
            let (line, position) = (self.line(tile, index), tile.row_and_column(index));
            let Some(spans) = tile.rays.get_mut(index) else { continue };
            let end = self.step(chain, &mut follower, position, &line, spans);
            let known = ends.get_mut(index).and_then(|ends| ends.get_mut(follower.which));
            if let (Some(_), Some(known)) = (end, known) {
                *known = end;
            }
        }
    }

    /// Follows the surface to a ray.
    fn step(
        &self,
        chain: &PieceChain<'_>,
        follower: &mut SurfaceFollower,
        ray: [usize; 2],
        line: &RayLine,
        spans: &mut RaySpans,
    ) -> Option<RayEnd> {
        // Step 1: intersect the tangent plane at the previous ray with this ray.
        let plain = follower.trace.on(line)?;
        // Step 2: extrapolate over single steps between rays. The curvature of the surface takes both
        // directions off the plane alike, while the delay changes its sign with the direction.
        let by = [0, 1].map(|k: usize| ray[k].cast_signed() - follower.ray[k].cast_signed());
        let (axis, sign) = match by {
            [0, 1] => (1, 1.0),
            [0, -1] => (1, -1.0),
            [1, 0] => (0, 1.0),
            _ => (0, 0.0),
        };
        let s = plain.s + follower.off[axis] * f64::abs(sign);
        // Extrapolate the delay with its trend, except where the zigzag turns.
        let goes_on = f64::abs(sign) > 0.0 && (sign - follower.sign[axis]).abs() < 0.5;
        let trend = if goes_on { follower.more[axis] * sign } else { 0.0 };
        let time = follower.time + (follower.later[axis] + trend) * sign;
        // Step 3: convert the time of the chain to a piece and its local time.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let number = (0.5 * time).round().clamp(0.0, chain.pieces.len() as f64 - 1.0) as usize;
        let u = time - 2.0 * number as f64;
        let expected = ExpectedSurface { s, guess: TimeGuess { u, ..plain.guess }, ..plain };
        // Step 4: correct the piece and cut the ray.
        let found = self.seek(chain, number, line, &expected)?;
        let number = found.number;
        let (s, near) = self.end(chain, &found, &mut follower.held, line, spans)?;
        let time = 2.0 * number as f64 + near.least;
        // Step 5: learn the deviation from the plane, the delay and its trend for the next ray.
        if f64::abs(sign) > 0.0 {
            follower.off[axis] = s - plain.s;
            let later = sign * (time - follower.time);
            if goes_on {
                follower.more[axis] = sign * (later - follower.later[axis]);
            }
            (follower.later[axis], follower.sign[axis]) = (later, sign);
        }
        (follower.time, follower.ray) = (time, ray);
        follower.trace = SurfaceTrace::new(line, s, &near);
        Some(RayEnd { number, time, s })
    }

    /// Finds the piece during which the tool is nearest to the expected surface, from `number` on or back.
    fn seek(
        &self,
        chain: &PieceChain<'_>,
        mut number: usize,
        line: &RayLine,
        expected: &ExpectedSurface,
    ) -> Option<FoundPiece> {
        let mut guess = expected.guess;
        let mut sign = 0.0;
        loop {
            let &motion = chain.pieces.get(number)?;
            let here = self.moving(motion).nearest(line, expected.s, guess);
            // A nearest instant at an end of the piece leads to the neighbour. The direction never reverses,
            // so the loop ends.
            let ends = here.u.abs() >= 1.0 && sign * here.u >= 0.0;
            let next = if here.u > 0.0 { number.checked_add(1) } else { number.checked_sub(1) };
            match next.filter(|next| ends && *next < chain.pieces.len()) {
                Some(next) => (number, guess.u, sign) = (next, -here.u, here.u),
                None => return Some(FoundPiece { number, expected: *expected, near: here }),
            }
        }
    }

    /// Removes from a ray what one piece sweeps up to the expected surface.
    fn end(
        &self,
        chain: &PieceChain<'_>,
        found: &FoundPiece,
        held: &mut Option<HeldPoint>,
        line: &RayLine,
        spans: &mut RaySpans,
    ) -> Option<(f64, NearestInstant)> {
        let FoundPiece { number, expected, near: here } = found;
        let (number, here) = (*number, *here);
        let &motion = chain.pieces.get(number)?;
        let span = spans.iter().find(|span| span[0] < expected.s && expected.s < span[1])?;
        // The end of the span on the side of the body: a depth known from the previous ray may prove that it
        // is inside.
        let at = line.at(span[usize::from(expected.sign < 0.0)]);
        let is_held = |u: f64| held.is_some_and(|held| held.holds(&at, number, u));
        let moving = self.moving(motion);
        let followed = moving.follow(line, span, expected, is_held, here)?;
        let FollowedCut { cut, s, near, depth } = followed;
        if let Some(depth) = depth {
            *held = Some(HeldPoint::new(at, depth, number, motion.bounded, near.u));
        }
        spans.take(cut);
        Some((s, near))
    }

    /// Cuts a ray by a body unless the planes of the body keep it off.
    fn try_on(
        &self,
        chain: &PieceChain<'_>,
        planes: &[BodyPlane],
        ray: &FollowedRay<'_>,
        spans: &mut RaySpans,
    ) {
        let Some(which) = planes.first().map(|plane| plane.part) else { return };
        let beside = self.beside(ray.line);
        // A plane above `-touch` over the span, for rays as for layers.
        let off = |span| planes.iter().any(|plane| plane.along(beside, span) > -self.touch);
        // From the last span back: cutting one renumbers only those after it.
        for at in (0..spans.len()).rev() {
            if !spans.get(at).is_none_or(off) {
                self.cut_by_all(chain, which, ray, spans, at);
            }
        }
    }

    /// Cuts a span by all pieces of a body.
    fn cut_by_all(
        &self,
        chain: &PieceChain<'_>,
        which: usize,
        ray: &FollowedRay<'_>,
        spans: &mut RaySpans,
        at: usize,
    ) {
        // Cuts split or remove this span only; the spans above it keep their number from the end.
        let above = spans.len() - at - 1;
        let pieces = chain.of(which);
        // No piece meets what the whole motion does not meet.
        let mut met = pieces.len() == 1;
        for number in pieces {
            let Some(&motion) = chain.pieces.get(number) else { continue };
            for at in (at..spans.len() - above).rev() {
                let Some(span) = spans.get(at) else { continue };
                if self.passes(motion, number, ray, span) {
                    continue;
                }
                let part = motion.part;
                met = met || self.meeting(part, &part.whole, ray.line, span).is_some();
                if !met {
                    return;
                }
                let end = ray.ends.iter().flatten().next();
                let guess = end.map_or(0.0, |end| end.seen_from(number));
                self.cut_span(&CutRequest { motion, guess }, ray.line, spans, at, &mut |_| ());
            }
        }
    }

    /// Tests if a piece certainly keeps off a span, from its nearest instant at a followed end. The piece that is nearest
    /// when the ray is decided, or just before or after, may stay so for longer.
    fn passes(
        &self,
        motion: BodyPiece<'_>,
        number: usize,
        ray: &FollowedRay<'_>,
        span: [f64; 2],
    ) -> bool {
        let followed = |end: &&RayEnd| span.iter().any(|s| s.total_cmp(&end.s).is_eq());
        let Some(end) = ray.ends.iter().flatten().find(followed) else { return false };
        // The piece that was followed ends exactly here.
        if end.number == number {
            return true;
        }
        // For any other, the plane at an end of the span must rise along the span.
        let moving = self.moving(motion);
        let guess = TimeGuess::at(end.seen_from(number));
        let holds = |s: f64, sign: f64| {
            let near = moving.nearest(ray.line, s, guess);
            near.bound > -self.touch && near.slope * sign >= moving.shear
        };
        // The end away from the followed one decides more often: it is tried first.
        let [low, high] = [(span[0], 1.0), (span[1], -1.0)];
        let order = if end.s > span[0] { [high, low] } else { [low, high] };
        order.into_iter().any(|(s, sign)| holds(s, sign))
    }
}

/// Reorders by bisection: the first, the middle, then the middles of both halves, and so on. Where bodies sweep along a
/// ray, a few of them then remove all of its material.
fn halving<T>(all: Vec<T>) -> Vec<T> {
    // Counting with reversed bits visits the list in van der Corput order; numbers beyond its end are
    // skipped.
    let bits = usize::BITS - all.len().leading_zeros();
    let order = (0..1usize << bits).map(|at| (at.reverse_bits() >> 1) >> (usize::BITS - 1 - bits));
    let mut left: Vec<Option<T>> = all.into_iter().map(Some).collect();
    order.filter_map(|at| left.get_mut(at).and_then(Option::take)).collect()
}
