//! Legs of which a path consists: straight ones and arcs.

use super::block::{BlockKind, BlockShape, BlockStart, LETTERS, MotionBlock};
use super::pace::Pace;
use crate::math;
use nalgebra::{SVector, Vector3};
use std::f64::consts::TAU;

/// A vector of all letters.
pub type LetterVector = SVector<f64, LETTERS>;

/// Length that one radian counts \[mm\], where moves of rotaries and of the tip are measured together.
pub(super) const RADIAN: f64 = 10.0;

/// Length below which a block does not move \[mm\]: rounding of positions.
pub(super) const SHORTEST: f64 = 1e-7;

/// Curve of a leg by its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LegCurve {
    /// Start, and change of the letters per length.
    Line([LetterVector; 2]),
    Arc(Arc),
}

/// A leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    pub(super) curve: LegCurve,
    pub(super) length: f64,
    pub(super) block: u32,
    /// Seconds per length at the programmed speed: of a feed, and of a rapid move. Zero for the other kind.
    pub(super) rates: [f64; 2],
    pub(super) kind: BlockKind,
    pub(super) begins: BlockStart,
    /// Limits of the axes to a change of speed, where the block has a time of its own.
    pub(super) pace: Pace,
}

/// Splits letters into X Y Z, A B C and U V W.
pub(super) fn triples(of: &LetterVector) -> [Vector3<f64>; 3] {
    [0, 3, 6].map(|at| Vector3::new(of[at], of[at + 1], of[at + 2]))
}

/// Returns the length of a move: X Y Z, U V W and the rotaries together.
fn length(of: &LetterVector) -> f64 {
    let [xyz, abc, uvw] = triples(of);
    (xyz.norm_squared() + uvw.norm_squared() + (abc * RADIAN).norm_squared()).sqrt()
}

/// Returns the length to which the programmed speed refers.
fn programmed_length(of: &LetterVector) -> f64 {
    let [xyz, abc, uvw] = triples(of).map(|triple| triple.norm());
    if xyz > SHORTEST {
        xyz
    } else if uvw > SHORTEST {
        uvw
    } else {
        abc
    }
}

impl Leg {
    /// Returns the leg of a block; `None` for a block that does not move.
    pub(super) fn of(block: &MotionBlock) -> Option<Self> {
        let [start, end] = [block.start, block.end].map(LetterVector::from);
        let step = end - start;
        let arc = match block.shape {
            BlockShape::Line => None,
            BlockShape::Arc { center, normal, turns } => {
                Arc::new([start, end], center.into(), normal.into(), turns)
            }
        };
        let (curve, length, programmed) = if let Some(arc) = arc {
            (LegCurve::Arc(arc), arc.length, arc.travel)
        } else {
            let length = length(&step);
            (LegCurve::Line([start, step / length]), length, programmed_length(&step))
        };
        (length > SHORTEST).then_some(())?;
        let rate = programmed / (length * block.speed);
        let rates = if block.kind == BlockKind::Rapid { [0.0, rate] } else { [rate, 0.0] };
        let (number, kind, begins) = (block.number, block.kind, block.begins);
        let pace = Pace::FREE;
        Some(Self { curve, length, block: number, rates, kind, begins, pace })
    }

    /// Returns the seconds per length at the programmed speed.
    pub(super) fn rate(&self) -> f64 {
        let [feed, rapid] = self.rates;
        feed + rapid
    }

    /// Returns the letters and their derivatives at a length from the start.
    pub(super) fn at(&self, x: f64) -> [LetterVector; 4] {
        match &self.curve {
            LegCurve::Line([start, direction]) => {
                let none = LetterVector::zeros();
                [start + direction * x, *direction, none, none]
            }
            LegCurve::Arc(arc) => arc.at(x),
        }
    }

    /// Returns the largest distance of nodes that follow its curve.
    pub(super) fn largest_step(&self) -> f64 {
        match &self.curve {
            LegCurve::Line(_) => f64::INFINITY,
            LegCurve::Arc(arc) => LARGEST_ARC / arc.turn.abs(),
        }
    }
}

/// Angle of an arc between two nodes \[rad\]: the quintic between them is as good as round.
const LARGEST_ARC: f64 = 0.1;

/// A helix, or a spiral where both ends have different radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    start: LetterVector,
    /// Change of the letters per length, without the circle.
    drift: LetterVector,
    center: Vector3<f64>,
    /// Directions at the start, radial and along the arc.
    axes: [Vector3<f64>; 2],
    /// Radius at the start, and its change per length.
    radius: [f64; 2],
    /// Angle per length \[rad\].
    turn: f64,
    length: f64,
    /// Length of X Y Z alone.
    travel: f64,
}

