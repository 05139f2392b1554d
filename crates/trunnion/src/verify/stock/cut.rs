//! A ray against a body in motion over one piece of a move.
//!
//! The distance `d(s, u)` of a convex body from a point `s` along the ray at time `u` is convex in `s`. Seen
//! from the tool a point moves straight while a piece lasts, but for the bend ([`Piece::bend`]), and pieces
//! are cut until that is below the tolerance: then `d` is convex in `u` as well. In both together it is not,
//! since the ray turns ([`Piece::shear`]). Hence
//!
//! * from the tangents at a point of the ray a plane is known below `d` for all times, the less steep by the
//!   shear the farther off: along such planes the search for where the body begins comes down to it from
//!   outside and cannot step over;
//! * between two such ends there may be a gap, as where a leaning flank turns past a ray. There is none if a
//!   point of the ray is in the body at the times of both ends: it is then in it at all times between.
//!   Otherwise both halves of the time are looked at one by one.
//!
//! The motion is not simplified: distances are those over the piece as it is.

use super::super::body::Body;
use super::super::sweep::Piece;
use nalgebra::{Point3, Vector3};

/// A body in motion over a part of a piece, and how exactly it is looked at \[mm\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving<'a> {
    piece: &'a Piece,
    body: Body,
    tolerance: f64,
    /// From when to when.
    time: [f64; 2],
    /// By how much planes below the distance are less steep farther along the ray.
    shear: f64,
}

/// A line of points `from + s way`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) from: Point3<f64>,
    /// Unit vector.
    pub(super) way: Vector3<f64>,
}

impl Line {
    #[inline]
    pub(super) fn at(&self, s: f64) -> Point3<f64> {
        self.from + self.way * s
    }
}

/// The body at the time at which it is nearest to a point of a line: nowhere on the line is its distance
/// below `bound + slope (s' - s)`.
#[derive(Debug, Clone, Copy)]
struct Nearest {
    distance: f64,
    bound: f64,
    slope: f64,
    u: f64,
}

/// Distance at a time, and its derivatives by time and along the line.
#[derive(Debug, Clone, Copy)]
struct Tangent {
    u: f64,
    distance: f64,
    by_u: f64,
    by_s: f64,
}

impl Tangent {
    /// Least that is possible while the time is between here and `end`.
    fn towards(&self, end: f64) -> Nearest {
        let bound = self.distance - self.by_u.abs() * (end - self.u).abs();
        Nearest { distance: self.distance, bound, slope: self.by_s, u: self.u }
    }

    /// Least that is possible where two planes meet, one falling by time and one rising: the mean of both
    /// that does neither. At a sharp edge only this mean has the slope of what is nearest.
    fn meet(&self, other: &Self) -> Nearest {
        let weight = other.by_u / (other.by_u - self.by_u);
        let mean = |a: f64, b: f64| weight * a + (1.0 - weight) * b;
        let at_zero = |plane: &Self| plane.distance - plane.by_u * plane.u;
        let near = if self.distance < other.distance { self } else { other };
        Nearest {
            distance: near.distance,
            bound: mean(at_zero(self), at_zero(other)),
            slope: mean(self.by_s, other.by_s),
            u: near.u,
        }
    }
}

/// Shares of the tolerance: how far a distance may be below its tangent over time, how far off pieces are as
/// quadratics, how deep a body may dip in without cutting, what a search over time may lose, when the way in
/// counts as found, and what may be taken for a gap. What is cut is then at most
/// `BEND + ERROR + SEARCH + CLOSE + GAP` outside, what is left at most `BEND + ERROR + SEARCH + TOUCH`
/// inside, neither of them more than 1.
pub(super) const BEND: f64 = 0.5;
pub(super) const ERROR: f64 = 0.1;
pub(super) const TOUCH: f64 = 0.15;
const SEARCH: f64 = 0.1;
const CLOSE: f64 = 0.05;
const GAP: f64 = 0.2;
/// Steps of a search for the nearest instant: two of them halve at least, so that this many pass from a metre
/// to below a nanometre.
const STEPS: u32 = 80;
/// Steps on the way in, which gain digits where the ray does not graze.
const WAY_IN: u32 = 500;
/// Places of a cut at which its depth is tried first.
const PLACES: i32 = 8;

