//! Lines and arcs of a contour in their plane.

use crate::math;
use std::f64::consts::TAU;

/// Slack of points on an element \[mm\].
const SLACK: f64 = 1e-9;

/// A line or an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaneElement {
    pub(super) start: [f64; 2],
    pub(super) end: [f64; 2],
    pub(super) way: ElementWay,
}

/// The way of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ElementWay {
    Line,
    /// About a centre, counterclockwise for a positive sweep \[rad\].
    Arc {
        center: [f64; 2],
        sweep: f64,
    },
}

/// Side of the way to which a contour turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FilletSide {
    Left,
    Right,
}

impl FilletSide {
    /// Returns 1 for left, -1 for right.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }

    /// Returns the unit vector square to a direction, on this side.
    pub(super) fn normal(self, [u, v]: [f64; 2]) -> [f64; 2] {
        scaled([-v, u], self.sign())
    }

    /// Returns the angle from one radius to another on an arc that turns to this side, below a full turn.
    pub(super) fn sweep(self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let angle = math::atan2(cross(from, to), dot(from, to));
        self.sign() * (self.sign() * angle).rem_euclid(TAU)
    }
}

impl PlaneElement {
    /// Returns the direction in which it begins.
    pub(super) fn first_direction(&self) -> Option<[f64; 2]> {
        self.direction(self.start)
    }

    /// Returns the direction in which it ends.
    pub(super) fn last_direction(&self) -> Option<[f64; 2]> {
        self.direction(self.end)
    }

    fn direction(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let way = match self.way {
            ElementWay::Line => minus(self.end, self.start),
            ElementWay::Arc { center, sweep } => {
                scaled(FilletSide::Left.normal(minus(at, center)), sweep.signum())
            }
        };
        let length = norm(way);
        (length > SLACK).then(|| scaled(way, 1.0 / length))
    }

    /// Returns it run through the other way.
    pub(super) fn reversed(self) -> Self {
        let way = match self.way {
            ElementWay::Line => ElementWay::Line,
            ElementWay::Arc { center, sweep } => ElementWay::Arc { center, sweep: -sweep },
        };
        Self { start: self.end, end: self.start, way }
    }

    /// Returns the points at a distance to the left of both this element and another.
    pub(super) fn centers_beside(&self, other: &Self, left: f64) -> [Option<[f64; 2]>; 2] {
        match (self.beside(left), other.beside(left)) {
            (Some(Parallel::Line(a)), Some(Parallel::Line(b))) => [meet_lines(a, b), None],
            (Some(Parallel::Line(line)), Some(Parallel::Circle(circle)))
            | (Some(Parallel::Circle(circle)), Some(Parallel::Line(line))) => {
                meet_line_and_circle(line, circle)
            }
            (Some(Parallel::Circle(a)), Some(Parallel::Circle(b))) => meet_circles(a, b),
            _ => [None, None],
        }
    }

    /// Returns the curve at a distance to its left.
    fn beside(&self, left: f64) -> Option<Parallel> {
        match self.way {
            ElementWay::Line => {
                let direction = self.first_direction()?;
                let point = plus(self.start, scaled(FilletSide::Left.normal(direction), left));
                Some(Parallel::Line(ParallelLine { point, direction }))
            }
            ElementWay::Arc { center, sweep } => {
                // Left of a counterclockwise arc is its inside.
                let radius = norm(minus(self.start, center)) - left * sweep.signum();
                (radius > SLACK).then_some(Parallel::Circle(ParallelCircle { center, radius }))
            }
        }
    }

    /// Returns the nearest point on the line or circle of the element.
    pub(super) fn foot(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        match self.way {
            ElementWay::Line => {
                let direction = self.first_direction()?;
                let along = dot(minus(point, self.start), direction);
                Some(plus(self.start, scaled(direction, along)))
            }
            ElementWay::Arc { center, .. } => {
                let out = minus(point, center);
                let radius = norm(minus(self.start, center));
                (norm(out) > SLACK).then(|| plus(center, scaled(out, radius / norm(out))))
            }
        }
    }

