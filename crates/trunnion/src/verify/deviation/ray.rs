//! The lowest point of a ray that the moving tool reaches.

use crate::verify::swept::bvh::ContentId;
use crate::verify::swept::quadratic::{MotionInstant, MotionPiece, RayQuery, SurfacePatch};
use crate::verify::swept::tool::{BodyPose, BodySurface, ConvexBody, DepthRule, NormalRay};
use nalgebra::Point3;

/// Lowest entry found so far, among tools that leave the ray at the surface or above it.
///
/// A tool that leaves the ray below the surface is behind a thin wall and cuts its other side. If it cut this side, the
/// point of the surface above it would be inside the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LowestEntry {
    /// Position at which the ray enters the tool \[mm\]; the end of the search if nothing was hit.
    pub(crate) s: f64,
    /// Program line of the move that got there.
    pub(crate) line: Option<u32>,
    /// Tool pose that got there.
    pub(crate) by: Option<DecidingPose>,
    /// The search was abandoned: `s` may be too high.
    pub(crate) unresolved: bool,
}

/// Tool pose, body and piece that decide a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DecidingPose {
    pub(crate) pose: BodyPose,
    pub(crate) body: u32,
    pub(crate) piece: u32,
}

/// Body in motion over a piece, with the numbers of both.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovingBody<'a> {
    pub(crate) piece: &'a MotionPiece,
    pub(crate) body: ConvexBody,
    pub(crate) numbers: ContentId,
}

/// Share of the tolerance by which a tool may cut into the ray unnoticed.
const GRAZE: f64 = -0.1;
/// Most intervals of one piece; a contact needs a few dozen.
const MOST_STEPS: u32 = 50_000;
/// Bisection depth at which an interval of time is 1e-9 of a piece, below all rounding.
const DEEPEST: u32 = 30;

impl LowestEntry {
    /// Returns the state before any entry, with the search ending at `reach` \[mm\].
    pub(crate) fn none(reach: f64) -> Self {
        Self { s: reach, line: None, by: None, unresolved: false }
    }

    /// Returns the nearest cutting end in place of what cuts along the normal, if it is nearer.
    pub(crate) fn or_nearer(self, nearest: Self) -> Self {
        let nearer = nearest.line.is_some() && (self.line.is_none() || nearest.s < self.s);
        if nearer { nearest } else { self }
    }

    /// Lowers `s` to the lowest entry of the ray into a body during its piece, to within `tolerance` \[mm\].
    ///
    /// Branch and bound over time. An interval in which the tool cannot come lower by more than the tolerance is dropped.
    /// Otherwise its middle is evaluated exactly and both halves are searched. A contact that cuts into the ray by less than
    /// a tenth of the tolerance may be dropped; otherwise a tool that slides along the ray would be searched for ever.
    pub(crate) fn search(&mut self, part: &MovingBody<'_>, ray: &NormalRay, tolerance: f64) {
        let MovingBody { piece, body, .. } = *part;
        let limit = self.s - tolerance;
        if limit <= -ray.below {
            return;
        }
        // Most pieces are rejected here, by one distance and its derivatives.
        // First the part of the ray above the surface alone: a tool that only comes below is behind a wall.
        let upper = NormalRay { below: 0.0, ..*ray };
        let end = limit.max(0.0);
        let target = RayQuery { body, ray: &upper, s: end, limit: end };
        if piece.bound(piece.middle(), 1.0, &target).low <= GRAZE * tolerance {
            self.refine(part, ray, tolerance);
        }
    }

    /// Lowers `s` to the distance of a point from a cutting end during its piece.
    ///
    /// It is that at one time, nearly the nearest: never less than the least distance. A point inside counts as touched.
    pub(crate) fn approach(&mut self, part: &MovingBody<'_>, point: &Point3<f64>) {
        let MovingBody { piece, body, numbers } = *part;
        if body.end_top().is_none() {
            return;
        }
        let u = piece.deepest(body, point).clamp(-1.0, 1.0);
        let distance = piece.distance(body, u, point).0.max(0.0);
        if distance < self.s {
            let by = DecidingPose {
                pose: piece.instant(u).pose,
                body: numbers.body,
                piece: numbers.item,
            };
            (self.s, self.line, self.by) = (distance, Some(piece.line), Some(by));
        }
    }