/// What a body sweeps of a ray: one interval nearly always.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Swept {
    pub(super) first: Option<[f64; 2]>,
    pub(super) more: Vec<[f64; 2]>,
}

impl Swept {
    fn push(&mut self, cut: [f64; 2]) {
        if self.first.is_none() { self.first = Some(cut) } else { self.more.push(cut) }
    }
}

impl<'a> Moving<'a> {
    pub(super) fn new(piece: &'a Piece, body: Body, tolerance: f64) -> Self {
        Self { piece, body, tolerance, time: [-1.0, 1.0], shear: piece.shear(2.0) }
    }

    /// Over both halves of the time.
    fn halves(&self) -> [Self; 2] {
        let [from, to] = self.time;
        let middle = 0.5 * (from + to);
        let shear = self.piece.shear(middle - from);
        [[from, middle], [middle, to]].map(|time| Self { time, shear, ..*self })
    }

    #[inline]
    fn tangent(&self, line: &Line, s: f64, u: f64) -> Tangent {
        let [distance, by_u, by_s] = self.piece.distance(self.body, u, &line.at(s), &line.way);
        Tangent { u, distance, by_u, by_s }
    }

    /// Distance of the nearest instant from a point of the line; `guess` is where to look first.
    #[inline]
    fn nearest(&self, line: &Line, s: f64, guess: f64) -> Nearest {
        let at = |u: f64| self.tangent(line, s, u);
        let enough = SEARCH * self.tolerance;
        let first = at(guess.clamp(self.time[0], self.time[1]));
        let rises = first.by_u > 0.0;
        let end = self.time[usize::from(!rises)];
        let found = first.towards(end);
        if found.distance - found.bound <= enough {
            return found;
        }
        let last = at(end);
        if (last.by_u > 0.0) == rises || last.by_u == 0.0 {
            return last.towards(end);
        }
        let [mut falling, mut rising] = if rises { [last, first] } else { [first, last] };
        let mut found = falling.meet(&rising);
        for step in 0..STEPS {
            if found.distance - found.bound <= enough {
                break;
            }
            // Where the slope is zero if it is linear, and where the two planes meet if it jumps.
            let share = if step % 2 == 0 {
                falling.by_u / (falling.by_u - rising.by_u)
            } else {
                (found.bound - falling.distance) / (falling.by_u * (rising.u - falling.u))
            };
            let share = if (0.0..=1.0).contains(&share) { share } else { 0.5 };
            let here = at(falling.u + share * (rising.u - falling.u));
            let before = found;
            *(if here.by_u > 0.0 { &mut rising } else { &mut falling }) = here;
            found = falling.meet(&rising);
            if before.distance < found.distance {
                (found.distance, found.u) = (before.distance, before.u);
            }
        }
        found
    }

    /// What the body sweeps of `low..high`, but for what it dips in by less than the tolerance.
    pub(super) fn swept(&self, line: &Line, span: [f64; 2]) -> Swept {
        let mut found = Swept::default();
        self.sweep(line, span, &mut found);
        found
    }

    fn sweep(&self, line: &Line, span: [f64; 2], found: &mut Swept) {
        let Some(cut) = self.hull(line, span) else { return };
        let [low, high] = cut.map(|end| end.0);
        if self.has_no_gap(line, cut) {
            found.push([low, high]);
            return;
        }
        // A quarter of what the ray turns, at its ends, is what it can be off in between.
        let [from, to] = self.time;
        if 0.25 * self.piece.shear(to - from) * (high - low) <= GAP * self.tolerance {
            found.push([low, high]);
            return;
        }
        for half in self.halves() {
            half.sweep(line, [low, high], found);
        }
    }

    /// Whether a point between both ends is in the body at both their times.
    fn has_no_gap(&self, line: &Line, [low, high]: [(f64, f64); 2]) -> bool {
        let same = (low.1 - high.1).abs() <= f64::EPSILON;
        let holds =
            |s: f64| [low.1, high.1].iter().all(|&u| self.tangent(line, s, u).distance <= 0.0);
        same || holds(0.5 * (low.0 + high.0)) || holds(high.0) || holds(low.0)
    }

