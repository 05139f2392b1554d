//! Straight legs of which a path consists: blocks, and the chords of arcs.

use super::block::{BlockKind, BlockShape, BlockStart, MotionBlock};
use crate::motion::LETTERS;
use std::f64::consts::TAU;
use trunnion::nalgebra::{SVector, Vector3};

/// A vector of all letters.
pub(super) type LetterVector = SVector<f64, LETTERS>;

/// Length that one radian counts \[mm\], where moves of rotaries and of the tip are measured together.
pub(super) const RADIAN: f64 = 10.0;

/// Length below which a block does not move \[mm\]: rounding of positions.
pub(super) const SHORTEST: f64 = 1e-7;

/// Largest distance between an arc and its chords, as a share of the tolerance.
const SAGITTA: f64 = 0.1;

/// Largest angle of a chord \[rad\].
const LARGEST_CHORD: f64 = 0.1;

/// Most chords of an arc.
const MOST_CHORDS: f64 = 20_000.0;

/// A straight leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    pub(super) start: LetterVector,
    /// Change of the letters per length.
    pub(super) direction: LetterVector,
    pub(super) length: f64,
    pub(super) block: u32,
    /// Seconds per length at the programmed speed: of a feed, and of a rapid move. Zero for the other kind.
    pub(super) rates: [f64; 2],
    pub(super) begins: BlockStart,
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

/// Returns the legs of a block, none if it does not move.
pub(super) fn legs(block: &MotionBlock, tolerance: f64) -> Vec<Leg> {
    let mut at = LetterVector::from(block.start);
    let mut legs = Vec::new();
    for point in points(block, tolerance) {
        let step = point - at;
        let length = length(&step);
        // A block without length has no direction: the next one begins where it did.
        if length <= SHORTEST {
            continue;
        }
        let rate = programmed_length(&step) / (length * block.speed);
        let rates = if block.kind == BlockKind::Rapid { [0.0, rate] } else { [rate, 0.0] };
        let begins = if legs.is_empty() { block.begins } else { BlockStart::Flow };
        let direction = step / length;
        legs.push(Leg { start: at, direction, length, block: block.number, rates, begins });
        at = point;
    }
    legs
}

/// Returns the ends of the legs.
fn points(block: &MotionBlock, tolerance: f64) -> Vec<LetterVector> {
    let end = LetterVector::from(block.end);
    let BlockShape::Arc { center, normal, turns } = block.shape else { return vec![end] };
    let start = LetterVector::from(block.start);
    let arc = Arc::new([start, end], center.into(), normal.into(), turns);
    let Some(arc) = arc else { return vec![end] };
    let count = arc.chords(SAGITTA * tolerance);
    (1..=count).map(|k| if k == count { end } else { arc.at(k as f64 / count as f64) }).collect()
}

/// A helix, or a spiral where both ends have different radii.
#[derive(Debug)]
struct Arc {
    ends: [LetterVector; 2],
    center: Vector3<f64>,
    axes: [Vector3<f64>; 3],
    radii: [f64; 2],
    heights: [f64; 2],
    angle: f64,
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
        let to = flat[1].dot(&second).atan2(flat[1].dot(&first));
        // Full circles end where they begin, up to rounding of the program.
        let rounding = SHORTEST / radii[0];
        let angle = if turns >= 0 {
            let positive = if to <= rounding { to + TAU } else { to };
            positive + TAU * f64::from(turns)
        } else {
            let negative = if to >= -rounding { to - TAU } else { to };
            negative + TAU * f64::from(turns + 1)
        };
        Some(Self { ends, center, axes: [first, second, axis], radii, heights, angle })
    }

    /// Number of chords that keep within `sagitta` of the arc.
    fn chords(&self, sagitta: f64) -> usize {
        let radius = self.radii[0].max(self.radii[1]);
        let widest = (8.0 * sagitta / radius).sqrt().min(LARGEST_CHORD);
        let count = (self.angle.abs() / widest).ceil().clamp(1.0, MOST_CHORDS);
        // The clamped number is small and not negative.
        (1..).find(|&n| n as f64 >= count).unwrap_or(1)
    }

    fn at(&self, share: f64) -> LetterVector {
        let mean = |[from, to]: [f64; 2]| from + (to - from) * share;
        let (sin, cos) = (self.angle * share).sin_cos();
        let [first, second, axis] = self.axes;
        let arm = (first * cos + second * sin) * mean(self.radii) + axis * mean(self.heights);
        let [from, to] = self.ends;
        let mut point = from + (to - from) * share;
        point.fixed_rows_mut::<3>(0).copy_from(&(self.center + arm));
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::block::BlockEnding;
    use crate::switched::KinematicsMode;

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
            mode: KinematicsMode::Axes,
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
            let legs = legs(&block(end, shape), 0.01);
            let length: f64 = legs.iter().map(|leg| leg.length).sum();
            let wanted = (angle * TAU * 10.0_f64).hypot(end[2]);
            assert!((length - wanted).abs() < 2e-3 * wanted, "{end:?} {turns}: {length} {wanted}");
            for leg in &legs {
                assert!((leg.start.xy().norm() - 10.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_block_without_length_has_no_legs() {
        assert!(legs(&block([10.0, 0.0, 0.0], BlockShape::Line), 0.01).is_empty());
    }
}
