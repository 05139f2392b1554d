//! Blocks of a program, as the control hands them over.

use super::numbers::Packed;
use super::piece::LETTERS;
use crate::switched::KinematicsMode;

/// Curve of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BlockShape {
    /// Straight in all letters.
    Line,
    /// Circle or helix in X Y Z, the other letters in proportion.
    Arc {
        /// Centre in X Y Z \[mm\].
        center: [f64; 3],
        /// Axis, not necessarily of unit length: the arc turns counterclockwise about it.
        normal: [f64; 3],
        /// Full turns besides the arc itself; from -1 downwards the arc turns clockwise.
        turns: i32,
    },
}

/// Override that a block obeys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockKind {
    /// At the feed, which is not exceeded anywhere.
    Feed,
    /// Rapid move.
    Rapid,
    /// In the time that its speed makes of its length: faster in one part of the block than in another where the blocks
    /// beside it are.
    Timed,
}

/// Beginning of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockStart {
    /// On the move.
    Flow,
    /// On the move; the place is met exactly in time, for outputs.
    Marked,
    /// At rest.
    Rest,
}

/// End of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockEnding {
    /// At rest.
    Stop,
    /// On the programmed path: at rest unless the next block goes on in the same direction.
    Exact,
    /// Rounded within the tolerance.
    Blend,
}

/// A block of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionBlock {
    /// Number that the plan reports back.
    pub number: u32,
    /// Position of X Y Z A B C U V W at its start \[mm or rad\].
    pub start: [f64; LETTERS],
    /// Position at its end \[mm or rad\].
    pub end: [f64; LETTERS],
    /// Curve between both.
    pub shape: BlockShape,
    /// Override that it obeys.
    pub kind: BlockKind,
    /// Programmed speed \[mm/s\]: of X Y Z; of U V W if those rest; of A B C \[rad/s\] if nothing else moves.
    pub speed: f64,
    /// Beginning.
    pub begins: BlockStart,
    /// End.
    pub ending: BlockEnding,
    /// Largest deviation of the tip where the corner at the end is rounded \[mm\].
    pub tolerance: f64,
    /// Kind of kinematics.
    pub mode: KinematicsMode,
    /// Length of the tool \[mm\].
    pub tool_length: f64,
}

/// Numbers of a block in a slot of the queue, the round of the queue among them.
pub(super) const BLOCK_NUMBERS: usize = 2 * LETTERS + 16;

impl Packed<BLOCK_NUMBERS> for (MotionBlock, u32) {
    fn pack(&self) -> [u64; BLOCK_NUMBERS] {
        let (block, round) = self;
        let (center, normal, turns) = match block.shape {
            BlockShape::Line => ([0.0; 3], [0.0; 3], i32::MAX),
            BlockShape::Arc { center, normal, turns } => (center, normal, turns),
        };
        let reals = block.start.iter().chain(&block.end).chain(&center).chain(&normal).chain([
            &block.speed,
            &block.tolerance,
            &block.tool_length,
        ]);
        let begins = match block.begins {
            BlockStart::Flow => 0,
            BlockStart::Marked => 1,
            BlockStart::Rest => 2,
        };
        let ending = match block.ending {
            BlockEnding::Stop => 0,
            BlockEnding::Exact => 1,
            BlockEnding::Blend => 2,
        };
        let whole = [
            u64::from(block.number),
            u64::from(*round),
            u64::from(turns.cast_unsigned()),
            match block.kind {
                BlockKind::Feed => 0,
                BlockKind::Rapid => 1,
                BlockKind::Timed => 2,
            },
            begins,
            ending,
            u64::from(block.mode == KinematicsMode::ToolCenterPoint),
        ];
        let mut numbers = [0; BLOCK_NUMBERS];
        let all = reals.map(|real| real.to_bits()).chain(whole);
        numbers.iter_mut().zip(all).for_each(|(slot, number)| *slot = number);
        numbers
    }

    fn unpack(numbers: &[u64; BLOCK_NUMBERS]) -> Self {
        let mut rest = numbers.iter().copied();
        let mut next = || rest.next().unwrap_or_default();
        let mut reals = [0.0; 2 * LETTERS + 9];
        for real in &mut reals {
            *real = f64::from_bits(next());
        }
        let small = |number: u64| u32::try_from(number).unwrap_or_default();
        let (number, round, turns) = (small(next()), small(next()), small(next()).cast_signed());
        let kind = match next() {
            0 => BlockKind::Feed,
            1 => BlockKind::Rapid,
            _ => BlockKind::Timed,
        };
        let begins = match next() {
            0 => BlockStart::Flow,
            1 => BlockStart::Marked,
            _ => BlockStart::Rest,
        };
        let ending = match next() {
            0 => BlockEnding::Stop,
            1 => BlockEnding::Exact,
            _ => BlockEnding::Blend,
        };
        let mode = if next() == 1 { KinematicsMode::ToolCenterPoint } else { KinematicsMode::Axes };
        let letters = |at: usize| std::array::from_fn(|letter| reals[at + letter]);
        let triple = |at: usize| std::array::from_fn(|letter| reals[at + letter]);
        let at = 2 * LETTERS;
        let shape = match turns {
            i32::MAX => BlockShape::Line,
            _ => BlockShape::Arc { center: triple(at), normal: triple(at + 3), turns },
        };
        let block = MotionBlock {
            number,
            start: letters(0),
            end: letters(LETTERS),
            shape,
            kind,
            speed: reals[at + 6],
            begins,
            ending,
            tolerance: reals[at + 7],
            mode,
            tool_length: reals[at + 8],
        };
        (block, round)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_survives_its_slot() {
        let arc = BlockShape::Arc { center: [1.0, 2.0, 3.0], normal: [0.0, 0.0, -1.0], turns: -2 };
        for (shape, kind) in [(BlockShape::Line, BlockKind::Rapid), (arc, BlockKind::Timed)] {
            let block = MotionBlock {
                number: 7,
                start: std::array::from_fn(|letter| letter as f64),
                end: std::array::from_fn(|letter| -0.5 * letter as f64),
                shape,
                kind,
                speed: 50.0,
                begins: BlockStart::Rest,
                ending: BlockEnding::Exact,
                tolerance: 0.01,
                mode: KinematicsMode::ToolCenterPoint,
                tool_length: 120.0,
            };
            assert_eq!(<(MotionBlock, u32)>::unpack(&(block, 3).pack()), (block, 3));
        }
    }
}