    /// Lowest and highest end of what is swept of a span, each with its time.
    fn hull(&self, line: &Line, [low, high]: [f64; 2]) -> Option<[(f64, f64); 2]> {
        let touch = -TOUCH * self.tolerance;
        let length = high - low;
        let top = self.nearest(line, high, 0.0);
        if top.distance <= touch {
            return Some([self.other_end(line, [high, low], &top), (high, top.u)]);
        }
        // Below it gets no nearer than this.
        if top.bound - (top.slope + self.shear).max(0.0) * length > touch {
            return None;
        }
        let bottom = self.nearest(line, low, top.u);
        if bottom.distance <= touch {
            return Some([(low, bottom.u), self.other_end(line, [low, high], &bottom)]);
        }
        let from = self.enter(line, [low, high], bottom)?;
        let to = self.enter(line, [high, low], top)?;
        (from.0 < to.0 && self.deepest(line, [from.0, to.0], touch) <= touch).then_some([from, to])
    }

    /// From `inside` towards `end`: where the body ends, and when.
    fn other_end(&self, line: &Line, [inside, end]: [f64; 2], at: &Nearest) -> (f64, f64) {
        let way = if end > inside { 1.0 } else { -1.0 };
        // The plane from inside leads out.
        let rise = at.slope * way - self.shear;
        let steps = if rise > 0.0 { -at.bound / rise } else { f64::MAX };
        let out = if steps < (end - inside) * way { inside + way * steps } else { end };
        let here = self.nearest(line, out, at.u);
        if here.bound <= CLOSE * self.tolerance {
            return (out, here.u);
        }
        self.enter(line, [out, inside], here).unwrap_or((inside, at.u))
    }

    /// From `from`, outside, towards `to`: where the body begins, and when.
    fn enter(&self, line: &Line, [from, to]: [f64; 2], mut here: Nearest) -> Option<(f64, f64)> {
        let way = if to > from { 1.0 } else { -1.0 };
        let mut s = from;
        for _ in 0..WAY_IN {
            if here.bound <= CLOSE * self.tolerance {
                break;
            }
            let fall = self.shear - here.slope * way;
            if fall <= 0.0 {
                return None;
            }
            s += way * here.bound / fall;
            if (to - s) * way < 0.0 {
                return None;
            }
            here = self.nearest(line, s, here.u);
        }
        Some((s, here.u))
    }

    /// Least distance over an interval: the best of some places, and of what halving finds around it; the
    /// search ends where it is at most `enough`.
    fn deepest(&self, line: &Line, [low, high]: [f64; 2], enough: f64) -> f64 {
        let step = (high - low) / f64::from(PLACES);
        let mut best = (f64::INFINITY, low);
        // The middle first.
        for place in [4, 2, 6, 1, 3, 5, 7, 0, 8] {
            let s = low + step * f64::from(place);
            let distance = self.nearest(line, s, 0.0).distance;
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
            let here = self.nearest(line, 0.5 * (low + high), 0.0);
            deepest = deepest.min(here.distance);
            if deepest <= enough || here.slope.abs() * (high - low) <= SEARCH * self.tolerance {
                break;
            }
            if here.slope > 0.0 { high = 0.5 * (low + high) } else { low = 0.5 * (low + high) }
        }
        deepest
    }

