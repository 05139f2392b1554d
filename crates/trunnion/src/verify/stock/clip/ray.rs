//! Clips a ray by a moving body over one piece of a move.
//!
//! The distance `d(s, u)` of a convex body from the point `s` of the ray at time `u` is convex in `s`. Seen from the tool, a
//! point moves straight during a piece, except for the bend ([bend]). With a parabola of that size added, `d`
//! is convex in `u` as well ([`BodyMotion::tangent`]); pieces are subdivided until it is below the tolerance. In both
//! variables together `d` is not convex, since the ray turns ([shear]). Hence:
//!
//! * The tangents at a point of the ray give a plane below `d` for all times, if its slope is reduced by the shear. Along
//!   such planes the search approaches the body from outside and cannot step over its surface.
//! * Between the two ends found this way there may be a gap, as where an inclined flank turns past a ray. There is none if a
//!   point of the ray is in the body at the times of both ends: it is then in the body at all times between. Otherwise both
//!   halves of the time are clipped one by one.
//!
//! Nothing else is simplified: all distances are those of the piece itself.
//!
//! [bend]: crate::verify::swept::quadratic::MotionPiece::bend
//! [shear]: crate::verify::swept::quadratic::MotionPiece::shear

use super::closest_approach::{BodyMotion, NearestInstant, RayLine, SEARCH, STEPS, TimeGuess};

// Shares of the tolerance. What is removed is at most `BEND + ERROR + SEARCH + CLOSE + GAP` outside the swept body, what
// remains at most `BEND + ERROR + SEARCH + TOUCH` inside; neither sum exceeds 1.

/// Share for half of the departure of points from straight motion.
pub(crate) const BEND: f64 = 0.55;
/// Share for the error of pieces as quadratics.
pub(crate) const ERROR: f64 = 0.1;
/// Share for the depth of a body that does not cut.
pub(crate) const TOUCH: f64 = 0.15;
/// Share for the distance at which the surface counts as reached.
pub(crate) const CLOSE: f64 = 0.05;
/// Share for an interval that may be a gap.
pub(crate) const GAP: f64 = 0.2;
/// Most steps towards the surface, which gain digits where the ray does not graze it.
const WAY_IN: u32 = 500;
/// Points of a cut at which its depth is tried first.
const SAMPLES: i32 = 8;

/// Intervals of a ray that a body sweeps: nearly always one.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct SweptSpans {
    pub(crate) first: Option<[f64; 2]>,
    pub(crate) more: Vec<[f64; 2]>,
}

impl SweptSpans {
    fn push(&mut self, cut: [f64; 2]) {
        if self.first.is_none() { self.first = Some(cut) } else { self.more.push(cut) }
    }
}

/// End of an interval of a ray, with the time at which the body is there.
#[derive(Clone, Copy)]
struct TimedEnd {
    s: f64,
    u: f64,
}

