//! Collisions of the tool with stock or fixtures.

use nalgebra::Point3;
use std::fmt;

/// What went wrong between tool and material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CollisionKind {
    /// The cutting part is in the stock at rapid speed.
    Rapid,
    /// Shank or holder run into the stock.
    Holder,
    /// Any part of the tool runs into a fixture.
    Fixture,
}

/// One line of a program that runs into something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collision {
    /// Into what, with what.
    pub kind: CollisionKind,
    /// Line of the program.
    pub line: u32,
    /// How deep it is in the tool, at least; in stock, where that is more than rays are apart, on the rays \[mm\].
    pub depth: f64,
    /// The deepest place, or the middle of the deepest ray \[mm\].
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