    /// Runs the branch and bound.
    fn refine(&mut self, part: &MovingBody<'_>, ray: &NormalRay, tolerance: f64) {
        let MovingBody { piece, body, numbers } = *part;
        // A stack of intervals by middle and depth: depth first needs at most two per level.
        let mut open = [(0.0, 0u32); 2 * DEEPEST as usize];
        let mut count = 1usize;
        let mut steps = 0;
        while let Some(&(u, depth)) = count.checked_sub(1).and_then(|last| open.get(last)) {
            count -= 1;
            steps += 1;
            if steps > MOST_STEPS {
                self.unresolved = true;
                return;
            }
            let limit = self.s - tolerance;
            if limit <= -ray.below {
                return;
            }
            // Depth n stands for the interval of half length 2^-n.
            let half = 0.5f64.powi(depth.cast_signed());
            let instant = piece.instant(u);
            let drift = |ray: &NormalRay, limit: f64| {
                let target = RayQuery { body, ray, s: limit, limit };
                open_drift(piece, &instant, half, &target, tolerance)
            };
            // Step 1: bound the interval. A ray is inside a convex body over one interval: above the surface, below the
            // limit if that is lower, or in between.
            let Some(mut towards) = drift(&NormalRay { below: 0.0, ..*ray }, limit.max(0.0)) else {
                continue;
            };
            if limit < 0.0 {
                let Some(lower) = drift(ray, limit) else { continue };
                towards = lower;
            }
            if limit < 0.0 && ray.rule == DepthRule::InsideTool {
                let (origin, skin) = (SurfacePatch::point(ray), BodySurface::Skin(body));
                if piece.keeps_off(&instant, half, skin, &origin).least() >= limit {
                    continue;
                }
            }
            // Step 2: evaluate the middle of the interval exactly.
            let entry = body.entry(&instant.pose, ray, self.s, 1e-3 * tolerance);
            let entry = entry.filter(|s| *s >= 0.0 || body.holds(&instant.pose, &ray.origin));
            let height = entry.map(|s| body.height_of(&instant.pose, ray, s));
            if let Some(s) = height.filter(|s| *s < self.s) {
                let (pose, body, piece) = (instant.pose, numbers.body, numbers.item);
                let by = DecidingPose { pose, body, piece };
                (self.s, self.line, self.by) = (s, Some(part.piece.line), Some(by));
            }
            // The interval is below all rounding, and its middle is evaluated.
            if depth + 1 >= DEEPEST {
                continue;
            }
            // Step 3: search the half towards which the tool descends first: last in, first out.
            let step = if towards > 0.0 { 0.5 * half } else { -0.5 * half };
            for next in [u + step, u - step] {
                if let Some(slot) = open.get_mut(count) {
                    *slot = (next, depth + 1);
                    count += 1;
                }
            }
        }
    }
}

/// Tests if the body may meet the ray below the limit within `half` of an instant; returns the derivative of its
/// distance by `u` if so.
///
/// If the ray leaves the body before the limit, the bound from the limit is poor; the point closest to the body gives
/// a sharp one.
fn open_drift(
    piece: &MotionPiece,
    instant: &MotionInstant,
    half: f64,
    target: &RayQuery<'_>,
    tolerance: f64,
) -> Option<f64> {
    let mut bound = piece.bound(instant, half, target);
    if bound.low <= GRAZE * tolerance && bound.by_s > 0.0 {
        let s = target.body.closest(&instant.pose, target.ray, target.limit);
        bound = piece.bound(instant, half, &RayQuery { s, ..*target });
    }
    (bound.low <= GRAZE * tolerance).then_some(bound.drift)
}
