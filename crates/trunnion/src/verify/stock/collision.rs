//! Collisions of the tool with stock or fixtures.

use nalgebra::Point3;
use std::fmt;

/// Kind of a collision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum CollisionKind {
    /// The cutting part is in the stock at rapid speed.
    Rapid,
    /// Shank or holder are in the stock.
    Holder,
    /// Any part of the tool is in a fixture.
    Fixture,
}

/// Collision of one program line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Collision {
    /// Kind of the collision.
    pub kind: CollisionKind,
    /// Line of the program.
    pub line: u32,
    /// Least depth inside the tool \[mm\]. In stock, depths above the ray spacing are those on the rays.
    pub depth: f64,
    /// Deepest point, or the middle of the deepest ray \[mm\].
    pub point: Point3<f64>,
}

impl fmt::Display for Collision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, line, depth, point: p } = self;
        let what = match kind {
            CollisionKind::Rapid => "cuts at rapid speed",
            CollisionKind::Holder => "shank or holder run into the stock",
            CollisionKind::Fixture => "runs into a fixture",
        };
        write!(
            f,
            "line {line}: {what}, {depth:.4} mm deep at X {:.3} Y {:.3} Z {:.3}",
            p.x, p.y, p.z
        )
    }
}