impl BodyMotion<'_> {
    /// Returns the motion over both halves of its time.
    fn halves(&self) -> [Self; 2] {
        let [from, to] = self.time;
        let middle = 0.5 * (from + to);
        // Half of the time turns the ray about half as far, which sharpens the planes.
        let shear = self.piece.shear(middle - from);
        [[from, middle], [middle, to]].map(|time| Self { time, shear, ..*self })
    }

    /// Returns the intervals of a span that the body sweeps, except where it is less deep than the tolerance. `guess` is the
    /// probable time at which it is nearest to the upper end.
    pub(crate) fn swept(&self, line: &RayLine, span: [f64; 2], guess: f64) -> SweptSpans {
        let mut found = SweptSpans::default();
        self.sweep(line, span, guess, &mut found);
        found
    }

    fn sweep(&self, line: &RayLine, span: [f64; 2], guess: f64, found: &mut SweptSpans) {
        // The swept part is between the first and the last contact, except for gaps.
        let Some(cut) = self.hull(line, span, TimeGuess::at(guess)) else { return };
        let [low, high] = cut.map(|end| end.s);
        if self.has_no_gap(line, cut) {
            found.push([low, high]);
            return;
        }
        // The ends can be off by a quarter of the turn of the ray times its length.
        let [from, to] = self.time;
        if 0.25 * self.piece.shear(to - from) * (high - low) <= GAP * self.tolerance {
            found.push([low, high]);
            return;
        }
        // A gap is possible: over half of the time the ray turns less, and the gap shows between both halves.
        for half in self.halves() {
            half.sweep(line, [low, high], guess, found);
        }
    }

    /// Tests if a point between both ends is in the body at the times of both.
    fn has_no_gap(&self, line: &RayLine, [low, high]: [TimedEnd; 2]) -> bool {
        let same = (low.u - high.u).abs() <= f64::EPSILON;
        let holds =
            |s: f64| [low.u, high.u].iter().all(|&u| self.tangent(line, s, u).distance <= 0.0);
        same || holds(0.5 * (low.s + high.s)) || holds(high.s) || holds(low.s)
    }

    /// Returns the lowest and the highest end of the swept part of a span.
    fn hull(
        &self,
        line: &RayLine,
        [low, high]: [f64; 2],
        guess: TimeGuess,
    ) -> Option<[TimedEnd; 2]> {
        let touch = -TOUCH * self.tolerance;
        let length = high - low;
        // Step 1: if the body holds the upper end of the span, search for its other end only.
        let top = self.nearest(line, high, guess);
        if top.distance <= touch {
            return Some([self.other_end(line, [high, low], &top), TimedEnd { s: high, u: top.u }]);
        }
        // The plane at the upper end excludes the whole span.
        if top.bound - (top.slope + self.shear).max(0.0) * length > touch {
            return None;
        }
        // Step 2: the same from the lower end.
        let bottom = self.nearest(line, low, top.guess());
        if bottom.distance <= touch {
            return Some([
                TimedEnd { s: low, u: bottom.u },
                self.other_end(line, [low, high], &bottom),
            ]);
        }
        // Step 3: neither end is in the body: approach its surface from both. Between them it must be deeper
        // than `touch`.
        let time = |(s, here): (f64, NearestInstant)| TimedEnd { s, u: here.u };
        let from = self.enter(line, [low, high], bottom).map(time)?;
        let to = self.enter(line, [high, low], top).map(time)?;
        let cuts = from.s < to.s && self.deepest(line, [from.s, to.s], touch) <= touch;
        cuts.then_some([from, to])
    }

    /// Returns the end of the body from a point inside it towards `end`.
    fn other_end(&self, line: &RayLine, [inside, end]: [f64; 2], at: &NearestInstant) -> TimedEnd {
        let out = self.beyond([inside, end], at).unwrap_or(end);
        let here = self.nearest(line, out, at.guess());
        if here.bound <= CLOSE * self.tolerance {
            return TimedEnd { s: out, u: here.u };
        }
        let end = self.enter(line, [out, inside], here);
        end.map_or(TimedEnd { s: inside, u: at.u }, |(s, here)| TimedEnd { s, u: here.u })
    }

    /// Returns the point before `end` at which the plane from `inside` leaves the body.
    pub(crate) fn beyond(&self, [inside, end]: [f64; 2], at: &NearestInstant) -> Option<f64> {
        let sign = if end > inside { 1.0 } else { -1.0 };
        // Slope outwards, less the shear: from the bound, below 0, the plane rises to 0 over -bound / rise.
        let rise = at.slope * sign - self.shear;
        let by = -at.bound / rise;
        (rise > 0.0 && by < (end - inside) * sign).then_some(inside + sign * by)
    }

    /// Finds the surface of the body from a point outside it towards `to`, with the nearest instant there.
    pub(crate) fn enter(
        &self,
        line: &RayLine,
        [from, to]: [f64; 2],
        mut here: NearestInstant,
    ) -> Option<(f64, NearestInstant)> {
        let sign = if to > from { 1.0 } else { -1.0 };
        let mut s = from;
        for _ in 0..WAY_IN {
            if here.bound <= CLOSE * self.tolerance {
                break;
            }
            // The steepest fall that the plane allows: stepping down it cannot pass the surface.
            let fall = self.shear - here.slope * sign;
            if fall <= 0.0 {
                return None;
            }
            s += sign * here.bound / fall;
            if (to - s) * sign < 0.0 {
                return None;
            }
            here = self.nearest(line, s, here.guess());
        }
        Some((s, here))
    }

    /// Returns the least distance over an interval, to within the search tolerance; stops once it is at most `enough`.
    ///
    /// Tries some points first, then bisects around the best one.
    fn deepest(&self, line: &RayLine, [low, high]: [f64; 2], enough: f64) -> f64 {
        // The distance is not convex along the ray for all times, so samples come before the bisection.
        let step = (high - low) / f64::from(SAMPLES);
        let mut best = (f64::INFINITY, low);
        // Start in the middle.
        for sample in [4, 2, 6, 1, 3, 5, 7, 0, 8] {
            let s = low + step * f64::from(sample);
            let distance = self.nearest(line, s, TimeGuess::at(0.0)).distance;
            if distance < best.0 {
                best = (distance, s);
            }
            if distance <= enough {
                return distance;
            }
        }
        let (mut deepest, middle) = best;
        let [mut low, mut high] = [(middle - step).max(low), (middle + step).min(high)];
        for _ in 0..STEPS {
            let here = self.nearest(line, 0.5 * (low + high), TimeGuess::at(0.0));
            deepest = deepest.min(here.distance);
            if deepest <= enough || here.slope.abs() * (high - low) <= SEARCH * self.tolerance {
                break;
            }
            if here.slope > 0.0 { high = 0.5 * (low + high) } else { low = 0.5 * (low + high) }
        }
        deepest
    }

    /// Returns the depth of the body below the surface it sweeps on a ray, if that exceeds `known`.
    pub(crate) fn depth(&self, line: &RayLine, [low, high]: [f64; 2], known: f64) -> Option<f64> {
        // The plane at the middle bounds the depth of the whole cut: most cuts end here.
        let half = 0.5 * (high - low);
        let middle = self.nearest(line, low + half, TimeGuess::at(0.0));
        if half * (middle.slope.abs() + self.shear) - middle.bound <= known {
            return None;
        }
        Some(-self.deepest(line, [low, high], f64::NEG_INFINITY)).filter(|depth| *depth > known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{AxisVector, ToolPose};
    use crate::verify::replay::mover::Mover;
    use crate::verify::replay::segment::{Block, Course, Segment};
    use crate::verify::stock::broad_phase::{BoundedPiece, MovingPart};
    use crate::verify::stock::clip::front::BodyPlane;
    use crate::verify::swept::quadratic;
    use crate::verify::swept::quadratic::MotionPiece;
    use crate::verify::swept::tool::ConvexBody;
    use nalgebra::{Point3, Rotation3, Unit, Vector3};
    use proptest::prelude::*;

    const TOLERANCE: f64 = 1e-3;

    fn pieces(ends: [ToolPose; 2]) -> Vec<BoundedPiece> {
        let (joints, course) = ([AxisVector::zeros(); 2], Course::Circle { ends });
        let block = Block::of_one(1.0);
        let segment =
            Segment { line: 1, tool: 0, joints, course, duration: 1.0, block, rapid: false };
        let mut whole = Vec::new();
        quadratic::pieces(&Mover::Locations, &segment, 60.0, ERROR * TOLERANCE, &mut whole)
            .unwrap();
        let straight = |piece: &MotionPiece| {
            quadratic::straight(&Mover::Locations, &segment, piece, [60.0, BEND * TOLERANCE])
                .unwrap()
        };
        whole.iter().flat_map(straight).map(|piece| BoundedPiece::new(&piece, 60.0)).collect()
    }

    /// Distance of a point from the tool at `t`, in cylinder coordinates and by slerp: nothing in common
    /// with the pieces.
    fn distance(body: ConvexBody, [from, to]: &[ToolPose; 2], t: f64, p: &Point3<f64>) -> f64 {
        let axis = from.axis.slerp(&to.axis, t);
        let y = p - (from.tip + (to.tip - from.tip) * t);
        let z = axis.dot(&y);
        let rho = axis.cross(&y).norm();
        match body {
            ConvexBody::Nose { major, minor, top } => {
                let [out, down] = [rho - major, minor - z];
                let round = out.max(0.0).hypot(down.max(0.0)) + out.max(down).min(0.0);
                (round - minor).max(z - top)
            }
            ConvexBody::Tangent(_) => panic!("cut by random programs in `carve`"),
            ConvexBody::Frustum { low, high, radius, slope } => {
                let side = (rho - radius - slope * (z - low)) / slope.hypot(1.0);
                side.max(low - z).max(z - high)
            }
        }
    }

    /// Least distance over the whole move: sampled densely, then by thirds around the best sample.
    fn nearest(body: ConvexBody, ends: &[ToolPose; 2], p: &Point3<f64>) -> f64 {
        let at = |t: f64| distance(body, ends, t, p);
        let best = (0..=100).map(|k| f64::from(k) / 100.0).min_by(|a, b| at(*a).total_cmp(&at(*b)));
        let best = best.unwrap();
        let [mut low, mut high] = [(best - 0.01).max(0.0), (best + 0.01).min(1.0)];
        for _ in 0..40 {
            let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            if at(a) < at(b) { high = b } else { low = a }
        }
        at(low).min(at(best))
    }

    fn body() -> impl Strategy<Value = ConvexBody> {
        prop_oneof![
            Just(ConvexBody::Nose { major: 10.0, minor: 6.0, top: 50.0 }),
            Just(ConvexBody::Nose { major: 0.0, minor: 3.0, top: 20.0 }),
            Just(ConvexBody::Nose { major: 5.0, minor: 0.0, top: 30.0 }),
            Just(ConvexBody::Frustum { low: 20.0, high: 45.0, radius: 12.0, slope: 0.4 }),
        ]
    }

    fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-size..size, -size..size, -size..size].prop_map(Vector3::from)
    }

    proptest! {
        /// Nothing farther than the tolerance from the swept body is cut, nothing deeper in it is left;
        /// turns about both axes, rays from anywhere.
        #[test]
        fn what_is_cut_of_a_ray_is_what_the_body_sweeps(
            body in body(),
            step in vector(4.0),
            lean in vector(0.6),
            turn in vector(0.12),
            through in vector(20.0),
            direction in vector(1.0).prop_filter("no way", |direction| direction.norm() > 0.1),
        ) {
            let axis = Rotation3::new(lean) * Vector3::z();
            let to = Rotation3::new(turn) * axis;
            let pose = |tip, axis| ToolPose { tip: Point3::from(tip), axis: Unit::new_normalize(axis) };
            let ends = [pose(-step, axis), pose(step, to)];
            let line = RayLine { from: Point3::from(through + axis * 12.0), direction: direction.normalize() };
            let mut left = crate::verify::stock::dexel::RaySpans::NONE;
            left.push([-30.0, 30.0]);
            for piece in &pieces(ends) {
                let moving = BodyMotion::new(piece, body, TOLERANCE);
                for at in (0..left.len()).rev() {
                    let span = left.get(at).unwrap();
                    let SweptSpans { first, more } = moving.swept(&line, span, 0.0);
                    for cut in first.into_iter().chain(more) {
                        prop_assert!(span[0] <= cut[0] && cut[0] < cut[1] && cut[1] <= span[1]);
                        left.take(cut);
                    }
                }
            }
            // Evenly, and close to both sides of every end.
            let mut positions: Vec<f64> = (0..=60).map(|k| f64::from(k) - 30.0).collect();
            for end in left.iter().flatten() {
                positions.extend([-1e-2, -1e-4, -1e-6, 1e-6, 1e-4, 1e-2].map(|by| end + by));
            }
            for s in positions.into_iter().filter(|s| s.abs() <= 30.0) {
                let distance = nearest(body, &ends, &line.at(s));
                let kept = left.iter().any(|[low, high]| (low..=high).contains(&s));
                if kept {
                    prop_assert!(distance >= -TOLERANCE, "left {distance} at {s}: {left:?}");
                } else {
                    prop_assert!(distance <= TOLERANCE, "cut {distance} at {s}: {left:?}");
                }
            }
        }
    }

    proptest! {
        /// Planes laid below a body over a whole piece, from one point or from two, bound its distance from below at
        /// every point that they hold for.
        #[test]
        fn planes_are_below_the_distance(
            body in body(),
            step in vector(2.0),
            lean in vector(0.6),
            turn in vector(0.15),
            through in vector(9.0),
            positions in [-20.0..20.0, -20.0..20.0, -9.0..9.0],
            beside in [-3.0..3.0, -3.0..3.0],
        ) {
            let axis = Rotation3::new(lean) * Vector3::z();
            let to = Rotation3::new(turn) * axis;
            let pose = |tip, axis| ToolPose { tip: Point3::from(tip), axis: Unit::new_normalize(axis) };
            let ends = [pose(-step, axis), pose(step, to)];
            let from = Point3::from(through + axis * 12.0);
            let [a, b, s] = positions;
            let at = from + Vector3::new(s, beside[0], beside[1]);
            let truth = nearest(body, &ends, &at) + ERROR * TOLERANCE;
            let mut least = f64::INFINITY;
            for bounded in pieces(ends) {
                let part = MovingPart::new(&bounded, [bounded].into(), body, None);
                let plane = |s: f64| BodyPlane::new(0, &part, 0, &(from + Vector3::x() * s));
                let [one, other] = [plane(a.min(b)), plane(a.max(b))];
                let over = |plane: &BodyPlane| plane.along([at.y, at.z], [at.x, at.x + 1e-9]);
                let meet = one.meet(&other).map_or(f64::NEG_INFINITY, |meet| over(&meet));
                least = least.min(over(&one).max(over(&other)).max(meet));
            }
            // The piece in which it is nearest has all of its planes below that; outside, the truth is less than the
            // distance.
            prop_assert!(truth > 0.0 || least <= truth, "{least} {truth}");
        }
    }

    #[test]
    fn a_ball_moved_straight_cuts_a_capsule() {
        let pose = |x: f64| ToolPose { tip: Point3::new(x, 0.0, 0.0), axis: Vector3::z_axis() };
        let pieces = pieces([pose(-5.0), pose(5.0)]);
        let [piece] = &pieces[..] else { panic!("{}", pieces.len()) };
        let body = ConvexBody::Nose { major: 0.0, minor: 5.0, top: 20.0 };
        let moving = BodyMotion::new(piece, body, TOLERANCE);
        let cut = |x: f64, y: f64, span| {
            let line = RayLine { from: Point3::new(x, y, 0.0), direction: Vector3::z() };
            moving.swept(&line, span, 0.0).first
        };
        let close = |cut: Option<[f64; 2]>, [low, high]: [f64; 2]| {
            let cut = cut.unwrap();
            assert!((cut[0] - low).abs() + (cut[1] - high).abs() < TOLERANCE, "{cut:?}");
        };
        close(cut(0.0, 0.0, [-10.0, 10.0]), [0.0, 10.0]);
        close(cut(2.0, 3.0, [-10.0, 30.0]), [1.0, 20.0]); // 3-4-5
        close(cut(8.0, 0.0, [-10.0, 10.0]), [1.0, 10.0]); // 3-4-5 at the end
        close(cut(8.0, 0.0, [3.0, 10.0]), [3.0, 10.0]);
        assert_eq!(cut(8.0, 0.0, [-10.0, 0.99]), None);
        assert_eq!(cut(0.0, 5.01, [-10.0, 30.0]), None);
    }
}