    /// How deep the body gets below the surface of what it sweeps of a ray, if that is deeper than `known`.
    pub(super) fn depth(&self, line: &Line, [low, high]: [f64; 2], known: f64) -> Option<f64> {
        let half = 0.5 * (high - low);
        let middle = self.nearest(line, low + half, 0.0);
        if half * (middle.slope.abs() + self.shear) - middle.bound <= known {
            return None;
        }
        Some(-self.deepest(line, [low, high], f64::NEG_INFINITY)).filter(|depth| *depth > known)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::replay::{Course, Mover, Segment};
    use super::super::super::sweep::straight_pieces;
    use super::*;
    use crate::types::{AxisVector, ToolPose};
    use nalgebra::{Rotation3, Unit};
    use proptest::prelude::*;

    const TOLERANCE: f64 = 1e-3;

    fn pieces(ends: [ToolPose; 2]) -> Vec<Piece> {
        let (joints, course) = ([AxisVector::zeros(); 2], Course::Circle { ends });
        let segment = Segment { line: 1, joints, course, duration: 1.0, rapid: false };
        let mut pieces = Vec::new();
        let shares = [ERROR * TOLERANCE, BEND * TOLERANCE];
        straight_pieces(&Mover::Locations, &segment, 60.0, shares, &mut pieces).unwrap();
        pieces
    }

    /// Distance of a point from the tool at `t`, in cylinder coordinates and by slerp: nothing in common
    /// with the pieces.
    fn distance(body: Body, [from, to]: &[ToolPose; 2], t: f64, p: &Point3<f64>) -> f64 {
        let axis = from.axis.slerp(&to.axis, t);
        let y = p - (from.tip + (to.tip - from.tip) * t);
        let z = axis.dot(&y);
        let rho = axis.cross(&y).norm();
        match body {
            Body::Nose { major, minor, top } => {
                let [out, down] = [rho - major, minor - z];
                let round = out.max(0.0).hypot(down.max(0.0)) + out.max(down).min(0.0);
                (round - minor).max(z - top)
            }
            Body::Frustum { low, high, radius, slope } => {
                let side = (rho - radius - slope * (z - low)) / slope.hypot(1.0);
                side.max(low - z).max(z - high)
            }
        }
    }

    /// Least distance over the whole move: sampled densely, then by thirds around the best sample.
    fn nearest(body: Body, ends: &[ToolPose; 2], p: &Point3<f64>) -> f64 {
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

    fn body() -> impl Strategy<Value = Body> {
        prop_oneof![
            Just(Body::Nose { major: 10.0, minor: 6.0, top: 50.0 }),
            Just(Body::Nose { major: 0.0, minor: 3.0, top: 20.0 }),
            Just(Body::Nose { major: 5.0, minor: 0.0, top: 30.0 }),
            Just(Body::Frustum { low: 20.0, high: 45.0, radius: 12.0, slope: 0.4 }),
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
            way in vector(1.0).prop_filter("no way", |way| way.norm() > 0.1),
        ) {
            let axis = Rotation3::new(lean) * Vector3::z();
            let to = Rotation3::new(turn) * axis;
            let pose = |tip, axis| ToolPose { tip: Point3::from(tip), axis: Unit::new_normalize(axis) };
            let ends = [pose(-step, axis), pose(step, to)];
            let line = Line { from: Point3::from(through + axis * 12.0), way: way.normalize() };
            let mut left = super::super::rays::Spans::NONE;
            left.push([-30.0, 30.0]);
            for piece in &pieces(ends) {
                let moving = Moving::new(piece, body, TOLERANCE);
                for at in (0..left.len()).rev() {
                    let span = left.get(at).unwrap();
                    let Swept { first, more } = moving.swept(&line, span);
                    for cut in first.into_iter().chain(more) {
                        prop_assert!(span[0] <= cut[0] && cut[0] < cut[1] && cut[1] <= span[1]);
                        left.take(cut);
                    }
                }
            }
            // Evenly, and close to both sides of every end.
            let mut places: Vec<f64> = (0..=60).map(|k| f64::from(k) - 30.0).collect();
            for end in left.iter().flatten() {
                places.extend([-1e-2, -1e-4, -1e-6, 1e-6, 1e-4, 1e-2].map(|by| end + by));
            }
            for s in places.into_iter().filter(|s| s.abs() <= 30.0) {
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

    #[test]
    fn a_ball_moved_straight_cuts_a_capsule() {
        let pose = |x: f64| ToolPose { tip: Point3::new(x, 0.0, 0.0), axis: Vector3::z_axis() };
        let pieces = pieces([pose(-5.0), pose(5.0)]);
        let [piece] = &pieces[..] else { panic!("{}", pieces.len()) };
        let body = Body::Nose { major: 0.0, minor: 5.0, top: 20.0 };
        let moving = Moving::new(piece, body, TOLERANCE);
        let cut = |x: f64, y: f64, span| {
            let line = Line { from: Point3::new(x, y, 0.0), way: Vector3::z() };
            moving.swept(&line, span).first
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