    /// Returns the length, or the angle, from the start to a point on the element; `None`: it is not on it.
    fn share(&self, point: [f64; 2]) -> Option<f64> {
        match self.way {
            ElementWay::Line => {
                let whole = norm(minus(self.end, self.start));
                let along = dot(minus(point, self.start), self.first_direction()?);
                (-SLACK..=whole + SLACK).contains(&along).then_some(along)
            }
            ElementWay::Arc { center, sweep } => {
                let side = if sweep > 0.0 { FilletSide::Left } else { FilletSide::Right };
                let [from, to] = [self.start, point].map(|at| minus(at, center));
                let angle = side.sweep(from, to).abs();
                let slack = SLACK / norm(from).max(SLACK);
                // A point at the very start may count as one full turn by rounding.
                let angle = if angle > TAU - slack { 0.0 } else { angle };
                (angle <= sweep.abs() + slack).then_some(angle)
            }
        }
    }

    /// Returns the part up to a point on it.
    pub(super) fn up_to(&self, point: [f64; 2]) -> Option<Self> {
        let share = self.share(point)?;
        let way = match self.way {
            ElementWay::Line => ElementWay::Line,
            ElementWay::Arc { center, sweep } => {
                ElementWay::Arc { center, sweep: sweep.signum() * share }
            }
        };
        Some(Self { end: point, way, ..*self })
    }

    /// Returns the part from a point on it.
    pub(super) fn from(&self, point: [f64; 2]) -> Option<Self> {
        let share = self.share(point)?;
        let way = match self.way {
            ElementWay::Line => ElementWay::Line,
            ElementWay::Arc { center, sweep } => {
                ElementWay::Arc { center, sweep: sweep - sweep.signum() * share }
            }
        };
        Some(Self { start: point, way, ..*self })
    }
}

/// A curve parallel to an element.
#[derive(Debug, Clone, Copy)]
enum Parallel {
    Line(ParallelLine),
    Circle(ParallelCircle),
}

#[derive(Debug, Clone, Copy)]
struct ParallelLine {
    point: [f64; 2],
    /// Of length 1.
    direction: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
struct ParallelCircle {
    center: [f64; 2],
    radius: f64,
}

fn meet_lines(a: ParallelLine, b: ParallelLine) -> Option<[f64; 2]> {
    // a + t d = b + s e, crossed with e.
    let across = cross(a.direction, b.direction);
    let along = cross(minus(b.point, a.point), b.direction) / across;
    along.is_finite().then(|| plus(a.point, scaled(a.direction, along)))
}

fn meet_line_and_circle(line: ParallelLine, circle: ParallelCircle) -> [Option<[f64; 2]>; 2] {
    let along = dot(minus(circle.center, line.point), line.direction);
    let foot = plus(line.point, scaled(line.direction, along));
    let away = norm(minus(foot, circle.center));
    // Pythagoras: half the chord.
    let half = half_chord(circle.radius, away);
    [1.0, -1.0].map(|sign| Some(plus(foot, scaled(line.direction, sign * half?))))
}

fn meet_circles(a: ParallelCircle, b: ParallelCircle) -> [Option<[f64; 2]>; 2] {
    let between = minus(b.center, a.center);
    let distance = norm(between);
    if distance <= SLACK {
        return [None, None];
    }
    let direction = scaled(between, 1.0 / distance);
    // From a^2 = x^2 + y^2 and b^2 = (d - x)^2 + y^2.
    let along =
        (distance * distance + a.radius * a.radius - b.radius * b.radius) / (2.0 * distance);
    let foot = plus(a.center, scaled(direction, along));
    let half = half_chord(a.radius, along);
    [FilletSide::Left, FilletSide::Right]
        .map(|side| Some(plus(foot, scaled(side.normal(direction), half?))))
}

/// Returns half the chord of a circle at a distance from its centre.
fn half_chord(radius: f64, away: f64) -> Option<f64> {
    let square = radius * radius - away * away;
    // Curves that touch may miss each other by rounding.
    (square >= -SLACK * radius).then(|| square.max(0.0).sqrt())
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

pub(super) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn scaled([u, v]: [f64; 2], by: f64) -> [f64; 2] {
    [by * u, by * v]
}

pub(super) fn norm([u, v]: [f64; 2]) -> f64 {
    math::hypot(u, v)
}
