//! Corners of a contour that a cutter follows beside it.

use crate::math;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Bends up to this angle need no corner \[rad\], as `LinuxCNC`'s interpreter has it.
const SMOOTH: f64 = 0.05;

/// Angles below this are rounding \[rad\].
const SAME_ANGLE: f64 = 1e-9;

/// Side of the contour on which the cutter is, seen along the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CutterSide {
    /// `G41`.
    Left,
    /// `G42`.
    Right,
}

impl CutterSide {
    /// Returns 1 for left, -1 for right.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }

    pub(super) fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// Returns true if a cutter on this side of an arc is towards its centre; `turn` is positive counterclockwise.
    pub(super) fn is_inside(self, turn: f64) -> bool {
        self.sign() * turn > 0.0
    }

    /// Returns the unit vector across a direction, towards the cutter.
    pub(super) fn across(self, direction: [f64; 2]) -> [f64; 2] {
        scaled([-direction[1], direction[0]], self.sign())
    }
}

/// A compensated move, of the centre of the cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum OffsetWay {
    /// With the direction of the programmed move; zero where none is known.
    Line { direction: [f64; 2] },
    /// About a centre; `turn` is positive counterclockwise, whole turns included; `sweep` is the programmed angle.
    Arc { center: [f64; 2], turn: i32, sweep: f64 },
}

/// Kind of a corner, seen from the cutter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CornerKind {
    /// The contour bends towards the cutter: both moves end where their offsets meet.
    Inside,
    /// It bends away: the cutter rolls about the corner.
    Outside,
    /// It goes on.
    Smooth,
}

/// A corner of the contour.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContourCorner {
    /// Programmed point.
    pub(super) at: [f64; 2],
    /// Centre of the cutter at the end of the move before.
    pub(super) before: [f64; 2],
    pub(super) side: CutterSide,
    /// Radius of the cutter.
    pub(super) radius: f64,
}

/// The next arc of a contour as it meets a corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContourArc {
    pub(super) center: [f64; 2],
    pub(super) radius: f64,
    /// Positive counterclockwise.
    pub(super) turn: f64,
}

impl ContourCorner {
    /// Returns the angle through which the cutter would roll about the corner, from -π/2 on; `across` is the unit
    /// vector to the cutter at the beginning of the next move.
    fn roll(&self, across: [f64; 2]) -> f64 {
        let before = minus(self.before, self.at);
        let angle = self.side.sign() * math::atan2(cross(across, before), dot(across, before));
        if angle < -FRAC_PI_2 { angle + TAU } else { angle }
    }

    /// Returns the kind of the corner to a line; `held` is the move before it.
    pub(super) fn kind_to_line(&self, across: [f64; 2], held: Option<OffsetWay>) -> CornerKind {
        let roll = self.roll(across);
        // A half turn behind an arc that bulges towards the cutter stays above and beside it.
        let bulges = matches!(held, Some(OffsetWay::Arc { turn, .. }) if !self.side.is_inside(f64::from(turn)));
        if roll > PI - SMOOTH && bulges { CornerKind::Inside } else { kind(roll) }
    }

    /// Returns the kind of the corner to an arc.
    pub(super) fn kind_to_arc(&self, across: [f64; 2], arc: &ContourArc) -> CornerKind {
        let roll = self.roll(across);
        let closed = (roll - PI).abs() < SMOOTH && !self.side.is_inside(arc.turn);
        if closed { CornerKind::Inside } else { kind(roll) }
    }

    /// Returns the direction of the move before, if it was a line.
    fn direction_before(&self) -> [f64; 2] {
        let [u, v] = unit(minus(self.before, self.at));
        scaled([v, -u], self.side.sign())
    }

    /// Returns the point where the offsets of two lines meet.
    pub(super) fn line_to_line(&self, across: [f64; 2]) -> Option<[f64; 2]> {
        let half = 0.5 * (self.roll(across) + PI);
        let back = self.radius / math::tan(half);
        back.is_finite().then(|| plus(self.before, scaled(self.direction_before(), -back)))
    }

    /// Returns the point where the offset of the arc before meets that of a line with this direction; `end` is the end
    /// of the arc before.
    pub(super) fn arc_to_line(
        &self,
        held: OffsetWay,
        end: [f64; 2],
        direction: [f64; 2],
    ) -> Option<[f64; 2]> {
        let OffsetWay::Arc { center, turn, .. } = held else { return None };
        let across = self.side.across(direction);
        // Distance from the centre of the arc to the offset of the line, along the normal to the cutter.
        let off = self.radius - dot(minus(center, self.at), across);
        let half = half_chord(distance(center, end), off)?;
        let ahead = if self.side.is_inside(f64::from(turn)) { -half } else { half };
        Some(plus(plus(center, scaled(across, off)), scaled(direction, ahead)))
    }

    /// Returns the point where the offset of the line before meets that of an arc.
    pub(super) fn line_to_arc(&self, arc: &ContourArc) -> Option<[f64; 2]> {
        let direction = self.direction_before();
        let across = [-direction[1], direction[0]];
        let off = dot(minus(self.before, arc.center), across);
        let half = half_chord(self.offset_radius(arc), off)?;
        let ahead = if self.side.is_inside(arc.turn) { half } else { -half };
        Some(plus(plus(arc.center, scaled(across, off)), scaled(direction, ahead)))
    }