impl Arc {
    /// `None` without a radius or a normal: the block is a line then.
    fn new(
        ends: [LetterVector; 2],
        center: Vector3<f64>,
        normal: Vector3<f64>,
        turns: i32,
    ) -> Option<Self> {
        let axis = normal.try_normalize(0.0)?;
        let arms = ends.map(|end| triples(&end)[0] - center);
        let heights = arms.map(|arm| arm.dot(&axis));
        let flat = [arms[0] - axis * heights[0], arms[1] - axis * heights[1]];
        let radii = flat.map(|arm| arm.norm());
        let first = flat[0].try_normalize(SHORTEST)?;
        let second = axis.cross(&first);
        let angle =
            whole_angle(math::atan2(flat[1].dot(&second), flat[1].dot(&first)), turns, radii[0]);
        // X Y Z drift along the axis alone, the other letters in proportion.
        let rise = heights[1] - heights[0];
        let mut drift = ends[1] - ends[0];
        drift.fixed_rows_mut::<3>(0).copy_from(&(axis * rise));
        let along = 0.5 * (radii[0] + radii[1]) * angle;
        let travel = math::hypot(along, rise);
        let [_, abc, uvw] = triples(&drift);
        let others = uvw.norm_squared() + (abc * RADIAN).norm_squared();
        let length = (travel * travel + others).sqrt();
        Some(Self {
            start: ends[0],
            drift: drift / length,
            center: center + axis * heights[0],
            axes: [first, second],
            radius: [radii[0], (radii[1] - radii[0]) / length],
            turn: angle / length,
            length,
            travel,
        })
    }

    fn at(&self, x: f64) -> [LetterVector; 4] {
        let (sin, cos) = math::sin_cos(self.turn * x);
        let [first, second] = self.axes;
        let [out, along] = [first * cos + second * sin, second * cos - first * sin];
        let [start, change] = self.radius;
        let (r, w) = (start + change * x, self.turn);
        // Derivatives of r(x) times a direction that turns with w.
        let circle = [
            out * r,
            out * change + along * (r * w),
            along * (2.0 * change * w) - out * (r * w * w),
            -out * (3.0 * change * w * w) - along * (r * w.powi(3)),
        ];
        let none = LetterVector::zeros();
        let mut letters = [self.start + self.drift * x, self.drift, none, none];
        let rise = triples(&letters[0])[0] - triples(&self.start)[0];
        letters[0].fixed_rows_mut::<3>(0).copy_from(&(self.center + rise));
        for (order, part) in letters.iter_mut().zip(circle) {
            let mut xyz = order.fixed_rows_mut::<3>(0);
            xyz += part;
        }
        letters
    }
}

/// Returns the signed angle of an arc whose ends are `to` apart \[rad\].
fn whole_angle(to: f64, turns: i32, radius: f64) -> f64 {
    // Full circles end where they begin, up to rounding of the program.
    let rounding = SHORTEST / radius;
    if turns >= 0 {
        let positive = if to <= rounding { to + TAU } else { to };
        positive + TAU * f64::from(turns)
    } else {
        let negative = if to >= -rounding { to - TAU } else { to };
        negative + TAU * f64::from(turns + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program_motion::block::{BlockCoordinates, BlockEnding};

    fn block(end: [f64; 3], shape: BlockShape) -> MotionBlock {
        let mut to = [0.0; LETTERS];
        to[..3].copy_from_slice(&end);
        let mut start = [0.0; LETTERS];
        start[0] = 10.0;
        MotionBlock {
            number: 1,
            start,
            end: to,
            shape,
            kind: BlockKind::Feed,
            speed: 50.0,
            begins: BlockStart::Flow,
            ending: BlockEnding::Blend,
            tolerance: 0.01,
            coordinates: BlockCoordinates::Axes,
            tool_length: 0.0,
        }
    }

    #[test]
    fn arcs_turn_as_they_are_told() {
        for (end, turns, z, angle) in [
            ([0.0, 10.0, 0.0], 0, 1.0, 0.25),
            ([0.0, 10.0, 0.0], -1, 1.0, 0.75),
            ([10.0, 0.0, 0.0], 0, 1.0, 1.0),
            ([10.0, 0.0, 2.0], 2, -1.0, 3.0),
        ] {
            let shape = BlockShape::Arc { center: [0.0; 3], normal: [0.0, 0.0, z], turns };
            let leg = Leg::of(&block(end, shape)).unwrap();
            let wanted = (angle * TAU * 10.0_f64).hypot(end[2]);
            assert!((leg.length - wanted).abs() < 1e-9, "{end:?} {turns}");
            let last = leg.at(leg.length)[0];
            for (letter, value) in end.iter().enumerate() {
                assert!((last[letter] - value).abs() < 1e-9, "{last}");
            }
            let h = 1e-4;
            let [low, at, high] = [1.0 - h, 1.0, 1.0 + h].map(|x| leg.at(x));
            assert!((at[0].xy().norm() - 10.0).abs() < 1e-9);
            for order in 0..3 {
                let slope = (high[order] - low[order]) / (2.0 * h);
                assert!((slope - at[order + 1]).amax() < 1e-6);
            }
        }
    }

    #[test]
    fn a_block_without_length_has_no_leg() {
        assert!(Leg::of(&block([10.0, 0.0, 0.0], BlockShape::Line)).is_none());
    }
}