    /// Returns the point where the offsets of two arcs meet; `end` is the end of the one before.
    pub(super) fn arc_to_arc(
        &self,
        held: OffsetWay,
        end: [f64; 2],
        arc: &ContourArc,
    ) -> Option<[f64; 2]> {
        let OffsetWay::Arc { center, turn, .. } = held else { return None };
        let before = distance(center, end);
        let apart = distance(center, arc.center);
        if before <= 0.0 || apart <= 0.0 {
            return None;
        }
        // Law of cosines in the triangle of both centres and the meeting point.
        let radius = self.offset_radius(arc);
        let cosine = (before * before + apart * apart - radius * radius) / (2.0 * before * apart);
        let (sin, cos) = math::sin_cos((cosine.abs() <= 1.0).then(|| math::acos(cosine))?);
        let inside = self.side.is_inside(f64::from(turn));
        let sense = if inside == (arc.turn > 0.0) { 1.0 } else { -1.0 };
        let along = scaled(minus(arc.center, center), 1.0 / apart);
        let across = scaled([-along[1], along[0]], sense);
        Some(plus(center, scaled(plus(scaled(along, cos), scaled(across, sin)), before)))
    }

    /// Returns the radius of an arc at the centre of the cutter.
    pub(super) fn offset_radius(&self, arc: &ContourArc) -> f64 {
        if self.side.is_inside(arc.turn) {
            arc.radius - self.radius
        } else {
            arc.radius + self.radius
        }
    }
}

fn kind(roll: f64) -> CornerKind {
    if !(-SMOOTH..=PI + SMOOTH).contains(&roll) {
        CornerKind::Inside
    } else if roll > SMOOTH {
        CornerKind::Outside
    } else {
        CornerKind::Smooth
    }
}

/// Returns half the chord that a line cuts from a circle.
fn half_chord(radius: f64, off: f64) -> Option<f64> {
    (off.abs() <= radius).then(|| (radius * radius - off * off).sqrt())
}

pub(super) fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

pub(super) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn scaled(a: [f64; 2], by: f64) -> [f64; 2] {
    [a[0] * by, a[1] * by]
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    math::hypot(a[0] - b[0], a[1] - b[1])
}

/// Returns the direction of a vector; zero for none.
pub(super) fn unit(a: [f64; 2]) -> [f64; 2] {
    let length = math::hypot(a[0], a[1]);
    if length > 0.0 { scaled(a, 1.0 / length) } else { [0.0; 2] }
}

/// Returns what is left of an arc that was programmed to run through an angle, up to a whole turn.
pub(super) fn sweep_left(center: [f64; 2], ends: [[f64; 2]; 2], turn: i32, programmed: f64) -> f64 {
    let left = sweep(center, ends, turn);
    // Ends of a whole circle are the same point but for the last bits.
    if left.abs() < SAME_ANGLE && programmed.abs() > PI { left + TAU.copysign(left) } else { left }
}

/// Returns the angle from one point to another about a centre in the sense of `turn`, up to a whole turn.
pub(super) fn sweep(center: [f64; 2], ends: [[f64; 2]; 2], turn: i32) -> f64 {
    let [from, to] = ends.map(|end| minus(end, center));
    let angle = math::atan2(cross(from, to), dot(from, to));
    if turn > 0 {
        if angle > 0.0 { angle } else { angle + TAU }
    } else if angle < 0.0 {
        angle
    } else {
        angle - TAU
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Option<[f64; 2]>, expected: [f64; 2]) {
        let found = found.unwrap();
        assert!(distance(found, expected) < 1e-12, "{found:?} is not {expected:?}");
    }

    #[test]
    fn a_square_corner_is_met_or_rolled_about() {
        // Along X to the origin, then up or down, with a cutter of radius 1 on the left.
        let corner =
            ContourCorner { at: [0.0; 2], before: [0.0, 1.0], side: CutterSide::Left, radius: 1.0 };
        let up = CutterSide::Left.across([0.0, 1.0]);
        assert_eq!(corner.kind_to_line(up, None), CornerKind::Inside);
        near(corner.line_to_line(up), [-1.0, 1.0]);
        let down = CutterSide::Left.across([0.0, -1.0]);
        assert_eq!(corner.kind_to_line(down, None), CornerKind::Outside);
        let on = CutterSide::Left.across([1.0, 0.0]);
        assert_eq!(corner.kind_to_line(on, None), CornerKind::Smooth);
    }

    #[test]
    fn a_whole_circle_stays_whole() {
        let ends = [[1.0, 0.0], [1.0, 1e-15]];
        for (turn, programmed) in [(1, TAU), (-1, -TAU)] {
            let left = sweep_left([0.0; 2], ends, turn, programmed);
            assert!((left - programmed).abs() < 1e-12, "{left}");
        }
        assert!(sweep_left([0.0; 2], ends, 1, 0.1) < 1e-12);
    }

    #[test]
    fn offsets_of_arcs_meet_those_of_lines_and_arcs() {
        // Along X to the origin, then counterclockwise about (-5, 0) to the inside.
        let corner =
            ContourCorner { at: [0.0; 2], before: [0.0, 1.0], side: CutterSide::Left, radius: 1.0 };
        let arc = ContourArc { center: [-5.0, 0.0], radius: 5.0, turn: 1.0 };
        near(corner.line_to_arc(&arc), [-5.0 + 15_f64.sqrt(), 1.0]);
        // About (-5, 0) to the origin, then back along X.
        let corner = ContourCorner { before: [-1.0, 0.0], ..corner };
        let held = OffsetWay::Arc { center: [-5.0, 0.0], turn: 1, sweep: 1.0 };
        near(corner.arc_to_line(held, [-1.0, 0.0], [-1.0, 0.0]), [-5.0 + 15_f64.sqrt(), -1.0]);
        // Two circles of radius 5, six apart, cutters inside of both: offsets meet on the middle line.
        let other = ContourArc { center: [1.0, 0.0], radius: 5.0, turn: 1.0 };
        near(corner.arc_to_arc(held, [-1.0, 0.0], &other), [-2.0, 7_f64.sqrt()]);
    }
}
